"""Speed loops at their current limit: who falls behind, and whether the robot turns for it."""

import math
from dataclasses import replace

import pytest
from bases import m2006
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig

from bench.arena import Arena
from bench.config import load_robot
from bench.controller import DirectionKeeper, SpeedController, control_of
from bench.kinematics import Kinematics
from bench.loop import simulated
from bench.odometry import wrap
from bench.plant import Plant
from bench.rc.transmitter import Sticks
from bench.world import SimulatedMotors

ROBOT = load_robot("m2006")
LIMIT_A = ROBOT.limits.current_a


def keeping(robot=ROBOT, keep=True):
    return replace(robot, control=replace(robot.control, keep_direction=keep))


def test_the_robot_file_chooses():
    assert type(control_of(ROBOT, Kinematics(ROBOT.wheels))[1]) is SpeedController
    assert type(control_of(keeping(), Kinematics(ROBOT.wheels))[1]) is DirectionKeeper


def drive(robot, bearing_deg, ticks):
    """Full stick that far from forward, on an open floor; what the robot has turned, in degrees."""
    bench = simulated(robot)
    bench.world.motors = SimulatedMotors(robot, Plant(robot, None))
    rig, turned = Rig(bench=bench).arm(), 0.0
    sticks = Sticks(forward=math.cos(math.radians(bearing_deg)), left=math.sin(math.radians(bearing_deg)))
    for _ in range(ticks):
        before = rig.truth.heading_rad
        rig.run(1, sticks)
        turned += wrap(rig.truth.heading_rad - before)
    return rig, math.degrees(turned)


@pytest.mark.parametrize(("bearing_deg", "without_deg"), [(30, -90), (90, 100), (150, -133)])
def test_asked_for_more_than_its_motors_give_a_robot_goes_slower_and_does_not_turn(bearing_deg, without_deg):
    assert drive(ROBOT, bearing_deg, 2000)[1] == pytest.approx(without_deg, abs=5.0)
    rig, turned_deg = drive(keeping(), bearing_deg, 2000)
    assert abs(turned_deg) < 0.2
    vx_mps, vy_mps, _ = rig.bench.world.plant.twist
    # Where it goes: wheels turn as asked to, and rollers that are pushed sideways slip a little.
    assert math.degrees(math.atan2(vy_mps, vx_mps)) == pytest.approx(bearing_deg, abs=2.0)
    assert 0.4 < math.hypot(vx_mps, vy_mps) < 0.55
    base = rig.bench.base
    shares = [was / asked for was, asked in zip(base.motors.speeds_radps, base.wanted_radps, strict=True)]
    assert max(shares) - min(shares) < 0.01, "every wheel has the same share of its speed"
    assert max(map(abs, rig.bench.world.plant.currents_a)) == pytest.approx(LIMIT_A, abs=0.01), "and one gives all"


def test_a_robot_within_its_motors_means_drives_the_same_to_the_last_bit():
    ends = []
    for keep in (False, True):
        rig = Rig(keeping(m2006(limits_current_a=5.0), keep)).arm()
        rig.run(400, Sticks(forward=0.5, left=0.3, turn=0.2))
        ends.append((rig.truth, rig.believed))
    assert ends[0] == ends[1]


three = st.lists(st.floats(-40, 40), min_size=3, max_size=3)


@given(st.lists(st.tuples(three, three), min_size=1, max_size=6))
def test_currents_are_those_of_one_share_of_the_wanted_speeds(ticks):
    """No more than the limit; as alone where none is above it; and as if a share, 0 to 1, had been asked for."""
    keeper = DirectionKeeper(keeping())
    for wanted, measured in ticks:
        plain, slower = SpeedController(ROBOT), SpeedController(ROBOT)
        plain._integral_a, slower._integral_a = list(keeper._integral_a), list(keeper._integral_a)
        alone, found = plain.step(wanted, measured), keeper.step(wanted, measured)
        assert all(-LIMIT_A <= current <= LIMIT_A for current in found)
        falls_behind = any(
            abs(speed) > 0.2 and math.copysign(1.0, speed) * current >= LIMIT_A
            for speed, current in zip(wanted, alone, strict=True)
        )
        if not falls_behind:
            assert found == alone
            continue
        # The share that the weakest can follow, by halving: the least at which one of them needs the limit.
        low, high = 0.0, 1.0
        for _ in range(60):
            share = 0.5 * (low + high)
            if too_much(slower, [share * speed for speed in wanted], measured):
                high = share
            else:
                low = share
        again = SpeedController(ROBOT)
        again._integral_a = list(slower._integral_a)
        if low > 1e-6 and all(abs(low * speed) > 0.21 or abs(speed) <= 0.2 for speed in wanted):
            assert found == pytest.approx(again.step([low * speed for speed in wanted], measured), abs=1e-6)


def too_much(controller, wanted, measured):
    """Whether a wheel would need more current in the sense in which it is to turn than it may have."""
    trial = SpeedController(replace(ROBOT, limits=replace(ROBOT.limits, current_a=1e9)))
    trial._integral_a = list(controller._integral_a)
    return any(
        math.copysign(1.0, speed) * current > LIMIT_A
        for speed, current in zip(wanted, trial.step(wanted, measured), strict=True)
        if abs(speed) > 0.2
    )


@pytest.mark.parametrize("bearing_deg", [0, 45, 90, 165])
def test_a_stop_from_full_speed_turns_it_by_less(bearing_deg):
    # docs/robots.md: 16 degrees at most without, 7 with, in thirteen directions.
    rig, _ = drive(keeping(), bearing_deg, 1500)
    before, at = rig.truth.heading_rad, rig.truth
    rig.run(400)
    assert abs(math.degrees(wrap(rig.truth.heading_rad - before))) < 8.0
    assert math.dist(at[:2], rig.truth[:2]) < 0.08
    assert rig.bench.world.plant.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_a_robot_that_leans_on_a_wall_has_nothing_left_over_when_its_driver_lets_go():
    robot = keeping()
    bench = simulated(robot)
    bench.world.motors = SimulatedMotors(robot, Plant(robot, Arena(1.0, 0.8)))
    rig = Rig(bench=bench).arm()
    rig.run(2000, Sticks(forward=1.0))
    assert rig.truth.x_m > 0.4, "at the wall"
    assert max(map(abs, bench.world.plant.currents_a)) == pytest.approx(LIMIT_A, abs=0.01)
    rig.run(300)
    assert max(map(abs, bench.world.plant.currents_a)) < 0.05
