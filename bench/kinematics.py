"""Body twist <-> wheel speeds, for any base of omni or mecanum wheels: one equation, one matrix a robot.

A wheel stands at p, pushes the chassis towards heading delta when it turns positively, and its roller on the ground
has its axis a at delta + gamma. Only motion along that axis is constrained (Siegwart and Nourbakhsh, Swedish wheel,
equation 3.12, turned into this frame):

    phi_dot = a . (v + omega x p) / (r cos gamma)

Stacked rows give H (wheels = H twist); the way back is the least-squares inverse H+ = (H'H)^-1 H', the plain inverse
for three wheels. Everything is worked in plain Python floats: a linear-algebra library's last bit depends on its
build, and a golden must not.

Frame: x forward, y left, counter-clockwise positive. Wheel speeds in rad/s at the wheel, increments in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from bench.config import Wheel
from bench.messages import BodyTwist

Row: TypeAlias = tuple[float, float, float]

SINGULAR_BELOW = 1e-9
"""Least determinant of the scaled, normalised H'H (1 for a well-made base) that still counts as rank 3."""


class Kinematics:
    """The matrix of one base and its least-squares inverse. Raises ValueError where they cannot span the plane."""

    __slots__ = ("_shares", "axes", "forward_rows", "inverse_rows", "length_m", "radii")

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self.axes = axis_rows(wheels)
        self.length_m = _length_scale(wheels)
        """The farthest wheel's distance from the origin: over it, metres and radians are judged alike."""
        self.radii = tuple(wheel.radius_m * math.cos(wheel.roller_rad) for wheel in wheels)
        """r cos gamma: metres along the roller axis for each radian of the wheel."""
        self.inverse_rows: tuple[Row, ...] = speed_rows(wheels)
        """H, one row a wheel: twist -> wheel speeds (the robotics name for this direction is inverse kinematics)."""
        self.forward_rows: tuple[tuple[float, ...], ...] = _pseudo_inverse(self.inverse_rows, self.length_m)
        """H+, three rows: wheel speeds -> twist."""
        # The same by wheel: its index, and what 1 rad/s of it adds to the twist.
        self._shares = tuple(
            (wheel, fx, fy, fw) for wheel, (fx, fy, fw) in enumerate(zip(*self.forward_rows, strict=True))
        )

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s (or increments in rad) that move the base with this twist (or increment)."""
        vx, vy, omega = twist
        return [hx * vx + hy * vy + hw * omega for hx, hy, hw in self.inverse_rows]

    def twist(self, wheel_speeds: Sequence[float]) -> BodyTwist:
        """The twist that fits these wheel speeds best, every wheel weighing the same."""
        return BodyTwist(*self.fit(wheel_speeds))

    def fit(self, wheels: Sequence[float]) -> Row:
        """Wheel speeds -> (vx, vy, omega), or wheel increments in rad -> increment: the best fit, as a plain tuple."""
        if len(wheels) != len(self._shares):
            raise ValueError(f"{len(wheels)} values for {len(self._shares)} wheels")
        x = y = turn = 0.0
        for wheel, fx, fy, fw in self._shares:
            value = wheels[wheel]
            x += fx * value
            y += fy * value
            turn += fw * value
        return x, y, turn

    def slip(self, wheel_speeds: Sequence[float]) -> list[float]:
        """Given speeds minus those that the best-fitting twist would give; zero for three wheels, always."""
        return [
            given - fit for given, fit in zip(wheel_speeds, self.wheel_speeds(self.twist(wheel_speeds)), strict=True)
        ]

    def slip_residual(self, wheel_speeds: Sequence[float]) -> float:
        """Length of the slip: with four wheels the |n . speeds| of the unit n with n H = 0. Needs more than three."""
        total = 0.0
        for slip in self.slip(wheel_speeds):
            total += slip * slip
        return math.sqrt(total)

    def slip_vectors(self) -> list[list[float]]:
        """Unit vectors n with n H = 0, one for each wheel above three: n . wheels is zero unless the wheels slip.

        They stand at right angles to each other; the last number of each that is not zero is positive.
        """
        count = len(self.radii)
        left = [self.slip([float(i == wheel) for i in range(count)]) for wheel in range(count)]
        found: list[list[float]] = []
        while len(found) < count - 3:
            # The longest of what is left is the one that rounding has hurt least.
            best = max(left, key=lambda vector: _dot(vector, vector))
            size = math.sqrt(_dot(best, best))
            last = [value for value in best if abs(value) > 1e-9 * size][-1]
            unit = [value / math.copysign(size, last) for value in best]
            found.append(unit)
            shares = [_dot(unit, vector) for vector in left]
            left = [
                [value - share * part for value, part in zip(vector, unit, strict=True)]
                for vector, share in zip(left, shares, strict=True)
            ]
        return found

    def wrench(self, wheel_torques: Sequence[float]) -> Row:
        """Body force (N, N) and moment (N m) of ideal wheel torques: the transpose of H."""
        fx = fy = moment = 0.0
        for (hx, hy, hw), torque in zip(self.inverse_rows, wheel_torques, strict=True):
            fx += hx * torque
            fy += hy * torque
            moment += hw * torque
        return fx, fy, moment


def desaturate(wheel_speeds: Sequence[float], limit_radps: float) -> list[float]:
    """Scale all wheels by one factor so that none is above the limit: the direction of travel survives."""
    fastest = max(map(abs, wheel_speeds))
    if fastest <= limit_radps:
        return list(wheel_speeds)
    scale = limit_radps / fastest
    return [speed * scale for speed in wheel_speeds]


def rotate_into_body(vx_field: float, vy_field: float, heading_rad: float) -> tuple[float, float]:
    """Field-frame velocity -> body frame: turned by minus the heading ("headless" driving)."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return c * vx_field + s * vy_field, c * vy_field - s * vx_field


