"""Roles: which part of the bench is real. Each is a short composition of the two halves, with ports where one was.

    base      a firmware under test: the bench plays transmitter, SLAMWARE core, ESCs and floor
    core      a SLAMWARE core under test: the bench plays the base, its motors and its driver
    motors    real motors: the bench plays driver, core and base; the plant only shadows them

A `Rig` holds the ports. What drives real motors passes `Limiter`, the last line before the port.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bench.base import Base
from bench.check.faulty import FaultyWorld
from bench.config import Robot
from bench.errors import UsageError
from bench.io.can_port import CanPort
from bench.io.limiter import Limiter, refuse_arming_by_link, refuse_unarmed
from bench.io.paced_writer import PacedWriter
from bench.io.rig import OutBus, Rig
from bench.io.serial_port import SerialPort
from bench.loop import Bench
from bench.messages import BodyTwist, CanFrame
from bench.plant import Plant
from bench.rc.line import USUAL
from bench.slamware.core_side import SlamwareCore
from bench.world import SimulatedMotors, World


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
    refuse_unarmed("--can", at["--can"], armed)
    refuse_arming_by_link("--can", at["--can"], robot)
    _refuse_unreal_faults(world)
    bus = rig.can("--can", at["--can"])
    assert bus is not None
    rig.limiter = Limiter(robot)
    rig.is_for_core_alone = robot.rc is None
    rig.holds_zero = not rig.is_for_core_alone  # that one moves when it is asked to, and --arm allows it
    base = bench.base
    if isinstance(base, Base):
        rig.is_armed = lambda: base.drive.armed
    world.motors = PortMotors(robot, world.plant, bus, rig, rig.limiter)
    return bench


def _refuse_unreal_faults(world: World) -> None:
    if isinstance(world, FaultyWorld):
        unreal = next((fault for fault in world.injector.faults if fault.wire in ("esc", "plant")), None)
        if unreal is not None:
            raise UsageError(f"--role motors: the fault {unreal.name!r} is one of {unreal.wire}, which is real here")


_BUILD: dict[str, Callable[[Bench, Rig, dict[str, str], bool], Bench]] = {
    "base": _base,
    "core": _core,
    "motors": _motors,
}


def _refuse(at: dict[str, str], role: str, names: tuple[str, ...], why: str) -> None:
    for name in names:
        if at[name] != "sim:":
            raise UsageError(f"--role {role}: {name} has no place, because {why}; leave it out")
