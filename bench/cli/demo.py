"""`wheelbench demo`: the bench in one go. In a terminal the dashboard plays it; without one it runs headless."""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from bench.cli.output import say
from bench.cli.terminal import has_terminal

if TYPE_CHECKING:
    from bench.screen.stage import Show


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("--headless", action="store_true", help="no dashboard, even in a terminal")
    parser.add_argument("--arena", metavar="FILE", help="drive it somewhere else; the golden will say where it differs")
    parser.add_argument("--record", metavar="DIR", type=Path, help="keep the recording")
    parser.add_argument("--overwrite", action="store_true", help="replace the recording that DIR holds")
    parser.add_argument("--update-pinned", action="store_true", help="make this run the golden (refused in CI)")
    parser.add_argument("--json", action="store_true", help="the summary as one JSON object")


def run(args: argparse.Namespace) -> int:
    """Run the demo and check it against its golden."""
    headless = args.headless or args.json or args.update_pinned
    if not headless and has_terminal():
        from bench.demo import SCENARIO
        from bench.screen.opening import opening_of_scenario
        from bench.tui import show

        return show(lambda: _shown(args), opening_of_scenario(SCENARIO, args.arena))
    return _headless(args)


def _shown(args: argparse.Namespace) -> Show:
    from bench.check.reading import Recording
    from bench.check.sources import from_scenario
    from bench.demo import SCENARIO, golden_directory
    from bench.screen.stage import Show

    job = from_scenario(SCENARIO, arena=args.arena)
    recorder = job.recorder(args.record, overwrite=args.overwrite) if args.record else None
    return Show(job, recorder, Recording.open(golden_directory()))


def _headless(args: argparse.Namespace) -> int:
    from bench.check.conduct import shortcomings
    from bench.check.golden import told
    from bench.check.reading import Recording
    from bench.check.sources import from_scenario
    from bench.cli.check import pin_and_tell
    from bench.cli.headless import execute
    from bench.demo import SCENARIO, golden_directory
    from bench.errors import EXIT_FAILED, EXIT_OK

    job = from_scenario(SCENARIO, arena=args.arena)
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as scratch:
        directory = args.record or Path(scratch) / "demo"
        summary, speed = execute(job, job.recorder(directory, overwrite=args.overwrite), quiet=args.json)
        if args.update_pinned:
            return pin_and_tell(directory, golden_directory(), args.json)
        comparison = told(Recording.open(directory), golden_directory())
    if args.json:
        print(json.dumps(summary.facts(job) | {"speed_factor": round(speed, 2), "golden": comparison.as_dict()}))
    else:
        say("wheelbench demo: RC bytes in, the robot moves, every frame recorded and checked")
        say(*summary.lines(job), f"speed     {speed:.1f} times real time, recording on")
        if args.record:
            say(f"recorded  {args.record}")
        say(*(f"{'' if at else 'golden':<10}{line}" for at, line in enumerate(comparison.lines)))
    return EXIT_OK if comparison.ok and not shortcomings(job) else EXIT_FAILED
