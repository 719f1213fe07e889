"""The failsafe matrix: ours is green, a wrong controller is red where its defect shows, and the verb says so."""

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from bench.__main__ import main
from bench.base import Base
from bench.check.failsafe import GREEN, LOST_TICKS, OFF, PHASES, RED, coast_ticks, losses, run_cell
from bench.check.subjects import SUBJECTS
from bench.config import load_robot
from bench.messages import BodyTwist

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import failsafe_bar

ROBOT = failsafe_bar.robot()
ROWS = {loss.name: loss for loss in losses(ROBOT)}
# A part of scripts/failsafe_bar.py: each defect shows in one of these cells at least, and not in another.
CELLS = [("RC silent", "strafe"), ("failsafe flag", "spin"), ("one byte lost", "cruise"), ("encoder stuck", "reversal")]


@pytest.mark.parametrize("name", failsafe_bar.EXPECTED)
def test_a_controller_is_red_where_its_defect_shows_and_only_there(name):
    build = SUBJECTS.get(name, Base)
    for loss, phase in CELLS:
        cell = run_cell(ROBOT, ROWS[loss], phase, build)
        expected = RED if (loss, phase) in failsafe_bar.EXPECTED[name] else GREEN
        assert cell.verdict == expected, cell


def test_every_wrong_controller_shows_in_the_tested_cells():
    for name in SUBJECTS:
        assert failsafe_bar.EXPECTED[name] & set(CELLS), name


def test_what_a_protocol_cannot_say_is_off_and_says_why():
    rows = {loss.name: loss for loss in losses(load_robot("m2006"))}
    cell = run_cell(load_robot("m2006"), rows["failsafe flag"], "cruise")
    assert (cell.verdict, cell.why) == (OFF, ("uart12 frames cannot say it",))
    assert rows["sticks frozen"].off_because == "frozen_ms is 0 in the profile uart12"
    assert not rows["garbage"].off_because


def test_the_limits_of_the_rules_are_those_of_the_robot_file():
    assert ROWS["RC silent"].stop_after == ROBOT.link.hold_ms + 2 * ROBOT.rc.period_ms + 5
    assert ROWS["RC silent"].quiet_after == ROBOT.link.disarm_ms + 2 * ROBOT.rc.period_ms + 5
    assert ROWS["failsafe flag"].stop_after == 2 * ROBOT.rc.period_ms + 5


def test_a_robot_coasts_as_long_as_its_friction_takes():
    # Plant-model, section 2: from v, a constant part and a viscous one: an exponential with an offset, then a stop.
    motor, weight = ROBOT.motor, (6.234, 3.227)
    along = math.sin(math.radians(75.0)) / 0.027
    rolling = 0.05 * (2.0 * weight[0] * math.cos(math.radians(75.0)) + weight[1])
    constant = 2.0 * along * motor.coulomb_nm + rolling
    viscous, mass = 2.0 * motor.viscous_nms * along**2, 4.672
    offset = constant / viscous
    seconds = mass / viscous * math.log((0.4 + offset) / (0.02 + offset))
    assert coast_ticks(ROBOT, BodyTwist(0.4, 0.0, 0.0)) == pytest.approx(1000.0 * seconds, rel=0.02)


@pytest.mark.parametrize(
    ("name", "phase"), [("omni3", "cruise"), ("slamware-a", "reversal"), ("deadwheel3", "spin"), ("siegwart", "strafe")]
)
def test_a_robot_that_rolls_for_longer_than_a_second_may(name, phase):
    """With one wheel that it cannot feel: that one coasts alone, and how long is watched to the end."""
    robot = load_robot(name)
    (stuck,) = (row for row in losses(robot) if row.name == "encoder stuck")
    cell = run_cell(robot, stuck, phase)
    assert (cell.verdict, cell.why) == (GREEN, ())
    assert cell.stop_ms > LOST_TICKS


def test_something_is_lost_for_as_long_as_the_robot_may_roll():
    slow = load_robot("siegwart")
    rolls = coast_ticks(slow, BodyTwist(0.4 * slow.limits.linear_mps, 0.0, 0.0))
    assert rolls > LOST_TICKS
    for row in losses(slow):
        if row.drives_on:
            assert row.lasting == LOST_TICKS, "it would meet a wall"
            continue
        assert row.lasting >= rolls + (slow.link.core_timeout_ms if row.by_core else slow.link.hold_ms)
        assert all(fault.lasting in (None, row.lasting) for fault in row.faults)
    assert {row.lasting for row in ROWS.values() if not row.by_core} == {LOST_TICKS}


def test_the_encoder_that_gets_stuck_is_of_a_wheel_that_turns_in_every_phase():
    (stuck,) = (row for row in losses(load_robot("slamware-a")) if row.name == "encoder stuck")
    assert stuck.faults[0].esc == 2, "its first wheel stands when it drives forward"
    assert ROWS["encoder stuck"].faults[0].esc == 1


