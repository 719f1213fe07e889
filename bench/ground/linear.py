"""Rows of three and 3 x 3 matrices as plain tuples: what a body with the freedoms x, y and yaw needs of linear algebra.

Products are added in a written order, so that no bit depends on a library's build.
"""

from __future__ import annotations

from typing import TypeAlias

from bench.kinematics import Row

Matrix: TypeAlias = tuple[Row, Row, Row]
ZERO: Row = (0.0, 0.0, 0.0)


def dot(a: Row, b: Row) -> float:
    """The inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def times(matrix: Matrix, row: Row) -> Row:
    """The matrix times a column."""
    return dot(matrix[0], row), dot(matrix[1], row), dot(matrix[2], row)


def resisted(inverse_mass: Matrix, row: Row, compliance: float) -> Matrix:
    """The symmetric inverse mass once motion along a row is resisted with this compliance (0: no motion any more)."""
    x, y, w = times(inverse_mass, row)
    size = compliance + dot(row, (x, y, w))
    (xx, xy, xw), (_, yy, yw), (_, _, ww) = inverse_mass
    xy, xw, yw = xy - x * y / size, xw - x * w / size, yw - y * w / size
    return (xx - x * x / size, xy, xw), (xy, yy - y * y / size, yw), (xw, yw, ww - w * w / size)
