"""What no value shows by itself: whether a whole robot, or a whole profile, can be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from bench.config.table import ConfigError, nearest
from bench.config.values import (
    CONTROL_KINDS,
    DM3519_CHOICES,
    MOTOR_KINDS,
    ODOMETRY_FORMS,
    ON_COMMAND_LOSS,
    PROTOCOLS,
    SLAMWARE_CHOICES,
    Axis,
    Motor,
    Profile,
    Robot,
    Wheel,
)
from bench.messages import TICK_US

MOST_ROTOR_RPM = 30_000
"""Half a turn between two reports, which come once a millisecond."""
DOES_NOT_SAY = "its angle, told once a millisecond, does not say which way it turned"
MOST_C610_A = 10.0
"""Of a command frame, which counts milliamperes from -10,000 to 10,000 (docs/c610.md)."""
MOST_BINARY_CONFIGURATION_BYTES = 1019
"""In a long frame that a core's buffer of 1024 bytes takes."""

MOST_BODIES = 10
"""Radii of its body that a wheel may be large, or away: beyond it somebody has written millimetres or inches."""
MOST_REFLECTED = 200.0
"""Times its own mass, or inertia, that a body's wheels may weigh on it: 12 is the most of ours (dm3519, turning). Far
beyond, the search for what each wheel does ends before it is exact: a step was wrong by half a motor's torque."""
SAME_PLACE_M = 1e-4
"""Two driven wheels so near are one that somebody has copied, and not yet moved."""

_MAY_BE_ZERO = {"rolling", "coulomb_nm", "load_friction", "current_lag_ms", "speed_filter_ms", "ki_a_per_rad"}
_MAY_BE_ZERO |= {"cog_height_m", "firmware_version", "hardware_version"}


_SANE = {
    "body.mass_kg": (0.01, 1e5),
    "body.inertia_kgm2": (1e-6, 1e6),
    "body.radius_m": (1e-3, 100.0),
    "body.cog_height_m": (0.0, 100.0),
    "ground.grip": (1e-3, 100.0),
    "ground.rolling": (0.0, 10.0),
    "motor.torque_nm_per_a": (1e-6, 1e4),
    "motor.coulomb_nm": (0.0, 1e5),
    "motor.viscous_nms": (1e-9, 1e5),
    "motor.inertia_kgm2": (1e-9, 1e5),
    "motor.resistance_ohm": (1e-4, 1e4),
    "motor.back_emf_vs": (1e-6, 1e4),
    "motor.supply_v": (0.1, 1e4),
    "motor.max_current_a": (1e-3, 1e3),
    "motor.current_lag_ms": (0.0, 1e4),
    "motor.speed_filter_ms": (0.0, 1e4),
    "limits.current_a": (1e-3, 1e3),
    "limits.linear_mps": (1e-3, 100.0),
    "limits.angular_radps": (1e-3, 1e3),
    "limits.wheel_radps": (1e-3, 1e4),
    "limits.linear_acceleration_mps2": (1e-3, 1e4),
    "limits.angular_acceleration_radps2": (1e-3, 1e5),
    "control.kp_a_per_radps": (1e-9, 1e6),
    "control.ki_a_per_rad": (0.0, 1e6),
}
_SANE_OF_A_WHEEL = {"radius_m": (1e-4, 100.0), "gear": (0.01, 1e4)}
"""Far beyond any robot: what lies outside is a slip of the keyboard, and arithmetic would suffer."""


def _least_inertia_kgm2(motor: Motor) -> float:
    """Explicit back-EMF is stable for steps below 2 J R/(Kt Ke) (reference plant model, 3.1)."""
    torque_nm_per_a = motor.torque_nm_per_a / (1.0 - motor.load_friction)
    return 1e-6 * TICK_US * torque_nm_per_a * motor.back_emf_vs / (2.0 * motor.resistance_ohm)


