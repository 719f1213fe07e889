"""The plant beside closed forms: `python scripts/plant_checks.py` prints what it does, should do and may be off by.

Each row runs the plant open loop and holds one number against the reference plant model (section beside it) or against
a formula of its section 2, evaluated here. No number on the right-hand side comes from the plant. docs/plant.md shows
the table; tests/test_plant_closed_forms.py runs every row.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1]))

from bench import plant as engine
from bench.arena import Arena
from bench.config import Robot, Wheel, load_robot
from bench.ground.loads import load_rows
from bench.kinematics import Kinematics
from bench.messages import BodyTwist, Pose
from bench.plant import STEP_S, Plant

Vector = tuple[float, float, float]
DIRECTIONS_DEG = (0.0, 30.0, 45.0, 60.0, 90.0)
FORWARDS, SPIN = (1.0, 0.0, -1.0), (1.0, 1.0, 1.0)
SIN75, COS75 = math.sin(math.radians(75.0)), math.cos(math.radians(75.0))
G = 9.81
NO_LOSSES = {"motor_coulomb_nm": 0.0, "motor_viscous_nms": 0.0, "ground_rolling": 0.0}
FLAT = {"body_cog_height_m": 0.0}
SLICK = {"ground_grip": 0.15, "ground_rolling": 0.0, **FLAT}
ROUNDING = 5e-13
ROOM = Arena(1.0, 0.8)


@dataclass(frozen=True, slots=True)
class Check:
    """One row: what `measure` gives, off by no more than `allowed` from what is expected."""

    name: str
    section: str
    expected: float
    allowed: float
    measure: Callable[[], float]


# --- robots -----------------------------------------------------------------------------------------------------------


def robot_with(wheels: Sequence[Wheel] = (), /, **changes: float) -> Robot:
    """The default robot without current lag, on these wheels; changes are named `table_key`."""
    robot = load_robot("m2006")
    for name, value in {"motor_current_lag_ms": 0.0, **changes}.items():
        table, key = name.split("_", 1)
        robot = replace(robot, **{table: replace(getattr(robot, table), **{key: value})})
    return replace(robot, wheels=tuple(wheels)) if wheels else robot


def tangential(*bearings_deg: float) -> list[Wheel]:
    """Omni wheels on the default robot's circle."""
    wheels = []
    for deg in bearings_deg:
        bearing = math.radians(deg)
        x_m, y_m = 0.061 * math.cos(bearing), 0.061 * math.sin(bearing)
        wheels.append(Wheel(f"at {deg}", x_m, y_m, bearing + math.pi / 2.0, 0.027, can_id=1))
    return wheels


def mecanum() -> list[Wheel]:
    """Rollers at 45 degrees."""
    corners = ((0.10, 0.12, -45.0), (0.10, -0.12, 45.0), (-0.10, 0.12, 45.0), (-0.10, -0.12, -45.0))
    return [Wheel("mecanum", x, y, 0.0, 0.03, can_id=1, roller_rad=math.radians(deg)) for x, y, deg in corners]


LAYOUTS: dict[str, list[Wheel]] = {
    "004": [],
    "omni 60/180/300": tangential(60.0, 180.0, 300.0),
    "omni 60/135/225/300": tangential(60.0, 135.0, 225.0, 300.0),
    "mecanum 45": mecanum(),
}


# --- section 2, formulas ----------------------------------------------------------------------------------------------


def forward_speed(current_a: float) -> float:
    """w = (Kt i - tau_c - r F)/b, v = w r/sin 75, F = c_rr (2 N1 cos 75 + N2)/(2 sin 75)."""
    n1, n2 = rest_loads()
    drag = 0.05 * (2.0 * n1 * COS75 + n2) / (2.0 * SIN75)
    return (0.18 * current_a - 0.020 - 0.027 * drag) / 0.0045 * 0.027 / SIN75


