"""Frames in words: keys that `wheelbench decode --json` promises, and one line for a person."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import LINES, frame

from bench.slamware import FrameDecoder, describe, encode_frame, summary


def only_event(data):
    (event,) = FrameDecoder().feed(data)
    return event


def test_a_request_as_decode_prints_it():
    assert describe(only_event(bytes.fromhex("10 03 F8 10 01 FA"))) == {
        "event": "frame",
        "protocol": "slamware",
        "offset": 0,
        "length": 6,
        "type": "standard",
        "code": 248,
        "payload": "1001",
        "decoded": {"as": "CONNECT_BASE request", "sub_command": 16, "protocol_version": 1},
    }


def test_noise_as_decode_prints_it():
    decoder = FrameDecoder()
    decoder.feed(b"\xaa\xbb\xcc")
    assert [describe(event) for event in decoder.finish()] == [
        {"event": "noise", "protocol": "slamware", "offset": 0, "length": 3, "reason": "flag"}
    ]


@pytest.mark.parametrize(
    ("name", "fields", "line"),
    [
        (
            "sdk-setv-fwd.request",
            {
                "as": "SET_V_AND_GET_DEADRECKON request",
                "sub_command": 0x41,
                "vx_mps": 0.25,
                "vy_mps": -6553 / 65536,
                "omega_radps": 0.5,
            },
            "0x41 vx +0.250 vy -0.100 w +0.500",
        ),
        (
            "dr-omni-sideways",
            {
                "as": "SET_V_AND_GET_DEADRECKON answer",
                "dx_m": 0.0,
                "dy_m": 0.0125,
                "dtheta_rad": 0.0,
                "wheel_stalled": False,
                "traction_lost": False,
            },
            "OK dx +0.00 mm dy +12.50 mm dth +0.00 deg",
        ),
        (
            "connect-std.reply",
            {
                "as": "CONNECT_BASE answer",
                "model": "ref base",
                "firmware_version": 90,
                "hardware_version": 1,
                "serial_number": "303132333435363738394142",
            },
            "OK ref base firmware 0.90 hardware 1",
        ),
        (
            "err-checksum-std.reply",
            {"as": "error", "error_code": 0x40, "meaning": "checksum mismatch"},
            "error 0x0040 checksum mismatch",
        ),
        ("sync-std.request", {"as": "SYNC", "bytes": 4}, "SYNC 4 bytes"),
        ("echo-long.reply", {"as": "ECHO", "bytes": 8}, "ECHO 8 bytes"),
        ("std-answer-empty", {"as": "empty OK"}, "OK"),
        ("err-unknown-cmd.request", {}, "code 0x7E with 0 bytes"),
        ("err-unknown-sub.request", {}, "0xA0 with 0 bytes"),
    ],
)
def test_vendor_frames_in_words(name, fields, line):
    event = only_event(frame(name))
    assert describe(event)["decoded"] == fields
    assert summary(event) == line


def test_status_bits_in_words():
    assert summary(only_event(frame("dr-raw-minus-one"))).endswith("deg wheel stalled traction lost")
    assert summary(only_event(frame("dr7-lifted.reply"))).endswith("deg traction lost")
    assert summary(only_event(bytes.fromhex("10 03 F8 10 01 FA"))) == "0x10 connect, protocol version 1"


def test_every_vendor_stream_can_be_told_in_json_and_in_words():
    for line in LINES:
        decoder = FrameDecoder()
        for event in decoder.feed(bytes.fromhex(line["hex"])) + decoder.finish():
            assert json.loads(json.dumps(describe(event)))["protocol"] == "slamware"
            assert summary(event)


@given(st.integers(0, 255), st.binary(max_size=40))
def test_any_frame_can_be_told(code, payload):
    event = only_event(encode_frame(code, payload))
    assert json.loads(json.dumps(describe(event)))["payload"] == payload.hex()
    assert summary(event).isprintable()
