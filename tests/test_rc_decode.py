"""What holds for every RC codec: the interface, silence, bounded memory, and round trips through any cut."""

import random
import sys
from itertools import accumulate

import pytest
import streams
from hypothesis import given, settings
from hypothesis import strategies as st

from bench import config, rc_decode
from bench.messages import RcFrame, RcLinkStatistics, RcNoise
from bench.rc import crsf, sbus

# Header, footer and length bytes of the protocols, and what stands beside them: the richest junk.
SPICE = bytes.fromhex("aa55 0f000414243403 c8ee18160c14 20400481")

CHANNELS = {
    "uart12": st.tuples(*[st.integers(0, 4095)] * 4, *[st.integers(0, 255)] * 2),
    "sbus": st.tuples(*[st.integers(0, 2047)] * 16),
    "crsf": st.tuples(*[st.integers(0, 2047)] * 16),
    "ibus": st.tuples(*[st.integers(0, 4095)] * 14),
    "dbus": st.tuples(
        *[st.integers(364, 1684)] * 4,
        *[st.integers(1, 3)] * 2,
        *[st.integers(-32768, 32767)] * 3,
        *[st.integers(0, 1)] * 2,
        st.integers(0, 65535),
        st.integers(0, 2047),
    ),
}
SOME = {
    "uart12": (2048, 1, 2, 4095, 1, 1),
    "sbus": (992,) * 16,
    "crsf": (992,) * 16,
    "ibus": (1500,) * 14,
    "dbus": (1024, 1030, 400, 1684, 1, 3, 0, -5, 0, 0, 1, 0x8001, 1024),
}
JUNK = st.one_of(st.binary(max_size=40), st.lists(st.sampled_from(SPICE), max_size=40).map(bytes))


each_protocol = pytest.mark.parametrize("protocol", rc_decode.PROTOCOLS)


def frames(protocol):
    return CHANNELS[protocol].map(lambda channels: rc_decode.encode(protocol, channels))


@st.composite
def damaged(draw, protocol):
    """A frame with a byte lost, doubled or changed, or without its end."""
    frame = bytearray(draw(frames(protocol)))
    at = draw(st.integers(0, len(frame) - 1))
    how = draw(st.sampled_from(("lost", "doubled", "changed", "cut")))
    if how == "lost":
        del frame[at]
    elif how == "doubled":
        frame.insert(at, frame[at])
    elif how == "changed":
        frame[at] = draw(st.integers(0, 255))
    else:
        del frame[at:]
    return bytes(frame)


def any_stream(protocol):
    return st.lists(st.one_of(frames(protocol), frames(protocol), damaged(protocol), JUNK), max_size=12).map(b"".join)


def decode(protocol, data):
    return streams.feed_whole(rc_decode.decoder(protocol), data)


# --- the face ----------------------------------------------------------------------------------------------------


def test_the_protocols_are_those_that_profiles_may_name():
    assert set(config.PROTOCOLS) <= set(rc_decode.PROTOCOLS)
    assert rc_decode.PROTOCOLS == ("uart12", "sbus", "crsf", "ibus", "dbus")


def test_an_unknown_protocol_is_refused_with_the_known_names():
    with pytest.raises(ValueError, match=r"no RC protocol is called 'ppm'; known: uart12, sbus, crsf, ibus, dbus"):
        rc_decode.decoder("ppm")
    with pytest.raises(ValueError, match=r"no RC protocol is called 'ppm'"):
        rc_decode.encode("ppm", (0,) * 16)


@pytest.mark.parametrize("pause_us", [0, -1, float("nan")])
def test_a_pause_that_cannot_be_is_refused(pause_us):
    with pytest.raises(ValueError, match="pause_us"):
        rc_decode.decoder("sbus", pause_us=pause_us)


@pytest.mark.parametrize(
    ("protocol", "bits", "baud"),
    [
        ("uart12", 12, 115_200),
        ("sbus", 12, 100_000),
        ("crsf", 10, 420_000),
        ("ibus", 10, 115_200),
        ("dbus", 11, 100_000),
    ],
)
def test_the_pause_is_five_byte_times_unless_given(protocol, bits, baud):
    """Start bit, eight data bits, a parity bit or none, one or two stop bits."""
    decoder = rc_decode.decoder(protocol)
    assert decoder.byte_us == pytest.approx(bits * 1_000_000 / baud, rel=1e-12)
    assert decoder.pause_us == pytest.approx(5 * bits * 1_000_000 / baud, rel=1e-12)
    assert rc_decode.decoder(protocol, pause_us=2000).pause_us == 2000


