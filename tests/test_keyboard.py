"""The dead-man's lease and the switches, driven as terminals drive them: presses and repeats, never a release."""

from dataclasses import replace

import pytest
from desk import M2006
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.config import load_profile
from bench.loop import simulated
from bench.messages import BodyTwist
from bench.rc.transmitter import Sticks
from bench.screen.key_sticks import KeySticks
from bench.screen.keyboard import FOREIGN_STOP, REAL_CORE, Keyboard

MOTION_KEYS = ["w", "s", "a", "d", "q", "e", "up", "down", "left", "right"]


class Desk:
    """A keyboard on a real bench, tick by tick."""

    def __init__(self, robot=M2006):
        self.bench = simulated(robot)
        self.keyboard = Keyboard(robot.rc)
        self.outputs = []

    @property
    def drive(self):
        return self.bench.base.drive

    def run(self, ticks):
        for _ in range(ticks):
            self.outputs.append(self.bench.tick(self.keyboard.inputs(self.bench.now_tick)))

    def press(self, key):
        return self.keyboard.press(key, self.bench.now_tick, self.drive.armed)

    def hold(self, key, delay_ms, interval_ms, repeats):
        """One key as a terminal sends it while it is held."""
        self.press(key)
        for repeat in range(repeats):
            self.run(interval_ms if repeat else delay_ms)
            self.press(key)

    def arm(self):
        self.run(50)
        self.press("enter")
        self.run(200)
        assert self.drive.armed
        return self


def test_a_key_grants_120_ms_to_the_tick():
    keys = KeySticks()
    keys.press("w", 1000)
    assert keys.sticks(1000) == keys.sticks(1119) == Sticks(forward=0.5)
    assert keys.sticks(1120) == Sticks()


def test_in_slow_motion_a_lease_is_120_ms_of_the_wall_and_never_more_of_the_robot():
    keys = KeySticks()
    for rate, ticks in ((0.1, 12), (0.5, 60), (1.0, 120), (4.0, 120)):
        keys.set_time(rate, 0)
        keys.press("w", 0)
        assert keys.sticks(ticks - 1) == Sticks(forward=0.5), rate
        assert keys.sticks(ticks) == Sticks(), rate


def test_a_lease_makes_room_for_a_lead():
    """On real ports what is done now counts some ticks later: the lead and the lease are 150 ms less a frame."""
    keys = KeySticks()
    for lead, ticks in ((0, 120), (20, 120), (80, 60), (250, 10)):
        keys.set_time(1.0, lead)
        keys.press("w", 1000)
        assert keys.sticks(1000 + ticks - 1) == Sticks(forward=0.5), lead
        assert keys.sticks(1000 + ticks) == Sticks(), lead


def test_where_releases_are_told_a_key_is_held_by_proofs_of_life_until_it_is_let_go():
    keys = KeySticks()
    keys.releases = True
    keys.press("w", 0)
    for tick in range(100, 1001, 100):
        keys.alive(tick)
        assert keys.sticks(tick + 119) == Sticks(forward=0.5)
    keys.let_go("w")
    assert keys.sticks(1001) == Sticks()


def test_a_held_key_without_a_proof_ends_with_its_lease_and_does_not_come_back_by_itself():
    keys = KeySticks()
    keys.releases = True
    keys.press("w", 0)
    keys.alive(100)
    assert keys.sticks(220) == Sticks()
    keys.alive(230)
    assert keys.sticks(231) == Sticks()
    keys.press("w", 240)
    assert keys.sticks(241) == Sticks(forward=0.5)


def test_proofs_hold_nothing_where_releases_are_not_told():
    keys = KeySticks()
    keys.press("w", 0)
    keys.alive(100)
    assert keys.sticks(120) == Sticks()


