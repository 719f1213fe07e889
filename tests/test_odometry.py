"""Odometry against the truth: closed forms on paper, the plant's pose, and the slip between them."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from bases import dead_wheels, m2006, omni4
from hypothesis import given, settings
from hypothesis import strategies as st
from rig import Rig

from bench.base import Base
from bench.check.reading import Recording
from bench.check.recording import Recorder, RunInfo
from bench.check.sources import from_recording
from bench.config import Gyro, Wheel, load_robot, robot_names
from bench.errors import UsageError
from bench.instruments import EmulatedGyro, GyroBus, NormalNumbers, PassiveWheels
from bench.kinematics import Kinematics, twist_from_document_002
from bench.loop import Bench, simulated
from bench.m2006 import encode_feedback
from bench.messages import BodyTwist, Pose, TickInput
from bench.noise import Noise
from bench.odometry import Odometry, wrap
from bench.plant import Arena, Plant
from bench.rc.transmitter import Sticks
from bench.reckoning import DEAD_WHEELS, DRIVEN_WHEELS, GYRO
from bench.world import SimulatedMotors, World

M2006 = load_robot("m2006")
DOCUMENT_002 = dead_wheels()


def off(pose, other):
    """Distance in m and angle in rad between two poses."""
    return math.dist(pose[:2], other[:2]), abs(wrap(pose[2] - other[2]))


def with_instruments(robot=M2006, *, dead=True, gyro=None):
    return replace(robot, dead_wheels=DOCUMENT_002 if dead else (), gyro=gyro)


def slippery(**changes):
    """Grip 0.15, and a driver who asks for more than that at once."""
    return m2006(ground_grip=0.15, limits_current_a=3.0, limits_linear_acceleration_mps2=20.0, **changes)


def four_wheels(**changes):
    robot = omni4(**changes)
    return replace(robot, wheels=tuple(replace(wheel, can_id=number) for number, wheel in enumerate(robot.wheels, 1)))


# --- on paper ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wheels", [M2006.wheels, DOCUMENT_002, omni4().wheels], ids=["004", "002", "four"])
@pytest.mark.parametrize("turn_deg", [90, -90, 180, 270, 360, 450])
def test_arcs_at_document_002s_rate_end_where_geometry_says(wheels, turn_deg):
    # Reference kinematics section 4: 1 m/s and 2 rad/s, 5 ms steps. Euler is 3.53 mm off after a quarter of a turn and
    # 5.00 mm after half a turn; the exponential map is off by nothing.
    turn = math.radians(turn_deg)
    steps = round(abs(turn) / 2.0 / 0.005)
    length_m = abs(turn) / 2.0
    kinematics = Kinematics(wheels)
    odometry = Odometry(kinematics)
    for _ in range(steps):
        odometry.advance(kinematics.wheel_speeds((length_m / steps, 0.0, turn / steps)))
    radius_m = length_m / turn
    assert odometry.pose[:2] == pytest.approx((radius_m * math.sin(turn), radius_m * (1 - math.cos(turn))), abs=1e-12)
    assert odometry.heading_rad == pytest.approx(turn, abs=1e-12)


@settings(max_examples=30)
@given(st.floats(-math.pi, math.pi), st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)))
def test_dead_wheels_turn_as_document_002_writes_them(heading, world_twist):
    # Its three equations, world velocities (x right, y forward) and its f, i, r at 0, 120, 240 degrees from forward.
    vx, vy, w = world_twist
    t, d = heading, 0.1
    rims = (
        -vx * math.cos(t) - vy * math.sin(t) + d * w,
        vx * math.sin(math.pi / 6 + t) + vy * math.sin(t - math.pi / 3) + d * w,
        vx * math.sin(math.pi / 6 - t) + vy * math.sin(t + math.pi / 3) + d * w,
    )
    wheels = PassiveWheels(with_instruments(), Pose(0.0, 0.0, t))
    x, y, omega = twist_from_document_002(vx, vy, w)
    # One step of 1 ms, its chord at the heading half way: the velocity at the heading of the equations is that turned.
    c, s = math.cos(omega * 0.0005), math.sin(omega * 0.0005)
    wheels.follow(Pose(0.001 * (c * x - s * y), 0.001 * (s * x + c * y), t + 0.001 * omega))
    assert [0.025 * speed for speed in wheels.speeds_radps] == pytest.approx(rims, abs=1e-9)


# --- encoders ----------------------------------------------------------------------------------------------------


def steps_of(robot, *angles):
    """A base that has heard these rotor angles of all its motors, one each millisecond."""
    base = Base(robot)
    for tick, angle in enumerate(angles):
        base.step(tick, b"", b"", [(0x200 + wheel.can_id, encode_feedback(angle, 0, 0)) for wheel in robot.wheels])
    return base


@pytest.mark.parametrize("start", [0, 4321, 8191])
def test_the_first_sample_only_sets_the_reference(start):
    # Document 000's code reports the whole counter as motion on the first call.
    assert steps_of(M2006, start).odometry.pose == (0.0, 0.0, 0.0)


COUNT_RAD = math.tau / 8192 / 36


@pytest.mark.parametrize(
    ("angles", "counts"),
    [
        ((8191, 0), 1),
        ((0, 8191), -1),
        ((8190, 8191, 0, 1), 3),
        ((1, 0, 8191, 8190), -3),
        # 29,999 rpm is 4095.9 counts a millisecond: the most that 1 kHz can tell, further than any M2006 gets.
        ((8000, 3903, 7998), 2 * 4095),
        ((100, 4197, 102), -2 * 4095),
    ],
)
def test_rotor_angles_are_unwrapped_both_ways(angles, counts):
    # All three wheels turn alike, so the robot turns: the inverse matrix of the reference, section 3.5. This robot's
    # wire counts down when its wheels turn counter-clockwise.
    turn_per_wheel_rad = 0.175809 + 0.091005 + 0.175809
    heading = steps_of(M2006, *angles).odometry.heading_rad
    assert heading == pytest.approx(-counts * COUNT_RAD * turn_per_wheel_rad, rel=1e-5)


class Gaps(SimulatedMotors):
    """A wire on which some frames get lost: `lost(tick, can_id)` says which."""

    lost = staticmethod(lambda tick, can_id: False)

    def step(self, tick, commands):
        return tuple(frame for frame in super().step(tick, commands) if not self.lost(tick, frame[0]))


def rig_with_gaps(robot, lost):
    motors = Gaps(robot)
    motors.lost = lost
    plain = simulated(robot)
    return Rig(bench=Bench(plain.base, World(robot, core=plain.world.core, motors=motors))).arm()


def drive(rig, ticks=1000):
    """A bend, and a stop in which the last report comes through."""
    rig.run(ticks, Sticks(forward=0.5, left=0.2, turn=0.4))
    rig.run(400)
    return off(rig.truth, rig.believed)


@pytest.mark.parametrize(
    ("lost", "metres"),
    [
        (lambda tick, can_id: tick % 2 and can_id == 0x201, 5e-4),  # one ESC reports at 500 Hz
        (lambda tick, can_id: tick % 7 == can_id % 3, 5e-4),  # single frames of all of them
    ],
)
def test_single_lost_frames_lose_no_motion(lost, metres):
    distance_m, angle_rad = drive(rig_with_gaps(m2006(ground_grip=1e6), lost))
    assert distance_m < metres
    assert angle_rad < 2e-3


@pytest.mark.parametrize("gap", [5, 15, 20])
def test_a_gap_of_all_wheels_leaves_no_motion_out(gap):
    # 20 ms at some 14 rad/s of the wheels: 1.6 rotor turns.
    rig = rig_with_gaps(m2006(ground_grip=1e6), lambda tick, can_id: 700 <= tick < 700 + gap)
    rig.run(701 - rig.bench.now_tick, Sticks(forward=0.5))  # the last report before the gap arrives in its first tick
    before, at = rig.believed, rig.truth
    rig.run(gap, Sticks(forward=0.5))
    assert rig.believed == before
    rig.run(1, Sticks(forward=0.5))
    assert math.dist(rig.truth[:2], at[:2]) > 0.0002 * gap
    late_m = 0.001 * math.hypot(*rig.bench.world.plant.twist[:2])
    assert off(rig.truth, rig.believed)[0] < late_m + 1e-4
    assert rig.bench.bus_findings == ()


def test_a_gap_too_long_is_no_motion_rather_than_a_wrong_one_and_is_told():
    rig = rig_with_gaps(m2006(ground_grip=1e6), lambda tick, can_id: can_id == 0x202 and 700 <= tick < 760)
    rig.run(701 - rig.bench.now_tick, Sticks(left=0.5))
    before = rig.believed
    rig.run(61, Sticks(left=0.5))
    assert rig.believed == before
    (finding,) = rig.bench.bus_findings
    assert finding.startswith("0x202 lost count, once since 0.761 s: silent for so long that its whole turns are not")
    at, before = rig.truth, rig.believed
    rig.run(400)
    assert math.dist(at[:2], rig.truth[:2]) == pytest.approx(math.dist(before[:2], rig.believed[:2]), abs=1e-3)


LATE_AND_LOST = Noise(angle_counts=2, late_ticks=3, loss_ppm=100_000, seed=5)


def by_true_wheels(bench, inputs):
    """Run; odometry of what the wheels really turned, tick by tick: it slips as they do, and misses nothing."""
    reference, last = Odometry(Kinematics(bench.robot.wheels)), bench.world.plant.wheel_angles_rad
    for given_input in inputs:
        bench.tick(given_input)
        angles = bench.world.plant.wheel_angles_rad
        reference.advance([new - old for new, old in zip(angles, last, strict=True)])
        last = angles
    return reference


def there_and_back(robot, ticks=250):
    """By the core at full speed, in a bend; then the other way at once; then a stop. No limit but the current."""
    most = robot.limits
    for forward, left, turn in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.1), (-1.0, 0.3, 0.0), (0.0, 0.0, 0.0)):
        twist = BodyTwist(forward * most.linear_mps, left * most.linear_mps, turn * most.angular_radps)
        yield from [TickInput(b"", twist)] * (ticks if forward else 150)


@pytest.mark.parametrize(
    ("name", "noise"),
    [
        *((name, LATE_AND_LOST) for name in robot_names()),
        ("m2006", Noise(late_ticks=2, loss_ppm=10_000, seed=1)),  # told 120 mm of 214 once
        ("m2006", Noise(late_ticks=1, loss_ppm=10_000, seed=2)),
        ("mecanum", Noise(late_ticks=3, loss_ppm=10_000, seed=3)),
    ],
)
def test_late_and_lost_frames_lose_no_motion(name, noise):
    robot = load_robot(name)
    limits = replace(robot.limits, linear_acceleration_mps2=20.0, angular_acceleration_radps2=200.0)
    bench = simulated(replace(robot, rc=None, limits=limits), noise=noise)
    reference = by_true_wheels(bench, there_and_back(robot))
    truth = reference.pose if name != "deadwheel3" else bench.world.plant.pose
    distance_m, angle_rad = off(truth, bench.base.odometry.pose)
    # Angles that are off by 2 counts; steps that hold several ticks; while wheels are waited for, some are older.
    size = max(wheel.radius_m for wheel in robot.wheels) / 0.05
    assert distance_m < 1e-3 * size
    assert angle_rad < 1e-3
    assert bench.bus_findings == ()


@pytest.mark.parametrize("which", [(0x202,), (0x201, 0x202, 0x203)], ids=["one", "all"])
@pytest.mark.parametrize("burst", [5, 20, 50])
def test_bursts_of_loss_lose_no_motion_that_can_be_known(burst, which):
    robot = replace(m2006(), rc=None)
    motors = Gaps(robot)
    motors.lost = lambda tick, can_id: can_id in which and tick % 150 < burst and tick < 600
    plain = simulated(robot)
    bench = Bench(plain.base, World(robot, core=plain.world.core, motors=motors))
    reference = by_true_wheels(bench, there_and_back(robot))
    distance_m, angle_rad = off(reference.pose, bench.base.odometry.pose)
    if burst <= 36:
        assert (distance_m < 5e-4, angle_rad < 5e-4, bench.bus_findings) == (True, True, ())
    else:
        assert distance_m > 0.005, "the way of the gaps"
        assert [text[:5] for text in bench.bus_findings] == [f"0x{can_id:X}" for can_id in which]
        assert all("lost count, 3 times since 0.2" in text for text in bench.bus_findings)


@pytest.mark.parametrize("name", robot_names())
def test_a_silence_within_its_bound_loses_no_robots_motion(name):
    robot = replace(load_robot(name), rc=None)
    motors = Gaps(robot)
    motors.lost = lambda tick, can_id: tick % 97 < 13 and tick < 600
    plain = simulated(robot)
    bench = Bench(plain.base, World(robot, core=plain.world.core, motors=motors))
    reference = by_true_wheels(bench, there_and_back(robot))
    truth = reference.pose if name != "deadwheel3" else bench.world.plant.pose
    distance_m, angle_rad = off(truth, bench.base.odometry.pose)
    assert (distance_m < 3e-4, angle_rad < 3e-4, bench.bus_findings) == (True, True, ())


def test_a_gyro_turns_the_way_that_was_waited_for():
    # A bend of 4 rad/s at 0.35 m/s, of which the wheels tell every 20 ms: 0.08 rad, or 0.3 mm of each 7 mm.
    robot = with_instruments(m2006(ground_grip=1e6, limits_angular_radps=4.0), dead=False, gyro=Gyro(1))
    rig = rig_with_gaps(robot, lambda tick, can_id: can_id == 0x203 and tick % 20 and tick < 1000)
    rig.run(1000 - rig.bench.now_tick, Sticks(forward=0.6, turn=1.0))
    rig.run(400)
    assert off(rig.truth, rig.believed)[0] < 1e-3


# --- truth beside the estimate -------------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", [m2006(ground_grip=1e6), four_wheels(ground_grip=1e6)], ids=["three", "four"])
def test_with_grip_without_end_driven_wheels_are_right_to_a_millimetre_after_a_second(robot):
    # Plant-model reference, section 4.3.
    distance_m, angle_rad = drive(Rig(robot).arm())
    assert distance_m < 1e-3
    assert angle_rad < 2e-3


def test_what_driven_wheels_are_off_by_is_the_slip_integral():
    # Plant-model reference, section 4.3: off by sum s_i dt. Passive wheels in the driven ones' places turn with the
    # ground; each driven wheel lags them by what has slipped under it, along its own axis.
    robot = slippery()
    plant = Plant(robot)
    ground = PassiveWheels(replace(robot, dead_wheels=robot.wheels), plant.pose)
    slipped_m = [0.0] * 3
    for step in range(1500):
        slipped_m = [sum_m + 0.001 * slip for sum_m, slip in zip(slipped_m, plant.slip_mps, strict=True)]
        plant.step((1.2, -0.4, -1.2) if step < 700 else (0.0, 0.0, 0.0))
        ground.follow(plant.pose)
    lags_m = [0.027 * (true - turned) for true, turned in zip(ground.angles_rad, plant.wheel_angles_rad, strict=True)]
    assert max(map(abs, slipped_m)) > 0.2, "it did slip"
    assert lags_m == pytest.approx(slipped_m, abs=1e-5)
    # And the robot believes what its wheels turned: the truth less the slip, seen through the inverse matrix.
    missing = Kinematics(robot.wheels).twist([slip / 0.027 for slip in slipped_m])
    odometry, true = Odometry(Kinematics(robot.wheels)), Odometry(Kinematics(robot.wheels))
    odometry.advance(plant.wheel_angles_rad)
    true.advance(ground.angles_rad)
    assert true.heading_rad - odometry.heading_rad == pytest.approx(missing.omega_radps, abs=1e-4)


def test_dead_wheels_are_right_while_the_driven_ones_spin():
    offs = {}
    for name, robot in (("driven", slippery()), ("dead", with_instruments(slippery()))):
        rig = Rig(robot).arm()
        worst_m = 0.0
        for sticks in (Sticks(forward=1.0, turn=0.3), Sticks(left=-1.0, turn=-0.4), Sticks(forward=-1.0)):
            for _ in range(30):
                rig.run(20, sticks)
                worst_m = max(worst_m, off(rig.truth, rig.believed)[0])
        rig.run(500)
        offs[name] = (worst_m, *off(rig.truth, rig.believed))
    assert offs["driven"][0] > 0.2
    # While it drives the report is a millisecond old: 1 mm at 1 m/s. At rest what stays is 8192 counts on 25 mm.
    assert offs["dead"][0] < 2e-3
    assert offs["dead"][1] < 3e-4
    assert offs["dead"][2] < 1e-3


def test_dead_wheels_stop_with_the_body_at_a_wall_while_the_driven_ones_turn_on():
    # Plant-model reference, section 3.3: stopped at 0.83 m/s the wheels turn on with 29.7 rad/s, 10.9 after 100 ms.
    # (The centre of gravity on the floor: a wall that pushes above it would take load, and with it brakes, from them.)
    robot = with_instruments(m2006(body_cog_height_m=0.0))
    plant = Plant(robot, Arena(1.0, 0.8), Pose(0.4195, 0.0, 0.0), BodyTwist(0.83, 0.0, 0.0))
    plain = simulated(robot)
    bench = Bench(plain.base, World(robot, core=None, motors=SimulatedMotors(robot, plant)))
    driven = Odometry(Kinematics(robot.wheels))
    last, speeds = plant.wheel_angles_rad, []
    for _ in range(400):
        bench.tick()
        driven.advance([new - old for new, old in zip(plant.wheel_angles_rad, last, strict=True)])
        last = plant.wheel_angles_rad
        if plant.twist.vx_mps < 0.1:
            speeds.append(abs(plant.wheel_speeds_radps[0]))
    assert speeds[0] == pytest.approx(29.7, abs=0.3)
    assert speeds[100] == pytest.approx(10.9, abs=0.3)
    travelled_m = plant.pose.x_m - 0.4195
    assert bench.base.odometry.pose.x_m == pytest.approx(travelled_m, abs=1e-3)
    assert driven.pose.x_m - travelled_m > 0.04, "the driven wheels report a way that was not gone"


def test_a_push_is_seen_by_dead_wheels_alone():
    # The motors brake, the floor gives way, and somebody pushes: driven wheels stand.
    robot = with_instruments(m2006(ground_grip=0.02))
    plant = Plant(robot, None, twist=BodyTwist(0.4, 0.3, 0.5))
    plain = simulated(robot)
    bench = Bench(plain.base, World(robot, core=None, motors=SimulatedMotors(robot, plant)))
    for _ in range(1500):
        bench.tick()
    assert math.hypot(plant.pose.x_m, plant.pose.y_m) > 0.1
    assert off(plant.pose, bench.base.odometry.pose)[0] < 1e-3


# --- sources that fall silent ----------------------------------------------------------------------------------------


def test_a_silent_encoder_board_is_waited_for_then_done_without():
    robot = with_instruments(m2006(ground_grip=1e6))
    rig = rig_with_gaps(robot, lambda tick, can_id: can_id == 0x205 and 600 <= tick < 900)
    rig.run(600 - rig.bench.now_tick, Sticks(forward=0.5, turn=0.2))
    reckoning = rig.bench.base.reckoning
    sources = []
    for _ in range(320):
        rig.run(1, Sticks(forward=0.5, turn=0.2))
        sources.append(reckoning.source)
    # The last report of tick 599 arrives in tick 600; feedback_timeout_ms is 20; the first new one arrives in 901.
    changes = [600 + place + 1 for place, (old, new) in enumerate(pairwise(sources)) if old != new]
    assert sources[0] == DEAD_WHEELS
    assert changes == [620, 902]
    assert sources[-1] == DEAD_WHEELS
    rig.run(400)
    distance_m, angle_rad = off(rig.truth, rig.believed)
    assert distance_m < 2e-3
    assert angle_rad < 4e-3


@pytest.mark.parametrize("gap", [1, 19, 20, 25, 60])
def test_no_gap_of_dead_wheels_loses_motion_or_counts_it_twice(gap):
    # Up to 20 ms they are waited for; then the driven wheels stand in, which are as right where nothing slips.
    robot = with_instruments(slippery() if gap < 20 else m2006(ground_grip=1e6))
    rig = rig_with_gaps(robot, lambda tick, can_id: can_id == 0x205 and tick % 80 < gap)
    rig.run(800 - rig.bench.now_tick % 80, Sticks(forward=1.0, turn=0.3))
    assert rig.bench.base.reckoning.source == DEAD_WHEELS
    rig.run(600)
    assert off(rig.truth, rig.believed)[0] < 2e-3


@pytest.mark.parametrize("gap", [21, 40, 71])
def test_dead_wheels_tell_of_a_silence_in_which_no_driven_wheel_could_stand_in(gap):
    # Nobody was heard for longer than driven wheels know their turns; dead ones turn slowly enough to.
    rig = rig_with_gaps(load_robot("deadwheel3"), lambda tick, can_id: 600 <= tick < 600 + gap)
    rig.run(601 - rig.bench.now_tick, Sticks(forward=0.8, turn=0.2))
    at = rig.truth
    rig.run(gap, Sticks(forward=0.8, turn=0.2))
    assert math.dist(rig.truth[:2], at[:2]) > 0.003
    rig.run(60, Sticks(forward=0.8, turn=0.2))
    rig.run(400)
    assert off(rig.truth, rig.believed)[0] < 1e-3
    assert [text.split(",")[0] for text in rig.bench.bus_findings] == [f"0x20{i} lost count" for i in (1, 2, 3)]


def test_wheels_stand_in_for_a_silent_gyro():
    robot = with_instruments(m2006(ground_grip=1e6), dead=False, gyro=Gyro(1))
    rig = rig_with_gaps(robot, lambda tick, can_id: can_id == 0x301 and 600 <= tick < 900)
    rig.run(590 - rig.bench.now_tick, Sticks(turn=0.5))
    reckoning = rig.bench.base.reckoning
    assert (reckoning.heading_source, reckoning.source) == (GYRO, DRIVEN_WHEELS)
    rig.run(200, Sticks(turn=0.5))
    assert reckoning.heading_source == DRIVEN_WHEELS
    rig.run(200, Sticks(turn=0.5))
    assert reckoning.heading_source == GYRO
    rig.run(400)
    assert off(rig.truth, rig.believed)[1] < 3e-3


# --- the gyro ------------------------------------------------------------------------------------------------------


def test_a_gyros_heading_is_true_where_all_wheels_slip():
    offs = {}
    for gyro in (None, Gyro(1)):
        rig = Rig(with_instruments(slippery(), dead=False, gyro=gyro)).arm()
        rig.run(800, Sticks(forward=1.0, left=0.5, turn=1.0))
        rig.run(600)
        offs[gyro] = off(rig.truth, rig.believed)
    assert offs[None][1] > 0.1
    assert offs[Gyro(1)][1] < 1e-4
    assert rig.bench.base.odometry.heading_rad == pytest.approx(rig.bench.base.reckoning.gyro.turned_rad, abs=1e-12)


@pytest.mark.parametrize("bias_degps", [0.5, -2.0])
def test_a_gyros_bias_drifts_by_bias_times_time(bias_degps):
    bias = math.radians(bias_degps)
    rig = Rig(with_instruments(dead=False, gyro=Gyro(1, bias_radps=bias)))
    rig.run(2001)
    # 2001 ticks: the reference comes with the report of tick 0, the last one heard is that of tick 1999.
    assert rig.truth.heading_rad == 0.0
    assert rig.believed.heading_rad == pytest.approx(bias * 1.999, abs=1e-8)
    assert rig.believed[:2] == (0.0, 0.0)


def test_a_printed_form_cannot_follow_a_gyro():
    robot = replace(load_robot("deadwheel3"), odometry="document-002-as-printed")
    assert Base(robot).reckoning.source == DEAD_WHEELS
    with pytest.raises(UsageError, match="takes its heading from wheels, and deadwheel3 has a gyro"):
        Base(replace(robot, gyro=Gyro(1)))


def test_noise_is_normal_enough_and_follows_its_seed():
    source = NormalNumbers(7)
    numbers = [source.next() for _ in range(20_000)]
    mean = math.fsum(numbers) / len(numbers)
    variance = math.fsum((number - mean) ** 2 for number in numbers) / len(numbers)
    assert abs(mean) < 4 / math.sqrt(len(numbers))
    assert variance == pytest.approx(1.0, abs=4 * math.sqrt(2 / len(numbers)))
    assert math.fsum(abs(number) < 1.0 for number in numbers) / len(numbers) == pytest.approx(0.683, abs=0.015)
    other, again = NormalNumbers(8), NormalNumbers(7)
    assert numbers[:5] == [again.next() for _ in range(5)] != [other.next() for _ in range(5)]


def test_a_noisy_gyro_walks_as_a_sum_of_noise_does():
    # After n samples of deviation s over dt the heading has the deviation s dt sqrt(n).
    ends = []
    for seed in range(60):
        gyro = EmulatedGyro(Gyro(1, rate_noise_radps=0.1, seed=seed))
        for _ in range(400):
            gyro.report(0.0)
        ends.append(gyro.turned_rad)
    deviation = math.sqrt(math.fsum(end * end for end in ends) / len(ends))
    assert deviation == pytest.approx(0.1 * 0.001 * math.sqrt(400), rel=0.35)


@settings(max_examples=30)
@given(st.integers(0, (1 << 32) - 1), st.lists(st.floats(-3.1, 3.1), max_size=20))
def test_any_turn_comes_through_the_gyros_frame(start, turns):
    bus, sensor = GyroBus(Gyro(3)), EmulatedGyro(Gyro(3))
    sensor.turned_rad = start * math.tau / (1 << 32)
    bus.receive(0, [sensor.report(0.0)])
    assert bus.turned_rad == 0.0
    for tick, turn in enumerate(turns, 1):
        heard = bus.receive(tick, [(0x201, bytes(8)), sensor.report(turn)])
        assert heard == pytest.approx(turn, abs=2e-9)
    assert bus.turned_rad == pytest.approx(math.fsum(turns), abs=1e-8)
    if turns:
        assert bus.rate_radps == pytest.approx(max(-32.767, min(32.767, turns[-1] * 1000)), abs=5e-4)


def test_a_gyros_frame_of_another_length_is_counted_and_dropped():
    bus = GyroBus(Gyro(1))
    assert bus.receive(0, [(0x301, bytes(5)), (0x301, bytes(8)), (0x302, bytes(6))]) is None
    assert bus.malformed_frames == 2


# --- what contradicts itself -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bearings_deg", "n"),
    [
        ((60.0, -60.0, -120.0, 120.0), (-0.5, 0.5, -0.5, 0.5)),  # reference kinematics 3.2
        (
            (57.2957795131, 137.0281653652, 222.9718346348, 302.7042204869),
            (-0.44509, 0.54945, -0.54945, 0.44509),
        ),  # 3.6
    ],
)
@settings(max_examples=30)
@given(speeds=st.tuples(*[st.floats(-50, 50)] * 4))
def test_the_slip_residual_is_the_references_n_times_the_wheels(bearings_deg, n, speeds):
    wheels = []
    for number, bearing_deg in enumerate(bearings_deg, 1):
        b = math.radians(bearing_deg)
        wheels.append(Wheel("", 0.1 * math.cos(b), 0.1 * math.sin(b), b - math.pi / 2, 0.03, number))
    expected = abs(math.fsum(share * speed for share, speed in zip(n, speeds, strict=True)))
    assert Kinematics(wheels).slip_residual(speeds) == pytest.approx(expected, abs=2e-3)


def slip_rows(rig):
    at = rig.bench.state_columns.index("slip_radps")
    return [(out.tick, *out.state[at : at + 2]) for out in rig.outputs if out.state]


def test_a_redundant_base_sees_its_slip_and_says_so():
    robot = four_wheels(limits_current_a=3.0)
    rig = Rig(robot).arm()
    plant, kinematics = rig.bench.world.plant, Kinematics(robot.wheels)
    rig.bench.world.core.ask_wheels((0.0, 0.0, 0.0, 0.0))
    rig.run(800)
    assert rig.bench.snapshot().slip_radps < 0.1
    rig.bench.world.core.ask_wheels((0.3, 0.0, 0.0, 0.0))  # one wheel against the other three
    seen = 0.0
    for _ in range(40):
        rig.run(17)
        slips = plant.slip_mps  # how the wheels slip during the next tick: its report is heard in the one after
        rig.run(2)
        true = kinematics.slip_residual([slip / 0.027 for slip in slips])
        assert rig.bench.snapshot().slip_radps == pytest.approx(true, abs=0.1)
        seen = max(seen, true)
    assert seen > 3.0
    limit = robot.limits.slip_radps
    assert rig.bench.snapshot().slip_limit_radps == limit
    rows = slip_rows(rig)
    assert min(slip for _, slip, flag in rows if flag) > limit >= max(slip for _, slip, flag in rows if not flag)


def test_a_base_with_grip_says_nothing_of_slip():
    rig = Rig(four_wheels(ground_grip=1e6)).arm()
    drive(rig)
    assert not any(flag for *_, flag in slip_rows(rig))
    assert max(slip for _, slip, _ in slip_rows(rig)) < 0.1, "rounding of the encoders alone"


def test_dead_wheels_show_the_slip_of_three_driven_ones():
    rig = Rig(with_instruments(slippery())).arm()
    plant, reckoning = rig.bench.world.plant, rig.bench.base.reckoning
    slips = []  # of each wheel, in rad/s, during each tick
    seen = told = 0.0
    for sticks in [Sticks(forward=1.0, turn=0.2)] * 300 + [Sticks()] * 500:
        slips.append([slip / 0.027 for slip in plant.slip_mps])
        rig.run(1, sticks)
        fresh, told = reckoning.slip_radps != told, reckoning.slip_radps
        if fresh and len(slips) > 11:
            # The newest report that the base has heard is that of the tick before.
            means = [math.fsum(wheel) / 10 for wheel in zip(*slips[-11:-1], strict=True)]
            assert told == pytest.approx(math.hypot(*means), abs=0.15)
            seen = max(seen, told)
    assert seen > 10.0
    assert rig.bench.base.slip_radps < 0.1, "it stands"
    assert any(flag for *_, flag in slip_rows(rig))


def test_lost_frames_are_no_slip():
    lost = {0x201: range(650, 660), 0x204: range(700, 705), 0x206: range(750, 780)}
    robot = with_instruments(m2006(ground_grip=1e6))
    rig = rig_with_gaps(robot, lambda tick, can_id: tick in lost.get(can_id, ()))
    rig.run(700, Sticks(forward=1.0, turn=0.3))
    assert max(slip for _, slip, _ in slip_rows(rig)) < 0.2


def test_three_wheels_cannot_see_their_slip():
    bench = simulated(M2006)
    assert bench.snapshot().slip_radps is None
    assert "slip_radps" not in bench.state_columns


# --- on the wires and in a recording ---------------------------------------------------------------------------------


def test_the_slamware_answers_come_from_the_chosen_odometry():
    ends = {}
    for name, robot in (("driven", slippery()), ("dead", with_instruments(slippery(), gyro=Gyro(1)))):
        rig = Rig(robot).arm()
        rig.run(600, Sticks(forward=1.0, turn=0.3))
        rig.run(600)
        ends[name] = off(rig.truth, rig.bench.world.core.pose)[0], off(rig.believed, rig.bench.world.core.pose)[0]
    assert ends["driven"][0] > 0.05
    assert ends["dead"][0] < 1e-3
    assert max(believed_off for _, believed_off in ends.values()) < 1e-3


def test_the_way_through_reckoning_is_the_default_robots_own_to_the_last_bit():
    # A dialect that tells of rims takes a robot of driven wheels alone through bench/reckoning.py.
    slamware = replace(M2006.slamware, dialect="firmware-2018-omni")
    poses = []
    for robot in (M2006, replace(M2006, slamware=slamware)):
        rig = Rig(robot).arm()
        rig.run(300, Sticks(forward=0.5, left=-0.3, turn=0.7))
        poses.append((rig.believed, rig.bench.base.odometry.heading_rad))
    assert rig.bench.base.reckoning.turned_rad == pytest.approx(rig.bench.world.plant.wheel_angles_rad, abs=0.02)
    assert poses[0] == poses[1]


def test_rims_are_those_of_driven_wheels_where_odometry_follows_dead_ones():
    robot = slippery()
    robot = with_instruments(replace(robot, slamware=replace(robot.slamware, dialect="firmware-2018-omni")))
    rig = Rig(robot).arm()
    rig.run(400, Sticks(forward=1.0))
    rig.run(500)
    told_m = rig.bench.base.slave.motion.rim_distances_m()
    assert told_m == pytest.approx([0.027 * angle for angle in rig.bench.world.plant.wheel_angles_rad], abs=1e-4)
    dead_m = math.dist(rig.believed[:2], (0.0, 0.0))
    assert abs(told_m[0]) > 1.5 * dead_m, "they spun"


def test_columns_stand_only_where_a_robot_has_something_to_tell():
    plain = simulated(M2006).state_columns
    assert len(plain) == 13 + 9
    more = simulated(with_instruments(gyro=Gyro(1))).state_columns
    assert more[: len(plain)] == plain
    assert more[len(plain) :] == (
        "slip_radps", "slipping",
        "dead1_rad", "dead1_encoder_rad", "dead2_rad", "dead2_encoder_rad", "dead3_rad", "dead3_encoder_rad",
        "gyro_heading_rad",
    )  # fmt: skip


def test_state_rows_have_truth_beside_what_was_decoded():
    rig = Rig(with_instruments(slippery(), gyro=Gyro(1))).arm()
    rig.run(600, Sticks(forward=1.0, turn=0.5))
    rig.run(600)
    row = dict(zip(rig.bench.state_columns, [out.state for out in rig.outputs if out.state][-1], strict=True))
    for number in (1, 2, 3):
        assert abs(row[f"dead{number}_rad"]) > 0.4
        assert row[f"dead{number}_encoder_rad"] == pytest.approx(row[f"dead{number}_rad"], abs=math.tau / 8192)
    assert row["gyro_heading_rad"] == pytest.approx(row["heading_rad"], abs=1e-5)


def test_a_recording_holds_their_frames_and_replays_from_them(tmp_path):
    path = tmp_path / "robot.toml"
    boards = "".join(
        f'\n[[dead_wheel]]\nname = "d{number}"\nbearing_deg = {bearing}\ndistance_m = 0.1\nradius_m = 0.025\n'
        f"can_id = {number}\n"
        for bearing, number in ((0.0, 4), (120.0, 5), (240.0, 6))
    )
    path.write_text(M2006.file.read_text() + boards + "\n[gyro]\ncan_id = 2\nrate_noise_degps = 0.1\nseed = 3\n")
    robot = load_robot(path)
    rig = Rig(robot).arm()
    rig.run(300, Sticks(forward=0.5, turn=0.5))
    info = RunInfo(robot.name, robot.rc.name)
    with Recorder(tmp_path / "run", info, rig.bench.state_columns, robot.file, robot.rc.file) as recorder:
        for out in rig.outputs:
            recorder.add(out)
    recording = Recording.open(tmp_path / "run")
    assert {can_id for can_id, _ in recording.feedback[100]} == {0x201, 0x202, 0x203, 0x204, 0x205, 0x206, 0x302}
    assert {can_id for frames in recording.commands.values() for can_id, _ in frames} == {0x200}
    for recorded_can in (False, True):
        again = list(from_recording(tmp_path / "run", recorded_can=recorded_can))
        assert again == rig.outputs


def test_our_base_takes_encoders_and_gyro_for_no_strangers():
    rig = Rig(with_instruments(gyro=Gyro(1)))
    rig.run(100)
    motors = rig.bench.base.motors
    assert motors.foreign_frames == 0
    assert motors.watch.findings == ()
    alone = Base(M2006)
    alone.motors.receive(0, [(0x204, bytes(8)), (0x301, bytes(6))])
    assert alone.motors.foreign_frames == 2
