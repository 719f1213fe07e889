"""docs/slamware.md says what is so: its tables, its settings and its Python (its commands: test_docs.py)."""

import math
import re
from pathlib import Path

import pytest
from slamware_vendor import BY_NAME, frame

from bench.config import ROBOTS_DIR, SlamwareSettings, load_robot
from bench.messages import BodyTwist
from bench.slamware import FrameDecoder, describe, encode_frame
from bench.slamware.commands import DIALECTS, ERROR_MEANINGS, SUB_COMMANDS
from bench.slamware.payloads import dead_reckon_answer, twist_request

PAGE = (Path(__file__).parents[1] / "docs" / "slamware.md").read_text()


def block(language):
    (found,) = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    return found


# Field of a worked table -> what `decode` calls it, and how many of the table's units make one of ours.
DECODED = {
    "vx": ("vx_mps", 1.0),
    "vy": ("vy_mps", 1.0),
    "omega": ("omega_radps", 1.0),
    "dx": ("dx_m", 1000.0),
    "dy": ("dy_m", 1000.0),
    "dtheta": ("dtheta_rad", 180.0 / math.pi),
}
WORKED = re.findall(r"<!-- frame: (\S+) -->\n((?:\|.*\n)+)", PAGE)


@pytest.mark.parametrize(("name", "table"), WORKED, ids=[name for name, _ in WORKED])
def test_the_worked_frames_are_the_vendors_and_go_both_ways(name, table):
    rows = re.findall(r"^\| `([0-9A-F ]+)` \| ([^|]+) \| (?:`([^`]+)`)? ?\| (?:(-?[\d.]+).*)?\|$", table, re.MULTILINE)
    data = bytes.fromhex("".join(raw for raw, *_ in rows))
    assert data == frame(name)
    escaped = "".join(f"\\x{byte:02X}" for byte in data)
    assert f"'{escaped}' >" in PAGE, "the command of the page makes the same bytes"
    (event,) = FrameDecoder().feed(data)
    found, numbers = describe(event)["decoded"], {}
    for raw, field, worked, value in rows:
        if not worked:
            continue
        assert int(re.search(r"0x([0-9A-F]+)", worked)[1], 16) == int.from_bytes(bytes.fromhex(raw), "little")
        assert eval(worked) == pytest.approx(float(value), abs=5e-6)
        numbers[field] = eval(worked)
        if field in DECODED:
            key, scale = DECODED[field]
            assert found[key] * scale == pytest.approx(numbers[field], abs=1e-9)
    if name.endswith(".request"):
        payload = twist_request(BodyTwist(numbers["vx"], numbers["vy"], numbers["omega"]))
        assert encode_frame(0xF8, payload) == data
    else:
        assert encode_frame(0x02, dead_reckon_answer(**BY_NAME[name]["input"])) == data


def test_two_frames_are_worked():
    assert len(WORKED) == 2


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
