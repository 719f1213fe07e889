"""What one base says beside another that heard the same: where they part first, what of it is time, and what is value.

Both have been given the same inputs, feedback included, so that nothing they do comes back to them: a base that is
late is late by as much in every frame, and a value that is rounded otherwise is off in that frame alone. In a closed
loop each would have drawn all the others along.

Time is found first, with the values as they are: the shift of one whole stream under which the two are closest. Values
are compared under that shift, so that a late frame is no wrong one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bench.canbus.table import Family
from bench.check.fields import Fields, Value, fields_of, shown, shown_value
from bench.check.pairing import Pairs, answers_of, paired
from bench.messages import TickOutput

MOST_LATE_TICKS = 200
"""A shift is looked for within so much, both ways."""
SHIFT_PAYS = 0.8
"""Under a shift the two must be closer by this factor; otherwise they are taken as they stand."""
WINDOW_TICKS = 500
"""Whether the shift changes is looked at in windows of this length."""
MOVING_COUNTS = 20.0
"""A window in which a value moves by less says nothing of time."""
ROUNDING_COUNTS = 1.0
FIT_COUNTS = 1.0
"""A scale or an offset explains a field where no frame is farther from it than this."""

Floats: TypeAlias = NDArray[np.float64]
COMMANDS, ANSWERS = "commands", "answers"
NEVER, UNASKED = "never come{}", "come{} that the reference has not"


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first place at which two streams are not the same, taken as they came."""

    tick: int
    wire: str
    field: str
    """Empty where one of them has nothing there."""
    reference: str
    peer: str


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is not the same. `kind` is late, varies, missing, extra (time), rounding, scale, offset, other."""

    is_time: bool
    kind: str
    wire: str
    fields: tuple[str, ...]
    amount: float
    """ms where it is time, frames where some are missing, else counts of the field (of a scale: the factor)."""
    text: str


@dataclass(frozen=True, slots=True)
class Parity:
    """What was found between a reference and one peer."""

    first: Divergence | None
    findings: tuple[Finding, ...]

    @property
    def is_same(self) -> bool:
        """Byte for byte, tick for tick."""
        return self.first is None


@dataclass(slots=True)
class _Stream:
    """One wire of one side: for each field its values by tick, NaN where nothing was sent."""

    fields: tuple[str, ...]
    values: Floats
    sent: NDArray[np.bool_]

    def held(self) -> Floats:
        """The value that was last sent, at every tick; the first one before it."""
        at = np.maximum.accumulate(np.where(self.sent, np.arange(len(self.sent)), -1))
        first = int(np.argmax(self.sent))
        return np.asarray(self.values[np.where(at < 0, first, at)])


def parity(reference: Sequence[TickOutput], peer: Sequence[TickOutput], family: Family) -> Parity:
    """Hold a peer's words against a reference's, given the same inputs; `family` has the CAN messages of the robot."""
    findings: list[Finding] = []
    wires = sorted({can_id for outs in (reference, peer) for out in outs for can_id, _ in out.can_commands})
    for can_id in wires:
        wire = f"can {can_id:#05x}"
        texts = [_frames(outs, can_id) for outs in (reference, peer)]
        findings += _compare_stream(f"{COMMANDS} {can_id:#05x}", *_streams(wire, texts, len(reference), family))
    findings += _compare_answers(paired(answers_of(reference), answers_of(peer), MOST_LATE_TICKS), family)
    return Parity(_first(reference, peer, family), tuple(findings))


def _frames(outs: Sequence[TickOutput], can_id: int) -> dict[int, bytes]:
    """The newest frame of an identifier in each tick that has one."""
    return {out.tick: data for out in outs for one, data in out.can_commands if one == can_id}


def _streams(wire: str, sides: Sequence[Mapping[int, bytes]], ticks: int, family: Family) -> list[_Stream]:
    """Both sides over the same fields: those that every frame of both has as numbers, or their bytes."""
    read = [{tick: _numbers(fields_of(wire, data, family)) for tick, data in side.items()} for side in sides]
    names = {tuple(fields) for side in read for fields in side.values()}
    if len(names) != 1 or not next(iter(names)):
        longest = max((len(data) for side in sides for data in side.values()), default=0)
        read = [{t: {f"byte {k}": data[k] for k in range(len(data))} for t, data in side.items()} for side in sides]
        names = {tuple(f"byte {k}" for k in range(longest))}
    (fields,) = names
    streams = []
    for side in read:
        values, sent = np.full((ticks, len(fields)), np.nan), np.zeros(ticks, bool)
        for tick, found in side.items():
            values[tick] = [found.get(name, np.nan) for name in fields]
            sent[tick] = True
        streams.append(_Stream(fields, values, sent))
    return streams


def _numbers(fields: Fields) -> dict[str, float]:
    return {name: float(value) for name, value in fields.items() if isinstance(value, int | float)}


def _compare_stream(wire: str, reference: _Stream, peer: _Stream) -> list[Finding]:
    if not reference.sent.any() or not peer.sent.any():
        count = int(reference.sent.sum() + peer.sent.sum())
        kind, what = ("extra", "only the peer sends it") if peer.sent.any() else ("missing", "the peer sends none")
        return [Finding(True, kind, wire, (), count, f"{wire}: {what}, {count} frames")]
    shift, least, most = _shifts(reference.held(), peer.held())
    found = []
    if shift or least != most:
        found.append(_timing(wire, shift, least, most))
    end = len(reference.sent) - abs(shift)
    here = slice(max(0, -shift), max(0, -shift) + end)
    there = slice(max(0, shift), max(0, shift) + end)
    found += _counts(wire, reference.sent[here], peer.sent[there])
    both = peer.sent[there] & reference.sent[here]
    ticks = np.flatnonzero(both) + here.start
    return found + _values(wire, reference.fields, reference.values[here][both], peer.values[there][both], ticks)


def _shifts(reference: Floats, peer: Floats) -> tuple[int, int, int]:
    """By how many ticks the peer is later: over all, and the least and most of single windows."""
    costs = {shift: _cost(reference, peer, shift) for shift in _around(0, MOST_LATE_TICKS, len(reference))}
    shift = min(costs, key=lambda one: (costs[one], abs(one)))
    if costs[shift] >= SHIFT_PAYS * costs[0]:
        shift = 0
    least = most = shift
    for start in range(MOST_LATE_TICKS, len(reference) - WINDOW_TICKS - MOST_LATE_TICKS, WINDOW_TICKS):
        here = slice(start, start + WINDOW_TICKS)
        if np.ptp(reference[here], axis=0).max(initial=0.0) < MOVING_COUNTS:
            continue
        window = {one: _window_cost(reference, peer, here, one) for one in _around(shift, 20, MOST_LATE_TICKS)}
        best = min(window, key=lambda one: (window[one], abs(one - shift)))
        if window[best] < 0.5 * window[shift] and window[shift] - window[best] > ROUNDING_COUNTS:
            least, most = min(least, best), max(most, best)
    return shift, least, most


def _around(middle: int, most: int, below: int) -> range:
    most = min(most, below - 1)
    return range(middle - most, middle + most + 1)


def _cost(reference: Floats, peer: Floats, shift: int) -> float:
    """Mean distance of the two, counts, with the peer taken this many ticks later."""
    end = len(reference) - abs(shift)
    apart = peer[max(0, shift) :][:end] - reference[max(0, -shift) :][:end]
    return float(np.abs(apart).mean()) if apart.size else np.inf


def _window_cost(reference: Floats, peer: Floats, here: slice, shift: int) -> float:
    return float(np.abs(peer[here.start + shift : here.stop + shift] - reference[here]).mean())


def _timing(wire: str, shift: int, least: int, most: int) -> Finding:
    way = "late" if shift >= 0 else "early"
    if least == most:
        return Finding(True, "late", wire, (), shift, f"{wire} come {abs(shift)} ms {way}, all alike")
    return Finding(True, "varies", wire, (), shift, f"{wire} come {least} to {most} ms late, mostly {shift}")


def _counts(wire: str, reference: NDArray[np.bool_], peer: NDArray[np.bool_]) -> list[Finding]:
    found = []
    missing, extra = int((reference & ~peer).sum()), int((peer & ~reference).sum())
    for kind, count, what in (("missing", missing, NEVER), ("extra", extra, UNASKED)):
        if count:
            text = f"{wire}: {_frames_that(count)} {what.format(_s(count))}"
            found.append(Finding(True, kind, wire, (), count, text))
    return found


def _frames_that(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _s(count: int) -> str:
    return "s" if count == 1 else ""


def _values(
    wire: str, fields: Sequence[str], reference: Floats, peer: Floats, ticks: NDArray[np.int64]
) -> list[Finding]:
    """Each field under the shift; those that are off in the same way together."""
    alike: dict[tuple[str, float], list[tuple[str, int, int]]] = {}
    for column, name in enumerate(fields):
        before, after = reference[:, column], peer[:, column]
        off = after - before
        differing = np.isnan(before) != np.isnan(after)
        off = np.where(np.isnan(off), 0.0, off)
        differing |= off != 0.0
        if differing.any():
            kind = _kind(before, off)
            alike.setdefault(kind, []).append((name, int(differing.sum()), int(ticks[np.argmax(differing)])))
    return [_value(wire, kind, amount, found, len(ticks)) for (kind, amount), found in alike.items()]


def _kind(reference: Floats, off: Floats) -> tuple[str, float]:
    """What a field's distances have in common: another rounding, an offset, a scale, or nothing."""
    largest = float(np.abs(off).max())
    if largest <= ROUNDING_COUNTS:
        return "rounding", largest
    middle = float(np.median(off))
    if abs(middle) > ROUNDING_COUNTS and np.abs(off - middle).max() <= FIT_COUNTS:
        return "offset", round(middle)
    square = float((reference * reference).sum())
    factor = float((reference * off).sum()) / square if square else 0.0
    if np.abs(off - factor * reference).max() <= FIT_COUNTS:
        return "scale", round(1.0 + factor, 3)
    return "other", largest


