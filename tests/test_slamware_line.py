"""Core and base over a damaged line: the core brings either base back, ours and the vendor's, and tells of it."""

import math
import random
from itertools import pairwise

import pytest
from damage import add_a_byte, drop_a_byte, flip_one_bit
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.slamware import FrameDecoder, SlamwareBase, SlamwareCore, as_reference_firmware, encode_frame
from bench.slamware.health import Fault, clear_request, health_request
from bench.slamware.payloads import connect_request, event_request
from bench.slamware.reference_base import reference_facts
from bench.slamware.schedule import FULL, Poll, Schedule
from bench.slamware.sense_payloads import Beacons, Power
from bench.slamware.senses import Motion, Senses

SEED = 20181120
CONNECT = bytes.fromhex("10 03 F8 10 01 FA")


def ours():
    return SlamwareBase(reference_facts(), Motion())


class Line:
    """A core, a base, and what happens to the bytes between them. An answer reaches the core in the next tick."""

    def __init__(self, base, core=None, hurt=lambda data: data):
        self.base, self.core, self.hurt = base, core or SlamwareCore(), hurt
        self.tick = 0
        self.answer = b""
        self.sent = []

    def run(self, ticks):
        for _ in range(ticks):
            request = self.core.step(self.tick, self.answer)
            if request:
                self.sent.append((self.tick, request))
                request = self.hurt(request)
            self.answer = self.base.receive(request, self.tick) if request else b""
            if self.answer:
                self.answer = self.hurt(self.answer)
            self.tick += 1
        return self

    def kinds(self):
        return [event.kind for event in self.core.events]


# --- bringing a line back ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("cut", [1, 2, 3, 7, 12, 16])
def test_a_base_that_waits_for_ever_is_brought_back(cut):
    line = Line(as_reference_firmware()).run(200)
    cut_once = iter([lambda data: data[:cut]])
    line.hurt = lambda data: next(cut_once, lambda whole: whole)(data)
    before = line.core.answers[0x41]
    line.run(1500)
    assert line.core.connected
    assert line.core.answers[0x41] > before + 15
    assert line.kinds().count("lost") == line.kinds().count("in step") == line.core.resyncs <= 1


def test_a_base_that_takes_the_tail_of_each_request_for_the_next_one_is_brought_back():
    """After a cut before the checksum, 10 03 F8 | 10 01 FA 10 | 03 F8 | 10 01 FA 10 ... would never end by itself."""
    base = as_reference_firmware()
    assert base.receive(CONNECT[:3], 0) == b""
    for tick in range(1, 50):
        assert base.receive(CONNECT, tick)[-7:] != reference_identity()[-7:]
    line = Line(base).run(400)
    assert line.kinds()[-3:] == ["lost", "in step", "connected"]
    assert line.core.events[-3].detail.startswith("the base called 3 requests in a row damaged")
    assert line.core.timeouts == 0


def test_a_base_left_in_the_middle_of_its_largest_frame_is_brought_back():
    base = as_reference_firmware()
    assert base.receive(b"\x50\xfd\x01\xf8", 0) == b""
    line = Line(base).run(900)
    assert line.core.connected
    assert line.kinds() == ["timeout", "lost", "in step", "connected"]
    assert line.core.resyncs == 1


def test_what_is_sent_to_bring_a_line_back():
    base = as_reference_firmware()
    base.receive(b"\x10\x30\xf8", 0)  # 50 bytes announced, 3 of them came
    line = Line(base).run(600)
    pieces = [(tick, data) for tick, data in line.sent if data[2:3] != b"\xf8"]
    # 6 bytes of the handshake and 48 of filler end the frame; then quiet, then SYNC with bytes of its own
    assert pieces == [
        (240, bytes(16)),
        (250, bytes(16)),
        (260, bytes(16)),
        (301, bytes.fromhex("10 04 00 A5 80 5A 6B")),
    ]
    assert line.core.connected


def test_nobody_there_is_no_endless_noise():
    class Nobody:
        def receive(self, data, tick):
            return b""

    line = Line(Nobody()).run(10_000)
    handshakes = [tick for tick, data in line.sent if data == CONNECT]
    assert handshakes == list(range(0, 10_000, 1000))
    filler = b"".join(data for _, data in line.sent if data != CONNECT)
    assert filler == bytes(528 * 10)
    assert line.core.resyncs == 10


