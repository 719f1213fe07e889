"""A scenario said in Python is the scenario of the file that says the same."""

import math
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench import demo
from bench.__main__ import main
from bench.base import Base
from bench.check.reading import Recording
from bench.config.emit import toml_text
from bench.errors import BenchError, UsageError
from bench.scenarios import load_robot, prepare, run, run_many

ROOT = Path(__file__).parents[1]

EVERYTHING = """
name = "all that a file can say"
about = "Übung"
robot = "m2006"
profile = "elrs"
seconds = 0.6
seed = 7
odometry = "forward-004-as-printed"

[arena]
length_m = 5.0
[[arena.patch]]
name = "ice"
x_m = 0.0
y_m = 0.0
radius_m = 1.0
grip = 0.3
rolling = 0.01

[noise]
loss = 0.01
late_ticks = 2

[[stick]]
at_s = 0.05
aux1 = true
[[stick]]
at_s = 0.1
forward = 0.5

[[core]]
at_s = 0.3
vx_mps = 0.1

[[fault]]
wire = "rc"
kind = "delay"
ms = 3
at_s = 0.2
for_s = 0.1
[[fault]]
wire = "plant"
kind = "push"
force_n = 4
bearing_deg = 90.0
when = "armed"
for_s = 0.1

[[expect]]
name = "it drives"
eventually = "vx_mps > 0.05"
[[expect]]
when = "armed"
then = "rc_age_ms < 50"
for_s = 0.2
vacuous = "allowed"
"""


def files_of(directory):
    return {path.name: path.read_bytes() for path in directory.iterdir() if path.name != "scenario.toml"}


def test_what_python_says_runs_as_the_file_does_and_its_recording_runs_again(tmp_path, capsys):
    (tmp_path / "all.toml").write_text(EVERYTHING)
    assert main(["replay", str(tmp_path / "all.toml"), "--record", str(tmp_path / "file")]) == 0
    result = run(record=tmp_path / "python", **tomllib.loads(EVERYTHING))
    assert result.ok
    assert [verdict.name for verdict in result.verdicts] == ["it drives", "then rc_age_ms < 50, when armed"]
    assert files_of(tmp_path / "python") == files_of(tmp_path / "file")
    capsys.readouterr()
    assert main(["replay", str(tmp_path / "python")]) == 0
    assert "golden    identical" in capsys.readouterr().out


def test_a_capture_and_a_robot_of_ones_own_are_found_from_the_current_folder(tmp_path, monkeypatch):
    for name in ("drive.bin", "drive.json"):
        shutil.copy(demo.SCENARIO.parent / name, tmp_path / name)
    shutil.copy(load_robot("m2006").file, tmp_path / "mine.toml")
    monkeypatch.chdir(tmp_path)
    assert run(rc="drive.bin", robot="mine.toml", seconds=2.5).summary["path_m"] > 0.1
    assert run(rc=Path("drive.bin"), robot=Path("mine.toml"), seconds=0.1).ok


STEP = {"seconds": 1.0, "stick": [{"at_s": 0.1, "aux1": True}, {"at_s": 0.2, "forward": 0.8}]}


def test_a_sweep_over_the_floor_changes_the_drive_and_is_not_recorded_under_another_robots_name(tmp_path):
    robot = load_robot("m2006")
    ways = [
        run(robot=replace(robot, ground=replace(robot.ground, grip=grip)), **STEP).summary["path_m"]
        for grip in (0.05, 0.1, 0.7)
    ]
    assert ways == sorted(ways)
    assert ways[2] > ways[0] + 0.05
    with pytest.raises(UsageError, match=r"this robot was changed since it was read; write the changed one to a file"):
        run(robot=replace(robot, ground=replace(robot.ground, grip=0.1)), record=tmp_path / "run", **STEP)
    assert not (tmp_path / "run").exists()
    assert run(robot=robot, record=tmp_path / "run", **STEP).ok


def test_prepare_gives_every_tick_and_a_look_inside():
    job = prepare(**STEP)
    outs = list(job)
    assert [out.tick for out in outs] == list(range(1000))
    assert job.bench.world.plant.pose.x_m == pytest.approx(outs[990].state[1], abs=0.01)
    assert all(len(out.can_feedback) == 3 for out in outs[1:])


class Still:
    """Sends nothing."""

    def __init__(self, robot):
        self.robot = robot

    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        return (), b""


