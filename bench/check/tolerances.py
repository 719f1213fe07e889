"""Tolerances that a user grants: `--tolerance speed=5rpm`, a field by the name that a comparison shows, with its unit.

The unit is asked for so that nobody grants 5 m/s where 5 rpm were meant: it must be the one the field is recorded in.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from bench.check.fields import UNITS, fields_of
from bench.check.reading import Recording
from bench.config import nearest
from bench.errors import UsageError

SAMPLES = 400
"""Frames of each wire that are looked at for the names of fields."""
_GIVEN = re.compile(r"\s*([^=]+?)\s*=\s*([^\sa-zA-Z]*[0-9.](?:e-?[0-9]+)?|nan|[+-]?inf)\s*(.*?)\s*")


def granted(given: Sequence[str], golden: Recording) -> dict[str, float]:
    """Field -> how far it may be from the golden, for `fields.tolerance`. Raises UsageError with what was meant."""
    table: dict[str, float] = {}
    units = unit_of_fields(golden) if given else {}
    for text in given:
        match = _GIVEN.fullmatch(text)
        if match is None:
            raise UsageError(f"--tolerance {text}: expected a field, a number and its unit, such as speed=5rpm")
        field, number, unit = match.groups()
        table |= dict.fromkeys(_meant(text, field, unit, units), _size(text, number))
    return table


def unit_of_fields(golden: Recording) -> dict[str, str]:
    """Name of every field in a recording that is a number with a unit -> its unit, as a comparison shows them."""
    names = set(golden.state_columns)
    for wire, samples in _samples(golden).items():
        for data in samples:
            names.update(fields_of(wire, data, golden.family))
    found = {}
    for name in names:
        last = name.rpartition(" ")[2]  # "frame 2 dx_m" is a dx_m too
        unit = UNITS.get(last.rpartition("_")[2])
        if unit is not None and last != "t_s":
            found[last] = unit
    return found


def _samples(golden: Recording) -> Mapping[str, list[bytes]]:
    wires: dict[str, dict[bytes, None]] = {}
    for _, can_id, data in golden.can[: 8 * SAMPLES]:
        wires.setdefault(f"can 0x{can_id:03X}", {})[data] = None
    for name, bytes_by_tick in (("core", golden.core_to_base), ("base", golden.base_to_core)):
        wires[f"slamware {name}"] = dict.fromkeys(list(bytes_by_tick.values())[:SAMPLES])
    return {wire: list(found)[:SAMPLES] for wire, found in wires.items()}


def _meant(text: str, field: str, unit: str, units: Mapping[str, str]) -> list[str]:
    """Fields of this name: as they are recorded, or without unit and number, as a comparison says them."""
    plain = field.replace(" ", "_").lower()
    found = [name for name in units if name == plain or _words(name) in (plain, plain.rstrip("_0123456789"))]
    numbered = [name for name in found if _words(name, numbers=True) == plain]
    found = [name for name in found if name == plain] or numbered or found
    if not found:
        known = sorted({_words(name) for name in units})
        raise UsageError(f"--tolerance {text}: no field is called {field!r}{nearest(plain, known)}")
    wanted = {units[name] for name in found}
    endings = {name.rpartition("_")[2] for name in found}
    if unit not in wanted | endings:
        right = " or ".join(sorted(wanted))
        raise UsageError(
            f"--tolerance {text}: {field} is recorded in {right}, "
            f"{f'not in {unit}' if unit else 'and the unit is missing'}; such as {field}=5{right.split()[0]}"
        )
    return found


def _words(name: str, *, numbers: bool = False) -> str:
    """current_2_ma -> current (current_2 with its number)."""
    words = name.rpartition("_")[0]
    return words if numbers else re.sub(r"_[0-9]+$", "", words)


def _size(text: str, number: str) -> float:
    try:
        size = float(number)
    except ValueError:
        size = math.nan
    if not 0.0 <= size < math.inf:
        raise UsageError(f"--tolerance {text}: expected a number from 0 up, got {number!r}")
    return size
