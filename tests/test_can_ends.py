"""Both ends of the motor bus where more is on it than should be: clashing ids, other controllers, the 0x700 frame."""

from dataclasses import replace

import pytest

from bench.canbus.watch import Kind
from bench.config import Gyro, load_robot
from bench.m2006 import EmulatedEscs, MotorBus, encode_command, encode_feedback

ROBOT = load_robot("m2006")
ONE_AMPERE = (0x200, encode_command((1000, 1000, 1000, 0)))
AT_REST = encode_feedback(0, 0, 0)


def escs_at_one_ampere():
    escs = EmulatedEscs(ROBOT)
    assert escs.receive(0, [ONE_AMPERE]) == [-1.0, -1.0, -1.0]
    return escs


def reports(escs):
    return [can_id for can_id, _ in escs.feedback([0.0] * 3, [0.0] * 3, [0.0] * 3)]


def test_absent_motors_get_zero_slots_and_their_groups_no_frame():
    ((can_id, data),) = MotorBus(ROBOT).command([0.1, 0.2, 0.3])
    assert (can_id, data[6:]) == (0x200, b"\x00\x00")
    upper = tuple(replace(wheel, can_id=wheel.can_id + 5) for wheel in ROBOT.wheels)  # ESCs 6, 7, 8
    ((can_id, data),) = MotorBus(replace(ROBOT, wheels=upper)).command([0.1, 0.2, 0.3])
    assert (can_id, data[:2]) == (0x1FF, b"\x00\x00")


def test_the_quick_id_frame_lets_go_of_every_motor_for_good():
    escs = escs_at_one_ampere()
    assert escs.receive(1, [(0x700, bytes(7))]) == [-1.0] * 3, "seven zeros are not the frame"
    assert escs.receive(2, [(0x700, b"\x01" + bytes(7))]) == [-1.0] * 3
    assert not escs.in_quick_id
    assert escs.receive(3, [(0x700, bytes(8))]) == [0.0] * 3
    assert escs.receive(4, [ONE_AMPERE]) == [0.0] * 3
    assert escs.in_quick_id
    assert reports(escs) == [0x201, 0x202, 0x203], "the rotors are turned by hand, and seen"
    assert [(one.kind, one.can_id, one.first_tick) for one in escs.watch.findings] == [(Kind.QUICK_ID, 0x700, 3)]


def test_an_esc_whose_id_somebody_else_uses_stops():
    escs = escs_at_one_ampere()
    assert escs.receive(1, [(0x202, AT_REST)]) == [-1.0, 0.0, -1.0]
    assert escs.receive(2, [ONE_AMPERE]) == [-1.0, 0.0, -1.0]
    assert reports(escs) == [0x201, 0x203]
    assert [(one.kind, one.can_id) for one in escs.watch.findings] == [(Kind.TWO_SENDERS, 0x202)]


def test_only_the_wheel_of_that_esc_stops_however_ids_are_given_out():
    wheels = tuple(replace(wheel, can_id=can_id) for wheel, can_id in zip(ROBOT.wheels, (3, 1, 2), strict=True))
    escs = EmulatedEscs(replace(ROBOT, wheels=wheels))
    escs.receive(0, [(0x201, AT_REST), ONE_AMPERE])
    assert escs.receive(1, [ONE_AMPERE]) == [-1.0, 0.0, -1.0]
    assert reports(escs) == [0x203, 0x202]


def test_before_anything_is_heard_everything_is_zero():
    bus = MotorBus(ROBOT)
    assert (bus.speeds_radps, bus.currents_ma, bus.rotor_rpm) == ([0.0] * 3, [0] * 3, [0] * 3)


def test_somebody_elses_feedback_is_none_of_an_escs_business():
    escs = escs_at_one_ampere()
    assert escs.receive(1, [(0x205, AT_REST), (0x123, b"")]) == [-1.0] * 3
    assert escs.watch.findings == ()


