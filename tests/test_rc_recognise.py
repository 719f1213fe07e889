"""Which protocol a file holds, and what is said about one that nothing decodes."""

import binascii
import random

import misreadings
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from misreadings import Mistake
from streams import KNOWN_RC, read_stream

from bench import rc_decode
from bench.rc.line import Settings, read, write
from bench.rc.misread import SHAPES, Budget, frames_at
from bench.rc.recognise import CAN, JUDGED_BYTES, recognise, scores
from bench.slamware.framing import FrameDecoder

OURS = {name: name for name in rc_decode.PROTOCOLS} | {"sbus2": "sbus"}
RECORDED = ["crsf-tbs-1", "sbus2-futaba-r7008sb-1"]
FOREIGN = {
    "foreign-dsmx-1": "looks like Spektrum DSM:",
    "foreign-sumd-1": "looks like Graupner SUMD:",
    "foreign-ghst-1": "looks like ImmersionRC Ghost:",
}
CANNOT_TELL = "cannot tell: "


@pytest.fixture(params=sorted(path.stem for path in KNOWN_RC.glob("*.bin")) + RECORDED)
def stream(request):
    if request.param in RECORDED:
        return read_stream(request.getfixturevalue("captures") / "rc" / request.param)
    return read_stream(KNOWN_RC / request.param)


def test_every_capture_is_named_with_its_times_and_without(stream):
    assert recognise(stream.data).protocol == OURS[stream.protocol]
    assert recognise(stream.data, stream.times_us).protocol == OURS[stream.protocol]


@pytest.mark.parametrize("name", FOREIGN)
def test_protocols_that_we_do_not_decode_are_named_too(captures, name):
    verdict = recognise((captures / "rc" / f"{name}.bin").read_bytes())
    assert (verdict.protocol, verdict.text.startswith(FOREIGN[name])) == (None, True)


def test_the_score_is_the_share_of_bytes_in_good_frames_and_the_next_is_named():
    crsf = KNOWN_RC / "crsf-loss-1.bin"
    data = misreadings.frames("sbus", 1)[0] * 30 + crsf.read_bytes()[:260]
    best, second, *_ = scores(data)
    assert (best.protocol, second.protocol) == ("sbus", "crsf")
    assert best.share == pytest.approx(750 / len(data), abs=0.03)
    assert recognise(data).text.endswith("next is crsf with 25 %")


def test_slamware_and_can_logs_are_recognised():
    vendor = bytes.fromhex("1002F830DA") + bytes.fromhex("1003F81001FA")
    assert len(FrameDecoder().feed(vendor)) == 2
    assert recognise(5 * vendor).protocol == "slamware"
    assert recognise(b"(0.001000) can0 200#02580258FDA80000\n").protocol == CAN


# --- no capture at all -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is empty"),
        (b"\xff" * 3000, "all 3000 bytes are 0xFF"),
        (b"ch1=1500 ch2=1500\r\n" * 20, "is a text"),
        (b"0F E0 03 1F 58 C0 07 16\n" * 4, "xxd -r -p"),
        (b"0fe0031f58c00716b080\n" * 4, "xxd -r -p"),
        (b"\x0f\x12\x00", "3 bytes are too few"),
        (misreadings.frames("sbus", 1)[0], "too few to tell. What there is would do as sbus"),
    ],
    ids=["empty", "stuck", "text", "hex", "hex in one", "short", "one frame without checksum"],
)
def test_what_is_no_capture_is_said(data, says):
    verdict = recognise(data)
    assert verdict.protocol is None
    assert says in verdict.text


def test_a_frame_with_a_checksum_is_enough():
    assert recognise(misreadings.frames("ibus", 1)[0]).protocol == "ibus"


# --- mistakes ----------------------------------------------------------------------------------------------------

TESTED = [
    ("uart12", "100000 baud"),
    ("uart12", "inversion wrong"),
    ("uart12", "8N1, errors kept"),
    ("uart12", "8N1, errors dropped"),
    ("sbus", "115200 8N1, no inverter"),
    ("sbus", "bits reversed"),
    ("dbus", "115200 baud"),
    ("ibus", "230400 baud"),
    ("ibus", "8E1"),
    ("crsf", "inversion wrong"),
]
CASES = [
    (mistake, seed)
    for seed, (protocol, label) in enumerate(TESTED)
    for mistake in misreadings.mistakes(protocol)
    if mistake.label == label
]


