"""A scripted replay through the Python API: sticks in, recording out, three questions asked of it.

    .venv/bin/python scripts/scripted_replay.py my_recording

1. Does the controller move the robot the way the sticks say?
2. Does it stop when it must?
3. Did the last change alter a single frame? (Run it again from the recording and compare.)
"""

import argparse
import sys
from pathlib import Path

from bench.check.compare import compare
from bench.check.reading import Recording
from bench.check.recording import Recorder, RunInfo
from bench.check.sources import from_recording
from bench.errors import BenchError
from bench.loop import simulated
from bench.messages import TickInput
from bench.rc.transmitter import AT_REST, Sticks, Transmitter


def main() -> None:
    """Drive, stop, and run it again."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("directory", type=Path, help="where to write the recording")
    directory = parser.parse_args().directory

    bench = simulated("m2006")  # our base, emulated ESCs, a plant and a SLAMWARE core, 1 ms a tick
    robot = bench.robot
    hands = Transmitter(robot.rc)  # sticks -> RC frames: the front door, whoever drives
    recorder = Recorder(directory, RunInfo("m2006", "uart12"), bench.state_columns, robot.file, robot.rc.file)

    def hold(sticks: Sticks, ms: int) -> None:
        for _ in range(ms):
            rc = hands.step(bench.now_tick, sticks)
            recorder.add(bench.tick(TickInput(rc)))

    with recorder:
        hold(AT_REST, 100)
        hold(Sticks(aux1=True), 100)  # a rising edge of AUX1 arms, sticks at rest
        hold(AT_REST, 100)
        hold(Sticks(forward=0.4), 1500)
        driven = bench.world.plant.pose
        hands.on = False  # the transmitter is switched off at full drive
        hold(Sticks(forward=0.4), 600)
        stopped = bench.world.plant.pose
        speed_mps = bench.world.plant.twist.vx_mps

    print(f"forward      the robot went {driven.x_m:+.3f} m ahead and {driven.y_m:+.4f} m to the side")
    further_m = stopped.x_m - driven.x_m
    print(f"link lost    it went {further_m:.3f} m further, now {speed_mps:.3f} m/s: {bench.base.link.reason}")
    assert driven.x_m > 0.2
    assert speed_mps == 0.0
    assert not bench.base.drive.armed

    again = directory.with_name(directory.name + "_again")
    run = from_recording(directory)
    with run.recorder(again) as recorder:
        for out in run:
            recorder.add(out)
    comparison = compare(Recording.open(again), Recording.open(directory))
    print("run again    " + comparison.lines[0])
    assert comparison.identical


if __name__ == "__main__":
    try:
        main()
    except BenchError as error:  # one sentence that says what, where and what to try
        print(f"scripted_replay.py: error: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
