"""The core, compiled by mypyc from the source as it is: the same bytes, and how many times faster. `make compiled`.

A copy of bench/ in a folder of its own gets the modules of CORE compiled, which takes a C compiler and some minutes.
Then the demo is driven, recorded and checked on the shipped robots by both, in turns: every file of the recordings and
the last bit of the plant's state must be the same. Exit status 1 where one is not, 3 where nothing can be compiled.

It shows that the source keeps to what can be compiled. It is no way to install the bench: what a dashboard's scrubbing
pickles, and what somebody derives from, has to be interpreted.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from arguments import at_least_one, end_with, parser, some_of

from bench.config import robot_names
from bench.errors import SurroundingsError

ROOT = Path(__file__).parents[1]
CORE = (
    *("ground/" + name for name in ("contact", "linear", "loads", "modes", "sweeps", "walls")),
    *("base", "controller", "dm3519", "drive", "hull", "kinematics", "link", "loop", "m2006", "messages", "motors"),
    *("odometry", "plant", "unwrap", "wiring", "world"),
    *("canbus/" + name for name in ("__init__", "bits", "c610", "dm3519", "instruments", "table", "watch")),
)
"""What a tick of a simulated bench runs through, but for the wires of the RC and of the core."""


def drive(robot: str, directory: Path) -> dict[str, object]:
    """Drive the demo with the bench that is imported: processor seconds, simulated seconds, and what came of it."""
    from bench.check.sources import from_scenario
    from bench.cli.headless import execute
    from bench.demo import SCENARIO

    run = from_scenario(SCENARIO, robot=robot, profile="uart12")
    with run.recorder(directory / "run") as recorder:
        start = time.process_time()
        execute(run, recorder, quiet=True)
        took_s = time.process_time() - start
    plant = run.bench.world.plant
    state = plant.pose, plant.twist, plant.wheel_angles_rad, plant.wheel_speeds_radps, plant.contact_forces_n
    told = hashlib.sha256(repr(state).encode())
    for path in sorted((directory / "run").iterdir()):
        told.update(path.read_bytes())
    return {"cpu_s": took_s, "simulated_s": run.ticks / 1000.0, "sha256": told.hexdigest()}


def compiled_copy(folder: Path) -> None:
    """A copy of the bench with its core compiled. Raises SurroundingsError where that cannot be done."""
    shutil.copytree(ROOT / "bench", folder / "bench", ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    done = subprocess.run(
        [sys.executable, "-m", "mypyc", "--strict", *(f"bench/{name}.py" for name in CORE)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    if done.returncode or not list((folder / "bench").glob("plant.*.so")):
        last = "\n".join(done.stdout.splitlines()[-8:])
        raise SurroundingsError(
            f"mypyc could not compile the core; it needs `pip install 'mypy[mypyc]'` and cc:\n{last}"
        )


def driven(tree: Path, robot: str) -> dict[str, float | str]:
    """The same in a process of its own, with the bench of this tree."""
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as directory:
        code = f"import sys; sys.path[:0] = [{str(tree)!r}, {str(ROOT / 'scripts')!r}]\n"
        code += "import json, pathlib, compiled, bench.plant\n"
        code += f"told = compiled.drive({robot!r}, pathlib.Path({directory!r})) | {{'plant': bench.plant.__file__}}\n"
        code += "print(json.dumps(told))"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=directory)
        if done.returncode:
            raise SurroundingsError(f"{robot} could not be driven with the bench in {tree}:\n{done.stderr[-2000:]}")
        told: dict[str, float | str] = json.loads(done.stdout)
        if not Path(str(told["plant"])).is_relative_to(tree):
            raise SurroundingsError(f"{told['plant']} was driven, where {tree} should have been")
        return told


def main() -> int:
    """Compile, drive, compare."""
    asked = parser(__doc__)
    asked.add_argument("--rounds", type=at_least_one, default=3, metavar="N", help="medians of how many (default 3)")
    asked.add_argument(
        "--robots", type=some_of(robot_names()), default=robot_names(), metavar="A,B", help="default: all"
    )
    args = asked.parse_args()
    differ = 0
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder:
        started = time.monotonic()
        print("compiling ...", flush=True)
        compiled_copy(Path(folder))
        print(f"{len(CORE)} modules compiled in {time.monotonic() - started:.0f} s\n")
        print(f"{'robot':<12}{'bytes':<8}{'interpreted':>12}{'compiled':>10}   times real time, recorded; times faster")
        for robot in args.robots:
            rounds = [(driven(ROOT, robot), driven(Path(folder), robot)) for _ in range(args.rounds)]
            same = len({told["sha256"] for both in rounds for told in both}) == 1
            differ += not same
            speeds = [[float(told["simulated_s"]) / float(told["cpu_s"]) for told in both] for both in rounds]
            plain, fast = (median(column) for column in zip(*speeds, strict=True))
            faster = median(compiled / interpreted for interpreted, compiled in speeds)
            print(f"{robot:<12}{'same' if same else 'DIFFER':<8}{plain:>12.1f}{fast:>10.1f}   {faster:.2f}", flush=True)
    return 1 if differ else 0


if __name__ == "__main__":
    end_with(main)
