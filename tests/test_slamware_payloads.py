"""Fields of the control bus: the vendor's structures byte for byte, units, limits."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import BY_NAME

from bench.messages import BodyTwist
from bench.slamware.payloads import (
    DeadReckon,
    Identity,
    connect_request,
    dead_reckon_answer,
    dead_reckon_from_answer,
    error_from_answer,
    identity_answer,
    identity_from_answer,
    meaning_of,
    twist_from_request,
    twist_request,
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
    assert identity_from_answer(payload("connect-std.reply") + b"rc1\0\0\0\0\0\0\0\0").model == "ref base"


def test_identity_from_hostile_bytes_has_nothing_that_a_terminal_obeys():
    model = identity_from_answer(b"\x1b[2J\xff\x07 ok!\n!" + bytes(16)).model
    assert model == "?[2J\u00ff? ok!?!"


@pytest.mark.parametrize(
    ("identity", "message"),
    [
        (Identity("thirteen char", 1, 1, "00" * 12), "model 'thirteen char' is not ASCII text of 0..12 characters"),
        (Identity("nät", 1, 1, "00" * 12), "model 'nät' is not ASCII"),
        (Identity("base", 65536, 1, "00" * 12), "firmware_version 65536 outside 0..65535"),
        (Identity("base", 1, -1, "00" * 12), "hardware_version -1 outside 0..65535"),
        (Identity("base", 1, 1, "00" * 11), f"serial_number '{'00' * 11}' is not 24 hexadecimal digits"),
        (Identity("base", 1, 1, "zz" * 12), "is not 24 hexadecimal digits"),
    ],
)
def test_identity_that_does_not_fit_is_refused(identity, message):
    with pytest.raises(ValueError, match=message):
        identity_answer(identity)


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
