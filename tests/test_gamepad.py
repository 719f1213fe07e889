"""A gamepad from its bytes to the robot: real joystick events through a FIFO in the kernel node's place."""

import os
import struct
import subprocess
import sys

import pytest
from desk import M2006, Granted, pass_ticks

from bench.config import load_robot
from bench.config.gamepads import GAMEPADS_DIR, GamepadMap, PadAxis, load_gamepad_map
from bench.config.table import ConfigError
from bench.errors import UsageError
from bench.io import gamepad as gamepad_module
from bench.io.gamepad import JoystickNode, PadEvent, joydev_buttons, joystick_events, open_gamepad, scaled
from bench.io.link import InlineLink
from bench.loop import simulated
from bench.rc.transmitter import Sticks
from bench.screen.gamepad_sticks import GamepadSticks
from bench.screen.keyboard import Keyboard
from bench.screen.session import Session

ARM, STOP, FORWARD, LEFT, TURN = 7, 1, 1, 0, 3


def js(kind, number, value, time_ms=0):
    """struct js_event: __u32 time; __s16 value; __u8 type; __u8 number."""
    return struct.pack("=IhBB", time_ms, value, kind, number)


AT_REST = b"".join(js(0x82, axis, 0) for axis in range(8)) + b"".join(js(0x81, button, 0) for button in range(11))


class Pad:
    """The other end of the node."""

    def __init__(self, path):
        self.path = path
        self.writer = None

    def plug(self, first=AT_REST):
        os.mkfifo(self.path)
        self.writer = os.open(self.path, os.O_RDWR)  # a FIFO opens for writing only where somebody reads
        self.send(first)

    def send(self, data):
        os.write(self.writer, data)

    def axis(self, number, value):
        self.send(js(0x02, number, value))

    def press(self, button):
        self.send(js(0x01, button, 1) + js(0x01, button, 0))

    def unplug(self):
        os.unlink(self.path)
        os.close(self.writer)
        self.writer = None


@pytest.fixture
def pad(tmp_path):
    made = Pad(tmp_path / "js0")
    yield made
    if made.writer is not None:
        os.close(made.writer)


def driving(pad, robot=M2006):
    node = JoystickNode(str(pad.path))
    node.revive()
    keyboard = Keyboard(robot.rc, gamepad=(node, load_gamepad_map("standard")))
    session = Session(InlineLink(simulated(robot), keyboard.inputs, Granted()), keyboard=keyboard)
    pass_ticks(session, 50)
    return session


def armed(pad):
    pad.plug()
    session = driving(pad)
    pad.press(ARM)
    pass_ticks(session, 50)
    pass_ticks(session, 50)
    assert session.link.latest().armed
    return session


def sticks(session):
    return session.link.latest().sticks


def test_events_as_the_kernel_lays_them_out():
    assert joystick_events(bytes.fromhex("10270000 0180 82 01  11270000 0100 01 07  12270000 ff7f 02 03")) == [
        PadEvent(True, 1, -1.0), PadEvent(False, 7, 1.0), PadEvent(True, 3, 1.0),
    ]  # fmt: skip
    assert joystick_events(js(0x04, 1, 5)) == [], "no such type"


def test_buttons_are_numbered_as_joydev_numbers_them():
    """An Xbox pad: A B X Y, shoulders, back, start, guide, thumbs are 0 to 10 on its joystick node."""
    codes = [0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13A, 0x13B, 0x13C, 0x13D, 0x13E]
    assert joydev_buttons(reversed(codes)) == {code: number for number, code in enumerate(codes)}
    assert joydev_buttons([0x100, 0x120, 0x1E]) == {0x120: 0, 0x100: 1}


def test_an_axis_over_its_own_range():
    assert [scaled(value, 0, 255) for value in (0, 255)] == [-1.0, 1.0]
    assert scaled(0, -32768, 32767) == pytest.approx(0.0, abs=1e-4)
    assert scaled(5, 3, 3) == 0.0


