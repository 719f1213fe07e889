"""Emulated hardware over real wires: ptys, sockets on the loopback, python-can's virtual and udp_multicast buses."""

import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import can
import pytest
import serial

from bench.config import load_profile, load_robot
from bench.errors import SurroundingsError, UsageError
from bench.io.can_port import open_can
from bench.io.clock import now_ns, wait_ns
from bench.io.emulated.devices import BaseOnLine, CoreOnLine, EscsOnBus, ReceiverOnLine
from bench.io.emulated.serve import serve
from bench.io.kinds import tcp_port
from bench.io.paced_writer import PacedWriter
from bench.io.serial_port import open_serial
from bench.m2006 import decode_feedback, encode_command
from bench.messages import BodyTwist, RcFrame
from bench.rc.line import USUAL, Settings
from bench.rc.retransmit import retransmitted, sticks_of
from bench.rc.transmitter import Sticks, Transmitter
from bench.rc_decode import decoder
from bench.slamware import SlamwareBase, SlamwareCore
from bench.slamware.reference_base import reference_facts
from bench.slamware.senses import Motion

M2006 = load_robot("m2006")
ROOT = Path(__file__).parents[1]
DEADLINE_S = 60.0


def until(holds, *steps):
    """Step by hand until something holds: real wires take their time on a busy machine."""
    deadline, tick = time.monotonic() + DEADLINE_S, 0
    while not holds():
        assert time.monotonic() < deadline, "nothing came"
        for step in steps:
            step(tick)
        tick += 1


# --- ESCs --------------------------------------------------------------------------------------------------------


@pytest.fixture(params=["virtual", "multicast"])
def bus(request):
    return request.getfixturevalue("multicast") if request.param == "multicast" else "can:virtual:escs-test"


def driver_of(address):
    """The same bus as somebody's driver opens it: with python-can and nothing of ours."""
    if "virtual" in address:
        return can.Bus(interface="virtual", channel="escs-test")
    group, _, port = address.removeprefix("can:udp_multicast:").partition("?port=")
    return can.Bus(interface="udp_multicast", channel=group, port=int(port), hop_limit=0)


def test_a_driver_turns_a_wheel(bus):
    """600 mA on motor 1: the wheel turns in the direction of its current, as far as the reports say."""
    escs = EscsOnBus(M2006, open_can("escs", bus))
    driver = driver_of(bus)
    try:
        reports = {}

        def talk(tick):
            driver.send(can.Message(arbitration_id=0x200, data=encode_command((600, 0, 0, 0)), is_extended_id=False))
            escs.step(tick)
            while (message := driver.recv(0)) is not None:
                reports.setdefault(message.arbitration_id, []).append(decode_feedback(bytes(message.data)))

        until(lambda: 0x201 in reports and reports[0x201][-1][1] > 100 and escs.facts()["commands"] >= 150, talk)
        assert {0x201, 0x202, 0x203} <= set(reports)
        assert reports[0x201][-1][2] == pytest.approx(600, abs=30)
        assert abs(reports[0x202][-1][2]) < 30
        assert escs.facts()["wheel_radps"][0] != 0.0
    finally:
        driver.shutdown()
        escs.close()


def test_over_multicast_a_sender_does_not_hear_itself(multicast):
    one, two = open_can("one", multicast), open_can("two", multicast)
    try:
        got = {"one": [], "two": []}
        for k in range(50):
            one.write([(0x201, bytes([k])), (0x202, b"")])
            two.write([(0x200, bytes([k]))])

        def arrived():
            got["one"] += one.read()
            got["two"] += two.read()
            return len(got["one"]) >= 50 and len(got["two"]) >= 100

        until(arrived)
        assert got["one"] == [(0x200, bytes([k])) for k in range(50)]
        assert got["two"] == [frame for k in range(50) for frame in ((0x201, bytes([k])), (0x202, b""))]
    finally:
        one.close()
        two.close()


