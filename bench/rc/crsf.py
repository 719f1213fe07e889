"""CRSF (TBS Crossfire, ExpressLRS): 420000 baud, 8N1, not inverted, 4 to 64 bytes, CRC-8.

    byte  0         1         2       3 ...       last
          address   length    type    payload     CRC-8, polynomial D5, over type and payload
          C8 ...    2 to 62: the bytes after this one

    type 16  RC channels       22 bytes: 16 channels x 11 bit, lowest first, as in SBUS; the length is 24
    type 14  link statistics   RSSI antenna 1, antenna 2 (dBm, sign dropped), uplink quality %, SNR (signed), active
                               antenna, mode, power, then RSSI, quality, SNR of the downlink

The checksum decides, and a frame is delivered with its last byte. But eight bits are wrong once in 256 times, so two
more rules keep a damaged frame from being believed, and from taking an intact one with it:

* Channels come first. Another frame is refused where a valid channels frame begins inside it.
* A frame that lost a byte swallows the address of the next one as its checksum. Where a frame's checksum equals its
  address (one in 256 does), the next byte is waited for: if a valid frame begins with that address, this one is not.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence

from bench.messages import RcEvent, RcFrame, RcLinkStatistics, RcOther
from bench.rc.framing import Decoder, pack_channels, unpack_channels

FLIGHT_CONTROLLER = 0xC8
ADDRESSES = frozenset((FLIGHT_CONTROLLER, 0xEE, 0xEA, 0xEC, 0x00))
"""Flight controller; module; handset; receiver; and broadcast, which old devices use."""
CHANNELS, LINK_STATISTICS = 0x16, 0x14

_ADDRESS = re.compile(rb"[\xc8\xee\xea\xec\x00]")
# The beginning of a channels frame, or as much of one as there is at the end of what may be looked at.
_CHANNELS_BEGIN = re.compile(rb"[\xc8\xee\xea\xec\x00](?:\Z|\x18(?:\Z|\x16))")
_CHANNELS_HEAD = bytes((24, CHANNELS))
_CHANNELS_SIZE = 26
_MIN_LENGTH, _MAX_LENGTH = 2, 62
_LINK = struct.Struct("BBBbBBBBBb")
# Types whose payload is known: name, and the shortest length byte. Longer ones are legal, the surplus is ignored.
_KNOWN = {
    0x02: ("gps", 17),
    0x07: ("vario", 4),
    0x08: ("battery", 10),
    0x14: ("link statistics", 12),
    0x16: ("channels", 24),
    0x17: ("subset of channels", 3),
    0x1C: ("link statistics, receiver", 7),
    0x1D: ("link statistics, transmitter", 8),
    0x1E: ("attitude", 8),
    0x21: ("flight mode", 2),
    0x28: ("device ping", 4),
    0x29: ("device info", 4),
    0x2B: ("parameter entry", 4),
    0x2C: ("parameter read", 4),
    0x2D: ("parameter write", 4),
    0x32: ("command", 4),
    0x7A: ("MSP request", 4),
    0x7B: ("MSP answer", 4),
    0x7C: ("MSP write", 4),
}
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_frame = tuple.__new__


def _crc_table() -> list[int]:
    table = []
    for crc in range(256):
        for _ in range(8):
            crc = crc << 1 ^ (0x1D5 if crc & 0x80 else 0)
        table.append(crc)
    return table


_CRC = _crc_table()


def crc8(data: bytes) -> int:
    """CRC-8 with polynomial 0xD5, start 0, not reflected: 0xBC over b"123456789", 0 over a frame with its checksum."""
    crc, table = 0, _CRC
    for byte in data:
        crc = table[crc ^ byte]
    return crc


class CrsfDecoder(Decoder):
    """CRSF bytes to frames. Reasons of noise: header, length, checksum, cut."""

    byte_us = 10 / 420_000 * 1e6

    def _scan(self, buf: bytes, closed: bool, out: list[RcEvent]) -> int:
        base, size, at = self._offset, len(buf), 0
        table = _CRC
        while at < size:
            address = buf[at]
            if address not in ADDRESSES:
                match = _ADDRESS.search(buf, at)
                found = match.start() if match else size
                self._refuse(base + at, base + found, "header", out)
                at = found
                continue
            end = at + _CHANNELS_SIZE
            reason: str | None = ""
            if end <= size and buf.startswith(_CHANNELS_HEAD, at + 1):
                # What nearly every frame is, without a call: the checksum, then a glance at the frame's own end.
                crc = 0
                for byte in buf[at + 2 : end]:
                    crc = table[crc ^ byte]
                if crc:
                    reason = "checksum"
                elif byte == address or byte == 24 or buf.find(_CHANNELS_HEAD, at + 4, end) > 0:
                    reason = _swallowed(buf, at, end, closed)
            else:
                reason = _refusal(buf, at, closed)
            if reason is None:
                return at
            if reason:
                self._refuse(base + at, base + at + 1, reason, out)
                at += 1
                continue
            if self._noise_length:
                self._end_noise(out)
            at = self._accept(buf, at, out)
        return at

    def _accept(self, buf: bytes, at: int, out: list[RcEvent]) -> int:
        offset, length, kind = self._offset + at, buf[at + 1] + 2, buf[at + 2]
        if kind == CHANNELS:
            out.append(_new_frame(RcFrame, (offset, length, unpack_channels(buf[at + 3 : at + 25]), False, False, ())))
            self.counters.frames += 1
        elif kind == LINK_STATISTICS:
            rssi_1, rssi_2, quality, snr_db, antenna, *_ = _LINK.unpack_from(buf, at + 3)
            # The wire drops the sign of the dBm; the antenna that is in use counts.
            out.append(RcLinkStatistics(offset, length, quality, -(rssi_2 if antenna else rssi_1), snr_db))
            self.counters.link_statistics += 1
        else:
            out.append(RcOther(offset, length, _KNOWN[kind][0] if kind in _KNOWN else f"type 0x{kind:02x}"))
            self.counters.others += 1
        return at + length


def _end(buf: bytes, at: int) -> int | None:
    """Where a frame that begins at `at` would end: 0 if its length is impossible, None while that is not known."""
    if at + 1 >= len(buf):
        return None
    length = buf[at + 1]
    if not _MIN_LENGTH <= length <= _MAX_LENGTH:
        return 0
    if at + 2 >= len(buf):
        return None
    kind = buf[at + 2]
    if kind in _KNOWN and (length < _KNOWN[kind][1] or (kind == CHANNELS and length != 24)):
        return 0
    return at + 2 + length


def _refusal(buf: bytes, at: int, closed: bool) -> str | None:
    """Why no frame begins at the address `at`: a reason, "" if one does, None while that is not known."""
    end = _end(buf, at)
    if end is None:
        return "cut" if closed else None
    if not end:
        return "length"
    inside = _channels_inside(buf, at, end, closed)
    if inside is None:
        return None
    if inside:
        return "cut"
    if end > len(buf):
        return "cut" if closed else None
    return "checksum" if crc8(buf[at + 2 : end]) else ""


def _channels_inside(buf: bytes, start: int, end: int, closed: bool) -> bool | None:
    """Whether a whole, valid channels frame begins between `start` and `end`; None while that is not known."""
    while (match := _CHANNELS_BEGIN.search(buf, start, end + 2)) and match.start() < end:
        begin = match.start()
        if begin + _CHANNELS_SIZE > len(buf):
            return False if closed else None
        if not crc8(buf[begin + 2 : begin + _CHANNELS_SIZE]):
            return True
        start = match.end()
    return False


def _swallowed(buf: bytes, at: int, end: int, closed: bool) -> str | None:
    """As `_refusal`, for a channels frame with a right checksum: is its end the beginning of another valid frame?"""
    address = buf[at]
    if buf[end - 1] == address:
        begin = end - 1
    elif buf[end - 1] == 24 and buf[end - 2] == address:
        begin = end - 2
    else:
        begin = buf.find(_CHANNELS_HEAD, at + 4, end) - 1
        if begin < 0 or buf[begin] != address:
            return ""
    other_end = _end(buf, begin)
    if other_end is None or other_end > len(buf):
        return "" if closed else None
    return "cut" if other_end and not crc8(buf[begin + 2 : other_end]) else ""


def encode(channels: Sequence[int], *, address: int = FLIGHT_CONTROLLER) -> bytes:
    """One channels frame from 16 channels (0 to 2047). Raises ValueError outside of that."""
    return encode_frame(CHANNELS, pack_channels("crsf", channels), address=address)


def encode_link_statistics(quality_percent: int, rssi_dbm: int, snr_db: int) -> bytes:
    """A link statistics frame, up- and downlink alike. Raises ValueError outside of 0..100, -255..0 and -128..127."""
    for name, value, low, high in (
        ("quality_percent", quality_percent, 0, 100),
        ("rssi_dbm", rssi_dbm, -255, 0),
        ("snr_db", snr_db, -128, 127),
    ):
        if not low <= value <= high:
            raise ValueError(f"crsf: {name} is {value}; expected {low} to {high}")
    payload = _LINK.pack(-rssi_dbm, -rssi_dbm, quality_percent, snr_db, 0, 2, 3, -rssi_dbm, quality_percent, snr_db)
    return encode_frame(LINK_STATISTICS, payload)


def encode_frame(kind: int, payload: bytes, *, address: int = FLIGHT_CONTROLLER) -> bytes:
    """Any frame from its type and payload (0 to 60 bytes). Raises ValueError for what cannot be one."""
    if address not in ADDRESSES:
        raise ValueError(f"crsf: address is {address:#x}; expected one of {', '.join(map(hex, sorted(ADDRESSES)))}")
    if not 0 <= kind <= 0xFF:
        raise ValueError(f"crsf: type is {kind}; expected 0 to 255")
    if len(payload) > _MAX_LENGTH - _MIN_LENGTH:
        raise ValueError(f"crsf: payload of {len(payload)} bytes; expected at most {_MAX_LENGTH - _MIN_LENGTH}")
    body = bytes((kind,)) + payload
    return bytes((address, len(body) + 1)) + body + bytes((crc8(body),))
