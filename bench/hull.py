"""The robot's body, a disc among walls and discs, moved by forces. pymunk lives only here.

What enters: the force on the body and its torque, once a step. What leaves: where it is, how it moves, and which
walls it touched. Wheels and floor are the plant's business.

Mostly nothing is near. In the open a body moves by the few sums that the engine would do, to the last bit
(`tests/test_hull.py` holds them beside it), without the way there and back, which was a sixth of the whole tick.
Near a wall or a disc, and while a disc moves, the engine has it.

Frame: field x, y in metres, heading counter-clockwise. A step moves the body by its old velocity and then changes it.
"""

from __future__ import annotations

import atexit
import math
import weakref
from typing import TypeAlias

import pymunk

from bench.arena import Arena, Disc, Obstacle
from bench.config import Body
from bench.ground.loads import GRAVITY_MPS2
from bench.messages import BodyTwist, Pose

WALL_THICKNESS_M = 0.2
"""Far more than a step at any speed of a robot, so that nothing tunnels."""
NEAR_M = 0.05
"""With anything as near as this the engine has the body. It finds what overlaps: any distance would do."""
LOOK_TICKS = 100
"""How often a body that the engine has is asked whether it is in the open again, twice as far away."""
COLLISION_SLOP_M = 1e-4
"""Overlap that the engine leaves alone. Its own default of 0.1 is meant for pixels."""
ROBOT, WALL = 1, 2
"""Collision types."""
COLLISION_BIAS = (1.0 - 0.3) ** 60
"""Share of an overlap left after a second: an impact at 5 m/s ends 5 mm deep and is back in 0.1 s."""

# The engine's properties without its attribute hooks: a fifth of what it takes to drive the engine.
_set_force, _set_torque = pymunk.Body.force.fset, pymunk.Body.torque.fset  # type: ignore[attr-defined]
_angle_of, _velocity_of = pymunk.Body.angle.fget, pymunk.Body.velocity.fget  # type: ignore[attr-defined]
_angular_velocity_of = pymunk.Body.angular_velocity.fget  # type: ignore[attr-defined]

EngineTouch: TypeAlias = tuple[pymunk.Shape, pymunk.Vec2d, float, pymunk.Vec2d, bool]
"""A wall, the normal towards it, its friction against the body, what the engine pushed it with (N s), just hit."""


