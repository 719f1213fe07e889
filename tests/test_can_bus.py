"""A CAN bus in bit times: arbitration against the bits of the standard, times and loads against arithmetic."""

from itertools import pairwise
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.canbus.bits import frame_bits, wire_bits
from bench.timed.can_bus import Arbitration, Frame, Mailboxes, Queue


def arbitration_field(frame: Frame) -> str:
    """Identifier, remote request and extension bits as ISO 11898-1 puts them on the wire; 0 is dominant."""
    remote = "01"[frame.remote_length is not None]
    if frame.extended:
        bits = f"{frame.can_id:029b}"
        return bits[:11] + "11" + bits[11:] + remote
    return f"{frame.can_id:011b}" + remote + "0"


def wired_and(fields: list[str]) -> int:
    """Who is left when each that sends a recessive bit and sees a dominant one gives up."""
    left = list(range(len(fields)))
    for at in range(max(map(len, fields))):
        level = min(fields[one][at] if at < len(fields[one]) else "1" for one in left)
        left = [one for one in left if at >= len(fields[one]) or fields[one][at] == level]
    return left[0]


def some_frame(random: Random) -> Frame:
    near = random.choice((0x200, 0x1FF, random.randrange(0x800)))  # identifiers that differ late are the hard ones
    if random.random() < 0.4:
        can_id = near << 18 | random.choice((0, 1, random.randrange(1 << 18)))
        return Frame(can_id, b"", True, random.choice((None, 0, 8)))
    return Frame(near, b"", False, random.choice((None, None, 0, 8)))


def test_the_wire_decides_bit_by_bit_in_100_000_random_sets():
    """Every set in its whole order: the frame that wins among those that are left is the one that goes next."""
    random = Random(11898)
    for number in range(100_000):
        frames = {frame.urgency: frame for frame in (some_frame(random) for _ in range(random.randint(2, 6)))}
        ours = [frames[urgency] for urgency in sorted(frames)]
        fields = [arbitration_field(frame) for frame in ours]
        assert len(set(fields)) == len(fields), "what is as urgent is the same frame on the wire"
        if number % 10:  # the order of strings of 0 and 1 is what a wired AND decides; every tenth set bit by bit
            assert fields == sorted(fields)
        else:
            while len(fields) > 1:
                assert wired_and(fields) == 0
                fields.pop(0)


def test_the_order_of_neighbours():
    """ISO 11898-1: identifier, request, extension, the rest of a long identifier, its request; 0 goes first."""
    order = [
        Frame(0x1FF, b""),
        Frame(0x200, b""),
        Frame(0x200, b"", remote_length=0),
        Frame(0x200 << 18, b"", True),
        Frame(0x200 << 18, b"", True, 0),
        Frame(0x200 << 18 | 0x00001, b"", True),
        Frame(0x200 << 18 | 0x00002, b"", True),
        Frame(0x200 << 18 | 0x20000, b"", True),
        Frame(0x200 << 18 | 0x3FFFF, b"", True),
        Frame(0x201, b""),
        Frame(0x201 << 18, b"", True),
    ]
    fields = [arbitration_field(frame) for frame in order]
    assert fields == sorted(fields)
    assert sorted(reversed(order), key=lambda frame: frame.urgency) == order


def test_a_bus_sends_in_that_order_and_back_to_back():
    random = Random(3)
    for _ in range(1000):
        frames = {frame.urgency: frame for frame in (some_frame(random) for _ in range(random.randint(1, 6)))}
        bus = Arbitration()
        for frame in random.sample(list(frames.values()), len(frames)):
            bus.join(Mailboxes()).offer(0, frame)
        sent = bus.run(until=1_000_000)
        assert [one.frame for one in sent] == [frames[urgency] for urgency in sorted(frames)]
        begins = 0
        for one in sent:
            assert (one.begin, one.end) == (begins, begins + one.frame.bits - 3)
            begins += one.frame.bits


def test_a_frame_that_has_begun_is_not_interrupted():
    """The urgent one comes a bit too late, and then before the other that has waited longer."""
    bus = Arbitration()
    patient, urgent = bus.join(Mailboxes()), bus.join(Mailboxes())
    patient.offer(0, Frame(0x7FF, bytes(8)))
    patient.offer(0, Frame(0x700, bytes(8)))
    urgent.offer(1, Frame(0x001, bytes(8)))
    assert [(one.begin, one.frame.can_id) for one in bus.run(until=10_000)] == [
        (0, 0x700),
        (frame_bits(0x700, bytes(8)), 0x001),
        (frame_bits(0x700, bytes(8)) + frame_bits(0x001, bytes(8)), 0x7FF),
    ]


def test_who_hears_a_frame_hears_it_when_its_last_bit_is_through():
    bus = Arbitration()
    node = bus.join(Mailboxes())
    node.offer(100, Frame(0x201, b"\x01\x02"))
    end = 100 + len(wire_bits(0x201, b"\x01\x02")) - 3
    assert bus.run(until=end - 1) == []
    assert bus.next_end == end
    assert [one.end for one in bus.run(until=end)] == [end]
    assert bus.next_end is None


def test_who_comes_when_the_wire_is_looked_at_still_takes_part():
    bus = Arbitration()
    node = bus.join(Mailboxes())
    node.offer(100, Frame(0x700, b""))
    assert bus.run(until=100) == []
    node.offer(100, Frame(0x001, b""))
    assert [one.frame.can_id for one in bus.run(until=1000)] == [0x001, 0x700]


