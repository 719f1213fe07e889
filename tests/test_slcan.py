"""SLCAN text and the emulated adapter: the LAWICEL CAN232 manual's commands, python-can as the other end, junk."""

import os
import random
import threading

import can
import pytest
import serial
from hypothesis import example, given
from hypothesis import strategies as st
from patience import until

from bench.config import load_robot
from bench.errors import SurroundingsError, UsageError
from bench.io.can_port import open_can
from bench.io.clock import now_ns, wait_ns
from bench.io.emulated.slcan import SlcanAdapter, SlcanOnLine
from bench.io.kinds import serial_line, slcan_port
from bench.io.kinds.crossed import crossed
from bench.io.limiter import Limiter
from bench.io.rig import CLOSING_FRAMES, OutBus, Rig
from bench.io.serial_port import open_serial
from bench.io.slcan import SlcanReader, encode, opening

FRAMES = st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=20)


# --- text --------------------------------------------------------------------------------------------------------


def test_a_frame_of_the_manual():
    assert encode((0x100, bytes.fromhex("1122334455667788"))) == b"t10081122334455667788\r"
    assert encode((0x7FF, b"")) == b"t7FF0\r"
    assert SlcanReader().feed(b"t10021133\r") == [(0x100, b"\x11\x33")]


def test_lower_case_time_stamps_and_line_feeds_are_read():
    reader = SlcanReader()
    assert reader.feed(b"t20a2beEF\r") == [(0x20A, b"\xbe\xef")]
    assert reader.feed(b"t2012BEEF1A2B\r") == [(0x201, b"\xbe\xef")]
    assert reader.feed(b"\nt2012BEEF\r\nt2020\r") == [(0x201, b"\xbe\xef"), (0x202, b"")]
    assert reader.noise_lines == 0


def test_what_is_no_motors_frame_is_counted():
    reader = SlcanReader()
    assert reader.feed(b"T0000020180011223344556677\rr2018\rR000002018\rz\rZ\r\r\a\at2010\r") == [(0x201, b"")]
    assert (reader.other_frames, reader.refusals, reader.noise_lines) == (3, 2, 0)
    assert reader.feed(b"T00000201800112233445566\rV1013\rt2018\rt2FG0\rt9990\rt2019\rt201+1\r") == []
    assert (reader.other_frames, reader.noise_lines) == (3, 7), "eight bytes said, seven there; and so on"


@given(FRAMES, st.lists(st.integers(0, 500), max_size=10))
def test_blocks_may_be_cut_anywhere(frames, cuts):
    text = b"".join(map(encode, frames))
    reader, got, start = SlcanReader(), [], 0
    for end in [*sorted(min(cut, len(text)) for cut in cuts), len(text)]:
        got += reader.feed(text[start:end])
        start = end
    assert got == frames


@given(FRAMES, st.data())
def test_no_frame_is_lost_between_junk(frames, data):
    """Junk stands between frames, not inside them, and makes none of its own: a whole frame would be one."""
    junk = st.binary(max_size=40).filter(lambda piece: not SlcanReader().feed(piece + b"\r"))
    text = b"".join(data.draw(junk) + encode(frame) for frame in frames)
    got = SlcanReader().feed(text)
    assert [frame for frame in got if frame in frames] == frames == got


@given(st.binary(max_size=300))
@example(b"t" * 300)
def test_noise_never_raises_and_never_piles_up(data):
    reader = SlcanReader()
    for _ in range(5):
        reader.feed(data)
    assert len(reader._rest) <= 64


@pytest.mark.parametrize("frame", [(0x800, b""), (-1, b""), (1, bytes(9))])
def test_what_does_not_fit_is_refused(frame):
    with pytest.raises(ValueError, match="no standard data frame"):
        encode(frame)


def test_a_bitrate_without_a_digit_is_refused():
    assert opening(500_000) == b"\r\r\rC\rS6\rO\r"
    with pytest.raises(ValueError, match="bitrate 123"):
        opening(123)


# --- the adapter -------------------------------------------------------------------------------------------------


