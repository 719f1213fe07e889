"""`wheelbench kin ROBOT`: wheel speeds from a twist and back, the matrices and how well-conditioned they are."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.config import Robot
    from bench.kinematics import Kinematics


NAME_WIDTH, CELL_WIDTH = 14, 12
MOST = 1e6
"""Of any number that is given, in m/s or rad/s: beyond every robot, and far from where arithmetic ends."""
TWIST = ("vx", "vy", "omega")


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
    from bench.kinematics import Kinematics, if_rollers_leaned_the_other_way

    robot = load_robot(args.robot)
    kinematics = Kinematics(robot.wheels)
    names = [wheel.name for wheel in robot.wheels]
    if args.twist is not None:
        twist = _numbers("--twist", args.twist, 3)
        wheels = kinematics.wheel_speeds(twist)
        facts: dict[str, object] = {"twist": twist, "wheels_radps": wheels}
        lines = [*_twist_line(twist), *_table(names, {"rad/s": wheels})]
    elif args.wheels is not None:
        wheels = _numbers("--wheels", args.wheels, len(names))
        twist, slip = list(kinematics.twist(wheels)), kinematics.slip(wheels)
        facts = {"twist": twist, "wheels_radps": wheels, "slip": slip}
        lines = [*_twist_line(twist), *_table(names, {"rad/s": wheels, "of it slip": slip})]
    else:
        facts = {"name": robot.name, "wheel_names": names, **_matrices(kinematics), **_dead_wheels(robot)}
        mirrored = if_rollers_leaned_the_other_way(robot.wheels)
        if mirrored is not None:
            facts["condition_with_rollers_negated"] = mirrored
        lines = _matrix_lines(kinematics, names, mirrored) + _dead_wheel_lines(robot)
    if args.json:
        print(json.dumps(facts))
    else:
        say(*lines)
    return 0


def _matrices(kinematics: Kinematics) -> dict[str, object]:
    values = _singular_values(kinematics)
    return {
        "twist_to_wheels": [list(row) for row in kinematics.inverse_rows],
        "wheels_to_twist": [list(row) for row in kinematics.forward_rows],
        "length_m": kinematics.length_m,
        "singular_values": values,
        "condition": values[0] / values[2],
        "slip_vectors": kinematics.slip_vectors(),
    }


def _dead_wheels(robot: Robot) -> dict[str, object]:
    """H of the passive wheels, and the way back where there are enough of them; nothing where there are none."""
    from bench.kinematics import Kinematics, speed_rows

    facts: dict[str, object] = {}
    if robot.dead_wheels:
        facts["twist_to_dead_wheels"] = [list(row) for row in speed_rows(robot.dead_wheels)]
    if len(robot.dead_wheels) >= 3:
        facts["dead_wheels_to_twist"] = [list(row) for row in Kinematics(robot.dead_wheels).forward_rows]
    return facts


def _matrix_lines(kinematics: Kinematics, names: Sequence[str], mirrored: float | None) -> list[str]:
    values = _singular_values(kinematics)
    lines = ["H: rad/s of a wheel for 1 m/s forward, 1 m/s left, 1 rad/s counter-clockwise", ""]
    lines += _table(names, dict(zip(TWIST, zip(*kinematics.inverse_rows, strict=True), strict=True)))
    lines += ["", "H+: what 1 rad/s of each wheel adds to the best fit, m/s, m/s and rad/s", ""]
    lines += _table(names, dict(zip(TWIST, kinematics.forward_rows, strict=True)))
    lines += ["", f"singular values   {'  '.join(f'{value:.4f}' for value in values)}"]
    lines += [f"                  of the rows in m/s, yaw at {kinematics.length_m:.4g} m, the farthest wheel's"]
    lines += [f"condition         {values[0] / values[2]:.4f}"]
    if mirrored is not None:
        lines += [
            f"                  {mirrored:.4f} with every roller_deg negated: it is that of",
            "                  the roller on the ground; the one on top leans the other way",
        ]
    lines += [""]
    vectors = kinematics.slip_vectors()
    if not vectors:
        return [*lines, "Any three wheel speeds are a motion: slip cannot be seen."]
    slip = {f"n{i + 1}" if len(vectors) > 1 else "n": vector for i, vector in enumerate(vectors)}
    return [*lines, "n . wheels is zero unless the wheels slip", "", *_table(names, slip)]


def _dead_wheel_lines(robot: Robot) -> list[str]:
    from bench.kinematics import Kinematics, speed_rows

    dead = robot.dead_wheels
    if not dead:
        return []
    names = [wheel.name for wheel in dead]
    rows = zip(*speed_rows(dead), strict=True)
    lines = ["", "Dead wheels, H", "", *_table(names, dict(zip(TWIST, rows, strict=True)))]
    if len(dead) >= 3:
        back = Kinematics(dead).forward_rows
        lines += ["", "Dead wheels, H+", "", *_table(names, dict(zip(TWIST, back, strict=True)))]
    return lines


def _singular_values(kinematics: Kinematics) -> list[float]:
    from bench.kinematics import singular_values

    return singular_values(kinematics.axes, kinematics.length_m)


def _numbers(option: str, text: str, count: int) -> list[float]:
    from bench.errors import UsageError

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or any(number != number for number in numbers):
        raise UsageError(f"{option}: expected {count} numbers with commas between them, got {text!r}")
    if any(abs(number) > MOST for number in numbers):
        raise UsageError(f"{option}: expected numbers from -{MOST:.0f} to {MOST:.0f}, got {text!r}")
    return numbers


def _twist_line(twist: Sequence[float]) -> list[str]:
    vx, vy, omega = twist
    return [f"forward {vx + 0.0:.5f} m/s, left {vy + 0.0:.5f} m/s, counter-clockwise {omega + 0.0:.5f} rad/s", ""]


def _table(names: Sequence[str], columns: Mapping[str, Sequence[float]]) -> list[str]:
    """A line a wheel, so that eight of them fit on a screen."""
    width = max(NAME_WIDTH, *(len(name) + 1 for name in names))
    lines = [f"  {'':{width}}" + "".join(f"{head:>{CELL_WIDTH}}" for head in columns)]
    for name, *values in zip(names, *columns.values(), strict=True):
        lines.append(f"  {name:{width}}" + "".join(f" {round(value, 5) + 0.0:{CELL_WIDTH - 1}.5f}" for value in values))
    return lines