def test_two_programs_that_each_fill_their_own_slot_stop_each_others_motors_and_are_reported():
    escs = EmulatedEscs(ROBOT)
    mine, yours = (0x200, encode_command((1000, 0, 0, 0))), (0x200, encode_command((0, 1000, 0, 0)))
    for tick in range(20):
        assert escs.receive(tick, [mine, yours]) == [0.0, -1.0, 0.0]
    (finding,) = escs.watch.findings
    assert (finding.kind, finding.can_id, finding.first_tick) == (Kind.TWO_SENDERS, 0x200, 7)


def test_a_second_controller_is_seen_where_nobody_commands_the_other_group():
    wheels = tuple(replace(wheel, can_id=can_id) for wheel, can_id in zip(ROBOT.wheels, (1, 2, 5), strict=True))
    escs = EmulatedEscs(replace(ROBOT, wheels=wheels))
    for tick in range(20):
        escs.receive(tick, [ONE_AMPERE, ONE_AMPERE])
    assert [(one.kind, one.can_id) for one in escs.watch.findings] == [(Kind.TWO_SENDERS, 0x200)]


def test_a_command_of_the_other_group_is_no_second_controller():
    escs = EmulatedEscs(ROBOT)
    for tick in range(20):
        escs.receive(tick, [ONE_AMPERE, (0x1FF, bytes(8))])
    assert escs.watch.findings == ()


def test_a_base_reports_other_controllers_and_unknown_escs():
    bus = MotorBus(ROBOT)
    for tick in range(3):
        bus.receive(tick, [(0x200, bytes(8)), (0x205, AT_REST), (0x201, AT_REST), (0x202, AT_REST[:7])])
    found = [(one.kind, one.can_id, one.count) for one in bus.watch.findings]
    assert found == [(Kind.OTHER_CONTROLLER, 0x200, 3), (Kind.UNKNOWN_ESC, 0x205, 3), (Kind.LENGTH, 0x202, 3)]
    assert (bus.foreign_frames, bus.malformed_frames) == (6, 3)


def test_a_base_leaves_encoder_boards_and_a_gyro_to_those_they_report_to():
    board = replace(ROBOT.wheels[0], can_id=5)
    bus = MotorBus(replace(ROBOT, dead_wheels=(board,), gyro=Gyro(2, 0.0, 0.0, 0)))
    bus.receive(0, [(0x205, AT_REST), (0x302, bytes(6)), (0x206, AT_REST), (0x301, bytes(6)), (0x201, AT_REST)])
    assert [(one.kind, one.can_id) for one in bus.watch.findings] == [(Kind.UNKNOWN_ESC, 0x206), (Kind.FOREIGN, 0x301)]
    assert (bus.foreign_frames, bus.silences(0)) == (2, [0, 1, 1])


def test_a_gm6020_on_an_escs_identifier_is_reported_by_the_base():
    wheels = tuple(replace(wheel, can_id=can_id) for wheel, can_id in zip(ROBOT.wheels, (1, 2, 5), strict=True))
    bus = MotorBus(replace(ROBOT, wheels=wheels))
    for tick in range(20):
        bus.receive(tick, [(0x205, AT_REST), (0x205, encode_feedback(4000, 12, 3))])
    (finding,) = bus.watch.findings
    assert (finding.kind, finding.first_tick, finding.last_tick) == (Kind.TWO_SENDERS, 7, 19)
    assert "two ESCs with ID 5, or a GM6020 with ID 1" in finding.text


def test_a_late_reader_sees_no_clash():
    bus = MotorBus(ROBOT)
    for tick in range(0, 200, 2):
        bus.receive(tick, [(0x201, AT_REST)] * 2)
    bus.receive(300, [(0x201, AT_REST)] * 100)
    assert bus.watch.findings == ()


@pytest.mark.parametrize("raw", [32000, -32000])
def test_a_command_beyond_the_range_is_clamped_at_ten_amperes(raw):
    data = raw.to_bytes(2, "big", signed=True) + bytes(6)
    assert EmulatedEscs(ROBOT).receive(0, [(0x200, data)])[0] == (-10.0 if raw > 0 else 10.0)


def test_a_c610_needs_no_waking():
    assert MotorBus(ROBOT).wake() == ()
