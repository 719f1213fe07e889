"""The corners of each protocol: what may follow an SBUS frame, and where eight bits of checksum are not enough."""

import random

import pytest
import streams

from bench import rc_decode
from bench.messages import RcFrame, RcLinkStatistics, RcNoise, RcOther
from bench.rc import crsf, ibus, sbus


def decode(protocol, data):
    decoder = rc_decode.decoder(protocol)
    events = streams.feed_whole(decoder, data)
    streams.check_counters(decoder.counters, events)
    return events


def sbus2(footer, raw=1024):
    return sbus.encode((raw,) * 16, footer=footer)


@pytest.mark.parametrize("count", range(1, 9))
@pytest.mark.parametrize("footer", [0x04, 0x14, 0x24, 0x34])
def test_up_to_eight_sensors_answer_between_two_sbus2_frames(footer, count):
    slots = bytes.fromhex("03 83 43 c3 23 a3 63 e3")[:count]
    answers = b"".join(bytes((slot, 0x0F, 0x2E)) for slot in slots)
    data = sbus2(footer) + answers + sbus2(footer)
    expected = [
        streams.sbus_frame(0, (1024,) * 16),
        *[RcOther(25 + 3 * k, 3, f"slot {k}") for k in range(count)],
        streams.sbus_frame(25 + 3 * count, (1024,) * 16),
    ]
    streams.check_stream(lambda: rc_decode.decoder("sbus"), data, expected)


def test_a_sensor_may_answer_long_after_the_frame():
    decoder = rc_decode.decoder("sbus")
    events = decoder.feed(sbus2(0x04), 3000)
    events += decoder.feed(bytes.fromhex("03c02e"), 3000 + 2150 + 360)
    events += decoder.feed(sbus2(0x14), 18000)
    assert events + decoder.finish() == [
        streams.sbus_frame(0, (1024,) * 16),
        RcOther(25, 3, "slot 0"),
        streams.sbus_frame(28, (1024,) * 16),
    ]


def test_an_answer_that_lost_a_byte_does_not_take_the_next_frame_along():
    decoder = rc_decode.decoder("sbus")
    events = decoder.feed(sbus2(0x04), 3000)
    events += decoder.feed(bytes.fromhex("03c0") + sbus2(0x14), 18000) + decoder.finish()
    assert events == [streams.sbus_frame(0, (1024,) * 16), RcNoise(25, 2, "cut"), streams.sbus_frame(27, (1024,) * 16)]


def test_no_more_than_eight_sensors_answer():
    decoder = rc_decode.decoder("sbus")
    decoder.feed(sbus2(0x04), 3000)
    events = decoder.feed(bytes.fromhex("03c02e") * 9, 10_000) + decoder.finish()
    assert len(streams.others_of(events)) == 8
    assert events[-1] == RcNoise(25 + 24, 3, "header")


def test_slot_bytes_behind_a_plain_sbus_frame_are_no_answer():
    data = sbus.encode((1024,) * 16) + bytes.fromhex("03c02e") + sbus.encode((1024,) * 16)
    assert decode("sbus", data) == [RcNoise(0, 28, "successor"), streams.sbus_frame(28, (1024,) * 16)]


def test_an_sbus_frame_is_believed_when_only_the_header_behind_it_is_missing():
    one, two, three = (sbus.encode((raw,) * 16) for raw in (1000, 1001, 1002))
    found = [event for event in decode("sbus", one + two[1:] + three) if isinstance(event, RcFrame)]
    assert [frame.channels[0] for frame in found] == [1000, 1002]


def test_a_shifted_sbus_frame_that_ends_well_is_not_believed_when_the_sticks_would_have_jumped():
    """Channel 0 begins with 0x0F; a byte too many makes the place behind the header look like a frame as well."""
    still = (0x50F, *[992] * 15)
    frame = sbus.encode(still)
    broken = frame[:20] + b"\x33" + frame[20:]
    events = decode("sbus", frame + broken + frame + frame)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [0, 51, 76]
    assert [event.reason for event in events if isinstance(event, RcNoise)] == ["successor"]


def test_an_sbus_frame_behind_a_doubled_header_is_believed():
    frame = sbus.encode((1000,) * 16)
    events = decode("sbus", frame + b"\x0f" + frame + frame)
    assert [event.offset for event in events if isinstance(event, RcFrame)] == [0, 26, 51]


def crsf_frame_that_lost(count, what_follows):
    """A damaged frame whose checksum comes out right with the bytes that follow it."""
    rng = random.Random("swallowed")
    for _ in range(100_000):
        damaged = bytearray(crsf.encode([rng.randrange(2048) for _ in range(16)]))
        at = rng.randrange(3, 24)
        del damaged[at : at + count]
        if crsf.crc8(bytes(damaged[2:]) + what_follows) == 0:
            return bytes(damaged)
    raise AssertionError("one in 256 would do")


