"""What the bytes inside control-bus frames mean: sub-commands, their fields, errors. One conversion each, named for it.

Requests speak m/s and rad/s, answers millimetres and degrees, both as two's-complement Q16 (value x 65536, low byte
first). Behind these functions everything is SI in the body frame: x forward, y left, counter-clockwise positive, which
is the bus's own frame too. Source: the structures of SLAMTEC's base reference firmware of 2018-11-20, executed, and
document 000.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from bench.messages import BodyTwist

CONNECT_BASE = 0x10
SET_V_AND_GET_DEADRECKON = 0x41

PROTOCOL_VERSION = 1

NOT_SYNCHRONISED, TOO_LONG, BAD_CHECKSUM = 0x0010, 0x0020, 0x0040
NOT_SUPPORTED, BAD_FORMAT, FAILED = 0x8000, 0x8001, 0x8002
ERROR_MEANINGS = {
    NOT_SYNCHRONISED: "byte outside any frame",
    TOO_LONG: "frame longer than the receive buffer",
    BAD_CHECKSUM: "checksum mismatch",
    NOT_SUPPORTED: "not supported",
    BAD_FORMAT: "format error in the request",
    FAILED: "execution failed",
}

WHEEL_STALLED, TRACTION_LOST = 0x02, 0x04
"""Bits of the status byte in a dead-reckoning answer."""

_Q16 = 65536.0
_S32_MIN, _S32_MAX = -(2**31), 2**31 - 1
_TWIST = struct.Struct("<3i")
_DEAD_RECKON = struct.Struct("<3iB")
_IDENTITY = struct.Struct("<12sHH12s")
_ERROR = struct.Struct("<H")

IDENTITY_BYTES = _IDENTITY.size
DEAD_RECKON_BYTES = _DEAD_RECKON.size


class SubCommand(NamedTuple):
    """A row of the table of sub-commands: its name and how many bytes follow the sub-command byte in a request."""

    name: str
    request_bytes: int


SUB_COMMANDS = {
    CONNECT_BASE: SubCommand("CONNECT_BASE", 1),
    SET_V_AND_GET_DEADRECKON: SubCommand("SET_V_AND_GET_DEADRECKON", _TWIST.size),
}


class Identity(NamedTuple):
    """What a base says of itself when a core connects."""

    model: str
    firmware_version: int
    """Major x 256 + minor."""
    hardware_version: int
    serial_number: str
    """24 hexadecimal digits: the 12 bytes in the order of the wire."""


class DeadReckon(NamedTuple):
    """Displacement since the previous answer, in the robot's frame as it stood then, and the status bits."""

    dx_m: float
    dy_m: float
    dtheta_rad: float
    status: int


def connect_request() -> bytes:
    """0x10: the handshake, protocol version 1."""
    return bytes((CONNECT_BASE, PROTOCOL_VERSION))


def twist_request(twist: BodyTwist) -> bytes:
    """0x41: the velocity to drive from now on. Raises ValueError where a component does not fit into Q16."""
    raw = []
    for name, value in zip(BodyTwist._fields, twist, strict=True):
        if not -32768.0 <= value < 32768.0:
            raise ValueError(f"{name} {value} outside -32768..32768")
        raw.append(int(value * _Q16))
    return bytes((SET_V_AND_GET_DEADRECKON,)) + _TWIST.pack(*raw)


def twist_from_request(fields: bytes) -> BodyTwist:
    """Velocity out of the 12 bytes after 0x41: m/s, m/s, rad/s."""
    vx_q16, vy_q16, omega_q16 = _TWIST.unpack(fields)
    return BodyTwist(vx_q16 / _Q16, vy_q16 / _Q16, omega_q16 / _Q16)


def dead_reckon_answer(dx_m: float, dy_m: float, dtheta_rad: float, status: int = 0) -> bytes:
    """13 bytes out of a displacement in metres and radians: Q16 millimetres and degrees, cut towards zero.

    What does not fit (32.768 m or 32768 degrees since the previous answer) stays at the limit: the vendor's conversion
    overflows there, which may turn a long way forward into a long way back.
    """
    return _DEAD_RECKON.pack(
        _q16_clamped(dx_m * 1000.0), _q16_clamped(dy_m * 1000.0), _q16_clamped(math.degrees(dtheta_rad)), status
    )


def dead_reckon_from_answer(payload: bytes) -> DeadReckon:
    """Displacement out of an answer of at least 13 bytes; later dialects append fields, which are left alone."""
    dx_q16, dy_q16, dtheta_q16, status = _DEAD_RECKON.unpack_from(payload)
    return DeadReckon(dx_q16 / _Q16 / 1000.0, dy_q16 / _Q16 / 1000.0, math.radians(dtheta_q16 / _Q16), status)


def identity_answer(identity: Identity) -> bytes:
    """28 bytes. Raises ValueError where a field does not fit."""
    model = identity.model.encode("ascii", "replace")
    if identity.model != model.decode() or len(model) > 12:
        raise ValueError(f"model {identity.model!r} is not ASCII text of 0..12 characters")
    for name in ("firmware_version", "hardware_version"):
        version = getattr(identity, name)
        if not 0 <= version <= 0xFFFF:
            raise ValueError(f"{name} {version} outside 0..65535")
    try:
        serial = bytes.fromhex(identity.serial_number)
    except ValueError:
        serial = b""
    if len(serial) != 12:
        raise ValueError(f"serial_number {identity.serial_number!r} is not 24 hexadecimal digits")
    return _IDENTITY.pack(model, identity.firmware_version, identity.hardware_version, serial)


def identity_from_answer(payload: bytes) -> Identity:
    """Identity out of an answer of at least 28 bytes; later dialects append fields, which are left alone."""
    model, firmware_version, hardware_version, serial = _IDENTITY.unpack_from(payload)
    text = model.split(b"\0", 1)[0].decode("latin-1")
    # Foreign bytes end up on a terminal: nothing but printable characters may get there.
    return Identity(
        "".join(c if c.isprintable() else "?" for c in text), firmware_version, hardware_version, serial.hex()
    )


def error_answer(code: int) -> bytes:
    """2 bytes of an error answer."""
    return _ERROR.pack(code)


def error_from_answer(payload: bytes) -> int:
    """Error code out of the 2 bytes of an error answer, made comparable.

    Codes below 0x8000 are bit fields, and the reference base leaves its own bit 0x80 ("a frame is complete") in them:
    it sends 0x00C0 where its wiki has 0x0040.
    """
    code: int = _ERROR.unpack(payload)[0]
    return code if code >= NOT_SUPPORTED else code & ~0x80


def meaning_of(code: int) -> str:
    """An error code in words; several where several bits are set, and "unknown" for what nobody defines."""
    if code >= NOT_SUPPORTED:
        return ERROR_MEANINGS.get(code, "unknown")
    return ", ".join(text for bit, text in ERROR_MEANINGS.items() if bit < NOT_SUPPORTED and code & bit) or "unknown"


def _q16_clamped(value: float) -> int:
    return int(max(float(_S32_MIN), min(float(_S32_MAX), value * _Q16)))
