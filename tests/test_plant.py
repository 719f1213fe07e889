"""The plant against closed forms, open loop. Numbers without a source beside them: reference plant model, 2 and 4.1.

Wheels of the default robot: 1 front right, 2 rear, 3 front left, positive along the counter-clockwise tangent. Forward
is therefore (+i, 0, -i).
"""

import math
import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import pytest
from bases import m2006, mecanum, omni3, omni4, tangential
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.arena import Patch
from bench.config import Wheel
from bench.kinematics import Kinematics
from bench.messages import BodyTwist, Pose
from bench.plant import Arena, Plant

ORIGIN = Pose(0.0, 0.0, 0.0)
SIN75, COS75 = 0.9659258262890683, 0.25881904510252074
DT = 0.001
FRICTIONLESS = {"motor_coulomb_nm": 0.0, "motor_viscous_nms": 0.0, "ground_rolling": 0.0}


def run(plant: Plant, currents_a, steps: int) -> Plant:
    for _ in range(steps):
        plant.step(currents_a)
    return plant


def kinetic_energy(plant: Plant, robot) -> float:
    vx, vy, omega = plant.twist
    energy = 0.5 * robot.body.mass_kg * (vx * vx + vy * vy) + 0.5 * robot.body.inertia_kgm2 * omega * omega
    return energy + sum(0.5 * robot.motor.inertia_kgm2 * w * w for w in plant.wheel_speeds_radps)


# --- steady motion -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("current_a", "speed_mps"), [(0.3, 0.183179), (0.4, 0.294989), (0.6, 0.518609), (1.0, 0.965848), (1.3, 1.301277)]
)
def test_forward_current_settles_at_the_closed_form_speed(current_a, speed_mps):
    plant = run(Plant(m2006(), arena=None), (current_a, 0.0, -current_a), 6000)
    vx, vy, omega = plant.twist
    assert vx == pytest.approx(speed_mps, abs=1e-5)
    assert (vy, omega) == pytest.approx((0.0, 0.0), abs=1e-9)
    # Wheel 1 turns by +35.775 rad/s for each m/s forward (sin 75 / 0.027), wheel 3 by as much the other way.
    assert plant.wheel_speeds_radps == pytest.approx([35.775 * vx, 0.0, -35.775 * vx], rel=1e-4, abs=1e-9)


def test_equal_currents_turn_the_base_on_the_spot():
    plant = run(Plant(m2006(), arena=None), (0.6, 0.6, 0.6), 6000)
    assert plant.twist.omega_radps == pytest.approx(8.65574, abs=1e-5)
    assert math.hypot(plant.pose.x_m, plant.pose.y_m) < 1e-9
    assert plant.wheel_speeds_radps == pytest.approx([8.65574 * 0.061 / 0.027] * 3, abs=1e-4)


