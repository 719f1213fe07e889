"""What a screen asks of the wires and signals, and what it is told: plain values."""

from __future__ import annotations

from typing import NamedTuple

from bench.io.scope import ScopePicture, ScopeSettings
from bench.io.wires.table import WireTable


class Look(NamedTuple):
    """What somebody wants to see."""

    wires: bool = False
    filter: str = ""
    log: int = 0
    """How many of the newest frames, in words; without any, the rows have no words either."""
    scope: ScopeSettings | None = None
    columns: int = 0
    """How many columns of dots the scope has room for."""


class Seen(NamedTuple):
    """The answer; None for what was not asked for."""

    wires: WireTable | None = None
    scope: ScopePicture | None = None
    building: float | None = None
    """The share of an earlier instant that has been built again; it is not shown before all is there."""
