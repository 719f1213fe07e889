"""The bus budget: the reference's load table, response times against published and simulated ones, verdicts."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.canbus import c610, dm3519
from bench.canbus.budget import budget, guaranteed_feedback_hz, response_times
from bench.canbus.streams import command_lengths, feedback_lengths, other_stream, streams

# m2006-c610 reference, section 2.3: motors, frames per ms, least, typical and bound in percent; and its verdicts.
TABLE = [
    (3, 4, 44.4, 47.8, 54.0, "guaranteed"),
    (4, 5, 55.5, 59.8, 67.5, "guaranteed"),
    (5, 7, 77.7, 83.8, 94.5, "guaranteed"),
    (6, 8, 88.8, 95.7, 108.0, "in practice"),
    (7, 9, 99.9, 107.6, 121.5, "too much"),
    (8, 10, 111.0, 119.6, 135.0, "too much"),
]


def percent(load):
    return round(100 * load, 1)


@pytest.mark.parametrize(("motors", "frames", "least", "typical", "bound", "verdict"), TABLE)
def test_loads_at_1_khz_both_ways(motors, frames, least, typical, bound, verdict):
    found = budget(streams(c610.FAMILY, range(1, motors + 1)))
    assert sum(row.stream.hz for row in found.rows) == 1000 * frames
    assert (percent(found.least), percent(found.typical), percent(found.worst)) == (least, typical, bound)
    assert found.verdict == verdict


@pytest.mark.parametrize(("command_hz", "about"), [(1000, 72), (500, 60)])
def test_eight_motors_fit_at_500_hz_of_feedback(command_hz, about):
    found = budget(streams(c610.FAMILY, range(1, 9), feedback_hz=500, command_hz=command_hz))
    assert round(100 * found.typical) == about
    assert found.verdict == "guaranteed"


def test_the_highest_ids_starve_first():
    eight = budget(streams(c610.FAMILY, range(1, 9)))
    assert [row.stream.can_id for row in eight.rows if row.is_lost] == [0x207, 0x208]
    assert eight.text == "does not fit: 0x207, 0x208 will get lost, 0x206 may be late"
    six = budget(streams(c610.FAMILY, range(1, 7)))
    assert six.text.startswith("fits in practice, not guaranteed")
    assert six.text.endswith("would delay 0x205, 0x206")


def test_typical_frames_are_as_long_as_the_reference_says():
    feedback, command = feedback_lengths(c610.FAMILY), command_lengths(c610.FAMILY, 0)
    assert feedback.typical == pytest.approx(119.4, abs=0.2)
    assert command.typical == pytest.approx(120.3, abs=0.3)
    assert feedback.resting == pytest.approx(123.2, abs=0.4)
    assert (command.resting, command_lengths(c610.FAMILY, 1).resting) == (126, 127)
    assert (feedback.least, feedback.worst, command.least, command.worst) == (111, 135, 111, 135)


def test_temperatures_stuff_less_than_zeros():
    assert feedback_lengths(dm3519.family()).typical < feedback_lengths(c610.FAMILY).typical


def test_response_times_of_three_motors():
    # one frame of 135 us under way, then all more urgent ones; the last has nobody behind it
    found = budget(streams(c610.FAMILY, (1, 2, 3)))
    assert [row.worst_us for row in found.rows] == [270, 405, 540, 540]
    assert [row.period_us for row in found.rows] == [1000] * 4


def test_half_the_bitrate_takes_twice_as_long():
    found = budget(streams(c610.FAMILY, (1, 2, 3), feedback_hz=500, command_hz=500), 500_000)
    assert [row.worst_us for row in found.rows] == [540, 810, 1080, 1080]
    assert percent(found.worst) == 54.0


def test_the_case_that_refuted_the_older_analysis():
    # Davis, Burns, Bril and Lukkien 2007: 1 ms frames every 2.5, 3.5 and 3.5 ms; the third's second instance is late
    assert response_times([(1000, 2500), (1000, 3500), (1000, 3500)]) == [2000, 3000, 3500]


def simulated(messages, offsets, span):
    """A bus, bit by bit where something happens: the longest wait of each message, everybody starting at `offsets`."""
    ready = [
        (offset + n * period, place)
        for place, ((_, period), offset) in enumerate(zip(messages, offsets, strict=True))
        for n in range(span // period)
    ]
    ready.sort()
    longest, queue, now = [0] * len(messages), [], 0
    while ready or queue:
        while ready and ready[0][0] <= now:
            born, place = ready.pop(0)
            queue.append((place, born))
        if not queue:
            now = ready[0][0]
            continue
        place, born = min(queue)
        queue.remove((place, born))
        now += messages[place][0]
        longest[place] = max(longest[place], now - born)
    return longest


message_sets = st.lists(st.tuples(st.integers(2, 12), st.integers(20, 80)), min_size=1, max_size=4)


@settings(max_examples=60)
@given(message_sets, st.data())
def test_no_simulated_bus_is_slower_than_the_bound(messages, data):
    bounds = response_times(messages)
    offsets = data.draw(st.tuples(*(st.integers(0, period) for _, period in messages)))
    for bound, longest in zip(bounds, simulated(messages, offsets, 4000), strict=True):
        assert bound is None or longest <= bound


def test_the_bound_is_reached():
    messages = [(4, 20), (4, 30), (6, 40)]
    slowest = [
        max(longest)
        for longest in zip(
            *(simulated(messages, offsets, 400) for offsets in itertools.product(range(8), range(8), range(8))),
            strict=True,
        )
    ]
    # the blocking frame must have begun one bit before: the bound counts it whole
    assert [bound - one for bound, one in zip(response_times(messages), slowest, strict=True)] == [1, 1, 0]


@given(st.lists(st.tuples(st.integers(1, 200), st.integers(0, 2000)), max_size=6))
def test_any_messages_get_an_answer(messages):
    found = response_times(messages)
    assert len(found) == len(messages)
    assert all(one is None or one >= bits for one, (bits, _) in zip(found, messages, strict=True))


def test_a_bus_that_is_all_but_full_gets_an_answer_soon():
    # 99.995 % full: what blocked it once would be caught up with after two thousand million bits
    assert response_times([(99_990, 100_000), (5, 100_001), (99_999, 10**9)])[1] is None


def test_the_highest_guaranteed_rate():
    for motors in (5, 6, 8):
        numbers = range(1, motors + 1)
        highest = guaranteed_feedback_hz(c610.FAMILY, numbers, command_hz=1000, bitrate=1_000_000)
        at = [budget(streams(c610.FAMILY, numbers, feedback_hz=hz)).verdict for hz in (highest, highest + 1)]
        assert at[0] == "guaranteed"
        assert at[1] != "guaranteed" or highest == 1000
    assert guaranteed_feedback_hz(c610.FAMILY, range(1, 9), command_hz=1000, bitrate=100_000) == 0


def test_a_gm6020_on_an_escs_identifier_is_a_clash():
    found = budget([*streams(c610.FAMILY, range(1, 6)), other_stream(0x205, 1000)])
    assert found.verdict == "clash"
    assert found.text == "clash: 0x205 is sent by C610_Feedback_5 and GM6020 1 or the like"
    assert budget([*streams(c610.FAMILY, range(1, 5)), other_stream(0x205, 1000)]).verdict == "guaranteed"


def test_other_frames_count_with_their_length():
    other = other_stream(0x101, 50, 4)
    assert (other.name, other.bits.least, other.bits.worst) == ("other", 79, 95)


def test_groups_that_have_no_motor_are_not_commanded():
    assert [one.can_id for one in streams(c610.FAMILY, (5, 8))] == [0x1FF, 0x205, 0x208]
    assert [one.can_id for one in streams(c610.FAMILY, (4, 5))] == [0x200, 0x1FF, 0x204, 0x205]