@pytest.mark.parametrize(
    ("protocol", "channels", "text"),
    [
        ("uart12", (0, 0, 0, 4096, 0, 0), "uart12: channel 3 is 4096; expected 0 to 4095"),
        ("uart12", (0, 0, 0, 0, 0, 256), "uart12: channel 5 is 256; expected 0 to 255"),
        ("uart12", (0, 0, 0, 0), "uart12: 4 channels; expected 6"),
        ("sbus", (2048, *[0] * 15), "sbus: channel 0 is 2048; expected 0 to 2047"),
        ("sbus", (0,) * 18, "sbus: 18 channels; expected 16"),
        ("crsf", (*[0] * 15, -1), "crsf: channel 15 is -1; expected 0 to 2047"),
        ("ibus", (4096, *[0] * 13), "ibus: channel 0 is 4096; expected 0 to 4095"),
        ("dbus", (363, *SOME["dbus"][1:]), "dbus: channel 0 is 363; expected 364 to 1684"),
        ("dbus", (*[1024] * 4, 0, *[1] * 8), "dbus: channel 4 is 0; expected 1 to 3"),
    ],
)
def test_encoders_refuse_what_no_frame_can_say(protocol, channels, text):
    with pytest.raises(ValueError, match=text):
        rc_decode.encode(protocol, channels)


@pytest.mark.parametrize("protocol", ["uart12", "crsf", "ibus", "dbus"])
def test_a_flag_that_the_protocol_cannot_carry_is_refused(protocol):
    if protocol != "ibus":
        with pytest.raises(ValueError, match=f"{protocol} frames cannot say failsafe"):
            rc_decode.encode(protocol, SOME[protocol], failsafe=True)
    with pytest.raises(ValueError, match=f"{protocol} frames cannot say frame_lost"):
        rc_decode.encode(protocol, SOME[protocol], frame_lost=True)
    with pytest.raises(ValueError, match=f"{protocol} frames cannot say digital"):
        rc_decode.encode(protocol, SOME[protocol], digital=(True, False))


@each_protocol
def test_channel_limits_are_those_that_the_encoder_takes(protocol):
    limits = rc_decode.channel_limits(protocol)
    assert len(limits) == len(SOME[protocol])
    for i, edge in ((i, edge) for i, (low, high) in enumerate(limits) for edge in (low, high)):
        rc_decode.encode(protocol, (*SOME[protocol][:i], edge, *SOME[protocol][i + 1 :]))
    for i, beyond in ((i, beyond) for i, (low, high) in enumerate(limits) for beyond in (low - 1, high + 1)):
        with pytest.raises(ValueError, match=f"channel {i} is {beyond}"):
            rc_decode.encode(protocol, (*SOME[protocol][:i], beyond, *SOME[protocol][i + 1 :]))


def test_sbus_options_out_of_range_are_refused():
    with pytest.raises(ValueError, match="upper_flags is 0x10"):
        sbus.encode((0,) * 16, upper_flags=0x10)
    with pytest.raises(ValueError, match="1 digital channels; expected 2"):
        sbus.encode((0,) * 16, digital=(True,))
    with pytest.raises(ValueError, match="footer is 0x3"):
        sbus.encode((0,) * 16, footer=0x03)


def test_crsf_options_out_of_range_are_refused():
    with pytest.raises(ValueError, match="address is 0x82"):
        crsf.encode((0,) * 16, address=0x82)
    with pytest.raises(ValueError, match="type is 256"):
        crsf.encode_frame(256, b"")
    with pytest.raises(ValueError, match="payload of 61 bytes; expected at most 60"):
        crsf.encode_frame(0x21, bytes(61))
    with pytest.raises(ValueError, match="quality_percent is 101"):
        crsf.encode_link_statistics(101, 0, 0)


def test_the_crsf_checksum_is_the_catalogued_one():
    """CRC-8/DVB-S2: polynomial 0xD5, check value 0xBC."""
    assert crsf.crc8(b"123456789") == 0xBC


# --- round trips and cuts ----------------------------------------------------------------------------------------