def test_the_adapters_states():
    adapter = SlcanAdapter()
    talk = [
        (b"\r", b"\r"),
        (b"O\r", b"\a"),  # no bitrate yet
        (b"t2010\r", b"\a"),
        (b"F\r", b"\a"),
        (b"S9\r", b"\a"),
        (b"S8\r", b"\r"),
        (b"C\r", b"\a"),  # not open
        (b"V\r", b"V1013\r"),
        (b"v\r", b"v1013\r"),
        (b"N\r", b"NA123\r"),
        (b"O\r", b"\r"),
        (b"O\r", b"\a"),
        (b"S6\r", b"\a"),  # only while closed
        (b"F\r", b"F00\r"),
        (b"t2012BEEF\r", b"z\r"),
        (b"T000002012BEEF\r", b"Z\r"),
        (b"r2012\r", b"z\r"),
        (b"t2012BEE\r", b"\a"),
        (b"t2019\r", b"\a"),
        (b"t8000\r", b"\a"),
        (b"hello\r", b"\a"),
        (b"C\r", b"\r"),
        (b"L\r", b"\r"),
        (b"t2010\r", b"\a"),  # listens only
        (b"C\r", b"\r"),
        (b"s1234\r", b"\r"),
        (b"Z1\r", b"\r"),
        (b"O\r", b"\r"),
    ]
    for text, answer in talk:
        assert adapter.feed(text) == answer, text
    assert adapter.take_sent() == ((0x201, b"\xbe\xef"),)
    assert (adapter.other_frames, adapter.take_sent()) == (2, ())
    assert adapter.deliver([(0x201, b"\x01")], 60_001) == b"t2011010001\r"


def test_a_closed_adapter_delivers_nothing():
    assert SlcanAdapter().deliver([(0x201, b"")]) == b""


@given(st.lists(st.binary(max_size=80), max_size=20))
def test_an_adapter_survives_any_text_and_then_works(pieces):
    adapter = SlcanAdapter()
    for piece in pieces:
        adapter.feed(piece)
        assert len(adapter._line) <= 32
    adapter.feed(b"\r")
    adapter.feed(opening(1_000_000))
    adapter.take_sent()
    assert adapter.feed(b"t2010\r") == b"z\r"
    assert (adapter.bitrate, adapter.take_sent()) == (1_000_000, ((0x201, b""),))


# --- over real ptys ----------------------------------------------------------------------------------------------


class Running:
    """An adapter on a pty with a bus behind it; `until` steps it by hand until something holds."""

    def __init__(self, address="pty:", limiter=None):
        self.bus, self.far = crossed()
        self.line = open_serial("adapter", address)
        self.device = SlcanOnLine(self.line, self.bus, limiter=limiter)
        self.tick = 0

    def step(self):
        self.device.step(self.tick)
        self.tick += 1

    def until(self, holds):
        deadline_ns = now_ns() + 60_000_000_000
        while not holds():
            assert now_ns() < deadline_ns, "nothing came"
            self.step()
            wait_ns(200_000)


@pytest.fixture
def adapter():
    running = Running()
    yield running
    running.device.close()


def test_python_can_drives_the_adapter(adapter):
    """Its reader is the second opinion on what an adapter sends."""
    bus = can.Bus(interface="slcan", channel=adapter.line.where, bitrate=500_000, sleep_after_open=0)
    try:
        adapter.until(lambda: adapter.device.adapter.is_open)
        assert adapter.device.adapter.bitrate == 500_000
        bus.send(can.Message(arbitration_id=0x200, data=bytes(range(8)), is_extended_id=False))
        got = []
        adapter.until(lambda: got.extend(adapter.far.read()) or got)
        assert got == [(0x200, bytes(range(8)))]
        adapter.far.write([(0x201, b"\x01\x02"), (0x202, b"")])
        adapter.step()
        messages = [bus.recv(60), bus.recv(60)]
        assert [(one.arbitration_id, bytes(one.data)) for one in messages] == [(0x201, b"\x01\x02"), (0x202, b"")]
    finally:
        bus.shutdown()
    adapter.until(lambda: not adapter.device.adapter.is_open)


def test_our_port_and_the_adapter_lose_no_frame_among_junk(adapter):
    rng = random.Random("slcan junk 1")
    port = open_can("--can", f"can:slcan:{adapter.line.where}")
    sent, got = [], []
    try:
        adapter.until(lambda: adapter.device.adapter.is_open)
        for _ in range(300):
            frames = [(rng.randrange(0x800), rng.randbytes(rng.randrange(9))) for _ in range(rng.randrange(4))]
            sent += frames
            adapter.line.write(
                rng.choice([b"", b"\a", b"x", b"BOOT v2\r", b"t20", b"\n", b"\xff\xfe", b"t2018AB\r", b"z\r"])
            )
            adapter.far.write(frames)
            adapter.step()
            got += port.read()
        adapter.until(lambda: got.extend(port.read()) or len(got) >= len(sent))
        assert got == sent
        assert port.noise > 0
        port.write(sent)
        back = []
        adapter.until(lambda: back.extend(adapter.far.read()) or len(back) >= len(sent))
        assert back == sent
    finally:
        port.close()
    adapter.until(lambda: not adapter.device.adapter.is_open)


