"""`wheelbench kin` and `robots`: what they print is what the reference has, worked by hand outside the code."""

import json
import math
import re
from pathlib import Path

import pytest
from robot_files import eight_wheels

from bench.__main__ import main
from bench.config import Wheel, load_robot, robot_names
from bench.kinematics import Kinematics

ROOT = Path(__file__).parents[1]
K = 0.866025404
T = 0.577350269
# Reference kinematics, section 3: H (for the rims where the document has rims), and its inverse to five places.
PRINTED = {
    "slamware-a": (
        [[0, 1, 0.18], [-K, -0.5, 0.18], [K, -0.5, 0.18]],
        [[0, -T, T], [0.66667, -0.33333, -0.33333], [1.85185, 1.85185, 1.85185]],
    ),
    "slamware-b": (
        [[0, -1, 0.18], [K, 0.5, 0.18], [-K, 0.5, 0.18]],
        [[0, T, -T], [-0.66667, 0.33333, 0.33333], [1.85185, 1.85185, 1.85185]],
    ),
    "omni3": (
        [[K, -0.5, -0.15], [-K, -0.5, -0.15], [0, 1, -0.15]],
        [[T, -T, 0], [-0.33333, -0.33333, 0.66667], [-2.22222, -2.22222, -2.22222]],
    ),
    "omni4": (
        [[K, -0.5, -0.15], [-K, -0.5, -0.15], [-K, 0.5, -0.15], [K, 0.5, -0.15]],
        [[0.28868, -0.28868, -0.28868, 0.28868], [-0.5, -0.5, 0.5, 0.5], [-1.66667] * 4],
    ),
    "mecanum": (
        [[1, -1, -0.22], [-1, -1, -0.22], [-1, 1, -0.22], [1, 1, -0.22]],
        [[0.25, -0.25, -0.25, 0.25], [-0.25, -0.25, 0.25, 0.25], [-1.13636] * 4],
    ),
    "siegwart": (
        [[K, -0.5, -1], [0, 1, -1], [-K, -0.5, -1]],
        [[T, 0, -T], [-0.33333, 0.66667, -0.33333], [-0.33333, -0.33333, -0.33333]],
    ),
    "m2006": (
        [[0.965926, 0.258819, 0.061], [0, -1, 0.061], [-0.965926, 0.258819, 0.061]],
        [[0.517638, 0, -0.517638], [0.397198, -0.794395, 0.397198], [6.511437, 3.370568, 6.511437]],
    ),
    "dm3519": (
        [[-0.84147, 0.5403, 0.086], [-0.68164, -0.73169, 0.086], [0.68164, -0.73169, 0.086], [0.84147, 0.5403, 0.086]],
        [
            [-0.35878, -0.29046, 0.29046, 0.35878],
            [0.39313, -0.39313, -0.39313, 0.39313],
            [3.34424, 2.46947, 2.46947, 3.34424],
        ],
    ),
}
# Section 2: singular values of the rows in m/s with yaw over the wheels' distance, and their condition.
CONDITIONED = {
    "slamware-a": ((1.7321, 1.2247, 1.2247), 1.4142),
    "slamware-b": ((1.7321, 1.2247, 1.2247), 1.4142),
    "omni3": ((1.7321, 1.2247, 1.2247), 1.4142),
    "siegwart": ((1.7321, 1.2247, 1.2247), 1.4142),
    "deadwheel3": ((1.7321, 1.2247, 1.2247), 1.4142),
    "m2006": ((1.7656, 1.3660, 1.0083), 1.7511),
    "omni4": ((2, 1.7321, 1), 2.0000),
    "dm3519": ((2.0152, 1.5315, 1.2624), 1.5963),
    "mecanum": ((1.9918, 1.4142, 1.4142), 1.4084),
}
SLIP = {  # sections 3.2 and 3.6
    "omni4": (-0.5, 0.5, -0.5, 0.5),
    "mecanum": (-0.5, 0.5, -0.5, 0.5),
    "dm3519": (-0.44509, 0.54945, -0.54945, 0.44509),
}


@pytest.fixture
def kin(capsys):
    def call(*words):
        assert main(["kin", *map(str, words)]) == 0
        return capsys.readouterr().out

    return call


def facts(kin, *words):
    return json.loads(kin(*words, "--json"))


@pytest.mark.parametrize("name", PRINTED)
def test_both_matrices(kin, name):
    said, radius_m = facts(kin, name), load_robot(name).wheels[0].radius_m
    rows, back = PRINTED[name]
    for got, want in zip(said["twist_to_wheels"], rows, strict=True):
        assert [value * radius_m for value in got] == pytest.approx(want, abs=5e-6)
    for got, want in zip(said["wheels_to_twist"], back, strict=True):
        assert [value / radius_m for value in got] == pytest.approx(want, abs=2e-4 if name == "dm3519" else 5e-6)


def test_there_are_literals_for_every_robot():
    assert PRINTED.keys() | {"deadwheel3"} == CONDITIONED.keys() == set(robot_names())


@pytest.mark.parametrize("name", CONDITIONED)
def test_singular_values_and_condition(kin, name):
    values, condition = CONDITIONED[name]
    said = facts(kin, name)
    assert said["singular_values"] == pytest.approx(values, abs=5e-5)
    assert said["condition"] == pytest.approx(condition, abs=5e-5)
    assert f"condition         {condition:.4f}\n" in kin(name)


@pytest.mark.parametrize("name", CONDITIONED)
def test_slip_vectors(kin, name):
    said = facts(kin, name)["slip_vectors"]
    assert said == ([pytest.approx(SLIP[name], abs=5e-6)] if name in SLIP else [])
    assert ("slip cannot be seen" in kin(name)) == (name not in SLIP)


