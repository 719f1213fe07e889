"""Document 000: SLAMWARE on a tri-omni base. Its odometry formulas and its odometer code, as printed.

Frame: x forward, y left, counter-clockwise positive; rims count metres, counter-clockwise positive. Layout a has one
wheel ahead (bearings 0, 120, 240 degrees), layout b two (180, -60, 60). The wheel speeds that it prints are right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

Increment = tuple[float, float, float]

RADIUS_M = 0.18
BEARINGS_A_DEG = (0.0, 120.0, 240.0)
BEARINGS_B_DEG = (180.0, -60.0, 60.0)

COS30 = 0.86602540
SIN30 = 0.5

CODE_LINES_AS_PRINTED = (
    "float dx = (-db / COS30f + dc / COS30f) / 2",
    "float dy = (da - db / SIN30f - dc / SIN30f) / 3",
    "float dtheta = (da + db + dc) / R / 3",
)
"""The three statements of the code between which the semicolons are missing. Row 5."""

S32_MIN, S32_MAX = -(2**31), 2**31 - 1


def layout_a_code_as_printed(da_m: float, db_m: float, dc_m: float, radius_m: float = RADIUS_M) -> Increment:
    """Layout a, the C code: (dx, dy, dtheta). dy divides by sin 30 where it has to multiply. Row 1."""
    dx = (-db_m / COS30 + dc_m / COS30) / 2
    dy = (da_m - db_m / SIN30 - dc_m / SIN30) / 3
    dtheta = (da_m + db_m + dc_m) / radius_m / 3
    return dx, dy, dtheta


def layout_a_text_as_printed(da_m: float, db_m: float, dc_m: float, radius_m: float = RADIUS_M) -> Increment:
    """Layout a, the text: (dx, dy, dtheta). Dx multiplies Db by cos 30, Dy multiplies Db by sin 30. Rows 2 and 3."""
    dx = (-db_m * COS30 + dc_m / COS30) / 2
    dy = (-db_m * SIN30 - dc_m / SIN30 + da_m) / 3
    dtheta = (da_m + db_m + dc_m) / radius_m / 3
    return dx, dy, dtheta


def layout_b_text_as_printed(da_m: float, db_m: float, dc_m: float, radius_m: float = RADIUS_M) -> Increment:
    """Layout b, the text: (dx, dy, dtheta). Dy divides by sin 30 where it has to multiply. Row 4."""
    dx = (db_m / COS30 - dc_m / COS30) / 2
    dy = (-da_m + db_m / SIN30 + dc_m / SIN30) / 3
    dtheta = (da_m + db_m + dc_m) / radius_m / 3
    return dx, dy, dtheta


def odometer_increments_as_printed(current_m: Sequence[float], last_m: Sequence[float] | None = None) -> list[float]:
    """Differences of the wheel odometers, the C code. On the first call (None) the memory is all zero. Row 6."""
    if last_m is None:
        last_m = [0.0] * len(current_m)
    return [now - before for now, before in zip(current_m, last_m, strict=True)]


def displacement_q16_as_printed(dx_m: float, dy_m: float, dtheta_rad: float) -> tuple[int, int, int]:
    """The answer's three fields: 16.16 millimetres and degrees, cast to a signed 32-bit number, unchecked. Row 7.

    What C makes of a value outside is undefined: here it is what an x86-64 does, the most negative number. (An ARM
    with a floating-point unit stays at the end of the range.)
    """
    return (
        _s32_as_printed(dx_m * 1000 * 65536),
        _s32_as_printed(dy_m * 1000 * 65536),
        _s32_as_printed(dtheta_rad * 180 / math.pi * 65536),
    )


def _s32_as_printed(value: float) -> int:
    whole = int(value)
    return whole if S32_MIN <= whole <= S32_MAX else S32_MIN