def check_robot(where: Path | str, robot: Robot) -> None:
    """Raise ConfigError where this robot cannot be built, stand, move or be driven.

    `where` begins the sentence: the robot's file, or what else somebody calls a robot that was made in Python.
    """
    # Imported here: kinematics builds on this package, and only a whole robot can be singular.
    from bench.ground.loads import load_rows
    from bench.kinematics import Kinematics, if_rollers_leaned_the_other_way
    from bench.slamware.payloads import Identity, identity_answer

    def fail(key: str, what: str) -> ConfigError:
        return ConfigError(f"{where}: {key}: {what}")

    for table in ("body", "ground", "motor", "limits", "control", "link", "slamware"):
        part = getattr(robot, table)
        for item in fields(part):
            value = getattr(part, item.name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if not math.isfinite(value):
                raise fail(f"{table}.{item.name}", f"expected a finite number, got {value}")
            if value < 0 or (value == 0 and item.name not in _MAY_BE_ZERO):
                raise fail(f"{table}.{item.name}", f"expected a positive number, got {value}")
    for key, (lowest, highest) in _SANE.items():
        table, name = key.split(".")
        value = getattr(getattr(robot, table), name)
        if not lowest <= value <= highest:
            raise fail(key, f"expected {lowest:g} to {highest:g}, got {value:g}")
    if len(robot.wheels) < 3:
        raise fail("wheel", f"an omni base needs at least three wheels, got {len(robot.wheels)}")
    _check_wheels(where, "wheel", robot.wheels)
    _check_wheels(where, "dead_wheel", robot.dead_wheels)
    for wheel in robot.wheels:
        rotor_rpm = robot.limits.wheel_radps * wheel.gear * 30.0 / math.pi
        if rotor_rpm > MOST_ROTOR_RPM:
            what = f"{robot.limits.wheel_radps:g} rad/s turn the rotor of {wheel.name!r} at {rotor_rpm:.0f} rpm"
            raise fail(
                "limits.wheel_radps",
                f"{what}; over {MOST_ROTOR_RPM} {DOES_NOT_SAY}",
            )
    most_m = MOST_BODIES * robot.body.radius_m
    every = [("wheel", wheel) for wheel in robot.wheels] + [("dead_wheel", wheel) for wheel in robot.dead_wheels]
    for key, wheel in every:
        away_m = math.hypot(wheel.x_m, wheel.y_m)
        for what, length_m in ((f"has a radius of {wheel.radius_m:g} m under", wheel.radius_m),
                               (f"stands {away_m:g} m from the centre of", away_m)):  # fmt: skip
            if length_m > most_m:
                what = f"{wheel.name!r} {what} a body of {robot.body.radius_m:g} m"
                raise fail(key, f"{what}; is that in metres?")
    for key in ("can_id", "name"):
        seen = [getattr(wheel, key) for wheel in robot.wheels]
        twice = [value for value in seen if seen.count(value) > 1]
        if twice:
            raise fail(f"wheel.{key}", f"{twice[0]!r} is given to more than one wheel")
    if robot.motor.kind not in MOTOR_KINDS:
        raise fail("motor.kind", f"{robot.motor.kind!r} is unknown{nearest(robot.motor.kind, list(MOTOR_KINDS))}")
    _check_currents(where, robot)
    reactions = ON_COMMAND_LOSS[robot.motor.kind]
    if robot.motor.on_command_loss not in reactions:
        known = " or ".join(map(repr, reactions))
        raise fail("motor.on_command_loss", f"expected {known}, got {robot.motor.on_command_loss!r}")
    if robot.motor.load_friction >= 1.0:
        raise fail("motor.load_friction", f"expected less than 1, got {robot.motor.load_friction}")
    lightest = _least_inertia_kgm2(robot.motor)
    if robot.motor.inertia_kgm2 < lightest:
        raise fail(
            "motor.inertia_kgm2",
            f"expected at least {lightest:.2g} with this torque constant, back-EMF and resistance, got "
            f"{robot.motor.inertia_kgm2:g}: back-EMF would turn so light a wheel round within a millisecond",
        )
    if robot.link.hold_ms >= robot.link.disarm_ms:
        raise fail("link.hold_ms", f"{robot.link.hold_ms} ms must be less than link.disarm_ms")
    try:
        kinematics = Kinematics(robot.wheels)
    except ValueError as error:
        mirrored = if_rollers_leaned_the_other_way(robot.wheels)
        hint = "; with every roller_deg negated they could: it is that of the roller on the ground"
        raise fail("wheel", f"{error}{'' if mirrored is None else hint}") from None
    for number, wheel in enumerate(robot.wheels):
        for other in robot.wheels[:number]:
            if math.hypot(wheel.x_m - other.x_m, wheel.y_m - other.y_m) < SAME_PLACE_M:
                raise fail("wheel", f"{wheel.name!r} stands where {other.name!r} does; two wheels need two places")
    try:
        load_rows(robot.wheels, robot.body.mass_kg, robot.body.cog_height_m)
    except ValueError as error:
        raise fail("wheel", str(error)) from None
    _check_reflected_inertia(where, robot, kinematics.inverse_rows)
    _check_dead_wheels(where, robot)
    _check_gyro(where, robot)
    if robot.rc is not None:
        check_profile(f"{where}: rc", robot.rc)
    if robot.control.kind not in CONTROL_KINDS:
        raise fail(
            "control.kind", f"{robot.control.kind!r} is unknown{nearest(robot.control.kind, list(CONTROL_KINDS))}"
        )
    if robot.odometry not in ODOMETRY_FORMS:
        raise fail("odometry", f"{robot.odometry!r} is unknown{nearest(robot.odometry, list(ODOMETRY_FORMS))}")
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


def _check_wheels(where: Path | str, table: str, wheels: Sequence[Wheel]) -> None:
    """Each wheel by itself, driven or dead."""
    for number, wheel in enumerate(wheels):

        def fail(key: str, what: str, number: int = number) -> ConfigError:
            return ConfigError(f"{where}: {table}[{number}].{key}: {what}")

        if wheel.direction not in (1, -1):
            raise fail("direction", f"expected 1 or -1, got {wheel.direction}")
        if wheel.can_id not in range(1, 9):
            raise fail("can_id", f"expected 1 to 8 as printed on the ESC, got {wheel.can_id}")
        for key, (least, most) in _SANE_OF_A_WHEEL.items():
            value = getattr(wheel, key)
            if not value > 0.0:
                raise fail(key, f"expected a positive number, got {value}")
            if not least <= value <= most:
                raise fail(key, f"expected {least:g} to {most:g}, got {value:g}")
        for key in ("x_m", "y_m", "heading_rad", "roller_rad"):
            value = getattr(wheel, key)
            if not math.isfinite(value):
                raise fail(key, f"expected a finite number, got {value}")
        if abs(math.cos(wheel.roller_rad)) < 1e-3:
            raise fail("roller_deg", "a roller axis across the wheel cannot drive; expected less than 90 degrees")


def _check_currents(where: Path | str, robot: Robot) -> None:
    """What the motor's wire can say, and that nothing asks for more."""

    def fail(key: str, what: str) -> ConfigError:
        return ConfigError(f"{where}: {key}: {what}")

    motor, chosen = robot.motor, robot.dm3519
    if motor.kind == "c610":
        if chosen is not None:
            raise fail("dm3519", f"this table is for motor.kind = 'dm3519'; the file has {motor.kind!r}")
        if motor.max_current_a > MOST_C610_A:
            raise fail("motor.max_current_a", f"a C610 is told {MOST_C610_A:g} A at most, got {motor.max_current_a:g}")
    else:
        if chosen is None:
            raise fail("dm3519", "the table [dm3519] is missing")
        if not 20.0 <= chosen.full_scale_a <= 20.5:
            raise fail("dm3519.full_scale_a", f"expected 20 to 20.5 A, got {chosen.full_scale_a}")
        for key, choices in DM3519_CHOICES.items():
            value = getattr(chosen, key)
            if value not in choices:
                raise fail(f"dm3519.{key}", f"{value!r} is unknown{nearest(value, list(choices))}")
        if motor.max_current_a > chosen.full_scale_a:
            raise fail("motor.max_current_a", f"{motor.max_current_a} A is above dm3519.full_scale_a")
    if robot.limits.current_a > motor.max_current_a:
        raise fail("limits.current_a", f"{robot.limits.current_a} A is above motor.max_current_a")


def _check_reflected_inertia(where: Path | str, robot: Robot, rows: Sequence[Sequence[float]]) -> None:
    """J sum H^2 beside what the body itself has, forward, sideways and turning (reference plant model, section 2)."""
    body = robot.body
    for column, key in enumerate(("mass_kg", "mass_kg", "inertia_kgm2")):
        squares = 0.0
        for row in rows:
            squares += row[column] * row[column]
        times = robot.motor.inertia_kgm2 * squares / getattr(body, key)
        if times > MOST_REFLECTED:
            raise ConfigError(
                f"{where}: body.{key}: the wheels' motor.inertia_kgm2 weighs {times:.0f} times as much on the floor, "
                f"more than {MOST_REFLECTED:g} times cannot be; are both in kg and m, and the gear squared once?"
            )


def _check_gyro(where: Path | str, robot: Robot) -> None:
    gyro = robot.gyro
    if gyro is None:
        return
    if gyro.can_id not in range(1, 9):
        raise ConfigError(f"{where}: gyro.can_id: expected 1 to 8, got {gyro.can_id}")
    if not 0.0 <= gyro.rate_noise_radps < math.inf:
        raise ConfigError(f"{where}: gyro.rate_noise_degps: expected 0 or more")
    if not math.isfinite(gyro.bias_radps):
        raise ConfigError(f"{where}: gyro.bias_degps: expected a finite number, got {gyro.bias_radps}")


def _check_dead_wheels(where: Path | str, robot: Robot) -> None:
    """An encoder answers on 0x200 + can_id as an ESC does, so nobody may have another's number."""
    from bench.kinematics import Kinematics

    owners = {wheel.can_id: wheel.name for wheel in robot.wheels}
    names = set(owners.values())
    for wheel in robot.dead_wheels:
        encoder_rpm = robot.limits.linear_mps / wheel.radius_m * wheel.gear * 30.0 / math.pi
        if encoder_rpm > MOST_ROTOR_RPM:
            raise ConfigError(
                f"{where}: dead_wheel: {robot.limits.linear_mps:g} m/s turn the encoder of {wheel.name!r} at "
                f"{encoder_rpm:.0f} rpm; over {MOST_ROTOR_RPM} {DOES_NOT_SAY}; is its gear that of the encoder?"
            )
        if wheel.name in names:
            raise ConfigError(f"{where}: dead_wheel.name: {wheel.name!r} is given to more than one wheel")
        if wheel.can_id in owners:
            raise ConfigError(
                f"{where}: dead_wheel.can_id: {wheel.can_id} of {wheel.name!r} is taken by {owners[wheel.can_id]!r}; "
                "wheels and dead wheels share the numbers 1 to 8"
            )
        names.add(wheel.name)
        owners[wheel.can_id] = wheel.name
    # Fewer than three are read and recorded; odometry needs three that span the plane.
    if len(robot.dead_wheels) >= 3:
        try:
            Kinematics(robot.dead_wheels)
        except ValueError:
            raise ConfigError(
                f"{where}: dead_wheel: cannot tell x, y and yaw apart (singular layout); turn or move one of them"
            ) from None


def check_profile(where: Path | str, profile: Profile) -> None:
    """Raise ConfigError where this profile cannot be a transmitter's."""

    def fail(key: str, what: str) -> ConfigError:
        return ConfigError(f"{where}: {key}: {what}")

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
        if not 0 < getattr(profile, name).travel < math.inf:
            raise fail(f"{name}.travel", "expected a positive number; use reversed = true to turn a stick round")
    # Imported here: the codecs build on this package's neighbours, and only a whole profile names channels.
    from bench.rc_decode import channel_limits

    limits = channel_limits(profile.protocol)
    last = len(limits) - 1
    for name in ("forward", "right", "clockwise", "aux1", "aux2"):
        part = getattr(profile, name)
        if part is None:
            continue
        if not 0 <= part.channel <= last:
            raise fail(f"{name}.channel", f"{profile.protocol} has channels 0 to {last}, got {part.channel}")
        key = "middle" if isinstance(part, Axis) else "pressed_from"
        low, high = limits[part.channel]
        if not low <= getattr(part, key) <= high:
            raise fail(f"{name}.{key}", f"{profile.protocol} says {low} to {high}, got {getattr(part, key)}")
