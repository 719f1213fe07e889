"""A base of somebody's own by `--controller FILE.py:NAME`: run, recorded, held against itself, judged, and its faults
told in one sentence with the user's own file and line."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from bench.__main__ import main
from bench.check.reading import Recording

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "docs" / "examples"
OURS = f"{EXAMPLE / 'my_controller' / 'controller.py'}:CrawlingBase"

MINE = '''
import struct
from limits import CURRENT_MA


class Forward:
    """Pushes forward from the first tick on, whatever anybody says."""

    def __init__(self, robot):
        self.sign = [-1, 0, 1]

    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        return [(0x200, bytearray(struct.pack(">4h", *(s * CURRENT_MA for s in self.sign), 0)))], b""


class Fails(Forward):
    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        if tick == 321:
            return self.look_up({})
        return super().step(tick, rc_bytes, slamware_bytes, can_in)

    def look_up(self, table):
        return table["speed"]


class Leaves(Forward):
    def step(self, *given):
        raise SystemExit(5)


class NoStep:
    def __init__(self, robot):
        pass


class NotUp:
    def __init__(self):
        pass


def gives(answer):
    class Gives(Forward):
        def step(self, *given):
            return answer

    return Gives


nothing, one, text = gives(None), gives((b"",)), gives(((), "text"))
wide, long, words = gives((((0x800, b""),), b"")), gives((((0x200, bytes(9)),), b"")), gives((((0x200, "1"),), b""))
LIMIT = 3
'''
SCENARIO = """
schema = 1
name = "pushed"
seconds = 0.5
{more}
[[expect]]
name = "it moves"
eventually = "vx_mps > 0.05"
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A folder with a controller, what it imports, and a scenario; the current folder."""
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "limits.py").write_text("CURRENT_MA = 500\n")
    (tmp_path / "run.toml").write_text(SCENARIO.format(more=""))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.partition("_")[0] in ("mine", "limits", "broken", "controller"):
            del sys.modules[name]


def said(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    out = capsys.readouterr()
    return status, out.out, out.err


def test_it_is_what_runs_and_the_recording_says_so(project, capsys):
    assert said(capsys, "replay", "run.toml")[0] == 1, "ours stands: nobody armed it"
    status, out, _ = said(capsys, "replay", "run.toml", "--controller", "mine.py:Forward", "--record", "run")
    assert status == 0
    assert "base      mine.py:Forward, not the bench's own" in out
    assert "odometry" not in out, "what a foreign base believes is its own secret"
    assert tomllib.loads(Path("run/run.toml").read_text())["controller"] == "mine.py:Forward"
    by_module = said(capsys, "replay", "run.toml", "--controller", "mine:Forward", "--json")
    assert by_module[0] == 0
    facts = json.loads(by_module[1])
    assert (facts["controller"], facts["odometry_off_m"], facts["link"]) == ("mine.py:Forward", None, None)


def test_a_scenario_may_name_it_relative_to_itself_and_the_command_line_wins(project, capsys):
    (project / "sub").mkdir()
    more = 'controller = "../mine.py:Forward"'
    (project / "sub" / "own.toml").write_text(SCENARIO.format(more=more))
    assert said(capsys, "replay", "sub/own.toml")[0] == 0
    assert said(capsys, "replay", "sub/own.toml", "--controller", "speed-loop")[0] == 1
    assert said(capsys, "replay", "sub/own.toml", "--junit", "junit.xml")[0] == 0
    (project / "sub" / "own.toml").write_text(SCENARIO.format(more=more.replace("Forward", "Forwrad")))
    status, _, error = said(capsys, "replay", "sub/own.toml")
    assert status == 2
    assert "own.toml: ../mine.py:Forwrad: ../mine.py has no 'Forwrad'; did you mean Forward?" in error


def test_its_recording_runs_again_with_it_and_tells_what_another_version_changes(project, capsys):
    assert said(capsys, "replay", "run.toml", "--controller", "mine.py:Forward", "--record", "run")[0] == 0
    status, _, error = said(capsys, "replay", "run")
    assert status == 2, "no data file makes us run code"
    assert "was recorded with the controller mine.py:Forward; give its place: --controller FOLDER/mine.py" in error
    status, out, _ = said(capsys, "replay", "run", "--controller", "mine.py:Forward")
    assert status == 0
    assert "golden    identical" in out
    (project / "next").mkdir()
    (project / "next" / "mine.py").write_text(MINE.replace("* CURRENT_MA", "* 501"))
    status, out, _ = said(capsys, "replay", "run", "--controller", "next/mine.py:Forward")
    assert status == 1
    assert "current 1 expected -500 mA, got -501 mA" in out


def test_a_wrong_one_of_ours_and_a_printed_form_go_by_the_same_option(project, capsys):
    out = said(capsys, "replay", "run.toml", "--controller", "no-timeout", "--record", "wrong")[1]
    assert "base      no-timeout, not the bench's own" in out
    assert "golden    identical" in said(capsys, "replay", "wrong")[1], "that one comes with the bench"
    status, _, error = said(capsys, "replay", "wrong", "--controller", "wheel-swap")
    assert status == 2
    assert "only a base of your own may take the place of its base: --controller FILE.py:NAME" in error
    out = said(capsys, "failsafe", "--only", "restart", "--jobs", "1", "--controller", "current-as-printed")[1]
    assert "m2006 with uart12, controller current-as-printed" in out


FAILED = "the controller failed at tick 321 (0.321 s): KeyError: 'speed' in mine.py:23 (look_up)"


def test_an_error_in_it_is_one_sentence_and_nothing_recorded_is_lost(project, capsys):
    status, _, error = said(capsys, "replay", "run.toml", "--controller", "mine.py:Fails", "--record", "run")
    assert status == 1
    assert error == f"wheelbench replay: {FAILED}; --traceback shows all of it\n"
    recording = Recording.open("run")
    assert recording.ticks == 321
    assert sorted(recording.commands) == list(range(321))
    status, _, error = said(capsys, "replay", "run.toml", "--controller", "mine.py:Fails", "--traceback")
    assert status == 1
    assert "return self.look_up({})" in error
    assert error.splitlines()[-1].startswith(f"wheelbench replay: {FAILED}")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("mine.py:NoStep", "mine.py:NoStep: gives 'NoStep', which has no step(tick, rc_bytes"),
        ("mine.py:NotUp", "mine.py:NotUp: did not come up: TypeError: "),
        ("mine.py:Leaves", "the controller failed at tick 0 (0.000 s): SystemExit: 5 in mine.py:28 (step)"),
        ("mine.py:nothing", "gave no frames at tick 0: step gives ((id, data), ...) and bytes, not None"),
        ("mine.py:one", "gave no frames at tick 0"),
        ("mine.py:text", "gave no frames at tick 0"),
        ("mine.py:words", "gave no frames at tick 0"),
        ("mine.py:wide", "a frame at tick 0 that no bus carries: id 2048, 0 bytes"),
        ("mine.py:long", "id 512, 9 bytes; an id is 0 to 0x7FF, and a frame holds at most 8 bytes"),
        ("mine.py:LIMIT", "is not callable; give a class or function that takes the robot: mine.py:Forward"),
        ("mine.py", "mine.py: does not say what makes the base; give a class or function that takes the robot"),
        ("mine.py:Forwards", "mine.py:Forwards: mine.py has no 'Forwards'; did you mean Forward?"),
        ("none.py:Forward", "none.py: there is no such file; a controller is FILE.py:NAME or module:NAME"),
        ("no_such_module:x", "no_such_module: there is no such module here; install it, or give its file"),
        ("sub:x", "there is no such module here"),
        ("broken.py:x", "broken.py: cannot be loaded: ModuleNotFoundError: No module named 'nothere' in broken.py:2"),
        (
            "no-timout",
            "no controller is called 'no-timout'; did you mean no-timeout? (or give your own: FILE.py:NAME, ",
        ),
    ],
)
def test_what_cannot_be_a_controller_is_one_sentence(project, capsys, name, says):
    (project / "broken.py").write_text("import os\nimport nothere\n")
    status, _, error = said(capsys, "replay", "run.toml", "--controller", name)
    assert status in (1, 2)
    assert says in error
    assert error.count("\n") == 1


def test_a_file_that_is_no_python_is_told_with_its_line(project, capsys):
    (project / "broken.py").write_text("one = 1\ndef (:\n")
    error = said(capsys, "replay", "run.toml", "--controller", "broken.py:x")[2]
    assert "broken.py: cannot be loaded: invalid syntax in broken.py:2" in error


def test_the_failsafe_matrix_judges_it_by_its_wires(project, capsys):
    # The example's controller loses the link after 60 ms of silence; it knows no flag, no zeros and no other axis.
    status, out, _ = said(capsys, "failsafe", "--controller", OURS, "--only", "restart", "--jobs", "1")
    assert status == 1
    assert "controller " + OURS in out
    assert "RED  restart, strafe, spin: does not move as the sticks say before the loss: 0.00, 0.00, 0.00" in out
    assert "restart           ok 0 ms" in out


def test_one_that_fails_in_the_matrix_is_red_there_and_the_matrix_goes_on(project, capsys):
    given = ("failsafe", "--controller", "mine.py:Fails")
    status, out, _ = said(capsys, *given, "--only", "restart")
    assert status == 1
    assert "restart           RED failed  RED failed" in out
    assert f"RED  restart, rest, cruise, strafe, spin, reversal: {FAILED}" in out
    status, _, error = said(capsys, *given, "--only", "restart", "--traceback")
    assert status == 1
    assert "return self.look_up({})" in error
    status, out, error = said(capsys, "failsafe", "--controller", "mine.py:NotUp")
    assert (status, out) == (1, "")
    assert "mine.py:NotUp: did not come up" in error


def test_several_processes_find_it_too(tmp_path):
    shutil.copytree(EXAMPLE / "my_controller", tmp_path / "mine", ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-m", "bench", "failsafe", "--controller", "controller:CrawlingBase"]
    done = subprocess.run(
        [*command, "--only", "one", "--json"],
        cwd=tmp_path / "mine",
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    cells = [json.loads(line) for line in done.stdout.splitlines()]
    assert [cell["verdict"] for cell in cells if cell["phase"] == "rest"] == ["ok", "ok"]
