"""Matrices out of formulas: what a printed pair of conversions does to a true motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from bench.config import Wheel
from bench.kinematics import Kinematics

Vector = Sequence[float]
Matrix = tuple[tuple[float, ...], ...]

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def tangential(
    bearings_deg: Sequence[float], distance_m: float, *, clockwise: bool = False, radius_m: float = 1.0
) -> Kinematics:
    """A base of tangential omni wheels; a wheel radius of 1 m makes wheel speeds rim speeds in m/s."""
    wheels = []
    for number, bearing_deg in enumerate(bearings_deg, start=1):
        bearing_rad = math.radians(bearing_deg)
        heading_rad = bearing_rad + math.radians(-90.0 if clockwise else 90.0)
        x_m, y_m = distance_m * math.cos(bearing_rad), distance_m * math.sin(bearing_rad)
        wheels.append(Wheel(str(number), x_m, y_m, heading_rad, radius_m, can_id=number))
    return Kinematics(wheels)


def returned(forward: Callable[[Vector], Vector], inverse: Callable[[Vector], Vector]) -> Matrix:
    """F H, row by row: what the pair gives back for a true motion. The identity, where F undoes H."""
    columns = [forward(inverse(axis)) for axis in AXES]
    return tuple(zip(*columns, strict=True))


def rows_of(inverse: Callable[[Vector], Vector]) -> Matrix:
    """H, a row a wheel."""
    return tuple(zip(*(inverse(axis) for axis in AXES), strict=True))


def worst(a: Sequence[Vector], b: Sequence[Vector]) -> float:
    """The largest difference between two matrices."""
    return max(abs(p - q) for row, other in zip(a, b, strict=True) for p, q in zip(row, other, strict=True))
