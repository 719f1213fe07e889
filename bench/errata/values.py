"""What a row of the errata is, and what measuring it brings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

GEOMETRY, PLANT = "geometry", "plant"


class Figure(NamedTuple):
    """One thing measured: what the right form gives and what the printed one gives, number by number."""

    name: str
    right: tuple[float, ...]
    printed: tuple[float, ...]
    unit: str = ""
    ground: str = GEOMETRY
    """What it was measured on: GEOMETRY (the formula against the wheel equation) or PLANT (a run)."""

    @property
    def error(self) -> float:
        """The largest difference between the two."""
        return max(abs(a - b) for a, b in zip(self.right, self.printed, strict=True))


class Evidence(NamedTuple):
    """The figures of a row, and in a sentence what they mean to a robot."""

    figures: tuple[Figure, ...]
    robot: str


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the errata. `measure` works its evidence out, on the spot and from nothing but the formulas."""

    number: int
    document: str
    where: str
    printed: str
    right: str
    measure: Callable[[], Evidence]
    holds: bool = False
    """The printed arithmetic is right; what is wrong is a comment, a scan or a word."""