def test_a_straight_run_of_ten_seconds_stays_on_its_line():
    # Without load transfer: a loaded rear wheel rolls a little heavier while the robot speeds up (2 mm in 10 s).
    plant = run(Plant(m2006(body_cog_height_m=0.0), arena=None), (1.0, 0.0, -1.0), 10_000)
    x_m, y_m, heading_rad = plant.pose
    assert x_m == pytest.approx(9.266, abs=1e-3)
    assert (y_m, heading_rad) == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("robot", [omni3(), omni4(), mecanum()], ids=["omni3", "omni4", "mecanum"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_torque_pattern_along_one_axis_moves_the_base_along_it(robot, axis):
    rows = Kinematics(robot.wheels).inverse_rows
    largest = max(abs(row[axis]) for row in rows)
    plant = run(Plant(robot, arena=None), [0.9 * row[axis] / largest for row in rows], 300)
    forwards = plant.twist[axis]
    assert forwards > 0.05
    assert max(abs(s) for s in plant.slip_mps) < 1e-9
    assert plant.wheel_speeds_radps == pytest.approx(Kinematics(robot.wheels).wheel_speeds(plant.twist), abs=0.01)


# --- inertia -----------------------------------------------------------------------------------------------------


def test_start_acceleration_forward():
    plant = run(Plant(m2006(), arena=None), (0.6, 0.0, -0.6), 1)
    assert plant.twist.vx_mps / DT == pytest.approx(1.2787, rel=0.005)


def test_start_acceleration_in_yaw():
    plant = run(Plant(m2006(), arena=None), (0.6, 0.6, 0.6), 1)
    assert plant.twist.omega_radps / DT == pytest.approx(24.88, rel=0.005)


@pytest.mark.parametrize(
    "torques_nm", [(0.08, 0.0, -0.08), (0.04, -0.08, 0.04), (0.05, 0.05, 0.05), (0.01, 0.02, 0.04)]
)
def test_the_mass_matrix_holds_the_wheels_and_their_coupling(torques_nm):
    plant = run(Plant(m2006(**FRICTIONLESS), arena=None), [torque / 0.18 for torque in torques_nm], 1)
    ax, ay, alpha = (value / DT for value in plant.twist)
    # m + J sum Hix^2, m + J sum Hiy^2, Jz + J sum Hiw^2, and J sum Hiy Hiw between y and yaw.
    coupling = 1.2e-3 * (0.061 / 0.027**2) * (2.0 * COS75 - 1.0)
    t1, t2, t3 = torques_nm
    assert 4.672 * ax == pytest.approx(SIN75 / 0.027 * (t1 - t3), abs=2e-3)
    assert 3.4664 * ay + coupling * alpha == pytest.approx((COS75 * (t1 + t3) - t2) / 0.027, abs=2e-3)
    assert coupling * ay + 0.02398 * alpha == pytest.approx(0.061 / 0.027 * (t1 + t2 + t3), abs=2e-4)


def test_a_torque_pattern_without_moment_still_yaws():
    plant = run(Plant(m2006(**FRICTIONLESS), arena=None), (0.04 / 0.18, -0.08 / 0.18, 0.04 / 0.18), 1)
    assert plant.twist.omega_radps / DT == pytest.approx(2.23, rel=0.005)


def test_equal_torques_push_the_base_sideways():
    plant = run(Plant(m2006(**FRICTIONLESS), arena=None), (0.05 / 0.18,) * 3, 1)
    assert plant.twist.vy_mps / DT == pytest.approx(-0.062, abs=0.0006)


# --- loads and grip ----------------------------------------------------------------------------------------------


def test_wheel_loads_at_rest():
    assert Plant(m2006()).wheel_loads_n == pytest.approx([6.234, 3.227, 6.234], abs=1e-3)
    assert Plant(mecanum()).wheel_loads_n == pytest.approx([1.6 * 9.81 / 4.0] * 4)


def test_acceleration_moves_load_to_the_rear_wheel():
    plant = run(Plant(m2006(), arena=None), (1.5, 0.0, -1.5), 20)
    before = plant.twist.vx_mps
    ax = (run(plant, (1.5, 0.0, -1.5), 1).twist.vx_mps - before) / DT
    front, rear, _ = plant.wheel_loads_n
    assert 2.0 * front + rear == pytest.approx(1.6 * 9.81)
    # Moments about the centre of gravity: sum N x = -m h ax.
    assert 2.0 * front * 0.061 * COS75 - rear * 0.061 == pytest.approx(-1.6 * 0.035 * ax, rel=1e-6)


@pytest.mark.parametrize(("current_a", "slips"), [(2.01, False), (2.03, True)])
def test_the_front_wheels_start_to_slip_at_2_02_a(current_a, slips):
    plant = run(Plant(m2006(ground_rolling=0.0), arena=None), (current_a, 0.0, -current_a), 1)
    assert (abs(plant.slip_mps[0]) > 1e-6) is slips
    assert (abs(plant.slip_mps[2]) > 1e-6) is slips


def test_spinning_wheels_push_with_their_grip_and_no_more():
    slick = {"ground_grip": 0.15, "ground_rolling": 0.0, "body_cog_height_m": 0.0}
    assert run(Plant(m2006(**slick), arena=None), (3.0, 0.0, -3.0), 100).twist.vx_mps == pytest.approx(
        0.11291, abs=1e-5
    )
    spin = run(Plant(m2006(**slick), arena=None), (3.0, 3.0, 3.0), 100)
    assert spin.twist.omega_radps == pytest.approx(2.56461, abs=1e-5)
    robot = mecanum(**slick)
    assert run(Plant(robot, arena=None), (3.0, 3.0, 3.0, 3.0), 100).twist.vx_mps == pytest.approx(0.10405, abs=1e-5)
    assert run(Plant(robot, arena=None), (-3.0, 3.0, 3.0, -3.0), 100).twist.vy_mps == pytest.approx(0.10405, abs=1e-5)


def test_forward_grip_with_load_transfer():
    plant = run(Plant(m2006(ground_rolling=0.0), arena=None), (5.0, 0.0, -5.0), 60)
    before = plant.twist.vx_mps
    assert (run(plant, (5.0, 0.0, -5.0), 1).twist.vx_mps - before) / DT == pytest.approx(4.02788, abs=2e-5)
    assert not plant.wheel_lift


@pytest.mark.parametrize("share", [0.98, 1.02])
@pytest.mark.parametrize(
    ("direction_deg", "limit_mps2"), [(0, 5.269), (30, 3.555), (45, 2.514), (60, 2.052), (90, 1.777)]
)
def test_the_grip_table_is_the_sharp_bound(direction_deg, limit_mps2, share):
    ux, uy = math.cos(math.radians(direction_deg)), math.sin(math.radians(direction_deg))
    wanted = share * limit_mps2
    # Three forces along the axes (SIN75, COS75), (0, -1), (-SIN75, COS75) with m a in sum and no moment.
    fx, fy = 1.6 * wanted * ux, 1.6 * wanted * uy
    both, difference = fy / (1.0 + COS75), fx / SIN75
    forces = ((both + difference) / 2.0, -both, (both - difference) / 2.0)
    rows = ((SIN75, COS75), (0.0, -1.0), (-SIN75, COS75))
    torques = [
        0.027 * f + 1.2e-3 * wanted * (ux * ax + uy * ay) / 0.027 for f, (ax, ay) in zip(forces, rows, strict=True)
    ]
    robot = m2006(**FRICTIONLESS, body_cog_height_m=0.0)
    plant = run(Plant(robot, arena=None), [torque / 0.18 for torque in torques], 1)
    if share < 1.0:
        assert max(map(abs, plant.slip_mps)) < 1e-12
        assert plant.twist == pytest.approx((wanted * ux * DT, wanted * uy * DT, 0.0), abs=1e-9)
    else:
        assert max(map(abs, plant.slip_mps)) > 1e-6


@pytest.mark.parametrize("by", ["robot file", "fault", "patch"])
def test_ice_takes_no_more_than_its_grip_from_a_robot_that_rolls_over_it(by):
    """Rolling loss 6 % of the load, grip 1 %: a roller slides before it turns. Along and across a wheel there is the
    grip once each, so no more than sqrt(2) of it brakes the body, and no more than that is lost in 0.2 s.
    """
    grip, ice_m = 0.01, 20.0
    ice = Patch("ice", 0.0, 0.0, grip=grip, rolling=0.06, length_m=ice_m, width_m=ice_m)
    arena = Arena(ice_m, ice_m, patches=(ice,)) if by == "patch" else None
    robot = m2006(ground_rolling=0.06, **{"ground_grip": grip} if by == "robot file" else {})
    plant = Plant(robot, arena, twist=BodyTwist(0.5, 0.0, 0.0))
    if by == "fault":
        plant.set_grip(grip)
    run(plant, [0.0] * 3, 200)
    lost_mps = 0.5 - plant.twist.vx_mps
    assert 0.001 < lost_mps <= math.sqrt(2.0) * grip * 9.81 * 0.2


def test_hard_braking_lifts_the_rear_wheel_and_weighs_no_more_than_the_robot():
    plant = Plant(m2006(), arena=None, twist=BodyTwist(2.0, 0.0, 0.0))
    lifted = 0
    for step in range(1000):
        plant.step((-5.0, 0.0, 5.0) if step % 400 < 200 else (5.0, 0.5, 6.0))
        lifted += plant.wheel_lift
        assert min(plant.wheel_loads_n) >= 0.0
        assert sum(plant.wheel_loads_n) == pytest.approx(1.6 * 9.81)
    assert lifted > 90


def test_braking_below_4_42_mps2_keeps_the_rear_wheel_down():
    plant = Plant(m2006(**FRICTIONLESS), arena=None, twist=BodyTwist(1.0, 0.0, 0.0))
    for share, lifts in ((0.99, False), (1.01, True)):
        current_a = share * 4.42 * 4.672 * 0.027 / (2.0 * SIN75 * 0.18)
        run(plant, (-current_a, 0.0, current_a), 5)
        assert plant.wheel_lift is lifts


# --- motors ------------------------------------------------------------------------------------------------------

WHEELS_IN_THE_AIR = {"ground_grip": 1e-12, "ground_rolling": 0.0}


def test_the_current_follows_its_command_with_the_lag_of_the_loop():
    plant = Plant(m2006(motor_current_lag_ms=2.0), arena=None)
    for step in range(1, 6):
        plant.step((1.0, 0.0, -0.5))
        assert plant.currents_a == pytest.approx([1.0 - math.exp(-step / 2.0), 0.0, -0.5 + 0.5 * math.exp(-step / 2.0)])


def test_without_lag_the_current_is_the_command():
    assert run(Plant(m2006()), (0.6, 0.1, -0.3), 1).currents_a == [0.6, 0.1, -0.3]


def test_the_supply_limits_the_speed_of_a_free_wheel():
    # Kt (24 - Ke w)/R = tau_c + b w at 52.305 rad/s, 499.5 rpm; ten amperes flow up to (24 - 4)/0.448 = 44.64 rad/s.
    plant = Plant(m2006(**WHEELS_IN_THE_AIR), arena=None)
    while plant.wheel_speeds_radps[0] < 44.5:
        plant.step((10.0, -10.0, 0.0))
        assert plant.currents_a == [10.0, -10.0, 0.0]
    run(plant, (10.0, -10.0, 0.0), 500)
    assert plant.wheel_speeds_radps == pytest.approx([52.305, -52.305, 0.0], abs=1e-3)
    assert plant.currents_a[0] == pytest.approx((24.0 - 0.448 * 52.305) / 0.40, abs=1e-2)


def test_load_friction_does_nothing_while_driving():
    plant = run(Plant(m2006(motor_load_friction=0.27), arena=None), (0.6, 0.0, -0.6), 6000)
    assert plant.twist.vx_mps == pytest.approx(0.518609, abs=1e-5)


def test_load_friction_helps_the_braking_motor():
    # 0.313 N m/A at 0.27: Kt (1 + mu_g)/(1 - mu_g).
    plants = [
        run(
            Plant(m2006(motor_load_friction=0.27, **WHEELS_IN_THE_AIR), twist=BodyTwist(0.5, 0.0, 0.0)), (-i, 0.0, i), 1
        )
        for i in (0.3, 0.4)
    ]
    weak, strong = (plant.wheel_speeds_radps[0] for plant in plants)
    assert 1.2e-3 * (weak - strong) / DT / 0.1 == pytest.approx(0.313, rel=0.005)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300, -1e300])
