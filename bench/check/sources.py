"""Where a run comes from: scenarios, captures and recordings all become one.

    run = from_source("bench/demo/demo.toml")
    for out in run: ...

The three sources differ in where the inputs come from and in nothing else:

    scenario    RC bytes of a capture by time, core requests of its timeline
    capture     RC bytes by their times, or paced by `period_ms` where there are none; the core asks for nothing
    recording   RC bytes and core bytes of the recording, tick by tick; `recorded_can` takes its feedback frames too
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from bench.arena import FIELD, load_arena
from bench.base import Base
from bench.check.controllers import Build, Controller, controller_of, is_own, name_of
from bench.check.crosswire.observer import CrossWire
from bench.check.expectations import Judge
from bench.check.faults import KINDS
from bench.check.faulty import FaultyWorld, Injector
from bench.check.reading import Recording
from bench.check.recording import RUN_TOML, RunInfo, read_bytes
from bench.check.run import Run, bench_in, info_of
from bench.check.scenario import Scenario, load_scenario
from bench.config import (
    ConfigError,
    Robot,
    check_robot,
    load_profile,
    load_robot,
    profile_names,
    profile_path,
    robot_path,
    with_choices,
)
from bench.errors import UsageError
from bench.loop import NOTHING, Bench, replayed, simulated_motors
from bench.messages import TickInput
from bench.plant import Plant
from bench.rc.capture import Capture, by_tick, load_capture
from bench.rc.transmitter import sent_by_tick
from bench.timed.timing import Timing
from bench.world import RecordedMotors, SimulatedMotors

TAIL_TICKS = 1000
"""A capture is run on for a second after its last byte: what a robot does when the stream ends is worth seeing."""


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
    """The run that a scenario describes. A robot made in Python is held to what a file is, and a maker of bases goes in
    as it is.
    """
    if isinstance(robot, Robot):
        check_robot(f"robot {robot.name!r}", robot)
        built = robot if profile is None else replace(robot, rc=load_profile(profile))
    else:
        built = robot_of(scenario, robot, profile)
    chosen = _chosen(scenario, built, controller)
    built = with_choices(chosen.robot, None, odometry)
    rc = _rc_of(scenario, built)
    place = load_arena(arena) if arena is not None else scenario.arena
    bench = bench_in(built, place, scenario.noise, chosen.build, scenario.wires)
    return Run(
        title=scenario.name,
        bench=bench,
        ticks=scenario.ticks,
        inputs=_scenario_inputs(scenario, rc),
        info=info_of(
            built, chosen.name, scenario=scenario.name, seed=scenario.seed, noise=scenario.noise, wires=scenario.wires
        ),
        judge=_judge(scenario, bench),
        injector=_injector(scenario, bench),
        checks=CrossWire(built, bench.state_columns, scenario.checks, noise=scenario.noise),
        about=scenario.about,
        scenario=scenario.text if scenario.says_more else None,
    )


def _chosen(scenario: Scenario, robot: Robot, controller: str | Build | None) -> Controller:
    """Who stands behind the seam: the scenario's, or another that is given in its place."""
    try:
        robot = with_choices(robot, None, scenario.odometry)
        chosen = controller_of(robot, None if controller else scenario.controller, scenario.path.parent)
    except UsageError as error:
        raise ConfigError(f"{scenario.path}: {error}") from error.__cause__
    if isinstance(controller, str):
        return controller_of(robot, controller)
    return chosen if controller is None else Controller(robot, controller, name_of(controller))


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
    chosen = controller_of(load_robot("m2006" if robot is None else robot, profile), controller)
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
    if recording.wires.is_on and not recorded_can:  # recorded feedback has come over its wires already
        # So have RC bytes and requests, which `replayed` takes past the lines.
        bench.world.timing = Timing(recording.wires, None)
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
        checks=CrossWire(
            built,
            bench.state_columns,
            scenario.checks if scenario else None,
            truth=not recorded_can,
            noise=recording.noise,
        ),
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


def _rc_of(scenario: Scenario, robot: Robot) -> dict[int, bytes]:
    """The capture's bytes, or what the robot's transmitter sends while a driver holds the sticks."""
    if scenario.rc is not None:
        capture = load_capture(scenario.rc)
        _refuse_another_protocol(scenario.path, capture.protocol, robot)
        return _rc_by_tick(capture, robot, scenario.period_ms)
    if not scenario.sticks:
        return {}
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


def robot_of(scenario: Scenario, robot: str | Path | None = None, profile: str | Path | None = None) -> Robot:
    """The robot and transmitter that a scenario names, unless others are given. Raises ConfigError."""
    if profile is None and scenario.profile is not None:
        profile = _said(scenario.path, "profile", scenario.profile, profile_path)
    if robot is None:
        robot = _said(scenario.path, "robot", scenario.robot, robot_path)
    return load_robot(robot, profile)


def _said(path: Path, key: str, name: str, find: Callable[[str | Path], Path]) -> Path:
    """The robot or profile that a scenario names: one of ours, or a file next to the scenario's."""
    beside = path.parent / name
    try:
        return find(beside if beside.suffix == ".toml" and beside.exists() else name)
    except ConfigError as error:
        raise ConfigError(f"{path}: {key}: {error}") from None
