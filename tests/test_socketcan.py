"""Linux's own CAN: `vcan0`, and the kernel's `slcan` over our adapter. `make socketcan` boots a kernel for them."""

import fcntl
import os
import socket
import struct
import subprocess
import sys
import termios
import tty
from contextlib import contextmanager
from pathlib import Path

import can
import pytest
from patience import DEADLINE_S, until

from bench.canbus.watch import Kind
from bench.check.reading import Recording
from bench.config import load_robot
from bench.errors import SurroundingsError
from bench.io import surroundings
from bench.io.can_port import open_can
from bench.io.emulated.devices import EscsOnBus
from bench.io.emulated.slcan import SlcanOnLine
from bench.io.kinds.crossed import crossed
from bench.io.serial_port import open_serial
from bench.m2006 import decode_feedback, encode_command

M2006 = load_robot("m2006")
WIRE = "can:socketcan:vcan0"
ROOT = Path(__file__).parents[1]
N_SLCAN = 17
"""The line discipline that makes an interface of a serial line (linux/tty.h)."""
SIOCGIFNAME, SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8910, 0x8913, 0x8914, 1
"""linux/sockios.h, linux/if.h."""
SO_RCVBUFFORCE = 33
"""asm-generic/socket.h."""

pytestmark = [
    pytest.mark.socketcan,
    pytest.mark.skipif(
        not Path("/sys/class/net/vcan0").exists(),
        reason="there is no vcan0 here; `make socketcan` runs these under a kernel that has it",
    ),
]


def set_up(interface, up):
    """What `ip link set INTERFACE up` and `down` do."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack("16sH14x", interface.encode(), 0)
        flags = struct.unpack("16sH14x", fcntl.ioctl(any_socket, SIOCGIFFLAGS, request))[1]
        flags = flags | IFF_UP if up else flags & ~IFF_UP
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sH14x", interface.encode(), flags))


@contextmanager
def driver(channel):
    """The bus as somebody's driver opens it: python-can and nothing of ours."""
    bus = can.Bus(channel=channel, interface="socketcan")
    try:
        yield bus
    finally:
        bus.shutdown()


def command(*currents_ma):
    return can.Message(arbitration_id=0x200, data=encode_command(currents_ma), is_extended_id=False)


def drives_a_wheel(bus, step):
    """600 mA on motor 1, over whatever lies between: it reports that current, and turns faster and faster."""
    reports = {}

    def talk():
        bus.send(command(600, 0, 0, 0))
        step()
        while (message := bus.recv(0)) is not None:
            reports.setdefault(message.arbitration_id, []).append(decode_feedback(bytes(message.data)))

    until(lambda: 0x201 in reports and reports[0x201][-1][1] > 300, talk)
    assert set(reports) == {0x201, 0x202, 0x203}
    assert reports[0x201][-1][2] == pytest.approx(600, abs=30)
    assert abs(reports[0x202][-1][2]) < 30


def test_a_driver_turns_a_wheel_over_the_kernels_bus():
    escs = EscsOnBus(M2006, open_can("escs", WIRE))
    ticks = iter(range(1 << 30))
    try:
        with driver("vcan0") as bus:
            drives_a_wheel(bus, lambda: escs.step(next(ticks)))
    finally:
        escs.close()


def test_what_is_no_motors_frame_is_counted_and_nothing_is_lost():
    """Extended, remote and FD frames are on many a bus; a full burst between two reads is all there, in order."""
    port = open_can("--can", WIRE)
    try:
        with driver("vcan0") as bus:
            bus.send(can.Message(arbitration_id=0x201, is_extended_id=True, data=bytes(8)))
            bus.send(can.Message(arbitration_id=0x201, is_remote_frame=True, is_extended_id=False, dlc=8))
            sent = [(0x201 + k % 3, k.to_bytes(8, "big")) for k in range(150)]
            for can_id, data in sent:
                bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))
            got = []
            until(lambda: got.extend(port.read()) or len(got) >= len(sent))
        assert got == sent
        assert (port.other_frames, port.noise, port.lost, port.is_flooded) == (2, 0, "", False)
    finally:
        port.close()