def test_an_impossible_current_is_contained(bad):
    plant = run(Plant(m2006()), (bad, 0.0, bad), 1)
    cut = math.copysign(10.0, bad) if math.isfinite(bad) else 0.0
    assert plant.currents_a == [cut, 0.0, cut]
    assert plant.bad_currents == (0 if math.isfinite(bad) else 2)
    run(plant, (bad, 0.0, bad), 200)
    assert all(map(math.isfinite, (*plant.pose, *plant.twist, *plant.wheel_speeds_radps, *plant.wheel_angles_rad)))


# --- rest, energy, symmetry --------------------------------------------------------------------------------------


def test_at_rest_without_current_nothing_moves_at_all():
    pose = Pose(0.3, -0.2, 1.0)
    plant = run(Plant(m2006(), pose=pose), (0.0, 0.0, 0.0), 100)
    assert plant.pose == pose
    assert plant.twist == (0.0, 0.0, 0.0)
    assert plant.wheel_angles_rad == plant.wheel_speeds_radps == plant.slip_mps == [0.0, 0.0, 0.0]


def test_a_current_below_the_friction_holds_the_robot_at_rest():
    plant = run(Plant(m2006()), (0.11, -0.11, 0.11), 200)  # 19.8 of 20 mN m
    assert plant.pose == ORIGIN
    assert run(plant, (0.15, 0.15, 0.15), 200).twist.omega_radps > 0.0


