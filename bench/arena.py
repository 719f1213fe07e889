"""Where a robot drives, as data: a walled field with further walls, discs to push, and patches of another floor.

    schema = 1
    name = "course"
    length_m = 6.0              # inside, along x; centred on (0, 0)
    width_m = 4.0
    friction = 0.3              # of walls and discs against the body
    restitution = 0.0

    [start]                     # where the robot begins; x_m, y_m, heading_deg

    [[wall]]                    # x1_m, y1_m, x2_m, y2_m; thickness_m

    [[disc]]                    # name, x_m, y_m, radius_m, mass_kg; friction against the floor

    [[patch]]                   # name, x_m, y_m; length_m and width_m, or radius_m; grip, rolling

A wheel's contact point decides on which floor it stands; where patches overlap, the later one lies on top. An arena is
a file of its own (`--arena FILE`, or `arena = "FILE"` in a scenario), or the table `[arena]` of a scenario.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from bench.config import Table, read_toml
from bench.config.emit import toml_text
from bench.messages import Pose

ORIGIN = Pose(0.0, 0.0, 0.0)
MOST_M = 1000.0
"""Larger than any hall, so that a slip of the keyboard is seen."""


class Obstacle(NamedTuple):
    """A line with a radius: a wall with round ends, or with both ends in one place a disc."""

    x1_m: float
    y1_m: float
    x2_m: float
    y2_m: float
    radius_m: float

    def nearest(self, x_m: float, y_m: float) -> tuple[float, float]:
        """From a point: how far to the surface (negative within), and the direction to it, rad."""
        along_x, along_y = self.x2_m - self.x1_m, self.y2_m - self.y1_m
        square = along_x * along_x + along_y * along_y
        share = ((x_m - self.x1_m) * along_x + (y_m - self.y1_m) * along_y) / square if square else 0.0
        share = max(0.0, min(1.0, share))
        dx, dy = self.x1_m + share * along_x - x_m, self.y1_m + share * along_y - y_m
        return math.hypot(dx, dy) - self.radius_m, math.atan2(dy, dx)


@dataclass(frozen=True, slots=True)
class Wall:
    """A wall from one point to the other, with round ends."""

    x1_m: float
    y1_m: float
    x2_m: float
    y2_m: float
    thickness_m: float = 0.02

    @property
    def obstacle(self) -> Obstacle:
        """Its shape."""
        return Obstacle(self.x1_m, self.y1_m, self.x2_m, self.y2_m, self.thickness_m / 2.0)


@dataclass(frozen=True, slots=True)
class Disc:
    """Something round that can be pushed, where it begins. It rubs on the floor with its weight."""

    name: str
    x_m: float
    y_m: float
    radius_m: float
    mass_kg: float
    friction: float = 0.3

    @property
    def obstacle(self) -> Obstacle:
        """Its shape, where it begins."""
        return Obstacle(self.x_m, self.y_m, self.x_m, self.y_m, self.radius_m)


@dataclass(frozen=True, slots=True)
class Patch:
    """A rectangle, or where it has a radius a circle, of a floor with another grip and rolling loss."""

    name: str
    x_m: float
    y_m: float
    grip: float
    rolling: float
    length_m: float = 0.0
    width_m: float = 0.0
    radius_m: float = 0.0

    def carries(self, x_m: float, y_m: float) -> bool:
        """Whether what touches the floor here touches the patch."""
        dx, dy = abs(x_m - self.x_m), abs(y_m - self.y_m)
        if self.radius_m:
            return dx * dx + dy * dy <= self.radius_m * self.radius_m
        return dx <= self.length_m / 2.0 and dy <= self.width_m / 2.0


@dataclass(frozen=True, slots=True)
class Arena:
    """A closed field, centred on the origin: inner length along x, inner width along y, and what stands in it."""

    length_m: float = 6.0
    width_m: float = 4.0
    friction: float = 0.3
    restitution: float = 0.0
    name: str = "field"
    start: Pose = ORIGIN
    walls: tuple[Wall, ...] = ()
    discs: tuple[Disc, ...] = ()
    patches: tuple[Patch, ...] = ()

    def clearance_m(self, x_m: float, y_m: float) -> float:
        """How far it is from here to the nearest wall; negative in one, or outside."""
        clear = min(self.length_m / 2.0 - abs(x_m), self.width_m / 2.0 - abs(y_m))
        for wall in self.walls:
            clear = min(clear, wall.obstacle.nearest(x_m, y_m)[0])
        return clear

    def in_the_way(self, radius_m: float, pose: Pose) -> str:
        """Why a robot of this radius cannot begin here, or nothing."""
        x_m, y_m = pose.x_m, pose.y_m
        half_x, half_y = self.length_m / 2.0 - radius_m, self.width_m / 2.0 - radius_m
        robot = f"a robot of radius {radius_m:g} m at ({x_m:g}, {y_m:g}) m"
        size = f"a field of {self.length_m} m x {self.width_m} m"
        if half_x < 0.0 or half_y < 0.0:
            return f"{robot} is larger than {size}"
        if not (abs(x_m) <= half_x and abs(y_m) <= half_y):
            return f"{robot} is not inside {size} centred on (0, 0)"
        for i, wall in enumerate(self.walls):
            if wall.obstacle.nearest(x_m, y_m)[0] < radius_m:
                return f"{robot} stands in wall[{i}]"
        for disc in self.discs:
            if disc.obstacle.nearest(x_m, y_m)[0] < radius_m:
                return f"{robot} stands in the disc {disc.name!r}"
        return ""


FIELD = Arena()


def load_arena(path: Path | str) -> Arena:
    """Read and check an arena file. Raises ConfigError with file, key and what to try."""
    path = Path(path)
    data = Table(path, "", read_toml(path))
    data.take_schema()
    return read_arena(data, path.stem)


def read_arena(data: Table, name: str) -> Arena:
    """An arena from its table. Raises ConfigError."""
    start = data.table("start", optional=True)
    arena = Arena(
        length_m=_size(data, "length_m", FIELD.length_m),
        width_m=_size(data, "width_m", FIELD.width_m),
        friction=_within(data, "friction", FIELD.friction, 10.0),
        restitution=_within(data, "restitution", FIELD.restitution, 1.0),
        name=data.get("name", str, name),
        start=Pose(
            start.get("x_m", float, 0.0),
            start.get("y_m", float, 0.0),
            math.radians(start.get("heading_deg", float, 0.0)),
        ),
        walls=tuple(map(_read_wall, data.tables("wall", optional=True))),
        discs=tuple(map(_read_disc, data.tables("disc", optional=True))),
        patches=tuple(map(_read_patch, data.tables("patch", optional=True))),
    )
    start.refuse_rest()
    data.refuse_rest()
    _check_discs(data, arena)
    return arena


def arena_toml(arena: Arena) -> str:
    """The arena as the text of a file that `load_arena` reads back to the same values."""
    start = {"x_m": arena.start.x_m, "y_m": arena.start.y_m, "heading_deg": _degrees(arena.start.heading_rad)}
    walls = [_picked(wall, ("x1_m", "y1_m", "x2_m", "y2_m", "thickness_m")) for wall in arena.walls]
    discs = [_picked(disc, ("name", "x_m", "y_m", "radius_m", "mass_kg", "friction")) for disc in arena.discs]
    patches = []
    for patch in arena.patches:
        shape = ("radius_m",) if patch.radius_m else ("length_m", "width_m")
        patches.append(_picked(patch, ("name", "x_m", "y_m", "grip", "rolling", *shape)))
    whole = {"schema": 1} | _picked(arena, ("name", "length_m", "width_m", "friction", "restitution"))
    return toml_text(whole | {"start": start, "wall": walls or None, "disc": discs or None, "patch": patches or None})


def _picked(value: object, keys: tuple[str, ...]) -> dict[str, object]:
    return {key: getattr(value, key) for key in keys}


def _degrees(angle_rad: float) -> float:
    """What reads back as the very same angle: a replay begins where the run began, to the last bit."""
    degrees = math.degrees(angle_rad)
    beside = [degrees, math.nextafter(degrees, -math.inf), math.nextafter(degrees, math.inf)]
    return next((one for one in beside if math.radians(one) == angle_rad), degrees)


def _read_wall(entry: Table) -> Wall:
    x1_m, y1_m, x2_m, y2_m = (entry.get(key, float) for key in ("x1_m", "y1_m", "x2_m", "y2_m"))
    wall = Wall(x1_m, y1_m, x2_m, y2_m, _size(entry, "thickness_m", 0.02))
    entry.refuse_rest()
    return wall


def _read_disc(entry: Table) -> Disc:
    disc = Disc(
        name=entry.get("name", str),
        x_m=entry.get("x_m", float),
        y_m=entry.get("y_m", float),
        radius_m=_size(entry, "radius_m"),
        mass_kg=_size(entry, "mass_kg"),
        friction=_within(entry, "friction", 0.3, 10.0),
    )
    entry.refuse_rest()
    if not disc.mass_kg >= 1e-3:
        raise entry.fail("mass_kg", f"expected at least 0.001 kg, got {disc.mass_kg:g}")
    if disc.radius_m < 5e-3:
        raise entry.fail("radius_m", f"expected at least 0.005 m, got {disc.radius_m:g}")
    return disc


def _read_patch(entry: Table) -> Patch:
    is_round = entry.has("radius_m")
    if is_round and (entry.has("length_m") or entry.has("width_m")):
        raise entry.fail("radius_m", "a patch is round (radius_m) or a rectangle (length_m, width_m), not both")
    patch = Patch(
        name=entry.get("name", str),
        x_m=entry.get("x_m", float),
        y_m=entry.get("y_m", float),
        grip=_size(entry, "grip"),
        rolling=_within(entry, "rolling", 0.05, 10.0),
        length_m=0.0 if is_round else _size(entry, "length_m"),
        width_m=0.0 if is_round else _size(entry, "width_m"),
        radius_m=_size(entry, "radius_m") if is_round else 0.0,
    )
    entry.refuse_rest()
    return patch


def _check_discs(data: Table, arena: Arena) -> None:
    """A disc that begins in something would be thrown out of it."""
    for i, disc in enumerate(arena.discs):
        free = Arena(arena.length_m, arena.width_m, walls=arena.walls, discs=arena.discs[:i])
        why = free.in_the_way(disc.radius_m, Pose(disc.x_m, disc.y_m, 0.0))
        if why:
            raise data.fail(f"disc[{i}]", why.replace("a robot", f"the disc {disc.name!r}", 1))


def _size(data: Table, key: str, *default: float) -> float:
    value: float = data.get(key, float, *default)
    if not 0.0 < value <= MOST_M:
        raise data.fail(key, f"expected more than 0 and at most {MOST_M:g}, got {value:g}")
    return value


def _within(data: Table, key: str, default: float, most: float) -> float:
    value: float = data.get(key, float, default)
    if not 0.0 <= value <= most:
        raise data.fail(key, f"expected 0 to {most:g}, got {value:g}")
    return value
