"""Document 004: the M2006 robot's kinematics and current mapping as printed, and the numbers of its firmware.

Frame: x right, y forward, yaw clockwise positive; wheels along their clockwise tangents, bearings counter-clockwise
from forward.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

RADIUS_M = 0.061
WHEEL_RADIUS_M = 0.027
BEARINGS_DEG = (-75.0, 180.0, 75.0)
MAX_CURRENT_A = 0.6
MAX_LINEAR_MPS = 1.0
MAX_ANGULAR_RADPS = 2.0

FIRMWARE_FORCE_VECTORS = ((-0.258, 0.966), (1.0, 0.0), (-0.258, -0.966))
FIRMWARE_LABELS_DEG = (-15.0, 90.0, -165.0)
"""What the firmware calls the direction of each: degrees, "counterclockwise from +y". Row 28."""


def inverse_as_printed(
    vx: float,
    vy: float,
    omega: float,
    bearings_rad: Sequence[float],
    radius_m: float = RADIUS_M,
    wheel_radius_m: float = WHEEL_RADIUS_M,
) -> list[float]:
    """Twist -> wheel speeds. Rows (sin, cos, L): radial where they have to be (cos, sin, L). Row 22."""
    return [(vx * math.sin(theta) + vy * math.cos(theta) + radius_m * omega) / wheel_radius_m for theta in bearings_rad]


def forward_as_printed(
    wheels: Sequence[float],
    bearings_rad: Sequence[float],
    radius_m: float = RADIUS_M,
    wheel_radius_m: float = WHEEL_RADIUS_M,
) -> tuple[float, float, float]:
    """Wheel speeds -> twist: r/3 times the transpose, which is no inverse of anything printed. Rows 23 and 24."""
    x = y = turn = 0.0
    for speed, theta in zip(wheels, bearings_rad, strict=True):
        x += speed * math.sin(theta)
        y += speed * math.cos(theta)
        turn += speed / radius_m
    third = wheel_radius_m / 3
    return third * x, third * y, third * turn


def current_as_printed(wheel_radps: float, wheel_max_radps: float, max_current_a: float = MAX_CURRENT_A) -> float:
    """Motor current, A: proportional to the wheel's speed, I = w / w_max * I_max. Rows 26 and 27."""
    return wheel_radps / wheel_max_radps * max_current_a


def firmware_wheels_as_printed(vx: float, vy: float, omega: float) -> list[float]:
    """Twist -> wheel speeds in the firmware of document 004: right, whatever its comments say. Row 28."""
    return [
        -(vx * force_x + vy * force_y) / WHEEL_RADIUS_M + RADIUS_M * omega / WHEEL_RADIUS_M
        for force_x, force_y in FIRMWARE_FORCE_VECTORS
    ]
