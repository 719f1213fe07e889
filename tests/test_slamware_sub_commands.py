"""Each sub-command of our slave: literal bytes, dialects, what is refused, what a core may not spoil."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.config import SLAMWARE_CHOICES, load_robot
from bench.messages import BodyTwist
from bench.slamware import FrameDecoder, SlamwareBase, encode_frame
from bench.slamware.commands import DIALECTS, SUB_COMMANDS
from bench.slamware.facts import facts_of
from bench.slamware.health import Fault
from bench.slamware.omni_base import BEHAVIOURS
from bench.slamware.payloads import Displacement
from bench.slamware.reference_base import reference_facts
from bench.slamware.schedule import SCHEDULES
from bench.slamware.sense_payloads import Beacons, Power
from bench.slamware.senses import Motion, Senses, Wanted

NOT_SUPPORTED = bytes.fromhex("50 03 00 03 00 80 D0")
BAD_FORMAT = bytes.fromhex("50 03 00 03 01 80 D1")
FAILED = bytes.fromhex("50 03 00 03 02 80 D2")
EMPTY_OK = bytes.fromhex("50 01 00 02 53")


class Felt(Senses):
    """Senses that feel what they are told."""

    def __init__(self):
        super().__init__()
        self.ranges, self.pressed, self.dock = [], [], Beacons(3, (0, 0, 0))

    def ranges_m(self):
        return self.ranges

    def contacts(self):
        return self.pressed

    def beacons(self):
        return self.dock


class Rolling(Motion):
    """Wheels that have rolled so far, and remember what they were asked."""

    def __init__(self, distances_m=(1.2345, -0.0019, 3.0)):
        self.wheel_count = len(distances_m)
        self.distances_m = distances_m
        self.asked = None
        self.wrong = ()

    def rim_distances_m(self):
        return self.distances_m

    def take_second_increment(self):
        return Displacement(0.010, -0.005, math.radians(1.5))

    def status(self):
        return 6

    def follow_rims(self, speeds_mps):
        self.asked = speeds_mps
        return Wanted(BodyTwist(0.1, 0.2, 0.3), (1.0, -1.0))

    def faults(self, tick):
        return self.wrong


def slave(dialect="firmware-2018", motion=None):
    facts = reference_facts()._replace(dialect=DIALECTS[dialect])
    return SlamwareBase(facts, motion or Rolling(), Felt())


def ask(base, payload, tick=0):
    """The whole answer to one request of 0xF8, given by its payload in hex."""
    return base.receive(encode_frame(0xF8, bytes.fromhex(payload), "standard"), tick)


def told(base, payload, tick=0):
    """The payload of its OK, in hex."""
    (event,) = FrameDecoder().feed(ask(base, payload, tick))
    assert (event.type, event.code) == ("long", 2)
    return event.payload.hex(" ")


# --- dialects ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("dialect", "identity", "motor_data", "bumpers", "dead_reckon"),
    [
        ("firmware-2018", 28, None, 4, 13),
        ("firmware-2018-omni", 28, 28, 4, 13),
        ("firmware-2015", 28, 28, 1, 13),
        ("sdk-2020", 39, None, 4, 17),
    ],
)
def test_sizes_of_each_dialect_on_three_wheels(dialect, identity, motor_data, bumpers, dead_reckon):
    base = slave(dialect)
    sizes = {"1001": identity, "31": motor_data, "33": bumpers, "41" + 24 * "0": dead_reckon}
    for request, size in sizes.items():
        answer = ask(base, request)
        if size is None:
            assert answer == NOT_SUPPORTED, "a left and a right is what an omni base has not"
        else:
            assert (answer[3], len(answer)) == (2, size + 5), request


@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_dialects_do_not_change_they_do_not_change(dialect):
    requests = ["20", "21", "30", "32", "3400", "50", "5f", "6063", "9001", "40" + 32 * "0"]
    assert [ask(slave(dialect), each) for each in requests] == [ask(slave(), each) for each in requests]


def test_the_names_that_a_robot_file_may_say_are_those_that_exist():
    assert set(SLAMWARE_CHOICES["dialect"]) == DIALECTS.keys()
    assert set(SLAMWARE_CHOICES["behaviour"]) == BEHAVIOURS.keys()
    assert set(SLAMWARE_CHOICES["polls"]) == SCHEDULES.keys()


def test_the_suffix_of_the_later_identity():
    facts = reference_facts()
    facts = facts._replace(identity=facts.identity._replace(firmware_suffix="rc1"), dialect=DIALECTS["sdk-2020"])
    assert told(SlamwareBase(facts, Motion()), "1001").endswith("42 72 63 31 00 00 00 00 00 00 00 00")


def test_the_uptime_of_the_later_dead_reckoning():
    base = slave("sdk-2020")
    assert told(base, "41" + 24 * "0", tick=123456).endswith("06 40 e2 01 00")


# --- sizes -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sub_command", SUB_COMMANDS)
def test_any_size_but_the_right_ones_is_a_format_error(sub_command):
    right = {0x10: [1], 0x34: [1], 0x40: [16], 0x41: [12], 0x60: [1], 0x90: [1, 2, 5]}.get(sub_command, [0])
    for size in range(20):
        answer = ask(slave(), f"{sub_command:02x}" + "07" * size)
        assert (answer == BAD_FORMAT) == (size not in right), size


@pytest.mark.parametrize("payload", ["900100", "9002", "9002000000 00", "9003", "900300", "9003000102"])
def test_health_commands_of_another_ones_size_are_format_errors(payload):
    assert ask(slave(), payload) == BAD_FORMAT


@pytest.mark.parametrize("payload", ["a0", "00", "11", "22", "35", "42", "51", "5e", "61", "91", "b0", "ff", "99" * 9])
def test_other_sub_commands_are_not_supported(payload):
    assert ask(slave(), payload) == NOT_SUPPORTED


# --- one by one --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("power", "payload"),
    [
        (Power(100), "64 00"),
        (Power(77), "4d 00"),
        (Power(0, charging=True), "00 01"),
        (Power(50, charging=True, external_supply=True), "32 03"),
        (Power(100, charging=True, on_dock=True), "64 05"),
    ],
)
def test_power(power, payload):
    base = slave()
    base.senses.battery = power
    assert told(base, "30") == payload


def test_two_wheels_tell_whole_millimetres_cut_towards_zero():
    assert told(slave(motion=Rolling((1.2349, -0.0019))), "31") == "d2 04 00 00 ff ff ff ff 06"


def test_three_and_four_wheels_tell_rims_and_a_displacement():
    rest = "00 00 0a 00 00 00 fb ff 00 80 01 00"
    assert told(slave("firmware-2018-omni"), "31") == f"d2 04 00 00 ff ff ff ff b8 0b 00 00 00 00 00 00 {rest}"
    four = Rolling((0.001, 0.002, 0.003, -0.004))
    assert told(slave("firmware-2015", four), "31") == f"01 00 00 00 02 00 00 00 03 00 00 00 fc ff ff ff {rest}"


@pytest.mark.parametrize("count", [0, 5])
def test_wheels_that_do_not_fit_are_refused(count):
    base = slave("firmware-2018-omni", Rolling((0.0,) * count))
    assert ask(base, "31") == ask(base, "40" + 32 * "0") == NOT_SUPPORTED


def test_ranges_are_unsigned_and_fill_their_slots():
    base = slave()
    base.senses.ranges = [0.5, 0.0, 1.234, 65.535, -1.0, 99.0]
    got = told(base, "32")
    assert got.startswith("00 00 f4 01 00 00 00 00 00 00 d2 04 00 00 ff ff 00 00 00 00 ff ff ff ff 00 00 00 00")
    assert len(got.split()) == 64
    base.senses.ranges = [1.0] * 20
    assert told(base, "32") == " ".join(["00 00 e8 03"] * 16)


@pytest.mark.parametrize(
    ("pressed", "four", "one"),
    [
        ([], "ff 03 00 00", "ff"),
        ([False, False], "ff 03 00 00", "ff"),
        ([True, False], "fe 03 00 00", "fe"),
        ([False, True], "fd 03 00 00", "fd"),
        ([True] * 8, "00 03 00 00", "00"),
        ([False] * 11 + [True], "ff 07 00 00", "ff"),
    ],
)
def test_contacts_are_active_low(pressed, four, one):
    for dialect, expected in (("firmware-2018", four), ("firmware-2015", one)):
        base = slave(dialect)
        base.senses.pressed = pressed
        assert told(base, "33") == expected


def test_dock_beacons():
    base = slave()
    base.senses.dock = Beacons(3, (1, 2, 4, 7))
    assert told(base, "3400") == "03 04 01 02 04 07"
    for other in range(1, 256):
        assert ask(base, f"34{other:02x}") == NOT_SUPPORTED


def test_wheel_speeds_are_whole_millimetres_in_wheel_order():
    base = slave()
    assert ask(base, "40 c8000000 6affffff 01000000 ffffff7f") == EMPTY_OK
    assert base.motion.asked == (0.2, -0.15, 0.001), "a base of three wheels takes three words"
    assert base.wanted_twist == BodyTwist(0.1, 0.2, 0.3)
    assert base.wanted_slip_radps == (1.0, -1.0)


def test_the_later_of_wheel_speeds_and_velocity_wins():
    base = slave()
    forward = "41 00000100 00000000 00000000"
    ask(base, "40" + 32 * "0")
    ask(base, forward)
    assert (base.wanted_twist, base.wanted_slip_radps) == (BodyTwist(1.0, 0.0, 0.0), ())
    ask(base, "40" + 32 * "0")
    assert (base.wanted_twist, base.wanted_slip_radps) == (BodyTwist(0.1, 0.2, 0.3), (1.0, -1.0))


def test_after_silence_wheel_speeds_are_forgotten_too():
    base = slave()
    ask(base, "40" + 32 * "0", tick=0)
    assert (base.alive(1000), base.alive(1001)) == (True, False)
    ask(base, "30", tick=1001)
    assert (base.wanted_twist, base.wanted_slip_radps) == (BodyTwist(0.0, 0.0, 0.0), ())


def test_what_a_base_asks_stays_until_the_core_has_it():
    base = slave()
    assert ask(base, "50") == EMPTY_OK
    base.ask_core(0x80)
    base.ask_core(0x53)
    assert base.asking == 0x53
    assert told(base, "50") == told(base, "50") == "53 00"
    assert ask(base, "5f") == EMPTY_OK
    assert base.asking is None
    assert ask(base, "50") == EMPTY_OK
    for request in (-1, 0xFF, 256):
        with pytest.raises(ValueError, match=rf"base request {request} outside 0\.\.254"):
            base.ask_core(request)


def test_events_are_kept_known_or_not():
    base = slave()
    assert ask(base, "6063", tick=5) == ask(base, "607f", tick=9) == EMPTY_OK
    assert list(base.core_events) == [(5, 0x63), (9, 0x7F)]
    for tick in range(500):
        ask(base, "6061", tick)
    assert len(base.core_events) == 50


def test_a_robot_that_has_none_of_it():
    base = SlamwareBase(reference_facts(), Motion())
    assert (told(base, "30"), told(base, "3400")) == ("64 00", "03 00")
    assert told(base, "33") == "ff 03 00 00"
    assert told(base, "32") == " ".join(["00"] * 64)
    assert ask(base, "31") == ask(base, "40" + 32 * "0") == NOT_SUPPORTED
    assert told(base, "41" + 24 * "0") == told(base, "41" + 24 * "0") == " ".join(["00"] * 13)
    assert base.motion.follow_rims(()) is None
    assert base.motion.take_second_increment() == (0.0, 0.0, 0.0)


# --- health ------------------------------------------------------------------------------------------------------

LOW = "00 01 02 01"
TEXT = "4c 6f 77 20 62 61 74 74 65 72 79 2e" + " 00" * 20


@pytest.mark.parametrize(
    ("percent", "summary", "code"),
    [(30, "00 00", None), (29, "01 01", "00 01 02 01"), (10, "01 01", "00 01 02 01"), (9, "02 01", "00 01 02 02")],
)
def test_a_low_battery_is_the_one_fault_of_the_vendor(percent, summary, code):
    base = slave()
    base.senses.battery = Power(percent)
    assert told(base, "9001") == summary
    if code:
        assert told(base, "900200") == f"{code} {TEXT}"
    assert ask(base, "900201") == FAILED


def test_a_cleared_fault_comes_back_when_its_cause_does():
    base = slave()
    base.senses.battery = Power(25)
    assert ask(base, "9003 00010201") == EMPTY_OK
    assert told(base, "9001") == "00 00"
    assert ask(base, "9003 00010201") == FAILED, "it is not registered now"
    base.senses.battery = Power(50)
    assert told(base, "9001") == "00 00"
    base.senses.battery = Power(25)
    assert told(base, "9001") == "01 01"


def test_clearing_leaves_the_level_out_of_account():
    base = slave()
    base.senses.battery = Power(5)
    for code in ("00010204", "00010201", "000102f0"):
        assert ask(base, f"9003 {code}") == (EMPTY_OK if code == "00010204" else FAILED)
    base.senses.battery = Power(50)
    assert ask(base, "9003 00000000") == ask(base, "9003 00010202") == FAILED


def test_faults_of_all_levels_add_up_and_are_told_by_index():
    base = slave()
    base.senses.battery = Power(25)
    base.motion.wrong = [Fault(0x02030001, "Motor 2 is silent."), Fault(0x04010100, "Stop.")]
    assert told(base, "9001") == "07 03"
    assert [told(base, f"9002{index:02x}")[:11] for index in range(3)] == [LOW, "01 00 03 02", "00 01 01 04"]
    assert ask(base, "900203") == FAILED
    base.motion.wrong = ()
    assert told(base, "9001") == "01 01"


def test_a_fault_raised_by_hand_stays_until_it_is_cleared():
    base = slave()
    base.health.raise_fault(Fault(0x02040300, "Sonar."))
    assert told(base, "9001") == "02 01"
    assert told(base, "900200").startswith("00 03 04 02 53 6f 6e 61 72 2e 00")
    assert ask(base, "9003 00030400") == EMPTY_OK
    assert told(base, "9001") == "00 00"


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (Fault(0x01020100, "x" * 32), r"is not ASCII text of 0\.\.31 characters"),
        (Fault(0x01020100, "schön"), "is not ASCII"),
        (Fault(0x01000000, "nothing"), "names no fault of 32 bits"),
        (Fault(2**32 + 1, "much"), "names no fault of 32 bits"),
    ],
)
def test_faults_that_do_not_fit_are_refused(fault, message):
    with pytest.raises(ValueError, match=message):
        slave().health.raise_fault(fault)


def test_more_faults_than_there_is_room_for():
    base = slave()
    for number in range(32):
        base.health.raise_fault(Fault(0x01040000 | number, "One."))
    with pytest.raises(ValueError, match="32 faults are raised already"):
        base.health.raise_fault(Fault(0x01040020, "Too many."))
    base.senses.battery = Power(5)
    assert told(base, "9001") == "01 20"


@pytest.mark.parametrize("command", [0x00, 0x04, 0x10, 0xFF])
def test_unknown_health_commands_fail(command):
    assert ask(slave(), f"90{command:02x}") == FAILED


# --- how a base of ours is built ---------------------------------------------------------------------------------


def test_configuration_of_the_default_robot():
    got = bytes.fromhex(told(SlamwareBase(facts_of(load_robot("m2006")), Motion()), "20"))
    assert len(got) == 264
    assert got[:7].hex(" ") == "00 00 50 00 00 01 04", "round, 80 mm, not two wheels, four sensors"
    # front: 80 mm ahead, 50 mm up, looking forward; left: looking 90 degrees
    assert got[7:23].hex(" ") == "00 50 00 00 00 00 00 00 00 32 00 00 00 00 00 00"
    assert got[23:39].hex(" ") == "00 00 00 00 00 50 00 00 00 32 00 00 00 5a 00 00"
    assert got[39:55].hex(" ") == "00 b0 ff ff 00 00 00 00 00 32 00 00 00 b4 00 00"
    assert got[55:71].hex(" ") == "00 00 00 00 00 b0 ff ff 00 32 00 00 00 0e 01 00"
    assert not any(got[71:135])
    # two bumpers, the first at 45 degrees on the rim: 56.57 mm each way
    assert got[135] == 2
    assert got[136:152].hex(" ") == "92 38 00 00 92 38 00 00 00 32 00 00 00 2d 00 00"
    assert got[152:168].hex(" ") == "92 38 00 00 6e c7 ff ff 00 32 00 00 00 3b 01 00"
    assert not any(got[168:])


def test_binary_configuration_of_the_default_robot_and_of_a_tool():
    robot = load_robot("m2006")
    got = bytes.fromhex(told(SlamwareBase(facts_of(robot), Motion()), "21"))
    assert got.startswith(bytes.fromhex("50 01 00 50 07 01 10 ff 02 30 00 03 10 00 04 30 0a") + b"wheelbench")
    robot = replace(robot, slamware=replace(robot.slamware, binary_configuration="5001 0060"))
    assert told(SlamwareBase(facts_of(robot), Motion()), "21") == "50 01 00 60"


# --- any state, any request --------------------------------------------------------------------------------------

requests = st.one_of(
    st.builds(
        lambda sub, fields: bytes((sub,)) + fields,
        st.sampled_from(sorted(SUB_COMMANDS)),
        st.one_of(st.binary(max_size=17), st.binary(min_size=12, max_size=12), st.binary(min_size=16, max_size=16)),
    ),
    st.binary(max_size=20),
)


@given(st.sampled_from(sorted(DIALECTS)), st.lists(requests, max_size=12), st.sampled_from([0, 2, 3, 4, 6]))
def test_every_request_has_exactly_one_answer(dialect, asked, wheels):
    base = slave(dialect, Rolling((0.5,) * wheels))
    for tick, payload in enumerate(asked):
        (event,) = FrameDecoder(max_bytes=65539).feed(base.receive(encode_frame(0xF8, payload), tick))
        assert event.code in (2, 3)
        assert base.alive(tick)
