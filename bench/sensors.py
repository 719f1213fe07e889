"""What a robot's sensors feel where it stands: pure geometry of a pose in an arena. No engine, no time.

Distances run along a beam to the face of a wall or a disc; a bumper closes where the body's rim is within its travel of
one; a dock is seen by a receiver that looks at it and that it looks at. `ArenaSenses` puts them together for the
SLAMWARE slave and computes only what a core asks for.

Frame: field x, y in metres, headings counter-clockwise. An arena is centred on the origin; without one there are no
walls.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from bench.arena import Arena, Obstacle
from bench.config import Robot
from bench.fittings import Bumper, Dock, DockReceiver, RangeSensor
from bench.messages import Pose
from bench.slamware.sense_payloads import Beacons, Power
from bench.slamware.senses import DOCK_BEACONS, Senses

BUMPER_TRAVEL_M = 0.001
"""A strip stands this far out from the body: the engine leaves robots that push a wall up to 0.1 mm off or in it."""
DOCKED_WITHIN_M = 0.02
"""Between rim and dock; charging contacts are springs."""
LEFT_BEACON, MAIN_BEACON, RIGHT_BEACON = 1, 2, 4
MAIN_HALF_RAD = math.radians(10.0)
SIDE_HALF_RAD = math.radians(45.0)
"""The main beacon shines ahead, the other two from there to their sides: the usual pattern, the figures are ours."""

_TURNED_AWAY = 1e-12


class Placed(Protocol):
    """Something that knows where the robot really is, and the discs."""

    @property
    def pose(self) -> Pose:
        """In the field."""
        ...

    @property
    def discs(self) -> Sequence[Obstacle]:
        """Where they are now."""
        ...


def distance_m(sensor: RangeSensor, pose: Pose, arena: Arena | None, discs: Sequence[Obstacle] = ()) -> float:
    """What the sensor measures: to the nearest face along its beam, at most its reach; 0 where it is in something."""
    if arena is None:
        return sensor.reach_m
    c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    x_m = pose.x_m + c * sensor.x_m - s * sensor.y_m
    y_m = pose.y_m + s * sensor.x_m + c * sensor.y_m
    looks_rad = pose.heading_rad + sensor.heading_rad
    nearest_m = sensor.reach_m
    for at_m, towards, half_m in (
        (x_m, math.cos(looks_rad), arena.length_m / 2.0),
        (y_m, math.sin(looks_rad), arena.width_m / 2.0),
    ):
        if abs(towards) > _TURNED_AWAY:
            nearest_m = min(nearest_m, (math.copysign(half_m, towards) - at_m) / towards)
    for obstacle in (*(wall.obstacle for wall in arena.walls), *discs):
        nearest_m = min(nearest_m, _beam_m(x_m, y_m, math.cos(looks_rad), math.sin(looks_rad), obstacle))
    return max(0.0, nearest_m)


def is_pressed(
    bumper: Bumper, radius_m: float, pose: Pose, arena: Arena | None, discs: Sequence[Obstacle] = ()
) -> bool:
    """Whether a wall or a disc touches the rim where the bumper is. In a corner two walls do."""
    if arena is None:
        return False
    for obstacle in (*(wall.obstacle for wall in arena.walls), *discs):
        gap_m, towards_rad = obstacle.nearest(pose.x_m, pose.y_m)
        if gap_m - radius_m <= BUMPER_TRAVEL_M and _covers(bumper, pose, towards_rad):
            return True
    half_x, half_y = arena.length_m / 2.0, arena.width_m / 2.0
    for wall_rad, gap_m in (
        (0.0, half_x - pose.x_m),
        (math.pi / 2.0, half_y - pose.y_m),
        (math.pi, half_x + pose.x_m),
        (-math.pi / 2.0, half_y + pose.y_m),
    ):
        if gap_m - radius_m <= BUMPER_TRAVEL_M and _covers(bumper, pose, wall_rad):
            return True
    return False


def beacons_seen(receiver: DockReceiver, pose: Pose, dock: Dock | None) -> int:
    """Bits of the beacons that a receiver at the robot's centre sees: 1 left, 2 main, 4 right, as the dock looks."""
    if dock is None:
        return 0
    dx_m, dy_m = pose.x_m - dock.x_m, pose.y_m - dock.y_m
    if math.hypot(dx_m, dy_m) > dock.reach_m:
        return 0
    to_dock_rad = math.atan2(-dy_m, -dx_m)
    if _off(to_dock_rad, pose.heading_rad + receiver.bearing_rad) > receiver.view_rad / 2.0:
        return 0
    bearing_rad = math.remainder(math.atan2(dy_m, dx_m) - dock.heading_rad, math.tau)
    seen = MAIN_BEACON if abs(bearing_rad) <= MAIN_HALF_RAD else 0
    # Left as one who stands in front of the dock and faces it: clockwise of the way it looks.
    if -SIDE_HALF_RAD <= bearing_rad <= 0.0:
        seen |= LEFT_BEACON
    if 0.0 <= bearing_rad <= SIDE_HALF_RAD:
        seen |= RIGHT_BEACON
    return seen


