"""Robots and transmitters as data: TOML files in, validated frozen values out.

Every geometry, limit, gain and timeout of the bench is a named number in a robot file (`bench/robots/*.toml`, or the
user's own); every transmitter is a profile (`bench/profiles/*.toml`, or the user's own). A file that cannot be right is
refused here, with one sentence that names file, key and the nearest valid choice, so that nothing behind this door has
to check again. Degrees exist only in the files; from here on angles are radians.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

from bench.errors import UsageError
from bench.fittings import Fittings, read_fittings

HERE = Path(__file__).parent
ROBOTS_DIR = HERE / "robots"
PROFILES_DIR = HERE / "profiles"
PROTOCOLS = ("uart12", "sbus", "dbus", "ibus", "crsf")
MOTOR_KINDS = ("c610", "dm3519")
ON_COMMAND_LOSS = {"c610": ("hold", "zero"), "dm3519": ("hold", "zero", "fault")}
DM3519_CHOICES = {"feedback": ("temperatures", "error"), "clear_error": ("long", "short")}
SLAMWARE_CHOICES = {
    "dialect": ("firmware-2018", "firmware-2018-omni", "firmware-2015", "sdk-2020"),
    "behaviour": ("strict", "as_reference_firmware"),
    "polls": ("velocity", "full"),
}

MOST_BINARY_CONFIGURATION_BYTES = 1019
"""In a long frame that a core's buffer of 1024 bytes takes."""


class ConfigError(UsageError):
    """A robot, profile or scenario file that cannot be right. The text is one sentence for the user."""


# --- what a robot is ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Wheel:
    """One driven wheel, by the wheel equation of docs/kinematics: where it stands and which way it pushes.

    `heading_rad` is the direction in which the wheel pushes the chassis when it turns positively; `roller_rad` the
    counter-clockwise angle from there to the axis of the roller on the ground (0 omni, +-pi/4 mecanum). `direction` is
    +1 or -1: the sign of the motor's wire (current, speed, angle) against the wheel's positive turn.
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


@dataclass(frozen=True, slots=True)
class Control:
    """Gains of the per-wheel speed loop: amperes per rad/s, amperes per rad; feed-forward from the motor's friction."""

    kp_a_per_radps: float
    ki_a_per_rad: float
    feed_forward: bool = True


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


# --- what a transmitter is ---------------------------------------------------------------------------------------


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
    rc: Profile | None = None
    source: str = ""
    assumed: tuple[str, ...] = ()
    file: Path | None = None


# --- reading -----------------------------------------------------------------------------------------------------


def robot_names() -> list[str]:
    """Names of the robots that come with wheelbench."""
    return sorted(path.stem for path in ROBOTS_DIR.glob("*.toml"))


def profile_names() -> list[str]:
    """Names of the transmitter profiles that come with wheelbench."""
    return sorted(path.stem for path in PROFILES_DIR.glob("*.toml"))


def robot_path(name_or_path: str | Path) -> Path:
    """The file of a robot, given as a name that `wheelbench robots` lists or as a path. Raises ConfigError."""
    return _find(name_or_path, ROBOTS_DIR, robot_names(), "robot")


def profile_path(name_or_path: str | Path) -> Path:
    """The file of a transmitter profile, given by name or by path. Raises ConfigError."""
    return _find(name_or_path, PROFILES_DIR, profile_names(), "profile")


def load_robot(name_or_path: str | Path, profile: str | Path | None = None) -> Robot:
    """Read and check a robot file; a profile given here takes the place of the file's own.

    Raises ConfigError with file, key and what to try.
    """
    path = robot_path(name_or_path)
    data = Table(path, "", read_toml(path))
    data.take_schema()
    motor = data.table("motor").into(Motor)
    wheels = tuple(_read_wheel(entry) for entry in data.tables("wheel"))
    body = data.table("body").into(Body)
    rc = data.get("rc", str, None)
    if profile is None and rc is not None:
        profile = _beside(path, rc)
    robot = Robot(
        name=data.get("name", str),
        about=data.get("about", str),
        wheels=wheels,
        body=body,
        ground=data.table("ground").into(Ground),
        motor=motor,
        limits=data.table("limits").into(Limits),
        control=data.table("control").into(Control),
        link=data.table("link", optional=True).into(LinkLimits),
        slamware=data.table("slamware", optional=True).into(SlamwareSettings),
        dm3519=_read_dm3519(data, motor),
        fittings=read_fittings(data, body.radius_m),
        rc=load_profile(profile) if profile is not None else None,
        source=data.get("source", str, ""),
        assumed=tuple(data.get("assumed", list, [])),
        file=path,
    )
    data.refuse_rest()
    _check_robot(path, robot)
    return robot