WILD = (0x200, bytes.fromhex("2710 D8F0 0064 2710"))
"""10000, -10000, 100, 10000: three motors of m2006, and a fourth that is somebody else's."""
WITHIN_600_MA = (0x200, bytes.fromhex("0258 FDA8 0064 0000"))
NO_CURRENT = (0x200, bytes(8))


def test_a_bridge_to_real_motors_passes_commands_within_the_robots_limits_and_nothing_else():
    """What m2006's file allows is 0.6 A on the ESCs 1 to 3. 0x201 is what an ESC says, never its controller."""
    bridge = Running(limiter=Limiter(load_robot("m2006")))
    port = open_can("--can", f"can:slcan:{bridge.line.where}")
    try:
        port.write([(0x123, bytes(8)), WILD, (0x1FF, bytes(8)), (0x201, bytes(8))])
        got = []
        bridge.until(lambda: got.extend(bridge.far.read()) or bridge.device.from_host == 4)
        assert got == [WITHIN_600_MA]
        facts = bridge.device.facts()
        assert (facts["frames_limited"], facts["frames_not_passed"]) == (1, 3)
        bridge.far.write([(0x201, bytes(8))])
        bridge.until(lambda: port.read() == ((0x201, bytes(8)),))
    finally:
        port.close()
        bridge.device.close()


@pytest.mark.parametrize("leaves", ["closes the channel", "pulls its cable", "is stopped with us"])
def test_whoever_leaves_a_bridge_leaves_no_current_behind(leaves):
    bridge = Running(limiter=Limiter(load_robot("m2006")))
    port = serial.Serial(bridge.line.where, 115_200)
    got = []
    try:
        port.write(opening(1_000_000) + b"t20080258000000000000\r")
        bridge.until(lambda: got.extend(bridge.far.read()) or got)
        assert got == [(0x200, bytes.fromhex("0258000000000000"))]
        if leaves == "closes the channel":
            port.write(b"C\r")
            bridge.until(lambda: not bridge.device.adapter.is_open)
        elif leaves == "pulls its cable":
            port.close()
            bridge.until(lambda: not bridge.device.adapter.is_open)
        else:
            bridge.device.close()
        assert bridge.far.read() == (NO_CURRENT,), "once, and at once"
    finally:
        port.close()
        bridge.device.close()
    assert bridge.far.read() == ()


def test_a_bridge_to_a_bus_that_is_away_says_no_current_when_it_is_back():
    bridge = Running(limiter=Limiter(load_robot("m2006")))
    port = open_can("--can", f"can:slcan:{bridge.line.where}")
    try:
        port.write([WILD])
        bridge.until(lambda: bridge.far.read() == (WITHIN_600_MA,))
        bridge.bus.lost = "unplugged"
        port.close()
        bridge.until(lambda: not bridge.device.adapter.is_open)
        bridge.far.read()  # nobody hears these
        bridge.bus.lost = ""
        bridge.step()
        bridge.step()
        assert bridge.far.read() == (NO_CURRENT,)
    finally:
        bridge.device.close()


SOME_CURRENT = (0x200, b"\x02\x58" * 4)


def full(line, frame=SOME_CURRENT):
    """A port to an adapter that reads nothing, when the line has not taken a byte for a while; frames sent by then.

    One by one, because a pty with no room for many may have some for one.
    """
    port, sent, refused = open_can("--can", f"can:slcan:{line.where}"), 0, 0
    while refused < 10:
        refused = 0 if port.write([frame], within_s=0.005) else refused + 1
        sent += 1
    return port, sent


