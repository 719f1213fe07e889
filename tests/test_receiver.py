"""A real receiver's bytes over a real pty: in by the front door as they came, lost by silence, picked up again."""

import os
import pty
import tty
from dataclasses import replace

import pytest
from desk import M2006, Granted, pass_ticks

from bench import rc_decode
from bench.config import load_profile
from bench.errors import SurroundingsError
from bench.io.link import InlineLink
from bench.io.receiver import open_receiver
from bench.loop import simulated
from bench.rc.transmitter import AT_REST, Sticks, Transmitter
from bench.screen.keyboard import Keyboard
from bench.screen.session import Session

PROFILES = {
    "uart12": "uart12", "sbus": "frsky-sbus", "dbus": "dr16", "ibus": "flysky", "crsf": "elrs",
}  # fmt: skip


class Radio:
    """The other end of the line, behind a link with a steady name, as udev gives one."""

    def __init__(self, path, profile=M2006.rc):
        self.path = path
        self.transmitter = Transmitter(profile)
        self.sent = b""
        self.master = None
        self.plug()

    def plug(self):
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        if os.path.lexists(self.path):
            os.unlink(self.path)
        os.symlink(os.ttyname(slave), self.path)
        self.slave = slave

    def unplug(self):
        os.close(self.master)
        os.close(self.slave)
        self.master = None

    def send(self, sticks=AT_REST, frames=1):
        profile = self.transmitter.profile
        self.send_bytes(rc_decode.encode(profile.protocol, self.transmitter.channels(sticks)) * frames)

    def send_bytes(self, data):
        os.write(self.master, data)
        self.sent += data


class Heard:
    """What came in by the front door."""

    def __init__(self):
        self.data = b""

    def add(self, out):
        self.data += out.rc


@pytest.fixture
def radio(tmp_path):
    made = Radio(tmp_path / "rc")
    yield made
    if made.master is not None:
        made.unplug()


@pytest.fixture
def session(radio):
    receiver = open_receiver(f"serial:{radio.path}", M2006.rc.protocol)
    keyboard = Keyboard(M2006.rc, receiver=receiver)
    heard = Heard()
    made = Session(InlineLink(simulated(M2006), keyboard.inputs, Granted(), takers=[heard]), keyboard=keyboard)
    made.heard = heard
    yield made
    keyboard.close()


