"""The real app on a real pty: key releases, hostile bytes, a terminal that stalls, stops, or goes away."""

import copy
import os
import random
import re
import signal
import time

import pytest
from pty_terminal import DEADLINE_S, PtyTerminal, Screen
from test_terminal_input import NOISE, VECTORS

from bench.check.reading import Recording
from bench.screen.terminal_input import InputDecoder, Key
from bench.tui import READY_TICKS

ENTER, W = b"\x1b[13;1:1u\x1b[13;1:3u", b"\x1b[119;1:1;119u"
W_UP = b"\x1b[119;1:3u"
TIMES = 3


SLOWER = f"""
import sys
from bench.io import clock
from bench.screen import key_sticks, terminal_watch
for module, names in (
    (key_sticks, ("KEY_LEASE_MS", "WITHIN_MS", "SILENT_HOLD_MS")), (terminal_watch, ("STALL_MS", "DETECTION_MS"))
):
    for name in names:
        setattr(module, name, {TIMES} * getattr(module, name))
clock.WallPacer.__init__.__defaults__ = (1.0, {TIMES} * clock.BURST_TICKS, clock.now_ns)
from bench.__main__ import main
sys.exit(main(sys.argv[1:]))
"""
"""The command, with hands and terminal so much slower: a busy machine may have no 120 ms to be alive in."""


@pytest.fixture
def opened(tmp_path):
    terminals = []

    def start(*command, **options):
        terminal = PtyTerminal(
            tmp_path, *(command or ("-m", "bench")), "drive", "--record", tmp_path / "run", **options
        )
        terminals.append(terminal)
        terminal.wait_for("not armed since boot")
        terminal.wait_until(lambda: last_tick(tmp_path / "run") >= READY_TICKS, "the first ticks")
        if terminal.kitty:
            terminal.wait_until(lambda: terminal.flags == [0, 27], "the keyboard to be taken")
        return terminal

    yield start
    for terminal in terminals:
        terminal.close()


def forward_stick(run):
    """(tick in ms, raw forward channel) of every RC frame: uart12, channel 2, middle 2048, below is forward."""
    found = re.findall(r"\((\d+)\.(\d{3})\d*\) \S+ > (.*)\n", (run / "rc.log").read_text())
    return [(int(s) * 1000 + int(ms), int("".join(data.split()[5:7]), 16)) for s, ms, data in found]


def last_tick(run):
    """The last in which an RC frame was sent, of what has been written so far."""
    return max((tick for tick, _ in forward_stick(run)), default=0)


def spans(run):
    """(start, end) of each time that the stick was pushed."""
    out, since = [], None
    for tick, raw in forward_stick(run):
        if (raw != 2048) is not (since is not None):
            if since is not None:
                out.append((since, tick))
            since = tick if since is None else None
    return out


def stopped(run):
    recording = Recording.open(run)
    return recording.complete and recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)


def leaves(decoder, data):
    """Whether these bytes are one of the keys that mean to leave, or to suspend."""
    names = {event.name for event in copy.deepcopy(decoder).feed(data) if isinstance(event, Key)}
    return bool(names & {"escape", "ctrl+c", "ctrl+q", "ctrl+z"})


def type_anything(terminal, seed, rounds):
    """Keys, answers and noise, cut anywhere; never a lone ESC at the end."""
    rng, shadow, sent = random.Random(seed), InputDecoder(), 0
    known = [data for data, _ in VECTORS] + [data for data in NOISE if len(data) < 100]
    while sent < rounds:
        data = b"".join(
            rng.choice(known) if rng.random() < 0.7 else rng.randbytes(rng.randrange(1, 20)) for _ in range(5)
        )
        data = data[rng.randrange(8) :] + b"\x1b["
        if leaves(shadow, data):
            continue
        shadow.feed(data)
        terminal.type(data)
        terminal.serve(0.005)
        sent += 1
    assert terminal.child.poll() is None, terminal.output[-3000:]
    terminal.type(b"\x1b[I")
    terminal.serve(1.2)  # whatever paste was open is over


