"""What crossed a wire, by field: names that end in units, how far two values are apart, how far they may be.

A field that a codec's own `describe` does not name is a byte. `compare` asks; nothing here reads a file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TypeAlias

from bench.canbus import c610
from bench.canbus.table import Family
from bench.check.lines import RC, STATE, can_id_of, cell_value
from bench.slamware.describe import decoded
from bench.slamware.framing import FrameDecoder, SlamwareFrame

Value: TypeAlias = float | int | str | None
Fields: TypeAlias = Mapping[str, Value]

TOLERANCES: Mapping[str, float] = {
    "_ma": 2,
    "_raw": 2,
    "_a": 0.002,
    "_counts": 3,
    "_rpm": 2,
    "heading_counts": 1 << 16,  # a gyro's, 2^32 a turn: 1e-4 rad
    "_m": 1e-4,
    "_mps": 1e-3,
    "_rad": 1e-4,
    "_radps": 1e-2,
    # One SLAMWARE answer covers one poll, not a whole run: three counts of a wheel are 2e-6 m, 3e-5 rad of the robot.
    "dx_m": 2e-6,
    "dy_m": 2e-6,
    "dtheta_rad": 5e-5,
}
"""How far a field may be from its golden on another platform: by name, or by unit where the name starts with `_`.

Where a golden was made, everything is exact. Elsewhere the physics engine and the C library come from another compiler
and may round the last bit differently, and the loop carries that into the neighbouring count. The numbers are a few
steps of each field's resolution: chosen, not measured. What has no entry is exact everywhere.
"""

_TURNS = {"angle_counts": 8192.0, "heading_rad": math.tau, "heading_counts": 2.0**32}
"""Fields that start again after a turn: from 8191 counts to 0 is one step."""

UNITS = {"ma": "mA", "raw": "counts", "a": "A", "mps": "m/s", "radps": "rad/s"}
UNITS |= {unit: unit for unit in ("m", "rad", "rpm", "counts")}


def fields_of_pair(
    wire: str, expected: bytes, got: bytes, columns: Sequence[Sequence[str]], family: Family = c610.FAMILY
) -> tuple[Fields, Fields]:
    """Both sides by field, under the same names.

    `columns` are the two headers of state.csv; a column that only one side has is left out. `family` has the CAN
    messages of the robot's motors. Frames of which the codec does not know the difference (another kind, another
    checksum) come as bytes.
    """
    if wire == STATE:
        rows = [
            dict(zip(names, map(cell_value, data.decode().split(",")), strict=True))
            for names, data in zip(columns, (expected, got), strict=True)
        ]
        both = [name for name in columns[0] if name in columns[1]]
        return {name: rows[0][name] for name in both}, {name: rows[1][name] for name in both}
    before, after = fields_of(wire, expected, family), fields_of(wire, got, family)
    if before.keys() != after.keys() or before == after:
        return _as_bytes(expected, len(got)), _as_bytes(got, len(expected))
    return before, after


def distance(name: str, expected: Value, got: Value) -> float | None:
    """How far two numbers are apart, the short way round where the field is an angle; None for anything else."""
    if not isinstance(expected, int | float) or not isinstance(got, int | float):
        return None
    apart = abs(expected - got)
    whole = turn(name)
    if whole:
        apart = min(apart % whole, whole - apart % whole)
    # Recorded values have at most nine decimals that mean something; behind them stands the error of the subtraction.
    return round(apart, 9)


@cache
def turn(name: str) -> float:
    """After how much a field starts again; 0 where it never does."""
    return next((turn for ending, turn in _TURNS.items() if name.endswith(ending)), 0.0)


def tolerance(name: str, tolerances: Mapping[str, float]) -> float:
    """What a table like `TOLERANCES` grants a field."""
    name = name.rpartition(" ")[2]  # "frame 2 dx_m" is a dx_m too
    return tolerances.get(name, tolerances.get("_" + name.rpartition("_")[2], 0.0))


def shown(wire: str, name: str) -> tuple[str, str]:
    """A field's name and unit for people: current_2_ma -> ("current 2", " mA"). Columns of state keep their name."""
    words, _, unit = name.rpartition("_")
    if wire == STATE or unit not in UNITS:
        return name, ""
    return words.replace("_", " "), f" {UNITS[unit]}"


def shown_value(value: Value) -> str:
    """A value for people: floats without the digits that mean nothing."""
    if value is None:
        return "nothing"
    return f"{value:.9f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def fields_of(wire: str, data: bytes, family: Family) -> Fields:
    """A frame by field; {} where no codec knows it whole."""
    if wire == RC:
        return {}  # a tick's bytes are rarely a frame; `wheelbench decode` reads the stream
    if not wire.startswith("can "):
        return _slamware_fields(data)
    message = family.message(can_id_of(wire), len(data))
    values = message.decode(data) if message is not None else None
    if message is None or values is None:
        return {}
    # Bytes 6 and 7 are empty on a C610 (temperature and error on a C620). Where they are not, every byte is compared.
    return message.describe(data) if message.layout.pack(*message.layout.unpack(data)) == data else {}


def _slamware_fields(data: bytes) -> Fields:
    """The fields of a tick's whole frames; {} where something else is among them."""
    fields: dict[str, Value] = {}
    events = FrameDecoder().feed(data)
    for number, event in enumerate(events, 1):
        known = decoded(event) if isinstance(event, SlamwareFrame) else {}
        if not known:
            return {}
        prefix = f"frame {number} " if len(events) > 1 else ""
        fields |= {prefix + name: value for name, value in known.items()}
    return fields if sum(event.length for event in events) == len(data) else {}


def _as_bytes(data: bytes, other_length: int) -> dict[str, Value]:
    fields: dict[str, Value] = {f"byte {index}": f"0x{byte:02X}" for index, byte in enumerate(data)}
    # Where the other side is longer, its further bytes face nothing.
    fields |= {f"byte {index}": None for index in range(len(data), other_length)}
    return fields