class Hull:
    """A robot's body in an arena (`None`: open floor), at a pose and moving with a twist.

    Raises ValueError where it cannot begin: outside of the walls, in something, or at no number.
    """

    __slots__ = (
        "_arena", "_body", "_building", "_discs", "_look_in", "_open", "_per_inertia", "_per_mass", "_radius", "_space",
        "_step_engine", "_x", "_y", "angle_rad", "omega_radps", "touches", "vx_mps", "vy_mps",
    )  # fmt: skip

    def __init__(self, body: Body, arena: Arena | None, pose: Pose, twist: BodyTwist) -> None:
        if not all(map(math.isfinite, (*pose, *twist))):
            raise ValueError(f"a robot cannot start at {pose} with {twist}")
        why = arena.in_the_way(body.radius_m, pose) if arena is not None else ""
        if why:
            raise ValueError(why)
        cos, sin = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        self.vx_mps = cos * twist.vx_mps - sin * twist.vy_mps
        self.vy_mps = sin * twist.vx_mps + cos * twist.vy_mps
        self.omega_radps = twist.omega_radps
        self.angle_rad = pose.heading_rad
        """Not wrapped."""
        self._x, self._y = pose.x_m, pose.y_m
        self._arena, self._radius = arena, body.radius_m
        self._per_mass, self._per_inertia = 1.0 / body.mass_kg, 1.0 / body.inertia_kgm2
        self.touches: list[EngineTouch] = []
        """The walls that the body touched, for whoever clears it."""

        self._space = pymunk.Space()
        _SPACES.add(self._space)
        self._step_engine = self._space.step
        self._space.gravity = (0.0, 0.0)
        self._space.damping = 1.0
        self._space.collision_slop = COLLISION_SLOP_M
        self._space.collision_bias = COLLISION_BIAS
        self._space.on_collision(ROBOT, WALL, post_solve=_note_touch, data=self.touches)
        self._body = pymunk.Body(body.mass_kg, body.inertia_kgm2)
        disc = pymunk.Circle(self._body, body.radius_m)
        disc.friction = disc.elasticity = 1.0  # the engine multiplies both with the wall's
        disc.collision_type = ROBOT
        self._building = pymunk.Body(body_type=pymunk.Body.STATIC)  # what walls are part of, and discs rub on
        self._space.add(self._body, disc, self._building)
        self._discs: list[tuple[pymunk.Body, float]] = []
        if arena is not None:
            self._build(arena)
        # Where the body's centre is in the open: between these x, and these y. Nowhere, where the engine has it.
        self._open: tuple[float, float, float, float] | None = None
        self._look_in = LOOK_TICKS
        if not self._is_open(self._x, self._y):
            self._enter_engine()

    def move(self, x_n: float, y_n: float, torque_nm: float, step_s: float) -> None:
        """Advance by one step with this force and torque, in the field's frame."""
        vx, vy, omega = self.vx_mps, self.vy_mps, self.omega_radps
        if self._open is not None:
            least_x, most_x, least_y, most_y = self._open
            x, y = self._x + vx * step_s, self._y + vy * step_s
            if (least_x < x < most_x and least_y < y < most_y) or self._is_open(x, y):
                self._x, self._y = x, y
                self.angle_rad += omega * step_s
                self.vx_mps = vx + x_n * self._per_mass * step_s
                self.vy_mps = vy + y_n * self._per_mass * step_s
                self.omega_radps = omega + torque_nm * self._per_inertia * step_s
                return
            self._enter_engine()
        body = self._body
        _set_force(body, (x_n, y_n))
        _set_torque(body, torque_nm)
        self._step_engine(step_s)
        self.angle_rad = _angle_of(body)
        self.vx_mps, self.vy_mps = _velocity_of(body)
        self.omega_radps = _angular_velocity_of(body)
        self._look_in -= 1
        if not self._look_in:
            self._look_in = LOOK_TICKS
            self._x, self._y = body.position
            self._is_open(self._x, self._y)

    @property
    def position_m(self) -> tuple[float, float]:
        """Where the centre is."""
        if self._open is not None:
            return self._x, self._y
        x, y = self._body.position  # not read every step: the step has no use for it
        return x, y

    @property
    def discs(self) -> list[Obstacle]:
        """Where the arena's discs are now, in its order."""
        places = ((*body.position, radius) for body, radius in self._discs)
        return [Obstacle(x, y, x, y, radius) for x, y, radius in places]

    @property
    def is_free(self) -> bool:
        """Whether the engine has no contact alive and no disc moves: it remembers no more than its bodies then."""
        alive: list[pymunk.Arbiter] = []
        for body in (self._body, *(body for body, _ in self._discs)):
            body.each_arbiter(alive.append)
        return not alive and not any(any(body.velocity) or body.angular_velocity for body, _ in self._discs)

    def _is_open(self, x: float, y: float) -> bool:
        """Look around from here, and remember how far the body may go before one has to look again."""
        self._open = None
        if self._arena is None:
            self._open = -math.inf, math.inf, -math.inf, math.inf
        elif self.is_free:
            clear = min([self._arena.clearance_m(x, y), *(disc.nearest(x, y)[0] for disc in self.discs)]) - self._radius
            if clear >= 2.0 * NEAR_M:
                side = (clear - NEAR_M) * math.sqrt(0.5)
                self._open = x - side, x + side, y - side, y + side
        return self._open is not None

    def _enter_engine(self) -> None:
        """The engine has the body from here on."""
        body = self._body
        body.position = self._x, self._y
        body.angle = self.angle_rad
        body.velocity = self.vx_mps, self.vy_mps
        body.angular_velocity = self.omega_radps

    def _build(self, arena: Arena) -> None:
        """Walls and discs, as the engine wants them."""
        thick = WALL_THICKNESS_M / 2.0
        far_x, far_y = arena.length_m / 2.0 + thick, arena.width_m / 2.0 + thick  # the inner face is the field's end
        corners = ((-far_x, -far_y), (far_x, -far_y), (far_x, far_y), (-far_x, far_y))
        for start, end in zip(corners, (*corners[1:], corners[0]), strict=True):
            self._add_wall(arena, Obstacle(*start, *end, thick))
        for wall in arena.walls:
            self._add_wall(arena, wall.obstacle)
        for disc in arena.discs:
            self._add_disc(arena, disc)

    def _add_wall(self, arena: Arena, shape: Obstacle) -> None:
        x1, y1, x2, y2, radius = shape
        wall = pymunk.Segment(self._building, (x1, y1), (x2, y2), radius)
        wall.friction, wall.elasticity = arena.friction, arena.restitution
        wall.collision_type = WALL
        self._space.add(wall)

    def _add_disc(self, arena: Arena, disc: Disc) -> None:
        """A body that rubs on the floor: two joints to it that hold with no more than friction."""
        space = self._space
        body = pymunk.Body(disc.mass_kg, pymunk.moment_for_circle(disc.mass_kg, 0.0, disc.radius_m))
        body.position = disc.x_m, disc.y_m
        shape = pymunk.Circle(body, disc.radius_m)
        shape.friction, shape.elasticity = arena.friction, arena.restitution
        slides = pymunk.PivotJoint(self._building, body, (disc.x_m, disc.y_m), (0.0, 0.0))
        slides.max_force = disc.friction * disc.mass_kg * GRAVITY_MPS2
        turns = pymunk.GearJoint(self._building, body, 0.0, 1.0)
        turns.max_force = 2.0 / 3.0 * disc.radius_m * slides.max_force  # a disc that lies flat
        for joint in (slides, turns):
            joint.max_bias = 0.0  # it brakes; it does not pull back to where the disc began
        space.add(body, shape, slides, turns)
        self._discs.append((body, disc.radius_m))


_SPACES: weakref.WeakSet[pymunk.Space] = weakref.WeakSet()


@atexit.register
def _empty_the_spaces() -> None:
    """Who still holds a plant when Python ends (a failed test's traceback does) would have it freed when the engine's
    callbacks are gone, and each body and shape in it says so on stderr.
    """
    for space in _SPACES:
        space.remove(*space.constraints, *space.shapes, *space.bodies)


def _note_touch(arbiter: pymunk.Arbiter, space: pymunk.Space, touches: list[EngineTouch]) -> None:
    """The engine has resolved a contact of robot and wall."""
    touches.append(
        (arbiter.shapes[1], arbiter.normal, arbiter.friction, arbiter.total_impulse, arbiter.is_first_contact)
    )
