"""A run: a bench, the inputs of every tick, and what it is called. Scenarios, captures and recordings all become one.

    run = from_source("bench/demo/demo.toml")
    for out in run: ...

The three sources differ in where the inputs come from and in nothing else:

    scenario    RC bytes of a capture by time, core requests of its timeline
    capture     RC bytes by their times, or paced by `period_ms` where there are none; the core asks for nothing
    recording   RC bytes and core bytes of the recording, tick by tick; `recorded_can` takes its feedback frames too
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from bench.arena import FIELD, Arena, arena_toml, load_arena
from bench.base import Base
from bench.check.controllers import Build, Controller, at_full_speed, controller_of, is_own, name_of
from bench.check.crosswire.observer import CrossWire
from bench.check.expectations import Judge
from bench.check.faults import KINDS
from bench.check.faulty import FaultyWorld, Injector
from bench.check.reading import Recording
from bench.check.recording import BLOCK_TICKS, RUN_TOML, Recorder, RunInfo, read_bytes
from bench.check.scenario import Scenario, load_scenario
from bench.config import (
    EXACT,
    SPEED_LOOP,
    ConfigError,
    Robot,
    load_profile,
    load_robot,
    profile_names,
    profile_path,
    robot_path,
    with_choices,
)
from bench.errors import UsageError
from bench.loop import NOTHING, Bench, replayed, simulated, simulated_motors
from bench.messages import TickInput, TickOutput
from bench.noise import SILENT, Noise
from bench.plant import Plant
from bench.rc.capture import Capture, by_tick, load_capture
from bench.rc.transmitter import sent_by_tick
from bench.world import RecordedMotors, SimulatedMotors

TAIL_TICKS = 1000
"""A capture is run on for a second after its last byte: what a robot does when the stream ends is worth seeing."""


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

    def recorder(self, directory: Path | str, *, overwrite: bool = False) -> Recorder:
        """A recorder for this run's ticks. Raises RecordingError where the place cannot be written."""
        robot = self.bench.robot
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
            overwrite=overwrite,
        )

    def __iter__(self) -> Iterator[TickOutput]:
        """Every tick of the run, in order."""
        run_tick, inputs = self._run_tick(), self.inputs
        with at_full_speed(self.bench.base):
            for tick in range(self.ticks):
                yield run_tick(inputs(tick))

    def blocks(self) -> Iterator[list[TickOutput]]:
        """The same, `BLOCK_TICKS` at a time: what follows a run costs a third of tick by tick then.

        Where a tick raises an error, the ones before it come first.
        """
        run_tick, inputs = self._run_tick(), self.inputs
        block: list[TickOutput] = []
        try:
            with at_full_speed(self.bench.base):
                for start in range(0, self.ticks, BLOCK_TICKS):
                    block = []
                    for tick in range(start, min(start + BLOCK_TICKS, self.ticks)):
                        block.append(run_tick(inputs(tick)))
                    yield block
        except Exception:
            yield block
            raise

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


def from_source(
    source: str | Path,
    *,
    robot: str | Path | None = None,
    protocol: str | None = None,
    profile: str | Path | None = None,
    period_ms: int | None = None,
    recorded_can: bool = False,
    controller: str | None = None,
    odometry: str | None = None,
    arena: str | Path | None = None,
) -> Run:
    """A run from whatever the path holds. Raises BenchError with what, where and what to try."""
    path = Path(source)
    if path.is_dir() and (path / RUN_TOML).exists():
        if robot is not None or protocol is not None or profile is not None or period_ms is not None:
            raise UsageError(f"{path}: a recording brings its own robot, profile and times; leave those options out")
        if odometry is not None or (controller is not None and not is_own(controller)):
            raise UsageError(
                f"{path}: a recording brings its own controller and odometry; leave those options out "
                "(only a base of your own may take the place of its base: --controller FILE.py:NAME)"
            )
        if arena is not None:
            raise UsageError(f"{path}: a recording brings its own arena; leave --arena out")
        return from_recording(path, recorded_can=recorded_can, controller=controller)
    if recorded_can:
        raise UsageError(f"{path}: only a recording has CAN feedback to replay")
    if path.suffix == ".toml":
        if protocol is not None or period_ms is not None:
            raise UsageError(f"{path}: a scenario file says itself what its stream is; leave those options out")
        return from_scenario(path, robot=robot, profile=profile, controller=controller, odometry=odometry, arena=arena)
    return from_capture(
        path,
        robot=robot,
        protocol=protocol,
        profile=profile,
        period_ms=period_ms,
        controller=controller,
        odometry=odometry,
        arena=arena,
    )


