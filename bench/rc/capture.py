"""Captures of RC streams on disk: a file of raw bytes, and beside it, where there is one, a .json that describes it.

    NAME.bin     the bytes as they leave a UART, already un-inverted
    NAME.json    format "rc-capture/1", protocol, length and sha256 of the bytes, and their timing:
                 "per byte"          byte_times: microseconds, one for each byte
                 "per burst"         rows of (first offset, start time); bytes follow each other every byte_us
                 anything else       no times

Any other file of raw bytes is a capture without times. Here bytes get their times, or are paced frame by frame where
they have none, so that the bench can feed them tick by tick.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

from bench import rc_decode
from bench.config.table import MOST_S, read_file
from bench.errors import UsageError
from bench.messages import TICK_US, RcFrame

FORMAT = "rc-capture/1"
_MOST_US = 1e6 * MOST_S
# Captures name what the receiver calls itself; we decode SBUS2 as the SBUS it is.
_PROTOCOL_OF = {"sbus2": "sbus"}
_WITHOUT = "mend it, or move it away to use the bytes alone"


@dataclass(frozen=True, slots=True)
class Capture:
    """The bytes of one stream, and what is known about them."""

    path: Path
    data: bytes
    times_us: tuple[float, ...] | None
    """When each byte had arrived, in microseconds from the beginning of the capture; None where that is not known."""
    protocol: str | None
    """What the description calls the protocol, by our name for it; None without a description."""


def load_capture(path: str | Path, use_times: bool = True) -> Capture:
    """Read a capture from its bytes, or from its .json. Raises UsageError with file, fault and what to try."""
    bytes_path = Path(path)
    if bytes_path.is_dir():
        raise UsageError(f"{bytes_path}: is a directory; a capture is a file of raw bytes, such as NAME.bin")
    described_by = bytes_path.with_suffix(".json")
    description: dict[str, Any] = {}
    if bytes_path.suffix == ".json" or described_by.is_file():
        description = _description(described_by)
        if bytes_path.suffix == ".json":
            bytes_path = bytes_path.parent / _get(described_by, description, "bin", str)
    data = _read(bytes_path)
    if not data:
        raise UsageError(f"{bytes_path}: is empty; a capture holds the raw bytes of the line")
    if not description:
        return Capture(bytes_path, data, None, None)
    _check(described_by, description, bytes_path, data)
    times_us = _times_us(described_by, description, len(data)) if use_times else None
    protocol = _get(described_by, description, "protocol", str)
    return Capture(bytes_path, data, times_us, _PROTOCOL_OF.get(protocol, protocol))


def by_tick(capture: Capture, protocol: str, period_ms: int | None = None) -> dict[int, bytes]:
    """The bytes of each tick that has any: by their times, or else one whole frame every `period_ms`.

    A frame that has no time takes the bytes before it along, junk and telemetry alike; what follows the last one
    travels with it. Raises UsageError where a period is needed and missing.
    """
    ticks: dict[int, bytearray] = {}
    if capture.times_us is not None:
        for byte, at_us in zip(capture.data, capture.times_us, strict=True):
            ticks.setdefault(int(at_us // TICK_US), bytearray()).append(byte)
        return {tick: bytes(data) for tick, data in ticks.items()}
    if period_ms is None:
        raise UsageError(f"{capture.path}: has no byte times; give the period from frame to frame with --period-ms")
    if period_ms < 1:
        raise UsageError(f"a period of {period_ms} ms cannot be; expected at least 1")
    decoder = rc_decode.decoder(protocol)
    events = decoder.feed(capture.data) + decoder.finish()
    ends = [event.offset + event.length for event in events if isinstance(event, RcFrame)]
    # One tick for all of it where there is no frame: nothing in it could be paced.
    ends[-1:] = [len(capture.data)]
    starts = [0, *ends]
    return {k * period_ms: capture.data[start:end] for k, (start, end) in enumerate(zip(starts, ends, strict=False))}


def _read(path: Path) -> bytes:
    try:
        return read_file(path)
    except FileNotFoundError:
        raise UsageError(f"{path}: no such file; a capture is a file of raw bytes, such as NAME.bin") from None
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror}); check the path") from None


def _description(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(_read(path).decode())
    except ValueError:
        raise UsageError(f"{path}: is not JSON; {_WITHOUT}") from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise UsageError(f"{path}: does not describe a capture (format {FORMAT!r}); {_WITHOUT}")
    return found


def _get(path: Path, table: dict[str, Any], key: str, kind: type) -> Any:
    value = table.get(key)
    if not isinstance(value, kind):
        raise UsageError(f"{path}: {key}: expected {_KIND_NAMES[kind]}, got {value!r}")
    return value


_KIND_NAMES = {str: "text", int: "a whole number", float: "a number", list: "a list", dict: "an object"}


def _check(path: Path, description: dict[str, Any], bytes_path: Path, data: bytes) -> None:
    """Refuse a description of other bytes: its times and its protocol would be wrong for these."""
    advice = "keep the two as they were made, or move the .json away"
    length = _get(path, description, "length", int)
    if length != len(data):
        raise UsageError(f"{path}: describes {length} bytes, but {bytes_path.name} has {len(data)}; {advice}")
    if _get(path, description, "sha256", str).lower() != hashlib.sha256(data).hexdigest():
        raise UsageError(f"{path}: describes other bytes than those in {bytes_path.name} (sha256 differs); {advice}")


def _times_us(path: Path, description: dict[str, Any], length: int) -> tuple[float, ...] | None:
    if "timing" not in description:
        return None
    timing = _get(path, description, "timing", dict)
    kind = timing.get("kind")
    if kind == "per byte":
        times = _get(path, timing, "byte_times", list)
    elif kind == "per burst":
        times = _burst_times(path, timing, length)
    else:
        return None
    if len(times) != length:
        raise UsageError(f"{path}: timing: {len(times)} times for {length} bytes; {_WITHOUT}")
    last_us = 0.0
    for i, at_us in enumerate(times):
        if type(at_us) not in (int, float) or not last_us <= at_us <= _MOST_US:
            raise UsageError(f"{path}: timing: byte {i} comes at {at_us!r} us, after {last_us} us; {_WITHOUT}")
        last_us = at_us
    return tuple(map(float, times))


def _is_time(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _MOST_US


def _burst_times(path: Path, timing: dict[str, Any], length: int) -> list[Any]:
    """A burst's time is that of its beginning; a byte has arrived one byte time later."""
    rows = _get(path, timing, "rows", list)
    byte_us = timing.get("byte_us")
    if not _is_time(byte_us) or not all(
        isinstance(row, list) and len(row) == 2 and type(row[0]) is int and _is_time(row[1]) for row in rows
    ):
        raise UsageError(f"{path}: timing: expected byte_us and rows of (first offset, start time); {_WITHOUT}")
    offsets = [row[0] for row in rows] + [length]
    times: list[Any] = []
    for (first, start_us), after in zip(rows, offsets[1:], strict=True):
        if first != len(times):
            raise UsageError(f"{path}: timing: a burst begins at byte {first}, not at {len(times)}; {_WITHOUT}")
        times += [start_us + byte_us * (i + 1) for i in range(after - first)]
    return times
