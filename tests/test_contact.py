"""The floor solver against the laws that it must satisfy, whatever the state, the layout and its history."""

import math
from random import Random

import pytest
from bases import m2006, mecanum, omni3, omni4
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.ground.contact import MAX_SWEEPS, Contact

LAYOUTS = {"004": m2006(), "omni3": omni3(), "omni4": omni4(), "mecanum": mecanum()}
MASS, YAW, WHEEL = 1.6, 0.0056, 1.2045e-3
GRIP, ROLLING = 0.7, 0.05
DRY = 2e-5  # 0.02 N m for 1 ms
NS, MPS = 1e-9, 1e-9  # what a solved step may be off by


def contact_of(layout: str) -> Contact:
    robot = LAYOUTS[layout]
    return Contact(robot.wheels, robot.ground, MASS, YAW, WHEEL)


def geometry(layout: str):
    for wheel in LAYOUTS[layout].wheels:
        angle = wheel.heading_rad + wheel.roller_rad
        ax, ay = math.cos(angle), math.sin(angle)
        arm, arm_across = wheel.x_m * ay - wheel.y_m * ax, wheel.x_m * ax + wheel.y_m * ay
        yield ax, ay, arm, arm_across, wheel.radius_m * math.cos(wheel.roller_rad)


def pushed_by_wheels(layout: str, contact: Contact, wheels, after) -> tuple[float, float, float]:
    """Newton for each wheel; every friction within its limit, and at the limit only against the motion. The impulse
    that they give the body, and its moment.
    """
    px = py = pw = 0.0
    vx, vy, omega = after
    rows = zip(geometry(layout), wheels, contact.speeds_radps, contact.impulses_ns, strict=True)
    for (ax, ay, arm, arm_across, rc), (momentum, dry, load), speed, (along, across) in rows:
        px += ax * along - ay * across
        py += ay * along + ax * across
        pw += arm * along + arm_across * across

        slip = ax * vx + ay * vy + arm * omega - rc * speed
        grip = GRIP * load
        assert abs(along) <= grip + NS
        if abs(slip) > MPS:
            assert along == pytest.approx(-math.copysign(grip, slip), abs=NS)

        side = ax * vy - ay * vx + arm_across * omega
        loss = ROLLING * load
        assert abs(across) <= loss + NS
        if abs(side) > MPS:
            assert across == pytest.approx(-math.copysign(loss, side), abs=NS)

        friction = momentum - rc * along - WHEEL * speed
        assert abs(friction) <= dry + rc * NS
        if abs(rc * speed) > MPS:
            assert friction == pytest.approx(math.copysign(dry, speed), abs=rc * NS)
    return px, py, pw


def check_laws(layout: str, contact: Contact, before, wheels, after) -> None:
    """The wheels' laws, and Newton for the body."""
    px, py, pw = pushed_by_wheels(layout, contact, wheels, after)
    was, now = ((MASS * vx, MASS * vy, YAW * omega) for vx, vy, omega in (before, after))
    assert (was[0] + px, was[1] + py, was[2] + pw) == pytest.approx(now, abs=NS)


# Speeds and torques of a robot, and often enough exactly none of one.
velocities = st.tuples(*[st.just(0.0) | st.floats(-3.0, 3.0)] * 2, st.just(0.0) | st.floats(-20.0, 20.0))
wheel_states = st.tuples(
    st.just(0.0) | st.floats(-0.1, 0.1), st.just(0.0) | st.floats(-2e-3, 2e-3), st.floats(0.0, 8e-3)
)


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None)
@given(data=st.data())
def test_one_step_from_any_state_obeys_the_laws(layout, data):
    contact = contact_of(layout)
    count = len(LAYOUTS[layout].wheels)
    before = data.draw(velocities)
    wheels = [(m + torque, DRY, load) for m, torque, load in data.draw(st.tuples(*[wheel_states] * count))]
    check_laws(layout, contact, before, wheels, contact.solve(*before, wheels))


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_a_drive_with_jumping_torques_obeys_the_laws_in_every_step(layout, data):
    contact = contact_of(layout)
    count = len(LAYOUTS[layout].wheels)
    torques_nms = st.tuples(*[st.floats(-3e-4, 3e-4) | st.just(0.0)] * count)
    velocity = (0.0, 0.0, 0.0)
    for _ in range(data.draw(st.integers(1, 4))):
        torques = data.draw(torques_nms)
        for _ in range(25):
            wheels = [(1.2e-3 * w + t, DRY, 4e-3) for w, t in zip(contact.speeds_radps, torques, strict=True)]
            before, velocity = velocity, contact.solve(*velocity, wheels)
            check_laws(layout, contact, before, wheels, velocity)
            assert contact.sweeps < MAX_SWEEPS


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_the_motion_does_not_depend_on_what_the_solver_did_before(layout, data):
    states = st.tuples(velocities, st.tuples(*[wheel_states] * len(LAYOUTS[layout].wheels)))
    (earlier, earlier_wheels), (before, wheels) = data.draw(states), data.draw(states)
    used, fresh = contact_of(layout), contact_of(layout)
    used.solve(*earlier, [(momentum, DRY, load) for momentum, _, load in earlier_wheels])
    wheels = [(momentum, DRY, load) for momentum, _, load in wheels]
    assert fresh.solve(*before, wheels) == pytest.approx(used.solve(*before, wheels), abs=1e-8)
    assert fresh.speeds_radps == pytest.approx(used.speeds_radps, abs=1e-6)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_steady_drive_needs_no_search(layout):
    contact = contact_of(layout)
    count = len(LAYOUTS[layout].wheels)
    velocity = (0.0, 0.0, 0.0)
    searched = 0
    for _ in range(500):
        wheels = [(1.2e-3 * w + 1e-4, DRY, 4e-3) for w in contact.speeds_radps]
        velocity = contact.solve(*velocity, wheels)
        searched += contact.sweeps > 0
    assert searched <= 3, f"{searched} of 500 steps with {count} equal torques left the kept inverse"