def arm(terminal, keys=ENTER):
    since = len(terminal.output)
    terminal.type(keys)
    terminal.wait_for(" ARMED ", since)
    terminal.serve(0.1)


def is_disarmed(terminal):
    """What was drawn last says so."""
    return terminal.output.rfind(b" DISARMED ") > terminal.output.rfind(b" ARMED ")


def pass_ticks(terminal, run, ticks):
    """Serve until so many have passed and are written."""
    end_tick = last_tick(run) + ticks
    terminal.wait_until(lambda: last_tick(run) >= end_tick, f"{ticks} ticks")


def hold(terminal, run, press, release):
    """Press, keep silent for longer than two leases, release: again until a push has lasted. (On a machine that is
    busy for longer than a lease a hold may end early.)
    """
    end, before = time.monotonic() + DEADLINE_S, len(spans(run))
    while max((end - start for start, end in spans(run)[before:]), default=0) <= TIMES * 250:
        assert time.monotonic() < end, f"no hold outlives a lease: {spans(run)}"
        terminal.type(press)
        terminal.serve(TIMES * 0.35)
        terminal.type(release)
        pass_ticks(terminal, run, 500)


def test_key_releases_where_the_terminal_tells_them_and_what_becomes_of_a_held_key(opened, tmp_path):
    terminal, run = opened("-c", SLOWER, kitty=True), tmp_path / "run"
    arm(terminal)
    terminal.type(b"\x1b[13;1:2u" * 5)  # Enter is still down: that is no second press
    hold(terminal, run, W, W_UP)  # longer than any lease, and no repeat was sent

    terminal.type(b"\x1b[109u")  # m
    terminal.wait_for("forward, left")
    hold(terminal, run, b"\x1b[<0;17;16M", b"\x1b[<0;17;16m")  # the upper end of the pad, and no movement was sent
    terminal.type(b"\x1b[109u")
    since_tick = last_tick(run)

    longest_s = 0.0

    def hold_until(let_go):
        """Press, and after a moment let something else end it: the release never comes."""
        nonlocal longest_s
        began = time.monotonic()
        terminal.type(W)
        terminal.serve(0.05)
        let_go()
        longest_s = max(longest_s, time.monotonic() - began)

    hold_until(lambda: terminal.type(b"\x1b[122;5u"))  # ctrl+z
    terminal.wait_until(lambda: terminal.flags == [0], "the keyboard to be given back")
    terminal.serve(0.3)
    os.kill(terminal.child.pid, signal.SIGCONT)
    terminal.wait_until(lambda: terminal.flags == [0, 27], "the keyboard to be taken again")
    pass_ticks(terminal, run, TIMES * 500)

    hold_until(lambda: os.kill(terminal.child.pid, signal.SIGSTOP))
    time.sleep(0.4)
    os.kill(terminal.child.pid, signal.SIGCONT)
    pass_ticks(terminal, run, TIMES * 500)
    terminal.wait_until(lambda: terminal.flags[-1] == 27, "the keyboard to be taken again")
    assert terminal.flags == [0, 27], "taken once"

    if is_disarmed(terminal):  # this process was held up for a second
        arm(terminal)
    hold_until(lambda: setattr(terminal, "answers", False))  # the connection stalls
    terminal.wait_until(lambda: is_disarmed(terminal), "the robot to be disarmed")
    terminal.answers = True
    terminal.serve(0.1)
    os.kill(terminal.child.pid, signal.SIGTERM)
    assert terminal.ended() == 0
    assert terminal.flags == [0], "the keyboard is as it was"

    # The terminal's last answer before that is no older than 400 ms when it counts, and is worth a lease of 120; so
    # many times, and half as long as a silent keyboard is believed.
    pushed = [end - start for start, end in spans(run) if start > since_tick]
    assert max(pushed, default=0) < 1000 * longest_s + TIMES * 530, "suspended, stopped, stalled: it ends"
    assert stopped(run)


