"""Byte streams for the tests of decoders: ways to feed them, captures with their truth, and damage to do to them."""

import json
import os
import random
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bench.messages import RcFrame, RcLinkStatistics, RcNoise, RcOther

KNOWN_RC = Path(__file__).parent.parent / "fixtures" / "known" / "rc"

# Further recordings lie where this variable says; see the fixture `captures` in conftest.py.
RECORDINGS = os.environ.get("WHEELBENCH_CAPTURES")


# --- feeding -----------------------------------------------------------------------------------------------------


def feed_whole(decoder: Any, data: bytes) -> list[Any]:
    return decoder.feed(data) + decoder.finish()


def feed_pieces(decoder: Any, data: bytes, sizes: Iterator[int]) -> list[Any]:
    """Cut the stream into pieces of these sizes, then end it."""
    events, at = [], 0
    while at < len(data):
        size = next(sizes)
        events += decoder.feed(data[at : at + size])
        at += size
    return events + decoder.finish()


def feed_bytes(decoder: Any, data: bytes) -> list[Any]:
    return feed_pieces(decoder, data, iter(lambda: 1, 0))


def check_stream(make: Callable[[], Any], data: bytes, expected: list[Any] | None = None) -> list[Any]:
    """The same events however the bytes arrive: whole, cut anywhere, one at a time. Returns them.

    Short streams are cut at every place, long ones into many pieces of every size up to 64, five times over.
    """
    events = feed_whole(make(), data)
    if expected is not None:
        assert events == expected
    assert feed_bytes(make(), data) == events
    if len(data) <= 400:
        for cut in range(1, len(data)):
            decoder = make()
            assert decoder.feed(data[:cut]) + decoder.feed(data[cut:]) + decoder.finish() == events, cut
    else:
        for seed in range(5):
            rng = random.Random(seed)
            assert feed_pieces(make(), data, iter(lambda: rng.randint(1, 64), 0)) == events, seed  # noqa: B023
    return events


