"""All that one picture of the dashboard shows, in one value. The picture is a function of it and of the size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.arena import FIELD, Arena, Obstacle
from bench.config import Robot
from bench.io.link import Wires
from bench.messages import Snapshot


@dataclass(frozen=True, slots=True)
class Pace:
    """How simulated time runs against the wall's; see `io.clock.Pacer`."""

    rate: float = 1.0
    speed: float | None = None
    late_ticks: int = 0
    slipped_ticks: int = 0
    paused: bool = False


@dataclass(frozen=True, slots=True)
class Hands:
    """What the person at the keys has set."""

    power_percent: int
    transmitter_on: bool | None
    """None where the robot takes no RC."""
    core_asks: bool


@dataclass(frozen=True, slots=True)
class Replay:
    """A run that is shown and not driven. `verdict` is the golden's, empty where there is none."""

    title: str
    ticks: int
    verdict: str = ""
    summary: tuple[str, ...] = ()
    """What the run has to say of itself, once it has ended."""


@dataclass(frozen=True, slots=True)
class Scene:
    """One picture. Either `hands` or `replay` is there."""

    robot: Robot
    snapshot: Snapshot
    wires: Wires
    trail: Sequence[tuple[float, float]]
    pace: Pace
    arena: Arena = FIELD
    discs: Sequence[Obstacle] = ()
    """Where the arena's discs are now."""
    hands: Hands | None = None
    replay: Replay | None = None
    recording: str = ""
    notice: str = ""
    help: bool = False
    zoom: bool = False
