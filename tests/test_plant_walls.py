"""A robot at a wall, against the figures of the reference plant model, section 3.3, and what follows from statics.

The room is 1.0 m x 0.8 m; the robot's radius is 0.08 m, so that it touches the wall ahead at x = 0.42 m.
"""

import math

import pytest
from bases import m2006, mecanum, omni3, omni4

from bench.kinematics import Kinematics
from bench.messages import BodyTwist, Pose
from bench.plant import STEP_S, Arena, Plant

ROOM = Arena(1.0, 0.8)
AT_THE_WALL = Pose(0.42, 0.0, 0.0)
SIN75 = math.sin(math.radians(75.0))
FORWARDS = (1.0, 0.0, -1.0)


def run(plant: Plant, currents_a, steps: int) -> Plant:
    for _ in range(steps):
        plant.step(currents_a)
    return plant


def stalled(current_a: float, **changes) -> Plant:
    plant = Plant(m2006(**changes), arena=ROOM, pose=Pose(0.415, 0.0, 0.0))
    return run(plant, [current_a * sign for sign in FORWARDS], 600)


def drive_n(plant: Plant) -> float:
    """What the two front wheels push forward with."""
    (right, _), _, (left, _) = plant.contact_forces_n
    return (right - left) * SIN75


# --- stall: the splitting error and its cure ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("current_a", "changes"),
    [(1.0, {"ground_grip": 2.0}), (1.0, {"ground_grip": 2.0, "body_cog_height_m": 0.0}), (0.3, {}), (0.5, {})],
)
def test_below_its_grip_a_stalled_robot_stands_still_with_its_wheels_at_rest(current_a, changes):
    """Solved apart, floor and wall let the wheels creep at 0.247 rad/s; solved together they stand, to the last bit."""
    plant = stalled(current_a, **changes)
    pose, angles = plant.pose, plant.wheel_angles_rad
    assert 0.42 < pose.x_m < 0.4202
    for _ in range(100):
        run(plant, [current_a * sign for sign in FORWARDS], 1)
        assert plant.wheel_speeds_radps == [0.0, 0.0, 0.0]
        assert plant.twist == (0.0, 0.0, 0.0)
    assert plant.wheel_angles_rad == angles
    assert plant.pose == pytest.approx(pose, abs=1e-8)  # the engine still takes back overlap


@pytest.mark.parametrize("current_a", [0.4, 0.7, 1.0])
def test_the_stall_force_lies_in_the_band_of_the_motors_friction(current_a):
    """At 1 A 11.45 to 14.31 N: 2 sin 75/r (Kt i -+ tau_c)."""
    plant = stalled(current_a, ground_grip=2.0, ground_rolling=0.0, body_cog_height_m=0.0)
    least, most = (2.0 * SIN75 / 0.027 * (0.18 * current_a + sign * 0.020) for sign in (-1.0, 1.0))
    if current_a == 1.0:
        assert (least, most) == pytest.approx((11.45, 14.31), abs=0.005)
    force_n, sideways_n = plant.wall_force_n
    assert least - 1e-9 <= -force_n <= most + 1e-9
    assert -force_n == pytest.approx(drive_n(plant), abs=1e-9)
    assert abs(sideways_n) < 1e-9


def test_a_wall_never_pulls_and_holds_no_more_than_asked():
    plant = stalled(1.0, ground_grip=2.0)
    run(plant, (-0.6, 0.0, 0.6), 200)
    assert plant.pose.x_m < 0.42
    assert plant.wall_force_n == (0.0, 0.0)
    assert plant.twist.vx_mps < -0.05


@pytest.mark.parametrize("current_a", [1.0, 2.0, 5.0])
def test_above_its_grip_it_pushes_with_2_mu_n_sin_75_and_spins(current_a):
    plant = stalled(current_a, ground_rolling=0.0, body_cog_height_m=0.0)
    assert -plant.wall_force_n[0] == pytest.approx(2.0 * 0.7 * 6.23441 * SIN75, abs=1e-4)  # 8.43 N
    assert plant.slip_mps[0] < -0.1
    assert plant.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert plant.pose.x_m == pytest.approx(0.42, abs=2e-4)


def test_a_wall_that_pushes_above_the_floor_takes_load_from_the_wheels_that_press():
    """Push F at height h tips like acceleration F/m does: F = m 4.02788, the forward grip of section 2."""
    plant = stalled(2.0, ground_rolling=0.0)
    assert -plant.wall_force_n[0] == pytest.approx(1.6 * 4.02788, abs=1e-4)
    front, rear, _ = plant.wheel_loads_n
    assert 2.0 * front + rear == pytest.approx(1.6 * 9.81)
    assert rear - 2.0 * front * math.cos(math.radians(75.0)) == pytest.approx(0.035 * 1.6 * 4.02788 / 0.061, abs=1e-4)