def test_of_four_wheels_in_a_cross_an_encoder_gets_stuck_that_turns():
    """None of them turns in every phase: those ahead and behind stand when it drives forward."""
    robot = load_robot("omni4")
    places = [(0.15, 0.0), (0.0, 0.15), (-0.15, 0.0), (0.0, -0.15)]
    wheels = [
        replace(wheel, x_m=x_m, y_m=y_m, heading_rad=math.atan2(y_m, x_m) + math.pi / 2)
        for wheel, (x_m, y_m) in zip(robot.wheels, places, strict=True)
    ]
    robot = replace(robot, wheels=tuple(wheels))
    (stuck,) = (row for row in losses(robot) if row.name == "encoder stuck")
    cell = run_cell(robot, stuck, "cruise")
    assert (cell.verdict, cell.why) == (GREEN, ())


@pytest.mark.parametrize(
    ("name", "phase", "limits", "frozen_ms"),
    [
        ("sticks frozen", "cruise", {}, 1500),
        ("RC silent", "cruise", {"disarm_ms": 1500}, 300),
        ("core silent", "cruise", {"handover_ms": 1500}, 300),
    ],
)
def test_a_robot_may_take_as_long_as_its_own_file_says(name, phase, limits, frozen_ms):
    robot = replace(ROBOT, link=replace(ROBOT.link, **limits), rc=replace(ROBOT.rc, frozen_ms=frozen_ms))
    (row,) = (row for row in losses(robot) if row.name == name)
    cell = run_cell(robot, row, phase)
    assert (cell.verdict, cell.why) == (GREEN, ())


def test_no_current_is_looked_for_however_late_it_has_to_be_none():
    robot = replace(ROBOT, link=replace(ROBOT.link, disarm_ms=1500))
    silent = losses(robot)[0]
    assert silent.quiet_after > 1500
    cell = run_cell(robot, silent, "spin", SUBJECTS["no-timeout"])
    assert any(why.startswith("still commands") for why in cell.why)


def test_what_nobody_would_wait_for_is_off():
    robot = replace(ROBOT, rc=replace(ROBOT.rc, frozen_ms=10**9))
    rows = {row.name: row for row in losses(robot)}
    assert rows["sticks frozen"].off_because == "more than 60 s have to pass first"
    assert not rows["RC silent"].off_because


def test_no_wall_stops_a_robot_that_does_not_stop():
    """By the time that this one has to stand it has driven more than the 3 m that there are in a field."""
    robot = load_robot("dm3519")
    robot = replace(robot, rc=replace(robot.rc, frozen_ms=2500))

    def deaf(robot):
        return Base(replace(robot, rc=replace(robot.rc, frozen_ms=0)))

    (row,) = (row for row in losses(robot) if row.name == "sticks frozen")
    cell = run_cell(robot, row, "cruise", deaf)
    assert (cell.verdict, cell.stop_ms) == (RED, None)
    assert cell.why[0].startswith("does not stand; ")


def test_the_verb_prints_a_row_its_rule_and_ends_well(capsys, tmp_path):
    page = tmp_path / "matrix.html"
    assert main(["failsafe", "--only", "restart", "--jobs", "1", "--html", str(page)]) == 0
    said = capsys.readouterr().out
    assert "restart           ok 0 ms" in said
    assert "restart           no current until armed, stay" in said
    assert "5 of 5 cells as their rules say" in said
    assert max(map(len, said.splitlines())) <= 80
    html = page.read_text()
    assert html.count('class="ok"') == 5
    assert "http" not in html, "self-contained"


def test_the_verb_names_what_is_red_to_people_and_machines(capsys):
    given = ["failsafe", "--controller", "no-timeout", "--only", "rc silent", "--jobs", "1"]
    assert main(given) == 1
    said = capsys.readouterr().out
    assert "RED  RC silent, cruise, reversal: does not stand; " in said
    assert main([*given, "--json"]) == 1
    cells = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [cell["phase"] for cell in cells] == list(PHASES)
    assert [cell["verdict"] for cell in cells] == [GREEN, RED, RED, RED, RED]


def test_a_controller_that_ends_its_process_is_red_in_every_phase(tmp_path, capsys):
    (tmp_path / "ends.py").write_text(
        "import os\nfrom bench.base import Base\nclass Ends(Base):\n    def step(self, *given):\n        os._exit(5)\n"
    )
    given = ["--controller", f"{tmp_path / 'ends.py'}:Ends", "--only", "ESC silent", "--jobs", "2"]
    assert main(["failsafe", *given]) == 1
    said = capsys.readouterr().out
    assert "every ESC silent  RED failed  RED failed  RED failed  RED failed  RED failed" in said
    assert "its process ended with status 5 before the run was over" in said
    assert "0 of 10 cells as their rules say" in said


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--controller", "no-timout"], "did you mean no-timeout?"),
        (["--only", "meteor"], "no loss is called 'meteor'; known: RC silent"),
        (["--jobs", "0"], "--jobs: expected 1 or more"),
        (["--frozen-ms", "0"], "--frozen-ms: expected 1 or more"),
        (["--robot", "slamware-b"], "takes no RC"),
        (["--only", "restart", "--jobs", "1", "--html", "/nowhere/x.html"], "/nowhere/x.html: cannot be written"),
    ],
)
def test_a_wrong_argument_is_one_sentence(options, says, capsys):
    assert main(["failsafe", *options]) in (2, 3)
    out, err = capsys.readouterr()
    assert says in err
    assert out == "", "before anything runs"
