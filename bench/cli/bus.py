"""`wheelbench bus ROBOT`: does everything fit on the motors' CAN bus, and how late can each message be?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.cli.output import say

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bench.canbus.budget import Budget
    from bench.canbus.measured import Measurement
    from bench.canbus.streams import Stream
    from bench.canbus.table import Family


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("robot", metavar="ROBOT", help="a name that `wheelbench robots` lists, or a .toml file")
    parser.add_argument(
        "--feedback-hz", metavar="N", type=int, default=1000, help="reports a second of each ESC and board (1000)"
    )
    parser.add_argument("--command-hz", metavar="N", type=int, default=1000, help="commands a second of a group (1000)")
    parser.add_argument(
        "--nodes", metavar="N|N-M", help="ESCs 1 to N in place of the robot's own; N-M: a line for every number of them"
    )
    parser.add_argument("--bitrate", metavar="N", type=int, default=1_000_000, help="bits a second (1000000)")
    parser.add_argument(
        "--also",
        metavar="ID:HZ[:BYTES]",
        action="append",
        default=[],
        help="something else on the bus: 0x205:1000, 0x101:50:4",
    )
    parser.add_argument("--log", metavar="FILE", type=Path, help="measure a recorded bus instead: any CAN log")
    parser.add_argument("--json", action="store_true", help="one JSON object, or one a line for --nodes N-M")


def run(args: argparse.Namespace) -> int:
    """Reckon and say the verdict; exit status 1 where something does not fit or two senders clash."""
    import json

    from bench.canbus.budget import CLASH, TOO_MUCH, budget, guaranteed_feedback_hz
    from bench.canbus.instruments import instrument_streams
    from bench.canbus.streams import streams
    from bench.config import load_robot
    from bench.errors import EXIT_FAILED, EXIT_OK
    from bench.motors import family as family_of

    robot = load_robot(args.robot)
    family = family_of(robot)
    for name in ("feedback_hz", "command_hz", "bitrate"):
        _check_range(f"--{name.replace('_', '-')}", getattr(args, name), 1, 1_000_000)
    if args.log is not None:
        return _measured(family, [wheel.can_id for wheel in (*robot.wheels, *robot.dead_wheels)], args)
    rates = {"feedback_hz": args.feedback_hz, "command_hz": args.command_hz}
    others = [_other(text) for text in args.also]
    counts = _node_counts(args.nodes)
    if not counts:
        boards = sorted(wheel.can_id for wheel in robot.dead_wheels)
        others += instrument_streams(boards, robot.gyro.can_id if robot.gyro else None, args.feedback_hz)
    if len(counts) > 1:
        return _many(family, counts, rates, others, args)
    numbers = range(1, counts[0] + 1) if counts else sorted(wheel.can_id for wheel in robot.wheels)
    found = budget([*streams(family, numbers, **rates), *others], args.bitrate)
    highest = guaranteed_feedback_hz(family, numbers, command_hz=args.command_hz, bitrate=args.bitrate, others=others)
    if args.json:
        facts = _facts(found) | {"robot": robot.name, "motors": len(numbers), "guaranteed_feedback_hz": highest} | rates
        print(json.dumps(facts))
    else:
        say(f"{robot.name}: {len(numbers)} {family.name} at {args.bitrate / 1e6:g} Mbit/s", "", *_lines(found))
        if found.verdict != CLASH and highest != args.feedback_hz:
            say(_advice(highest, args.feedback_hz))
    return EXIT_FAILED if found.verdict in (TOO_MUCH, CLASH) else EXIT_OK


def _many(family: Family, counts: range, rates: dict[str, int], others: list[Stream], args: argparse.Namespace) -> int:
    """A line for every number of motors."""
    import json

    from bench.canbus.budget import budget
    from bench.canbus.streams import streams

    if not args.json:
        say("motors  frames/s  least %  typical %  at rest %  worst %  verdict")
    for count in counts:
        sent = [*streams(family, range(1, count + 1), **rates), *others]
        found = budget(sent, args.bitrate)
        if args.json:
            print(json.dumps({"motors": count, **rates, **_facts(found)}))
            continue
        loads = "".join(f"{100 * load:{width}.1f}" for load, width in zip(_loads(found), (9, 11, 11, 9), strict=True))
        say(f"{count:6}{sum(one.hz for one in sent):10}{loads}  {found.verdict}")
    return 0


def _measured(family: Family, numbers: list[int], args: argparse.Namespace) -> int:
    """What a log says; exit status 1 where somebody is on the bus who should not be."""
    import json

    from bench.canbus.c610 import QUICK_ID
    from bench.canbus.measured import measure
    from bench.canbus.watch import BusWatch
    from bench.cli.canlog import frames
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError

    also = [message.can_id for message in family.others if message.can_id != QUICK_ID]
    found = measure(frames(args.log), BusWatch(numbers, also), args.bitrate)
    if not found.frames:
        raise UsageError(f"{args.log}: has no frame of classic CAN")
    if args.json:
        print(json.dumps(_measured_facts(found)))
    else:
        say(*_measured_lines(found))
    return EXIT_FAILED if found.findings else EXIT_OK


def _measured_facts(found: Measurement) -> dict[str, Any]:
    return {
        "bitrate": found.bitrate,
        "seconds": round(found.seconds, 6),
        "frames": found.frames,
        "load_percent": {"mean": round(100 * found.load, 2), "busiest_100_ms": round(100 * found.busiest, 2)},
        "messages": [
            {
                "can_id": one.can_id,
                "extended": one.extended,
                "frames": one.frames,
                "bits": {"least": one.least_bits, "mean": round(one.bits / one.frames, 2), "most": one.most_bits},
            }
            for _, one in sorted(found.by_id.items())
        ],
        "findings": [finding.text for finding in found.findings],
    }


def _measured_lines(found: Measurement) -> Iterable[str]:
    yield f"{found.frames} frames in {found.seconds:.3f} s at {found.bitrate / 1e6:g} Mbit/s"
    yield f"load {100 * found.load:.1f} %, in the busiest 100 ms {100 * found.busiest:.1f} %"
    yield ""
    yield "id            frames      Hz   bits: least     mean   most"
    for _, one in sorted(found.by_id.items()):
        hz = one.frames / found.seconds if found.seconds else 0.0
        name = f"0x{one.can_id:0{8 if one.extended else 3}X}"
        mean = one.bits / one.frames
        yield f"{name:10}{one.frames:10}{hz:8.0f}{one.least_bits:14}{mean:9.1f}{one.most_bits:7}"
    yield ""
    yield from (finding.text for finding in found.findings)
    if not found.findings:
        yield "nobody is on the bus who should not be"


def _loads(found: Budget) -> tuple[float, float, float, float]:
    return found.least, found.typical, found.resting, found.worst


def _facts(found: Budget) -> dict[str, Any]:
    """Everything as plain values. Loads in percent, times in microseconds; null where a time has no bound."""
    names = ("least", "typical", "at_rest", "worst")
    return {
        "bitrate": found.bitrate,
        "load_percent": {name: round(100 * load, 4) for name, load in zip(names, _loads(found), strict=True)},
        "messages": [
            {
                "can_id": row.stream.can_id,
                "name": row.stream.name,
                "hz": row.stream.hz,
                "bits": {name: round(bits, 2) for name, bits in zip(names, row.stream.bits, strict=True)},
                "period_us": round(row.period_us, 3),
                "response_us": {"usual": _rounded(row.usual_us), "worst": _rounded(row.worst_us)},
                "guaranteed": row.is_guaranteed,
            }
            for row in found.rows
        ],
        "verdict": found.verdict,
        "text": found.text,
    }


def _lines(found: Budget) -> Iterable[str]:
    yield "id     message                   Hz   bits: least  typical  at rest  worst   response: usual     worst   due"
    for row in found.rows:
        one = row.stream
        bits = f"{one.bits.least:11}{one.bits.typical:9.1f}{one.bits.resting:9.1f}{one.bits.worst:7}"
        times = f"{_time(row.usual_us):>18}{_time(row.worst_us):>10}{row.period_us:6.0f}"
        yield f"0x{one.can_id:03X}  {one.name:21}{one.hz:7} {bits}{times}"
    least, typical, resting, worst = (f"{100 * load:.1f} %" for load in _loads(found))
    yield f"{'load':36} {least:>11}{typical:>9}{resting:>9}{worst:>8}"
    yield ""
    yield found.text


def _time(us: float | None) -> str:
    return "no bound" if us is None else f"{us:.0f} us"


def _rounded(us: float | None) -> float | None:
    return None if us is None else round(us, 3)


def _advice(highest: int, feedback_hz: int) -> str:
    if highest == 0:
        return "no rate of feedback would fit: fewer commands, fewer motors, or a second bus"
    if highest < feedback_hz:
        return (
            f"guaranteed up to {highest} Hz of feedback with these commands; the rate is set in the ESC's configuration"
        )
    return f"there is room: {highest} Hz of feedback would still be guaranteed"


def _check_range(option: str, value: int, low: int, high: int) -> None:
    from bench.errors import UsageError

    if not low <= value <= high:
        raise UsageError(f"{option}: expected {low} to {high}, got {value}")


def _node_counts(text: str | None) -> range:
    """`5` is one count, `3-8` six of them; none given is none."""
    from bench.canbus.c610 import ESCS
    from bench.errors import UsageError

    if text is None:
        return range(0)
    first, dash, last = text.partition("-")
    try:
        low, high = int(first), int(last if dash else first)
    except ValueError:
        low, high = 0, 0
    if not 1 <= low <= high <= ESCS:
        raise UsageError(f"--nodes: expected 1 to {ESCS} or a range of these like 3-8, got {text!r}")
    return range(low, high + 1)


def _other(text: str) -> Stream:
    from bench.canbus.streams import other_stream
    from bench.errors import UsageError

    parts = text.split(":")
    try:
        can_id, hz, length = int(parts[0], 0), int(parts[1]), int(parts[2]) if len(parts) == 3 else 8
    except (ValueError, IndexError):
        can_id, hz, length = -1, 0, 0
    if len(parts) > 3 or not 0 <= can_id <= 0x7FF or not 1 <= hz <= 100_000 or not 0 <= length <= 8:
        raise UsageError(f"--also: expected ID:HZ or ID:HZ:BYTES like 0x205:1000, got {text!r}")
    return other_stream(can_id, hz, length)
