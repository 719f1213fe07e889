"""What a session works on: a run, the link that runs it, and a keyboard or what judges it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from bench.arena import Arena
from bench.check.crosswire import CrossWire
from bench.check.reading import Recording
from bench.check.recording import Recorder
from bench.check.run import Run, bench_in, info_of
from bench.check.summary import Summary
from bench.config import Robot
from bench.io.clock import Pacer
from bench.io.link import InlineLink, Taker
from bench.io.process.link import ProcessLink
from bench.screen.keyboard import Keyboard
from bench.screen.lamp import GoldenLamp
from bench.screen.settings import SettingsFile
from bench.screen.wire_lamps import WireLamps
from bench.world import RecordedMotors, noise_of


@dataclass(frozen=True, slots=True)
class Stage:
    """One run on the screen. `keyboard` drives it; without one it is shown as it is."""

    link: InlineLink | ProcessLink
    job: Run
    keyboard: Keyboard | None = None
    lamp: GoldenLamp | None = None
    summary: Summary | None = None
    agree: WireLamps | None = None


class Show(NamedTuple):
    """A run that is to be shown: what keeps it, what it is held against where that is not its own recording."""

    run: Run
    recorder: Recorder | None = None
    golden: Recording | None = None
    settings: SettingsFile | None = None


def to_drive(job: Run, keyboard: Keyboard, pacer: Pacer) -> Stage:
    """A run that a person drives; its wires are checked as in any other."""
    bench = job.bench
    agree = WireLamps(CrossWire(bench.robot, bench.state_columns, noise=noise_of(bench.world.motors)))
    link = InlineLink(bench, keyboard.inputs, pacer, takers=[agree], remembers=True)
    link.witness = agree.touched
    return Stage(link, job, keyboard, agree=agree)


def to_drive_robot(robot: Robot, arena: Arena, pacer: Pacer) -> Stage:
    """A robot in an arena, for a person to drive. Raises UsageError where it cannot begin there."""
    keyboard = Keyboard(robot.rc)
    bench = bench_in(robot, arena)
    return to_drive(Run(robot.name, bench, 0, keyboard.inputs, info_of(robot)), keyboard, pacer)


def to_show(run: Run, golden: Recording | None, pacer: Pacer) -> Stage:
    """A run that is shown: held against a golden or the recording that it repeats, judged by its expectations."""
    golden = golden or run.source
    lamp = GoldenLamp(golden) if golden is not None else None
    summary = Summary(len(run.bench.robot.wheels))
    agree = WireLamps(run.checks) if run.checks is not None else None
    judges = (summary, lamp, agree, run.judge)
    takers: list[Taker] = [taker for taker in judges if taker is not None]
    motors = run.bench.world.motors
    shared = [motors.recorded] if isinstance(motors, RecordedMotors) else []
    link = InlineLink(run.bench, run.inputs, pacer, takers=takers, ticks=run.ticks, remembers=True, shared=shared)
    link.witness = agree.touched if agree is not None else None
    return Stage(link, run, None, lamp, summary, agree)
