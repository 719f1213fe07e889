"""Ways on the plane: where a telling of a motion has come to, and what it told between two instants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import fsum
from operator import mul
from typing import NamedTuple

from bench.odometry import exponential


def fitted(rows: Sequence[Sequence[float]], wheels: Sequence[float]) -> tuple[float, float, float]:
    """What `Kinematics.fit` gives, by its `forward_rows`: in a third of the steps, which tells 500 times a second."""
    along, aside, turn = rows
    return fsum(map(mul, along, wheels)), fsum(map(mul, aside, wheels)), fsum(map(mul, turn, wheels))


class Way(NamedTuple):
    """A pose since the telling began; the heading is not wrapped."""

    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0

    def turned_by(self, ux: float, uy: float, dtheta: float) -> Way:
        """After a body increment of one constant twist."""
        return self.moved_by(*exponential(ux, uy, dtheta), dtheta)

    def moved_by(self, dx_m: float, dy_m: float, dtheta_rad: float) -> Way:
        """After a displacement, in the frame as it stood."""
        cos, sin = math.cos(self.heading_rad), math.sin(self.heading_rad)
        return Way(
            self.x_m + cos * dx_m - sin * dy_m, self.y_m + sin * dx_m + cos * dy_m, self.heading_rad + dtheta_rad
        )

    def since(self, start: Way) -> Way:
        """The displacement from there to here, in the frame there."""
        cos, sin = math.cos(start.heading_rad), math.sin(start.heading_rad)
        dx_m, dy_m = self.x_m - start.x_m, self.y_m - start.y_m
        return Way(cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m, self.heading_rad - start.heading_rad)

    def towards(self, other: Way, part: float) -> Way:
        """Part of the way (0 to 1) to another pose."""
        return Way(
            self.x_m + part * (other.x_m - self.x_m),
            self.y_m + part * (other.y_m - self.y_m),
            self.heading_rad + part * (other.heading_rad - self.heading_rad),
        )
