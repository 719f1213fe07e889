"""Our master: its schedule, what it makes of answers, and core against base over bytes."""

import math
import random

import pytest
from damage import add_a_byte, drop_a_byte, flip_one_bit
from hypothesis import given, settings
from hypothesis import strategies as st
from slamware_vendor import frame

from bench.messages import BodyTwist
from bench.slamware import SlamwareBase, SlamwareCore, encode_frame
from bench.slamware.payloads import Displacement
from bench.slamware.reference_base import reference_facts
from bench.slamware.senses import Motion

CONNECT = bytes.fromhex("10 03 F8 10 01 FA")
HALT = bytes.fromhex("10 0E F8 41 000000000000000000000000 A7")
IDENTITY = frame("connect-std.reply")
NO_MOTION = bytes.fromhex("50 0E 00 02 00000000 00000000 00000000 00 5C")
BAD_CHECKSUM_OF_THE_REFERENCE = bytes.fromhex("50 03 00 03 C0 00 90")
NOT_SUPPORTED = bytes.fromhex("50 03 00 03 00 80 D0")


def sent(core, first, last, answers=()):
    """[(tick, bytes)] that leave in first..last, while answers {tick: bytes} arrive."""
    answers = dict(answers)
    steps = [(tick, core.step(tick, answers.get(tick, b""))) for tick in range(first, last + 1)]
    return [(tick, data) for tick, data in steps if data]


def asked(core, first, last, answers=()):
    """The same without what brings a lost line back: the requests of 0xF8."""
    return [(tick, data) for tick, data in sent(core, first, last, answers) if data[2] == 0xF8]


def connected_core(**settings_):
    core = SlamwareCore(**settings_)
    assert core.step(0, b"") == CONNECT
    assert core.step(1, IDENTITY) == b""
    assert core.connected
    return core


# --- schedule ----------------------------------------------------------------------------------------------------


def test_connects_once_per_second_until_it_is_answered():
    core = SlamwareCore()
    assert asked(core, 0, 3500) == [(0, CONNECT), (1000, CONNECT), (2000, CONNECT), (3000, CONNECT)]
    assert not core.connected
    assert core.timeouts == 4


def test_a_refused_handshake_is_repeated_a_second_later():
    core = SlamwareCore()
    assert asked(core, 0, 1500, {1: NOT_SUPPORTED}) == [(0, CONNECT), (1000, CONNECT)]
    assert core.errors == {0x8000: 1}
    assert not core.connected


def test_polls_at_20_hz_once_connected_and_answered():
    core = SlamwareCore()
    answers = {1: IDENTITY} | {tick: NO_MOTION for tick in range(51, 1100, 50)}
    got = sent(core, 0, 1050, answers)
    assert got == [(0, CONNECT), *((tick, HALT) for tick in range(50, 1051, 50))]
    assert core.identity.model == "ref base"
    assert core.answers == {0x10: 1, 0x41: 20}
    assert core.requests == {0x10: 1, 0x41: 21}
    assert [event.kind for event in core.events] == ["connected"]


def test_the_period_is_a_setting():
    core = connected_core(poll_ms=20)
    assert sent(core, 2, 60, {21: NO_MOTION, 41: NO_MOTION}) == [(20, HALT), (40, HALT), (60, HALT)]


@pytest.mark.parametrize("name", ["poll_ms", "connect_ms", "answer_timeout_ms"])
def test_a_period_of_nothing_is_refused(name):
    with pytest.raises(ValueError, match=f"{name} 0 is less than one tick"):
        SlamwareCore(**{name: 0})


def test_one_request_is_outstanding_at_a_time_and_a_late_answer_releases_the_next():
    core = connected_core()
    assert sent(core, 2, 179, {170: NO_MOTION}) == [(50, HALT), (170, HALT)]


def test_a_missing_answer_means_searching_again_at_once():
    core = connected_core()
    assert asked(core, 2, 1300) == [(50, HALT), (250, CONNECT), (1250, CONNECT)]
    assert not core.connected
    assert [(event.tick, event.kind, event.detail) for event in core.events][1:] == [
        (250, "timeout", "no answer to 0x41"),
        (450, "timeout", "no answer to 0x10"),
        (450, "lost", "the base does not answer; ending its open frame, if it has one"),
    ]


def test_an_error_answer_ends_the_request_and_the_next_leaves_on_schedule():
    core = connected_core()
    assert sent(core, 2, 150, {51: BAD_CHECKSUM_OF_THE_REFERENCE, 101: NOT_SUPPORTED}) == [
        (50, HALT),
        (100, HALT),
        (150, HALT),
    ]
    assert core.connected
    assert core.errors == {0x0040: 1, 0x8000: 1}
    assert core.events[-2][1:] == ("error", "0x0040 to 0x41: checksum mismatch")


