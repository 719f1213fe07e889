"""Frames in words: one JSON object for `wheelbench decode slamware --json`, one line for the dashboard.

A new sub-command is a row in `_REQUESTS`, a row in `_ANSWERS` where its answer has a size of its own, and a line in
`_LINES`. An answer names neither its command nor its sub-command: its payload is read by status and size, and `as` says
as what.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from bench.slamware.framing import CONTROL_BUS, ECHO, ERROR, OK, SYNC, SlamwareEvent, SlamwareFrame
from bench.slamware.payloads import (
    CONNECT_BASE,
    DEAD_RECKON_BYTES,
    IDENTITY_BYTES,
    SET_V_AND_GET_DEADRECKON,
    SUB_COMMANDS,
    TRACTION_LOST,
    WHEEL_STALLED,
    dead_reckon_from_answer,
    error_from_answer,
    identity_from_answer,
    meaning_of,
    twist_from_request,
)


def describe(event: SlamwareEvent) -> dict[str, Any]:
    """The event as plain values, in the form of `wheelbench decode --json`."""
    facts = event._asdict()
    if not isinstance(event, SlamwareFrame):
        return {"event": "noise", "protocol": "slamware", **facts}
    facts["payload"] = event.payload.hex()
    return {"event": "frame", "protocol": "slamware", **facts, "decoded": decoded(event)}


def decoded(frame: SlamwareFrame) -> dict[str, Any]:
    """Fields in SI units and what the frame was read `as`; {} where nothing is known of it."""
    payload = frame.payload
    size = len(payload)
    if frame.code == CONTROL_BUS and payload:
        command = SUB_COMMANDS.get(payload[0])
        if command is not None and size == 1 + command.request_bytes:
            return {
                "as": f"{command.name} request",
                "sub_command": payload[0],
                **_REQUESTS[payload[0]](payload[1:]),
            }
    elif frame.code == OK and size in _ANSWERS:
        name, fields = _ANSWERS[size]
        return {"as": name, **fields(payload)}
    elif frame.code == ERROR and size == 2:
        code = error_from_answer(payload)
        return {"as": "error", "error_code": code, "meaning": meaning_of(code)}
    elif frame.code in (SYNC, ECHO):
        return {"as": "SYNC" if frame.code == SYNC else "ECHO", "bytes": size}
    return {}


def summary(event: SlamwareEvent) -> str:
    """One line for a person."""
    if not isinstance(event, SlamwareFrame):
        return f"{event.length} bytes refused: {event.reason}"
    facts = decoded(event)
    if facts:
        return _LINES[facts["as"]](facts)
    if event.code == CONTROL_BUS and event.payload:
        return f"0x{event.payload[0]:02X} with {len(event.payload) - 1} bytes"
    return f"code 0x{event.code:02X} with {len(event.payload)} bytes"


def _dead_reckon_fields(payload: bytes) -> dict[str, Any]:
    dx_m, dy_m, dtheta_rad, status = dead_reckon_from_answer(payload)
    return {
        "dx_m": dx_m,
        "dy_m": dy_m,
        "dtheta_rad": dtheta_rad,
        "wheel_stalled": bool(status & WHEEL_STALLED),
        "traction_lost": bool(status & TRACTION_LOST),
    }


def _dead_reckon_line(facts: dict[str, Any]) -> str:
    dx_mm, dy_mm, dtheta_deg = facts["dx_m"] * 1e3, facts["dy_m"] * 1e3, math.degrees(facts["dtheta_rad"])
    stalled = " wheel stalled" if facts["wheel_stalled"] else ""
    lost = " traction lost" if facts["traction_lost"] else ""
    return f"OK dx {dx_mm:+.2f} mm dy {dy_mm:+.2f} mm dth {dtheta_deg:+.2f} deg{stalled}{lost}"


def _identity_line(facts: dict[str, Any]) -> str:
    version = facts["firmware_version"]
    return f"OK {facts['model']} firmware {version >> 8}.{version & 0xFF} hardware {facts['hardware_version']}"


_REQUESTS: dict[int, Callable[[bytes], dict[str, Any]]] = {
    CONNECT_BASE: lambda fields: {"protocol_version": fields[0]},
    SET_V_AND_GET_DEADRECKON: lambda fields: twist_from_request(fields)._asdict(),
}
"""The fields of a request, by sub-command, out of the bytes after it."""

_ANSWERS: dict[int, tuple[str, Callable[[bytes], dict[str, Any]]]] = {
    0: ("empty OK", lambda payload: {}),
    DEAD_RECKON_BYTES: ("SET_V_AND_GET_DEADRECKON answer", _dead_reckon_fields),
    IDENTITY_BYTES: ("CONNECT_BASE answer", lambda payload: identity_from_answer(payload)._asdict()),
}
"""What an OK answer is read as, and its fields, by the size of its payload."""

_LINES: dict[str, Callable[[dict[str, Any]], str]] = {
    "CONNECT_BASE request": lambda facts: f"0x10 connect, protocol version {facts['protocol_version']}",
    "SET_V_AND_GET_DEADRECKON request": lambda facts: (
        f"0x41 vx {facts['vx_mps']:+.3f} vy {facts['vy_mps']:+.3f} w {facts['omega_radps']:+.3f}"
    ),
    "empty OK": lambda facts: "OK",
    "SET_V_AND_GET_DEADRECKON answer": _dead_reckon_line,
    "CONNECT_BASE answer": _identity_line,
    "error": lambda facts: f"error 0x{facts['error_code']:04X} {facts['meaning']}",
    "SYNC": lambda facts: f"SYNC {facts['bytes']} bytes",
    "ECHO": lambda facts: f"ECHO {facts['bytes']} bytes",
}
