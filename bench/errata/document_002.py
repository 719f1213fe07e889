"""Document 002, rows 17 to 20: full-field localisation from three dead wheels."""

from __future__ import annotations

import math

from bench.as_printed.document_002 import (
    BEARINGS_DEG,
    DELTA_T_MS,
    DISTANCE_MM,
    PositionAsPrinted,
    calculate_position_as_printed,
    velocity_as_printed,
)
from bench.config import EXACT
from bench.errata.algebra import tangential
from bench.errata.trial import drive, robot_for
from bench.errata.values import PLANT, Evidence, Figure, Row
from bench.messages import BodyTwist
from bench.odometry import wrap

WHEELS = tangential(BEARINGS_DEG, DISTANCE_MM / 1000.0)
MENDED = 180.0 / math.pi


def driven(speed_mps: float, omega_radps: float, turn_rad: float, degrees_per_unit: float = 1.0) -> PositionAsPrinted:
    """What the code says after an arc at constant speed, called every 5 ms (stretched by less than 1 % to fit)."""
    calls = round(turn_rad / omega_radps * 1000.0 / DELTA_T_MS)
    # mm/ms is m/s; the twist is the robot's own, and the same in every call.
    rims = WHEELS.wheel_speeds((speed_mps, 0.0, omega_radps))
    v_f, v_i, v_r = rims
    position = PositionAsPrinted()
    delta_t_ms = turn_rad / omega_radps * 1000.0 / calls
    for _ in range(calls):
        position = calculate_position_as_printed(
            position, v_f, v_i, v_r, delta_t_ms=delta_t_ms, degrees_per_unit=degrees_per_unit
        )
    return position


def arc_mm(speed_mps: float, omega_radps: float, turn_rad: float) -> tuple[float, float]:
    """Where the arc really ends: (right, forward)."""
    radius_mm = 1000.0 * speed_mps / omega_radps
    return -radius_mm * (1.0 - math.cos(turn_rad)), radius_mm * math.sin(turn_rad)


def _off_mm(speed_mps: float, omega_radps: float, turn_rad: float, degrees_per_unit: float = 1.0) -> float:
    return math.dist(
        driven(speed_mps, omega_radps, turn_rad, degrees_per_unit)[:2], arc_mm(speed_mps, omega_radps, turn_rad)
    )


def _row_17() -> Evidence:
    circle = driven(1.0, 1.0, math.tau)
    runs = [
        drive(robot_for("deadwheel3", odometry=form), BodyTwist(0.6, 0.0, 1.5), turn_rad=math.tau)
        for form in (EXACT, "document-002-as-printed")
    ]
    told = [math.degrees(run.believed_turned_rad) for run in runs]
    off = [math.dist(run.believed[:2], run.pose[:2]) for run in runs]
    return Evidence(
        (
            Figure("a circle of 1 m: heading", (360.0,), (circle.yaw_deg,), "deg"),
            Figure("a circle of 1 m: right, forward", arc_mm(1.0, 1.0, math.tau), circle[:2], "mm"),
            Figure("quarter turn, 1 m/s, 2 rad/s: off by", (0.0,), (_off_mm(1.0, 2.0, math.pi / 2),), "mm"),
            Figure("half turn, 1 m/s, 2 rad/s: off by", (0.0,), (_off_mm(1.0, 2.0, math.pi),), "mm"),
            Figure("a circle of 0.4 m: heading told", (told[0],), (told[1],), "deg", PLANT),
            Figure("the same: told to stand off by", (off[0],), (off[1],), "m", PLANT),
        ),
        f"The heading is {360.0 / circle.yaw_deg:.1f} times too small: after one circle the robot is told to stand "
        f"{math.hypot(*circle[:2]) / 1000:.2f} m from where it is.",
    )


def _row_18() -> Evidence:
    printed = driven(0.0, 5.0, 30 * math.tau).yaw_deg
    mended = driven(0.0, 5.0, 1.5 * math.tau, MENDED).yaw_deg
    return Evidence(
        (
            Figure("30 turns", (_wrapped_deg(30 * 360.0),), (printed,), "deg"),
            Figure("1.5 turns, row 17 mended", (_wrapped_deg(1.5 * 360.0),), (mended,), "deg"),
        ),
        "A heading controller that trusts -180..180 takes the long way round, once for every turn that was driven.",
    )


def _wrapped_deg(degrees: float) -> float:
    return math.degrees(wrap(math.radians(degrees)))


def _row_19() -> Evidence:
    quarter, half, full = (_off_mm(1.0, 2.0, turn, MENDED) for turn in (math.pi / 2, math.pi, math.tau))
    return Evidence(
        (
            Figure("quarter turn, row 17 mended: off by", (0.0,), (quarter,), "mm"),
            Figure("half turn: off by", (0.0,), (half,), "mm"),
            Figure("full turn: off by", (0.0,), (full,), "mm"),
        ),
        f"{half:.1f} mm lost in every half turn at 1 m/s and 2 rad/s; a full circle closes and hides it.",
    )


def _row_20() -> Evidence:
    v_f, v_i, v_r = WHEELS.wheel_speeds((0.0, 0.0, 1.0))
    w = velocity_as_printed(0.0, v_f, v_i, v_r)[2]
    return Evidence(
        (Figure("w of 1 rad/s, by its comment in deg/ms", (math.degrees(1.0) / 1000.0,), (w,), "deg/ms"),),
        f"The comment is how row 17 came about: w is {w:g} rad/ms.",
    )


ROWS = (
    Row(
        17, "002", "the code: the heading's unit", "position_yaw += w*delta_t", "position_yaw += w*delta_t*180/PI",
        _row_17,
    ),
    Row(
        18, "002", "the code: the heading's range", "float position_yaw = 0; // degrees (-180~180)",
        "wrap after every step", _row_18,
    ),
    Row(
        19, "002", "the code and text: the step", "position_x += v_x*delta_t, at the old heading",
        "the exponential map: exact for constant twist", _row_19,
    ),
    Row(20, "002", "the code: the comment beside w", "float w; // deg/ms", "rad/ms", _row_20, holds=True),
)  # fmt: skip
