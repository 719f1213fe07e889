"""Dead wheels and gyro in a robot file, what is refused there, and what the verbs and the dashboard show of them."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cantools
import pytest
from desk import WIRES, scene

from bench.__main__ import main
from bench.config import ConfigError, Gyro, load_robot
from bench.screen.status import status
from bench.screen.text import WARN
from bench.screen.wires import wires

ROOT = Path(__file__).parents[1]
DEAD_WHEELS = "".join(
    f"""
[[dead_wheel]]
name = "{name}"
bearing_deg = {bearing}
distance_m = 0.1
radius_m = 0.025
can_id = {can_id}
"""
    for name, bearing, can_id in (("f", 0.0, 4), ("i", 120.0, 5), ("r", 240.0, 6))
)


def robot_file(tmp_path, more, top=""):
    text = (ROOT / "bench" / "robots" / "m2006.toml").read_text()
    path = tmp_path / "my_robot.toml"
    path.write_text(top + text + more)
    return path


# --- the robot file ----------------------------------------------------------------------------------------------


def test_dead_wheels_stand_like_wheels_and_count_at_the_axle(tmp_path):
    robot = load_robot(robot_file(tmp_path, DEAD_WHEELS + "direction = -1\ngear = 2.5\n"))
    assert [wheel.name for wheel in robot.dead_wheels] == ["f", "i", "r"]
    front, _, rear = robot.dead_wheels
    assert (front.x_m, front.y_m, front.heading_rad) == pytest.approx((0.1, 0.0, math.pi / 2))
    assert (front.gear, front.direction, front.roller_rad) == (1.0, 1, 0.0)
    assert (rear.gear, rear.direction) == (2.5, -1)
    assert len(robot.wheels) == 3, "they are not among the driven ones"
    assert load_robot("m2006").dead_wheels == ()


def test_a_gyro_is_perfect_unless_its_file_says_otherwise(tmp_path):
    assert load_robot("m2006").gyro is None
    assert load_robot(robot_file(tmp_path, "[gyro]\ncan_id = 1\n")).gyro == Gyro(1, 0.0, 0.0, 0)
    gyro = load_robot(
        robot_file(tmp_path, "[gyro]\ncan_id = 2\nrate_noise_degps = 0.18\nbias_degps = -0.9\nseed = 7\n")
    ).gyro
    assert gyro == Gyro(2, math.radians(0.18), math.radians(-0.9), 7)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("can_id = 4", "can_id = 3", "dead_wheel.can_id: 3 of 'f' is taken by 'front left'; wheels and dead wheels"),
        ("can_id = 5", "can_id = 4", "dead_wheel.can_id: 4 of 'i' is taken by 'f'"),
        ("can_id = 6", "can_id = 9", "dead_wheel[2].can_id: expected 1 to 8"),
        ('name = "r"', 'name = "rear"', "dead_wheel.name: 'rear' is given to more than one wheel"),
        ("bearing_deg = 240.0", "bearing_deg = 0.0", "dead_wheel: cannot tell x, y and yaw apart"),
        ("radius_m = 0.025", "radius_m = 0.0", "dead_wheel[0].radius_m: expected a positive number"),
        (
            "radius_m = 0.025",
            "radius_m = 25",
            "dead_wheel: 'f' has a radius of 25 m under a body of 0.08 m; is that in",
        ),
        (
            "distance_m = 0.1",
            "distance_m = 100",
            "dead_wheel: 'f' stands 100 m from the centre of a body of 0.08 m; is",
        ),
        ("radius_m = 0.025", "radius_m = 0.025\ngear = -1.0", "dead_wheel[0].gear: expected a positive number"),
        (
            "radius_m = 0.025",  # 1 m/s, 40 rad/s: 382 rpm, and 79 times that is 30,176
            "radius_m = 0.025\ngear = 79.0",
            "dead_wheel: 1 m/s turn the encoder of 'f' at 30176 rpm; over 30000 its angle, told once a millisecond",
        ),
        ("radius_m = 0.025", "radius_m = 0.025\nroller_deg = 45.0", "dead_wheel[0].roller_deg: unknown key"),
        ("can_id = 6", "can_id = 6\n[gyro]\ncan_id = 0", "gyro.can_id: expected 1 to 8"),
        ("can_id = 6", "can_id = 6\n[gyro]\ncan_id = 1\nrate_noise_degps = -1", "gyro.rate_noise_degps: expected 0"),
        ("can_id = 6", "can_id = 6\n[gyro]\ncan_id = 1\nbias = 1", "gyro.bias: unknown key; known: bias_degps, can_id"),
    ],
)
def test_what_cannot_be_is_refused_with_file_and_key(tmp_path, old, new, says):
    assert old in DEAD_WHEELS
    path = robot_file(tmp_path, DEAD_WHEELS.replace(old, new, 1))
    with pytest.raises(ConfigError) as refused:
        load_robot(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert says in str(refused.value)


def test_an_unknown_form_of_odometry_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="odometry: 'exakt' is unknown; did you mean exact"):
        load_robot(robot_file(tmp_path, "", top='odometry = "exakt"\n'))


# --- where people look -------------------------------------------------------------------------------------------


def test_kin_shows_the_dead_wheels_rows(capsys):
    # Document 002 at 100 mm: -vx and so on in its frame is (-sin, cos, d) by bearing in ours, over 25 mm.
    assert main(["kin", "deadwheel3", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    h = math.sqrt(3.0) / 2.0
    rows = ((0.0, 1.0, 0.1), (-h, -0.5, 0.1), (h, -0.5, 0.1))
    for got, row in zip(facts["twist_to_dead_wheels"], rows, strict=True):
        assert got == pytest.approx([value / 0.025 for value in row], abs=1e-9)
    back = ((0.0, -0.57735, 0.57735), (0.66667, -0.33333, -0.33333), (3.33333, 3.33333, 3.33333))
    for got, row in zip(facts["dead_wheels_to_twist"], back, strict=True):  # reference kinematics 3.1 with R = 0.1
        assert got == pytest.approx([value * 0.025 for value in row], abs=1e-6)
    assert main(["kin", "m2006", "--json"]) == 0
    assert "twist_to_dead_wheels" not in json.loads(capsys.readouterr().out)


def test_bus_and_dbc_have_the_boards(tmp_path, capsys):
    path = robot_file(tmp_path, DEAD_WHEELS + "\n[gyro]\ncan_id = 1\n")
    main(["bus", str(path), "--json"])
    sent = json.loads(capsys.readouterr().out)["messages"]
    assert [(one["can_id"], one["name"]) for one in sent if "C610" not in one["name"]] == [
        (0x204, "Encoder_4"), (0x205, "Encoder_5"), (0x206, "Encoder_6"), (0x301, "Gyro_1"),
    ]  # fmt: skip
    assert [one["can_id"] for one in sent if one["name"].startswith("C610_Command")] == [0x200], "nobody commands them"
    assert main(["dbc", str(path)]) == 0
    database = cantools.database.load_string(capsys.readouterr().out, "dbc", strict=True)
    gyro = database.get_message_by_frame_id(0x301)
    assert gyro.senders == ["Gyro_1"]
    said = gyro.decode(bytes.fromhex("07d040000000"))
    assert (said["rate"], said["heading"]) == pytest.approx((2.0, math.pi / 2))


def test_the_dashboard_shows_a_gyro_in_words_and_slip_where_there_can_be_some():
    frames = ((0x201, bytes.fromhex("04D2E9F0FDA80000")), (0x301, bytes.fromhex("07D040000000")))
    line = wires(scene(wires=replace(WIRES, can_feedback=(12_345, frames))), 100, 5)[2]
    assert "301 +2.00 rad/s" in "".join(text for text, _ in line)
    assert "slip" not in shown(scene())
    assert "slip 0.25" in shown(scene(slip_radps=0.25, slip_limit_radps=1.0))
    assert ("slip 1.25".rjust(12), WARN) in cells(scene(slip_radps=1.25, slip_limit_radps=1.0))


def cells(of):
    return [cell for line in status(of, 60, 30) for cell in line]


def shown(of):
    return "".join(text for text, _ in cells(of))
