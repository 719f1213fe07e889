"""Formulas over time: the monitor says what the definition says, on any trace, whatever the formula."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check.temporal import Always, Atom, Before, Both, Either, Eventually, Monitor, Until, negated, rises

UP = Atom(lambda sample: sample[0], lambda sample: -sample[0])
DOWN = Atom(lambda sample: sample[1], lambda sample: -sample[1])


def by_definition(formula, trace, tick):
    """The margin at a tick as the module's first lines define it, by recursion over the whole trace."""
    match formula:
        case Atom():
            return formula.margin(trace[tick])
        case Both(one, other):
            return min(by_definition(one, trace, tick), by_definition(other, trace, tick))
        case Either(one, other):
            return max(by_definition(one, trace, tick), by_definition(other, trace, tick))
        case Always(inner, first, last):
            return min((by_definition(inner, trace, at) for at in window(trace, tick, first, last)), default=math.inf)
        case Eventually(inner, first, last):
            return max((by_definition(inner, trace, at) for at in window(trace, tick, first, last)), default=-math.inf)
        case Until(inner, release, last):
            return max(
                min([by_definition(release, trace, at), *(by_definition(inner, trace, b) for b in range(tick, at))])
                for at in window(trace, tick, 0, last)
            )
        case Before(inner, at_start):
            return by_definition(inner, trace, tick - 1) if tick else at_start
    raise AssertionError(formula)


def window(trace, tick, first, last):
    end = len(trace) if last is None else min(len(trace), tick + last + 1)
    return range(tick + first, end)


def windows(inner):
    first = st.integers(0, 4)
    last = st.none() | st.integers(0, 5)
    bounds = st.tuples(first, last).filter(lambda pair: pair[1] is None or pair[0] <= pair[1])
    return st.builds(lambda kind, f, pair: kind(f, *pair), st.sampled_from((Always, Eventually)), inner, bounds)


plain = st.recursive(
    st.sampled_from((UP, DOWN)),
    lambda inner: st.one_of(
        st.builds(Both, inner, inner), st.builds(Either, inner, inner), st.builds(rises, inner), windows(inner)
    ),
    max_leaves=6,
)
formulas = st.one_of(
    plain,
    st.builds(Until, plain, plain, st.none() | st.integers(0, 5)),
    windows(st.builds(Until, plain, plain, st.none() | st.integers(0, 4))),
)
traces = st.lists(st.tuples(*[st.sampled_from((-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 3.0, math.inf))] * 2), max_size=14)


def watched(formula, trace):
    monitor = Monitor(formula)
    for sample in trace:
        monitor.push(sample)
    return monitor.finish(), monitor


@settings(max_examples=200)
@given(formulas, traces.filter(bool))
def test_the_monitor_agrees_with_the_definition(formula, trace):
    assert watched(formula, trace)[0] == by_definition(formula, trace, 0)


@settings(max_examples=100)
@given(formulas, traces.filter(bool), traces)
def test_what_is_certain_stays_whatever_comes(formula, trace, more):
    monitor = Monitor(formula)
    certain = None
    for sample in trace + more:
        monitor.push(sample)
        if certain is None:
            certain = monitor.margin
        assert monitor.margin == certain
    if certain is not None:
        assert monitor.finish() == certain


@settings(max_examples=100)
@given(plain, traces.filter(bool))
def test_a_negated_formula_has_the_opposite_margin(formula, trace):
    assert by_definition(negated(formula), trace, 0) == -by_definition(formula, trace, 0)


@settings(max_examples=200)
@given(windows(plain), traces.filter(bool))
def test_the_deciding_tick_has_the_margin(formula, trace):
    margin, monitor = watched(formula, trace)
    if monitor.least_tick < len(trace) and abs(margin) != math.inf:
        assert by_definition(formula.inner, trace, monitor.least_tick) == margin


def test_a_bounded_formula_is_certain_as_soon_as_its_window_is_over():
    monitor = Monitor(Eventually(UP, 0, 2))
    for value in (-3.0, -1.0):
        monitor.push((value, 0.0))
        assert monitor.margin is None
    monitor.push((-2.0, 0.0))
    assert (monitor.margin, monitor.least_tick) == (-1.0, 1)


def test_a_long_run_is_watched_in_bounded_memory():
    monitor = Monitor(Always(Either(UP, Eventually(DOWN, 0, 50))))
    for tick in range(20_000):
        monitor.push((-1.0, math.sin(tick / 10.0)))
    inner = monitor._node
    assert len(inner._ones) <= 51
    assert len(inner._other._candidates) <= 51
    assert inner._other._all == []


def test_an_empty_trace_satisfies_only_what_asks_for_nothing():
    assert Monitor(Always(UP)).finish() == math.inf
    assert Monitor(Eventually(UP)).finish() == -math.inf
    assert Monitor(Until(UP, DOWN)).finish() == -math.inf


def test_until_cannot_be_negated():
    with pytest.raises(TypeError, match="Until"):
        negated(Until(UP, DOWN))
