"""A run with a printed form in the place of the right one, on purpose: `--controller NAME`, `--odometry NAME`.

A form belongs to a layout of wheels. What a robot's wheels are is read from its kinematics: a wheel that feels the
line (ax, ay) with a moment about the origin is a tangential wheel at that distance, whatever its file calls it. Frames
and signs are turned here, so that a form fails by its own fault and by nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

from bench.as_printed import document_000, document_001, document_002, document_004
from bench.config import Robot
from bench.controller import Controller, Inverse, speed_controller
from bench.errors import UsageError
from bench.kinematics import Kinematics, Row, rotate_into_body
from bench.odometry import Odometry, wrap

SAME_ANGLE_RAD = math.radians(0.01)
SAME_LENGTH = 1e-6


class Tangential(NamedTuple):
    """Tangential wheels: bearings counter-clockwise from forward, one distance and one radius for all."""

    bearings_rad: tuple[float, ...]
    distance_m: float
    radius_m: float
    clockwise: tuple[float, ...]
    """Times a speed in the wheel's own sense: the speed along its clockwise tangent."""


def tangential(kinematics: Kinematics) -> Tangential | None:
    """What this base is as a tangential one; None where its wheels differ in distance or radius."""
    rows, radii = kinematics.axes, kinematics.radii
    distance_m, radius_m = abs(rows[0][2]), radii[0]
    if any(abs(abs(moment) - distance_m) > SAME_LENGTH for _, _, moment in rows) or distance_m == 0.0:
        return None
    if any(abs(radius - radius_m) > SAME_LENGTH for radius in radii):
        return None
    bearings = tuple(wrap(math.atan2(ay, ax) - math.copysign(math.pi / 2, moment)) for ax, ay, moment in rows)
    return Tangential(bearings, distance_m, radius_m, tuple(-math.copysign(1.0, moment) for _, _, moment in rows))


def fitting(
    name: str, robot: Robot, kinematics: Kinematics, bearings_deg: Sequence[float] | None, count: int
) -> Tangential:
    """The layout of a base that a form can be used on. Raises UsageError with what the form is for."""
    found = tangential(kinematics)
    if found is not None and len(found.bearings_rad) == count:
        if bearings_deg is None:
            return found
        pairs = zip(found.bearings_rad, bearings_deg, strict=True)
        if all(abs(wrap(has - math.radians(wants))) < SAME_ANGLE_RAD for has, wants in pairs):
            return found
    at = "" if bearings_deg is None else f" at {', '.join(f'{bearing:g}' for bearing in bearings_deg)} degrees"
    raise UsageError(
        f"{name}: is for {count} tangential wheels of one size{at}, in this order, and {robot.name} has others; "
        "give another --robot (`wheelbench robots` lists them)"
    )


class CurrentAsPrinted:
    """Document 004: current proportional to the wanted wheel speed, whatever the wheel does. Row 26."""

    __slots__ = ("_max_a", "_max_radps")

    def __init__(self, robot: Robot) -> None:
        self._max_radps = robot.limits.wheel_radps
        self._max_a = robot.limits.current_a

    def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
        """Currents for this tick."""
        return [document_004.current_as_printed(wanted, self._max_radps, self._max_a) for wanted in wanted_radps]

    def reset(self) -> None:
        """There is nothing to forget."""


class Inverse004AsPrinted:
    """Document 004: rows (sin, cos, L), radial where they have to be tangential. Row 22."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        self._layout = fitting("inverse-004-as-printed", robot, kinematics, None, 3)

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s."""
        vx, vy, omega = twist
        bearings, distance_m, radius_m, clockwise = self._layout
        printed = document_004.inverse_as_printed(-vy, vx, -omega, bearings, distance_m, radius_m)
        return [sign * speed for sign, speed in zip(clockwise, printed, strict=True)]


