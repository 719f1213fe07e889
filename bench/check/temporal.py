"""Formulas over time, and by how much a run satisfies them: a small signal temporal logic in discrete time.

A formula has a margin at every tick of a trace. It holds there where the margin is not negative; how far the margin is
from zero says how near the run came to the other verdict, in the unit of the comparison that decides it.

    Atom(f)                   f(sample); a NaN holds nothing
    Both, Either              the lesser, the greater margin of the two
    Before(f, at_start)       f in the tick before this one; `at_start` in the first
    Always(f, first, last)    the least margin of f in the ticks first..last after this one
    Eventually(f, ...)        the greatest
    Until(f, g, last)         g within `last` ticks, and f in every tick before it

`last=None` means to the end of the trace. A trace ends: a window reaches as far as the trace does, and an empty one
holds for Always and not for the other two. There is no negation of a margin, because less-than and at-most differ
where the margin is zero: `negated` turns a formula into its opposite instead, down to the atoms.

`Monitor` takes samples one by one and needs no more memory than the windows are long (Until and inner windows without
an end keep the trace). Source of the semantics: Maler and Nickovic 2004; of the margins: Donzé and Maler 2010.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

Margin: TypeAlias = Callable[[Any], float]


@dataclass(frozen=True, slots=True)
class Atom:
    """What one sample says by itself. `opposite` is its negation, which holds exactly where this does not."""

    margin: Margin
    opposite: Margin


@dataclass(frozen=True, slots=True)
class Both:
    """One and the other."""

    one: Formula
    other: Formula


@dataclass(frozen=True, slots=True)
class Either:
    """One or the other."""

    one: Formula
    other: Formula


@dataclass(frozen=True, slots=True)
class Before:
    """One tick earlier."""

    inner: Formula
    at_start: float


@dataclass(frozen=True, slots=True)
class Always:
    """In every tick of the window."""

    inner: Formula
    first: int = 0
    last: int | None = None


@dataclass(frozen=True, slots=True)
class Eventually:
    """In some tick of the window."""

    inner: Formula
    first: int = 0
    last: int | None = None


@dataclass(frozen=True, slots=True)
class Until:
    """The first holds until the second does, which it must."""

    inner: Formula
    release: Formula
    last: int | None = None


Formula: TypeAlias = Atom | Both | Either | Before | Always | Eventually | Until


def negated(formula: Formula) -> Formula:
    """The formula that holds exactly where this one does not. Raises TypeError for Until: nothing needs it."""
    match formula:
        case Atom(margin, opposite):
            return Atom(opposite, margin)
        case Both(one, other):
            return Either(negated(one), negated(other))
        case Either(one, other):
            return Both(negated(one), negated(other))
        case Before(inner, at_start):
            return Before(negated(inner), -at_start)
        case Always(inner, first, last):
            return Eventually(negated(inner), first, last)
        case Eventually(inner, first, last):
            return Always(negated(inner), first, last)
    raise TypeError(f"{type(formula).__name__} has no negation here")


def rises(formula: Formula) -> Formula:
    """Where a formula begins to hold; in the first tick it is enough that it holds."""
    return Both(formula, Before(negated(formula), math.inf))


class Monitor:
    """The margin of a formula at the first tick of a trace, told sample by sample.

    `margin` is None until it is certain; after `finish` it is always there. `least_tick` is the tick that decides it:
    of an Always the one with the least margin, of an Eventually the one with the greatest, else the first.
    """

    def __init__(self, formula: Formula) -> None:
        # The outermost window is judged here: so it needs no memory, and knows its tick.
        self._outer = formula if isinstance(formula, Always | Eventually) else None
        inner = self._outer.inner if self._outer else formula
        self._node = _node(inner)
        self._at_once = _at_once(inner)
        self._sign = -1.0 if isinstance(formula, Eventually) else 1.0
        self._so_far = self._sign * math.inf
        self._judged = 0
        self.margin: float | None = None
        self.least_tick = self._outer.first if self._outer else 0

    @property
    def so_far(self) -> float | None:
        """The margin if no tick changed it any more; None while no tick has been judged."""
        if self.margin is not None:
            return self.margin
        is_judged = self._outer is not None and self._judged > self._outer.first
        return self._so_far if is_judged else None

    def push(self, sample: Any) -> None:
        """The next tick."""
        if self._at_once is not None:
            self._take(self._at_once(sample))
            return
        for value in self._node.push(sample):
            self._take(value)

    def finish(self) -> float:
        """The trace is over; returns the margin."""
        for value in self._node.finish():
            self._take(value)
        if self.margin is None:
            self.margin = self._so_far if self._outer is not None else -math.inf
        return self.margin

    def _take(self, value: float) -> None:
        tick, outer = self._judged, self._outer
        self._judged += 1
        if outer is None:
            if tick == 0:
                self.margin = value
            return
        if tick < outer.first or self.margin is not None:
            return
        if self._sign * value < self._sign * self._so_far:
            self._so_far, self.least_tick = value, tick
        if tick == outer.last:
            self.margin = self._so_far


# --- nodes: each tells its margins in order of time, as soon as they are certain ------------------------------------


class _AtomNode:
    def __init__(self, margin: Margin) -> None:
        self._margin = margin

    def push(self, sample: Any) -> Iterable[float]:
        return (self._margin(sample),)

    def finish(self) -> Iterable[float]:
        return ()


class _PairNode:
    """Two inner nodes, of which one may know later than the other."""

    def __init__(self, one: Formula, other: Formula, join: Callable[[float, float], float]) -> None:
        self._one, self._other = _node(one), _node(other)
        self._ones: deque[float] = deque()
        self._others: deque[float] = deque()
        self._join = join

    def push(self, sample: Any) -> Iterable[float]:
        self._ones.extend(self._one.push(sample))
        self._others.extend(self._other.push(sample))
        return self._joined()

    def finish(self) -> Iterable[float]:
        self._ones.extend(self._one.finish())
        self._others.extend(self._other.finish())
        return self._joined()

    def _joined(self) -> Iterator[float]:
        ones, others = self._ones, self._others
        while ones and others:
            yield self._join(ones.popleft(), others.popleft())


class _BeforeNode:
    def __init__(self, formula: Before) -> None:
        self._inner = _node(formula.inner)
        self._last = formula.at_start

    def push(self, sample: Any) -> Iterable[float]:
        return self._delayed(self._inner.push(sample))

    def finish(self) -> Iterable[float]:
        return self._delayed(self._inner.finish())

    def _delayed(self, values: Iterable[float]) -> Iterator[float]:
        for value in values:
            yield self._last
            self._last = value


class _WindowNode:
    """The least (sign +1) or greatest (-1) margin of a window, from a deque of candidates in order."""

    def __init__(self, inner: Formula, first: int, last: int | None, sign: float) -> None:
        self._inner = _node(inner)
        self._first, self._last, self._sign = first, last, sign
        self._known = 0
        self._told = 0
        # (tick, sign * margin), rising in both: what comes later and is less makes the earlier ones irrelevant.
        self._candidates: deque[tuple[int, float]] = deque()
        self._all: list[float] = []

    def push(self, sample: Any) -> Iterable[float]:
        return [told for value in self._inner.push(sample) for told in self._add(self._sign * value)]

    def finish(self) -> Iterable[float]:
        told = [told for value in self._inner.finish() for told in self._add(self._sign * value)]
        return told + self._rest()

    def _add(self, value: float) -> Iterable[float]:
        tick = self._known
        self._known += 1
        if self._last is None:
            self._all.append(value)
            return ()
        candidates = self._candidates
        while candidates and candidates[-1][1] >= value:
            candidates.pop()
        candidates.append((tick, value))
        return (self._tell(),) if tick >= self._last else ()

    def _tell(self) -> float:
        """The margin of the next tick whose window lies in what is known."""
        start = self._told + self._first
        self._told += 1
        candidates = self._candidates
        while candidates and candidates[0][0] < start:
            candidates.popleft()
        return self._sign * (candidates[0][1] if candidates else math.inf)

    def _rest(self) -> list[float]:
        if self._last is not None:
            return [self._tell() for _ in range(self._told, self._known)]
        least, suffix = math.inf, []
        for value in reversed(self._all):
            least = min(least, value)
            suffix.append(self._sign * least)
        suffix.reverse()
        return suffix[self._first :] + [self._sign * math.inf] * min(self._first, len(suffix))


class _UntilNode:
    """Told at the end, from the last tick to the first; a window of `last` ticks only narrows where g must come."""

    def __init__(self, formula: Until) -> None:
        self._inner, self._release = _node(formula.inner), _node(formula.release)
        self._within = _WindowNode(_TOLD, 0, formula.last, -1.0)
        self._inners: list[float] = []
        self._releases: list[float] = []

    def push(self, sample: Any) -> Iterable[float]:
        self._inners.extend(self._inner.push(sample))
        self._releases.extend(self._release.push(sample))
        return ()

    def finish(self) -> Iterable[float]:
        self._inners.extend(self._inner.finish())
        self._releases.extend(self._release.finish())
        soon = [told for value in self._releases for told in self._within.push(value)]
        soon += self._within.finish()
        after, margins = -math.inf, []
        for inner, release in zip(reversed(self._inners), reversed(self._releases), strict=True):
            after = max(release, min(inner, after))
            margins.append(after)
        return [min(*both) for both in zip(reversed(margins), soon, strict=True)]


def _at_once(formula: Formula) -> Margin | None:
    """The margin of a formula that looks at one tick alone; None where it looks further.

    Most conditions do, and as one function they cost a fifth of nodes that hand lists to each other.
    """
    match formula:
        case Atom(margin, _):
            return margin
        case Both(one, other) | Either(one, other):
            first, second = _at_once(one), _at_once(other)
            if first is None or second is None:
                return None
            if isinstance(formula, Both):
                return lambda sample: min(first(sample), second(sample))
            return lambda sample: max(first(sample), second(sample))
    return None


_TOLD = Atom(lambda value: value, lambda value: -value)
_Node: TypeAlias = _AtomNode | _PairNode | _BeforeNode | _WindowNode | _UntilNode


def _node(formula: Formula) -> _Node:
    margin = _at_once(formula)
    if margin is not None:
        return _AtomNode(margin)
    match formula:
        case Both(one, other):
            return _PairNode(one, other, min)
        case Either(one, other):
            return _PairNode(one, other, max)
        case Before():
            return _BeforeNode(formula)
        case Always(inner, first, last):
            return _WindowNode(inner, first, last, 1.0)
        case Eventually(inner, first, last):
            return _WindowNode(inner, first, last, -1.0)
        case Until():
            return _UntilNode(formula)
    raise TypeError(f"{formula!r} is no formula")