def test_a_robot_that_waits_costs_no_step_and_moves_off_like_any_other():
    """Where nothing moves the plant leaves its steps out; a robot of which it cannot know has the same life."""
    waiting, watched = Plant(m2006()), Plant(m2006())
    for _ in range(900):
        waiting.step([0.05, 0.0, -0.05])
        watched.step([0.05, 0.0, -0.05])
        watched.push(0.0, 0.0)  # something might: each of its steps is worked out
    assert waiting.currents_a == watched.currents_a == pytest.approx([0.05, 0.0, -0.05])
    for currents_a in ([0.3, -0.1, 0.2], [0.0, 0.0, 0.0]):
        for _ in range(300):
            waiting.step(currents_a)
            watched.step(currents_a)
            watched.push(0.0, 0.0)
        assert waiting.pose == watched.pose != Pose(0.0, 0.0, 0.0)
        assert waiting.wheel_angles_rad == watched.wheel_angles_rad
        assert waiting.contact_forces_n == watched.contact_forces_n


@pytest.mark.parametrize("disturb", [lambda plant: plant.push(40.0, 0.0), lambda plant: plant.step([0.6, 0.0, -0.6])])
def test_a_robot_that_waits_can_be_moved(disturb):
    plant = Plant(m2006())
    for _ in range(50):
        plant.step([0.0, 0.0, 0.0])
    disturb(plant)
    for _ in range(3):
        plant.step([0.0, 0.0, 0.0])
    assert plant.pose != Pose(0.0, 0.0, 0.0)


