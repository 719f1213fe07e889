"""What the bytes inside control-bus frames mean: identity, motion, errors. One conversion each, named for it.

Requests speak m/s and rad/s, answers millimetres and degrees, both as two's-complement Q16 (value x 65536, low byte
first); only 0x31 and 0x40 count in whole millimetres. Behind these functions everything is SI in the body frame: x
forward, y left, counter-clockwise positive, which is the bus's own frame too. Source: the structures of SLAMTEC's base
reference firmware of 2018-11-20, executed, its chassis SDK of 2020, and document 000.

Encoders raise ValueError with the value and its limits. Decoders take payloads whose size has been looked at.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import NamedTuple

from bench.messages import BodyTwist
from bench.slamware.commands import (
    CONNECT_BASE,
    ERROR_MEANINGS,
    MOST_WHEELS,
    NOT_SUPPORTED,
    PROTOCOL_VERSION,
    SEND_EVENT,
    SET_BASE_MOTOR,
    SET_V_AND_GET_DEADRECKON,
)

Q16 = 65536.0
_S32_MIN, _S32_MAX = -(2**31), 2**31 - 1
_TWIST = struct.Struct("<3i")
_WHEELS = struct.Struct("<4i")
_DEAD_RECKON = struct.Struct("<3iB")
_TWO_WHEELS = struct.Struct("<2iB")
_RIMS = struct.Struct("<7i")
_UPTIME = struct.Struct("<I")
_IDENTITY = struct.Struct("<12sHH12s")
_ERROR = struct.Struct("<H")
_SUFFIX_BYTES = 11

IDENTITY_BYTES, LONG_IDENTITY_BYTES = _IDENTITY.size, _IDENTITY.size + _SUFFIX_BYTES
DEAD_RECKON_BYTES, LONG_DEAD_RECKON_BYTES = _DEAD_RECKON.size, _DEAD_RECKON.size + _UPTIME.size
MOTOR_DATA_BYTES, OMNI_MOTOR_DATA_BYTES = _TWO_WHEELS.size, _RIMS.size


class Identity(NamedTuple):
    """What a base says of itself when a core connects."""

    model: str
    firmware_version: int
    """Major x 256 + minor."""
    hardware_version: int
    serial_number: str
    """24 hexadecimal digits: the 12 bytes in the order of the wire."""
    firmware_suffix: str = ""
    """Text behind the version; only the 39-byte answer has room for it."""


class Displacement(NamedTuple):
    """How a robot moved, in its own frame as it stood at the start."""

    dx_m: float
    dy_m: float
    dtheta_rad: float


class DeadReckon(NamedTuple):
    """Displacement since the previous answer, in the robot's frame as it stood then, and the status bits."""

    dx_m: float
    dy_m: float
    dtheta_rad: float
    status: int
    uptime_ms: int | None = None
    """Milliseconds since the base was powered, where the dialect tells them."""


class MotorData(NamedTuple):
    """How far the wheels have rolled since the base was powered, and what its layout adds to that."""

    distances_m: tuple[float, ...]
    """Left and right of a two-wheel base, or four rim distances in wheel order; whole millimetres on the wire."""
    displacement: Displacement | None = None
    """28-byte layout: since the previous answer of this kind."""
    status: int | None = None
    """9-byte layout: the status bits."""


def connect_request(version: int = PROTOCOL_VERSION) -> bytes:
    """0x10: the handshake."""
    return bytes((CONNECT_BASE, version))


def identity_answer(identity: Identity, size: int = IDENTITY_BYTES) -> bytes:
    """28 or 39 bytes. Raises ValueError where a field does not fit."""
    model = _ascii("model", identity.model, 12)
    suffix = _ascii("firmware_suffix", identity.firmware_suffix, _SUFFIX_BYTES)
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
    answer = _IDENTITY.pack(model, identity.firmware_version, identity.hardware_version, serial)
    return answer + suffix.ljust(_SUFFIX_BYTES, b"\0") if size == LONG_IDENTITY_BYTES else answer


def identity_from_answer(payload: bytes) -> Identity:
    """Identity out of an answer of at least 28 bytes; what follows the 39th is left alone."""
    model, firmware_version, hardware_version, serial = _IDENTITY.unpack_from(payload)
    suffix = payload[IDENTITY_BYTES:LONG_IDENTITY_BYTES]
    return Identity(printable(model), firmware_version, hardware_version, serial.hex(), printable(suffix))


def twist_request(twist: BodyTwist) -> bytes:
    """0x41: the velocity to drive from now on. Raises ValueError where a component does not fit into Q16."""
    raw = []
    for name, value in zip(BodyTwist._fields, twist, strict=True):
        if not -32768.0 <= value < 32768.0:
            raise ValueError(f"{name} {value} outside -32768..32768")
        raw.append(int(value * Q16))
    return bytes((SET_V_AND_GET_DEADRECKON,)) + _TWIST.pack(*raw)


def twist_from_request(fields: bytes) -> BodyTwist:
    """Velocity out of the 12 bytes after 0x41: m/s, m/s, rad/s."""
    vx_q16, vy_q16, omega_q16 = _TWIST.unpack(fields)
    return BodyTwist(vx_q16 / Q16, vy_q16 / Q16, omega_q16 / Q16)


