"""Whether a recording was made with what a scenario says now: a file may have been edited since, under its old name.

A recording holds every input that reached its base, so those are held against what the scenario's transmitter and core
say: on real wires, too, where the bench plays both. What a fault has done to a wire is not foretold; up to there they
are compared, and the faults themselves with those of the recording. What judges a run (expectations, checks) is no
input, and the base is what parity is about.
"""

from __future__ import annotations

from collections.abc import Iterator

from bench.arena import FIELD
from bench.check.reading import Recording
from bench.check.run import Run
from bench.check.scenario import Scenario, load_scenario
from bench.messages import ZERO_TWIST
from bench.slamware.commands import SET_V_AND_GET_DEADRECKON
from bench.slamware.framing import CONTROL_BUS, FrameDecoder, SlamwareFrame
from bench.slamware.payloads import twist_request
from bench.timed.settings import UNTIMED
from bench.timed.timing import Timing

LINE_TICKS = 100
"""A request is on a timed line for less, down to 2400 baud."""


def other_inputs(recording: Recording, scenario: Scenario, job: Run) -> str:
    """What is not the same, in a few words; empty where nothing is. `job` is the scenario's run, not yet begun."""
    return next(_differences(recording, scenario, job), "")


def _differences(recording: Recording, scenario: Scenario, job: Run) -> Iterator[str]:
    kept = load_scenario(recording.scenario_file, alone=True) if recording.scenario_file is not None else None
    if recording.arena != (job.bench.world.plant.arena or FIELD):
        yield "another arena"
    if (recording.noise.is_on or scenario.noise.is_on) and recording.noise != scenario.noise:
        yield "other noise"
    is_real = recording.info.role is not None  # real wires take their own time
    if not is_real and recording.wires != scenario.wires:
        yield "other wires"
    if (kept.faults if kept is not None else ()) != scenario.faults:
        yield "other faults"
    if scenario.faults and recording.info.seed != scenario.seed:
        yield "another seed"
    if kept is not None and kept.sticks != scenario.sticks:
        yield "other sticks"
    if kept is not None and kept.core != scenario.core:
        yield "another core"
    wires = UNTIMED if is_real else scenario.wires
    timing = Timing(wires, job.bench.robot.rc.protocol if job.bench.robot.rc else None) if wires.is_on else None
    yield from _other_rc(recording, job, timing, _until(scenario, "rc"))
    if recording.info.role != "core":
        yield from _other_requests(recording, job, LINE_TICKS if timing is not None else 0, _until(scenario, "core"))


def _until(scenario: Scenario, wire: str) -> int:
    """The first tick at which a fault may touch this wire."""
    return min((fault.at or 0 for fault in scenario.faults if fault.wire == wire), default=scenario.ticks)


def _other_rc(recording: Recording, job: Run, timing: Timing | None, until: int) -> Iterator[str]:
    heard = recording.rc
    for tick in range(until):
        sent = job.inputs(tick).rc
        if heard.get(tick, b"") != (timing.rc(sent) if timing is not None else sent):
            yield f"other RC bytes from {tick / 1000:.3f} s on"
            return


def _other_requests(recording: Recording, job: Run, line_ticks: int, until: int) -> Iterator[str]:
    """Of the core's velocities; when it asks depends on the answers of the base."""
    wanted = {-1: twist_request(ZERO_TWIST)}
    for tick in range(until):
        twist = job.inputs(tick).core_twist
        if twist is not None:
            wanted[tick] = twist_request(twist)
    decoder = FrameDecoder()
    for tick, data in recording.core_to_base.items():
        for event in decoder.feed(data, tick):
            if tick >= until or not isinstance(event, SlamwareFrame) or event.code != CONTROL_BUS:
                continue
            payload = bytes(event.payload)
            if payload[:1] == bytes((SET_V_AND_GET_DEADRECKON,)) and payload not in _asked(wanted, tick, line_ticks):
                yield f"other velocities from the core from {tick / 1000:.3f} s on"
                return


def _asked(wanted: dict[int, bytes], tick: int, line_ticks: int) -> list[bytes]:
    """What the core wanted at some time while a request that has come now was on its way."""
    begun = max(at for at in wanted if at <= max(-1, tick - line_ticks))
    return [payload for at, payload in wanted.items() if begun <= at <= tick]