def test_coasting_ends_when_the_closed_form_says_and_in_an_exact_stop():
    plant = Plant(m2006(body_cog_height_m=0.0), arena=None, twist=BodyTwist(0.5, 0.0, 0.0))
    steps = 0
    while plant.twist.vx_mps > 1e-12:
        before = plant.twist.vx_mps
        plant.step((0.0, 0.0, 0.0))
        assert plant.twist.vx_mps < before
        steps += 1
    # m dv/dt = -(F + B v): dry friction of two motors and rolling loss, then the viscous part.
    constant = 2.0 * SIN75 / 0.027 * 0.020 + 0.05 * (2.0 * 6.2344 * COS75 + 3.2272)
    viscous = 2.0 * 0.0045 * (SIN75 / 0.027) ** 2
    assert steps * DT == pytest.approx(4.672 / viscous * math.log(1.0 + 0.5 * viscous / constant), abs=0.002)
    run(plant, (0.0, 0.0, 0.0), 20)  # the engine may round for a few steps
    stopped = plant.pose, plant.wheel_angles_rad
    run(plant, (0.0, 0.0, 0.0), 200)
    assert (plant.pose, plant.wheel_angles_rad) == stopped
    assert plant.twist == (0.0, 0.0, 0.0)
    assert plant.wheel_speeds_radps == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("heading_rad", [0.0, 0.3, 1.9, -2.6])
