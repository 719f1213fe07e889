"""`wheelbench robots`: what can be driven."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.config import Robot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("--json", action="store_true", help="one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """List the robots that come with wheelbench."""
    import json

    from bench.config import load_robot, profile_names, robot_names

    for name in robot_names():
        robot = load_robot(name)
        if args.json:
            print(json.dumps(_facts(robot)))
        else:
            say(*_lines(robot))
    if not args.json:
        say(
            "",
            f"your own: --robot my_robot.toml; docs/robots.md has every key. Profiles: {', '.join(profile_names())}",
        )
    return 0


def _facts(robot: Robot) -> dict[str, object]:
    limits = robot.limits
    return {
        "name": robot.name,
        "about": robot.about,
        "source": robot.source,
        "assumed": list(robot.assumed),
        "wheels": len(robot.wheels),
        "wheel_names": [wheel.name for wheel in robot.wheels],
        "wheel_radii_m": [wheel.radius_m for wheel in robot.wheels],
        "dead_wheels": len(robot.dead_wheels),
        "gyro": robot.gyro is not None,
        "radius_m": robot.body.radius_m,
        "mass_kg": robot.body.mass_kg,
        "motor": robot.motor.kind,
        "current_limit_a": limits.current_a,
        "linear_mps": limits.linear_mps,
        "angular_radps": limits.angular_radps,
        "rc": robot.rc.name if robot.rc else None,
        "protocol": robot.rc.protocol if robot.rc else None,
    }


def _lines(robot: Robot) -> list[str]:
    """A robot in three lines: what it is, what it is made of, how it is driven."""
    limits, body = robot.limits, robot.body
    wheels = f"{len(robot.wheels)} wheels of {_millimetres([2 * wheel.radius_m for wheel in robot.wheels])} mm"
    if robot.dead_wheels:
        wheels += f", {len(robot.dead_wheels)} dead wheels"
    if robot.gyro:
        wheels += ", gyro"
    motors = f"{robot.motor.kind.upper()} up to {limits.current_a:g} A"
    driver = f"by {robot.rc.name} ({robot.rc.protocol})" if robot.rc else "by a SLAMWARE core alone"
    return [
        f"{robot.name:12} {robot.about}",
        f"{'':12} {wheels}; {2000 * body.radius_m:.0f} mm across, {body.mass_kg:g} kg; {motors}",
        f"{'':12} up to {limits.linear_mps:g} m/s and {limits.angular_radps:g} rad/s, {driver}",
    ]


def _millimetres(lengths_m: Sequence[float]) -> str:
    """One size, or from the smallest to the largest."""
    least, most = (f"{1000 * length:g}" for length in (min(lengths_m), max(lengths_m)))
    return least if least == most else f"{least} to {most}"
