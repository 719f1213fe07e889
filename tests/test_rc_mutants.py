"""What a change in an RC decoder would break and no other test sees: each of these has killed a mutant."""

import pytest
import streams

from bench import rc_decode
from bench.messages import RcFrame, RcNoise, RcOther
from bench.rc import crsf, sbus


def test_an_sbus_frame_is_believed_before_one_that_lost_its_header_however_reads_cut_it():
    first, headless, last = (sbus.encode((raw,) * 16) for raw in (1000, 1010, 1020))
    expected = [
        streams.sbus_frame(0, (1000,) * 16),
        RcNoise(25, 24, "header"),
        streams.sbus_frame(49, (1020,) * 16),
    ]
    streams.check_stream(lambda: rc_decode.decoder("sbus"), first + headless[1:] + last, expected)


# Types and their shortest length byte: the payload's fixed part, type and checksum; the extended header has two more.
CRSF_TYPES = [
    (0x02, "gps", 17),
    (0x07, "vario", 4),
    (0x08, "battery", 10),
    (0x17, "subset of channels", 3),
    (0x1C, "link statistics, receiver", 7),
    (0x1D, "link statistics, transmitter", 8),
    (0x1E, "attitude", 8),
    (0x21, "flight mode", 2),
    (0x28, "device ping", 4),
    (0x29, "device info", 4),
    (0x2B, "parameter entry", 4),
    (0x2C, "parameter read", 4),
    (0x2D, "parameter write", 4),
    (0x32, "command", 4),
    (0x7A, "MSP request", 4),
    (0x7B, "MSP answer", 4),
    (0x7C, "MSP write", 4),
]


@pytest.mark.parametrize(("kind", "name", "shortest"), CRSF_TYPES)
def test_a_crsf_type_has_its_name_and_a_shortest_length(kind, name, shortest):
    data = crsf.encode_frame(kind, bytes([0x55] * (shortest - 2)), address=0xEA)
    assert data[1] == shortest
    decoder = rc_decode.decoder("crsf")
    assert streams.feed_whole(decoder, data) == [RcOther(0, shortest + 2, name)]
    assert (decoder.counters.others, decoder.counters.frames, decoder.counters.link_statistics) == (1, 0, 0)
    if shortest > 2:
        (refused,) = streams.feed_whole(
            rc_decode.decoder("crsf"), crsf.encode_frame(kind, bytes([0x55] * (shortest - 3)), address=0xEA)
        )
        assert (refused.offset, refused.length, refused.reason) == (0, shortest + 1, "length")


@pytest.mark.parametrize("data", [b"\xc8", b"\xc8\x18", b"\xc8\x18\x16", b"\xc8\x0c\x14"])
def test_the_beginning_of_a_crsf_frame_is_cut_at_the_end(data):
    assert streams.feed_whole(rc_decode.decoder("crsf"), data) == [RcNoise(0, len(data), "cut")]


def test_crsf_link_statistics_are_counted_once():
    decoder = rc_decode.decoder("crsf")
    streams.feed_whole(decoder, crsf.encode_link_statistics(99, -40, 7) * 3)
    assert (decoder.counters.link_statistics, decoder.counters.others) == (3, 0)


@pytest.mark.parametrize("aux", [(2, 0), (0, 2), (2, 1)])
def test_a_uart12_button_beyond_one_waits_for_what_follows(aux):
    data = rc_decode.encode("uart12", (1, 2, 3, 4, *aux))
    decoder = rc_decode.decoder("uart12")
    assert decoder.feed(data) == []
    assert decoder.feed(b"\xaa") == [RcFrame(0, 12, (1, 2, 3, 4, *aux))]


@pytest.mark.parametrize("place", [1, 3, 5, 7])
def test_a_uart12_stick_of_4096_is_out_of_range(place):
    data = bytearray(rc_decode.encode("uart12", (0, 0, 0, 0, 0, 0)))
    data[place] = 0x10
    assert streams.feed_whole(rc_decode.decoder("uart12"), bytes(data)) == [RcNoise(0, 12, "range")]
