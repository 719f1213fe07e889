"""Field-centric driving on every robot, through RC bytes, in the plant: stick forward is the field's forward.

The field is the one that the robot looked along when it was armed. The truth is the plant's pose; how the heading is
known (driven wheels, dead wheels, gyro) is the robot's business.
"""

import math
from dataclasses import replace

import pytest
from rig import Rig

from bench import rc_decode
from bench.config import Gyro, load_robot, robot_names
from bench.loop import Bench, simulated
from bench.messages import Pose, TickInput
from bench.odometry import wrap
from bench.plant import FIELD, Plant
from bench.rc.transmitter import AT_REST, Sticks
from bench.world import SimulatedMotors, World

START = Pose(0.0, 0.0, 0.7)


class Pilot(Rig):
    """A rig that stands anywhere, turns to headings and says which way it went, both against the heading at arming."""

    def __init__(self, robot, pose=START):
        plain = simulated(robot)
        motors = SimulatedMotors(robot, Plant(robot, FIELD, pose))
        super().__init__(bench=Bench(plain.base, World(robot, core=plain.world.core, motors=motors)))
        self.zero_rad = pose.heading_rad
        self.turned_rad = 0.0
        self.heading_rad = pose.heading_rad

    def hold(self, ticks, sticks=AT_REST):
        """Hold the sticks; `turned_rad` follows the true heading round and round."""
        for _ in range(0, ticks, 10):
            self.run(10, sticks)
            self.turned_rad += wrap(self.truth.heading_rad - self.heading_rad)
            self.heading_rad = self.truth.heading_rad

    def arm_field_centric(self):
        self.arm()
        self.hold(50, Sticks(aux2=True))
        self.hold(20)
        assert self.bench.base.drive.field_centric
        return self

    def turn_to(self, degrees):
        """Roughly, from where it is and the whole way, until it stands: 60 kg overshoot by 35 degrees."""
        way = math.copysign(1.0, math.radians(degrees) - self.turned_rad)
        while way * (math.radians(degrees) - self.turned_rad) > 0.15:
            self.hold(10, Sticks(turn=way))
        self.hold(100)
        while max(map(abs, self.bench.world.plant.twist)) > 0.01:
            self.hold(20)
        assert abs(math.degrees(self.turned_rad) - degrees) < 40.0

    def went(self, sticks):
        """Which way it went in the field of arming, in degrees, when these sticks were held."""
        x_m, y_m, _ = start = self.truth
        while math.dist(self.truth[:2], start[:2]) < 0.03:
            self.hold(20, sticks)
        return math.degrees(math.atan2(self.truth.y_m - y_m, self.truth.x_m - x_m) - self.zero_rad)

    def heading_off_deg(self):
        """What the robot believes to look away from where it looks."""
        return math.degrees(wrap(self.believed.heading_rad + self.zero_rad - self.truth.heading_rad))


def apart_deg(a, b):
    return abs(math.degrees(wrap(math.radians(a - b))))


def robot_with_rc(name):
    robot = load_robot(name)
    return robot if robot.rc is not None else load_robot(name, "uart12")


QUARTERS = (
    (-90, Sticks(forward=0.6), 0.0),
    (90, Sticks(left=0.6), 90.0),
    (180, Sticks(forward=-0.6), 180.0),
    (450, Sticks(left=-0.6), -90.0),
)
THE_OTHER_WAY = tuple((-degrees, sticks, expected) for degrees, sticks, expected in QUARTERS)


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_goes_where_the_field_says(name):
    pilot = Pilot(robot_with_rc(name)).arm_field_centric()
    for degrees, sticks, expected in QUARTERS:
        pilot.turn_to(degrees)
        # Wheels that slip while they brake a turn lose heading, and no driven wheel can know it.
        assert abs(pilot.heading_off_deg()) < 15.0
        assert apart_deg(pilot.went(sticks) + pilot.heading_off_deg(), expected) < 3.0, f"at {degrees} degrees"


def test_with_a_gyro_slip_costs_no_heading():
    # dm3519 brakes a turn of 4 rad/s with more than its floor holds: some degrees a stop, without the gyro.
    pilot = Pilot(replace(load_robot("dm3519"), gyro=Gyro(1))).arm_field_centric()
    for degrees, sticks, expected in THE_OTHER_WAY:
        pilot.turn_to(degrees)
        assert abs(pilot.heading_off_deg()) < 0.1
        assert apart_deg(pilot.went(sticks), expected) < 3.0, f"at {degrees} degrees"


@pytest.mark.parametrize("gyro", [None, Gyro(1)], ids=["wheels", "gyro"])
def test_forward_is_where_the_robot_looked_when_it_was_armed(gyro):
    pilot = Pilot(replace(load_robot("mecanum"), gyro=gyro)).arm_field_centric()
    pilot.turn_to(120)
    pilot.hold(60, Sticks(aux1=True))
    pilot.hold(60)
    assert not pilot.bench.base.drive.armed
    pilot.hold(60, Sticks(aux1=True))
    pilot.hold(60)
    assert pilot.bench.base.drive.armed
    again_rad = pilot.turned_rad
    pilot.turn_to(210)
    expected = math.degrees(again_rad)  # not 0, which was forward before
    assert apart_deg(pilot.went(Sticks(forward=0.6)) + pilot.heading_off_deg(), expected) < 3.0


# --- the same in a transmitter's own numbers -------------------------------------------------------------------------

SBUS_REST = [992] * 16
UPPER, LOWER = 1800, 184


def sbus(**channels):
    raw = list(SBUS_REST)
    raw[4] = raw[5] = LOWER
    for name, value in channels.items():
        raw[{"right": 0, "forward": 1, "clockwise": 3, "aux1": 4, "aux2": 5}[name]] = value
    return rc_decode.encode("sbus", raw)


def uart12(**channels):
    raw = [2048, 2048, 2048, 2048, 0, 0]
    for name, value in channels.items():
        raw[{"clockwise": 0, "forward": 2, "right": 3, "aux1": 4, "aux2": 5}[name]] = value
    return rc_decode.encode("uart12", raw)


@pytest.mark.parametrize(
    ("profile", "encode", "pressed", "forward", "right", "counter_clockwise"),
    [
        # Document 004: below the middle is forward and right, above is clockwise.
        ("uart12", uart12, 1, {"forward": 800}, {"right": 800}, {"clockwise": 0}),
        # FrSky: above the middle is forward, right and clockwise.
        ("frsky-sbus", sbus, UPPER, {"forward": 1500}, {"right": 1500}, {"clockwise": LOWER}),
    ],
)
def test_in_the_numbers_of_transmitters_whose_signs_differ(profile, encode, pressed, forward, right, counter_clockwise):
    bench = simulated(load_robot("mecanum", profile))
    period = bench.robot.rc.period_ms

    def hold(ticks, **channels):
        before = bench.world.plant.pose
        for _ in range(ticks):
            bench.tick(TickInput(encode(**channels) if bench.now_tick % period == 0 else b""))
        after = bench.world.plant.pose
        return math.degrees(math.atan2(after.y_m - before.y_m, after.x_m - before.x_m))

    for channels in ({}, {"aux1": pressed}, {}, {"aux2": pressed}, {}):
        hold(40, **channels)
    assert bench.base.drive.field_centric
    while bench.world.plant.pose.heading_rad < math.pi / 2 - 0.15:
        hold(10, **counter_clockwise)
    hold(200)
    assert apart_deg(hold(250, **forward), 0.0) < 3.0
    hold(200)
    assert apart_deg(hold(250, **right), -90.0) < 3.0
