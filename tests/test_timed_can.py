"""The bus with time as python-can's programs see it: an interface like any other, in real time."""

import gc
import os
import threading
import time
from contextlib import contextmanager
from itertools import pairwise

import can
import pytest
from patience import DEADLINE_S

from bench.canbus.bits import frame_bits
from bench.config import load_robot
from bench.io import timed_can
from bench.io.can_port import open_can
from bench.io.clock import now_ns
from bench.io.emulated.devices import EscsOnBus
from bench.m2006 import decode_feedback, encode_command

BITRATE = 50_000  # a frame lasts 2.5 ms


@pytest.fixture
def node(request):
    """Opens nodes of a channel of this test alone."""
    opened = []

    def join(bitrate=BITRATE, **options):
        opened.append(can.Bus(request.node.name, interface="wheelbench", bitrate=bitrate, **options))
        return opened[-1]

    yield join
    for bus in opened:
        bus.shutdown()


@pytest.fixture
def clock(monkeypatch):
    """The wires' clock. While it stands, all that is sent is sent at that instant, however busy the machine is."""

    class Clock:
        behind_ns, stood_ns = 0, None

        def __call__(self):
            return now_ns() - self.behind_ns if self.stood_ns is None else self.stood_ns

        @contextmanager
        def stands(self):
            self.stood_ns = self()
            try:
                yield
            finally:
                self.behind_ns, self.stood_ns = now_ns() - self.stood_ns, None

        def pass_ms(self, milliseconds):
            self.stood_ns += int(1e6 * milliseconds)

    made = Clock()
    monkeypatch.setattr(timed_can, "now_ns", made)
    return made


def message(can_id, data=bytes(8), **more):
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **more)


def test_python_can_knows_it_by_its_name():
    assert "wheelbench" in can.VALID_INTERFACES


def test_what_one_sends_the_others_hear_when_it_is_through(node):
    one, two, three = node(), node(), node()
    began = time.monotonic()
    one.send(message(0x201, b"\x01\x02\x03"))
    heard = two.recv(DEADLINE_S)
    took_s = time.monotonic() - began
    assert (heard.arbitration_id, bytes(heard.data), heard.is_rx) == (0x201, b"\x01\x02\x03", True)
    assert took_s >= (frame_bits(0x201, b"\x01\x02\x03") - 4) / BITRATE, "not before its last bit"
    assert three.recv(DEADLINE_S).timestamp == heard.timestamp
    assert one.recv(0) is None, "a node does not hear itself"
    own = node(receive_own_messages=True)
    own.send(message(0x100))
    assert own.recv(DEADLINE_S).is_rx is False


def test_a_burst_goes_back_to_back_and_by_urgency(node, clock):
    """Three nodes have queues full before the first frame is through: the wire takes the most urgent head each time."""
    ears = node()
    senders = {first: node() for first in (0x300, 0x100, 0x200)}
    with clock.stands():
        senders[0x300].send(message(0x7FF))  # takes the wire for 2.5 ms, in which all the others queue up
        clock.pass_ms(1)
        for first, bus in senders.items():
            for k in range(3):
                bus.send(message(first + k, bytes([k] * 8)))
    heard = [ears.recv(DEADLINE_S) for _ in range(10)]
    assert [one.arbitration_id for one in heard] == [
        0x7FF, 0x100, 0x101, 0x102, 0x200, 0x201, 0x202, 0x300, 0x301, 0x302,
    ]  # fmt: skip
    for before, after in pairwise(heard):
        bits = (after.timestamp - before.timestamp) * BITRATE
        assert bits == pytest.approx(frame_bits(after.arbitration_id, bytes(after.data)), abs=0.01)


