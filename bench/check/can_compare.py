"""The CAN logs of two recordings, all frames at once: what `compare` finds line by line, in a twentieth of its time.

What differs is found as columns. What is then said of it is left to the line-by-line comparison of that one tick, so
that there is one place that knows the words. `tests/test_can_compare.py` holds the two to the same findings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bench.canbus.table import Family, Message
from bench.check.arrays import CanArrays
from bench.check.fields import turn

Rows: TypeAlias = NDArray[np.int64]
Mask: TypeAlias = NDArray[np.bool_]
TickFrames: TypeAlias = list[tuple[str, bytes]]
ToleranceOf: TypeAlias = Callable[[str], float] | None


@dataclass(slots=True)
class WireFindings:
    """Of one identifier: frames in the golden, how many differ, the first tick of them, how far fields are apart."""

    frames: int
    differing: int = 0
    first_tick: int | None = None
    largest: dict[str, float] = field(default_factory=dict)

    def found(self, ticks: NDArray[np.int32]) -> None:
        """Differences at these ticks."""
        if len(ticks):
            first = int(ticks.min())
            self.first_tick = first if self.first_tick is None else min(first, self.first_tick)
            self.differing += len(ticks)


def findings(golden: CanArrays, run: CanArrays, family: Family, tolerance_of: ToleranceOf) -> dict[str, WireFindings]:
    """By wire. `tolerance_of` says what a field is granted; None: not a bit."""
    found = {}
    seen = [np.zeros(0, np.int32)]
    for can_id in sorted({*golden.ids, *run.ids}):
        before, after = (np.flatnonzero(side.can_id == can_id) for side in (golden, run))
        wire = WireFindings(len(before))
        for ticks in _of_wire(golden, run, before, after, family.message(can_id), tolerance_of, wire, seen):
            wire.found(ticks)
        found[f"can 0x{can_id:03X}"] = wire
    for tick, wire_name in _other_order(golden, run, np.concatenate(seen)):
        found[wire_name].found(np.array([tick], np.int32))
    return found


def tick_of(arrays: CanArrays, tick: int) -> TickFrames:
    """The frames of one tick, as a line-by-line reader gives them."""
    first, end = np.searchsorted(arrays.tick, [tick, tick + 1])
    columns = arrays.rows(slice(int(first), int(end)))
    return [
        (f"can 0x{can_id:03X}", data.to_bytes(8, "big")[:length])
        for can_id, data, length in zip(
            columns.can_id.tolist(), columns.data.tolist(), columns.length.tolist(), strict=True
        )
    ]


def fields_of(message: Message, data: NDArray[np.uint64]) -> dict[str, Rows]:
    """The fields of many frames of one message, by the name under which `describe` has them."""
    octets = data.astype(">u8").view(np.uint8).reshape(-1, 8)
    values: dict[str, Rows] = {}
    for one in message.variables:
        value = np.zeros(len(data), np.int64)
        for place in range(one.first_byte, one.first_byte + one.size):
            value = (value << 8) | octets[:, place]
        if one.signed:
            sign = 1 << (8 * one.size - 1)
            value = (value ^ sign) - sign
        values[one.key] = value
    return values


def is_message(message: Message, data: NDArray[np.uint64]) -> Mask:
    """Which frames (of the message's length) say nothing beside its fields, so that comparing fields compares all."""
    known = constant = 0
    for one in message.fields:
        shift = 8 * (8 - one.first_byte - one.size)
        if one.is_constant:
            constant |= one.low << shift
        else:
            known |= ((1 << 8 * one.size) - 1) << shift
    return np.asarray((data & ~np.uint64(known)) == np.uint64(constant))


def nth_in_tick(ticks: NDArray[np.int32]) -> Rows:
    """Of frames in order: which is the second, third one of its tick."""
    return np.asarray(np.arange(len(ticks)) - np.searchsorted(ticks, ticks, "left"))


def _of_wire(
    golden: CanArrays,
    run: CanArrays,
    before: Rows,
    after: Rows,
    message: Message | None,
    tolerance_of: ToleranceOf,
    wire: WireFindings,
    seen: list[NDArray[np.int32]],
) -> Iterator[NDArray[np.int32]]:
    """Ticks of differences, one entry for each; ticks in which anything is not the same go to `seen`."""
    ticks = golden.tick[before], run.tick[after]
    if not np.array_equal(*ticks):
        keys = [one.astype(np.int64) << 16 | nth_in_tick(one) for one in ticks]
        _, left, right = np.intersect1d(keys[0], keys[1], assume_unique=True, return_indices=True)
        for one, both in zip(ticks, (left, right), strict=True):
            alone = np.ones(len(one), bool)
            alone[both] = False
            seen.append(one[alone])
            yield one[alone]
        before, after = before[left], after[right]
    differ = (golden.data[before] != run.data[after]) | (golden.length[before] != run.length[after])
    before, after = before[differ], after[differ]
    seen.append(golden.tick[before])
    if message is None or not message.variables:
        yield golden.tick[before]
        return
    decodes = np.ones(len(before), bool)
    for side, rows in ((golden, before), (run, after)):
        decodes &= (side.length[rows] == message.length) & is_message(message, side.data[rows])
    yield golden.tick[before[~decodes]]
    before, after = before[decodes], after[decodes]
    beyond = _beyond(message, golden.data[before], run.data[after], tolerance_of, wire)
    yield golden.tick[before[beyond]]


def _beyond(
    message: Message,
    before: NDArray[np.uint64],
    after: NDArray[np.uint64],
    tolerance_of: ToleranceOf,
    wire: WireFindings,
) -> Mask:
    """Which frames have a field beyond what it is granted; how far each field goes is noted."""
    values = fields_of(message, before), fields_of(message, after)
    beyond = np.ones(len(before), bool) if tolerance_of is None else np.zeros(len(before), bool)
    first_seen: list[tuple[int, str, float]] = []
    for one in message.variables:
        expected, got = values[0][one.key], values[1][one.key]
        apart = np.abs(expected - got)
        differing = np.flatnonzero(apart)
        if not len(differing):
            continue
        whole = int(turn(one.key))
        if whole:
            apart = np.minimum(apart % whole, whole - apart % whole)
        first_seen.append((int(differing[0]), one.key, float(apart.max())))
        if tolerance_of is not None:
            beyond |= apart > tolerance_of(one.key)
            if one.words:  # what has another name is another thing
                named = [
                    [one.words.get(value, "unknown") for value in side[differing].tolist()] for side in (expected, got)
                ]
                beyond[differing] |= np.array([a != b for a, b in zip(*named, strict=True)], bool)
    # In the order in which a reader of the log meets them: sorting by row keeps the message's order within a frame.
    for _, name, largest in sorted(first_seen, key=lambda one: one[0]):
        wire.largest[name] = largest
    return beyond


def _other_order(golden: CanArrays, run: CanArrays, differing: NDArray[np.int32]) -> Iterator[tuple[int, str]]:
    """Ticks that have the same frames in another order, and the wire of the first that is not in its place."""
    kept = golden.outside(differing), run.outside(differing)
    ids = golden.can_id[kept[0]], run.can_id[kept[1]]
    rows = np.flatnonzero(ids[0] != ids[1])
    if not len(rows):
        return
    ticks = golden.tick[kept[0]][rows]
    first = np.unique(ticks, return_index=True)[1]
    for tick, can_id in zip(ticks[first].tolist(), ids[0][rows[first]].tolist(), strict=True):
        yield tick, f"can 0x{can_id:03X}"
