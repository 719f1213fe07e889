"""How fast this machine is just now, by an empty Python call, and what a speed would be where that call takes longer.

On a shared machine the same program runs several times slower from one hour to the next, and so does an empty call. A
number that is kept is therefore also told for the reference machine, whose empty call takes 24 ns, and 48 ns where its
clock is cold. Processor time of this thread: waiting for a busy core is not in it, and is not taken out of wall time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import repeat
from statistics import median
from typing import TypeVar

REFERENCE_NS = {"warm": 24.0, "cold": 48.0}
CALLS, READINGS = 4000, 25

Result = TypeVar("Result")


def reading_ns(calls: int = CALLS) -> float:
    """One empty call, ns: the mean of so many in a row, loop and all, as `timeit` has it."""

    def nothing() -> None:
        pass

    begin = time.thread_time_ns()
    for _ in repeat(None, calls):
        nothing()
    return (time.thread_time_ns() - begin) / calls


def now_ns() -> float:
    """An empty call at this moment, ns."""
    return median(reading_ns() for _ in range(READINGS))


def beside(job: Callable[[], Result]) -> tuple[Result, float]:
    """What a job gives, and the empty call beside it, ns: the mean of the moments before and after."""
    before_ns = now_ns()
    result = job()
    return result, (before_ns + now_ns()) / 2.0


def told_for_reference(
    values: Sequence[float], calls_ns: Sequence[float], form: str = "{:.1f}", *, is_cost: bool = False
) -> tuple[str, ...]:
    """Speeds (or costs) of the rounds, each by its own empty call, for each of REFERENCE_NS: medians of the rounds."""
    pairs = list(zip(values, calls_ns, strict=True))
    return tuple(
        form.format(median(value * ns / call_ns if is_cost else value * call_ns / ns for value, call_ns in pairs))
        for ns in REFERENCE_NS.values()
    )
