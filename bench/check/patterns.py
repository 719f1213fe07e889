"""What one field's values may have suffered: each pattern predicts the run from the golden, and counts where it fails.

Enter: the golden's and the run's counts, frame by frame, from the first frame that differs to the last. A pattern that
does not fit at all gives None. `wrong` marks the frames that it does not explain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bench.check.traces import Ints

Wrong: TypeAlias = NDArray[np.bool_]

LONGEST_LAG_FRAMES = 250
_SHIFTS = np.array([shift for lag in range(1, LONGEST_LAG_FRAMES + 1) for shift in (lag, -lag)])
_ASKED = 300
_FEWEST = 3
_FEW = 8
"""With fewer frames than this, noise is not told from anything else."""
_BEYOND_ROUNDING = 2
"""Counts. So far from a middle its two sides are told apart."""


class Pattern(NamedTuple):
    """A kind of change, its number (counts, a factor, frames) and which frames it leaves unexplained."""

    kind: str
    amount: float
    wrong: Wrong
    weight: float = 1.0
    """Below 1 for what fits too easily."""


class Stretch(NamedTuple):
    """The frames in question: `first` to the end of `run`; what came before is there to look back at."""

    golden: Ints
    run: Ints
    first: int
    turn: int = 0

    @property
    def apart(self) -> Ints:
        """Run minus golden, the short way round."""
        apart = self.run[self.first :] - self.golden[self.first :]
        return (apart + self.turn // 2) % self.turn - self.turn // 2 if self.turn else apart


def patterns(stretch: Stretch) -> Iterator[Pattern]:
    """Every pattern that fits somewhat; none for so few frames that anything fits."""
    if (stretch.apart != 0).sum() < _FEWEST:
        return
    for find in (flipped, stuck, offset, scaled, quantised, late, noise):
        found = find(stretch)
        if found is not None:
            yield found


def flipped(stretch: Stretch) -> Pattern | None:
    """The sign is the other one; a stick's, which has no sign, is reversed around its middle (the amount)."""
    golden, run, first, turn = stretch
    sums = golden[first:] + run[first:]
    if turn:
        return Pattern("flipped", 0.0, sums % turn != 0)
    plain = Pattern("flipped", 0.0, sums != 0)
    values, votes = np.unique(sums, return_counts=True)
    usual = values[votes.argmax()]
    middle = float(usual) / 2.0
    if usual == 0 or plain.wrong.mean() < 0.5:
        return plain
    if not _turns_around(middle, golden[first:][sums == usual], rest=float(golden[0])):
        return plain
    return Pattern("flipped", middle, sums != usual, 0.99)


def _turns_around(middle: float, mirrored: Ints, rest: float) -> bool:
    """Whether that is a stick's middle: any two values have one. Both sides of it are mirrored, or it is where the
    stick rested at the start.
    """
    above, below = float(mirrored.max()) - middle, middle - float(mirrored.min())
    is_rest = abs(rest - middle) < _BEYOND_ROUNDING
    return (max if is_rest else min)(above, below) >= _BEYOND_ROUNDING


def stuck(stretch: Stretch) -> Pattern | None:
    """One value stays, however the golden moves."""
    _, run, first, _ = stretch
    value = run[first]
    held = first > 0 and run[first - 1] == value
    return Pattern("stuck", float(value), run[first:] != value, 1.0 if held else 0.9)


def offset(stretch: Stretch) -> Pattern | None:
    """The same number of counts added everywhere."""
    apart = stretch.apart
    values, votes = np.unique(apart[apart != 0], return_counts=True)
    amount = values[votes.argmax()]
    return Pattern("offset", float(amount), apart != amount, 0.99)