def test_a_full_queue_refuses_and_with_patience_takes(node, clock):
    bus = node(tx_frames=3)
    ears = node()
    with clock.stands():
        for k in range(4):
            bus.send(message(0x100 + k))
            clock.pass_ms(0.1)  # the first is on the wire
        with pytest.raises(can.CanOperationError, match="3 frames wait already"):
            bus.send(message(0x200))
    bus.send(message(0x2FF), timeout=DEADLINE_S)
    heard = []
    while not heard or heard[-1] != 0x2FF:
        heard.append(ears.recv(DEADLINE_S).arbitration_id)
    assert heard == [0x100, 0x101, 0x102, 0x103, 0x2FF]


def test_extended_and_remote_frames_and_what_is_none(node):
    one, two = node(), node()
    one.send(can.Message(arbitration_id=0x12345678, is_extended_id=True, data=b"\x09"))
    one.send(message(0x55, b"", is_remote_frame=True, dlc=4))
    first, second = two.recv(DEADLINE_S), two.recv(DEADLINE_S)
    assert (first.arbitration_id, first.is_extended_id, bytes(first.data)) == (0x12345678, True, b"\x09")
    assert (second.arbitration_id, second.is_remote_frame, second.dlc) == (0x55, True, 4)
    with pytest.raises(can.CanOperationError, match="classic"):
        one.send(message(0x1, is_fd=True))


def test_python_cans_own_threads_and_filters_work_on_it(node):
    """A Notifier listens, a periodic task sends: what programs are made of."""
    bus, ears = node(bitrate=1_000_000), node(bitrate=1_000_000, can_filters=[{"can_id": 0x200, "can_mask": 0x7FF}])
    got, enough = [], threading.Event()

    def take(one):
        got.append(one)
        if len(got) >= 5:
            enough.set()

    notifier = can.Notifier(ears, [take])
    task = bus.send_periodic(message(0x200), 0.01)
    other = bus.send_periodic(message(0x300), 0.01)
    try:
        assert enough.wait(DEADLINE_S)
    finally:
        task.stop()
        other.stop()
        notifier.stop()
    assert {one.arbitration_id for one in got} == {0x200}


def test_a_wire_has_one_bitrate_and_ends_with_its_last_node(node):
    one = node()
    with pytest.raises(can.CanInitializationError, match="runs at 50000 bit/s, not 125000"):
        node(bitrate=125_000)
    one.shutdown()
    assert node(bitrate=125_000).channel_info.endswith("125000 bit/s")
    with pytest.raises(can.CanInitializationError, match="1000 to 1000000"):
        node(bitrate=2_000_000)


def test_who_waits_for_nothing_waits_as_long_as_was_said(node):
    bus = node()
    began = time.monotonic()
    assert bus.recv(0.05) is None
    assert time.monotonic() - began >= 0.05
    assert bus.load == 0.0


def test_the_bench_and_a_driver_meet_on_it(request):
    """Our emulated motors on `can:wheelbench:NAME@BITRATE`, somebody's driver beside them."""
    name = request.node.name
    escs = EscsOnBus(load_robot("m2006"), open_can("escs", f"can:wheelbench:{name}@1000000?tx_frames=64"))
    with can.Bus(name, interface="wheelbench", bitrate=1_000_000) as driver:
        reports = {}
        deadline = time.monotonic() + DEADLINE_S
        tick = 0
        while reports.get(0x201, (0, 0, 0))[1] < 100:
            assert time.monotonic() < deadline, reports
            driver.send(message(0x200, encode_command((600, 0, 0, 0))), timeout=DEADLINE_S)
            escs.step(tick)
            tick += 1
            while (heard := driver.recv(0)) is not None:
                reports[heard.arbitration_id] = decode_feedback(bytes(heard.data))
        assert set(reports) == {0x201, 0x202, 0x203}
        assert driver.load > 0.0
    escs.close()


