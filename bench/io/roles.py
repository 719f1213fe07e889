"""Roles: which part of the bench is real. Each is a short composition of the two halves, with ports where one was.

    base      a firmware under test: the bench plays transmitter, SLAMWARE core, ESCs and floor
    core      a SLAMWARE core under test: the bench plays the base, its motors and its driver
    motors    real motors: the bench plays driver, core and base; the plant only shadows them

A `Rig` holds the ports. It looks after them between ticks: says when one is lost and when it is back, lets frames of
late ticks leave only where they are the newest, and keeps everything silent while something is missing. What drives
real motors passes `Limiter`, the last line before the port.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

from bench.base import Base
from bench.check.faulty import FaultyWorld
from bench.config import Robot
from bench.errors import UsageError
from bench.io.address import can_address, serial_address
from bench.io.can_port import CanPort, open_can
from bench.io.paced_writer import PacedWriter
from bench.io.serial_port import SerialPort, open_serial
from bench.loop import Bench
from bench.messages import ZERO_TWIST, BodyTwist, CanFrame, TickInput
from bench.motors import family
from bench.plant import Plant
from bench.rc.line import USUAL
from bench.slamware.core_side import SlamwareCore
from bench.world import SimulatedMotors

SILENT = TickInput(b"", ZERO_TWIST)
"""What enters while something is missing: no transmitter, and a core that wants to stand."""
CLOSING_FRAMES = 3
_WORDS = struct.Struct(">hhhh")


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

    def flush(self) -> None:
        """Let them go."""
        if self._waiting:
            self.port.write([frame for frames in self._waiting.values() for frame in frames])
            self._waiting.clear()


class Limiter:
    """The last line before a port with motors: currents within the robot's limit, and nothing that is no command."""

    def __init__(self, robot: Robot) -> None:
        known = family(robot)
        self.limit_raw = math.floor(robot.limits.current_a * known.raw_per_a)
        self.clamped = self.refused = 0
        """Frames."""
        ids = {wheel.can_id for wheel in robot.wheels}
        groups = sorted({(can_id - 1) // 4 for can_id in ids})
        self._commands = {known.commands[group].can_id: group for group in groups}
        self._slots = {
            command: tuple(group * 4 + slot + 1 in ids for slot in range(4))
            for command, group in self._commands.items()
        }
        self._others = {message.can_id: message.length for message in known.others}
        self.stop = tuple((can_id, bytes(8)) for can_id in self._commands)

    def __call__(self, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """What may leave."""
        passed = []
        for can_id, data in frames:
            if can_id in self._commands and len(data) == 8:
                passed.append((can_id, self._limited(can_id, data)))
            elif self._others.get(can_id) == len(data):
                passed.append((can_id, data))
            else:
                self.refused += 1
        return tuple(passed)

    def _limited(self, can_id: int, data: bytes) -> bytes:
        most, slots = self.limit_raw, self._slots[can_id]
        given = _WORDS.unpack(data)
        # Slots of motors that are not this robot's stay empty: somebody else's may hang there.
        kept = [max(-most, min(most, raw)) if mine else 0 for raw, mine in zip(given, slots, strict=True)]
        limited = _WORDS.pack(*kept)
        self.clamped += limited != data
        return limited


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
        self._lost: dict[int, str] = {}
        self._flooded: set[int] = set()
        self._is_armed: Callable[[], bool] = lambda: False

    @property
    def is_silent(self) -> bool:
        """Whether a port or the operator is missing: then nothing is asked of anybody."""
        return bool(self._lost) or self.operator_silent

    @property
    def missing(self) -> tuple[str, ...]:
        """The ports that are lost now, and why."""
        return tuple(f"{self.ports[index].name}: {why}" for index, why in self._lost.items())

    def gated(self, inputs: Callable[[int], TickInput]) -> Callable[[int], TickInput]:
        """The same inputs, but silence while something is missing."""

        def given(tick: int) -> TickInput:
            entering = inputs(tick)
            return SILENT if self._lost or self.operator_silent else entering

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
            elif self.holds_zero and not self._is_armed():
                self.holds_zero = False

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
                for _ in range(CLOSING_FRAMES):
                    bus.put(self.limiter.stop)
                    bus.flush()
        for port in self.ports:
            port.close()

    def _back(self, tick: int, port: SerialPort | CanPort) -> None:
        again = "; arm again to go on" if self.limiter is not None else ""
        self.notices.append((tick, f"{port.name}: back{again}"))

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


class PortBase:
    """A firmware under test, behind the seam: what the world says goes out, what comes back is its answer."""

    def __init__(
        self,
        can: tuple[CanPort, OutBus] | None,
        rc: PacedWriter | None,
        slamware: SerialPort | None,
    ) -> None:
        self._can, self._rc, self._slamware = can, rc, slamware

    def step(
        self, tick: int, rc_bytes: bytes, slamware_bytes: bytes, can_in: Sequence[CanFrame]
    ) -> tuple[tuple[CanFrame, ...], bytes]:
        """One millisecond of wires."""
        commands: tuple[CanFrame, ...] = ()
        answer = b""
        if self._rc is not None and rc_bytes:
            self._rc.put(rc_bytes)
        if self._slamware is not None:
            if slamware_bytes:
                self._slamware.write(slamware_bytes)
            answer = self._slamware.read()
        if self._can is not None:
            port, out = self._can
            out.put(can_in)
            commands = port.read()
        return commands, answer


class PortCore(SlamwareCore):
    """A SLAMWARE core at the end of a serial line. Nobody here tells it what to ask for."""

    def __init__(self, line: SerialPort) -> None:
        super().__init__()
        self._port = line

    def ask(self, twist: BodyTwist) -> None:
        """It asks what it likes."""

    def step(self, tick: int, answer_bytes: bytes) -> bytes:
        """The base's answer out, the core's request in."""
        if answer_bytes:
            self._port.write(answer_bytes)
        return self._port.read()


class PortMotors(SimulatedMotors):
    """Real motors on a bus; ours and the plant only shadow what they are told."""

    def __init__(self, robot: Robot, plant: Plant, bus: tuple[CanPort, OutBus], rig: Rig, limiter: Limiter) -> None:
        super().__init__(robot, plant)
        self._port, self._out = bus
        self._rig, self._limiter = rig, limiter

    def step(self, tick: int, commands: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """Commands out, within limits; the feedback that has come."""
        leaving = self._limiter.stop if self._rig.holds_zero else self._limiter(commands)
        self._out.put(leaving)
        self.plant.step(self.escs.receive(tick, leaving))
        if self.instruments is not None:
            self.instruments.step()
        return self._port.read()


def take_role(
    bench: Bench, role: str, *, rc: str = "sim:", slamware: str = "sim:", can: str = "sim:", armed: bool = False
) -> tuple[Bench, Rig]:
    """A bench whose part is real, and its ports. Raises UsageError for addresses that the role has no use for, and
    where motors may move without `armed`; SurroundingsError where a port cannot be opened. Ports are closed then.
    """
    rig = Rig(role)
    try:
        return _BUILD[role](bench, rig, {"--rc": rc, "--slamware": slamware, "--can": can}, armed), rig
    except BaseException:
        rig.close()
        raise


def _base(bench: Bench, rig: Rig, at: dict[str, str], armed: bool) -> Bench:
    if at["--can"] == "sim:":
        raise UsageError(
            "--role base: needs --can, where the firmware's commands come from; such as --can can:socketcan:can0"
        )
    can = rig.can("--can", at["--can"])
    robot = bench.robot
    if robot.rc is None and at["--rc"] != "sim:":
        raise UsageError(f"--rc {at['--rc']}: {robot.name} takes no RC; leave --rc out")
    line = rig.serial("--rc", at["--rc"], robot.rc.protocol if robot.rc else None)
    rc = None
    if line is not None and robot.rc is not None:
        rc = PacedWriter(line, USUAL[robot.rc.protocol])
        rig.writers.append(rc)
    return Bench(PortBase(can, rc, rig.serial("--slamware", at["--slamware"])), bench.world)


def _core(bench: Bench, rig: Rig, at: dict[str, str], armed: bool) -> Bench:
    _refuse(at, "core", ("--rc", "--can"), "the bench plays the base and its motors")
    if at["--slamware"] == "sim:":
        raise UsageError("--role core: needs --slamware, where the core is; such as --slamware serial:/dev/ttyUSB0")
    line = rig.serial("--slamware", at["--slamware"])
    assert line is not None
    bench.world.core = PortCore(line)
    return bench


def _motors(bench: Bench, rig: Rig, at: dict[str, str], armed: bool) -> Bench:
    _refuse(at, "motors", ("--rc", "--slamware"), "the bench plays driver and core")
    if at["--can"] == "sim:":
        raise UsageError(
            "--role motors: needs --can, where the motors are; such as --can can:slcan:/dev/ttyACM0@1000000"
        )
    robot, world = bench.robot, bench.world
    if not can_address("--can", at["--can"]).is_harmless:
        if not armed:
            raise UsageError(f"--can {at['--can']}: may move real motors; lift the robot off the floor and add --arm")
        if robot.rc is not None and robot.rc.arming != "switch":
            raise UsageError(
                f"--role motors: the profile {robot.rc.name} arms by its link alone; give one with a switch"
            )
    if isinstance(world, FaultyWorld):
        unreal = next((fault for fault in world.injector.faults if fault.wire in ("esc", "plant")), None)
        if unreal is not None:
            raise UsageError(f"--role motors: the fault {unreal.name!r} is one of {unreal.wire}, which is real here")
    bus = rig.can("--can", at["--can"])
    assert bus is not None
    rig.limiter = Limiter(robot)
    rig.holds_zero = True
    base = bench.base
    if isinstance(base, Base):
        rig._is_armed = lambda: base.drive.armed
    plant = world.plant
    world.motors = PortMotors(robot, plant, bus, rig, rig.limiter)
    return bench


_BUILD: dict[str, Callable[[Bench, Rig, dict[str, str], bool], Bench]] = {
    "base": _base,
    "core": _core,
    "motors": _motors,
}


def _refuse(at: dict[str, str], role: str, names: tuple[str, ...], why: str) -> None:
    for name in names:
        if at[name] != "sim:":
            raise UsageError(f"--role {role}: {name} has no place, because {why}; leave it out")
