"""docs/slamware.md says what is so: its tables, its settings and its Python (its commands: test_docs.py)."""

import re
from pathlib import Path

import pytest

from bench.config import ROBOTS_DIR, SlamwareSettings, load_robot
from bench.slamware import FrameDecoder
from bench.slamware.commands import DIALECTS, ERROR_MEANINGS, SUB_COMMANDS

PAGE = (Path(__file__).parents[1] / "docs" / "slamware.md").read_text()


def block(language):
    (found,) = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    return found


def test_every_sub_command_has_its_row():
    rows = {int(code, 16) for code in re.findall(r"^\| `([0-9A-F]{2})(?: 0\d)?` [a-zI]", PAGE, re.MULTILINE)}
    assert rows == SUB_COMMANDS.keys()


def test_every_error_has_its_bytes():
    rows = re.findall(r"^\| `([0-9A-F]{4})` \| `([0-9A-F ]+)`", PAGE, re.MULTILINE)
    assert {int(code, 16) for code, _ in rows} == ERROR_MEANINGS.keys()
    for code, data in rows:
        (event,) = FrameDecoder().feed(bytes.fromhex(data))
        assert (event.code, event.payload) == (3, int(code, 16).to_bytes(2, "little"))


def test_every_dialect_has_its_sizes():
    rows = re.findall(r"^\| `([a-z]+-\d{4}[a-z-]*)`.* \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", PAGE, re.MULTILINE)
    assert {name: tuple(map(int, sizes)) for name, *sizes in rows} == DIALECTS


def test_its_settings_are_those_of_a_robot_file(tmp_path):
    settings = block("toml")
    keys, _, rest = settings.partition("[[range_sensor]]")
    tables, _, slamware = rest.partition("[slamware]")
    head, _, tail = (ROBOTS_DIR / "m2006.toml").read_text().partition("[[wheel]]")
    before, _, _ = tail.partition("[slamware]")
    path = tmp_path / "mine.toml"
    path.write_text(f"{head}{keys}[[wheel]]{before}[[range_sensor]]{tables}[slamware]{slamware}")
    robot = load_robot(path)
    assert robot.fittings.bumpers == ()
    assert [sensor.name for sensor in robot.fittings.range_sensors] == ["front"]
    assert robot.fittings.dock.x_m == pytest.approx(2.9)
    assert robot.slamware == SlamwareSettings(), "what the page shows is what is so without it"


def test_its_python_runs():
    exec(block("python"), {})