def test_no_key_is_held_longer_than_a_second_without_a_sign_of_the_keyboard():
    """A program in between could answer for ever for a terminal that is gone; repeats it cannot make up."""
    keys = KeySticks()
    keys.releases = True
    keys.press("w", 0)
    held = 0
    for tick in range(3000):
        if tick % 50 == 0:
            keys.alive(tick)
        held += any(keys.sticks(tick))
    assert held == 1120
    keys.press("w", 3000)
    keys.press("q", 3050)
    for tick in range(3100, 5001, 50):
        keys.press("q", tick)  # the repeats of one key stand for the keyboard
        keys.alive(tick)
    assert keys.sticks(5000) == Sticks(forward=0.5, turn=0.5)


def test_of_two_opposite_keys_the_one_pressed_last_counts_and_the_other_comes_back_when_it_is_let_go():
    keys = KeySticks()
    keys.releases = True
    keys.press("w", 0)
    keys.press("s", 50)
    assert keys.sticks(60) == Sticks(forward=-0.5)
    keys.let_go("s")
    assert keys.sticks(60) == Sticks(forward=0.5)


@given(
    delay_ms=st.integers(250, 660),
    rate_hz=st.integers(10, 40),
    jitter_ms=st.integers(0, 40),
    repeats=st.integers(0, 12),
    key=st.sampled_from(MOTION_KEYS),
    seed=st.randoms(use_true_random=False),
)
@settings(max_examples=6)
def test_zero_twist_is_commanded_at_most_150_ms_after_the_last_sign_of_a_key(
    delay_ms, rate_hz, jitter_ms, repeats, key, seed
):
    """A key as terminals send it, no release. Measured on the twist that the base asks of its wheels, tick by tick."""
    desk = Desk().arm()
    desk.press(key)
    for repeat in range(repeats):
        desk.run(max(1, (round(1000 / rate_hz) if repeat else delay_ms) + seed.randint(-jitter_ms, jitter_ms)))
        desk.press(key)
    last = desk.bench.now_tick
    moved = False
    while desk.bench.now_tick < last + 150:
        desk.run(1)
        moved = moved or any(desk.bench.base.wanted_radps)
    assert moved, "it drove"
    for _ in range(100):
        desk.run(1)
        assert not any(desk.bench.base.wanted_radps)


@pytest.mark.parametrize(
    ("key", "sticks"),
    [
        ("w", Sticks(forward=0.5)), ("up", Sticks(forward=0.5)), ("s", Sticks(forward=-0.5)),
        ("down", Sticks(forward=-0.5)), ("a", Sticks(left=0.5)), ("left", Sticks(left=0.5)), ("d", Sticks(left=-0.5)),
        ("right", Sticks(left=-0.5)), ("q", Sticks(turn=0.5)), ("e", Sticks(turn=-0.5)),
    ],
)  # fmt: skip
def test_which_way_each_key_pushes(key, sticks):
    keys = KeySticks()
    keys.press(key, 0)
    assert keys.sticks(0) == sticks


def test_axes_add_up_and_opposite_keys_replace_each_other():
    keys = KeySticks()
    keys.press("w", 0)
    keys.press("q", 50)
    assert keys.sticks(60) == Sticks(forward=0.5, turn=0.5)
    keys.press("s", 70)
    assert keys.sticks(80) == Sticks(forward=-0.5, turn=0.5)
    assert keys.sticks(175) == Sticks(forward=-0.5)


@given(
    keys=st.lists(
        st.tuples(
            st.sampled_from(MOTION_KEYS),
            st.integers(250, 660),  # the first repeat, of the systems that we know
            st.integers(20, 60),
            st.integers(0, 8),
            st.integers(0, 150),  # then the finger moves on to the next key
        ),
        min_size=1,
        max_size=3,
    )
)
@settings(max_examples=8)
def test_sticks_are_at_rest_150_ms_after_the_last_key_whatever_was_typed(keys):
    desk = Desk().arm()
    for key, delay_ms, interval_ms, repeats, pause_ms in keys:
        desk.hold(key, delay_ms, interval_ms, repeats)
        assert any(desk.keyboard.sticks.sticks(desk.bench.now_tick))
        last_key = desk.bench.now_tick
        desk.run(pause_ms)
    desk.run(150 - (desk.bench.now_tick - last_key))
    assert desk.drive.sticks == (0.0, 0.0, 0.0), "decoded from the RC bytes, in the base"
    assert desk.drive.armed
    desk.run(400)
    assert desk.bench.base.wanted_radps == pytest.approx([0.0, 0.0, 0.0])


