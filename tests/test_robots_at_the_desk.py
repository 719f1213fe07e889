"""Every robot file through the verbs that people drive it by: the dashboard on a screen of memory, and `replay`."""

import json
import re

import pytest
from desk import at_the_keys, frame, on_screen, piloted
from robot_files import EXAMPLE, eight_wheels

from bench.__main__ import main
from bench.config import load_robot, robot_names
from bench.demo import SCENARIO
from bench.rc.transmitter import Sticks, Transmitter


@pytest.fixture
def robot(request, tmp_path):
    """One of ours, or the odd ones: five wheels, eight wheels."""
    text = {"five wheels": EXAMPLE, "eight wheels": eight_wheels()}.get(request.param)
    if text is None:
        return load_robot(request.param)
    (tmp_path / "mine.toml").write_text(text)
    return load_robot(tmp_path / "mine.toml")


@pytest.mark.parametrize("robot", [*robot_names(), "five wheels", "eight wheels"], indirect=True)
def test_the_dashboard_draws_it_and_drives_it(robot):
    async def drive(app, pilot):
        frame(app, 60)
        if robot.rc:
            await pilot.press("enter")
            frame(app, 100)
            for _ in range(6):
                await pilot.press("a")
                frame(app, 100)
        else:
            await pilot.press("c")  # the core's arc
            frame(app, 700)
        assert app.session.link.latest().armed
        drawn.append(on_screen(app, 80, 24))

    drawn = []
    app = piloted(at_the_keys(robot), drive)
    pose = app.session.link.latest().pose
    assert (pose.y_m if robot.rc else pose.x_m) > 0.05
    (rows,) = drawn
    assert robot.name in rows[0]
    heading = next(i for i, row in enumerate(rows) if row.startswith(" wheel"))
    lines = rows[heading + 1 : heading + 1 + len(robot.wheels)]
    for wheel, line in zip(robot.wheels, lines, strict=True):
        assert re.match(rf" {re.escape(wheel.name[:12]):12} *[-+]\d+\.\d\d +[-+]\d+\.\d\d .*[-+]\d\.\d{{3}} A", line), (
            line
        )
    arena = "".join(row.partition("│")[2].partition("│")[0] for row in rows[2:])
    drawn_cells = sum(0x2800 < ord(cell) < 0x2900 or cell in "→↗↑↖←↙↓↘" for cell in arena)
    # Twelve dots of the grid; a robot of 2 m is a ring of a third of the field, a small one an arrow and its trail.
    assert drawn_cells > (40 if robot.body.radius_m >= 1.0 else 14), "\n".join(rows)


def by_its_own_transmitter(robot, path):
    """An RC capture: armed, then to the left for 0.7 s."""
    transmitter = Transmitter(robot.rc)
    parts = [(60, Sticks()), (60, Sticks(aux1=True)), (60, Sticks()), (700, Sticks(left=0.5))]
    held = [sticks for ticks, sticks in parts for _ in range(ticks)]
    path.write_bytes(b"".join(transmitter.step(tick, sticks) for tick, sticks in enumerate(held)))
    return [str(path), "--protocol", robot.rc.protocol]


def by_its_core(path):
    """A scenario: the core asks for a way to the left."""
    path.write_text('schema = 1\nname = "left"\nrobot = "m2006"\nseconds = 1.5\n[[core]]\nat_s = 0.1\nvy_mps = 0.3\n')
    return [str(path)]


@pytest.mark.parametrize("name", robot_names())
def test_replay_drives_it(name, tmp_path, capsys):
    robot = load_robot(name)
    source = by_its_own_transmitter(robot, tmp_path / "left.bin") if robot.rc else by_its_core(tmp_path / "left.toml")
    record = ["--record", str(tmp_path / "run")] if name in ("siegwart", "slamware-b") else []
    assert main(["replay", *source, "--robot", name, *record, "--json"]) == 0
    x_m, y_m, heading_rad = json.loads(capsys.readouterr().out)["end"]
    assert y_m > 0.1
    # The stop is at the current's limit, wheel by wheel, and turns a base of three wheels; dm3519 locks its wheels.
    assert (x_m, heading_rad) == (
        pytest.approx(0.0, abs=0.02),
        pytest.approx(0.0, abs=0.25 if name == "dm3519" else 0.1),
    )
    if record:
        assert main(["replay", str(tmp_path / "run")]) == 0
        assert "golden    identical" in capsys.readouterr().out


def test_a_scenarios_stream_is_not_fed_to_a_transmitter_of_another_kind(capsys):
    assert main(["replay", str(SCENARIO), "--robot", "mecanum"]) == 2
    said = capsys.readouterr().err
    assert "is uart12, but the profile dr16 speaks dbus; give --profile (uart12 would fit)" in said
