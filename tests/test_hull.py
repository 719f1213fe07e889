"""The hull is held beside pymunk itself: in the open and on the way from there to a wall and back, bit for bit."""

import math
import platform
import random
from itertools import pairwise

import pymunk
import pytest

from bench import hull as hull_module
from bench.arena import FIELD, Arena, Disc, Wall
from bench.config import Body
from bench.hull import Hull
from bench.io.still import again, still
from bench.messages import BodyTwist, Pose

STEP_S = 0.001
BODY = Body(mass_kg=3.7, inertia_kgm2=0.043, radius_m=0.13, cog_height_m=0.05)
START, TWIST = Pose(0.31, -0.17, 2.9), BodyTwist(0.4, -0.2, 1.3)
ROOMY = Arena(length_m=40.0, width_m=40.0)
ULPS = 0 if platform.machine() in ("x86_64", "AMD64") else 4
"""Elsewhere a compiler may have fused the engine's multiplications and additions, which then round once, not twice."""


def state(hull):
    return (*hull.position_m, hull.angle_rad, hull.vx_mps, hull.vy_mps, hull.omega_radps)


def same(ours, engines, steps=1):
    return all(
        abs(a - b) <= steps * ULPS * math.ulp(b) and math.copysign(1.0, a) == math.copysign(1.0, b)
        for a, b in zip(ours, engines, strict=True)
    )


def wild(seed, count):
    rng = random.Random(seed)
    return [(rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0), rng.uniform(-0.5, 0.5)) for _ in range(count)]


@pytest.mark.parametrize("arena", [None, ROOMY], ids=["open floor", "field"])
def test_in_the_open_a_body_moves_as_in_the_engine(arena):
    space, body = pymunk.Space(), pymunk.Body(BODY.mass_kg, BODY.inertia_kgm2)
    space.damping = 1.0
    space.add(body, pymunk.Circle(body, BODY.radius_m))
    cos, sin = math.cos(START.heading_rad), math.sin(START.heading_rad)
    body.position, body.angle = (START.x_m, START.y_m), START.heading_rad
    body.velocity = cos * 0.4 - sin * -0.2, sin * 0.4 + cos * -0.2
    body.angular_velocity = 1.3
    ours = Hull(BODY, arena, START, TWIST)
    for step, (x_n, y_n, torque_nm) in enumerate(wild("open", 3000), 1):
        body.force, body.torque = (x_n, y_n), torque_nm
        space.step(STEP_S)
        ours.move(x_n, y_n, torque_nm, STEP_S)
        engines = (*body.position, body.angle, *body.velocity, body.angular_velocity)
        assert same(state(ours), engines, step), f"step {step}"


def driven_about(arena, monkeypatch, near_m):
    """What comes of being pushed from wall to wall: states, the steps that touched a wall, and those of the engine."""
    engine_step, states, touched, engine_steps = pymunk.Space.step, [], [], []

    def counted_step(space, step_s):
        engine_steps.append(len(states))
        engine_step(space, step_s)

    monkeypatch.setattr(pymunk.Space, "step", counted_step)
    monkeypatch.setattr(hull_module, "NEAR_M", near_m)
    hull = Hull(BODY, arena, START, TWIST)
    for step in range(9000):
        x_n, y_n = ((14.0, 3.0), (-14.0, 1.0), (2.0, -9.0), (-5.0, 9.0))[step // 1500 % 4]
        hull.move(x_n - 2.0 * hull.vx_mps, y_n - 2.0 * hull.vy_mps, 0.1 - 0.05 * hull.omega_radps, STEP_S)
        states.append(state(hull))
        if hull.touches:
            touched.append(step)
            hull.touches.clear()
    monkeypatch.undo()
    return states, touched, engine_steps


WALLED = Arena(walls=(Wall(0.9, -2.0, 1.1, 0.8), Wall(-1.5, 0.0, -1.5, 0.4)))
LITTERED = Arena(discs=(Disc("box", 1.4, 0.1, 0.1, 1.0, 0.6), Disc("ball", -0.9, -0.3, 0.02, 0.045, 0.1)))


@pytest.mark.parametrize("arena", [FIELD, WALLED, LITTERED], ids=["field", "walls", "discs"])
def test_to_a_wall_and_back_it_goes_as_it_would_with_the_engine_all_along(arena, monkeypatch):
    states, touched, near = driven_about(arena, monkeypatch, hull_module.NEAR_M)
    engines, engine_touched, always = driven_about(arena, monkeypatch, math.inf)
    assert touched == engine_touched
    assert len(always) == len(states)
    assert sum(b - a > 100 for a, b in pairwise(touched)) >= 3, "it came to several walls"
    assert sum(b - a > 100 for a, b in pairwise(near)) >= 3, "and was in the open between them"
    if not ULPS:
        assert states == engines


@pytest.mark.parametrize("steps", [1000, 2950], ids=["in the open", "near a wall"])
def test_what_is_kept_of_it_goes_on_as_it_did(steps):
    hull = Hull(BODY, FIELD, START, TWIST)
    for _ in range(steps):
        hull.move(3.0, 0.5, 0.0, STEP_S)
    assert hull.is_free
    twin = again(still(hull))
    for _ in range(2000):
        hull.move(3.0, 0.5, 0.0, STEP_S)
        twin.move(3.0, 0.5, 0.0, STEP_S)
    assert state(twin) == state(hull)
    assert len(twin.touches) == len(hull.touches) > 0


def test_a_disc_is_met_wherever_it_has_been_pushed_to():
    hull = Hull(BODY, Arena(discs=(Disc("box", 0.8, -0.17, 0.1, 1.0),)), START, BodyTwist(0.0, 0.0, 0.0))
    for step in range(6000):
        way = -1.0 if 1200 <= step < 2400 else 1.0  # to it, pushing it, back from it and to it again
        hull.move(8.0 * way - 10.0 * hull.vx_mps, -10.0 * hull.vy_mps, 0.0, STEP_S)
    (disc,) = hull.discs
    assert disc.x1_m > 1.2
    assert disc.x1_m - hull.position_m[0] == pytest.approx(BODY.radius_m + 0.1, abs=0.002)


@pytest.mark.parametrize("where", [Pose(2.9, 0.0, 0.0), Pose(0.0, 2.5, 0.0), Pose(math.nan, 0.0, 0.0)])
def test_a_body_that_cannot_begin_there_is_refused(where):
    with pytest.raises(ValueError, match="robot"):
        Hull(BODY, FIELD, where, TWIST)


def test_a_disc_that_spins_is_braked_as_one_that_lies_flat():
    """Friction of an even pressure: 2/3 mu m g r against m r^2 / 2, so that it loses 4 mu g / 3 r each second."""
    grip, radius_m, spin_radps = 0.6, 0.1, 40.0
    hull = Hull(BODY, Arena(discs=(Disc("box", 0.6, -0.17, radius_m, 1.0, grip),)), START, BodyTwist(0.0, 0.0, 0.0))
    ((disc, _),) = hull._discs
    disc.angular_velocity = spin_radps
    for _ in range(200):
        hull.move(0.0, 0.0, 0.0, STEP_S)
    lost_radps = 4.0 * grip * 9.80665 / (3.0 * radius_m) * 0.2
    assert disc.angular_velocity == pytest.approx(spin_radps - lost_radps, rel=1e-3)