def test_an_ok_behind_an_error_or_behind_its_deadline_is_still_taken():
    core = connected_core()
    sent(core, 2, 60, {51: bytes.fromhex("50 03 00 03 10 00 40"), 52: frame("dr-omni-back")})
    assert core.pose.x_m == pytest.approx(-0.0312)
    assert core.unexpected == 0
    core = SlamwareCore()
    assert asked(core, 0, 660, {600: IDENTITY, 601: NO_MOTION}) == [(0, CONNECT), (600, HALT), (650, HALT)]
    assert (core.connected, core.timeouts, core.unexpected) == (True, 1, 0)


def test_asks_for_the_latest_velocity():
    core = connected_core()
    core.ask(BodyTwist(1.0, 0.0, 0.0))
    core.ask(BodyTwist(0.25, -0.1, 0.5))
    ((_, data),) = sent(core, 2, 50)
    assert data == encode_frame(0xF8, bytes.fromhex("41 00400000 67E6FFFF 00800000"), "standard")
    with pytest.raises(ValueError, match="vx_mps 40000"):
        core.ask(BodyTwist(40000.0, 0.0, 0.0))


# --- answers -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["dr-omni-mixed", "dr-with-timestamp", "std-answer-dr", "dr2-straight.reply"])
def test_both_frame_types_and_later_dialects_are_accepted(name):
    core = connected_core()
    sent(core, 2, 51, {51: frame(name)})
    assert core.answers == {0x10: 1, 0x41: 1}
    assert core.pose != (0.0, 0.0, 0.0)


def test_increments_are_composed_in_the_robots_frame():
    core = connected_core()
    # 100 mm forward and a quarter turn left, three times; then 50 mm to the left, the status bits set.
    quarter = encode_frame(2, bytes.fromhex("00006400 00000000 00005A00 00"))
    sideways = encode_frame(2, bytes.fromhex("00000000 00003200 00000000 06"), "standard")
    sent(core, 2, 201, {51: quarter, 101: quarter, 151: quarter, 201: sideways})
    assert core.pose == pytest.approx((0.05, 0.1, -math.pi / 2), abs=1e-12)
    assert core.status == 6


def test_heading_is_wrapped():
    core = connected_core()
    half = encode_frame(2, bytes.fromhex("00000000 00000000 0000B400 00"))
    sent(core, 2, 51, {51: half})
    assert core.pose.heading_rad == pytest.approx(math.pi)
    sent(core, 52, 101, {101: half})
    assert core.pose.heading_rad == pytest.approx(0.0, abs=1e-12)


def test_frames_that_answer_nothing_are_passed_over():
    core = connected_core()
    # nothing outstanding; then a status answer, an echo, the invalid status and a short error before the real one
    wrong = (
        bytes.fromhex("50 03 00 02 4D 00 1C") + encode_frame(1, b"x") + encode_frame(0xFF) + encode_frame(3, b"\x40")
    )
    sent(core, 2, 51, {10: NO_MOTION, 51: wrong + NO_MOTION})
    assert core.unexpected == 5
    assert core.answers == {0x10: 1, 0x41: 1}


def test_noise_before_an_answer_is_counted_and_survived():
    core = connected_core()
    sent(core, 2, 51, {51: b"\x00\x10\xff" + NO_MOTION})
    assert 0x41 not in core.answers
    sent(core, 52, 250)
    # 0x10 0xFF announces 258 bytes that never come; at the deadline the answer behind it is found after all.
    assert core.answers == {0x10: 1, 0x41: 1}
    assert core.noise_bytes == 3
    assert core.timeouts == 0
    assert core.connected


def test_an_answer_found_at_the_deadline_does_not_bring_the_next_request_forward():
    core = connected_core(poll_ms=500)
    assert sent(core, 2, 1100, {501: b"\x10\xff" + NO_MOTION, 1001: NO_MOTION}) == [(500, HALT), (1000, HALT)]
    assert core.answers == {0x10: 1, 0x41: 2}
    assert core.timeouts == 0


def test_half_an_answer_from_before_does_not_spoil_the_next():
    core = connected_core()
    sent(core, 2, 300, {60: NO_MOTION[:9], 251: IDENTITY})
    assert core.connected
    assert core.noise_bytes == 9


def test_event_log_is_bounded():
    core = connected_core(poll_ms=2)
    sent(core, 2, 2000, {tick: b"\xaa" + NO_MOTION for tick in range(3, 2000, 2)})
    assert core.noise_bytes > 900
    assert len(core.events) == 200


# --- core against base -------------------------------------------------------------------------------------------


class Robot(Motion):
    """Moves as it is told, perfectly, and knows the displacement since it was last asked."""

    def __init__(self):
        self.x_m = self.y_m = self.heading_rad = 0.0
        self.mark = (0.0, 0.0, 0.0)

    def step(self, twist):
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        self.x_m += (c * twist.vx_mps - s * twist.vy_mps) * 0.001
        self.y_m += (s * twist.vx_mps + c * twist.vy_mps) * 0.001
        self.heading_rad += twist.omega_radps * 0.001

    def take_increment(self):
        x, y, heading = self.mark
        self.mark = (self.x_m, self.y_m, self.heading_rad)
        c, s = math.cos(heading), math.sin(heading)
        dx, dy = self.x_m - x, self.y_m - y
        return Displacement(c * dx + s * dy, c * dy - s * dx, self.heading_rad - heading)