@pytest.mark.parametrize(("count", "swallowed"), [(2, "c8 18"), (3, "c8 18 16"), (4, "c8 18 16 e0")])
def test_a_crsf_frame_that_swallowed_more_than_the_address_is_refused_as_well(count, swallowed):
    damaged = crsf_frame_that_lost(count, bytes.fromhex(swallowed))
    data = damaged + crsf.encode((992,) * 16)
    size = 26 - count
    expected = [RcNoise(0, size, "cut"), RcFrame(size, 26, (992,) * 16)]
    streams.check_stream(lambda: rc_decode.decoder("crsf"), data, expected)


def crsf_frame_whose_checksum_is_its_address():
    return next(data for raw in range(2048) if (data := crsf.encode((raw, *[992] * 15)))[-1] == 0xC8)


def test_a_crsf_frame_that_swallowed_the_next_address_is_refused_and_the_next_one_is_not_lost():
    """The checksum of 25 bytes and the next frame's 0xC8 is right once in 256 times."""
    damaged = crsf_frame_that_lost(1, b"\xc8")
    following = crsf.encode((992,) * 16)
    data = bytes(damaged) + following + following
    expected = [RcNoise(0, 25, "cut"), RcFrame(25, 26, (992,) * 16), RcFrame(51, 26, (992,) * 16)]
    streams.check_stream(lambda: rc_decode.decoder("crsf"), data, expected)
    statistics = crsf.encode_link_statistics(99, -60, 10)
    assert decode("crsf", bytes(damaged) + statistics)[1] == RcLinkStatistics(25, 14, 99, -60, 10)


def test_a_crsf_frame_whose_checksum_is_its_address_waits_for_one_more_byte_or_for_silence():
    data = crsf_frame_whose_checksum_is_its_address()
    decoder = rc_decode.decoder("crsf")
    assert decoder.feed(data) == []
    (frame,) = decoder.feed(b"\xc8")
    assert (frame.offset, frame.length) == (0, 26)

    decoder = rc_decode.decoder("crsf")
    assert decoder.feed(data, 1000) == []
    assert len(decoder.feed(b"", 1120)) == 1


def test_channels_come_first_where_another_crsf_frame_claims_their_bytes():
    channels = crsf.encode((992,) * 16)
    swallowing = bytes((0xC8, 40, 0x21)) + channels + bytes(11)
    data = swallowing + bytes((crsf.crc8(swallowing[2:]),))
    decoder = rc_decode.decoder("crsf")
    # Delivered with its last byte, although the other frame is not complete yet.
    assert decoder.feed(data[:29]) == [RcNoise(0, 3, "cut"), RcFrame(3, 26, (992,) * 16)]
    streams.check_stream(lambda: rc_decode.decoder("crsf"), data)


@pytest.mark.parametrize("address", [0xC8, 0xEE, 0xEA, 0xEC, 0x00])
def test_crsf_takes_every_address_of_the_reference(address):
    assert decode("crsf", crsf.encode((992,) * 16, address=address)) == [RcFrame(0, 26, (992,) * 16)]


def test_valid_crsf_frames_of_other_types_are_neither_channels_nor_noise():
    data = crsf.encode_frame(0x08, bytes(8)) + crsf.encode_frame(0x99, b"\x01\x02")
    assert decode("crsf", data) == [RcOther(0, 12, "battery"), RcOther(12, 6, "type 0x99")]


def test_a_known_crsf_type_that_is_too_short_is_no_frame_and_a_longer_one_is():
    assert decode("crsf", crsf.encode_frame(0x14, bytes(9)))[0].reason == "length"
    assert decode("crsf", crsf.encode_frame(0x14, bytes(9)))[0].offset == 0
    (statistics,) = decode("crsf", crsf.encode_frame(0x14, b"\x32\x00\x63\x05" + bytes(8)))
    assert statistics == RcLinkStatistics(0, 16, 99, -50, 5)


def test_ibus_failsafe_marks_every_channel_it_is_encoded_with():
    data = rc_decode.encode("ibus", (1500,) * 14, failsafe=True)
    assert data[2:4] == bytes.fromhex("dcc5")
    decoder = rc_decode.decoder("ibus")
    assert decoder.feed(data) == [RcFrame(0, 32, (1500,) * 14, True)]
    assert decoder.counters.failsafe == 1


def test_a_uart12_frame_may_begin_in_a_refused_one():
    """Both have odd buttons; the first is not followed by a header, the second by the end."""
    data = bytes.fromhex("aa 00 aa 0000 0000 0000 0002 55 00 55")
    expected = [RcNoise(0, 2, "successor"), RcFrame(2, 12, (0, 0, 0, 2, 0x55, 0))]
    streams.check_stream(lambda: rc_decode.decoder("uart12"), data, expected)