class ThreeWheels001AsPrinted:
    """Document 001, three omni wheels: it turns the command into the body itself, by a heading that is not wrapped.

    The compact code takes the heading as the text has it, clockwise: row 9. The "detailed" lines take it in the sense
    that theirs want, so that what is wrong is their own: row 10. Both by the fast sine: rows 13 to 15.
    """

    FORMS: ClassVar[dict[str, tuple[Callable[[float, float, float, float], list[float]], float]]] = {
        "document-001-three-as-printed": (document_001.three_wheels_as_printed, -1.0),
        "document-001-three-detailed-as-printed": (document_001.three_wheels_detailed_as_printed, 1.0),
    }

    def __init__(self, robot: Robot, kinematics: Kinematics, field_heading_rad: Callable[[], float]) -> None:
        name, bearings_deg = robot.control.kind, document_001.BEARINGS_3_DEG
        self._form, self._sense = self.FORMS[name]
        self._layout = fitting(name, robot, kinematics, bearings_deg, len(bearings_deg))
        self._heading_rad = field_heading_rad

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s; the twist is turned back into the field, where the form expects it."""
        vx, vy, omega = twist
        heading_rad = self._heading_rad()
        vx_field, vy_field = rotate_into_body(vx, vy, -heading_rad)
        _, distance_m, radius_m, clockwise = self._layout
        heading_deg = self._sense * math.degrees(heading_rad)
        printed = self._form(-vy_field, vx_field, distance_m * omega, heading_deg)
        return [sign * speed / radius_m for sign, speed in zip(clockwise, printed, strict=True)]


class FourWheels001AsPrinted:
    """Document 001, four omni wheels, the compact code: the third wheel's angle is another robot's. Row 11."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        bearings_deg = document_001.BEARINGS_4_DEG
        self._layout = fitting("document-001-four-as-printed", robot, kinematics, bearings_deg, len(bearings_deg))

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s; a field-centric command has been turned before, so the heading is 0 here."""
        vx, vy, omega = twist
        _, distance_m, radius_m, clockwise = self._layout
        printed = document_001.four_wheels_as_printed(-vy, vx, distance_m * omega, 0.0)
        return [sign * speed / radius_m for sign, speed in zip(clockwise, printed, strict=True)]


class Mecanum001AsPrinted:
    """Document 001, mecanum wheels: translation comes out times cos 45, rotation does not. Row 12."""

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        root2 = math.sqrt(2.0)
        rows = [(root2 * ax, root2 * ay, root2 * moment) for ax, ay, moment in kinematics.axes]
        self._lever_m = -rows[0][2]
        self._radius_m = root2 * kinematics.radii[0]
        wanted = [(1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
        fits = len(rows) == len(wanted) and all(
            math.dist(row, (x, y, -self._lever_m)) < SAME_LENGTH for row, (x, y) in zip(rows, wanted, strict=True)
        )
        if not fits or any(abs(radius - kinematics.radii[0]) > SAME_LENGTH for radius in kinematics.radii):
            raise UsageError(
                "document-001-mecanum-as-printed: is for four mecanum wheels of one size (front left, front right, "
                f"rear right, rear left, the right side mirrored), and {robot.name} has others; try --robot mecanum"
            )

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s."""
        vx, vy, omega = twist
        printed = document_001.mecanum_as_printed(-vy, vx, self._lever_m * omega, 0.0)
        return [speed / self._radius_m for speed in printed]


class Forward004AsPrinted(Odometry):
    """Document 004: r/3 times the transpose, which undoes nothing. Rows 23 and 24."""

    __slots__ = ("_layout",)

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        super().__init__(kinematics)
        self._layout = fitting(robot.odometry, robot, kinematics, None, 3)

    def advance(self, increments_rad: Sequence[float]) -> None:
        """Move by what the wheels turned, as the document reads it."""
        bearings, distance_m, radius_m, clockwise = self._layout
        turned = [sign * increment for sign, increment in zip(clockwise, increments_rad, strict=True)]
        right, forward, turn = document_004.forward_as_printed(turned, bearings, distance_m, radius_m)
        self.move(forward, -right, -turn)