@pytest.mark.parametrize("twist", [(0.3, 0.2, 4.0), (-0.1, 0.4, -9.0), (0.0, 0.0, 3.0)])
def test_any_coasting_ends_in_an_exact_stop(heading_rad, twist):
    plant = Plant(m2006(), arena=None, pose=Pose(0.0, 0.0, heading_rad), twist=BodyTwist(*twist))
    pose = run(plant, (0.0, 0.0, 0.0), 2000).pose
    assert plant.twist == (0.0, 0.0, 0.0)
    assert run(plant, (0.0, 0.0, 0.0), 50).pose == pose


@pytest.mark.parametrize("robot", [m2006(), omni4(), mecanum()], ids=["m2006", "omni4", "mecanum"])
@settings(deadline=None, max_examples=15)
@given(vx=st.floats(-3, 3), vy=st.floats(-3, 3), omega=st.floats(-20, 20))
def test_without_current_energy_never_grows(robot, vx, vy, omega):
    plant = Plant(robot, arena=Arena(2.0, 2.0), twist=BodyTwist(vx, vy, omega))
    currents = (0.0,) * len(robot.wheels)
    energy = kinetic_energy(plant, robot)
    for _ in range(200):
        plant.step(currents)
        before, energy = energy, kinetic_energy(plant, robot)
        assert energy <= before * (1.0 + 1e-12)


def test_the_start_pose_turns_and_moves_the_path_and_nothing_else():
    turn, x0, y0 = 2.1, 0.4, -0.7
    here = Plant(m2006(), arena=None)
    there = Plant(m2006(), arena=None, pose=Pose(x0, y0, turn))
    for step in range(1500):
        currents = (1.5, 0.2, -0.4) if step < 700 else (-0.8, 0.5, 0.3)
        here.step(currents)
        there.step(currents)
    assert there.twist == pytest.approx(here.twist, abs=1e-9)
    x, y, heading = here.pose
    c, s = math.cos(turn), math.sin(turn)
    assert there.pose == pytest.approx(
        (x0 + c * x - s * y, y0 + s * x + c * y, math.remainder(heading + turn, math.tau)), abs=1e-9
    )


def test_mirrored_currents_mirror_the_path():
    left, right = Plant(m2006(), arena=None), Plant(m2006(), arena=None)
    for step in range(1500):
        i1, i2, i3 = (2.5, 0.2, -0.4) if step < 700 else (-0.8, 0.5, 0.3)
        left.step((i1, i2, i3))
        right.step((-i3, -i2, -i1))
    x, y, heading = left.pose
    assert right.pose == pytest.approx((x, -y, -heading), abs=1e-9)


def test_half_the_currents_of_a_bend_give_the_pose_that_the_wheels_count():
    """Without slip the encoders know the path: exact arcs from wheel increments end where the body is."""
    plant = Plant(m2006(), arena=None)
    kinematics = Kinematics(m2006().wheels)
    x = y = heading = 0.0
    angles = plant.wheel_angles_rad
    for _ in range(2000):
        plant.step((0.7, 0.3, -0.4))
        before, angles = angles, plant.wheel_angles_rad
        dx, dy, turn = kinematics.twist([b - a for a, b in zip(before, angles, strict=True)])
        c, s = math.cos(heading + turn / 2.0), math.sin(heading + turn / 2.0)
        x, y, heading = x + c * dx - s * dy, y + s * dx + c * dy, heading + turn
    assert plant.twist.omega_radps > 1.0
    assert (x, y) == pytest.approx(plant.pose[:2], abs=1e-6)
    assert math.remainder(heading, math.tau) == pytest.approx(plant.pose.heading_rad, abs=1e-9)


# --- refusals and determinism ------------------------------------------------------------------------------------


def test_what_cannot_stand_or_fit_is_refused():
    with pytest.raises(ValueError, match="2 currents for 3 wheels"):
        Plant(m2006()).step((0.0, 0.0))
    with pytest.raises(ValueError, match=r"not inside a field of 6\.0 m x 4\.0 m"):
        Plant(m2006(), pose=Pose(2.95, 0.0, 0.0))
    with pytest.raises(ValueError, match="cannot start"):
        Plant(m2006(), arena=None, pose=Pose(math.nan, 0.0, 0.0))


