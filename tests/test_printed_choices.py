"""A printed form in the place of the right one: chosen by name, recorded, refused where it does not fit."""

import json
import math
import tomllib
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.__main__ import main
from bench.as_printed.choices import CurrentAsPrinted, tangential
from bench.config import (
    CONTROL_KINDS,
    EXACT,
    ODOMETRY_FORMS,
    SPEED_LOOP,
    ConfigError,
    Gyro,
    load_robot,
    robot_names,
    robot_path,
    with_choices,
)
from bench.controller import SpeedController, control_of
from bench.errors import UsageError
from bench.io.still import again, still
from bench.kinematics import Kinematics, rotate_into_body
from bench.odometry import Odometry, odometry_of
from bench.scenarios import prepare

SCENARIO = """
schema = 1
name = "a step to the right"
robot = "{robot}"
seconds = 1.5
{more}
[[core]]
at_s = 0.1
vy_mps = -0.3
"""


@pytest.fixture
def scenario(tmp_path):
    """Writes a scenario on the default robot, or on another, that its core drives alone."""

    def write(more="", robot="m2006"):
        text = robot_path(robot).read_text()
        (tmp_path / "robot.toml").write_text("".join(line for line in text.splitlines(True) if line[:5] != "rc = "))
        path = tmp_path / "scenario.toml"
        path.write_text(SCENARIO.format(robot="robot.toml", more=more))
        return str(path)

    return write


def replay(capsys, *arguments):
    status = main(["replay", *arguments, "--json"])
    out = capsys.readouterr()
    return status, json.loads(out.out) if status < 2 else out.err


def test_a_step_to_the_right_goes_forward_by_the_printed_inverse(scenario, capsys):
    _, right = replay(capsys, scenario())
    _, printed = replay(capsys, scenario(), "--controller", "inverse-004-as-printed")
    assert right["end"][1] < -0.2
    assert abs(right["end"][0]) < 0.05
    assert printed["end"][0] > 0.2 > abs(printed["end"][1])
    assert (right["controller"], printed["controller"]) == (SPEED_LOOP, "inverse-004-as-printed")
    assert printed["odometry_off_m"] < 1e-3, "it knows where it went"


def test_the_same_by_the_scenarios_own_key_and_the_command_line_wins(scenario, capsys):
    path = scenario('controller = "inverse-004-as-printed"\nodometry = "forward-004-as-printed"')
    _, by_key = replay(capsys, path)
    assert by_key["end"][0] > 0.2
    assert by_key["odometry_off_m"] > 0.1
    _, won = replay(capsys, path, "--controller", SPEED_LOOP, "--odometry", EXACT)
    assert won["end"][1] < -0.2
    assert won["odometry_off_m"] < 0.01


def test_a_run_says_which_forms_it_has_and_how_far_its_odometry_ended(scenario, capsys):
    assert main(["replay", scenario(), "--odometry", "forward-004-as-printed"]) == 1, "its wires do not agree"
    said = capsys.readouterr().out
    assert "the odometry is forward-004-as-printed; it ends 0." in said
    assert main(["replay", scenario(), "--controller", "current-as-printed"]) == 0
    assert "the controller is current-as-printed, not the speed loop" in capsys.readouterr().out


def test_a_recording_keeps_the_choice_and_runs_again_the_same(scenario, capsys, tmp_path):
    directory = tmp_path / "run"
    forms = ("--controller", "current-as-printed", "--odometry", "document-002-as-printed")
    assert replay(capsys, scenario(), *forms, "--record", str(directory))[0] == 0
    facts = tomllib.loads((directory / "run.toml").read_text())
    assert (facts["controller"], facts["odometry"]) == (forms[1], forms[3])
    status, again = replay(capsys, str(directory))
    assert status == 0
    assert again["controller"] == "current-as-printed"
    status, said = replay(capsys, str(directory), *forms[:2])
    assert status == 2
    assert "brings its own controller and odometry" in said


def test_a_plain_run_says_nothing_of_choices(scenario, capsys, tmp_path):
    assert replay(capsys, scenario(), "--record", str(tmp_path / "run"))[0] == 0
    assert not {"controller", "odometry"} & set(tomllib.loads((tmp_path / "run" / "run.toml").read_text()))


