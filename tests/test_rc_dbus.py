"""DBUS has no header and no checksum: where frames begin, against a slow reading of the rules in `bench.rc.dbus`."""

import random

import pytest
import streams

from bench import rc_decode
from bench.messages import RcFrame, RcNoise

AT_REST = (1024, 1024, 1024, 1024, 3, 1, 0, 0, 0, 0, 0, 0, 1024)
MOVED = (1100, 900, 1300, 1024, 3, 1, 0, 0, 0, 0, 0, 0, 1024)

# Plausible frames that are plausible again when they are turned by so many bytes: repeated, they can be read twice.
TWO_READINGS = {
    1: bytes.fromhex("07849d1071a8661701000001010100010000"),
    2: bytes.fromhex("cb029923539ce9740000b82a000101010100"),
    4: bytes.fromhex("c621d205b57ce2f232db0000000000010001"),
    13: bytes.fromhex("64ec62e336d80000000101000000abdd0101"),
    14: bytes.fromhex("059aaefc46e80000010000000101df53a600"),
    16: bytes.fromhex("ad991f9ab1fb000000010000000101010004"),
    17: bytes.fromhex("05abab2e9baa0000000100000000e62e0000"),
}


def dbus(*values):
    return rc_decode.encode("dbus", values)


def turned(frame, count):
    return frame[count:] + frame[:count]


# --- what is plausible ---------------------------------------------------------------------------------------------


def changed(at, value):
    frame = bytearray(dbus(*AT_REST))
    frame[at] = value
    return bytes(frame)


@pytest.mark.parametrize("at", [12, 13])
def test_a_mouse_button_is_0_or_1(at):
    for value in (0, 1, 2, 3, 255):
        (event,) = streams.feed_whole(rc_decode.decoder("dbus"), changed(at, value))
        if value < 2:
            assert event.channels[9 + at - 12] == value
        else:
            assert event == RcNoise(0, 18, "range")


def test_the_wheel_has_11_bits():
    for high, expected in ((0x07, 0x7FF), (0x08, None), (0x80, None)):
        frame = changed(16, 0xFF if expected else 0x00)[:17] + bytes((high,))
        (event,) = streams.feed_whole(rc_decode.decoder("dbus"), frame)
        assert event == (RcFrame(0, 18, (*AT_REST[:12], expected)) if expected else RcNoise(0, 18, "range"))


# --- where frames begin --------------------------------------------------------------------------------------------


def plausible(data, at):
    """The four sticks of a frame at `at`, read field by field from the table of bits; None where there is none."""
    frame = data[at : at + 18]
    if len(frame) < 18:
        return None
    bits = "".join(f"{byte:08b}"[::-1] for byte in frame[:6])  # lowest bit first, as on the wire
    sticks = tuple(int(bits[k : k + 11][::-1], 2) for k in (0, 11, 22, 33))
    switches = bits[44:46], bits[46:48]
    if "00" in switches or not all(364 <= raw <= 1684 for raw in sticks):
        return None
    if frame[12] > 1 or frame[13] > 1 or frame[17] > 7:
        return None
    return sticks


def slow_reading(bursts):
    """Offsets of the frames in bursts with silence between them, by the rules, one after the other."""
    found, base, sticks, frame_end = [], 0, (1024,) * 4, None
    for burst in bursts:

        def row(at, count, burst=burst):
            return all(plausible(burst, at + 18 * k) for k in range(count))

        def moved(at, sticks, burst=burst):
            return sum(abs(raw - last) for raw, last in zip(plausible(burst, at), sticks, strict=True))

        at = 0
        while at + 18 <= len(burst):
            left = len(burst) - at
            if plausible(burst, at) is None:
                believed = False
            elif left == 18:
                believed = True  # nothing follows, and nothing can
            elif at == 0 and left < 36:
                believed = False  # bytes have come from nowhere, or are gone
            else:
                expected = at == 0 or base + at == frame_end
                followed = row(at + 18, 1)
                inside = [k for k in range(at + 1, at + 18) if row(k, 2 if expected else 3)]
                # At the end of a burst two plausible frames are all that can follow each other.
                alone = expected or row(at, 3) or (followed and left < 54)
                nearer = [k for k in inside if moved(k, sticks) < moved(at, sticks)]
                believed = (expected and followed) or (alone and not nearer)
            if believed:
                found.append(base + at)
                sticks, frame_end = plausible(burst, at), base + at + 18
                at += 18
            else:
                at += 1
        base += len(burst)
    return found