@each_protocol
@settings(max_examples=40)
@given(data=st.data())
def test_what_is_encoded_is_decoded(protocol, data):
    rows = data.draw(st.lists(CHANNELS[protocol], min_size=1, max_size=4))
    sent = [rc_decode.encode(protocol, row) for row in rows]
    size = len(sent[0])
    digital = (False, False) if protocol == "sbus" else ()
    expected = [RcFrame(k * size, size, row, digital=digital) for k, row in enumerate(rows)]
    assert streams.check_stream(lambda: rc_decode.decoder(protocol), b"".join(sent), expected)


@settings(max_examples=30)
@given(
    channels=CHANNELS["sbus"],
    failsafe=st.booleans(),
    frame_lost=st.booleans(),
    digital=st.tuples(st.booleans(), st.booleans()),
    upper=st.integers(0, 15),
)
@pytest.mark.parametrize("footer", [0x00, 0x04, 0x14, 0x24, 0x34])
def test_sbus_flags_go_round(channels, failsafe, frame_lost, digital, upper, footer):
    data = sbus.encode(channels, failsafe, frame_lost, digital, upper_flags=upper, footer=footer)
    assert decode("sbus", data) == [streams.sbus_frame(0, channels, failsafe, frame_lost, digital)]


@given(quality=st.integers(0, 100), rssi_dbm=st.integers(-255, 0), snr_db=st.integers(-128, 127))
def test_link_statistics_go_round(quality, rssi_dbm, snr_db):
    data = crsf.encode_link_statistics(quality, rssi_dbm, snr_db)
    assert decode("crsf", data) == [RcLinkStatistics(0, 14, quality, rssi_dbm, snr_db)]


@each_protocol
@settings(max_examples=40)
@given(data=st.data())
def test_any_bytes_however_cut_give_the_same_events_and_account_for_every_byte(protocol, data):
    stream = data.draw(any_stream(protocol))
    events = streams.check_stream(lambda: rc_decode.decoder(protocol), stream)
    streams.check_partition(events, len(stream))


@each_protocol
@settings(max_examples=40)
@given(data=st.data())
def test_any_times_however_cut_give_the_same_events(protocol, data):
    stream = data.draw(any_stream(protocol))
    rng = random.Random(data.draw(st.integers(0, 2**32)))
    times_us = list(accumulate(rng.choices((0, 20, 100, 5000), (9, 9, 9, 1), k=len(stream))))
    decoder = rc_decode.decoder(protocol)
    events = decoder.feed(stream, times_us) + decoder.finish()
    streams.check_partition(events, len(stream))

    decoder, one_by_one = rc_decode.decoder(protocol), []
    for i, at_us in enumerate(times_us):
        one_by_one += decoder.feed(stream[i : i + 1], at_us)
    assert one_by_one + decoder.finish() == events

    # Silence says the same, whether the next byte tells of it or an empty feed does.
    decoder, with_ticks = rc_decode.decoder(protocol), []
    for i, at_us in enumerate(times_us):
        with_ticks += decoder.feed(b"", at_us)
        with_ticks += decoder.feed(stream[i : i + 1], at_us)
    assert with_ticks + decoder.finish() == events


@each_protocol
def test_bytearrays_and_views_decode_like_bytes(protocol):
    data = b"\x11" + rc_decode.encode(protocol, SOME[protocol])
    expected = decode(protocol, data)
    source = bytearray(data)
    decoder = rc_decode.decoder(protocol)
    events = decoder.feed(memoryview(source)[:7])
    source[:7] = bytes(7)  # what was fed is ours, the caller may use its buffer again
    assert events + decoder.feed(bytearray(data[7:])) + decoder.finish() == expected


# --- silence -----------------------------------------------------------------------------------------------------


@each_protocol
def test_nothing_is_pending_at_the_beginning_and_after_the_end(protocol):
    decoder = rc_decode.decoder(protocol)
    assert not decoder.pending
    decoder.feed(b"\xaa\x0f\xc8")
    assert decoder.pending
    decoder.finish()
    assert not decoder.pending
    assert decoder.feed(b"") == decoder.finish() == []


@pytest.mark.parametrize("protocol", ["uart12", "crsf", "ibus"])
def test_a_frame_that_proves_itself_is_delivered_with_its_last_byte(protocol):
    data = rc_decode.encode(protocol, SOME[protocol])
    decoder = rc_decode.decoder(protocol)
    assert decoder.feed(data[:-1]) == []
    assert decoder.feed(data[-1:]) == [RcFrame(0, len(data), SOME[protocol])]
    assert not decoder.pending