def test_who_leaves_takes_along_what_has_not_begun():
    bus = Arbitration()
    gone, other = bus.join(Queue(9)), bus.join(Mailboxes())
    for can_id in (0x100, 0x101):
        gone.offer(0, Frame(can_id, b""))
    other.offer(10, Frame(0x300, b""))
    bus.run(until=20)
    bus.leave(gone)
    assert [one.frame.can_id for one in bus.run(until=1000)] == [0x100, 0x300]
    assert bus.next_end is None


def test_how_long_the_wire_was_taken_ends_with_the_time_asked_for():
    """0x555 and eight bytes 0x55 need no stuff bit before the checksum: at least the 108 bits of the standard."""
    bus, frame = Arbitration(), Frame(0x555, b"\x55" * 8)
    bits = len(wire_bits(0x555, b"\x55" * 8))
    assert 108 + 3 <= bits <= 108 + 3 + 4
    node = bus.join(Mailboxes())
    assert bus.busy_until(50) == 0
    node.offer(100, frame)
    taken = []
    for now in (100, 101, 150, 100 + bits - 1, 100 + bits, 1000):
        bus.run(until=now)
        taken.append(bus.busy_until(now))
    assert taken == [0, 1, 50, bits - 1, bits, bits]


def test_a_newer_value_takes_the_place_of_one_that_waits():
    bus = Arbitration()
    node = bus.join(Mailboxes())
    for value in range(5):
        node.offer(value, Frame(0x201, bytes([value])))
    assert node.lost == 4
    assert [one.frame.data for one in bus.run(until=1000)] == [b"\x04"]
    node.offer(1000, Frame(0x201, b"\x05"))
    bus.run(until=1010)  # it has begun
    node.offer(1010, Frame(0x201, b"\x06"))
    assert [one.frame.data for one in bus.run(until=2000)] == [b"\x05", b"\x06"]
    assert node.lost == 4
    assert [node.offer(2000, Frame(can_id, b"")) for can_id in (0x201, 0x202, 0x201)] == [True, True, False]


def test_a_queue_keeps_its_order_and_has_an_end():
    bus = Arbitration()
    queue, other = bus.join(Queue(2)), bus.join(Mailboxes())
    assert [queue.offer(0, Frame(can_id, b"")) for can_id in (0x600, 0x001, 0x002)] == [True, True, False]
    other.offer(0, Frame(0x300, b""))
    assert [one.frame.can_id for one in bus.run(until=1000)] == [0x300, 0x600, 0x001]
    assert queue.lost == 1


@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8), st.integers(0, 5000)), max_size=40), st.data())
def test_however_it_is_looked_at_the_wire_is_the_same(frames, data):
    """Run in one go, and in steps of any size: the same frames at the same times, never two at once, none lost."""

    def run(stops):
        bus = Arbitration()
        queues = [bus.join(Queue(len(frames) + 1)) for _ in range(3)]
        for number, (can_id, payload, at) in enumerate(sorted(frames, key=lambda frame: frame[2])):
            queues[number % 3].offer(at, Frame(can_id, payload))
        return [sent for stop in stops for sent in bus.run(stop)], bus

    far = 100_000
    whole, bus = run([far])
    pieces, _ = run([*sorted(data.draw(st.lists(st.integers(0, 15_000), max_size=20))), far])
    assert [(one.begin, one.end, one.frame) for one in whole] == [(one.begin, one.end, one.frame) for one in pieces]
    assert len(whole) == len(frames)
    for before, after in pairwise(whole):
        assert after.begin >= before.end + 3
    assert bus.busy_bits == sum(frame_bits(can_id, payload) for can_id, payload, _ in frames)


@pytest.mark.parametrize(("bitrate", "motors"), [(1_000_000, 3), (1_000_000, 6), (500_000, 3), (250_000, 1)])
def test_the_load_is_that_of_arithmetic(bitrate, motors):
    """A command and so many reports each millisecond for ten seconds: within 0.1 % of bits times rate."""
    random = Random(7)
    bus = Arbitration()
    base, escs = bus.join(Mailboxes()), bus.join(Mailboxes())
    bits, per_tick, ticks = 0, bitrate // 1000, 10_000
    for tick in range(ticks):
        frames = [Frame(0x200, random.randbytes(8))]
        frames += [Frame(0x201 + motor, random.randbytes(6) + bytes(2)) for motor in range(motors)]
        for frame in frames:
            (base if frame.can_id == 0x200 else escs).offer(tick * per_tick, frame)
            bits += frame_bits(frame.can_id, frame.data)
        bus.run(until=(tick + 1) * per_tick)
    assert base.lost == escs.lost == 0
    assert bus.busy_bits / (ticks * per_tick) == pytest.approx(bits * 1000 / ticks / bitrate, rel=1e-3)


def test_asking_when_the_next_frame_ends_begins_none():
    """What is offered in the gap after a frame takes part in the next arbitration, whoever has looked ahead."""
    bus = Arbitration()
    patient, urgent = bus.join(Queue(9)), bus.join(Queue(9))
    patient.offer(0, Frame(0x300, b""))
    (first,) = bus.run(bus.next_end)
    patient.offer(first.end, Frame(0x400, b""))
    assert bus.next_end == first.end + 3 + frame_bits(0x400, b"") - 3
    urgent.offer(first.end + 1, Frame(0x100, b""))
    assert [one.frame.can_id for one in bus.run(1000)] == [0x100, 0x400]
