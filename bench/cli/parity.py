"""`wheelbench parity SCENARIO --worlds sim,WORLD,...`: one scenario, several bases; where they part, and how."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.check.parity import Parity
    from bench.check.worlds import Beside

ABOUT = """A WORLD is sim (our own base), what --controller takes elsewhere (FILE.py:NAME, a firmware's FILE.toml, a
name such as no-timeout), or a recording of the same scenario, made on real hardware perhaps. The first one drives; what
it heard is given to each of the others, byte for byte, and what they say is held against it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.description = ABOUT
    parser.add_argument("scenario", metavar="SCENARIO", type=Path, help="a scenario (.toml)")
    parser.add_argument(
        "--worlds",
        metavar="W,W,...",
        type=_between_commas,
        action="extend",
        default=[],
        help="two or more, with commas between; the first is the reference",
    )
    parser.add_argument(
        "--world",
        metavar="W",
        dest="worlds",
        action="append",
        default=[],
        help="one more, as it stands: for a path that has a comma; may be given again, and alone",
    )
    parser.add_argument("--robot", metavar="R", help="another than the scenario's: a name or a .toml file")
    parser.add_argument("--record", metavar="DIR", type=Path, help="keep the reference's recording there")
    parser.add_argument("--overwrite", action="store_true", help="replace the recording that DIR holds")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Run them, one after the other; exit status 1 where one says anything else, or at another time."""
    from bench.check.worlds import worlds_of
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError

    names = [name for name in args.worlds if name]
    if len(names) < 2:
        given = f"only {names[0]}" if names else "none"
        raise UsageError(
            f"--worlds: expected two or more with commas between, like sim,my_base.py:Base, and got {given} "
            "(a path that has a comma: --world sim --world PATH)"
        )
    found = []
    for beside in worlds_of(args.scenario, names, robot=args.robot, record=args.record, overwrite=args.overwrite):
        found.append(beside)
        if not args.json:  # at once: the next world may fail, or take its time
            say(*_lines(names[0], beside), flush=True)
    if args.json:
        print(json.dumps({"reference": names[0], "worlds": [_facts(one) for one in found]}))
    return EXIT_OK if all(one.parity.is_same for one in found) else EXIT_FAILED


def _between_commas(text: str) -> list[str]:
    return text.split(",")


def _facts(beside: Beside) -> dict[str, Any]:
    parity = beside.parity
    first = parity.first
    return {
        "world": beside.world,
        "same": parity.is_same,
        "ticks": beside.ticks,
        "first": first
        and {
            "tick": first.tick,
            "wire": first.wire,
            "field": first.field,
            "reference": first.reference,
            "peer": first.peer,
        },
        "timing": _findings(parity, is_time=True),
        "values": _findings(parity, is_time=False),
    }


def _findings(parity: Parity, *, is_time: bool) -> list[dict[str, Any]]:
    return [
        {"kind": one.kind, "wire": one.wire, "fields": list(one.fields), "amount": one.amount, "text": one.text}
        for one in parity.findings
        if one.is_time == is_time
    ]


def _lines(reference: str, beside: Beside) -> list[str]:
    parity, seconds = beside.parity, beside.ticks / 1000
    if parity.first is None:
        return [f"{beside.world}: the same as {reference}, byte for byte, for {seconds:.1f} s"]
    first = parity.first
    what = f"{first.wire} {first.field}".rstrip()
    lines = [
        f"{beside.world}: not the same as {reference}",
        f"  first     {first.tick / 1000:.3f} s (tick {first.tick}) {what}: {reference} {first.reference},"
        f" {beside.world} {first.peer}",
    ]
    for title, is_time, none in (("timing", True, "none is late, early or missing"), ("value", False, "none differs")):
        texts = [one.text for one in parity.findings if one.is_time == is_time] or [none]
        lines += [f"  {title if not at else '':<8}  {text}" for at, text in enumerate(texts)]
    return lines
