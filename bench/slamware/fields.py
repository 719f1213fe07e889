"""The fields of each request and answer as plain values, SI units and radians: what `describe` prints as JSON.

One value a name, so that a comparison can say which one differs; only the tree of 0x21 keeps its shape.

A new sub-command is a row in `REQUEST_FIELDS` and one in `ANSWER_FIELDS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bench.slamware import commands as bus
from bench.slamware.answer_table import ANSWERS
from bench.slamware.config_payloads import Symbol, Tree, configuration_from_answer, decode_tree
from bench.slamware.health import code_from_fields, fault_from_answer, fault_in_words, health_from_answer
from bench.slamware.payloads import (
    LONG_IDENTITY_BYTES,
    dead_reckon_from_answer,
    identity_from_answer,
    motor_data_from_answer,
    twist_from_request,
    wheels_from_request,
)
from bench.slamware.sense_payloads import (
    base_request_from_answer,
    beacons_from_answer,
    contact_bits,
    power_from_answer,
    ranges_from_answer,
)

Facts = dict[str, Any]


def _dead_reckon_fields(payload: bytes) -> Facts:
    dx_m, dy_m, dtheta_rad, status, uptime_ms = dead_reckon_from_answer(payload)
    fields = {"dx_m": dx_m, "dy_m": dy_m, "dtheta_rad": dtheta_rad, **_status_fields(status)}
    return fields if uptime_ms is None else {**fields, "uptime_ms": uptime_ms}


def _status_fields(status: int) -> Facts:
    return {"wheel_stalled": bool(status & bus.WHEEL_STALLED), "traction_lost": bool(status & bus.TRACTION_LOST)}


def _identity_fields(payload: bytes) -> Facts:
    fields = identity_from_answer(payload)._asdict()
    if len(payload) < LONG_IDENTITY_BYTES:
        del fields["firmware_suffix"]
    return fields


def _motor_fields(payload: bytes) -> Facts:
    distances_m, displacement, status = motor_data_from_answer(payload)
    fields = _numbered("wheel", "m", distances_m)
    if displacement is not None:
        fields |= displacement._asdict()
    if status is not None:
        fields |= _status_fields(status)
    return fields


def _configuration_fields(payload: bytes) -> Facts:
    shape, radius_m, drive, range_sensors, bumpers = configuration_from_answer(payload)
    fields: Facts = {"shape": shape, "radius_m": radius_m, "drive": drive}
    for name, positions in (("range_sensor", range_sensors), ("bumper", bumpers)):
        fields[f"{name}s"] = len(positions)
        for number, position in enumerate(positions, 1):
            fields |= {f"{name}_{number}_{key}": value for key, value in position._asdict().items()}
    return fields


def _contact_fields(payload: bytes) -> Facts:
    bits = contact_bits(payload)
    triggered = (str(bit) for bit in range(10) if not bits >> bit & 1)
    return {"bits": bits, "triggered": " ".join(triggered)}


def _beacon_fields(payload: bytes) -> Facts:
    number, seen = beacons_from_answer(payload)
    return {"beacons": number, "receivers": len(seen), **_numbered("receiver", "bits", seen)}


def _base_request_fields(payload: bytes) -> Facts:
    request = base_request_from_answer(payload)
    meaning = "nothing" if request is None else bus.BASE_REQUEST_NAMES.get(request, "unknown")
    return {"base_request": request, "meaning": meaning}


def _fault_fields(payload: bytes) -> Facts:
    fault = fault_from_answer(payload)
    return {"fault_code": fault.code, "text": fault.text, "meaning": fault_in_words(fault.code)}


def _health_request_fields(fields: bytes) -> Facts:
    facts: Facts = {"health_command": fields[0]}
    if fields[0] == bus.GET_FAULT:
        facts["index"] = fields[1]
    elif fields[0] == bus.CLEAR_FAULT:
        facts["fault_code"] = code_from_fields(fields)
    return facts


def _numbered(name: str, unit: str, values: Sequence[float]) -> Facts:
    return {f"{name}_{number}_{unit}": value for number, value in enumerate(values, 1)}


def _plain(tree: Tree | None) -> Any:
    """A tree as JSON: keys and symbols by number, as they are on the wire."""
    if isinstance(tree, dict):
        return {f"0x{key:02X}": _plain(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_plain(entry) for entry in tree]
    if isinstance(tree, float) and not math.isfinite(tree):
        return str(tree)
    return {"symbol": tree.number} if isinstance(tree, Symbol) else tree


def _nothing(fields: bytes) -> Facts:
    return {}


REQUEST_FIELDS: Mapping[int, Callable[[bytes], Facts]] = {
    **dict.fromkeys(bus.SUB_COMMANDS, _nothing),
    bus.CONNECT_BASE: lambda fields: {"protocol_version": fields[0]},
    bus.GET_AUTO_HOME_DATA: lambda fields: {"data_type": fields[0]},
    bus.SET_BASE_MOTOR: lambda fields: _numbered("wheel", "mps", wheels_from_request(fields)),
    bus.SET_V_AND_GET_DEADRECKON: lambda fields: twist_from_request(fields)._asdict(),
    bus.SEND_EVENT: lambda fields: {"core_event": fields[0], "meaning": bus.EVENT_NAMES.get(fields[0], "unknown")},
    bus.HEALTH_MGMT: _health_request_fields,
}
"""The fields of a request, by sub-command, out of the bytes after it."""

ANSWER_FIELDS: Mapping[tuple[int, int], Callable[[bytes], Facts]] = {
    **dict.fromkeys(ANSWERS, _nothing),
    (bus.CONNECT_BASE, 0): _identity_fields,
    (bus.GET_BASE_CONF, 0): _configuration_fields,
    (bus.GET_BINARY_CONF, 0): lambda payload: {"bytes": len(payload), "tree": _plain(decode_tree(payload))},
    (bus.GET_BASE_STATUS, 0): lambda payload: power_from_answer(payload)._asdict(),
    (bus.GET_BASE_MOTOR_DATA, 0): _motor_fields,
    (bus.GET_BASE_SENSOR_DATA, 0): lambda payload: _numbered("range", "m", ranges_from_answer(payload)),
    (bus.GET_BASE_BUMPER_DATA, 0): _contact_fields,
    (bus.GET_AUTO_HOME_DATA, 0): _beacon_fields,
    (bus.SET_V_AND_GET_DEADRECKON, 0): _dead_reckon_fields,
    (bus.POLL_BASE_CMD, 0): _base_request_fields,
    (bus.HEALTH_MGMT, bus.GET_HEALTH): lambda payload: health_from_answer(payload)._asdict(),
    (bus.HEALTH_MGMT, bus.GET_FAULT): _fault_fields,
}
"""The fields of an OK answer, by what was asked."""
