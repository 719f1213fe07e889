"""Options that several verbs share: who stands behind the seam, tolerances, the RC protocol of a stream."""

from __future__ import annotations

import argparse

ROLE_HELP = "which part is real: sim (none), base (a firmware), core (a SLAMWARE core), motors"
ARM_HELP = "with --role motors: they may move"


def add_controller(parser: argparse.ArgumentParser) -> None:
    """Who stands behind the seam. What it names is looked up where the robot is read: `bench.check.controllers`."""
    parser.add_argument(
        "--controller",
        metavar="C",
        help="instead of the bench's own: yours (FILE.py:NAME, module:NAME, or a firmware's FILE.toml: docs/dut.md), "
        "a wrong one (docs/scenarios.md), "
        "or a printed form (docs/errata.md)",
    )
    parser.add_argument("--traceback", action="store_true", help="show errors in your own controller whole")


def add_choices(parser: argparse.ArgumentParser) -> None:
    """The controller and the odometry."""
    add_controller(parser)
    parser.add_argument("--odometry", metavar="NAME", help="a printed form instead of exact odometry: docs/errata.md")


def add_tolerance(parser: argparse.ArgumentParser) -> None:
    """How far fields may be from a golden; `bench.check.tolerances` reads it."""
    parser.add_argument(
        "--tolerance",
        metavar="FIELD=SIZE",
        action="append",
        default=[],
        help="how far a field may be from the golden, with its unit: speed=5rpm; may be given again",
    )


def check_protocol(protocol: str) -> None:
    """What `--protocol` names is one that we speak. Raises UsageError."""
    from bench.errors import UsageError
    from bench.rc_decode import PROTOCOLS

    if protocol not in PROTOCOLS:
        raise UsageError(f"--protocol {protocol}: expected {', '.join(PROTOCOLS)}")


def add_role(parser: argparse.ArgumentParser) -> None:
    """The options of every verb that can run on real ports."""
    parser.add_argument("--role", choices=("sim", "base", "core", "motors"), default="sim", help=ROLE_HELP)
    parser.add_argument("--arm", action="store_true", help=ARM_HELP)


def check_arm(role: str, arm: bool) -> None:
    """`--arm` is no wish that nothing can grant: only in one role is there anything real to move. Raises UsageError."""
    from bench.errors import UsageError

    if arm and role != "motors":
        raise UsageError(
            f"--arm: lets real motors move, and in the role {role} the bench drives none; leave it out, or give "
            "--role motors and their --can"
        )


def check_jobs(jobs: int) -> None:
    """Raises UsageError."""
    from bench.errors import UsageError

    if jobs < 1:
        raise UsageError(f"--jobs: expected 1 or more, got {jobs}")