@pytest.mark.parametrize(
    ("option", "name", "said"),
    [
        ("--controller", "curent-as-printed", "did you mean current-as-printed?"),
        ("--odometry", "document-000-as-printed", "did you mean document-00"),
        ("--odometry", "wheels", "known: exact, forward-004-as-printed"),
        ("--odometry", "document-000-a-as-printed", "for 3 tangential wheels of one size at 0, 120, 240 degrees"),
        ("--controller", "document-001-mecanum-as-printed", "try --robot mecanum"),
    ],
)
def test_a_wrong_name_or_robot_is_one_sentence(scenario, capsys, option, name, said):
    assert main(["replay", scenario(), option, name]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_robot_file_may_name_them(tmp_path):
    text = robot_path("m2006").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(
        text.replace('rc = "uart12"', 'rc = "uart12"\nodometry = "forward-004-as-printed"').replace(
            "[control]", '[control]\nkind = "current-as-printed"'
        )
    )
    robot = load_robot(path)
    kinematics = Kinematics(robot.wheels)
    assert isinstance(control_of(robot, kinematics)[1], CurrentAsPrinted)
    assert type(odometry_of(robot, kinematics)) is not Odometry
    path.write_text(text.replace("[control]", '[control]\nkind = "curent-as-printed"'))
    with pytest.raises(ConfigError, match=r"control\.kind: .* did you mean current-as-printed"):
        load_robot(path)


def test_a_scenario_that_names_an_unknown_form_is_refused_with_its_path(scenario, capsys):
    path = scenario('odometry = "exakt"')
    assert main(["replay", path]) == 2
    assert f"{path}: no odometry is called 'exakt'; did you mean exact?" in capsys.readouterr().err


THREE_001 = ("document-001-three-as-printed", "document-001-three-detailed-as-printed")


@pytest.mark.parametrize(
    ("kind", "heading_deg", "forward", "yaw"),
    [
        (THREE_001[0], 0.0, 1.0, 0.0),
        (THREE_001[0], 45.0, 0.0, 0.0),
        (THREE_001[0], 90.0, -1.0, 0.0),
        (THREE_001[1], 0.0, 1.0, 0.0),
        (THREE_001[1], 90.0, -1.0 / 3.0, -2.0 / 3.0),
    ],
)
def test_document_001_on_three_wheels_turns_the_command_itself(kind, heading_deg, forward, yaw):
    """Asked for 1 m/s forward in the field: rows 9 and 10, whose motions are closed forms; `yaw` is R omega."""
    robot = with_choices(load_robot("omni3"), kind)
    kinematics, heading_rad = Kinematics(robot.wheels), math.radians(heading_deg)
    inverse, _ = control_of(robot, kinematics, lambda: heading_rad)
    vx, vy, omega = kinematics.fit(inverse.wheel_speeds((*rotate_into_body(1.0, 0.0, heading_rad), 0.0)))
    found = rotate_into_body(vx, vy, -heading_rad)[0], abs(kinematics.axes[0][2]) * omega
    assert found == pytest.approx((forward, yaw), abs=0.003), "the fast sine is off by 0.001"


def test_after_most_of_a_turn_document_001_asks_a_wheel_for_twice_its_speed():
    """Row 15: nothing wraps the heading, and with its radians a degree its sine of -240 degrees is 2.086."""
    robot = with_choices(load_robot("omni3"), THREE_001[0])
    inverse, _ = control_of(robot, Kinematics(robot.wheels), lambda: math.radians(300.0))
    field_forward = (*rotate_into_body(1.0, 0.0, math.radians(300.0)), 0.0)
    assert abs(inverse.wheel_speeds(field_forward)[0]) * robot.wheels[0].radius_m == pytest.approx(2.086, abs=0.0005)


@pytest.mark.parametrize(("kind", "ahead"), [(None, 1.0), (THREE_001[0], -1.0)])
def test_a_run_shows_that_field_centric_driving_goes_the_other_way(kind, ahead):
    """Turned to the left by a quarter and asked for forward: with the printed form the robot comes back. Until it has
    turned, the form is right.
    """
    stick = [
        {"at_s": 0.1, "aux1": True}, {"at_s": 0.4, "aux1": False, "aux2": True}, {"at_s": 0.5, "turn": 0.5},
        {"at_s": 1.57, "turn": 0.0}, {"at_s": 2.0, "forward": 0.4},
    ]  # fmt: skip
    job = prepare(robot="omni3", controller=kind, seconds=4.0, stick=stick)
    for _ in job:
        pass
    pose = job.bench.world.plant.pose
    assert abs(math.remainder(pose.heading_rad - math.pi / 2, math.tau)) < 0.35
    assert pose.x_m * ahead > 0.2


def test_a_form_that_hears_the_heading_goes_on_from_a_still():
    """It holds on to its base, and that to it."""
    bench = prepare(robot="omni3", controller=THREE_001[0], seconds=1.0).bench
    other = again(still(bench))
    other.base.drive.field_centric, other.base.drive.driver = True, "rc"
    other.base.odometry.heading_rad = math.pi / 2
    for one, forward in ((bench, 1.0), (other, -1.0)):
        heading_rad = one.base.odometry.heading_rad
        speeds = one.base.inverse.wheel_speeds((*rotate_into_body(1.0, 0.0, heading_rad), 0.0))
        vx, vy, _ = one.base.kinematics.fit(speeds)
        assert rotate_into_body(vx, vy, -heading_rad)[0] == pytest.approx(forward, abs=0.003)


# --- every name, on every robot of ours -------------------------------------------------------------------------------

ROBOTS = {name: load_robot(name) for name in robot_names()}
THREE_EVEN_ARMS = {"m2006", "slamware-a", "slamware-b", "omni3", "siegwart", "deadwheel3"}


def fits(build, robot):
    try:
        build(robot, Kinematics(robot.dead_wheels if build is odometry_of and robot.dead_wheels else robot.wheels))
    except UsageError:
        return False
    return True


@pytest.mark.parametrize("kind", CONTROL_KINDS)
def test_every_kind_of_control_fits_the_robots_of_its_document(kind):
    fitting = {name for name, robot in ROBOTS.items() if fits(control_of, with_choices(robot, kind))}
    expected = {
        "inverse-004-as-printed": THREE_EVEN_ARMS,
        "document-001-three-as-printed": {"omni3"},
        "document-001-three-detailed-as-printed": {"omni3"},
        "document-001-four-as-printed": {"omni4"},
        "document-001-mecanum-as-printed": {"mecanum"},
    }
    assert fitting == expected.get(kind, set(ROBOTS))


@pytest.mark.parametrize("form", ODOMETRY_FORMS)
def test_every_form_of_odometry_fits_the_robots_of_its_document(form):
    fitting = {name for name, robot in ROBOTS.items() if fits(odometry_of, with_choices(robot, None, form))}
    expected = {
        "forward-004-as-printed": THREE_EVEN_ARMS,
        "document-000-a-as-printed": {"slamware-a", "deadwheel3"},
        "document-000-a-text-as-printed": {"slamware-a", "deadwheel3"},
        "document-000-b-as-printed": {"slamware-b"},
    }
    assert fitting == expected.get(form, set(ROBOTS))


def test_a_form_that_reads_heading_from_wheels_is_refused_beside_a_gyro():
    robot = replace(with_choices(ROBOTS["m2006"], None, "forward-004-as-printed"), gyro=Gyro(can_id=8))
    with pytest.raises(UsageError, match="has a gyro"):
        odometry_of(robot, Kinematics(robot.wheels))


def test_the_default_is_the_speed_loop_and_exact_odometry():
    robot = ROBOTS["m2006"]
    kinematics = Kinematics(robot.wheels)
    inverse, controller = control_of(robot, kinematics)
    assert inverse is kinematics
    assert type(controller) is SpeedController
    assert type(odometry_of(robot, kinematics)) is Odometry


@pytest.mark.parametrize(
    ("name", "bearings_deg"), [("m2006", (-75, 180, 75)), ("slamware-b", (180, -60, 60)), ("omni3", (60, -60, 180))]
)
def test_the_layout_is_read_from_the_matrix_whichever_way_a_wheel_turns(name, bearings_deg):
    robot = ROBOTS[name]
    turned = [replace(wheel, heading_rad=wheel.heading_rad + math.pi) for wheel in robot.wheels]
    for wheels in (robot.wheels, turned):
        layout = tangential(Kinematics(wheels))
        for found, expected in zip(layout.bearings_rad, bearings_deg, strict=True):
            assert math.remainder(found - math.radians(expected), math.tau) == pytest.approx(0, abs=1e-9)
        assert layout.radius_m == robot.wheels[0].radius_m
    assert layout.clockwise == tuple(-sign for sign in tangential(Kinematics(robot.wheels)).clockwise)


STEPS = st.lists(st.tuples(*[st.floats(-0.01, 0.01)] * 3), min_size=1, max_size=20)


@given(STEPS)
def test_layout_a_as_printed_is_exact_but_for_the_leak_of_dy(steps):
    """With R times the rotation put back into dy, the form is the right one: its frames and signs are turned well."""
    robot = with_choices(ROBOTS["slamware-a"], None, "document-000-a-as-printed")
    kinematics = Kinematics(robot.wheels)
    printed, exact = odometry_of(robot, kinematics), Odometry(kinematics)
    for ux, uy, turn in steps:
        printed.advance(kinematics.wheel_speeds((ux, uy + 0.18 * turn, turn)))
        exact.advance(kinematics.wheel_speeds((ux, uy, turn)))
    assert printed.pose == pytest.approx(exact.pose, abs=1e-6)
    assert printed.take_increment() == pytest.approx(exact.take_increment(), abs=1e-6)


@given(STEPS)
def test_document_002_moves_by_its_field_velocity_and_a_heading_that_is_too_small(steps):
    robot = with_choices(ROBOTS["m2006"], None, "document-002-as-printed")
    odometry = odometry_of(robot, Kinematics(robot.wheels))
    x = y = heading = 0.0
    for ux, uy, turn in steps:
        for _ in range(5):
            odometry.move(ux, uy, turn)
        c, s = math.cos(heading), math.sin(heading)
        x, y, heading = x + 5 * (c * ux - s * uy), y + 5 * (s * ux + c * uy), heading + math.radians(5 * turn)
    assert odometry.pose == pytest.approx((x, y, heading), abs=1e-9)
