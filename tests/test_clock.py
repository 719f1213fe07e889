"""Pacers: how much simulated time may pass, on a clock that the test turns by hand."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.io.clock import FreePacer, Metronome, WallPacer, now_ns
from bench.io.lateness import Lateness

MS = 1_000_000


class Clock:
    ns = 5_000_000_000

    def __call__(self):
        return self.ns

    def pass_ms(self, milliseconds):
        self.ns += int(milliseconds * MS)


def paced(**options):
    clock = Clock()
    return WallPacer(read_ns=clock, **options), clock


def test_a_millisecond_of_the_wall_is_a_tick():
    pacer, clock = paced()
    assert pacer.due(0) == 0
    clock.pass_ms(50)
    assert pacer.due(0) == 50
    assert pacer.due(50) == 0
    clock.pass_ms(0.999)
    assert pacer.due(50) == 0
    clock.pass_ms(0.001)
    assert pacer.due(50) == 1


def test_deadlines_are_absolute_so_fractions_are_not_lost():
    pacer, clock = paced()
    done = pacer.due(0)
    for _ in range(1000):
        clock.pass_ms(16.7)
        done += pacer.due(done)
    assert done == 16_700


def test_what_was_not_run_stays_due():
    pacer, clock = paced()
    pacer.due(0)
    clock.pass_ms(30)
    assert pacer.due(10) == 20


@pytest.mark.parametrize(("rate", "ticks"), [(0.1, 5), (0.5, 25), (2.0, 100), (4.0, 200)])
def test_a_rate_makes_slow_motion_or_haste(rate, ticks):
    pacer, clock = paced(rate=rate)
    pacer.due(0)
    clock.pass_ms(50)
    assert pacer.due(0) == ticks


def test_a_burst_bounds_what_runs_at_once_and_the_rest_slips():
    pacer, clock = paced(burst_ticks=100)
    pacer.due(0)
    clock.pass_ms(3000)
    assert pacer.due(0) == 100
    assert pacer.slipped_ticks == 2900
    clock.pass_ms(7)
    assert pacer.due(100) == 7, "what slipped does not come back"
    assert pacer.slipped_ticks == 2900


@given(
    st.lists(st.integers(0, 2000), max_size=60), st.integers(1, 300), st.sampled_from([0.1, 0.25, 1.0, 2.0]),
)  # fmt: skip
def test_every_tick_of_the_wall_is_run_or_slipped(passes, burst, rate):
    pacer, clock = paced(burst_ticks=burst, rate=rate)
    done, start = pacer.due(0), clock.ns
    for milliseconds in passes:
        clock.pass_ms(milliseconds)
        due = pacer.due(done)
        assert 0 <= due <= burst
        done += due
    assert done + pacer.slipped_ticks == int((clock.ns - start) * rate) // MS


def test_a_pause_is_no_delay():
    pacer, clock = paced()
    pacer.due(0)
    clock.pass_ms(20)
    done = pacer.due(0)
    pacer.restart()
    clock.pass_ms(60_000)
    assert pacer.due(done) == 0
    clock.pass_ms(5)
    assert pacer.due(done) == 5
    assert pacer.slipped_ticks == 0


def test_the_rate_changes_without_a_jump():
    pacer, clock = paced()
    pacer.due(0)
    clock.pass_ms(40)
    done = pacer.due(0)
    pacer.set_rate(0.5)
    assert pacer.due(done) == 0
    clock.pass_ms(40)
    assert pacer.due(done) == 20


def test_speed_and_lateness_are_measured_over_a_second():
    pacer, clock = paced(burst_ticks=40)
    done = pacer.due(0)
    assert pacer.speed is None
    for _ in range(20):
        clock.pass_ms(50)  # ten of the fifty slip each time
        done += pacer.due(done)
    assert pacer.speed == pytest.approx(0.76)  # the ticks of the last frame have not run yet: 19 of 20 frames count
    assert pacer.late_ticks == 40
    assert pacer.slipped_ticks == 200


def test_a_clock_that_stands_still_grants_nothing():
    pacer, _ = paced()
    assert [pacer.due(0) for _ in range(3)] == [0, 0, 0]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_that_leads_nowhere_is_refused(rate):
    with pytest.raises(ValueError, match="rate"):
        WallPacer(rate)


def test_a_burst_of_nothing_is_refused():
    with pytest.raises(ValueError, match="burst_ticks 0"):
        WallPacer(burst_ticks=0)


def test_the_real_clock_never_goes_back():
    pacer = WallPacer()
    assert pacer.due(0) == 0
    before = now_ns()
    assert now_ns() >= before


def test_a_free_pacer_always_grants_its_burst():
    pacer = FreePacer(17)
    assert [pacer.due(0), pacer.due(17)] == [17, 17]


# --- the metronome -----------------------------------------------------------------------------------------------


class Sleeper(Clock):
    """A clock that passes while somebody sleeps, `oversleeps_us` too long, and a little at every look."""

    oversleeps_us = 0
    slept_us = 0.0

    def __call__(self):
        self.ns += 100
        return self.ns

    def sleep(self, seconds):
        self.slept_us += seconds * 1e6
        self.ns += round(seconds * 1e9) + 1000 * self.oversleeps_us


def ticking(**options):
    clock = Sleeper()
    return Metronome(read_ns=clock, sleep=clock.sleep, **options), clock


def test_deadlines_do_not_drift():
    metronome, clock = ticking()
    start = clock.ns
    for _ in range(1000):
        metronome.wait()
        clock.pass_ms(0.3)
    assert clock.ns - start == pytest.approx(1000 * MS + 0.3 * MS, abs=2000)
    assert metronome.lateness.facts()["max_us"] < 1


def test_late_ticks_are_due_at_once_and_counted_each():
    metronome, clock = ticking()
    metronome.wait()
    clock.pass_ms(3.5)
    late = [metronome.wait() for _ in range(4)]
    assert [round(one / MS, 1) for one in late] == [2.5, 1.5, 0.5, 0.0]
    assert not metronome.is_behind
    assert metronome.lateness.over_1_ms == 2


def test_what_is_far_behind_slips():
    metronome, clock = ticking()
    metronome.wait()
    clock.pass_ms(1000)
    metronome.wait()
    assert metronome.slipped_ticks == 999
    metronome.wait()
    assert metronome.lateness.ticks == 3


def test_spinning_is_given_up_where_it_is_of_no_use():
    metronome, clock = ticking()
    metronome.wait()
    assert clock.slept_us == pytest.approx(950, abs=2), "it wakes a little before"
    clock.oversleeps_us = 400
    metronome.wait()
    clock.oversleeps_us = 0
    metronome.wait()
    clock.slept_us = 0
    metronome.wait()
    assert clock.slept_us == pytest.approx(1000, abs=2), "after a miss it sleeps to the deadline"
    for _ in range(2500):
        metronome.wait()
    clock.slept_us = 0
    metronome.wait()
    assert clock.slept_us < 995, "and tries again after a calm while"


def test_percentiles_of_lateness_by_hand():
    lateness = Lateness()
    assert lateness.facts()["p99_us"] == 0.0
    for late_us in [*range(1, 100), 5000]:
        lateness.add(late_us * 1000)
    facts = lateness.facts()
    assert (facts["p50_us"], facts["p99_us"], facts["max_us"]) == (51.0, 100.0, 5000.0)
    assert (facts["p999_us"], facts["over_1_ms_percent"]) == (5000.0, 1.0)
