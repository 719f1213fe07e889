"""Three rows by three, and no more."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.messages import BodyTwist

Vector = tuple[float, float, float]


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """Of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def determinant(m: Sequence[Sequence[float]]) -> float:
    """Of three rows."""
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


def solved(matrix: Sequence[Sequence[float]], right: Sequence[float]) -> Vector:
    """Cramer's rule."""
    whole = determinant(matrix)
    parts = [
        determinant([[right[i] if k == column else row[k] for k in range(3)] for i, row in enumerate(matrix)])
        for column in range(3)
    ]
    return parts[0] / whole, parts[1] / whole, parts[2] / whole


def turned(twist: BodyTwist, angle: float) -> Vector:
    """A twist in a frame turned back by the angle."""
    c, s = math.cos(angle), math.sin(angle)
    return c * twist.vx_mps - s * twist.vy_mps, s * twist.vx_mps + c * twist.vy_mps, twist.omega_radps
