"""What a change in an RC decoder would break and no other test sees: each of these has killed a mutant."""

import random

import pytest
import streams

from bench import rc_decode
from bench.messages import RcFrame, RcLinkStatistics, RcNoise, RcOther
from bench.rc import crsf, ibus, sbus


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


# --- SBUS --------------------------------------------------------------------------------------------------------


def test_the_flags_of_a_frame_that_lost_its_header_are_not_its_footer():
    first, last = sbus.encode((1000,) * 16), sbus.encode((1020,) * 16)
    headless = sbus.encode((1010,) * 16, digital=(True, True))[1:]
    events = streams.check_stream(lambda: rc_decode.decoder("sbus"), first + headless + last)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [0, 49]


@pytest.mark.parametrize("count", range(25))
def test_an_sbus2_frame_is_believed_where_the_stream_ends_in_its_answers(count):
    answers = bytes.fromhex("03c02e 83c02e 43c02e c3c02e 23c02e a3c02e 63c02e e3c02e")[:count]
    expected = [streams.sbus_frame(0, (1024,) * 16)]
    expected += [RcOther(25 + 3 * k, 3, f"slot {k}") for k in range(count // 3)]
    expected += [RcNoise(25 + count - count % 3, count % 3, "cut")] if count % 3 else []
    data = sbus.encode((1024,) * 16, footer=0x04) + answers
    streams.check_stream(lambda: rc_decode.decoder("sbus"), data, expected)


@pytest.mark.parametrize(("moved", "believed"), [(79, False), (80, True), (81, True)])
def test_of_two_places_that_overlap_the_later_must_be_eight_times_as_near(moved, believed):
    """The earlier one moves a channel by `moved`, the later one by 10; the flags of the one are the other's header."""
    before, after = sbus.encode((1024,) * 16), sbus.encode((1024, 1034, *[1024] * 14))
    earlier = sbus.encode((1024, 1024, 1024 + moved, *[1024] * 13))[:23]
    events = streams.check_stream(lambda: rc_decode.decoder("sbus"), before + earlier + after)
    found = [event.offset for event in events if isinstance(event, RcFrame)]
    assert found == ([0, 48] if believed else [0])


def test_upper_flags_of_sbus_are_four_bits():
    assert sbus.encode((0,) * 16, upper_flags=0xF)[23] == 0xF0
    assert sbus.encode((0,) * 16, upper_flags=0)[23] == 0
    with pytest.raises(ValueError, match="upper_flags is -0x1"):
        sbus.encode((0,) * 16, upper_flags=-1)


# --- what all share ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [15, 17])
@pytest.mark.parametrize("protocol", ["sbus", "crsf"])
def test_sixteen_channels_are_neither_fifteen_nor_seventeen(protocol, count):
    with pytest.raises(ValueError, match=f"{protocol}: {count} channels; expected 16"):
        rc_decode.encode(protocol, (0,) * count)


def test_a_pause_may_be_shorter_than_a_microsecond():
    assert rc_decode.decoder("crsf", pause_us=0.001).pause_us == 0.001


def test_a_single_byte_of_noise_is_pending():
    decoder = rc_decode.decoder("uart12")
    assert decoder.feed(b"\x01") == []
    assert decoder.pending
    assert decoder.finish() == [RcNoise(0, 1, "header")]


# --- CRSF --------------------------------------------------------------------------------------------------------


def test_crsf_channels_with_a_wrong_checksum_are_refused_for_it():
    data = bytearray(crsf.encode((992,) * 16))
    data[10] ^= 1
    assert streams.feed_whole(rc_decode.decoder("crsf"), bytes(data))[0].reason == "checksum"


def test_the_longest_crsf_frame_has_64_bytes():
    data = crsf.encode_frame(0x21, bytes([0x55] * 60))
    assert (len(data), data[1]) == (64, 62)
    assert streams.feed_whole(rc_decode.decoder("crsf"), data) == [RcOther(0, 64, "flight mode")]
    longer = b"\xc8\x3f\x21" + bytes([0x55] * 61)
    longer += bytes((crsf.crc8(longer[2:]),))
    assert streams.feed_whole(rc_decode.decoder("crsf"), longer) == [RcNoise(0, 65, "length")]


def crsf_frame_that_swallows(beginning, length, following):
    """A frame of that many bytes, of which those that `following` begins with are the last, checksum and all."""
    rng = random.Random("swallows")
    for _ in range(100_000):
        free = bytes(rng.randrange(1, 0x80) for _ in range(length - len(beginning) - len(following)))
        if crsf.crc8((beginning + free + following)[2:]) == 0:
            return beginning + free
    raise AssertionError("one in 256 would do")


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_crsf_frame_of_any_type_that_swallowed_the_beginning_of_channels_is_refused(count):
    following = crsf.encode((992,) * 16)
    damaged = crsf_frame_that_swallows(b"\xc8\x0c\x14", 14, following[:count])
    expected = [RcNoise(0, 14 - count, "cut"), RcFrame(14 - count, 26, (992,) * 16)]
    streams.check_stream(lambda: rc_decode.decoder("crsf"), damaged + following, expected)


def test_crsf_channels_right_behind_another_frame_leave_it_alone():
    data = crsf.encode_link_statistics(99, -60, 10) + crsf.encode((992,) * 16)
    expected = [RcLinkStatistics(0, 14, 99, -60, 10), RcFrame(14, 26, (992,) * 16)]
    streams.check_stream(lambda: rc_decode.decoder("crsf"), data, expected)


def test_a_crsf_frame_that_swallowed_another_than_channels_stands():
    """Channels come first, but no other type does: of these two the earlier one."""
    following = crsf.encode_frame(0x21, bytes(22))
    damaged = crsf_frame_that_swallows(b"\xc8\x0c\x14", 14, following[:1])
    events = streams.check_stream(lambda: rc_decode.decoder("crsf"), damaged + following)
    assert [(event.offset, event.length) for event in events] == [(0, 14), (14, 25)]


@pytest.mark.parametrize("beginning", ["c8 18 16", "c8 18 16 18 16", "c8 18 16 c8 18"])
def test_crsf_channels_that_swallowed_nearly_all_of_the_next_frame_are_refused(beginning):
    beginning = bytes.fromhex(beginning)
    lost = 26 - len(beginning)
    following = next(
        data for raw in range(2048) if crsf.crc8(beginning[2:] + (data := crsf.encode((raw, *[992] * 15)))[:lost]) == 0
    )
    events = streams.check_stream(lambda: rc_decode.decoder("crsf"), beginning + following)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [len(beginning)]


def test_crsf_channels_that_hold_those_of_another_address_stand():
    """Whoever loses a byte swallows a frame of its own: its own address."""
    following = crsf.encode((992,) * 16, address=0xEE)
    damaged = crsf_frame_that_swallows(b"\xc8\x18\x16", 26, following[:8])
    events = streams.check_stream(lambda: rc_decode.decoder("crsf"), damaged + following)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [0]


def test_crsf_channels_whose_checksum_looks_like_a_length_stand_where_the_next_frame_lost_its_head():
    good = crsf_frame_that_swallows(b"\xc8\x18\x16", 26, b"\x18") + b"\x18"
    assert good[-2] != 0xC8
    following = crsf.encode((992,) * 16)[2:]
    events = streams.check_stream(lambda: rc_decode.decoder("crsf"), good + following)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [0]


def test_crsf_link_statistics_are_written_as_their_table_has_them():
    # RSSI of both antennas, quality, SNR, antenna, mode, power; RSSI, quality and SNR of the downlink.
    data = crsf.encode_link_statistics(99, -60, -10)
    assert data[:-1] == bytes.fromhex("c8 0c 14  3c 3c 63 f6  00 02 03  3c 63 f6")


@pytest.mark.parametrize(
    ("name", "low", "high"), [("quality_percent", 0, 100), ("rssi_dbm", -255, 0), ("snr_db", -128, 127)]
)
def test_crsf_link_statistics_take_all_between_their_limits(name, low, high):
    some = {"quality_percent": 99, "rssi_dbm": -60, "snr_db": 10}
    for edge in (low, high):
        (event,) = streams.feed_whole(rc_decode.decoder("crsf"), crsf.encode_link_statistics(**{**some, name: edge}))
        assert (
            getattr(
                event,
                {"quality_percent": "uplink_quality_percent", "rssi_dbm": "uplink_rssi_dbm", "snr_db": "uplink_snr_db"}[
                    name
                ],
            )
            == edge
        )
    for beyond in (low - 1, high + 1):
        with pytest.raises(ValueError, match=f"crsf: {name} is {beyond}; expected {low} to {high}"):
            crsf.encode_link_statistics(**{**some, name: beyond})


def test_a_crsf_type_is_a_byte():
    for kind in (0, 255):
        assert crsf.encode_frame(kind, b"")[2] == kind
    for kind in (-1, 256):
        with pytest.raises(ValueError, match=f"type is {kind}; expected 0 to 255"):
            crsf.encode_frame(kind, b"")


# --- i-BUS -------------------------------------------------------------------------------------------------------


def test_an_ibus_frame_is_marked_only_where_it_is_asked_for():
    assert ibus.encode((1500,) * 14) == ibus.encode((1500,) * 14, failsafe=False) != ibus.encode((1500,) * 14, True)
    assert ibus.encode((1500,) * 14)[2:4] == bytes.fromhex("dc05")


# --- DBUS --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("frame", "sticks"),
    [
        # A byte further on stand 1492, 897, 635, 941: 1067 counts from the middle, and these are 1066 from it.
        ("05 d4 0d dc 9e 5a 77 00 00 00 00 00 00 00 00 00 00 00", (1029, 442, 880, 1359)),
        # 1100, 506, 1146, 1276: both are 968 counts from the middle, and the earlier place is believed.
        ("01 4c d4 8f 1e f9 b9 00 00 00 00 00 00 00 00 00 00 00", (1025, 649, 575, 1167)),
    ],
)
def test_the_first_dbus_frame_is_that_whose_sticks_are_nearer_to_1024(frame, sticks):
    data = b"\x00" + bytes.fromhex(frame) * 4
    (noise, *frames) = streams.check_stream(lambda: rc_decode.decoder("dbus"), data)
    assert (noise.offset, noise.length) == (0, 1)
    assert [(event.offset, event.channels[:4]) for event in frames] == [(1 + 18 * k, sticks) for k in range(4)]


@pytest.mark.parametrize(
    ("protocol", "limits"),
    [
        ("uart12", ((0, 4095),) * 4 + ((0, 255),) * 2),
        ("sbus", ((0, 2047),) * 16),
        ("crsf", ((0, 2047),) * 16),
        ("ibus", ((0, 4095),) * 14),
        # Sticks, switches, mouse, its buttons, keys; the wheel is eleven bits, as docs/rc/dbus.md has it.
        ("dbus", (*((364, 1684),) * 4, *((1, 3),) * 2, *((-32768, 32767),) * 3, *((0, 1),) * 2, (0, 65535), (0, 2047))),
    ],
)
def test_channels_have_the_limits_of_their_documents(protocol, limits):
    assert rc_decode.channel_limits(protocol) == limits
