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
    again = re.search(r"^wheelbench (replay \S+)$", said, re.MULTILINE)
    assert again, said
    assert Path(again.group(1).split()[1]).is_dir()


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
        ("@pytest.mark.wheelbench(robt='m2006')\ndef test(bench): pass", "takes robot= and profile=, not robt"),
        ("@pytest.mark.wheelbench(robot='slamware-b')\ndef test(rc): pass", "takes no RC; use slamware_link"),
    ],
)
def test_a_wrong_marker_is_one_sentence(project, text, says):
    status, said = run_pytest(project(f"import pytest\n{text}"), "-q")
    assert status == 1
    assert says in said
    assert "Traceback" not in said


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
    assert "again: wheelbench replay" in said
    assert "Traceback" not in said


def test_installing_wheelbench_installs_the_plugin_and_importing_it_costs_little():
    text = (ROOT / "pyproject.toml").read_text()
    assert '[project.entry-points.pytest11]\nwheelbench = "bench.pytest_plugin"' in text
    heavy = {"pymunk", "can", "serial", "textual", "bench.loop"}
    code = "import pytest, sys, bench.pytest_plugin; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert heavy & set(done.stdout.split()) == set()