def test_a_held_key_drives_without_a_gap_once_it_repeats():
    desk = Desk().arm()
    desk.hold("w", 500, 33, 1)
    desk.run(33)
    for _ in range(20):
        desk.press("w")
        for _ in range(33):
            desk.run(1)
            assert desk.drive.sticks[0] > 0.0


def test_the_robot_goes_the_way_of_the_key():
    for key, x, y in (("w", 1, 0), ("s", -1, 0), ("a", 0, 1), ("d", 0, -1)):
        desk = Desk().arm()
        desk.hold(key, 33, 33, 14)
        pose = desk.bench.world.plant.pose
        assert pose.x_m * x + pose.y_m * y > 0.03, key
    for key, turn in (("q", 1), ("e", -1)):
        desk = Desk().arm()
        desk.hold(key, 33, 33, 14)
        assert desk.bench.world.plant.pose.heading_rad * turn > 0.2, key


def test_power_goes_from_10_to_100_percent():
    desk = Desk()
    assert desk.keyboard.sticks.power_percent == 50
    assert "60 %" in desk.keyboard.change_power(1)
    for _ in range(20):
        desk.keyboard.change_power(1)
    assert desk.keyboard.sticks.power_percent == 100
    for _ in range(20):
        desk.keyboard.change_power(-1)
    assert desk.keyboard.sticks.power_percent == 10


def test_enter_arms_and_disarms():
    desk = Desk().arm()
    desk.press("enter")
    desk.run(11)
    assert not desk.drive.armed
    assert desk.drive.why_disarmed == "AUX1"


@pytest.mark.parametrize("delay_ms", [250, 500, 660])
@pytest.mark.parametrize("interval_ms", [20, 90])
def test_enter_held_down_ends_disarmed(delay_ms, interval_ms):
    desk = Desk()
    desk.run(50)
    desk.hold("enter", delay_ms, interval_ms, 12)
    desk.run(200)
    assert not desk.drive.armed


def test_f_turns_field_centric_on_and_off():
    desk = Desk().arm()
    for expected in (True, False):
        desk.press("f")
        desk.run(200)
        assert desk.drive.field_centric is expected


def test_t_loses_the_link_and_only_a_deliberate_press_arms_again():
    desk = Desk().arm()
    desk.press("t")
    desk.run(520)
    assert desk.bench.base.link.state == "lost"
    assert not desk.drive.armed
    assert "T switches" in desk.press("enter")
    desk.press("t")
    desk.run(300)
    assert desk.bench.base.link.state == "live"
    assert not desk.drive.armed, "an Enter of before must not arm now"
    desk.press("enter")
    desk.run(20)
    assert desk.drive.armed


def test_c_lets_the_core_drive_an_arc_and_stand_again():
    desk = Desk().arm()
    desk.press("c")
    desk.run(900)
    assert desk.drive.driver == "core"
    assert desk.bench.base.slave.wanted_twist == pytest.approx((0.2, 0.0, 0.5), abs=1e-4)
    desk.press("c")
    desk.run(900)
    assert desk.bench.base.slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)


def test_a_touch_of_a_key_takes_over_from_the_core():
    desk = Desk().arm()
    desk.press("c")
    desk.run(900)
    desk.press("s")
    desk.run(20)
    assert desk.drive.driver == "rc"