def test_a_sync_that_comes_back_changed_does_not_count():
    class Parrot:
        """Answers filler with an error and SYNC with another SYNC."""

        def receive(self, data, tick):
            if data == CONNECT:
                return b""
            return encode_frame(3, b"\x10\x00") if not any(data) else encode_frame(0, b"\x01\x02\x03", "standard")

    line = Line(Parrot()).run(3000)
    assert not line.core.connected
    assert "in step" not in line.kinds()
    assert [tick for tick, data in line.sent if data == CONNECT] == [0, 1000, 2000]


def test_a_late_handshake_ends_the_search():
    core = SlamwareCore()
    for tick in range(260):
        core.step(tick, b"")
    assert core.resyncs == 1
    core.step(260, reference_identity())
    assert core.connected
    assert [event.kind for event in core.events] == ["timeout", "lost", "connected"]
    assert core.step(261, b"")[3] == 0x41


def reference_identity():
    return ours().receive(CONNECT, 0)


# --- damage from a named seed ------------------------------------------------------------------------------------


def cut_it(data, rng):
    return data[: rng.randrange(len(data))]


def replace_it(data, rng):
    return rng.randbytes(rng.randrange(1, 40))


DAMAGES = [flip_one_bit, drop_a_byte, add_a_byte, cut_it, replace_it]


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("make", [ours, as_reference_firmware])
@pytest.mark.parametrize("schedule", [Schedule(), FULL], ids=["velocity", "full"])
def test_the_line_is_back_within_three_seconds_of_any_damage(damage, make, schedule):
    rng = random.Random(SEED)
    line = Line(make(), SlamwareCore(schedule=schedule))
    line.hurt = lambda data: damage(data, rng) if rng.random() < 0.1 else data
    line.run(10_000)
    assert line.core.errors or line.core.noise_bytes or line.core.timeouts, "nothing was damaged"
    line.hurt = lambda data: data
    line.run(3000)
    assert line.core.connected
    before = line.core.answers[0x41]
    line.run(1000)
    assert line.core.answers[0x41] >= before + 19
    assert all(math.isfinite(value) for value in line.core.pose)


def test_each_kind_of_trouble_is_told_with_its_tick():
    line = Line(ours()).run(100)
    line.hurt = lambda data: data[:-1] + bytes((data[-1] ^ 1,))
    line.run(2)
    assert [tuple(event) for event in line.core.events][1:] == []
    line.run(60)
    # the request's checksum is damaged, and so is that of the error that answers it
    line.hurt = lambda data: data
    line.run(400)
    assert [(event.tick, event.kind) for event in line.core.events][1:] == [
        (300, "noise"),
        (300, "timeout"),
        (301, "connected"),
    ]


# --- the schedule ------------------------------------------------------------------------------------------------


class Surroundings(Senses):
    def ranges_m(self):
        return (0.25, 1.5)

    def contacts(self):
        return (False, True)

    def beacons(self):
        return Beacons(3, (1, 2, 4))


def test_the_full_schedule_learns_everything():
    base = as_reference_firmware(Surroundings())
    base.senses.battery = Power(25, charging=True, external_supply=True)
    base.ask_core(0xA4)
    base.motion.turn(6390, 3195)
    line = Line(base, SlamwareCore(schedule=FULL)).run(3000)
    known = line.core.known
    assert known.identity == reference_facts().identity
    assert known.configuration.radius_m == pytest.approx(0.18)
    assert len(known.configuration.range_sensors) == 4
    assert known.binary_configuration == reference_facts().binary_configuration
    assert known.power == Power(25, charging=True, external_supply=True)
    assert known.ranges_m[:3] == pytest.approx((0.25, 1.5, 0.0))
    assert known.contacts == (False, True) + (False,) * 8
    assert known.beacons == Beacons(3, (1, 2, 4))
    assert known.motor_data.distances_m == (1.0, 0.5)
    assert known.health == (1, 1)
    assert known.faults == {0: Fault(0x01020100, "Low battery.")}
    assert list(base.core_events) == [(base.core_events[0][0], 0x63)]
    assert base.asking is None
    told = [(event.kind, event.detail) for event in line.core.events]
    assert ("asked", "0xA4 go home") in told
    assert ("fault", "power warning: battery low, unit 0") in told
    assert line.core.errors == {}
    assert line.core.timeouts == line.core.unexpected == line.core.noise_bytes == 0


