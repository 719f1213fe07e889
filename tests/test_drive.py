"""Who drives and what a lost link means, through the link's own state machine, limit by limit."""

import math
from dataclasses import replace

import pytest

from bench.config import load_robot
from bench.drive import Drive
from bench.link import RcLink
from bench.messages import BodyTwist, RcFrame

CORE = BodyTwist(0.2, 0.1, 0.5)


class Driver:
    """One drive under test, fed with uart12 sticks every 10 ms, the way a robot is."""

    def __init__(self, **profile_changes):
        robot = load_robot("m2006")
        limits = replace(robot.limits, linear_acceleration_mps2=3.0, angular_acceleration_radps2=15.0)
        robot = replace(robot, rc=replace(robot.rc, **profile_changes), limits=limits)
        self.link = RcLink(robot.rc, robot.link)
        self.drive = Drive(robot)
        self.tick = -1
        self.heading = 0.0
        self.core_alive = False

    def run(self, ticks, *, forward=2048, right=2048, turn=2048, aux1=0, aux2=0, frames=True, **flags):
        """Run some ticks with the sticks held; the last twist comes back."""
        twist = None
        for _ in range(ticks):
            self.tick += 1
            events = []
            if frames and self.tick % 10 == 0:
                events = [RcFrame(0, 12, (turn, 2048, forward, right, aux1, aux2), **flags)]
            self.link.step(self.tick, events)
            twist = self.drive.step(self.tick, self.link, CORE, self.core_alive, self.heading)
        return twist

    def arm(self):
        self.run(20)
        self.run(20, aux1=1)
        self.run(20)
        assert self.drive.armed
        return self


def test_boot_is_disarmed_and_without_power():
    driver = Driver()
    assert driver.run(50) is None
    assert driver.run(50, forward=0) is None
    assert not driver.drive.armed


def test_rising_aux1_arms_with_sticks_at_rest_only():
    driver = Driver()
    driver.run(20, forward=0)
    driver.run(20, forward=0, aux1=1)
    assert not driver.drive.armed
    assert "sticks" in driver.drive.why_disarmed
    driver.run(20, aux1=1)
    assert not driver.drive.armed, "no edge, no arming"
    driver.run(20)
    driver.run(20, aux1=1)
    assert driver.drive.armed


def test_aux1_held_since_power_up_is_no_edge():
    driver = Driver()
    driver.run(100, aux1=1)
    assert not driver.drive.armed


@pytest.mark.parametrize(
    ("raw", "armed"), [(2048 + 102, True), (2048 + 103, False), (2048 - 102, True), (2048 - 103, False)]
)
def test_the_dead_band_edge_decides_arming(raw, armed):
    # dead_band 0.05 of a travel of 2048 is 102.4 counts
    driver = Driver()
    driver.run(20, forward=raw)
    driver.run(20, forward=raw, aux1=1)
    assert driver.drive.armed is armed


def test_aux1_disarms_wherever_the_sticks_are():
    driver = Driver().arm()
    assert driver.run(500, forward=0).vx_mps > 0.9
    assert driver.run(20, forward=0, aux1=1) is None
    assert not driver.drive.armed


@pytest.mark.parametrize(
    ("sticks", "expected"),
    [
        ({"forward": 0}, (1.0, 0, 0)),  # document 004: raw below the middle is forward
        ({"forward": 4095}, (-1.0, 0, 0)),
        ({"right": 0}, (0, -1.0, 0)),  # below is right, and right is minus y
        ({"right": 4095}, (0, 1.0, 0)),
        ({"turn": 4095}, (0, 0, -2.0)),  # above is clockwise, and clockwise is minus omega
        ({"turn": 0}, (0, 0, 2.0)),
        ({"forward": 0, "right": 0}, (math.sqrt(0.5), -math.sqrt(0.5), 0)),  # 1.0 m/s is the limit of the speed
    ],
)
def test_full_sticks_ask_document_004s_speeds(sticks, expected):
    assert Driver().arm().run(1000, **sticks) == pytest.approx(expected, abs=2e-3)