def test_without_releases_a_key_moves_for_its_lease_a_late_one_not_at_all_and_no_bytes_crash_the_app(opened, tmp_path):
    terminal, run = opened(), tmp_path / "run"
    arm(terminal, b"\r")
    while not spans(run):  # on a machine that is busy for longer than 400 ms it may have come too late
        terminal.type(b"w")
        pass_ticks(terminal, run, 1000)
    (nudge,) = spans(run)
    assert nudge[1] - nudge[0] <= 130
    terminal.answers = False
    terminal.serve(0.5)
    terminal.type(b"wwwwwwww")
    terminal.wait_for("not heard")
    terminal.type(b" ")
    terminal.wait_until(lambda: is_disarmed(terminal), "the robot to be disarmed")
    assert spans(run) == [nudge]
    terminal.answers = True
    type_anything(terminal, seed=1, rounds=150)
    terminal.type(b" ")
    os.kill(terminal.child.pid, signal.SIGHUP)
    assert terminal.ended() == 0
    assert b"Traceback" not in terminal.output
    assert stopped(run)


def test_no_bytes_crash_the_app_where_releases_are_told_and_a_closed_window_stops_the_robot(opened, tmp_path):
    terminal = opened(kitty=True)
    type_anything(terminal, seed=2, rounds=150)
    terminal.type(W)
    terminal.serve(0.05)
    terminal.vanish()
    terminal.ended()
    assert b"Traceback" not in terminal.output
    assert stopped(tmp_path / "run")


def test_what_is_written_past_textual_leaves_the_screen_as_textual_draws_it(opened):
    terminal = opened(size=(30, 100))
    terminal.screen = Screen(24, 80)
    terminal.resize(24, 80)
    terminal.wait_to_show("the keys", lambda screen: "quit" in screen.lines[-1])
    arm(terminal, b"\r")
    for keys in (b"www", b"2", b"w", b"3", b"4", b"?", b"?", b"1", b"x", b"\x1b[B"):
        terminal.type(keys)
        terminal.serve(0.3)
    terminal.wait_to_show("the faults", lambda screen: "nothing gets through" in "".join(screen.lines))
    terminal.type(b"\x1b")  # what comes behind it too soon makes another key of it
    terminal.wait_to_show("no faults", lambda screen: "nothing gets through" not in "".join(screen.lines))
    for keys in (b"qq", b"p"):
        terminal.type(keys)
        terminal.serve(0.3)

    def stands(screen):
        """Time stands, and nothing is said any more: not of a terminal that was slow to answer either."""
        return "PAUSED" in screen.lines[0] and "fork" in screen.lines[-1] and screen.lines[-2].startswith(" answer ")

    terminal.wait_to_show("a pause", stands)
    frames = terminal.questions + 2
    terminal.wait_until(lambda: terminal.questions >= frames, "the end of that picture")
    patched = [*map(list, terminal.screen.cells)]
    terminal.resize(30, 100)
    terminal.serve(0.5)
    terminal.screen = Screen(24, 80)
    terminal.resize(24, 80)
    terminal.wait_to_show("the same", lambda screen: screen.cells == patched)


def test_killed_outright_the_terminal_is_given_back_by_its_guardian(opened):
    terminal = opened(kitty=True)
    os.kill(terminal.child.pid, signal.SIGKILL)
    terminal.wait_until(lambda: terminal.flags == [0], "the keyboard to be given back")
    terminal.wait_until(lambda: terminal.output.endswith(b"\x1b[?25h\x1b[?1049l"), "cursor and screen to be given back")


def test_a_terminal_that_takes_nothing_does_not_block_the_bench(opened, tmp_path):
    terminal, run = opened(), tmp_path / "run"
    arm(terminal, b"\r")
    end, before_tick = time.monotonic() + DEADLINE_S, last_tick(run)
    while last_tick(run) < before_tick + 1000:  # nobody reads: the pty is full after some frames
        assert time.monotonic() < end, "the bench does not go on"
        time.sleep(0.05)
    os.kill(terminal.child.pid, signal.SIGTERM)
    while terminal.child.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    assert terminal.child.poll() is not None, "it waits for a terminal that takes nothing"
    assert stopped(run)