@pytest.mark.parametrize("count", [4, 5, 6, 8])
def test_slip_vectors_stand_at_right_angles_to_every_motion_and_to_each_other(count):
    # Unequal in every way, and one wheel twice, whose difference is a slip vector by itself.
    wheels = [
        Wheel(str(i), 0.2 - 0.1 * (i % 5), 0.15 * (-1) ** i, 1.1 * i, 0.03 + 0.01 * (i % 3), i + 1, roller_rad=0.1 * i)
        for i in range(count - 1)
    ]
    kinematics = Kinematics([*wheels, wheels[0]])
    vectors = kinematics.slip_vectors()
    assert len(vectors) == count - 3
    for i, n in enumerate(vectors):
        for column in zip(*kinematics.inverse_rows, strict=True):
            assert sum(a * b for a, b in zip(n, column, strict=True)) == pytest.approx(0.0, abs=1e-10)
        for k, other in enumerate(vectors):
            assert sum(a * b for a, b in zip(n, other, strict=True)) == pytest.approx(float(i == k), abs=1e-12)


def test_the_textbooks_example_both_ways(kin):
    said = facts(kin, "siegwart", "--wheels", "4,1,2")  # document 003, equation 3.34
    assert said["twist"] == pytest.approx([1.154701, -1.333333, -2.333333], abs=1e-6)
    assert facts(kin, "siegwart", "--twist=1.154701,-1.333333,-2.333333")["wheels_radps"] == pytest.approx(
        [4, 1, 2], abs=1e-5
    )


def test_slip_of_wheels_that_contradict_each_other(kin):
    # One wheel of four held, the others rolling forward: a quarter of the difference on each, by n = (-1, 1, -1, 1)/2.
    said = facts(kin, "mecanum", "--wheels", "20,-20,-20,0")
    assert said["slip"] == pytest.approx([5, -5, 5, -5])
    assert said["twist"] == pytest.approx([0.75, -0.25, 1.13636], abs=1e-5)


def test_what_people_read_names_the_wheels(kin):
    text = kin("mecanum", "--wheels", "20,-20,-20,0")
    assert "forward 0.75000 m/s, left -0.25000 m/s, counter-clockwise 1.13636 rad/s" in text
    assert re.search(r"^ +rad/s +of it slip$", text, re.MULTILINE)
    assert re.search(r"^  rear right +-20\.00000 +5\.00000$", text, re.MULTILINE)
    assert "-0.00000" not in kin("m2006")


def test_eight_wheels_fit_on_a_screen(kin, tmp_path):
    (tmp_path / "ring.toml").write_text(eight_wheels())
    text = kin(tmp_path / "ring.toml")
    assert max(map(len, text.splitlines())) <= 80
    assert re.search(r"^ +n1 +n2 +n3 +n4 +n5$", text, re.MULTILINE)


@pytest.mark.parametrize(("half_width_m", "condition"), [(0.1, 7.8102), (0.08, 3.6056)])
def test_rollers_taken_from_above_are_told(tmp_path, capsys, half_width_m, condition):
    """By hand: an X in place of the diamond turns with lx - ly where the diamond has lx + ly, over hypot(lx, ly)."""
    text = (ROOT / "bench/robots/mecanum.toml").read_text()
    text = (
        text.replace("roller_deg = ", "roller_deg = -").replace("--", "").replace("y_m = 0.1", f"y_m = {half_width_m}")
    )
    text = text.replace("y_m = -0.1", f"y_m = -{half_width_m}")
    (tmp_path / "seen.toml").write_text(text)
    assert main(["kin", str(tmp_path / "seen.toml"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["condition"] == pytest.approx(math.hypot(0.12, half_width_m) / (0.12 - half_width_m), rel=1e-9)
    assert said["condition"] == pytest.approx(condition, abs=5e-5)
    right = (0.12 + half_width_m) / math.hypot(0.12, half_width_m)
    assert said["condition_with_rollers_negated"] == pytest.approx(max(right, 1 / right), rel=1e-9)
    assert main(["kin", str(tmp_path / "seen.toml")]) == 0
    out = capsys.readouterr().out
    assert "with every roller_deg negated: it is that of\n" in out
    assert max(map(len, out.splitlines())) <= 80
    square = text.replace(f"y_m = {half_width_m}", "y_m = 0.12").replace(f"y_m = -{half_width_m}", "y_m = -0.12")
    (tmp_path / "square.toml").write_text(square)
    assert main(["kin", str(tmp_path / "square.toml")]) == 2
    assert "(singular layout); with every roller_deg negated they could" in capsys.readouterr().err


def test_robots_whose_rollers_are_right_are_told_nothing(kin):
    assert not [name for name in robot_names() if "condition_with_rollers_negated" in facts(kin, name)]


def test_robots_say_what_they_are(capsys):
    assert main(["robots"]) == 0
    text = capsys.readouterr().out
    assert "4 wheels of 100 mm; 360 mm across, 6 kg; C610 up to 1.8 A" in text
    assert "up to 0.8 m/s and 2.5 rad/s, by a SLAMWARE core alone" in text
    assert main(["robots", "--json"]) == 0
    said = {one["name"]: one for one in map(json.loads, capsys.readouterr().out.splitlines())}
    assert said["deadwheel3"]["dead_wheels"] == 3
    assert said["siegwart"]["wheel_radii_m"] == [1.0, 1.0, 1.0]
    assert (said["mecanum"]["rc"], said["mecanum"]["protocol"]) == ("dr16", "dbus")
    assert said["slamware-b"]["protocol"] is None
    assert "body.mass_kg" in said["omni3"]["assumed"]
