"""What a newcomer sees of the Makefile where an install fails: why, and what to try, in a few lines."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def checkout(tmp_path):
    """A scratch copy with an empty environment of its own, whose pip is that of the tests."""
    pip = pytest.importorskip("pip", reason="pip is not installed: there is nothing to install with")
    for name in ("Makefile", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path)
    environment = tmp_path / ".venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    (packages,) = environment.glob("lib/python*/site-packages")
    (packages / "pip").symlink_to(Path(pip.__file__).parent)
    return tmp_path


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_an_install_that_fails_says_why_and_what_to_try(checkout):
    alone = {"PIP_CONFIG_FILE": os.devnull, "PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_RETRIES": "2"}
    # Of the make that runs these tests, nothing: under another one it would say which folder it enters.
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "MAKE", "MFLAGS"))}
    done = subprocess.run(["make", "demo"], cwd=checkout, env=kept | alone, capture_output=True, text=True)
    assert done.returncode == 2, "make's own status"
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert lines[0].startswith("installing wheelbench")
    assert sum("WARNING" in line for line in lines) == 1, done.stderr
    assert "Connection refused" in done.stderr
    assert any("ERROR" in line and "hatchling" in line for line in lines)
    assert lines[-2].startswith("wheelbench: pip could not install into .venv")
    assert "Traceback" not in done.stderr
    stamps = {path.name for path in (checkout / ".venv").glob(".*")} - {".gitignore"}  # Python 3.13 writes that one
    assert not stamps, "the next make tries again"


@pytest.mark.parametrize("kind", ["socketcan", "gamepad"])
def test_where_no_such_kernel_can_be_had_the_recipe_says_why(tmp_path, kind):
    """Status 125 is what `make socketcan` and `make gamepad` take for a skip; any other would be a failed test."""
    (tmp_path / "bin").mkdir()
    for tool in ("bash", "dirname", "uname"):
        (tmp_path / "bin" / tool).symlink_to(shutil.which(tool))
    done = subprocess.run(
        [shutil.which("bash"), ROOT / "scripts/kernels/run.sh", kind, "true"],
        env={"PATH": str(tmp_path / "bin"), "KERNEL_CACHE": str(tmp_path / "cache")},
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (125, "")
    assert done.stderr.startswith(f"{kind}: ")
    assert len(done.stderr.splitlines()) == 1


KERNEL = f"""#!{sys.executable} -IS
import os, signal, sys, time
os.setsid()  # as user-mode Linux does
desk = next(word[5:] for word in sys.argv if word.startswith("DESK="))
child = os.fork()  # as its processes do, holds the output open
if child:
    open(desk + "/begun", "w").close()
    print(os.getpid(), child, flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize("ended_by", ["time", "Ctrl-C"])
def test_a_kernel_that_goes_on_is_ended_with_all_of_its_processes(tmp_path, ended_by):
    """A command that is cut off has failed: 125 ("there is no kernel here") would make a skipped test of it."""
    root = tmp_path / "root"
    (root / "usr/lib/uml/modules/6/kernel").mkdir(parents=True)
    (root / "usr/bin").mkdir()
    (root / "fetched").touch()
    (root / "usr/bin/linux.uml").write_text(KERNEL)
    (root / "usr/bin/linux.uml").chmod(0o755)
    limit_s = "5" if ended_by == "time" else "300"
    environment = {**os.environ, "KERNEL_CACHE": str(tmp_path), "KERNEL_LIMIT_S": limit_s}
    with subprocess.Popen(
        [shutil.which("bash"), ROOT / "scripts/kernels/run.sh", "socketcan", "true"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as script:  # fmt: skip
        pids = [int(pid) for pid in script.stdout.readline().split()]
        if ended_by == "Ctrl-C":
            os.killpg(script.pid, signal.SIGINT)
        assert script.wait(60) == (130 if ended_by == "Ctrl-C" else 124)
        assert ended_by == "Ctrl-C" or "cut off after 5 s" in script.stderr.read()
    assert len(pids) == 2
    deadline = time.monotonic() + 60
    while any(is_running(pid) for pid in pids):
        assert time.monotonic() < deadline, "its processes go on"
        time.sleep(0.05)


def is_running(pid):
    """Whether it is there and no zombie."""
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