def load_profile(name_or_path: str | Path) -> Profile:
    """Read and check a transmitter profile. Raises ConfigError with file, key and what to try."""
    path = profile_path(name_or_path)
    data = Table(path, "", read_toml(path))
    data.take_schema()
    sticks = {name: data.table(name).into(Axis) for name in ("forward", "right", "clockwise")}
    buttons = {name: data.table(name).into(Button) for name in ("aux1", "aux2") if data.has(name)}
    profile = data.into(Profile, **sticks, **buttons, file=path)
    _check_profile(path, profile)
    return profile


def read_toml(path: Path) -> dict[str, Any]:
    """The file's tables. Raises ConfigError where it cannot be read or is not TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not a text file; a TOML file is expected") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from None


def nearest(word: str, choices: list[str]) -> str:
    """'; did you mean X?' or '; known: A, B, C', to end an error sentence with."""
    close = difflib.get_close_matches(word, choices, n=1)
    return f"; did you mean {close[0]}?" if close else f"; known: {', '.join(choices)}"


_T = TypeVar("_T")
_KIND_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false", list: "a list"}


class Table:
    """One TOML table with its address, so that every refusal says which file and which key."""

    def __init__(self, path: Path, where: str, values: Mapping[str, Any]) -> None:
        self.path = path
        self.where = where
        self.values = dict(values)
        self.known: list[str] = []

    def key(self, name: str) -> str:
        """The key's full address in the file."""
        return f"{self.where}.{name}" if self.where else name

    def fail(self, name: str, what: str) -> ConfigError:
        """The error for one key of this table."""
        return ConfigError(f"{self.path}: {self.key(name)}: {what}")

    def has(self, name: str) -> bool:
        """Whether the file gives this key, which is a known one from now on."""
        self.known.append(name)
        return name in self.values

    def take_schema(self) -> None:
        """Refuse a file of another schema."""
        schema = self.get("schema", int, 1)
        if schema != 1:
            raise self.fail("schema", f"expected 1, got {schema}; this file is for another version of wheelbench")

    def get(self, name: str, kind: type, default: Any = MISSING) -> Any:
        """Take one value out of the table, checked for its kind."""
        self.known.append(name)
        if name not in self.values:
            if default is MISSING:
                unknown = [key for key in self.values if difflib.get_close_matches(key, [name])]
                hint = f"; is {unknown[0]} meant to be it?" if unknown else ""
                raise self.fail(name, f"is missing{hint}")
            return default
        value = self.values.pop(name)
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            raise self.fail(name, f"expected {_KIND_NAMES[kind]}, got {value!r}")
        if isinstance(value, float) and not math.isfinite(value):
            raise self.fail(name, f"expected a finite number, got {value}")
        return value

    def table(self, name: str, *, optional: bool = False) -> Table:
        """Take a table out of this one."""
        self.known.append(name)
        value = self.values.pop(name, {} if optional else None)
        if value is None:
            raise self.fail(name, f"the table [{self.key(name)}] is missing")
        if not isinstance(value, dict):
            raise self.fail(name, f"expected a table [{self.key(name)}], got {value!r}")
        return Table(self.path, self.key(name), value)

    def tables(self, name: str, *, optional: bool = False) -> list[Table]:
        """Take an array of tables, at least one long unless `optional`."""
        self.known.append(name)
        value = self.values.pop(name, [] if optional else None)
        if not isinstance(value, list) or not (value or optional) or not all(isinstance(e, dict) for e in value):
            raise self.fail(name, f"expected at least one table [[{self.key(name)}]]")
        return [Table(self.path, f"{self.key(name)}[{i}]", entry) for i, entry in enumerate(value)]

    def into(self, cls: type[_T], **ready: Any) -> _T:
        """Fill a dataclass from this table; keys that it does not have are errors."""
        values = dict(ready)
        for item in fields(cls):  # type: ignore[arg-type]
            if item.name in ready or str(item.type).endswith("| None"):
                continue
            kind = {"str": str, "int": int, "float": float, "bool": bool}[str(item.type)]
            values[item.name] = self.get(item.name, kind, item.default)
        self.refuse_rest()
        return cls(**values)

    def refuse_rest(self) -> None:
        """Raise ConfigError where the file has a key that nobody asked for."""
        for name in self.values:
            if name not in self.known:
                raise self.fail(name, f"unknown key{nearest(name, sorted(set(self.known)))}")


