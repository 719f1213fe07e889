"""Exact bits of classic CAN frames: the golden frames, and every other frame against a slow reading of the standard."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.canbus.bits import frame_bits, frame_us, least_bits, stuff_bits, wire_bits, worst_bits

KNOWN = Path(__file__).parents[1] / "fixtures" / "known" / "can"
C610 = json.loads((KNOWN / "c610-frames.json").read_text())["frames"]

standard_ids = st.integers(0, 0x7FF)
# Long runs are what stuffing is about: bytes of ones and zeros more often than chance would have it.
payloads = st.lists(st.sampled_from([0, 0, 255, 255, 0x07, 0xF8, 0x55]) | st.integers(0, 255), max_size=8).map(bytes)


@pytest.mark.parametrize("frame", C610, ids=lambda frame: f"{frame['can_id']:03X} {frame['about']}")
def test_golden_frames_to_the_bit(frame):
    data = bytes.fromhex(frame["data"])
    assert stuff_bits(frame["can_id"], data) == frame["stuff_bits"]
    assert frame_bits(frame["can_id"], data) == frame["wire_bits"]
    assert frame_us(frame["can_id"], data) == frame["wire_bits"]
    assert frame_us(frame["can_id"], data, bitrate=500_000) == 2 * frame["wire_bits"]


def test_the_two_golden_tables_are_all_there():
    assert [frame["wire_bits"] for frame in C610] == [126, 127, 124, 123, 121, 116, 125, 119, 119, 125]


def header(can_id, data, extended, remote_length):
    """Start bit to data, drawn field by field as the standard draws it."""
    remote = int(remote_length is not None)
    length = len(data) if remote_length is None else remote_length
    bits = "0"
    if extended:
        bits += f"{can_id:029b}"[:11] + "11" + f"{can_id:029b}"[11:] + str(remote) + "00"
    else:
        bits += f"{can_id:011b}" + str(remote) + "00"
    return bits + f"{length:04b}" + "".join(f"{byte:08b}" for byte in data)


def checksum(bits):
    """Long division by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1."""
    rest = [int(bit) for bit in bits + "0" * 15]
    divisor = [int(bit) for bit in "1100010110011001"]
    for place in range(len(bits)):
        if rest[place]:
            for i, bit in enumerate(divisor):
                rest[place + i] ^= bit
    return "".join(map(str, rest[-15:]))


def destuffed(wire):
    """A receiver: after five alike the next bit is dropped, and it must be the other one."""
    bits, at = "", 0
    last, run = "", 0
    while at < len(wire):
        bit = wire[at]
        run = run + 1 if bit == last else 1
        last = bit
        bits += bit
        at += 1
        if run == 5 and at < len(wire):
            assert wire[at] != bit, "six alike"
            last, run = wire[at], 1
            at += 1
    return bits


@given(st.data(), payloads, st.booleans(), st.booleans())
def test_a_receiver_gets_back_what_was_sent(data, payload, extended, is_remote):
    can_id = data.draw(st.integers(0, 0x1FFFFFFF) if extended else standard_ids)
    remote_length = data.draw(st.integers(0, 8)) if is_remote else None
    payload = b"" if is_remote else payload
    wire = wire_bits(can_id, payload, extended=extended, remote_length=remote_length)
    assert wire.endswith("1011111111111"), "delimiter, acknowledge, delimiter, seven of end, three of gap"
    raw = header(can_id, payload, extended, remote_length)
    assert destuffed(wire[:-13]) == raw + checksum(raw)
    options = {"extended": extended, "remote_length": remote_length}
    assert frame_bits(can_id, payload, **options) == len(wire)
    assert stuff_bits(can_id, payload, **options) == len(wire) - 13 - len(raw) - 15
    length = len(payload)
    assert least_bits(length, extended=extended) <= len(wire) <= worst_bits(length, extended=extended)


@pytest.mark.parametrize("can_id", [0x15555555, 0x0AAAAAAA, 0x1FFFFFFF, 0])
def test_stuffing_begins_with_the_first_bits_of_an_identifier(can_id):
    wire = wire_bits(can_id, b"ab", extended=True)
    assert destuffed(wire[:-13])[:-15] == header(can_id, b"ab", True, None)
    assert frame_bits(can_id, b"ab", extended=True) == len(wire)


def test_bounds_of_eight_bytes():
    assert (least_bits(8), worst_bits(8)) == (111, 135)
    assert (least_bits(0), worst_bits(0)) == (47, 55)
    assert (least_bits(8, extended=True), worst_bits(8, extended=True)) == (131, 160)


def test_a_stuff_bit_may_follow_the_last_bit_of_the_checksum():
    ids = (can_id for can_id in range(2048) if checksum(header(can_id, b"", False, None)).endswith("0100000"))
    assert wire_bits(next(ids))[:-13].endswith("000001")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"can_id": 0x800}, "identifier 0x800 outside 0..0x7ff"),
        ({"can_id": -1}, "identifier -0x1 outside"),
        ({"can_id": 1 << 29, "extended": True}, "outside 0..0x1fffffff"),
        ({"can_id": 1, "data": bytes(9)}, "length 9 outside 0..8"),
        ({"can_id": 1, "remote_length": 9}, "length 9 outside 0..8"),
        ({"can_id": 1, "remote_length": -1}, "length -1 outside 0..8"),
        ({"can_id": 1, "data": b"x", "remote_length": 1}, "a remote frame carries no data"),
    ],
)
def test_what_is_no_classic_frame_is_refused(arguments, says):
    with pytest.raises(ValueError, match=says):
        frame_bits(**arguments)


@pytest.mark.parametrize("length", [9, -1])
def test_bounds_refuse_a_length_that_does_not_exist(length):
    with pytest.raises(ValueError, match=rf"length {length} outside 0\.\.8"):
        worst_bits(length)
