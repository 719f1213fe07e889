"""Whole turns over gaps in the feedback: exact integers for truth, and the worst motion that the bound allows."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bench.canbus.watch import Kind
from bench.config import load_robot, robot_names
from bench.kinematics import Kinematics
from bench.m2006 import MotorBus, encode_feedback
from bench.messages import BodyTwist
from bench.noise import Noise, NoisyFeedback
from bench.plant import Plant
from bench.unwrap import Births, ByShorterWay, BySpeed, filter_share, steepest_turns_per_ms2, stray_ms2

ROBOT = load_robot("m2006")
SHARE = 1.0 - math.exp(-1.0 / 10.0)
RUN_UP_TICKS = 60
# docs/odometry.md has these. In ticks, of the wheel that is turned most easily.
KNOWN_TICKS = {
    "deadwheel3": 18, "dm3519": 36, "m2006": 36, "mecanum": 20, "omni3": 23, "omni4": 24, "siegwart": 31,
    "slamware-a": 15, "slamware-b": 15,
}  # fmt: skip


def reports(changes, speed=0.0, start=0.0):
    """(exact counts, angle, rpm) after each tick, of a rotor whose speed, counts/ms, changes by so much in each.

    As the plant and an ESC do it: turn by the old speed, then change it, then filter it.
    """
    turned, shown, told = start, speed, []
    for change in [0.0, *changes]:
        turned += speed
        speed += change
        shown += SHARE * (speed - shown)
        told.append((math.floor(turned), math.floor(turned) % 8192, round(shown * 60_000 / 8192)))
    return told


def shorter(apart):
    return (apart + 4096) % 8192 - 4096


def way(unwrap, told, begin, gap, wheel=0):
    (_, first, before), (_, last, after) = told[begin], told[begin + gap]
    return unwrap.way(wheel, shorter(last - first), (before, after), range(gap, gap + 1))


# --- the bound -------------------------------------------------------------------------------------------------------


def weights(gap):
    """What each change of a rotor's speed, once a tick, adds to its way beyond the prediction: by trying each alone."""
    ticks, found = RUN_UP_TICKS * 4, []
    for at in range(ticks + gap):
        speed = shown = way = begin = 0.0
        for tick in range(ticks + gap):
            way += speed if tick >= ticks else 0.0
            speed += tick == at
            shown += SHARE * (speed - shown)
            begin = shown if tick == ticks - 1 else begin
        found.append(way - 0.5 * gap * (begin + shown) - (1 / SHARE - 0.5) * (shown - begin))
    return found


@pytest.mark.parametrize("gap", [1, 2, 5, 20, 37])
def test_the_bound_is_the_worst_that_any_motion_does(gap):
    assert stray_ms2(gap, filter_share(10.0)) == pytest.approx(math.fsum(map(abs, weights(gap))), rel=1e-9)


@pytest.mark.parametrize("beyond", [0, 2])
def test_the_bound_is_sharp(beyond):
    """The worst motion: known at the longest gap; two ticks more, and the nearest turn to the prediction is wrong."""
    unwrap = BySpeed(ROBOT)
    gap, slope = unwrap.longest_ticks(0) + beyond, unwrap.slopes[0]
    told = reports([math.copysign(slope, weight) for weight in weights(gap)], speed=-500.0)
    turned = told[-1][0] - told[-1 - gap][0]
    mean = 0.5 * (told[-1][2] + told[-1 - gap][2]) * gap + (1 / SHARE - 0.5) * (told[-1][2] - told[-1 - gap][2])
    apart = turned - mean * 8192 / 60_000
    found = way(unwrap, told, len(told) - 1 - gap, gap)
    if beyond:
        assert apart > 4096
        assert found is None
    else:
        assert 3700 < apart < 4096
        assert found.counts == turned