def listen(session, radio, ms, sticks=AT_REST):
    """So long the radio sends a frame every 10 ms; the screen draws 20 times a second, and waits for what is sent."""
    for _ in range(ms // 50):
        radio.send(sticks, 5)
        pass_ticks(session, 50)


def arm(session, radio):
    listen(session, radio, 100)
    listen(session, radio, 100, Sticks(aux1=True))
    listen(session, radio, 100)
    assert session.link.latest().armed


def test_its_bytes_drive_and_are_those_that_it_sent(session, radio):
    arm(session, radio)
    listen(session, radio, 200, Sticks(forward=0.7))
    assert session.link.latest().sticks[0] > 0.5
    pass_ticks(session, 50)
    assert session.heard.data == radio.sent
    assert session.link.latest().rc_noise_bytes == 0
    session.key("w")
    assert "the receiver has the sticks" in session.scene().notice
    assert not session.scene().hands.arms


def test_what_came_while_ticks_passed_is_given_on_over_as_many(session, radio):
    listen(session, radio, 200)
    frames = session.link.latest().rc_frames
    radio.send(frames=5)
    for _ in range(5):
        pass_ticks(session, 10)
        frames, before = session.link.latest().rc_frames, frames
        assert frames - before in (1, 2), "a frame every 10 ms, as it was sent"


@pytest.mark.parametrize("protocol", ["uart12", "sbus", "dbus", "ibus", "crsf"])
def test_every_byte_is_given_on_in_its_order_and_no_frame_is_cut(tmp_path, protocol):
    robot = replace(M2006, rc=load_profile(PROFILES[protocol]))
    line = Radio(tmp_path / protocol, robot.rc)
    receiver = open_receiver(f"serial:{line.path}", protocol)
    out = []
    for tick in range(0, 1000, 50):
        line.send(Sticks(forward=0.3), 5)
        line.send_bytes(b"\x00\xff" if tick == 500 else b"")
        out += [receiver.read(tick + ms) for ms in range(50)]
    out += [receiver.read(1000 + ms) for ms in range(120)]
    assert b"".join(out) == line.sent
    if protocol != "dbus":  # it has no sync byte: a decoder waits for what follows
        whole = rc_decode.encode(protocol, line.transmitter.channels(Sticks(forward=0.3)))
        assert sum(data == whole for data in out) > 90
    receiver.close()
    line.unplug()


def test_noise_without_end_is_given_on_and_what_lay_there_for_long_is_not(radio):
    receiver = open_receiver(f"serial:{radio.path}", "uart12")
    receiver.read(0)
    radio.send_bytes(bytes(100))
    assert b"".join(receiver.read(tick) for tick in range(1, 200)) == bytes(100)
    radio.send(frames=300)
    assert len(b"".join(receiver.read(tick) for tick in range(200, 400))) <= 51 * 12
    receiver.close()


def test_read_every_tick_it_is_given_on_at_once(radio):
    receiver = open_receiver(f"serial:{radio.path}", "uart12")
    for tick in range(1, 5):
        radio.send()
        assert receiver.read(tick) == radio.sent[-12:]
    receiver.close()


def test_pulled_out_the_link_is_lost_and_put_back_it_is_picked_up(session, radio):
    arm(session, radio)
    listen(session, radio, 200, Sticks(forward=0.7))
    radio.unplug()
    for _ in range(3):
        pass_ticks(session, 50)
    assert "waiting for it" in session.scene().notice
    assert session.link.latest().sticks == (0.0, 0.0, 0.0) or session.link.latest().link != "live"
    assert session.link.bench.base.wanted_radps == pytest.approx([0.0, 0.0, 0.0]), "150 ms"
    for _ in range(10):
        pass_ticks(session, 50)
    assert not session.link.latest().armed
    assert session.scene().hands.source_state
    radio.plug()
    session.keyboard.receiver.port._retry_ns = 0
    pass_ticks(session, 50)
    assert "there again" in session.scene().notice
    listen(session, radio, 200, Sticks(forward=0.7))
    assert session.link.latest().link == "live"
    assert not session.link.latest().armed, "only a deliberate act arms again"


def test_space_cuts_it_off_and_enter_lets_it_through_again(session, radio):
    arm(session, radio)
    listen(session, radio, 100, Sticks(forward=0.7))
    session.key("space")
    listen(session, radio, 150, Sticks(forward=0.7))
    assert session.link.bench.base.wanted_radps == pytest.approx([0.0, 0.0, 0.0])
    listen(session, radio, 500, Sticks(forward=0.7))
    assert not session.link.latest().armed
    session.key("enter")
    listen(session, radio, 200, Sticks(forward=0.7))
    assert session.link.latest().link == "live"
    assert not session.link.latest().armed


def test_from_receiver_to_keys_the_link_is_lost_in_between(session, radio):
    arm(session, radio)
    session.key("i")
    listen(session, radio, 650, Sticks(forward=0.7))
    assert session.link.latest().why_disarmed.startswith("link lost")
    pass_ticks(session, 100)
    assert session.link.latest().link == "live"
    session.key("i")
    listen(session, radio, 900, Sticks(aux1=True))
    assert not session.link.latest().armed, "a switch that stands pressed is no deliberate act"


def test_leaving_disarms_by_silence(session, radio):
    arm(session, radio)
    listen(session, radio, 100, Sticks(forward=0.7))
    session.key("escape")
    assert session.over
    assert not session.link.latest().armed


def test_a_line_that_is_not_there_is_one_sentence(tmp_path):
    with pytest.raises(SurroundingsError, match="there is no device"):
        open_receiver(f"serial:{tmp_path}/none", "uart12")