def test_an_axis_rests_in_the_dead_zone_that_its_driver_tells():
    """0 to 255 with 15, as hid-input tells of any stick: joydev's zero is 112 to 142, its ends 97 beyond."""
    assert [scaled(value, 0, 255, 15) for value in (0, 15, 112, 127, 142, 239, 255)] == [-1, -1, 0, 0, 0, 1, 1]
    assert scaled(190, 0, 255, 15) == pytest.approx(48 / 97, abs=1e-3)
    assert scaled(100, 0, 255, 64) == 0.0, "nothing is left beside it"
    # joydev_correct(): 2**29 // 97 a step beyond the dead zone, cut to 14 bits less.
    raw = [round(scaled(value, 0, 255, 15) * 32767) for value in (100, 111, 113, 141, 143, 154)]
    assert raw == [-4054, -338, 0, 0, 337, 4053]


def test_its_sticks_and_buttons_drive_through_the_front_door(pad):
    session = armed(pad)
    for axis, value, which, sense in (
        (FORWARD, -32767, 0, 1), (FORWARD, 32767, 0, -1), (LEFT, -32767, 1, 1), (TURN, 32767, 2, -1),
    ):  # fmt: skip
        pad.axis(axis, value)
        pass_ticks(session, 20)
        assert sticks(session)[which] * sense > 0.9
        assert session.link.wires.rc is not None
        pad.axis(axis, 0)
        pass_ticks(session, 20)
        assert sticks(session) == (0.0, 0.0, 0.0)
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 20)
    pad.press(STOP)
    pass_ticks(session, 30)
    assert not session.link.latest().armed


def test_pulled_out_it_stops_and_put_back_it_drives_only_from_rest(pad, monkeypatch):
    session = armed(pad)
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 50)
    assert sticks(session)[0] > 0.9
    pad.unplug()
    pass_ticks(session, 50)  # one frame of the screen
    assert sticks(session) == (0.0, 0.0, 0.0), "zero within 150 ms"
    assert "not there" in session.scene().hands.source_state
    pad.plug(AT_REST + js(0x82, FORWARD, -32767))
    session.keyboard.pad._retry_ns = 0
    for _ in range(3):
        pass_ticks(session, 50)
    assert sticks(session) == (0.0, 0.0, 0.0)
    assert session.scene().hands.source_state == "let its sticks go first"
    pad.axis(FORWARD, 0)
    pass_ticks(session, 20)
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 20)
    assert sticks(session)[0] > 0.9


def test_out_of_focus_it_has_to_be_let_go_first(pad):
    session = armed(pad)
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 50)
    session.hands_off()
    pass_ticks(session, 50)
    assert sticks(session) == (0.0, 0.0, 0.0)
    pad.axis(FORWARD, -20000)
    pass_ticks(session, 50)
    assert sticks(session) == (0.0, 0.0, 0.0)


def test_space_stops_it_and_motion_keys_say_who_drives(pad):
    session = armed(pad)
    session.key("w")
    assert "the gamepad has the sticks" in session.scene().notice
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 20)
    session.key("space")
    pass_ticks(session, 75)
    assert not session.link.latest().armed


def test_i_gives_the_sticks_to_the_keys(pad):
    session = armed(pad)
    pad.axis(FORWARD, -32767)
    pass_ticks(session, 20)
    session.key("i")
    pass_ticks(session, 20)
    assert sticks(session) == (0.0, 0.0, 0.0)
    session.key("w")
    pass_ticks(session, 20)
    assert sticks(session)[0] > 0.4


def test_events_cut_in_two_are_whole(pad):
    pad.plug(b"")
    node = JoystickNode(str(pad.path))
    assert node.revive()
    event = js(0x02, 1, -32767)
    pad.send(event[:3])
    assert node.read() == []
    pad.send(event[3:] + event[:7])
    assert node.read() == [PadEvent(True, 1, -1.0)]
    node.close()


LAYOUT = GamepadMap("x", PadAxis(1, True), PadAxis(0), PadAxis(2), arm=0, stop=1, hold=5, dead_band=0.2)