def is_docked(radius_m: float, pose: Pose, dock: Dock | None) -> bool:
    """Whether the robot's front touches the dock's."""
    if dock is None:
        return False
    dx_m, dy_m = pose.x_m - dock.x_m, pose.y_m - dock.y_m
    if math.hypot(dx_m, dy_m) - radius_m > DOCKED_WITHIN_M:
        return False
    in_front = _off(math.atan2(dy_m, dx_m), dock.heading_rad) <= SIDE_HALF_RAD
    return in_front and _off(pose.heading_rad, dock.heading_rad + math.pi) <= MAIN_HALF_RAD


class ArenaSenses(Senses):
    """The senses of one robot in one field. The plant knows where it is; the battery is what it is set to."""

    def __init__(self, robot: Robot, plant: Placed, arena: Arena | None) -> None:
        super().__init__()
        self._fittings = robot.fittings
        self._radius_m = robot.body.radius_m
        self._plant = plant
        self._arena = arena

    def power(self) -> Power:
        """The battery as it was set; on the dock it charges."""
        if is_docked(self._radius_m, self._plant.pose, self._fittings.dock):
            return self.battery._replace(charging=True, on_dock=True)
        return self.battery

    def ranges_m(self) -> Sequence[float]:
        """One distance for each range sensor."""
        pose, discs = self._plant.pose, self._plant.discs
        return [distance_m(sensor, pose, self._arena, discs) for sensor in self._fittings.range_sensors]

    def contacts(self) -> Sequence[bool]:
        """One for each bumper."""
        pose, discs = self._plant.pose, self._plant.discs
        return [is_pressed(bumper, self._radius_m, pose, self._arena, discs) for bumper in self._fittings.bumpers]

    def beacons(self) -> Beacons:
        """One bitmap for each receiver."""
        pose, dock = self._plant.pose, self._fittings.dock
        return Beacons(DOCK_BEACONS, tuple(beacons_seen(each, pose, dock) for each in self._fittings.receivers))


def _covers(bumper: Bumper, pose: Pose, towards_rad: float) -> bool:
    return _off(towards_rad, pose.heading_rad + bumper.bearing_rad) <= bumper.span_rad / 2.0


def _beam_m(x_m: float, y_m: float, cos: float, sin: float, obstacle: Obstacle) -> float:
    """From a point along a direction to where an obstacle begins; 0 within it, infinite where the beam misses it."""
    if obstacle.nearest(x_m, y_m)[0] <= 0.0:
        return 0.0
    x1, y1, x2, y2, radius = obstacle
    hits = [_to_circle(x1 - x_m, y1 - y_m, cos, sin, radius), _to_circle(x2 - x_m, y2 - y_m, cos, sin, radius)]
    length = math.hypot(x2 - x1, y2 - y1)
    if length:
        ux, uy = (x2 - x1) / length, (y2 - y1) / length
        across = ux * sin - uy * cos  # of the beam, over the wall's line
        if abs(across) > _TURNED_AWAY:
            height = ux * (y_m - y1) - uy * (x_m - x1)
            far = (math.copysign(radius, height) - height) / across
            at = ux * (x_m + far * cos - x1) + uy * (y_m + far * sin - y1)
            if far >= 0.0 and 0.0 <= at <= length:
                hits.append(far)
    return min(hits)


def _to_circle(dx_m: float, dy_m: float, cos: float, sin: float, radius_m: float) -> float:
    """Along a beam to a circle whose centre is (dx, dy) away from where it starts, outside."""
    ahead = dx_m * cos + dy_m * sin
    beside = dx_m * sin - dy_m * cos
    if ahead < 0.0 or abs(beside) > radius_m:
        return math.inf
    return ahead - math.sqrt(radius_m * radius_m - beside * beside)


def _off(a_rad: float, b_rad: float) -> float:
    """The angle between two directions, 0 to pi."""
    return abs(math.remainder(a_rad - b_rad, math.tau))