def from_scenario(
    path: Path,
    *,
    robot: str | Path | None = None,
    profile: str | Path | None = None,
    controller: str | None = None,
    odometry: str | None = None,
    arena: str | Path | None = None,
) -> Run:
    """The run that a scenario file describes: with its robot, forms and arena, or with others."""
    return run_of(
        load_scenario(path), robot=robot, profile=profile, controller=controller, odometry=odometry, arena=arena
    )


def run_of(
    scenario: Scenario,
    *,
    robot: str | Path | Robot | None = None,
    profile: str | Path | None = None,
    controller: str | Build | None = None,
    odometry: str | None = None,
    arena: str | Path | None = None,
) -> Run:
    """The run that a scenario describes. A robot made in Python and a maker of bases go in as they are."""
    path = scenario.path
    if isinstance(robot, Robot):
        built = robot if profile is None else replace(robot, rc=load_profile(profile))
    else:
        built = robot_of(scenario, robot, profile)
    try:
        built = with_choices(built, None, scenario.odometry)
        chosen = controller_of(built, None if controller else scenario.controller, path.parent)
    except UsageError as error:
        raise ConfigError(f"{path}: {error}") from error.__cause__
    if isinstance(controller, str):
        chosen = controller_of(built, controller)
    elif controller is not None:
        chosen = Controller(built, controller, name_of(controller))
    built = with_choices(chosen.robot, None, odometry)
    rc: dict[int, bytes] = {}
    if scenario.rc is not None:
        capture = load_capture(scenario.rc)
        _refuse_another_protocol(path, capture.protocol, built)
        rc = _rc_by_tick(capture, built, scenario.period_ms)
    elif scenario.sticks:
        rc = _rc_of_sticks(scenario, built)
    bench = bench_in(built, load_arena(arena) if arena is not None else scenario.arena, scenario.noise, chosen.build)
    return Run(
        title=scenario.name,
        bench=bench,
        ticks=scenario.ticks,
        inputs=_scenario_inputs(scenario, rc),
        info=info_of(built, chosen.name, scenario=scenario.name, seed=scenario.seed, noise=scenario.noise),
        judge=_judge(scenario, bench),
        injector=_injector(scenario, bench),
        checks=CrossWire(built, bench.state_columns, scenario.checks),
        about=scenario.about,
        scenario=scenario.text if scenario.says_more else None,
    )


def from_capture(
    path: Path,
    *,
    robot: str | Path | None = None,
    protocol: str | None = None,
    profile: str | Path | None = None,
    period_ms: int | None = None,
    controller: str | None = None,
    odometry: str | None = None,
    arena: str | Path | None = None,
) -> Run:
    """A capture driven through a robot (the default one unless given)."""
    capture = load_capture(path)
    protocol = protocol or capture.protocol
    chosen = controller_of(load_robot(robot or "m2006", profile), controller)
    built = with_choices(chosen.robot, None, odometry)
    if built.rc is None:
        raise UsageError(f"{built.file}: this robot takes no RC; give --profile to drive it with a capture")
    _refuse_another_protocol(path, protocol, built)
    rc = _rc_by_tick(capture, built, period_ms)
    if not rc:
        raise UsageError(f"{path}: holds no bytes to replay")
    bench = bench_in(built, load_arena(arena) if arena is not None else FIELD, build=chosen.build)
    return Run(
        title=path.stem,
        bench=bench,
        ticks=max(rc) + 1 + TAIL_TICKS,
        inputs=lambda tick: TickInput(rc[tick]) if tick in rc else NOTHING,
        info=info_of(built, chosen.name),
        checks=CrossWire(built, bench.state_columns),
    )


def from_recording(path: Path, *, recorded_can: bool = False, controller: str | None = None) -> Run:
    """A recording again: from its inputs, or with its CAN feedback in place of the plant's.

    A base of somebody's own is named in it and not held by it, and no data file makes us run code: it comes with
    `controller`, as one may that takes the place of the recording's base.
    """
    recording = Recording.open(path)
    name = recording.info.controller
    if controller is None and is_own(name):
        raise UsageError(f"{path}: was recorded with the controller {name}; give its place: --controller FOLDER/{name}")
    built = load_robot(recording.robot_file, recording.profile_file)
    built = with_choices(built, None, recording.info.odometry)
    chosen = controller_of(built, controller or name)
    built = chosen.robot
    rc, core = recording.rc, recording.core_to_base
    arena = recording.arena
    motors: SimulatedMotors | RecordedMotors = (
        RecordedMotors(built, recording.feedback, Plant(built, arena, arena.start))
        if recorded_can
        else simulated_motors(built, arena, recording.noise)
    )
    bench = replayed(built, motors)
    if chosen.build is not Base:
        bench = Bench(chosen.build(built), bench.world)
    scenario = load_scenario(recording.scenario_file, alone=True) if recording.scenario_file else None
    # What reached the base over RC and from the core is in the recording as it came, faults included.
    again = ("answer", "command") if recorded_can else ("answer", "command", "feedback", "esc", "plant")
    injector = _injector(scenario, bench, again) if scenario else None
    if injector is not None:
        injector.by_hand = recording.info.scenario is None
    return Run(
        title=recording.info.scenario or path.name,
        bench=bench,
        ticks=recording.ticks,
        inputs=lambda tick: TickInput(rc.get(tick, b""), None, core.get(tick, b"")),
        info=replace(recording.info, controller=chosen.name, wheelbench=RunInfo("").wheelbench),
        source=recording,
        judge=_judge(scenario, bench) if scenario else None,
        injector=injector,
        # Beside recorded feedback the plant is a shadow, and knows nothing of those wheels.
        checks=CrossWire(built, bench.state_columns, scenario.checks if scenario else None, truth=not recorded_can),
        scenario=read_bytes(recording.scenario_file) if recording.scenario_file else None,
    )


