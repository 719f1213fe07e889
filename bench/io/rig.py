"""The real ports of a run, looked after between ticks.

A rig says when a port is lost and when it is back, lets frames of late ticks leave only where they are the newest, and
keeps everything silent while something is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bench.io.address import can_address, serial_address
from bench.io.can_port import LAST_WORD_S, CanPort, open_can
from bench.io.limiter import Limiter
from bench.io.paced_writer import PacedWriter
from bench.io.serial_port import SerialPort, open_serial
from bench.messages import ZERO_TWIST, BodyTwist, CanFrame, TickInput
from bench.rc.line import USUAL

SILENT = TickInput(b"", ZERO_TWIST)
"""What enters while something is missing: no transmitter, and a core that wants to stand."""
CLOSING_FRAMES = 3
HELD = "real motors are held at zero: {} to go on"


class OutBus:
    """Frames on their way to a bus. A tick's all leave; of several late ticks, the newest of each identifier."""

    def __init__(self, port: CanPort) -> None:
        self.port = port
        self.superseded = 0
        """Frames that never left because a newer one was there."""
        self._waiting: dict[int, list[CanFrame]] = {}

    def put(self, frames: Sequence[CanFrame]) -> None:
        """The frames of one tick."""
        waiting = self._waiting
        mine: set[int] = set()
        for frame in frames:
            can_id = frame[0]
            if can_id not in mine:
                mine.add(can_id)
                self.superseded += len(waiting.pop(can_id, ()))
                waiting[can_id] = [frame]
            else:
                waiting[can_id].append(frame)

    def end(self, frames: Sequence[CanFrame]) -> None:
        """The last word, several times; what was waiting has nothing to say any more."""
        self._waiting.clear()
        self.port.write([*frames] * CLOSING_FRAMES, LAST_WORD_S)

    def flush(self) -> None:
        """Let them go."""
        if self._waiting:
            self.port.write([frame for frames in self._waiting.values() for frame in frames])
            self._waiting.clear()


class Rig:
    """The real ports of a run. `notices` are sentences for the person, with their tick, until they are taken."""

    def __init__(self, role: str) -> None:
        self.role = role
        self.ports: list[SerialPort | CanPort] = []
        self.buses: list[OutBus] = []
        self.writers: list[PacedWriter] = []
        self.notices: list[tuple[int, str]] = []
        self.losses = 0
        self.operator_silent = False
        self.limiter: Limiter | None = None
        self.holds_zero = False
        """Real motors get no current until everything is there and the base is disarmed."""
        self.is_armed: Callable[[], bool] = lambda: False
        """Whether the base is armed, where somebody can tell."""
        self.is_for_core_alone = False
        """A robot without RC is armed for ever. It may go on when a standstill has been asked for."""
        self._asked: BodyTwist | None = ZERO_TWIST
        """None: a recording's bytes ask, of which nobody knows here whether they ask for a standstill."""
        self._lost: dict[int, str] = {}
        self._flooded: set[int] = set()

    @property
    def is_silent(self) -> bool:
        """Whether a port or the operator is missing: then nothing is asked of anybody."""
        return bool(self._lost) or self.operator_silent

    @property
    def missing(self) -> tuple[str, ...]:
        """The ports that are lost now, and why; or that motors stand still under a base that is armed."""
        if self.holds_zero and not self.is_silent and self._is_wanted():
            return (HELD.format(self._freed_by("disarm and arm again")),)
        return tuple(f"{self.ports[index].name}: {why}" for index, why in self._lost.items())

    def gated(self, inputs: Callable[[int], TickInput]) -> Callable[[int], TickInput]:
        """The same inputs, but silence while something is missing, and while a robot without RC is held."""

        def given(tick: int) -> TickInput:
            entering = inputs(tick)
            if entering.core_twist is not None or entering.slamware:
                self._asked = entering.core_twist
            return SILENT if self.is_silent or (self.is_for_core_alone and self.holds_zero) else entering

        return given

    def look(self, tick: int) -> None:
        """After a tick: which port has gone or come back."""
        for index, port in enumerate(self.ports):
            if port.is_flooded and index not in self._flooded:
                self._flooded.add(index)
                self.notices.append((tick, f"{port.name}: floods, with more than a real wire could bring"))
            if port.lost:
                if index not in self._lost:
                    self.losses += 1
                    self.notices.append((tick, f"{port.name}: lost ({port.lost}); zero until it is back"))
                self._lost[index] = port.lost
                if port.revive():
                    del self._lost[index]
                    self._back(tick, port)
            elif index in self._lost:
                del self._lost[index]
                self._back(tick, port)
        if self.limiter is not None:
            if self.is_silent:
                self.holds_zero = True
            elif self.holds_zero and not self._is_wanted():
                self.holds_zero = False

    def watch_operator(self, tick: int, silent: bool) -> None:
        """Whether the operator has said nothing for too long."""
        if silent != self.operator_silent:
            self.operator_silent = silent
            what = f"is back{self._again}" if not silent else "is silent: zero until that changes"
            self.notices.append((tick, f"the operator {what}"))

    def flush(self) -> None:
        """Let what is waiting go."""
        for bus in self.buses:
            bus.flush()

    def step(self) -> None:
        """A millisecond for the lines that are paced."""
        for writer in self.writers:
            writer.step()

    def find(self) -> bool:
        """Whether all ports are there; before the first tick, when it is no loss that one is not yet."""
        return all([port.revive() for port in self.ports])

    def close(self) -> None:
        """Give everything back; motors are told to stop first."""
        if self.limiter is not None:
            for bus in self.buses:
                bus.end(self.limiter.stop)
        for port in self.ports:
            port.close()

    def _back(self, tick: int, port: SerialPort | CanPort) -> None:
        self.notices.append((tick, f"{port.name}: back{self._again}"))

    def _is_wanted(self) -> bool:
        """Whether the robot would move on its own, were it let go."""
        return self._asked != ZERO_TWIST if self.is_for_core_alone else self.is_armed()

    @property
    def _again(self) -> str:
        return f"; {self._freed_by('arm again')} to go on" if self.limiter is not None else ""

    def _freed_by(self, arming: str) -> str:
        """What lets motors go that are held at zero."""
        if not self.is_for_core_alone:
            return arming
        return "ask it to stand" if self._asked is not None else "start this run anew"

    def serial(self, name: str, address: str, protocol: str | None = None) -> SerialPort | None:
        """Open a serial line of this rig; None for `sim:`."""
        where = serial_address(name, address)
        if where.is_sim:
            return None
        port = open_serial(name, where, USUAL[protocol]) if protocol else open_serial(name, where)
        self.ports.append(port)
        return port

    def can(self, name: str, address: str) -> tuple[CanPort, OutBus] | None:
        """Open a bus of this rig; None for `sim:`."""
        where = can_address(name, address)
        if where.is_sim:
            return None
        port = open_can(name, where)
        self.ports.append(port)
        bus = OutBus(port)
        self.buses.append(bus)
        return port, bus