def test_dead_band_and_hold_button():
    pad = GamepadSticks(LAYOUT)
    pad.feed([PadEvent(True, 0, 0.1), PadEvent(False, 5, 0.0), PadEvent(False, 5, 1.0)])
    assert pad.sticks() == Sticks()
    for value, expected in ((0.2, 0.0), (0.6, 0.5), (1.0, 1.0), (-0.6, -0.5)):
        pad.feed([PadEvent(True, 0, value), PadEvent(True, 1, value)])
        assert pad.sticks().left == pytest.approx(expected)
        assert pad.sticks().forward == pytest.approx(-expected)
    pad.feed([PadEvent(False, 5, 0.0)])
    assert pad.sticks() == Sticks()


def test_what_the_map_names_and_a_pad_has_not():
    pad = GamepadSticks(LAYOUT)
    assert pad.lacking(3, 6) == pad.lacking(None, None) == ""
    assert pad.lacking(2, 1) == (
        "it has no axis 2 (turn), no button 1 (stop), no button 5 (hold); another --gamepad-map may fit"
    )


def test_a_button_that_is_pressed_when_the_pad_is_found_is_no_press():
    pad = GamepadSticks(LAYOUT)
    assert pad.feed([PadEvent(False, 0, 1.0)]) == []
    assert pad.feed([PadEvent(False, 0, 0.0), PadEvent(False, 0, 1.0)]) == ["enter"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("arm = 7", "arm = 1"), "buttons: one button cannot do two things"),
        (("arm = 7", "arm = 700"), "buttons.arm: expected 0 to 511"),
        (("axis = 3", "axis = 99"), "turn.axis: expected 0 to 63"),
        (("dead_band = 0.12", "dead_band = 0.9"), "dead_band: expected 0 to 0.5"),
        (("arm = 7", "armed = 7"), "buttons.arm: is missing; is armed meant to be it?"),
        (("stop = 1", "stop = 1\nrumble = 3"), "rumble"),
    ],
)
def test_a_map_that_cannot_be_right_is_refused_by_file_and_key(tmp_path, change, words):
    path = tmp_path / "mine.toml"
    path.write_text((GAMEPADS_DIR / "standard.toml").read_text().replace(*change))
    with pytest.raises(ConfigError) as refused:
        load_gamepad_map(path)
    assert str(path) in str(refused.value)
    assert words in str(refused.value)


def test_unknown_names_and_addresses_are_one_sentence():
    with pytest.raises(ConfigError, match="did you mean standard"):
        load_gamepad_map("standart")
    with pytest.raises(UsageError, match="expected auto, /dev/input/js0 or evdev:"):
        open_gamepad("js0")


def test_a_device_that_is_no_joystick_node_is_told_and_let_go():
    open_files = os.listdir("/proc/self/fd")
    assert open_gamepad("/dev/null").lost.startswith("it is no gamepad: no joystick node; ")
    assert os.listdir("/proc/self/fd") == open_files


def test_the_first_of_eleven_nodes_is_the_one_of_the_lowest_number(pad, tmp_path, monkeypatch):
    """js10 comes behind js2. The nodes are elsewhere here, so the search for them is what it would find."""
    monkeypatch.setattr(gamepad_module.glob, "glob", lambda _: [str(tmp_path / name) for name in ("js10", "js2")])
    pad.path = tmp_path / "js2"
    pad.plug()
    first = open_gamepad("auto")
    assert not first.lost
    first.close()


def test_without_evdev_there_is_a_sentence_with_what_to_install():
    code = "import sys; sys.modules['evdev'] = None\nfrom bench.io.gamepad import open_gamepad\n" \
        "from bench.errors import SurroundingsError\n" \
        "try: open_gamepad('evdev:/dev/input/event0')\nexcept SurroundingsError as error: print(error)"  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'wheelbench[gamepad]'" in done.stdout


def test_robots_without_rc_are_told_apart():
    assert load_robot("slamware-b").rc is None
