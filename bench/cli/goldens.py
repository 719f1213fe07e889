"""`wheelbench goldens [FOLDER]`: what is pinned, whether it is whole, and which goldens nothing is held against."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from bench.cli.output import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument(
        "folder",
        metavar="FOLDER",
        type=Path,
        nargs="?",
        default=Path("fixtures/pinned"),
        help="where they lie (fixtures/pinned)",
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """List them; exit status 1 if one is damaged or used by no test, scenario or program."""
    from bench.check.pinned import goldens
    from bench.errors import EXIT_FAILED, EXIT_OK

    found = goldens(args.folder)
    if args.json:
        rows = [
            {
                "name": one.directory.name,
                "robot": one.robot,
                "ticks": one.ticks,
                "users": one.users,
                "damage": one.damage,
                "unread": one.unread,
            }
            for one in found
        ]
        print(json.dumps({"ok": all(one.ok for one in found), "goldens": rows}))
    else:
        say(*([one.text for one in found] or [f"{args.folder} holds no golden"]))
    return EXIT_OK if all(one.ok for one in found) else EXIT_FAILED
