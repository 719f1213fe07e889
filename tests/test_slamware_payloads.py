"""Fields of the control bus: the vendor's structures byte for byte, units, limits."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import BY_NAME

from bench.messages import BodyTwist
from bench.slamware.config_payloads import (
    BaseConfiguration,
    Position,
    Symbol,
    configuration_answer,
    configuration_from_answer,
    decode_tree,
    encode_tree,
)
from bench.slamware.health import Fault, fault_answer, fault_from_answer, fault_in_words
from bench.slamware.payloads import (
    DeadReckon,
    Identity,
    MotorData,
    connect_request,
    dead_reckon_answer,
    dead_reckon_from_answer,
    error_from_answer,
    event_request,
    identity_answer,
    identity_from_answer,
    meaning_of,
    motor_data_from_answer,
    omni_motor_answer,
    twist_from_request,
    twist_request,
    two_wheel_answer,
    wheels_from_request,
    wheels_request,
)
from bench.slamware.sense_payloads import (
    Beacons,
    Power,
    base_request_from_answer,
    beacons_answer,
    beacons_from_answer,
    contacts_answer,
    contacts_from_answer,
    power_answer,
    power_from_answer,
    ranges_answer,
    ranges_from_answer,
)


def payload(name):
    return bytes.fromhex(BY_NAME[name]["frame"]["payload"])


def test_connect_request():
    assert connect_request() == payload("connect-std.request") == b"\x10\x01"


def test_identity_of_the_reference_base():
    reference = Identity("ref base", 0x005A, 1, "303132333435363738394142")
    assert identity_answer(reference) == payload("connect-std.reply")
    assert identity_from_answer(payload("connect-std.reply")) == reference


def test_identity_of_a_later_dialect_is_read_up_to_what_is_known():
    later = identity_from_answer(payload("connect-std.reply") + b"rc1\0\0\0\0\0\0\0\0" + b"more")
    assert (later.model, later.firmware_suffix) == ("ref base", "rc1")
    assert identity_answer(later, 39) == payload("connect-std.reply") + b"rc1\0\0\0\0\0\0\0\0"


def test_identity_from_hostile_bytes_has_nothing_that_a_terminal_obeys():
    model = identity_from_answer(b"\x1b[2J\xff\x07 ok!\n!" + bytes(16)).model
    assert model == "?[2J\u00ff? ok!?!"


@pytest.mark.parametrize(
    ("identity", "message"),
    [
        (Identity("thirteen char", 1, 1, "00" * 12), "model 'thirteen char' is not ASCII text of 0..12 characters"),
        (Identity("nät", 1, 1, "00" * 12), "model 'nät' is not ASCII"),
        (Identity("base", 1, 1, "00" * 12, "twelve chars"), "firmware_suffix 'twelve chars' is not ASCII"),
        (Identity("base", 65536, 1, "00" * 12), "firmware_version 65536 outside 0..65535"),
        (Identity("base", 1, -1, "00" * 12), "hardware_version -1 outside 0..65535"),
        (Identity("base", 1, 1, "00" * 11), f"serial_number '{'00' * 11}' is not 24 hexadecimal digits"),
        (Identity("base", 1, 1, "zz" * 12), "is not 24 hexadecimal digits"),
    ],
)
def test_identity_that_does_not_fit_is_refused(identity, message):
    with pytest.raises(ValueError, match=message):
        identity_answer(identity)


@pytest.mark.parametrize("version", [0, 65535])
def test_identity_fills_its_fields(version):
    identity = Identity("twelve chars", version, version, "ff" * 12, "eleven char")
    answer = identity_answer(identity, 39)
    assert answer == b"twelve chars" + version.to_bytes(2, "little") * 2 + b"\xff" * 12 + b"eleven char"
    assert identity_from_answer(answer) == identity


@pytest.mark.parametrize(
    ("name", "twist"),
    [
        ("sdk-setv-fwd", BodyTwist(0.25, -0.1, 0.5)),
        ("sdk-setv-back", BodyTwist(-0.4, 0.0, -0.75)),
        ("dr3-left-arc", BodyTwist(-0.25, 0.0, 0.0)),
        ("dr5-spin-right", BodyTwist(0.0, 0.0, 0.0)),
    ],
)
def test_twist_request_as_the_vendor_sends_it(name, twist):
    assert twist_request(twist) == payload(f"{name}.request")
    assert twist_from_request(payload(f"{name}.request")[1:]) == pytest.approx(twist, abs=1 / 65536)


def test_twist_signs_and_places():
    # vx 1 forward, vy -2 (right), omega 0.5 counter-clockwise
    assert twist_from_request(bytes.fromhex("00000100 0000feff 00800000")) == BodyTwist(1.0, -2.0, 0.5)


def test_a_twist_fills_its_fields():
    assert twist_request(BodyTwist(-32768.0, 32767.5, -32767.5))[1:] == bytes.fromhex("00000080 0080ff7f 00800080")


@pytest.mark.parametrize("value", [32768.0, -32769.0, math.nan, math.inf, -math.inf])
def test_twist_that_does_not_fit_is_refused(value):
    with pytest.raises(ValueError, match=r"vy_mps .* outside -32768\.\.32768"):
        twist_request(BodyTwist(0.0, value, 0.0))


@pytest.mark.parametrize("name", ["dr-omni-sideways", "dr-omni-mixed", "dr-omni-neg", "dr-omni-back", "dr-omni-spin"])
def test_displacements_byte_for_byte(name):
    given_ = BY_NAME[name]["input"]
    assert dead_reckon_answer(given_["dx_m"], given_["dy_m"], given_["dtheta_rad"]) == payload(name)


def test_displacement_just_inside_32_bits():
    # The vendor's single precision moves in steps of 128 here, ours does not.
    ours = dead_reckon_answer(32.767, -32.767, 571.5)
    vendors = payload("dr-omni-big")
    for i in (0, 4, 8):
        a, b = (int.from_bytes(data[i : i + 4], "little", signed=True) for data in (ours, vendors))
        assert abs(a - b) <= 128


@pytest.mark.parametrize(
    ("metres", "raw"),
    [
        (0.001, 65536),
        (-0.001, -65536),
        (1.9 / 65536e3, 1),
        (-1.9 / 65536e3, -1),
        (0.9 / 65536e3, 0),
        (-0.9 / 65536e3, 0),
        (32.767999999999994, 2147483647),
        (32.768, 2147483647),
        (-32.768, -2147483648),
        (1e300, 2147483647),
        (-math.inf, -2147483648),
    ],
)
def test_displacement_is_cut_towards_zero_and_stays_at_the_limit(metres, raw):
    assert dead_reckon_answer(metres, 0.0, 0.0)[:4] == raw.to_bytes(4, "little", signed=True)


def test_displacement_fields_and_status_bits():
    got = dead_reckon_from_answer(bytes.fromhex("00000a00 0000fbff 00800100 06"))
    assert got == DeadReckon(*map(pytest.approx, (0.010, -0.005, math.radians(1.5))), 6)
    assert dead_reckon_answer(0.010, -0.005, math.radians(1.5), 6)[12] == 6
    assert dead_reckon_from_answer(payload("dr-raw-minus-one")).status == 6


def test_displacement_of_a_later_dialect_tells_the_uptime():
    moved = map(pytest.approx, (0.010, -0.005, math.radians(1.5)))
    expected = DeadReckon(*moved, 0, 123456)
    assert dead_reckon_from_answer(payload("dr-with-timestamp")) == expected
    assert dead_reckon_from_answer(payload("dr-with-timestamp") + b"more") == expected
    assert dead_reckon_answer(0.0, 0.0, 0.0, 0, 2**32 + 7)[13:] == bytes.fromhex("07000000"), "49.7 days later"


@given(*[st.floats(-30.0, 30.0)] * 3)
def test_displacement_survives_the_wire_within_one_unit(dx_m, dy_m, dtheta_rad):
    got = dead_reckon_from_answer(dead_reckon_answer(dx_m, dy_m, dtheta_rad))
    assert got.dx_m == pytest.approx(dx_m, abs=1.6e-8)
    assert got.dy_m == pytest.approx(dy_m, abs=1.6e-8)
    assert got.dtheta_rad == pytest.approx(dtheta_rad, abs=2.7e-7)


@given(*[st.floats(-32767.0, 32767.0)] * 3)
def test_twist_survives_the_wire_within_one_unit(vx, vy, omega):
    assert twist_from_request(twist_request(BodyTwist(vx, vy, omega))[1:]) == pytest.approx(
        (vx, vy, omega), abs=1 / 65536
    )


@pytest.mark.parametrize(
    ("data", "code", "meaning"),
    [
        ("1000", 0x0010, "byte outside any frame"),
        ("2000", 0x0020, "frame longer than the receive buffer"),
        ("4000", 0x0040, "checksum mismatch"),
        ("c000", 0x0040, "checksum mismatch"),
        ("c100", 0x0041, "checksum mismatch"),
        ("9000", 0x0010, "byte outside any frame"),
        ("3000", 0x0030, "byte outside any frame, frame longer than the receive buffer"),
        ("0080", 0x8000, "not supported"),
        ("0180", 0x8001, "format error in the request"),
        ("0280", 0x8002, "execution failed"),
        ("8080", 0x8080, "unknown"),
        ("0400", 0x0004, "unknown"),
    ],
)
def test_error_codes_and_the_reference_bases_marker_bit(data, code, meaning):
    assert error_from_answer(bytes.fromhex(data)) == code
    assert meaning_of(code) == meaning


# --- there and back ----------------------------------------------------------------------------------------------

si = st.floats(-30.0, 30.0)


@given(st.lists(st.integers(-2_147_483, 2_147_483), max_size=4))
def test_wheel_speeds_survive_the_wire(speeds_mps):
    asked = wheels_from_request(wheels_request(speeds_mps)[1:])
    assert asked == tuple(speeds_mps) + (0.0,) * (4 - len(speeds_mps))


def test_wheel_speeds_of_the_vendor():
    assert wheels_request((0.2, 0.2)) == payload("set-motor-200-200.request")
    assert wheels_from_request(payload("set-motor-neg.request")[1:]) == (-0.15, 0.15, 0.0, 0.0)


@given(st.lists(si, max_size=4), st.tuples(si, si, si))
def test_rims_survive_the_wire_within_a_millimetre(distances_m, displacement):
    data = motor_data_from_answer(omni_motor_answer(distances_m, displacement))
    assert data.distances_m == pytest.approx((*distances_m, *[0.0] * (4 - len(distances_m))), abs=1e-3)
    assert data.displacement == pytest.approx(displacement, abs=1e-6)
    assert data.status is None


def test_four_wheels_in_whole_millimetres_by_hand():
    # 1500 = 0x5dc, -2 = 0xfffffffe, 2147483000 = 0x7ffffd78
    request = wheels_request((1.5, -0.002, 2_147_483.0, -2_147_483.0))
    assert request == b"\x40" + bytes.fromhex("dc050000 feffffff 78fdff7f 88020080")
    for beyond in (2_147_483.1, -2_147_483.1):
        with pytest.raises(ValueError, match=r"wheel speed .* outside -2147483\.\.2147483"):
            wheels_request((beyond,))
    with pytest.raises(ValueError, match="5 wheel speeds; the request has room for 4"):
        wheels_request((0.0,) * 5)


def test_distances_are_cut_to_whole_millimetres_by_hand():
    assert two_wheel_answer(1.2345, -2.0019, 3) == bytes.fromhex("d2040000 2ff8ffff 03")
    # Four rims, then 1 mm, -2 mm and a degree as Q16.
    answer = omni_motor_answer((1.2345, -2.0019, 0.0, 1.0), (0.001, -0.002, math.radians(1.0000001)))
    assert answer == bytes.fromhex("d2040000 2ff8ffff 00000000 e8030000 00000100 0000feff 00000100")
    data = motor_data_from_answer(answer)
    assert data.distances_m == (1.234, -2.001, 0.0, 1.0)
    assert data.displacement == pytest.approx((0.001, -0.002, math.radians(1.0)))
    assert data.status is None


def test_an_event_by_hand():
    assert event_request(0x02) == b"\x60\x02"


def test_two_wheels_of_the_vendor():
    assert two_wheel_answer(1.0, 0.5) == payload("motor-data-1000-500.reply")
    assert motor_data_from_answer(payload("motor-data-1000-500.reply") + b"later") == MotorData((1.0, 0.5), None, 0)
    assert two_wheel_answer(9e9, -9e9, 2).hex() == "ffffff7f0000008002"
    with pytest.raises(ValueError, match="5 wheel distances; the answer has room for 4"):
        omni_motor_answer((0.0,) * 5, (0.0, 0.0, 0.0))


@given(st.builds(Power, st.integers(0, 100), st.booleans(), st.booleans(), st.booleans()))
def test_power_survives_the_wire(power):
    assert power_from_answer(power_answer(power)) == power
    assert power_from_answer(power_answer(power) + b"later") == power


def test_a_battery_of_101_percent_is_refused():
    for percent in (-1, 101):
        with pytest.raises(ValueError, match=rf"battery percentage {percent} outside 0\.\.100"):
            power_answer(Power(percent))


@given(st.lists(st.floats(0.0, 65.5), max_size=16))
def test_ranges_survive_the_wire(ranges_m):
    got = ranges_from_answer(ranges_answer(ranges_m))
    assert got == pytest.approx((*ranges_m, *[0.0] * (16 - len(ranges_m))), abs=2e-8)


def test_more_ranges_than_slots_are_refused():
    with pytest.raises(ValueError, match="17 distances; the answer has 16 slots"):
        ranges_answer([1.0] * 17)


@given(st.lists(st.booleans(), max_size=32), st.sampled_from([1, 4]))
def test_contacts_survive_the_wire(contacts, size):
    count = min(len(contacts), 8 * size)
    assert contacts_from_answer(contacts_answer(contacts, size), count) == tuple(contacts[:count])


@given(st.builds(Beacons, st.integers(0, 255), st.lists(st.integers(0, 255), max_size=8).map(tuple)))
def test_beacons_survive_the_wire(beacons):
    assert beacons_from_answer(beacons_answer(beacons)) == beacons


def test_receivers_that_did_not_come_are_not_invented():
    assert beacons_from_answer(b"\x03\xff\x01\x02") == Beacons(3, (1, 2))


@pytest.mark.parametrize(("data", "request_"), [("", None), ("80 00", 0x80), ("ff 00", None), ("53", 0x53)])
def test_what_a_base_asks(data, request_):
    assert base_request_from_answer(bytes.fromhex(data)) == request_


codes = st.integers(1, 0xFFFFFFFF).filter(lambda code: code & 0xF0FFFFFF)
texts = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=31)


@given(st.builds(Fault, codes, texts))
def test_faults_survive_the_wire(fault):
    assert fault_from_answer(fault_answer(fault)) == fault


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0x01020100, "power warning: battery low, unit 0"),
        (0x02030001, "motion error: controller down, unit 1"),
        (0x04010100, "system fatal: emergency stop, unit 0"),
        (0x02041101, "sensor error: dust bin, unit 1"),
        (0x03001234, "user fault: kind 18, unit 52"),
        (0x010F0000, "component 15 warning: kind 0, unit 0"),
    ],
)
def test_fault_codes_in_words(code, words):
    assert fault_in_words(code) == words


positions = st.builds(Position, si, si, si, st.floats(0.0, 6.28))
configurations = st.builds(
    BaseConfiguration,
    st.integers(0, 1),
    st.floats(0.0, 10.0),
    st.integers(0, 1),
    st.lists(positions, max_size=8).map(tuple),
    st.lists(positions, max_size=8).map(tuple),
)


@given(configurations)
def test_configurations_survive_the_wire(configuration):
    got = configuration_from_answer(configuration_answer(configuration))
    assert (got.shape, got.drive) == (configuration.shape, configuration.drive)
    assert got.radius_m == pytest.approx(configuration.radius_m, abs=2e-6)
    for ours, theirs in ((configuration.range_sensors, got.range_sensors), (configuration.bumpers, got.bumpers)):
        assert len(ours) == len(theirs)
        for a, b in zip(ours, theirs, strict=True):
            assert a[:3] == pytest.approx(b[:3], abs=2e-6)
            assert abs(math.remainder(a.heading_rad - b.heading_rad, math.tau)) < 4e-5


def test_of_more_than_eight_sensors_the_first_eight_are_told():
    many = tuple(Position(0.1 * i, 0.0, 0.0, -math.pi / 2) for i in range(16))
    got = configuration_from_answer(configuration_answer(BaseConfiguration(0, 0.1, 1, many, many)))
    assert len(got.range_sensors) == len(got.bumpers) == 8
    assert got.range_sensors[0].heading_rad == pytest.approx(3 * math.pi / 2)
    assert len(configuration_from_answer(b"\xff" * 264).bumpers) == 8


trees = st.recursive(
    st.one_of(
        st.just(True),
        st.integers(0, 0xFFFF),
        st.builds(Symbol, st.integers(0, 255)),
        st.floats(width=32, allow_nan=False),
        st.text(st.characters(max_codepoint=127), max_size=20),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.integers(0, 255), inner, max_size=4)),
    max_leaves=20,
)


@given(trees)
def test_trees_survive_the_wire(tree):
    assert decode_tree(encode_tree(tree)) == tree


@given(st.binary(max_size=80))
def test_any_bytes_are_a_tree_or_none(data):
    decode_tree(data)


@pytest.mark.parametrize(
    "data", ["", "99", "50 01 00", "40 02 60", "30 05 41", "20 00 00", "60 60", "40 01" * 17 + "60"]
)
def test_what_is_no_tree(data):
    assert decode_tree(bytes.fromhex(data)) is None


@pytest.mark.parametrize("value", [False, -1, 65536, "schön", "x" * 256, [0] * 256, None, {256: 1}])
def test_what_fits_into_no_tree(value):
    with pytest.raises(ValueError, match=r"does not fit|range\(0, 256\)"):
        encode_tree(value)
