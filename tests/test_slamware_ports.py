"""Core and base over real ports, pyserial at both ends: a pty pair, and socket:// on the loopback. Bytes as they are.

The line carries each write to its end before the next tick; nothing sleeps, everything has a deadline.
"""

import os
import random
import select
import socket
import time
import tty

import pytest
import serial
from patience import DEADLINE_S

from bench.messages import BodyTwist
from bench.slamware import SlamwareBase, SlamwareCore, as_reference_firmware
from bench.slamware.payloads import Displacement
from bench.slamware.reference_base import reference_facts
from bench.slamware.schedule import FULL
from bench.slamware.senses import Motion

SEED = "slamware ports 1"


class Cable:
    """Two serial ports and what joins them, as `os.read` and `os.write` see it. `hurt` stands in the middle."""

    def __init__(self, core_port, base_port, middle, hurt=lambda data: data):
        self.core_port, self.base_port = core_port, base_port
        self.middle = middle  # file descriptors: the core's far end, the base's far end
        self.hurt = hurt

    def to_base(self, data):
        return self._carry(self.core_port, self.middle[0], self.middle[1], self.base_port, data)

    def to_core(self, data):
        return self._carry(self.base_port, self.middle[1], self.middle[0], self.core_port, data)

    def _carry(self, sender, out_of, into, receiver, data):
        sender.write(data)
        data = self.hurt(self._all(out_of, len(data)))
        os.write(into, data)
        received = receiver.read(len(data))
        assert received == data, "the port changed or lost bytes"
        assert receiver.in_waiting == 0
        return received

    def _all(self, descriptor, size):
        data, deadline = b"", time.monotonic() + DEADLINE_S
        while len(data) < size:
            assert time.monotonic() < deadline, f"{size - len(data)} bytes did not arrive"
            if select.select([descriptor], [], [], 0.1)[0]:
                data += os.read(descriptor, size - len(data))
        return data


@pytest.fixture
def over_pty():
    """A pty pair, crossed in the middle: pyserial opens the device of each."""
    far, ports = [], []
    for _ in range(2):
        master, device = os.openpty()
        tty.setraw(device)
        ports.append(serial.Serial(os.ttyname(device), 115200, timeout=DEADLINE_S, write_timeout=DEADLINE_S))
        os.close(device)
        far.append(master)
    yield Cable(*ports, far)
    for port in ports:
        port.close()
    for master in far:
        os.close(master)


@pytest.fixture
def over_socket():
    """Two connections to a listener on the loopback, which joins them."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(DEADLINE_S)
        url = f"socket://127.0.0.1:{listener.getsockname()[1]}"
        far, ports = [], []
        for _ in range(2):
            ports.append(serial.serial_for_url(url, timeout=DEADLINE_S))
            far.append(listener.accept()[0])
        yield Cable(*ports, [end.fileno() for end in far])
        for port in ports:
            port.close()
        for end in far:
            end.close()


@pytest.fixture(params=["over_pty", "over_socket"])
def cable(request):
    return request.getfixturevalue(request.param)


class Cart(Motion):
    """Goes straight, 0.5 mm in each millisecond in which the slave wants it to."""

    wheel_count = 2

    def __init__(self):
        self.x_m = self.told_m = 0.0

    def take_increment(self):
        moved, self.told_m = self.x_m - self.told_m, self.x_m
        return Displacement(moved, 0.0, 0.0)


def run(core, base, cable, ticks, start=0):
    """Core and base at the ends of a cable; an answer reaches the core in the next tick."""
    answer = b""
    for tick in range(start, start + ticks):
        request = core.step(tick, answer)
        answer = base.receive(cable.to_base(request), tick) if request else b""
        answer = cable.to_core(answer) if answer else b""
        if base.alive(tick) and isinstance(base.motion, Cart):
            base.motion.x_m += base.wanted_twist.vx_mps * 0.001
    return start + ticks


def test_a_core_drives_our_base(cable):
    core, base = SlamwareCore(), SlamwareBase(reference_facts(), Cart())
    core.ask(BodyTwist(0.5, 0.0, 0.0))
    tick = run(core, base, cable, 1000)
    core.ask(BodyTwist(0.0, 0.0, 0.0))
    run(core, base, cable, 200, tick)
    assert core.connected
    assert base.motion.x_m > 0.4
    assert core.pose.x_m == pytest.approx(base.motion.x_m, abs=1e-6)
    assert core.errors == base.errors == {}
    assert core.timeouts == core.noise_bytes == core.unexpected == 0


def test_a_core_learns_everything_of_the_vendors_base(cable):
    core, base = SlamwareCore(schedule=FULL), as_reference_firmware()
    run(core, base, cable, 1500)
    known = core.known
    assert known.binary_configuration == reference_facts().binary_configuration
    assert known.configuration.radius_m == pytest.approx(0.18)
    assert None not in (known.power, known.motor_data, known.beacons, known.health)
    assert core.errors == {}
    assert core.timeouts == core.noise_bytes == core.unexpected == 0


@pytest.mark.parametrize("make", [lambda: SlamwareBase(reference_facts(), Cart()), as_reference_firmware])
def test_a_damaged_line_comes_back(cable, make):
    rng = random.Random(SEED)

    def hurt(data):
        if rng.random() >= 0.1:
            return data
        at = rng.randrange(len(data))
        return rng.choice([data[:at], data[:at] + data[at + 1 :], data[:at] + rng.randbytes(2) + data[at:]])

    core, base = SlamwareCore(schedule=FULL), make()
    cable.hurt = hurt
    tick = run(core, base, cable, 4000)
    assert core.timeouts
    assert core.noise_bytes or core.errors
    cable.hurt = lambda data: data
    tick = run(core, base, cable, 3000, tick)
    assert core.connected
    before = core.answers[0x41]
    run(core, base, cable, 1000, tick)
    assert core.answers[0x41] >= before + 19
