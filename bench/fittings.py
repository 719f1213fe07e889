"""What a robot carries besides wheels and motors: bumpers, range sensors, dock receivers. And the dock that they seek.

    [[bumper]]         name, bearing_deg, span_deg; height_m
    [[range_sensor]]   name, bearing_deg; distance_m (the body's radius), heading_deg (outwards), height_m, reach_m
    [[dock_receiver]]  name, bearing_deg, view_deg
    [dock]             x_m, y_m, heading_deg (the way it looks) in the field; reach_m

A robot file that names none of a kind gets the usual set on its rim: two bumpers (left, right), four range sensors
(front, left, rear, right), three receivers (left, main, right). `bumper = []` says that there are none. There is no
dock unless the file places one. Order in the file is order on the wire.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bench.config import Table

MAX_BUMPERS, MAX_RANGE_SENSORS, MAX_RECEIVERS = 8, 16, 8
"""What the SLAMWARE control bus can tell of."""

MOST_M = 100.0
"""From the robot's centre: larger than any robot, and told on the bus in 32 bits of 1/256 mm."""
HEIGHT_M = 0.05
REACH_M = 4.0
DOCK_REACH_M = 3.0


@dataclass(frozen=True, slots=True)
class Bumper:
    """A contact strip on the body's rim: closes where a wall touches the rim within span/2 of the bearing."""

    name: str
    bearing_rad: float
    span_rad: float
    height_m: float = HEIGHT_M


@dataclass(frozen=True, slots=True)
class RangeSensor:
    """One beam: where it starts on the body, where it looks, and how far."""

    name: str
    x_m: float
    y_m: float
    heading_rad: float
    height_m: float = HEIGHT_M
    reach_m: float = REACH_M


@dataclass(frozen=True, slots=True)
class DockReceiver:
    """An infrared receiver on the body: sees the dock's beacons within view/2 of its bearing."""

    name: str
    bearing_rad: float
    view_rad: float


@dataclass(frozen=True, slots=True)
class Dock:
    """A charging dock in the field, which looks along its heading and can be seen from as far as its reach."""

    x_m: float
    y_m: float
    heading_rad: float
    reach_m: float = DOCK_REACH_M


@dataclass(frozen=True, slots=True)
class Fittings:
    """All of it, in the order of the robot file."""

    bumpers: tuple[Bumper, ...] = ()
    range_sensors: tuple[RangeSensor, ...] = ()
    receivers: tuple[DockReceiver, ...] = ()
    dock: Dock | None = None


def read_fittings(data: Table, radius_m: float) -> Fittings:
    """The fittings of a robot file, or the usual ones on a body of this radius. Raises ConfigError."""
    bumpers, range_sensors, receivers = usual_bumpers(), usual_range_sensors(radius_m), usual_receivers()
    if data.has("bumper"):
        bumpers = tuple(map(_read_bumper, _limited(data, "bumper", MAX_BUMPERS)))
    if data.has("range_sensor"):
        entries = _limited(data, "range_sensor", MAX_RANGE_SENSORS)
        range_sensors = tuple(_read_range_sensor(entry, radius_m) for entry in entries)
    if data.has("dock_receiver"):
        receivers = tuple(map(_read_receiver, _limited(data, "dock_receiver", MAX_RECEIVERS)))
    dock = _read_dock(data.table("dock")) if data.has("dock") else None
    return Fittings(bumpers, range_sensors, receivers, dock)


def usual_bumpers() -> tuple[Bumper, ...]:
    """Two strips over the front half."""
    return tuple(
        Bumper(name, math.radians(deg), math.radians(90.0)) for name, deg in (("left", 45.0), ("right", -45.0))
    )


def usual_range_sensors(radius_m: float) -> tuple[RangeSensor, ...]:
    """Four beams from the rim, one for each side."""
    sides = (("front", 0.0), ("left", 90.0), ("rear", 180.0), ("right", 270.0))
    return tuple(_on_the_rim(name, math.radians(deg), radius_m) for name, deg in sides)


def usual_receivers() -> tuple[DockReceiver, ...]:
    """Three receivers over the front, in the order of the reference base."""
    sides = (("left", 45.0), ("main", 0.0), ("right", -45.0))
    return tuple(DockReceiver(name, math.radians(deg), math.radians(60.0)) for name, deg in sides)


def _on_the_rim(name: str, bearing_rad: float, radius_m: float) -> RangeSensor:
    return RangeSensor(name, radius_m * math.cos(bearing_rad), radius_m * math.sin(bearing_rad), bearing_rad)


def _limited(data: Table, name: str, most: int) -> list[Table]:
    entries = data.tables(name, optional=True)
    if len(entries) > most:
        raise data.fail(name, f"expected at most {most}, got {len(entries)}")
    return entries


def _read_bumper(entry: Table) -> Bumper:
    bumper = Bumper(
        name=entry.get("name", str),
        bearing_rad=math.radians(entry.get("bearing_deg", float)),
        span_rad=_angle(entry, "span_deg"),
        height_m=_place(entry, "height_m", HEIGHT_M),
    )
    entry.refuse_rest()
    return bumper


def _read_range_sensor(entry: Table, radius_m: float) -> RangeSensor:
    bearing_deg = entry.get("bearing_deg", float)
    bearing_rad = math.radians(bearing_deg)
    distance_m = _place(entry, "distance_m", radius_m)
    sensor = RangeSensor(
        name=entry.get("name", str),
        x_m=distance_m * math.cos(bearing_rad),
        y_m=distance_m * math.sin(bearing_rad),
        heading_rad=math.radians(entry.get("heading_deg", float, bearing_deg)),
        height_m=_place(entry, "height_m", HEIGHT_M),
        reach_m=_positive(entry, "reach_m", REACH_M),
    )
    entry.refuse_rest()
    return sensor


def _read_receiver(entry: Table) -> DockReceiver:
    receiver = DockReceiver(
        name=entry.get("name", str),
        bearing_rad=math.radians(entry.get("bearing_deg", float)),
        view_rad=_angle(entry, "view_deg"),
    )
    entry.refuse_rest()
    return receiver


def _read_dock(entry: Table) -> Dock:
    dock = Dock(
        x_m=entry.get("x_m", float),
        y_m=entry.get("y_m", float),
        heading_rad=math.radians(entry.get("heading_deg", float)),
        reach_m=_positive(entry, "reach_m", DOCK_REACH_M),
    )
    entry.refuse_rest()
    return dock


def _angle(entry: Table, name: str) -> float:
    degrees: float = entry.get(name, float)
    if not 0.0 < degrees <= 360.0:
        raise entry.fail(name, f"expected more than 0 and at most 360 degrees, got {degrees}")
    return math.radians(degrees)


def _place(entry: Table, name: str, default: float) -> float:
    value: float = entry.get(name, float, default)
    if abs(value) > MOST_M:
        raise entry.fail(name, f"expected -{MOST_M:g} to {MOST_M:g}, got {value:g}")
    return value


def _positive(entry: Table, name: str, default: float) -> float:
    value: float = entry.get(name, float, default)
    if value <= 0.0:
        raise entry.fail(name, f"expected a positive number, got {value}")
    return value
