"""A recording as traces: each wire's frames in order, with their ticks and decoded fields as columns of whole numbers.

A field is kept in its smallest steps (counts on CAN and RC, Q16 of the SLAMWARE words, millionths in state.csv), so
that "scaled", "flipped" and "quantised" are questions about integers. What a codec does not decode has no field; its
frames still have their bytes, as a number that is the same for the same bytes in both recordings of a pair.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bench import rc_decode
from bench.canbus.table import Family
from bench.check.arrays import CanArrays
from bench.check.can_compare import fields_of, is_message
from bench.check.fields import turn
from bench.check.lines import BASE_TO_CORE, CAN_LOG, CORE_TO_BASE, RC, RC_LOG, SLAMWARE_LOG, STATE, STATE_CSV
from bench.check.reading import Recording
from bench.check.recording import LOGS
from bench.config import ConfigError, load_robot
from bench.messages import RcFrame, RcNoise
from bench.slamware.describe import decoded
from bench.slamware.framing import FrameDecoder, SlamwareFrame

Ints: TypeAlias = NDArray[np.int64]
Interner: TypeAlias = dict[object, int]

STATE_STEP = 1e-6
_SLAMWARE_STEPS = {
    "dx_m": 1e-3 / 65536,
    "dy_m": 1e-3 / 65536,
    "dtheta_rad": math.radians(1.0 / 65536),
    "vx_mps": 1.0 / 65536,
    "vy_mps": 1.0 / 65536,
    "omega_radps": 1.0 / 65536,
}
"""What one count of a word is worth (document 000 and the vendor's header); rim speeds and distances are whole mm."""
_MM = 1e-3


@dataclass(frozen=True, slots=True)
class FieldTrace:
    """One field of one wire. Where `valid` is False the frame does not have it."""

    counts: Ints
    valid: NDArray[np.bool_]
    step: float = 1.0
    """What a count is worth in the unit of the field's name."""
    turn: int = 0
    """Counts of a turn, where the field starts again after one."""


@dataclass(frozen=True, slots=True)
class Trace:
    """One wire: entry i of every column is its i-th frame."""

    wire: str
    ticks: Ints
    keys: Ints
    """Equal where the frames' bytes are."""
    fields: Mapping[str, FieldTrace] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.ticks)


def traces_of_pair(golden: Recording, run: Recording) -> dict[str, tuple[Trace, Trace]]:
    """Every wire on which the two logs are not byte for byte the same: the golden's trace and the run's."""
    pairs: dict[str, tuple[Trace, Trace]] = {}
    for name in LOGS:
        if golden.content(name) == run.content(name):
            continue
        interner: Interner = {}
        before, after = (_LOADERS[name](side, interner) for side in (golden, run))
        for wire in sorted({**before, **after}):
            pair = before.get(wire, _empty(wire)), after.get(wire, _empty(wire))
            if any(
                not np.array_equal(*columns) for columns in zip(*((one.ticks, one.keys) for one in pair), strict=True)
            ):
                pairs[wire] = pair
    return pairs


def can_of(recording: Recording) -> CanArrays:
    """The recording's CAN frames up to its end. Raises RecordingError where a line cannot be read."""
    arrays = recording.can_arrays
    late = recording.complete and arrays is not None and len(arrays.tick) and arrays.tick[-1] >= recording.ticks
    if arrays is not None and not late:
        return arrays.until(recording.ticks)
    # Line by line: this finds the words for what is wrong.
    frames = recording.can
    found = CanArrays.of_size(len(frames))
    for row, (tick, can_id, data) in enumerate(frames):
        found.tick[row], found.can_id[row], found.length[row] = tick, can_id, len(data)
        found.data[row] = int.from_bytes(data.ljust(8, b"\0"), "big")
    return found


def _can_traces(recording: Recording, _interner: Interner) -> dict[str, Trace]:
    arrays, family = can_of(recording), recording.family
    return {f"can 0x{can_id:03X}": _can_trace(arrays, can_id, family) for can_id in arrays.ids}


def _can_trace(arrays: CanArrays, can_id: int, family: Family) -> Trace:
    rows = np.flatnonzero(arrays.can_id == can_id)
    data, lengths = arrays.data[rows], arrays.length[rows]
    # The length is part of what crossed the wire: it takes the place of a hash's salt.
    keys = (data ^ (lengths.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15))).view(np.int64)
    message = family.message(can_id)
    fields: dict[str, FieldTrace] = {}
    if message is not None and message.variables:
        valid = (lengths == message.length) & is_message(message, data)
        for name, values in fields_of(message, data).items():
            counts = 8192 if name.endswith("angle_counts") else 0
            fields[name] = FieldTrace(values, valid, 1.0, counts)
    return Trace(f"can 0x{can_id:03X}", arrays.tick[rows].astype(np.int64), keys, fields)


