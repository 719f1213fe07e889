"""RC protocols that we do not decode, recognised: so that a file of theirs gets its name, not "no frame".

    dsm    Spektrum DSM2, DSMX satellite   115200 8N1   16 bytes: 2 of status, 7 words  PIII IVVV VVVV VVVV (or 10 bit)
    sumd   Graupner SUMD                   115200 8N1   A8, 01 (or 81: failsafe), n, n words, CRC-16
    st24   Yuneec ST24                     115200 8N1   55 55, length, type, data, CRC-8 (07) from the length on
    ghst   ImmersionRC Ghost               420000 8N1   82 or 89, length, type, data, CRC-8 (D5) from the type on

P in the first word of DSM: the second half of the channels; I: the channel's number. DSM has no checksum, so two frames
must follow each other, and their numbers must be possible ones, none of them twice.
"""

from __future__ import annotations

import binascii
from collections.abc import Callable, Mapping
from struct import Struct

from bench.rc.crsf import crc8

_WORDS = Struct(">7H")
_DSM_LENGTH, _DSM_CHANNELS, _DSM_UNUSED = 16, 12, 0xFFFF
_GHST_ADDRESSES = (0x82, 0x89)


def share(protocol: str, data: bytes) -> float:
    """Of all bytes, those in good frames of one of `PROTOCOLS`."""
    length_at = _LENGTH_AT[protocol]
    at = good = 0
    while at < len(data):
        length = length_at(data, at)
        good += length
        at += length or 1
    return good / len(data) if data else 0.0


def _dsm(data: bytes, at: int) -> int:
    """How long the frame at `at` is; 0 if there is none. So the other three."""
    later, earlier = _dsm_words(data, at + _DSM_LENGTH), _dsm_words(data, at - _DSM_LENGTH)
    return _DSM_LENGTH if _dsm_words(data, at) and (later or earlier) else 0


def _dsm_words(data: bytes, at: int) -> bool:
    """Whether seven words stand there with the numbers of different channels, in one of the two resolutions."""
    if at < 0 or at + _DSM_LENGTH > len(data):
        return False
    words = [word for word in _WORDS.unpack_from(data, at + 2) if word != _DSM_UNUSED]
    if len(words) < 4 or any(word & 0x8000 for word in words[1:]):
        return False
    for bits in (11, 10):
        numbers = [(word & 0x7FFF) >> bits for word in words]
        if max(numbers) < _DSM_CHANNELS and len(set(numbers)) == len(numbers):
            return True
    return False


def _sumd(data: bytes, at: int) -> int:
    if at + 3 > len(data) or data[at] != 0xA8 or data[at + 1] not in (0x01, 0x81) or not 1 <= data[at + 2] <= 32:
        return 0
    length = 3 + 2 * data[at + 2] + 2
    # Over all bytes, its own included, the checksum is 0.
    return length if at + length <= len(data) and not binascii.crc_hqx(data[at : at + length], 0) else 0


def _st24(data: bytes, at: int) -> int:
    if at + 3 > len(data) or data[at : at + 2] != b"\x55\x55" or data[at + 2] < 3:
        return 0
    length = 3 + data[at + 2]
    return length if at + length <= len(data) and not _crc8_07(data[at + 2 : at + length]) else 0


def _ghst(data: bytes, at: int) -> int:
    if at + 3 > len(data) or data[at] not in _GHST_ADDRESSES or not 2 <= data[at + 1] <= 62:
        return 0
    length = 2 + data[at + 1]
    return length if at + length <= len(data) and not crc8(data[at + 2 : at + length]) else 0


def _crc8_07(data: bytes) -> int:
    """CRC-8 with polynomial 0x07, start 0, not reflected: 0xF4 over b"123456789", 0 over a frame with its checksum."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x107 if crc & 0x80 else 0)) & 0xFF
    return crc


_LENGTH_AT: Mapping[str, Callable[[bytes, int], int]] = {"dsm": _dsm, "sumd": _sumd, "st24": _st24, "ghst": _ghst}
PROTOCOLS: Mapping[str, str] = {
    "dsm": "Spektrum DSM",
    "sumd": "Graupner SUMD",
    "st24": "Yuneec ST24",
    "ghst": "ImmersionRC Ghost",
}
"""Our name and the one on the box."""