def _find(name_or_path: str | Path, folder: Path, names: list[str], what: str) -> Path:
    text = str(name_or_path)
    if text in names:
        return folder / f"{text}.toml"
    path = Path(name_or_path)
    if path.is_dir():
        raise ConfigError(f"{path}: is a directory; a {what} is a .toml file, or one of: {', '.join(names)}")
    if path.suffix == ".toml" or path.exists():
        return path
    raise ConfigError(f"no {what} is called {text!r}{nearest(text, names)} (or give the path of a .toml file)")


def _beside(path: Path, name: str) -> str | Path:
    """A profile that a robot file names: one of ours, or a file next to the robot's."""
    return path.parent / name if name.endswith(".toml") else name


def _read_dm3519(data: Table, motor: Motor) -> Dm3519 | None:
    is_given = data.has("dm3519")
    if motor.kind != "dm3519":
        if is_given:
            raise data.fail("dm3519", f"this table is for motor.kind = 'dm3519'; the file has {motor.kind!r}")
        return None
    table = data.table("dm3519", optional=True)
    chosen = table.into(Dm3519)
    if not 20.0 <= chosen.full_scale_a <= 20.5:
        raise table.fail("full_scale_a", f"expected 20 to 20.5 A, got {chosen.full_scale_a}")
    for key, choices in DM3519_CHOICES.items():
        value = getattr(chosen, key)
        if value not in choices:
            raise table.fail(key, f"{value!r} is unknown{nearest(value, list(choices))}")
    if motor.max_current_a > chosen.full_scale_a:
        raise data.fail("motor.max_current_a", f"{motor.max_current_a} A is above dm3519.full_scale_a")
    return chosen


def _read_wheel(entry: Table) -> Wheel:
    """A wheel by (x_m, y_m, heading_deg) or, standing tangentially, by (bearing_deg, distance_m)."""
    if entry.has("bearing_deg"):
        bearing_rad = math.radians(entry.get("bearing_deg", float))
        distance_m = entry.get("distance_m", float)
        x_m, y_m = distance_m * math.cos(bearing_rad), distance_m * math.sin(bearing_rad)
        # The counter-clockwise tangent, unless the file says otherwise.
        heading_rad = math.radians(entry.get("heading_deg", float, math.degrees(bearing_rad) + 90.0))
    else:
        x_m, y_m = entry.get("x_m", float), entry.get("y_m", float)
        heading_rad = math.radians(entry.get("heading_deg", float))
    wheel = Wheel(
        name=entry.get("name", str),
        x_m=x_m,
        y_m=y_m,
        heading_rad=heading_rad,
        radius_m=entry.get("radius_m", float),
        can_id=entry.get("can_id", int),
        direction=entry.get("direction", int, 1),
        roller_rad=math.radians(entry.get("roller_deg", float, 0.0)),
        gear=entry.get("gear", float, 36.0),
    )
    entry.refuse_rest()
    if wheel.direction not in (1, -1):
        raise entry.fail("direction", f"expected 1 or -1, got {wheel.direction}")
    if not 1 <= wheel.can_id <= 8:
        raise entry.fail("can_id", f"expected 1 to 8 as printed on the ESC, got {wheel.can_id}")
    if wheel.radius_m <= 0.0:
        raise entry.fail("radius_m", f"expected a positive number, got {wheel.radius_m}")
    if wheel.gear <= 0.0:
        raise entry.fail("gear", f"expected a positive number, got {wheel.gear}")
    if abs(math.cos(wheel.roller_rad)) < 1e-3:
        raise entry.fail("roller_deg", "a roller axis across the wheel cannot drive; expected less than 90 degrees")
    return wheel


_MAY_BE_ZERO = {"rolling", "coulomb_nm", "load_friction", "current_lag_ms", "speed_filter_ms", "ki_a_per_rad"}
_MAY_BE_ZERO |= {"firmware_version", "hardware_version"}


