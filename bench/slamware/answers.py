"""What a base does and answers for each sub-command of 0xF8, whatever its receiver is like.

    0x10 who are you       0x30 power             0x40 wheel speeds       0x50 what do you ask    0x90 health
    0x20 how are you built 0x31 wheel distances   0x41 velocity, motion   0x5F I have it
    0x21 the same, free    0x32 ranges            0x60 an event
                           0x33 contacts          0x34 dock beacons

A sub-command is a row in `commands.SUB_COMMANDS` and a handler here. How requests arrive, what is refused before it is
looked at, and how long a core lives: `base_side`, `reference_firmware`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from bench.messages import TICK_US, ZERO_TWIST, BodyTwist
from bench.slamware import commands as bus
from bench.slamware.config_payloads import configuration_answer
from bench.slamware.facts import BaseFacts
from bench.slamware.health import (
    HealthRegister,
    battery_faults,
    code_from_fields,
    fault_answer,
    health_answer,
)
from bench.slamware.payloads import (
    LONG_DEAD_RECKON_BYTES,
    OMNI_MOTOR_DATA_BYTES,
    Displacement,
    dead_reckon_answer,
    identity_answer,
    omni_motor_answer,
    twist_from_request,
    two_wheel_answer,
    wheels_from_request,
)
from bench.slamware.sense_payloads import (
    RANGE_SLOTS,
    base_request_answer,
    beacons_answer,
    contacts_answer,
    power_answer,
    ranges_answer,
)
from bench.slamware.senses import NOWHERE, Motion, Senses, Wanted

EVENT_LOG_LENGTH = 50
STANDSTILL = Wanted(ZERO_TWIST)


class Refused(Exception):
    """A well-formed request that this base does not carry out."""

    def __init__(self, code: int) -> None:
        super().__init__(f"error 0x{code:04X}")
        self.code = code


class Answers:
    """The state of one slave, and its answers. ValueError where the facts do not fit on the wire."""

    def __init__(self, facts: BaseFacts, motion: Motion, senses: Senses | None = None) -> None:
        self.facts = facts
        self.motion = motion
        self.senses = senses or Senses()
        self.wanted_twist: BodyTwist = ZERO_TWIST
        """Velocity of the last 0x41, or of the wheel speeds of the last 0x40, whichever came later."""
        self.wanted_slip_radps: tuple[float, ...] = ()
        """Wheel speeds of a 0x40 beyond those of the twist, in wheel order; empty where there are none."""
        self.connected = False
        """Whether a core has shaken hands since boot. Motion is obeyed without, as the reference base does."""
        self.asking: int | None = None
        """What this base asks of its core (0x50) until the core has it (0x5F). Pulls nCCMD low on a real base."""
        self.core_events: deque[tuple[int, int]] = deque(maxlen=EVENT_LOG_LENGTH)
        """(tick, event) of what the core told with 0x60, known or not."""
        self.health = HealthRegister()
        self._tick = 0
        self._has_reported_motion = False
        self._identity = identity_answer(facts.identity, facts.dialect.identity_bytes)
        self._configuration = configuration_answer(facts.configuration)
        # Methods and no lambdas: an instant of a run is kept by pickling it (`io.still`).
        self._handlers: dict[int, Callable[[bytes], bytes]] = {
            bus.CONNECT_BASE: self._connect,
            bus.GET_BASE_CONF: self._base_configuration,
            bus.GET_BINARY_CONF: self._binary_configuration,
            bus.GET_BASE_STATUS: self._power,
            bus.GET_BASE_MOTOR_DATA: self._motor_data,
            bus.GET_BASE_SENSOR_DATA: self._ranges,
            bus.GET_BASE_BUMPER_DATA: self._contacts,
            bus.GET_AUTO_HOME_DATA: self._beacons,
            bus.SET_BASE_MOTOR: self._set_wheels,
            bus.SET_V_AND_GET_DEADRECKON: self._set_velocity,
            bus.POLL_BASE_CMD: self._base_request,
            bus.POLL_BASE_ANS_CMD: self._request_taken,
            bus.SEND_EVENT: self._event,
            bus.HEALTH_MGMT: self._manage_health,
        }

    def ask_core(self, request: int) -> None:
        """Ask the core for something from its next 0x50 on; the latest request stands. ValueError outside 0..254."""
        if not 0 <= request < bus.NOTHING_TO_ASK:
            raise ValueError(f"base request {request} outside 0..254")
        self.asking = request

    def carry_out(self, sub_command: int, fields: bytes, tick: int) -> bytes:
        """Do what a request asks and give the payload of its OK. Raises Refused with the error code."""
        handler = self._handlers.get(sub_command)
        if handler is None:
            raise Refused(bus.NOT_SUPPORTED)
        self._tick = tick
        return handler(fields)

    def stop(self) -> None:
        """Forget what a core wanted of the wheels."""
        self._want(STANDSTILL)

    def _want(self, wanted: Wanted) -> None:
        self.wanted_twist, self.wanted_slip_radps = wanted

    def _connect(self, fields: bytes) -> bytes:
        if fields[0] != bus.PROTOCOL_VERSION:
            raise Refused(bus.NOT_SUPPORTED)
        self.connected = True
        return self._identity

    def _base_configuration(self, fields: bytes) -> bytes:
        return self._configuration

    def _binary_configuration(self, fields: bytes) -> bytes:
        return self.facts.binary_configuration

    def _power(self, fields: bytes) -> bytes:
        return power_answer(self.senses.power())

    def _ranges(self, fields: bytes) -> bytes:
        return ranges_answer(self.senses.ranges_m()[:RANGE_SLOTS])

    def _base_request(self, fields: bytes) -> bytes:
        return base_request_answer(self.asking)

    def _motor_data(self, fields: bytes) -> bytes:
        motion = self.motion
        if self.facts.dialect.motor_data_bytes == OMNI_MOTOR_DATA_BYTES:
            if not 0 < motion.wheel_count <= bus.MOST_WHEELS:
                raise Refused(bus.NOT_SUPPORTED)
            return omni_motor_answer(motion.rim_distances_m(), motion.take_second_increment())
        if motion.wheel_count != 2:  # the layout has a left and a right, and an omni base has neither
            raise Refused(bus.NOT_SUPPORTED)
        left_m, right_m = motion.rim_distances_m()
        return two_wheel_answer(left_m, right_m, motion.status())

    def _contacts(self, fields: bytes) -> bytes:
        return contacts_answer(self.senses.contacts(), self.facts.dialect.bumper_bytes)

    def _beacons(self, fields: bytes) -> bytes:
        if fields[0] != bus.DOCK_BEACONS:
            raise Refused(bus.NOT_SUPPORTED)
        return beacons_answer(self.senses.beacons())

    def _set_wheels(self, fields: bytes) -> bytes:
        count = self.motion.wheel_count
        if not 0 < count <= bus.MOST_WHEELS:
            raise Refused(bus.NOT_SUPPORTED)
        wanted = self.motion.follow_rims(wheels_from_request(fields)[:count])
        if wanted is not None:
            self._want(wanted)
        return b""

    def _set_velocity(self, fields: bytes) -> bytes:
        increment = self.motion.take_increment()
        self._want(self.motion.follow_twist(twist_from_request(fields)))
        if not self._has_reported_motion:
            # The first answer after boot is zero and throws earlier motion away. A new handshake does not repeat that.
            self._has_reported_motion = True
            increment = NOWHERE
        says_time = self.facts.dialect.dead_reckon_bytes == LONG_DEAD_RECKON_BYTES
        return self._dead_reckoned(increment, self._tick * TICK_US // 1000 if says_time else None)

    def _dead_reckoned(self, increment: Displacement, uptime_ms: int | None) -> bytes:
        return dead_reckon_answer(*increment, self.motion.status(), uptime_ms)

    def _request_taken(self, fields: bytes) -> bytes:
        self.asking = None
        return b""

    def _event(self, fields: bytes) -> bytes:
        self.core_events.append((self._tick, fields[0]))
        return b""

    def _manage_health(self, fields: bytes) -> bytes:
        register, command = self.health, fields[0]
        register.take_causes((*battery_faults(self.senses.power().percent), *self.motion.faults(self._tick)))
        faults = register.faults
        if command == bus.GET_HEALTH:
            return health_answer(faults)
        if command == bus.GET_FAULT and fields[1] < len(faults):
            return fault_answer(faults[fields[1]])
        if command == bus.CLEAR_FAULT and register.clear(code_from_fields(fields)):
            return b""
        raise Refused(bus.FAILED)