def test_junk_on_the_network_is_counted_and_no_frame_is_lost(multicast):
    port, driver = open_can("port", multicast), driver_of(multicast)
    noise = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    noise.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    try:
        for k in range(10):
            noise.sendto(b"no frame at all", driver._multicast._send_destination)
            driver.send(can.Message(arbitration_id=0x200 + k, data=b"", is_extended_id=False))
        driver.send(can.Message(arbitration_id=0x200, data=b"", is_extended_id=True))
        got = []
        until(lambda: got.extend(port.read()) or (len(got) >= 10 and port.noise >= 10 and port.other_frames))
        assert got == [(0x200 + k, b"") for k in range(10)]
        assert (port.noise, port.lost, port.other_frames) == (10, "", 1)
    finally:
        noise.close()
        driver.shutdown()
        port.close()


@pytest.mark.parametrize(
    ("address", "error", "tells"),
    [
        ("can:virtuall:x", UsageError, "did you mean virtual?"),
        ("can:socketcan:nocan9", SurroundingsError, "; "),
        ("can:udp_multicast:10.0.0.1", SurroundingsError, "a group such as 239.74.163.2"),
        ("can:udp_multicast:239.0.0.1?port=five", UsageError, "port=five: expected 1 to 65534"),
        ("can:slcan:/dev/no-such-thing", SurroundingsError, "plug it in"),
        ("can:slcan:/dev/null", SurroundingsError, "is no serial port"),
        ("can:slcan:socket://127.0.0.1:9", SurroundingsError, "start the other end first"),
    ],
)
def test_what_python_can_refuses_is_one_sentence(address, error, tells, capfd):
    with pytest.raises(error) as told:
        open_can("--can", address)
    assert tells in str(told.value)
    assert len(str(told.value).splitlines()) == 1
    assert capfd.readouterr() == ("", ""), "the libraries say nothing beside it"


# --- serial lines ------------------------------------------------------------------------------------------------


def test_a_pty_tells_who_is_there(tmp_path):
    link = tmp_path / "rc"
    port = open_serial("rc", f"pty:{link}")
    assert port.lost
    port.write(b"to nobody")
    assert port.dropped_bytes == 9
    with serial.Serial(str(link), 115200, timeout=DEADLINE_S) as peer:
        assert port.revive()
        port.write(b"frame")
        assert peer.read(5) == b"frame", "and nothing of what was sent to nobody"
        peer.write(b"answer\r\n\x03\x04")
        got = bytearray()
        until(lambda: got.extend(port.read()) or len(got) >= 10)
        assert got == b"answer\r\n\x03\x04", "raw: no echo, no line ends, no signals"
    assert port.read() == b""
    assert (port.lost, port.losses) == ("the other end has closed it", 1)
    with serial.Serial(str(link), 115200):
        assert port.revive()
    port.close()
    assert not link.exists()


class BetweenTwoLooks:
    """A poll in whose middle the other end writes and leaves, when the kernel has looked for input already."""

    def __init__(self, poll, leave):
        self._poll, self._leave = poll, leave

    def poll(self, timeout):
        leave, self._leave = self._leave, None
        if leave is None:
            return self._poll.poll(timeout)
        leave()
        return [(descriptor, events & ~select.POLLIN) for descriptor, events in self._poll.poll(timeout)]


def test_who_writes_and_leaves_at_once_is_heard():
    port = open_serial("rc", "pty:")
    peer = serial.Serial(port.where, 115200)
    assert port.revive()

    def leave():
        peer.write(b"last word")
        peer.close()

    port._poll = BetweenTwoLooks(port._poll, leave)
    assert port.read() == b"last word"
    assert port.lost
    port.close()


def test_a_full_line_drops_and_counts_and_never_blocks():
    port = open_serial("rc", "pty:")
    with serial.Serial(port.where, 115200) as peer:
        assert peer.is_open
        for _ in range(100):
            port.write(bytes(1000))
        assert 0 < port.dropped_bytes < 100_000
        assert port.lost == ""
    port.close()


