"""Captures on disk: what is read, what is refused and with which sentence, and which tick a byte belongs to."""

import hashlib
import json

import pytest
from streams import KNOWN_RC, read_stream

from bench import rc_decode
from bench.errors import UsageError
from bench.rc.capture import by_tick, load_capture

FRAME = rc_decode.encode("uart12", (2048, 2048, 2048, 2048, 0, 0))


@pytest.fixture
def pair(tmp_path):
    """Write a capture and its description; returns the path of the bytes."""

    def write(data=FRAME, name="mine", **changes):
        described = {
            "format": "rc-capture/1",
            "bin": f"{name}.bin",
            "length": len(data),
            "sha256": hashlib.sha256(data).hexdigest(),
            "protocol": "uart12",
        }
        described.update(changes)
        path = tmp_path / f"{name}.bin"
        path.write_bytes(data)
        path.with_suffix(".json").write_text(json.dumps(described), encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("name", sorted(path.stem for path in KNOWN_RC.glob("*.bin")))
def test_every_capture_is_read_as_its_description_says(name):
    stream = read_stream(KNOWN_RC / name)
    capture = load_capture(KNOWN_RC / f"{name}.bin")
    assert (capture.data, capture.protocol) == (stream.data, stream.protocol)
    assert capture.times_us == (None if stream.times_us is None else pytest.approx(stream.times_us))
    assert load_capture(KNOWN_RC / f"{name}.json") == capture
    without = load_capture(KNOWN_RC / f"{name}.bin", use_times=False)
    assert (without.data, without.times_us, without.protocol) == (stream.data, None, stream.protocol)


def test_read_sizes_are_no_times_and_sbus2_is_our_sbus(captures):
    assert load_capture(captures / "rc" / "crsf-tbs-1.bin").times_us is None
    futaba = load_capture(captures / "rc" / "sbus2-futaba-r7008sb-1.bin")
    assert futaba.protocol == "sbus"
    assert futaba.times_us is not None
    assert futaba.times_us[13] == 15000.6


def test_a_file_of_raw_bytes_needs_no_description(tmp_path):
    path = tmp_path / "dump"
    path.write_bytes(FRAME)
    capture = load_capture(path)
    assert (capture.path, capture.data, capture.times_us, capture.protocol) == (path, FRAME, None, None)


# --- refusals ----------------------------------------------------------------------------------------------------


def refusal(path):
    with pytest.raises(UsageError) as caught:
        load_capture(path)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_a_missing_file_is_named(tmp_path):
    for name in ("nowhere.bin", "nowhere.json"):
        assert "no such file" in (text := refusal(tmp_path / name))
        assert name in text


def test_a_directory_is_refused(tmp_path):
    assert "is a directory; a capture is a file of raw bytes" in refusal(tmp_path)


def test_an_empty_file_is_refused(tmp_path):
    path = tmp_path / "empty.bin"
    path.touch()
    assert "empty.bin: is empty" in refusal(path)


def test_a_description_of_other_bytes_is_refused(pair):
    assert "mine.json: describes 13 bytes, but mine.bin has 12" in refusal(pair(length=13))
    assert "mine.json: describes other bytes than those in mine.bin (sha256 differs)" in refusal(pair(sha256="00" * 32))


def test_a_json_that_is_no_description_is_refused(tmp_path):
    path = tmp_path / "mine.bin"
    path.write_bytes(FRAME)
    for text in ("{", "[1]", '{"format": "other/1"}', "\xff"):
        path.with_suffix(".json").write_bytes(text.encode("latin-1"))
        assert "mine.json: " in refusal(path)
        assert "move it away to use the bytes alone" in refusal(path)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"protocol": 7}, "protocol: expected text, got 7"),
        ({"length": "12"}, "length: expected a whole number, got '12'"),
        ({"timing": []}, "timing: expected an object"),
        ({"timing": {"kind": "per byte"}}, "byte_times: expected a list"),
        ({"timing": {"kind": "per byte", "byte_times": [0.0] * 11}}, "11 times for 12 bytes; mend it, or move it away"),
        ({"timing": {"kind": "per byte", "byte_times": [5, 4] * 6}}, "byte 1 comes at 4 us, after 5 us"),
        ({"timing": {"kind": "per byte", "byte_times": ["a"] * 12}}, "byte 0 comes at 'a' us"),
        ({"timing": {"kind": "per byte", "byte_times": [-1.0] * 12}}, "byte 0 comes at -1.0 us"),
        ({"timing": {"kind": "per byte", "byte_times": [10**400] * 12}}, "byte 0 comes at 1000"),
        ({"timing": {"kind": "per byte", "byte_times": [86_400_000_001.0] * 12}}, "byte 0 comes at 86400000001.0 us"),
        ({"timing": {"kind": "per burst", "byte_us": 1.5, "rows": [[0, 10**400]]}}, "expected byte_us and rows"),
        ({"timing": {"kind": "per burst", "byte_us": 10**400, "rows": [[0, 1.5]]}}, "expected byte_us and rows"),
        ({"timing": {"kind": "per burst", "rows": [[0, 0.0]]}}, "expected byte_us and rows"),
        ({"timing": {"kind": "per burst", "byte_us": 100, "rows": [[0]]}}, "expected byte_us and rows"),
        ({"timing": {"kind": "per burst", "byte_us": 100, "rows": [[3, 0.0]]}}, "a burst begins at byte 3, not at 0"),
    ],
)
def test_a_description_that_cannot_be_right_is_refused_by_key(pair, changes, text):
    assert text in refusal(pair(**changes))


