"""`wheelbench check RUN [GOLDEN]`: compare, and say in words what differs; and whether RUN's own wires agree."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from bench.cli.choices import add_tolerance
from bench.cli.output import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("run", metavar="RUN", type=Path, help="a recording")
    parser.add_argument(
        "golden",
        metavar="GOLDEN",
        type=Path,
        nargs="?",
        help="a golden or another recording (the demo's golden unless given)",
    )
    parser.add_argument(
        "--update-pinned",
        action="store_true",
        help="make RUN the golden at GOLDEN, and say what that changes (refused in CI)",
    )
    add_tolerance(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Compare, and hold the run's wires against each other; exit status 1 when something is not as it should be."""
    from bench.check.crosswire.finding import check_lines
    from bench.check.crosswire.recorded import outcomes_of
    from bench.check.firmware_log import death
    from bench.check.golden import told
    from bench.check.reading import Recording
    from bench.config import ConfigError
    from bench.demo import golden_directory
    from bench.errors import EXIT_FAILED, EXIT_OK

    if args.update_pinned:
        return _pin(args)
    golden = args.golden or golden_directory()
    recording = Recording.open(args.run)
    found = told(recording, golden, args.tolerance)
    try:
        outcomes, unread = outcomes_of(recording), []
    except ConfigError as error:  # a comparison needs no robot; what its wires should say of each other does
        outcomes, unread = [], [f"checks    not judged: {error}"]
    died = death(args.run)
    if args.json:
        facts = found.as_dict() | {"checks": [outcome.as_dict() for outcome in outcomes]}
        print(json.dumps(facts | ({"died": died.as_dict()} if died else {})))
    else:
        say(*found.lines, *check_lines(outcomes), *unread, *(died.lines() if died else []))
    return EXIT_OK if found.ok and all(outcome.ok for outcome in outcomes) else EXIT_FAILED


def _pin(args: argparse.Namespace) -> int:
    from bench.errors import UsageError

    if args.golden is None:
        raise UsageError("--update-pinned: say which golden: wheelbench check RUN GOLDEN --update-pinned")
    return pin_and_tell(args.run, args.golden, args.json)


def pin_and_tell(run: Path, golden: Path, as_json: bool) -> int:
    """Make a recording the golden, print what that changes, and give the exit status."""
    from bench.check.golden import pin
    from bench.errors import EXIT_OK

    changed = pin(run, golden)
    if as_json:
        print(json.dumps({"pinned": str(golden), "changed": changed.as_dict() if changed else None}))
    else:
        say(*(changed.lines if changed else ["pinned for the first time"]), f"pinned: {golden}")
    return EXIT_OK
