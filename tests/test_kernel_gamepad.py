"""Gamepads of the kernel's own making, through its joystick nodes and evdev. `make gamepad` boots a kernel for them."""

import argparse
import os
import signal
from functools import partial

import patience
import pty_terminal
import pytest
from desk import M2006, Granted, pass_ticks
from virtual_pad import (
    EV_ABS,
    HAT,
    HAT_X,
    HAT_Y,
    KEY_A,
    KEY_Z,
    RX,
    RY,
    START,
    STICK,
    XPAD_AXES,
    XPAD_BUTTONS,
    A,
    B,
    Range,
    VirtualPad,
    X,
    Y,
    Z,
)  # fmt: skip

from bench.__main__ import main
from bench.check.reading import Recording
from bench.cli import drive as verb
from bench.config.gamepads import GamepadMap, PadAxis, load_gamepad_map
from bench.io.gamepad import PadEvent, open_gamepad
from bench.io.link import InlineLink
from bench.loop import simulated
from bench.screen.keyboard import Keyboard
from bench.screen.session import Session

DEADLINE_S = 300.0  # an emulated processor
until = partial(patience.until, deadline_s=DEADLINE_S)
FULL = -32768
"""Y and X of a stick that is pushed forward, to the left."""

pytestmark = [
    pytest.mark.gamepad,
    pytest.mark.skipif(
        not os.access("/dev/uinput", os.W_OK),
        reason="no /dev/uinput here to write to; `make gamepad` runs these under a kernel that makes input devices",
    ),
]


@pytest.fixture
def plug():
    made = []

    def plugged(*args, **options):
        made.append(VirtualPad(*args, **options))
        return made[-1]

    yield plugged
    for pad in made:
        pad.unplug()


@pytest.fixture
def evdev():
    return pytest.importorskip(
        "evdev", reason="evdev is not installed: pip install 'wheelbench[gamepad]', which takes a C compiler"
    )


@pytest.fixture(params=["js", "event"])
def kind(request):
    if request.param == "event":
        request.getfixturevalue("evdev")
    return request.param


def address(pad, kind):
    return ("evdev:" if kind == "event" else "") + pad.node(kind)


class Driven:
    """A base whose transmitter is in the hands of whoever holds the pad at `where`."""

    def __init__(self, where, layout=None):
        self.pad = open_gamepad(where)
        keyboard = Keyboard(M2006.rc, gamepad=(self.pad, layout or load_gamepad_map("standard")))
        self.session = Session(InlineLink(simulated(M2006), keyboard.inputs, Granted()), keyboard=keyboard)
        self.said = []
        self.frame()

    def frame(self):
        """One picture of the screen: 50 ms of the base."""
        pass_ticks(self.session, 50)
        if self.session.scene().notice not in self.said[-1:]:
            self.said.append(self.session.scene().notice)

    def arm(self, pad, button=START):
        pad.press(button)
        self.frame()
        self.frame()
        assert self.session.link.latest().armed

    def drives_only_from_rest(self, pad):
        """A stick that is pushed already does not count before it has been let go."""
        assert self.sticks == (0.0, 0.0, 0.0)
        pad.move(Y, 0)
        self.frame()
        pad.move(Y, FULL)
        self.frame()
        assert self.sticks[0] > 0.9

    @property
    def sticks(self):
        return self.session.link.latest().sticks

    @property
    def state(self):
        return self.session.scene().hands.source_state

    def close(self):
        self.pad.close()


@pytest.fixture
def drive():
    opened = []

    def driven(where, layout=None):
        opened.append(Driven(where, layout))
        return opened[-1]

    yield driven
    for one in opened:
        one.close()


def standing(events):
    """How axes and buttons stand after these events."""
    return {(event.is_axis, event.number): event.value for event in events}


ODD = {
    X: Range(0, 255, 15, 128), Y: Range(-127, 127, 0), Z: Range(0, 1023, 63, 512), RX: STICK,
    RY: Range(100, 4000, 200, 2050), 0x06: Range(-1000, 24, 0, -488), 0x09: Range(0, 1), HAT_X: HAT, HAT_Y: HAT,
}  # fmt: skip


