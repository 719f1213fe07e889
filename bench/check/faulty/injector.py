"""The faults of a run: when each acts, its machine on its wire, and a witness of every piece that it touched."""

from __future__ import annotations

import random
from collections.abc import Sequence
from itertools import takewhile
from typing import NamedTuple, TypeVar

from bench.check.expression import condition, signals_in
from bench.check.faults import KINDS, Fault
from bench.check.faulty.machines import machine_of
from bench.check.faulty.pieces import Frames, Machine, shown
from bench.check.signals import Signals, names
from bench.check.temporal import Margin
from bench.config import Robot
from bench.messages import TickOutput

Piece = TypeVar("Piece", bytes, Frames)


class Touch(NamedTuple):
    """One piece that a fault did not leave as it was."""

    tick: int
    fault: str
    wire: str
    before: str
    after: str

    @property
    def text(self) -> str:
        """Its line in faults.log."""
        at = f"({self.tick // 1000}.{self.tick % 1000:03d}000)"
        return f'{at} "{self.fault}" {self.wire} {self.before} -> {self.after}'


class Phase:
    """Whether a fault is active: from a tick or from a condition's becoming true, for so long."""

    def __init__(self, fault: Fault, margin: Margin | None) -> None:
        self._fault, self._margin = fault, margin
        self._held = False
        self._since: int | None = fault.at if margin is None else None

    def observe(self, tick: int, sample: object) -> None:
        """What the run was like in this tick: a condition that becomes true starts the fault in the next one."""
        if self._margin is None:
            return
        holds = self._margin(sample) >= 0.0
        if holds and not self._held:
            self._since = tick + 1
        self._held = holds

    def active(self, tick: int) -> bool:
        """Whether the fault acts in this tick."""
        since, lasting = self._since, self._fault.lasting
        return since is not None and since <= tick and (lasting is None or tick < since + lasting)


class Injector:
    """The faults of a run, those on `wires`. Raises ValueError for a condition that cannot be read and a wheel that is
    not there.
    """

    def __init__(
        self,
        faults: Sequence[Fault],
        robot: Robot,
        state_columns: Sequence[str],
        seed: int = 0,
        wires: Sequence[str] = tuple(KINDS),
    ) -> None:
        known = names(robot, state_columns)
        wanted = {name for fault in faults if fault.when for name in signals_in(fault.when, known)}
        self._signals = Signals(robot, state_columns, wanted) if wanted else None
        self.faults: list[Fault] = []
        self.touches: list[Touch] = []
        self.by_hand = False
        self._robot, self._seed = robot, seed
        self._touched: dict[int, int] = {}
        self._phases: list[Phase] = []
        self._wires: dict[str, list[tuple[int, Machine]]] = {}
        for fault in faults:
            self._take(fault, condition(fault.when, known).margin if fault.when else None, fault.wire in wires)

    def inject(self, fault: Fault) -> None:
        """One more fault, from its time on, whatever its wire. Raises ValueError as at the start."""
        if fault.when:
            raise ValueError(f"{fault.name}: when: a fault that joins a run begins at a time")
        self._take(fault, None, True)

    def _take(self, fault: Fault, margin: Margin | None, acts: bool) -> None:
        robot, index = self._robot, len(self.faults)
        if fault.esc is not None and fault.esc > len(robot.wheels):
            raise ValueError(f"{fault.name}: esc: {robot.name} has {len(robot.wheels)} wheels, got {fault.esc}")
        if fault.wire == "rc" and robot.rc is None:
            raise ValueError(f"{fault.name}: wire: {robot.name} takes no RC")
        chance = random.Random(f"{self._seed} {index} {fault.name}")
        machine = machine_of(fault, robot, chance) if acts else None
        self.faults.append(fault)
        self._touched[index] = 0
        self._phases.append(Phase(fault, margin))
        if machine is not None:
            self._wires.setdefault(fault.wire, []).append((index, machine))

    def observe(self, out: TickOutput) -> None:
        """Follow the run, for the faults that wait for a condition."""
        if self._signals is not None:
            sample = self._signals.take(out)
            for phase in self._phases:
                phase.observe(out.tick, sample)

    def counts(self) -> dict[str, int]:
        """How many pieces each fault has touched."""
        acting = sorted({index for machines in self._wires.values() for index, _ in machines})
        return {self.faults[index].name: self._touched[index] for index in acting}

    def untouched(self) -> list[str]:
        """Names of the faults that touched nothing: a run that was to prove something has not.

        Faults that somebody injected by hand were to prove nothing (`by_hand`).
        """
        return [] if self.by_hand else [name for name, touched in self.counts().items() if not touched]

    def through(self, wire: str, tick: int, piece: Piece) -> Piece:
        """What the faults of a wire leave of a piece."""
        for index, machine in self._wires.get(wire, ()):
            after = machine(tick, piece, self._phases[index].active(tick))
            if after != piece:
                self._note(index, tick, shown(piece), shown(after))
            piece = after
        return piece

    def acting(self, wire: str, tick: int) -> list[Fault]:
        """The faults of motors or floor that act in this tick."""
        found = []
        for index, _ in self._wires.get(wire, ()):
            if self._phases[index].active(tick):
                found.append(self.faults[index])
        return found

    def note(self, fault: Fault, tick: int, before: str, after: str) -> None:
        """A witness of what a fault did to something else than a wire."""
        self._note(self.faults.index(fault), tick, before, after)

    def _note(self, index: int, tick: int, before: str, after: str) -> None:
        self._touched[index] += 1
        fault = self.faults[index]
        self.touches.append(Touch(tick, fault.name, fault.wire, before, after))

    def take_touches(self) -> list[Touch]:
        """What was touched since the last call."""
        taken, self.touches = self.touches, []
        return taken

    def touches_of(self, tick: int) -> list[Touch]:
        """What was touched in the newest tick, which this is; it stays to be taken."""
        return list(takewhile(lambda touch: touch.tick == tick, reversed(self.touches)))
