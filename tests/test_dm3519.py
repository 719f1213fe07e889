"""DM3519 motors: both ends of their wire, the robot that has them, and what its file may not say."""

import math
from dataclasses import replace

import pytest
from desk import SCENE
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig

from bench.canbus.dm3519 import clear_error
from bench.canbus.watch import Kind
from bench.check.fields import fields_of_pair
from bench.config import ConfigError, Dm3519, load_robot
from bench.dm3519 import Dm3519Bus, EmulatedDm3519s
from bench.io.link import Wires
from bench.loop import simulated
from bench.motors import emulated_escs, family, motor_bus
from bench.rc.transmitter import Sticks
from bench.screen import text
from bench.screen.wires import wires

ROBOT = load_robot("dm3519")
THREE_AMPERES = (0x200, bytes.fromhex("099A099A099A099A"))  # 2458 counts of 20 A / 16384


def robot(*, loss="fault", **choice):
    motor = replace(ROBOT.motor, on_command_loss=loss, command_timeout_ms=50)
    return replace(ROBOT, motor=motor, dm3519=Dm3519(**choice))


def escs(**choice):
    return emulated_escs(robot(feedback="error", **choice))


def feedback(motors, angle=0.0, speed=0.0, current=0.0):
    return motors.feedback([angle] * 4, [speed] * 4, [current] * 4)


def errors(motors):
    return [data[7] for _, data in feedback(motors)]


def test_the_kind_chooses_both_ends():
    assert isinstance(motor_bus(ROBOT), Dm3519Bus)
    assert isinstance(emulated_escs(ROBOT), EmulatedDm3519s)
    assert not isinstance(motor_bus(load_robot("m2006")), Dm3519Bus)
    assert (family(ROBOT).name, family(load_robot("m2006")).name) == ("dm3519", "c610")


@pytest.mark.parametrize(("full_scale", "raw"), [(20.0, 2457), (20.5, 2397)])
def test_currents_are_clamped_below_three_amperes_on_either_scale(full_scale, raw):
    # limits.current_a = 3: the last whole count below it
    ((can_id, data),) = motor_bus(robot(full_scale_a=full_scale)).command([5.0, -5.0, 0.0, math.nan])
    assert (can_id, data) == (0x200, raw.to_bytes(2, "big") + (-raw).to_bytes(2, "big", signed=True) + bytes(4))


@pytest.mark.parametrize(("full_scale", "amperes"), [(20.0, 3.0005), (20.5, 3.0755)])
def test_a_command_is_worth_what_the_file_says(full_scale, amperes):
    motors = emulated_escs(robot(full_scale_a=full_scale))
    assert motors.receive(0, [THREE_AMPERES]) == pytest.approx([amperes] * 4, abs=1e-4)
    assert motors.receive(1, [(0x200, bytes.fromhex("7FFF 8000 0000 0000"))])[:2] == [full_scale, -full_scale]


def test_feedback_is_that_of_the_rotor_behind_3591_to_187():
    motors = emulated_escs(replace(ROBOT, motor=replace(ROBOT.motor, speed_filter_ms=0.0)))
    (can_id, data), *_ = feedback(motors, angle=math.tau / 4, speed=10.0, current=2.0)
    assert can_id == 0x201
    turns = 3591 / 187 / 4
    assert int.from_bytes(data[:2], "big") == math.floor(turns * 8192) % 8192
    assert int.from_bytes(data[2:4], "big", signed=True) == round(10 * 60 / math.tau * 3591 / 187)
    assert int.from_bytes(data[4:6], "big", signed=True) == round(2 / 20 * 16384)
    assert data[6:] == bytes([25, 1])


def test_the_other_variant_has_two_temperatures():
    motors = emulated_escs(robot(feedback="temperatures"))
    assert {data[6:] for _, data in feedback(motors)} == {bytes([25, 25])}


def test_a_lost_command_ends_in_state_d_until_the_error_is_cleared():
    motors = escs()
    for tick in range(200):  # nothing has been commanded yet: the watchdog does not run
        motors.receive(tick, ())
    assert errors(motors) == [1] * 4
    motors.receive(200, [THREE_AMPERES])
    assert motors.receive(249, ()) != [0.0] * 4
    assert motors.receive(250, ()) == [0.0] * 4
    assert errors(motors) == [0xD] * 4
    assert motors.receive(251, [THREE_AMPERES]) == [0.0] * 4, "a command alone does not wake it"
    motors.receive(252, [clear_error(2), clear_error(4, "short")])
    assert motors.receive(253, [THREE_AMPERES]) == pytest.approx([0, 3.0005, 0, 3.0005], abs=1e-4)
    assert errors(motors) == [0xD, 1, 0xD, 1]


