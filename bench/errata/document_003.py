"""Document 003, row 21: a textbook page whose results hold and whose scan lost signs."""

from __future__ import annotations

from bench.as_printed.document_003 import (
    BEARINGS_DEG,
    EXAMPLE_RESULT,
    EXAMPLE_WHEELS,
    Matrix,
    inverse_j1f_as_printed,
    inverse_j1f_scan_as_printed,
    j1f_as_printed,
)
from bench.errata.algebra import AXES, Vector, returned, tangential, worst
from bench.errata.trial import robot_for, settled
from bench.errata.values import PLANT, Evidence, Figure, Row
from bench.messages import BodyTwist

BASE = tangential(BEARINGS_DEG, 1.0, clockwise=True)


def times(matrix: Matrix, vector: Vector) -> tuple[float, ...]:
    """Matrix times vector."""
    x, y, w = vector
    return tuple(row[0] * x + row[1] * y + row[2] * w for row in matrix)


def _row_21() -> Evidence:
    j1f, inverse, scan = j1f_as_printed(), inverse_j1f_as_printed(), inverse_j1f_scan_as_printed()

    def off(forward: Matrix) -> float:
        return worst(returned(lambda wheels: times(forward, wheels), lambda twist: times(j1f, twist)), AXES)

    read = times(scan, EXAMPLE_WHEELS)
    robot = robot_for("siegwart")
    plant = settled(robot, BodyTwist(*(0.1 * value for value in EXAMPLE_RESULT)), 3000)
    driven_rims = tuple(
        speed * wheel.radius_m for speed, wheel in zip(plant.wheel_speeds_radps, robot.wheels, strict=True)
    )
    rims = tuple(0.1 * value for value in EXAMPLE_WHEELS)
    return Evidence(
        (
            Figure("3.32 against the wheel equation, off by", (0.0,), (worst(j1f, BASE.inverse_rows),)),
            Figure("3.33 times 3.32 against 1, off by", (0.0,), (off(inverse),)),
            Figure("3.34: wheels (4, 1, 2) drive", EXAMPLE_RESULT, times(inverse, EXAMPLE_WHEELS), "m/s, rad/s"),
            Figure("a tenth of that motion asked: rims", rims, driven_rims, "m/s", PLANT),
            Figure("3.33 as scanned, off by", (0.0,), (off(scan),)),
            Figure("3.34 by 3.33 as scanned", EXAMPLE_RESULT, read, "m/s, rad/s"),
        ),
        f"The book is right. Who types in the scan has a robot that turns at {read[2]:.2f} instead of "
        f"{EXAMPLE_RESULT[2]:.2f} rad/s in its odometry.",
    )


ROWS = (
    Row(
        21, "003", "equations 3.32 to 3.34, as scanned", "-1/3l  1/3l  -1/3l, one minus on a line of its own",
        "-1/3l  -1/3l  -1/3l; every printed result holds", _row_21, holds=True,
    ),
)  # fmt: skip