def test_an_sbus_frame_waits_for_a_header_or_for_silence_longer_than_the_pause():
    data = rc_decode.encode("sbus", (992,) * 16)
    frame = streams.sbus_frame(0, (992,) * 16)

    decoder = rc_decode.decoder("sbus")
    assert decoder.feed(data) == []
    assert decoder.pending
    assert decoder.feed(b"\x0f") == [frame]

    decoder = rc_decode.decoder("sbus")
    assert decoder.feed(data, 10_000) == []
    assert decoder.feed(b"", 10_600) == []
    assert decoder.feed(b"", 10_601) == [frame]
    assert not decoder.pending


def test_a_uart12_frame_with_odd_button_values_waits_likewise():
    channels = (2048, 2048, 2048, 2048, 0, 0x55)
    data = rc_decode.encode("uart12", channels)
    decoder = rc_decode.decoder("uart12")
    assert decoder.feed(data) == []
    assert decoder.feed(data[:1]) == [RcFrame(0, 12, channels)]
    assert decode("uart12", data + b"\x01") == [RcNoise(0, 13, "successor")]


def test_the_bytes_of_a_piece_came_one_after_the_other_before_its_time():
    """64-byte reads of a line without gaps: the times of the reads must not look like silence."""
    data = b"".join(rc_decode.encode("sbus", (k,) * 16) for k in range(100))
    decoder, events = rc_decode.decoder("sbus"), []
    for i in range(0, len(data), 64):
        piece = data[i : i + 64]
        events += decoder.feed(piece, (i + len(piece)) * 120)
    assert [event.channels[0] for event in events + decoder.finish()] == list(range(100))


def test_a_pause_inside_a_frame_cuts_it():
    data = rc_decode.encode("sbus", (992,) * 16)
    decoder = rc_decode.decoder("sbus")
    assert decoder.feed(data[:10], 0) == []
    # The rest in one piece of 15 bytes, whose first came 14 byte times of 120 us before the last.
    assert decoder.feed(data[10:], 14 * 120 + 601) == [RcNoise(0, 10, "cut")]
    assert decoder.finish() == [RcNoise(10, 15, "cut")]


def test_without_a_time_a_pause_is_neither_seen_nor_invented():
    data = rc_decode.encode("sbus", (992,) * 16)
    decoder = rc_decode.decoder("sbus")
    decoder.feed(data[:10], 0)
    decoder.feed(data[10:20])
    assert decoder.feed(data[20:], 1e9) == []
    assert decoder.finish() == [streams.sbus_frame(0, (992,) * 16)]


def test_a_gap_as_long_as_the_pause_is_none_and_one_that_is_longer_is():
    data = rc_decode.encode("sbus", (992,) * 16) + b"\x01"
    for gap_us, reason in ((600, "successor"), (601, "header")):
        decoder = rc_decode.decoder("sbus")
        events = decoder.feed(data, [0] * 25 + [gap_us]) + decoder.finish()
        assert events[-1].reason == reason


def test_times_and_bytes_must_match_in_number():
    with pytest.raises(ValueError, match="2 times for 3 bytes"):
        rc_decode.decoder("sbus").feed(b"abc", [0.0, 1.0])


def test_times_that_run_backwards_are_no_pause():
    data = rc_decode.encode("sbus", (992,) * 16)
    decoder = rc_decode.decoder("sbus")
    assert decoder.feed(data, [1e6 - i for i in range(25)]) + decoder.finish() == [streams.sbus_frame(0, (992,) * 16)]


@each_protocol
def test_offsets_go_on_after_the_end_of_a_stream(protocol):
    data = rc_decode.encode(protocol, SOME[protocol])
    decoder = rc_decode.decoder(protocol)
    first = decoder.feed(data) + decoder.finish()
    second = decoder.feed(data) + decoder.finish()
    assert [event.offset for event in first + second] == [0, len(data)]


# --- noise -------------------------------------------------------------------------------------------------------


@each_protocol
@pytest.mark.parametrize("what", ["random", "spice", "headers"])
def test_megabytes_of_noise_are_reported_now_and_then_and_leave_nothing_behind(protocol, what):
    rng = random.Random(what)
    size = 1_000_000 if what == "random" and protocol != "dbus" else 100_000
    if what == "random":
        noise = rng.randbytes(size)
    elif what == "spice":
        noise = bytes(rng.choices(SPICE, k=size))
    else:
        noise = rng.choice(SPICE[:1] + b"\x0f\xc8").to_bytes(1, "big") * size
    decoder = rc_decode.decoder(protocol)
    unreported = longest = 0
    events = []
    for i in range(0, size, 500):
        new = decoder.feed(noise[i : i + 500])
        events += new
        unreported = 0 if new else unreported + 500
        longest = max(longest, unreported)
    assert longest <= 2000
    kept = sys.getsizeof(decoder._waiting) + sum(sys.getsizeof(value) for value in vars(decoder).values())
    assert kept < 2000
    events += decoder.finish()
    streams.check_partition(events, size)
    assert max(event.length for event in events) <= 1024
    streams.check_counters(decoder.counters, events)