@pytest.mark.parametrize(("before", "after"), [(0, 0), (1000, 3000), (2000, -500)])
@pytest.mark.parametrize("gap", [1, 2, 10])
def test_a_way_is_believed_within_the_bound_and_half_a_sixteenth_of_a_turn(gap, before, after):
    """Around the sum of the speeds as the module's text has it: its mean, and what the filter holds back."""
    unwrap, counts_per_rpm_tick = BySpeed(ROBOT), 8192 / 60_000
    ahead = counts_per_rpm_tick * (0.5 * gap * (before + after) + (1 / SHARE - 0.5) * (after - before))
    stray = unwrap.slopes[0] * math.fsum(map(abs, weights(gap))) + 256
    for counts in (math.floor(ahead + stray), math.ceil(ahead - stray)):
        assert unwrap.way(0, shorter(counts), (before, after), range(gap, gap + 1)) == (counts, gap, gap)
    for counts in (math.floor(ahead + stray) + 1, math.ceil(ahead - stray) - 1):
        assert unwrap.way(0, shorter(counts), (before, after), range(gap, gap + 1)) is None


def test_a_tick_is_never_too_long():
    unwrap = BySpeed(ROBOT)
    unwrap.slopes = (1e9,)
    assert unwrap.longest_ticks(0) == 1


def test_a_motor_without_a_filter_reports_what_its_rotor_does():
    assert filter_share(0.0) == 1.0


def test_a_rotor_is_turned_by_its_motor_and_by_no_more_grip_than_rubber_has():
    """0.6 A of 0.18 Nm/A, a fifth of the load lost in the gear on either way, and 0.02 Nm, on 0.0012 kgm^2."""
    motor = replace(ROBOT.motor, load_friction=0.2)
    alone = replace(ROBOT, motor=motor, ground=replace(ROBOT.ground, grip=0.0, rolling=0.0))
    turns_per_ms2 = (0.6 * 0.18 * 1.2 / 0.8 + 0.02) / 0.0012 * 36 / math.tau * 1e-6
    assert steepest_turns_per_ms2(alone) == pytest.approx([turns_per_ms2] * 3, rel=1e-12)
    held = [replace(ROBOT, ground=replace(ROBOT.ground, grip=grip)) for grip in (1.4, 1.5, 2.0)]
    less, rubber, more = map(steepest_turns_per_ms2, held)
    assert less[0] < rubber[0]
    assert rubber == more


# --- births ----------------------------------------------------------------------------------------------------------


def gaps_of(births, tick, reports=1):
    """The gaps of a wheel's reports of one tick; each is told to be any of them."""
    found = []
    for behind in reversed(range(reports)):
        gaps = births.gaps(0, tick, behind)
        births.heard(0, tick, behind, gaps[0], gaps[-1])
        found.append((gaps[0], gaps[-1]))
    return found


def test_a_report_may_be_as_late_as_any_was():
    births = Births(1)
    births.first(0, 0)
    assert gaps_of(births, 1) == [(1, 1)]
    assert gaps_of(births, 3) == [(2, 2)], "none was late yet"
    assert gaps_of(births, 5, reports=2) == [(1, 1), (1, 1)], "of 4 and 5: one tick late"
    assert gaps_of(births, 7) == [(1, 2)], "of 6 or 7"
    assert gaps_of(births, 9, reports=3) == [(1, 1), (1, 1), (1, 1)], "of 7, 8 and 9: that one was of 6, two ticks late"
    assert gaps_of(births, 12) == [(1, 3)], "of 10, 11 or 12"
    assert gaps_of(births, 13) == [(1, 3)], "no two in one tick: of 11, 12 or 13, one or more after that"
    assert gaps_of(births, 15, reports=2) == [(1, 3), (1, 2)]


def test_two_late_ones_after_one_of_unknown_birth_show_how_late_they_are():
    births = Births(1)
    births.first(0, 0)
    gaps_of(births, 2, reports=2)
    assert gaps_of(births, 4) == [(1, 2)]
    assert gaps_of(births, 7, reports=3) == [(1, 2), (1, 1), (1, 1)]
    assert gaps_of(births, 10) == [(1, 3)], "two ticks late was seen"


@pytest.mark.parametrize("usual_before", [False, True])
def test_fifty_calm_ticks_in_a_row_are_in_step_whatever_was_before(usual_before):
    births = Births(1)
    if usual_before:
        for tick in range(30):
            births.settled(tick, alone=True)
        births.exactly(30)
    assert [births.settled(tick, alone=True) for tick in range(31, 81)] == [False] * 49 + [True]


