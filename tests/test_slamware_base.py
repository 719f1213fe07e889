"""Our slave against the vendor's exchanges, and what it must never do."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import frame

from bench.messages import BodyTwist
from bench.slamware import FrameDecoder, SlamwareBase, encode_frame
from bench.slamware.payloads import Displacement
from bench.slamware.reference_base import reference_facts
from bench.slamware.senses import Motion

REFERENCE = reference_facts()

CONNECT = bytes.fromhex("10 03 F8 10 01 FA")
DRIVE = encode_frame(0xF8, bytes.fromhex("41 00800000 00C0FFFF 00000100"), "standard")  # 0.5, -0.25, 1.0
HALT = bytes.fromhex("10 0E F8 41 000000000000000000000000 A7")
UNKNOWN_SUB = bytes.fromhex("10 02 F8 99 73")
NO_MOTION = bytes.fromhex("50 0E 00 02 00000000 00000000 00000000 00 5C")
NOT_SYNCHRONISED = bytes.fromhex("50 03 00 03 10 00 40")
TOO_LONG = bytes.fromhex("50 03 00 03 20 00 70")
BAD_CHECKSUM = bytes.fromhex("50 03 00 03 40 00 10")
NOT_SUPPORTED = bytes.fromhex("50 03 00 03 00 80 D0")
BAD_FORMAT = bytes.fromhex("50 03 00 03 01 80 D1")


class Wheels(Motion):
    """Wheels that hand over what was put into them, and count how often they were asked."""

    def __init__(self, increment=(0.0, 0.0, 0.0)):
        self.increment = increment
        self.taken = 0

    def take_increment(self):
        self.taken += 1
        increment, self.increment = self.increment, (0.0, 0.0, 0.0)
        return increment


@pytest.fixture
def wheels():
    return Wheels()


@pytest.fixture
def slave(wheels):
    return SlamwareBase(REFERENCE, wheels)


def increments_of(answer):
    """Q16 millimetres and degrees of a dead-reckoning answer."""
    (event,) = FrameDecoder().feed(answer)
    assert (event.type, event.code, len(event.payload)) == ("long", 2, 13)
    return [int.from_bytes(event.payload[i : i + 4], "little", signed=True) for i in (0, 4, 8)]


# --- requests ----------------------------------------------------------------------------------------------------


def test_velocity_request_is_taken_in_si(slave):
    assert slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)
    assert slave.receive(DRIVE, 0) == NO_MOTION
    assert slave.wanted_twist == BodyTwist(0.5, -0.25, 1.0)


def test_handshake(slave):
    assert not slave.connected
    assert slave.receive(bytes.fromhex("10 03 F8 10 02 F9"), 0) == NOT_SUPPORTED
    assert not slave.connected
    assert slave.receive(CONNECT, 1) == frame("connect-std.reply")
    assert slave.connected
    assert slave.requests == {0x10: 2}
    assert slave.errors == {0x8000: 1}


def test_facts_that_do_not_fit_on_the_wire_are_refused_at_the_start(wheels):
    identity = REFERENCE.identity._replace(model="a name much too long")
    with pytest.raises(ValueError, match="model 'a name much too long'"):
        SlamwareBase(REFERENCE._replace(identity=identity), wheels)


@pytest.mark.parametrize("kind", ["standard", "long"])
@pytest.mark.parametrize("code", [0x00, 0x01])
@pytest.mark.parametrize("filler", [b"", b"\x10\x50", bytes(254)])
def test_sync_and_echo_come_back_verbatim(slave, kind, code, filler):
    request = encode_frame(code, filler, kind)
    assert slave.receive(request, 0) == request


def test_largest_echo_comes_back_whole_and_a_larger_one_is_refused(slave):
    request = encode_frame(1, bytes(range(254)) * 2)
    assert len(request) == 513
    assert slave.receive(request, 0) == request
    assert slave.receive(encode_frame(1, bytes(509)), 1) == TOO_LONG


@pytest.mark.parametrize("code", [0x02, 0x03, 0x0F, 0x7E, 0xF1, 0xF9, 0xFF])
def test_unknown_commands_are_not_supported(slave, code):
    assert slave.receive(encode_frame(code, b"\x41" + bytes(12)), 0) == NOT_SUPPORTED


@pytest.mark.parametrize("payload", ["", "10", "100101", "41", "41" + "00" * 11, "41" + "00" * 13, "41" + "00" * 16])
def test_wrong_sizes_are_format_errors_and_change_nothing(slave, wheels, payload):
    slave.receive(DRIVE, 0)
    wheels.increment = (0.1, 0.0, 0.0)
    assert slave.receive(encode_frame(0xF8, bytes.fromhex(payload)), 1) == BAD_FORMAT
    assert slave.wanted_twist == BodyTwist(0.5, -0.25, 1.0)
    assert wheels.increment == (0.1, 0.0, 0.0)
    assert not slave.connected


def test_every_request_of_a_read_is_answered_in_order(slave):
    echo = encode_frame(1, b"ab", "standard")
    assert slave.receive(echo + CONNECT + DRIVE + echo, 0) == echo + frame("connect-std.reply") + NO_MOTION + echo


# --- odometry ----------------------------------------------------------------------------------------------------


def test_first_answer_is_zero_and_throws_earlier_motion_away(slave, wheels):
    wheels.increment = (1.0, 2.0, 3.0)
    slave.receive(CONNECT, 0)
    assert increments_of(slave.receive(DRIVE, 0)) == [0, 0, 0]
    assert increments_of(slave.receive(DRIVE, 50)) == [0, 0, 0]
    wheels.increment = (0.001, -0.002, math.radians(1.0))
    assert increments_of(slave.receive(DRIVE, 100)) == [65536, -131072, 65536]


def test_neither_a_new_handshake_nor_silence_repeats_the_first_answer_rule(slave, wheels):
    slave.receive(DRIVE, 0)
    wheels.increment = (0.002, 0.0, 0.0)
    slave.receive(CONNECT, 100_000)
    assert increments_of(slave.receive(DRIVE, 100_000)) == [131072, 0, 0]


def test_nothing_but_an_answered_velocity_request_clears_the_displacement(slave, wheels):
    slave.receive(DRIVE, 0)
    wheels.increment = (0.004, 0.0, 0.0)
    damaged = bytearray(HALT)
    damaged[-1] ^= 0x80
    for data in (bytes(damaged), CONNECT, UNKNOWN_SUB, b"\xaa", encode_frame(1, HALT), encode_frame(0xF8, HALT[3:-2])):
        slave.receive(data, 10)
    assert wheels.taken == 1
    assert increments_of(slave.receive(HALT, 20)) == [262144, 0, 0]
    assert increments_of(slave.receive(HALT, 30)) == [0, 0, 0]


# --- liveness ----------------------------------------------------------------------------------------------------


def test_dead_before_the_first_frame(slave):
    assert not slave.alive(0)


@pytest.mark.parametrize(("later_ms", "alive"), [(0, True), (999, True), (1000, True), (1001, False), (10**9, False)])
def test_more_than_1000_ms_of_silence_is_dead(slave, later_ms, alive):
    slave.receive(DRIVE, 5)
    assert slave.alive(5 + later_ms) is alive


def test_core_timeout_is_a_setting(wheels):
    slave = SlamwareBase(REFERENCE, wheels, core_timeout_ms=250)
    slave.receive(DRIVE, 0)
    assert (slave.alive(250), slave.alive(251)) == (True, False)


@pytest.mark.parametrize(
    "data", [UNKNOWN_SUB, CONNECT, bytes.fromhex("10 03 F8 10 02 F9"), encode_frame(0xF8), encode_frame(0xF8, b"\x41")]
)
def test_every_good_control_bus_frame_is_life(slave, data):
    slave.receive(data, 700)
    assert (slave.alive(1700), slave.alive(1701)) == (True, False)


@pytest.mark.parametrize(
    "data",
    [
        encode_frame(0, HALT),
        encode_frame(1, HALT),
        encode_frame(0x7E, HALT),
        HALT[:-1] + b"\xa6",
        HALT[:-1],
        b"\xaa",
        b"\x10\x00\x10",
        b"\x50\x58\x02",
    ],
)
def test_nothing_else_is_life(slave, data):
    slave.receive(data, 0)
    assert not slave.alive(0)


def test_after_silence_the_next_velocity_is_obeyed_at_once(slave):
    slave.receive(CONNECT + HALT, 0)
    assert slave.receive(DRIVE, 5000) == NO_MOTION
    assert slave.alive(5000)
    assert slave.wanted_twist == BodyTwist(0.5, -0.25, 1.0)


def test_after_silence_no_other_request_brings_the_old_velocity_back(slave):
    slave.receive(DRIVE, 0)
    slave.receive(UNKNOWN_SUB, 1000)
    assert slave.wanted_twist == BodyTwist(0.5, -0.25, 1.0)
    slave.receive(UNKNOWN_SUB, 2001)
    assert slave.alive(2001)
    assert slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)


# --- damage ------------------------------------------------------------------------------------------------------


def test_each_fault_gets_one_answer_at_once(slave):
    assert slave.receive(b"\xaa", 0) == NOT_SYNCHRONISED
    assert slave.receive(b"\xbb\xcc", 0) == b""
    assert slave.receive(b"\xdd", 5) == b""
    assert slave.receive(HALT[:-1] + b"\x00", 6) == BAD_CHECKSUM
    assert slave.receive(b"\xaa", 7) == NOT_SYNCHRONISED
    assert slave.receive(b"\xaa", 107) == NOT_SYNCHRONISED
    assert slave.receive(b"\x10\x00\x10", 108) == BAD_FORMAT
    assert slave.receive(b"\x50\x58\x02", 109) == TOO_LONG
    assert slave.errors == {0x0010: 3, 0x0040: 1, 0x8001: 1, 0x0020: 1}


def test_stray_bytes_are_one_fault_for_as_long_as_they_keep_coming(slave):
    assert [slave.receive(b"\xaa", tick) for tick in (0, 60, 120, 219)] == [NOT_SYNCHRONISED, b"", b"", b""]
    assert slave.receive(b"\xaa", 319) == NOT_SYNCHRONISED


def test_a_request_whose_flag_was_damaged_is_answered_once(slave):
    assert slave.receive(b"\x11" + HALT[1:], 0) == NOT_SYNCHRONISED
    assert slave.receive(HALT, 50) == NO_MOTION


def test_a_cut_request_is_dropped_without_an_answer(slave):
    slave.receive(CONNECT, 0)
    assert slave.receive(DRIVE[:7], 50) == b""
    assert slave.receive(HALT, 150) == NO_MOTION
    assert slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)
    assert slave.errors == {}


def test_nothing_inside_a_refused_frame_is_executed(slave, wheels):
    damaged = bytearray(encode_frame(1, DRIVE))
    damaged[-1] ^= 1
    assert slave.receive(bytes(damaged), 0) == BAD_CHECKSUM
    assert slave.receive(encode_frame(1, DRIVE * 40), 10) == TOO_LONG
    assert slave.receive(HALT, 11) == NO_MOTION
    assert slave.requests == {0x41: 1}
    assert slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)


@given(st.integers(0, 8 * 17 - 1))
def test_no_single_flipped_bit_moves_the_robot(bit):
    wheels = Wheels()
    slave = SlamwareBase(REFERENCE, wheels)
    bad = bytearray(DRIVE)
    bad[bit // 8] ^= 1 << bit % 8
    slave.receive(bytes(bad), 0)
    assert slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)
    assert not slave.alive(0)
    assert slave.receive(DRIVE, 150).endswith(NO_MOTION)


class Moving(Motion):
    def take_increment(self):
        return Displacement(0.01, -0.02, 0.03)


pieces = st.one_of(
    st.sampled_from([CONNECT, DRIVE, HALT, UNKNOWN_SUB, DRIVE[:9], b"\xaa", b"\x10", b"\x50", b"\x50\xff\xff"]),
    st.binary(max_size=12),
)


@given(st.lists(st.tuples(st.integers(0, 120), pieces), max_size=20))
def test_answers_depend_on_bytes_and_ticks_not_on_cuts(schedule):
    whole = SlamwareBase(REFERENCE, Moving())
    bytewise = SlamwareBase(REFERENCE, Moving())
    tick = 0
    for wait, data in schedule:
        tick += wait
        answers = b"".join(bytewise.receive(data[i : i + 1], tick) for i in range(len(data)))
        assert whole.receive(data, tick) == answers
        frames = FrameDecoder(max_bytes=65539).feed(answers)
        assert sum(event.length for event in frames) == len(answers)
        assert all(hasattr(event, "code") for event in frames)
    assert (whole.wanted_twist, whole.requests, whole.errors) == (
        bytewise.wanted_twist,
        bytewise.requests,
        bytewise.errors,
    )


@given(st.binary(max_size=300))
def test_any_bytes_are_answered_with_less_than_ten_times_their_number(data):
    slave = SlamwareBase(REFERENCE, Motion())
    assert len(slave.receive(data, 0)) < 10 * len(data) + 1
    assert slave.receive(b"", 1) == b""