def rest_loads() -> tuple[float, float]:
    """Of a front wheel and the rear one: moments about the rear contact, and all of the weight."""
    n1 = 1.6 * G / (2.0 * (1.0 + COS75))
    return n1, 1.6 * G - 2.0 * n1


def acceleration_under(robot: Robot, torques_nm: Sequence[float]) -> Vector:
    """M a = H' tau with M = diag(m, m, Jz) + J H' H, by Cramer's rule."""
    rows = Kinematics(robot.wheels).inverse_rows
    body = robot.body
    matrix = [[0.0] * 3 for _ in range(3)]
    for i, mass in enumerate((body.mass_kg, body.mass_kg, body.inertia_kgm2)):
        matrix[i][i] = mass
        for k in range(3):
            matrix[i][k] += robot.motor.inertia_kgm2 * math.fsum(row[i] * row[k] for row in rows)
    push = [math.fsum(row[i] * torque for row, torque in zip(rows, torques_nm, strict=True)) for i in range(3)]
    return solved(matrix, push)


def grip_limit(robot: Robot, direction_deg: float) -> tuple[float, Vector]:
    """The largest acceleration along a direction without yaw, and the multipliers that prove it.

    Linear programme: largest F with sum f_i w_i = F (u, 0), |f_i| <= mu N_i, w_i = (axis, moment). Its dual has a
    vertex y for every pair of wheels (y w_i = y w_j = 0, y (u, 0) = 1); the least sum of mu N_i |y w_i| over them is F.
    """
    ux, uy = math.cos(math.radians(direction_deg)), math.sin(math.radians(direction_deg))
    rows = Kinematics(robot.wheels).axes
    loads = [rest for rest, _, _ in load_rows(robot.wheels, robot.body.mass_kg, 0.0)]
    best = math.inf
    proof = (0.0, 0.0, 0.0)
    for one, other in combinations(rows, 2):
        matrix = [[ux, uy, 0.0], list(one), list(other)]
        if abs(determinant(matrix)) < 1e-12:
            continue
        y = solved(matrix, [1.0, 0.0, 0.0])
        force = math.fsum(robot.ground.grip * n * abs(dot(y, row)) for n, row in zip(loads, rows, strict=True))
        if force < best:
            best, proof = force, y
    return best / robot.body.mass_kg, proof


# --- runs -------------------------------------------------------------------------------------------------------------


def run(plant: Plant, currents_a: Sequence[float], steps: int) -> Plant:
    """Steps with these currents."""
    for _ in range(steps):
        plant.step(currents_a)
    return plant


def times(signs: Sequence[float], current_a: float) -> list[float]:
    """A pattern of currents."""
    return [sign * current_a for sign in signs]


def driven(robot: Robot, currents_a: Sequence[float], steps: int) -> BodyTwist:
    """The twist after so many steps on an open floor."""
    return run(Plant(robot, None), currents_a, steps).twist


def steady(current_a: float) -> float:
    """The speed that a current settles at, forward."""
    return driven(robot_with(), times(FORWARDS, current_a), 6000).vx_mps


def first_step(robot: Robot, currents_a: Sequence[float]) -> Vector:
    """The acceleration of the first step from rest."""
    vx, vy, omega = driven(robot, currents_a, 1)
    return vx / STEP_S, vy / STEP_S, omega / STEP_S


