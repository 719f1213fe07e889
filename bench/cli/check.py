"""`wheelbench check RUN [GOLDEN]`: compare, and say in words what differs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path


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
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Compare; exit status 0 when nothing differs beyond what is allowed, 1 when something does."""
    from bench.check.golden import told
    from bench.check.reading import Recording
    from bench.demo import golden_directory
    from bench.errors import EXIT_FAILED, EXIT_OK

    golden = args.golden or golden_directory()
    found = told(Recording.open(args.run), golden)
    print(json.dumps(found.as_dict()) if args.json else "\n".join(found.lines))
    return EXIT_OK if found.ok else EXIT_FAILED
