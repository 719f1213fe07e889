"""Laws that hold for any drive: energy, order of the integrator, symmetry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random

from bench import plant as engine
from bench.config import Wheel
from bench.kinematics import Kinematics
from bench.messages import Pose
from bench.plant import STEP_S, Plant
from plant_rows.algebra import dot, turned
from plant_rows.check import FLAT, FORWARDS, SIN75, Check, robot_with, run, times
from plant_rows.speeds import forward_speed


def energy(wheels: Sequence[Wheel] = (), steps: int = 2000, seed: int = 11) -> tuple[float, float]:
    """With every friction active: the worst imbalance of a step, J, and the largest loss that was a gain."""
    robot = robot_with(wheels, ground_grip=0.3)
    plant = Plant(robot, None)
    axes = Kinematics(robot.wheels)
    motor, body = robot.motor, robot.body
    random = Random(seed)
    currents = [0.0] * len(robot.wheels)
    worst, gain = 0.0, 0.0
    for step in range(steps):
        if step % 100 == 0:
            currents = [random.uniform(-2.5, 2.5) for _ in robot.wheels]
        pose, before, old_speeds = plant.pose, plant.twist, plant.wheel_speeds_radps
        turn = 1.5 * STEP_S * before.omega_radps
        start = turned(before, -turn)
        run(plant, currents, 1)
        end = turned(plant.twist, plant.pose.heading_rad - pose.heading_rad - turn)
        mean = [(a + b) / 2.0 for a, b in zip(start, end, strict=True)]
        change = 0.5 * body.mass_kg * (end[0] ** 2 + end[1] ** 2 - start[0] ** 2 - start[1] ** 2)
        change += 0.5 * body.inertia_kgm2 * (end[2] ** 2 - start[2] ** 2)
        work = losses = 0.0
        for wheel, axis, rc, old, new, amps, (along, across) in zip(
            robot.wheels, axes.axes, axes.radii, old_speeds, plant.wheel_speeds_radps, currents, plant.contact_forces_n,
            strict=True,
        ):  # fmt: skip
            ax, ay, _ = axis
            side = (-ay, ax, wheel.x_m * ax + wheel.y_m * ay)
            spin = (old + new) / 2.0
            change += 0.5 * motor.inertia_kgm2 * (new**2 - old**2)
            work += STEP_S * motor.torque_nm_per_a * amps * spin
            viscous = motor.viscous_nms * new
            dry = motor.torque_nm_per_a * amps - rc * along - viscous - motor.inertia_kgm2 * (new - old) / STEP_S
            tyre, roll = dot(axis, mean) - rc * spin, dot(side, mean)
            losses -= STEP_S * ((dry + viscous) * spin - along * tyre - across * roll)
            # The law is the end of the step's: against its speed, and within its limit.
            gain = max(gain, -dry * new, -viscous * new, along * (dot(axis, end) - rc * new), across * dot(side, end))
            gain = max(gain, abs(dry) - motor.coulomb_nm)
        worst = max(worst, abs(work + losses - change))
    return worst, gain


def halving() -> float:
    """Error of the position after half a second of a straight start, at 1 ms over that at 0.5 ms."""
    rate = math.exp(-0.5 / (4.67198 / (2.0 * 0.0045 * (SIN75 / 0.027) ** 2)))
    tau = 4.67198 / (2.0 * 0.0045 * (SIN75 / 0.027) ** 2)
    exact = forward_speed(0.6) * (0.5 - tau * (1.0 - rate))
    errors = []
    for parts in (1, 2):
        engine.STEP_S = STEP_S / parts
        try:
            errors.append(run(Plant(robot_with(**FLAT), None), times(FORWARDS, 0.6), 500 * parts).pose.x_m - exact)
        finally:
            engine.STEP_S = STEP_S
    return errors[0] / errors[1]


def mirrored() -> float:
    """Currents reflected, path reflected: how far from it."""
    left, right = Plant(robot_with(), None), Plant(robot_with(), None)
    for step in range(1500):
        i1, i2, i3 = (2.5, 0.2, -0.4) if step < 700 else (-0.8, 0.5, 0.3)
        left.step((i1, i2, i3))
        right.step((-i3, -i2, -i1))
    (x, y, heading), other = left.pose, right.pose
    return max(abs(other.x_m - x), abs(other.y_m + y), abs(other.heading_rad + heading))


def start_turned() -> float:
    """A turned and moved start turns and moves the path: how far from it."""
    turn = 2.1
    here, there = Plant(robot_with(), None), Plant(robot_with(), None, Pose(0.4, -0.7, turn))
    for step in range(1500):
        for plant in (here, there):
            plant.step((1.5, 0.2, -0.4) if step < 700 else (-0.8, 0.5, 0.3))
    x, y, _ = here.pose
    c, s = math.cos(turn), math.sin(turn)
    return math.hypot(there.pose.x_m - 0.4 - c * x + s * y, there.pose.y_m + 0.7 - s * x - c * y)


def rows() -> list[Check]:
    """In the order of the page."""
    return [
        Check("energy balance, worst of 2000 steps, J", "4.1", 0.0, 1e-12, lambda: energy()[0]),
        Check("a loss that is a gain, worst, N m/s, N m", "4.1", 0.0, 1e-9, lambda: energy()[1]),
        Check("error at 1 ms over error at 0.5 ms", "4.3", 2.0, 0.05, halving),
        Check("mirrored currents, off the mirrored path, m, rad", "4.3", 0.0, 1e-9, mirrored),
        Check("turned start, off the turned path, m", "4.3", 0.0, 1e-9, start_turned),
    ]
