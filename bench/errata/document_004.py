"""Document 004, rows 22 to 28: the M2006 robot. Twists stand in its own frame: right, forward, clockwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from bench.as_printed.document_004 import (
    BEARINGS_DEG,
    FIRMWARE_FORCE_VECTORS,
    FIRMWARE_LABELS_DEG,
    MAX_CURRENT_A,
    MAX_LINEAR_MPS,
    RADIUS_M,
    WHEEL_RADIUS_M,
    firmware_wheels_as_printed,
    forward_as_printed,
    inverse_as_printed,
)
from bench.config import Robot, load_robot
from bench.controller import control_of
from bench.errata.algebra import Vector, returned, rows_of, tangential, worst
from bench.errata.trial import drive, pushed, robot_for, settled
from bench.errata.values import PLANT, Evidence, Figure, Row
from bench.kinematics import Kinematics, singular_values, twist_from_document_004
from bench.messages import ZERO_TWIST, BodyTwist

BEARINGS_RAD = tuple(map(math.radians, BEARINGS_DEG))
NAME_22 = "inverse-004-as-printed"
EVEN_DEG = (0.0, 120.0, 240.0)
BASE = tangential(BEARINGS_DEG, RADIUS_M, clockwise=True, radius_m=WHEEL_RADIUS_M)
EVEN = tangential(EVEN_DEG, RADIUS_M, clockwise=True, radius_m=WHEEL_RADIUS_M)


def right_inverse(twist: Vector) -> list[float]:
    """Twist in the document's frame -> wheel speeds, by the wheel equation: rows (cos, sin, L)/r."""
    return BASE.wheel_speeds(twist_from_document_004(*twist))


def right_forward(wheels: Vector, base: Kinematics = BASE) -> tuple[float, float, float]:
    """Wheel speeds -> twist in the document's frame."""
    vx, vy, omega = base.fit(wheels)
    return -vy, vx, -omega


def _printed_inverse(twist: Vector, bearings_rad: Sequence[float] = BEARINGS_RAD) -> list[float]:
    vx, vy, omega = twist
    return inverse_as_printed(vx, vy, omega, bearings_rad)


def _firmware(twist: Vector) -> list[float]:
    vx, vy, omega = twist
    return firmware_wheels_as_printed(vx, vy, omega)


def _row_22() -> Evidence:
    to_right = right_forward(_printed_inverse((1.0, 0.0, 0.0)))
    ahead = right_forward(_printed_inverse((0.0, 1.0, 0.0)))
    return Evidence(
        (
            Figure("1 m/s right drives: right, forward, yaw", (1.0, 0.0, 0.0), to_right, "m/s, rad/s"),
            Figure("1 m/s forward drives: right, forward, yaw", (0.0, 1.0, 0.0), ahead, "m/s, rad/s"),
            Figure("0.3 m/s right asked for 2 s: forward, left", _driven_right(), _driven_right(NAME_22), "m", PLANT),
        ),
        "It is the right matrix with x and y exchanged: asked to go right the robot goes forward, and the reverse.",
    )


def _driven_right(controller: str | None = None) -> tuple[float, float]:
    run = drive(robot_for("m2006", controller=controller), BodyTwist(0.0, -0.3, 0.0), ticks=2000)
    return run.pose[:2]


def _row_23() -> Evidence:
    f_h = returned(lambda wheels: forward_as_printed(wheels, BEARINGS_RAD), _printed_inverse)
    right = returned(right_forward, right_inverse)
    twist = BodyTwist(0.3, 0.0, 0.0)
    pair = robot_for("m2006", controller=NAME_22, odometry="forward-004-as-printed")
    told = [math.degrees(drive(robot, twist, ticks=2000).believed_turned_rad) for robot in (robot_for("m2006"), pair)]
    read = forward_as_printed(_printed_inverse((0.0, 1.0, 0.0)), BEARINGS_RAD)
    alone = forward_as_printed(right_inverse((0.0, 1.0, 0.0)), BEARINGS_RAD)
    return Evidence(
        (
            *(Figure(f"row {name} of F H", a, b) for name, a, b in zip(("vx", "vy", "yaw"), right, f_h, strict=True)),
            Figure("1 m/s forward reads back: right, forward, yaw", (0.0, 1.0, 0.0), read, "m/s, rad/s"),
            Figure("the same, wheels by the right inverse", (0.0, 1.0, 0.0), alone, "m/s, rad/s"),
            Figure("0.3 m/s forward asked for 2 s, with row 22: turn told", (told[0],), (told[1],), "deg", PLANT),
        ),
        f"Asked for 1 m/s forward, the printed pair drives right (row 22) and reads {read[1]:.3f} m/s forward and a "
        f"spin of {read[2]:.2f} rad/s. A robot that truly goes forward is read as going right, at {alone[0]:.3f} m/s.",
    )


