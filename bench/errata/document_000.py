"""Document 000, rows 1 to 8: SLAMWARE odometry on a tri-omni base."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

from bench.as_printed.document_000 import (
    BEARINGS_A_DEG,
    BEARINGS_B_DEG,
    CODE_LINES_AS_PRINTED,
    RADIUS_M,
    S32_MAX,
    Increment,
    displacement_q16_as_printed,
    layout_a_code_as_printed,
    layout_a_text_as_printed,
    layout_b_text_as_printed,
    odometer_increments_as_printed,
)
from bench.config import EXACT
from bench.errata.algebra import returned, tangential
from bench.errata.trial import drive, robot_for
from bench.errata.values import PLANT, Evidence, Figure, Row
from bench.messages import BodyTwist, Pose
from bench.odometry import compose
from bench.slamware.payloads import dead_reckon_answer, dead_reckon_from_answer

Form = Callable[[float, float, float], Increment]

LAYOUT_A = tangential(BEARINGS_A_DEG, RADIUS_M)
LAYOUT_B = tangential(BEARINGS_B_DEG, RADIUS_M)
ORIGIN = Pose(0.0, 0.0, 0.0)
FORWARD, LEFT, TURN = 0, 1, 2
SPIN = BodyTwist(0.0, 0.0, 2.0)
MOVE = (0.5, -0.2, 1.0)
"""m, m, rad: what the first row's evidence is worked with."""


def _row_1() -> Evidence:
    rims = LAYOUT_A.wheel_speeds(MOVE)
    forms = (EXACT, "document-000-a-as-printed")
    right_m, printed_m = (
        drive(robot_for("slamware-a", odometry=form), SPIN, turn_rad=math.tau).believed_path_m for form in forms
    )
    leak_m = _returned_a(layout_a_code_as_printed)[LEFT][TURN] * math.tau
    return Evidence(
        (
            Figure(
                "dy for (0.5 m, -0.2 m, 1 rad)", (LAYOUT_A.fit(rims)[1],), (layout_a_code_as_printed(*rims)[1],), "m"
            ),
            _row_figure("row dy of F H", layout_a_code_as_printed, LEFT),
            Figure("sideways in one turn on the spot", (0.0,), (leak_m,), "m"),
            Figure("a turn on the spot: travel told", (right_m,), (printed_m,), "m", PLANT),
            _half_turn("slamware-a", "document-000-a-as-printed"),
        ),
        f"Every turn on the spot is told as {abs(leak_m):.2f} m of travel sideways. A whole turn closes that circle "
        "and hides it from who looks at the end only; half a turn does not.",
    )


def _row_2() -> Evidence:
    row = _row_figure("row dx of F H", layout_a_text_as_printed, FORWARD)
    forward_m, _ = _driven_ahead("document-000-a-text-as-printed")
    told_m, _ = _driven_ahead(EXACT)
    return Evidence(
        (row, Figure("2 s forward: told", (told_m,), (forward_m,), "m", PLANT)),
        f"Forward travel is told {100 * (1 - row.printed[0]):.1f} % short.",
    )


def _row_3() -> Evidence:
    row = _row_figure("row dy of F H", layout_a_text_as_printed, LEFT)
    _, left_m = _driven_ahead("document-000-a-text-as-printed")
    _, told_m = _driven_ahead(EXACT)
    return Evidence(
        (row, Figure("2 s forward: told to the left", (told_m,), (left_m,), "m", PLANT)),
        f"A metre forward is told as {row.printed[0]:+.3f} m to the left as well.",
    )


def _row_4() -> Evidence:
    printed = returned(lambda rims: layout_b_text_as_printed(*rims), LAYOUT_B.wheel_speeds)
    right = returned(LAYOUT_B.fit, LAYOUT_B.wheel_speeds)
    leak_m = printed[LEFT][TURN] * math.tau
    return Evidence(
        (
            Figure("row dy of F H", right[LEFT], printed[LEFT]),
            Figure("sideways in one turn on the spot", (0.0,), (leak_m,), "m"),
            _half_turn("slamware-b", "document-000-b-as-printed"),
        ),
        f"As row 1, to the other side: {leak_m:+.2f} m a turn.",
    )


def _row_5() -> Evidence:
    missing = [line for line in CODE_LINES_AS_PRINTED if not line.endswith(";")]
    return Evidence(
        (Figure("statements without their semicolon", (0.0,), (float(len(missing)),)),),
        "None: it does not compile. Who adds the semicolons has row 1.",
    )


def _row_6() -> Evidence:
    counters_m = LAYOUT_A.wheel_speeds((2.0, 0.0, 0.0))  # the wheels have a history: two metres forward
    first = LAYOUT_A.fit(odometer_increments_as_printed(counters_m))
    second = LAYOUT_A.fit(odometer_increments_as_printed(counters_m, counters_m))
    return Evidence(
        (
            Figure("first report of a base at rest", (0.0, 0.0, 0.0), first, "m, m, rad"),
            Figure("second report", (0.0, 0.0, 0.0), second, "m, m, rad"),
        ),
        f"A base that is switched on again after {first[0]:.0f} m jumps by {first[0]:.0f} m in the core's map.",
    )


