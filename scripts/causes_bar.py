"""Does the comparison name the right cause? Twelve kinds of fault, put into recordings of four robots, 20 seeds each.

`logs/faults.py` puts them in, `logs/frames.py` writes them out: nothing there knows how `bench.check.causes` works.

    python scripts/causes_bar.py              960 recordings: the table of what was named for what; exit 1 below the bar
    python scripts/causes_bar.py --seeds 2 --robot m2006
"""

from __future__ import annotations

import math
import random
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from arguments import at_least_one, end_with, parser
from logs.faults import FAULTS
from logs.frames import Log
from make_demo import sticks_at

from bench.check.causes import causes
from bench.check.reading import Recording
from bench.check.recording import Recorder, RunInfo
from bench.config import load_robot
from bench.loop import simulated
from bench.messages import BodyTwist, TickInput
from bench.rc.transmitter import Transmitter

ROBOTS = ("m2006", "dm3519", "omni4", "mecanum")
SECONDS = 8.0
SEEDS = 20
RIGHT_OF_ALL, RIGHT_OF_EACH = 0.90, 0.70


def drive(robot: str, directory: Path, seconds: float = SECONDS) -> Recording:
    """The demo's sticks on any robot, while a SLAMWARE core asks for a wandering twist."""
    bench = simulated(load_robot(robot))
    assert bench.robot.rc is not None
    assert bench.robot.file is not None
    transmitter = Transmitter(bench.robot.rc)
    info = RunInfo(robot=robot, profile=bench.robot.rc.name)
    with Recorder(directory, info, bench.state_columns, bench.robot.file, bench.robot.rc.file) as recorder:
        for tick in range(round(seconds * 1000)):
            t_s = tick / 1000
            # Never quite still, as hands are not.
            sticks = sticks_at(t_s)
            shaken = sticks._replace(
                forward=sticks.forward + 0.03 * math.sin(7.1 * t_s),
                left=sticks.left + 0.03 * math.sin(5.3 * t_s),
                turn=sticks.turn + 0.03 * math.sin(6.1 * t_s),
            )
            wanted = BodyTwist(0.3 * math.sin(1.9 * t_s), 0.2 * math.sin(2.7 * t_s), 0.5 * math.sin(1.3 * t_s))
            core = wanted if tick % 50 == 0 else None
            recorder.add(bench.tick(TickInput(transmitter.step(tick, shaken), core)))
    return Recording.open(directory)


class Trial(NamedTuple):
    """What was put in, what was named first, and the sentence."""

    fault: str
    robot: str
    seed: int
    named: str
    text: str


def trials(robots: Sequence[str], seeds: Sequence[int], faults: Sequence[str], folder: Path) -> Iterator[Trial]:
    """Every fault on every robot with every seed."""
    for robot in robots:
        golden = drive(robot, folder / robot)
        log = Log.of(golden.directory, robot)
        for fault in faults:
            for seed in seeds:
                changed = log.copy()
                FAULTS[fault](changed, random.Random(f"{fault} {robot} {seed}"))
                changed.write(folder / "run")
                found = causes(Recording.open(folder / "run"), golden)
                first = found[0] if found else None
                yield Trial(fault, robot, seed, first.kind if first else "nothing", first.text if first else "")


def table(done: Sequence[Trial]) -> str:
    """Rows: what was put in. Columns: what was named first."""
    faults = list(dict.fromkeys(trial.fault for trial in done))
    named = [*FAULTS, *sorted({trial.named for trial in done} - FAULTS.keys())]
    lines = [" " * 11 + "".join(f"{name[:7]:>8}" for name in named) + "   right"]
    for fault in faults:
        counts = Counter(trial.named for trial in done if trial.fault == fault)
        cells = "".join(f"{counts[name] or '.':>8}" for name in named)
        lines.append(f"{fault:11}{cells}   {counts[fault] / counts.total():6.1%}")
    return "\n".join(lines)


def shares(done: Sequence[Trial]) -> tuple[float, float]:
    """The share of all that was named right, and of the class that fared worst."""
    each = []
    for fault in {trial.fault for trial in done}:
        right = [trial.named == fault for trial in done if trial.fault == fault]
        each.append(sum(right) / len(right))
    return sum(trial.named == trial.fault for trial in done) / len(done), min(each)


def main(arguments: Sequence[str] | None = None) -> int:
    """Inject, ask, print the table, judge."""
    asked = parser(__doc__)
    asked.add_argument(
        "--seeds", type=at_least_one, default=SEEDS, metavar="N", help=f"seeds for each (default {SEEDS})"
    )
    asked.add_argument("--first-seed", type=int, default=0, metavar="N", help="the first of them (default 0)")
    asked.add_argument("--robot", action="append", metavar="R", help="a robot; may be repeated (default: four)")
    asked.add_argument("--fault", action="append", choices=list(FAULTS), metavar="F", help="a fault; may be repeated")
    asked.add_argument("--wrong", action="store_true", help="print the sentence of each that was named wrong")
    args = asked.parse_args(arguments)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder:
        done = list(trials(args.robot or ROBOTS, seeds, args.fault or list(FAULTS), Path(folder)))
    if args.wrong:
        for trial in done:
            if trial.named != trial.fault:
                print(f"{trial.fault} on {trial.robot}, seed {trial.seed}: {trial.named}: {trial.text}")
    print(table(done))
    of_all, of_worst = shares(done)
    ok = of_all >= RIGHT_OF_ALL and of_worst >= RIGHT_OF_EACH
    print(
        f"{of_all:.1%} of {len(done)} named right (bar {RIGHT_OF_ALL:.0%}), the worst class {of_worst:.1%}"
        f" (bar {RIGHT_OF_EACH:.0%}): {'ok' if ok else 'MISSED'}; {time.perf_counter() - started:.0f} s"
    )
    return 0 if ok else 1


if __name__ == "__main__":
    end_with(main)
