"""The bus on our omni robots, through the whole chain: wheels from feedback frames, sensors from the plant."""

import math
from dataclasses import replace

import pytest
from bases import omni3, omni4
from hypothesis import given, settings
from hypothesis import strategies as st
from rig import Rig

from bench.base import Base
from bench.config import load_robot
from bench.kinematics import Kinematics
from bench.loop import simulated
from bench.messages import TickInput
from bench.odometry import Odometry
from bench.rc.transmitter import Sticks
from bench.slamware import FrameDecoder, SlamwareCore, encode_frame
from bench.slamware.omni_base import OmniMotion
from bench.slamware.payloads import motor_data_from_answer, wheels_request
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.schedule import FULL

NOT_SUPPORTED = bytes.fromhex("50 03 00 03 00 80 D0")


def with_settings(robot, **changes):
    return replace(robot, slamware=replace(robot.slamware, **changes))


def default(**changes):
    return with_settings(load_robot("m2006"), **changes)


def alone(robot):
    """The same robot without RC: it takes the core alone."""
    return replace(robot, rc=None)


class Asked:
    """A bench whose core is the test: requests go in as bytes, every one answered in its tick."""

    def __init__(self, robot):
        self.bench = simulated(robot)
        self.bench.world.core = None

    def ask(self, payload):
        """The OK's payload, or the whole error."""
        out = self.bench.tick(TickInput(slamware=encode_frame(0xF8, payload, "standard")))
        (event,) = FrameDecoder().feed(out.base_to_core)
        return event.payload if event.code == 2 else out.base_to_core

    def run(self, ticks, payload=None):
        """Run, asking again every 100 ms."""
        for tick in range(ticks):
            if payload is not None and tick % 100 == 0:
                self.ask(payload)
            else:
                self.bench.tick()
        return self


# --- 0x31 --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dialect", ["firmware-2018", "sdk-2020"])
def test_two_wheel_distances_are_refused(dialect):
    assert Asked(default(dialect=dialect)).ask(b"\x31") == NOT_SUPPORTED


@pytest.mark.parametrize("dialect", ["firmware-2018-omni", "firmware-2015"])
def test_rim_distances_and_displacement_are_what_the_wheels_turned(dialect):
    rig = Asked(alone(default(dialect=dialect)))
    plant = rig.bench.world.plant
    before = [0.0, 0.0, 0.0]
    x0, y0, heading0 = plant.pose
    for rims_mps in ((0.1, 0.1, 0.1), (-0.1, 0.0, 0.1), (0.0, -0.08, 0.05)):
        rig.run(1000, wheels_request(rims_mps))
        rig.run(300, wheels_request((0.0, 0.0, 0.0)))
        data = motor_data_from_answer(rig.ask(b"\x31"))
        turned = [angle * 0.027 for angle in plant.wheel_angles_rad]
        assert data.distances_m[:3] == pytest.approx(turned, abs=1.1e-3)
        assert data.distances_m[3] == 0.0
        assert max(abs(new - old) for new, old in zip(turned, before, strict=True)) > 0.02, "it moved"
        before = turned
        x, y, heading = plant.pose
        dx, dy = x - x0, y - y0
        c, s = math.cos(heading0), math.sin(heading0)
        moved = (c * dx + s * dy, c * dy - s * dx)
        assert data.displacement[:2] == pytest.approx(moved, abs=2e-3)
        assert data.displacement[2] == pytest.approx(math.remainder(heading - heading0, math.tau), abs=0.02)
        x0, y0, heading0 = x, y, heading


def test_asking_for_rims_takes_nothing_from_the_velocitys_displacement():
    asked, quiet = (Asked(alone(default(dialect="firmware-2018-omni"))) for _ in range(2))
    drive = bytes.fromhex("41 00200000 00000000 00000000")
    for rig in (asked, quiet):
        rig.ask(drive)
        rig.run(400)
    for tick in range(50):
        asked.ask(b"\x31") if tick % 7 == 0 else asked.bench.tick()
    quiet.run(50)
    assert asked.ask(drive) == quiet.ask(drive)


def test_rims_are_counted_only_for_a_dialect_that_tells_them():
    assert Base(default()).reckoning is None
    assert Base(default(dialect="firmware-2015")).reckoning.turned_rad == [0.0] * 3


# --- 0x40 --------------------------------------------------------------------------------------------------------


