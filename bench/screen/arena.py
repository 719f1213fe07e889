"""The field from above: walls, robot with its heading, its trail, and where its odometry believes it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from bench.arena import ORIGIN, Arena, Obstacle, Patch
from bench.config import Robot
from bench.fittings import Bumper
from bench.messages import FOREIGN_BASE, Pose
from bench.screen.canvas import Canvas
from bench.screen.scene import Scene
from bench.screen.text import (
    BAD_BADGE,
    GHOST,
    GRID,
    LABEL,
    PLAIN,
    ROBOT,
    TRAIL,
    WARN,
    Line,
    first_that_fits,
    fit,
    width_of,
)
from bench.sensors import distance_m, is_pressed

LEAST_ZOOM_M, ZOOM_RADII = 1.0, 4.5
"""How wide the picture from close by is: a large robot with its nose has to be in it, in the height too."""
GRID_M, ZOOM_GRIDS = 1.0, 5
TRUE_SIZE_FROM_DOTS = 3.0
"""A robot with a radius of fewer dots is drawn as an arrow: a ring that small shows no heading."""
GHOST_FROM_DOTS = 2.0
"""So far off, odometry gets a cross of its own."""
PATCH_DOTS = 3.0
NOSE_DOTS, NOSE_RADII = 6.0, 1.5
ARROWS = "→↗↑↖←↙↓↘"
BEAM_DOTS = 4.0
"""Between two dots of a range sensor's beam."""
STRIP_DOTS = 2.0
"""How far a pressed bumper stands out from the body: far enough for its own row of dots."""
_WALL = (("│", LABEL),)


def arena(scene: Scene, width: int, height: int) -> list[Line]:
    """The field in a frame. Whole, the frame is the wall; zoomed, the robot stays in the middle and walls are drawn."""
    columns, rows = width - 2, height - 2
    length_m, width_m = scene.arena.length_m, scene.arena.width_m
    if scene.zoom:
        across_m = max(LEAST_ZOOM_M, math.ceil(ZOOM_RADII * scene.robot.body.radius_m))
        caption = f" {across_m:g} m across, around the robot "
        canvas = Canvas(columns, rows)
        view = _View(canvas, scene.snapshot.pose, canvas.width / across_m)
        _ground(view, scene.arena, across_m / ZOOM_GRIDS)
        _walls(view, length_m / 2, width_m / 2)
        trail, slips = _Placed(view).place(scene.trail), _Placed(view).place(scene.slips)
    else:
        caption = f" field {length_m:g} × {width_m:g} m "
        field = _whole_field(scene.arena, columns, rows)
        canvas = field.view.canvas.copy()
        view = _View(canvas, ORIGIN, field.view.scale)
        trail, slips = field.trail.place(scene.trail), field.slips.place(scene.slips)
    _draw(view, scene, trail, slips)
    return [
        _edge("┌", [[(caption, PLAIN)]], "┐", width),
        *canvas.lines(_WALL, _WALL),
        _edge("└", _legend(scene), "┘", width),
    ]


def pressed(scene: Scene) -> list[Bumper]:
    """The robot's bumpers that touch something where it stands."""
    body, pose = scene.robot.body.radius_m, scene.snapshot.pose
    return [one for one in scene.robot.fittings.bumpers if is_pressed(one, body, pose, scene.arena, scene.discs)]


def _legend(scene: Scene) -> list[Line]:
    """What the signs mean, from many words to few; where a bumper is pressed, that instead."""
    bumpers = " ".join(one.name for one in pressed(scene))
    if bumpers:
        return [[(f" BUMPER {bumpers} ", BAD_BADGE)], [(" BUMPER ", BAD_BADGE)]]
    signs: Line = [(" ↑ robot  + odometry ", PLAIN)]
    return [[*signs, ("× slipped ", WARN)], [(" × slipped ", WARN)]] if scene.slips else [signs]


class _View:
    """Metres of the field -> dots of the canvas: x to the right, y up."""

    def __init__(self, canvas: Canvas, centre: Pose, scale: float) -> None:
        self.canvas = canvas
        self.scale = scale
        self._u = canvas.width / 2 - centre.x_m * scale
        self._v = canvas.height / 2 + centre.y_m * scale

    def at(self, x_m: float, y_m: float) -> tuple[float, float]:
        # A robot against the far wall stands on the last dot, not outside of the picture.
        return self._u + x_m * self.scale - 1e-6, self._v - y_m * self.scale - 1e-6