def twist_from_document_004(x_right: float, y_forward: float, yaw_clockwise: float) -> BodyTwist:
    """Document 004 and its firmware: x right, y forward, yaw clockwise -> this frame."""
    return BodyTwist(y_forward, -x_right, -yaw_clockwise)


def twist_from_document_002(x_right: float, y_forward: float, yaw_counter_clockwise: float) -> BodyTwist:
    """Documents 001 and 002: x right, y forward, yaw counter-clockwise -> this frame."""
    return BodyTwist(y_forward, -x_right, yaw_counter_clockwise)


def axis_rows(wheels: Sequence[Wheel]) -> tuple[Row, ...]:
    """(ax, ay, p x a) of each wheel: what its roller axis feels of a twist, in m/s. Singular layouts have them too."""
    return tuple(_axis_row(wheel) for wheel in wheels)


def speed_rows(wheels: Sequence[Wheel]) -> tuple[Row, ...]:
    """H, for any number of wheels: what 1 m/s forward, 1 m/s left and 1 rad/s make of each, in rad/s."""
    radii = [wheel.radius_m * math.cos(wheel.roller_rad) for wheel in wheels]
    return tuple((ax / r, ay / r, moment / r) for (ax, ay, moment), r in zip(axis_rows(wheels), radii, strict=True))


def condition(wheels: Sequence[Wheel]) -> float:
    """Largest over smallest singular value: 1.41 for three wheels 120 degrees apart, infinite for a singular layout."""
    largest, _, smallest = singular_values(axis_rows(wheels), _length_scale(wheels))
    return largest / smallest if smallest > 1e-9 * largest else math.inf


def if_rollers_leaned_the_other_way(wheels: Sequence[Wheel]) -> float | None:
    """The condition with every roller's angle negated, where that is far better; None where it is not.

    Mecanum wheels are told apart by the roller that is seen, on top, and driven by the one on the ground, which leans
    the other way. Taken for each other they leave a base that hardly turns, or on a square not at all.
    """
    mirrored = condition([replace(wheel, roller_rad=-wheel.roller_rad) for wheel in wheels])
    return mirrored if 2.0 * mirrored < condition(wheels) else None


def singular_values(rows: Sequence[Row], length_scale_m: float) -> list[float]:
    """Singular values, largest first, of rows (already times r cos gamma) with the third column over the length."""
    a = _gram([(x, y, w / length_scale_m) for x, y, w in rows])
    return [math.sqrt(max(0.0, value)) for value in _symmetric_eigenvalues(a)]


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


def _axis_row(wheel: Wheel) -> Row:
    angle = wheel.heading_rad + wheel.roller_rad
    ax, ay = math.cos(angle), math.sin(angle)
    return ax, ay, wheel.x_m * ay - wheel.y_m * ax


def _length_scale(wheels: Sequence[Wheel]) -> float:
    return math.sqrt(max((wheel.x_m * wheel.x_m + wheel.y_m * wheel.y_m for wheel in wheels), default=0.0)) or 1.0


def _gram(rows: Sequence[Sequence[float]]) -> list[list[float]]:
    gram = [[0.0] * 3 for _ in range(3)]
    for row in rows:
        for i in range(3):
            for j in range(3):
                gram[i][j] += row[i] * row[j]
    return gram


def _pseudo_inverse(rows: Sequence[Row], length_m: float) -> tuple[tuple[float, ...], ...]:
    # The third column is divided by a length first: the determinant is then a fair measure of the layout, not of units.
    scaled = [(x, y, w / length_m) for x, y, w in rows]
    g = _gram(scaled)
    size = (g[0][0] + g[1][1] + g[2][2]) / 3.0
    cofactors = [
        [
            g[(j + 1) % 3][(i + 1) % 3] * g[(j + 2) % 3][(i + 2) % 3]
            - g[(j + 1) % 3][(i + 2) % 3] * g[(j + 2) % 3][(i + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    determinant = g[0][0] * cofactors[0][0] + g[0][1] * cofactors[1][0] + g[0][2] * cofactors[2][0]
    if not math.isfinite(determinant) or determinant <= SINGULAR_BELOW * size**3:
        raise ValueError("the wheels cannot move the base in x, y and yaw independently (singular layout)")
    inverse = [[value / determinant for value in line] for line in cofactors]
    forward = [[inverse[i][0] * x + inverse[i][1] * y + inverse[i][2] * w for x, y, w in scaled] for i in range(3)]
    return tuple(forward[0]), tuple(forward[1]), tuple(value / length_m for value in forward[2])


def _symmetric_eigenvalues(a: list[list[float]]) -> list[float]:
    """Eigenvalues of a symmetric 3 x 3 matrix, largest first, by cyclic Jacobi rotations."""
    m = [row[:] for row in a]
    for _ in range(30):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if m[p][q] == 0.0:
                continue
            theta = 0.5 * math.atan2(2.0 * m[p][q], m[q][q] - m[p][p])
            c, s = math.cos(theta), math.sin(theta)
            for k in range(3):
                m[k][p], m[k][q] = c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]
            for k in range(3):
                m[p][k], m[q][k] = c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]
    return sorted((m[i][i] for i in range(3)), reverse=True)
