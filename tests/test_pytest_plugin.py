"""The plugin as a user has it: pytest in a folder of its own, in a process of its own."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "docs" / "examples" / "my_controller"


def run_pytest(folder, *options, **variables):
    """A pytest run with our plugin and xdist, and no other."""
    environment = {key: value for key, value in os.environ.items() if key not in ("CI", "PYTEST_ADDOPTS")}
    environment |= {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONPATH": str(ROOT), **variables}
    command = [sys.executable, "-m", "pytest", "-p", "bench.pytest_plugin", "-p", "no:cacheprovider", *options]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture
def project(tmp_path):
    """A folder with one test file."""

    def write(text, name="test_mine.py"):
        (tmp_path / name).write_text(text)
        return tmp_path

    return write


def test_the_example_project_passes_with_its_golden_on_several_processes(tmp_path):
    folder = tmp_path / "mine"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    status, said = run_pytest(folder, "-p", "xdist", "-n", "2", "-q", CI="1")
    assert status == 0, said
    assert "4 passed" in said


def test_a_change_in_the_users_controller_is_told_in_words_with_wires_and_a_command(tmp_path):
    folder = tmp_path / "mine"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    source = (folder / "controller.py").read_text()
    (folder / "controller.py").write_text(source.replace("FULL_STICK_MA = 400", "FULL_STICK_MA = 401"))
    status, said = run_pytest(folder, "-q", "-k", "looked_at")
    assert status == 1
    assert re.search(r"can 0x200: current 1 expected -?\d+ mA, got -?\d+ mA", said)
    assert len(re.findall(r"^\(0\.\d{6}\) can0 ", said, re.MULTILINE)) in range(40, 51)
    again = re.search(r"^wheelbench (replay \S+ --controller controller.py:CrawlingBase)$", said, re.MULTILINE)
    assert again, said
    done = subprocess.run(
        [sys.executable, "-m", "bench", *again.group(1).split()],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "golden    identical" in done.stdout, "the command that is printed does run it again"


GOLDEN = """
def test_drive(bench, rc, golden):
    rc.arm().hold(forward=0.5).run(0.1)
    golden()
"""


def test_a_golden_is_pinned_only_when_asked_and_never_in_ci(project):
    folder = project(GOLDEN)
    status, said = run_pytest(folder, "-q")
    assert status == 1
    assert "there is no golden" in said
    assert "pytest --update-pinned" in said
    status, said = run_pytest(folder, "-q", "--update-pinned", CI="true")
    assert status == 4
    assert "not pinned in CI" in said
    assert run_pytest(folder, "-q", "--update-pinned")[0] == 0
    assert (folder / "goldens" / "test_drive" / "golden.toml").exists()
    assert run_pytest(folder, "-q", CI="true")[0] == 0


def test_none_in_the_marker_is_what_no_marker_is(project):
    text = "import pytest\n@pytest.mark.wheelbench(robot=None, profile=None, arena=None)\ndef test(bench):"
    assert run_pytest(project(f"{text} assert bench.robot.name == 'm2006'"), "-q")[0] == 0


def test_the_marker_chooses_robot_and_profile(project):
    folder = project(
        """
import pytest

@pytest.mark.wheelbench(robot="mecanum", profile="elrs")
def test_sideways(bench, rc, plant, slamware_link, can_bus):
    assert len(plant.currents_a) == 4
    rc.arm().hold(left=0.3).run(1.0)
    assert plant.pose.y_m > 0.01
    assert slamware_link.requests and slamware_link.answers
    assert len(can_bus.frames(0x201)) == len(bench.outputs)
    assert {"angle_counts", "speed_rpm", "current_ma"} <= can_bus.decoded(0x201)[-1][1].keys()

@pytest.mark.wheelbench(robot="slamware-b")
def test_by_the_core_alone(bench, slamware_link, plant):
    slamware_link.ask(vx_mps=0.2)
    bench.run(1.0)
    assert plant.twist.vx_mps > 0.05