def test_an_interface_that_goes_down_is_lost_and_comes_back():
    port = open_can("--can", WIRE)
    try:
        set_up("vcan0", False)
        until(lambda: port.lost, lambda: (port.write([(0x200, bytes(8))]), port.read()))
        assert port.losses == 1
        assert port.dropped_frames >= 1
        set_up("vcan0", True)
        until(port.revive)
        with driver("vcan0") as bus:
            port.write([(0x200, b"\x01\x02")])
            assert bytes(bus.recv(DEADLINE_S).data) == b"\x01\x02"
    finally:
        set_up("vcan0", True)
        port.close()


def test_an_interface_that_is_not_there_names_what_to_type():
    with pytest.raises(SurroundingsError, match="bring it up: sudo ip link set nocan9 up") as told:
        open_can("--can", "can:socketcan:nocan9")
    assert len(str(told.value).splitlines()) == 1


def test_doctor_finds_it():
    assert ("can:socketcan:vcan0 is unknown", surroundings.OK) in [
        (one.text, one.state) for one in surroundings.can_buses()
    ]


SCENARIO = """schema = 1
name = "over the kernel's bus"
robot = "m2006"
seconds = 1.5
[[stick]]
at_s = 0.3
aux1 = true
[[stick]]
at_s = 0.5
forward = 0.5
"""


def test_real_motors_by_their_commands_alone(tmp_path):
    """Two programs, the kernel between them: `emulate escs` plays the motors, a scenario drives them with `--arm`."""
    (tmp_path / "drive.toml").write_text(SCENARIO)
    wheelbench = [sys.executable, "-m", "bench"]
    drive = [*wheelbench, "replay", str(tmp_path / "drive.toml"), "--role", "motors", "--can", WIRE, "--arm"]
    heard = []
    with (
        driver("vcan0") as bus,
        subprocess.Popen(
            [*wheelbench, "emulate", "escs", WIRE, "--json"], stdout=subprocess.PIPE, text=True, cwd=ROOT
        ) as motors,
    ):
        # Room for the whole run: on the one CPU of this kernel three others may run for long before we hear them.
        bus.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 25)
        try:
            assert "listening" in motors.stdout.readline()
            with subprocess.Popen([*drive, "--record", str(tmp_path / "run")], cwd=ROOT) as run:
                while run.poll() is None:
                    heard.append(bus.recv(0.1))
        finally:
            motors.terminate()
            motors.wait()
        while (message := bus.recv(0)) is not None:
            heard.append(message)
    heard = [(message.arbitration_id, bytes(message.data)) for message in heard if message is not None]
    recording = Recording.open(tmp_path / "run")
    assert {can_id for can_id, _ in heard} == {0x200, 0x201, 0x202, 0x203}
    commands = [data for can_id, data in heard if can_id == 0x200]
    assert commands[-1] == bytes(8), "the last word is: no current"
    assert any(any(data) for data in commands)
    assert recording.ticks == 1500
    logged = [data for tick in recording.commands.values() for can_id, data in tick if can_id == 0x200]
    assert set(commands) <= {*logged, bytes(8)}, "what was on the bus is what the recording says"


@contextmanager
def kernel_slcan(path):
    """An interface of the kernel's own SLCAN on this line, made as `slcand` does: speed, open, line discipline."""
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        tty.setraw(line)
        os.write(line, b"C\rS8\rO\r")
        fcntl.ioctl(line, termios.TIOCSETD, struct.pack("i", N_SLCAN))
        name = fcntl.ioctl(line, SIOCGIFNAME, bytes(32)).rstrip(b"\0").decode()
        set_up(name, True)
        yield name
    finally:
        os.close(line)


def test_the_kernels_slcan_finds_our_adapter_a_real_one():
    """Its driver speaks to the emulated adapter; motors hang on that, and python-can drives them through the kernel."""
    line = open_serial("adapter", "pty:")
    near, far = crossed()
    adapter, escs = SlcanOnLine(line, near), EscsOnBus(M2006, far)
    ticks = iter(range(1 << 30))

    def step():
        tick = next(ticks)
        adapter.step(tick)
        escs.step(tick)

    try:
        with kernel_slcan(line.where) as name:
            for _ in range(20):
                step()
            with driver(name) as bus:
                drives_a_wheel(bus, step)
                assert name in [path.name for path in Path("/sys/class/net").iterdir()]
    finally:
        escs.close()
        adapter.close()
    assert not [one for one in escs.motors.escs.watch.findings if one.kind is Kind.LENGTH]
