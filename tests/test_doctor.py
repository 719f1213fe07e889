"""`wheelbench doctor` on this very machine, and on machines that lack something."""

import json
import os
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.config import load_robot
from bench.errors import SurroundingsError
from bench.io import surroundings, timing
from bench.io.lateness import Lateness
from bench.io.punctual import REAL_TIME

ROOT = Path(__file__).parents[1]
M2006 = load_robot("m2006")
NEEDS_COMPILER = pytest.mark.skipif(timing.compiler_here() is None, reason="there is no C compiler here")


def test_it_looks_at_everything_and_says_what_to_try(call):
    status, out, err = call("doctor", "--json")
    assert (status, err) == (0, "")
    findings = json.loads(out)["findings"]
    topics = {one["topic"] for one in findings}
    assert {"terminal", "python", "serial", "permissions", "can", "multicast", "compiler", "clock", "load"} <= topics
    for one in findings:
        assert one["state"] in ("ok", "lacking", "bad")
        assert bool(one["what_to_try"]) == (one["state"] != "ok"), one
    status, out, _ = call("doctor")
    assert status == 0
    assert out.count("try: ") == sum(bool(one["what_to_try"]) for one in findings)


def test_a_machine_without_a_compiler(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert surroundings._compiler().state == surroundings.LACKING
    assert timing.compiler_here() is None


def test_can_interfaces_are_those_of_the_kernel(monkeypatch):
    class Net(type(Path())):
        pass

    monkeypatch.setattr(surroundings.socket, "socket", lambda *_: type("Socket", (), {"close": lambda self: None})())
    states = {"can0": ("280", "down"), "vcan0": ("280", "unknown"), "lo": ("772", "unknown")}
    monkeypatch.setattr(surroundings.Path, "iterdir", lambda self: [self / name for name in states])
    monkeypatch.setattr(surroundings, "_read", lambda path: states[path.parent.name][path.name == "operstate"])
    down, up = surroundings.can_buses()
    assert (down.state, down.text) == ("bad", "can:socketcan:can0 is down")
    assert down.what_to_try == "sudo ip link set can0 up type can bitrate 1000000"
    assert (up.state, up.text) == ("ok", "can:socketcan:vcan0 is unknown")


def in_terminal(answer, env=None):
    """Run `doctor` in a pty that is a terminal of 100x30 and says this when it is asked; what it printed."""
    master, slave = os.openpty()
    code = "import sys, termios; termios.tcsetwinsize(0, (30, 100)); from bench.__main__ import main; "
    code += "from bench.cli import doctor; doctor.KITTY_S = 60.0; "  # this one answers, whenever it gets to it
    code += "sys.exit(main(['doctor']))"
    running = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=ROOT,
        stdin=slave,
        stdout=slave,
        stderr=slave,
        env={**os.environ, "TERM": "xterm-256color", **(env or {})},
        start_new_session=True,
    )
    os.close(slave)
    seen, answered, deadline = b"", False, time.monotonic() + 60
    while time.monotonic() < deadline:
        if select.select([master], [], [], 0.05)[0]:
            try:
                seen += os.read(master, 65536)
            except OSError:
                break
        if b"\x1b[c" in seen and not answered:
            answered = True
            os.write(master, answer)
    assert running.wait(60) == 0
    os.close(master)
    return seen.decode()


def test_a_terminal_that_tells_when_keys_are_let_go():
    seen = in_terminal(b"\x1b[?0u\x1b[?62;c", {"COLORTERM": "truecolor"})
    assert "tells when a key is let go" in seen
    assert "xterm-256color, 100x30" in seen
    assert "16 million colours" in seen


def test_a_terminal_that_does_not():
    seen = in_terminal(b"\x1b[?62;c", {"COLORTERM": ""})
    assert "does not tell when a key is let go" in seen
    assert "export COLORTERM" in seen


@NEEDS_COMPILER
def test_timing_tells_both_loops(call):
    status, out, err = call("doctor", "timing", "--seconds", "0.3", "--no-dashboard", "--json")
    assert (status, err) == (0, "")
    facts = json.loads(out)
    assert facts["ours"]["ticks"] == facts["c"]["ticks"] == 300
    assert facts["ours"]["p50_us"] <= facts["ours"]["p99_us"] <= facts["ours"]["max_us"]
    assert facts["scheduling"]
    status, out, _ = call("doctor", "timing", "--seconds", "0.2", "--no-dashboard", "--load", "--no-priority")
    assert status == 0
    assert "a loop in C" in out
    assert f"beside {os.cpu_count()} busy processes" in out
    ticks = [line.split("us")[1].split()[:2] for line in out.splitlines()[5:]]
    assert [sum(int(row[k]) for row in ticks) for k in (0, 1)] == [200, 200], "each tick is in the histogram"


def test_without_a_compiler_ours_is_told_alone(call, monkeypatch):
    monkeypatch.setattr(timing, "compiler_here", lambda: None)
    status, out, _ = call("doctor", "timing", "--seconds", "0.1", "--no-dashboard")
    assert status == 0
    assert "no C compiler to compare with" in out


def test_a_compiler_that_does_not_work_is_a_sentence(tmp_path):
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho 'no headers here' >&2\nexit 1\n")
    broken.chmod(0o755)
    with pytest.raises(SurroundingsError, match="no headers here"):
        timing.compiled(str(broken), tmp_path)
    with pytest.raises(SurroundingsError, match="cannot be run"):
        timing.compiled(str(tmp_path / "none"), tmp_path)


def test_seconds_have_to_make_sense(call):
    assert call("doctor", "timing", "--seconds", "0")[0] == 2


def test_counts_join_without_loss():
    one, two = Lateness(), Lateness()
    for late_ns in (500, 1_500, 999_000):
        one.add(late_ns)
    two.add(2_000_000)
    one.join(two)
    facts = one.facts()
    assert (facts["ticks"], facts["max_us"], facts["over_1_ms_percent"]) == (4, 2000.0, 25.0)
    assert dict(one.bars())["1 us"] == 1
    assert dict(one.bars())["2 us"] == 1
    assert sum(count for _, count in one.bars()) == 4


def test_a_child_gets_what_it_may_have():
    """In a process of its own: what is asked for holds for all of it."""
    code = "from bench.io.punctual import be_punctual; print(be_punctual(with_priority=False)); print(be_punctual())"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    ordinary, most = done.stdout.splitlines()
    assert ordinary in ("ordinary scheduling", "ordinary priority, short time slice")
    assert most in (REAL_TIME, ordinary)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="priorities are asked for on Linux alone")
def test_on_one_processor_nobody_takes_it_all():
    """There a loop with priority that falls behind would leave a twentieth to whoever hears the stop key."""
    code = (
        "import os; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])\n"
        "from bench.io.punctual import be_punctual; from bench.io.surroundings import clock\n"
        "print(be_punctual()); print(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK)\n"
        "print(clock()[-1])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    scheduling, policy, finding = done.stdout.splitlines()
    assert scheduling in ("ordinary scheduling", "ordinary priority, short time slice")
    assert int(policy) == os.SCHED_OTHER
    assert "on one processor" in finding


@pytest.mark.parametrize("option", [["--load"], ["--seconds", "5"], ["--no-dashboard"], ["--no-priority"]])
def test_what_goes_with_a_measurement_is_not_passed_over(call, option):
    assert call("doctor", *option) == (2, "", f"wheelbench doctor: {option[0]}: goes with `wheelbench doctor timing`\n")
