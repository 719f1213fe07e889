"""The checks on a run that is over, from its recording."""

from __future__ import annotations

from bench.check.crosswire.finding import Outcome
from bench.check.crosswire.observer import CrossWire
from bench.check.reading import Recording, as_outputs
from bench.check.scenario import load_scenario
from bench.config import load_robot


def outcomes_of(recording: Recording) -> list[Outcome]:
    """What the wires of a recording say of each other, judged as its scenario has it.

    can.log does not say who sent a frame; that a base sends what a motor does is found by the rate alone here. Raises
    RecordingError or ConfigError where the recording cannot be read.
    """
    robot = load_robot(recording.robot_file, recording.profile_file)
    scenario = load_scenario(recording.scenario_file, alone=True) if recording.scenario_file else None
    # Beside real motors the plant is a shadow, and knows nothing of those wheels.
    truth = recording.info.role != "motors"
    checks = scenario.checks if scenario else None
    found = CrossWire(robot, recording.state_columns, checks, truth=truth, noise=recording.noise)
    for tick, fault, wire in recording.touches:
        found.touched(tick, fault, wire)
    for out in as_outputs(recording):
        found.add(out)
    return found.outcomes()