@pytest.mark.parametrize("robot", [omni3(), omni4(), mecanum()], ids=["omni3", "omni4", "mecanum"])
@pytest.mark.parametrize("bearing_deg", [0.0, 90.0, 180.0, 270.0])
def test_every_layout_stalls_at_every_wall(robot, bearing_deg):
    """Below the grip: the wheels that push stand; the wall takes what the floor gives, and nothing turns."""
    angle = math.radians(bearing_deg)
    rows = Kinematics(robot.wheels).inverse_rows
    pattern = [row[0] * math.cos(angle) + row[1] * math.sin(angle) for row in rows]
    currents = [0.25 * share / max(map(abs, pattern)) for share in pattern]
    start = Pose(0.415 * math.cos(angle), 0.315 * math.sin(angle), 0.0)
    plant = run(Plant(robot, arena=ROOM, pose=start), currents, 700)
    pose, angles = plant.pose, plant.wheel_angles_rad
    run(plant, currents, 50)
    assert plant.wheel_angles_rad == angles
    assert plant.pose == pytest.approx(pose, abs=1e-8)
    assert plant.wheel_speeds_radps == [0.0] * len(robot.wheels)
    floor = [0.0, 0.0]
    for wheel, (along, across) in zip(robot.wheels, plant.contact_forces_n, strict=True):
        axis = wheel.heading_rad + wheel.roller_rad + plant.pose.heading_rad
        floor[0] += along * math.cos(axis) - across * math.sin(axis)
        floor[1] += along * math.sin(axis) + across * math.cos(axis)
    push_x, push_y = plant.wall_force_n
    assert (floor[0] + push_x, floor[1] + push_y) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert math.hypot(push_x, push_y) > 1.0


def test_in_a_corner_it_stands_against_two_walls():
    plant = run(Plant(m2006(), arena=ROOM, pose=Pose(0.41, 0.31, 0.0)), (0.4, -0.3, -0.2), 1200)
    pose, angles = plant.pose, plant.wheel_angles_rad
    run(plant, (0.4, -0.3, -0.2), 50)
    assert plant.wheel_angles_rad == angles
    assert plant.pose == pytest.approx(pose, abs=1e-8)
    assert pose[:2] == pytest.approx((0.42, 0.32), abs=2e-4)
    force = plant.wall_force_n
    assert max(force) < -0.5


# --- impact ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed_mps", [1.0, 2.0, 3.0, 4.0, 5.0])
@pytest.mark.parametrize("direction_deg", [0, 90, 180, 270, 37])
def test_no_impact_gets_through_a_wall(speed_mps, direction_deg):
    angle = math.radians(direction_deg)
    twist = BodyTwist(speed_mps * math.cos(angle), speed_mps * math.sin(angle), 0.0)
    plant = Plant(m2006(), arena=Arena(0.5, 0.4), twist=twist)
    deepest = 0.0
    for _ in range(300):
        plant.step((0.0, 0.0, 0.0))
        x, y, _ = plant.pose
        deepest = max(deepest, abs(x) - (0.25 - 0.08), abs(y) - (0.2 - 0.08))
    assert 0.0 < deepest <= speed_mps * STEP_S + 2e-4
    assert abs(x) <= 0.25 - 0.08 + 2e-4
    assert abs(y) <= 0.2 - 0.08 + 2e-4


def test_walls_are_as_elastic_and_as_rough_as_the_arena_says():
    def after_impact(arena: Arena, vy_mps: float) -> BodyTwist:
        plant = Plant(m2006(), arena, Pose(0.415, 0.0, 0.0), BodyTwist(1.0, vy_mps, 0.0))
        while plant.twist.vx_mps > 0.5:
            plant.step((0.0, 0.0, 0.0))
        return plant.twist

    assert after_impact(Arena(1.0, 0.8, restitution=0.5), 0.0).vx_mps == pytest.approx(-0.5, abs=0.01)
    assert after_impact(Arena(1.0, 0.8, restitution=0.0), 0.0).vx_mps == pytest.approx(0.0, abs=0.01)
    # Sliding to the left along a wall ahead: its friction acts to the right of the body's front, clockwise.
    smooth, rough = (after_impact(Arena(1.0, 0.8, friction=friction), 1.0) for friction in (0.0, 0.3))
    assert rough.vy_mps < smooth.vy_mps - 0.2
    assert rough.omega_radps < smooth.omega_radps - 2.0


@pytest.mark.parametrize(("speed_mps", "deepest_m"), [(1.0, 0.001), (3.0, 0.003), (5.0, 0.005)])
def test_an_impact_goes_no_deeper_than_one_step_and_comes_back(speed_mps, deepest_m):
    """About v h at most: 0.2 mm at 1 m/s, 1.9 at 3, 4.6 at 5 (it depends on where in the step the wall stands)."""
    depths = []
    for start in range(10):
        x = 0.40 - 0.0001 * speed_mps * start
        plant = Plant(m2006(), arena=ROOM, pose=Pose(x, 0.0, 0.0), twist=BodyTwist(speed_mps, 0.0, 0.0))
        depth = 0.0
        for _ in range(30):
            plant.step((0.0, 0.0, 0.0))
            depth = max(depth, plant.pose.x_m - 0.42)
        depths.append(depth)
        # (1 - 0.3)^60 a second: half of what is more than the slop is gone after 32 ms.
        before = max(plant.pose.x_m - 0.42 - 1e-4, 0.0)
        run(plant, (0.0, 0.0, 0.0), 33)
        assert plant.pose.x_m - 0.42 - 1e-4 <= 0.51 * before + 1e-6
    assert 0.5 * deepest_m < max(depths) <= deepest_m


