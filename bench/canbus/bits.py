"""How many bits a classic CAN frame takes on the wire, to the bit: header, checksum, stuffing, end and gap.

    start 1 | identifier 11 (or 11 + 18) | control | length 4 | data 0 to 64 | checksum 15 || delimiters, end, gap
    '--------------------- a stuff bit after every five alike ---------------------------' '------- 13 -------'

ISO 11898-1. The polynomial is 0x4599; a stuff bit is the first of the next five. Nothing is stuffed after the checksum:
its delimiter, acknowledge and delimiter (3), the end of frame (7) and the gap before the next frame (3).
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import TypeAlias

POLYNOMIAL = 0x4599
UNSTUFFED = 3 + 7 + 3
GAP = 3
_Steps: TypeAlias = "list[tuple[_Steps, int]]"
"""By the next byte: the steps after it, and how many bits were stuffed."""
_Shares: TypeAlias = tuple[tuple[int, ...], ...]


def frame_bits(can_id: int, data: bytes = b"", *, extended: bool = False, remote_length: int | None = None) -> int:
    """Bits from the start of this frame to the earliest start of the next one, three bits of gap included.

    `extended` is a 29-bit identifier; `remote_length` makes it a remote frame that asks for so many bytes. Raises
    ValueError for what is no classic frame.
    """
    if not extended and remote_length is None:
        return _data_frame_bits(can_id, data)
    raw, count = _raw_bits(can_id, data, extended, remote_length)
    return count + _stuff_count(raw, count) + UNSTUFFED


def stuff_bits(can_id: int, data: bytes = b"", *, extended: bool = False, remote_length: int | None = None) -> int:
    """How many of these bits are stuffing."""
    return _stuff_count(*_raw_bits(can_id, data, extended, remote_length))


def frame_us(
    can_id: int,
    data: bytes = b"",
    *,
    bitrate: int = 1_000_000,
    extended: bool = False,
    remote_length: int | None = None,
) -> float:
    """The same as time, in microseconds."""
    return frame_bits(can_id, data, extended=extended, remote_length=remote_length) * 1e6 / bitrate


def wire_bits(can_id: int, data: bytes = b"", *, extended: bool = False, remote_length: int | None = None) -> str:
    """The frame as a scope shows it, one character a bit: 0 is dominant. Acknowledged, and with its gap."""
    raw, count = _raw_bits(can_id, data, extended, remote_length)
    wire: list[str] = []
    last, run = "", 0
    for bit in f"{raw:0{count}b}":
        run = run + 1 if bit == last else 1
        last = bit
        wire.append(bit)
        if run == 5:
            last, run = "1" if bit == "0" else "0", 1
            wire.append(last)
    return "".join(wire) + "1" + "0" + "1" + "1" * 7 + "1" * GAP


def least_bits(length: int, *, extended: bool = False) -> int:
    """A frame of this many bytes without a single stuff bit."""
    return _stuffable(length, extended) + UNSTUFFED


def worst_bits(length: int, *, extended: bool = False) -> int:
    """What no frame of this many bytes can exceed: the first stuff bit after five, then one after every four."""
    stuffable = _stuffable(length, extended)
    return stuffable + (stuffable - 1) // 4 + UNSTUFFED


def _data_frame_bits(can_id: int, data: bytes) -> int:
    """The usual frame at less cost, for a bus that is counted while it runs: byte by byte from its header."""
    checksum, steps, bits, shares = _header(can_id, len(data))
    for byte, share in zip(data, shares, strict=True):
        checksum ^= share[byte]
        steps, stuffed = steps[byte]
        bits += stuffed
    steps, stuffed = steps[checksum >> 7]
    # The seven bits that are left, and one that is unlike the last of them: it is never stuffed.
    return bits + stuffed + steps[checksum << 1 & 0xFE | ~checksum & 1][1]


@lru_cache(maxsize=256)
def _header(can_id: int, length: int) -> tuple[int, _Steps, int, _Shares]:
    """Of a header before so many bytes: the checksum if they were zeros, what stuffing goes on from, the frame's bits
    but for the stuffing of data and checksum; and each byte's share of the checksum.
    """
    raw, count = _raw_bits(can_id, bytes(length), False, None)
    head, head_count = raw >> 15 + 8 * length, count - 15 - 8 * length
    state, stuffed = _stuffed(0, head, head_count)
    return raw & 0x7FFF, _stuff_steps()[state], count + stuffed + UNSTUFFED, _shares()[8 - length :]


@cache
def _shares() -> _Shares:
    """For each of eight bytes and each of its values: what it alone adds (xor) to their checksum, which is linear."""
    return tuple(tuple(_checksum(byte << 8 * behind, 64) for byte in range(256)) for behind in range(7, -1, -1))


def _stuffable(length: int, extended: bool) -> int:
    if not 0 <= length <= 8:
        raise ValueError(f"length {length} outside 0..8")
    return (54 if extended else 34) + 8 * length


def _raw_bits(can_id: int, data: bytes, extended: bool, remote_length: int | None) -> tuple[int, int]:
    """Everything that is stuffed, as a number and its count of bits."""
    limit = 0x1FFFFFFF if extended else 0x7FF
    if not 0 <= can_id <= limit:
        raise ValueError(f"identifier {can_id:#x} outside 0..{limit:#x}")
    is_remote = remote_length is not None
    length = len(data) if remote_length is None else remote_length
    if not 0 <= length <= 8:
        raise ValueError(f"length {length} outside 0..8")
    if is_remote and data:
        raise ValueError(f"a remote frame carries no data, got {len(data)} bytes")
    if extended:
        # 11 bits of identifier, two recessive (substitute remote request, extension), 18 more, then as below.
        head, count = (can_id >> 18) << 2 | 0b11, 14
        head, count = head << 18 | (can_id & 0x3FFFF), count + 18
        head, count = head << 3 | is_remote << 2, count + 3
    else:
        head, count = can_id << 3 | is_remote << 2, 15  # start, identifier, remote request, two dominant
    head, count = head << 4 | length, count + 4
    head, count = head << 8 * len(data) | int.from_bytes(data, "big"), count + 8 * len(data)
    return head << 15 | _checksum(head, count), count + 15


def _checksum(value: int, count: int) -> int:
    # The register starts at zero, so zeros before the first bit change nothing: whole bytes will do.
    table, register = _checksum_table(), 0
    for byte in value.to_bytes((count + 7) // 8, "big"):
        register = (register << 8 & 0x7FFF) ^ table[register >> 7 ^ byte]
    return register


@cache
def _checksum_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        register = byte << 7
        for _ in range(8):
            register = (register << 1) ^ (POLYNOMIAL if register & 0x4000 else 0)
        table.append(register & 0x7FFF)
    return tuple(table)


def _stuff_count(raw: int, count: int) -> int:
    # Before the start bit the bus idles at recessive level; nothing is counted there, so the run starts at zero.
    lead = count % 8
    state, stuffed = _stuffed(0, raw >> count - lead, lead)
    steps = _stuff_steps()[state]
    for byte in (raw & (1 << count - lead) - 1).to_bytes(count // 8, "big"):
        steps, more = steps[byte]
        stuffed += more
    return stuffed


def _stuffed(state: int, value: int, count: int) -> tuple[int, int]:
    """So many bits further, bit by bit: the state after them, and how many bits were stuffed."""
    stuffed = 0
    for shift in range(count - 1, -1, -1):
        state, more = _stuffed_once(state, value >> shift & 1)
        stuffed += more
    return state, stuffed


def _stuffed_once(state: int, bit: int) -> tuple[int, int]:
    """One bit further. A state is 2 x run + last bit; run 0 is before the first bit."""
    run, last = state >> 1, state & 1
    run = run + 1 if run and bit == last else 1
    if run < 5:
        return run << 1 | bit, 0
    return 1 << 1 | (1 - bit), 1  # the stuff bit is the other one, and the first of its own run


@cache
def _stuff_steps() -> tuple[_Steps, ...]:
    """For every state its steps."""
    steps: tuple[_Steps, ...] = tuple([] for _ in range(10))
    for state in range(10):
        for byte in range(256):
            after, stuffed = _stuffed(state, byte, 8)
            steps[state].append((steps[after], stuffed))
    return steps
