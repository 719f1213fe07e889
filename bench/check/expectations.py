"""What a run shall do, over its signals: `[[expect]]` in a scenario, or the same in Python. Judged while it runs.

    always = C                  in every tick; with `while = W`, in every tick in which W holds
    eventually = C              in some tick; with `within_s`, in one of so many seconds
    when = E, then = C          each time E becomes true: C, within `within_s` (0 unless given), and then for `for_s`
    always = C, until = R       C until R, which must come, within `within_s` where that is given
    when = E, always = C, until = R     the same each time E becomes true
    from_s, to_s                only this part of the run
    vacuous = "allowed"         the run may pass without W or E ever holding; else that fails

C, E, W, R are conditions (`expression`) over signals (`signals`). A window that reaches beyond the end of the run is
judged by what there is of it: what has not come until then has not come.

The margin of a verdict is the least one, in the unit of the comparison that decides: how much was left, or missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass

from bench.check.expression import condition, signals_in
from bench.check.signals import Signals, names
from bench.check.temporal import Always, Atom, Both, Either, Eventually, Formula, Monitor, Until, negated, rises
from bench.config import ConfigError, Robot, Table
from bench.messages import TickOutput

PASSED, FAILED, VACUOUS = "passed", "failed", "vacuous"


@dataclass(frozen=True, slots=True)
class Expectation:
    """One sentence about a run. Times in ticks, both ends included; conditions in the words of the scenario file."""

    name: str
    always: str = ""
    eventually: str = ""
    then: str = ""
    when: str = ""
    whilst: str = ""
    """`while` in a file."""
    until: str = ""
    within: int | None = None
    lasting: int = 0
    """`for_s` in a file."""
    first: int = 0
    last: int | None = None
    may_be_vacuous: bool = False

    def __post_init__(self) -> None:
        main = [word for word in ("always", "eventually", "then") if getattr(self, word)]
        if len(main) != 1:
            raise ValueError(f"expected one of always, eventually, then; got {' and '.join(main) or 'none'}")
        for word, others, sentence in (
            ("then", self.when, "then needs when: each time E becomes true, then C"),
            ("until", self.always, "until needs always: C until R"),
            ("whilst", self.always and not self.until and not self.when, "while goes with always alone"),
            ("when", self.then or (self.always and self.until), "when goes with then, or with always and until"),
            ("lasting", self.then, "for_s goes with when and then"),
        ):
            if getattr(self, word) and not others:
                raise ValueError(sentence)
        if self.within is not None and (self.within < 0 or (self.always and not self.until)):
            raise ValueError("within_s goes with eventually, then or until, and is not negative")
        if self.lasting < 0 or self.first < 0 or (self.last is not None and self.last < self.first):
            raise ValueError("times run forwards: for_s and from_s are not negative, and to_s is not before from_s")

    @property
    def conditions(self) -> tuple[str, ...]:
        """Every condition in it."""
        given = (self.always, self.eventually, self.then, self.when, self.whilst, self.until)
        return tuple(text for text in given if text)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of one expectation."""

    name: str
    result: str
    """passed, failed or vacuous."""
    margin: float
    """Negative: it failed, by so much. Infinite where only texts or flags decide."""
    at_tick: int | None
    """Where the margin was least; None where there is no such instant."""
    ok: bool
    """Not failed; and not vacuous, unless that is allowed."""

    @property
    def text(self) -> str:
        """One line for people."""
        if self.result == VACUOUS:
            return f"{self.name}: never put to the test: its premise did not hold in any tick"
        where = f" at {self.at_tick / 1000:.3f} s" if self.at_tick is not None else ""
        if not math.isfinite(self.margin):
            return f"{self.name}: {self.result}{where}"
        if self.margin < 0.0:
            return f"{self.name}: failed{where}, by {abs(self.margin):.4g}"
        return f"{self.name}: passed, with {self.margin:.4g} to spare{where}"

    def as_dict(self) -> dict[str, object]:
        """Plain values for --json; an infinite margin is none."""
        return asdict(self) | {"margin": self.margin if math.isfinite(self.margin) else None}


def read_expectation(entry: Table) -> Expectation:
    """One `[[expect]]` table. Raises ConfigError with file, key and what to try."""
    words = {key: entry.get(key, str, "") for key in ("always", "eventually", "then", "when", "while", "until", "name")}
    ticks = {key: entry.ticks(key, None) for key in ("within_s", "for_s", "from_s", "to_s")}
    vacuous = entry.get("vacuous", str, "fails")
    if vacuous not in ("fails", "allowed"):
        raise entry.fail("vacuous", f"expected 'fails' or 'allowed', got {vacuous!r}")
    entry.refuse_rest()
    said = words.pop("name")
    words["whilst"] = words.pop("while")
    try:
        return Expectation(
            name=said or _sentence(words),
            within=ticks["within_s"],
            lasting=ticks["for_s"] or 0,
            first=ticks["from_s"] or 0,
            last=ticks["to_s"],
            may_be_vacuous=vacuous == "allowed",
            **words,
        )
    except ValueError as error:
        raise ConfigError(f"{entry.path}: {entry.where}: {error}") from None


def _sentence(words: dict[str, str]) -> str:
    """What an expectation without a name is called."""
    return ", ".join(f"{'while' if word == 'whilst' else word} {text}" for word, text in words.items() if text)


HOLDS, NOT_YET, UNTESTED = "holds", "not yet", "untested"