def test_after_an_impact_at_0_83_mps_the_wheels_run_on():
    """29.7 rad/s at the stop, 10.9 after 100 ms without current, while the body stands: no load transfer, as there."""
    start = Pose(0.41957, 0.0, 0.0)
    plant = Plant(m2006(body_cog_height_m=0.0), arena=ROOM, pose=start, twist=BodyTwist(0.83, 0.0, 0.0))
    run(plant, (0.0, 0.0, 0.0), 1)
    assert plant.twist.vx_mps == pytest.approx(0.0, abs=1e-12)
    assert -plant.wall_force_n[0] * STEP_S == pytest.approx(
        1.6 * 0.83, abs=0.01
    )  # the body's momentum, not the wheels'
    assert plant.wheel_speeds_radps[0] == pytest.approx(29.7, abs=0.1)
    run(plant, (0.0, 0.0, 0.0), 100)
    assert plant.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert plant.wheel_speeds_radps[0] == pytest.approx(10.9, abs=0.15)
    # J dw/dt = -(tau_c + b w + r mu N): exponential with offset.
    pull = (0.020 + 0.027 * 0.7 * 6.23441) / 0.0045
    closed = (0.83 * SIN75 / 0.027 - 0.083 + pull) * math.exp(-0.1 * 0.0045 / 1.2e-3) - pull
    assert plant.wheel_speeds_radps[0] == pytest.approx(closed, abs=0.05)


def test_an_elastic_wall_throws_it_back_and_its_wheels_pull_it_forwards_again():
    start = Pose(0.41957, 0.0, 0.0)
    robot = m2006(body_cog_height_m=0.0)
    plant = Plant(robot, Arena(1.0, 0.8, restitution=0.5), start, BodyTwist(0.83, 0.0, 0.0))
    run(plant, (0.0, 0.0, 0.0), 1)
    assert plant.twist.vx_mps == pytest.approx(-0.415, abs=1e-3)
    run(plant, (0.0, 0.0, 0.0), 100)
    assert plant.twist.vx_mps == pytest.approx(0.12, abs=0.005)


def test_an_oblique_impact_turns_the_robot_by_what_the_wall_rubs():
    """Impulse friction times the normal one at the rim: the moment is clockwise for a wall ahead passed to the left."""
    robot = m2006()
    plant = Plant(robot, ROOM, Pose(0.4199, 0.0, 0.0), BodyTwist(1.0, 1.0, 0.0))
    run(plant, (0.0, 0.0, 0.0), 1)
    push_x, push_y = plant.wall_force_n
    assert push_y == pytest.approx(0.3 * push_x, rel=1e-9)
    assert plant.twist.omega_radps == pytest.approx(push_y * STEP_S * 0.08 / 0.0056, abs=0.05)


def test_a_robot_that_slides_along_a_wall_is_rubbed_by_friction_times_its_push():
    robot = m2006(body_cog_height_m=0.0, ground_rolling=0.0)
    for friction in (0.0, 0.3):
        room = Arena(40.0, 0.8, friction=friction)
        plant = Plant(robot, room, Pose(-15.0, 0.32, 0.0), BodyTwist(1.0, 0.0, 0.0))
        run(plant, (0.9, -1.0, -0.9), 200)
        push_x, push_y = plant.wall_force_n
        assert push_y < -1.0
        assert plant.twist.vx_mps > 0.1
        assert push_x == pytest.approx(friction * push_y, abs=1e-9)


# --- nothing else changes -------------------------------------------------------------------------------------------


def test_walls_out_of_reach_change_no_bit():
    open_floor, room = Plant(m2006(), arena=None), Plant(m2006())
    for step in range(2000):
        currents = (1.5, 0.2, -0.4) if step < 900 else (-0.8, 0.5, 0.3)
        open_floor.step(currents)
        room.step(currents)
        assert (room.pose, room.twist, room.wheel_angles_rad) == (
            open_floor.pose, open_floor.twist, open_floor.wheel_angles_rad,
        )  # fmt: skip


def test_a_wall_once_touched_and_left_is_forgotten():
    touched = run(Plant(m2006(), arena=ROOM, pose=Pose(0.415, 0.0, 0.0)), (0.6, 0.0, -0.6), 300)
    run(touched, (-0.6, 0.0, 0.6), 400)
    fresh = Plant(m2006(), arena=None, pose=touched.pose, twist=touched.twist)
    for _ in range(100):
        touched.step((-0.6, 0.0, 0.6))
        fresh.step((-0.6, 0.0, 0.6))
    assert tuple(touched.twist) == pytest.approx(tuple(fresh.twist), abs=1e-4)
    assert touched.wall_force_n == (0.0, 0.0)
