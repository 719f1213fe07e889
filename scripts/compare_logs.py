"""Two large recordings compared, in a process of its own: by wheelbench, or by python-can's reader and a plain loop.

    scripts/compare_logs.py wheelbench RUN GOLDEN
    scripts/compare_logs.py python-can RUN GOLDEN
    scripts/compare_logs.py make FOLDER FRAMES       write FOLDER/golden, FOLDER/few and FOLDER/late

Prints one JSON object: frames that differ, what was said first, CPU seconds and peak memory of the whole process with
its start and imports. `few` differs from the golden in 40 fields, `late` in nearly every line: all feedback comes 3 ms
late from a tenth of the log on. `scripts/benchmark.py --only compare` runs them side by side.
"""

from __future__ import annotations

import json
import random
import resource
import struct
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from arguments import at_least_one, end_with, existing, parser

FIELDS = 40
LATE_TICKS = 3
FEEDBACK = struct.Struct(">HhhBx")
COMMAND = struct.Struct(">4h")


def wheelbench(run_dir: str, golden_dir: str) -> tuple[int, str]:
    """What `wheelbench check` does."""
    from bench.check.golden import told
    from bench.check.reading import Recording

    found = told(Recording.open(run_dir), golden_dir)
    return sum(wire["differing"] for wire in found.as_dict()["wires"]), found.lines[0]


def python_can(run_dir: str, golden_dir: str) -> tuple[int, str]:
    """Both logs through python-can's reader, message beside message, field by field."""
    import can

    sides = [list(can.LogReader(Path(directory) / "can.log")) for directory in (run_dir, golden_dir)]
    differing, first = 0, ""
    for run, golden in zip(*sides, strict=False):
        layout = COMMAND if golden.arbitration_id == 0x200 else FEEDBACK
        same = run.arbitration_id == golden.arbitration_id and abs(run.timestamp - golden.timestamp) < 5e-7
        if same and len(run.data) == len(golden.data) == 8:
            for got, expected in zip(layout.unpack(run.data), layout.unpack(golden.data), strict=True):
                same = same and abs(got - expected) <= 0
        else:
            same = same and run.data == golden.data
        if not same:
            differing += 1
            first = first or f"{golden} against {run}"
    return differing, first


def make(folder: str, frames: int) -> None:
    """The demo's golden over and over, on the CAN bus alone."""
    from bench.check.reading import Recording, as_outputs
    from bench.check.recording import Recorder
    from bench.demo import golden_directory
    from bench.messages import TickOutput

    demo = Recording.open(golden_directory())
    outputs = list(as_outputs(demo))
    ticks = frames // 4

    def on_and_on() -> Iterator[TickOutput]:
        for tick in range(ticks):
            out = outputs[tick % len(outputs)]
            yield TickOutput(tick, b"", b"", b"", out.can_commands, out.can_feedback, None)

    def few() -> Iterator[TickOutput]:
        changed = set(random.Random(1).sample(range(ticks), min(FIELDS, ticks)))
        for out in on_and_on():
            if out.tick in changed:
                can_id, data = out.can_feedback[out.tick % 3]
                moved = (can_id, data[:5] + bytes((data[5] ^ 1,)) + data[6:])
                frames_now = [moved if one[0] == can_id else one for one in out.can_feedback]
                out = out._replace(can_feedback=tuple(frames_now))
            yield out

    def late() -> Iterator[TickOutput]:
        before = on_and_on()
        start = ticks // 10
        yield from islice(before, start)
        waiting = [()] * LATE_TICKS
        for out in before:
            waiting.append(out.can_feedback)
            yield out._replace(can_feedback=waiting.pop(0))

    for name, source in (("golden", on_and_on()), ("few", few()), ("late", late())):
        directory = Path(folder) / name
        with Recorder(directory, demo.info, demo.state_columns, demo.robot_file, demo.profile_file) as recorder:
            while block := list(islice(source, 1000)):
                recorder.extend(block)


JOBS = {"wheelbench": wheelbench, "python-can": python_can}


def main() -> int:
    """One job, one JSON object."""
    asked = parser(__doc__)
    jobs = asked.add_subparsers(dest="job", required=True, metavar="JOB")
    for name, job in JOBS.items():
        words = jobs.add_parser(name, help=(job.__doc__ or "").splitlines()[0])
        words.add_argument("run", type=existing, metavar="RUN", help="a recording")
        words.add_argument("golden", type=existing, metavar="GOLDEN", help="another")
    words = jobs.add_parser("make", help=(make.__doc__ or "").splitlines()[0])
    words.add_argument("folder", metavar="FOLDER", help="where to write them")
    words.add_argument("frames", type=at_least_one, metavar="FRAMES", help="how many CAN frames each has")
    args = asked.parse_args()
    if args.job == "make":
        make(args.folder, args.frames)
        return 0
    differing, said = JOBS[args.job](str(args.run), str(args.golden))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    facts = {"differing": differing, "said": said, "cpu_s": time.process_time(), "peak_mb": peak_mb}
    print(json.dumps(facts))
    return 0


if __name__ == "__main__":
    end_with(main)
