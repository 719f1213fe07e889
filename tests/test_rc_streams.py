"""Every stream whose frames are known: all of them come out, and no other, however the bytes arrive."""

import json

import pytest
import streams
from streams import KNOWN_RC, read_stream

from bench import rc_decode
from bench.messages import RcFrame, RcNoise

OURS = {name: name for name in rc_decode.PROTOCOLS} | {"sbus2": "sbus"}

CONSTRUCTED = sorted(path.stem for path in KNOWN_RC.glob("*.bin") if not path.stem.startswith("vectors"))
RECORDED_WITH_TIMES = ["sbus2-futaba-r7008sb-1"]
RECORDED = ["crsf-tbs-1", *RECORDED_WITH_TIMES]  # of the first, only the sizes of its reads are known
FOREIGN = ["foreign-dsmx-1", "foreign-ghst-1", "foreign-sumd-1"]


def requested(request):
    if request.param in RECORDED:
        return read_stream(request.getfixturevalue("captures") / "rc" / request.param)
    return read_stream(KNOWN_RC / request.param)


@pytest.fixture(params=CONSTRUCTED + RECORDED)
def stream(request):
    return requested(request)


@pytest.fixture(params=CONSTRUCTED + RECORDED_WITH_TIMES)
def timed_stream(request):
    return requested(request)


def make(stream, **options):
    return rc_decode.decoder(OURS[stream.protocol], **options)


def check_truth(stream, events):
    assert streams.frames_of(events, len(stream.frames[0][1]) if stream.frames else None) == stream.frames
    assert streams.statistics_of(events) == stream.statistics


def test_the_fixtures_are_all_there():
    assert len(CONSTRUCTED) >= 11


def test_without_times_every_listed_frame_is_seen_and_no_other(stream):
    events = streams.check_stream(lambda: make(stream), stream.data)
    check_truth(stream, events)
    streams.check_partition(events, len(stream.data))


def test_with_a_time_for_each_byte_every_listed_frame_is_seen_and_no_other(timed_stream):
    stream = timed_stream
    data, times_us = stream.data, stream.times_us
    decoder = make(stream)
    events = decoder.feed(data, times_us) + decoder.finish()
    check_truth(stream, events)
    streams.check_partition(events, len(data))

    decoder, one_by_one = make(stream), []
    for i in range(len(data)):
        one_by_one += decoder.feed(data[i : i + 1], times_us[i])
    assert one_by_one + decoder.finish() == events

    decoder, by_chunk = make(stream), []
    for i in range(0, len(data), 7):
        by_chunk += decoder.feed(data[i : i + 7], times_us[i : i + 7])
    assert by_chunk + decoder.finish() == events


def test_in_ticks_of_a_millisecond_every_listed_frame_is_seen_and_no_other(timed_stream):
    """As the bench feeds it: nothing is left for the end, because silence speaks."""
    decoder = make(timed_stream, pause_us=2000)
    events = streams.feed_ticks(decoder, timed_stream.data, timed_stream.times_us)
    check_truth(timed_stream, events)
    streams.check_partition(events, len(timed_stream.data))
    assert not decoder.pending


def test_counters_are_the_sums_of_the_events(stream):
    decoder = make(stream)
    events = streams.feed_whole(decoder, stream.data)
    streams.check_counters(decoder.counters, events)
    assert decoder.counters.frames == len(stream.frames)
    assert decoder.counters.failsafe == sum(failsafe for *_, failsafe, _ in stream.frames)
    assert decoder.counters.frame_lost == sum(lost for *_, lost in stream.frames)
    assert decoder.counters.link_statistics == len(stream.statistics)


def test_read_sizes_of_a_real_driver_change_nothing(captures):
    stream = read_stream(captures / "rc" / "crsf-tbs-1")
    sizes = json.loads((captures / "rc" / "crsf-tbs-1.json").read_text())["timing"]["read_sizes"]
    check_truth(stream, streams.feed_pieces(make(stream), stream.data, iter(sizes)))


def test_sensors_that_answer_on_the_sbus2_line_cost_no_frame_and_are_no_noise(captures):
    stream = read_stream(captures / "rc" / "sbus2-futaba-r7008sb-1")
    events = streams.feed_whole(make(stream), stream.data)
    answers = streams.others_of(events)
    assert [(answer.offset, answer.length, answer.kind) for answer in answers[:2]] == [
        (215, 3, "slot 0"),
        (318, 3, "slot 0"),
    ]
    assert len(answers) == 12
    # The beginning in mid-frame; the frame that misses a byte, with the answer that follows it.
    assert [event for event in events if isinstance(event, RcNoise)] == [
        RcNoise(0, 13, "header"),
        RcNoise(88, 27, "footer"),
    ]


@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("protocol", rc_decode.PROTOCOLS)
def test_foreign_streams_give_no_frame(captures, name, protocol):
    foreign = read_stream(captures / "rc" / name)
    events = streams.check_stream(lambda: rc_decode.decoder(protocol), foreign.data)
    assert not [event for event in events if isinstance(event, RcFrame)]
    if foreign.times_us is not None:
        decoder = rc_decode.decoder(protocol)
        timed = decoder.feed(foreign.data, foreign.times_us) + decoder.finish()
        assert not [event for event in timed if isinstance(event, RcFrame)]


FOREIGN_TO_US = [
    pytest.param(protocol, name, id=f"{protocol}-{name}")
    for protocol in rc_decode.PROTOCOLS
    for name in CONSTRUCTED
    if not name.startswith(protocol)
]


@pytest.mark.parametrize(("protocol", "name"), FOREIGN_TO_US)
def test_no_protocol_finds_its_frames_in_the_streams_of_another(protocol, name):
    data = read_stream(KNOWN_RC / name).data
    assert not [event for event in streams.feed_whole(rc_decode.decoder(protocol), data) if isinstance(event, RcFrame)]
