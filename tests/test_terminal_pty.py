"""The real app on a real pty: key releases, hostile bytes, a terminal that stalls, stops, or goes away."""

import copy
import os
import random
import re
import signal
import time

import pytest
from pty_terminal import DEADLINE_S, PtyTerminal, cells
from test_terminal_input import NOISE, VECTORS

from bench.check.reading import Recording
from bench.screen.terminal_input import InputDecoder, Key

ENTER, W = b"\x1b[13;1:1u\x1b[13;1:3u", b"\x1b[119;1:1;119u"
W_UP = b"\x1b[119;1:3u"


@pytest.fixture
def opened(tmp_path):
    terminals = []

    def start(**options):
        terminal = PtyTerminal(tmp_path, "-m", "bench", "drive", "--record", tmp_path / "run", **options)
        terminals.append(terminal)
        terminal.wait_for("not armed since boot")
        terminal.serve(0.2)
        return terminal

    yield start
    for terminal in terminals:
        terminal.close()


def forward_stick(run):
    """(tick in ms, raw forward channel) of every RC frame: uart12, channel 2, middle 2048, below is forward."""
    found = re.findall(r"\((\d+)\.(\d{3})\d*\) \S+ > (.*)", (run / "rc.log").read_text())
    return [(int(s) * 1000 + int(ms), int("".join(data.split()[5:7]), 16)) for s, ms, data in found]


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


def test_key_releases_where_the_terminal_tells_them_and_what_becomes_of_a_held_key(opened, tmp_path):
    terminal = opened(kitty=True)
    assert terminal.flags == [0, 27]
    arm(terminal)
    terminal.type(b"\x1b[13;1:2u" * 5)  # Enter is still down: that is no second press
    for _ in range(3):  # on a machine that is busy for longer than a lease, a hold may end early
        terminal.type(W)
        terminal.serve(0.5)
        terminal.type(W_UP)
        terminal.serve(0.2)

    terminal.type(b"\x1b[109u")  # m
    terminal.wait_for("forward, left")
    for _ in range(3):  # on the upper end of the pad, and held still
        terminal.type(b"\x1b[<0;17;16M")
        terminal.serve(0.5)
        terminal.type(b"\x1b[<0;17;16m")
        terminal.serve(0.2)
    terminal.type(b"\x1b[109u")

    terminal.type(W)
    terminal.serve(0.1)
    terminal.type(b"\x1b[122;5u")  # ctrl+z
    terminal.wait_until(lambda: terminal.flags == [0], "the keyboard to be given back")
    terminal.serve(0.3)
    os.kill(terminal.child.pid, signal.SIGCONT)
    terminal.wait_until(lambda: terminal.flags == [0, 27], "the keyboard to be taken again")
    terminal.serve(0.3)

    terminal.type(W)
    terminal.serve(0.1)
    os.kill(terminal.child.pid, signal.SIGSTOP)
    time.sleep(0.4)
    os.kill(terminal.child.pid, signal.SIGCONT)
    terminal.serve(0.5)
    assert terminal.flags == [0, 27], "taken once"

    terminal.type(W)
    terminal.serve(0.2)
    terminal.answers = False  # the connection stalls: the release will never come
    terminal.wait_for(" DISARMED ", len(terminal.output))
    terminal.answers = True
    terminal.serve(0.1)
    os.kill(terminal.child.pid, signal.SIGTERM)
    assert terminal.ended() == 0
    assert terminal.flags == [0], "the keyboard is as it was"

    pushed = [end - start for start, end in spans(tmp_path / "run")]
    assert max(pushed[:3]) > 250, "longer than any lease, and no repeat was sent"
    assert max(pushed[3:6]) > 250, "the mouse: no movement was sent"
    assert max(pushed[6:]) < 600, "suspended, stopped, stalled: it ends"
    assert stopped(tmp_path / "run")


def test_without_releases_a_key_moves_for_its_lease_a_late_one_not_at_all_and_no_bytes_crash_the_app(opened, tmp_path):
    terminal = opened()
    arm(terminal, b"\r")
    terminal.type(b"w")
    terminal.serve(0.3)
    terminal.answers = False
    terminal.serve(0.5)
    terminal.type(b"wwwwwwww")
    terminal.wait_for("not heard")
    since = len(terminal.output)
    terminal.type(b" ")
    terminal.wait_for(" DISARMED ", since)
    terminal.answers = True
    type_anything(terminal, seed=1, rounds=150)
    terminal.type(b" ")
    os.kill(terminal.child.pid, signal.SIGHUP)
    assert terminal.ended() == 0
    assert b"Traceback" not in terminal.output
    assert stopped(tmp_path / "run")
    first, *_ = spans(tmp_path / "run")
    assert first[1] - first[0] <= 130


def test_no_bytes_crash_the_app_where_releases_are_told_and_a_closed_window_stops_the_robot(opened, tmp_path):
    terminal = opened(kitty=True)
    type_anything(terminal, seed=2, rounds=150)
    terminal.type(W)
    terminal.serve(0.05)
    terminal.vanish()
    terminal.ended()
    assert b"Traceback" not in terminal.output
    assert stopped(tmp_path / "run")


def rows(screen):
    return "\n".join("".join(sign for sign, _ in row) for row in screen)


def screen_when(terminal, since, condition):
    """What the output since then shows, once it is so."""
    end = time.monotonic() + DEADLINE_S
    while not condition(screen := cells(terminal.output[since:], 24, 80)):
        assert time.monotonic() < end, rows(screen)
        terminal.serve(0.3)
    return screen


def test_what_is_written_past_textual_leaves_the_screen_as_textual_draws_it(opened):
    terminal = opened(size=(30, 100))
    since = len(terminal.output)
    terminal.resize(24, 80)
    screen_when(terminal, since, lambda screen: "quit" in rows(screen[-1:]))
    arm(terminal, b"\r")
    for keys in (b"www", b"2", b"w", b"3", b"4", b"?", b"?", b"1", b"x", b"\x1b[B", b"\x1b", b"qq", b"p"):
        terminal.type(keys)
        terminal.serve(0.3)
    # Time stands, and nothing is said any more.
    patched = screen_when(terminal, since, lambda screen: "PAUSED" in rows(screen[:1]) and "fork" in rows(screen[-1:]))
    terminal.resize(30, 100)
    terminal.serve(0.5)
    since = len(terminal.output)
    terminal.resize(24, 80)
    screen_when(terminal, since, lambda screen: screen == patched)


def test_killed_outright_the_terminal_is_given_back_by_its_guardian(opened):
    terminal = opened(kitty=True)
    assert terminal.flags == [0, 27]
    os.kill(terminal.child.pid, signal.SIGKILL)
    terminal.wait_until(lambda: terminal.flags == [0], "the keyboard to be given back")
    terminal.wait_until(lambda: terminal.output.endswith(b"\x1b[?25h\x1b[?1049l"), "cursor and screen to be given back")


def test_a_terminal_that_takes_nothing_does_not_block_the_bench(opened, tmp_path):
    terminal = opened()
    arm(terminal, b"\r")
    time.sleep(2.0)  # nobody reads: the pty is full after some frames
    os.kill(terminal.child.pid, signal.SIGTERM)
    end = time.monotonic() + 20
    while terminal.child.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    assert terminal.child.poll() is not None, "it waits for a terminal that takes nothing"
    assert stopped(tmp_path / "run")
    assert Recording.open(tmp_path / "run").ticks > 1000, "the bench went on meanwhile"
