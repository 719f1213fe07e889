"""Makes faults happen: a world whose wires, motors and floor fail as a scenario says, with a witness of every touch.

`FaultyWorld` stands where a `World` stands. What it changes, it changes where the base or the motors meet it, so a
recording holds what really arrived. A fault is a small machine that takes each tick's piece and gives what is left of
it; while it is not active it hands everything through untouched, and `touched` counts the pieces that it did not.

Several faults on one wire act in the order of the scenario file.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from itertools import takewhile
from typing import Any, NamedTuple, TypeAlias, TypeVar

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.check.expression import condition, signals_in
from bench.check.faults import FRAME_KINDS, KINDS, Fault
from bench.check.signals import Signals, names
from bench.check.temporal import Margin
from bench.config import Robot
from bench.messages import CanFrame, RcFrame, TickInput, TickOutput
from bench.motors import family
from bench.world import SimulatedMotors, World

OVER_CURRENT = b"\x0a"
"""Byte 7 of a DM3519's feedback: `bench.canbus.dm3519.ERRORS`."""

Frames: TypeAlias = tuple[CanFrame, ...]
Piece = TypeVar("Piece", bytes, Frames)
Machine: TypeAlias = Callable[[int, Any, bool], Any]
"""Tick, what came in it, whether the fault acts -> what is left. Bytes to bytes, frames to frames."""


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
        machine = _machine(fault, robot, chance) if acts else None
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
                self._note(index, tick, _text(piece), _text(after))
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


class FaultyWorld(World):
    """A world in which the faults of an injector happen."""

    def __init__(self, world: World, injector: Injector) -> None:
        motors = world.motors
        if isinstance(motors, SimulatedMotors):
            motors = _FaultyMotors(world.robot, motors, injector)
        super().__init__(world.robot, core=world.core, motors=motors)
        self.take_over(world)
        self.injector = injector

    def speak(self, tick: int, given: TickInput) -> tuple[bytes, bytes, Frames]:
        """As `World.speak`, over failing wires."""
        rc, core, feedback = super().speak(tick, given)
        through = self.injector.through
        return through("rc", tick, rc), through("core", tick, core), feedback

    def hear(self, tick: int, can_out: Sequence[CanFrame], slamware_out: bytes) -> Frames:
        """As `World.hear`, over failing wires. The feedback that it gives is what reaches the base."""
        through = self.injector.through
        commands = through("command", tick, tuple(can_out))
        feedback = super().hear(tick, commands, through("answer", tick, slamware_out))
        self._feedback = feedback = through("feedback", tick, feedback)
        return feedback


class _FaultyMotors(SimulatedMotors):
    """Motors that may fall silent or weak, on a floor that may be slippery, under a robot that may be pushed."""

    def __init__(self, robot: Robot, motors: SimulatedMotors, injector: Injector) -> None:
        self.plant, self.escs, self.instruments = motors.plant, motors.escs, motors.instruments
        self.noise = motors.noise
        self._injector = injector
        self._ids = [family(robot).feedback[wheel.can_id - 1].can_id for wheel in robot.wheels]
        self._grip, self._full_grip = 1.0, robot.ground.grip

    def step(self, tick: int, commands: Sequence[CanFrame]) -> Frames:
        """As `SimulatedMotors.step`."""
        plant, injector = self.plant, self._injector
        currents = list(self.escs.receive(tick, commands))
        silent: set[int] = set()
        for fault in injector.acting("esc", tick):
            for wheel in range(len(currents)) if fault.esc is None else (fault.esc - 1,):
                before = currents[wheel]
                if fault.kind == "silent":
                    silent.add(self._ids[wheel])
                currents[wheel] = 0.0 if fault.kind == "silent" else before * fault.factor
                if fault.kind == "silent" or before:
                    after = "silent" if fault.kind == "silent" else f"{currents[wheel]:.3f} A"
                    injector.note(fault, tick, f"wheel {wheel + 1}: {before:.3f} A", after)
        self._touch_the_plant(tick)
        plant.step(currents)
        feedback = self.escs.feedback(plant.wheel_angles_rad, plant.wheel_speeds_radps, plant.currents_a)
        if self.noise is not None:
            feedback = self.noise.step(tick, feedback)
        if silent:
            feedback = tuple(frame for frame in feedback if frame[0] not in silent)
        return feedback if self.instruments is None else feedback + self.instruments.step()

    def _touch_the_plant(self, tick: int) -> None:
        grip = 1.0
        for fault in self._injector.acting("plant", tick):
            if fault.kind == "slippery":
                grip *= fault.factor
                self._injector.note(fault, tick, "grip 1", f"grip {fault.factor:g}")
                continue
            x_n, y_n = fault.force_n * math.cos(fault.bearing_rad), fault.force_n * math.sin(fault.bearing_rad)
            self.plant.push(x_n, y_n)
            self._injector.note(fault, tick, "0 N", f"{x_n:.2f} N, {y_n:.2f} N")
        if grip != self._grip:
            self._grip = grip
            self.plant.set_grip(grip * self._full_grip)


