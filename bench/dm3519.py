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
from bench.m2006 import EmulatedEscs, MotorBus
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

    __slots__ = ("_clear_variant", "_numbers", "_sees_errors")

    def __init__(self, robot: Robot, family: Family) -> None:
        super().__init__(robot, family)
        chosen = _choice(robot)
        self._sees_errors = chosen.feedback == "error"
        self._clear_variant = chosen.clear_error
        self._numbers = tuple(wheel.can_id for wheel in robot.wheels)

    @property
    def errors(self) -> list[int]:
        """As each motor last reported it; 1, on, before its first report."""
        return [data[7] if data and self._sees_errors else ON for _, data in self._reports]

    @property
    def temperatures_degc(self) -> list[int]:
        """As each motor last reported it; 0 before its first report."""
        return [data[6] if data else 0 for _, data in self._reports]

    def wake(self) -> tuple[CanFrame, ...]:
        """A clear-error frame for every motor that reports an error; where none can be seen, for every motor."""
        return tuple(
            clear_error(number, self._clear_variant)
            for number, error in zip(self._numbers, self.errors, strict=True)
            if not self._sees_errors or error != ON
        )


class EmulatedDm3519s(EmulatedEscs):
    """The motors' end: as C610s, with a watchdog, and errors that either of the two clear frames takes away."""

    __slots__ = ("_all_on", "_numbers", "_sees_errors", "_told", "_watchdog_ticks", "errors")

    def __init__(self, robot: Robot, family: Family) -> None:
        super().__init__(robot, family)
        count = len(robot.wheels)
        self._sees_errors = _choice(robot).feedback == "error"
        self._watchdog_ticks = robot.motor.command_timeout_ms if robot.motor.on_command_loss == "fault" else None
        self._numbers = tuple(wheel.can_id for wheel in robot.wheels)
        self._heard = [_NEVER] * count
        self._last_words = [IDLE_DEGC << 8 | IDLE_DEGC] * count
        self._all_on = [ON] * count
        self._told: list[int] = []  # the errors that `_last_words` say
        self.errors = [ON] * count

    def fault(self, number: int, error: int) -> None:
        """Put ESC `number` into an error state, as if its sensor failed or its coil were hot. ValueError if unknown."""
        if error not in ERRORS:
            raise ValueError(f"error {error:#x} is none of {', '.join(f'{one:#x}' for one in ERRORS)}")
        self.errors[self._numbers.index(number)] = error

    def receive(self, tick: int, frames: Sequence[CanFrame]) -> list[float]:
        """Take this tick's command frames; answer with the current of each wheel in A, in its positive sense."""
        currents_a = super().receive(tick, frames)
        watchdog = self._watchdog_ticks
        if self.errors == self._all_on and (watchdog is None or tick - min(self._heard) < watchdog):
            return currents_a  # as in nearly every tick
        for wheel, error in enumerate(self.errors):
            if watchdog is not None and error == ON and tick - self._heard[wheel] >= watchdog:
                self.errors[wheel] = error = LINK_LOST
            if error != ON:
                currents_a[wheel] = 0.0
        return currents_a

    def feedback(
        self, angles_rad: Sequence[float], speeds_radps: Sequence[float], currents_a: Sequence[float]
    ) -> tuple[CanFrame, ...]:
        """One feedback frame for each ESC from its wheel's angle, speed and current, in wheel order."""
        if self._sees_errors and self.errors != self._told:
            self._told = list(self.errors)
            self._last_words = [IDLE_DEGC << 8 | error for error in self._told]
        return super().feedback(angles_rad, speeds_radps, currents_a)

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
