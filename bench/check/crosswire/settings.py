"""The `[checks]` table of a scenario: which checks of the wires run, and what they allow.

    [checks]
    odometry = "off"                # or "expected": the run fails where it finds nothing; "on" unless given

    [checks.rest_current]           # a table changes what is allowed
    current_a = 0.05
    state = "on"

Angles are degrees in the file and radians from here on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

from bench.config import Table, nearest

ON, OFF, EXPECTED = STATES = ("on", "off", "expected")


@dataclass(frozen=True, slots=True)
class OdometryCheck:
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

    odometry: OdometryCheck = field(default_factory=OdometryCheck)
    rest_current: RestCurrentCheck = field(default_factory=RestCurrentCheck)
    answers: AnswersCheck = field(default_factory=AnswersCheck)
    bus: BusCheck = field(default_factory=BusCheck)


def read_checks(data: Table) -> Checks:
    """The settings of a `[checks]` table. Raises ConfigError with file, key and the nearest valid one."""
    settings = {one.name: _read(data, one.name, one.default_factory()) for one in fields(Checks)}  # type: ignore[misc]
    data.refuse_rest()
    return Checks(**settings)


def _read(data: Table, name: str, default: Any) -> Any:
    kind = type(default)
    if not data.has(name):
        return default
    if not isinstance(data.values[name], dict):
        return kind(state=_state(data, name))
    table = data.table(name)
    values: dict[str, Any] = {}
    for one in fields(kind):
        if one.name == "state":
            values["state"] = _state(table, "state")
        elif one.name.endswith("_rad"):
            key = one.name.removesuffix("_rad") + "_deg"
            values[one.name] = math.radians(_positive(table, key, math.degrees(one.default)))
        else:
            values[one.name] = _positive(table, one.name, one.default)
    table.refuse_rest()
    return kind(**values)


def _state(table: Table, key: str) -> str:
    state: str = table.get(key, str, ON)
    if state not in STATES:
        raise table.fail(key, f"expected 'on', 'off', 'expected', or a table; got {state!r}{nearest(state, [*STATES])}")
    return state


def _positive(table: Table, key: str, default: Any) -> Any:
    value = table.get(key, type(default), default)
    if value <= 0 and key in table.known and value != default:
        raise table.fail(key, f"expected more than 0, got {value}")
    return value
