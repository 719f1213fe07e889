"""The plant against an independent engine: `make validate`. MuJoCo, in three dimensions, with every roller a body.

    scripts/validate.py                    every check; exit status 1 where one is out of its allowance
    scripts/validate.py --only m2006       one robot
    scripts/validate.py --json             one object a line

The same torques act on both, open loop or through the same simple speed servo, and the motion is compared: the plant's
wheel equation, reflected inertia, loads and grip against rollers that know none of these. Motor friction, rolling loss
and the supply's limit are switched off in both: what is compared is the ground. Needs mujoco (`make validate` installs
it beside the bench); without it the exit status is 3.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Protocol

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from arguments import end_with, parser, some_of

from bench.config import Robot, load_robot
from bench.kinematics import Kinematics
from bench.messages import BodyTwist, Pose
from bench.plant import STEP_S as PLANT_STEP_S
from bench.plant import Plant

ROBOTS = ("m2006", "dm3519", "omni3", "omni4", "mecanum")
ALLOWED = {"twist": 0.02, "travel": 0.04}
"""Of the largest value of a comparison. Rollers ripple by a quarter of a percent, and where a mecanum base turns, two
rollers of a wheel touch the floor in places that move differently, and rub. Travel adds up what a whole drive does."""


class Engine(Protocol):
    """A robot that torques move, in either engine."""

    def step(self, torques_nm: Sequence[float]) -> None:
        """One step of this engine's own length."""
        ...

    @property
    def wheel_speeds_radps(self) -> list[float]:
        """In wheel order."""
        ...

    @property
    def pose(self) -> Pose:
        """From above."""
        ...

    @property
    def twist(self) -> BodyTwist:
        """In the body frame."""
        ...


Torques = Callable[[float, Sequence[float]], Sequence[float]]
"""Time in s and wheel speeds in rad/s -> wheel torques in N m."""


class Check(NamedTuple):
    """One comparison: what both engines are asked to do, and which numbers of it count."""

    name: str
    robot: Robot
    torques: Torques
    seconds: float
    measure: str
    """`twist`: the mean over the last third; `travel`: the pose at the end, in a field that it starts at 0 of."""


class Verdict(NamedTuple):
    """What came out of both."""

    robot: str
    check: str
    measure: str
    rollers: tuple[float, ...]
    plant: tuple[float, ...]
    error: float
    """The largest difference, as a share of the largest value; a turn counts at the wheels' distance."""
    allowed: float
    slower: float
    """CPU time of the rollers over the plant's, for the same simulated time."""


def lossless(robot: Robot, grip: float | None = None, height_m: float | None = None) -> Robot:
    """The robot with a motor that gives 1 N m for 1 A at any speed and no loss anywhere but in the tyres' grip."""
    motor = replace(
        robot.motor,
        torque_nm_per_a=1.0,
        coulomb_nm=0.0,
        viscous_nms=0.0,
        load_friction=0.0,
        current_lag_ms=0.0,
        max_current_a=1e3,
        supply_v=1e9,
    )
    body = robot.body if height_m is None else replace(robot.body, cog_height_m=height_m)
    ground = replace(robot.ground, rolling=0.0, grip=grip or robot.ground.grip)
    return replace(robot, motor=motor, body=body, ground=ground)


def checks(robot: Robot) -> Iterator[Check]:
    """Speeds through a servo, accelerations from rest, a long winding drive, and wheels that spin."""
    stuck = lossless(robot)
    kinematics = Kinematics(robot.wheels)
    quick, turn = 0.5, 0.12 / kinematics.length_m
    for twist in ((quick, 0.0, 0.0), (0.0, quick, 0.0), (0.0, 0.0, turn), (0.6 * quick, -0.8 * quick, 0.75 * turn)):
        yield Check(f"held at {_words(twist)}", stuck, servo(stuck, twist), 0.9, "twist")

    # A third of the robot's weight, shared out: below the grip, and well above what rollers lose as they take turns.
    size = 0.3 * robot.body.mass_kg * 9.81 * robot.wheels[0].radius_m / len(robot.wheels)
    for name, pattern in patterns(kinematics, size).items():
        yield Check(f"pushed {name}", stuck, lambda _t, _w, p=pattern: p, 0.5, "twist")
    yield Check("winding drive, 1.2 s", stuck, winding(len(robot.wheels), size), 1.2, "travel")

    for grip in (0.15, 0.30):
        # With the centre of gravity at the height of the axles.
        sliding = lossless(robot, grip, robot.wheels[0].radius_m)
        spin = 2.0 * slipping_nm(sliding)
        directions = patterns(kinematics, spin)
        for name in ("forward", "round"):
            pattern = tuple(math.copysign(spin, value) if value else 0.0 for value in directions[name])
            yield Check(f"spinning {name}, grip {grip:g}", sliding, lambda _t, _w, p=pattern: p, 0.3, "twist")


def slipping_nm(robot: Robot) -> float:
    """A wheel torque that no wheel holds: what the floor takes of an even share of the weight, and the wheel's inertia
    at the acceleration that the grip allows.
    """
    grip_mps2, radius_m = robot.ground.grip * 9.81, robot.wheels[0].radius_m
    return grip_mps2 * (robot.body.mass_kg * radius_m / len(robot.wheels) + robot.motor.inertia_kgm2 / radius_m)


