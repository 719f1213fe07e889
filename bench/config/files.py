"""Where robots and profiles lie, and how their tables become values. Degrees end here."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from bench.config.checks import check_profile, check_robot
from bench.config.named import named_file, names_in
from bench.config.table import ConfigError, Table, nearest, read_toml
from bench.config.values import (
    CONTROL_KINDS,
    MOTOR_GEARS,
    ODOMETRY_FORMS,
    Axis,
    Body,
    Button,
    Control,
    Dm3519,
    Ground,
    Gyro,
    Limits,
    LinkLimits,
    Motor,
    Profile,
    Robot,
    SlamwareSettings,
    Wheel,
)
from bench.fittings import read_fittings

ROBOTS_DIR = Path(__file__).parents[1] / "robots"
PROFILES_DIR = Path(__file__).parents[1] / "profiles"
MOST_WHEELS = 8
"""Ids of ESCs on one bus: 0x201 to 0x208 report."""


def robot_names() -> list[str]:
    """Names of the robots that come with wheelbench."""
    return names_in(ROBOTS_DIR)


def profile_names() -> list[str]:
    """Names of the transmitter profiles that come with wheelbench."""
    return names_in(PROFILES_DIR)


def robot_path(name_or_path: str | Path) -> Path:
    """The file of a robot, given as a name that `wheelbench robots` lists or as a path. Raises ConfigError."""
    return named_file(name_or_path, ROBOTS_DIR, "robot")


def profile_path(name_or_path: str | Path) -> Path:
    """The file of a transmitter profile, given by name or by path. Raises ConfigError."""
    return named_file(name_or_path, PROFILES_DIR, "profile")


def load_robot(name_or_path: str | Path, profile: str | Path | None = None) -> Robot:
    """Read and check a robot file; a profile given here takes the place of the file's own.

    Raises ConfigError with file, key and what to try.
    """
    path = robot_path(name_or_path)
    data = Table(path, "", read_toml(path))
    data.take_schema()
    motor = data.table("motor").into(Motor)
    entries = data.tables("wheel")
    if len(entries) > MOST_WHEELS:
        raise data.fail("wheel", f"a CAN bus has the ids 1 to {MOST_WHEELS}, got {len(entries)} wheels")
    # A kind that nobody knows is told by the checks, which see the whole robot.
    gear = MOTOR_GEARS.get(motor.kind, 1.0)
    wheels = tuple(_read_wheel(entry, gear) for entry in entries)
    body = data.table("body").into(Body)
    rc = data.get("rc", str, None)
    if profile is None and rc is not None:
        try:
            profile = profile_path(_beside(path, rc))
            if not profile.exists():
                raise ConfigError(f"{profile}: there is no such file; it is looked for beside the robot's")
        except ConfigError as error:
            raise data.fail("rc", str(error)) from None
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
        dead_wheels=tuple(_read_dead_wheel(entry) for entry in data.tables("dead_wheel", optional=True)),
        gyro=_read_gyro(data.table("gyro")) if data.has("gyro") else None,
        odometry=data.get("odometry", str, "exact"),
        rc=load_profile(profile) if profile is not None else None,
        source=data.get("source", str, ""),
        assumed=tuple(data.get("assumed", list, [])),
        file=path,
    )
    data.refuse_rest()
    check_robot(path, robot)
    return robot


def with_choices(robot: Robot, controller: str | None = None, odometry: str | None = None) -> Robot:
    """The robot with another controller or odometry than its file's. Raises ConfigError with the nearest name."""
    if controller is not None:
        if controller not in CONTROL_KINDS:
            raise ConfigError(f"no controller is called {controller!r}{nearest(controller, list(CONTROL_KINDS))}")
        robot = replace(robot, control=replace(robot.control, kind=controller))
    if odometry is not None:
        if odometry not in ODOMETRY_FORMS:
            raise ConfigError(f"no odometry is called {odometry!r}{nearest(odometry, list(ODOMETRY_FORMS))}")
        robot = replace(robot, odometry=odometry)
    return robot


def load_profile(name_or_path: str | Path) -> Profile:
    """Read and check a transmitter profile. Raises ConfigError with file, key and what to try."""
    path = profile_path(name_or_path)
    data = Table(path, "", read_toml(path))
    data.take_schema()
    sticks = {name: data.table(name).into(Axis) for name in ("forward", "right", "clockwise")}
    buttons = {name: data.table(name).into(Button) for name in ("aux1", "aux2") if data.has(name)}
    profile = data.into(Profile, **sticks, **buttons, file=path)
    check_profile(path, profile)
    return profile


def _beside(path: Path, name: str) -> str | Path:
    """A profile that a robot file names: one of ours, or a file next to the robot's."""
    return path.parent / name if name.endswith(".toml") else name


def _read_dm3519(data: Table, motor: Motor) -> Dm3519 | None:
    is_given = data.has("dm3519")
    if motor.kind != "dm3519":
        if is_given:
            raise data.fail("dm3519", f"this table is for motor.kind = 'dm3519'; the file has {motor.kind!r}")
        return None
    return data.table("dm3519", optional=True).into(Dm3519)


def _read_wheel(entry: Table, usual_gear: float) -> Wheel:
    """A driven wheel: where it stands, its motor's wire, its rollers and its gear."""
    return _read_any_wheel(
        entry,
        roller_rad=math.radians(entry.get("roller_deg", float, 0.0)),
        gear=entry.get("gear", float, usual_gear),
    )


def _read_dead_wheel(entry: Table) -> Wheel:
    """A passive omni wheel with an encoder on its axle; `gear` where the encoder turns faster than the wheel."""
    return _read_any_wheel(entry, roller_rad=0.0, gear=entry.get("gear", float, 1.0))


def _read_any_wheel(entry: Table, *, roller_rad: float, gear: float) -> Wheel:
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
        roller_rad=roller_rad,
        gear=gear,
    )
    entry.refuse_rest()
    return wheel


def _read_gyro(table: Table) -> Gyro:
    gyro = Gyro(
        can_id=table.get("can_id", int),
        rate_noise_radps=math.radians(table.get("rate_noise_degps", float, 0.0)),
        bias_radps=math.radians(table.get("bias_degps", float, 0.0)),
        seed=table.get("seed", int, 0),
    )
    table.refuse_rest()
    return gyro