def _row_24() -> Evidence:
    even_rad = tuple(map(math.radians, EVEN_DEG))
    f_h = returned(lambda wheels: forward_as_printed(wheels, even_rad), lambda twist: _printed_inverse(twist, even_rad))
    diagonal = (f_h[0][0], f_h[1][1], f_h[2][2])
    return Evidence(
        (Figure("diagonal of F H, wheels 120 deg apart", (1.0, 1.0, 1.0), diagonal),),
        f"Even where the wheels stand evenly, {diagonal[0]:.0%} of the way is counted: translation wants 2r/3.",
    )


def _row_25() -> Evidence:
    first, second, third = BEARINGS_DEG[2], BEARINGS_DEG[1], BEARINGS_DEG[0] + 360.0
    gaps = (second - first, third - second, first + 360.0 - third)
    push = BASE.wrench((-0.1, -0.1, -0.1))  # counter-clockwise, as section 3.5 of the kinematics reference counts
    even = EVEN.wrench((-0.1, -0.1, -0.1))
    robot = load_robot("m2006")
    bases = (_evenly(robot), robot)
    straight, aside = (pushed(base, (2.0, 2.0, 2.0), 300).vy_mps for base in bases)
    weak = [pushed(base, (MAX_CURRENT_A,) * 3, 300).vy_mps for base in bases]
    return Evidence(
        (
            Figure("between neighbours", (120.0, 120.0, 120.0), gaps, "deg"),
            Figure("condition of the matrix", (_condition(EVEN),), (_condition(BASE),)),
            Figure("0.1 N m on every wheel: forward, left, yaw", even, push, "N, N m"),
            Figure("2 A in every motor for 0.3 s: left", (straight,), (aside,), "m/s", PLANT),
            Figure("0.6 A in every motor for 0.3 s: left", (weak[0],), (weak[1],), "m/s", PLANT),
        ),
        f"Equal torques turn a 120 degree base on the spot; this one they push sideways by {abs(push[1]):.2f} N too. "
        "At 0.6 A the inertia of the rotors and the rolling resistance take all of it.",
    )


def _evenly(robot: Robot) -> Robot:
    """The same robot on wheels 120 degrees apart, the rear one where it was."""
    wheels = []
    for wheel, bearing_deg in zip(robot.wheels, (-60.0, 180.0, 60.0), strict=True):
        bearing_rad = math.radians(bearing_deg)
        x_m, y_m = RADIUS_M * math.cos(bearing_rad), RADIUS_M * math.sin(bearing_rad)
        wheels.append(replace(wheel, x_m=x_m, y_m=y_m, heading_rad=bearing_rad + math.pi / 2))
    return replace(robot, wheels=tuple(wheels))


def _condition(base: Kinematics) -> float:
    values = singular_values(base.axes, base.length_m)
    return values[0] / values[2]


def _row_26() -> Evidence:
    loop, printed = robot_for("m2006"), robot_for("m2006", controller="current-as-printed")
    figures = []
    for asked_mps in (0.2, 0.3, 0.5):
        speeds = [settled(robot, BodyTwist(asked_mps, 0.0, 0.0)).twist.vx_mps for robot in (loop, printed)]
        figures.append(Figure(f"{asked_mps} m/s forward asked: settles at", (speeds[0],), (speeds[1],), "m/s", PLANT))
    turns = [settled(robot, BodyTwist(0.0, 0.0, 2.0)).twist.omega_radps for robot in (loop, printed)]
    figures.append(Figure("2 rad/s asked: settles at", (turns[0],), (turns[1],), "rad/s", PLANT))
    diagonal = [settled(robot, BodyTwist(0.3, 0.3, 0.0)).twist for robot in (loop, printed)]
    ways = [(math.degrees(math.atan2(twist.vy_mps, twist.vx_mps)), twist.omega_radps) for twist in diagonal]
    figures.append(Figure("0.3 m/s both ways asked: direction, yaw", ways[0], ways[1], "deg, rad/s", PLANT))
    stops = [settled(robot, ZERO_TWIST, 1500, BodyTwist(0.5, 0.0, 0.0)).pose.x_m for robot in (loop, printed)]
    figures.append(Figure("pushed at 0.5 m/s, 0 asked: rolls on", (stops[0],), (stops[1],), "m", PLANT))
    holding = [_holding_nm(robot) for robot in (loop, printed)]
    figures.append(Figure("standing, a wheel forced to 1 rad/s: torque", (holding[0],), (holding[1],), "N m"))
    return Evidence(
        tuple(figures),
        f"The speed is what friction leaves of the current: {ways[1][0]:.0f} deg where 45 deg is asked, nothing at all "
        "for a slow command, and no force against a push.",
    )