def feed_ticks(decoder: Any, data: bytes, times_us: Sequence[float]) -> list[Any]:
    """As the bench does it: the bytes of each millisecond together, and an empty feed while something is pending."""
    ticks: dict[int, bytearray] = {}
    for byte, at_us in zip(data, times_us, strict=True):
        ticks.setdefault(int(at_us // 1000), bytearray()).append(byte)
    events = []
    for tick in range(max(ticks) + 10):
        piece = bytes(ticks.get(tick, b""))
        if piece or decoder.pending:
            events += decoder.feed(piece, tick * 1000)
    return events


# --- captures ----------------------------------------------------------------------------------------------------


class Stream(NamedTuple):
    """A capture and the frames that are in it: (offset, channels, failsafe, frame lost)."""

    name: str
    protocol: str
    data: bytes
    times_us: list[float] | None
    frames: list[tuple[int, tuple[int, ...], bool, bool]]
    statistics: list[tuple[int, int, int]]
    """(offset, uplink quality, uplink RSSI) of CRSF link statistics."""


def read_stream(path: Path) -> Stream:
    described = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    data = path.with_suffix(".bin").read_bytes()
    frames, statistics = _truth(described)
    return Stream(path.stem, described["protocol"], data, _times_us(described, len(data)), frames, statistics)


def _times_us(described: dict[str, Any], length: int) -> list[float] | None:
    timing = described.get("timing", {})
    if timing.get("kind") == "per byte":
        return timing["byte_times"]
    if timing.get("kind") == "per burst":
        ends = [row[0] for row in timing["rows"][1:]] + [length]
        return [
            start_us + (i + 1) * timing["byte_us"]
            for (first, start_us), end in zip(timing["rows"], ends, strict=True)
            for i in range(end - first)
        ]
    return None


def _truth(described: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    if "vectors" in described:
        return [], []
    protocol, rows = described["protocol"], described.get("frames", {}).get("rows")
    if protocol == "uart12":
        # What the firmware takes although no 12-bit converter sends it is no frame for us.
        listed = [(at, tuple(values), False, False) for at, values in described["intact_frames"]["rows"]]
        return [frame for frame in listed if max(frame[1][:4]) <= 4095], []
    if protocol == "sbus2":
        channels = tuple(described["good_frames"]["channels"])
        return [(row[0], channels, False, False) for row in described["good_frames"]["rows"]], []
    if protocol == "sbus":
        return [(at, tuple(channels), bool(flags & 8), bool(flags & 4)) for at, flags, *channels in rows], []
    if protocol == "ibus":
        # The words as they were on the wire: 0xC in the upper four bits of one is the failsafe mark.
        return [
            (at, tuple(word & 0xFFF for word in words), any(word >> 12 == 0xC for word in words), False)
            for at, _, *words in rows
        ], []
    if protocol == "dbus":
        # Sticks and switches; mouse, keys and wheel are not listed and stand still in these streams.
        return [(at, tuple(values), False, False) for at, plausible, *values in rows if plausible], []
    if protocol == "crsf" and rows:
        frames = [(at, tuple(values), False, False) for at, kind, *values in rows if kind == 22]
        return frames, [(at, *values) for at, kind, *values in rows if kind == 20]
    if protocol == "crsf":
        # Frames of 26 bytes end to end; a row is written when anything changes.
        changes = {row[0]: tuple(row[1:]) for row in described["raw_channels"]["rows"]}
        frames, channels = [], ()
        for k in range(described["frames"]["count"]):
            channels = changes.get(k, channels)
            frames.append((26 * k, channels, False, False))
        return frames, []
    return [], []


def frames_of(events: list[Any], channels: int | None = None) -> list[tuple[int, tuple[int, ...], bool, bool]]:
    """Frames as `Stream.frames` lists them, with the first so many channels."""
    return [(e.offset, e.channels[:channels], e.failsafe, e.frame_lost) for e in events if isinstance(e, RcFrame)]


def sbus_frame(
    offset: int,
    channels: Sequence[int],
    failsafe: bool = False,
    frame_lost: bool = False,
    digital: Any = (False, False),
) -> RcFrame:
    """An SBUS frame; both digital channels are off where nothing is said."""
    return RcFrame(offset, 25, tuple(channels), failsafe, frame_lost, digital)


def statistics_of(events: list[Any]) -> list[tuple[int, int, int]]:
    return [(e.offset, e.uplink_quality_percent, e.uplink_rssi_dbm) for e in events if isinstance(e, RcLinkStatistics)]


def others_of(events: list[Any]) -> list[RcOther]:
    return [event for event in events if isinstance(event, RcOther)]


def check_partition(events: list[Any], length: int) -> None:
    """Every byte is accounted for exactly once, in stream order."""
    at = 0
    for event in events:
        assert event.offset == at, event
        assert event.length > 0
        at += event.length
    assert at == length


def check_counters(counters: Any, events: list[Any]) -> None:
    """Every event is counted once, under its own name, and noise under its reason."""
    frames = [event for event in events if isinstance(event, RcFrame)]
    assert counters.frames == len(frames)
    assert counters.failsafe == sum(frame.failsafe for frame in frames)
    assert counters.frame_lost == sum(frame.frame_lost for frame in frames)
    assert counters.link_statistics == sum(isinstance(event, RcLinkStatistics) for event in events)
    assert counters.others == len(others_of(events))
    noise = [event for event in events if isinstance(event, RcNoise)]
    assert counters.noise_events == Counter(event.reason for event in noise)
    lengths: Counter[str] = Counter()
    for event in noise:
        lengths[event.reason] += event.length
    assert counters.noise_bytes == lengths


# --- damage ------------------------------------------------------------------------------------------------------


def walking_sticks(seed: str, count: int, middle: int, top: int) -> list[list[int]]:
    """Four sticks that wander around the middle."""
    rng = random.Random(seed)
    sticks, rows = [middle] * 4, []
    for _ in range(count):
        sticks = [max(0, min(top, raw + rng.randint(-20, 20))) for raw in sticks]
        rows.append(sticks)
    return rows


def lose_bytes(frames: list[bytes], every: int, seed: str) -> tuple[bytes, dict[int, int]]:
    """Lay frames end to end with one byte missing from each `every`-th; returns offset -> number of the intact ones."""
    rng = random.Random(seed)
    data, intact = bytearray(), {}
    for k, frame in enumerate(frames):
        if k % every == every - 1:
            gone = rng.randrange(len(frame))
            data += frame[:gone] + frame[gone + 1 :]
        else:
            intact[len(data)] = k
            data += frame
    return bytes(data), intact
