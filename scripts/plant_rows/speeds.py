"""Speeds without slip: what a current settles at, how fast it gets there, where it ends."""

from __future__ import annotations

import math
from functools import partial

from bench.messages import BodyTwist, Pose
from bench.plant import STEP_S, Plant
from plant_rows.check import (
    COS75,
    FLAT,
    FORWARDS,
    SIN75,
    SPIN,
    Check,
    driven,
    first_step,
    rest_loads,
    robot_with,
    run,
    times,
)

STEADY = {0.3: 0.183179, 0.4: 0.294989, 0.6: 0.518609, 1.0: 0.965848, 1.3: 1.301277}


def forward_speed(current_a: float) -> float:
    """w = (Kt i - tau_c - r F)/b, v = w r/sin 75, F = c_rr (2 N1 cos 75 + N2)/(2 sin 75)."""
    n1, n2 = rest_loads()
    drag = 0.05 * (2.0 * n1 * COS75 + n2) / (2.0 * SIN75)
    return (0.18 * current_a - 0.020 - 0.027 * drag) / 0.0045 * 0.027 / SIN75


def steady(current_a: float) -> float:
    """The speed that a current settles at, forward."""
    return driven(robot_with(), times(FORWARDS, current_a), 6000).vx_mps


def time_constant() -> float:
    """From the approach to the steady speed between 0.5 and 1.5 s."""
    plant = run(Plant(robot_with(**FLAT), None), times(FORWARDS, 0.6), 500)
    early = forward_speed(0.6) - plant.twist.vx_mps
    late = forward_speed(0.6) - run(plant, times(FORWARDS, 0.6), 1000).twist.vx_mps
    return 1.0 / math.log(early / late)


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


def rows() -> list[Check]:
    """In the order of the page."""
    return [
        *(
            Check(f"steady speed forward at {amps} A, m/s", "4.1", speed, 1e-6, partial(steady, amps))
            for amps, speed in STEADY.items()
        ),
        Check("time constant forward, s", "2", 0.4056, 6e-4, time_constant),
        Check(
            "start at 0.6 A, m/s2", "2", 1.2787, 0.0064,
            lambda: first_step(robot_with(), times(FORWARDS, 0.6))[0],
        ),
        Check("turning at 0.6 A, rad/s", "4.1", 8.65574, 2e-5, lambda: driven(robot_with(), times(SPIN, 0.6), 6000)[2]),
        Check("drift while turning 6 s, m", "4.1", 0.0, 1e-9, drift_in_rotation),
        Check("start turning at 0.6 A, rad/s2", "2", 24.88, 0.08,
              lambda: first_step(robot_with(), times(SPIN, 0.6))[2]),
        Check("coast-down from 0.5 m/s, s", "2", coast_down_formula(), 2e-3, coast_down),
        Check("straight run of 10 s at 1 A, m", "4.1", 9.266, 1e-3, lambda: straight_run().x_m),
        Check("the same, sideways, m", "4.1", 0.0, 1e-9, lambda: straight_run().y_m),
        Check("the same, heading, rad", "4.1", 0.0, 1e-9, lambda: straight_run().heading_rad),
    ]  # fmt: skip