def test_the_ramp_is_the_robot_files():
    driver = Driver().arm()
    driver.run(1)
    before = driver.tick
    while driver.run(1, forward=0).vx_mps < 0.5:
        assert driver.tick < before + 1000
    first_frame = (before // 10 + 1) * 10
    assert driver.tick - first_frame + 1 == pytest.approx(0.5 / 3.0 * 1000, abs=1.5)  # 3 m/s2


def test_sticks_let_go_mean_zero_at_once():
    driver = Driver().arm()
    assert driver.run(500, forward=0).vx_mps > 0.9
    driver.run(-(driver.tick + 1) % 10, forward=0)
    assert driver.run(1) == (0, 0, 0), "in the tick of the frame that finds them at rest"


@pytest.mark.parametrize(("silence", "moving"), [(99, True), (100, False), (101, False)])
def test_silence_holds_then_brakes(silence, moving):
    driver = Driver().arm()
    driver.run(10 - driver.tick % 10)  # the last tick brought a frame
    driver.run(400, forward=0)
    assert driver.tick % 10 == 0
    twist = driver.run(silence, frames=False)
    assert (twist.vx_mps > 0.5) is moving
    assert driver.drive.armed


@pytest.mark.parametrize(("silence", "armed"), [(499, True), (500, False), (501, False)])
def test_silence_disarms(silence, armed):
    driver = Driver().arm()
    driver.run(10 - driver.tick % 10)
    driver.run(400, forward=0)
    twist = driver.run(silence, frames=False)
    assert driver.drive.armed is armed
    assert (twist == (0, 0, 0)) if armed else (twist is None)


def test_failsafe_brakes_without_hold():
    driver = Driver().arm()
    driver.run(10 - driver.tick % 10)
    driver.run(400, forward=0)
    driver.run(9, forward=0)
    assert driver.run(1, forward=0, failsafe=True) == (0, 0, 0)


def test_disarmed_by_loss_blocks_every_source_until_a_deliberate_re_arm():
    driver = Driver().arm()
    driver.core_alive = True
    assert driver.run(1000) == pytest.approx(CORE)
    driver.run(600, frames=False)
    assert driver.run(2000) is None, "frames are back, the core keeps asking, nobody has re-armed"
    assert "link lost" in driver.drive.why_disarmed
    driver.run(20, aux1=1)
    assert driver.drive.armed


def test_a_press_that_began_during_the_loss_does_not_arm():
    driver = Driver().arm()
    driver.run(600, frames=False)
    driver.run(200, aux1=1)
    assert not driver.drive.armed
    driver.run(20)
    driver.run(20, aux1=1)
    assert driver.drive.armed


@pytest.mark.parametrize(("rest", "driven_by"), [(499, "rc"), (500, "core"), (501, "core")])
def test_sticks_at_rest_hand_over_to_a_live_core(rest, driven_by):
    driver = Driver().arm()
    driver.core_alive = True
    driver.run(10 - driver.tick % 10)
    driver.run(200, forward=0)
    driver.run(9, forward=0)
    driver.run(1)  # the frame that finds the sticks at rest
    driver.run(rest)
    assert driver.drive.driver == driven_by


def test_a_touched_stick_takes_over_at_once():
    driver = Driver().arm()
    driver.core_alive = True
    driver.run(1000)
    assert driver.drive.driver == "core"
    driver.run(10 - driver.tick % 10, right=0)
    assert driver.drive.driver == "rc"


def test_a_dead_core_drives_nothing():
    driver = Driver().arm()
    assert driver.run(1000) == (0, 0, 0)
    assert driver.drive.driver == "none"


def test_aux2_toggles_field_centric_with_the_heading_zero_at_arming():
    driver = Driver()
    driver.heading = 0.7
    driver.arm()
    driver.run(20, aux2=1)
    driver.run(20)
    assert driver.drive.field_centric
    driver.heading = 0.7 + math.pi / 2  # the robot has turned left by a quarter since arming
    assert driver.run(1000, forward=0) == pytest.approx((0, -1.0, 0), abs=2e-3)
    driver.heading = 0.7 - math.pi / 2
    assert driver.run(1000, forward=0) == pytest.approx((0, 1.0, 0), abs=2e-3)


def test_on_link_profiles_arm_with_the_link_and_come_back_with_it():
    driver = Driver(arming="on_link")
    assert driver.run(600, forward=0).vx_mps > 0.9
    assert driver.run(600, frames=False) is None
    assert driver.run(600, forward=0).vx_mps > 0.9


def test_a_robot_without_rc_takes_the_core_alone():
    drive = Drive(replace(load_robot("m2006"), rc=None))
    for tick in range(1000):
        twist = drive.step(tick, None, CORE, True, 0.0)
    assert twist == pytest.approx(CORE)
    assert drive.step(1000, None, CORE, False, 0.0) == (0, 0, 0)


def test_the_core_is_limited_like_the_sticks():
    drive = Drive(replace(load_robot("m2006"), rc=None))
    for tick in range(5000):
        twist = drive.step(tick, None, BodyTwist(30.0, 40.0, -50.0), True, 0.0)
    assert twist == pytest.approx((0.6, 0.8, -2.0))
