"""What the attacks' bytes mean: a line of raw bytes, or a script from which frames are built and damaged.

The first eight bytes of an input say how the rest is meant, where it is cut into pieces, and when its bytes come. A
script is what makes an attack reach beyond the framing: bytes alone seldom have the right checksum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from bench import rc_decode
from bench.rc import crsf, sbus
from bench.slamware.commands import SUB_COMMANDS
from bench.slamware.framing import encode_frame

HEAD = 8
MOST_BUILT = 2000
"""A script ends here, so that one input does not take as long as a hundred."""


def built(script: bytes, frame: Callable[[bytes], bytes]) -> bytes:
    """A line from a script: runs of raw bytes, whole frames, frames with a byte lost, changed, doubled or swallowed."""
    out, at, last = bytearray(), 0, b""
    while at < len(script) and len(out) < MOST_BUILT:
        what, how = script[at] & 7, script[at] >> 3
        at += 1
        if what < 2:
            out += script[at : at + how]
            at += how
            continue
        if what < 7:
            last = frame(script[at : at + 8].ljust(8, b"\0"))
            at += 8
        piece = bytearray(last)
        if what == 4 and piece:
            del piece[how % len(piece)]
        elif what == 5 and piece:
            piece[how % len(piece)] ^= 1 << how % 8
        elif what == 6:
            piece.insert(how % (len(piece) + 1), 0xC8 ^ how)
        out += piece
    return bytes(out)


def pieces(data: bytes, head: bytes) -> Iterator[tuple[int, int]]:
    """Where to cut: begin and end of each piece, from one byte to all of them."""
    at, turn = 0, 0
    while at < len(data):
        size = 1 + head[1 + turn % 3] % 67
        yield at, at + size
        at, turn = at + size, turn + 1


def times_us(count: int, head: bytes) -> list[int]:
    """A time for each byte: mostly the next one follows at once, sometimes after silence, and clocks run backwards."""
    now_us, out = 0, []
    for i in range(count):
        step = head[4 + i % 3]
        now_us += 90 if (i + head[7]) % (1 + step % 31) else step * 97 - 500
        out.append(now_us)
    return out


def rc_frame(protocol: str) -> Callable[[bytes], bytes]:
    """Eight bytes -> a valid frame of the protocol."""
    limits = rc_decode.channel_limits(protocol)
    flags = {"sbus": ("failsafe", "frame_lost"), "ibus": ("failsafe",)}.get(protocol, ())

    def build(seed: bytes) -> bytes:
        if protocol == "crsf" and seed[0] & 1:
            if seed[0] & 2:
                return crsf.encode_link_statistics(seed[1] % 101, -seed[2], seed[3] - 128)
            return crsf.encode_frame(seed[1], seed[2:] * (seed[0] >> 5), address=sorted(crsf.ADDRESSES)[seed[2] % 5])
        word = int.from_bytes(seed, "little")
        channels = [low + (word >> 3 * i) % (high - low + 1) for i, (low, high) in enumerate(limits)]
        if protocol == "sbus" and seed[0] & 1:
            footer = sorted(sbus.FOOTERS)[seed[1] % 5]
            answers = b"".join(bytes((0x03 | slot << 3 & 0xFF, seed[2], seed[3])) for slot in range(seed[4] % 10))
            return (
                sbus.encode(
                    channels, digital=(bool(seed[5] & 1), bool(seed[5] & 2)), upper_flags=seed[5] >> 4, footer=footer
                )
                + answers
            )
        return rc_decode.encode(protocol, channels, **{flag: bool(seed[i] & 2) for i, flag in enumerate(flags)})

    return build


def request_frame(seed: bytes) -> bytes:
    """A frame of the control bus: mostly requests that a base knows, of the right size or nearly."""
    kind = ("standard", "long")[seed[0] & 1]
    if seed[0] & 6:
        sub_command = sorted(SUB_COMMANDS)[seed[1] % len(SUB_COMMANDS)]
        sizes = SUB_COMMANDS[sub_command].request_bytes
        size = sizes[seed[2] % len(sizes)] + (seed[0] & 0x30 == 0x30)
        return encode_frame(0xF8, bytes((sub_command,)) + (seed[3:] * 4)[:size], kind)
    return encode_frame((0, 1, 2, 3, 0xF8, 0xFF)[seed[1] % 6], (seed[2:] * 30)[: seed[2]], kind)


def answer_frame(seed: bytes) -> bytes:
    """What a base may say: OK with data of any size, or an error."""
    if seed[0] & 7 == 0:
        return encode_frame(3, bytes((seed[1], seed[2])))
    return encode_frame(2, (seed[2:] * 30)[: seed[1] % 64])


def seeds(name: str) -> Iterator[bytes]:
    """Inputs to begin with: a few frames as a script, and the same as bytes."""
    make = {"base": request_frame, "firmware": request_frame, "slamware": request_frame, "core": answer_frame}.get(name)
    if name in rc_decode.PROTOCOLS:
        make = rc_frame(name)
    for number in range(24):
        seed = bytes((number * 37 + i * i * 11) & 0xFF for i in range(8))
        script = b"".join(
            bytes((2 + (number + i) % 6 | (number * 7 + i) % 32 << 3,)) + seed[i:] + seed[:i] for i in range(5)
        )
        yield bytes((number << 1 | 1,)) + seed[1:] + script
        if make is not None:
            yield bytes((number << 1,)) + seed[1:] + built(script, make)
    if name == "lines":
        yield b"(0.001000) can0 201#0000000000000000\n(1.000000) AA 55\n(1.000000) > 10 02\n(1.000000) 1,2,3"
