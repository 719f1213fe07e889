"""Ctrl-C in the command's first moments: status 130, a line at most, and no traceback. In processes of their own."""

import os
import pty
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from bench.cli.interrupt import end_with

ROOT = Path(__file__).parents[1]
SCRIPT = "import sys; from bench.cli.interrupt import command; sys.exit(command())"
"""What an installer makes of the entry point."""
STRUCK = """
import os, signal, sys
left = int(sys.argv.pop(1))
def strikes(event, _):
    global left
    if event == "import":
        left -= 1
        if not left:
            os.kill(os.getpid(), signal.SIGINT)
from bench.cli.interrupt import command
sys.addaudithook(strikes)
try:
    command()
finally:
    print("left", left)
"""
"""The command, and a Ctrl-C with its Nth import."""
STRUCK_AS_MODULE = """
import os, runpy, signal, sys
sys.addaudithook(lambda event, met: event == "import" and met[0] == "argparse" and os.kill(os.getpid(), signal.SIGINT))
runpy.run_module("bench", run_name="__main__", alter_sys=True)
"""
"""`python -m bench`, and a Ctrl-C with the first import that takes its time."""
STRUCK_AT_THE_END = """
import atexit, os, signal
from bench.cli.interrupt import command
atexit.register(os.kill, os.getpid(), signal.SIGINT)
command()
"""
STRUCK_BETWEEN = """
import os, signal, time
from bench.cli.interrupt import hand_over, take_over
class Dying:
    def __init__(self, last):
        self.last = last
    def __del__(self):
        self.last()
def strikes():
    os.kill(os.getpid(), signal.SIGINT)
def fails():
    raise ValueError("odd")
take_over()
hand_over()
for struck in strikes, lambda: Dying(strikes):
    try:
        struck()
        time.sleep(30.0)
        print("lost")
    except KeyboardInterrupt:
        print("caught")
Dying(fails)
"""
FIRST_LINES = {"__init__.py": 99, "cli/__init__.py": 99, "cli/interrupt.py": 99, "__main__.py": 12}
"""Which of our files Python reads before it can be told of Ctrl-C, and how far."""
COMMAND = "replay", "docs/examples/link_loss.toml"


def heeding():
    """In the child: whoever runs these tests in the background ignores Ctrl-C, and that is inherited."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def deaf():
    """In the child, as by `nohup` or a shell's `&`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run(*words, child=heeding):
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=child,
    )
    return done.returncode, done.stdout, done.stderr


def test_the_entry_point_is_the_one_that_is_tried_here():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    assert scripts == {"wheelbench": "bench.cli.interrupt:command"}


@pytest.fixture(scope="module")
def imports():
    """How many there are in a run to its end."""
    status, out, err = run("-c", STRUCK, 1_000_000, *COMMAND)
    assert (status, err) == (0, "")
    return 1_000_000 - int(out.split()[-1])


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.9])
def test_ctrl_c_with_any_import_is_a_line_and_130(imports, share):
    """From the first to nearly the last, whatever was being read: argparse, the verb, pymunk."""
    status, _, err = run("-c", STRUCK, 1 + int(imports * share), *COMMAND)
    assert (status, err) == (130, "wheelbench replay: interrupted\n")


def test_ctrl_c_in_the_first_moments_of_the_module_is_the_same():
    assert run("-c", STRUCK_AS_MODULE, "robots") == (130, "", "wheelbench robots: interrupted\n")


def test_ctrl_c_when_all_is_done_is_the_same():
    status, out, err = run("-c", STRUCK_AT_THE_END, "robots")
    assert (status, err) == (130, "wheelbench robots: interrupted\n")
    assert out.endswith("uart12\n"), "it had been done"


def test_between_them_it_can_be_caught_wherever_it_strikes_and_other_errors_are_told():
    status, out, err = run("-c", STRUCK_BETWEEN)
    assert (status, out) == (0, "caught\ncaught\n")
    assert "ValueError: odd" in err
    assert "KeyboardInterrupt" not in err


def test_a_second_ctrl_c_while_the_first_is_told_is_the_same():
    def told():
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as ended:
        end_with(told)
    assert ended.value.code == 130


def test_who_was_started_deaf_to_it_stays_so():
    status, out, err = run("-c", STRUCK, 1, "robots", child=deaf)
    assert (status, err) == (0, "")
    assert "m2006" in out


@pytest.mark.parametrize("how", [("-m", "bench"), ("-c", SCRIPT)])
def test_ctrl_c_on_a_terminal_at_any_moment_shows_no_line_of_ours(how):
    """From 0 ms on. Until our first lines have been read it is Python's own to tell; then there is no traceback."""
    began = time.monotonic()
    assert struck(how, 60.0)[0] == 0
    whole_s = time.monotonic() - began
    for moment in range(5):
        status, text = struck(how, whole_s * moment / 5)
        if "Traceback" in text:
            ours = re.findall(re.escape(f"{ROOT}/bench/") + r'(.*?)", line (\d+)', text)
            assert all(int(line) <= FIRST_LINES.get(file, 0) for file, line in ours), (moment, text)
            assert "argparse" not in text, (moment, text)
            assert any(own in text for own in ("<frozen", "site", 'File "<string>"')), (moment, text)
        else:
            assert status in (130, -signal.SIGINT, 0), (moment, text)


def struck(how, after_s):
    """(status, all that the terminal shows) of the command when Ctrl-C is typed then, if it is still there."""
    master, slave = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, *how, "robots"], cwd=ROOT, stdin=slave, stdout=slave, stderr=slave, preexec_fn=heeding
    )
    os.close(slave)
    try:
        child.wait(after_s)
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGINT)
    shown = b""
    while True:
        try:
            shown += os.read(master, 65536)
        except OSError:  # nobody has it open any more
            break
    os.close(master)
    return child.wait(), shown.decode()