def test_a_last_word_waits_for_room_on_a_line_that_is_full(monkeypatch):
    """An ESC keeps its last current: what stops the motors may not be what a full line drops, or cuts in two."""
    line = open_serial("adapter", "pty:")
    port, _ = full(line)
    rig = Rig("motors")
    rig.limiter, rig.ports, rig.buses = Limiter(load_robot("m2006")), [port], [OutBus(port)]
    rig.buses[0].put([SOME_CURRENT])
    reader, heard = SlcanReader(), []

    def while_it_waits(duration_ns):
        heard.extend(reader.feed(line.read()))
        wait_ns(duration_ns)

    monkeypatch.setattr(serial_line, "wait_ns", while_it_waits)  # the other end reads while we wait, and only then
    rig.close()
    while data := line.read():
        heard.extend(reader.feed(data))
    line.close()
    assert heard[-CLOSING_FRAMES:] == [NO_CURRENT] * CLOSING_FRAMES
    assert set(heard[:-CLOSING_FRAMES]) == {SOME_CURRENT}


def test_a_last_word_counts_however_much_stands_before_it(adapter):
    """Whoever read nothing for a moment has more before it than one read brings; then the host is gone already."""
    port = open_can("--can", f"can:slcan:{adapter.line.where}")
    adapter.until(lambda: adapter.device.adapter.is_open)
    for _ in range(500):
        assert port.write([SOME_CURRENT])
    assert port.write([NO_CURRENT])
    port.close()
    adapter.step()
    assert adapter.far.read() == (SOME_CURRENT,) * 500 + (NO_CURRENT,)
    assert not adapter.device.adapter.is_open


@pytest.mark.parametrize("length", [6, 7, 8])
def test_a_frame_that_a_full_line_cuts_takes_no_other_with_it(length):
    """An adapter takes a line for a frame as a whole. At these lengths the last one is cut in its middle."""
    line = open_serial("adapter", "pty:")
    port, _ = full(line, (0x200, bytes(length)))
    heard, frame = b"", (0x100, b"")
    while not port.write([frame]):  # there is room some time after it was read
        heard += line.read()

    def read():
        nonlocal heard
        heard += line.read()

    until(lambda: heard.endswith(encode(frame)), read)
    assert heard.endswith(b"\r" + encode(frame))
    port.close()
    line.close()


def test_each_frame_that_a_full_line_drops_is_counted():
    line = open_serial("adapter", "pty:")
    port, sent = full(line)
    assert not port.write([SOME_CURRENT] * 50, within_s=0.02)
    reader, heard = SlcanReader(), []
    until(lambda: len(heard) + port.dropped_frames >= sent + 50, lambda: heard.extend(reader.feed(line.read())))
    assert len(heard) + port.dropped_frames == sent + 50
    port.close()
    line.close()


def test_a_pulled_cable_is_noticed_and_taken_up_again(tmp_path):
    link = tmp_path / "adapter"
    first = Running(f"pty:{link}")
    port = open_can("--can", f"can:slcan:{link}")
    first.until(lambda: first.device.adapter.is_open)
    first.device.close()
    assert port.read() == ()
    assert port.lost
    port.write([(0x200, bytes(8))])
    assert (port.dropped_frames, port.losses) == (1, 1)
    again = Running(f"pty:{link}")
    try:
        again.until(lambda: port.revive() and port.read() == () and again.device.adapter.is_open)
        again.far.write([(0x201, b"\x07")])
        got = []
        again.until(lambda: got.extend(port.read()) or got)
        assert got == [(0x201, b"\x07")]
    finally:
        port.close()
        again.device.close()


def test_an_adapter_that_will_not_open_is_named(monkeypatch):
    """It refuses everything but its version."""
    monkeypatch.setattr(slcan_port, "ANSWER_NS", 60_000_000_000)  # this one does answer, whenever it gets to it
    master, slave = os.openpty()

    def refuse():
        heard = b""
        while not heard.endswith(b"V\r"):
            heard += os.read(master, 100)
        os.write(master, b"\r\r\r\a\a\aV1013\r")

    adapter = threading.Thread(target=refuse)
    adapter.start()
    try:
        with pytest.raises(SurroundingsError, match="refuses to open; try another bitrate"):
            open_can("--can", f"can:slcan:{os.ttyname(slave)}")
    finally:
        adapter.join()
        os.close(master)
        os.close(slave)


def test_a_silent_adapter_is_believed_and_noted(adapter):
    port = open_can("--can", f"can:slcan:{adapter.line.where}")  # nobody steps it meanwhile
    assert "answers nothing" in port.note
    adapter.until(lambda: adapter.device.adapter.is_open)
    port.close()


def test_a_bitrate_that_no_adapter_has():
    with pytest.raises(UsageError, match="take one of them"):
        open_can("--can", "can:slcan:pty:@123456")
