"""Speed-loop gains of a robot file, by a stated method: what stands in each file's [control] table.

    python scripts/tune.py [ROBOT ...]      print the gains of these robots, or of all
    python scripts/tune.py --write          write them into the robot files
    python scripts/tune.py --check          drive them: the table of docs/plant.md

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

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from arguments import end_with, parser

from bench.base import Base
from bench.canbus.c610 import COUNTS
from bench.config import Robot, load_profile, load_robot, robot_names, robot_path
from bench.controller import DT_S
from bench.kinematics import Kinematics, singular_values
from bench.loop import simulated
from bench.messages import TickInput
from bench.plant import Plant
from bench.rc.transmitter import AT_REST, Sticks, Transmitter
from bench.world import SimulatedMotors

FLOOR_MARGIN_RAD = math.radians(60.0)
FREE_MARGIN_RAD = math.radians(45.0)
COUNT_SHARE_OF_LIMIT = 0.05
INTEGRATOR_CORNER = 1.0 / 4.0
DEAD_TIME_S = 2.0 * DT_S
SHARE = 0.3
"""Of the full stick: every robot reaches it within its current's limit."""
ARMING_TICKS, PUSHED_TICKS, RELEASED_TICKS = 100, 1400, 800
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


class Sample(NamedTuple):
    """One tick of a drive along one axis: m/s, or rad/s where it turns."""

    wanted: float
    is_: float
    currents_a: tuple[float, ...]


class Judged(NamedTuple):
    """What a drive shows of a speed loop. Speeds as those of the axis, times in ms."""

    speed: float
    lag: float
    """Largest difference between the ramp and the robot."""
    overshoot: float
    """Above the speed, as a share of it."""
    settled_ms: int
    """From the end of the ramp until the robot stays within 2 % of the speed."""
    standing_ms: int
    """From letting go until the robot stays below 2 % of the speed."""


def response(robot: Robot, axis: int) -> list[Sample]:
    """On an open floor: a stick is pushed to SHARE for PUSHED_TICKS and let go. The axis is 0 forward, 1 left, 2 turn.

    A robot without RC is given a transmitter, for this: its speed loops do not know who drives.
    """
    profile = replace(robot.rc or load_profile("uart12"), arming="on_link", dead_band=0.0, expo=0.0)
    robot = replace(robot, rc=profile)
    bench = simulated(robot)
    bench.world.motors = SimulatedMotors(robot, Plant(robot, arena=None))
    base, plant, transmitter = bench.base, bench.world.plant, Transmitter(profile)
    assert isinstance(base, Base)
    pushed = Sticks(*(SHARE if i == axis else 0.0 for i in range(3)))
    samples = []
    for tick in range(-ARMING_TICKS, PUSHED_TICKS + RELEASED_TICKS):
        sticks = pushed if 0 <= tick < PUSHED_TICKS else AT_REST
        bench.tick(TickInput(transmitter.step(bench.now_tick, sticks)))
        if tick >= 0:
            wanted = base.kinematics.twist(base.wanted_radps)
            samples.append(Sample(wanted[axis], plant.twist[axis], tuple(plant.currents_a)))
    return samples


def judged(samples: Sequence[Sample]) -> Judged:
    """The figures of a response."""
    pushed = samples[:PUSHED_TICKS]
    speed = pushed[-1].wanted
    band = 0.02 * speed
    ramped = next(tick for tick, sample in enumerate(pushed) if sample.wanted == speed)
    outside = [tick for tick, sample in enumerate(pushed) if abs(sample.is_ - speed) > band]
    let_go = next(tick for tick, sample in enumerate(samples) if tick >= PUSHED_TICKS and sample.wanted == 0.0)
    moving = [tick for tick, sample in enumerate(samples) if abs(sample.is_) > band]
    return Judged(
        speed=speed,
        lag=max(abs(sample.wanted - sample.is_) for sample in pushed),
        overshoot=max(sample.is_ for sample in pushed) / speed - 1.0,
        settled_ms=max(0, outside[-1] + 1 - ramped),
        standing_ms=moving[-1] + 1 - let_go,
    )


def check_row(name: str) -> str:
    """One robot's row of the table in docs/plant.md."""
    robot = load_robot(name)
    each = [judged(response(robot, axis)) for axis in range(3)]
    cells = [
        ", ".join(f"{one.speed:.2f}" for one in each),
        ", ".join(f"{1000 * one.lag:.0f}" for one in each),
        ", ".join(f"{100 * one.overshoot:.0f}" for one in each),
        ", ".join(f"{one.settled_ms}" for one in each),
        ", ".join(f"{one.standing_ms}" for one in each),
    ]
    return f"| {name} | {' | '.join(cells)} |"


def main() -> int:
    """Print or write the gains."""
    asked = parser(__doc__)
    asked.add_argument(
        "robots", nargs="*", metavar="ROBOT", help="names or .toml files (all that come with wheelbench)"
    )
    asked.add_argument("--write", action="store_true", help="write them into the files")
    asked.add_argument("--check", action="store_true", help="drive them, and print what their gains do")
    args = asked.parse_args()
    for name in args.robots or robot_names():
        path = robot_path(name)
        if args.check:
            print(check_row(name))
        elif args.write:
            path.write_text(written(path), encoding="utf-8")
        else:
            t = tune(load_robot(path))
            print("\n".join((name, comment(t), "[control]", *gains(t).values(), "")))
    return 0


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


if __name__ == "__main__":
    end_with(main)