def test_one_pad_by_either_way_is_the_same_pad(plug, evdev):
    """Odd ranges and dead zones, number for number as the kernel's joydev makes them: one map serves both."""
    pad = plug(ODD, (*XPAD_BUTTONS, 0x2C0, 0x101, 0x120))
    ways = [open_gamepad(address(pad, kind)) for kind in ("js", "event")]
    first, second = (standing(way.read()) for way in ways)
    assert first == second
    assert len(first) == len(ODD) + 14
    for code, (low, high, flat, _) in ODD.items():
        middle = (low + high) // 2
        edges = (middle - flat - 1, middle - flat, middle, middle + flat, middle + flat + 1)
        for value in (low, *edges, (middle + high) // 2, high, low + 1):
            pad.move(code, value)
            for known, way in zip((first, second), ways, strict=True):
                known |= standing(way.read())
            assert first == second, (code, value)
    for way in ways:
        way.close()


def test_its_sticks_hat_and_buttons_drive_through_the_front_door(plug, drive, kind):
    pad = plug()
    driven = drive(address(pad, kind))
    driven.arm(pad)
    for code, value, which, sense in ((Y, FULL, 0, 1), (Y, 32767, 0, -1), (X, FULL, 1, 1), (RX, 32767, 2, -1)):
        pad.move(code, value)
        driven.frame()
        assert driven.sticks[which] * sense > 0.9
        pad.move(code, 0)
        driven.frame()
        assert driven.sticks == (0.0, 0.0, 0.0)
    pad.move(Y, FULL)
    pad.press(B)
    driven.frame()
    driven.frame()
    assert not driven.session.link.latest().armed
    assert driven.sticks == (0.0, 0.0, 0.0)


def test_a_hat_may_be_the_stick(plug, drive, kind):
    pad = plug()
    driven = drive(address(pad, kind), GamepadMap("hat", PadAxis(7, True), PadAxis(6, True), PadAxis(3), arm=7, stop=1))
    driven.arm(pad)
    pad.report((EV_ABS, HAT_Y, -1), (EV_ABS, HAT_X, 1))
    driven.frame()
    assert driven.sticks[0] > 0.9
    assert driven.sticks[1] < -0.9


def test_pulled_out_while_it_drives_it_stops_and_put_back_it_drives_only_from_rest(plug, drive, kind):
    pad = plug()
    where = address(pad, kind)
    driven = drive(where)
    driven.arm(pad)
    pad.move(Y, FULL)
    driven.frame()
    assert driven.sticks[0] > 0.9
    pad.unplug()
    driven.frame()
    assert driven.sticks == (0.0, 0.0, 0.0)
    assert "not there" in driven.state
    assert "not there" in driven.said[-1]
    again = plug({**XPAD_AXES, Y: STICK._replace(first=FULL)})
    assert address(again, kind) == where
    until(lambda: not driven.pad.lost, driven.frame)
    driven.frame()
    assert driven.said[-1].endswith("there")
    assert driven.state == "let its sticks go first"
    driven.drives_only_from_rest(again)


def test_of_two_pads_each_drives_its_own(plug, drive, kind):
    pads = plug(name="One"), plug(name="Other")
    bases = [drive(address(pad, kind)) for pad in pads]
    for pad, driven in zip(pads, bases, strict=True):
        driven.arm(pad)
    pads[1].move(X, FULL)
    for driven in bases:
        driven.frame()
    assert bases[0].sticks == (0.0, 0.0, 0.0)
    assert bases[1].sticks[1] > 0.9
    pads[1].unplug()
    pads[0].move(Y, FULL)
    for driven in bases:
        driven.frame()
    assert bases[0].sticks[0] > 0.9
    assert bases[1].sticks == (0.0, 0.0, 0.0)


def test_where_the_first_of_two_is_pulled_out_the_other_is_named_and_drives_only_from_rest(plug, drive):
    first, other = plug(name="One"), plug(name="Other")
    driven = drive("auto")
    driven.arm(first)
    first.move(Y, FULL)
    other.move(Y, FULL)
    driven.frame()
    assert driven.sticks[0] > 0.9
    first.unplug()
    driven.frame()
    assert driven.sticks == (0.0, 0.0, 0.0)
    assert "not there" in driven.said[-1]
    until(lambda: not driven.pad.lost, driven.frame)
    driven.frame()
    assert driven.said[-1] == f"gamepad {other.node('js')} (Other): there"
    driven.drives_only_from_rest(other)


def test_one_that_may_not_be_read_says_so_and_is_taken_once_it_may(plug, drive, kind):
    pad = plug()
    os.chmod(pad.node(kind), 0o600)
    os.seteuid(65534)  # root may read anything
    try:
        driven = drive(address(pad, kind))
        assert driven.state == "you may not read it; docs/driving.md has the udev rule"
    finally:
        os.seteuid(0)
    os.chmod(pad.node(kind), 0o644)
    os.seteuid(65534)
    try:
        until(lambda: not driven.pad.lost, driven.frame)
    finally:
        os.seteuid(0)
    driven.arm(pad)
    pad.move(Y, FULL)
    driven.frame()
    assert driven.sticks[0] > 0.9


def test_axes_that_have_not_spoken_yet_do_not_drive(plug, drive, kind):
    """A driver tells changes alone: until one comes, the kernel says 0, and of 0 to 255 that is a stick pushed away."""
    byte = Range(0, 255, 15)
    pad = plug({X: byte, Y: byte, RX: byte, RY: byte, HAT_X: HAT, HAT_Y: HAT})
    driven = drive(
        address(pad, kind), GamepadMap("byte", PadAxis(1, True), PadAxis(0, True), PadAxis(2, True), arm=7, stop=1)
    )
    assert driven.sticks == (0.0, 0.0, 0.0)
    assert driven.state == "let its sticks go first"
    pad.report(*((EV_ABS, code, 128) for code in (X, Y, RX, RY)))
    driven.frame()
    driven.arm(pad)
    pad.move(Y, 0)
    driven.frame()
    assert driven.sticks[0] > 0.9
    for _ in range(5):
        pad.report((EV_ABS, Y, 0))  # no change: the kernel says nothing
        driven.frame()
        assert driven.sticks[0] > 0.9, "held is held"


def test_more_than_the_kernel_keeps_between_two_pictures(plug, drive, kind):
    """A pad that reports a thousand times a second, whose stick is let go in what the kernel drops."""
    pad = plug()
    driven = drive(address(pad, kind))
    driven.arm(pad)
    pad.move(Y, FULL)
    driven.frame()
    assert driven.sticks[0] > 0.9
    pad.report((EV_ABS, Y, 0))
    for count in range(2000):
        pad.report((EV_ABS, Z, count % 250), (EV_ABS, RY, -10_000 - count))
    driven.frame()
    assert driven.sticks == (0.0, 0.0, 0.0)
    pad.move(Y, FULL)
    for count in range(20):
        pad.report((EV_ABS, Z, count % 250 + 1), (EV_ABS, RY, count))
    pad.move(Y, 0)
    driven.frame()
    assert driven.sticks == (0.0, 0.0, 0.0), "all that is there is taken at once"


def test_a_desk_full_of_buttons_is_whole_at_first_sight(plug, drive, kind):
    """61 buttons are told before the axes: a stick that is held is not taken for one at rest that was not told yet."""
    joystick, pad_buttons, happy = range(0x120, 0x130), range(0x130, 0x13F), range(0x2C0, 0x2C0 + 30)
    pad = plug({**XPAD_AXES, RX: STICK._replace(first=30_000)}, (*joystick, *pad_buttons, *happy))
    driven = drive(address(pad, kind), GamepadMap("desk", PadAxis(1), PadAxis(0), PadAxis(3), arm=7, stop=1))
    assert driven.state == "let its sticks go first"
    for _ in range(5):
        driven.frame()
        assert driven.sticks == (0.0, 0.0, 0.0)


def test_devices_that_are_no_gamepads_are_told(plug, drive, evdev):
    keyboard = plug({}, range(KEY_A, KEY_Z), name="Keys")
    assert [name.rstrip("0123456789") for name in keyboard.nodes()] == ["event"], "joydev makes no node of it"
    assert "no gamepad" in drive(f"evdev:{keyboard.node('event')}").state
    assert "no gamepad" in drive(keyboard.node("event")).state
    assert "no gamepad" in drive("/dev/input/mice").state
    assert "no gamepad" in drive("evdev:/dev/input/mice").state
    assert "no gamepad" in drive("evdev:/dev/null").state
    assert "no gamepad" in drive("/dev/null").state
    assert "plug it in" in drive("/dev/input/js31").state


def test_what_the_map_names_and_the_pad_has_not_is_told(plug, drive, kind):
    pad = plug({X: STICK, Y: STICK}, (A, B))
    driven = drive(address(pad, kind))
    assert driven.state == (
        "it has no axis 3 (turn), no button 7 (arm), no button 3 (field_centric); another --gamepad-map may fit"
    )


def test_a_real_event_device_through_evdev(evdev):
    codes = evdev.ecodes
    info = evdev.AbsInfo(0, -32768, 32767, 0, 0, 0)
    abilities = {codes.EV_ABS: [(code, info) for code in (0, 1, 3, 4)], codes.EV_KEY: [codes.BTN_A, codes.BTN_START]}
    with evdev.UInput(abilities, name="wheelbench test") as made:
        pad = open_gamepad(f"evdev:{made.device.path}")
        pad.read()
        made.write(codes.EV_ABS, 1, -32768)
        made.syn()
        assert PadEvent(True, 1, -1.0) in pad.read()
    pad.read()
    assert pad.lost


def replayed(run, capsys):
    """That `wheelbench replay` makes the same of the recorded inputs, byte for byte."""
    status = main(["replay", str(run)])
    said = capsys.readouterr().out
    assert (status, "identical" in said) == (0, True), said


def test_a_drive_by_it_is_recorded_stops_where_it_was_pulled_out_and_replays(plug, kind, tmp_path, monkeypatch, capsys):
    """The bench of `wheelbench drive --gamepad --record`, whose time here passes as it is granted."""
    monkeypatch.setattr("bench.io.clock.WallPacer", Granted)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    pad, run = plug(), tmp_path / "run"
    parser = argparse.ArgumentParser()
    verb.add_arguments(parser)
    session = verb._session(parser.parse_args(["--gamepad", address(pad, kind), "--record", str(run)]))

    def frames(count):
        for _ in range(count):
            pass_ticks(session, 50)

    frames(2)
    pad.press(START)
    frames(4)
    pad.move(Y, FULL)
    frames(12)
    assert session.link.latest().twist.vx_mps > 0.2
    pulled_tick = session.link.bench.now_tick
    pad.unplug()
    frames(24)
    session.leave(patience=False)
    recording = Recording.open(run)
    assert recording.complete
    commands = {tick: dict(sent)[0x200] for tick, sent in recording.commands.items()}
    assert any(commands[pulled_tick - 1]), "it drove"
    assert not any(commands[recording.ticks - 1]), "no current is asked for"
    column = recording.state_columns.index("vx_mps")
    assert max(abs(row[column]) for tick, row in recording.state.items() if tick > pulled_tick + 1000) < 0.01
    replayed(run, capsys)


def test_the_dashboard_itself_says_that_it_has_gone_and_come_back(plug, tmp_path, monkeypatch, capsys):
    """In a terminal, by the first node that there is. An emulated processor is too slow to prove a terminal alive, so
    sticks stay at rest; the button that arms counts, and what is told.
    """
    monkeypatch.setattr(pty_terminal, "DEADLINE_S", DEADLINE_S)
    run, pad = tmp_path / "run", plug()
    terminal = pty_terminal.PtyTerminal(tmp_path, "-m", "bench", "drive", "--gamepad", "--record", run)

    def arm():
        pad.press(START)
        terminal.serve(3.0)

    try:
        terminal.wait_for("not armed since boot")
        until(lambda: b" ARMED " in terminal.output, arm)
        pad.unplug()
        terminal.wait_until(lambda: "gamepad: it is not there" in shown(terminal), "the loss to be told")
        plug({**XPAD_AXES, Y: STICK._replace(first=FULL)})
        terminal.wait_until(lambda: "gamepad: let its sticks go" in shown(terminal), "the pad to be taken again")
        os.kill(terminal.child.pid, signal.SIGTERM)
        assert terminal.ended() == 0
    finally:
        terminal.close()
    replayed(run, capsys)


def shown(terminal):
    """What stands on its screen."""
    return "\n".join("".join(cell for cell, _ in row) for row in pty_terminal.cells(terminal.output, 24, 80))