def worst_inertia(wheels: Sequence[Wheel]) -> float:
    """Every wheel alone and four mixtures: the largest difference from M^-1 H' tau, as a share of the largest part."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    count = len(robot.wheels)
    random = Random(3)
    patterns = [[0.02 if i == k else 0.0 for i in range(count)] for k in range(count)]
    patterns += [[random.uniform(-0.02, 0.02) for _ in range(count)] for _ in range(4)]
    worst = 0.0
    for torques in patterns:
        wanted = acceleration_under(robot, torques)
        got = first_step(robot, [torque / 0.18 for torque in torques])
        largest = max(map(abs, wanted))
        worst = max(worst, *(abs(a - b) / largest for a, b in zip(got, wanted, strict=True)))
    return worst


def effective(axis: int) -> float:
    """Force over acceleration along one axis, with torques that move the default robot along it alone."""
    robot = robot_with(**NO_LOSSES, **FLAT)
    rows = Kinematics(robot.wheels).inverse_rows
    # tau = (H^+)' (M e_axis): the torques whose generalised force is M times a unit acceleration along the axis.
    unit = 0.3 if axis < 2 else 3.0
    matrix = [[math.fsum(row[i] * row[k] for row in rows) for k in range(3)] for i in range(3)]
    mass = acceleration_inverse(robot, axis)
    weights = solved(matrix, [unit * part for part in mass])
    torques = [dot(row, weights) for row in rows]
    got = first_step(robot, [torque / 0.18 for torque in torques])
    return unit * mass[axis] / got[axis]


def acceleration_inverse(robot: Robot, axis: int) -> Vector:
    """A column of M."""
    rows = Kinematics(robot.wheels).inverse_rows
    body = (robot.body.mass_kg, robot.body.mass_kg, robot.body.inertia_kgm2)
    column = [robot.motor.inertia_kgm2 * math.fsum(row[i] * row[axis] for row in rows) for i in range(3)]
    column[axis] += body[axis]
    return column[0], column[1], column[2]


def time_constant() -> float:
    """From the approach to the steady speed between 0.5 and 1.5 s."""
    plant = run(Plant(robot_with(**FLAT), None), times(FORWARDS, 0.6), 500)
    early = forward_speed(0.6) - plant.twist.vx_mps
    late = forward_speed(0.6) - run(plant, times(FORWARDS, 0.6), 1000).twist.vx_mps
    return 1.0 / math.log(early / late)


def grip_reached(wheels: Sequence[Wheel], direction_deg: float) -> float:
    """All wheels spin the way that the bound's multipliers want: what the plant then does along them."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    _, y = grip_limit(robot, direction_deg)
    signs = [
        0.0 if abs(dot(y, row)) < 1e-9 else math.copysign(1.0, dot(y, row)) for row in Kinematics(robot.wheels).axes
    ]
    ax, ay, alpha = first_step(robot, times(signs, 10.0))
    return y[0] * ax + y[1] * ay + y[2] * robot.body.inertia_kgm2 * alpha / robot.body.mass_kg


def beyond_the_grip(wheels: Sequence[Wheel]) -> float:
    """By how much random currents exceed the bound, in any direction of the table."""
    return max(0.0, *(most_of_many(wheels, deg) for deg in DIRECTIONS_DEG))


def most_of_many(wheels: Sequence[Wheel], direction_deg: float) -> float:
    """Of a hundred random currents, the most along the bound, less the bound."""
    robot = robot_with(wheels, **NO_LOSSES, **FLAT)
    limit, y = grip_limit(robot, direction_deg)
    random = Random(round(direction_deg))
    most = 0.0
    for _ in range(100):
        ax, ay, alpha = first_step(robot, [random.uniform(-10.0, 10.0) for _ in robot.wheels])
        most = max(most, y[0] * ax + y[1] * ay + y[2] * robot.body.inertia_kgm2 * alpha / robot.body.mass_kg)
    return most - limit


def slip_onset() -> float:
    """The current between 1.9 and 2.2 A from which a front wheel slips in the first step from rest."""
    low, high = 1.9, 2.2
    for _ in range(30):
        middle = (low + high) / 2.0
        plant = run(Plant(robot_with(ground_rolling=0.0, **FLAT), None), times(FORWARDS, middle), 1)
        low, high = (low, middle) if abs(plant.slip_mps[0]) > 1e-9 else (middle, high)
    return low