class Line:
    """Core, both wires and base, as the bench ticks them. `to_base` and `to_core` may damage what passes."""

    def __init__(self, to_base=lambda data: data, to_core=lambda data: data):
        self.robot = Robot()
        self.core = SlamwareCore()
        self.slave = SlamwareBase(reference_facts(), self.robot)
        self.to_base, self.to_core = to_base, to_core
        self.tick = 0
        self.answer = b""

    def run(self, ticks):
        for _ in range(ticks):
            request = self.core.step(self.tick, self.answer)
            self.answer = self.slave.receive(self.to_base(request) if request else b"", self.tick)
            if self.answer:
                self.answer = self.to_core(self.answer)
            if self.slave.alive(self.tick):
                self.robot.step(self.slave.wanted_twist)
            self.tick += 1

    def settle(self):
        """Stand still on a clean line until the last displacement has been told."""
        self.to_base = self.to_core = lambda data: data
        self.core.ask(BodyTwist(0.0, 0.0, 0.0))
        self.run(3000)

    def error(self):
        pose = self.core.pose
        turn = math.remainder(pose.heading_rad - self.robot.heading_rad, math.tau)
        return math.hypot(pose.x_m - self.robot.x_m, pose.y_m - self.robot.y_m), abs(turn)


def drive(line):
    for twist in (BodyTwist(0.5, 0.0, 0.0), BodyTwist(0.0, -0.4, 0.0), BodyTwist(0.3, 0.2, 1.5)):
        line.core.ask(twist)
        line.run(1000)


def test_core_and_base_agree_over_a_clean_line():
    line = Line()
    drive(line)
    line.settle()
    assert line.core.connected
    assert line.slave.connected
    assert math.hypot(line.robot.x_m, line.robot.y_m) > 0.5
    distance_m, turn_rad = line.error()
    # each of some 60 answers is cut by up to 1/65536 mm and 1/65536 degree
    assert distance_m < 2e-6
    assert turn_rad < 2e-5
    assert line.core.timeouts == line.core.unexpected == line.core.noise_bytes == 0
    assert line.core.errors == line.slave.errors == {}
    assert line.slave.requests[0x41] == line.core.answers[0x41]


def test_the_robot_stops_when_the_core_falls_silent():
    line = Line()
    line.core.ask(BodyTwist(0.5, 0.0, 0.0))
    line.run(500)
    line.to_base = lambda data: b""
    line.run(2000)
    assert not line.slave.alive(line.tick)
    stopped_at = line.robot.x_m
    line.run(2000)
    assert line.robot.x_m == stopped_at
    line.to_base = lambda data: data
    line.run(2000)
    assert line.robot.x_m > stopped_at


def stray_byte_in_front(data, rng):
    return b"\xaa" + data


def lose_it(data, rng):
    return b""


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from([flip_one_bit, drop_a_byte, stray_byte_in_front, lose_it]),
    st.integers(0, 2**32),
    st.sampled_from([0.02, 0.1, 0.3]),
)
def test_damaged_requests_lose_time_but_no_displacement(damage, seed, share):
    rng = random.Random(seed)
    line = Line(to_base=lambda data: damage(data, rng) if rng.random() < share else data)
    drive(line)
    line.settle()
    distance_m, turn_rad = line.error()
    assert distance_m < 5e-6
    assert turn_rad < 5e-5
    assert line.core.connected


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from([flip_one_bit, drop_a_byte, add_a_byte, lose_it]),
    st.integers(0, 2**32),
    st.sampled_from([0.1, 0.5]),
)
def test_the_link_recovers_from_any_damage(damage, seed, share):
    rng = random.Random(seed)

    def hurt(data):
        return damage(data, rng) if rng.random() < share else data

    line = Line(hurt, hurt)
    drive(line)
    line.settle()
    assert line.core.connected
    before = line.core.answers[0x41]
    line.run(1000)
    assert line.core.answers[0x41] == before + 20


def test_a_lost_answer_is_lost_displacement():
    line = Line()
    line.core.ask(BodyTwist(0.5, 0.0, 0.0))
    line.run(500)
    line.to_core = lambda data: b""
    line.run(50)
    line.settle()
    assert line.core.timeouts == 1
    assert line.error()[0] == pytest.approx(0.025, abs=0.001)


@given(st.lists(st.binary(max_size=40), max_size=30))
def test_any_bytes_as_answers_never_raise(chunks):
    core = SlamwareCore(poll_ms=2, connect_ms=5, answer_timeout_ms=3)
    for tick, data in enumerate(chunks):
        core.step(tick, data)
    assert all(math.isfinite(value) for value in core.pose)