def _rc_traces(recording: Recording, interner: Interner) -> dict[str, Trace]:
    chunks = recording.rc
    frames = _rc_frames(recording)
    if frames:
        rows: list[Mapping[str, int]] = []
        for _, frame in frames:
            flags = {"failsafe": int(frame.failsafe), "frame_lost": int(frame.frame_lost)}
            channels = {f"channel_{number}_raw": value for number, value in enumerate(frame.channels)}
            rows.append(channels | flags)
        keys = [_interned(interner, (frame.channels, frame.failsafe, frame.frame_lost)) for _, frame in frames]
        return {
            RC: Trace(RC, _ints(tick for tick, _ in frames), _ints(keys), _numeric_fields(rows, lambda _: (1.0, 0)))
        }
    keys = [_interned(interner, data) for data in chunks.values()]
    return {RC: Trace(RC, _ints(chunks), _ints(keys))}


def _rc_frames(recording: Recording) -> list[tuple[int, RcFrame]]:
    """(tick of its last byte, frame); empty where much of the stream is noise, or nobody knows its protocol."""
    try:
        profile = load_robot(recording.robot_file, recording.profile_file).rc
    except ConfigError:
        return []
    if profile is None:
        return []
    decoder = rc_decode.decoder(profile.protocol)
    frames: list[tuple[int, RcFrame]] = []
    noise = 0
    for tick, data in recording.rc.items():
        for event in decoder.feed(data):
            if isinstance(event, RcFrame):
                frames.append((tick, event))
            elif isinstance(event, RcNoise):
                noise += event.length
    return frames if noise * 10 < sum(map(len, recording.rc.values())) else []


def _slamware_traces(recording: Recording, interner: Interner) -> dict[str, Trace]:
    traces = {}
    for wire, chunks in ((CORE_TO_BASE, recording.core_to_base), (BASE_TO_CORE, recording.base_to_core)):
        decoder = FrameDecoder()
        ticks, keys, rows = [], [], []
        for tick, data in chunks.items():
            events = decoder.feed(data)
            known = [decoded(event) if isinstance(event, SlamwareFrame) else {} for event in events] or [{}]
            for number, facts in enumerate(known):
                ticks.append(tick)
                keys.append(_interned(interner, (data, number)))
                rows.append({name: value for name, value in facts.items() if isinstance(value, int | float)})
        traces[wire] = Trace(wire, _ints(ticks), _ints(keys), _numeric_fields(rows, _slamware_step))
    return {wire: trace for wire, trace in traces.items() if len(trace)}


def _slamware_step(name: str) -> tuple[float, int]:
    return _SLAMWARE_STEPS.get(name, _MM if name.endswith(("_m", "_mps")) else 1.0), 0


def _state_traces(recording: Recording, interner: Interner) -> dict[str, Trace]:
    columns, state = recording.state_columns[1:], recording.state
    rows: list[dict[str, float]] = []
    keys = []
    for row in state.values():
        cells = dict(zip(columns, row[1:], strict=True))
        keys.append(_interned(interner, row[1:]))
        rows.append({name: value for name, value in cells.items() if isinstance(value, int | float)})
    return {STATE: Trace(STATE, _ints(state), _ints(keys), _numeric_fields(rows, _state_step))}


def _state_step(name: str) -> tuple[float, int]:
    return STATE_STEP, round(turn(name) / STATE_STEP)


def _numeric_fields(
    rows: list[Mapping[str, int]] | list[dict[str, float]], step_of: Callable[[str], tuple[float, int]]
) -> dict[str, FieldTrace]:
    names: dict[str, None] = {}
    for row in rows:
        names.update(dict.fromkeys(row))
    fields = {}
    for name in names:
        step, turn_counts = step_of(name)
        valid = np.array([name in row for row in rows], bool)
        counts = _ints(round(row.get(name, 0) / step) for row in rows)
        fields[name] = FieldTrace(counts, valid, step, turn_counts)
    return fields


def _interned(interner: Interner, thing: object) -> int:
    return interner.setdefault(thing, len(interner))


def _ints(values: object) -> Ints:
    return np.array(list(values), np.int64)  # type: ignore[call-overload]


def _empty(wire: str) -> Trace:
    return Trace(wire, _ints(()), _ints(()))


_LOADERS: dict[str, Callable[[Recording, Interner], dict[str, Trace]]] = {
    RC_LOG: _rc_traces,
    SLAMWARE_LOG: _slamware_traces,
    STATE_CSV: _state_traces,
    CAN_LOG: _can_traces,
}
