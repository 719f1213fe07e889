"""The numbers of the control bus: sub-commands, errors, events, base requests, and the dialects of the payloads.

Source: SLAMTEC's base reference firmware of 2018-11-20, executed; its chassis SDK of 2020; the vendor's wiki. Names are
the vendor's.
"""

from __future__ import annotations

from typing import NamedTuple

CONNECT_BASE = 0x10
GET_BASE_CONF, GET_BINARY_CONF = 0x20, 0x21
GET_BASE_STATUS, GET_BASE_MOTOR_DATA, GET_BASE_SENSOR_DATA = 0x30, 0x31, 0x32
GET_BASE_BUMPER_DATA, GET_AUTO_HOME_DATA = 0x33, 0x34
SET_BASE_MOTOR, SET_V_AND_GET_DEADRECKON = 0x40, 0x41
POLL_BASE_CMD, POLL_BASE_ANS_CMD = 0x50, 0x5F
SEND_EVENT = 0x60
HEALTH_MGMT = 0x90

PROTOCOL_VERSION = 1
DOCK_BEACONS = 0
"""The one data type of 0x34."""
GET_HEALTH, GET_FAULT, CLEAR_FAULT = 0x01, 0x02, 0x03
"""Health commands, the first byte after 0x90."""
MOST_WHEELS = 4
"""Words in a 0x40 request, and distances in the 28-byte answer to 0x31."""


class SubCommand(NamedTuple):
    """A row of the table of sub-commands: its name and how many bytes may follow the sub-command byte in a request."""

    name: str
    request_bytes: tuple[int, ...]


SUB_COMMANDS = {
    CONNECT_BASE: SubCommand("CONNECT_BASE", (1,)),
    GET_BASE_CONF: SubCommand("GET_BASE_CONF", (0,)),
    GET_BINARY_CONF: SubCommand("GET_BINARY_CONF", (0,)),
    GET_BASE_STATUS: SubCommand("GET_BASE_STATUS", (0,)),
    GET_BASE_MOTOR_DATA: SubCommand("GET_BASE_MOTOR_DATA", (0,)),
    GET_BASE_SENSOR_DATA: SubCommand("GET_BASE_SENSOR_DATA", (0,)),
    GET_BASE_BUMPER_DATA: SubCommand("GET_BASE_BUMPER_DATA", (0,)),
    GET_AUTO_HOME_DATA: SubCommand("GET_AUTO_HOME_DATA", (1,)),
    SET_BASE_MOTOR: SubCommand("SET_BASE_MOTOR", (16,)),
    SET_V_AND_GET_DEADRECKON: SubCommand("SET_V_AND_GET_DEADRECKON", (12,)),
    POLL_BASE_CMD: SubCommand("POLL_BASE_CMD", (0,)),
    POLL_BASE_ANS_CMD: SubCommand("POLL_BASE_ANS_CMD", (0,)),
    SEND_EVENT: SubCommand("SEND_EVENT", (1,)),
    HEALTH_MGMT: SubCommand("HEALTH_MGMT", (1, 2, 5)),
}

_HEALTH_BYTES = {GET_HEALTH: 1, GET_FAULT: 2, CLEAR_FAULT: 5}


def well_sized(sub_command: int, fields: bytes) -> bool:
    """Whether so many bytes may follow this known sub-command."""
    if len(fields) not in SUB_COMMANDS[sub_command].request_bytes:
        return False
    return sub_command != HEALTH_MGMT or _HEALTH_BYTES.get(fields[0], len(fields)) == len(fields)


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
"""Bits of the status byte in the answers to 0x31 and 0x41."""

SYSTEM_UP = 0x63
EVENT_NAMES = {
    0x61: "lidar connection failed",
    0x62: "lidar ramp-up failed",
    SYSTEM_UP: "system up",
    0x64: "firmware update",
    0x65: "core disconnecting",
    0x66: "firmware update done",
    0x80: "sweep started",
    0x81: "sweep ended",
    0x82: "vacuum on",
    0x83: "vacuum off",
}
"""What a core tells with 0x60."""

NOTHING_TO_ASK = 0xFF
"""Bases of 2017 answer 0x50 with this where later ones answer with nothing."""
BASE_REQUEST_NAMES = {
    0x51: "get info",
    0x52: "reset Wi-Fi",
    0x53: "firmware upgrading",
    0x80: "start sweep",
    0x81: "stop sweep",
    0x82: "spot sweep",
    0x90: "get health",
    0xA0: "move forward",
    0xA1: "move backward",
    0xA2: "turn left",
    0xA3: "turn right",
    0xA4: "go home",
    0xAF: "cancel",
    0xB0: "auxiliary anchor",
}
"""What a base asks of its core in the answer to 0x50."""


class Dialect(NamedTuple):
    """How long four answers are: their layout changed over the years."""

    identity_bytes: int
    """0x10: 28, or 39 with the firmware version's suffix."""
    motor_data_bytes: int
    """0x31: 9 for two wheels, or 28 with four wheel distances and a displacement."""
    bumper_bytes: int
    """0x33: 4, or 1."""
    dead_reckon_bytes: int
    """0x41: 13, or 17 with the base's uptime."""


DIALECTS = {
    "firmware-2018": Dialect(28, 9, 4, 13),
    "firmware-2018-omni": Dialect(28, 28, 4, 13),
    "firmware-2015": Dialect(28, 28, 1, 13),
    "sdk-2020": Dialect(39, 9, 4, 17),
}
"""By the `dialect` of a robot file. The first is the reference firmware's; "-omni" is the same with the only answer to
0x31 that has room for more than two wheels."""
