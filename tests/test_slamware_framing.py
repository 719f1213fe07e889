"""Framing of the control bus: literals of the reference page, the vendor's frames, and any bytes at all."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from slamware_vendor import BY_NAME, LINES, frame

from bench.slamware import FrameDecoder, SlamwareFrame, SlamwareNoise, encode_frame
from bench.slamware.framing import CONTROL_BUS, ECHO, ERROR, INVALID, OK, SYNC, xor_of

FRAMES = [line for line in LINES if line["frame"] is not None]
GOOD = [line for line in FRAMES if line["frame"]["checksum_ok"] and line["frame"]["length_field"] > 0]

STATUS_REQUEST = bytes.fromhex("10 02 F8 30 DA")
EMPTY_OK = bytes.fromhex("50 01 00 02 53")


def rescanning():
    return FrameDecoder()


def strict():
    return FrameDecoder(rescan=False, max_bytes=513)


def events_of(make, data, finish=True):
    """The events of a stream, checked to be the same whole, in bytes, and cut in two at many places."""
    decoder = make()
    expected = decoder.feed(data) + (decoder.finish() if finish else [])
    cuts = range(0, len(data) + 1, max(1, len(data) // 40))
    for chunks in [[data[i : i + 1] for i in range(len(data))], *([data[:cut], data[cut:]] for cut in cuts)]:
        decoder = make()
        got = [event for chunk in chunks for event in decoder.feed(chunk)] + (decoder.finish() if finish else [])
        assert got == expected
    return expected


# --- what the reference page and the vendor's code say -------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "kind", "code", "payload"),
    [
        ("10 02 F8 30 DA", "standard", 0xF8, "30"),
        ("50 02 00 F8 30 9A", "long", 0xF8, "30"),
        ("50 03 00 02 4D 00 1C", "long", 0x02, "4D 00"),
        ("50 01 00 02 53", "long", 0x02, ""),
        ("50 03 00 03 00 80 D0", "long", 0x03, "00 80"),
        ("10 03 F8 10 01 FA", "standard", 0xF8, "10 01"),
    ],
)
@pytest.mark.parametrize("make", [rescanning, strict])
def test_worked_examples_both_ways(make, data, kind, code, payload):
    data, payload = bytes.fromhex(data), bytes.fromhex(payload)
    assert events_of(make, data) == [SlamwareFrame(0, len(data), kind, code, payload)]
    assert encode_frame(code, payload, kind) == data


@pytest.mark.parametrize("line", GOOD, ids=lambda line: line["name"])
@pytest.mark.parametrize("make", [rescanning, strict])
def test_every_frame_of_the_vendor_is_read_and_rebuilt(make, line):
    data = bytes.fromhex(line["hex"])
    said = line["frame"]
    payload = bytes.fromhex(said["payload"])
    assert events_of(make, data) == [SlamwareFrame(0, len(data), said["type"], said["code"], payload)]
    assert encode_frame(said["code"], payload, said["type"]) == data


def test_the_vendor_frames_are_all_there():
    assert (len(LINES), len(FRAMES), len(GOOD)) == (161, 154, 152)


@pytest.mark.parametrize("make", [rescanning, strict])
def test_damaged_vendor_frames_are_refused(make):
    for name in ("err-checksum-std.request", "keep-bad-checksum.request"):
        data = bytes.fromhex(BY_NAME[name]["hex"])
        assert [(event.offset, event.length, event.reason) for event in events_of(make, data)] == [
            (0, len(data), "checksum")
        ]


def test_flipping_any_single_bit_of_a_frame_refuses_it():
    good = frame("dr2-straight.request")
    for bit in range(8 * len(good)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        for make in (rescanning, strict):
            assert not [event for event in events_of(make, bytes(bad)) if isinstance(event, SlamwareFrame)], bit


# --- the limits --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "size", "kind", "message"),
    [
        (-1, 0, "long", "code -1 outside 0..255"),
        (256, 0, "standard", "code 256 outside 0..255"),
        (0xF8, 255, "standard", r"payload of 255 bytes; a standard frame takes 0\.\.254"),
        (0xF8, 65535, "long", r"payload of 65535 bytes; a long frame takes 0\.\.65534"),
        (0xF8, 0, "short", "frame type 'short'; known: standard, long"),
    ],
)
def test_encoder_refuses_what_no_frame_can_hold(code, size, kind, message):
    with pytest.raises(ValueError, match=message):
        encode_frame(code, bytes(size), kind)


def test_largest_frames():
    assert len(encode_frame(1, bytes(254), "standard")) == 258
    largest = encode_frame(1, bytes(65534), "long")
    assert len(largest) == 65539
    assert FrameDecoder(max_bytes=65539).feed(largest)[0].payload == bytes(65534)
    assert FrameDecoder(max_bytes=65538).feed(largest) == []


def test_strict_receiver_takes_length_509_and_refuses_510():
    takes = encode_frame(1, bytes(508))
    assert takes[1:3] == (509).to_bytes(2, "little")
    assert [type(event) for event in events_of(strict, takes)] == [SlamwareFrame]
    refuses = encode_frame(1, bytes(509))
    assert events_of(strict, refuses) == [SlamwareNoise(0, 514, "oversize")]


@pytest.mark.parametrize(("size", "found"), [(1024, [SlamwareFrame]), (1025, [SlamwareNoise])])
def test_a_receiver_waits_for_1024_bytes_unless_told(size, found):
    """The buffer of the vendor's master driver."""
    decoder = FrameDecoder(rescan=False)
    assert [type(event) for event in decoder.feed(encode_frame(1, bytes(size - 5)))] == found


