"""What never changes about a base, and what its slave therefore answers alike for ever: identity and build."""

from __future__ import annotations

import math
from typing import NamedTuple

from bench.config import Robot, SlamwareSettings
from bench.fittings import Bumper
from bench.slamware import config_payloads as tree
from bench.slamware.commands import DIALECTS, Dialect
from bench.slamware.config_payloads import BaseConfiguration, Position, Symbol, Tree, encode_tree
from bench.slamware.payloads import Identity

NO_ID = 0xFF


class BaseFacts(NamedTuple):
    """Identity, build and dialect of one base."""

    identity: Identity
    configuration: BaseConfiguration
    binary_configuration: bytes
    dialect: Dialect = DIALECTS["firmware-2018"]


def identity_of(settings: SlamwareSettings) -> Identity:
    """What 0x10 answers. Whether it fits on the wire is seen when it is encoded."""
    return Identity(
        settings.model,
        settings.firmware_version,
        settings.hardware_version,
        settings.serial_number,
        settings.firmware_suffix,
    )


def facts_of(robot: Robot) -> BaseFacts:
    """The facts of a robot file."""
    settings, radius_m = robot.slamware, robot.body.radius_m
    bumpers = tuple(_on_the_rim(strip, radius_m) for strip in robot.fittings.bumpers)
    sensors = tuple(
        Position(sensor.x_m, sensor.y_m, sensor.height_m, sensor.heading_rad) for sensor in robot.fittings.range_sensors
    )
    drive = tree.TWO_WHEELS if len(robot.wheels) == 2 else tree.OMNI
    configuration = BaseConfiguration(tree.ROUND, radius_m, drive, sensors, bumpers)
    blob = bytes.fromhex(settings.binary_configuration)
    identity = identity_of(settings)
    return BaseFacts(
        identity, configuration, blob or encode_tree(_tree(identity, configuration)), DIALECTS[settings.dialect]
    )


def _on_the_rim(strip: Bumper, radius_m: float) -> Position:
    bearing_rad = strip.bearing_rad
    return Position(radius_m * math.cos(bearing_rad), radius_m * math.sin(bearing_rad), strip.height_m, bearing_rad)


def _tree(identity: Identity, configuration: BaseConfiguration) -> Tree:
    base: dict[int, Tree] = {
        tree.MANUFACTURER_ID: NO_ID,
        tree.MANUFACTURER: "",
        tree.MODEL_ID: 0,
        tree.MODEL: identity.model,
        tree.HARDWARE_VERSION: identity.hardware_version,
        tree.SIZE: 2.0 * configuration.radius_m,
        tree.SENSORS: [
            {tree.ID: number, tree.TYPE: Symbol(tree.BUMPER), tree.POSE: _pose(strip)}
            for number, strip in enumerate(configuration.bumpers)
        ],
    }
    return {tree.BASE: base}


def _pose(position: Position) -> Tree:
    x_m, y_m, z_m, heading_rad = position
    return {tree.X: x_m, tree.Y: y_m, tree.Z: z_m, tree.YAW: heading_rad % math.tau}