def patterns(kinematics: Kinematics, size_nm: float) -> dict[str, tuple[float, ...]]:
    """Wheel torques of at most this size that push forward, sideways and round, and in all three ways at once."""
    rows = kinematics.inverse_rows
    found = {name: tuple(row[axis] for row in rows) for axis, name in enumerate(("forward", "to the left", "round"))}
    # Not any pattern: where wheels of a redundant base work against each other, a real tyre creeps and ours does not.
    found["every way"] = tuple(0.6 * x - 0.8 * y + 0.75 * w / kinematics.length_m for x, y, w in rows)
    return {
        name: tuple(size_nm * value / max(map(abs, pattern)) if abs(value) > 1e-9 else 0.0 for value in pattern)
        for name, pattern in found.items()
    }


def servo(robot: Robot, twist: Sequence[float]) -> Torques:
    """Wheels held at the speeds of this twist, with a time constant of 4 ms."""
    wanted = Kinematics(robot.wheels).wheel_speeds(twist)
    gain = robot.motor.inertia_kgm2 / 0.004

    def torques(_time_s: float, speeds: Sequence[float]) -> list[float]:
        return [gain * (want - speed) for want, speed in zip(wanted, speeds, strict=True)]

    return torques


def winding(wheels: int, size_nm: float) -> Torques:
    """Torques that rise and fall, every wheel at its own pace."""

    def torques(time_s: float, _speeds: Sequence[float]) -> list[float]:
        return [size_nm * math.sin((2.0 + 0.7 * wheel) * time_s + wheel) for wheel in range(wheels)]

    return torques


def run(engine: Engine, step_s: float, check: Check) -> tuple[tuple[float, ...], float]:
    """The measured values, and the CPU seconds they took."""
    begun, before = time.process_time(), engine.pose
    total, counted = [0.0, 0.0, 0.0], 0
    steps = round(check.seconds / step_s)
    for number in range(steps):
        engine.step(check.torques(number * step_s, engine.wheel_speeds_radps))
        if check.measure == "twist" and number >= steps * 2 // 3:
            counted += 1
            for axis, value in enumerate(engine.twist):
                total[axis] += value
    took = time.process_time() - begun
    if check.measure == "twist":
        return tuple(value / counted for value in total), took
    pose = engine.pose
    return (pose.x_m - before.x_m, pose.y_m - before.y_m, pose.heading_rad - before.heading_rad), took


def judge(check: Check) -> Verdict:
    """Both engines, and how far they are apart."""
    from beside.mujoco_robot import STEP_S, RollerRobot

    rollers = RollerRobot(check.robot)
    rollers.settle()
    measured, rollers_s = run(rollers, STEP_S, check)
    computed, plant_s = run(PlantEngine(check.robot), PLANT_STEP_S, check)
    length_m = Kinematics(check.robot.wheels).length_m
    scale = (1.0, 1.0, length_m)
    largest = max(abs(value) * unit for value, unit in zip(measured, scale, strict=True))
    apart = max(abs(a - b) * unit for a, b, unit in zip(measured, computed, scale, strict=True))
    slower = rollers_s / plant_s
    return Verdict(
        check.robot.name, check.name, check.measure, measured, computed, apart / largest, ALLOWED[check.measure], slower
    )


class PlantEngine(Plant):
    """The bench's plant on open floor; the frictionless motor's amperes are newton metres."""

    __slots__ = ()

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot, arena=None)


def _words(twist: Sequence[float]) -> str:
    return ", ".join(f"{value:.3g}" for value in twist)


def main() -> int:
    """The command line; 0 where every check is within its allowance."""
    asked = parser(__doc__)
    asked.add_argument(
        "--only", type=some_of(ROBOTS), default=list(ROBOTS), metavar="A,B", help=f"some of {', '.join(ROBOTS)}"
    )
    asked.add_argument("--json", action="store_true", help="one object a line")
    given = asked.parse_args()
    try:
        import mujoco
    except ImportError:
        print("scripts/validate.py needs mujoco; `make validate` installs it into .venv-validate", file=sys.stderr)
        return 3
    if not given.json:
        print(f"MuJoCo {mujoco.__version__}; vx m/s, vy m/s, omega rad/s (travel: m, m, rad)")
        print(f"{'robot':<9}{'check':<30}{'rollers':>27}{'plant':>27}{'apart':>8}{'allowed':>9}")
    verdicts = []
    for name in given.only:
        for check in checks(load_robot(name)):
            verdict = judge(check)
            verdicts.append(verdict)
            if given.json:
                print(json.dumps(verdict._asdict()), flush=True)
                continue
            values = ["".join(f"{value:9.4f}" for value in side) for side in (verdict.rollers, verdict.plant)]
            mark = "" if verdict.error <= verdict.allowed else "  OUT"
            print(
                f"{verdict.robot:<9}{verdict.check:<30}{values[0]}{values[1]}"
                f"{verdict.error:8.2%}{verdict.allowed:9.1%}{mark}",
                flush=True,
            )
    out = [verdict for verdict in verdicts if not verdict.error <= verdict.allowed]
    if not given.json:
        slower = sorted(verdict.slower for verdict in verdicts)[len(verdicts) // 2]
        print(
            f"{len(verdicts) - len(out)} of {len(verdicts)} within their allowance; "
            f"the rollers take {slower:.0f} times the plant's CPU time"
        )
    return 1 if out else 0


if __name__ == "__main__":
    end_with(main)
