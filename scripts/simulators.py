"""How fast a robot moves here beside other simulators that Python can step: the same robot, in the same run.

    python scripts/simulators.py [--seconds S] [--rounds N] [--json]

Builds a throw-away virtual environment with the others and lets each move the three-wheel robot m2006 for S seconds of
its life, in turns, round by round. What counts is CPU time. They do not simulate the same things:

    bench      RC bytes, our base, CAN frames, ESCs, the plant with stick and slip, all of it recorded; 1 ms a step
    plant      the plant of it alone, from motor currents to wheel angles; 1 ms a step
    mujoco     three dimensions, a body for each of 48 rollers (beside/mujoco_robot.py), from wheel torques; 0.2 ms a
               step, which its rollers need; in C, stepped from Python with nothing but the torques set
    ir-sim     a disc that has the velocity it is told, and a test for collisions: no wheel, no mass; 1 ms a step

Exit status: 0, or 3 if the others cannot be installed here.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import Any

import peers
from arguments import above_zero, at_least_one, end_with, parser

PACKAGES = ("mujoco==4.0.0", "ir-sim==2.12.0", "pymunk>=7.0")
DRIVEN_FROM_TICK = 1500
"""The demo arms at 1.0 s and drives from 1.5 s."""
LONGEST_S = 25.0

IR_SIM_WORLD = """
world: {height: 6, width: 6, step_time: 0.001, sample_time: 1.0, collision_mode: 'stop'}
robot:
  - {kinematics: {name: 'omni'}, shape: {name: 'circle', radius: 0.08}, state: [3, 3, 0], goal: [5, 5, 0]}
"""

Contestant = Callable[[], float]
"""Goes on for a little and says how many seconds of the robot's life that were."""


def bench_contestant(held: ExitStack) -> Contestant:
    """The whole loop, recorded, where the demo drives by sticks."""
    from bench.check.sources import from_scenario
    from bench.demo import SCENARIO

    job = from_scenario(SCENARIO)
    recorder = held.enter_context(job.recorder(_folder(held) / "run"))
    blocks = job.blocks()
    for _ in range(DRIVEN_FROM_TICK // 100):
        recorder.extend(next(blocks))

    def go_on() -> float:
        block = next(blocks)
        recorder.extend(block)
        return len(block) / 1000.0

    return go_on


def plant_contestant(_: ExitStack) -> Contestant:
    """The plant alone, turning and drifting."""
    from bench.config import load_robot
    from bench.plant import STEP_S, Plant

    plant = Plant(load_robot("m2006"))

    def go_on() -> float:
        for _ in range(100):
            plant.step((0.3, 0.2, 0.25))
        return 100 * STEP_S

    return go_on


def mujoco_contestant(_: ExitStack) -> Contestant:
    """Explicit rollers, with the torques that those currents are."""
    from beside.mujoco_robot import STEP_S, RollerRobot

    from bench.config import load_robot

    robot = load_robot("m2006")
    rollers = RollerRobot(robot)
    torques_nm = [robot.motor.torque_nm_per_a * current_a for current_a in (0.3, 0.2, 0.25)]

    def go_on() -> float:
        for _ in range(20):
            rollers.step(torques_nm)
        return 20 * STEP_S

    return go_on


def ir_sim_contestant(held: ExitStack) -> Contestant:
    """An omnidirectional disc, without a display."""
    import irsim
    import numpy

    file = _folder(held) / "world.yaml"
    file.write_text(IR_SIM_WORLD)
    world = irsim.make(str(file), display=False, disable_all_plot=True, log_level="ERROR")
    velocity = numpy.array([[0.1], [0.05]])

    def go_on() -> float:
        for _ in range(10):
            world.step(velocity)
        return 0.01

    return go_on


def _folder(held: ExitStack) -> Path:
    return Path(held.enter_context(tempfile.TemporaryDirectory(prefix="wheelbench-")))


CONTESTANTS: dict[str, Callable[[ExitStack], Contestant]] = {
    "bench": bench_contestant,
    "plant": plant_contestant,
    "mujoco": mujoco_contestant,
    "ir-sim": ir_sim_contestant,
}


def measure(seconds: float, rounds: int, names: Sequence[str] = tuple(CONTESTANTS)) -> dict[str, list[float]]:
    """Seconds of the robot's life for each CPU second, round by round."""
    with ExitStack() as held:
        return _measure({name: CONTESTANTS[name](held) for name in names}, seconds, rounds)


def _measure(made: dict[str, Contestant], seconds: float, rounds: int) -> dict[str, list[float]]:
    names = list(made)
    factors: dict[str, list[float]] = {name: [] for name in names}
    for number in range(rounds):
        order = random.Random(number)
        lived, spent = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
        # Small turns, so that whatever else the machine does falls on all of them.
        while min(lived.values()) < seconds:
            for name in order.sample(names, len(names)):
                if lived[name] < seconds:
                    start = time.process_time()
                    lived[name] += made[name]()
                    spent[name] += time.process_time() - start
        for name in names:
            factors[name].append(lived[name] / spent[name])
    return factors


def measured(python: Path, seconds: float, rounds: int) -> dict[str, list[float]]:
    """The same, from a process of the environment that has the others."""
    command = [str(python), __file__, "--inside", "--seconds", str(seconds), "--rounds", str(rounds)]
    settings = {**os.environ, "PYTHONPATH": str(peers.ROOT), "MPLBACKEND": "Agg"}
    done = subprocess.run(
        command, env=settings, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True
    )
    factors: dict[str, list[float]] = json.loads(done.stdout.splitlines()[-1])
    return factors


def ratios(factors: dict[str, list[float]]) -> dict[str, float]:
    """How many times as fast as each of the others the bench is: medians of the rounds."""
    return {
        name: median(ours / theirs for ours, theirs in zip(factors["bench"], times, strict=True))
        for name, times in factors.items()
        if name != "bench"
    }


def main() -> int:
    """Build the environment, measure in it, and print what came out."""
    asked = parser(__doc__)
    asked.add_argument(
        "--seconds", type=above_zero, default=0.5, metavar="S", help="of the robot's life, a round (default 0.5)"
    )
    asked.add_argument("--rounds", type=at_least_one, default=5, metavar="N", help="default 5")
    asked.add_argument("--json", action="store_true", help="both figures as JSON")
    asked.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args: Any = asked.parse_args()
    if args.seconds * args.rounds > LONGEST_S:
        asked.error(f"the demo is over after {LONGEST_S:g} s; give fewer rounds, or shorter ones")
    if args.inside:
        print(json.dumps(measure(args.seconds, args.rounds)))
        return 0
    with tempfile.TemporaryDirectory(prefix="wheelbench-simulators-") as folder:
        python = peers.environment(folder, PACKAGES)
        if python is None:
            return 3
        factors = measured(python, args.seconds, args.rounds)
    if args.json:
        print(json.dumps({"simulated_s_per_cpu_s": factors, "bench_times_as_fast_as": ratios(factors)}, indent=1))
    else:
        for name, times in factors.items():
            print(f"{name:8} {median(times):8.2f} s of the robot's life for each CPU second")
        print(", ".join(f"{ratio:.2f} times as fast as {name}" for name, ratio in ratios(factors).items()))
    return 0


if __name__ == "__main__":
    end_with(main)
