"""What a robot and a transmitter are: frozen values, SI units and radians. Checked by `checks`, trusted elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from bench.fittings import Fittings

PROTOCOLS = ("uart12", "sbus", "dbus", "ibus", "crsf")
MOTOR_GEARS = {"c610": 36.0, "dm3519": 3591 / 187}
"""Of the motor that is sold with it: the M2006 of a C610, and the DM3519 by its maker's count of teeth."""
MOTOR_KINDS = tuple(MOTOR_GEARS)
ON_COMMAND_LOSS = {"c610": ("hold", "zero"), "dm3519": ("hold", "zero", "fault")}
DM3519_CHOICES = {"feedback": ("temperatures", "error"), "clear_error": ("long", "short")}
SPEED_LOOP, EXACT = "speed-loop", "exact"
# What is called "-as-printed" is a fault of a source document, to be chosen on purpose. docs/errata.md.
CONTROL_KINDS = (
    SPEED_LOOP,
    "current-as-printed",
    "inverse-004-as-printed",
    "document-001-three-as-printed",
    "document-001-three-detailed-as-printed",
    "document-001-four-as-printed",
    "document-001-mecanum-as-printed",
)
ODOMETRY_FORMS = (
    EXACT,
    "forward-004-as-printed",
    "document-000-a-as-printed",
    "document-000-a-text-as-printed",
    "document-000-b-as-printed",
    "document-002-as-printed",
)
SLAMWARE_CHOICES = {
    "dialect": ("firmware-2018", "firmware-2018-omni", "firmware-2015", "sdk-2020"),
    "behaviour": ("strict", "as_reference_firmware"),
    "polls": ("velocity", "full"),
}


@dataclass(frozen=True, slots=True)
class Wheel:
    """One wheel, driven or passive, by the wheel equation of docs/robots.md: where it stands, which way it pushes.

    `heading_rad` is the direction in which the wheel pushes the chassis when it turns positively; `roller_rad` the
    counter-clockwise angle from there to the axis of the roller on the ground (0 omni, +-pi/4 mecanum). `direction` is
    +1 or -1: the sign of the motor's wire (current, speed, angle) against the wheel's positive turn. A passive wheel
    has no motor: what answers on `can_id` is the encoder on its axle, `gear` turns of it for one of the wheel.
    """

    name: str
    x_m: float
    y_m: float
    heading_rad: float
    radius_m: float
    can_id: int
    direction: int = 1
    roller_rad: float = 0.0
    gear: float = 36.0
    """A robot file without one has its motor's, of `MOTOR_GEARS`."""


@dataclass(frozen=True, slots=True)
class Gyro:
    """A yaw-rate sensor that sums its own heading. Without noise and bias it tells the truth. docs/gyro.md."""

    can_id: int
    """1 to 8: the sensor's number, which its frame's identifier is made of."""
    rate_noise_radps: float = 0.0
    """Standard deviation of each sample of the rate, a sample a millisecond."""
    bias_radps: float = 0.0
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Body:
    """The rigid body: a disc in the plane, its centre of gravity above the origin of the wheels."""

    mass_kg: float
    inertia_kgm2: float
    radius_m: float
    cog_height_m: float


@dataclass(frozen=True, slots=True)
class Ground:
    """Friction of the wheels on the floor: Coulomb along the roller axis, rolling loss across it."""

    grip: float
    rolling: float


@dataclass(frozen=True, slots=True)
class Motor:
    """Motor, gear and speed controller; torques, speeds and inertia as seen at the wheel (output shaft)."""

    kind: str
    torque_nm_per_a: float
    coulomb_nm: float
    viscous_nms: float
    inertia_kgm2: float
    resistance_ohm: float
    back_emf_vs: float
    supply_v: float
    max_current_a: float
    load_friction: float = 0.0
    current_lag_ms: float = 1.0
    speed_filter_ms: float = 10.0
    on_command_loss: str = "hold"
    command_timeout_ms: int = 100


@dataclass(frozen=True, slots=True)
class Dm3519:
    """Which of the contradicting sources a robot's DM3519 motors follow. docs/dm3519.md."""

    full_scale_a: float = 20.0
    """What 16384 counts of current stand for: 20 or 20.5 A."""
    feedback: str = "temperatures"
    clear_error: str = "long"


