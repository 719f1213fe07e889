"""`wheelbench kin ROBOT`: wheel speeds from a twist and back, the matrices and how well-conditioned they are."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bench.config import Robot
    from bench.kinematics import Kinematics


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("robot", metavar="ROBOT", help="a name that `wheelbench robots` lists, or a .toml file")
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--twist", metavar="VX,VY,OMEGA", help="m/s forward, m/s left, rad/s counter-clockwise")
    way.add_argument("--wheels", metavar="W1,W2,...", help="rad/s, in the robot's wheel order")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Convert, or print the robot's matrices."""
    import json

    from bench.config import load_robot
    from bench.kinematics import Kinematics

    robot = load_robot(args.robot)
    kinematics = Kinematics(robot.wheels)
    facts: dict[str, object]
    if args.twist is not None:
        twist = _numbers("--twist", args.twist, 3)
        facts = {"twist": twist, "wheels_radps": kinematics.wheel_speeds(twist)}
    elif args.wheels is not None:
        wheels = _numbers("--wheels", args.wheels, len(robot.wheels))
        facts = {"twist": list(kinematics.twist(wheels)), "wheels_radps": wheels, "slip": kinematics.slip(wheels)}
    else:
        facts = _matrices(kinematics)
        if robot.dead_wheels:
            facts |= _dead_wheels(robot)
    if args.json:
        print(json.dumps(facts))
        return 0
    for key, value in facts.items():
        print(f"{key.replace('_', ' '):24}", end="")
        rows = value if isinstance(value, list) and value and isinstance(value[0], list) else [value]
        for i, row in enumerate(rows):
            print(" " * (24 if i else 0) + (_line(row) if isinstance(row, list) else f"{row:.4f}"))
    return 0


def _matrices(kinematics: Kinematics) -> dict[str, object]:
    from bench.kinematics import singular_values

    values = singular_values(kinematics.axes, kinematics.length_m)
    return {
        "twist_to_wheels": [list(row) for row in kinematics.inverse_rows],
        "wheels_to_twist": [list(row) for row in kinematics.forward_rows],
        "singular_values": values,
        "condition": values[0] / values[2],
    }


def _dead_wheels(robot: Robot) -> dict[str, object]:
    """H of the passive wheels, and the way back where there are enough of them."""
    from bench.kinematics import Kinematics, speed_rows

    facts: dict[str, object] = {"twist_to_dead_wheels": [list(row) for row in speed_rows(robot.dead_wheels)]}
    if len(robot.dead_wheels) >= 3:
        facts["dead_wheels_to_twist"] = [list(row) for row in Kinematics(robot.dead_wheels).forward_rows]
    return facts


def _numbers(option: str, text: str, count: int) -> list[float]:
    from bench.errors import UsageError

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or any(number != number or abs(number) == float("inf") for number in numbers):
        raise UsageError(f"{option}: expected {count} numbers with commas between them, got {text!r}")
    return numbers


def _line(row: Sequence[float]) -> str:
    return "".join(f"{value + 0.0:12.5f}" for value in row)
