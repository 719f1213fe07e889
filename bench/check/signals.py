"""What crossed the wires and where the robot was, as named signals: one sample a tick, the last value held.

    t_s                                   the tick's time
    the columns of state.csv              every 10 ms: truth, odometry, link, armed, driver, wheels
    speed_mps, odo_off_m                  made of them: over ground; odometry to truth
    command1_a, command2_a ...            what the base commands each motor, in the wheel's sense; None before a frame
    feedback1_radps, feedback1_a ...      what each ESC reports; None before a frame
    rc0, rc1 ...                          raw channels of the last good RC frame
    rc_failsafe, rc_frame_lost            its flags
    rc_age_ms, command_age_ms             time since the last good RC frame, since the last command frame
    core_vx_mps, core_vy_mps, core_omega_radps     what the SLAMWARE core last asked for with 0x41

Wheels count from 1, in the robot file's order; channels from 0. Everything is decoded from the recorded bytes, so a
run while it runs and its recording afterwards have the same signals. Only what is asked for is decoded.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.canbus.table import Family, Message
from bench.config import Robot
from bench.messages import CanFrame, RcFrame, TickOutput
from bench.motors import family
from bench.slamware.describe import decoded
from bench.slamware.framing import FrameDecoder, SlamwareFrame

_SPEED, _ODO_OFF = "speed_mps", "odo_off_m"
_RC_AGE, _COMMAND_AGE = "rc_age_ms", "command_age_ms"
_CORE = ("core_vx_mps", "core_vy_mps", "core_omega_radps")
_Place: TypeAlias = tuple[str, int, float]
"""Signal, which of the message's values, and what a count of it is worth."""


def names(robot: Robot, state_columns: Sequence[str]) -> tuple[str, ...]:
    """Every signal that a run of this robot has."""
    found = [*state_columns, _SPEED, _ODO_OFF, _COMMAND_AGE]
    for number in range(1, len(robot.wheels) + 1):
        found += [f"command{number}_a", f"feedback{number}_radps", f"feedback{number}_a"]
    if robot.rc is not None:
        found += [f"rc{channel}" for channel in range(len(rc_decode.channel_limits(robot.rc.protocol)))]
        found += ["rc_failsafe", "rc_frame_lost", _RC_AGE]
    return (*found, *_CORE)


class Signals:
    """Follows a run tick by tick. `sample` is one dictionary that changes: what it holds is of the last tick taken."""

    def __init__(self, robot: Robot, state_columns: Sequence[str], wanted: Iterable[str]) -> None:
        every = names(robot, state_columns)
        asked = frozenset(wanted)
        unknown = asked - frozenset(every)
        if unknown:
            raise ValueError(f"no signal is called {min(unknown)!r}; known: {', '.join(every)}")
        self.sample: dict[str, Any] = dict.fromkeys(asked)
        self._columns = tuple(state_columns)
        self._state_wanted = bool(asked & {*state_columns, _SPEED, _ODO_OFF})
        motors = any(name.startswith(("command", "feedback")) for name in asked)
        self._motors = _Motors(robot, family(robot), asked) if motors else None
        rc = robot.rc if any(name.startswith("rc") for name in asked) else None
        self._rc = rc_decode.decoder(rc.protocol, pause_us=RC_PAUSE_US) if rc else None
        self._rc_tick: int | None = None
        self._core = FrameDecoder() if asked & set(_CORE) else None

    def take(self, out: TickOutput) -> dict[str, Any]:
        """The next tick; returns the sample."""
        sample = self.sample
        if out.state is not None and self._state_wanted:
            self._take_state(out.state)
        if "t_s" in sample:
            sample["t_s"] = out.tick / 1000.0
        if self._motors is not None:
            self._motors.take(out, sample)
        if self._rc is not None:
            self._take_rc(out)
        if self._core is not None and out.core_to_base:
            self._take_core(out)
        return sample

    def _take_state(self, row: Sequence[float | int | str]) -> None:
        sample = self.sample
        values = dict(zip(self._columns, row, strict=True))
        for name in sample.keys() & values.keys():
            sample[name] = values[name]
        if _SPEED in sample:
            sample[_SPEED] = math.hypot(float(values["vx_mps"]), float(values["vy_mps"]))
        if _ODO_OFF in sample:
            odometry = float(values["odo_x_m"]), float(values["odo_y_m"])
            sample[_ODO_OFF] = math.dist((float(values["x_m"]), float(values["y_m"])), odometry)

    def _take_rc(self, out: TickOutput) -> None:
        assert self._rc is not None
        sample = self.sample
        for event in self._rc.feed(out.rc, out.tick * 1000):
            if isinstance(event, RcFrame):
                self._rc_tick = out.tick
                for channel, raw in enumerate(event.channels):
                    if f"rc{channel}" in sample:
                        sample[f"rc{channel}"] = raw
                for name, flag in (("rc_failsafe", event.failsafe), ("rc_frame_lost", event.frame_lost)):
                    if name in sample:
                        sample[name] = flag
        if _RC_AGE in sample and self._rc_tick is not None:
            sample[_RC_AGE] = out.tick - self._rc_tick

    def _take_core(self, out: TickOutput) -> None:
        assert self._core is not None
        for event in self._core.feed(out.core_to_base):
            values = decoded(event) if isinstance(event, SlamwareFrame) else {}
            for name in _CORE:
                if name in self.sample and name.removeprefix("core_") in values:
                    self.sample[name] = values[name.removeprefix("core_")]