class Forward000AsPrinted(Odometry):
    """Document 000: dx, dy, dtheta from three rims, with dy (and in one form dx) wrong. Rows 1 to 4."""

    __slots__ = ("_form", "_layout")

    FORMS: ClassVar[dict[str, tuple[Sequence[float], Callable[[float, float, float, float], Row]]]] = {
        "document-000-a-as-printed": (document_000.BEARINGS_A_DEG, document_000.layout_a_code_as_printed),
        "document-000-a-text-as-printed": (document_000.BEARINGS_A_DEG, document_000.layout_a_text_as_printed),
        "document-000-b-as-printed": (document_000.BEARINGS_B_DEG, document_000.layout_b_text_as_printed),
    }

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        super().__init__(kinematics)
        bearings_deg, self._form = self.FORMS[robot.odometry]
        self._layout = fitting(robot.odometry, robot, kinematics, bearings_deg, 3)

    def advance(self, increments_rad: Sequence[float]) -> None:
        """Move by what the wheels turned, as the document reads it."""
        _, distance_m, radius_m, clockwise = self._layout
        a, b, c = (-sign * radius_m * increment for sign, increment in zip(clockwise, increments_rad, strict=True))
        self.move(*self._form(a, b, c, distance_m))


class Odometry002AsPrinted(Odometry):
    """Document 002: what its code makes of the rims of its three dead wheels, every 5 ms. Rows 17 to 19.

    Its closed formulas are right, so any robot's increments will do: they are turned into what three such wheels would
    have counted.
    """

    __slots__ = ("_moves", "_position", "_sums")

    def __init__(self, robot: Robot, kinematics: Kinematics) -> None:
        super().__init__(kinematics)
        self._position = document_002.PositionAsPrinted()
        self._sums = (0.0, 0.0, 0.0)
        self._moves = 0

    def move(self, ux: float, uy: float, dtheta: float) -> None:
        """Gather body increments of a millisecond each; every fifth, call the document's code."""
        x_m, y_m, turn_rad = self._sums
        self._sums = x_m, y_m, turn_rad = x_m + ux, y_m + uy, turn_rad + dtheta
        self._moves += 1
        if self._moves < document_002.DELTA_T_MS:
            return
        self._moves, self._sums = 0, (0.0, 0.0, 0.0)
        per_ms = 1000.0 / document_002.DELTA_T_MS
        v_f, v_i, v_r = (
            per_ms * (y_m * math.cos(bearing) - x_m * math.sin(bearing) + document_002.DISTANCE_MM / 1000.0 * turn_rad)
            for bearing in map(math.radians, document_002.BEARINGS_DEG)
        )
        self._position = document_002.calculate_position_as_printed(self._position, v_f, v_i, v_r)
        right_mm, forward_mm, yaw_deg = self._position
        self._x_m, self._y_m = forward_mm / 1000.0, -right_mm / 1000.0
        self.heading_rad = math.radians(yaw_deg)


def odometry_as_printed(robot: Robot, kinematics: Kinematics) -> Odometry:
    """The printed form that `odometry` names. Raises UsageError where it is not for this robot."""
    name = robot.odometry
    if name == "document-002-as-printed":
        return Odometry002AsPrinted(robot, kinematics)
    if robot.gyro is not None:
        raise UsageError(f"{name}: reads heading from wheels, and {robot.name} has a gyro; leave its [gyro] out")
    if name == "forward-004-as-printed":
        return Forward004AsPrinted(robot, kinematics)
    return Forward000AsPrinted(robot, kinematics)


def control_as_printed(
    robot: Robot, kinematics: Kinematics, field_heading_rad: Callable[[], float]
) -> tuple[Inverse, Controller]:
    """The printed form that `control.kind` names: of the wheel speeds, or of the currents. Raises UsageError."""
    match robot.control.kind:
        case "current-as-printed":
            return kinematics, CurrentAsPrinted(robot)
        case "inverse-004-as-printed":
            return Inverse004AsPrinted(robot, kinematics), speed_controller(robot)
        case "document-001-three-as-printed" | "document-001-three-detailed-as-printed":
            return ThreeWheels001AsPrinted(robot, kinematics, field_heading_rad), speed_controller(robot)
        case "document-001-four-as-printed":
            return FourWheels001AsPrinted(robot, kinematics), speed_controller(robot)
        case "document-001-mecanum-as-printed":
            return Mecanum001AsPrinted(robot, kinematics), speed_controller(robot)
    raise ValueError(f"no printed form of control is called {robot.control.kind!r}")