@given(
    st.lists(st.tuples(st.sampled_from([*MOTION_KEYS, "enter", "enter", "f", "c"]), st.integers(0, 150)), max_size=12)
)
@settings(max_examples=15)
def test_space_stops_whatever_came_before(typed):
    desk = Desk()
    desk.run(50)
    for key, pause_ms in typed:
        desk.press(key)
        desk.run(pause_ms)
    desk.press("space")
    # One frame period where the switch is free; where Enter is still pressed it has to be released first.
    desk.run(75)
    assert not desk.drive.armed
    assert desk.drive.sticks == (0.0, 0.0, 0.0)
    assert desk.outputs[-1].can_commands == ((0x200, bytes(8)),)
    desk.run(300)
    assert not desk.drive.armed, "and nothing arms or drives later"


def test_space_held_down_is_as_good_as_pressed_once():
    desk = Desk().arm()
    desk.press("w")
    desk.run(20)
    desk.hold("space", 250, 33, 10)
    desk.run(200)
    assert not desk.drive.armed


def test_two_spaces_at_once_do_not_delay_each_other():
    desk = Desk().arm()
    desk.press("space")
    desk.press("space")
    desk.run(11)
    assert not desk.drive.armed


def test_space_takes_back_an_enter_that_has_not_left():
    desk = Desk()
    desk.run(51)  # one tick past a frame: the next one leaves in nine
    desk.press("enter")
    desk.run(3)
    desk.press("space")
    desk.run(300)
    assert not desk.drive.armed


def test_without_an_arming_switch_space_takes_the_link():
    desk = Desk(replace(M2006, rc=load_profile("crossfire")))
    desk.run(100)
    assert desk.drive.armed
    assert "transmitter off" in desk.press("space")
    desk.run(520)
    assert not desk.drive.armed
    desk.press("t")
    desk.run(50)
    assert "armed by its link" in desk.press("enter")
    assert not desk.keyboard.hands(0).arms
    assert Keyboard(M2006.rc).hands(0).arms


def test_nobody_but_a_foreign_base_knows_whether_it_is_armed_and_nothing_is_told_of_it():
    keyboard = Keyboard(M2006.rc)
    assert keyboard.press("w", 0, None) == ""
    assert keyboard.press("w", 0, False) == "disarmed; Enter arms"
    assert keyboard.press("space", 0, None) == FOREIGN_STOP
    assert keyboard.press("space", 0, True) == "stopped"


@pytest.mark.parametrize("armed", [True, False, None])
def test_who_is_abandoned_stops_and_a_foreign_base_loses_its_link(armed):
    keyboard = Keyboard(M2006.rc)
    keyboard.abandon(0, armed)
    frames = [frame for tick in range(300) if (frame := keyboard.inputs(tick).rc)]
    assert bool(frames) is (armed is not None), "of a foreign base only its own watch over the link can be relied on"
    assert any(frame != frames[0] for frame in frames) is (armed is True), (
        "the arming switch is pressed, the sticks rest"
    )
    assert keyboard.transmitter.on is (armed is not None)


def test_a_real_core_is_not_said_to_have_been_told():
    for profile in (M2006.rc, None):
        keyboard = Keyboard(profile, core_is_real=True)
        assert keyboard.press("c", 0, True) == REAL_CORE
        assert keyboard.hands(0).core_asks is None
        assert keyboard.press("space", 0, True) == (REAL_CORE if profile is None else "stopped")
        assert not keyboard.core_asks
    assert Keyboard(None).press("space", 0, True) == "stopped: the core asks for nothing"


def test_a_robot_without_rc_is_driven_by_its_core_alone():
    desk = Desk(replace(M2006, rc=None))
    assert "no RC" in desk.press("w")
    assert "no RC" in desk.press("t")
    assert all(not out.rc for out in desk.outputs)
    desk.press("c")
    desk.run(900)
    assert desk.drive.driver == "core"
    desk.press("space")
    desk.run(900)
    assert desk.bench.base.slave.wanted_twist == BodyTwist(0.0, 0.0, 0.0)


def test_disarmed_the_keys_say_how_to_arm():
    desk = Desk()
    desk.run(50)
    assert desk.press("w") == "disarmed; Enter arms"
    desk.run(150)
    assert not desk.arm().press("w")
