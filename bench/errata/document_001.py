"""Document 001, rows 9 to 16: motor output equations of omni and mecanum bases, and the fast sine.

Wheel speeds are rim speeds; R = 0.15 m and k = lx + ly = 0.22 m, which the document leaves to its reader.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from bench.as_printed.document_001 import (
    ANGLE_TO_RADIAN,
    BEARINGS_3_DEG,
    BEARINGS_4_DEG,
    EXACT,
    FAST,
    Trig,
    four_wheels_as_printed,
    mecanum_as_printed,
    my_cos_as_printed,
    my_sin_as_printed,
    three_wheels_as_printed,
    three_wheels_detailed_as_printed,
)
from bench.config import Robot, Wheel
from bench.errata.algebra import Vector, rows_of, tangential, worst
from bench.errata.trial import field_centric, robot_for, settled
from bench.errata.values import PLANT, Evidence, Figure, Row
from bench.kinematics import Kinematics, rotate_into_body, twist_from_document_002
from bench.messages import BodyTwist
from bench.odometry import wrap

Form = Callable[[float, float, float, float, Trig], list[float]]

RADIUS_M = 0.15
HALF_LENGTH_M, HALF_WIDTH_M = 0.12, 0.10
SINE_POINTS = 20_001

THREE = tangential(BEARINGS_3_DEG, RADIUS_M, clockwise=True)
FOUR = tangential(BEARINGS_4_DEG, RADIUS_M, clockwise=True)
MECANUM = Kinematics(
    [
        Wheel("front left", HALF_LENGTH_M, HALF_WIDTH_M, 0.0, 1.0, can_id=1, roller_rad=-math.pi / 4),
        Wheel("front right", HALF_LENGTH_M, -HALF_WIDTH_M, math.pi, 1.0, can_id=2, roller_rad=math.pi / 4),
        Wheel("rear right", -HALF_LENGTH_M, -HALF_WIDTH_M, math.pi, 1.0, can_id=3, roller_rad=-math.pi / 4),
        Wheel("rear left", -HALF_LENGTH_M, HALF_WIDTH_M, 0.0, 1.0, can_id=4, roller_rad=math.pi / 4),
    ]
)


def right_wheels(base: Kinematics, lever_m: float, x: float, y: float, z: float, heading_deg: float) -> list[float]:
    """The wheel speeds of a field command (x right, y forward, z = lever x omega) at a heading, counter-clockwise."""
    vx_field, vy_field, omega = twist_from_document_002(x, y, z / lever_m)
    return base.wheel_speeds((*rotate_into_body(vx_field, vy_field, math.radians(heading_deg)), omega))


def field_motion(base: Kinematics, wheels: Vector, heading_deg: float) -> tuple[float, float, float]:
    """What these wheels do to a base at a heading: (right, forward, counter-clockwise) in the field."""
    vx, vy, omega = base.fit(wheels)
    vx_field, vy_field = rotate_into_body(vx, vy, -math.radians(heading_deg))
    return -vy_field, vx_field, omega


def _row_9() -> Evidence:
    facing = [
        Figure(f"facing {heading:.0f} deg: direction off by", (0.0,), (_direction_error_deg(heading),), "deg")
        for heading in (10.0, 45.0, 90.0)
    ]
    right = rows_of(lambda command: right_wheels(MECANUM, HALF_LENGTH_M + HALF_WIDTH_M, *_xyz(command), 30.0))
    printed = rows_of(lambda command: mecanum_as_printed(*_xyz(command), -30.0, EXACT))
    # Row 12: translation comes out times cos 45. What is left is the sense of the heading.
    off = worst([row[:2] for row in right], [(row[0] * math.sqrt(2), row[1] * math.sqrt(2)) for row in printed])
    return Evidence(
        (
            *facing,
            Figure("mecanum equations, facing 30 deg: rows off by", (0.0,), (off,)),
            *_driven_facing_90(three_wheels_as_printed, -1.0),
        ),
        "Field-centric driving turns the wrong way, by twice the heading: facing 90 deg, forward is backward. The "
        "mecanum equations do want it clockwise, so one gyroscope cannot serve both as the text has it.",
    )


def _driven_facing_90(form: Form, sense: float) -> tuple[Figure, ...]:
    """A robot that faces 90 degrees is asked to go field forward: by the right equations, and by a form."""
    right = _driven_to_the_field(three_wheels_as_printed, EXACT, 90.0, 90.0)
    printed = _driven_to_the_field(form, FAST, 90.0, 90.0, sense)
    name = "facing 90 deg, 0.3 m/s field forward for 1.5 s: forward, left, turned"
    return (Figure(name, right, printed, "m, m, deg", PLANT),)


def _driven_to_the_field(
    form: Form, trig: Trig, heading_deg: float, gyro_deg: float, sense: float = 1.0
) -> tuple[float, float, float]:
    """Field forward at 0.3 m/s for 1.5 s, field-centric: (forward m, left m, turned deg) in the field."""
    robot = robot_for("omni3")
    radius_m = robot.wheels[0].radius_m

    def wheels(gyro_rad: float) -> list[float]:
        return [rim / radius_m for rim in form(0.0, 0.3, 0.0, sense * math.degrees(gyro_rad), trig)]

    pose, turned_rad = field_centric(robot, wheels, 1500, math.radians(heading_deg), math.radians(gyro_deg))
    return pose.x_m, pose.y_m, math.degrees(turned_rad)


def _direction_error_deg(heading_deg: float) -> float:
    """Field forward asked for with a heading that counts clockwise, as the text says."""
    right, forward, _ = field_motion(THREE, three_wheels_as_printed(0.0, 1.0, 0.0, -heading_deg, EXACT), heading_deg)
    return abs(math.degrees(math.atan2(-right, forward)))


def _row_10() -> Evidence:
    def error(heading: float) -> float:
        right = rows_of(lambda command: right_wheels(THREE, RADIUS_M, *_xyz(command), heading))
        return worst(right, rows_of(lambda c: three_wheels_detailed_as_printed(*_xyz(c), heading, EXACT)))

    driven = field_motion(THREE, three_wheels_detailed_as_printed(0.0, 1.0, 0.0, 90.0, EXACT), 90.0)
    return Evidence(
        (
            Figure("worst row, facing 30 deg", (0.0,), (error(30.0),)),
            Figure("worst row, facing 90 deg", (0.0,), (error(90.0),)),
            Figure("facing 90 deg, 1 m/s field forward: right, forward, yaw", (0.0, 1.0, 0.0), driven, "m/s, rad/s"),
            *_driven_facing_90(three_wheels_detailed_as_printed, 1.0),
        ),
        f'Right while the robot faces forward. Turned by 90 deg, "forward" drives it backward at {abs(driven[1]):.2f} '
        f"of the speed and spins it at {abs(driven[2]):.1f} rad/s for each m/s.",
    )


def _row_11() -> Evidence:
    forward = four_wheels_as_printed(0.0, 1.0, 0.0, 0.0, EXACT)
    sideways = four_wheels_as_printed(1.0, 0.0, 0.0, 0.0, EXACT)
    right = right_wheels(FOUR, RADIUS_M, 0.0, 1.0, 0.0, 0.0)
    slip = max(map(abs, FOUR.slip(forward)))
    asked = BodyTwist(0.3, 0.0, 0.0)
    loop, plant = (settled(robot, asked, 2000) for robot in _both("omni4", "document-001-four-as-printed"))
    printed_row = rows_of(lambda command: four_wheels_as_printed(*_xyz(command), 0.0, EXACT))[2]
    right_row = rows_of(lambda command: right_wheels(FOUR, RADIUS_M, *_xyz(command), 0.0))[2]
    return Evidence(
        (
            Figure("row of wheel 3", right_row, printed_row),
            Figure("y = 1: speed of wheel 3", (right[2],), (forward[2],), "m/s"),
            Figure("y = 1 drives: right, forward, R yaw", (0.0, 1.0, 0.0), _rim_motion(forward), "m/s"),
            Figure("y = 1: every contact slips by", (0.0,), (slip,), "m/s"),
            Figure("x = 1 drives: right, forward, R yaw", (1.0, 0.0, 0.0), _rim_motion(sideways), "m/s"),
            Figure("0.3 m/s forward asked: forward, left, yaw", loop.twist, plant.twist, "m/s, rad/s", PLANT),
            Figure("the same: largest current", (_most(loop.currents_a),), (_most(plant.currents_a),), "A", PLANT),
        ),
        f"One wheel stands still in straight travel: the robot drives {_angle_deg(_rim_motion(forward)):.0f} deg "
        f"off to the left, turns, and drags all four wheels at {slip:.2f} of its speed: "
        f"{_most(plant.currents_a):.1f} A where {_most(loop.currents_a):.2f} A would do.",
    )


def _most(values: Vector) -> float:
    return max(map(abs, values))


def _both(robot: str, controller: str) -> tuple[Robot, Robot]:
    return robot_for(robot), robot_for(robot, controller=controller)


def _rim_motion(wheels: Vector) -> tuple[float, float, float]:
    right, forward, omega = field_motion(FOUR, wheels, 0.0)
    return right, forward, RADIUS_M * omega


def _angle_deg(motion: Vector) -> float:
    return abs(math.degrees(math.atan2(motion[0], motion[1])))


def _row_12() -> Evidence:
    lever_m = HALF_LENGTH_M + HALF_WIDTH_M
    runs = [
        settled(robot, BodyTwist(0.3, 0.0, 1.0), 2000) for robot in _both("mecanum", "document-001-mecanum-as-printed")
    ]
    radii = [run.twist.vx_mps / run.twist.omega_radps for run in runs]
    _, forward, yaw = field_motion(MECANUM, mecanum_as_printed(0.0, 1.0, lever_m, 0.0, EXACT), 0.0)
    return Evidence(
        (
            Figure("1 m/s and 1 rad/s: forward, yaw", (1.0, 1.0), (forward, yaw), "m/s, rad/s"),
            Figure("yaw over translation", (1.0,), (yaw / forward,)),
            Figure("0.3 m/s and 1 rad/s asked: radius of the circle", (radii[0],), (radii[1],), "m", PLANT),
        ),
        f"A circle of 1 m radius becomes one of {forward / yaw:.2f} m, unless z is scaled by cos 45 as well.",
    )


def _row_13() -> Evidence:
    step = 540.0 / (SINE_POINTS - 1)
    angles = [math.radians(-180.0 + step * n) for n in range(SINE_POINTS)]
    sines = [my_sin_as_printed(angle) for angle in angles]
    cosines = [my_cos_as_printed(angle) for angle in angles]
    off = max(abs(sine - math.sin(angle)) for sine, angle in zip(sines, angles, strict=True))
    off = max(off, *(abs(cosine - math.cos(angle)) for cosine, angle in zip(cosines, angles, strict=True)))
    turned = max(abs(wrap(math.atan2(s, c) - a)) for s, c, a in zip(sines, cosines, angles, strict=True))
    excess = [s * s + c * c - 1.0 for s, c in zip(sines, cosines, strict=True)]
    return Evidence(
        (
            Figure("largest error, -180 to 360 deg", (0.0,), (off,)),
            Figure("largest error of a direction", (0.0,), (math.degrees(turned),), "deg"),
            Figure("sin^2 + cos^2 - 1, least and most", (0.0, 0.0), (min(excess), max(excess))),
        ),
        f"Hardly any: {1000 * 10 * turned:.0f} mm aside in 10 m.",
    )


def _row_14() -> Evidence:
    def figure(name: str, right: Callable[[float], float], printed: Callable[[float], float], degrees: float) -> Figure:
        angle = math.radians(degrees)
        return Figure(f"{name}({degrees:.0f} deg)", (right(angle),), (printed(angle),))

    return Evidence(
        (
            *(figure("sin", math.sin, my_sin_as_printed, degrees) for degrees in (-240.0, -300.0, -450.0)),
            figure("cos", math.cos, my_cos_as_printed, -300.0),
        ),
        "60 - ang leaves the range after 240 deg of heading. After 510 deg a wheel is asked for "
        f"{my_sin_as_printed(math.radians(60.0 - 510.0)):.0f} times its speed.",
    )


def _row_15() -> Evidence:
    printed = three_wheels_as_printed(0.0, 1.0, 0.0, -300.0, FAST)
    right = right_wheels(THREE, RADIUS_M, 0.0, 1.0, 0.0, -300.0)
    runs = [_driven_to_the_field(three_wheels_as_printed, trig, 60.0, -300.0) for trig in (EXACT, FAST)]
    return Evidence(
        (
            Figure("heading -300 deg: y factor of motor 1", (right[0],), (printed[0],)),
            Figure("0.3 m/s field forward for 1.5 s: forward, left, turned", runs[0], runs[1], "m, m, deg", PLANT),
        ),
        f"After most of a turn clockwise, motor 1 is asked for {printed[0] / right[0]:.1f} times its speed. The text "
        "promises -180 to 180; the argument is called relative distance and accumulates.",
    )


def _row_16() -> Evidence:
    relative = ANGLE_TO_RADIAN / (math.pi / 180.0) - 1.0
    return Evidence(
        (
            Figure("relative error", (0.0,), (relative,)),
            Figure("a turn of heading, in degrees", (360.0,), (360.0 * (1.0 + relative),), "deg"),
        ),
        f"A heading that is never wrapped loses {-360.0 * relative:.3f} deg a turn; wrapped, at most half of that.",
    )


def _xyz(command: Vector) -> tuple[float, float, float]:
    x, y, z = command
    return x, y, z


ROWS = (
    Row(
        9, "001", "the text below the code: the heading's sense",
        "omni: cos(60 + ang) x + sin(60 + ang) y - z, ang clockwise positive",
        "ang counter-clockwise positive for omni wheels, clockwise for mecanum", _row_9,
    ),
    Row(
        10, "001", 'three wheels, the "detailed" lines: motor 3',
        "-cos(0 - ang) x - sin(0 - ang) y - z", "-cos(0 + ang) x - sin(0 + ang) y - z", _row_10,
    ),
    Row(
        11, "001", "four omni wheels, the code: c", "c = (a - b)*0.5f, which is ang", "c = a, which is 60 + ang",
        _row_11,
    ),
    Row(
        12, "001", "mecanum: translation and rotation",
        "cos(45 - ang) x + sin(45 - ang) y - z", "the same times sqrt(2), or z times cos 45", _row_12,
    ),
    Row(
        13, "001", "the fast sine: accuracy",
        "1.27323954 rad - 0.405284735 rad |rad|, then 0.225 of its square", "sin, cos of the C library", _row_13,
    ),
    Row(
        14, "001", "the fast sine: range", "while(rad > 2*ONE_PI), and nothing for rad < -ONE_PI", "wrap first",
        _row_14,
    ),
    Row(15, "001", "the heading's range", "ang_motion=imu[z].Relative_Dist", "wrap to -180..180 degrees", _row_15),
    Row(16, "001", "degrees to radians", "angle_to_radian = 0.01745f", "pi/180 = 0.017453293", _row_16),
)  # fmt: skip
