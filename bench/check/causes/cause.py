"""One explanation of a difference, and what the makers of explanations share."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

GOOD = 0.6
"""A score from which a cause is said without a "perhaps"."""


@dataclass(frozen=True, slots=True)
class Cause:
    """One explanation. `fields` is empty where whole frames are meant, `last_tick` None where it lasts to the end."""

    kind: str
    wires: tuple[str, ...]
    fields: tuple[str, ...]
    first_tick: int
    last_tick: int | None
    amount: float
    """What the kind has a number for: ticks late, frames, a factor, an offset or step in the field's unit."""
    score: float
    """0 to 1: the share of the wire's differences that it explains, less what its easiness costs."""
    differing: int
    left: int
    """Of so many differences so many stay unexplained."""
    text: str = ""
    usual: float = 0.0
    """What the golden has in place of the amount, where a sentence needs both: its period."""

    @property
    def is_sure(self) -> bool:
        """Whether it explains most of what it is said to explain."""
        return self.score >= GOOD

    @property
    def evidence(self) -> str:
        """What speaks for it, as a clause."""
        if not self.left:
            return "explains every difference there"
        return f"explains {math.floor(1000 * (1 - self.left / self.differing)) / 10} % of the differences there"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for --json."""
        return {**asdict(self), "score": round(self.score, 3), "evidence": self.evidence}


def by_score(found: list[Cause]) -> list[Cause]:
    """The best first."""
    return sorted(found, key=lambda cause: -cause.score)


def scored(blank: Cause, kind: str, amount: float, total: int, left: int, weight: float) -> Cause:
    """A cause that leaves so many of all differences, `total`, unexplained; `weight` is what its easiness costs."""
    left = max(0, min(left, total))
    score = weight * (1.0 - left / total)
    return replace(blank, kind=kind, amount=float(amount), score=score, differing=total, left=left)


def end_of(last: int, end_tick: int) -> int | None:
    """None where it lasts to the end, or so near that nobody can tell."""
    return None if end_tick - last <= max(100, end_tick // 20) else last
