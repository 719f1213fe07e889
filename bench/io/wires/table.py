"""What is told of the wires: plain values, as they were after a tick.

rc      the receiver's bytes: frames of the robot's protocol, and what is none
can     the motors' bus: a row an identifier, its load from the exact bits of its frames
core    the SLAMWARE control bus: a row a sub-command, requests and answers apart
"""

from __future__ import annotations

from typing import NamedTuple

RC, CAN, CORE = "rc", "can", "core"
ORDER = (RC, CAN, CORE)


class WireSum(NamedTuple):
    """A whole wire. Rates are a second's; `load` is the share of the wire's time, 1.0 is full."""

    wire: str
    about: str
    frames: int
    rate_hz: float
    load: float
    errors: int
    """Bytes (rc, core) that are no frame; on CAN, frames that no row had room for."""


class WireRow(NamedTuple):
    """All frames of one kind on one wire: an identifier, a sub-command, a kind of RC frame."""

    wire: str
    key: str
    name: str
    frames: int
    rate_hz: float
    load: float
    last_tick: int
    data: bytes
    said: str


class Logged(NamedTuple):
    """One frame."""

    tick: int
    wire: str
    key: str
    data: bytes
    said: str


class WireTable(NamedTuple):
    """Everything at one instant; `log` from old to new, only what the filter lets pass."""

    tick: int
    sums: tuple[WireSum, ...]
    rows: tuple[WireRow, ...]
    log: tuple[Logged, ...]
