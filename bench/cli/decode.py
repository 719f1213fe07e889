"""`wheelbench decode PROTOCOL FILE`: any capture to decoded lines or JSON lines."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.cli.output import say
from bench.errors import spelt

if TYPE_CHECKING:
    from bench.canbus.table import Family
    from bench.messages import RcEvent
    from bench.rc.capture import Capture
    from bench.rc.health import HealthMeter

CAN_LOGS = ("c610", "dm3519")
OTHER_WIRES = ("slamware", *CAN_LOGS)
AUTO = "auto"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument(
        "protocol",
        metavar="PROTOCOL",
        help="uart12, sbus, crsf, ibus, dbus; slamware; c610, dm3519 (a CAN log); auto finds out which",
    )
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="raw bytes, with byte times in FILE's .json if there is one"
    )
    parser.add_argument("--robot", metavar="R", help="of a CAN log: the robot whose file says what is on its bus")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")
    parser.add_argument("--chunk", type=int, metavar="N", default=0, help="feed the decoder N bytes at a time")
    parser.add_argument("--no-times", action="store_true", help="leave the byte times of the .json out of account")


def run(args: argparse.Namespace) -> int:
    """Decode a file; exit status 0 if a frame came out, 1 if none did."""
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError
    from bench.rc.health import HealthMeter, summary

    if args.chunk < 0:
        raise UsageError(f"--chunk: expected 1 or more bytes, got {args.chunk}")
    if args.robot is not None and args.protocol not in (*CAN_LOGS, AUTO):
        raise UsageError(f"--robot: goes with a CAN log ({', '.join(CAN_LOGS)}), not with {args.protocol}")
    if args.protocol == AUTO:
        protocol, capture = _recognised(args)
    else:
        protocol, capture = args.protocol, None
    if protocol is None:
        return EXIT_FAILED
    meter = HealthMeter()
    if protocol in CAN_LOGS:
        facts = _can(protocol, args.file, args.robot)
    else:
        facts = _serial(protocol, capture or _capture(protocol, args), args.chunk, meter)
    frames = 0
    for fact in facts:
        frames += fact["event"] == "frame"
        if args.json:
            print(json.dumps(fact))
        else:
            say(_line(fact))
    if not frames:
        print(f"wheelbench decode: no {protocol} frame in {spelt(str(args.file))}", file=sys.stderr)
    if protocol not in OTHER_WIRES and not args.json:
        print(f"wheelbench decode: {summary(meter.at())}", file=sys.stderr)
    return EXIT_OK if frames else EXIT_FAILED


def _recognised(args: argparse.Namespace) -> tuple[str | None, Capture | None]:
    """The protocol of the file, or None, and its bytes where it is a capture; says on stderr what was seen."""
    from bench.errors import UsageError
    from bench.rc.capture import load_capture
    from bench.rc.recognise import CAN, JUDGED_BYTES, is_can_log, recognise

    capture = verdict = None
    if args.file.is_file():
        # An empty file and a CAN log are no captures: they come before anything is asked of one.
        try:
            with args.file.open("rb") as file:
                head = file.read(JUDGED_BYTES)
        except OSError as error:
            raise UsageError(f"{args.file}: cannot be read ({error.strerror}); check the path") from None
        if not head or is_can_log(head):
            verdict = recognise(head)
    if verdict is None:
        capture = load_capture(args.file, use_times=not args.no_times)
        verdict = recognise(capture.data, capture.times_us)
    print(f"wheelbench decode: {spelt(str(args.file))}: {verdict.text}", file=sys.stderr)
    # The DM3519 speaks on the identifiers of the C610: nothing in a log tells them apart for certain.
    return "c610" if verdict.protocol == CAN else verdict.protocol, capture


def _capture(protocol: str, args: argparse.Namespace) -> Capture:
    from bench import rc_decode
    from bench.config import nearest
    from bench.errors import UsageError
    from bench.rc.capture import load_capture

    known = [*rc_decode.PROTOCOLS, *OTHER_WIRES, AUTO]
    if protocol not in known:
        raise UsageError(f"no protocol is called {protocol!r}{nearest(protocol, known)}")
    return load_capture(args.file, use_times=not args.no_times)


def _serial(protocol: str, capture: Capture, chunk: int, meter: HealthMeter) -> Iterator[dict[str, Any]]:
    pieces = _pieces(capture.data, capture.times_us, chunk or len(capture.data))
    if protocol == "slamware":
        return _slamware(data for data, _ in pieces)
    return _rc(protocol, pieces, capture.times_us, meter)


def _pieces(data: bytes, times_us: Any, size: int) -> Iterator[tuple[bytes, Any]]:
    for start in range(0, len(data), size):
        yield data[start : start + size], times_us[start : start + size] if times_us is not None else None


def _rc(
    protocol: str, pieces: Iterable[tuple[bytes, Any]], times_us: Sequence[float] | None, meter: HealthMeter
) -> Iterator[dict[str, Any]]:
    from bench import rc_decode

    decoder = rc_decode.decoder(protocol)
    for data, piece_times_us in chain(pieces, [(b"", None)]):
        for event in decoder.feed(data, piece_times_us) if data else decoder.finish():
            meter.take(times_us[event.offset + event.length - 1] if times_us is not None else None, [event])
            yield _rc_fact(protocol, event)


def _rc_fact(protocol: str, event: RcEvent) -> dict[str, Any]:
    """One event as plain values: `channels` are raw wire values, `offset` counts bytes from the start of the file."""
    from bench.messages import RcFrame, RcLinkStatistics, RcNoise

    fact: dict[str, Any] = {"event": "other", "protocol": protocol, "offset": event.offset, "length": event.length}
    if isinstance(event, RcFrame):
        flags = {"failsafe": event.failsafe, "frame_lost": event.frame_lost}
        flags |= dict(zip(("ch17", "ch18"), event.digital, strict=False))  # as their makers call them, counted from 1
        return fact | {"event": "frame", "channels": list(event.channels), "flags": flags}
    if isinstance(event, RcNoise):
        return fact | {"event": "noise", "reason": event.reason}
    if isinstance(event, RcLinkStatistics):
        rest = {key: value for key, value in event._asdict().items() if key not in fact}
        return fact | {"event": "link"} | rest
    return fact | {"kind": event.kind}


def _slamware(pieces: Iterable[bytes]) -> Iterator[dict[str, Any]]:
    from bench.slamware.describe import Conversation
    from bench.slamware.framing import FrameDecoder

    decoder, conversation = FrameDecoder(), Conversation()
    for data in pieces:
        for event in decoder.feed(data):
            yield conversation.describe(event)
    for event in decoder.finish():
        yield conversation.describe(event)


def _can(protocol: str, path: Path, robot: str | None) -> Iterator[dict[str, Any]]:
    """The frames of a CAN log in any format that python-can reads."""
    from bench.cli.canlog import frames

    describe = _family(protocol, robot).describe
    for frame in frames(path):
        classic = not frame.extended and frame.remote_length is None
        decoded = describe(frame.can_id, frame.data) if classic else {}
        yield {
            "event": "frame" if decoded else "other",
            "protocol": protocol,
            "at_us": frame.at_us,
            "can_id": frame.can_id,
            "data": frame.data.hex(),
            "decoded": decoded,
        }


def _family(protocol: str, robot: str | None) -> Family:
    from bench.canbus import c610, dm3519
    from bench.config import load_robot
    from bench.errors import UsageError
    from bench.motors import family

    if robot is None:
        return c610.FAMILY if protocol == "c610" else dm3519.family()
    found = family(load_robot(robot))
    if found.name != protocol:
        raise UsageError(f"--robot: {robot} has motors of kind {found.name}, not {protocol}")
    return found


def _line(fact: dict[str, Any]) -> str:
    """The same for people."""
    if "can_id" in fact:
        fields = "  ".join(f"{key} {value}" for key, value in fact["decoded"].items())
        return f"{fact['at_us'] / 1e6:12.6f}  0x{fact['can_id']:03X}  {fields or fact['data']}"
    where = f"{fact['offset']:8} +{fact['length']:<4}"
    if fact["event"] == "noise":
        return f"{where} noise     {fact['reason']}"
    if "channels" in fact:
        flags = " ".join(name for name, is_set in fact["flags"].items() if is_set)
        return f"{where} channels  {' '.join(f'{raw:4}' for raw in fact['channels'])}  {flags}".rstrip()
    rest = {key: value for key, value in fact.items() if key not in ("event", "protocol", "offset", "length")}
    if "decoded" in rest:
        rest |= rest.pop("decoded")
    return f"{where} {fact['event']:9} " + "  ".join(f"{key} {value}" for key, value in rest.items())
