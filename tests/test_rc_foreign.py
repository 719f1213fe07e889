"""Protocols that are only recognised: their frames by the books, the recordings, and none in what is not theirs."""

import binascii

import pytest
from hypothesis import given
from hypothesis import strategies as st
from streams import KNOWN_RC

from bench.rc import foreign

RECORDED = {"foreign-dsmx-1": "dsm", "foreign-ghst-1": "ghst", "foreign-sumd-1": "sumd"}


@pytest.mark.parametrize("name", RECORDED)
def test_the_recordings_are_recognised_and_as_nothing_else(captures, name):
    data = (captures / "rc" / f"{name}.bin").read_bytes()
    shares = {protocol: foreign.share(protocol, data) for protocol in foreign.PROTOCOLS}
    assert shares.pop(RECORDED[name]) > 0.95
    assert set(shares.values()) == {0.0}


def sumd(words):
    body = bytes((0xA8, 0x01, len(words))) + b"".join(word.to_bytes(2, "big") for word in words)
    return body + binascii.crc_hqx(body, 0).to_bytes(2, "big")


def st24(data):
    body = bytes((len(data) + 2, 0)) + data
    crc = 0
    for byte in body:  # bit by bit, as a shift register
        for k in range(7, -1, -1):
            crc = ((crc << 1) ^ (0x07 if (crc >> 7 ^ byte >> k) & 1 else 0)) & 0xFF
    return b"\x55\x55" + body + bytes((crc,))


def dsm(values, half):
    words = [number << 11 | value for number, value in values]
    words[0] |= half << 15
    return b"\x00\x00" + b"".join(word.to_bytes(2, "big") for word in words)


DSM_HALVES = (
    dsm([(1, 1024), (5, 340), (2, 1024), (3, 1024), (0, 352), (7, 1024), (6, 1706)], 1),
    dsm([(1, 1024), (5, 340), (2, 1024), (3, 1024), (4, 1706), (8, 1024), (9, 1024)], 0),
)


@pytest.mark.parametrize(
    ("protocol", "frame"),
    [("sumd", sumd([0x2EE0] * 12)), ("st24", st24(bytes(range(20)))), ("dsm", b"".join(DSM_HALVES))],
    ids=["sumd", "st24", "dsm"],
)
def test_frames_by_the_books(protocol, frame):
    data = b"\x00\xff" + 4 * frame + b"\x01"
    assert foreign.share(protocol, data) == pytest.approx(4 * len(frame) / len(data))


@pytest.mark.parametrize("frame", [sumd([0x2EE0] * 12), st24(bytes(range(20)))], ids=["sumd", "st24"])
def test_a_wrong_bit_anywhere_is_no_frame(frame):
    protocol = "sumd" if frame[0] == 0xA8 else "st24"
    for k in range(8 * len(frame)):
        damaged = bytearray(frame)
        damaged[k // 8] ^= 1 << k % 8
        assert foreign.share(protocol, bytes(damaged)) == 0.0


def test_dsm_needs_numbers_of_different_channels_and_a_second_frame():
    assert foreign.share("dsm", DSM_HALVES[0]) == 0.0
    twice = dsm([(1, 1024), (1, 340), (2, 1024), (3, 1024), (0, 352), (7, 1024), (6, 1706)], 1)
    beyond = dsm([(1, 1024), (15, 340), (2, 1024), (3, 1024), (0, 352), (7, 1024), (6, 1706)], 1)
    assert foreign.share("dsm", 8 * twice) == foreign.share("dsm", 8 * beyond) == 0.0
    assert foreign.share("dsm", bytes(1600)) == 0.0


@pytest.mark.parametrize("path", sorted(KNOWN_RC.glob("*.bin")), ids=lambda path: path.stem)
def test_our_own_protocols_are_none_of_these(path):
    assert not any(foreign.share(protocol, path.read_bytes()) for protocol in foreign.PROTOCOLS)


@given(st.binary(max_size=300))
def test_any_bytes_have_a_share(data):
    assert all(0 <= foreign.share(protocol, data) <= 1 for protocol in foreign.PROTOCOLS)
