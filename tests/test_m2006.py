"""C610 frames against literal bytes (m2006-c610 reference, section 1.5), and both ends of the bus."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.canbus.watch import Kind
from bench.config import load_robot
from bench.m2006 import (
    EmulatedEscs,
    MotorBus,
    decode_command,
    decode_feedback,
    describe,
    encode_command,
    encode_feedback,
)

ROBOT = load_robot("m2006")

COMMANDS = [
    ((0, 0, 0, 0), "00 00 00 00 00 00 00 00"),
    ((1000, 1000, 1000, 0), "03 E8 03 E8 03 E8 00 00"),
    ((-1000, -1000, -1000, 0), "FC 18 FC 18 FC 18 00 00"),
    ((600, 600, 600, 0), "02 58 02 58 02 58 00 00"),
    ((10000, -10000, 10000, -10000), "27 10 D8 F0 27 10 D8 F0"),
]
FEEDBACK = [
    ((0, 0, 0), "00 00 00 00 00 00 00 00"),
    ((4321, 12300, 850), "10 E1 30 0C 03 52 00 00"),
    ((17, -12300, -850), "00 11 CF F4 FC AE 00 00"),
    ((8191, -1, -1), "1F FF FF FF FF FF 00 00"),
]


@pytest.mark.parametrize(("currents", "text"), COMMANDS)
def test_command_bytes(currents, text):
    assert encode_command(currents) == bytes.fromhex(text)
    assert decode_command(bytes.fromhex(text)) == currents


@pytest.mark.parametrize(("fields", "text"), FEEDBACK)
def test_feedback_bytes(fields, text):
    assert encode_feedback(*fields) == bytes.fromhex(text)
    assert decode_feedback(bytes.fromhex(text)) == fields


@pytest.mark.parametrize("raw", [10001, -10001, 40000])
def test_a_command_beyond_the_esc_is_refused(raw):
    with pytest.raises(ValueError, match=rf"current_1 {raw} outside -10000\.\.10000"):
        encode_command((raw, 0, 0, 0))


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_any_frame_is_survived_at_both_ends(can_id, data):
    MotorBus(ROBOT).receive(0, [(can_id, data)])
    EmulatedEscs(ROBOT).receive(0, [(can_id, data)])
    describe(can_id, data)


def test_frames_of_a_wrong_length_are_counted_and_dropped():
    bus, escs = MotorBus(ROBOT), EmulatedEscs(ROBOT)
    bus.receive(0, [(0x201, b"\x00" * 7), (0x205, b"\x00" * 8)])
    assert (bus.malformed_frames, bus.foreign_frames) == (1, 1)
    assert escs.receive(0, [(0x200, b"\x03\xe8" * 3)]) == [0, 0, 0]
    assert escs.malformed_frames == 1
    assert [(one.kind, one.can_id) for one in escs.watch.findings] == [(Kind.LENGTH, 0x200)]
    good = (0x200, bytes.fromhex("03E8 03E8 03E8 0000"))
    assert escs.receive(1, [(0x200, b""), good]) == [-1.0, -1.0, -1.0], "and the next frame is taken"


def test_positive_wheel_current_is_negative_on_this_robots_wire():
    # document 004: positive current on the wire drives the clockwise tangent; wheels count counter-clockwise
    assert MotorBus(ROBOT).command([0.3, -0.2, 0.0]) == ((0x200, bytes.fromhex("FED4 00C8 0000 0000")),)
    assert EmulatedEscs(ROBOT).receive(0, [(0x200, bytes.fromhex("FED4 00C8 0000 0000"))]) == [0.3, -0.2, 0.0]


@pytest.mark.parametrize(
    ("current_a", "raw"),
    [
        (0.5994, -599),
        (0.6, -600),
        (-0.6, 600),
        (0.6006, -600),
        (5.0, -600),
        (-5.0, 600),
        (math.inf, -600),
        (-math.inf, 600),
        (math.nan, 0),
    ],
)
def test_the_last_line_before_the_port_clamps(current_a, raw):
    ((_, data),) = MotorBus(ROBOT).command([current_a, 0.0, 0.0])
    assert decode_command(data)[0] == raw


def feedback_for(wheel_rad, tick_speed=0.0):
    return EmulatedEscs(ROBOT).feedback([wheel_rad] * 3, [tick_speed] * 3, [0.0] * 3)


def test_feedback_shows_the_rotor_behind_the_gear():
    # A tenth of a wheel turn is 3.6 rotor turns; on this robot's wire a positive turn counts down.
    frames = feedback_for(math.tau / 10)
    assert [can_id for can_id, _ in frames] == [0x201, 0x202, 0x203]
    angle, _, _ = decode_feedback(frames[0][1])
    assert angle == pytest.approx((-3.6 * 8192) % 8192, abs=1)


def test_reported_speed_settles_at_rotor_rpm_within_its_filter():
    escs = EmulatedEscs(ROBOT)
    at_rest = escs.feedback([0.0] * 3, [0.0] * 3, [0.0] * 3)
    assert [data for _, data in at_rest] == [bytes(8)] * 3, "bytes 6 and 7 are empty on a C610"
    full = -10.0 * 36 * 60 / math.tau
    for tick in range(1, 12):
        frames = escs.feedback([0.0] * 3, [10.0] * 3, [0.0] * 3)
        _, rpm, _ = decode_feedback(frames[0][1])
        assert rpm == pytest.approx(full * (1 - math.exp(-tick / 10)), abs=1)  # after 10 ms, a 10 ms filter is at 63 %


@pytest.mark.parametrize(
    ("rotor_rpm", "reported"),
    [(32767.4, 32767), (32767.6, 32767), (-32768.4, -32768), (-32768.6, -32768), (1e9, 32767)],
)
def test_a_rotor_speed_beyond_its_field_saturates_and_does_not_wrap(rotor_rpm, reported):
    escs = EmulatedEscs(replace(ROBOT, motor=replace(ROBOT.motor, speed_filter_ms=0.0)))
    wheel_radps = -rotor_rpm / 36 * math.tau / 60
    for _, data in escs.feedback([0.0] * 3, [wheel_radps] * 3, [0.0] * 3):
        assert decode_feedback(data)[1] == reported


@given(st.lists(st.floats(-80, 80), min_size=1, max_size=60))
def test_increments_follow_the_wheels_through_every_wrap(speeds):
    bus, angle = MotorBus(ROBOT), 0.0
    bus.receive(0, feedback_for(angle))
    total = 0.0
    for tick, speed in enumerate(speeds, start=1):
        angle += speed / 1000
        bus.receive(tick, feedback_for(angle))
        total += bus.take_increments()[0]
    assert total == pytest.approx(angle, abs=2 * math.tau / (36 * 8192))
    assert bus.speeds_radps[0] == pytest.approx(speeds[-1], abs=0.05)


def test_a_base_keeps_what_each_esc_last_reported():
    bus = MotorBus(ROBOT)
    bus.receive(0, [(0x202, encode_feedback(8191, -12300, -850)), (0x203, encode_feedback(0, 9, 8))])
    bus.receive(1, [(0x202, encode_feedback(818, 12300, 850))])
    assert (bus.rotor_rpm, bus.currents_ma) == ([0, 12300, 9], [0, 850, 8])
    # 819 counts through the wrap, in a millisecond; a positive turn of the wheel counts down.
    turned_rad = -819 * math.tau / (36 * 8192)
    assert bus.take_increments() == pytest.approx([0.0, turned_rad, 0.0], rel=1e-12)
    assert bus.speeds_radps == pytest.approx([0.0, turned_rad / 0.001, 0.0], rel=1e-12)


def test_silence_is_counted_from_the_last_frame_and_at_first_from_the_beginning():
    bus = MotorBus(ROBOT)
    assert (bus.silent_ticks(0), bus.silences(0), bus.complete) == (1, [1, 1, 1], False)
    bus.receive(0, feedback_for(0.0)[:1])
    assert (bus.silent_ticks(4), bus.silences(4), bus.complete) == (5, [4, 5, 5], False)
    bus.receive(5, feedback_for(0.0)[1:])
    assert (bus.silent_ticks(7), bus.silences(7), bus.complete) == (7, [7, 2, 2], True)


def test_all_wheels_may_report_in_the_first_tick():
    bus = MotorBus(ROBOT)
    bus.receive(0, feedback_for(0.0))
    assert bus.complete
    bus.take_increments()
    assert not bus.complete


def test_one_lost_frame_loses_no_motion():
    bus = MotorBus(ROBOT)
    bus.receive(0, feedback_for(0.0))
    bus.take_increments()
    bus.receive(1, feedback_for(0.02)[1:])
    assert not bus.complete
    bus.receive(2, feedback_for(0.04))
    assert bus.complete
    assert bus.take_increments() == pytest.approx([0.04] * 3, abs=1e-4)
    assert bus.speeds_radps == pytest.approx([20.0] * 3, abs=0.1)


_ONE_TICK = st.tuples(
    st.integers(1, 4),  # ticks since the one before
    st.sampled_from(["all", "all", "all", "all", "all", "all", "two", "none", "twice", "short", "foreign"]),
    st.lists(st.integers(0, 9000), min_size=3, max_size=3),
)


class ByWheel:
    """What the feedback of three wheels adds up to, in counts of the wire, each wheel by itself."""

    def __init__(self):
        self.heard, self.last, self.turned_counts, self.taken = [-1] * 3, [None] * 3, [0] * 3, -1
        self.late_ticks = self.longest_ticks = 0
        """By how much a report was seen to be late, at least; the longest gap since counts were last taken."""

    def turned(self, tick, frames):
        before = list(self.heard)
        self.late_ticks = max(self.late_ticks, int(len({can_id for can_id, _ in frames}) < len(frames)))
        for can_id, data in frames:
            wheel = can_id - 0x201
            if wheel in range(3) and len(data) == 8:
                angle = data[0] * 256 + data[1]
                if self.last[wheel] is not None:
                    self.turned_counts[wheel] += (angle - self.last[wheel] + 4096) % 8192 - 4096
                    self.longest_ticks = max(self.longest_ticks, tick - before[wheel])
                self.heard[wheel], self.last[wheel] = tick, angle
        if min(self.heard) <= self.taken:
            return None
        counts, self.turned_counts, self.taken = self.turned_counts, [0] * 3, tick
        return counts


@given(st.lists(_ONE_TICK, max_size=25))
def test_in_which_order_the_reports_of_a_tick_arrive_makes_no_difference(ticks):
    """In wheel order, tick after tick, they take a way of their own through the bus; turned round they do not."""
    usual, unusual, plain, tick = MotorBus(ROBOT), MotorBus(ROBOT), ByWheel(), -1
    for gap, what, angles in ticks:
        tick += gap
        # They say that their rotors stand: over more than one lost frame an angle may contradict that.
        reports = [(0x201 + i, angle.to_bytes(2, "big") + bytes((0, 0, 2, i, 0, 0))) for i, angle in enumerate(angles)]
        frames = {
            "two": reports[1:], "none": [], "twice": reports * 2,
            "short": [*reports[:2], (0x203, bytes(7))], "foreign": [(0x205, bytes(8)), *reports],
        }.get(what, reports)  # fmt: skip
        turned_rad = usual.turned(tick, frames)
        assert turned_rad == unusual.turned(tick, sorted(frames, reverse=True))
        counts = plain.turned(tick, frames)
        if turned_rad == []:
            assert plain.longest_ticks + plain.late_ticks > 2
        else:
            found = turned_rad if turned_rad is None else [round(rad * -36 * 8192 / math.tau) for rad in turned_rad]
            assert found == counts
        if counts is not None:
            plain.longest_ticks = 0
        for name in ("speeds_radps", "currents_ma", "rotor_rpm", "complete", "quietest_tick", "malformed_frames"):
            assert getattr(usual, name) == getattr(unusual, name), name
        assert usual.silences(tick) == unusual.silences(tick) == [tick - heard for heard in plain.heard]


def test_a_tick_like_the_one_before_is_not_kept_by_wheel():
    class Counting(MotorBus):
        by_wheel = 0

        def receive(self, tick, frames):
            self.by_wheel += 1
            super().receive(tick, frames)

    bus = Counting(ROBOT)
    for tick in range(100):
        assert bus.turned(tick, feedback_for(tick / 1000)) is not None
    assert bus.by_wheel == 1, "the first tick has none before it"


@pytest.mark.parametrize(("policy", "expected"), [("hold", [0.3, 0.3]), ("zero", [0.3, 0.0])])
def test_command_loss(policy, expected):
    motor = replace(ROBOT.motor, on_command_loss=policy, command_timeout_ms=50)
    escs = EmulatedEscs(replace(ROBOT, motor=motor))
    escs.receive(100, MotorBus(ROBOT).command([0.3] * 3))
    assert [escs.receive(149, ())[0], escs.receive(150, ())[0]] == expected


def test_esc_ids_above_four_use_the_second_group():
    wheels = tuple(replace(wheel, can_id=i) for wheel, i in zip(ROBOT.wheels, (4, 5, 8), strict=True))
    robot = replace(ROBOT, wheels=wheels)
    frames = MotorBus(robot).command([0.1, 0.2, 0.3])
    assert frames == ((0x200, bytes.fromhex("0000 0000 0000 FF9C")), (0x1FF, bytes.fromhex("FF38 0000 0000 FED4")))
    assert EmulatedEscs(robot).receive(0, frames) == pytest.approx([0.1, 0.2, 0.3])


def test_fields_by_name():
    assert describe(0x1FF, encode_command((1, 2, 3, 4))) == {
        "current_5_ma": 1,
        "current_6_ma": 2,
        "current_7_ma": 3,
        "current_8_ma": 4,
    }
    assert describe(0x201, bytes.fromhex("10 E1 30 0C 03 52 00 00")) == {
        "angle_counts": 4321,
        "speed_rpm": 12300,
        "current_ma": 850,
    }
    assert describe(0x300, b"") == {}
