"""One scenario in several worlds: the first drives, the others hear what it heard and are held against it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from bench.check.conduct import conduct
from bench.check.controllers import controller_of
from bench.check.inputs import other_inputs
from bench.check.parity import Parity, parity
from bench.check.reading import Recording
from bench.check.recording import RUN_TOML, read_bytes
from bench.check.run import Run
from bench.check.scenario import load_scenario
from bench.check.sources import from_recording, from_scenario
from bench.config import SPEED_LOOP
from bench.errors import UsageError
from bench.messages import TickOutput
from bench.motors import family

SIM = "sim"
"""Our own base, in simulation."""


class Beside(NamedTuple):
    """One world beside the reference."""

    world: str
    ticks: int
    parity: Parity


def worlds_of(
    scenario: Path,
    worlds: Sequence[str],
    *,
    robot: str | None = None,
    record: Path | None = None,
    overwrite: bool = False,
) -> Iterator[Beside]:
    """Run the scenario in the first world, then hold each of the others against it.

    A world is `SIM`, a controller as `controllers` names them, or the directory of a recording. Of a recording the
    reference hears what was recorded: its own feedback would be another world's. Raises UsageError (for a recording of
    another run, too), ConfigError, RecordingError, and ControllerFailed where somebody's own base fails.
    """
    reference, *others = worlds
    if is_recording(reference):
        raise UsageError(
            f"--worlds: the first one drives, and {reference} is a recording; put sim or a controller there"
        )
    if record is not None and any(
        is_recording(world) and Path(world).resolve() == record.resolve() for world in others
    ):
        raise UsageError(f"--record {record}: is one of the worlds; record in another directory")
    job = from_scenario(scenario, robot=robot, controller=_controller(reference))
    for world in others:  # what is no world is told before the first one has run
        if is_recording(world):
            _refuse_another_run(scenario, job, Recording.open(world))
        else:
            controller_of(job.bench.robot, _controller(world))
    if all(map(is_recording, others)) and record is None:
        for world in others:
            yield _beside_recording(reference, Path(world))
        return
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as scratch:
        directory = record or Path(scratch) / "reference"
        conduct(job, job.recorder(directory, overwrite=overwrite))
        ours = _heard_again(directory, reference)
        for world in others:
            if is_recording(world):
                yield _beside_recording(reference, Path(world))
            else:
                theirs = _heard_again(directory, world)
                yield Beside(world, len(ours), parity(ours, theirs, family(job.bench.robot)))


def is_recording(world: str) -> bool:
    """Whether a world's name is the directory of a recording."""
    return (Path(world) / RUN_TOML).is_file()


def _refuse_another_run(scenario: Path, job: Run, recording: Recording) -> None:
    """What another robot said, or the same one elsewhere, is no answer to this scenario. Raises UsageError."""
    robot, where = job.bench.robot, recording.directory
    advice = f"record {scenario} itself: wheelbench replay {scenario} --record DIR, with --role base perhaps"
    if recording.info.scenario != job.title:
        other = f"of the scenario {recording.info.scenario!r}" if recording.info.scenario else "of no scenario"
        raise UsageError(f"{where}: is a recording {other}, not of {job.title!r}; {advice}")
    files = (recording.robot_file, robot.file), (recording.profile_file, robot.rc.file if robot.rc else None)
    for key, (theirs, ours) in zip(("robot", "profile"), files, strict=True):
        if (theirs and read_bytes(theirs)) != (ours and read_bytes(ours)):
            name, give = getattr(recording.info, key), "give --robot, or " if key == "robot" else ""
            raise UsageError(f"{where}: was made with another {key} ({name}) than {ours}; {give}{advice}")
    if recording.ticks != job.ticks:
        lasts = f"holds {recording.ticks / 1000:g} s and the scenario lasts {job.ticks / 1000:g} s"
        raise UsageError(f"{where}: {lasts}; {advice}")
    other = other_inputs(recording, load_scenario(scenario), job)
    if other:
        raise UsageError(f"{where}: was made with {other} than {scenario} says now; {advice}")


def _beside_recording(reference: str, directory: Path) -> Beside:
    ours = _heard_again(directory, reference)
    recording = Recording.open(directory)
    commands, answers = recording.commands, recording.base_to_core
    theirs = [
        out._replace(can_commands=commands.get(out.tick, ()), base_to_core=answers.get(out.tick, b"")) for out in ours
    ]
    return Beside(str(directory), len(ours), parity(ours, theirs, recording.family))


def _heard_again(directory: Path, world: str) -> list[TickOutput]:
    """What this world says when it hears what a recording holds, feedback included."""
    job: Run = from_recording(directory, recorded_can=True, controller=_controller(world))
    return [out for block in job.blocks() for out in block]


def _controller(world: str) -> str:
    return SPEED_LOOP if world == SIM else world
