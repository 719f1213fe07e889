"""Who should not be on the bus: every kind of finding, its sentence, and memory that does not grow."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.canbus.watch import BusWatch, Kind


def heard(frames, numbers=(1, 2, 3), also=()):
    watch = BusWatch(numbers, also)
    for tick, can_id, *length in frames:
        watch.hear(tick, can_id, *(length or [8]))
    return watch


def only(watch):
    (finding,) = watch.findings
    return finding


def test_a_bus_as_it_should_be_has_no_findings():
    frames = [(tick, can_id) for tick in range(50) for can_id in (0x200, 0x201, 0x202, 0x203)]
    assert heard(frames).findings == ()


@pytest.mark.parametrize(
    ("can_id", "kind", "says"),
    [
        (0x204, Kind.UNKNOWN_ESC, "an ESC with ID 4, which the robot file does not have"),
        (0x205, Kind.UNKNOWN_ESC, "an ESC with ID 5 or a GM6020 with ID 1, which"),
        (0x208, Kind.UNKNOWN_ESC, "an ESC with ID 8 or a GM6020 with ID 4, which"),
        (0x20B, Kind.UNKNOWN_ESC, ": a GM6020 with ID 7, which"),
        (0x20C, Kind.FOREIGN, "no motor or controller of this bus"),
        (0x700, Kind.QUICK_ID, "puts every C610 into quick-ID mode"),
        (0x7FF, Kind.FOREIGN, "no motor"),
    ],
)
def test_frames_that_do_not_belong_here(can_id, kind, says):
    finding = only(heard([(1500, can_id), (1501, can_id)]))
    assert (finding.kind, finding.can_id, finding.first_tick, finding.last_tick, finding.count) == (
        kind,
        can_id,
        1500,
        1501,
        2,
    )
    assert finding.text.startswith(f"0x{can_id:03X} {kind}, 2 times since 1.500 s: ")
    assert says in finding.text


def test_what_the_motors_kind_also_has_belongs_here():
    assert heard([(0, 0x7FF, 4), (0, 0x7FF, 8)], also=(0x7FF,)).findings == ()


def test_a_wrong_length():
    finding = only(heard([(0, 0x201, 7)]))
    assert (finding.kind, finding.count) == (Kind.LENGTH, 1)
    assert finding.text == "0x201 wrong length, once since 0.000 s: command and feedback frames have 8 bytes"


@pytest.mark.parametrize(
    ("can_id", "says"),
    [
        (0x201, "two ESCs with ID 1; a C610 whose ID is taken stops and blinks orange twice"),
        (0x206, "two ESCs with ID 6, or a GM6020 with ID 2; a C610"),
        (0x200, "two controllers command this group, and each sets all four currents"),
    ],
)
def test_two_senders_on_one_identifier(can_id, says):
    frames = [(tick, can_id) for tick in range(40) for _ in range(2)]
    finding = only(heard(frames, numbers=(1, 6)))
    assert (finding.kind, finding.first_tick, finding.last_tick) == (Kind.TWO_SENDERS, 7, 39)
    assert says in finding.text


def test_a_reader_that_is_late_is_no_second_sender():
    # a tick without a frame, then one with two; and one with fifty after a long pause
    late = [(tick, 0x201) for tick in range(1, 400, 2) for _ in range(2)]
    assert heard(late).findings == ()
    assert heard([(0, 0x201)] * 50 + [(tick, 0x201) for tick in range(1, 100)]).findings == ()


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 0x1FFFFFFF), st.integers(0, 64)), max_size=300))
def test_any_bus_is_survived_in_bounded_memory(frames):
    watch = heard(sorted(frames))
    assert len(watch.findings) <= 64
    assert all(finding.text for finding in watch.findings)


def test_memory_does_not_grow():
    watch = heard([(tick, can_id) for tick in range(10) for can_id in range(0x300, 0x600) for _ in range(2)])
    assert len(watch.findings) == 64
    # the 64 identifiers whose ticks are remembered are two senders each from tick 7 on, and there is no room for that
    assert watch.unlisted == 10 * 2 * 0x300 - 64 * 20 + 64 * 3
    assert max(len(watch._at), len(watch._twice)) <= 64