def test_a_cleared_motor_has_the_whole_time_until_it_is_lost_again():
    motors = escs()
    motors.receive(0, [THREE_AMPERES])
    motors.receive(50, ())
    motors.receive(300, [clear_error(2)])
    motors.receive(349, ())
    assert errors(motors) == [0xD, 1, 0xD, 0xD]
    motors.receive(350, ())
    assert errors(motors) == [0xD] * 4


@pytest.mark.parametrize("variant", ["error", "temperatures"])
def test_what_no_motor_has_said_is_on_and_zero_degrees(variant):
    machine = robot(feedback=variant)
    bus, motors = motor_bus(machine), emulated_escs(machine)
    assert (bus.errors, bus.temperatures_degc) == ([1] * 4, [0] * 4)
    bus.receive(0, feedback(motors))
    assert (bus.errors, bus.temperatures_degc) == ([1] * 4, [25] * 4)


@pytest.mark.parametrize(("loss", "expected"), [("hold", 3.0005), ("zero", 0.0)])
def test_without_the_watchdog_it_does_as_the_file_says(loss, expected):
    motors = emulated_escs(robot(loss=loss, feedback="error"))
    motors.receive(0, [THREE_AMPERES])
    assert motors.receive(50, ())[0] == pytest.approx(expected, abs=1e-4)
    assert errors(motors) == [1] * 4


def test_any_error_can_be_put_in_and_is_seen_by_the_base():
    machine = robot(feedback="error")
    motors, bus = emulated_escs(machine), motor_bus(machine)
    motors.fault(3, 0xC)
    assert motors.receive(0, [THREE_AMPERES])[2] == 0.0
    bus.receive(1, feedback(motors))
    assert bus.errors == [1, 1, 0xC, 1]
    assert bus.temperatures_degc == [25] * 4
    assert bus.wake() == ((0x7FF, bytes.fromhex("0300553C00000000")),)
    motors.receive(2, bus.wake())
    assert motors.receive(3, [THREE_AMPERES])[2] > 2.9
    with pytest.raises(ValueError, match="error 0x7 is none of"):
        motors.fault(3, 7)


def test_a_base_that_cannot_see_errors_clears_them_all():
    frames = motor_bus(robot(feedback="temperatures", clear_error="short")).wake()
    assert frames == tuple((0x7FF, bytes([16 * number, 0, 0x55, 0x3C])) for number in (1, 2, 3, 4))


def test_0x700_is_not_its_frame_and_a_taken_id_stops_it():
    motors = escs()
    motors.receive(0, [THREE_AMPERES])
    assert motors.receive(1, [(0x700, bytes(8))])[0] > 2.9
    assert motors.receive(2, [(0x201, bytes(8))])[0] == 0.0
    assert [can_id for can_id, _ in feedback(motors)] == [0x202, 0x203, 0x204]
    assert [one.kind for one in motors.watch.findings] == [Kind.TWO_SENDERS]


