"""Sensors of a robot between four walls: by hand-worked poses, on every side, and pure."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.config import load_robot
from bench.fittings import Bumper, Dock, DockReceiver, Fittings, RangeSensor
from bench.messages import Pose
from bench.plant import FIELD, Arena, Plant
from bench.sensors import ArenaSenses, beacons_seen, distance_m, is_docked, is_pressed
from bench.slamware.sense_payloads import Beacons, Power

AHEAD = RangeSensor("ahead", 0.08, 0.0, 0.0)
LEFT_SIDE = RangeSensor("left", 0.0, 0.08, math.pi / 2)
RADIUS = 0.08


@pytest.mark.parametrize(
    ("sensor", "pose", "distance"),
    [
        (AHEAD, (0.0, 0.0, 0.0), 2.92),
        (AHEAD, (1.0, 0.5, 0.0), 1.92),
        (AHEAD, (0.0, 0.0, math.pi), 2.92),
        (AHEAD, (0.0, 0.5, math.pi / 2), 1.42),
        (AHEAD, (0.0, 0.5, -math.pi / 2), 2.42),
        (LEFT_SIDE, (0.0, 0.5, 0.0), 1.42),
        (LEFT_SIDE, (0.0, 0.5, math.pi / 2), 2.92),
        # 45 degrees towards the corner of x 3, y 2: the wall at y 2 comes first
        (AHEAD, (0.0, 0.0, math.pi / 4), 2.0 * math.sqrt(2) - 0.08),
        (replace(AHEAD, reach_m=1.5), (0.0, 0.0, 0.0), 1.5),
        (replace(AHEAD, heading_rad=math.pi), (0.0, 0.0, 0.0), 3.08),
        (AHEAD, (2.95, 0.0, 0.0), 0.0),
    ],
)
def test_distances(sensor, pose, distance):
    assert distance_m(sensor, Pose(*pose), FIELD) == pytest.approx(distance, abs=1e-12)


def test_on_an_open_floor_nothing_is_seen_or_touched():
    assert distance_m(AHEAD, Pose(0.0, 0.0, 0.0), None) == 4.0
    assert not is_pressed(Bumper("all", 0.0, math.tau), RADIUS, Pose(99.0, 0.0, 0.0), None)


@given(st.floats(-2.9, 2.9), st.floats(-1.9, 1.9), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_a_beam_ends_on_a_wall_or_at_its_reach(x, y, heading, looks):
    sensor = RangeSensor("any", 0.0, 0.0, looks, reach_m=1.0)
    distance = distance_m(sensor, Pose(x, y, heading), FIELD)
    end_x, end_y = x + distance * math.cos(heading + looks), y + distance * math.sin(heading + looks)
    assert abs(end_x) <= 3.0 + 1e-9
    assert abs(end_y) <= 2.0 + 1e-9
    at_wall = abs(abs(end_x) - 3.0) < 1e-9 or abs(abs(end_y) - 2.0) < 1e-9
    assert at_wall or distance == 1.0


FRONT_LEFT = Bumper("left", math.pi / 4, math.pi / 2)
FRONT_RIGHT = Bumper("right", -math.pi / 4, math.pi / 2)


@pytest.mark.parametrize(
    ("pose", "left", "right"),
    [
        ((0.0, 0.0, 0.0), False, False),
        ((2.92, 0.0, 0.0), True, True),  # the wall touches where the two meet
        ((2.92, 0.0, -0.2), True, False),
        ((2.92, 0.0, 0.2), False, True),
        ((2.918, 0.0, 0.2), False, False),  # 2 mm away
        ((2.92, 0.0, math.pi), False, False),  # backwards against it: no bumper there
        ((0.0, 1.92, 0.3), True, False),
        ((0.0, -1.92, -0.3), False, True),
        ((-2.92, 0.0, 3.0), True, False),
        ((2.92, 1.92, 0.2), True, True),  # in a corner: one wall each
    ],
)
def test_bumpers(pose, left, right):
    got = [is_pressed(bumper, RADIUS, Pose(*pose), FIELD) for bumper in (FRONT_LEFT, FRONT_RIGHT)]
    assert got == [left, right]


DOCK = Dock(2.9, 0.0, math.pi)
MAIN = DockReceiver("main", 0.0, math.radians(60.0))


@pytest.mark.parametrize(
    ("pose", "seen"),
    [
        ((1.0, 0.0, 0.0), 7),  # straight in front: main, and the edges of both others
        (
            (1.0, 0.1, 0.0),
            2 | 1,
        ),  # the dock looks to -x, so +y is to its right hand: it sees "left" as one who faces it
        ((1.0, -0.1, 0.0), 2 | 4),
        ((1.0, 0.8, -0.4), 1),
        ((1.0, -0.8, 0.4), 4),
        ((1.0, 0.0, math.pi), 0),  # looking away
        ((1.0, 0.0, 0.5), 7),
        ((1.0, 0.0, 0.6), 0),  # out of view
        ((-0.2, 0.0, 0.0), 0),  # out of reach
        ((2.9, 1.0, -math.pi / 2), 0),  # beside it
    ],
)
def test_dock_beacons(pose, seen):
    assert beacons_seen(MAIN, Pose(*pose), DOCK) == seen
    assert beacons_seen(MAIN, Pose(*pose), None) == 0


@pytest.mark.parametrize(
    ("pose", "docked"),
    [
        ((2.81, 0.0, 0.0), True),
        ((2.79, 0.0, 0.0), False),
        ((2.81, 0.0, 0.2), False),
        ((2.81, 0.0, math.pi), False),
        ((2.99, 0.0, math.pi), False),
    ],
)
def test_docked(pose, docked):
    assert is_docked(RADIUS, Pose(*pose), DOCK) is docked
    assert not is_docked(RADIUS, Pose(*pose), None)


def test_a_robot_at_the_wall_of_its_field():
    robot = load_robot("m2006")
    robot = replace(robot, fittings=replace(robot.fittings, dock=Dock(3.0, 0.0, math.pi)))
    senses = ArenaSenses(robot, Plant(robot, pose=Pose(2.91, 0.0, 0.0)), FIELD)
    assert senses.ranges_m() == pytest.approx([0.01, 1.92, 4.0, 1.92])
    assert senses.contacts() == [False, False]
    assert senses.beacons() == Beacons(3, (0, 7, 0))
    assert senses.power() == Power(100, charging=True, on_dock=True)
    senses = ArenaSenses(robot, Plant(robot, Arena(2.0, 2.0), Pose(0.0, 0.92, math.pi / 2)), Arena(2.0, 2.0))
    assert senses.contacts() == [True, True]
    senses.battery = Power(12)
    assert senses.power() == Power(12)


def test_a_robot_without_fittings_senses_nothing():
    robot = replace(load_robot("m2006"), fittings=Fittings())
    senses = ArenaSenses(robot, Plant(robot), FIELD)
    assert (senses.ranges_m(), senses.contacts(), senses.beacons()) == ([], [], Beacons(3, ()))