def _holding_nm(robot: Robot) -> float:
    _, controller = control_of(robot, Kinematics(robot.wheels))
    currents = controller.step([0.0] * len(robot.wheels), [1.0] + [0.0] * (len(robot.wheels) - 1))
    return -currents[0] * robot.motor.torque_nm_per_a


def _row_27() -> Evidence:
    robot = robot_for("m2006")
    asked = BodyTwist(MAX_LINEAR_MPS, 0.0, 0.0)
    reached = settled(robot, asked).twist.vx_mps
    more_a = MAX_CURRENT_A + 0.2
    more = settled(replace(robot, limits=replace(robot.limits, current_a=more_a)), asked).twist.vx_mps
    # Losses are Coulomb and viscous: speed rises with current along a line.
    needed_a = MAX_CURRENT_A + (MAX_LINEAR_MPS - reached) * (more_a - MAX_CURRENT_A) / (more - reached)
    return Evidence(
        (
            Figure("1.0 m/s forward asked, 0.6 A: settles at", (MAX_LINEAR_MPS,), (reached,), "m/s", PLANT),
            Figure("current for 1.0 m/s forward", (needed_a,), (MAX_CURRENT_A,), "A", PLANT),
        ),
        f"Full stick gives {reached:.2f} m/s: the two limits of the document cannot both be.",
    )


def _row_28() -> Evidence:
    right = rows_of(right_inverse)
    printed = rows_of(_firmware)
    angles = tuple(math.degrees(math.atan2(-x, y)) for x, y in FIRMWARE_FORCE_VECTORS)
    worst_part = worst(right, printed) * WHEEL_RADIUS_M
    return Evidence(
        (
            *(Figure(f"row of wheel {n}", a, b) for n, (a, b) in enumerate(zip(right, printed, strict=True), start=1)),
            Figure("force vectors, counter-clockwise from y", angles, FIRMWARE_LABELS_DEG, "deg"),
        ),
        f"None: the rows are right to {worst_part:.1e} (cosines cut after three digits). Who believes the comments and "
        "computes the vectors from the angles gets left and right exchanged.",
    )


ROWS = (
    Row(
        22, "004", "inverse kinematics", "1/r (vx sin(theta) + vy cos(theta) + L omega)",
        "1/r (vx cos(theta) + vy sin(theta) + L omega)", _row_22,
    ),
    Row(
        23, "004", "forward kinematics", "r/3 [sin(theta); cos(theta); 1/L]", "the inverse of the right matrix",
        _row_23,
    ),
    Row(
        24, "004", "forward kinematics, at 120 degrees", "r/3 [sin(theta); cos(theta); 1/L]", "2r/3, 2r/3, r/(3L)",
        _row_24,
    ),
    Row(
        25, "004", "wheel installation angles", "-75, 180, 75: similar to a traditional three wheel setup",
        "105, 105 and 150 degrees apart", _row_25,
    ),
    Row(
        26, "004", "current mapping", "I = omega / omega_max I_max", "a speed loop a wheel", _row_26,
    ),
    Row(
        27, "004", "limits", "maximum current 0.6 A, maximum linear velocity 1.0 m/s",
        "0.6 A for what it reaches, or the current that 1.0 m/s needs", _row_27,
    ),
    Row(
        28, "004", "the firmware's comments", "force vectors -15, 90, -165 deg counterclockwise from +y",
        "the same clockwise; cosine and sine named the other way round", _row_28, holds=True,
    ),
)  # fmt: skip
