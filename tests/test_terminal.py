"""The dashboard in a real terminal: typed at, read, resized, left. Needs tmux."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from bench.check.reading import Recording

ROOT = Path(__file__).parents[1]
DEADLINE_S = 120.0

needs_tmux = pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed: no terminal to run in")


STARTER = """
import subprocess, sys
from pathlib import Path
place = Path(sys.argv[1])
child = subprocess.Popen(sys.argv[2:])
(place / "pid").write_text(str(child.pid))
(place / "ended").write_text(str(child.wait()))
sys.stdin.read()  # the terminal stays, to be read
"""


class Terminal:
    """One program in a terminal of its own. Everything waits for what it wants to see, until a deadline."""

    def __init__(self, place, socket):
        self.tmux = ["tmux", "-S", str(socket), "-f", "/dev/null"]
        self.place = place

    def start(self, *command):
        starter = [sys.executable, "-c", STARTER, str(self.place), *map(str, command)]
        self.do("new-session", "-d", "-x", "80", "-y", "24", "-c", str(ROOT), *starter)

    def do(self, *arguments):
        return subprocess.run([*self.tmux, *arguments], capture_output=True, text=True, check=True).stdout

    def keys(self, *keys):
        self.do("send-keys", *keys)

    def screen(self):
        return self.do("capture-pane", "-p")

    @property
    def pid(self):
        return int((self.place / "pid").read_text())

    def wait(self, what, seen):
        end = time.monotonic() + DEADLINE_S
        while time.monotonic() < end:
            screen = self.screen()
            if seen(screen):
                return screen
            time.sleep(0.05)
        raise AssertionError(f"not within {DEADLINE_S:g} s: {what}. The screen:\n{self.screen()}")

    def wait_for(self, text):
        return self.wait(text, lambda screen: text in screen)

    def driven(self, screen, *keys):
        """Push; arm before, as at the start, where the machine stood still and a silent terminal disarmed."""
        if " DISARMED " in screen:
            self.keys("Enter")
            self.wait_for(" ARMED ")
        self.keys(*keys)

    def wait_for_end(self):
        ended = self.place / "ended"
        self.wait("the end of the program", lambda _: ended.exists() and ended.read_text())
        return int(ended.read_text())


@pytest.fixture
def terminal(tmp_path):
    with tempfile.TemporaryDirectory(prefix="wb-") as folder:  # short: the path of a socket has few characters
        opened = Terminal(tmp_path, Path(folder) / "tmux")
        yield opened
        subprocess.run([*opened.tmux, "kill-server"], capture_output=True)


def wheelbench(*arguments):
    return [sys.executable, "-m", "bench", *map(str, arguments)]


def pose_x(screen):
    return float(screen.partition("pose     x ")[2].split(" ")[0])


@needs_tmux
def test_a_drive_from_start_to_end(terminal, tmp_path):
    terminal.start(*wheelbench("drive", "--record", tmp_path / "run"))
    terminal.wait_for("not armed since boot")
    first = terminal.wait("feedback on the screen", lambda screen: "rpm/mA" in screen)
    assert "m2006, uart12" in first.splitlines()[0]
    assert " SPACE STOP   ? help  Esc quit" in first.splitlines()[23]
    terminal.keys("Enter")
    terminal.wait_for(" ARMED ")

    def moved(screen):
        terminal.driven(screen, "w")
        return pose_x(screen) > 0.02

    terminal.wait("the robot to move", moved)
    terminal.wait("the sticks at rest again", lambda screen: screen.count(" +0 %") == 3)

    terminal.do("resize-window", "-x", "120", "-y", "40")
    terminal.wait("room", lambda screen: " wire        ago  last frame" in screen and "core's arc" in screen)
    terminal.do("resize-window", "-x", "50", "-y", "12")
    terminal.wait("the page for little room", lambda screen: "\n moves " in screen and "SPACE STOP" in screen)
    terminal.do("resize-window", "-x", "80", "-y", "24")
    terminal.wait_for("WASDQE 50 %")
    terminal.keys("?")
    terminal.wait_for("A key drives while it repeats.")
    terminal.keys("?")
    terminal.wait("the dashboard", lambda screen: "WASDQE 50 %" in screen and "ARMED " in screen)

    terminal.keys("Escape")
    assert terminal.wait_for_end() == 0
    assert "ARMED" not in terminal.screen(), "the terminal is as it was"
    recording = Recording.open(tmp_path / "run")
    assert recording.complete
    assert recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)
    assert any(data[0:2] != b"\0\0" for frames in recording.commands.values() for _, data in frames), "it drove"


@needs_tmux
def test_a_terminal_that_is_taken_away_leaves_a_closed_recording(terminal, tmp_path):
    terminal.start(*wheelbench("drive", "--record", tmp_path / "run"))
    terminal.wait_for("not armed since boot")
    os.kill(terminal.pid, signal.SIGHUP)
    assert terminal.wait_for_end() == 0
    assert Recording.open(tmp_path / "run").complete


@needs_tmux
def test_dragged_by_the_mouse_then_a_frozen_terminal_disarms_and_a_killed_one_leaves_it_whole(terminal, tmp_path):
    run = tmp_path / "run"
    terminal.start(*wheelbench("drive", "--record", run))
    terminal.wait_for("not armed since boot")
    terminal.keys("Enter")
    terminal.wait_for(" ARMED ")
    terminal.keys("m")
    screen = terminal.wait_for("forward, left").splitlines()
    row = next(y for y, line in enumerate(screen, 1) if "forward, left" in line)

    def dragged(screen):
        """Down on the middle, up to the frame, and so on; the terminal's bytes for it, as xterm sends them."""
        terminal.driven(screen, "-l", f"\x1b[<0;17;{row + 4}M\x1b[<32;17;{row + 1}M")
        return pose_x(screen) > 0.01

    terminal.wait("the robot to follow the mouse", dragged)
    terminal.keys("-l", f"\x1b[<0;17;{row + 1}m")
    terminal.keys("m")
    terminal.wait_for("WASDQE 50 %")

    server = int(terminal.do("display-message", "-p", "#{pid}"))
    os.kill(server, signal.SIGSTOP)  # a terminal that hangs
    time.sleep(2.0)
    os.kill(server, signal.SIGCONT)
    terminal.wait_for(" DISARMED ")
    terminal.keys("Enter")
    terminal.wait_for(" ARMED ")
    terminal.keys("w")
    pid = terminal.pid
    terminal.do("kill-server")
    end = time.monotonic() + DEADLINE_S
    while Path(f"/proc/{pid}").exists() and time.monotonic() < end:
        time.sleep(0.05)
    recording = Recording.open(run)
    assert recording.complete
    assert recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)