@pytest.mark.parametrize("data", ["10 12", "50 11 00"])
def test_an_oversize_frame_is_refused_with_the_last_byte_of_its_length(data):
    data = bytes.fromhex(data)
    takes, refuses = (FrameDecoder(rescan=False, max_bytes=size) for size in (21, 20))
    assert takes.feed(data) == []
    assert refuses.feed(data[:-1]) == []
    assert refuses.feed(data[-1:]) == [SlamwareNoise(0, 21, "oversize")]


def test_the_codes_are_those_of_the_vendor():
    assert (SYNC, ECHO, OK, ERROR, CONTROL_BUS, INVALID) == (0x00, 0x01, 0x02, 0x03, 0xF8, 0xFF)


def test_strict_receiver_passes_over_the_body_of_an_oversize_frame():
    body = STATUS_REQUEST * 120
    oversize = encode_frame(1, body)
    assert strict().feed(oversize[:3]) == [SlamwareNoise(0, 605, "oversize")]
    assert events_of(strict, oversize + STATUS_REQUEST) == [
        SlamwareNoise(0, 605, "oversize"),
        SlamwareFrame(605, 5, "standard", 0xF8, b"\x30"),
    ]


@pytest.mark.parametrize(("data", "size"), [("10 00 10", 3), ("50 00 00 50", 4)])
def test_length_0_is_refused_and_nothing_after_it_is_lost(data, size):
    data = bytes.fromhex(data)
    good = SlamwareFrame(size, 5, "standard", 0xF8, b"\x30")
    assert events_of(strict, data + STATUS_REQUEST) == [SlamwareNoise(0, size, "length"), good]
    assert events_of(rescanning, data + STATUS_REQUEST) == [SlamwareNoise(0, size, "length"), good]


# --- damage ------------------------------------------------------------------------------------------------------


def test_rescanning_reports_noise_as_one_run_before_the_next_frame():
    data = b"\xaa\xbb\xcc" + EMPTY_OK + b"\x10\x10" + EMPTY_OK
    assert rescanning().feed(b"\xaa\xbb\xcc") == []
    assert events_of(rescanning, data) == [
        SlamwareNoise(0, 3, "flag"),
        SlamwareFrame(3, 5, "long", 2, b""),
        SlamwareNoise(8, 2, "stalled"),
        SlamwareFrame(10, 5, "long", 2, b""),
    ]


def test_rescanning_finds_a_frame_inside_a_damaged_one_and_strict_does_not():
    inner = frame("dr1-first.request")
    damaged = bytearray(encode_frame(1, inner))
    damaged[-1] ^= 0x01
    data = bytes(damaged) + EMPTY_OK
    assert events_of(rescanning, data) == [
        SlamwareNoise(0, 4, "checksum"),
        SlamwareFrame(4, 17, "standard", 0xF8, inner[3:-1]),
        SlamwareNoise(21, 1, "flag"),
        SlamwareFrame(22, 5, "long", 2, b""),
    ]
    assert events_of(strict, data) == [SlamwareNoise(0, 22, "checksum"), SlamwareFrame(22, 5, "long", 2, b"")]


def test_strict_receiver_reports_every_stray_byte_as_it_comes():
    assert events_of(strict, b"\xaa\xbb" + STATUS_REQUEST) == [
        SlamwareNoise(0, 1, "flag"),
        SlamwareNoise(1, 1, "flag"),
        SlamwareFrame(2, 5, "standard", 0xF8, b"\x30"),
    ]