def dead_reckon_answer(
    dx_m: float, dy_m: float, dtheta_rad: float, status: int = 0, uptime_ms: int | None = None
) -> bytes:
    """13 bytes, or 17 with an uptime: Q16 millimetres and degrees, cut towards zero.

    What does not fit (32.768 m or 32768 degrees since the previous answer) stays at the limit: the vendor's conversion
    overflows there, which may turn a long way forward into a long way back. The uptime starts again after 49.7 days.
    """
    answer = _DEAD_RECKON.pack(*_displacement_q16(dx_m, dy_m, dtheta_rad), status)
    return answer if uptime_ms is None else answer + _UPTIME.pack(uptime_ms & 0xFFFFFFFF)


def dead_reckon_from_answer(payload: bytes) -> DeadReckon:
    """Displacement out of an answer of at least 13 bytes; what follows the 17th is left alone."""
    dx_q16, dy_q16, dtheta_q16, status = _DEAD_RECKON.unpack_from(payload)
    uptime_ms = None
    if len(payload) >= LONG_DEAD_RECKON_BYTES:
        (uptime_ms,) = _UPTIME.unpack_from(payload, DEAD_RECKON_BYTES)
    return DeadReckon(*_displacement_si(dx_q16, dy_q16, dtheta_q16), status, uptime_ms)


def wheels_request(speeds_mps: Sequence[float]) -> bytes:
    """0x40: rim speeds in wheel order, at most four; whole mm/s. Raises ValueError where they do not fit."""
    if len(speeds_mps) > MOST_WHEELS:
        raise ValueError(f"{len(speeds_mps)} wheel speeds; the request has room for {MOST_WHEELS}")
    raw = [0] * MOST_WHEELS
    for wheel, speed_mps in enumerate(speeds_mps):
        if not -2_147_483.0 <= speed_mps <= 2_147_483.0:
            raise ValueError(f"wheel speed {speed_mps} outside -2147483..2147483")
        raw[wheel] = round(speed_mps * 1000.0)
    return bytes((SET_BASE_MOTOR,)) + _WHEELS.pack(*raw)


def wheels_from_request(fields: bytes) -> tuple[float, ...]:
    """Four rim speeds in m/s out of the 16 bytes after 0x40."""
    return tuple(speed_mmps / 1000.0 for speed_mmps in _WHEELS.unpack(fields))


def two_wheel_answer(left_m: float, right_m: float, status: int = 0) -> bytes:
    """0x31 of a two-wheel base, 9 bytes: distances since power-up, cut to whole millimetres, and the status bits."""
    return _TWO_WHEELS.pack(_clamped(left_m * 1000.0), _clamped(right_m * 1000.0), status)


def omni_motor_answer(distances_m: Sequence[float], displacement: Sequence[float]) -> bytes:
    """0x31 of up to four wheels, 28 bytes: rim distances since power-up, displacement since the previous answer."""
    if len(distances_m) > MOST_WHEELS:
        raise ValueError(f"{len(distances_m)} wheel distances; the answer has room for {MOST_WHEELS}")
    whole_mm = [_clamped(distance_m * 1000.0) for distance_m in distances_m]
    whole_mm += [0] * (MOST_WHEELS - len(whole_mm))
    return _RIMS.pack(*whole_mm, *_displacement_q16(*displacement))


def motor_data_from_answer(payload: bytes) -> MotorData:
    """Distances out of an answer of at least 9 bytes; from 28 on it is the layout with four wheels."""
    if len(payload) >= OMNI_MOTOR_DATA_BYTES:
        *whole_mm, dx_q16, dy_q16, dtheta_q16 = _RIMS.unpack_from(payload)
        moved = Displacement(*_displacement_si(dx_q16, dy_q16, dtheta_q16))
        return MotorData(tuple(distance / 1000.0 for distance in whole_mm), displacement=moved)
    left_mm, right_mm, status = _TWO_WHEELS.unpack_from(payload)
    return MotorData((left_mm / 1000.0, right_mm / 1000.0), status=status)


def event_request(event: int) -> bytes:
    """0x60: something happened at the core."""
    return bytes((SEND_EVENT, event))


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


def printable(raw: bytes) -> str:
    """Zero-padded text from the wire. It ends up on a terminal: nothing but printable characters may get there."""
    return "".join(c if c.isprintable() else "?" for c in raw.split(b"\0", 1)[0].decode("latin-1"))


def _ascii(name: str, text: str, most: int) -> bytes:
    raw = text.encode("ascii", "replace")
    if raw.decode() != text or len(raw) > most:
        raise ValueError(f"{name} {text!r} is not ASCII text of 0..{most} characters")
    return raw


def _displacement_q16(dx_m: float, dy_m: float, dtheta_rad: float) -> tuple[int, int, int]:
    return (
        _clamped(dx_m * 1000.0 * Q16),
        _clamped(dy_m * 1000.0 * Q16),
        _clamped(math.degrees(dtheta_rad) * Q16),
    )


def _displacement_si(dx_q16: int, dy_q16: int, dtheta_q16: int) -> tuple[float, float, float]:
    return dx_q16 / Q16 / 1000.0, dy_q16 / Q16 / 1000.0, math.radians(dtheta_q16 / Q16)


def _clamped(value: float) -> int:
    return int(max(float(_S32_MIN), min(float(_S32_MAX), value)))