@given(
    st.sampled_from(robot_names()),
    st.floats(-1.0, 1.0),
    st.lists(st.floats(-1.0, 1.0), min_size=RUN_UP_TICKS, max_size=RUN_UP_TICKS),
    st.lists(st.sampled_from([-1.0, 1.0]) | st.floats(-1.0, 1.0), min_size=1, max_size=60),
    st.integers(0, 8191),
)
def test_whole_turns_are_right_or_told_to_be_unknown(name, speed, before, during, start):
    unwrap = UNWRAPS[name]
    slope, gap = unwrap.slopes[0], len(during)
    told = reports([slope * share for share in (*before, *during)], 2500.0 * speed, start)
    assume(all(abs(rpm) < 32767 for *_, rpm in told))
    found = way(unwrap, told, RUN_UP_TICKS, gap)
    if gap > KNOWN_TICKS[name]:
        assert found is None
    else:
        assert found == (told[-1][0] - told[RUN_UP_TICKS][0], gap, gap)


UNWRAPS = {name: BySpeed(load_robot(name)) for name in robot_names()}


@pytest.mark.parametrize("name", robot_names())
def test_how_long_each_robots_wheels_may_be_silent(name):
    wheels = range(len(load_robot(name).wheels))
    assert min(map(UNWRAPS[name].longest_ticks, wheels)) == KNOWN_TICKS[name]