def scaled(stretch: Stretch) -> Pattern | None:
    """Everything times the same factor, to the nearest count either way."""
    golden, run = stretch.golden[stretch.first :], stretch.run[stretch.first :]
    if stretch.turn:
        return None
    changed = (run != golden) & (golden != 0)
    if not changed.any():
        return None
    large = changed & (np.abs(golden) >= np.quantile(np.abs(golden[changed]), 0.5))
    ratio = float(np.median(run[large] / golden[large]))
    best = None
    for factor in (round(ratio, 2), round(ratio, 3), ratio, _between(golden[large], run[large], ratio)):
        if abs(factor) < 0.01 or factor in (1.0, -1.0):
            continue
        wrong = np.abs(factor * golden - run) >= 1.0
        if best is None or wrong.sum() < best.wrong.sum():
            best = Pattern("scaled", factor, wrong, 0.98)
    if best is None:
        return None
    # A factor near 1 on small values is within a count of anything; it must have moved what it is said to have moved.
    telling = changed & (np.abs((best.amount - 1.0) * golden) >= 2.0)
    if telling.sum() < 0.2 * changed.sum() or len(np.unique(golden[telling])) < 3:
        return best._replace(weight=0.5)
    return best


def _between(golden: Ints, run: Ints, ratio: float) -> float:
    """The factor in the middle of those that bring all counts within one; on large counts a median is too coarse."""
    close = np.abs(ratio * golden - run) < np.maximum(2.0, 1e-4 * np.abs(run))
    if not close.any():
        return ratio
    edges = (run[close] - 1.0) / golden[close], (run[close] + 1.0) / golden[close]
    return float((np.minimum(*edges).max() + np.maximum(*edges).min()) / 2.0)


def quantised(stretch: Stretch) -> Pattern | None:
    """Only every n-th count is left."""
    golden, run = stretch.golden[stretch.first :], stretch.run[stretch.first :]
    changed = run != golden
    step = int(np.gcd.reduce(run[changed]))
    if step < 2 or step <= int(np.gcd.reduce(golden)) or len(np.unique(run)) < 3:
        return None
    return Pattern("quantised", float(step), (run % step != 0) | (np.abs(stretch.apart) >= step), 0.99)


def late(stretch: Stretch) -> Pattern | None:
    """The golden's values, some frames later or earlier, while the frames themselves come in time."""
    golden, run, first, _ = stretch
    rows = np.arange(first, len(run), dtype=np.int64)
    # Which shifts are worth a full look shows on some of the frames that differ.
    asked = rows[golden[first:] != run[first:]][:_ASKED]
    at = asked[:, None] - _SHIFTS
    inside = (at >= 0) & (at < len(golden))
    hits = (inside & (golden[np.clip(at, 0, len(golden) - 1)] == run[asked][:, None])).sum(axis=0)
    best: Pattern | None = None
    fewest_wrong = len(rows)
    for shift in _SHIFTS[np.argsort(-hits, kind="stable")[:3]].tolist():
        at = rows - shift
        inside = (at >= 0) & (at < len(golden))
        wrong = ~inside
        wrong[inside] = golden[at[inside]] != run[rows[inside]]
        if wrong.sum() < fewest_wrong:
            fewest_wrong, best = int(wrong.sum()), Pattern("late", float(shift), wrong, 0.99)
    return best


def noise(stretch: Stretch) -> Pattern | None:
    """Deviations with nothing in common: neither with the one before nor with the signal. Nothing is predicted."""
    apart = stretch.apart
    changed = apart != 0
    if changed.sum() < _FEW or (apart[changed] == apart[changed][0]).all():
        return None
    centred = apart - apart.mean()
    power = float((centred * centred).mean())
    if power <= 0.0:
        return None
    alike = abs(float((centred[1:] * centred[:-1]).mean()) / power)
    signal = stretch.golden[stretch.first :] - stretch.golden[stretch.first :].mean()
    along = float((signal * signal).mean())
    follows = abs(float((signal * centred).mean())) / math.sqrt(power * along) if along > 0.0 else 0.0
    if alike > 0.35 or follows > 0.6:
        return None
    size = float(np.sqrt((apart[changed].astype(np.float64) ** 2).mean()))
    return Pattern("noise", size, np.zeros(len(apart), bool), 0.75)