class _Placed:
    """Where the dots of a list of points are that grows at its end and is cut at its beginning: each is placed once."""

    def __init__(self, view: _View) -> None:
        self._view = view
        self._points: list[tuple[float, float]] = []
        self._numbers: list[int] = []

    def place(self, points: Sequence[tuple[float, float]]) -> list[int]:
        """All of them, as `Canvas.place` has it."""
        new = list(points)
        gone = self._points.index(new[0]) if new and new[0] in self._points else 0
        have = len(self._points) - gone
        if new[:have] != self._points[gone:]:
            gone, have = len(self._points), 0
        at = self._view.at
        self._numbers = self._numbers[gone:] + self._view.canvas.place([at(*point) for point in new[have:]])
        self._points = new
        return self._numbers


class _Field:
    """The whole of an arena at one size: what never moves, drawn once, and what has been placed on it."""

    def __init__(self, arena: Arena, columns: int, rows: int) -> None:
        canvas = Canvas(columns, rows)
        scale = min(canvas.width / arena.length_m, canvas.height / arena.width_m)
        self.view = _View(canvas, ORIGIN, scale)
        _ground(self.view, arena, GRID_M)
        self.trail, self.slips = _Placed(self.view), _Placed(self.view)


_whole_field = lru_cache(maxsize=4)(_Field)


def _ground(view: _View, arena: Arena, grid_m: float) -> None:
    """Grid, patches, inner walls."""
    # No grid on the outer walls: there the frame is, or a line.
    columns, rows = math.ceil(arena.length_m / 2 / grid_m), math.ceil(arena.width_m / 2 / grid_m)
    for i in range(1 - columns, columns):
        for k in range(1 - rows, rows):
            view.canvas.dot(*view.at(i * grid_m, k * grid_m), GRID)
    for patch in arena.patches:
        _patch(view, patch)
    for wall in arena.walls:
        _obstacle(view, wall.obstacle)


def _draw(view: _View, scene: Scene, trail: Sequence[int], slips: Sequence[int]) -> None:
    """What moves, the robot on top. `trail` and `slips` as the canvas has placed them."""
    canvas, snapshot = view.canvas, scene.snapshot
    for obstacle in scene.discs:
        _obstacle(view, obstacle)
    canvas.mark(trail, TRAIL)
    canvas.signs(slips, "×", WARN)
    if scene.zoom:
        _beams(view, scene)
    pose, guess = snapshot.pose, snapshot.odometry
    # Right under an arrow it would only flicker between two cells.
    off_dots = math.hypot(guess.x_m - pose.x_m, guess.y_m - pose.y_m) * view.scale
    if snapshot.driver != FOREIGN_BASE and (scene.zoom or off_dots >= GHOST_FROM_DOTS):
        canvas.sign(*view.at(guess.x_m, guess.y_m), "+", GHOST)
    _robot(view, scene)


def _walls(view: _View, half_length: float, half_width: float) -> None:
    left, top = view.at(-half_length, half_width)
    right, bottom = view.at(half_length, -half_width)
    canvas = view.canvas
    # Cut to the picture first: a line of which most lies outside would cost its whole length.
    u0, u1 = max(left, 0.0), min(right, canvas.width - 1.0)
    v0, v1 = max(top, 0.0), min(bottom, canvas.height - 1.0)
    if u0 > u1 or v0 > v1:
        return
    for v in (top, bottom):
        canvas.line(u0, v, u1, v, LABEL)
    for u in (left, right):
        canvas.line(u, v0, u, v1, LABEL)


def _patch(view: _View, patch: Patch) -> None:
    """Dotted, as thick as the eye can tell from the grid."""
    half_length = patch.radius_m or patch.length_m / 2
    half_width = patch.radius_m or patch.width_m / 2
    step_m = max(PATCH_DOTS / view.scale, half_length / 50, half_width / 50)
    for i in range(int(-half_length / step_m), int(half_length / step_m) + 1):
        for k in range(int(-half_width / step_m), int(half_width / step_m) + 1):
            x_m, y_m = patch.x_m + i * step_m, patch.y_m + k * step_m
            if patch.carries(x_m, y_m):
                view.canvas.dot(*view.at(x_m, y_m), GRID)


