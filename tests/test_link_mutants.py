"""What a change in the link machine would break and no other test sees: words, counts and limits, as literals."""

from dataclasses import replace

import pytest

from bench import link as machine
from bench.config import LinkLimits, load_profile
from bench.link import HOLD, LIVE, NEUTRAL, RcLink
from bench.messages import RcFrame, RcLinkStatistics, RcNoise

MOVED = (2048, 2048, 1024, 2048, 0, 0)


def a_link(**changes):
    return RcLink(replace(load_profile("uart12"), **changes), LinkLimits())


def frame(channels=MOVED, **flags):
    return RcFrame(0, 12, channels, **flags)


def test_states_have_the_names_that_recordings_hold():
    states = (
        machine.NEVER_SEEN,
        machine.LIVE,
        machine.DEGRADED,
        machine.HOLD,
        machine.NEUTRAL,
        machine.LOST,
    )
    assert states == ("never seen", "live", "degraded", "hold", "neutral", "lost")


def test_a_new_link_knows_nothing():
    link = a_link()
    assert (link.reason, link.last_good_tick) == ("no frame yet", -1)
    assert (link.frames, link.flagged_frames, link.noise_bytes) == (0, 0, 0)


def test_frames_are_counted_apart_from_flagged_ones_and_noise():
    link = a_link()
    link.step(7, [frame(), RcNoise(12, 5, "header"), frame()])
    link.step(9, [frame(failsafe=True), frame(failsafe=True), frame(frame_lost=True), RcNoise(53, 2, "cut")])
    assert (link.frames, link.flagged_frames, link.noise_bytes) == (2, 3, 7)
    assert (link.last_good_tick, link.age_ticks(12)) == (7, 5)


@pytest.mark.parametrize(
    ("age", "reason"),
    [
        (25, ""),
        (26, "silence"),
        (100, "no good frame for 100 ms"),
        (500, "no good frame for 500 ms"),
    ],
)
def test_silence_says_for_how_long(age, reason):
    link = a_link()
    link.step(3, [frame()])
    link.step(3 + age, ())
    assert link.reason == reason


def test_a_slow_transmitter_is_quiet_only_where_it_would_be_neutral():
    link = a_link(period_ms=50)  # 2.5 periods are more than the 100 ms of hold
    link.step(0, [frame()])
    assert [link.step(tick, ()) for tick in (98, 99, 100)] == [LIVE, LIVE, NEUTRAL]


def test_words_of_what_takes_the_command_away():
    link = a_link(max_travel=0.5)
    link.step(0, [frame((2048, 2048, 0, 2048, 0, 0))])
    link.step(1, [frame()])
    link.step(2, [frame((2048, 2048, 0, 2048, 0, 0))])
    assert link.reason == "sticks out of travel"
    link.step(3, [RcLinkStatistics(0, 14, 0, -100, 0)])
    assert link.reason == "link quality 0"
    link.step(4, [frame()])
    assert link.reason == "link quality 0"


def test_sticks_are_frozen_for_as_long_as_they_have_not_moved():
    link = a_link(frozen_ms=300)
    for tick in range(1000, 1200):
        assert link.step(tick, [frame((2048, 2048, 1000 + tick % 2, 2048, 0, 0))]) == LIVE
    states = [link.step(tick, [frame()]) for tick in range(1200, 1501)]
    assert states == [LIVE] * 300 + [NEUTRAL]
    assert link.reason == "sticks frozen for 300 ms"
    assert link.step(1501, [frame((2048, 2048, 1023, 2048, 0, 0))]) == LIVE


def test_on_uart12_any_channel_that_is_not_zero_makes_a_frame():
    link = a_link()
    assert link.step(0, [frame((0, 7, 0, 0, 0, 0))]) == LIVE
    assert link.step(1, [frame((0, 0, 0, 0, 0, 0))]) == NEUTRAL


def test_hold_begins_after_two_and_a_half_periods():
    link = a_link(period_ms=4)
    link.step(0, [frame()])
    assert [link.step(tick, ()) for tick in (10, 11)] == [LIVE, HOLD]
