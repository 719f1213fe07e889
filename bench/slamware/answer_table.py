"""Which sizes an OK answer may have, by what was asked: the core's means to match them, and the reader's.

An answer names neither command nor sub-command. It is matched by order, by status, and by these sizes: as wide as later
dialects may append fields, as narrow as keeps a late answer from being taken for another one.
"""

from __future__ import annotations

from bench.slamware import commands as bus
from bench.slamware.config_payloads import CONFIGURATION_BYTES
from bench.slamware.framing import LONG_MAX_PAYLOAD

ANSWERS: dict[tuple[int, int], tuple[int, int]] = {
    (bus.CONNECT_BASE, 0): (28, 63),
    (bus.GET_BASE_CONF, 0): (CONFIGURATION_BYTES, 512),
    (bus.GET_BINARY_CONF, 0): (1, LONG_MAX_PAYLOAD),
    (bus.GET_BASE_STATUS, 0): (2, 8),
    (bus.GET_BASE_MOTOR_DATA, 0): (9, 36),
    (bus.GET_BASE_SENSOR_DATA, 0): (64, 128),
    (bus.GET_BASE_BUMPER_DATA, 0): (1, 4),
    (bus.GET_AUTO_HOME_DATA, 0): (2, 257),
    (bus.SET_BASE_MOTOR, 0): (0, 0),
    (bus.SET_V_AND_GET_DEADRECKON, 0): (13, 27),
    (bus.POLL_BASE_CMD, 0): (0, 2),
    (bus.POLL_BASE_ANS_CMD, 0): (0, 0),
    (bus.SEND_EVENT, 0): (0, 0),
    (bus.HEALTH_MGMT, bus.GET_HEALTH): (2, 8),
    (bus.HEALTH_MGMT, bus.GET_FAULT): (5, 36),
    (bus.HEALTH_MGMT, bus.CLEAR_FAULT): (0, 0),
}
"""(sub-command, health command or 0) -> least and most bytes of its OK answer."""


def kind_of(request: bytes) -> tuple[int, int] | None:
    """The row of a request's payload; None where no OK can answer it."""
    if not request:
        return None
    kind = (request[0], request[1] if request[0] == bus.HEALTH_MGMT and len(request) > 1 else 0)
    return kind if kind in ANSWERS else None


def reads(request: bytes, payload: bytes) -> tuple[int, int] | None:
    """The row of a request whose answer this payload can be; None where it cannot."""
    kind = kind_of(request)
    if kind is None:
        return None
    least, most = ANSWERS[kind]
    return kind if least <= len(payload) <= most else None
