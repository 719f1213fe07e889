"""The vendor's base with its defects, beyond the captured exchanges: what the reference page says was seen."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import VendorRobot

from bench.messages import BodyTwist
from bench.slamware import FrameDecoder, SlamwareFrame, as_reference_firmware, encode_frame
from bench.slamware.config_payloads import decode_tree
from bench.slamware.payloads import Displacement
from bench.slamware.reference_base import reference_facts
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.sense_payloads import Power
from bench.slamware.senses import Motion

STATUS = bytes.fromhex("10 02 F8 30 DA")
LONG_STATUS = bytes.fromhex("50 02 00 F8 30 9A")
FULL = bytes.fromhex("50 03 00 02 64 00 35")
STRAY = bytes.fromhex("50 03 00 03 10 00 40")
TOO_LONG = bytes.fromhex("50 03 00 03 20 00 70")
CHECKSUM = bytes.fromhex("50 03 00 03 C0 00 90")
STRAY_AND_FRAME = bytes.fromhex("50 03 00 03 90 00 C0")
STRAY_AND_TOO_LONG = bytes.fromhex("50 03 00 03 30 00 60")
NOT_SUPPORTED = bytes.fromhex("50 03 00 03 00 80 D0")
EMPTY_OK = bytes.fromhex("50 01 00 02 53")
HALT = encode_frame(0xF8, b"\x41" + bytes(12), "standard")


@pytest.fixture
def base():
    return as_reference_firmware()


def test_every_stray_byte_is_answered(base):
    assert base.receive(b"\xaa\xbb\x00", 0) == STRAY * 3
    assert base.receive(STATUS, 0) == FULL
    assert base.errors == {0x0010: 3}


def test_checksum_errors_carry_the_marker_in_both_frame_types(base):
    assert base.receive(STATUS[:-1] + b"\x00", 0) == CHECKSUM
    assert base.receive(LONG_STATUS[:-1] + b"\x00", 0) == CHECKSUM
    assert not base.alive(0)


def test_no_silence_ends_a_frame(base):
    assert base.receive(STATUS[:4], 0) == b""
    assert base.receive(STATUS[4:], 10**9) == FULL
    assert base.receive(HALT[:7], 10**9) == b""
    assert base.receive(STATUS, 2 * 10**9) == b""
    assert base.receive(STATUS, 3 * 10**9) == CHECKSUM
    assert base.receive(STATUS, 3 * 10**9) == FULL


def test_length_0_repeats_the_previous_request_of_its_type(base):
    assert base.receive(bytes.fromhex("10 00 10"), 0) == bytes.fromhex("10 00 10"), "after boot: a SYNC"
    base.receive(STATUS, 1)
    assert base.receive(bytes.fromhex("10 00 10"), 2) == FULL
    assert base.receive(bytes.fromhex("10 00 11"), 2) == CHECKSUM
    base.receive(LONG_STATUS, 3)
    assert base.receive(bytes.fromhex("50 00 00 50"), 4) == FULL
    assert base.requests == {0x30: 4}
    assert base.alive(1004)


def test_missing_fields_are_those_of_earlier_frames_and_further_ones_are_left_alone(base):
    drive = encode_frame(0xF8, bytes.fromhex("41 00800000 00C0FFFF 00000100"), "standard")
    base.receive(drive, 0)
    assert base.receive(encode_frame(0xF8, bytes.fromhex("41 00400000"), "standard"), 1)[3] == 2
    assert base.wanted_twist == BodyTwist(0.25, -0.25, 1.0)
    base.receive(encode_frame(0xF8, bytes.fromhex("41 00000100 00000000 00000000 FFFFFFFF"), "standard"), 2)
    assert base.wanted_twist == BodyTwist(1.0, 0.0, 0.0)
    assert base.receive(bytes.fromhex("10 01 F8 E9"), 3)[3] == 2
    assert base.requests == {0x41: 4}


def test_oversize_is_seen_at_the_first_byte_of_the_body_and_the_rest_is_stray(base):
    assert base.receive(bytes.fromhex("50 FE 01"), 0) == b""
    assert base.receive(b"\xf8", 0) == TOO_LONG
    assert base.receive(b"\x30\xaa", 0) == STRAY * 2
    assert base.receive(STATUS, 0) == FULL


def test_echo_at_the_edge_of_both_buffers(base):
    for size in (0, 254, 507):
        request = encode_frame(1, bytes(range(256))[: size % 256] + bytes(size - size % 256))
        assert base.receive(request, 0) == request, size
    request = encode_frame(1, bytes(508))
    assert request[1:3] == (509).to_bytes(2, "little")
    answer = base.receive(request, 1)
    assert (len(answer), answer[:-1]) == (513, request[:-1])
    assert answer[-1] != request[-1]
    too_long = base.receive(encode_frame(1, bytes(509)), 2)
    assert too_long == TOO_LONG + STRAY * 510


def test_a_loop_that_is_busy_merges_faults_and_loses_requests():
    slow = as_reference_firmware(bytes_per_look=100)
    assert slow.receive(b"\xaa" + STATUS, 0) == STRAY_AND_FRAME
    assert slow.receive(bytes.fromhex("50 58 02 F8 AA"), 1) == STRAY_AND_TOO_LONG
    assert slow.receive(STATUS + encode_frame(1, b"ab"), 2) == encode_frame(1, b"ab"), "the first was overwritten"
    assert slow.errors == {0x0090: 1, 0x0030: 1}
    with pytest.raises(ValueError, match="bytes_per_look 0 is less than 1"):
        as_reference_firmware(bytes_per_look=0)


@pytest.mark.parametrize("code", [0x02, 0x0F, 0x7E, 0xF9, 0xFF])
def test_other_codes_are_not_supported_and_no_life(base, code):
    assert base.receive(encode_frame(code, b"\x30"), 0) == NOT_SUPPORTED
    assert not base.alive(0)


def test_the_stop_is_at_1001_ms_and_a_new_velocity_starts_at_once(base):
    wheels = base.motion
    base.receive(encode_frame(0xF8, bytes.fromhex("41 00400000 00000000 00000000"), "standard"), 7)
    assert wheels.targets_mmps(base.alive(1007)) == (250, 250)
    assert wheels.targets_mmps(base.alive(1008)) == (0, 0)
    base.receive(STATUS, 2000)
    assert wheels.targets_mmps(base.alive(2000)) == (0, 0)
    base.receive(encode_frame(0xF8, bytes.fromhex("41 00C0FFFF 00000000 00000000"), "standard"), 2001)
    assert wheels.targets_mmps(base.alive(2001)) == (-250, -250)


def test_wheel_speeds_are_taken_as_they_are(base):
    assert base.receive(encode_frame(0xF8, bytes.fromhex("40 C8000000 6AFFFFFF 01000000 02000000")), 0) == EMPTY_OK
    assert base.motion.targets_mmps(True) == (200, -150)
    assert base.wanted_twist == pytest.approx((0.025, 0.0, -350 / 236))


def test_too_far_is_as_far_back_as_can_be():
    class Far(Motion):
        def take_increment(self):
            return Displacement(33.0, -33.0, 600.0)

    base = ReferenceFirmware(reference_facts(), Far())
    base.receive(HALT, 0)
    assert base.receive(HALT, 50)[4:16].hex(" ") == "00 00 00 80 00 00 00 80 00 00 00 80"


def test_a_low_battery_is_told():
    robot = VendorRobot()
    base = as_reference_firmware(robot)
    robot.battery = Power(9)
    assert base.receive(encode_frame(0xF8, b"\x90\x01"), 0) == encode_frame(2, b"\x02\x01")


def test_its_binary_configuration_is_the_tree_that_the_vendor_printed():
    tree = decode_tree(reference_facts().binary_configuration)
    assert list(tree) == [0x00, 0x18, 0x16, 0x1A]
    assert (tree[0][2], tree[0][4], len(tree[0][0x0A])) == ("Slamtec", "Slamware SDP", 6)


pieces = st.one_of(
    st.sampled_from([STATUS, LONG_STATUS, HALT, HALT[:9], b"\x10\x00\x10", b"\x50\x00\x00\x50", b"\x50\x58\x02\xf8"]),
    st.binary(max_size=30),
)


@given(st.lists(pieces, max_size=12).map(b"".join))
def test_any_bytes_are_answered_alike_however_they_are_cut(data):
    whole, bytewise = as_reference_firmware(), as_reference_firmware()
    answers = whole.receive(data, 5)
    assert b"".join(bytewise.receive(data[i : i + 1], 5) for i in range(len(data))) == answers
    # Frames, all of them; but for the SYNC of length 0 that it copies right after boot.
    assert all(
        isinstance(event, SlamwareFrame) or event.reason == "length"
        for event in FrameDecoder(rescan=False, max_bytes=65539).feed(answers)
    )
    assert len(whole._receiver.buffer) == 512
    assert (whole.wanted_twist, whole.requests, whole.errors) == (
        bytewise.wanted_twist,
        bytewise.requests,
        bytewise.errors,
    )
