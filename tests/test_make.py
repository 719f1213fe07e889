"""What a newcomer sees of the Makefile where an install fails: why, and what to try, in a few lines."""

import os
import shutil
import subprocess
import sys
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
    assert not list((checkout / ".venv").glob(".*")), "the next make tries again"


def test_where_no_kernel_with_can_can_be_had_socketcan_says_why(tmp_path):
    """Status 125 is what `make socketcan` takes for a skip; any other would be a failed test."""
    (tmp_path / "bin").mkdir()
    for tool in ("bash", "dirname", "uname"):
        (tmp_path / "bin" / tool).symlink_to(shutil.which(tool))
    done = subprocess.run(
        [shutil.which("bash"), ROOT / "scripts/socketcan/run.sh", "true"],
        env={"PATH": str(tmp_path / "bin"), "SOCKETCAN_CACHE": str(tmp_path / "cache")},
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (125, "")
    assert done.stderr.startswith("socketcan: ")
    assert len(done.stderr.splitlines()) == 1
