"""How fast we decode RC bytes beside other Python packages that do: the same streams, in the same run.

    python scripts/peers.py [--frames N] [--rounds N] [--json]

Builds a throw-away virtual environment, installs the peers that deliver channels from a byte stream, and lets each of
them and our decoders read the same streams of walking sticks, in turns, round by round. What counts is CPU time, from
bytes to the channels of every frame in the hands of a consumer; for us that includes finding the frames again after
damage and a record of every event. Peers that own a serial port read from one that never makes them wait. Then each
reads a stream in which every 20th frame has lost a byte.

Exit status: 0 if we are at least 1.3 times as fast as the fastest peer of each protocol, 1 if not, 3 if the peers
cannot be installed here.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from arguments import at_least_one, end_with, parser

ROOT = Path(__file__).resolve().parents[1]
BAR = 1.3
SEED = "wheelbench peers 1"
BLOCKS = (64, 4096)
PACKAGES = ("rfrx==2.1.2", "crsf-parser==0.3.2", "rpycrsf==0.1.0", "flySkyiBus==1.0.0")
RANGES = {"sbus": (16, 172, 992, 1811), "crsf": (16, 172, 992, 1811), "ibus": (14, 1000, 1500, 2000)}

Channels = tuple[int, ...]
Consumer = Callable[[Any], None]
Reader = Callable[[bytes, Consumer], None]


class Peer(NamedTuple):
    """A reader of one protocol: what it is called, how it reads, and how its frames become channels in wire order."""

    name: str
    read: Reader
    channels: Callable[[Any], Channels]
    share: float = 1.0
    """Of the stream, how much it reads when it is timed: the slowest would keep everybody waiting."""


def walking(protocol: str, frames: int) -> list[Channels]:
    """Four sticks that walk, the rest at rest."""
    rng = random.Random(f"{SEED} {protocol}")
    count, low, middle, high = RANGES[protocol]
    channels, rows = [middle] * count, []
    for _ in range(frames):
        for i in range(4):
            channels[i] = max(low, min(high, channels[i] + rng.randint(-20, 20)))
        rows.append(tuple(channels))
    return rows


# --- the readers ---------------------------------------------------------------------------------------------------


class _StreamEnd(Exception):
    """Raised by a port that has no more bytes: the peers' own loops do not end."""


class _Port:
    """A serial port that has everything already."""

    data = b""

    def __init__(self, *_: Any, **__: Any) -> None:
        self._data, self._at = self.data, 0

    def read(self, size: int) -> bytes:
        piece = self._data[self._at : self._at + size]
        if len(piece) < size:
            raise _StreamEnd
        self._at += size
        _Port.at = self._at  # the next port that opens goes on here
        return piece

    at = 0

    def __enter__(self) -> _Port:
        self._at = _Port.at
        return self

    def __exit__(self, *_: Any) -> None:
        """A port that is closed and opened again has missed nothing."""


def _open(data: bytes) -> None:
    _Port.data, _Port.at = data, 0


def ours(protocol: str, block: int) -> Peer:
    """Our decoder, fed in blocks."""
    from bench import rc_decode
    from bench.messages import RcFrame

    def read(data: bytes, consume: Consumer) -> None:
        decoder = rc_decode.decoder(protocol)
        for start in range(0, len(data), block):
            for event in decoder.feed(data[start : start + block]):
                if type(event) is RcFrame:
                    consume(event)
        for event in decoder.finish():
            if type(event) is RcFrame:
                consume(event)

    return Peer(f"wheelbench, blocks of {block}", read, lambda frame: frame.channels)


def peers(protocol: str) -> list[Peer]:
    """The packages that are installed in this environment for a protocol."""
    return {"sbus": _sbus_peers, "crsf": _crsf_peers, "ibus": _ibus_peers}[protocol]()


def _sbus_peers() -> list[Peer]:
    import rfrx.sbus

    # Its reader opens a real port, and sleeps for a second after every fault: not our time.
    rfrx.sbus.serial.Serial = _Port
    rfrx.sbus.sleep = lambda _: None

    def read(data: bytes, consume: Consumer) -> None:
        class Reader(rfrx.sbus.SbusReader):  # type: ignore[misc]
            def process(self, frame: Any) -> None:
                consume(frame)

        _open(data)
        try:
            Reader()
        except _StreamEnd:
            return

    return [Peer("rfrx", read, lambda frame: tuple(frame.chans))]


