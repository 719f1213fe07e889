"""A bench that a test drives: hold the sticks, let time pass, look at what crossed the wires. Recorded all the while.

    with Driven(load_robot("m2006"), directory) as bench:
        bench.arm()
        bench.hold(forward=0.4).run(1.5)
        bench.transmitter.on = False
        bench.run(0.6)
        assert bench.plant.twist.vx_mps == 0.0

Sticks go in by the front door: encoded by the robot's own transmitter profile. `build` makes the base under test out of
a robot; it is ours unless another is given.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from bench.arena import FIELD, Arena, arena_toml
from bench.base import Base, ControlledBase
from bench.check.controllers import address_of, at_full_speed, name_of
from bench.check.lines import can_lines, rc_lines, slamware_lines
from bench.check.recording import Recorder
from bench.check.run import bench_in, info_of
from bench.config import Robot
from bench.messages import BodyTwist, CanFrame, TickInput, TickOutput
from bench.plant import Plant
from bench.rc.transmitter import AT_REST, Sticks, Transmitter

PRESS_S = 0.1
QUIET_TICKS = 20
"""A wire on which nothing else is left speaks every so often: the longest period of a transmitter's frames."""


class Driven:
    """One bench, its driver and its recording. A context manager; the recording ends with it.

    `outputs` is every tick until now. Raises ValueError for a robot that came from no file: it cannot be recorded.
    """

    def __init__(
        self,
        robot: Robot,
        directory: Path | str,
        build: Callable[[Robot], ControlledBase] = Base,
        arena: Arena = FIELD,
    ) -> None:
        if robot.file is None:
            raise ValueError("a run is recorded with its robot's file; this robot came from none")
        self.build = build
        self.bench = bench_in(robot, arena, build=build)
        self.transmitter = Transmitter(robot.rc) if robot.rc else None
        self.sticks = AT_REST
        self.outputs: list[TickOutput] = []
        self._twist: BodyTwist | None = None
        profile_file = robot.rc.file if robot.rc else None
        self.recorder = Recorder(
            directory,
            info_of(robot, name_of(build)),
            self.bench.state_columns,
            robot.file,
            profile_file,
            arena=arena_toml(arena) if arena != FIELD else "",
            heard=getattr(self.bench.base, "log_lines", None),
        )

    @property
    def directory(self) -> Path:
        """Of the recording."""
        return self.recorder.directory

    @property
    def robot(self) -> Robot:
        """Which one it is."""
        return self.bench.robot

    @property
    def base(self) -> ControlledBase:
        """The base under test."""
        return self.bench.base

    @property
    def plant(self) -> Plant:
        """Where the robot really is: `pose`, `twist`, `currents_a`."""
        return self.bench.world.plant

    def hold(
        self, *, forward: float = 0.0, left: float = 0.0, turn: float = 0.0, aux1: bool = False, aux2: bool = False
    ) -> Driven:
        """The sticks from now on; what is not named is at rest. Raises ValueError outside of -1 to 1."""
        for name, value in (("forward", forward), ("left", left), ("turn", turn)):
            if not -1.0 <= value <= 1.0:  # a transmitter would make full stick of it, of a NaN too
                raise ValueError(f"{name} is {value}; expected -1 to 1")
        self.sticks = Sticks(forward, left, turn, aux1, aux2)
        return self

    def ask(self, vx_mps: float = 0.0, vy_mps: float = 0.0, omega_radps: float = 0.0) -> Driven:
        """What the SLAMWARE core asks for from now on."""
        self._twist = BodyTwist(vx_mps, vy_mps, omega_radps)
        return self

    def arm(self) -> Driven:
        """Press AUX1 with the sticks at rest, and let go."""
        return self.hold().run(PRESS_S).hold(aux1=True).run(PRESS_S).hold().run(PRESS_S)

    def run(self, seconds: float) -> Driven:
        """Let time pass. Raises ValueError for less than none."""
        if seconds < 0.0:
            raise ValueError(f"a run of {seconds} s; expected 0 or more")
        bench, transmitter = self.bench, self.transmitter
        with at_full_speed(bench.base):
            for _ in range(round(1000 * seconds)):
                rc = transmitter.step(bench.now_tick, self.sticks) if transmitter else b""
                out = bench.tick(TickInput(rc, self._twist))
                self._twist = None
                self.outputs.append(out)
                self.recorder.add(out)
        return self

    def frames(self, can_id: int | None = None) -> list[tuple[int, CanFrame]]:
        """(tick, frame) of the CAN bus, commands and feedback; of one identifier, or all."""
        return [
            (out.tick, frame)
            for out in self.outputs
            for frame in out.can_commands + out.can_feedback
            if can_id is None or frame[0] == can_id
        ]

    def last_lines(self, count: int = 50) -> list[str]:
        """The newest lines of the wires, in the form of the logs."""
        return wire_lines(self.outputs, count)

    @property
    def again(self) -> str | None:
        """The command that runs the recording again; None where the base under test has no name to give."""
        return replay_command(self.directory, self.build)

    def close(self) -> None:
        """End the recording."""
        self.recorder.close()

    def __enter__(self) -> Driven:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def replay_command(source: Path, build: object) -> str | None:
    """How to run a scenario or recording again with this maker of bases; None where it has no name to give."""
    command = f"wheelbench replay {shlex.quote(str(source))}"
    if build is Base:
        return command
    address = address_of(build)
    return f"{command} --controller {shlex.quote(address)}" if address else None


def wire_lines(outputs: list[TickOutput], count: int) -> list[str]:
    """The last lines of all wires of these ticks, in the form of the logs, by time."""
    outputs = outputs[-QUIET_TICKS * count :]
    if not outputs:
        return []
    ticks = [out.tick for out in outputs]
    text = can_lines(ticks, [out.can_commands for out in outputs], [out.can_feedback for out in outputs])
    text += rc_lines(ticks, [out.rc for out in outputs])
    text += slamware_lines(ticks, [out.core_to_base for out in outputs], [out.base_to_core for out in outputs])
    return sorted(text.splitlines(), key=lambda line: float(line[1 : line.index(")")]))[-count:]