def test_rim_speeds_come_true_in_wheel_order():
    rig = Asked(alone(default()))
    rims_mps = (0.05, -0.12, 0.08)
    rig.run(1500, wheels_request(rims_mps))
    assert rig.bench.base.wanted_radps == pytest.approx([rim / 0.027 for rim in rims_mps], abs=1e-9)
    assert rig.bench.world.plant.wheel_speeds_radps == pytest.approx([rim / 0.027 for rim in rims_mps], abs=0.3)
    assert rig.bench.base.drive.driver == "core"


@settings(max_examples=30)
@given(st.tuples(*[st.integers(-100, 100)] * 3))
def test_three_wheels_have_no_speeds_that_disagree(rims_mmps):
    robot = default()
    kinematics = Kinematics(robot.wheels)
    motion = OmniMotion(robot, kinematics, Odometry(kinematics), lambda tick: (0, 0, 0))
    assert motion.rim_distances_m() == (0.0, 0.0, 0.0), "not counted in this dialect"
    wanted = motion.follow_rims([rim / 1000 for rim in rims_mmps])
    assert wanted.slip_radps == ()
    assert kinematics.wheel_speeds(wanted.twist) == pytest.approx([rim / 27 for rim in rims_mmps], abs=1e-9)


def four_wheels():
    wheels = tuple(replace(wheel, can_id=number) for number, wheel in enumerate(omni4().wheels, 1))
    return alone(replace(omni4(), wheels=wheels))


def test_four_wheels_may_work_against_each_other_and_stop_together():
    rig = Asked(four_wheels())
    rims_mps = (0.1, 0.0, 0.0, 0.0)
    rig.run(1500, wheels_request(rims_mps))
    base = rig.bench.base
    assert base.wanted_radps == pytest.approx([rim / 0.027 for rim in rims_mps], abs=1e-9)
    assert base.slave.wanted_slip_radps != ()
    rig.run(1, bytes.fromhex("41") + bytes(12))
    assert base.slave.wanted_slip_radps == ()
    rig.run(500, bytes.fromhex("41") + bytes(12))
    assert base.wanted_radps == pytest.approx([0.0] * 4, abs=1e-9)


def test_a_silent_core_stops_what_works_against_each_other_too():
    rig = Asked(four_wheels())
    rig.run(1, wheels_request((0.1, -0.1, 0.1, -0.1)))
    rig.run(1000)
    assert any(rig.bench.base.wanted_radps)
    rig.run(1)
    assert rig.bench.base.wanted_radps == [0.0] * 4


def test_the_robots_limits_hold_for_wheel_speeds():
    rig = Asked(alone(default()))
    rig.run(3000, wheels_request((2.0, 2.0, 2.0)))
    # a spin: 2 rad/s at most, on 61 mm, over 27 mm
    assert rig.bench.base.wanted_radps == pytest.approx([2.0 * 61 / 27] * 3)
    rig = Asked(four_wheels())
    rig.run(100, wheels_request((9.0, -9.0, 9.0, -9.0)))
    assert max(map(abs, rig.bench.base.wanted_radps)) == pytest.approx(37.04)


def test_disarmed_means_no_current_whatever_the_core_wants():
    rig = Rig()
    core = rig.bench.world.core
    rig.run(100)
    core.ask_wheels((0.1, 0.1, 0.1))
    rig.run(2000)
    assert rig.bench.base.slave.alive(rig.bench.now_tick)
    assert not rig.bench.base.drive.armed
    assert rig.bench.base.wanted_radps == [0.0] * 3
    assert {out.can_commands for out in rig.outputs[-1000:]} == {((0x200, bytes(8)),)}


def test_a_touched_stick_takes_over_from_wheel_speeds_and_gives_them_back():
    rig = Rig().arm()
    rig.bench.world.core.ask_wheels((0.1, 0.1, 0.1))
    rig.run(1500)
    spin = [0.1 / 0.027] * 3
    assert rig.bench.base.wanted_radps == pytest.approx(spin)
    rig.run(200, Sticks(forward=1.0))
    assert rig.bench.base.drive.driver == "rc"
    rig.run(1500)
    assert rig.bench.base.wanted_radps == pytest.approx(spin)


# --- sensors and health ------------------------------------------------------------------------------------------