def test_shutdown_ends_a_thread_that_waits_and_says_so_to_others(node):
    bus = node()
    ended = []

    def wait(what):
        with pytest.raises(can.CanOperationError, match="is shut down"):
            what()
        ended.append(what)

    threads = [
        threading.Thread(target=wait, args=(what,), daemon=True) for what in (bus.recv, lambda: bus.recv(DEADLINE_S))
    ]
    for thread in threads:
        thread.start()
    time.sleep(0.05)
    bus.shutdown()
    for thread in threads:
        thread.join(DEADLINE_S)
    assert len(ended) == 2
    for late in (lambda: bus.recv(0), lambda: bus.send(message(0x1))):
        wait(late)
    bus.shutdown()


def test_two_threads_of_one_bus_send_and_receive_and_nothing_is_lost_or_doubled(node):
    one, two = node(bitrate=1_000_000), node(bitrate=1_000_000)
    got, all_sent = [], threading.Event()

    def send(first):
        for k in range(100):
            one.send(message(first, k.to_bytes(8, "big")), timeout=DEADLINE_S)

    def receive():
        while True:
            is_last = all_sent.is_set() and one._wire.bus.next_end is None
            if (heard := two.recv(0.02)) is not None:
                got.append((heard.arbitration_id, int.from_bytes(heard.data, "big")))
            elif is_last:
                return

    senders = [threading.Thread(target=send, args=(can_id,), daemon=True) for can_id in (0x100, 0x200)]
    receivers = [threading.Thread(target=receive, daemon=True) for _ in range(2)]
    for thread in (*senders, *receivers):
        thread.start()
    for thread in senders:
        thread.join(DEADLINE_S)
    all_sent.set()
    for thread in receivers:
        thread.join(DEADLINE_S)
    assert sorted(got) == [(can_id, k) for can_id in (0x100, 0x200) for k in range(100)]


def test_who_does_not_receive_loses_the_newest_and_can_tell(node):
    deaf, one = node(bitrate=1_000_000, rx_frames=3), node(bitrate=1_000_000)
    for k in range(5):
        one.send(message(0x100 + k), timeout=DEADLINE_S)
    while one._wire.bus.next_end is not None:
        assert one.recv(0.002) is None
    assert [deaf.recv(0).arbitration_id for _ in range(3)] == [0x100, 0x101, 0x102]
    assert deaf.recv(0) is None
    assert deaf.overruns == 2
    with pytest.raises(can.CanInitializationError, match="rx_frames 0"):
        node(rx_frames=0)


def test_a_bus_that_nobody_holds_any_more_leaves_the_wire(request):
    name = request.node.name
    forgotten = can.Bus(name, interface="wheelbench", bitrate=125_000)
    forgotten.send(message(0x1))
    del forgotten
    gc.collect()
    with can.Bus(name, interface="wheelbench", bitrate=250_000) as other:  # another bitrate: the old wire is gone
        assert len(other._wire.nodes) == 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_has_a_wire_of_its_own(node):
    """Its parent waits in `recv` and holds locks as it likes; the child sends, receives and ends."""
    one, two = node(), node()
    thread = threading.Thread(target=lambda: two.recv(DEADLINE_S), daemon=True)
    held = threading.Event(), threading.Event()

    def hold():
        with one._wire.changed:
            held[0].set()
            held[1].wait(DEADLINE_S)

    holder = threading.Thread(target=hold, daemon=True)
    thread.start()
    holder.start()
    held[0].wait(DEADLINE_S)
    child = os.fork()
    if child == 0:
        one.send(message(0x123))
        os._exit(0 if two.recv(DEADLINE_S).arbitration_id == 0x123 else 1)
    held[1].set()
    deadline = time.monotonic() + DEADLINE_S
    while (ended := os.waitpid(child, os.WNOHANG)) == (0, 0) and time.monotonic() < deadline:
        time.sleep(0.01)
    if ended == (0, 0):
        os.kill(child, 9)
        os.waitpid(child, 0)
    assert ended == (child, 0), "the child is stuck, or heard nothing"
    one.send(message(0x1))
    thread.join(DEADLINE_S)
