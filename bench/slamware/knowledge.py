"""What a core has learnt of its base: the latest of each answer, and the pose that all increments add up to."""

from __future__ import annotations

import math
from collections.abc import Callable

from bench.messages import Pose
from bench.odometry import wrap
from bench.slamware import commands as bus
from bench.slamware.config_payloads import BaseConfiguration, configuration_from_answer
from bench.slamware.health import Fault, Health, fault_from_answer, health_from_answer
from bench.slamware.payloads import (
    Identity,
    MotorData,
    dead_reckon_from_answer,
    identity_from_answer,
    motor_data_from_answer,
)
from bench.slamware.sense_payloads import (
    Beacons,
    Power,
    base_request_from_answer,
    beacons_from_answer,
    contacts_from_answer,
    power_from_answer,
    ranges_from_answer,
)

ORIGIN = Pose(0.0, 0.0, 0.0)
CONTACTS = 10
"""Contacts that the reference base defines; what a base says of others is told by its configuration alone."""


class Knowledge:
    """All None, empty or zero until the base has told it."""

    def __init__(self) -> None:
        self.identity: Identity | None = None
        self.pose = ORIGIN
        """Where the core believes the robot is: the increments of all 0x41 answers that arrived, composed."""
        self.status = 0
        """Status bits of the last 0x41 answer."""
        self.uptime_ms: int | None = None
        self.configuration: BaseConfiguration | None = None
        self.binary_configuration = b""
        self.power: Power | None = None
        self.motor_data: MotorData | None = None
        self.ranges_m: tuple[float, ...] = ()
        self.contacts: tuple[bool, ...] = ()
        """The first ten contacts, True where one is triggered."""
        self.beacons: Beacons | None = None
        self.health: Health | None = None
        self.faults: dict[int, Fault] = {}
        """By index; those of the last summary that counted any."""
        self.base_request: int | None = None
        """What the base asked in its last answer to 0x50."""
        self._readers: dict[tuple[int, int], Callable[[bytes, bytes], None]] = {
            (bus.CONNECT_BASE, 0): self._identify,
            (bus.GET_BASE_CONF, 0): self._configure,
            (bus.GET_BINARY_CONF, 0): self._configure_freely,
            (bus.GET_BASE_STATUS, 0): self._measure_power,
            (bus.GET_BASE_MOTOR_DATA, 0): self._roll,
            (bus.GET_BASE_SENSOR_DATA, 0): self._range,
            (bus.GET_BASE_BUMPER_DATA, 0): self._touch,
            (bus.GET_AUTO_HOME_DATA, 0): self._see_dock,
            (bus.SET_V_AND_GET_DEADRECKON, 0): self._move,
            (bus.POLL_BASE_CMD, 0): self._be_asked,
            (bus.HEALTH_MGMT, bus.GET_HEALTH): self._take_health,
            (bus.HEALTH_MGMT, bus.GET_FAULT): self._take_fault,
        }

    def take(self, kind: tuple[int, int], request: bytes, payload: bytes) -> None:
        """Learn from the OK to a request; its kind and size have been matched (`answer_table`)."""
        reader = self._readers.get(kind)
        if reader is not None:
            reader(payload, request)

    def _identify(self, payload: bytes, request: bytes) -> None:
        self.identity = identity_from_answer(payload)

    def _configure(self, payload: bytes, request: bytes) -> None:
        self.configuration = configuration_from_answer(payload)

    def _configure_freely(self, payload: bytes, request: bytes) -> None:
        self.binary_configuration = payload

    def _measure_power(self, payload: bytes, request: bytes) -> None:
        self.power = power_from_answer(payload)

    def _roll(self, payload: bytes, request: bytes) -> None:
        self.motor_data = motor_data_from_answer(payload)

    def _range(self, payload: bytes, request: bytes) -> None:
        self.ranges_m = ranges_from_answer(payload)

    def _touch(self, payload: bytes, request: bytes) -> None:
        self.contacts = contacts_from_answer(payload, CONTACTS)

    def _see_dock(self, payload: bytes, request: bytes) -> None:
        self.beacons = beacons_from_answer(payload)

    def _move(self, payload: bytes, request: bytes) -> None:
        # An increment is a displacement, not a twist: it is turned into the frame and added, without the exponential.
        dx_m, dy_m, dtheta_rad, self.status, self.uptime_ms = dead_reckon_from_answer(payload)
        x_m, y_m, heading_rad = self.pose
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        self.pose = Pose(x_m + c * dx_m - s * dy_m, y_m + s * dx_m + c * dy_m, wrap(heading_rad + dtheta_rad))

    def _be_asked(self, payload: bytes, request: bytes) -> None:
        self.base_request = base_request_from_answer(payload)

    def _take_health(self, payload: bytes, request: bytes) -> None:
        self.health = health_from_answer(payload)
        self.faults = {index: fault for index, fault in self.faults.items() if index < self.health.number}

    def _take_fault(self, payload: bytes, request: bytes) -> None:
        self.faults[request[2]] = fault_from_answer(payload)