def test_a_device_that_goes_and_comes(tmp_path):
    link = tmp_path / "tty"
    far = open_serial("far", f"pty:{link}")
    port = open_serial("rc", f"serial:{link}?baud=100000&format=8E2")
    assert "pseudo-terminal" in port.note
    far.close()
    assert port.read() == b""
    assert port.lost
    assert not port.revive(), "not before half a second has passed"
    far = open_serial("far", f"pty:{link}")
    until(port.revive)
    far.write(b"back")
    got = bytearray()
    until(lambda: got.extend(port.read()) or got)
    assert (bytes(got), port.losses) == (b"back", 1)
    port.close()
    far.close()


def test_a_driver_that_keeps_other_settings_is_refused(monkeypatch):
    """A pty drops the parity bit and says nothing, and then refuses it: as some USB adapters do."""
    port = open_serial("far", "pty:")
    monkeypatch.setattr(os.path, "realpath", lambda path: path.replace("/dev/pts/", "/dev/ttyUSB"))
    with pytest.raises(SurroundingsError, match="was set to 100000 8E2, but the driver made it 100000 8N2"):
        open_serial("--rc", f"serial:{port.where}?baud=100000&format=8E2")
    with pytest.raises(SurroundingsError, match="refuses 100000 8E2; try another"):
        open_serial("--rc", f"serial:{port.where}?baud=100000&format=8E2")
    port.close()


def test_a_listener_takes_one_after_the_other():
    with socket.create_server(("127.0.0.1", 0)) as free:
        number = free.getsockname()[1]
    listener = open_serial("slamware", f"listen://127.0.0.1:{number}")
    for text in (b"first", b"second"):
        client = open_serial("slamware", listener.where)
        client.write(text)
        got = bytearray()
        until(lambda got=got, text=text: got.extend(listener.read()) or len(got) >= len(text))
        assert got == text
        listener.write(b"ok")
        back = bytearray()
        until(lambda back=back, client=client: back.extend(client.read()) or len(back) >= 2)
        client.close()
        until(lambda: listener.read() == b"" and listener.lost)
    with pytest.raises(SurroundingsError, match="cannot listen there"):
        open_serial("slamware", f"listen://127.0.0.1:{number}")
    listener.close()


@pytest.fixture
def connection():
    """Both ends of a TCP line: ours, and one of nobody's."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        port = open_serial("--can", f"socket://127.0.0.1:{server.getsockname()[1]}")
        peer, _ = server.accept()
    with peer:
        yield port, peer
        port.close()


def test_what_was_said_last_arrives_though_the_line_is_full_and_more_is_there_to_read(connection, monkeypatch):
    """A connection that is closed over something unread is reset, and with it goes what had not left yet."""
    port, peer = connection
    while port.write(bytes(65536)):
        pass
    peer.sendall(b"feedback")
    heard = bytearray()

    def listen():
        time.sleep(0.1)  # by then it has left
        with suppress(ConnectionResetError):
            while data := peer.recv(65536):
                heard.extend(data)

    monkeypatch.setattr(tcp_port, "LEAVE_S", DEADLINE_S)
    listener = threading.Thread(target=listen)
    listener.start()
    assert port.write(b"last word", within_s=DEADLINE_S)
    port.close()
    listener.join()
    assert heard.endswith(b"last word")


def test_nobody_waits_long_for_one_who_reads_nothing(connection):
    port, _ = connection
    while port.write(bytes(65536)):
        pass
    begun = time.monotonic()
    port.close()
    assert time.monotonic() - begun < DEADLINE_S / 2


def test_what_one_said_who_has_left_is_read_though_nothing_can_be_told_him(connection):
    """Who left over something unread has reset the connection: the next write finds that, and not the next read."""
    port, peer = connection
    port.write(b"feedback")
    peer.recv(1)
    peer.sendall(b"last word")
    peer.close()
    until(lambda: not port.write(b"feedback"))
    assert port.lost
    assert port.read() == b"last word"
    assert port.read() == b""


OPENS_AS_NOBODY = """
import os
from bench.errors import SurroundingsError
from bench.io.serial_port import open_serial

