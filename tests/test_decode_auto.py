"""`wheelbench decode auto FILE`, and the line about a stream's health that `decode` ends with."""

import json
import os
import threading
from collections import Counter

import pytest
from patience import DEADLINE_S
from streams import KNOWN_RC

CAPTURES = sorted(path for path in KNOWN_RC.glob("*.bin"))
RECORDED = ("crsf-tbs-1", "sbus2-futaba-r7008sb-1")
OURS = {"sbus2": "sbus"}


@pytest.fixture(params=[path.stem for path in CAPTURES] + list(RECORDED))
def path(request):
    if request.param in RECORDED:
        return request.getfixturevalue("captures") / "rc" / f"{request.param}.bin"
    return KNOWN_RC / f"{request.param}.bin"


@pytest.mark.parametrize("options", [[], ["--json"], ["--chunk", "7"], ["--no-times", "--json"]], ids=str)
def test_auto_decodes_as_the_named_protocol_does(call, path, options):
    described = json.loads(path.with_suffix(".json").read_text())["protocol"]
    protocol = OURS.get(described, described)
    named, auto = (call("decode", name, path, *options) for name in (protocol, "auto"))
    assert auto[:2] == named[:2]
    first, *rest = auto[2].splitlines()
    assert f"{path.name}: {protocol}" in first
    assert rest == named[2].splitlines()


def test_auto_reads_a_pipe_once(call, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    whole = (KNOWN_RC / "ibus-loss-1.bin").read_bytes()
    writer = threading.Thread(target=pipe.write_bytes, args=(whole,), daemon=True)
    writer.start()
    status, out, _ = call("decode", "auto", pipe)  # a second reading would wait for a writer for ever
    writer.join(DEADLINE_S)
    assert (status, writer.is_alive()) == (0, False)
    assert "channels" in out


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="this system has no file whose reading fails")
def test_a_file_whose_reading_fails_is_one_sentence(call):
    says = "wheelbench decode: /proc/self/mem: cannot be read (Input/output error); check the path\n"
    assert call("decode", "auto", "/proc/self/mem") == (2, "", says)


def test_auto_takes_a_can_log_for_what_it_is(call, tmp_path):
    log = tmp_path / "can.log"
    log.write_text("(0.001000) can0 200#02580258FDA80000\n(0.001000) can0 202#10E1300C03520000\n")
    status, out, err = call("decode", "auto", log, "--json")
    assert (status, out) == call("decode", "c610", log, "--json")[:2]
    assert status == 0
    assert "a CAN log" in err


@pytest.mark.parametrize("data", [b"", b"\x00" * 100, b"hello, world\n"], ids=["empty", "stuck", "text"])
def test_auto_says_what_is_wrong_and_fails(call, tmp_path, data):
    path = tmp_path / "stream.bin"
    path.write_bytes(data)
    status, out, err = call("decode", "auto", path)
    assert (status, out, len(err.splitlines())) == (1, "", 1)


def test_auto_on_what_is_no_file_is_a_usage_error(call, tmp_path):
    assert call("decode", "auto", tmp_path)[0] == call("decode", "auto", tmp_path / "nothing")[0] == 2


def test_decode_ends_with_one_line_about_the_health_of_the_stream(call):
    """The figures as the streams were made: a frame every 10 ms, none late; and as the list of events has them."""
    err = call("decode", "uart12", KNOWN_RC / "uart12-clean-1.bin")[2]
    assert err == ("wheelbench decode: 300 frames; 0 bytes of noise; 100.0 Hz, jitter 0.00 ms; longest gap 10.0 ms\n")
    junk = KNOWN_RC / "uart12-junk-1.bin"
    events = [json.loads(line) for line in call("decode", "uart12", junk, "--no-times", "--json")[1].splitlines()]
    noise = Counter()
    for event in events:
        if event["event"] == "noise":
            noise[event["reason"]] += event["length"]
    told = ", ".join(f"{reason} {count}" for reason, count in noise.most_common())
    assert call("decode", "uart12", junk, "--no-times")[2] == (
        f"wheelbench decode: 160 frames; {noise.total()} bytes of noise ({told})\n"
    )


def test_flags_are_counted_in_the_closing_line_and_json_has_none(call):
    path = KNOWN_RC / "sbus-loss-1.bin"
    rows = json.loads(path.with_suffix(".json").read_text())["frames"]["rows"]
    failsafe, lost = (sum(bool(row[1] & bit) for row in rows) for bit in (8, 4))
    assert f" {len(rows)} frames ({failsafe} failsafe, {lost} frame lost);" in call("decode", "sbus", path)[2]
    assert call("decode", "sbus", path, "--json")[2] == ""