@pytest.mark.parametrize(
    ("wheels", "message"),
    [
        ([tangential(0.0), tangential(40.0), tangential(80.0)], "wheel 'at 40.0' would carry"),
        ([Wheel("a", x, 0.0, h, 0.027, 1) for x, h in ((-0.1, 1.5), (0.0, 0.0), (0.1, 1.6))], "stand in one line"),
    ],
)
def test_a_robot_that_would_fall_over_is_refused(wheels, message):
    with pytest.raises(ValueError, match=message):
        Plant(replace(m2006(), wheels=tuple(wheels)))


WILD_RUN = """
import sys
sys.path.insert(0, {tests!r})
from bases import m2006
from bench.plant import Arena, Plant
plant = Plant(m2006(motor_current_lag_ms=1.0), arena=Arena(1.0, 0.8))
seed = 12345
currents = (0.0, 0.0, 0.0)
for step in range(3000):
    if step % 50 == 0:
        draws = []
        for _ in range(3):
            seed = (seed * 1103515245 + 12345) % 2**31
            draws.append(seed / 2**30 - 1.0)
        currents = tuple(3.0 * draw for draw in draws)
    plant.step(currents)
print([value.hex() for value in (*plant.pose, *plant.twist, *plant.wheel_angles_rad, *plant.slip_mps)])
"""


def test_the_same_run_gives_the_same_floats_in_any_process():
    code = WILD_RUN.format(tests=os.path.dirname(__file__))
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True, text=True, check=True,
        ).stdout
        for hash_seed in ("1", "2")
    ]  # fmt: skip
    assert len(outputs[0]) > 100
    assert outputs[0] == outputs[1]


def test_two_plants_in_one_process_do_not_know_of_each_other():
    histories = []
    for _ in range(2):
        plant = Plant(m2006())
        histories.append([run(plant, (0.9, 0.1, -0.7), 1).pose for _ in range(300)])
    assert histories[0] == histories[1]
    assert all(a != b for a, b in pairwise(histories[0][2:]))


def test_lists_already_given_out_do_not_change():
    plant = run(Plant(m2006()), (0.6, 0.0, -0.6), 10)
    angles, kept = plant.wheel_angles_rad, list(plant.wheel_angles_rad)
    run(plant, (0.6, 0.0, -0.6), 10)
    assert angles == kept != plant.wheel_angles_rad


@pytest.mark.parametrize(("share", "moves"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("heading_rad", [0.0, 2.0])
def test_a_push_below_rolling_loss_and_drive_stick_moves_nothing(heading_rad, share, moves):
    """Reference 4.3. From behind, 2 tau_c sin 75/r of the motors and three wheels' rolling loss hold it."""
    least_n = 2.0 * SIN75 * 0.020 / 0.027 + 0.05 * (2.0 * 6.23441 * COS75 + 3.22717)
    start = Pose(0.0, 0.0, heading_rad)
    plant = Plant(m2006(body_cog_height_m=0.0), arena=None, pose=start)
    for _ in range(200):
        plant.push(share * least_n * math.cos(heading_rad), share * least_n * math.sin(heading_rad))
        plant.step((0.0, 0.0, 0.0))
    assert (plant.twist != (0.0, 0.0, 0.0)) is moves
    assert (plant.pose != start) is moves


KEPT_TO_THE_END = """
import contextvars
from bench.arena import Arena, Disc
from bench.config import load_robot
from bench.plant import Plant
kept = contextvars.ContextVar("kept")
kept.set(Plant(load_robot("m2006"), Arena(discs=(Disc("puck", 1.0, 0.0, 0.05, 0.2),))))
"""


def test_a_plant_that_somebody_holds_when_python_ends_says_nothing():
    """A failed test is held by its traceback, in a plugin's context. The engine then had a line for each wall."""
    done = subprocess.run([sys.executable, "-c", KEPT_TO_THE_END], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
