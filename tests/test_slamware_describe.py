"""Frames in words: keys that `wheelbench decode --json` promises, and one line for a person."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import EXCHANGES, LINES, frame

from bench.slamware import Conversation, FrameDecoder, describe, encode_frame, summary
from bench.slamware.payloads import omni_motor_answer


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


def both_ways(data):
    conversation = Conversation()
    return [conversation.describe(event).get("decoded", {}) for event in FrameDecoder().feed(data)]


@pytest.mark.parametrize(
    ("exchange", "asked", "told"),
    [
        (
            "status-dock-charging",
            {"as": "GET_BASE_STATUS request", "sub_command": 0x30},
            {"percent": 100, "charging": True, "external_supply": False, "on_dock": True},
        ),
        (
            "motor-data-1000-500",
            {"sub_command": 0x31},
            {"wheel_1_m": 1.0, "wheel_2_m": 0.5, "wheel_stalled": False, "traction_lost": False},
        ),
        ("bumper-left", {"sub_command": 0x33}, {"bits": 0x3FE, "triggered": "0"}),
        ("bumper-cliff-0", {}, {"bits": 0x3FB, "triggered": "2"}),
        (
            "auto-home-each-own",
            {"data_type": 0},
            {"beacons": 3, "receivers": 3, "receiver_1_bits": 1, "receiver_2_bits": 2, "receiver_3_bits": 4},
        ),
        ("sensor-data-4ch", {}, {"range_1_m": 0.5, "range_2_m": 0.0, "range_3_m": 1.234, "range_4_m": 4.0}),
        (
            "set-motor-neg",
            {"wheel_1_mps": -0.15, "wheel_2_mps": 0.15, "wheel_3_mps": 0.0, "wheel_4_mps": 0.0},
            {"as": "empty OK"},
        ),
        ("poll-none", {"as": "POLL_BASE_CMD request"}, {"as": "empty OK"}),
        ("poll-start-sweep", {}, {"base_request": 0x80, "meaning": "start sweep"}),
        ("event-system-up", {"core_event": 0x63, "meaning": "system up"}, {"as": "empty OK"}),
        ("event-unknown", {"core_event": 0x7F, "meaning": "unknown"}, {"as": "empty OK"}),
        ("health-warn", {"health_command": 1}, {"levels": 1, "number": 1}),
        (
            "health-warn-detail",
            {"health_command": 2, "index": 0},
            {"fault_code": 0x01020100, "text": "Low battery.", "meaning": "power warning: battery low, unit 0"},
        ),
        ("health-clear-known", {"health_command": 3, "fault_code": 0x01020100}, {"as": "empty OK"}),
        ("binary-conf-long", {}, {"bytes": 308}),
        (
            "base-conf-std",
            {},
            {
                "shape": 0,
                "radius_m": 0.18,
                "drive": 0,
                "range_sensors": 4,
                "range_sensor_2_y_m": -0.12,
                "bumpers": 2,
                "bumper_1_z_m": 0.05,
            },
        ),
    ],
)
def test_answers_in_the_light_of_their_requests(exchange, asked, told):
    (found,) = (each for each in EXCHANGES if each.name == exchange)
    request, answer = both_ways(found.request + found.answers)
    assert {key: request[key] for key in asked} == asked
    assert {key: answer[key] for key in told} == told


def test_every_answer_of_the_vendor_is_read_as_what_was_asked():
    read = 0
    for exchange in EXCHANGES:
        if exchange.request is not None and exchange.lines[0]["normative"]:
            *_, request, answer = both_ways(exchange.request + exchange.answers)
            if request.get("sub_command") is not None and answer["as"] not in ("empty OK", "error"):
                assert request["as"].split()[0] == answer["as"].split()[0], exchange.name
                read += 1
    assert read == 41


def test_the_tree_of_the_binary_configuration_keeps_its_shape():
    told = describe(only_event(frame("binary-conf-long.reply")))["decoded"]
    assert told["as"] == "GET_BINARY_CONF answer"
    base = told["tree"]["0x00"]
    assert base["0x02"] == "Slamtec"
    assert base["0x0A"][0]["0x0B"] == {"symbol": 0x0C}
    assert base["0x0A"][5]["0x0D"]["0x0E"] == pytest.approx(0.044)


def test_rims_and_a_tree_with_a_number_that_is_none():
    rims = encode_frame(2, omni_motor_answer((0.1, -0.2, 0.3), (0.004, 0.0, 0.0)))
    told = describe(only_event(rims), b"\x31")["decoded"]
    assert (told["wheel_1_m"], told["wheel_2_m"], told["wheel_4_m"], told["dx_m"]) == (0.1, -0.2, 0.0, 0.004)
    nan = encode_frame(2, bytes.fromhex("50 01 06 20 00 00 C0 7F"))
    assert describe(only_event(nan))["decoded"]["tree"] == {"0x06": "nan"}


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("set-motor-200-200.request", "0x40 +0.200 +0.200 +0.000 +0.000 m/s"),
        ("event-start-vacuum.request", "0x60 event 0x82 vacuum on"),
        ("motor-data-zero.request", "0x31 GET_BASE_MOTOR_DATA"),
        ("auto-home-none.request", "0x34 GET_AUTO_HOME_DATA data_type 0"),
        ("bumper-idle.reply", "OK contacts 0x000003FF"),
        ("bumper-left.reply", "OK contacts 0x000003FE triggered 0"),
        ("motor-data-1000-500.reply", "OK wheel_1_m 1.0 wheel_2_m 0.5 wheel_stalled False traction_lost False"),
        ("binary-conf-long.reply", "OK binary configuration of 308 bytes"),
        ("auto-home-none.reply", "OK beacons 3 receivers 3 receiver_1_bits 0 receiver_2_bits 0 receiver_3_bits 0"),
        ("status-77.reply", "code 0x02 with 2 bytes"),
    ],
)
def test_one_line_each_without_knowing_what_was_asked(name, line):
    assert summary(only_event(frame(name))) == line


@pytest.mark.parametrize(
    ("name", "asked", "line"),
    [
        ("status-77.reply", b"\x30", "OK battery 77 %"),
        ("status-dock-charging.reply", b"\x30", "OK battery 100 % charging on the dock"),
        ("poll-upgrade.reply", b"\x50", "OK base_request 83 meaning firmware upgrading"),
        ("health-warn.reply", b"\x90\x01", "OK levels 1 number 1"),
        ("status-77.reply", b"\x41" + bytes(12), "code 0x02 with 2 bytes"),
    ],
)
def test_one_line_each_when_it_is_known(name, asked, line):
    assert summary(only_event(frame(name)), asked) == line


@given(st.integers(0, 255), st.binary(max_size=70), st.binary(max_size=3))
def test_any_frame_can_be_told(code, payload, asked):
    event = only_event(encode_frame(code, payload))
    assert json.loads(json.dumps(describe(event)))["payload"] == payload.hex()
    assert json.dumps(describe(event, asked))
    assert summary(event).isprintable()
    assert summary(event, asked).isprintable()