# --- the machines ----------------------------------------------------------------------------------------------------


def _machine(fault: Fault, robot: Robot, chance: random.Random) -> Machine:
    """What a fault does to a wire: (tick, piece, active) -> piece. Objects and no closures: an instant can be kept."""
    if fault.wire in ("esc", "plant"):
        return _untouched
    if fault.wire in ("command", "feedback"):
        return _bus_machine(fault, robot, chance)
    if fault.wire == "rc" and fault.kind in FRAME_KINDS:
        assert robot.rc is not None
        return _Frames(fault.kind, robot.rc.protocol)
    return _holder(fault, b"") or _Serial(fault, chance)


def _bus_machine(fault: Fault, robot: Robot, chance: random.Random) -> Machine:
    own: dict[str, Callable[[], Machine]] = {
        "stuck": _Stuck, "freeze": _FrozenFrames, "flag": partial(_ErrorFlag, robot)
    }  # fmt: skip
    machine = own[fault.kind]() if fault.kind in own else _holder(fault, ()) or _Bus(fault, chance)
    if fault.esc is None:
        return machine
    number = robot.wheels[fault.esc - 1].can_id
    messages = family(robot)
    return _Only({messages.feedback[number - 1].can_id, messages.commands[(number - 1) // 4].can_id}, machine)


def _untouched(_tick: int, piece: Any, _active: bool) -> Any:
    return piece


class _Only:
    """The frames of one ESC through a machine; the others as they are, before them."""

    def __init__(self, ids: set[int], machine: Machine) -> None:
        self._ids, self._machine = ids, machine

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        ids = self._ids
        chosen = tuple(frame for frame in frames if frame[0] in ids)
        left: Frames = self._machine(tick, chosen, active)
        return frames if left == chosen else tuple(frame for frame in frames if frame[0] not in ids) + left


class _Serial:
    """Bytes that are changed within their tick."""

    def __init__(self, fault: Fault, chance: random.Random) -> None:
        self._fault, self._chance = fault, chance

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        if not active:
            return piece
        fault, chance = self._fault, self._chance
        match fault.kind:
            case "drop":
                return b"" if piece and chance.random() < fault.probability else piece
            case "duplicate":
                return piece + piece
            case "corrupt":
                return _corrupted(piece, fault.probability, chance)
            case "lose_byte":
                return bytes(byte for byte in piece if chance.random() >= fault.probability)
            case "truncate":
                return piece[: fault.keep]
            case "garbage":
                return chance.randbytes(len(piece) or 1)
        raise ValueError(f"{fault.kind} is no fault of a serial wire")


class _Bus:
    """Frames that are changed within their tick."""

    def __init__(self, fault: Fault, chance: random.Random) -> None:
        self._fault, self._chance = fault, chance

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        if not active:
            return frames
        fault, chance = self._fault, self._chance
        match fault.kind:
            case "drop":
                return tuple(frame for frame in frames if chance.random() >= fault.probability)
            case "duplicate":
                return frames + frames
            case "corrupt":
                return tuple((i, _corrupted(data, fault.probability, chance)) for i, data in frames)
            case "truncate":
                return tuple((i, data[: fault.keep]) for i, data in frames)
        raise ValueError(f"{fault.kind} is no fault of the bus")


def _holder(fault: Fault, empty: bytes | Frames) -> Machine | None:
    """The machines that keep pieces for later."""
    if fault.kind == "delay":
        return _Delay(fault.ms, empty)
    if fault.kind == "stall":
        return _Stall(empty)
    if fault.kind == "freeze":
        return _FrozenPieces()
    return _Swap(empty) if fault.kind == "reorder" else None


class _Delay:
    """Pieces come later; what is still under way when the fault ends comes before what follows."""

    def __init__(self, ms: int, empty: Any) -> None:
        self._ms, self._empty = ms, empty
        self._waiting: deque[tuple[int, Any]] = deque()

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        waiting = self._waiting
        if not active and not waiting:
            return piece
        if piece:
            # After the fault nothing waits longer than what is before it.
            due = tick + self._ms if active else max(tick, waiting[-1][0] if waiting else tick)
            waiting.append((due, piece))
        out = self._empty
        while waiting and waiting[0][0] <= tick:
            out += waiting.popleft()[1]
        return out


class _Stall:
    """Nothing comes, then everything."""

    def __init__(self, empty: Any) -> None:
        self._empty: Any = empty
        self._held: Any = empty

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        held = self._held + piece
        self._held = held if active else self._empty
        return self._empty if active else held


class _Swap:
    """Every piece waits for the next one and comes after it. Several frames of one tick change places at once."""

    def __init__(self, empty: Any) -> None:
        self._empty: Any = empty
        self._held: Any = empty

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        held = self._held
        if active and piece and not held:
            if isinstance(piece, tuple) and len(piece) > 1:
                return piece[::-1]
            self._held = piece
            return self._empty
        if held and (piece or not active):
            self._held = self._empty
            return piece + held
        return piece


class _FrozenPieces:
    """Every piece is the first one again."""

    def __init__(self) -> None:
        self._first = b""

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        if not active:
            self._first = b""
            return piece
        self._first = self._first or piece
        return self._first if piece else piece


class _FrozenFrames:
    """Every frame of an identifier is the first one again."""

    def __init__(self) -> None:
        self._first: dict[int, bytes] = {}

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        if not active:
            self._first.clear()
            return frames
        return tuple((can_id, self._first.setdefault(can_id, data)) for can_id, data in frames)


class _ErrorFlag:
    """Feedback that reports an error. Raises ValueError where the motor's frames have no place for one."""

    def __init__(self, robot: Robot) -> None:
        if robot.dm3519 is None or robot.dm3519.feedback != "error":
            raise ValueError(
                f"flag: the feedback of {robot.name} cannot report an error; that of a DM3519 can, where its [dm3519] "
                'says feedback = "error"'
            )

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        return tuple((can_id, data[:7] + OVER_CURRENT) for can_id, data in frames) if active else frames


class _Frames:
    """Whole RC frames with something changed. From the moment it acts, bytes wait until their frame is whole."""

    def __init__(self, kind: str, protocol: str) -> None:
        self._kind, self._protocol = kind, protocol
        self._frozen: tuple[int, ...] | None = None
        self._decoder = rc_decode.decoder(protocol, pause_us=RC_PAUSE_US)
        self._lowest = tuple(low for low, _ in rc_decode.channel_limits(protocol))
        self._changed(RcFrame(0, 0, self._lowest))  # refuses a flag that this protocol cannot carry, before the run

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        events = self._decoder.feed(piece, tick * 1000)
        if not active:
            self._frozen = None
            return piece
        return b"".join([self._changed(event) for event in events if isinstance(event, RcFrame)])

    def _changed(self, frame: RcFrame) -> bytes:
        channels = frame.channels
        if self._kind == "zeros":
            channels = self._lowest
        elif self._kind == "freeze":
            if self._frozen is None:
                self._frozen = channels
            channels = self._frozen
        failsafe = frame.failsafe or self._kind == "flag"
        lost = frame.frame_lost or self._kind == "lost_flag"
        return rc_decode.encode(self._protocol, channels, failsafe, lost, frame.digital)


class _Stuck:
    """Feedback frames with the angle of the first one, and no speed: bytes 0 to 3 in every family."""

    def __init__(self) -> None:
        self._angles: dict[int, bytes] = {}

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        if not active:
            self._angles.clear()
            return frames
        return tuple((i, self._angles.setdefault(i, data[:2]) + b"\0\0" + data[4:]) for i, data in frames)


def _corrupted(piece: bytes, probability: float, chance: random.Random) -> bytes:
    return bytes(byte ^ (1 << chance.randrange(8)) if chance.random() < probability else byte for byte in piece)


def _text(piece: bytes | Frames) -> str:
    """A piece for a person."""
    if isinstance(piece, bytes):
        return piece.hex(" ").upper() or "-"
    return " ".join(f"{can_id:03X}#{data.hex().upper()}" for can_id, data in piece) or "-"
