"""`wheelbench bus` and `wheelbench dbc` as a person meets them."""

import json
from pathlib import Path

import cantools
import pytest

KNOWN = Path(__file__).parents[1] / "fixtures" / "known" / "can"


def test_the_default_robot(call):
    status, out, _ = call("bus", "m2006", "--json")
    facts = json.loads(out)
    assert status == 0
    assert facts["load_percent"] == pytest.approx(
        {"least": 44.4, "typical": 47.8, "at_rest": 49.7, "worst": 54}, abs=0.05
    )
    assert [one["can_id"] for one in facts["messages"]] == [0x200, 0x201, 0x202, 0x203]
    assert [one["response_us"]["worst"] for one in facts["messages"]] == [270, 405, 540, 540]
    assert (facts["verdict"], facts["motors"], facts["guaranteed_feedback_hz"]) == ("guaranteed", 3, 1000)


@pytest.mark.parametrize(
    ("arguments", "status", "verdict"),
    [
        (["--nodes", 5], 0, "guaranteed"),
        (["--nodes", 6], 0, "in practice"),
        (["--nodes", 7], 1, "too much"),
        (["--nodes", 8, "--feedback-hz", 500], 0, "guaranteed"),
        (["--bitrate", 400000], 1, "too much"),
        (["--bitrate", 500000, "--feedback-hz", 400, "--command-hz", 400], 0, "guaranteed"),
        (["--nodes", 5, "--also", "0x205:1000"], 1, "clash"),
        (["--nodes", 5, "--also", "0x209:1000"], 0, "in practice"),
        (["--also", "0x101:50:4", "--also", "257:50:4"], 1, "clash"),
    ],
)
def test_verdicts_and_exit_status(call, arguments, status, verdict):
    found, out, _ = call("bus", "m2006", *arguments, "--json")
    assert (found, json.loads(out)["verdict"]) == (status, verdict)


def test_a_line_for_every_number_of_motors(call):
    status, out, _ = call("bus", "m2006", "--nodes", "3-8", "--json")
    facts = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert [round(one["load_percent"]["typical"], 1) for one in facts] == [47.8, 59.8, 83.8, 95.7, 107.6, 119.6]