def test_a_controller_may_be_a_class_and_is_named_in_the_recording(tmp_path):
    result = run(controller=Still, record=tmp_path / "run", **STEP)
    assert result.summary["path_m"] == 0.0
    assert result.summary["controller"] == "test_scenarios_in_python.py:Still"
    assert Recording.open(tmp_path / "run").info.controller == "test_scenarios_in_python.py:Still"
    assert run(controller=Base, **STEP).summary == run(**STEP).summary


def test_many_come_in_order_whatever_becomes_of_them():
    given = [{**STEP, "name": "a"}, {**STEP, "name": "b", "sede": 1}, {**STEP, "name": "c", "seed": 3}]
    for jobs in (1, 2):
        found = list(run_many(given, jobs=jobs))
        assert [result.name for result in found] == ["a", "b", "c"]
        assert [result.ok for result in found] == [True, False, True]
        assert found[1].error == "scenario 'b': sede: unknown key; did you mean seed?"
    with pytest.raises(UsageError, match="jobs: expected 1 or more"):
        run_many(given, jobs=0)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({}, "scenario: seconds: is missing"),
        ({"seconds": "1"}, "scenario: seconds: expected a number, got '1'"),
        ({"seconds": 1, "fualt": []}, "fualt: unknown key; did you mean fault?"),
        ({"seconds": 1, "name": "a/b", "fault": [{"wire": "rc", "kind": "dorp"}]}, "'a_b': fault[0].kind: 'dorp'"),
        ({"seconds": 1, "fault": [{}, {"wire": object()}]}, "fault[1].wire: expected text, a number, true or false"),
        ({"seconds": 1, "fault": {"wire": "rc"}}, "fault: expected at least one table [[fault]]"),
        ({"seconds": 1, "expect": "always armed"}, "expect: expected at least one table [[expect]]"),
        ({"seconds": math.nan}, "seconds: expected a finite number"),
        ({"seconds": 1, "extends": "base.toml"}, "extends: is for files; in Python, take the keys of another"),
        ({"seconds": 1, "robot": "m206"}, "scenario: robot: no robot is called 'm206'; did you mean m2006?"),
        ({"seconds": 1, "controller": "no-timout"}, "no controller is called 'no-timout'; did you mean no-timeout?"),
        ({"seconds": 1, "noise": {1: 2}}, "noise.1: a key is a text"),
    ],
)
def test_what_is_wrong_is_one_sentence_with_its_key(keys, says):
    with pytest.raises(BenchError) as caught:
        run(**keys)
    assert says in str(caught.value)


_SCALARS = st.text() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False) | st.booleans()
_VALUES = st.recursive(
    _SCALARS | st.lists(_SCALARS, max_size=3),
    lambda inner: (
        st.dictionaries(st.text(), inner, max_size=3)
        | st.lists(st.dictionaries(st.text(), inner, max_size=2), min_size=1, max_size=2)
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.text(), _VALUES, max_size=4))
def test_any_tables_become_toml_and_come_back(values):
    assert tomllib.loads(toml_text(values)) == values


def test_numbers_of_numpy_are_numbers_and_what_is_none_is_not_given():
    values = {"a": numpy.float64(0.5), "b": numpy.int64(3), "c": numpy.bool_(True), "d": None, "e": (1, 2)}
    assert tomllib.loads(toml_text(values)) == {"a": 0.5, "b": 3, "c": True, "e": [1, 2]}


def test_the_example_runs():
    done = subprocess.run(
        [sys.executable, ROOT / "docs" / "examples" / "sweep.py"], capture_output=True, text=True, cwd=ROOT, check=True
    )
    lines = done.stdout.splitlines()
    assert [line.split("  ")[0].strip() for line in lines] == [
        "grip 0.7", "grip 0.2", "grip 0.1", "2 ms late", "10 ms late", "40 ms late",
    ]  # fmt: skip
    assert all("stops: passed" in line for line in lines[:2])


def test_a_premise_that_holds_by_a_hair_is_no_margin_of_what_follows_from_it():
    late = {"when": "rc_age_ms >= 100", "then": "speed_mps < 0.02", "within_s": 0.2}
    never = {"while": "rc_age_ms > 99.5", "always": "speed_mps < 0.02"}
    gone = {"wire": "rc", "kind": "drop", "at_s": 0.6}
    result = run(controller="no-timeout", expect=[late, never], fault=[gone], **STEP)
    speeds = [math.hypot(row[4], row[5]) for row in result.rows if row[0] >= 0.69]
    assert len(speeds) > 20
    for verdict in result.verdicts:
        assert verdict.result == "failed"
        assert -verdict.margin > min(speeds) - 0.02 - 0.01
