"""All that one picture of the dashboard shows, in one value. The picture is a function of it and of the size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from bench.arena import FIELD, Arena, Obstacle
from bench.check.expectations import Standing
from bench.config import Robot
from bench.io.link import Wires
from bench.io.look import Seen
from bench.io.scope import ScopeSettings
from bench.messages import Snapshot
from bench.screen.dialog import Shown as Dialog
from bench.screen.layout import DRIVE
from bench.screen.wire_lamps import WireLamp


@dataclass(frozen=True, slots=True)
class Pace:
    """How simulated time runs against the wall's; see `io.clock.Pacer`."""

    rate: float = 1.0
    speed: float | None = None
    late_ticks: int = 0
    slipped_ticks: int = 0
    paused: bool = False
    behind_ticks: int = 0
    """By how much the instant that is shown lies before the newest."""
    steps: bool = True
    """Whether it can be run tick by tick: simulated time can."""
    goes_back: bool = True
    """Whether earlier instants can be shown."""


@dataclass(frozen=True, slots=True)
class Hands:
    """What the person at the keys has set."""

    power_percent: int
    transmitter_on: bool | None
    """None where the robot takes no RC."""
    core_asks: bool | None
    """None where the core is a real one."""
    releases: bool = False
    """Whether the terminal tells when a key is let go."""
    arms: bool = True
    """Whether Enter works the switch that arms."""
    source: str = "keys"
    """What holds the sticks."""
    source_state: str = ""
    """How it is, where there is something to say."""
    pad: tuple[float, float, float] | None = None
    """The mouse's sticks are shown, and stand so: forward, left, counter-clockwise, -1 to 1."""
    curve: str = ""
    """What the transmitter's profile makes of a stick."""


@dataclass(frozen=True, slots=True)
class Replay:
    """A run that is shown and not driven. `verdict` is the golden's, empty where there is none."""

    title: str
    ticks: int
    verdict: str = ""
    summary: tuple[str, ...] = ()
    """What the run has to say of itself, once it has ended."""


@dataclass(frozen=True, slots=True)
class Menu:
    """What is being typed or chosen: a filter, a signal for the scope, its trigger."""

    kind: str
    text: str = ""
    choices: tuple[str, ...] = ()
    row: int = 0
    trace: int = 0
    """Which of the scope's traces the chosen signal is for."""


@dataclass(frozen=True, slots=True)
class Shown:
    """What the person looks at, and how."""

    page: str = DRIVE
    filter: str = ""
    held: bool = False
    menu: Menu | None = None
    scope: ScopeSettings | None = None


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
    saving: str = ""
    """How far the golden is that is being saved."""
    notice: str = ""
    shown: Shown = field(default_factory=Shown)
    seen: Seen = field(default_factory=Seen)
    """What was sampled of wires and signals, as far as the page shows it."""
    lamps: Sequence[Standing] = ()
    """How the expectations of a scenario stand."""
    agree: Sequence[WireLamp] = ()
    """What the wires say of each other; empty where they are not checked while they run."""
    agree_since_tick: int = 0
    """From where on they are checked: after a fork from there."""
    slips: Sequence[tuple[float, float]] = ()
    """Where the robot's wheels slid over the floor, of late."""
    help: bool = False
    zoom: bool = False
    dialog: Dialog | None = None
    """A list that is open over the panels."""
