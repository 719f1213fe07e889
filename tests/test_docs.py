"""Every command in README.md and docs/ is run, line by line, in a copy of the checkout's outside."""

import os
import pty
import re
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest
from compilers import HOW_TO_GET_THEM, MISSING

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "fixtures" / "README.md"]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
QUIT = b"\x11"  # Ctrl-Q


def commands(page):
    """The lines of a page's shell blocks, without their comments."""
    for language, block in FENCE.findall(page.read_text()):
        assert language in ("sh", "toml", "python", "text"), f"{page.name}: nobody runs a block of {language}"
        if language == "sh":
            lines = (re.sub(r"\s+#\s.*", "", line).strip() for line in block.splitlines())
            yield from (line for line in lines if line)


@pytest.fixture
def outside(tmp_path):
    """A folder that looks like the checkout and may be written into."""
    for path in ROOT.iterdir():
        if path.name not in (".git", "recordings"):
            (tmp_path / path.name).symlink_to(path)
    return tmp_path


def environment():
    return {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "TERM": "xterm-256color",
    }


def run(line, folder):
    done = subprocess.run(
        ["bash", "-c", line],
        cwd=folder,
        env=environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"


def run_in_terminal(line, folder):
    """Run a command that needs a terminal, wait for its screen, and quit it as a person would."""
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execvpe("bash", ["bash", "-c", f"stty rows 24 cols 80; exec {line}"], environment())
    robot = re.search(r"--robot (\S+)", line)
    title = robot.group(1).encode() if robot else b"m2006"
    seen, asked, deadline = b"", False, time.monotonic() + 60
    while time.monotonic() < deadline:
        if select.select([terminal], [], [], 0.1)[0]:
            try:
                seen += os.read(terminal, 65536)
            except OSError:  # the other end has closed: the program is gone
                break
        if not asked and title in seen:
            os.write(terminal, QUIT)
            asked = True
    os.close(terminal)
    _, status = os.waitpid(child, 0)
    assert asked, seen[-500:]
    assert os.waitstatus_to_exitcode(status) == 0, seen[-500:]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_command_of_the_page_works(page, outside):
    left_out = []
    for line in commands(page):
        if MISSING and re.search(r"wheelbench dut|\b(mine|fixed)\b.*toml", line):
            left_out.append(line)
        elif line == "make test":  # this very run
            plan = subprocess.run(["make", "-n", "test"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
            assert "-m pytest" in plan
        elif line == "make demo" and not (ROOT / ".venv").exists():
            run("wheelbench demo", outside)  # the tests run from another environment: no second one is built here
        elif line == "make demo":
            # Never install from here: the environment is the checkout's own, and its commands would name this folder.
            run("make -o pyproject.toml demo", outside)
        elif line.startswith("wheelbench drive"):
            run_in_terminal(line, outside)
        else:
            run(line, outside)
    if left_out:
        pytest.skip(f"{HOW_TO_GET_THEM}; left out: {left_out[0]} ...")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_link_of_the_page_leads_somewhere(page):
    for target in LINK.findall(page.read_text()):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_files_named_in_the_readme_exist():
    for name in re.findall(r"`((?:bench|scripts|tests|fixtures|docs)/[\w./-]+)`", (ROOT / "README.md").read_text()):
        assert (ROOT / name).exists(), name
