"""`--controller` and `--odometry`: another form in the place of the bench's own. docs/errata.md."""

from __future__ import annotations

import argparse


def add_choices(parser: argparse.ArgumentParser) -> None:
    """The two options. What they name is looked up where the robot is read, with the nearest name in the error."""
    parser.add_argument("--controller", metavar="NAME", help="a printed form instead of the speed loop: docs/errata.md")
    parser.add_argument("--odometry", metavar="NAME", help="a printed form instead of exact odometry: docs/errata.md")