@pytest.mark.parametrize("before", [1021, 1022, 1023])
def test_a_run_of_noise_may_be_cut_inside_a_refused_uart12_frame(before):
    data = b"\x01" * before + rc_decode.encode("uart12", (0, 0, 0, 0, 0, 2)) + b"\x01"
    assert [(event.offset, event.length) for event in decode("uart12", data)] == [(0, 1024), (1024, before - 1011)]


def ibus_frame(words):
    body = b"\x20\x40" + b"".join(word.to_bytes(2, "little") for word in words)
    return body + (0xFFFF - sum(body)).to_bytes(2, "little")


def test_sensor_polls_between_ibus_frames_are_neither_channels_nor_noise():
    frame = rc_decode.encode("ibus", (1500,) * 14)
    data = frame + bytes.fromhex("04 81 7a ff  04 91 6a ff") + frame
    polls = [RcOther(32, 4, "poll 0x81"), RcOther(36, 4, "poll 0x91")]
    events = decode("ibus", data)
    assert events == [RcFrame(0, 32, (1500,) * 14), *polls, RcFrame(40, 32, (1500,) * 14)]
    streams.check_stream(lambda: rc_decode.decoder("ibus"), data, events)


def test_four_more_ibus_channels_are_built_of_three_nibbles_each_lowest_first():
    words = [1500] * 14
    for i, more in enumerate((0xABC, 0x123, 0xFED, 0x456)):
        for k in range(3):
            words[3 * i + k] |= (more >> 4 * k & 0xF) << 12
    (frame,) = ibus.IbusDecoder(eighteen=True).feed(ibus_frame(words))
    assert frame == RcFrame(0, 32, (*(1500,) * 14, 0xABC, 0x123, 0xFED, 0x456))


@pytest.mark.parametrize("word", [0x1000, 0x1001, 0x5FFF, 0xBFFF, 0xD000])
def test_an_ibus_channel_is_the_lower_12_bits_and_only_0xc_above_them_is_a_failsafe(word):
    (frame,) = decode("ibus", ibus_frame([word, *[1500] * 13]))
    assert frame == RcFrame(0, 32, (word & 0xFFF, *[1500] * 13))


# --- DBUS --------------------------------------------------------------------------------------------------------

AT_REST = (1024, 1024, 1024, 1024, 3, 1, 0, 0, 0, 0, 0, 0, 1024)
MOVED = (1100, 900, 1300, 1024, 3, 1, 0, 0, 0, 0, 0, 0, 1024)


def dbus(*values):
    return rc_decode.encode("dbus", values)


def test_a_dbus_burst_is_a_frame_if_it_is_18_plausible_bytes():
    frame = dbus(*MOVED)
    for burst, seen in ((frame, True), (frame[:17], False), (frame + b"\x00", False), (b"\x00" + frame[:17], False)):
        decoder = rc_decode.decoder("dbus")
        decoder.feed(dbus(*AT_REST), 0)
        events = decoder.feed(burst, 14_000) + decoder.feed(b"", 20_000)
        assert [event.channels for event in events if isinstance(event, RcFrame)] == [AT_REST, *[MOVED] * seen]


@pytest.mark.parametrize("switches", [0x0000, 0x1000, 0x4000])
def test_a_dbus_frame_needs_both_switches(switches):
    frame = bytearray(dbus(*AT_REST))
    frame[5] = frame[5] & 0x0F | switches >> 8
    assert decode("dbus", bytes(frame)) == [RcNoise(0, 18, "range")]


def test_dbus_frames_that_come_in_one_piece_after_silence_are_believed_one_by_one():
    decoder = rc_decode.decoder("dbus")
    decoder.feed(dbus(*AT_REST), 0)
    events = decoder.feed(dbus(*MOVED) + dbus(*AT_REST), 28_000)
    assert events == [RcFrame(0, 18, AT_REST), RcFrame(18, 18, MOVED)]
    assert decoder.feed(b"", 40_000) == [RcFrame(36, 18, AT_REST)]


@pytest.mark.parametrize("start", range(1, 18))
def test_a_dbus_stream_that_starts_inside_a_frame_is_aligned_without_times(start):
    rows = [(1024 + k, 1000 - k, 1024, 1050, 3, 1, 0, 0, 0, 0, 0, 0, 1024) for k in range(6)]
    data = b"".join(dbus(*row) for row in rows)[start:]
    events = streams.check_stream(lambda: rc_decode.decoder("dbus"), data)
    assert [event.channels for event in events if isinstance(event, RcFrame)] == rows[1:]
