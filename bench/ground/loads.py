"""How the robot's weight stands on its wheels: statics, with load transfer under acceleration. Pure arithmetic.

Three wheels are statically determined; more share by least squares, as public SSL firmware has it. A wheel that would
carry less than nothing has lifted: the transfer is cut at that point, so that the loads still add up to the weight
(just clamping at zero would invent weight: plant-model reference, section 1.3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.config import Wheel
from bench.kinematics import Row

GRAVITY_MPS2 = 9.81
TIPPING_MARGIN = 1.0 - 1e-12
"""Keeps a lifted wheel's load from rounding below zero."""


def load_rows(wheels: Sequence[Wheel], mass_kg: float, height_m: float) -> list[Row]:
    """For each wheel (N at rest, N for each m/s^2 forward, N for each m/s^2 to the left).

    Sum N = m g, sum N x = -m h ax, sum N y = -m h ay: one solution for three wheels, the one of least squares for more.
    Raises ValueError where the robot would fall over at rest.
    """
    rows = [(1.0, wheel.x_m, wheel.y_m) for wheel in wheels]
    gram = [[0.0] * 3 for _ in range(3)]
    for row in rows:
        for i in range(3):
            for j in range(3):
                gram[i][j] += row[i] * row[j]
    adjugate = (_cross(gram[1], gram[2]), _cross(gram[2], gram[0]), _cross(gram[0], gram[1]))
    determinant = gram[0][0] * adjugate[0][0] + gram[0][1] * adjugate[0][1] + gram[0][2] * adjugate[0][2]
    if determinant <= 1e-9 * gram[0][0] * gram[1][1] * gram[2][2]:
        raise ValueError("the wheels stand in one line: the robot would fall over")
    tip = -mass_kg * height_m
    loads = []
    for wheel, row in zip(wheels, rows, strict=True):
        share = [(row[0] * a[0] + row[1] * a[1] + row[2] * a[2]) / determinant for a in adjugate]
        rest = mass_kg * GRAVITY_MPS2 * share[0]
        if rest < 0.0:
            raise ValueError(
                f"wheel {wheel.name!r} would carry {rest:.3g} N at rest: the centre of gravity, at (0, 0), "
                "is not between the wheels and the robot would fall over"
            )
        loads.append((rest, tip * share[1], tip * share[2]))
    return loads


def lift_above(rows: Sequence[Row]) -> float:
    """The square of an acceleration, m^2/s^4, up to which no wheel lifts, whatever its direction."""
    squares = [(rest * rest, per_ax * per_ax + per_ay * per_ay) for rest, per_ax, per_ay in rows]
    return min((load / transfer for load, transfer in squares if transfer), default=math.inf)


def tipping_part(rows: Sequence[Row], ax: float, ay: float) -> float:
    """The part of the load transfer, 0 to 1, that leaves no wheel below zero; the loads still add up to the weight."""
    part = 1.0
    for rest, per_ax, per_ay in rows:
        load = rest + per_ax * ax + per_ay * ay
        if load < 0.0:
            part = min(part, rest / (rest - load) * TIPPING_MARGIN)
    return part


def _cross(a: Sequence[float], b: Sequence[float]) -> Row:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