def _crsf_peers() -> list[Peer]:
    import rpycrsf.protocol
    from crsf_parser import CRSFParser, PacketValidationStatus

    rpycrsf.protocol.serial.Serial = _Port

    def read_rpycrsf(data: bytes, consume: Consumer) -> None:
        _open(data)
        port = rpycrsf.protocol.CRSFPort("")
        unpack, read_frame = rpycrsf.protocol.unpack_rc_channels, port.read_frame
        try:
            while True:
                frame = read_frame()
                if frame and frame[0] == 0x16 and len(frame[1]) == 22:
                    consume(unpack(frame[1]))
        except _StreamEnd:
            return

    def parser(block: int) -> Peer:
        def read(data: bytes, consume: Consumer) -> None:
            valid = PacketValidationStatus.VALID
            parser = CRSFParser(lambda frame, status: consume(frame) if status == valid else None)
            waiting = bytearray()
            for start in range(0, len(data), block):
                waiting += data[start : start + block]
                parser.parse_stream(waiting)

        # It delivers the channels from the last to the first (an open issue of its project).
        return Peer(f"crsf-parser, blocks of {block}", read, lambda f: tuple(f.payload.channels)[::-1], share=0.05)

    return [Peer("rpycrsf", read_rpycrsf, tuple), *map(parser, BLOCKS)]


def _ibus_peers() -> list[Peer]:
    import serial
    from flySkyiBus import IBus

    serial.Serial = _Port

    def read(data: bytes, consume: Consumer) -> None:
        _open(data)
        bus = IBus("")
        try:
            while True:
                consume(bus.read())
        except _StreamEnd:
            return

    return [Peer("flySkyiBus", read, lambda values: tuple(values[2:16]))]


# --- measuring -----------------------------------------------------------------------------------------------------


def delivered(peer: Peer, frames: list[bytes], rows: list[Channels], lose: bool) -> tuple[int, int, int]:
    """(intact frames in the stream, of these delivered, frames delivered that were never sent)."""
    rng = random.Random(f"{SEED} lost bytes")
    data, expected = bytearray(), []
    for k, frame in enumerate(frames):
        if lose and k % 20 == 19:
            gone = rng.randrange(len(frame))
            data += frame[:gone] + frame[gone + 1 :]
        else:
            data += frame
            expected.append(rows[k])
    got: list[Channels] = []
    peer.read(bytes(data), lambda frame: got.append(peer.channels(frame)))
    right, at = 0, 0
    for channels in got:  # in order, as they were sent
        try:
            at = expected.index(channels, at, at + 200) + 1
            right += 1
        except ValueError:
            pass
    return len(expected), right, len(got) - right


def measure(protocol: str, frames: int, rounds: int) -> Iterator[dict[str, Any]]:
    """One row for each reader of a protocol; ours come last."""
    from bench import rc_decode

    rows = walking(protocol, frames)
    encoded = [rc_decode.encode(protocol, row) for row in rows]
    length = len(encoded[0])
    data = b"".join(encoded)
    readers = [*peers(protocol), *(ours(protocol, block) for block in BLOCKS)]
    times: dict[str, list[float]] = {reader.name: [] for reader in readers}
    for _ in range(rounds):
        for reader in readers:
            count = max(1, int(frames * reader.share))
            piece, seen = data[: count * length], [0]

            def consume(_: Any, seen: list[int] = seen) -> None:
                seen[0] += 1

            start = time.process_time()
            reader.read(piece, consume)
            times[reader.name].append((time.process_time() - start) / count)
    some = slice(0, min(2000, frames))
    for reader in readers:
        all_of_them, right, wrong = delivered(reader, encoded[some], rows[some], lose=False)
        intact, after_loss, wrong_after_loss = delivered(reader, encoded[some], rows[some], lose=True)
        us = statistics.median(times[reader.name]) * 1e6
        yield {
            "protocol": protocol,
            "reader": reader.name,
            "us_per_frame": us,
            "frames_per_s": 1e6 / us,
            "clean": [right, all_of_them, wrong],
            "lost_bytes": [after_loss, intact, wrong_after_loss],
            "times_us": [t * 1e6 for t in times[reader.name]],
        }