def _check_robot(path: Path, robot: Robot) -> None:
    # Imported here: kinematics builds on this module, and only a whole robot can be singular.
    from bench.kinematics import Kinematics
    from bench.loads import load_rows
    from bench.slamware.payloads import Identity, identity_answer

    def fail(key: str, what: str) -> ConfigError:
        return ConfigError(f"{path}: {key}: {what}")

    for table in ("body", "ground", "motor", "limits", "control", "link", "slamware"):
        part = getattr(robot, table)
        for item in fields(part):
            value = getattr(part, item.name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if value < 0 or (value == 0 and item.name not in _MAY_BE_ZERO):
                raise fail(f"{table}.{item.name}", f"expected a positive number, got {value}")
    if len(robot.wheels) < 3:
        raise fail("wheel", f"an omni base needs at least three wheels, got {len(robot.wheels)}")
    for key in ("can_id", "name"):
        seen = [getattr(wheel, key) for wheel in robot.wheels]
        twice = [value for value in seen if seen.count(value) > 1]
        if twice:
            raise fail(f"wheel.{key}", f"{twice[0]!r} is given to more than one wheel")
    if robot.motor.kind not in MOTOR_KINDS:
        raise fail("motor.kind", f"{robot.motor.kind!r} is unknown{nearest(robot.motor.kind, list(MOTOR_KINDS))}")
    reactions = ON_COMMAND_LOSS[robot.motor.kind]
    if robot.motor.on_command_loss not in reactions:
        known = " or ".join(map(repr, reactions))
        raise fail("motor.on_command_loss", f"expected {known}, got {robot.motor.on_command_loss!r}")
    if robot.motor.load_friction >= 1.0:
        raise fail("motor.load_friction", f"expected less than 1, got {robot.motor.load_friction}")
    if robot.limits.current_a > robot.motor.max_current_a:
        raise fail("limits.current_a", f"{robot.limits.current_a} A is above motor.max_current_a")
    if robot.link.hold_ms >= robot.link.disarm_ms:
        raise fail("link.hold_ms", f"{robot.link.hold_ms} ms must be less than link.disarm_ms")
    try:
        Kinematics(robot.wheels)
        load_rows(robot.wheels, robot.body.mass_kg, robot.body.cog_height_m)
    except ValueError as error:
        raise fail("wheel", str(error)) from None
    said = robot.slamware
    for key, choices in SLAMWARE_CHOICES.items():
        chosen = getattr(said, key)
        if chosen not in choices:
            raise fail(f"slamware.{key}", f"{chosen!r} is unknown{nearest(chosen, list(choices))}")
    try:
        identity = Identity(
            said.model, said.firmware_version, said.hardware_version, said.serial_number, said.firmware_suffix
        )
        identity_answer(identity)
    except ValueError as error:
        raise fail("slamware", str(error)) from None
    try:
        blob = bytes.fromhex(said.binary_configuration)
    except ValueError:
        raise fail("slamware.binary_configuration", "expected pairs of hexadecimal digits") from None
    if len(blob) > MOST_BINARY_CONFIGURATION_BYTES:
        most = MOST_BINARY_CONFIGURATION_BYTES
        raise fail("slamware.binary_configuration", f"expected at most {most} bytes, got {len(blob)}")


def _check_profile(path: Path, profile: Profile) -> None:
    def fail(key: str, what: str) -> ConfigError:
        return ConfigError(f"{path}: {key}: {what}")

    if profile.protocol not in PROTOCOLS:
        raise fail("protocol", f"{profile.protocol!r} is unknown{nearest(profile.protocol, list(PROTOCOLS))}")
    if profile.arming not in ("switch", "on_link"):
        raise fail("arming", f"expected 'switch' or 'on_link', got {profile.arming!r}")
    if profile.arming == "switch" and profile.aux1 is None:
        raise fail("aux1", "the table [aux1] is missing; arming = 'switch' needs a switch to arm with")
    if not 0.0 <= profile.dead_band < 1.0:
        raise fail("dead_band", f"expected 0 to less than 1, got {profile.dead_band}")
    if not 0.0 <= profile.expo <= 1.0:
        raise fail("expo", f"expected 0 to 1, got {profile.expo}")
    if profile.period_ms < 1:
        raise fail("period_ms", f"expected at least 1, got {profile.period_ms}")
    if profile.max_travel and profile.max_travel <= 1.0:
        raise fail("max_travel", f"expected 0 (off) or more than 1 (full travel), got {profile.max_travel}")
    if profile.frozen_ms < 0:
        raise fail("frozen_ms", f"expected 0 (off) or more, got {profile.frozen_ms}")
    for name in ("forward", "right", "clockwise"):
        if getattr(profile, name).travel <= 0:
            raise fail(f"{name}.travel", "expected a positive number; use reversed = true to turn a stick round")
    # Imported here: the codecs build on this module's neighbours, and only a whole profile names channels.
    from bench.rc_decode import channel_limits

    last = len(channel_limits(profile.protocol)) - 1
    for name in ("forward", "right", "clockwise", "aux1", "aux2"):
        part = getattr(profile, name)
        if part is not None and not 0 <= part.channel <= last:
            raise fail(f"{name}.channel", f"{profile.protocol} has channels 0 to {last}, got {part.channel}")