@dataclass(frozen=True, slots=True)
class Standing:
    """How one expectation stands while the run goes on."""

    name: str
    state: str
    """passed or failed, where that is certain; before: holds, not yet (it must still come), untested (no premise)."""
    margin: float
    """The least so far, of what must still come the greatest; infinite where no number decides, or nothing has."""
    at_tick: int | None


class Judge:
    """Follows a run and judges it. Raises ValueError for a condition that cannot be read, or names no signal."""

    def __init__(self, expectations: Iterable[Expectation], robot: Robot, state_columns: Sequence[str]) -> None:
        self._expectations = tuple(expectations)
        known = names(robot, state_columns)
        wanted = {name for one in self._expectations for text in one.conditions for name in signals_in(text, known)}
        self._signals = Signals(robot, state_columns, wanted)
        self._watches = [_Watch(one, known) for one in self._expectations]
        self._tick = 0

    def add(self, out: TickOutput) -> None:
        """The next tick of the run."""
        sample = (out.tick, self._signals.take(out))
        for watch in self._watches:
            watch.push(sample)

    def standings(self) -> list[Standing]:
        """How they stand after the last tick, in the order of the expectations. Costs next to nothing."""
        return [watch.standing() for watch in self._watches]

    def verdicts(self) -> list[Verdict]:
        """At the end of the run, in the order of the expectations."""
        return [watch.finish() for watch in self._watches]


_Stamped = tuple[int, dict[str, object]]


class _Watch:
    """One expectation: its formula, and whether its premise ever held."""

    def __init__(self, expectation: Expectation, known: Sequence[str]) -> None:
        self._expectation = expectation
        premise = _premise(expectation, known)
        self._premise = Monitor(Eventually(premise)) if premise else None
        self._monitor = Monitor(_formula(expectation, premise, known))

    def push(self, sample: _Stamped) -> None:
        self._monitor.push(sample)
        if self._premise is not None:
            self._premise.push(sample)

    def standing(self) -> Standing:
        name, monitor, margin = self._expectation.name, self._monitor, self._monitor.so_far
        premise = self._premise.so_far if self._premise is not None else math.inf
        if premise is None or premise < 0.0:
            return Standing(name, UNTESTED, math.inf, None)
        decided = monitor.margin is not None
        waits = bool(self._expectation.eventually or (self._expectation.until and not self._expectation.when))
        if margin is None:
            state = NOT_YET if waits else HOLDS
        elif margin < 0.0:
            state = NOT_YET if waits and not decided else FAILED
        else:
            state = PASSED if decided or waits else HOLDS
        at_tick = monitor.least_tick if margin is not None and math.isfinite(margin) else None
        return Standing(name, state, math.inf if margin is None else margin, at_tick)

    def finish(self) -> Verdict:
        one, margin = self._expectation, self._monitor.finish()
        if self._premise is not None and self._premise.finish() < 0.0:
            return Verdict(one.name, VACUOUS, math.inf, None, one.may_be_vacuous)
        passed = margin >= 0.0
        at_tick = self._monitor.least_tick if math.isfinite(margin) or not passed else None
        return Verdict(one.name, PASSED if passed else FAILED, margin, at_tick, passed)


def _premise(one: Expectation, known: Sequence[str]) -> Formula | None:
    """When the expectation says something at all; None: always."""
    premise: Formula | None = None
    if one.whilst:
        premise = _truth(one.whilst, known)
    elif one.when:
        premise = rises(_truth(one.when, known))
    if one.first or one.last is not None:
        window = _between(one.first, one.last)
        premise = Both(premise, window) if premise else window
    return premise


def _formula(one: Expectation, premise: Formula | None, known: Sequence[str]) -> Formula:
    if one.eventually:
        wanted = _atom(one.eventually, known)
        inside = Both(wanted, _between(one.first, one.last)) if one.first or one.last is not None else wanted
        return Eventually(inside, 0, None if one.within is None else one.first + one.within)
    if one.until:
        held: Formula = Until(_atom(one.always, known), _atom(one.until, known), one.within)
        if not one.when:
            return held
    elif one.then:
        held = _atom(one.then, known)
        if one.lasting:
            held = Always(held, 0, one.lasting)
        if one.within:
            held = Eventually(held, 0, one.within)
    else:
        held = _atom(one.always, known)
    if premise is None:
        return Always(held)
    return Always(Either(negated(premise), held))


def _atom(text: str, known: Sequence[str]) -> Atom:
    """A condition on the signals of a stamped sample."""
    plain = condition(text, known)
    margin, opposite = plain.margin, plain.opposite
    return Atom(lambda stamped: margin(stamped[1]), lambda stamped: opposite(stamped[1]))


def _truth(text: str, known: Sequence[str]) -> Atom:
    """A premise: it holds or not. How nearly it does is no margin of what is expected."""
    margin = condition(text, known).margin

    def holds(stamped: _Stamped) -> bool:
        return margin(stamped[1]) >= 0.0

    return _certain(holds)


def _certain(holds: Callable[[_Stamped], bool]) -> Atom:
    return Atom(
        lambda stamped: math.inf if holds(stamped) else -math.inf,
        lambda stamped: -math.inf if holds(stamped) else math.inf,
    )


def _between(first: int, last: int | None) -> Atom:
    def inside(stamped: _Stamped) -> bool:
        return first <= stamped[0] and (last is None or stamped[0] <= last)

    return _certain(inside)