def test_the_full_schedule_keeps_its_rates_and_velocity_its_own():
    line = Line(as_reference_firmware(), SlamwareCore(schedule=FULL)).run(10_000)
    counts = line.core.answers
    assert counts[0x41] == 199
    assert counts[0x21] == counts[0x20] == counts[0x60] == 1
    for sub_command, times in ((0x33, 100), (0x32, 100), (0x50, 50), (0x31, 20), (0x34, 20), (0x30, 10), (0x90, 10)):
        assert abs(counts[sub_command] - times) <= 1, hex(sub_command)
    velocity = [tick for tick, data in line.sent if data[3] == 0x41]
    assert max(b - a for a, b in pairwise(velocity)) <= 52


def test_what_a_base_does_not_support_is_asked_once_a_connection():
    line = Line(ours(), SlamwareCore(schedule=Schedule((), (Poll(b"\x31", 100), Poll(b"\x30", 100))))).run(2000)
    assert line.core.requests[0x31] == 1
    assert line.core.errors == {0x8000: 1}
    assert line.core.answers[0x30] >= 19


def test_requests_of_a_user_leave_once_in_their_order_between_velocities():
    base = ours()
    line = Line(base).run(10)
    for event in (0x63, 0x82, 0x65):
        line.core.request(event_request(event))
    line.run(30)
    assert [event for _, event in base.core_events] == [0x63, 0x82, 0x65]
    with pytest.raises(ValueError, match="41 is no request of the control bus"):
        line.core.request(b"\x41")
    with pytest.raises(ValueError, match="nothing is no request"):
        line.core.request(b"")
    with pytest.raises(ValueError, match="a0 is no request"):
        SlamwareCore(schedule=Schedule((b"\xa0",)))
    for event in range(64):
        line.core.request(event_request(event))
    with pytest.raises(ValueError, match="64 requests are waiting already"):
        line.core.request(health_request())


def test_a_core_clears_a_fault():
    base = ours()
    base.health.raise_fault(Fault(0x01040300, "Sonar."))
    line = Line(base).run(10)
    line.core.request(clear_request(0x01040300))
    line.run(10)
    assert base.health.faults == ()
    assert line.core.answers[0x90] == 1


def test_wheel_speeds_take_the_velocitys_place():
    base = as_reference_firmware()
    line = Line(base).run(100)
    line.core.ask_wheels((0.2, -0.15))
    line.run(100)
    assert base.motion.targets_mmps(True) == (200, -150)
    assert line.sent[-1][1].hex(" ") == encode_frame(
        0xF8, bytes.fromhex("40 c8000000 6affffff 00000000 00000000"), "standard"
    ).hex(" ")
    for wrong, message in (((0.0,) * 5, "5 wheel speeds"), ((3e6,), "wheel speed 3000000.0 outside")):
        with pytest.raises(ValueError, match=message):
            line.core.ask_wheels(wrong)


# --- any bytes ---------------------------------------------------------------------------------------------------

answers = st.one_of(
    st.binary(max_size=40),
    st.builds(encode_frame, st.sampled_from([0, 1, 2, 3, 0xFF]), st.binary(max_size=70)),
    st.builds(encode_frame, st.just(2), st.sampled_from([bytes(28), bytes(13), bytes(2), b"\x07\xff", b"\x80\x00"])),
)


@settings(max_examples=50)
@given(st.lists(answers, max_size=60))
def test_any_answers_never_raise_and_every_request_is_well_formed(chunks):
    core = SlamwareCore(poll_ms=2, connect_ms=5, answer_timeout_ms=3, schedule=FULL)
    for tick in range(3 * len(chunks)):
        out = core.step(tick, chunks[tick // 3] if tick % 3 == 0 else b"")
        if out and any(out):
            (event,) = FrameDecoder().feed(out)
            assert event.code in (0x00, 0xF8)
    assert core._timetable.is_full is False
    assert len(core.known.faults) <= 255


def test_the_handshake_may_say_another_version():
    assert ours().receive(encode_frame(0xF8, connect_request(2)), 0) == bytes.fromhex("50 03 00 03 00 80 D0")
