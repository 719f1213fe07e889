"""Every value that crosses a border between two boxes. No behaviour lives here.

Units end the names. Frame: REP-103, x forward, y left, angles and yaw rate counter-clockwise positive, SI.
Inside the tick values are tuples or named tuples (a tuple costs 30 ns, a frozen dataclass 500 ns, and a tick makes
dozens); what leaves the tick for a screen or a file is a frozen dataclass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

TICK_US = 1000
"""One tick of the bench is one millisecond. Time is an integer number of ticks and is only ever passed in."""

CanFrame: TypeAlias = tuple[int, bytes]
"""A classic CAN data frame: 11-bit identifier, 0 to 8 data bytes."""


class BodyTwist(NamedTuple):
    """Velocity of the robot in its own frame: x forward, y left, omega counter-clockwise seen from above."""

    vx_mps: float
    vy_mps: float
    omega_radps: float


ZERO_TWIST = BodyTwist(0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """Where the robot stands in the field frame; the heading is wrapped to (-pi, pi]."""

    x_m: float
    y_m: float
    heading_rad: float


class RcFrame(NamedTuple):
    """One RC channels frame as it was on the wire. What it means for the robot is decided in `drive`."""

    offset: int
    """Bytes from the start of the stream to the first byte of the frame."""
    length: int
    channels: tuple[int, ...]
    """Raw wire values in wire order (uart12: its four sticks and two buttons)."""
    failsafe: bool = False
    frame_lost: bool = False
    digital: tuple[bool, ...] = ()
    """SBUS: channels 16 and 17, which are only on or off (its makers count from 1: ch17, ch18). Else empty."""


class RcNoise(NamedTuple):
    """Bytes that are no frame of the protocol: a count and the reason of the first refusal, never an exception."""

    offset: int
    length: int
    reason: str


class RcLinkStatistics(NamedTuple):
    """What the receiver says about the radio link (CRSF 0x14). Uplink quality 0 means: no link."""

    offset: int
    length: int
    uplink_quality_percent: int
    uplink_rssi_dbm: int
    uplink_snr_db: int


class RcOther(NamedTuple):
    """A valid frame that is neither channels nor an error: telemetry, a poll, a slave's answer."""

    offset: int
    length: int
    kind: str


RcEvent: TypeAlias = RcFrame | RcNoise | RcLinkStatistics | RcOther


class TickInput(NamedTuple):
    """All that may influence a tick from outside. If it is not here, it cannot change the run."""

    rc: bytes = b""
    """Bytes that the RC receiver delivered to the base during this tick."""
    core_twist: BodyTwist | None = None
    """What the built-in SLAMWARE core shall ask for from now on; None leaves it as it was."""
    slamware: bytes = b""
    """Bytes from a core outside of the bench (a recording's, say). Used where the world has no core of its own."""


StateRow: TypeAlias = tuple[float | int | str, ...]
"""One row of state.csv, in the order of `Bench.state_columns`."""


class TickOutput(NamedTuple):
    """What crossed each wire in one tick, and on every `STATE_PERIOD_TICKS`-th tick where the robot was."""

    tick: int
    rc: bytes
    core_to_base: bytes
    base_to_core: bytes
    can_commands: tuple[CanFrame, ...]
    """Frames that the base sent in this tick."""
    can_feedback: tuple[CanFrame, ...]
    """Frames that the ESCs sent in this tick, after the commands; they reach the base in the next one."""
    state: StateRow | None
    """Where the robot is, or None between two rows."""


STATE_PERIOD_TICKS = 10


FOREIGN_BASE = "foreign base"
"""In the place of what only our own base knows of itself: who drives, whether the link is alive to it."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """One instant of a bench, for people: SI units, radians, wheel order. Taken at screen rate, never per tick."""

    tick: int
    pose: Pose
    twist: BodyTwist
    odometry: Pose
    link: str
    link_reason: str
    link_age_ms: int | None
    armed: bool | None
    """None of a foreign base: only it knows."""
    why_disarmed: str
    driver: str
    field_centric: bool
    sticks: tuple[float, float, float]
    rc_frame: RcFrame | None
    rc_frames: int
    rc_noise_bytes: int
    wheel_names: tuple[str, ...]
    wheel_wanted_radps: tuple[float, ...]
    wheel_radps: tuple[float, ...]
    wheel_current_a: tuple[float, ...]
    current_limit_a: float
    core_alive: bool
    core_connected: bool
    core_twist: BodyTwist
    bus_findings: tuple[str, ...] = ()
    """Who is on the CAN bus that should not be, a sentence each, the newest last."""
    slip_radps: float | None = None
    """By how much the driven wheels contradict each other, or dead wheels; None where they cannot."""
    slip_limit_radps: float = 0.0
    """From there on the base is said to slip."""
    odometry_source: str = "driven wheels"
    heading_source: str = "driven wheels"