@given(st.lists(st.tuples(st.integers(0x1F8, 0x20C) | st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=12))
def test_any_frames_are_survived_at_both_ends(frames):
    for variant in ("temperatures", "error"):
        bus, motors = motor_bus(robot(feedback=variant)), emulated_escs(robot(feedback=variant))
        for tick in range(2):
            bus.receive(tick, frames)
            assert all(-20 <= one <= 20 for one in motors.receive(tick, frames))
            bus.receive(tick, feedback(motors))
            bus.wake()


@pytest.mark.parametrize(
    ("sticks", "axis", "sign"),
    [
        (Sticks(forward=0.4), 0, 1),
        (Sticks(left=0.4), 1, 1),
        (Sticks(turn=0.5), 2, 1),
        (Sticks(forward=-0.4), 0, -1),
    ],
)
def test_the_robot_drives_the_way_the_sticks_say(sticks, axis, sign):
    rig = Rig("dm3519").arm()
    rig.run(600, sticks)
    assert rig.truth[axis] * sign > 0.1
    assert all(abs(other) < 0.02 for i, other in enumerate(rig.truth) if i != axis)
    assert rig.believed == pytest.approx(rig.truth, abs=5e-3)


def test_after_a_dead_bus_the_next_start_wakes_the_motors():
    bench = simulated(ROBOT)
    rig = Rig(bench=bench).arm()
    rig.run(300, Sticks(forward=0.4))
    for number in (1, 2, 3, 4):
        bench.world.motors.escs.fault(number, 0xD)
    rig.run(300, Sticks(forward=0.4))
    assert bench.world.plant.currents_a == pytest.approx([0.0] * 4, abs=1e-9), "off, while the base asks for motion"
    rig.run(50, Sticks(aux1=True))  # disarm
    rig.run(50)
    rig.run(50, Sticks(aux1=True))  # arm again
    rig.run(300, Sticks(forward=0.4))
    assert min(map(abs, bench.world.plant.currents_a)) > 0.1
    sent = [frame for out in rig.outputs for frame in out.can_commands if frame[0] == 0x7FF]
    assert sent == [clear_error(number) for number in (1, 2, 3, 4)]


# --- what people see ----------------------------------------------------------------------------------------------


def test_the_dashboard_shows_milliamperes_of_either_scale():
    command, report = (0x200, bytes.fromhex("099A F666 0000 0000")), (0x201, bytes.fromhex("10E1 1DB0 0334 1901"))
    for full_scale, asked, had in ((20.0, 3000, 1001), (20.5, 3076, 1026)):
        scene = replace(SCENE, robot=robot(full_scale_a=full_scale), wires=Wires(None, (7, (command,)), (7, (report,))))
        lines = [text.plain(line) for line in wires(scene, 120, 5)]
        assert f"200 +{asked} -{asked}    +0    +0 mA" in lines[1]
        assert f"201 4321 cnt  +7600 rpm +{had} mA" in lines[2]


def test_the_dashboard_shows_a_clear_frame_as_bytes():
    scene = replace(SCENE, robot=ROBOT, wires=Wires(None, (7, (clear_error(3),))))
    assert "7FF 03 00 55 3C 00 00 00 00" in text.plain(wires(scene, 120, 5)[1])


def test_a_difference_is_named_by_the_robots_own_fields():
    before, after = bytes.fromhex("10E1 1DB0 0334 1901"), bytes.fromhex("10E1 1DB0 0333 190D")
    expected, got = fields_of_pair("can 0x201", before, after, (), family(ROBOT))
    differing = {name: (expected[name], got[name]) for name in expected if expected[name] != got[name]}
    assert differing == {"current_raw": (820, 819), "error": (1, 13), "error_name": ("on", "link lost")}
    assert fields_of_pair("can 0x201", before, after, ())[0]["byte 7"] == "0x01", "to a C610 it is bytes"


# --- the robot file --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('feedback = "error"', 'feedback = "errors"', "dm3519.feedback: 'errors' is unknown; did you mean error?"),
        ('clear_error = "long"', 'clear_error = "8"', "dm3519.clear_error: '8' is unknown; known: long, short"),
        ("full_scale_a = 20.0", "full_scale_a = 16.384", "dm3519.full_scale_a: expected 20 to 20.5 A, got 16.384"),
        ("full_scale_a = 20.0", "fullscale_a = 20.0", "dm3519.fullscale_a: unknown key; did you mean full_scale_a?"),
        ("max_current_a = 17.2", "max_current_a = 21", "motor.max_current_a: 21.0 A is above dm3519.full_scale_a"),
        ('kind = "dm3519"', 'kind = "c610"', "dm3519: this table is for motor.kind = 'dm3519'; the file has 'c610'"),
        ('loss = "fault"', 'loss = "faults"', "motor.on_command_loss: expected 'hold' or 'zero' or 'fault', got"),
    ],
)
def test_what_the_file_may_not_say(tmp_path, old, new, says):
    text = ROBOT.file.read_text()
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(ConfigError) as refused:
        load_robot(path)
    assert says in str(refused.value)


def test_a_c610_has_no_fault_to_choose(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(load_robot("m2006").file.read_text().replace('loss = "hold"', 'loss = "fault"'))
    with pytest.raises(ConfigError, match="expected 'hold' or 'zero', got 'fault'"):
        load_robot(path)


def test_without_its_table_a_dm3519_robot_has_the_usual_choices(tmp_path):
    text = ROBOT.file.read_text()
    start, end = text.index("[dm3519]"), text.index("[limits]")
    path = tmp_path / "mine.toml"
    path.write_text(text[:start] + text[end:])
    assert load_robot(path).dm3519 == Dm3519(20.0, "temperatures", "long")