def _refuse_another_protocol(path: Path, protocol: str | None, robot: Robot) -> None:
    """A stream that the robot's transmitter does not speak would be noise from end to end."""
    profile = robot.rc
    if profile is None or protocol is None or profile.protocol == protocol:
        return
    fitting = [name for name in profile_names() if load_profile(name).protocol == protocol]
    known = f" ({', '.join(fitting)} would fit)" if fitting else ""
    raise UsageError(
        f"{path}: is {protocol}, but the profile {profile.name} speaks {profile.protocol}; give --profile{known}"
    )


def bench_in(robot: Robot, arena: Arena, noise: Noise = SILENT, build: Build = Base) -> Bench:
    """The simulated bench in an arena, with our base or another. Raises UsageError where a robot cannot begin."""
    why = arena.in_the_way(robot.body.radius_m, arena.start)
    if why:
        raise UsageError(f"arena {arena.name!r}: {why}; give it another [start]")
    bench = simulated(robot, arena, noise)
    return bench if build is Base else Bench(build(robot), bench.world)


def _judge(scenario: Scenario, bench: Bench) -> Judge | None:
    if not scenario.expectations:
        return None
    try:
        return Judge(scenario.expectations, bench.robot, bench.state_columns)
    except ValueError as error:
        raise UsageError(f"{scenario.path}: expect: {error}") from None


def _injector(scenario: Scenario, bench: Bench, wires: Sequence[str] = tuple(KINDS)) -> Injector | None:
    """Make the scenario's faults on these wires happen to a bench."""
    if not any(fault.wire in wires for fault in scenario.faults):
        return None
    try:
        injector = Injector(scenario.faults, bench.robot, bench.state_columns, scenario.seed, wires)
    except ValueError as error:
        raise UsageError(f"{scenario.path}: fault: {error}") from None
    bench.world = FaultyWorld(bench.world, injector)
    return injector


def _rc_of_sticks(scenario: Scenario, robot: Robot) -> dict[int, bytes]:
    """What the robot's transmitter sends while a driver holds the sticks as the scenario says."""
    if robot.rc is None:
        raise UsageError(f"{scenario.path}: stick: {robot.name} takes no RC; drive it with [[core]], or give a profile")
    return sent_by_tick(robot.rc, scenario.sticks, scenario.ticks)


def _scenario_inputs(scenario: Scenario, rc: dict[int, bytes]) -> Callable[[int], TickInput]:
    core = dict(scenario.core)
    given = {tick: TickInput(rc.get(tick, b""), core.get(tick)) for tick in rc.keys() | core.keys()}
    return lambda tick: given.get(tick, NOTHING)


def _rc_by_tick(capture: Capture, robot: Robot, period_ms: int | None) -> dict[int, bytes]:
    profile = robot.rc
    if profile is None:
        return {}
    return by_tick(capture, profile.protocol, period_ms or profile.period_ms)


def info_of(
    robot: Robot, controller: str | None = None, *, scenario: str | None = None, seed: int = 0, noise: Noise = SILENT
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
    )


def robot_of(scenario: Scenario, robot: str | Path | None = None, profile: str | Path | None = None) -> Robot:
    """The robot and transmitter that a scenario names, unless others are given. Raises ConfigError."""
    if profile is None and scenario.profile is not None:
        profile = _said(scenario.path, "profile", scenario.profile, profile_path)
    return load_robot(robot or _said(scenario.path, "robot", scenario.robot, robot_path), profile)


def _said(path: Path, key: str, name: str, find: Callable[[str | Path], Path]) -> Path:
    """The robot or profile that a scenario names: one of ours, or a file next to the scenario's."""
    beside = path.parent / name
    try:
        return find(beside if beside.suffix == ".toml" and beside.exists() else name)
    except ConfigError as error:
        raise ConfigError(f"{path}: {key}: {error}") from None