class _Motors:
    """Commands and feedback of every wheel, in A and rad/s of the wheel, positive in its own sense."""

    def __init__(self, robot: Robot, messages: Family, wanted: frozenset[str]) -> None:
        amperes = messages.full_scale_a / messages.full_scale_raw
        self._commands: dict[int, tuple[Message, list[_Place]]] = {}
        self._feedback: dict[int, tuple[Message, list[_Place]]] = {}
        for number, wheel in enumerate(robot.wheels, 1):
            report = messages.feedback[wheel.can_id - 1]
            group = next(one for one in messages.commands if _place(one, f"current_{wheel.can_id}") is not None)
            rpm, ampere = wheel.direction * math.tau / 60.0 / wheel.gear, wheel.direction * amperes
            for found, message, name, field, scale in (
                (self._commands, group, f"command{number}_a", f"current_{wheel.can_id}", ampere),
                (self._feedback, report, f"feedback{number}_radps", "speed", rpm),
                (self._feedback, report, f"feedback{number}_a", "current", ampere),
            ):
                place = _place(message, field)
                if place is not None and (name in wanted or found is self._commands):
                    found.setdefault(message.can_id, (message, []))[1].append((name, place, scale))
        self._by_command = any(name.startswith("command") for name in wanted)
        self._command_tick: int | None = None

    def take(self, out: TickOutput, sample: dict[str, Any]) -> None:
        if self._by_command:
            if self._read(self._commands, out.can_commands, sample):
                self._command_tick = out.tick
            if _COMMAND_AGE in sample and self._command_tick is not None:
                sample[_COMMAND_AGE] = out.tick - self._command_tick
        if self._feedback:
            self._read(self._feedback, out.can_feedback, sample)

    def _read(
        self,
        known: dict[int, tuple[Message, list[_Place]]],
        frames: Iterable[CanFrame],
        sample: dict[str, Any],
    ) -> bool:
        read = False
        for can_id, data in frames:
            message, places = known.get(can_id, (None, []))
            values = message.decode(data) if message is not None else None
            if values is None:
                continue
            read = True
            for name, place, scale in places:
                if name in sample:
                    sample[name] = values[place] * scale
        return read


def _place(message: Message, field: str) -> int | None:
    """Where `decode` has a field; None where the message has none of this name."""
    return next((place for place, one in enumerate(message.variables) if one.name == field), None)
