"""The robot that is not there: motors, wheels on a floor, and a body in a walled field.

What enters: the current that each speed controller was told to drive, once a millisecond. What leaves: pose, twist,
wheel angles and speeds, and the currents that really flow. CAN frames, rotor counts and filters are the ESC's business.

A motor's current follows its command with a first-order lag, within the maximum current and within what the supply
leaves above the back-EMF. The wheels have inertia of their own, so what a motor feels of its neighbours (reflected
inertia off the diagonal included), a spinning wheel and a stalled one all come out of the same equations. `contact`
solves the floor; `hull` moves the body and takes its impacts. A wall that was touched in the last step is a row of
the floor's solve in this one (`walls`), so that a stalled robot stands still and its wheels with it.

One step: motors, floor, and the hull with the force and torque of both. The hull moves the body first and changes its
velocity afterwards, as its engine does, so the velocity of this step is travelled in the next one. Hence two rules.
Wheels turn by their old speed too, and the floor is solved at the heading that the body will have half way through that
next move: what the wheels count is then what the body travels, in a bend as well.

Frame: field x, y in metres, heading counter-clockwise; the body's centre of gravity is the origin of its wheels. A wall
pushes at the height of the centre of gravity: wheels that press against it lose load as they do when they accelerate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from bench.arena import FIELD, ORIGIN, Arena, Obstacle
from bench.config import Robot
from bench.ground.contact import Contact
from bench.ground.loads import lift_above, load_rows, tipping_part
from bench.ground.modes import WheelState
from bench.ground.walls import WallRows
from bench.hull import Hull
from bench.messages import TICK_US, ZERO_TWIST, BodyTwist, Pose

STEP_S = TICK_US / 1e6


class Plant:
    """One robot on its wheels in a field (`arena=None`: open floor), rolling with `twist` at the start.

    Wheel values stand in the robot file's wheel order, in the wheel's positive sense. Every list that an attribute
    gives is a new one each step and never changes afterwards. Raises ValueError where the robot would fall over at
    rest, or cannot begin where it is put: outside of the walls, or in something.
    """

    __slots__ = (
        "_acceleration", "_axes", "_contact", "_current_limits", "_feet", "_floor", "_hull", "_lift_above",
        "_load_rows", "_mass", "_patches", "_pushed", "_rests_with", "_rolling", "_still", "_supply", "_torques",
        "_walls", "_wheel_inertia", "_yaw_inertia", "arena", "bad_currents", "currents_a", "wheel_angles_rad",
        "wheel_lift", "wheel_speeds_radps",
    )  # fmt: skip

    def __init__(
        self, robot: Robot, arena: Arena | None = FIELD, pose: Pose = ORIGIN, twist: BodyTwist = ZERO_TWIST
    ) -> None:
        motor, body = robot.motor, robot.body
        # The torque constant without friction; while driving, load friction leaves torque_nm_per_a of it.
        torque = motor.torque_nm_per_a / (1.0 - motor.load_friction)
        self._torques = STEP_S * torque, STEP_S * motor.coulomb_nm, STEP_S * motor.load_friction * torque
        self._supply = motor.supply_v, motor.back_emf_vs, motor.resistance_ohm
        decay = math.exp(-1e3 * STEP_S / motor.current_lag_ms) if motor.current_lag_ms > 0.0 else 0.0
        # Below this wheel speed the supply can drive any current that the controller may ask for.
        free = max(0.0, (motor.supply_v - motor.resistance_ohm * motor.max_current_a) / motor.back_emf_vs)
        self._current_limits = motor.max_current_a, -motor.max_current_a, decay, free
        self._mass, self._yaw_inertia, self._wheel_inertia = body.mass_kg, body.inertia_kgm2, motor.inertia_kgm2
        damped = motor.inertia_kgm2 + STEP_S * motor.viscous_nms
        self._rolling = robot.ground.rolling
        self._floor = _floor(robot.ground.grip, self._rolling)
        ground = replace(robot.ground, rolling=self._floor[1])
        self._contact = Contact(robot.wheels, ground, body.mass_kg, body.inertia_kgm2, damped, twist)
        self._load_rows = load_rows(robot.wheels, body.mass_kg, body.cog_height_m)
        self._lift_above = lift_above(self._load_rows)
        self._acceleration = 0.0, 0.0
        self._pushed: tuple[float, float] | None = None
        self._still: Sequence[WheelState] | None = None  # what the last step had to solve, if it left all standing
        self._rests_with: list[float] | None = None  # commanded currents with which nothing moves any more

        self.currents_a = [0.0] * len(robot.wheels)
        """What flows, after lag and limits."""
        self.wheel_speeds_radps = self._contact.speeds_radps
        self.wheel_angles_rad = [0.0] * len(robot.wheels)
        """Turned since the start, not wrapped."""
        self.bad_currents = 0
        """Commanded currents that were no finite number; each was taken for 0 A."""
        self.wheel_lift = False
        """A wheel would have left the floor: load moves only as far as to tipping, and the motion is a guess."""

        self._hull = Hull(body, arena, pose, twist)
        self._walls = WallRows(body.mass_kg, body.inertia_kgm2, body.radius_m)
        self.arena = arena
        self._patches = [(each, _floor(each.grip, each.rolling)) for each in arena.patches] if arena is not None else []
        self._feet = [(wheel.x_m, wheel.y_m) for wheel in robot.wheels] if self._patches else []
        self._axes = math.cos(pose.heading_rad), math.sin(pose.heading_rad)

    def step(self, currents_a: Sequence[float]) -> None:
        """Advance 1 ms with these commanded currents, A; beyond the motor's maximum they are cut, no number is 0 A."""
        if len(currents_a) != len(self.currents_a):
            raise ValueError(f"{len(currents_a)} currents for {len(self.currents_a)} wheels")
        if self._rests_with is not None and currents_a == self._rests_with:
            return  # as the last step left everything, so would this one
        self._rests_with = None
        hull = self._hull
        omega = hull.omega_radps
        heading = hull.angle_rad + 1.5 * STEP_S * omega
        self._axes = cos, sin = math.cos(heading), math.sin(heading)
        vx_field, vy_field = hull.vx_mps, hull.vy_mps
        vx = cos * vx_field + sin * vy_field
        vy = cos * vy_field - sin * vx_field

        ax, ay = self._acceleration
        self.wheel_lift = False
        if ax * ax + ay * ay > self._lift_above:
            ax, ay = self._at_tipping(ax, ay)
        kick, coulomb, load_friction = self._torques
        most, least, decay, free = self._current_limits
        inertia = self._wheel_inertia
        currents = []
        angles = []
        wheels = []
        # zip(strict=True) would add a twentieth to the whole step; the lengths are checked above.
        for asked, current, speed, angle, (rest, per_ax, per_ay) in zip(  # noqa: B905
            currents_a, self.currents_a, self.wheel_speeds_radps, self.wheel_angles_rad, self._load_rows
        ):
            if not least <= asked <= most:
                asked = self._cut(asked)
            current = asked + (current - asked) * decay
            if not -free <= speed <= free:
                current = self._within_supply(current, speed)
            dry = coulomb + load_friction * (current if current > 0.0 else -current) if load_friction else coulomb
            currents.append(current)
            angles.append(angle + STEP_S * speed)
            wheels.append((inertia * speed + kick * current, dry, STEP_S * (rest + per_ax * ax + per_ay * ay)))
        currents_before, self.currents_a = self.currents_a, currents
        self.wheel_angles_rad = angles

        contact = self._contact
        if self._feet:
            contact.stand_on(self._floors())
        walls = self._lean(cos, sin) if hull.touches else None
        pushed = self._pushed
        if pushed is not None:
            push_x, push_y = (cos * pushed[0] + sin * pushed[1]), (cos * pushed[1] - sin * pushed[0])
            vx, vy = vx + STEP_S * push_x / self._mass, vy + STEP_S * push_y / self._mass
        new_vx, new_vy, new_omega = contact.solve(vx, vy, omega, wheels, walls)
        self.wheel_speeds_radps = contact.speeds_radps
        self._acceleration = ax, ay = (new_vx - vx) / STEP_S, (new_vy - vy) / STEP_S
        if walls is not None:
            self._acceleration = self._by_the_floor(walls, ax, ay)
        if pushed is not None:  # at the height of the centre of gravity: it moves no load
            ax, ay = ax + push_x / self._mass, ay + push_y / self._mass
            self._pushed = None
        mass = self._mass
        turning = self._yaw_inertia * (new_omega - omega) / STEP_S
        hull.move(mass * (cos * ax - sin * ay), mass * (sin * ax + cos * ay), turning, STEP_S)
        if not (new_vx or new_vy or new_omega) and currents == currents_before:
            self._look_for_rest(currents_a, wheels)
        else:
            self._still = None

    def push(self, x_n: float, y_n: float) -> None:
        """A force on the centre of gravity during the next step, in the field's frame."""
        self._pushed = x_n, y_n
        self._rests_with = None

    def set_grip(self, grip: float) -> None:
        """Another grip of the floor, from the next step on. Patches keep theirs."""
        self._rests_with = None
        self._floor = _floor(grip, self._rolling)
        if not self._patches:
            self._contact.stand_on([self._floor] * len(self.currents_a))

    @property
    def pose(self) -> Pose:
        """Where the body is, in the field."""
        x, y = self._hull.position_m
        heading = math.remainder(self._hull.angle_rad, math.tau)
        return Pose(x, y, heading if heading > -math.pi else math.pi)

    @property
    def twist(self) -> BodyTwist:
        """How the body moves, in its own frame."""
        hull = self._hull
        cos, sin, vx, vy = math.cos(hull.angle_rad), math.sin(hull.angle_rad), hull.vx_mps, hull.vy_mps
        return BodyTwist(cos * vx + sin * vy, cos * vy - sin * vx, hull.omega_radps)

    @property
    def slip_mps(self) -> list[float]:
        """How fast each contact slides along its roller axis: body over floor minus what the wheel rolls."""
        (cos, sin), hull = self._axes, self._hull
        vx, vy = hull.vx_mps, hull.vy_mps
        return self._contact.slips_mps(cos * vx + sin * vy, cos * vy - sin * vx, hull.omega_radps)

    @property
    def contact_forces_n(self) -> list[tuple[float, float]]:
        """What the floor did to the body in the last step: for each wheel (along the roller axis, across it)."""
        return [(along / STEP_S, across / STEP_S) for along, across in self._contact.impulses_ns]

    @property
    def wall_force_n(self) -> tuple[float, float]:
        """What the walls that touch the body did to it in the last step, in the field's frame."""
        cos, sin = self._axes
        x = y = 0.0
        for _, _, _, impulse, _ in self._hull.touches:
            x += impulse.x
            y += impulse.y
        if not all(is_first for *_, is_first in self._hull.touches):
            push_x, push_y, _ = self._walls.push_ns()
            x += cos * push_x - sin * push_y
            y += sin * push_x + cos * push_y
        return x / STEP_S, y / STEP_S

    @property
    def inexact_steps(self) -> int:
        """How many steps ended before the forces of the floor were exact: wheels of much inertia under a light body."""
        return self._contact.inexact_steps

    @property
    def discs(self) -> list[Obstacle]:
        """Where the arena's discs are now, in its order."""
        return self._hull.discs

    @property
    def is_free(self) -> bool:
        """Whether the engine remembers no more than where bodies are and how they move."""
        return self._hull.is_free

    @property
    def wheel_loads_n(self) -> list[float]:
        """Weight on each wheel, load transfer of the last step's acceleration included."""
        ax, ay = self._acceleration
        part = tipping_part(self._load_rows, ax, ay)
        return [rest + part * (per_ax * ax + per_ay * ay) for rest, per_ax, per_ay in self._load_rows]

    def _look_for_rest(self, currents_a: Sequence[float], wheels: Sequence[WheelState]) -> None:
        """Find out whether further steps with these commanded currents would change nothing at all, not one bit.

        So it is where two steps in a row had the same to solve and both left everything standing, the engine with
        nothing to push against and no disc that may still slide. One tick in seven of the demo is such a one, and
        then costs next to nothing.
        """
        hull = self._hull
        moves = hull.vx_mps or hull.vy_mps or hull.omega_radps or any(self.wheel_speeds_radps)
        if moves or any(self._acceleration) or hull.touches or hull.discs or self._contact.sweeps:
            self._still = None
        elif self._still == wheels:
            self._rests_with = list(currents_a)
        else:
            self._still = wheels

    def _floors(self) -> list[tuple[float, float]]:
        """Grip and rolling loss under each wheel."""
        x, y = self._hull.position_m
        cos, sin = math.cos(self._hull.angle_rad), math.sin(self._hull.angle_rad)
        floors = []
        for wheel_x, wheel_y in self._feet:
            at_x, at_y = x + cos * wheel_x - sin * wheel_y, y + sin * wheel_x + cos * wheel_y
            floor = self._floor
            for patch, under in self._patches:
                if patch.carries(at_x, at_y):
                    floor = under
            floors.append(floor)
        return floors

    def _lean(self, cos: float, sin: float) -> WallRows:
        """The walls that touched the body at the end of the last step, in the frame of this one."""
        walls = self._walls
        walls.touch(
            [
                (wall, -cos * normal.x - sin * normal.y, sin * normal.x - cos * normal.y, friction)
                for wall, normal, friction, _, _ in self._hull.touches
            ]
        )
        self._hull.touches.clear()
        return walls

    def _by_the_floor(self, walls: WallRows, ax: float, ay: float) -> tuple[float, float]:
        """The part of an acceleration that the floor has caused: it alone pushes below the centre of gravity."""
        push_x, push_y, _ = walls.push_ns()
        momentum = self._mass * STEP_S
        return ax - push_x / momentum, ay - push_y / momentum

    def _cut(self, asked: float) -> float:
        """What a motor makes of a current beyond its limits; of what is no number, nothing."""
        if not math.isfinite(asked):
            self.bad_currents += 1
            return 0.0
        most, least, _, _ = self._current_limits
        return most if asked > most else least

    def _at_tipping(self, ax: float, ay: float) -> tuple[float, float]:
        part = tipping_part(self._load_rows, ax, ay)
        self.wheel_lift = part < 1.0
        return part * ax, part * ay

    def _within_supply(self, current: float, speed: float) -> float:
        """What the supply can drive against the back-EMF of a wheel at this speed."""
        supply, back_emf, resistance = self._supply
        return max((-supply - back_emf * speed) / resistance, min(current, (supply - back_emf * speed) / resistance))


def _floor(grip: float, rolling: float) -> tuple[float, float]:
    """Grip and rolling loss: a roller that is harder to turn than to drag slides, and then the floor takes its grip."""
    return grip, min(rolling, grip)
