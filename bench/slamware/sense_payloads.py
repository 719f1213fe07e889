"""What a base senses, on the control bus: power, distances, contacts, dock beacons, and what it asks of its core.

    0x30  u8 percent | u8 bits: 0 charging, 1 external supply, 2 on the dock
    0x32  16 x u32, Q16 millimetres, unsigned, in the order of the sensor configuration; unused slots are zero
    0x33  u32 (an older dialect: u8), a bit for each contact: 0 triggered, 1 not
    0x34  u8 beacons of the dock | u8 receivers n | u8[n], a bit for each beacon that the receiver sees
    0x50  nothing, or u8 request | one undefined byte

Source: SLAMTEC's base reference firmware of 2018-11-20, executed.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

from bench.slamware.commands import NOTHING_TO_ASK

RANGE_SLOTS = 16
BUMPER_BYTES = 4
IDLE_CONTACTS = 0x3FF
"""The ten bits that the reference base defines stay 1 where a base has fewer contacts: cores know no other idle."""

_RANGES = struct.Struct("<16I")
RANGES_BYTES = _RANGES.size
_Q16_PER_M = 65536.0 * 1000.0
_CHARGING, _EXTERNAL_SUPPLY, _ON_DOCK = 1, 2, 4


class Power(NamedTuple):
    """State of the battery, 0 to 100 percent, and where current comes from."""

    percent: int
    charging: bool = False
    external_supply: bool = False
    on_dock: bool = False


class Beacons(NamedTuple):
    """How many beacons the dock has, and for each receiver of the base a bit for each beacon that it sees."""

    number: int
    seen: tuple[int, ...]


def power_answer(power: Power) -> bytes:
    """2 bytes. Raises ValueError outside 0..100 percent."""
    if not 0 <= power.percent <= 100:
        raise ValueError(f"battery percentage {power.percent} outside 0..100")
    bits = (_CHARGING, _EXTERNAL_SUPPLY, _ON_DOCK)
    return bytes((power.percent, sum(bit for bit, is_set in zip(bits, power[1:], strict=True) if is_set)))


def power_from_answer(payload: bytes) -> Power:
    """Power out of at least 2 bytes; bits that later dialects define are left alone."""
    percent, bits = payload[0], payload[1]
    return Power(percent, bool(bits & _CHARGING), bool(bits & _EXTERNAL_SUPPLY), bool(bits & _ON_DOCK))


def ranges_answer(ranges_m: Sequence[float]) -> bytes:
    """64 bytes out of at most 16 distances in metres; each is cut to 0..65.535 m. Raises ValueError for more."""
    if len(ranges_m) > RANGE_SLOTS:
        raise ValueError(f"{len(ranges_m)} distances; the answer has {RANGE_SLOTS} slots")
    raw = [int(max(0.0, min(4294967295.0, range_m * _Q16_PER_M))) for range_m in ranges_m]
    return _RANGES.pack(*raw, *[0] * (RANGE_SLOTS - len(raw)))


def ranges_from_answer(payload: bytes) -> tuple[float, ...]:
    """16 distances in metres out of at least 64 bytes; which slots mean something is told by 0x20."""
    return tuple(raw / _Q16_PER_M for raw in _RANGES.unpack_from(payload))


def contacts_answer(contacts: Sequence[bool], size: int = BUMPER_BYTES) -> bytes:
    """`size` bytes, low byte first; True is a contact that is triggered, and a 0 on the wire."""
    bits = IDLE_CONTACTS | (1 << len(contacts)) - 1
    for contact, triggered in enumerate(contacts):
        if triggered:
            bits &= ~(1 << contact)
    return (bits & (1 << 8 * size) - 1).to_bytes(size, "little")


def contact_bits(payload: bytes) -> int:
    """The bitmap out of 1 to 4 bytes, still active-low; missing bytes are as if nothing was triggered there."""
    return int.from_bytes(payload[:BUMPER_BYTES].ljust(BUMPER_BYTES, b"\xff"), "little")


def contacts_from_answer(payload: bytes, count: int) -> tuple[bool, ...]:
    """Which of the first `count` contacts are triggered."""
    bits = contact_bits(payload)
    return tuple(not bits >> contact & 1 for contact in range(count))


def beacons_answer(beacons: Beacons) -> bytes:
    """2 + n bytes."""
    return bytes((beacons.number, len(beacons.seen), *beacons.seen))


def beacons_from_answer(payload: bytes) -> Beacons:
    """Beacons out of at least 2 bytes; of the receivers that are announced, those that came."""
    return Beacons(payload[0], tuple(payload[2 : 2 + payload[1]]))


def base_request_answer(asking: int | None) -> bytes:
    """Nothing, or 2 bytes; the reference base leaves the second to chance, here it is 0."""
    return b"" if asking is None else bytes((asking, 0))


def base_request_from_answer(payload: bytes) -> int | None:
    """What the base asks of its core, None where that is nothing; the 2017 bases say 0xFF for it."""
    return None if not payload or payload[0] == NOTHING_TO_ASK else payload[0]