# --- ticks -------------------------------------------------------------------------------------------------------


def test_times_are_rounded_down_to_ticks(pair):
    times = [0, 999.9, 1000, 1999, 2000, *[2500.5] * 6, 7001]
    capture = load_capture(pair(timing={"kind": "per byte", "byte_times": times}))
    assert by_tick(capture, "uart12") == {0: FRAME[:2], 1: FRAME[2:4], 2: FRAME[4:11], 7: FRAME[11:]}


def test_bytes_of_a_burst_follow_each_other(pair):
    timing = {"kind": "per burst", "byte_us": 400.0, "rows": [[0, 0.0], [4, 10_000.0]]}
    capture = load_capture(pair(timing=timing))
    assert capture.times_us[:5] == (400.0, 800.0, 1200.0, 1600.0, 10_400.0)
    assert by_tick(capture, "uart12")[0] == FRAME[:2]


def test_without_times_whole_frames_are_paced_and_junk_travels_with_them(pair):
    data = b"\x01\x02" + FRAME + FRAME + b"\x03" + FRAME + b"\x04\x05"
    capture = load_capture(pair(data))
    assert by_tick(capture, "uart12", 10) == {
        0: b"\x01\x02" + FRAME,
        10: FRAME,
        20: b"\x03" + FRAME + b"\x04\x05",
    }


def test_without_any_frame_all_bytes_come_at_once(pair):
    assert by_tick(load_capture(pair(b"\x01\x02\x03")), "uart12", 10) == {0: b"\x01\x02\x03"}


def test_without_times_a_period_is_needed(pair):
    capture = load_capture(pair())
    with pytest.raises(UsageError, match=r"mine.bin: has no byte times; give .* --period-ms"):
        by_tick(capture, "uart12")
    with pytest.raises(UsageError, match="a period of 0 ms"):
        by_tick(capture, "uart12", 0)


@pytest.mark.parametrize("name", ["crsf-loss-1", "sbus-loss-1", "uart12-junk-1"])
@pytest.mark.parametrize("use_times", [True, False])
def test_ticks_hold_every_byte_in_order_and_the_bench_sees_every_frame(name, use_times):
    stream = read_stream(KNOWN_RC / name)
    ticks = by_tick(load_capture(KNOWN_RC / f"{name}.bin", use_times), stream.protocol, 9)
    assert list(ticks) == sorted(ticks)
    assert b"".join(ticks.values()) == stream.data
    decoder = rc_decode.decoder(stream.protocol, pause_us=2000)
    for tick in range(max(ticks) + 10):
        decoder.feed(ticks.get(tick, b""), tick * 1000)
    assert decoder.counters.frames == len(stream.frames)