@dataclass(frozen=True, slots=True)
class Limits:
    """What the controller may ask for. Currents are clamped at the last line before the port."""

    current_a: float
    linear_mps: float
    angular_radps: float
    wheel_radps: float
    linear_acceleration_mps2: float
    angular_acceleration_radps2: float
    slip_radps: float = 0.5
    """Above this slip residual a redundant base is said to slip. docs/odometry.md."""


@dataclass(frozen=True, slots=True)
class Control:
    """Gains of the per-wheel speed loop: amperes per rad/s, amperes per rad; feed-forward from the motor's friction."""

    kp_a_per_radps: float
    ki_a_per_rad: float
    feed_forward: bool = True
    keep_direction: bool = False
    """Where the current limit lets one wheel fall behind, the others slow down with it."""
    kind: str = SPEED_LOOP
    """What turns a twist into currents: one of CONTROL_KINDS."""


@dataclass(frozen=True, slots=True)
class LinkLimits:
    """After how much silence what happens. docs/links.md draws the states."""

    hold_ms: int = 100
    disarm_ms: int = 500
    handover_ms: int = 500
    core_timeout_ms: int = 1000
    feedback_timeout_ms: int = 20


@dataclass(frozen=True, slots=True)
class SlamwareSettings:
    """What the base says of itself on the SLAMWARE control bus, and what the built-in core polls. docs/slamware.md."""

    model: str = "wheelbench"
    firmware_version: int = 0x0001
    hardware_version: int = 1
    serial_number: str = "000000000000000000000000"
    firmware_suffix: str = ""
    dialect: str = "firmware-2018"
    behaviour: str = "strict"
    binary_configuration: str = ""
    """Hexadecimal digits of the vendor's configuration tool, to answer 0x21 with; empty: made from the robot file."""
    poll_ms: int = 50
    polls: str = "velocity"


@dataclass(frozen=True, slots=True)
class Axis:
    """One stick: (raw - middle) / travel, reversed where raw below the middle means forward, right or clockwise."""

    channel: int
    middle: int
    travel: float
    reversed: bool = False


@dataclass(frozen=True, slots=True)
class Button:
    """One switch: pressed while raw is at least `pressed_from` (or at most, where `reversed`)."""

    channel: int
    pressed_from: int
    reversed: bool = False

    def is_pressed(self, channels: Sequence[int]) -> bool:
        """Whether raw channels say so; what has no such channel does not."""
        if self.channel >= len(channels):
            return False
        raw = channels[self.channel]
        return raw <= self.pressed_from if self.reversed else raw >= self.pressed_from


@dataclass(frozen=True, slots=True)
class Profile:
    """A transmitter: which protocol it speaks, which channel is what, and how it arms."""

    name: str
    protocol: str
    forward: Axis
    right: Axis
    clockwise: Axis
    aux1: Button | None = None
    aux2: Button | None = None
    about: str = ""
    period_ms: int = 10
    dead_band: float = 0.05
    expo: float = 0.0
    frozen_ms: int = 0
    max_travel: float = 0.0
    arming: str = "switch"
    file: Path | None = None


@dataclass(frozen=True, slots=True)
class Robot:
    """Everything that the bench knows about one base. Wheel order is the file's order."""

    name: str
    about: str
    wheels: tuple[Wheel, ...]
    body: Body
    ground: Ground
    motor: Motor
    limits: Limits
    control: Control
    link: LinkLimits = field(default_factory=LinkLimits)
    slamware: SlamwareSettings = field(default_factory=SlamwareSettings)
    dm3519: Dm3519 | None = None
    """Set where the motors are of this kind, and only there."""
    fittings: Fittings = field(default_factory=Fittings)
    dead_wheels: tuple[Wheel, ...] = ()
    """Passive wheels with an encoder each: they turn with the ground, carry nothing and drive nothing."""
    gyro: Gyro | None = None
    odometry: str = EXACT
    """How increments become a pose: one of ODOMETRY_FORMS."""
    rc: Profile | None = None
    source: str = ""
    assumed: tuple[str, ...] = ()
    file: Path | None = None

    @property
    def follows_dead_wheels(self) -> bool:
        """Whether its dead wheels are enough to tell every motion in the plane."""
        return len(self.dead_wheels) >= 3

    @property
    def sees_slip(self) -> bool:
        """Whether a driven wheel that slips contradicts something: a fourth wheel, or dead wheels."""
        return len(self.wheels) > 3 or self.follows_dead_wheels