def awkward_stream(rng):
    """A few frames, most of which can be read twice, some damaged, with bytes lost and bytes from nowhere."""
    data = bytearray()
    for _ in range(rng.randint(1, 4)):
        turn, frame = rng.choice(list(TWO_READINGS.items()))
        frame = rng.choice((frame, turned(frame, turn), dbus(*AT_REST), dbus(*MOVED)))
        data += frame * rng.randint(1, 5)
        damage = rng.randrange(5)
        if damage == 0:
            del data[rng.randrange(len(data))]
        elif damage == 1:
            data[rng.randrange(len(data))] = rng.choice((0, 1, 255))
        elif damage == 2:
            data += bytes(rng.randint(1, 18))
    return bytes(data[rng.choice((0, 0, 1, 5)) :])


def offsets(events):
    return [event.offset for event in events if isinstance(event, RcFrame)]


def test_without_times_frames_are_found_where_the_rules_find_them():
    rng = random.Random("dbus")
    frames = 0
    for _ in range(250):
        data = awkward_stream(rng)
        expected = slow_reading([data])
        decoder = rc_decode.decoder("dbus")
        assert offsets(decoder.feed(data) + decoder.finish()) == expected, data.hex()
        frames += len(expected)
    assert frames > 600


def test_silence_ends_a_burst_and_the_rules_begin_anew():
    rng = random.Random("dbus bursts")
    for _ in range(120):
        bursts = [awkward_stream(rng)[: rng.choice((18, 19, 36, 54, 200))] for _ in range(3)]
        decoder, events = rc_decode.decoder("dbus", pause_us=2000), []
        for k, burst in enumerate(bursts):
            events += decoder.feed(burst, [1e6 * k] * len(burst))
        assert offsets(events + decoder.finish()) == slow_reading(bursts), [burst.hex() for burst in bursts]


def test_cutting_an_awkward_stream_changes_nothing():
    rng = random.Random("dbus cuts")
    for _ in range(8):
        data = awkward_stream(rng)
        streams.check_stream(lambda: rc_decode.decoder("dbus"), data)


@pytest.mark.parametrize("turn", TWO_READINGS)
def test_of_two_readings_that_one_is_taken_whose_sticks_are_nearer_to_the_middle(turn):
    frame = TWO_READINGS[turn]
    distance = {
        k: sum(abs(raw - 1024) for raw in plausible(turned(frame, k), 0)) for k in range(18) if plausible(frame * 2, k)
    }
    nearest = min(distance, key=distance.__getitem__)
    for start in distance:
        data = turned(frame, start) * 8
        # A byte from nowhere, so that no place is the expected one. It must not begin a third reading.
        for stray in (b"\x00", b"\xff"):
            if plausible(stray + data, 0) is None:
                events = streams.feed_whole(rc_decode.decoder("dbus"), stray + data)
                assert (offsets(events)[0] - 1 + start) % 18 == nearest


def test_a_switch_that_moves_makes_no_reading_less_near():
    frame = TWO_READINGS[4]
    last = dbus(1205, 600, 1047, 1626, 1, 1, 0, 0, 0, 0, 0, 0, 1024)
    here, other = plausible(frame, 0), plausible(turned(frame, 4), 0)
    moved = [sum(abs(raw - was) for raw, was in zip(to, plausible(last, 0), strict=True)) for to in (here, other)]
    assert moved[0] <= moved[1] <= moved[0] + 1
    events = streams.feed_whole(rc_decode.decoder("dbus"), last * 2 + b"\xff" + frame * 8)
    assert offsets(events) == [0, 18, *range(37, 37 + 8 * 18, 18)]


def test_a_frame_is_delivered_with_the_byte_that_settles_it():
    one, two = dbus(*AT_REST), dbus(*MOVED)
    # Expected and followed by a plausible one: when that is whole. After a stray byte: when no place inside of the
    # first frame can begin three in a row that are not known yet, 17 bytes further than its own three.
    for stray, settled in ((b"", 36), (b"\xff", 1 + 17 + 54)):
        decoder = rc_decode.decoder("dbus")
        data = stray + one + two * 5
        assert offsets(decoder.feed(data[: settled - 1])) == []
        assert offsets(decoder.feed(data[settled - 1 : settled]))[:1] == [len(stray)]


def test_a_frame_before_a_damaged_one_is_believed_when_nothing_inside_it_can_begin_two():
    one, damaged = dbus(*AT_REST), bytes(18)
    decoder = rc_decode.decoder("dbus")
    data = one + damaged + one * 2
    assert offsets(decoder.feed(data[:52])) == []
    assert offsets(decoder.feed(data[52:53])) == [0]


def test_a_burst_of_too_many_bytes_has_no_successor():
    decoder = rc_decode.decoder("dbus")
    decoder.feed(dbus(*MOVED) + b"\x00", 0)
    assert decoder.feed(b"", 10_000) == [RcNoise(0, 19, "successor")]
