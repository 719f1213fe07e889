"""Noise for long: 100 MB for every decoder, and its memory must not grow. `make fuzz` begins with it.

    scripts/noise.py --mb 100 --jobs 2     exit status 1 where memory grew, or bytes went unaccounted for

Uniform bytes would be kind: half of these are bytes that begin, end or fill a frame of some protocol. Each decoder runs
in a process of its own; what counts is how much the largest resident size grew after the first megabyte.
"""

from __future__ import annotations

import multiprocessing
import random
import resource
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from arguments import above_zero, at_least_one, end_with, parser

from bench import rc_decode
from bench.slamware.base_side import SlamwareBase
from bench.slamware.core_side import SlamwareCore
from bench.slamware.framing import FrameDecoder
from bench.slamware.reference_base import reference_facts
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.senses import Motion

PIECE_BYTES = 4096
MOST_GROWTH_KB = 1024
"""Less than a hundredth of what went through; the allocator's own reserve moves by a few hundred kB."""
_MARKS = bytes.fromhex(
    "0F 00 04 14 24 34 03 AA 55 20 40 C8 EE EA EC 18 16 10 50 F8 41 01 02 04 05 08 0F 00 00 C8 10 50"
)
_TABLE = bytes(_MARKS[value % 32] if value < 128 else value for value in range(256))


class Result(NamedTuple):
    """One decoder after its noise."""

    name: str
    seconds: float
    fed_bytes: int
    told_bytes: int
    frames: int
    grown_kb: int


def noise(seed: int) -> Iterator[bytes]:
    """Endless pieces: half of the bytes mean something to a decoder."""
    chance = random.Random(seed)
    while True:
        yield chance.randbytes(PIECE_BYTES).translate(_TABLE)


def _rc(protocol: str) -> Callable[[bytes, int], tuple[int, int]]:
    decoder = rc_decode.decoder(protocol)

    def take(piece: bytes, tick: int) -> tuple[int, int]:
        events = decoder.feed(piece) if piece else decoder.finish()
        return sum(event.length for event in events), sum(hasattr(event, "channels") for event in events)

    return take


def _framing(rescan: bool) -> Callable[[bytes, int], tuple[int, int]]:
    decoder = FrameDecoder(rescan=rescan)

    def take(piece: bytes, tick: int) -> tuple[int, int]:
        events = decoder.feed(piece, tick) if piece else decoder.finish()
        return sum(event.length for event in events), sum(hasattr(event, "code") for event in events)

    return take


def _end(receive: Callable[[bytes, int], bytes]) -> Callable[[bytes, int], tuple[int, int]]:
    """An end of the control bus keeps no count of bytes: they are all taken as told."""

    def take(piece: bytes, tick: int) -> tuple[int, int]:
        return len(piece), bool(receive(piece, tick))

    return take


def _core() -> Callable[[bytes, int], tuple[int, int]]:
    core = SlamwareCore()
    return _end(lambda piece, tick: core.step(tick, piece))


MAKERS: dict[str, Callable[[], Callable[[bytes, int], tuple[int, int]]]] = {
    **{protocol: lambda protocol=protocol: _rc(protocol) for protocol in rc_decode.PROTOCOLS},  # type: ignore[misc]
    "slamware, rescan": lambda: _framing(True),
    "slamware, whole": lambda: _framing(False),
    "base": lambda: _end(SlamwareBase(reference_facts(), Motion()).receive),
    "firmware": lambda: _end(ReferenceFirmware(reference_facts(), Motion()).receive),
    "core": _core,
}
"""A fresh decoder by name: takes bytes (none: the end) and a tick, returns bytes accounted for and frames found."""


def run(name: str, size: int, resident_kb: Callable[[], int]) -> Result:
    """Feed `size` bytes of noise; `resident_kb` is asked after the first megabyte, or half of a smaller size."""
    take, pieces = MAKERS[name](), noise(seed=len(name))
    begun, fed, told, frames, before_kb = time.monotonic(), 0, 0, 0, -1
    while fed < size:
        if before_kb < 0 and fed >= min(1_000_000, size // 2):
            before_kb = resident_kb()
        lengths, found = take(next(pieces), fed // PIECE_BYTES)
        fed, told, frames = fed + PIECE_BYTES, told + lengths, frames + found
    lengths, found = take(b"", fed // PIECE_BYTES)
    grown_kb = resident_kb() - before_kb
    return Result(name, time.monotonic() - begun, fed, told + lengths, frames + found, grown_kb)


def largest_kb() -> int:
    """The largest resident size of this process so far."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size // 1024 if sys.platform == "darwin" else size


def _process(job: tuple[str, int]) -> Result:
    return run(*job, largest_kb)


def is_good(result: Result) -> bool:
    """No growth, and each byte in an event; a frame that was refused whole may announce more than came."""
    return result.grown_kb <= MOST_GROWTH_KB and 0 <= result.told_bytes - result.fed_bytes <= 65538


def main() -> int:
    """The command line; 0 where every decoder held."""
    asked = parser(__doc__)
    asked.add_argument("--mb", type=above_zero, default=100.0, metavar="MB", help="for each decoder (default 100)")
    asked.add_argument("--jobs", type=at_least_one, default=2, metavar="N", help="decoders at a time (default 2)")
    given = asked.parse_args()
    print(f"{'decoder':<18}{'MB':>7}{'seconds':>9}{'frames':>9}{'grown kB':>10}", flush=True)
    held = True
    with multiprocessing.get_context("spawn").Pool(given.jobs, maxtasksperchild=1) as pool:
        for one in pool.imap(_process, [(name, int(given.mb * 1e6)) for name in MAKERS]):
            held = held and is_good(one)
            verdict = "" if is_good(one) else f"   NOT HELD: {one.told_bytes} of {one.fed_bytes} bytes told"
            figures = f"{one.fed_bytes / 1e6:>7.1f}{one.seconds:>9.0f}{one.frames:>9}{one.grown_kb:>10}"
            print(f"{one.name:<18}{figures}{verdict}", flush=True)
    return 0 if held else 1


if __name__ == "__main__":
    end_with(main)