def test_what_would_fit_is_said(call):
    _, out, _ = call("bus", "m2006", "--nodes", 8)
    assert "does not fit: 0x207, 0x208 will get lost, 0x206 may be late" in out
    assert "guaranteed up to 617 Hz of feedback" in out
    assert "no bound" in out
    _, out, _ = call("bus", "m2006", "--bitrate", 100_000)
    assert "no rate of feedback would fit" in out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--nodes", "0"], "--nodes: expected 1 to 8 or a range of these like 3-8, got '0'"),
        (["--nodes", "9"], "--nodes: expected 1 to 8"),
        (["--nodes", "5-3"], "--nodes: expected 1 to 8"),
        (["--nodes", "three"], "--nodes: expected 1 to 8"),
        (["--also", "0x205"], "--also: expected ID:HZ or ID:HZ:BYTES like 0x205:1000, got '0x205'"),
        (["--also", "0x800:10"], "--also: expected"),
        (["--also", "0x205:0"], "--also: expected"),
        (["--also", "0x205:10:9"], "--also: expected"),
        (["--also", "0x205:10:8:1"], "--also: expected"),
        (["--feedback-hz", "0"], "--feedback-hz: expected 1 to 1000000, got 0"),
        (["--bitrate", "2000000"], "--bitrate: expected 1 to 1000000"),
        (["--log", "nowhere.log"], "nowhere.log: is no file"),
        (["--log", KNOWN / "c610-frames.json"], "is no CAN log that can be read"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(call, arguments, says):
    status, out, err = call("bus", "m2006", *arguments)
    assert (status, out) == (2, "")
    assert says in err


def test_a_recorded_bus_with_strangers(call):
    status, out, _ = call("bus", "m2006", "--log", KNOWN / "clash.log", "--json")
    facts = json.loads(out)
    assert status == 1
    assert facts["frames"] == 120
    assert [text.partition(",")[0] for text in facts["findings"]] == ["0x205 unknown ESC", "0x200 two senders"]


def test_times_of_a_log_count_from_its_first_frame(call, tmp_path):
    log = tmp_path / "late.log"
    log.write_text("(1700000000.000000) can0 201#0000000000000000\n(1700000002.500000) can0 205#0000000000000000\n")
    _, out, _ = call("bus", "m2006", "--log", log)
    assert "2 frames in 2.500 s" in out
    assert "0x205 unknown ESC, once since 2.500 s" in out


def test_the_busiest_tenth_of_a_second_is_found(call, tmp_path):
    # 100 frames of 125 bits in the first 50 ms, then one a second
    times = [500 * n for n in range(100)] + [1_000_000 * n for n in range(1, 10)]
    log = tmp_path / "burst.log"
    log.write_text("".join(f"({us / 1e6:.6f}) can0 201#0000000000000000\n" for us in times))
    facts = json.loads(call("bus", "m2006", "--log", log, "--json")[1])
    assert facts["load_percent"] == {"mean": 0.15, "busiest_100_ms": 12.5}


def test_a_recorded_bus_of_our_own(call, tmp_path):
    scenario = tmp_path / "short.toml"
    scenario.write_text('schema = 1\nname = "short"\nseconds = 0.3\n')
    assert call("replay", scenario, "--robot", "dm3519", "--record", tmp_path / "run")[0] == 0
    status, out, _ = call("bus", "dm3519", "--log", tmp_path / "run" / "can.log")
    assert (status, out.splitlines()[-1]) == (0, "nobody is on the bus who should not be")


def test_extended_and_remote_frames_of_a_log_count_and_are_nobodys(call, tmp_path):
    log = tmp_path / "mixed.log"
    log.write_text("(0.000000) can0 00000201#0000000000000000\n(0.001000) can0 201#R8\n(0.002000) can0 201#00\n")
    status, out, _ = call("bus", "m2006", "--log", log, "--json")
    facts = json.loads(out)
    assert [(one["can_id"], one["extended"], one["frames"]) for one in facts["messages"]] == [
        (0x201, False, 2),
        (0x201, True, 1),
    ]
    assert (status, len(facts["findings"])) == (1, 1), "the frame of one byte"
    assert call("decode", "c610", log)[0] == 1, "none of these is a C610's"


def test_an_empty_log_is_refused(call, tmp_path):
    log = tmp_path / "empty.log"
    log.write_text("")
    assert call("bus", "m2006", "--log", log)[0] == 2


@pytest.mark.parametrize(("robot", "messages"), [("m2006", 11), ("dm3519", 11)])
def test_the_dbc_verb_prints_a_dbc(call, robot, messages):
    status, out, _ = call("dbc", robot)
    database = cantools.database.load_string(out, "dbc", strict=True)
    assert (status, len(database.messages)) == (0, messages)
    assert f"the robot {robot}" in out


def test_the_dbc_has_the_variant_of_the_robot_file(call, tmp_path):
    own = tmp_path / "own.toml"
    text = (Path(__file__).parents[1] / "bench" / "robots" / "dm3519.toml").read_text()
    own.write_text(text.replace('"error"', '"temperatures"').replace("20.0", "20.5").replace('"long"', '"short"'))
    database = cantools.database.load_string(call("dbc", own)[1], "dbc", strict=True)
    feedback = database.get_message_by_frame_id(0x201)
    assert [signal.name for signal in feedback.signals] == ["angle", "speed", "current", "coil", "mosfet"]
    assert database.get_message_by_frame_id(0x7FF).length == 4
    assert database.decode_message(0x200, bytes.fromhex("4000") + bytes(6))["current_1"] == 20.5


def test_a_dm3519_log_is_decoded_by_its_robot(call):
    log = KNOWN / "dm3519-frames.log"
    assert "error_name link lost" in call("decode", "dm3519", log, "--robot", "dm3519")[1]
    assert "coil_degc 41  mosfet_degc 13" in call("decode", "dm3519", log)[1]
    status, _, err = call("decode", "dm3519", log, "--robot", "m2006")
    assert (status, "m2006 has motors of kind c610, not dm3519" in err) == (2, True)
