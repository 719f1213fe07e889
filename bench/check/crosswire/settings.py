"""The `[checks]` table of a scenario: which checks of the wires run, and what they allow.

    [checks]
    motion = "off"                  # or "expected": the run fails where it finds nothing; "on" unless given

    [checks.rest_current]           # a table changes what is allowed
    current_a = 0.05
    state = "on"

Angles are degrees in the file and radians from here on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

from bench.config import Table, nearest

ON, OFF, EXPECTED = STATES = ("on", "off", "expected")


@dataclass(frozen=True, slots=True)
class MotionCheck:
    """How far two tellings of the same way may be apart after a second, beyond what slip explains."""

    state: str = ON
    length_m: float = 0.002
    """Whatever the way: encoder noise of a few hundred counts, a late frame at walking speed."""
    share: float = 0.01
    """Of the way and of the turn: what a radius is known to."""
    angle_rad: float = math.radians(0.5)


@dataclass(frozen=True, slots=True)
class RestCurrentCheck:
    """What may flow in a motor whose robot stands, is told to, and is not pushed."""

    state: str = ON
    current_a: float = 0.0
    """0: a quarter of what the motor's dry friction holds, by the robot's file (`rest.FRICTION_SHARE`)."""


@dataclass(frozen=True, slots=True)
class AnswersCheck:
    """How long a base may take to answer."""

    state: str = ON
    within_ms: int = 200
    """As long as our core waits; no vendor document has a figure."""


@dataclass(frozen=True, slots=True)
class BusCheck:
    """What the wires can carry."""

    state: str = ON
    rate_hz: int = 1000
    """The most that one identifier is sent: what a C610 and a DM3519 report and take."""
    bitrate: int = 1_000_000
    slamware_baud: int = 115_200


@dataclass(frozen=True, slots=True)
class Checks:
    """All four."""

    motion: MotionCheck = field(default_factory=MotionCheck)
    rest_current: RestCurrentCheck = field(default_factory=RestCurrentCheck)
    answers: AnswersCheck = field(default_factory=AnswersCheck)
    bus: BusCheck = field(default_factory=BusCheck)


def read_checks(data: Table) -> Checks:
    """The settings of a `[checks]` table. Raises ConfigError with file, key and the nearest valid one."""
    plain = Checks()
    settings = {one.name: _read(data, one.name, getattr(plain, one.name)) for one in fields(Checks)}
    data.refuse_rest()
    return Checks(**settings)


def _read(data: Table, name: str, plain: Any) -> Any:
    """One check: a word for its state, or a table of what it allows."""
    if not data.has(name):
        return plain
    if not isinstance(data.values[name], dict):
        return replace(plain, state=_state(data, name))
    table = data.table(name)
    values: dict[str, Any] = {}
    for one in fields(plain):
        value = getattr(plain, one.name)
        if one.name == "state":
            values["state"] = _state(table, "state")
        elif one.name.endswith("_rad"):
            key = one.name.removesuffix("_rad") + "_deg"
            values[one.name] = math.radians(_positive(table, key, math.degrees(value)))
        else:
            values[one.name] = _positive(table, one.name, value)
    table.refuse_rest()
    return replace(plain, **values)


def _state(table: Table, key: str) -> str:
    state: str = table.get(key, str, ON)
    if state not in STATES:
        raise table.fail(key, f"expected 'on', 'off', 'expected' or a table; got {state!r}{nearest(state, [*STATES])}")
    return state


def _positive(table: Table, key: str, plain: Any) -> Any:
    """A number more than 0; where the file is silent, what is allowed anyway."""
    if not table.has(key):
        return plain
    value = table.get(key, type(plain))
    if value <= 0:
        raise table.fail(key, f"expected more than 0, got {value}")
    return value