FAULT = """
import sys, bench.loop
tick = bench.loop.Bench.tick
def faulty(self, *given):
    if self.now_tick == 400:
        raise ZeroDivisionError("a fault for the test")
    return tick(self, *given)
bench.loop.Bench.tick = faulty
from bench.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@needs_tmux
def test_a_fault_in_the_bench_is_one_sentence_after_the_terminal_is_back(terminal, tmp_path):
    (tmp_path / "faulty.py").write_text(FAULT)
    terminal.start(sys.executable, tmp_path / "faulty.py", "drive", "--record", tmp_path / "run")
    assert terminal.wait_for_end() == 1
    said = " ".join(terminal.screen().split())
    assert "wheelbench drive: stopped at tick 400: ZeroDivisionError in faulty.py:" in said
    assert "Traceback" not in said
    recording = Recording.open(tmp_path / "run")
    assert recording.complete
    assert recording.ticks == 400


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["drive"], 3, "without one use `wheelbench demo` or `wheelbench replay`"),
        (["drive", "--can", "recorded"], 2, "goes with --replay DIR"),
        (["drive", "--replay", "x", "--robot", "m2006"], 2, "brings its own robot"),
    ],
)
def test_without_a_terminal_or_with_a_contradiction_there_is_one_sentence(arguments, status, words):
    done = subprocess.run(wheelbench(*arguments), capture_output=True, text=True, stdin=subprocess.DEVNULL, cwd=ROOT)
    assert done.returncode == status
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""
