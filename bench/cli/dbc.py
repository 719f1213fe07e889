"""`wheelbench dbc ROBOT`: a DBC of every message on the robot's motor bus, for SavvyCAN, cantools and the like."""

from __future__ import annotations

import argparse
import sys


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("robot", metavar="ROBOT", help="a name that `wheelbench robots` lists, or a .toml file")


def run(args: argparse.Namespace) -> int:
    """Write the file to standard output: `wheelbench dbc m2006 > m2006.dbc`."""
    from bench.canbus.dbc import dbc
    from bench.config import load_robot
    from bench.motors import family as family_of

    robot = load_robot(args.robot)
    family = family_of(robot)
    sys.stdout.write(dbc(family, f"{family.about}, as on the robot {robot.name}"))
    return 0
