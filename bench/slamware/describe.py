"""Frames in words: one JSON object for `wheelbench decode slamware --json`, one line for the dashboard.

A request names its sub-command. An answer names nothing: `Conversation` reads it as the answer to the last request it
has seen, as a core does; without one an answer is read by its size, where that leaves no doubt. `as` says as what.

The fields are `fields`; a sub-command whose fields need words has a line in `_LINES`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from bench.slamware import commands as bus
from bench.slamware.answer_table import reads
from bench.slamware.config_payloads import CONFIGURATION_BYTES, decode_tree
from bench.slamware.fields import ANSWER_FIELDS, REQUEST_FIELDS, Facts
from bench.slamware.framing import CONTROL_BUS, ECHO, ERROR, OK, SYNC, SlamwareEvent, SlamwareFrame
from bench.slamware.health import FAULT_BYTES
from bench.slamware.payloads import (
    DEAD_RECKON_BYTES,
    IDENTITY_BYTES,
    LONG_DEAD_RECKON_BYTES,
    LONG_IDENTITY_BYTES,
    MOTOR_DATA_BYTES,
    error_from_answer,
    meaning_of,
)
from bench.slamware.sense_payloads import BUMPER_BYTES, RANGES_BYTES


class Conversation:
    """Both directions of a line in one stream: tells each frame in the light of what was asked before it."""

    def __init__(self) -> None:
        self._asked = b""

    def describe(self, event: SlamwareEvent) -> Facts:
        """As `describe`."""
        facts = describe(event, self._asked)
        if isinstance(event, SlamwareFrame):
            self._asked = event.payload if event.code == CONTROL_BUS else b""
        return facts


def describe(event: SlamwareEvent, asked: bytes = b"") -> Facts:
    """The event as plain values, in the form of `wheelbench decode --json`; `asked` is what it may answer."""
    facts = event._asdict()
    if not isinstance(event, SlamwareFrame):
        return {"event": "noise", "protocol": "slamware", **facts}
    facts["payload"] = event.payload.hex()
    return {"event": "frame", "protocol": "slamware", **facts, "decoded": decoded(event, asked)}


def decoded(frame: SlamwareFrame, asked: bytes = b"") -> Facts:
    """Fields in SI units and what the frame was read `as`; {} where nothing is known of it."""
    payload = frame.payload
    if frame.code == CONTROL_BUS and payload:
        command = bus.SUB_COMMANDS.get(payload[0])
        if command is not None and bus.well_sized(payload[0], payload[1:]):
            fields = REQUEST_FIELDS[payload[0]](payload[1:])
            return {"as": f"{command.name} request", "sub_command": payload[0], **fields}
    elif frame.code == OK:
        return _answer(payload, asked)
    elif frame.code == ERROR and len(payload) == 2:
        code = error_from_answer(payload)
        return {"as": "error", "error_code": code, "meaning": meaning_of(code)}
    elif frame.code in (SYNC, ECHO):
        return {"as": "SYNC" if frame.code == SYNC else "ECHO", "bytes": len(payload)}
    return {}


def summary(event: SlamwareEvent, asked: bytes = b"") -> str:
    """One line for a person."""
    if not isinstance(event, SlamwareFrame):
        return f"{event.length} bytes refused: {event.reason}"
    facts = decoded(event, asked)
    if facts:
        line = _LINES.get(facts["as"])
        return line(facts) if line else _plain_line(facts)
    if event.code == CONTROL_BUS and event.payload:
        return f"0x{event.payload[0]:02X} with {len(event.payload) - 1} bytes"
    return f"code 0x{event.code:02X} with {len(event.payload)} bytes"


def _answer(payload: bytes, asked: bytes) -> Facts:
    if not payload:
        return {"as": "empty OK"}
    kind = reads(asked, payload) if asked else _by_size(payload)
    if kind is None:
        return {}
    name = bus.SUB_COMMANDS[kind[0]].name
    return {"as": f"{name} answer", **ANSWER_FIELDS[kind](payload)}


def _by_size(payload: bytes) -> tuple[int, int] | None:
    kind = _KIND_OF_SIZE.get(len(payload))
    if kind is None and decode_tree(payload) is not None:
        return bus.GET_BINARY_CONF, 0
    if kind is None and len(payload) > 2 and payload[1] == len(payload) - 2:
        return bus.GET_AUTO_HOME_DATA, 0
    return kind


def _dead_reckon_line(facts: Facts) -> str:
    dx_mm, dy_mm, dtheta_deg = facts["dx_m"] * 1e3, facts["dy_m"] * 1e3, math.degrees(facts["dtheta_rad"])
    stalled = " wheel stalled" if facts["wheel_stalled"] else ""
    lost = " traction lost" if facts["traction_lost"] else ""
    return f"OK dx {dx_mm:+.2f} mm dy {dy_mm:+.2f} mm dth {dtheta_deg:+.2f} deg{stalled}{lost}"


def _identity_line(facts: Facts) -> str:
    version = facts["firmware_version"]
    return f"OK {facts['model']} firmware {version >> 8}.{version & 0xFF} hardware {facts['hardware_version']}"


def _power_line(facts: Facts) -> str:
    ways = (("charging", "charging"), ("external_supply", "external supply"), ("on_dock", "on the dock"))
    return " ".join((f"OK battery {facts['percent']} %", *(text for key, text in ways if facts[key])))


def _ranges_line(facts: Facts) -> str:
    return "OK " + " ".join(f"{value:.3f}" for key, value in facts.items() if key.startswith("range_")) + " m"


def _contacts_line(facts: Facts) -> str:
    return f"OK contacts 0x{facts['bits']:08X}" + (f" triggered {facts['triggered']}" if facts["triggered"] else "")


def _wheels_line(facts: Facts) -> str:
    return "0x40 " + " ".join(f"{facts[f'wheel_{number}_mps']:+.3f}" for number in range(1, 5)) + " m/s"


def _event_line(facts: Facts) -> str:
    return f"0x60 event 0x{facts['core_event']:02X} {facts['meaning']}"


def _plain_line(facts: Facts) -> str:
    """For frames without a line of their own: "0x31 GET_BASE_MOTOR_DATA", "OK wheel_1_m 0.1"."""
    name: str = facts["as"]
    rest = [f"{key} {value}" for key, value in facts.items() if key not in ("as", "sub_command")]
    head = f"0x{facts['sub_command']:02X} {name.removesuffix(' request')}" if "sub_command" in facts else "OK"
    return " ".join((head, *rest))


_KIND_OF_SIZE = {
    BUMPER_BYTES: (bus.GET_BASE_BUMPER_DATA, 0),
    MOTOR_DATA_BYTES: (bus.GET_BASE_MOTOR_DATA, 0),
    DEAD_RECKON_BYTES: (bus.SET_V_AND_GET_DEADRECKON, 0),
    LONG_DEAD_RECKON_BYTES: (bus.SET_V_AND_GET_DEADRECKON, 0),
    IDENTITY_BYTES: (bus.CONNECT_BASE, 0),
    LONG_IDENTITY_BYTES: (bus.CONNECT_BASE, 0),
    FAULT_BYTES: (bus.HEALTH_MGMT, bus.GET_FAULT),
    RANGES_BYTES: (bus.GET_BASE_SENSOR_DATA, 0),
    CONFIGURATION_BYTES: (bus.GET_BASE_CONF, 0),
}
"""What an OK is read as by the size of its payload, where nobody knows what was asked; two bytes may be many things."""

_LINES: Mapping[str, Callable[[Facts], str]] = {
    "CONNECT_BASE request": lambda facts: f"0x10 connect, protocol version {facts['protocol_version']}",
    "SET_V_AND_GET_DEADRECKON request": lambda facts: (
        f"0x41 vx {facts['vx_mps']:+.3f} vy {facts['vy_mps']:+.3f} w {facts['omega_radps']:+.3f}"
    ),
    "SET_BASE_MOTOR request": _wheels_line,
    "SEND_EVENT request": _event_line,
    "empty OK": lambda facts: "OK",
    "CONNECT_BASE answer": _identity_line,
    "GET_BASE_STATUS answer": _power_line,
    "GET_BINARY_CONF answer": lambda facts: f"OK binary configuration of {facts['bytes']} bytes",
    "GET_BASE_SENSOR_DATA answer": _ranges_line,
    "GET_BASE_BUMPER_DATA answer": _contacts_line,
    "SET_V_AND_GET_DEADRECKON answer": _dead_reckon_line,
    "error": lambda facts: f"error 0x{facts['error_code']:04X} {facts['meaning']}",
    "SYNC": lambda facts: f"SYNC {facts['bytes']} bytes",
    "ECHO": lambda facts: f"ECHO {facts['bytes']} bytes",
}
