"""Document 002: full-field localisation with three dead wheels, its formulas and its C code as printed.

Frame: x right, y forward, yaw counter-clockwise, millimetres, milliseconds; wheels f, i, r at bearings 0, 120 and 240
degrees from forward, counter-clockwise positive. The closed formulas are right; what the code makes of them is not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

DISTANCE_MM = 100.0
DELTA_T_MS = 5.0
BEARINGS_DEG = (0.0, 120.0, 240.0)


class PositionAsPrinted(NamedTuple):
    """The code's three globals."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    yaw_deg: float = 0.0


def velocity_as_printed(
    theta_rad: float, v_f: float, v_i: float, v_r: float, d_mm: float = DISTANCE_MM
) -> tuple[float, float, float]:
    """Field velocity from rim speeds in mm/ms: (vx, vy in mm/ms, w). Right; but w is in rad/ms, not deg/ms. Row 20."""
    c, s, root3 = math.cos(theta_rad), math.sin(theta_rad), math.sqrt(3)
    v_x = -2 * c / 3 * v_f + (c + root3 * s) / 3 * v_i + (c - root3 * s) / 3 * v_r
    v_y = -2 * s / 3 * v_f + (s - root3 * c) / 3 * v_i + (s + root3 * c) / 3 * v_r
    w = v_f / (3 * d_mm) + v_i / (3 * d_mm) + v_r / (3 * d_mm)
    return v_x, v_y, w


def calculate_position_as_printed(
    position: PositionAsPrinted,
    v_f: float,
    v_i: float,
    v_r: float,
    *,
    d_mm: float = DISTANCE_MM,
    delta_t_ms: float = DELTA_T_MS,
    degrees_per_unit: float = 1.0,
) -> PositionAsPrinted:
    """One call of the C code: radians are added to degrees, the yaw is never wrapped, the step is Euler's. Rows 17-19.

    `degrees_per_unit` = 180/pi mends the first fault, so that the others can be seen behind it.
    """
    v_x, v_y, w = velocity_as_printed(position.yaw_deg * math.pi / 180, v_f, v_i, v_r, d_mm)
    return PositionAsPrinted(
        position.x_mm + v_x * delta_t_ms,
        position.y_mm + v_y * delta_t_ms,
        position.yaw_deg + w * delta_t_ms * degrees_per_unit,
    )
