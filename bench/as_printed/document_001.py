"""Document 001: motor output equations of three and four omni wheels and of mecanum wheels, and its fast sine.

Frame: a field command x right, y forward and z, which is added to every wheel as it is; `ang_deg` is the gyroscope's
heading. Wheels count along the clockwise tangent (mecanum: left side forward, right side backward). What the text says
of the heading's sense, clockwise positive, holds for the mecanum equations only. Row 9.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

ONE_PI = 3.14159265
ANGLE_TO_RADIAN = 0.01745
"""Row 16: pi/180 cut after four digits."""
BEARINGS_3_DEG = (60.0, -60.0, 180.0)
BEARINGS_4_DEG = (60.0, -60.0, -120.0, 120.0)


class Trig(NamedTuple):
    """Which sine, cosine and radians a degree an equation is evaluated with."""

    sin: Callable[[float], float]
    cos: Callable[[float], float]
    rad_per_deg: float


def mx_sin_as_printed(rad: float) -> float:
    """The parabola behind the fast sine; for -pi to pi. Rows 13 and 14."""
    sine = rad * (1.27323954 + 0.405284735 * rad) if rad < 0 else rad * (1.27323954 - 0.405284735 * rad)
    if sine < 0:
        return sine * (-0.225 * (sine + 1) + 1)
    return sine * (0.225 * (sine - 1) + 1)


def my_sin_as_printed(rad: float) -> float:
    """The fast sine: folds what is above pi and never what is below -pi. Rows 13 and 14."""
    flag = 1
    while rad > 2 * ONE_PI:
        rad -= 2 * ONE_PI
    if rad >= ONE_PI:
        rad -= ONE_PI
        flag = -1
    return mx_sin_as_printed(rad) * flag


def my_cos_as_printed(rad: float) -> float:
    """The fast cosine: the fast sine a quarter turn on; wrong below -270 degrees. Rows 13 and 14."""
    flag = 1
    rad += ONE_PI / 2.0
    while rad > 2 * ONE_PI:
        rad -= 2 * ONE_PI
    if rad >= ONE_PI:
        flag = -1
        rad -= ONE_PI
    return my_sin_as_printed(rad) * flag


EXACT = Trig(math.sin, math.cos, math.pi / 180.0)
FAST = Trig(my_sin_as_printed, my_cos_as_printed, ANGLE_TO_RADIAN)
"""What the document computes with."""


def three_wheels_as_printed(x: float, y: float, z: float, ang_deg: float, trig: Trig = FAST) -> list[float]:
    """Three omni wheels, the compact code: right, for a heading that counts counter-clockwise. Row 9."""
    sin, cos, rad = trig
    a, b = (60 + ang_deg) * rad, (60 - ang_deg) * rad
    c = (a - b) * 0.5
    return [
        cos(a) * x + sin(a) * y - z,
        cos(b) * x - sin(b) * y - z,
        -cos(c) * x - sin(c) * y - z,
    ]


def three_wheels_detailed_as_printed(x: float, y: float, z: float, ang_deg: float, trig: Trig = FAST) -> list[float]:
    """Three omni wheels, the "detailed" lines: motor 3 has 0 - ang where it has to be 0 + ang. Row 10."""
    sin, cos, rad = trig
    a, b, c = (60 + ang_deg) * rad, (60 - ang_deg) * rad, (0 - ang_deg) * rad
    return [
        cos(a) * x + sin(a) * y - z,
        cos(b) * x - sin(b) * y - z,
        -cos(c) * x - sin(c) * y - z,
    ]


def four_wheels_as_printed(x: float, y: float, z: float, ang_deg: float, trig: Trig = FAST) -> list[float]:
    """Four omni wheels, the compact code: c is the three-wheel robot's, where it has to be a. Row 11."""
    sin, cos, rad = trig
    a, b = (60 + ang_deg) * rad, (60 - ang_deg) * rad
    c = (a - b) * 0.5
    return _four_as_printed(x, y, z, (a, b, c), sin, cos)


def four_wheels_detailed_as_printed(x: float, y: float, z: float, ang_deg: float, trig: Trig = FAST) -> list[float]:
    """Four omni wheels, the "detailed" lines: right, for a heading that counts counter-clockwise. Row 9."""
    sin, cos, rad = trig
    a, b = (60 + ang_deg) * rad, (60 - ang_deg) * rad
    return _four_as_printed(x, y, z, (a, b, a), sin, cos)


def mecanum_as_printed(x: float, y: float, z: float, ang_deg: float, trig: Trig = FAST) -> list[float]:
    """Four mecanum wheels: translation comes out times cos 45, rotation does not. Row 12."""
    sin, cos, rad = trig
    a, b = (45 - ang_deg) * rad, (45 + ang_deg) * rad
    return _four_as_printed(x, y, z, (a, b, a), sin, cos)


def _four_as_printed(
    x: float,
    y: float,
    z: float,
    angles: tuple[float, float, float],
    sin: Callable[[float], float],
    cos: Callable[[float], float],
) -> list[float]:
    a, b, c = angles
    return [
        cos(a) * x + sin(a) * y - z,
        cos(b) * x - sin(b) * y - z,
        -cos(c) * x - sin(c) * y - z,
        -cos(b) * x + sin(b) * y - z,
    ]
