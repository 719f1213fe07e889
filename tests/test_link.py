"""Link supervision at, below and above each limit. The limits are design decisions, written here as literals."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.config import LinkLimits, load_profile
from bench.link import DEGRADED, HOLD, LIVE, LOST, NEUTRAL, NEVER_SEEN, RcLink
from bench.messages import RcFrame, RcLinkStatistics, RcNoise

REST = (2048, 2048, 2048, 2048, 0, 0)
MOVED = (2048, 2048, 1024, 2048, 0, 0)


def frame(channels=MOVED, **flags):
    return RcFrame(0, 12, channels, **flags)


def a_link(**changes):
    return RcLink(replace(load_profile("uart12"), **changes), LinkLimits())


def live_link(first=MOVED, **changes):
    link = a_link(**changes)
    assert link.step(0, [frame(first)]) == LIVE
    return link


def test_boot_is_never_seen_for_ever():
    link = a_link()
    assert [link.step(tick, ()) for tick in range(2000)] == [NEVER_SEEN] * 2000
    assert link.age_ticks(2000) is None


@pytest.mark.parametrize(
    ("age", "state"),
    [
        (1, LIVE),
        (25, LIVE),
        (26, HOLD),
        (99, HOLD),
        (100, NEUTRAL),
        (101, NEUTRAL),
        (499, NEUTRAL),
        (500, LOST),
        (9999, LOST),
    ],
)
def test_silence(age, state):
    link = live_link()
    assert link.step(age, ()) == state
    assert link.age_ticks(age) == age


@pytest.mark.parametrize(
    ("age", "state"), [(10, DEGRADED), (99, DEGRADED), (100, NEUTRAL), (499, NEUTRAL), (500, LOST)]
)
def test_frames_flagged_lost_do_not_refresh(age, state):
    link = live_link()
    for tick in range(10, age + 1):
        link.step(tick, [frame(frame_lost=True)] if tick % 10 == 0 or tick == age else ())
    assert (link.state, link.reason) == (state, "frame lost")
    assert link.last_good_tick == 0


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        (frame(failsafe=True), "failsafe flag"),
        (frame(failsafe=True, frame_lost=True), "failsafe flag"),
        (frame((0, 0, 0, 0, 0, 0)), "all channels 0"),
        (RcLinkStatistics(0, 14, 0, -108, 11), "link quality 0"),
        (frame((2048, 2048)), "channels missing"),
    ],
)
def test_what_says_loss_is_neutral_at_once_and_lost_in_time(event, reason):
    link = live_link()
    assert link.step(10, [event]) == NEUTRAL
    assert link.reason == reason
    assert link.step(499, [event]) == NEUTRAL
    assert link.step(500, [event]) == LOST
    assert link.reason == reason


def test_a_good_frame_ends_a_failsafe():
    link = live_link()
    link.step(10, [frame(failsafe=True)])
    assert link.step(11, ()) == NEUTRAL
    assert link.step(20, [frame()]) == LIVE


def test_quality_zero_holds_until_quality_returns():
    link = live_link()
    link.step(10, [RcLinkStatistics(0, 14, 0, -108, 11)])
    assert link.step(20, [frame()]) == NEUTRAL
    assert link.step(30, [RcLinkStatistics(0, 14, 100, -70, 8), frame()]) == LIVE


def test_quality_zero_before_the_first_frame_is_told():
    link = a_link()
    assert link.step(0, [RcLinkStatistics(0, 14, 0, -108, 11)]) == NEVER_SEEN
    assert link.reason == "link quality 0"


@pytest.mark.parametrize(("last", "state"), [(299, LIVE), (300, NEUTRAL), (301, NEUTRAL)])
def test_frozen_sticks_where_the_profile_asks_for_it(last, state):
    link = live_link(frozen_ms=300)
    for tick in [*range(1, last, 10), last]:
        link.step(tick, [frame()])
    assert link.state == state


def test_sticks_at_rest_may_stand_still():
    link = a_link(frozen_ms=300)
    assert {link.step(tick, [frame(REST)]) for tick in range(0, 2000, 10)} == {LIVE}


def test_frozen_is_off_by_default():
    link = a_link()
    assert {link.step(tick, [frame()]) for tick in range(0, 5000, 10)} == {LIVE}


def test_noise_counts_and_changes_nothing():
    link = live_link()
    assert link.step(10, [RcNoise(12, 7, "header")]) == LIVE
    assert link.noise_bytes == 7
    assert link.step(100, [RcNoise(19, 5, "header")]) == NEUTRAL


@pytest.mark.parametrize(("beyond", "state"), [(224, LIVE), (225, LIVE), (226, NEUTRAL)])
def test_sticks_out_of_travel_where_the_profile_asks_for_it(beyond, state):
    # i-BUS in microseconds: 1500 +- 500, and 1.45 of that is 725 away: 775 and 2225 are the last that count
    axis = {"middle": 1500, "travel": 500.0}
    profile = load_profile("uart12")
    axes = {name: replace(getattr(profile, name), **axis) for name in ("forward", "right", "clockwise")}
    link = live_link((1500, 1500, 1600, 1500, 0, 0), max_travel=1.45, **axes)
    raw = 2000 + beyond
    assert link.step(10, [frame((1500, 1500, raw, 1500, 0, 0))]) == state
    assert link.step(20, [frame((1500, 1500, 3000 - raw, 1500, 0, 0))]) == state


def test_travel_is_not_watched_by_default():
    assert live_link().step(10, [frame((2048, 2048, 4095, 2048, 0, 0))]) == LIVE


CROSSFIRE_REST = (172, 992, 992, 992, *[992] * 12)


@pytest.mark.parametrize(
    ("channels", "state"),
    [
        ((172, 0, 0, 0, *[992] * 12), NEUTRAL),  # "no pulses": what the transmitter drives is 0, the rest may not be
        ((172, 0, 0, 1, *[992] * 12), LIVE),
        ((0, 992, 992, 992, *[0] * 12), LIVE),
    ],
)
def test_zeros_on_all_used_channels_say_loss(channels, state):
    link = RcLink(load_profile("crossfire"), LinkLimits())
    assert link.step(0, [RcFrame(0, 26, CROSSFIRE_REST)]) == LIVE
    assert link.step(4, [RcFrame(26, 26, channels)]) == state


def test_quality_is_what_the_receiver_last_said():
    link = live_link()
    assert link.quality_percent is None
    link.step(1, [RcLinkStatistics(12, 14, 87, -60, 9)])
    assert link.quality_percent == 87
    link.step(2, [RcLinkStatistics(26, 14, 3, -100, 1)])
    assert link.quality_percent == 3


@pytest.mark.parametrize(("forward", "state"), [(2048 + 128, LIVE), (2048 + 129, NEUTRAL), (2048 - 129, NEUTRAL)])
def test_sticks_at_the_edge_of_the_dead_band_may_rest_for_ever(forward, state):
    channels = (2048, 2048, forward, 2048, 0, 0)
    link = live_link(channels, frozen_ms=300, dead_band=0.0625)  # 128 of 2048
    states = [link.step(tick, [frame(channels)]) for tick in range(1, 302)]
    assert states[298] == LIVE
    assert states[-1] == state


@pytest.mark.parametrize(("forward", "state"), [(2048 - 1024, LIVE), (2048 - 1025, NEUTRAL), (2048 + 1025, NEUTRAL)])
def test_the_end_of_the_travel_still_belongs_to_it(forward, state):
    link = live_link(max_travel=0.5)
    assert link.step(1, [frame((2048, 2048, forward, 2048, 0, 0))]) == state


def test_a_frame_that_lacks_only_the_last_used_channel_is_refused():
    link = live_link()
    assert link.step(1, [frame(MOVED[:5])]) == NEUTRAL
    assert link.reason == "channels missing"


_NEWS = st.sampled_from(
    [frame(), frame(REST), frame(frame_lost=True), frame(failsafe=True), RcNoise(0, 3, "header"),
     RcLinkStatistics(0, 14, 0, -108, 11), RcLinkStatistics(0, 14, 99, -60, 11)]
)  # fmt: skip


@given(st.lists(st.tuples(st.sampled_from([1, 2, 10, 25, 26, 27, 75, 101, 501]), _NEWS), max_size=8))
def test_what_is_left_out_before_review_tick_changes_nothing(news):
    always, mostly_not, now = a_link(), a_link(), 0
    for silence, event in [*news, (600, frame())]:
        for tick in range(now, now + silence):
            always.step(tick, ())
            if tick >= mostly_not.review_tick:
                mostly_not.step(tick, ())
            assert (mostly_not.state, mostly_not.reason) == (always.state, always.reason)
        now += silence
        assert mostly_not.step(now, [event]) == always.step(now, [event])
        now += 1


def test_review_tick_is_the_first_in_which_silence_is_news():
    link = a_link()
    link.step(40, [frame()])
    assert link.step(link.review_tick - 1, ()) == LIVE
    assert link.step(link.review_tick, ()) == HOLD
