"""How expectations stand while a run goes on: what a lamp shows must never be taken back by the verdict."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check.expectations import FAILED, HOLDS, NOT_YET, PASSED, UNTESTED, VACUOUS, Expectation, Judge
from bench.check.sources import from_scenario
from bench.config import load_robot
from bench.loop import simulated
from bench.messages import TickOutput

M2006 = load_robot("m2006")
COLUMNS = simulated("m2006").state_columns
X, VX = COLUMNS.index("x_m"), COLUMNS.index("vx_mps")
EXAMPLE = Path(__file__).parents[1] / "docs" / "examples" / "link_loss.toml"


def out(tick, x, vx=0.0):
    state = [0.0] * len(COLUMNS)
    state[X], state[VX] = x, vx
    return TickOutput(tick, b"", b"", b"", (), (), tuple(state))


def judge(*expectations):
    return Judge(expectations, M2006, COLUMNS)


def states(expectation, values):
    """The standing after each tick of x, and the verdict at the end."""
    judged = judge(expectation)
    seen = []
    for tick, x in enumerate(values):
        judged.add(out(tick, x))
        seen.append(judged.standings()[0].state)
    return seen, judged.verdicts()[0].result


@pytest.mark.parametrize(
    ("expectation", "values", "seen", "verdict"),
    [
        (Expectation("a", always="x_m < 2"), [1, 1, 3, 1], [HOLDS, HOLDS, FAILED, FAILED], FAILED),
        (Expectation("e", eventually="x_m > 2"), [1, 3, 1], [NOT_YET, PASSED, PASSED], PASSED),
        (Expectation("e", eventually="x_m > 2", within=1), [1, 1, 3], [NOT_YET, FAILED, FAILED], FAILED),
        (Expectation("w", always="x_m < 2", whilst="x_m > 0"), [0, 1, 0], [UNTESTED, HOLDS, HOLDS], PASSED),
        (Expectation("w", always="x_m < 2", whilst="x_m > 5"), [0, 1], [UNTESTED, UNTESTED], VACUOUS),
        (Expectation("t", when="x_m > 0", then="x_m > 2", within=1), [0, 1, 3], [UNTESTED, HOLDS, HOLDS], PASSED),
        (Expectation("t", when="x_m > 0", then="x_m > 2", within=1), [0, 1, 1], [UNTESTED, HOLDS, FAILED], FAILED),
        (Expectation("u", always="x_m < 2", until="x_m > 5"), [1, 1, 6], [NOT_YET, NOT_YET, NOT_YET], PASSED),
        (Expectation("f", always="x_m < 2", first=2), [9, 9, 1], [UNTESTED, UNTESTED, HOLDS], PASSED),
    ],
)
def test_each_form_stands_as_it_should(expectation, values, seen, verdict):
    assert states(expectation, values) == (seen, verdict)


def test_the_margin_is_the_least_so_far_and_says_when():
    judged = judge(Expectation("a", always="x_m < 2"))
    for tick, x in enumerate([1.0, 1.75, 0.5]):
        judged.add(out(tick, x))
    (standing,) = judged.standings()
    assert (standing.margin, standing.at_tick) == (0.25, 1)


forms = st.sampled_from(
    [
        Expectation("a", always="x_m < 2"),
        Expectation("e", eventually="x_m > 2"),
        Expectation("e", eventually="x_m > 2", within=3),
        Expectation("w", always="x_m < 2", whilst="x_m > 0"),
        Expectation("t", when="x_m > 0", then="x_m > 1", within=2),
        Expectation("l", when="x_m > 0", then="x_m > 1", within=2, lasting=2),
        Expectation("u", always="x_m < 2", until="x_m > 2", within=4),
        Expectation("v", when="x_m > 0", always="x_m < 2", until="x_m < 0"),
        Expectation("f", always="x_m < 2", first=2, last=4),
    ]
)


@given(forms, st.lists(st.sampled_from([-1.0, 0.0, 0.5, 1.5, 2.0, 2.5]), min_size=1, max_size=10))
@settings(max_examples=200)
def test_what_is_certain_is_never_taken_back(expectation, values):
    seen, verdict = states(expectation, values)
    for state in (PASSED, FAILED):
        if state in seen:
            assert verdict == state
            assert set(seen[seen.index(state) :]) == {state}
    if verdict == VACUOUS:
        assert set(seen) == {UNTESTED}


def test_a_real_run_stands_as_its_scenario_goes():
    """The example of docs/scenarios.md: it drives until the receiver is unplugged at 2 s, and is back at 3.5 s."""
    run = from_scenario(EXAMPLE)
    at = {}
    for done in run:
        run.judge.add(done)
        if done.tick in (999, 2499, 3999):
            at[done.tick] = [one.state for one in run.judge.standings()]
    assert at[999] == [NOT_YET, UNTESTED, UNTESTED, UNTESTED]
    assert at[2499][0] == PASSED
    assert at[3999] == [PASSED, HOLDS, HOLDS, HOLDS]
    assert all(one.ok for one in run.judge.verdicts())
    assert [one.state for one in run.judge.standings()] == [PASSED] * 4
