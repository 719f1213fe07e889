"""DaMiao DM3519 on CAN: both ends of the wire, where they are not a C610's. The messages are in `bench.canbus.dm3519`.

    on 1 --(no command for command_timeout_ms, on_command_loss = "fault")--> link lost D
     ^   --(`fault`)------------------------------------------------------> any other error
     '------------------------(clear-error frame)------------------------------'

In an error a motor gives no current and takes no command, but reports. That it stays there until the clear frame, and
that the timeout counts from the first command, is assumed; so are its temperatures, which do not move from 25 degC.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.canbus.dm3519 import ERRORS, LINK_LOST, ON, clear_error, cleared_esc
from bench.canbus.table import Family
from bench.config import Dm3519, Robot
from bench.m2006 import FRAME_LENGTH, EmulatedEscs, MotorBus
from bench.messages import CanFrame

IDLE_DEGC = 25


def _choice(robot: Robot) -> Dm3519:
    if robot.dm3519 is None:
        raise ValueError(f"robot {robot.name} has motors of kind {robot.motor.kind}, not dm3519")
    return robot.dm3519


class Dm3519Bus(MotorBus):
    """The base's end: as a C610's, and what bytes 6 and 7 say.

    `temperatures_degc` and `errors` are in wheel order. With feedback = "temperatures" nobody can see an error, and
    `errors` stays at 1, on.
    """

    __slots__ = ("_clear_variant", "_numbers", "_sees_errors", "_wheel_of", "errors", "temperatures_degc")

    def __init__(self, robot: Robot, family: Family) -> None:
        super().__init__(robot, family)
        chosen = _choice(robot)
        self._sees_errors = chosen.feedback == "error"
        self._clear_variant = chosen.clear_error
        self._numbers = tuple(wheel.can_id for wheel in robot.wheels)
        self._wheel_of = {family.feedback[number - 1].can_id: wheel for wheel, number in enumerate(self._numbers)}
        self.errors = [ON] * len(self._numbers)
        self.temperatures_degc = [0] * len(self._numbers)

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> None:
        """Take the feedback frames that arrived in this tick."""
        super().receive(tick, frames)
        for can_id, data in frames:
            wheel = self._wheel_of.get(can_id)
            if wheel is not None and len(data) == FRAME_LENGTH:
                self.temperatures_degc[wheel] = data[6]
                if self._sees_errors:
                    self.errors[wheel] = data[7]

    def wake(self) -> tuple[CanFrame, ...]:
        """A clear-error frame for every motor that reports an error; where none can be seen, for every motor."""
        return tuple(
            clear_error(number, self._clear_variant)
            for number, error in zip(self._numbers, self.errors, strict=True)
            if not self._sees_errors or error != ON
        )


class EmulatedDm3519s(EmulatedEscs):
    """The motors' end: as C610s, with a watchdog, and errors that either of the two clear frames takes away."""

    __slots__ = ("_numbers", "_sees_errors", "_watchdog_ticks", "errors")

    def __init__(self, robot: Robot, family: Family) -> None:
        super().__init__(robot, family)
        count = len(robot.wheels)
        self._sees_errors = _choice(robot).feedback == "error"
        self._watchdog_ticks = robot.motor.command_timeout_ms if robot.motor.on_command_loss == "fault" else None
        self._numbers = tuple(wheel.can_id for wheel in robot.wheels)
        self._heard = [_NEVER] * count
        self.errors = [ON] * count

    def fault(self, number: int, error: int) -> None:
        """Put ESC `number` into an error state, as if its sensor failed or its coil were hot. ValueError if unknown."""
        if error not in ERRORS:
            raise ValueError(f"error {error:#x} is none of {', '.join(f'{one:#x}' for one in ERRORS)}")
        self.errors[self._numbers.index(number)] = error

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> list[float]:
        """Take this tick's command frames; answer with the current of each wheel in A, in its positive sense."""
        currents_a = super().receive(tick, frames)
        for wheel, error in enumerate(self.errors):
            if self._watchdog_ticks is not None and error == ON and tick - self._heard[wheel] >= self._watchdog_ticks:
                self.errors[wheel] = error = LINK_LOST
            if error != ON:
                currents_a[wheel] = 0.0
        return currents_a

    def feedback(
        self, angles_rad: Sequence[float], speeds_radps: Sequence[float], currents_a: Sequence[float]
    ) -> tuple[CanFrame, ...]:
        """One feedback frame for each ESC from its wheel's angle, speed and current, in wheel order."""
        frames = super().feedback(angles_rad, speeds_radps, currents_a)
        errors = self.errors
        return tuple(
            (can_id, data[:6] + bytes((IDLE_DEGC, errors[wheel] if self._sees_errors else IDLE_DEGC)))
            for (wheel, *_), (can_id, data) in zip(self._reports, frames, strict=True)
        )

    def _other_frame(self, tick: int, can_id: int, data: bytes) -> None:
        number = cleared_esc(can_id, data)
        if number in self._numbers:
            wheel = self._numbers.index(number)
            self.errors[wheel] = ON
            self._heard[wheel] = tick  # the watchdog starts anew
        else:
            super()._other_frame(tick, can_id, data)


_NEVER = 1 << 62
"""A tick that does not come: the watchdog of a motor that has never been commanded does not run."""
