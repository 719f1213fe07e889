"""How much of a damaged stream comes through, without times. Twenty named seeds for each number."""

import random

import pytest
from streams import KNOWN_RC, feed_whole, lose_bytes, read_stream, walking_sticks

from bench import rc_decode
from bench.messages import RcFrame

SEEDS = [f"lost byte {k}" for k in range(20)]
COUNT, EVERY = 2000, 20


def eleven_bit_rows(kind, seed):
    if kind == "random":
        rng = random.Random(seed)
        return [[rng.randrange(2048) for _ in range(16)] for _ in range(COUNT)]
    middle = {"FrSky": 992, "Futaba": 1024}[kind]
    return [[*sticks, *[middle] * 12] for sticks in walking_sticks(seed, COUNT, middle, 2047)]


def dbus_sticks(seed):
    return [[max(364, raw) for raw in row] for row in walking_sticks(seed, COUNT, 1024, 1684)]


def uart12_rows(kind, seed):
    if kind == "random":
        rng = random.Random(seed)
        return [[*(rng.randrange(4096) for _ in range(4)), rng.randrange(2), rng.randrange(2)] for _ in range(COUNT)]
    return [[*sticks, 0, 0] for sticks in walking_sticks(seed, COUNT, 2048, 4095)]


def through(protocol, rows, seed):
    """(intact frames that came out, wrong ones) of a stream in which every 20th frame lost a byte."""
    frames = [rc_decode.encode(protocol, row) for row in rows]
    data, intact = lose_bytes(frames, EVERY, seed)
    assert len(intact) == 1900
    found = [event for event in feed_whole(rc_decode.decoder(protocol), data) if isinstance(event, RcFrame)]
    right = sum(f.offset in intact and f.channels == tuple(rows[intact[f.offset]]) for f in found)
    return right, len(found) - right


@pytest.mark.parametrize("kind", ["FrSky", "Futaba", "random"])
def test_sbus_without_times(kind):
    """The bar is 1,890 of 1,900 on average; the header of the next frame alone gives 1,892."""
    results = [through("sbus", eleven_bit_rows(kind, seed), seed) for seed in SEEDS]
    assert sum(right for right, _ in results) / len(SEEDS) >= 1899
    assert [wrong for _, wrong in results] == [0] * len(SEEDS)


@pytest.mark.parametrize("kind", ["FrSky", "random"])
def test_crsf_without_times(kind):
    results = [through("crsf", eleven_bit_rows(kind, seed), seed) for seed in SEEDS]
    assert results == [(1900, 0)] * len(SEEDS)


@pytest.mark.parametrize("kind", ["Futaba", "random"])
def test_ibus_without_times(kind):
    results = [through("ibus", [row[:14] for row in eleven_bit_rows(kind, seed)], seed) for seed in SEEDS[:5]]
    assert results == [(1900, 0)] * 5


def test_dbus_with_times():
    """Nothing in a DBUS frame tells that a byte is missing; silence does."""
    for seed in SEEDS[:5]:
        frames = [rc_decode.encode("dbus", (*row, 1, 3, 0, 0, 0, 0, 0, 0, 1024)) for row in dbus_sticks(seed)]
        data, intact = lose_bytes(frames, EVERY, seed)
        decoder, found, at = rc_decode.decoder("dbus"), [], 0
        for k, frame in enumerate(frames):
            size = len(frame) - (k % EVERY == EVERY - 1)
            found += decoder.feed(data[at : at + size], k * 14_000)
            at += size
        found = [event for event in found + decoder.finish() if isinstance(event, RcFrame)]
        assert [frame.offset for frame in found] == sorted(intact)


def test_dbus_without_times():
    """Most come through all the same; some of those that lost a byte at rest cannot be told from good ones."""
    for seed in SEEDS[:5]:
        right, wrong = through("dbus", [(*row, 1, 3, 0, 0, 0, 0, 0, 0, 0) for row in dbus_sticks(seed)], seed)
        assert right >= 1890
        assert wrong <= 10


@pytest.mark.parametrize("kind", ["walking", "random"])
def test_uart12_without_times(kind):
    results = [through("uart12", uart12_rows(kind, seed), seed) for seed in SEEDS]
    assert results == [(1900, 0)] * len(SEEDS)


def test_uart12_stream_with_a_byte_missing_in_every_tenth_frame():
    """178 of 180 without times would do; the robot's own routine gets 161."""
    stream = read_stream(KNOWN_RC / "uart12-lostbytes-1")
    assert len(stream.frames) == 180
    found = [e for e in feed_whole(rc_decode.decoder("uart12"), stream.data) if isinstance(e, RcFrame)]
    assert [(frame.offset, frame.channels) for frame in found] == [frame[:2] for frame in stream.frames]
