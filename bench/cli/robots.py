"""`wheelbench robots`: what can be driven."""

from __future__ import annotations

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("--json", action="store_true", help="one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """List the robots that come with wheelbench."""
    import json

    from bench.config import load_robot, profile_names, robot_names

    for name in robot_names():
        robot = load_robot(name)
        facts = {
            "name": name,
            "wheels": len(robot.wheels),
            "rc": robot.rc.name if robot.rc else None,
            "motor": robot.motor.kind,
            "current_limit_a": robot.limits.current_a,
            "about": robot.about,
        }
        if args.json:
            print(json.dumps(facts))
        else:
            print(f"{name:12} {robot.about}")
            rc = facts["rc"] or "none"
            motors = f"{len(robot.wheels)} wheels, {robot.motor.kind}, {robot.limits.current_a:g} A"
            print(f"{'':12} {motors}, transmitter {rc}")
    if not args.json:
        print(f"\nyour own: --robot my_robot.toml (copy one of bench/robots/). Profiles: {', '.join(profile_names())}")
    return 0