@pytest.mark.parametrize(("mistake", "seed"), CASES, ids=[f"{one.protocol}, {one.label}" for one, _ in CASES])
def test_the_mistake_is_named(mistake: Mistake, seed: int):
    assert misreadings.outcome(mistake, seed) == "right", recognise(misreadings.data_of(mistake, seed)).text


def test_all_cases_are_there():
    assert len(CASES) == len(TESTED)


def test_how_late_the_port_sees_an_edge_and_a_clock_a_little_off_change_no_name():
    for late_bits, baud in ((1 / 16, 115_200), (0.0, 115_500)):
        data = misreadings.misread("sbus", 3, Settings(baud), late_bits=late_bits)
        assert (
            "SBUS (100000 8E2 inverted) through a port that does not invert and at 115200 baud" in recognise(data).text
        )


def test_the_search_counts_every_frame_that_gives_the_bytes():
    """A right port leaves one way for each frame; nothing is unknown but what the shape leaves free."""
    for shape in SHAPES:
        reader = shape.settings._replace(stop_bits=1)
        frame = misreadings.frames(shape.protocol, 5)[7]
        best = frames_at(frame, 0, shape, reader, Budget(10**6))[0]
        known_bits = sum(mask.bit_count() for mask, _ in shape.known)
        assert (best.end, best.ways, best.gain) == (len(frame), 1, pytest.approx(known_bits)), shape.protocol


# --- what must not be claimed ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_random_bytes_are_no_protocol(seed):
    verdict = recognise(random.Random(seed).randbytes(4096))
    assert (verdict.protocol, verdict.text.startswith(CANNOT_TELL)) == (None, True)
    assert "4096 bytes, 256 different ones" in verdict.text


@pytest.mark.parametrize("baud", [100_000, 230_400, 420_000])
def test_a_misread_protocol_that_we_do_not_know_is_called_none_of_ours(baud):
    """Twelve words of SUMD on a 115200 8N1 line: of the line something may be said, of what is on it nothing."""
    rng = random.Random(baud)
    bursts = []
    for k in range(40):
        words = [0x2EE0 + rng.randint(-3000, 3000) if number < 4 else 0x2EE0 for number in range(12)]
        body = b"\xa8\x01\x0c" + b"".join(word.to_bytes(2, "big") for word in words)
        bursts.append((10_000 * k, body + binascii.crc_hqx(body, 0).to_bytes(2, "big")))
    data = bytes(one.byte for one in read(write(bursts, Settings(115_200)), Settings(baud)))
    verdict = recognise(data)
    assert verdict.protocol is None
    assert verdict.text.startswith((CANNOT_TELL, "looks like a line at 115200 8N1, "))


def test_what_is_seen_is_said_where_nothing_fits():
    block = random.Random(4).randbytes(37)
    times_us = [11_000 * (k // 37) + 87 * (k % 37) for k in range(40 * 37)]
    verdict = recognise(40 * block, times_us)
    assert verdict.protocol is None
    assert verdict.text.startswith(CANNOT_TELL)
    assert "repeating every 37, a burst every 11.0 ms" in verdict.text


@settings(max_examples=10)
@given(st.one_of(st.binary(max_size=120), st.lists(st.sampled_from([0x0F, 0xAA, 0, 0xFF, 0xC8]), max_size=120)))
def test_any_bytes_get_a_verdict_and_always_the_same(data):
    data = bytes(data)
    verdict = recognise(data)
    assert verdict == recognise(data, None)
    assert verdict.text
    assert verdict.protocol in (*rc_decode.PROTOCOLS, "slamware", CAN, None)


def test_only_the_beginning_of_a_long_file_is_judged():
    data = (KNOWN_RC / "uart12-clean-1.bin").read_bytes() * 20
    assert recognise(data[:JUDGED_BYTES] + random.Random(1).randbytes(2**20)) == recognise(data[:JUDGED_BYTES])
