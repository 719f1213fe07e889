"""Each robot that drives all the time: its whole tick, recorded, and its plant's step, against a bare pymunk step.

The bare step is the engine's own, of the same body. For orientation: nothing here has a bar.
"""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from statistics import median

import pymunk

from bench.arena import FIELD
from bench.check.recording import BLOCK_TICKS, RunInfo
from bench.check.run import Run
from bench.config import Robot, robot_names
from bench.loop import simulated
from bench.messages import BodyTwist, TickInput
from bench.plant import STEP_S, Plant
from bench.rc.transmitter import Sticks, Transmitter
from benchmarks.empty_call import beside, told_for_reference
from benchmarks.table import Row, Sample
from benchmarks.timing import side_by_side

TICKS, SLICE = 1500, BLOCK_TICKS
ARMING_TICKS = 300


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds for each robot: a whole tick, recorded; a step of its plant; the engine alone with the same body."""
    names = robot_names()
    sample: Sample = {}
    for name in order.sample(names, len(names)):
        seconds, call_ns = beside(partial(_seconds_of, name, order, max(1, round(TICKS * share) // SLICE)))
        sample |= {f"{name} {what}": value for what, value in seconds.items()} | {f"{name} call_ns": call_ns}
    return sample


def report(samples: Sequence[Sample]) -> list[Row]:
    """For orientation."""
    rows = []
    for name in robot_names():
        calls_ns = [s[f"{name} call_ns"] for s in samples]
        for what, title in (("tick", "a whole tick, recorded"), ("plant", "a step of the plant")):
            factors = [0.001 / s[f"{name} {what}"] for s in samples]
            ratio = median(s[f"{name} {what}"] / s[f"{name} pymunk"] for s in samples)
            value = f"{1000 / median(factors):.1f} µs: {median(factors):.0f} x real time, {ratio:.1f} bare pymunk steps"
            told = told_for_reference(factors, calls_ns, "{:.0f} x real time")
            rows.append(Row(f"{name}, {title}", value, told_for_reference=told))
    return rows


def driving(name: str, ticks: int) -> Run:
    """A run in which this robot is driven about all the time, by its own kind of transmitter, or by the core alone."""
    bench = simulated(name)
    profile, limits = bench.robot.rc, bench.robot.limits
    transmitter = Transmitter(profile) if profile else None

    def inputs(tick: int) -> TickInput:
        forward, left = 0.6 * math.cos(tick / 300.0), 0.6 * math.sin(tick / 300.0)
        if transmitter is None:
            asked = BodyTwist(forward * limits.linear_mps, left * limits.linear_mps, 0.4 * limits.angular_radps)
            return TickInput(core_twist=asked)
        sticks = Sticks(forward, left, 0.4) if tick >= ARMING_TICKS else Sticks(aux1=100 <= tick < 200)
        return TickInput(transmitter.step(tick, sticks))

    return Run(name, bench, ticks, inputs, RunInfo(robot=name, profile=profile.name if profile else None))


def _seconds_of(name: str, order: random.Random, slices: int) -> Sample:
    """CPU seconds of a tick, a step of the plant, a step of the engine."""
    job = driving(name, ARMING_TICKS + slices * SLICE)
    robot = job.bench.robot
    plant, space = Plant(robot), _bare_space(robot)
    currents_a = [robot.limits.current_a / 2.0] * len(robot.wheels)
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder, job.recorder(Path(folder) / "run") as recorder:
        blocks = job.blocks()
        for block in islice(blocks, ARMING_TICKS // SLICE):
            recorder.extend(block)

        def tick() -> None:
            recorder.extend(next(blocks))

        def step() -> None:
            for _ in range(SLICE):
                plant.step(currents_a)

        def bare() -> None:
            for _ in range(SLICE):
                space.step(STEP_S)

        seconds = side_by_side(order, slices, {"tick": tick, "plant": step, "pymunk": bare})
    return {what: value / (slices * SLICE) for what, value in seconds.items()}


def _bare_space(robot: Robot) -> pymunk.Space:
    body = robot.body
    space = pymunk.Space()
    disc = pymunk.Body(body.mass_kg, body.inertia_kgm2)
    disc.angular_velocity = 5.0
    space.add(disc, pymunk.Circle(disc, body.radius_m))
    x, y = FIELD.length_m / 2.0, FIELD.width_m / 2.0
    corners = ((-x, -y), (x, -y), (x, y), (-x, y))
    for start, end in zip(corners, (*corners[1:], corners[0]), strict=True):
        space.add(pymunk.Segment(space.static_body, start, end, 0.05))
    return space