def said(device):
    try:
        open_serial("rc", f"serial:./{device}")
    except SurroundingsError as error:
        return str(error)

assert "dialout" not in said("nothing")  # loads what it takes, while it may
if os.geteuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
print(said("tty"))
"""


def test_a_device_without_permission_names_the_group(tmp_path):
    """In a process of its own, which can stop being root: root may open everything."""
    tmp_path.chmod(0o755)
    (tmp_path / "tty").touch(0o000)
    done = subprocess.run(
        [sys.executable, "-c", OPENS_AS_NOBODY], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "dialout" in done.stdout


def test_bytes_leave_no_faster_than_their_line():
    """25 bytes of SBUS are 25 x 12 bits at 100000 baud: 3.0 ms."""
    port = open_serial("rc", "pty:")
    writer = PacedWriter(port, USUAL["sbus"])
    writer.put(bytes(25))
    assert [len(writer.step()) for _ in range(5)] == [8, 8, 9, 0, 0]
    eight_n_one = PacedWriter(port, Settings(115_200))
    eight_n_one.put(bytes(1000))
    assert sum(len(eight_n_one.step()) for _ in range(80)) == pytest.approx(80 * 11.52, abs=1)
    eight_n_one.put(bytes(100_000))
    assert port.dropped_bytes > 90_000
    port.close()


# --- SLAMWARE ----------------------------------------------------------------------------------------------------


class Still(Motion):
    wheel_count = 2


def test_our_core_drives_the_emulated_base_over_a_pty():
    """The core as a library program would have it: pyserial and the codec, nothing of our ports."""
    device = BaseOnLine(load_robot("slamware-a"), open_serial("base", "pty:"))
    core = SlamwareCore()
    core.ask(BodyTwist(0.2, 0.0, 0.0))
    with serial.Serial(device.line.where, 115200, timeout=0) as port:

        def talk(tick):
            device.step(tick)
            request = core.step(tick, port.read(4096))
            if request:
                port.write(request)

        until(lambda: device.facts()["x_m"] > 0.1, talk)
        assert core.connected
        assert core.pose.x_m == pytest.approx(device.facts()["x_m"], abs=0.03)
        assert device.facts()["driver"] == "core"
    device.close()


def test_the_emulated_core_drives_a_base_over_a_socket():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        device = CoreOnLine(
            open_serial("core", f"socket://127.0.0.1:{listener.getsockname()[1]}"), {0: BodyTwist(0.3, 0, 0)}
        )
        far, _ = listener.accept()
    far.setblocking(False)
    base = SlamwareBase(reference_facts(), Still())

    def talk(tick):
        device.step(tick)
        try:
            answer = base.receive(far.recv(4096), tick)
        except BlockingIOError:
            return
        if answer:
            far.sendall(answer)

    until(lambda: base.wanted_twist.vx_mps, talk)
    assert base.wanted_twist.vx_mps == pytest.approx(0.3, abs=1e-3)
    assert device.facts()["connected"]
    device.close()
    far.close()


# --- RC ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["uart12", "frsky-sbus", "dr16", "flysky", "elrs"])
def test_a_receiver_speaks_every_protocol_on_a_pty(name):
    profile = load_profile(name)
    transmitter = Transmitter(profile)
    held = Sticks(forward=0.5, left=-1.0, aux1=True)
    frames = {tick: data for tick in range(60) if (data := transmitter.step(tick, held))}
    port = open_serial("rc", "pty:")
    device = ReceiverOnLine(port, profile.protocol, frames, USUAL[profile.protocol])
    reader, got = decoder(profile.protocol, 2000), []
    with serial.Serial(port.where, 115200, timeout=0) as peer:
        for tick in range(120):
            device.step(tick)
            got += [event for event in reader.feed(peer.read(4096), tick * 1000) if isinstance(event, RcFrame)]
    assert len(got) == len(frames) == device.frames_out
    assert {frame.channels for frame in got} == {transmitter.channels(held)}
    device.close()


@pytest.mark.parametrize("sent_by", ["frsky-sbus", "dr16", "flysky", "elrs"])
def test_a_stream_is_sent_again_in_other_words(sent_by):
    read_by, sent_by = load_profile("uart12"), load_profile(sent_by)
    transmitter = Transmitter(read_by)
    held = {0: Sticks(), 200: Sticks(0.75, 0.25, -0.5), 400: Sticks(-1.0, aux1=True), 600: None}
    stream, sticks = {}, None
    for tick in range(900):
        sticks = held.get(tick, sticks)
        if sticks is not None and (data := transmitter.step(tick, sticks)):
            stream[tick] = data
    again = retransmitted(stream, read_by, sent_by)
    reader = decoder(sent_by.protocol, 2000)
    seen = {}
    for tick, data in again.items():
        for event in reader.feed(data, tick * 1000):
            assert isinstance(event, RcFrame)
            seen[tick] = sticks_of(event.channels, sent_by)
    for tick in (190, 390, 590):
        nearest = max(at for at in seen if at <= tick)
        expected = held[tick // 200 * 200]
        assert seen[nearest][:3] == pytest.approx(expected[:3], abs=0.002)
        assert seen[nearest][3:] == expected[3:]
    assert max(seen) < 700, "silent where the stream was"


# --- served ------------------------------------------------------------------------------------------------------


def test_devices_are_stepped_once_a_millisecond():
    ticks, closed = [], []

    class Device:
        def step(self, tick):
            ticks.append(tick)

        def facts(self):
            return {}

        def close(self):
            closed.append(True)

    started = now_ns()
    assert serve([Device()], ticks=100) >= 100
    assert now_ns() - started >= 99_000_000
    assert ticks == list(range(len(ticks)))
    assert closed == [True]


def wheelbench(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "bench", *map(str, arguments)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_emulate_says_where_it_is_what_it_hears_and_stops_by_ctrl_c(tmp_path):
    link = tmp_path / "adapter"
    running = wheelbench("emulate", "slcan", f"pty:{link}", "--robot", "m2006")
    try:
        first = running.stdout.readline()
        assert first.startswith("SLCAN adapter with the ESCs of m2006 behind it")
        assert str(link) in first
        port = open_can("--can", f"can:slcan:{link}")
        command = (0x200, encode_command((0, 500, 0, 0)))
        seen = {}

        def turns(tick):
            port.write([command])
            seen.update(port.read())
            wait_ns(1_000_000)

        until(lambda: 0x202 in seen and decode_feedback(seen[0x202])[1] > 50, turns)
        while "open yes, bitrate 1000000" not in (heard := running.stdout.readline()):
            assert "open no" in heard, "a second may have passed before the port was opened"
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=DEADLINE_S)
        assert (running.returncode, err) == (0, "")
        assert "stopped" in out.splitlines()[-1]
        assert not link.exists()
        port.close()
    finally:
        running.kill()
        running.communicate()


@pytest.mark.parametrize(
    ("arguments", "status", "tells"),
    [
        (("escs", "pty:"), 2, "expected can:slcan"),
        (("escs", "sim:"), 2, "sim: is inside the process, where nobody else can meet it; expected can:slcan"),
        (("base", "sim:"), 2, "sim: is inside the process, where nobody else can meet it; expected pty:"),
        (
            ("slcan", "--bus", "sim:"),
            2,
            "sim: is inside the process, where nobody else can meet it; expected can:slcan",
        ),
        (("firmware", "--can", "can0"), 2, "--can can0: expected can:slcan"),
        (("base", "can:virtual:x"), 2, "is a CAN bus"),
        (("core", "pty:", "--twist", "fast"), 2, "expected VX,VY,OMEGA"),
        (("core", "pty:", "--twist", "nan,0,0"), 2, "expected numbers from -32767 to 32767"),
        (("core", "pty:", "--twist", "0,0,1e30"), 2, "expected numbers from -32767 to 32767"),
        (("firmware", "--can", "can:virtual:x", "--rc", "pty:", "--robot", "slamware-b"), 2, "slamware-b takes no RC"),
        (("firmware", "--can", "can:slcan:/dev/ttyACM0"), 2, "may move real motors; lift the robot off the floor"),
        (
            ("slcan", "--bus", "can:socketcan:can0"),
            2,
            "may move real motors; lift the robot off the floor and add --arm",
        ),
        (("slcan", "--bus", "can:socketcan:can0", "--robot", "m2006"), 2, "may move real motors; lift the robot"),
        (("slcan", "--bus", "can:socketcan:can0", "--arm"), 2, "add --robot, whose current limit then holds"),
        (("slcan", "--robot", "m2006", "--arm"), 2, "--arm: goes with --bus"),
        (("receiver", "pty:", "--protocol", "morse"), 2, "expected uart12, sbus"),
        (("receiver", "pty:", "--protocol", "sbus", "--seconds", "-1"), 2, "expected a positive number"),
        (("base", "serial:/dev/no-such-thing"), 3, "plug it in"),
    ],
)
def test_emulate_refuses_in_one_sentence(call, arguments, status, tells):
    got, out, err = call("emulate", *arguments)
    assert (got, out) == (status, "")
    assert tells in err
    assert len(err.splitlines()) == 1


def test_a_receiver_plays_a_scenario_whose_robot_lies_beside_it(call, tmp_path):
    (tmp_path / "mine.toml").write_text((ROOT / "bench" / "robots" / "m2006.toml").read_text())
    scenario = tmp_path / "s.toml"
    rc = ROOT / "bench" / "demo" / "drive.bin"
    scenario.write_text(f'schema = 1\nname = "s"\nseconds = 1.0\nrobot = "mine.toml"\nrc = "{rc}"\n')
    played = ("emulate", "receiver", "pty:", "--protocol", "sbus", "--from", scenario, "--seconds", "0.1", "--json")
    status, out, err = call(*played)
    assert (status, err) == (0, "")
    assert json.loads(out.splitlines()[-1])["frames"] > 0


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (("base", "pty:"), "requests"),
        (("core", "pty:"), "requests"),
        (("core", "pty:", "--from", "bench/demo/demo.toml"), "requests"),
        (("receiver", "pty:", "--protocol", "crsf"), "bytes_to_nobody"),
        (("receiver", "pty:", "--profile", "dr16", "--from", "bench/demo/demo.toml"), "channels"),
        (("receiver", "pty:", "--protocol", "uart12", "--from", "docs/examples/link_loss.toml", "--repeat"), "frames"),
        (("receiver", "pty:", "--protocol", "ibus", "--from", "bench/demo/drive.bin"), "frames"),
        (("escs", "can:virtual:nobody", "--robot", "dm3519"), "feedback"),
        (("slcan", "--bus", "can:virtual:nobody"), "adapter_commands"),
        (("slcan", "--bus", "can:virtual:nobody", "--robot", "m2006"), "frames_limited"),
    ],
)
def test_emulate_tells_programs_too(call, arguments, key):
    status, out, err = call("emulate", *arguments, "--seconds", "0.05", "--json")
    assert (status, err) == (0, "")
    listening, *_, stopped = map(json.loads, out.splitlines())
    assert listening["event"] == "listening"
    assert listening["where"]
    assert stopped["event"] == "stopped"
    assert key in stopped