def _row_7() -> Evidence:
    too_far_m = (S32_MAX + 1) / 65536 / 1000
    told_m = displacement_q16_as_printed(too_far_m, 0.0, 0.0)[0] / 65536 / 1000
    ours_m = dead_reckon_from_answer(dead_reckon_answer(too_far_m, 0.0, 0.0, 0)).dx_m
    turns = (S32_MAX + 1) / 65536 / 360
    return Evidence(
        (Figure(f"a report of {too_far_m:.3f} m", (ours_m,), (told_m,), "m"),),
        f"Increments never come near it. A total does after {too_far_m:.3f} m or {turns:.0f} turns. What comes then C "
        f"leaves open: on an x86-64, as here, the robot is told to stand {too_far_m - told_m:.1f} m from where it is; "
        "an ARM with a floating-point unit goes on telling the end of the range.",
    )


def _row_8() -> Evidence:
    # A quarter turn at 0.5 m/s and 1 rad/s, told every 50 ms: the same increments, read in three ways.
    polls = round(math.pi / 2 / 0.05)
    turn = math.pi / 2 / polls
    arc_m = 0.5 * turn
    exact, old, new = ORIGIN, ORIGIN, ORIGIN
    for _ in range(polls):
        exact = compose(exact, (arc_m, 0.0, turn))
        old = _straight(old, arc_m, turn, old.heading_rad)
        new = _straight(new, arc_m, turn, new.heading_rad + turn)
    return Evidence(
        (
            Figure("read in the old frame, off by", (0.0,), (math.dist(exact[:2], old[:2]),), "m"),
            Figure("read in the new frame, off by", (0.0,), (math.dist(exact[:2], new[:2]),), "m"),
            Figure("half-angle of one report", (0.0,), (math.degrees(turn / 2),), "deg"),
        ),
        f"Core and base may be {1000 * math.dist(old[:2], new[:2]):.0f} mm apart after a quarter turn of 0.5 m and "
        "both be as the document says. Ours: the frame at the start, exact arc.",
    )


def _half_turn(robot: str, odometry: str) -> Figure:
    """Half a turn on the spot, the core at the wheel: how far from the truth the odometry says the robot stands."""
    runs = [drive(robot_for(robot, odometry=form), SPIN, turn_rad=math.pi) for form in (EXACT, odometry)]
    right_m, printed_m = (math.dist(run.believed[:2], run.pose[:2]) for run in runs)
    return Figure("half a turn: told to stand off by", (right_m,), (printed_m,), "m", PLANT)


@cache
def _driven_ahead(odometry: str) -> tuple[float, float]:
    """Two seconds forward on layout a: what the odometry says, (forward, left) in m."""
    run = drive(robot_for("slamware-a", odometry=odometry), BodyTwist(0.4, 0.0, 0.0), ticks=2000)
    return run.believed[:2]


def _straight(pose: Pose, arc_m: float, turn_rad: float, along_rad: float) -> Pose:
    x_m, y_m, heading_rad = pose
    return Pose(x_m + arc_m * math.cos(along_rad), y_m + arc_m * math.sin(along_rad), heading_rad + turn_rad)


def _returned_a(form: Form) -> tuple[tuple[float, ...], ...]:
    return returned(lambda rims: form(*rims), LAYOUT_A.wheel_speeds)


def _row_figure(name: str, form: Form, axis: int) -> Figure:
    return Figure(name, returned(LAYOUT_A.fit, LAYOUT_A.wheel_speeds)[axis], _returned_a(form)[axis])


ROWS = (
    Row(
        1, "000", "layout a, the code: dy",
        "dy = (da - db / SIN30f - dc / SIN30f) / 3", "dy = (2 da - db - dc) / 3", _row_1,
    ),
    Row(
        2, "000", "layout a, the text: Dx",
        "Dx = (- Db * cos(30°) + Dc / cos(30°)) / 2", "Dx = (Dc - Db) / sqrt(3)", _row_2,
    ),
    Row(
        3, "000", "layout a, the text: Dy",
        "Dy = (- Db * sin(30°) - Dc / sin(30°) + Da) / 3", "Dy = (2 Da - Db - Dc) / 3", _row_3,
    ),
    Row(
        4, "000", "layout b, the text: Dy",
        "Dy = (-Da + Db / sin(30°) + Dc / sin(30°)) / 3", "Dy = (-2 Da + Db + Dc) / 3", _row_4,
    ),
    Row(5, "000", "the code: dx, dy, dtheta", CODE_LINES_AS_PRINTED[0], CODE_LINES_AS_PRINTED[0] + ";", _row_5),
    Row(
        6, "000", "the code: the first call",
        "static float wheel_odometer[3]; da = current_wheel_odometer[0] - wheel_odometer[0]",
        "the first call sets the reference and reports no motion", _row_6,
    ),
    Row(
        7, "000", "the answer's number format",
        "base_dx_mm_q16 = (_s32)(dx * 1000 * 65536)", "increments only, never totals; clamped", _row_7,
    ),
    Row(
        8, "000", "the answer's meaning",
        "(dx, dy mm, dtheta): not said whether chord or arc, old or new frame",
        "frame at the start of the increment, exact arc", _row_8,
    ),
)  # fmt: skip