def test_a_robot_held_by_its_rolling_loss_needs_no_search():
    contact = contact_of("004")
    wheels = [(2.3e-5, DRY, 6.2e-3), (0.0, DRY, 3.2e-3), (-2.3e-5, DRY, 6.2e-3)]  # 3 mN m more than the dry friction
    sweeps = []
    for _ in range(20):
        assert contact.solve(0.0, 0.0, 0.0, wheels) == (0.0, 0.0, 0.0)
        sweeps.append(contact.sweeps)
    assert sum(sweeps[1:]) == 0, sweeps
    assert any(across for _, across in contact.impulses_ns)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("most_nms", [2.7e-5, 3e-4])  # 0.15 A, mostly at rest against friction, and 1.7 A
def test_torques_that_jump_cost_short_searches_and_no_others(layout, most_nms):
    contact = contact_of(layout)
    random = Random(1)
    velocity = (0.0, 0.0, 0.0)
    sweeps = []
    for _ in range(40):
        torques = [random.uniform(-most_nms, most_nms) for _ in contact.speeds_radps]
        for _ in range(100):
            wheels = [(1.2e-3 * w + t, DRY, 4e-3) for w, t in zip(contact.speeds_radps, torques, strict=True)]
            velocity = contact.solve(*velocity, wheels)
            sweeps.append(contact.sweeps)
    searches = list(filter(None, sweeps))
    assert 0 < len(searches) < 0.05 * len(sweeps)
    assert sum(searches) < 1.0 * len(sweeps)


def test_all_wheels_at_rest_hold_the_body_at_exactly_rest():
    contact = contact_of("004")
    wheels = [(1.5e-5, DRY, 4e-3), (0.0, DRY, 4e-3), (-1.5e-5, DRY, 4e-3)]  # 15 mN m: below the dry friction
    assert contact.solve(0.0, 0.0, 0.0, wheels) == (0.0, 0.0, 0.0)
    assert contact.solve(1e-5, -1e-5, 1e-4, wheels) == (0.0, 0.0, 0.0)
    assert contact.speeds_radps == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_wheel_on_ice_has_the_ices_grip_and_the_others_their_own(layout):
    contact = contact_of(layout)
    count = len(LAYOUTS[layout].wheels)
    wheels = [(3e-4, DRY, 4e-3)] * count  # 0.3 N m: more than any floor takes from a wheel at rest
    velocity = contact.solve(0.0, 0.0, 0.0, wheels)
    ice = [(0.1, 0.01)] + [(GRIP, ROLLING)] * (count - 1)
    contact.stand_on(ice)
    for _ in range(20):
        wheels = [(1.2e-3 * w + 3e-4, DRY, 4e-3) for w in contact.speeds_radps]
        velocity = contact.solve(*velocity, wheels)
        for (along, across), (grip, rolling) in zip(contact.impulses_ns, ice, strict=True):
            assert abs(along) <= grip * 4e-3 + NS
            assert abs(across) <= rolling * 4e-3 + NS
    assert abs(contact.impulses_ns[0][0]) == pytest.approx(0.1 * 4e-3)
    assert abs(contact.impulses_ns[1][0]) > 2.0 * 0.1 * 4e-3


@pytest.mark.parametrize("layout", LAYOUTS)
def test_back_on_its_own_floor_nothing_remembers_the_other(layout):
    ground = LAYOUTS[layout].ground
    contacts = contact_of(layout), contact_of(layout)
    contacts[1].stand_on([(0.1, 0.01)] * len(LAYOUTS[layout].wheels))
    contacts[1].stand_on([(ground.grip, ground.rolling)] * len(LAYOUTS[layout].wheels))
    wheels = [(3e-4 + 1e-5 * i, DRY, 4e-3) for i in range(len(LAYOUTS[layout].wheels))]
    assert contacts[0].solve(0.1, 0.2, 0.3, wheels) == contacts[1].solve(0.1, 0.2, 0.3, wheels)