def test_driving_into_the_wall_is_felt_and_seen():
    rig = Asked(alone(default()))
    assert rig.ask(b"\x33").hex() == "ff030000"
    forward = bytes.fromhex("41 00800000 00000000 00000000")
    rig.run(9000, forward)
    assert rig.bench.world.plant.pose.x_m == pytest.approx(2.92, abs=2e-3)
    assert rig.ask(b"\x33").hex() in ("fc030000", "fd030000", "fe030000"), "the strips meet where it touches"
    front_mm = int.from_bytes(rig.ask(b"\x32")[:4], "little") / 65536
    assert front_mm == pytest.approx(0.0, abs=2.0)
    rig.run(2000, bytes.fromhex("41 00C0FFFF 00000000 00000000"))
    assert rig.ask(b"\x33").hex() == "ff030000"
    truth_mm = (3.0 - rig.bench.world.plant.pose.x_m - 0.08) * 1000
    assert int.from_bytes(rig.ask(b"\x32")[:4], "little") / 65536 == pytest.approx(truth_mm, abs=1e-3)


def test_a_motor_that_falls_silent_is_a_fault():
    class WithoutSecond:
        def __init__(self, motors):
            self.motors, self.plant = motors, motors.plant
            self.silent = False

        def step(self, tick, commands):
            frames = self.motors.step(tick, commands)
            return tuple(frame for frame in frames if not (self.silent and frame[0] == 0x202))

    rig = Asked(alone(default()))
    motors = rig.bench.world.motors = WithoutSecond(rig.bench.world.motors)
    rig.run(50)
    assert rig.ask(b"\x90\x01").hex() == "0000"
    motors.silent = True
    rig.run(19)
    assert rig.ask(b"\x90\x01").hex() == "0000"
    rig.run(5)
    assert rig.ask(b"\x90\x01").hex() == "0201"
    assert rig.ask(b"\x90\x02\x00")[:4].hex() == "01000302"
    assert rig.ask(b"\x90\x02\x00")[4:].startswith(b"Motor 2 is silent.\0")
    motors.silent = False
    rig.run(5)
    assert rig.ask(b"\x90\x01").hex() == "0000"


# --- as a robot file chooses ---------------------------------------------------------------------------------------


def test_the_full_schedule_of_a_robot_file_learns_this_robot():
    rig = Rig(default(polls="full", dialect="firmware-2018-omni")).arm()
    rig.run(1500)
    known = rig.bench.world.core.known
    assert known.configuration.radius_m == pytest.approx(0.08)
    assert known.ranges_m[:4] == pytest.approx((2.92, 1.92, 2.92, 1.92), abs=0.01)
    assert known.contacts == (False,) * 10
    assert known.beacons == (3, (0, 0, 0))
    assert known.power == (100, False, False, False)
    assert known.health == (0, 0)
    assert known.motor_data.distances_m == pytest.approx((0.0,) * 4, abs=2e-3)
    assert rig.bench.world.core.errors == {}
    assert rig.bench.base.slave.core_events


def test_the_default_core_asks_for_nothing_but_velocity():
    rig = Rig()
    rig.run(3000)
    assert set(rig.bench.world.core.requests) == {0x10, 0x41}


@pytest.mark.parametrize("schedule", ["velocity", "full"])
def test_our_robot_behind_the_vendors_receiver(schedule):
    rig = Rig(default(behaviour="as_reference_firmware", polls=schedule)).arm()
    assert isinstance(rig.bench.base.slave, ReferenceFirmware)
    rig.bench.world.core.ask((0.2, 0.1, 0.5))
    rig.run(3000)
    core = rig.bench.world.core
    assert core.connected
    assert math.hypot(core.pose.x_m - rig.truth.x_m, core.pose.y_m - rig.truth.y_m) < 0.02
    assert math.hypot(rig.truth.x_m, rig.truth.y_m) > 0.2


def test_odometry_over_the_bus_in_the_single_precision_of_the_vendor_is_as_good():
    ends = []
    for behaviour in ("strict", "as_reference_firmware"):
        rig = Rig(default(behaviour=behaviour)).arm()
        rig.bench.world.core.ask((0.2, 0.1, 0.5))
        rig.run(2500)
        ends.append(rig.bench.world.core.pose)
    assert ends[0] == pytest.approx(ends[1], abs=1e-4)


def test_a_core_of_ones_own_schedule():
    bench = simulated(omni3_with_ids())
    bench.world.core = SlamwareCore(poll_ms=20, schedule=FULL)
    for _ in range(500):
        bench.tick()
    assert bench.world.core.known.configuration is not None


def omni3_with_ids():
    wheels = tuple(replace(wheel, can_id=number) for number, wheel in enumerate(omni3().wheels, 1))
    return replace(omni3(), wheels=wheels)
