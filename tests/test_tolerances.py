"""Tolerances of a user's own: by field, in its unit; and goldens that no run can be held against."""

import shutil

import pytest

from bench.__main__ import main
from bench.check.reading import Recording
from bench.check.tolerances import unit_of_fields
from bench.scenarios import run

DRIVE = {"seconds": 0.5, "stick": [{"at_s": 0.1, "aux1": True}, {"at_s": 0.2, "forward": 0.5}]}


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walk") / "walk"
    run(record=folder, **DRIVE)
    return folder


@pytest.fixture
def faster(walk, tmp_path):
    """The same, where ESC 1 reports 4 rpm and 2 mA more in one frame."""
    folder = tmp_path / "faster"
    shutil.copytree(walk, folder)
    log = (folder / "can.log").read_text().splitlines(True)
    at = next(n for n, line in enumerate(log) if line.startswith("(0.400000) can0 201#"))
    stamp, _, data = log[at].strip().partition("#")
    angle, speed, current, rest = data[:4], int(data[4:8], 16), int(data[8:12], 16), data[12:]
    log[at] = f"{stamp}#{angle}{speed + 4 & 0xFFFF:04X}{current + 2 & 0xFFFF:04X}{rest}\n"
    (folder / "can.log").write_text("".join(log))
    return folder


def check(capsys, *arguments):
    status = main(["check", *map(str, arguments)])
    return status, *capsys.readouterr()


@pytest.mark.parametrize(
    ("given", "status"),
    [
        ((), 1),
        (("speed=4rpm", "current=2mA"), 0),
        (("speed = 4 rpm", "current_ma = 2.0 ma"), 0),
        (("speed_rpm=4rpm", "current=2e0mA"), 0),
        (("speed=4rpm",), 1),
        (("speed=3rpm", "current=2mA"), 1),
        (("speed=4rpm", "current=1mA"), 1),
        (("speed=4rpm", "current 2=2mA"), 1),  # of the command frame's second motor alone
        (("angle=4096counts", "heading=3rad", "x=1m", "vx=1m/s"), 1),
    ],
)
def test_what_is_granted_is_granted_and_nothing_else(capsys, walk, faster, given, status):
    options = [word for one in given for word in ("--tolerance", one)]
    found, out, _ = check(capsys, faster, walk, *options)
    assert found == status
    assert (f"note: compared with --tolerance {', '.join(given)}" in out) == bool(given)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("speed=5mA", "speed is recorded in rpm, not in mA; such as speed=5rpm"),
        ("speed=5", "speed is recorded in rpm, and the unit is missing; such as speed=5rpm"),
        ("heading=1deg", "heading is recorded in rad, not in deg"),
        ("vx=0.1rpm", "vx is recorded in m/s, not in rpm"),
        ("current=2rpm", "current is recorded in mA, not in rpm"),
        ("spede=5rpm", "no field is called 'spede'; did you mean speed?"),
        ("link=1m", "no field is called 'link'; known: angle, current"),
        ("speed=-1rpm", "expected a number from 0 up, got '-1'"),
        ("speed=nanrpm", "expected a number from 0 up, got 'nan'"),
        ("speed=infrpm", "expected a number from 0 up, got 'inf'"),
        ("speed=1e999rpm", "expected a number from 0 up"),
        ("speed=rpm", "expected a field, a number and its unit, such as speed=5rpm"),
        ("speed", "expected a field, a number and its unit, such as speed=5rpm"),
        ("", "expected a field, a number and its unit, such as speed=5rpm"),
        ("=5rpm", "expected a field, a number and its unit"),
    ],
)
def test_a_tolerance_that_cannot_be_is_one_sentence(capsys, walk, given, says):
    status, out, err = check(capsys, walk, walk, "--tolerance", given)
    assert (status, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1


def test_every_number_with_a_unit_can_be_granted(walk):
    units = unit_of_fields(Recording.open(walk))
    assert units["current_ma"] == units["current_4_ma"] == "mA"
    assert units["angle_counts"] == "counts"
    assert units["speed_rpm"] == "rpm"
    assert units["dx_m"] == "m"
    assert units["vx_mps"] == "m/s"
    assert units["wheel3_current_a"] == "A"
    assert "t_s" not in units


def test_a_replay_takes_it_with_its_golden_and_several_scenarios_do_not(capsys, walk, faster, tmp_path):
    assert main(["replay", str(walk), "--golden", str(faster)]) == 1
    given = ["--tolerance", "speed=4rpm", "--tolerance", "current=2mA"]
    assert main(["replay", str(walk), "--golden", str(faster), *given]) == 0
    capsys.readouterr()
    assert main(["replay", "a.toml", "b.toml", *given]) == 2
    assert "--tolerance: goes with one source" in capsys.readouterr().err


def test_a_replay_refuses_a_tolerance_before_it_runs(capsys, walk, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.cli.headless.execute", lambda *_, **__: pytest.fail("it ran"))
    (tmp_path / "short.toml").write_text('schema = 1\nname = "short"\nseconds = 0.1\n')
    assert main(["replay", str(tmp_path / "short.toml"), "--tolerance", "speed=4rpm"]) == 2
    assert "--tolerance: there is nothing that the run is held against; add --golden DIR" in capsys.readouterr().err
    assert main(["replay", str(walk), "--tolerance", "sped=4rpm"]) == 2
    assert "no field is called 'sped'" in capsys.readouterr().err


def test_a_golden_of_another_robot_is_refused_and_one_of_another_version_compared_with_a_note(capsys, walk, tmp_path):
    run(record=tmp_path / "other", robot="mecanum", **DRIVE)
    status, out, err = check(capsys, walk, tmp_path / "other")
    assert (status, out) == (2, "")
    assert f"{tmp_path / 'other'}: is of the robot mecanum, and the run {walk} is of m2006; give a golden of the" in err
    old = tmp_path / "old"
    shutil.copytree(walk, old)
    text = (old / "run.toml").read_text()
    (old / "run.toml").write_text(text.replace('wheelbench = "', 'wheelbench = "0.0.'))
    status, out, _ = check(capsys, walk, old)
    assert status == 0
    assert "note: wheelbench: 0.0." in out
    (old / "run.toml").write_text(text.replace("schema = 1", "schema = 2"))
    status, out, err = check(capsys, walk, old)
    assert status == 2
    assert "schema: expected 1, got 2; the recording is of another version of wheelbench" in err
