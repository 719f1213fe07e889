"""The scope: it triggers where a signal crosses, shows what was, forgets what is old. The signal is a known one."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check.signals import names
from bench.config import load_robot
from bench.io.look import Look
from bench.io.scope import KEPT_TICKS, SPANS_MS, Scope, ScopeSettings, scope_signals
from bench.io.tap import Tap
from bench.loop import simulated
from bench.messages import TickOutput
from bench.screen.scope import bounds

M2006 = load_robot("m2006")
COLUMNS = simulated("m2006").state_columns
X = COLUMNS.index("x_m")


def out(tick, value):
    """A tick whose x_m is the value; `state` comes every tick here, so that every tick is a sample."""
    state = [0.0] * len(COLUMNS)
    state[X], state[X + 1] = value, -value
    return TickOutput(tick, b"", b"", b"", (), (), tuple(state))


def sine(tick):
    """Crosses 0.5 upwards at 83.3 ms and each second after."""
    return math.sin(2.0 * math.pi * tick / 1000.0)


def a_scope(ticks, **settings):
    scope = Scope(M2006, COLUMNS, ScopeSettings(("x_m", "y_m"), **settings))
    for start in range(0, ticks, 50):
        scope.take([out(tick, sine(tick)) for tick in range(start, min(start + 50, ticks))])
    return scope


def test_it_triggers_at_the_tick_in_which_the_signal_has_passed_the_level():
    picture = a_scope(3000, span_ms=500, mode="normal", level=0.5).picture(100)
    assert picture.state == "triggered"
    assert picture.trigger_tick == 2084, "asin(0.5) is a twelfth of the turn: 2083.3 ms"
    assert picture.start_tick == 2084 - 100
    falling = a_scope(3000, span_ms=500, mode="normal", edge="falling", level=0.5).picture(100)
    assert falling.trigger_tick == 2417


def test_a_signal_that_rests_on_the_level_triggers_when_it_leaves_it():
    scope = Scope(M2006, COLUMNS, ScopeSettings(("x_m",), 100, "normal"))
    scope.take([out(tick, 0.0 if tick < 700 else 1.0) for tick in range(1000)])
    assert scope.picture(10).trigger_tick == 700


def test_a_picture_stands_until_the_next_one_is_complete():
    scope = a_scope(1500, span_ms=1000, mode="normal", level=0.5)
    assert scope.picture(10).trigger_tick == 84
    scope.take([out(tick, sine(tick)) for tick in range(1500, 1883)])
    assert scope.picture(10).trigger_tick == 84
    scope.take([out(1883, sine(1883))])
    assert scope.picture(10).trigger_tick == 1084


def test_single_catches_one_and_only_a_new_shot_catches_another():
    scope = a_scope(900, span_ms=200, mode="single", level=0.5)
    assert (scope.picture(10).state, scope.picture(10).trigger_tick) == ("caught", 84)
    scope.take([out(tick, sine(tick)) for tick in range(900, 2000)])
    assert scope.picture(10).trigger_tick == 84
    scope.change(scope.settings._replace(shot=1))
    assert scope.picture(10).state == "waiting"
    scope.take([out(tick, sine(tick)) for tick in range(2000, 2400)])
    assert scope.picture(10).trigger_tick == 2084


def test_normal_waits_for_a_level_that_is_never_reached_and_auto_runs_free():
    assert a_scope(3000, mode="normal", level=2.0).picture(10).state == "waiting"
    free = a_scope(3000, mode="auto", level=2.0, span_ms=1000).picture(10)
    assert (free.state, free.start_tick, free.trigger_tick) == ("free", 2000, None)


def test_auto_runs_free_again_when_triggers_stop_coming():
    scope = a_scope(600, span_ms=100, mode="auto", level=0.5)
    assert scope.picture(10).state == "triggered"
    scope.take([out(tick, 0.0) for tick in range(600, 800)])
    assert scope.picture(10).state == "free"


def test_every_column_has_the_least_and_greatest_of_its_samples():
    """250 samples in 25 columns: ten each, compared with a plain loop over the function."""
    picture = a_scope(3000, span_ms=500, mode="normal", level=0.5).picture(50)
    trace = picture.traces[0]
    for column in range(50):
        samples = [sine(picture.start_tick + 10 * column + i) for i in range(10)]
        assert (trace.low[column], trace.high[column]) == (min(samples), max(samples)), column
    assert picture.traces[1].low == tuple(-value for value in trace.high), "the other signal is its mirror"


def test_fewer_samples_than_columns_are_shown_as_steps():
    trace = a_scope(3000, span_ms=20, mode="normal", level=0.5).picture(40).traces[0]
    assert len(trace.low) == 40
    assert trace.low == trace.high
    assert len(set(trace.low)) == 20


def test_a_signal_that_has_no_value_yet_has_none():
    scope = Scope(M2006, COLUMNS, ScopeSettings(("feedback1_radps", "x_m"), 100))
    scope.take([out(tick, 1.0) for tick in range(100)])
    feedback, x = scope.picture(10).traces
    assert all(math.isnan(value) for value in feedback.low)
    assert x.low == (1.0,) * 10


def test_a_jump_of_the_run_begins_anew():
    scope = a_scope(500, span_ms=100)
    scope.take([out(tick, 0.25) for tick in range(5000, 5050)])
    low = scope.picture(10).traces[0].low
    assert [value for value in low if not math.isnan(value)] == [0.25] * 5


def test_a_picture_after_others_is_the_one_that_a_fresh_scope_draws():
    """Run on, in other columns, over another time: nothing stays of what was drawn before."""
    scope, seen = a_scope(1000, span_ms=500, level=2.0), 1000
    later = ((1000, 500, 50), (1000, 500, 20), (1500, 500, 20), (1600, 200, 20), (1900, 500, 20))
    for end, span_ms, columns in later:
        scope.take([out(tick, sine(tick)) for tick in range(seen, end)])
        scope.change(scope.settings._replace(span_ms=span_ms))
        assert scope.picture(columns) == a_scope(end, span_ms=span_ms, level=2.0).picture(columns)
        seen = end


def test_a_run_that_goes_back_shows_its_new_way_though_the_trigger_comes_at_the_same_tick():
    scope = Scope(M2006, COLUMNS, ScopeSettings(("x_m",), 100, "normal", level=0.5))
    for height in (1.0, 2.0):
        scope.take([out(tick, 0.0 if tick < 700 else height) for tick in range(1000)])
        picture = scope.picture(10)
        assert (picture.trigger_tick, max(picture.traces[0].high)) == (700, height)


@given(
    st.sampled_from(SPANS_MS), st.sampled_from(["auto", "normal", "single"]), st.sampled_from(["rising", "falling"]),
    st.floats(-2.0, 2.0), st.integers(0, 900), st.integers(0, 300),
)  # fmt: skip
@settings(max_examples=60)
def test_any_settings_give_a_picture_of_that_many_columns(span, mode, edge, level, ticks, columns):
    picture = a_scope(ticks, span_ms=span, mode=mode, edge=edge, level=level).picture(columns)
    assert all(len(trace.low) == len(trace.high) == columns for trace in picture.traces)
    if picture.trigger_tick is not None and 0 < picture.trigger_tick < ticks:
        sign = 1.0 if edge == "rising" else -1.0
        assert sign * (sine(picture.trigger_tick) - level) > 0.0 >= sign * (sine(picture.trigger_tick - 1) - level)


def test_it_keeps_no_more_than_it_can_show():
    scope = Scope(M2006, COLUMNS, ScopeSettings(("x_m",), SPANS_MS[-1]))
    for start in range(0, 60_000, 1000):
        scope.take([out(tick, 0.0) for tick in range(start, start + 1000)])
    assert len(scope._samples["x_m"]) <= 1.3 * KEPT_TICKS
    assert not any(math.isnan(value) for value in scope.picture(100).traces[0].low)


def test_a_signal_chosen_now_has_a_past():
    tap = Tap(M2006, COLUMNS)
    for tick in range(1000):
        tap.add(out(tick, sine(tick)))
    tap.look(Look(scope=ScopeSettings(("x_m",), 500), columns=50))
    trace = tap.look(Look(scope=ScopeSettings(("y_m",), 500, level=9.0), columns=50)).scope.traces[0]
    assert not any(math.isnan(value) for value in trace.low)


def test_numbers_can_be_drawn_and_words_cannot():
    found = scope_signals(M2006, COLUMNS)
    assert set(names(M2006, COLUMNS)) - set(found) == {"link", "driver", "t_s"}
    with pytest.raises(ValueError, match="no signal is called 'speed'"):
        Tap(M2006, COLUMNS).look(Look(scope=ScopeSettings(("speed",))))


@pytest.mark.parametrize(
    ("low", "high", "scale"),
    [(0.0, 10.0, (0.0, 10.0)), (-17.0, 18.5, (-20.0, 20.0)), (3.0, 3.0, (2.0, 4.0)), (math.nan, math.nan, (-1.0, 1.0))],
)
def test_scales_are_round_numbers_around_what_is_there(low, high, scale):
    least, most = bounds(low, high)
    assert (least, most) == pytest.approx(scale)


@given(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_a_scale_always_holds_what_is_there(one, other):
    low, high = min(one, other), max(one, other)
    least, most = bounds(low, high)
    assert least <= low
    assert most >= high
    assert most > least