def verdicts(rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """For each protocol: our slower block size over the fastest peer, as the median of the rounds' ratios."""
    for protocol in RANGES:
        of_it = [row for row in rows if row["protocol"] == protocol]
        own = [row for row in of_it if row["reader"].startswith("wheelbench")]
        others = [row for row in of_it if not row["reader"].startswith("wheelbench")]
        fastest = min(others, key=lambda row: row["us_per_frame"])
        slowest = max(own, key=lambda row: row["us_per_frame"])
        ratios = [theirs / us for theirs, us in zip(fastest["times_us"], slowest["times_us"], strict=True)]
        ratio = statistics.median(ratios)
        yield {"protocol": protocol, "fastest_peer": fastest["reader"], "ratio": ratio, "holds": ratio >= BAR}


def print_table(rows: list[dict[str, Any]], results: list[dict[str, Any]]) -> None:
    """For people."""
    print(f"{'':6} {'reader':28} {'us/frame':>9} {'frames/s':>10}   {'clean stream':20} every 20th frame lost a byte")
    for row in rows:
        clean, lost = (_share(*row[key]) for key in ("clean", "lost_bytes"))
        print(
            f"{row['protocol']:6} {row['reader']:28} {row['us_per_frame']:9.2f} {row['frames_per_s']:10,.0f}   "
            f"{clean:20} {lost}"
        )
    for result in results:
        print(
            f"{result['protocol']}: {result['ratio']:.2f} times the fastest peer ({result['fastest_peer']}); "
            f"bar {BAR}: {'holds' if result['holds'] else 'MISSED'}"
        )


def _share(right: int, of: int, wrong: int) -> str:
    return f"{right} of {of}" + (f", {wrong} wrong" if wrong else "")


def inside(args: argparse.Namespace) -> int:
    """In the environment that has the peers: measure, and print JSON for the outer process."""
    with open(os.devnull, "w") as nowhere:
        out, sys.stdout = sys.stdout, nowhere  # one of them prints when it is imported, one on every wrong checksum
        logging_off()
        rows = [row for protocol in RANGES for row in measure(protocol, args.frames, args.rounds)]
        sys.stdout = out
    json.dump(rows, sys.stdout)
    return 0


def logging_off() -> None:
    """A peer that logs every fault would be timed for writing."""
    import logging

    logging.disable(logging.CRITICAL)


def environment(folder: str, packages: Sequence[str] = PACKAGES, with_pip: bool = True) -> Path | None:
    """Make a virtual environment that has these packages: its interpreter, or None where they cannot be installed."""
    print("installing the peers into a throw-away environment ...", file=sys.stderr)
    python = Path(folder) / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [str(python), "-m", "pip", "install", "--quiet", "--quiet", "--disable-pip-version-check", *packages]
    try:
        venv.create(folder, with_pip=with_pip)
        subprocess.run(pip, stdout=sys.stderr, check=True)
    except (OSError, subprocess.CalledProcessError):
        print(f"the peers cannot be installed here: {' '.join(packages)}", file=sys.stderr)
        return None
    return python


def measured(python: Path, frames: int, rounds: int) -> list[dict[str, Any]]:
    """The rows of every reader of every protocol, from a process of that environment."""
    command = [str(python), __file__, "--inside", "--frames", str(frames), "--rounds", str(rounds)]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, text=True, check=True
    )
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    return rows


def outside(args: argparse.Namespace) -> int:
    """Build the environment, measure in it, and print what came out."""
    with tempfile.TemporaryDirectory(prefix="wheelbench-peers-") as folder:
        python = environment(folder)
        if python is None:
            return 3
        print(f"measuring: {args.rounds} rounds of {args.frames} frames ...", file=sys.stderr)
        rows = measured(python, args.frames, args.rounds)
    results = list(verdicts(rows))
    if args.json:
        print(json.dumps({"rows": rows, "verdicts": results}, indent=1))
    else:
        print_table(rows, results)
    return 0 if all(result["holds"] for result in results) else 1


def main() -> int:
    """Run as a script."""
    asked = parser(__doc__)
    asked.add_argument("--frames", type=at_least_one, default=100_000, metavar="N", help="a stream (default 100000)")
    asked.add_argument("--rounds", type=at_least_one, default=5, metavar="N", help="default 5")
    asked.add_argument("--json", action="store_true", help="the rows and verdicts as JSON")
    asked.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = asked.parse_args()
    return inside(args) if args.inside else outside(args)


if __name__ == "__main__":
    end_with(main)
