"""Walls as rows of the floor's solve: the laws that they obey from any state, on every layout, whatever came before.

Without this file's rows nothing else of the solver changes: `test_contact` holds the floor alone to its own laws.
"""

import math

import pytest
from bases import m2006, mecanum, omni3, omni4
from hypothesis import given, settings
from hypothesis import strategies as st
from test_contact import DRY, MASS, NS, WHEEL, YAW, pushed_by_wheels, velocities, wheel_states

from bench.ground.contact import MAX_WALL_SWEEPS, Contact
from bench.ground.walls import WallRows

LAYOUTS = {"004": m2006(), "omni3": omni3(), "omni4": omni4(), "mecanum": mecanum()}
RADIUS = 0.08
MPS = 1e-9
HELD_MPS = 3e-7  # towards or from a wall that the body leans on, where floor and wall all but agree on a direction
CAPPED_MPS, CAPPED_J = 1e-3, 1e-5


def energy(contact: Contact, velocity) -> float:
    vx, vy, omega = velocity
    body = 0.5 * MASS * (vx * vx + vy * vy) + 0.5 * YAW * omega * omega
    return body + sum(0.5 * WHEEL * speed * speed for speed in contact.speeds_radps)


def energy_with(wheels, velocity) -> float:
    """Before the step, the motors' torque taken in."""
    vx, vy, omega = velocity
    body = 0.5 * MASS * (vx * vx + vy * vy) + 0.5 * YAW * omega * omega
    return body + sum(0.5 * momentum * momentum / WHEEL for momentum, _, _ in wheels)


def base_of(layout: str) -> tuple[Contact, WallRows]:
    robot = LAYOUTS[layout]
    return Contact(robot.wheels, robot.ground, MASS, YAW, WHEEL), WallRows(MASS, YAW, RADIUS)


def check_laws(layout, contact, walls, touches, before, wheels, after) -> None:
    """Newton with the walls' impulses; no wall pulls, none is entered, rubbing within friction and against sliding."""
    vx, vy, omega = after
    if contact.sweeps == MAX_WALL_SWEEPS:  # rare; such a step is only nearly right, and must not be wrong
        assert all(nx * vx + ny * vy >= -CAPPED_MPS for _, nx, ny, _ in touches)
        assert all(normal >= 0.0 for normal, _ in walls.impulses_ns)
        assert energy(contact, after) <= energy_with(wheels, before) + CAPPED_J
        return
    px, py, pw = pushed_by_wheels(layout, contact, wheels, after)
    for (_, nx, ny, friction), (normal, tangent) in zip(touches, walls.impulses_ns, strict=True):
        px += nx * normal - ny * tangent
        py += ny * normal + nx * tangent
        pw -= RADIUS * tangent
        away = nx * vx + ny * vy
        rim = nx * vy - ny * vx - RADIUS * omega
        assert normal >= 0.0
        assert away >= -HELD_MPS
        if normal > NS:
            assert away < HELD_MPS
        assert abs(tangent) <= friction * normal + NS
        if abs(rim) > MPS:
            assert tangent == pytest.approx(-math.copysign(friction * normal, rim), abs=NS)
    was, now = ((MASS * vx, MASS * vy, YAW * omega) for vx, vy, omega in (before, after))
    assert (was[0] + px, was[1] + py, was[2] + pw) == pytest.approx(now, abs=NS)


@st.composite
def touching(draw):
    """One wall from anywhere, or two that meet in a corner of 60 to 150 degrees.

    In whole degrees: a wheel's axis is then met exactly or clearly not. In between (micro-radians) the sweeps are slow
    and end at their cap; the motion is right to `HELD_MPS` there, the impulses are not.
    """
    bearing_deg = draw(st.integers(-180, 180))
    bearings_deg = [bearing_deg]
    if draw(st.booleans()):
        bearings_deg.append(bearing_deg + draw(st.integers(30, 120)))
    friction = draw(st.sampled_from((0.0, 0.3, 0.8)))
    angles = map(math.radians, bearings_deg)
    return [(i, math.cos(angle), math.sin(angle), friction) for i, angle in enumerate(angles)]


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=60)
@given(data=st.data())
def test_one_step_at_any_wall_obeys_the_laws(layout, data):
    contact, walls = base_of(layout)
    before, touches = data.draw(velocities), data.draw(touching())
    states = data.draw(st.tuples(*[wheel_states] * len(LAYOUTS[layout].wheels)))
    wheels = [(momentum + torque, DRY, load) for momentum, torque, load in states]
    walls.touch(touches)
    check_laws(layout, contact, walls, touches, before, wheels, contact.solve(*before, wheels, walls))


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=15)
@given(data=st.data())
def test_a_drive_along_walls_obeys_the_laws_in_every_step(layout, data):
    contact, walls = base_of(layout)
    torques_nms = st.tuples(*[st.floats(-3e-4, 3e-4) | st.just(0.0)] * len(LAYOUTS[layout].wheels))
    velocity = (0.0, 0.0, 0.0)
    for _ in range(data.draw(st.integers(1, 4))):
        torques, touches = data.draw(torques_nms), data.draw(touching())
        for _ in range(25):
            wheels = [(1.2e-3 * w + t, DRY, 4e-3) for w, t in zip(contact.speeds_radps, torques, strict=True)]
            walls.touch(touches)
            before, velocity = velocity, contact.solve(*velocity, wheels, walls)
            check_laws(layout, contact, walls, touches, before, wheels, velocity)