def _value(wire: str, kind: str, amount: float, found: Sequence[tuple[str, int, int]], frames: int) -> Finding:
    names = tuple(name for name, _, _ in found)
    _, unit = shown("", names[0])
    what = _listed([shown("", name)[0] for name in names])
    most, first = max(count for _, count, _ in found), min(tick for _, _, tick in found)
    differ, are = ("differs", "is") if len(names) == 1 else ("differ", "are")
    size = {
        "rounding": f"{differ} by {amount:g}{unit} at most: another rounding",
        "offset": f"{are} off by {amount:+g}{unit}",
        "scale": f"{are} scaled by {amount:g}",
        "other": f"{differ} by up to {amount:g}{unit}",
    }[kind]
    text = f"{wire}: {what} {size}; in {most} of {frames} frames, first at {first / 1000:.3f} s"
    return Finding(False, kind, wire, names, amount, text)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _compare_answers(both: Pairs, family: Family) -> list[Finding]:
    """Answers one by one: they follow requests, which both have got at the same times."""
    found: list[Finding] = []
    pairs = both.pairs
    for kind, count, what in (("missing", both.missing, NEVER), ("extra", both.extra, UNASKED)):
        if count:
            found.append(Finding(True, kind, ANSWERS, (), count, f"{ANSWERS}: {count} {what.format(_s(count))}"))
    if not pairs:
        return found
    late = sorted(there.tick - here.tick for here, there in pairs)
    middle = late[len(late) // 2]
    if late[0] or late[-1]:
        found.append(_timing(ANSWERS, middle, late[0], late[-1]))
    differing = [(here.tick, here.data, there.data) for here, there in pairs if here.data != there.data]
    if differing:
        tick = differing[0][0]
        names = tuple(sorted({name for _, before, after in differing for name in _apart(before, after, family)}))
        listed = _listed([shown("", name)[0] for name in names]) if names else ""
        what = f"{listed} differ{_s(len(names))}" if names else "their bytes differ"
        text = f"{ANSWERS}: {what}; in {len(differing)} of {len(pairs)}, first at {tick / 1000:.3f} s"
        found.append(Finding(False, "other", ANSWERS, names, len(differing), text))
    return found


def _apart(before: bytes, after: bytes, family: Family) -> list[str]:
    """The fields of two answers that are not the same; none where they are other kinds of answer."""
    one, other = (fields_of("slamware", data, family) for data in (before, after))
    return [name for name in one if one[name] != other[name]] if one.keys() == other.keys() else []


def _first(reference: Sequence[TickOutput], peer: Sequence[TickOutput], family: Family) -> Divergence | None:
    for ours, theirs in zip(reference, peer, strict=True):
        if ours.can_commands == theirs.can_commands and ours.base_to_core == theirs.base_to_core:
            continue
        before, after = dict(ours.can_commands), dict(theirs.can_commands)
        for can_id in (*before, *after):
            if before.get(can_id) != after.get(can_id):
                wire = f"can {can_id:#05x}"
                return _divergence(ours.tick, wire, before.get(can_id), after.get(can_id), family)
        if ours.base_to_core != theirs.base_to_core:
            wire = "slamware base->core"
            return _divergence(ours.tick, wire, ours.base_to_core or None, theirs.base_to_core or None, family)
        return Divergence(ours.tick, "can", "", _ids(ours), _ids(theirs))  # the same frames in another order, or twice
    return None


def _divergence(tick: int, wire: str, before: bytes | None, after: bytes | None, family: Family) -> Divergence:
    if before is not None and after is not None:
        one, other = (fields_of(wire, data, family) for data in (before, after))
        for name in one:
            if name in other and one[name] != other[name]:
                label, unit = shown(wire, name)
                return Divergence(tick, wire, label, _with(one[name], unit), _with(other[name], unit))
    return Divergence(tick, wire, "", _hex(before), _hex(after))


def _with(value: Value, unit: str) -> str:
    return shown_value(value) + unit


def _hex(data: bytes | None) -> str:
    return "nothing" if data is None else data.hex(" ").upper()


def _ids(out: TickOutput) -> str:
    return " ".join(f"{can_id:#05x}" for can_id, _ in out.can_commands) or "nothing"
