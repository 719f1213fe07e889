"""The faults that a person may inject: every kind on every wire of `check.faults`, with figures that can be seen.

A fault is kept as its `[[fault]]` table, so that a recording's scenario.toml says the same as the run had.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

from bench.check.faults import KINDS, Fault, read_fault
from bench.check.faulty import Injector
from bench.config import ConfigError, Robot, Table
from bench.config.emit import toml_text
from bench.loop import Bench

Values: TypeAlias = Mapping[str, str | int | float]
SECONDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0)
GRAVITY_MPS2 = 9.81
_WORDS = {
    "drop": "nothing gets through",
    "delay": "100 ms late",
    "duplicate": "everything twice",
    "reorder": "pieces change places",
    "corrupt": "bits turn over, 1 byte in 50",
    "lose_byte": "1 byte in 50 is missing",
    "truncate": "only the first 4 bytes",
    "garbage": "random bytes",
    "stall": "held back, then all at once",
    "flag": "the failsafe flag",
    "lost_flag": "the frame-lost flag",
    "freeze": "channels frozen",
    "zeros": "channels at their lowest",
    "stuck": "its encoder stands still",
    "silent": "neither drives nor reports",
    "weak": "gives 30 % of its current",
    "slippery": "a fifth of the grip",
}
_FIGURES: dict[str, Values] = {
    "delay": {"ms": 100}, "truncate": {"keep": 4}, "weak": {"factor": 0.3}, "slippery": {"factor": 0.2},
}  # fmt: skip
_PUSHES = ((0.0, "along x"), (90.0, "along y"), (180.0, "against x"), (-90.0, "against y"))
_OF_ONE_ESC = ("esc", "stuck")


def known_faults(robot: Robot) -> list[tuple[str, Values]]:
    """What can be injected into a run of this robot: in words, and as a table without name and times."""
    found: list[tuple[str, Values]] = []
    for wire, kinds in KINDS.items():
        for kind in kinds:
            found += _variants(robot, wire, kind)
    return [(words, values) for words, values in found if _fits(robot, values)]


def fault_at(bench: Bench, values: Values, number: int, seconds: float) -> tuple[Fault, str]:
    """The fault from the bench's next tick on, the run's `number`-th by hand; and its table as text."""
    name = f"by hand {number}: {values['wire']} {values['kind']}"
    table = {"name": name, **values, "at_s": bench.now_tick / 1000, "for_s": seconds}
    return read_fault(Table(Path("by hand"), "fault", table)), table_text(table)


def table_text(values: Mapping[str, object]) -> str:
    """A `[[fault]]` table as TOML."""
    return toml_text({"fault": [values]})


def _variants(robot: Robot, wire: str, kind: str) -> list[tuple[str, Values]]:
    base: dict[str, str | int | float] = {"wire": wire, "kind": kind, **_FIGURES.get(kind, {})}
    if kind == "push":
        force_n = round(0.5 * robot.body.mass_kg * GRAVITY_MPS2, 1)
        pushes = [(f"plant push: {force_n:g} N {way}", bearing) for bearing, way in _PUSHES]
        return [(words, {**base, "force_n": force_n, "bearing_deg": bearing}) for words, bearing in pushes]
    words = f"{wire} {kind}: {_WORDS[kind]}"
    if wire in _OF_ONE_ESC or kind in _OF_ONE_ESC:
        wheels = enumerate(robot.wheels, 1)
        return [(f"{wire} {kind}, {wheel.name}: {_WORDS[kind]}", {**base, "esc": number}) for number, wheel in wheels]
    return [(words, base)]


def _fits(robot: Robot, values: Values) -> bool:
    """Whether this robot can have it: a protocol without a failsafe flag cannot carry one."""
    try:
        fault = read_fault(Table(Path("by hand"), "fault", {**values, "at_s": 0.0, "for_s": 1.0}))
        Injector((), robot, ("t_s",)).inject(fault)
    except (ValueError, ConfigError):
        return False
    return True