"""
    )
    status, said = run_pytest(folder, "-q", "--strict-markers", "-W", "error")
    assert status == 0, said


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "@pytest.mark.wheelbench(robot='m206')\ndef test(bench): pass",
            "no robot is called 'm206'; did you mean m2006?",
        ),
        ("@pytest.mark.wheelbench(robt='m2006')\ndef test(bench): pass", "takes robot=, profile=, arena=; not robt"),
        ("@pytest.mark.wheelbench(arena=3)\ndef test(bench): pass", "arena is a name or a file, not 3"),
        ("@pytest.mark.wheelbench(arena='')\ndef test(bench): pass", "cannot be read (Is a directory)"),
        ("@pytest.mark.wheelbench(robot='')\ndef test(bench): pass", "is a directory; a robot is a .toml file"),
        ("@pytest.mark.wheelbench(robot='slamware-b')\ndef test(rc): pass", "takes no RC; use slamware_link"),
    ],
)
def test_a_wrong_marker_is_one_sentence(project, text, says):
    status, said = run_pytest(project(f"import pytest\n{text}"), "-q")
    assert status == 1
    assert says in said
    assert "Traceback" not in said
    assert "During handling" not in said, "once, not with the error that it came from"


SCENARIO = """
schema = 1
name = "stands"
seconds = 0.2

[[expect]]
name = "stands"
always = "speed_mps <= {most}"
"""


def test_scenario_files_are_tests(project):
    folder = project(SCENARIO.format(most=0.1), "good.scenario.toml")
    project(SCENARIO.format(most=-0.1), "bad.scenario.toml")
    project(SCENARIO.format(most=0.1) + "[[expcet]]\n", "wrong.scenario.toml")
    status, said = run_pytest(folder, "-v")
    assert status == 1
    assert re.search(r"good\.scenario\.toml::good PASSED", said)
    assert "stands: failed at 0.000 s, by 0.1" in said
    assert "wrong.scenario.toml: expcet: unknown key; did you mean expect?" in said
    assert re.search(r"- Captured run it again call -+\nwheelbench replay bad\.scenario\.toml\n", said)
    assert "Traceback" not in said


DRIVEN = """
schema = 1
name = "driven"
seconds = 0.6

[[stick]]
at_s = 0.1
aux1 = true
[[stick]]
at_s = 0.2
forward = 1.0

[[fault]]
wire = "feedback"
kind = "duplicate"
at_s = 0.1
for_s = 0.01

[[expect]]
name = "slow"
always = "speed_mps < 0.05"
"""


def test_a_scenario_drives_the_projects_own_controller_and_keeps_its_recording_and_witnesses(tmp_path):
    folder = tmp_path / "mine"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "push.scenario.toml").write_text(DRIVEN)
    (folder / "ours.scenario.toml").write_text(DRIVEN.replace("seconds", 'controller = "speed-loop"\nseconds'))
    status, said = run_pytest(folder, "-q", "-k", "push or ours", "--basetemp", str(tmp_path / "kept"))
    assert status == 1
    assert "wheelbench replay push.scenario.toml --controller controller.py:CrawlingBase" in said
    assert re.search(r"^wheelbench replay ours\.scenario\.toml$", said, re.MULTILINE)
    kept = tmp_path / "kept" / "push0" / "run"
    assert f"(its recording: {kept})" in said
    assert (kept / "faults.log").read_text().count('"feedback duplicate"') == 10
    assert 'controller = "controller.py:CrawlingBase"' in (kept / "run.toml").read_text()
    # Ours is faster; the lines end where the expectation fails, not where the run does.
    until = [float(at) for at in re.findall(r"of the wires until ([\d.]+) s", said)]
    assert len(until) == 2
    assert max(until) < 0.6
    assert len(re.findall(r"^\(0\.\d{6}\) \w+0 ", said, re.MULTILINE)) == 100


def test_an_error_in_the_controller_of_a_scenario_is_shown_and_its_recording_kept(project):
    folder = project(SCENARIO.format(most=0.1), "some.scenario.toml")
    project(
        """
import pytest

@pytest.fixture
def controller():
    return lambda robot: Broken()

class Broken:
    def step(self, tick, *wires):
        if tick == 70:
            raise ZeroDivisionError("in my own code")
        return (), b""
