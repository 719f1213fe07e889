"""Any golden is pinned by an explicit flag at a desk, says what changes, and is reported where nothing uses it."""

from __future__ import annotations

import ctypes
import json
import os
from contextlib import contextmanager
from pathlib import Path

import pytest
from recordings import made_run, record

from bench.__main__ import main
from bench.check.golden import pin
from bench.check.pinned import goldens

ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def _at_a_desk(monkeypatch):
    monkeypatch.delenv("CI", raising=False)


def run_in(directory: Path, factor: float = 1.0) -> str:
    """The made-up run; ESC 2 reports its speed times a factor from tick 60 on."""
    directory.mkdir(parents=True)
    outputs = made_run(200)
    for tick in range(60, 200):
        frames = list(outputs[tick].can_feedback)
        can_id, data = frames[1]
        speed = round(int.from_bytes(data[2:4], "big", signed=True) * factor)
        frames[1] = (can_id, data[:2] + speed.to_bytes(2, "big", signed=True) + data[4:])
        outputs[tick] = outputs[tick]._replace(can_feedback=tuple(frames))
    return str(record(directory / "run", outputs).directory)


def test_the_flag_pins_and_says_what_changes(tmp_path, capsys):
    golden = str(tmp_path / "pinned" / "walk")
    assert main(["check", run_in(tmp_path / "a"), golden, "--update-pinned"]) == 0
    assert capsys.readouterr().out == f"pinned for the first time\npinned: {golden}\n"
    changed = run_in(tmp_path / "b", 0.5)
    assert main(["check", changed, golden]) == 1
    assert "checks    not judged: " in capsys.readouterr().out, "its robot file is no robot's"
    assert main(["check", changed, golden, "--update-pinned"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("differs: speed in the feedback of ESC 2 is scaled by 0.5 from 0.060 s on")
    assert any(line.startswith("  can 0x202            200 compared, ") for line in lines)
    assert main(["check", changed, golden]) == 0
    capsys.readouterr()
    assert main(["check", changed, golden, "--update-pinned", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["changed"]["identical"]


def test_nothing_is_pinned_in_ci_or_without_a_name(tmp_path, capsys, monkeypatch):
    run, golden = run_in(tmp_path / "a"), tmp_path / "walk"
    assert main(["check", run, "--update-pinned"]) == 2
    assert "say which golden" in capsys.readouterr().err
    monkeypatch.setenv("CI", "1")
    assert main(["check", run, str(golden), "--update-pinned"]) == 2
    assert "is not pinned in CI" in capsys.readouterr().err
    assert not golden.exists()


def project(tmp_path: Path) -> Path:
    folder = tmp_path / "fixtures" / "pinned"
    run = run_in(tmp_path / "a")
    for name in ("walk", "walk_back", "spin"):
        pin(run, folder / name)
    (tmp_path / "pyproject.toml").write_text("")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_walk.py").write_text('GOLDEN = ROOT / "fixtures" / "pinned" / "walk"\n')
    (tmp_path / "notes.md").write_text("pinned/spin is our pride\n")
    return folder


def test_goldens_that_nothing_uses_are_reported(tmp_path, capsys):
    folder = project(tmp_path)
    assert main(["goldens", str(folder)]) == 1
    spin, walk, walk_back = capsys.readouterr().out.splitlines()
    assert spin.endswith("UNUSED: nothing is held against it; delete it")
    assert walk.split() == ["walk", "little,", "0.2", "s", "used", "by", "tests/test_walk.py"]
    assert "UNUSED" in walk_back
    (tmp_path / "scenario.toml").write_text('golden = ["pinned/spin", "pinned/walk_back"]\n')
    assert [one.users for one in goldens(folder)] == [
        ("scenario.toml",),
        ("tests/test_walk.py",),
        ("scenario.toml",),
    ]
    (tmp_path / "circle.toml").symlink_to(tmp_path / "circle.toml")  # in a project: a link that leads nowhere,
    os.mkfifo(tmp_path / "pipe.py")  # and a pipe that nobody writes to
    assert main(["goldens", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"]


def test_goldens_of_the_plugin_are_used_by_the_test_of_their_name(tmp_path):
    folder = tmp_path / "tests" / "goldens"
    run = run_in(tmp_path / "a")
    for name in ("test_walk", "test_walk_fast_", "turn", "test_gone"):
        pin(run, folder / name)
    (tmp_path / "pyproject.toml").write_text("")
    (tmp_path / "tests" / "test_base.py").write_text('def test_walk(golden):\n    golden()\n    golden("turn")\n')
    used = {one.directory.name: bool(one.users) for one in goldens(folder)}
    assert used == {"test_walk": True, "test_walk_fast_": True, "turn": True, "test_gone": False}


def test_a_damaged_golden_is_reported(tmp_path, capsys):
    folder = project(tmp_path)
    (folder / "walk" / "rc.log").write_text("")
    assert main(["goldens", str(folder)]) == 1
    assert "rc.log: is not what was pinned; restore it or pin again" in capsys.readouterr().out
    assert main(["goldens", str(tmp_path / "nowhere")]) == 2


def test_a_golden_is_no_folder_of_goldens(tmp_path, capsys):
    walk = project(tmp_path) / "walk"
    assert main(["goldens", str(walk)]) == 2
    says = f"wheelbench goldens: {walk}: is a golden itself; give the folder that it lies in\n"
    assert capsys.readouterr() == ("", says)


@contextmanager
def seeing_what_modes_allow():
    """Root may read all, until it lays down CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH, bits 1 and 2: capabilities(7).

    Another user could not: this very code may lie where nobody else may look.
    """
    if os.geteuid() != 0:
        yield
        return
    libc, header, sets = ctypes.CDLL(None), (ctypes.c_uint32 * 2)(0x20080522), (ctypes.c_uint32 * 6)()
    assert libc.capget(header, sets) == 0
    effective = sets[0]
    sets[0] = effective & ~0b110
    assert libc.capset(header, sets) == 0
    try:
        yield
    finally:
        sets[0] = effective
        assert libc.capset(header, sets) == 0


def test_what_cannot_be_read_is_said(tmp_path, capsys):
    folder = project(tmp_path)
    (tmp_path / "scenario.toml").write_text('golden = ["pinned/spin", "pinned/walk_back"]\n')
    assert main(["goldens", str(folder)]) == 0
    capsys.readouterr()
    (folder / "walk").chmod(0)
    with seeing_what_modes_allow():
        status = main(["goldens", str(folder)])
    (folder / "walk").chmod(0o755)
    spin, walk, walk_back = capsys.readouterr().out.splitlines()
    assert status == 1
    assert "used by scenario.toml" in spin
    assert "used by scenario.toml" in walk_back
    assert walk.split() == [
        "walk",
        *f"{folder / 'walk'}: cannot be read (Permission denied); check the path and its permissions".split(),
    ]
    folder.chmod(0)
    with seeing_what_modes_allow():
        status = main(["goldens", str(folder)])
    folder.chmod(0o755)
    says = f"{folder}: cannot be read (Permission denied); check the path and its permissions\n"
    assert (status, *capsys.readouterr()) == (3, "", f"wheelbench goldens: {says}")


def test_nobody_is_told_to_delete_what_an_unreadable_file_may_use(tmp_path, capsys):
    folder = project(tmp_path)
    (tmp_path / "scenario.toml").write_text('golden = ["pinned/spin", "pinned/walk_back"]\n')
    for path, line in ((tmp_path / "tests", 1), (tmp_path / "scenario.toml", 0)):
        mode = path.stat().st_mode
        path.chmod(0)
        with seeing_what_modes_allow():
            status = main(["goldens", str(folder)])
        path.chmod(mode)
        told = capsys.readouterr().out.splitlines()[line]
        assert status == 1
        assert told.endswith(f"UNUSED, as far as can be read: not {path.name}")


def test_every_golden_of_ours_is_whole_and_in_use():
    found = goldens(ROOT / "fixtures" / "pinned")
    assert "demo" in [one.directory.name for one in found]
    assert all(one.ok for one in found), [one.text for one in found]