@pytest.mark.parametrize("name", robot_names())
def test_no_rotor_of_the_plant_changes_its_speed_faster_than_the_bound_says(name):
    """Full current one way and the other, from rolling sideways, spinning, with and without the floor's help."""
    robot = load_robot(name)
    limit, kinematics, used = robot.limits.current_a, Kinematics(robot.wheels), 0.0
    bounds = [
        1e3 * slope * math.tau / wheel.gear
        for slope, wheel in zip(steepest_turns_per_ms2(robot), robot.wheels, strict=True)
    ]
    for twist in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.3, 0.2, 3.0)):
        fastest = max(map(abs, kinematics.wheel_speeds(twist)))
        twist = BodyTwist(*(0.9 * robot.limits.wheel_radps / fastest * one for one in twist))
        plant = Plant(robot, None, twist=twist)
        for tick in range(240):
            signs = [1.0 if (tick // 40 + wheel) % 2 else -1.0 for wheel in range(len(robot.wheels))]
            last = plant.wheel_speeds_radps
            plant.step([limit * sign for sign in signs])
            for wheel, bound in enumerate(bounds):
                drag = robot.motor.viscous_nms * abs(last[wheel]) / robot.motor.inertia_kgm2 / 1e3  # see the module
                used = max(used, abs(plant.wheel_speeds_radps[wheel] - last[wheel]) / (bound + drag))
    assert 0.02 < used < 1.0


def test_passive_encoders_are_unwrapped_the_shorter_way_while_they_are_slow_enough():
    wheels = [replace(ROBOT.wheels[0], gear=gear) for gear in (1.0, 10.0, 100.0)]
    unwrap = ByShorterWay(wheels)
    assert unwrap.way(0, -4096, (30000, 30000), range(1, 73)).counts == -4096
    assert unwrap.way(0, 5, (0, 0), range(73, 74)) is None
    assert unwrap.way(1, 5, (0, 0), range(7, 8)) == (5, 7, 7)
    assert unwrap.way(1, 5, (0, 0), range(7, 9)) is None
    assert unwrap.way(1, 5, (0, 0), range(3, 6)) == (5, 3, 5)
    assert unwrap.way(2, 5, (0, 0), range(1, 2)) == (5, 1, 1), "a tick is never too long"
    assert unwrap.way(2, 5, (0, 0), range(1, 3)) is None


# --- on the bus ------------------------------------------------------------------------------------------------------


def on_the_bus(told):
    """Frames of three rotors that do the same, one tick after the other. The current says which tick it was."""
    return [
        tuple((0x201 + i, encode_feedback(angle, rpm, tick)) for i in range(3))
        for tick, (_, angle, rpm) in enumerate(told)
    ]


WIRE_RAD = -math.tau / (36 * 8192)


@settings(max_examples=50)
@given(
    st.lists(st.tuples(st.floats(-1.0, 1.0), st.integers(1, 60)), min_size=3, max_size=12),
    st.integers(0, 3),
    st.sampled_from([0, 10_000, 100_000]),
    st.integers(0, 2**32),
)
def test_late_and_lost_frames_lose_no_count(phases, late_ticks, loss_ppm, seed):
    """From rest, where lateness is learnt, through any motion within the limits, up to 14,000 rotor rpm."""
    slope = BySpeed(ROBOT).slopes[1]
    changes, now = [0.0] * 150, 0.0
    for share, ticks in phases:
        for _ in range(ticks):
            change = slope * share if abs(now + slope * share) < 1900 else 0.0
            now += change
            changes.append(change)
    told = reports(changes)
    bus, wire = MotorBus(ROBOT), NoisyFeedback(Noise(0, late_ticks, loss_ppm, seed))
    first, total = {}, [0.0] * 3
    for tick, frames in enumerate([*on_the_bus(told), *[()] * 4]):
        arrived = wire.step(tick, frames)
        for can_id, data in arrived:
            first.setdefault(can_id - 0x201, int.from_bytes(data[4:6], "big"))
        increments_rad = bus.turned(tick, arrived)
        assert increments_rad != [], "nothing is left out"
        total = [one + more for one, more in zip(total, increments_rad or [0.0] * 3, strict=True)]
    assert bus.watch.findings == ()
    waiting = bus.take_increments()
    for wheel, last in enumerate(bus.currents_ma):
        counts = round((total[wheel] + waiting[wheel]) / WIRE_RAD)
        assert counts == told[last][0] - told[first[wheel]][0]


@pytest.mark.parametrize("gap", [20, 37, 40, 200])
def test_a_gap_beyond_the_bound_is_told_and_leaves_motion_out(gap):
    told = reports([0.0] * (gap + 20), speed=1700.0)
    bus = MotorBus(ROBOT)
    total, lost = 0.0, 0
    for tick, frames in enumerate(on_the_bus(told)):
        silent = 10 < tick < 10 + gap
        increments_rad = bus.turned(tick, frames[1:] if silent else frames)
        assert (increments_rad is None) == silent
        lost += increments_rad == []
        total += sum(increments_rad or [0.0]) / 3
    counts = round(total / WIRE_RAD)
    if gap <= KNOWN_TICKS["m2006"]:
        assert (counts, lost, bus.watch.findings) == (told[-1][0] - told[0][0], 0, ())
    else:
        assert (counts, lost) == (told[-1][0] - told[0][0] - (told[10 + gap][0] - told[10][0]), 1)
        (finding,) = bus.watch.findings
        assert (finding.kind, finding.can_id, finding.count, finding.first_tick) == (
            Kind.LOST_COUNT,
            0x201,
            1,
            10 + gap,
        )
        assert "silent for so long that its whole turns are not known" in finding.text


# --- what the bus makes of it, tick by tick: three rotors that do the same --------------------------------------------

STILL, SLOW_RPM, QUICK_RPM = 0, 1465, 12_000
SLOW, QUICK = 200, 1638
"""Counts a tick, of rotors that turn so fast. Two ways of a slow one may be as like as one: it is within the noise."""


class Counted(MotorBus):
    """Counts the ticks that are not like the one before: those are kept by wheel."""

    by_wheel = 0

    def receive(self, tick, frames):
        self.by_wheel += 1
        super().receive(tick, frames)


def all_say(counts, rpm):
    return tuple((0x201 + i, encode_feedback(counts % 8192, rpm, 0)) for i in range(3))


def counts_of(rads):
    return [round(rad / WIRE_RAD) for rad in rads]


def bus_with_late_reports(counts, rpm):
    """Ten usual ticks from 0; the reports of tick 10 come in tick 11, with those of tick 11: one tick late, no more."""
    bus = Counted(ROBOT)
    for tick in range(10):
        bus.turned(tick, all_say(counts * tick, rpm))
    assert bus.turned(10, ()) is None
    both = (*all_say(counts * 10, rpm), *all_say(counts * 11, rpm))
    assert counts_of(bus.turned(11, both)) == [2 * counts] * 3
    assert counts_of(bus.speeds_radps) == [counts * 1000] * 3
    return bus


def is_in_step(bus, tick, counts, rpm):
    """Whether the bus knows that the last reports were born in the tick before: this one is a usual one then."""
    before = bus.by_wheel
    bus.turned(tick, all_say(counts, rpm))
    return bus.by_wheel == before


def test_a_usual_tick_gives_what_one_by_wheel_gives():
    bus = Counted(ROBOT)
    bus.turned(0, all_say(0, 0))
    assert counts_of(bus.turned(1, all_say(10, 73))) == [10] * 3
    assert bus.speeds_radps == pytest.approx([-10_000 * math.tau / (36 * 8192)] * 3, rel=1e-12)
    assert bus.by_wheel == 1
    frames = [(0x203, encode_feedback(40, 73, 0)), (0x202, encode_feedback(30, 73, 0)), (0x201, bytes((0, 20)) * 4)]
    assert counts_of(bus.turned(2, frames)) == [10, 20, 30], "in another order"
    assert bus.speeds_radps == pytest.approx([one * -1e4 * math.tau / (36 * 8192) for one in (1, 2, 3)], rel=1e-12)
    assert bus.by_wheel == 2
    assert bus.turned(3, [*all_say(50, 73)[:2], (0x203, bytes(7))]) is None
    assert (bus.by_wheel, bus.malformed_frames) == (3, 1)


@pytest.mark.parametrize("usual_ticks", [1, 6])
def test_usual_ticks_are_remembered_when_a_wheel_falls_silent(usual_ticks):
    bus = MotorBus(ROBOT)
    for tick in range(usual_ticks):
        bus.turned(tick, all_say(10 * tick, 73))
    assert bus.silences(usual_ticks + 2) == [3, 3, 3]
    bus.turned(usual_ticks, all_say(10 * usual_ticks, 73)[1:])
    assert bus.silences(usual_ticks) == [1, 0, 0]


def test_a_bus_whose_reports_were_all_late_at_once_is_in_step_again():
    assert is_in_step(bus_with_late_reports(QUICK, QUICK_RPM), 12, QUICK * 12, QUICK_RPM)


def test_two_reports_in_the_first_tick_do_not_make_later_ones_late():
    bus = Counted(ROBOT)
    bus.turned(0, all_say(0, 0) * 2)
    bus.turned(1, ())
    bus.turned(2, all_say(0, 0))
    assert is_in_step(bus, 3, 0, 0)


@pytest.mark.parametrize(("disturbed", "calm_from"), [(None, 21), ("foreign", 41), ("two", 41)])
def test_late_reports_are_forgotten_after_fifty_calm_ticks(disturbed, calm_from):
    """Until then a report after a lost one may be of two ticks, and those after it: none is taken for a usual one."""
    bus = bus_with_late_reports(STILL, 0)
    for tick in range(12, calm_from + 50):
        frames = all_say(0, 0)
        if tick == 20:
            frames = ()
        if tick == 40:
            frames = {"foreign": (*frames, (0x208, bytes(8))), "two": frames[1:]}.get(disturbed, frames)
        before = bus.by_wheel
        bus.turned(tick, frames)
        assert (bus.by_wheel == before) == (tick < 20), tick
    assert is_in_step(bus, calm_from + 50, 0, 0)
    bus.turned(calm_from + 51, ())
    bus.turned(calm_from + 52, all_say(0, 0))
    assert is_in_step(bus, calm_from + 53, 0, 0), "one after a lost one is of its tick again"


def test_a_copy_of_a_report_takes_no_time():
    bus = Counted(ROBOT)
    bus.turned(0, all_say(0, SLOW_RPM))
    assert counts_of(bus.turned(1, all_say(SLOW, SLOW_RPM) * 2)) == [SLOW] * 3
    assert counts_of(bus.speeds_radps) == [SLOW * 1000] * 3
    assert bus.turned(2, ()) is None
    three = (*all_say(SLOW * 2, SLOW_RPM), *all_say(SLOW * 3, SLOW_RPM) * 2)
    assert counts_of(bus.turned(3, three)) == [SLOW * 2] * 3
    assert counts_of(bus.speeds_radps) == [SLOW * 1000] * 3


def test_the_speed_says_how_long_a_gap_was_where_reports_may_be_late():
    """At 20,000 rpm two ticks are two thirds of a turn: the shorter way round is the other one."""
    rpm, counts = 20_000, 2731
    bus = bus_with_late_reports(counts, rpm)
    assert bus.turned(12, ()) is None
    assert counts_of(bus.turned(13, all_say(counts * 13, rpm))) == [2 * counts] * 3
    assert counts_of(bus.speeds_radps) == [counts * 1000] * 3


def test_where_two_gaps_agree_the_speed_is_over_the_ticks_since_a_wheel_was_heard():
    bus = bus_with_late_reports(SLOW, SLOW_RPM)
    bus.turned(12, ())
    for tick, ticks in ((13, 2), (14, 1), (15, 1)):
        assert counts_of(bus.turned(tick, all_say(SLOW * tick, SLOW_RPM))) == [SLOW * ticks] * 3
        assert counts_of(bus.speeds_radps) == [SLOW * 1000] * 3


@pytest.mark.parametrize(
    ("ticks", "speed_ticks", "in_step"),
    [
        (1, 1, False),  # it was born a tick before: reports may be late from now on
        (2, 2, True),
        (3, 2, True),  # none is born before the one before it: not believed, and the angle is
        (0, 2, True),  # nor is it of the same tick
    ],
)
def test_a_report_after_a_lost_one_is_as_old_as_its_speed_says(ticks, speed_ticks, in_step):
    rpm, counts = 3000, 410
    bus = Counted(ROBOT)
    for tick in range(5):
        bus.turned(tick, all_say(counts * tick, rpm))
    bus.turned(5, ())
    assert counts_of(bus.turned(6, all_say(counts * (4 + ticks), rpm))) == [counts * ticks] * 3
    assert counts_of(bus.speeds_radps) == pytest.approx([counts * ticks * 1000 / speed_ticks] * 3, abs=1)
    assert is_in_step(bus, 7, counts * (5 + ticks), rpm) == in_step


def test_an_angle_that_contradicts_its_speed_over_one_lost_frame_is_taken_the_shorter_way():
    bus = bus_with_late_reports(STILL, 0)
    bus.turned(12, ())
    assert counts_of(bus.turned(13, all_say(1000, 0))) == [1000] * 3
    assert counts_of(bus.speeds_radps) == [500_000] * 3
    assert bus.watch.findings == ()
    assert not is_in_step(bus, 14, 1000, 0), "nor is it known when it was born"


@pytest.mark.parametrize("were_late", [False, True])
def test_over_two_lost_frames_it_is_told(were_late):
    bus = bus_with_late_reports(STILL, 0)
    if not were_late:
        bus = Counted(ROBOT)
        bus.turned(11, all_say(0, 0))
    assert (bus.turned(12, ()), bus.turned(13, ())) == (None, None)
    assert bus.turned(14, all_say(1000, 60)) == []
    assert bus.speeds_radps == pytest.approx([-math.tau / 36] * 3, rel=1e-12), "a rotor turn a second, as it reports"
    assert [(one.kind, one.can_id) for one in bus.watch.findings] == [(Kind.LOST_COUNT, 0x201 + i) for i in range(3)]


@pytest.mark.parametrize(("silent_ticks", "known"), [(35, True), (36, False)])
def test_a_report_that_may_be_late_is_not_known_for_longer(silent_ticks, known):
    """At rest every gap agrees, but not even that says what happened in 37 ticks."""
    bus = bus_with_late_reports(STILL, 0)
    for tick in range(12, 12 + silent_ticks):
        bus.turned(tick, ())
    assert (bus.turned(12 + silent_ticks, all_say(0, 0)) != []) == known