""",
        "conftest.py",
    )
    status, said = run_pytest(folder, "-q")
    assert status == 1
    assert re.search(r"^E +ZeroDivisionError: in my own code$", said, re.MULTILINE)
    assert "the last lines of the wires until 0.069 s" in said
    assert "python -m pytest 'some.scenario.toml::some'" in said, "a lambda has no name to give"


def test_what_is_pinned_and_what_it_changes_is_printed_and_so_is_an_unused_golden(project):
    folder = project(GOLDEN)
    status, said = run_pytest(folder, "-q", "--update-pinned", "-p", "xdist", "-n", "2")
    assert status == 0
    assert "pinned goldens/test_drive: new" in said
    project(GOLDEN.replace("forward=0.5", "forward=0.8"))
    said = run_pytest(folder, "-q", "--update-pinned")[1]
    assert "pinned goldens/test_drive: differs: " in said
    assert re.search(r"rc +\d+ compared, \d+ differ", said)
    project("def test_other(bench): pass")
    status, said = run_pytest(folder, "-q", "-p", "xdist", "-n", "2")
    assert status == 0
    assert "golden goldens/test_drive: UNUSED: nothing is held against it; delete it" in said


def test_a_golden_takes_tolerances_in_their_units(project):
    folder = project(GOLDEN)
    assert run_pytest(folder, "-q", "--update-pinned")[0] == 0
    golden = folder / "goldens" / "test_drive" / "golden.toml"
    golden.unlink()  # a plain recording, so that it may be edited
    log = golden.parent / "can.log"
    text = log.read_text()
    at = text.index("(0.399000) can0 201#") + len("(0.399000) can0 201#0000")
    log.write_text(f"{text[:at]}{int(text[at : at + 4], 16) ^ 1:04X}{text[at + 4 :]}")
    assert run_pytest(folder, "-q")[0] == 1
    project(GOLDEN.replace("golden()", 'golden(tolerance={"speed": "1 rpm"})'))
    assert run_pytest(folder, "-q")[0] == 0
    project(GOLDEN.replace("golden()", 'golden(tolerance={"speed": "1 mA"})'))
    status, said = run_pytest(folder, "-q")
    assert status == 1
    assert "speed is recorded in rpm, not in mA; such as speed=5rpm" in said


def test_two_tests_of_one_name_are_told_that_they_would_share_a_golden(project):
    folder = project(
        """
class TestA:
    def test_drive(self, rc, golden):
        golden()

class TestB:
    def test_drive(self, rc, golden):
        golden()

    def test_named(self, rc, golden):
        golden("other")
"""
    )
    status, said = run_pytest(folder, "-q", "--update-pinned")
    assert status == 1
    assert "test_mine.py::TestA::test_drive and test_mine.py::TestB::test_drive share the golden test_drive" in said
    assert [path.name for path in (folder / "goldens").iterdir()] == ["other"]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ("hold(forward=float('nan'))", "forward is nan; expected -1 to 1"),
        ("hold(turn=-1.5)", "turn is -1.5; expected -1 to 1"),
        ("run(-1)", "a run of -1 s; expected 0 or more"),
    ],
)
def test_a_wrong_call_is_told(project, call, says):
    assert says in run_pytest(project(f"def test_now(rc): rc.{call}"), "-q")[1]


def test_a_test_that_fails_before_the_first_tick_fails_as_any_other(project):
    status, said = run_pytest(project("def test_now(bench): assert bench is None"), "-q")
    assert status == 1
    assert "1 failed" in said
    assert "INTERNALERROR" not in said


def test_the_marker_chooses_an_arena_beside_the_test(project):
    folder = project('name = "hall"\nlength_m = 1.0\n[start]\nx_m = 0.2\n', "hall.toml")
    project(
        """
import pytest

@pytest.mark.wheelbench(arena="hall.toml")
def test_wall(bench, rc, plant):
    assert plant.pose.x_m == 0.2
    rc.arm().hold(forward=1.0).run(1.0)
    assert plant.pose.x_m < 0.5
"""
    )
    status, said = run_pytest(folder, "-q")
    assert status == 0, said


def test_installing_wheelbench_installs_the_plugin_and_importing_it_costs_little():
    text = (ROOT / "pyproject.toml").read_text()
    assert '[project.entry-points.pytest11]\nwheelbench = "bench.pytest_plugin"' in text
    heavy = {"pymunk", "can", "serial", "textual", "bench.loop"}
    code = "import pytest, sys, bench.pytest_plugin; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert heavy & set(done.stdout.split()) == set()
