"""A run: a bench, the inputs of every tick, and what it is called. `sources` makes one of whatever a path holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from bench.arena import FIELD, Arena, arena_toml
from bench.base import Base
from bench.check.controllers import Build, at_full_speed, hears_no_core
from bench.check.crosswire.observer import CrossWire
from bench.check.expectations import Judge
from bench.check.faulty import Injector
from bench.check.reading import Recording
from bench.check.recording import BLOCK_TICKS, Recorder, RunInfo
from bench.config import (
    EXACT,
    SPEED_LOOP,
    Robot,
    load_robot,
    with_choices,
)
from bench.errors import UsageError
from bench.loop import Bench, simulated
from bench.messages import TickInput, TickOutput
from bench.noise import SILENT, Noise
from bench.timed.settings import UNTIMED, Wires
from bench.timed.timing import Timing


@dataclass(slots=True)
class Run:
    """Iterate to run it, once. `source` is the recording that it repeats, where it is one's replay."""

    title: str
    bench: Bench
    ticks: int
    inputs: Callable[[int], TickInput]
    info: RunInfo
    source: Recording | None = None
    judge: Judge | None = None
    """Of the scenario's expectations."""
    injector: Injector | None = None
    """Of the scenario's faults."""
    checks: CrossWire | None = None
    """Of what the wires say of each other; in every run that is judged."""
    about: str = ""
    """What the scenario says of itself."""
    scenario: bytes | None = None
    """Its text goes into the recording where it says what the other files do not: faults, expectations, checks."""
    lifted_ticks: int = 0
    """In so many a wheel would have left the floor: the plant has no robot that tips, and its motion is a guess."""
    first_lift_tick: int = -1

    def recorder(self, directory: Path | str, *, overwrite: bool = False) -> Recorder:
        """A recorder for this run's ticks. Raises RecordingError where the place cannot be written, UsageError where it
        is the recording that is run again.
        """
        robot = self.bench.robot
        if self.source is not None and Path(directory).resolve() == self.source.directory.resolve():
            raise UsageError(f"--record {directory}: is the recording that is run again; record in another directory")
        if robot.file is None:
            raise ValueError("a run is recorded with its robot's file; this robot came from none")
        profile_file = robot.rc.file if robot.rc else None
        if robot != with_choices(load_robot(robot.file, profile_file), robot.control.kind, robot.odometry):
            raise UsageError(
                f"{robot.file}: a recording keeps the robot's file, and this robot was changed since it was read; "
                "write the changed one to a file of its own to record it"
            )
        columns = self.bench.state_columns
        arena = self.bench.world.plant.arena
        text = arena_toml(arena) if arena is not None and arena != FIELD else ""
        return Recorder(
            directory,
            self.info,
            columns,
            robot.file,
            profile_file,
            scenario=self.scenario,
            arena=text,
            heard=getattr(self.bench.base, "log_lines", None),
            on_bus=self.bench.world.timing.start_log() if self.bench.world.timing is not None else None,
            overwrite=overwrite,
        )

    def __iter__(self) -> Iterator[TickOutput]:
        """Every tick of the run, in order."""
        run_tick, inputs, plant = self._run_tick(), self.inputs, self.bench.world.plant
        with at_full_speed(self.bench.base):
            for tick in range(self.ticks):
                out = run_tick(inputs(tick))
                if plant.wheel_lift:
                    self._lifts(tick)
                yield out

    def blocks(self) -> Iterator[list[TickOutput]]:
        """The same, `BLOCK_TICKS` at a time: what follows a run costs a third of tick by tick then.

        Where a tick raises an error, the ones before it come first.
        """
        run_tick, inputs, plant = self._run_tick(), self.inputs, self.bench.world.plant
        block: list[TickOutput] = []
        try:
            with at_full_speed(self.bench.base):
                for start in range(0, self.ticks, BLOCK_TICKS):
                    block = []
                    for tick in range(start, min(start + BLOCK_TICKS, self.ticks)):
                        block.append(run_tick(inputs(tick)))
                        if plant.wheel_lift:
                            self._lifts(tick)
                    yield block
        except Exception:
            yield block
            raise

    def _lifts(self, tick: int) -> None:
        if not self.lifted_ticks:
            self.first_lift_tick = tick
        self.lifted_ticks += 1

    def _run_tick(self) -> Callable[[TickInput], TickOutput]:
        """The bench's tick; faults that wait for a condition see what came of it."""
        run_tick, injector = self.bench.tick, self.injector
        if injector is None:
            return run_tick

        def observed(given: TickInput) -> TickOutput:
            out = run_tick(given)
            injector.observe(out)
            return out

        return observed


def bench_in(robot: Robot, arena: Arena, noise: Noise = SILENT, build: Build = Base, wires: Wires = UNTIMED) -> Bench:
    """The simulated bench in an arena, with our base or another. Raises UsageError where a robot cannot begin."""
    why = arena.in_the_way(robot.body.radius_m, arena.start)
    if why:
        fits = 2.0 * robot.body.radius_m <= min(arena.length_m, arena.width_m)
        what = "give it another [start]" if fits else "give it a larger field (--arena FILE, docs/plant.md)"
        raise UsageError(f"arena {arena.name!r}: {why}; {what}")
    bench = simulated(robot, arena, noise)
    bench.world.timing = Timing(wires, robot.rc.protocol if robot.rc else None) if wires.is_on else None
    if hears_no_core(build):
        bench.world.core = None
    return bench if build is Base else Bench(build(robot), bench.world)


def info_of(
    robot: Robot,
    controller: str | None = None,
    *,
    scenario: str | None = None,
    seed: int = 0,
    noise: Noise = SILENT,
    wires: Wires = UNTIMED,
) -> RunInfo:
    """What run.toml says of a run of this robot; `controller` as `bench.check.controllers` names it."""
    return RunInfo(
        robot=robot.name,
        profile=robot.rc.name if robot.rc else None,
        scenario=scenario,
        controller=controller or (robot.control.kind if robot.control.kind != SPEED_LOOP else None),
        odometry=robot.odometry if robot.odometry != EXACT else None,
        seed=seed,
        noise_angle_counts=noise.angle_counts or None,
        noise_late_ticks=noise.late_ticks or None,
        noise_loss_ppm=noise.loss_ppm or None,
        wires_can_bitrate=wires.can_bitrate or None,
        wires_slamware_baud=wires.slamware_baud if wires.is_on else None,
        wires_also=wires.also_text or None,
    )