def forward_grip() -> float:
    """The most that the front wheels get onto the floor, load transfer included."""
    plant = run(Plant(robot_with(ground_rolling=0.0), None), times(FORWARDS, 5.0), 60)
    before = plant.twist.vx_mps
    return (run(plant, times(FORWARDS, 5.0), 1).twist.vx_mps - before) / STEP_S


def coast_down() -> float:
    """Time from 0.5 m/s to an exact stop."""
    plant = Plant(robot_with(**FLAT), None, twist=BodyTwist(0.5, 0.0, 0.0))
    steps = 0
    while plant.twist.vx_mps > 1e-12:
        run(plant, (0.0, 0.0, 0.0), 1)
        steps += 1
    return steps * STEP_S


def coast_down_formula() -> float:
    """m dv/dt = -(F + B v): exponential with offset."""
    n1, n2 = rest_loads()
    constant = 2.0 * SIN75 / 0.027 * 0.020 + 0.05 * (2.0 * n1 * COS75 + n2)
    viscous = 2.0 * 0.0045 * (SIN75 / 0.027) ** 2
    return (1.6 + 1.2e-3 * 2.0 * (SIN75 / 0.027) ** 2) / viscous * math.log(1.0 + 0.5 * viscous / constant)


def straight_run() -> Pose:
    """Where ten seconds at 1 A end."""
    return run(Plant(robot_with(**FLAT), None), times(FORWARDS, 1.0), 10_000).pose


def drift_in_rotation() -> float:
    """How far turning on the spot moves the robot."""
    return math.hypot(*run(Plant(robot_with(), None), times(SPIN, 0.6), 6000).pose[:2])


def stall(current_a: float, **changes: float) -> Plant:
    """The robot after 0.6 s against a wall."""
    plant = Plant(robot_with(ground_rolling=0.0, **changes), ROOM, Pose(0.415, 0.0, 0.0))
    return run(plant, times(FORWARDS, current_a), 600)


def beyond_the_band() -> float:
    """How far the stall force at 1 A lies outside of 2 sin 75/r (Kt i -+ tau_c)."""
    force = -stall(1.0, ground_grip=2.0, **FLAT).wall_force_n[0]
    least, most = (2.0 * SIN75 / 0.027 * (0.18 + sign * 0.020) for sign in (-1.0, 1.0))
    return max(0.0, least - force, force - most)


def creep() -> float:
    """The fastest wheel of a robot stalled below its grip."""
    return max(map(abs, stall(1.0, ground_grip=2.0).wheel_speeds_radps))


def impact(restitution: float, steps: int) -> Plant:
    """The robot so many steps after it stood 0.43 mm before a wall at 0.83 m/s."""
    start, speed = Pose(0.41957, 0.0, 0.0), BodyTwist(0.83, 0.0, 0.0)
    return run(
        Plant(robot_with(**FLAT), Arena(1.0, 0.8, restitution=restitution), start, speed), (0.0, 0.0, 0.0), steps
    )


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


def tipping(forwards: bool) -> float:
    """Acceleration at which a wheel's load is gone: the front ones forwards, the rear one braking."""
    rest, per_ax, _ = load_rows(robot_with().wheels, 1.6, 0.035)[0 if forwards else 1]
    return -rest / per_ax


# --- small algebra ----------------------------------------------------------------------------------------------------


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """Of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def determinant(m: Sequence[Sequence[float]]) -> float:
    """Of three rows."""
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


def solved(matrix: Sequence[Sequence[float]], right: Sequence[float]) -> Vector:
    """Cramer's rule."""
    whole = determinant(matrix)
    parts = [
        determinant([[right[i] if k == column else row[k] for k in range(3)] for i, row in enumerate(matrix)])
        for column in range(3)
    ]
    return parts[0] / whole, parts[1] / whole, parts[2] / whole


def turned(twist: BodyTwist, angle: float) -> Vector:
    """A twist in a frame turned back by the angle."""
    c, s = math.cos(angle), math.sin(angle)
    return c * twist.vx_mps - s * twist.vy_mps, s * twist.vx_mps + c * twist.vy_mps, twist.omega_radps