def _obstacle(view: _View, obstacle: Obstacle) -> None:
    """The outline of a wall or a disc, dot by dot."""
    x1, y1, x2, y2, radius = obstacle
    length = math.hypot(x2 - x1, y2 - y1)
    angle = math.atan2(y2 - y1, x2 - x1)
    canvas = view.canvas
    for k in range(int(length * view.scale) + 1 if length else 0):
        share = k / (length * view.scale)
        if share <= 1.0:
            x, y = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
            for side in (-radius, radius):
                canvas.dot(*view.at(x - side * math.sin(angle), y + side * math.cos(angle)), LABEL)
    points = max(6, int(radius * view.scale * 3))
    for k in range(points + 1):
        turn = angle - math.pi / 2 + math.pi * k / points
        c, s = radius * math.cos(turn), radius * math.sin(turn)
        canvas.dot(*view.at(x2 + c, y2 + s), LABEL)
        canvas.dot(*view.at(x1 - c, y1 - s), LABEL)


def _beams(view: _View, scene: Scene) -> None:
    """What the range sensors see: dots from where each one looks to what it meets."""
    pose = scene.snapshot.pose
    cos, sin = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    across_m = (view.canvas.width + view.canvas.height) / view.scale
    for sensor in scene.robot.fittings.range_sensors:
        x_m = pose.x_m + cos * sensor.x_m - sin * sensor.y_m
        y_m = pose.y_m + sin * sensor.x_m + cos * sensor.y_m
        length_m = min(distance_m(sensor, pose, scene.arena, scene.discs), across_m)
        looks = pose.heading_rad + sensor.heading_rad
        step_m = BEAM_DOTS / view.scale
        for k in range(1, int(length_m / step_m) + 1):
            view.canvas.dot(*view.at(x_m + k * step_m * math.cos(looks), y_m + k * step_m * math.sin(looks)), GRID)


def _robot(view: _View, scene: Scene) -> None:
    pose = scene.snapshot.pose
    canvas = view.canvas
    u, v = view.at(pose.x_m, pose.y_m)
    c, s = math.cos(pose.heading_rad), -math.sin(pose.heading_rad)  # dots count downwards
    radius = scene.robot.body.radius_m * view.scale
    if radius < TRUE_SIZE_FROM_DOTS:
        canvas.line(u, v, u + NOSE_DOTS * c, v + NOSE_DOTS * s, ROBOT)
        canvas.sign(u, v, ARROWS[round(pose.heading_rad / (math.pi / 4)) % 8], ROBOT)
        return
    canvas.dots([(u + radius * x, v + radius * y) for x, y in _circle(max(12, int(radius * 6)))], ROBOT)
    canvas.line(u, v, u + NOSE_RADII * radius * c, v + NOSE_RADII * radius * s, ROBOT)
    for bumper in pressed(scene):
        _bumper(view, bumper, scene.robot, pose)
    for wheel in scene.robot.wheels:
        wx, wy = (wheel.x_m * view.scale, -wheel.y_m * view.scale)
        at_u, at_v = u + c * wx - s * wy, v + s * wx + c * wy
        heading = wheel.heading_rad + pose.heading_rad
        reach = wheel.radius_m * view.scale
        du, dv = reach * math.cos(heading), -reach * math.sin(heading)
        canvas.line(at_u - du, at_v - dv, at_u + du, at_v + dv, ROBOT)


@lru_cache(maxsize=8)
def _circle(points: int) -> list[tuple[float, float]]:
    angles = [2 * math.pi * i / points for i in range(points)]
    return [(math.cos(angle), math.sin(angle)) for angle in angles]


def _bumper(view: _View, bumper: Bumper, robot: Robot, pose: Pose) -> None:
    """A pressed one, as an arc outside of the body's ring."""
    u, v = view.at(pose.x_m, pose.y_m)
    radius = robot.body.radius_m * view.scale + STRIP_DOTS
    points = max(6, int(radius * bumper.span_rad))
    for i in range(points + 1):
        angle = pose.heading_rad + bumper.bearing_rad + bumper.span_rad * (i / points - 0.5)
        view.canvas.dot(u + radius * math.cos(angle), v - radius * math.sin(angle), WARN)


def _edge(left: str, captions: list[Line], right: str, width: int) -> Line:
    inner = width - 2
    words = first_that_fits(captions, inner)
    return fit([(left, LABEL), *words, ("─" * (inner - width_of(words)) + right, LABEL)], width)