@pytest.mark.parametrize(("gap", "stalls"), [(99, False), (100, True), (101, True), (5000, True)])
def test_a_partial_frame_is_dropped_after_100_ms_of_silence(gap, stalls):
    for make in (rescanning, strict):
        decoder = make()
        assert decoder.feed(STATUS_REQUEST[:4], 1000) == []
        assert decoder.feed(b"", 1050) == []  # an empty read is not a byte
        got = decoder.feed(STATUS_REQUEST, 1000 + gap) + decoder.finish()
        if stalls:
            assert got == [SlamwareNoise(0, 4, "stalled"), SlamwareFrame(4, 5, "standard", 0xF8, b"\x30")]
        else:
            assert got[0].reason == "checksum"


def test_silence_ends_an_oversize_frame_too():
    for gap, code in ((99, []), (100, [0xF8])):
        decoder = strict()
        assert decoder.feed(bytes.fromhex("50 58 02 F8"), 0) == [SlamwareNoise(0, 604, "oversize")]
        assert [event.code for event in decoder.feed(STATUS_REQUEST, gap)] == code


def test_without_times_nothing_ever_stalls():
    decoder = strict()
    assert [decoder.feed(bytes((byte,))) for byte in STATUS_REQUEST][:4] == [[]] * 4


def test_slow_bytes_are_no_fault():
    for make in (rescanning, strict):
        decoder = make()
        got = [event for i, byte in enumerate(STATUS_REQUEST) for event in decoder.feed(bytes((byte,)), 99 * i)]
        assert got == [SlamwareFrame(0, 5, "standard", 0xF8, b"\x30")]


# --- any bytes ---------------------------------------------------------------------------------------------------

small_frames = st.builds(
    encode_frame, st.integers(0, 255), st.binary(max_size=40), st.sampled_from(["standard", "long"])
)
streams = st.lists(
    st.one_of(
        small_frames,
        small_frames.map(lambda data: data[:-1]),
        st.binary(max_size=20),
        st.sampled_from([b"\x10", b"\x50", b"\x10\x00\x10", b"\x50\x58\x02", b"\x50\x05\x00", b"\x10\x10\x10"]),
    ),
    max_size=12,
).map(b"".join)
modes = st.sampled_from([rescanning, strict])


@given(st.binary(max_size=600))
def test_checksum_is_the_xor_of_all_bytes(data):
    expected = 0
    for byte in data:
        expected ^= byte
    assert xor_of(data) == expected


@given(st.integers(0, 255), st.binary(max_size=254), st.sampled_from(["standard", "long"]), modes)
def test_decoding_gives_back_what_was_encoded(code, payload, kind, make):
    data = encode_frame(code, payload, kind)
    assert make().feed(data) == [SlamwareFrame(0, len(data), kind, code, payload)]


@given(streams, modes, st.lists(st.integers(0, 400), max_size=8), st.lists(st.integers(0, 150), max_size=9))
def test_events_depend_on_bytes_and_ticks_not_on_cuts(data, make, cuts, waits):
    """Chunks that share a tick may be cut again at will; events come in stream order."""
    edges = sorted({0, len(data), *(cut for cut in cuts if cut < len(data))})
    chunks = [data[a:b] for a, b in pairwise(edges)]
    coarse, fine = make(), make()
    expected, got = [], []
    tick = 0
    for i, chunk in enumerate(chunks):
        tick += waits[i] if i < len(waits) else 1
        expected += coarse.feed(chunk, tick)
        for k in range(len(chunk)):
            got += fine.feed(chunk[k : k + 1], tick)
            got += fine.feed(b"", tick)
    assert got + fine.finish() == expected + coarse.finish()
    offsets = [event.offset for event in got]
    assert offsets == sorted(set(offsets))


@given(streams)
def test_rescanning_accounts_for_every_byte_once(data):
    decoder = rescanning()
    end = 0
    for event in decoder.feed(data) + decoder.finish():
        assert event.offset == end
        end += event.length
    assert end == len(data)


@given(st.binary(max_size=64), small_frames)
def test_rescanning_never_misses_a_frame_after_noise_without_flag_bytes(noise, good):
    noise = noise.replace(b"\x10", b"").replace(b"\x50", b"")
    decoder = rescanning()
    assert (decoder.feed(noise + good) + decoder.finish())[-1].offset == len(noise)


@given(st.binary(min_size=1, max_size=40), modes)
def test_memory_stays_bounded_for_ever(pattern, make):
    decoder = make()
    limit = 1024 if make is rescanning else 513
    for _ in range(300):
        decoder.feed(pattern)
        assert len(decoder._rest) < limit
