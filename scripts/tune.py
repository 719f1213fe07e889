"""Speed-loop gains of a robot file, by a stated method: what stands in each file's [control] table.

    python scripts/tune.py [ROBOT ...]      print the gains of these robots, or of all
    python scripts/tune.py --write          write them into the robot files

The loop. A motor's torque moves its wheel, and through the floor the body and the other wheels. Without slip the wheels
accelerate by H M^-1 H' tau, with M = diag(m, m, Jz) + J H'H: three directions of motion, each a first-order lag of its
own, with 1/inertia = mu / (1 + J mu) for the eigenvalues mu of H diag(m, m, Jz)^-1 H'. A wheel that slips or hangs in
the air has 1/J, above all of these, and is the fastest thing that the loop ever meets.

In the way stand the motor's current lag and 2 ms: half a tick of the speed measured as a difference of angles, one tick
until the feedback is heard, half a tick in which the current is held.

The rule. The corner ki/kp of the integrator lies at a quarter of the bandwidth that the slowest direction gets. Then kp
is the greatest with which
  * every direction keeps 60 degrees of phase margin on the floor, and a free wheel 45 degrees (viscous friction, which
    only adds to both, is left out), and
  * one count of the encoder, seen in one tick, moves the current by no more than 5 % of its limit.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from pathlib import Path
from typing import NamedTuple

from bench.canbus.c610 import COUNTS
from bench.config import Robot, load_robot, robot_names, robot_path
from bench.controller import DT_S
from bench.kinematics import Kinematics, singular_values

FLOOR_MARGIN_RAD = math.radians(60.0)
FREE_MARGIN_RAD = math.radians(45.0)
COUNT_SHARE_OF_LIMIT = 0.05
INTEGRATOR_CORNER = 1.0 / 4.0
DEAD_TIME_S = 2.0 * DT_S
DIGITS = 3


class Tuning(NamedTuple):
    """Gains, and what they give. Crossovers in rad/s; angles in radians."""

    kp_a_per_radps: float
    ki_a_per_rad: float
    free_crossover: float
    slow_crossover: float
    fast_crossover: float
    bound: str
    """What decided on kp, in words."""


def directions(robot: Robot) -> list[float]:
    """1/inertia, in rad/s^2 of the wheels for each N m on them, of the three directions of motion; greatest first."""
    m, jz, j = robot.body.mass_kg, robot.body.inertia_kgm2, robot.motor.inertia_kgm2
    rows = [
        (hx / math.sqrt(m), hy / math.sqrt(m), hw / math.sqrt(jz))
        for hx, hy, hw in Kinematics(robot.wheels).inverse_rows
    ]
    return [value * value / (1.0 + j * value * value) for value in singular_values(rows, 1.0)]


def phase_margin(crossover: float, corner: float, lag_s: float) -> float:
    """Of kp (1 + corner/s) / s behind the dead time and the lag, at its crossover (all rad/s)."""
    return math.pi / 2 - math.atan(corner / crossover) - DEAD_TIME_S * crossover - math.atan(lag_s * crossover)


def tune(robot: Robot) -> Tuning:
    """The gains of this robot by the rule above."""
    motor = robot.motor
    free = 1.0 / motor.inertia_kgm2
    fast, middle, slow = directions(robot)
    corner_share, lag_s = INTEGRATOR_CORNER * slow, motor.current_lag_ms / 1e3
    on_floor = min(_greatest_gain(share, corner_share, lag_s, FLOOR_MARGIN_RAD) for share in (fast, middle, slow))
    in_air = _greatest_gain(free, corner_share, lag_s, FREE_MARGIN_RAD)
    count_radps = max(math.tau / (COUNTS * wheel.gear) / DT_S for wheel in robot.wheels)
    by_count = COUNT_SHARE_OF_LIMIT * robot.limits.current_a / count_radps
    kp, bound = min(
        (on_floor / motor.torque_nm_per_a, "60 degrees of phase margin on the floor set kp"),
        (in_air / motor.torque_nm_per_a, "45 degrees of phase margin of a wheel in the air set kp"),
        (by_count, "5 % of the current limit for one encoder count set kp"),
    )
    kp = _rounded(kp)
    gain = kp * motor.torque_nm_per_a
    return Tuning(
        kp_a_per_radps=kp,
        ki_a_per_rad=_rounded(kp * INTEGRATOR_CORNER * slow * gain),
        free_crossover=free * gain,
        slow_crossover=slow * gain,
        fast_crossover=fast * gain,
        bound=bound,
    )


def _greatest_gain(per_inertia: float, corner_share: float, lag_s: float, margin: float) -> float:
    """The greatest torque for each rad/s with which a lag of this 1/inertia keeps the margin."""
    low, high = 0.0, math.pi / 2 / DEAD_TIME_S / per_inertia  # there the dead time alone has used up the phase
    for _ in range(60):
        gain = (low + high) / 2
        enough = phase_margin(gain * per_inertia, gain * corner_share, lag_s) >= margin
        low, high = (gain, high) if enough else (low, gain)
    return low


def comment(t: Tuning) -> str:
    """What stands over the [control] table of a robot file."""
    floor = f"{t.slow_crossover:.0f} to {t.fast_crossover:.0f} rad/s on the floor"
    return (
        f"# By scripts/tune.py, which says how: bandwidth {floor}, {t.free_crossover:.0f} in the air;\n"
        f"# {t.bound}, ki/kp is a quarter of the slowest bandwidth."
    )


def gains(t: Tuning) -> dict[str, str]:
    """The lines of the table that are tuned, by key."""
    return {key: f"{key} = {getattr(t, key):g}" for key in ("kp_a_per_radps", "ki_a_per_rad")}


def written(path: Path) -> str:
    """The file's text with the gains, and the comment over their table, as they should be."""
    t = tune(load_robot(path))
    above, mark, below = path.read_text(encoding="utf-8").partition("\n[control]\n")
    above = re.sub(r"(?:\n#[^\n]*)*\Z", "", above)
    for key, line in gains(t).items():
        below = re.sub(rf"^{key} *=.*$", line, below, count=1, flags=re.MULTILINE)
    return f"{above}\n{comment(t)}{mark}{below}"


def main() -> int:
    """Print or write the gains."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "robots", nargs="*", metavar="ROBOT", help="names or .toml files (all that come with wheelbench)"
    )
    parser.add_argument("--write", action="store_true", help="write them into the files")
    args = parser.parse_args()
    for name in args.robots or robot_names():
        path = robot_path(name)
        if args.write:
            path.write_text(written(path), encoding="utf-8")
        else:
            t = tune(load_robot(path))
            print("\n".join((name, comment(t), "[control]", *gains(t).values(), "")))
    return 0


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


if __name__ == "__main__":
    sys.exit(main())