# --- the table --------------------------------------------------------------------------------------------------------

GRIP_TABLE = {
    "004": (5.269, 3.555, 2.514, 2.052, 1.777),
    "omni 60/135/225/300": (5.495, 3.621, 3.374, 3.374, 3.434),
    "mecanum 45": (4.856, 3.555, 3.434, 3.555, 4.856),
}
STEADY = {0.3: 0.183179, 0.4: 0.294989, 0.6: 0.518609, 1.0: 0.965848, 1.3: 1.301277}


def checks() -> list[Check]:
    """Every row, in the order of the page."""
    rows = [
        Check(f"reflected inertia, {name}: worst of all torques, share", "2", 0.0, 1e-9, partial(worst_inertia, wheels))
        for name, wheels in LAYOUTS.items()
    ]
    rows += [
        Check("effective mass forward, kg", "2", 4.672, 5e-4, partial(effective, 0)),
        Check("effective mass sideways, kg", "2", 3.47, 5e-3, partial(effective, 1)),
        Check("effective yaw inertia, kg m2", "2", 0.0240, 5e-5, partial(effective, 2)),
    ]
    rows += [
        Check(f"steady speed forward at {amps} A, m/s", "4.1", speed, 1e-6, partial(steady, amps))
        for amps, speed in STEADY.items()
    ]
    rows += [
        Check("time constant forward, s", "2", 0.4056, 6e-4, time_constant),
        Check(
            "start at 0.6 A, m/s2", "2", 1.2787, 0.0064,
            lambda: first_step(robot_with(), times(FORWARDS, 0.6))[0],
        ),
        Check("turning at 0.6 A, rad/s", "4.1", 8.65574, 2e-5, lambda: driven(robot_with(), times(SPIN, 0.6), 6000)[2]),
        Check("drift while turning 6 s, m", "4.1", 0.0, 1e-9, drift_in_rotation),
        Check("start turning at 0.6 A, rad/s2", "2", 24.88, 0.08,
              lambda: first_step(robot_with(), times(SPIN, 0.6))[2]),
        Check(
            "turning, all wheels spinning, mu 0.7, rad/s2", "2", 119.7, 0.05,
            lambda: first_step(robot_with(ground_rolling=0.0, **FLAT), times(SPIN, 10.0))[2],
        ),
        Check(
            "forward, wheels spinning, mu 0.15, m/s2", "4.1", 1.1291, 5e-5,
            lambda: driven(robot_with(**SLICK), times(FORWARDS, 3.0), 100)[0] / 0.1,
        ),
        Check(
            "turning, wheels spinning, mu 0.15, rad/s2", "4.1", 25.6461, 5e-5,
            lambda: driven(robot_with(**SLICK), times(SPIN, 3.0), 100)[2] / 0.1,
        ),
        Check(
            "mecanum forward, spinning, mu 0.15, m/s2", "4.1", 1.0405, 5e-5,
            lambda: driven(robot_with(mecanum(), **SLICK), (3.0, 3.0, 3.0, 3.0), 100)[0] / 0.1,
        ),
        Check(
            "mecanum sideways, spinning, mu 0.15, m/s2", "4.1", 1.0405, 5e-5,
            lambda: driven(robot_with(mecanum(), **SLICK), (-3.0, 3.0, 3.0, -3.0), 100)[1] / 0.1,
        ),
    ]  # fmt: skip
    rows += [
        Check(f"grip limit {name} at {deg:g} deg, m/s2", "2", limit, 6e-4, partial(grip_reached, LAYOUTS[name], deg))
        for name, limits in GRIP_TABLE.items()
        for deg, limit in zip(DIRECTIONS_DEG, limits, strict=True)
    ]
    rows += [
        Check(f"beyond it with any currents, {name}, m/s2", "2", 0.0, 1e-9, partial(beyond_the_grip, LAYOUTS[name]))
        for name in GRIP_TABLE
    ]
    rows += [
        Check("rear wheel lifts at, m/s2", "2", -4.42, 6e-3, partial(tipping, False)),
        Check("front wheels lift at, m/s2", "2", 17.1, 0.05, partial(tipping, True)),
        Check("forward grip with load transfer, m/s2", "4.1", 4.02788, 2e-5, forward_grip),
        Check("onset of slip from rest, A", "2", 2.02, 8e-3, slip_onset),
        Check("coast-down from 0.5 m/s, s", "2", coast_down_formula(), 2e-3, coast_down),
        Check("straight run of 10 s at 1 A, m", "4.1", 9.266, 1e-3, lambda: straight_run().x_m),
        Check("the same, sideways, m", "4.1", 0.0, 1e-9, lambda: straight_run().y_m),
        Check("the same, heading, rad", "4.1", 0.0, 1e-9, lambda: straight_run().heading_rad),
        Check(
            "torques (0.04, -0.08, 0.04) N m yaw at, rad/s2", "2", 2.23, 1.1e-2,
            lambda: first_step(robot_with(**NO_LOSSES), [t / 0.18 for t in (0.04, -0.08, 0.04)])[2],
        ),
        Check(
            "torques of 0.05 N m each push sideways at, m/s2", "2", -0.062, 5e-4,
            lambda: first_step(robot_with(**NO_LOSSES), [0.05 / 0.18] * 3)[1],
        ),
        Check("stall at 1 A outside of 11.45 to 14.31 N, N", "3.3", 0.0, 1e-9, beyond_the_band),
        Check(
            "stall above the grip, N", "2", 8.43, 5e-3, lambda: -stall(1.0, **FLAT).wall_force_n[0]
        ),
        Check("stalled below the grip, wheel speed, rad/s", "3.3", 0.0, 0.0, creep),
        Check("stop at 0.83 m/s, wheels, rad/s", "3.3", 29.7, 0.1, lambda: impact(0.0, 1).wheel_speeds_radps[0]),
        Check("the same 100 ms later, rad/s", "3.3", 10.9, 0.15, lambda: impact(0.0, 101).wheel_speeds_radps[0]),
        Check("rebound at elasticity 0.5, m/s", "3.3", -0.415, 1e-3, lambda: impact(0.5, 1).twist.vx_mps),
        Check("the same 100 ms later, m/s", "3.3", 0.12, 5e-3, lambda: impact(0.5, 101).twist.vx_mps),
        Check("energy balance, worst of 2000 steps, J", "4.1", 0.0, 1e-12, lambda: energy()[0]),
        Check("a loss that is a gain, worst, N m/s, N m", "4.1", 0.0, 1e-9, lambda: energy()[1]),
        Check("error at 1 ms over error at 0.5 ms", "4.3", 2.0, 0.05, halving),
        Check("mirrored currents, off the mirrored path, m, rad", "4.3", 0.0, 1e-9, mirrored),
        Check("turned start, off the turned path, m", "4.3", 0.0, 1e-9, start_turned),
    ]  # fmt: skip
    return rows


def row_of(check: Check, measured: float) -> str:
    """A line of the table."""
    off = abs(measured - check.expected)
    # The last bits of a zero differ between platforms.
    ends = f"{measured:.8g} | {off:.0e}" if off >= ROUNDING or check.expected else f"below {ROUNDING:.0e} | -"
    return f"| {check.name} | {check.section} | {check.expected:.8g} | {ends} | {check.allowed:.1e} |"


def main() -> int:
    """Print the table; 1 where a row is out of bounds."""
    print("| check | section | expected | measured | off by | allowed |\n|---|---|---|---|---|---|")
    failed = 0
    for check in checks():
        measured = check.measure()
        print(row_of(check, measured), flush=True)
        failed += not abs(measured - check.expected) <= check.allowed
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
