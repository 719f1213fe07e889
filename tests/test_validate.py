"""What `make validate` compares: a model that weighs what the robot file says; and a wrong plant is seen."""

import math
import subprocess
import sys
import xml.etree.ElementTree as Xml
from dataclasses import replace
from pathlib import Path

import pytest

from bench.config import load_robot, robot_names
from bench.kinematics import Kinematics

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import validate
from beside import mujoco_robot


def numbers(text):
    return [float(word) for word in text.split()]


def masses(body, x=0.0, y=0.0, turn=0.0):
    """(kg, x, y) of a body and all that hangs on it; a wheel's rollers, all around it, balance on its hub."""
    at_x, at_y, _ = numbers(body.get("pos", "0 0 0"))
    c, s = math.cos(turn), math.sin(turn)
    x, y = x + c * at_x - s * at_y, y + s * at_x + c * at_y
    w, _, _, z = numbers(body.get("quat", "1 0 0 0"))
    turn += 2.0 * math.atan2(z, w)
    inertial = body.find("inertial")
    off_x, off_y, _ = numbers(inertial.get("pos"))
    yield float(inertial.get("mass")), x + off_x, y + off_y
    for child in body.findall("body"):
        yield from masses(child, x, y, turn)


@pytest.mark.parametrize("name", robot_names())
def test_the_model_weighs_what_the_file_says_and_balances_on_the_origin(name):
    robot = load_robot(name)
    base = Xml.fromstring(mujoco_robot.model_xml(robot)).find("worldbody/body")
    parts = list(masses(base))
    assert sum(kg for kg, _, _ in parts) == pytest.approx(robot.body.mass_kg, rel=1e-9)
    for axis in (1, 2):
        assert sum(part[0] * part[axis] for part in parts) == pytest.approx(0.0, abs=1e-9)
    assert len(base.findall("body")) == len(robot.wheels)
    assert len(base.findall("body/body")) == mujoco_robot.ROLLERS * len(robot.wheels)


def test_the_lowest_roller_lies_along_the_roller_axis():
    robot = load_robot("m2006")
    robot = replace(robot, wheels=tuple(replace(wheel, roller_rad=0.7) for wheel in robot.wheels))
    wheel = Xml.fromstring(mujoco_robot.model_xml(robot)).find("worldbody/body/body")
    lowest = wheel.find("body")
    w, i, j, k = numbers(lowest.get("quat"))
    assert numbers(lowest.get("pos"))[2] == pytest.approx(-0.8 * robot.wheels[0].radius_m)
    assert (i, j) == (0.0, 0.0)
    assert 2.0 * math.atan2(k, w) == pytest.approx(0.7)


def test_every_direction_is_pushed_and_no_wheel_gets_more_than_asked():
    kinematics = Kinematics(load_robot("m2006").wheels)
    for name, axis in (("forward", 0), ("to the left", 1), ("round", 2)):
        pattern = validate.patterns(kinematics, 0.1)[name]
        assert max(map(abs, pattern)) == pytest.approx(0.1)
        assert kinematics.wrench(pattern)[axis] > 0.0


def test_without_mujoco_it_says_how_to_get_it():
    script = Path(validate.__file__)
    hidden = "import sys, runpy; sys.modules['mujoco'] = None; sys.argv = ['validate.py']; " + (
        f"sys.path.insert(0, {str(script.parent)!r}); runpy.run_path({str(script)!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", hidden], capture_output=True, text=True)
    assert done.returncode == 3
    assert "make validate" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_wrong_plant_is_out(monkeypatch):
    pytest.importorskip("mujoco", reason="mujoco is not installed: `make validate` installs it and runs this test")
    check = next(one for one in validate.checks(load_robot("m2006")) if one.name == "pushed forward")
    good = validate.judge(check)
    assert good.error < good.allowed

    class Heavier(validate.PlantEngine):
        def __init__(self, robot):
            super().__init__(replace(robot, body=replace(robot.body, mass_kg=1.2 * robot.body.mass_kg)))

    monkeypatch.setattr(validate, "PlantEngine", Heavier)
    assert validate.judge(check).error > good.allowed