def test_random_noise_gives_no_frame():
    noise = random.Random("noise").randbytes(1_000_000)
    for protocol in ("uart12", "crsf", "ibus"):
        assert not [event for event in decode(protocol, noise) if isinstance(event, RcFrame)], protocol
    # SBUS has 22 bits of evidence and no more: one place in four million looks like a frame.
    assert len([event for event in decode("sbus", noise) if isinstance(event, RcFrame)]) <= 2


@pytest.mark.parametrize(
    ("protocol", "data", "expected"),
    [
        ("uart12", "00 01 02", [RcNoise(0, 3, "header")]),
        ("uart12", "aa 0800 0800 0800 0800 00 00 54", [RcNoise(0, 12, "footer")]),
        ("uart12", "aa 0800 1800 0800 0800 00 00 55", [RcNoise(0, 12, "range")]),
        ("uart12", "aa 0800 0800", [RcNoise(0, 5, "cut")]),
        ("sbus", "0f" + "00" * 23 + "01", [RcNoise(0, 25, "footer")]),
        ("sbus", "0f" + "00" * 24 + "01", [RcNoise(0, 26, "successor")]),
        ("sbus", "0f" + "00" * 20, [RcNoise(0, 21, "cut")]),
        ("crsf", "c8 01 16", [RcNoise(0, 3, "length")]),
        ("crsf", "c8 3f 16", [RcNoise(0, 3, "length")]),
        ("crsf", "c8 17 16", [RcNoise(0, 3, "length")]),
        ("crsf", "c8 02 21 00", [RcNoise(0, 4, "checksum")]),
        ("crsf", "c8 18 16 e0", [RcNoise(0, 4, "cut")]),
        ("crsf", "82 18 16", [RcNoise(0, 3, "header")]),
        ("ibus", "20 41 00", [RcNoise(0, 3, "header")]),
        ("ibus", "20 40" + "dc05" * 14 + "0000", [RcNoise(0, 32, "checksum")]),
        ("ibus", "20 40 dc", [RcNoise(0, 3, "cut")]),
        ("dbus", "00" * 18, [RcNoise(0, 18, "range")]),
        ("dbus", "00" * 3, [RcNoise(0, 3, "cut")]),
    ],
)
def test_noise_tells_the_reason_of_its_first_refusal(protocol, data, expected):
    assert streams.check_stream(lambda: rc_decode.decoder(protocol), bytes.fromhex(data)) == expected


def test_a_run_of_noise_is_cut_by_its_own_length_and_each_piece_has_its_own_reason():
    data = b"\x01" * 1023 + b"\x0f" + b"\x01" * 24
    assert decode("sbus", data) == [RcNoise(0, 1024, "header"), RcNoise(1024, 24, "header")]
    assert decode("sbus", b"\x0f" + b"\x01" * 1500) == [RcNoise(0, 1024, "footer"), RcNoise(1024, 477, "header")]
    decoder = rc_decode.decoder("sbus")
    assert decoder.feed(b"\x01" * 1024) == [RcNoise(0, 1024, "header")]
    assert not decoder.pending
    data = b"\x01" * 1024 + b"\x0f" + b"\x01" * 24
    assert decode("sbus", data) == [RcNoise(0, 1024, "header"), RcNoise(1024, 25, "footer")]


def test_counters_tell_frames_flags_and_reasons_apart():
    good = (992,) * 16
    data = sbus.encode(good) + sbus.encode(good, frame_lost=True) + sbus.encode(good, True, True) + b"\x01\x02"
    decoder = rc_decode.decoder("sbus")
    decoder.feed(data, 0)
    decoder.feed(b"", 10_000)
    assert (decoder.counters.frames, decoder.counters.frame_lost, decoder.counters.failsafe) == (2, 1, 0)
    # The third frame had another byte behind it than a header: refused, and not counted as a failsafe.
    assert decoder.counters.noise_bytes == {"successor": 27}
    assert decoder.counters.noise_events == {"successor": 1}
