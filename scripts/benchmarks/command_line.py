"""`wheelbench --help` against `python -c pass`, and what the command line loads before it needs it."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from benchmarks.table import Row, Sample, verdict

FACTOR_AT_MOST, EXTRA_S = 3.0, 0.030
HEAVY = ("can", "cantools", "numpy", "pymunk", "serial", "textual")
RUNS = 5


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """Wall seconds of fresh processes, and how many heavy packages are loaded."""
    installed = shutil.which("wheelbench", path=str(Path(sys.executable).parent))
    wheelbench = [installed] if installed else [sys.executable, "-m", "bench"]
    commands = {"help": [*wheelbench, "--help"], "bare": [sys.executable, "-c", "pass"]}
    walls: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(max(1, round(RUNS * share))):
        for name in order.sample(sorted(commands), len(commands)):
            start = time.perf_counter()
            subprocess.run(commands[name], check=True, stdout=subprocess.DEVNULL)
            walls[name].append(time.perf_counter() - start)
    return {name: median(times) for name, times in walls.items()} | {"heavy": len(heavy_imports())}


def report(samples: Sequence[Sample]) -> list[Row]:
    """Whether `--help` stays near the interpreter's own start."""
    bare, shown = median(s["bare"] for s in samples), median(s["help"] for s in samples)
    allowed = FACTOR_AT_MOST * bare + EXTRA_S
    heavy = max(s["heavy"] for s in samples)
    return [
        Row(
            "`wheelbench --help`, wall, against `python -c pass`",
            f"{shown / bare:.1f} x ({shown * 1000:.0f} ms)",
            f"at most {FACTOR_AT_MOST:g} x + {EXTRA_S * 1000:g} ms",
            verdict(shown <= allowed),
        ),
        Row("  heavy packages that bench.__main__ imports", f"{heavy:.0f}", "none", verdict(heavy == 0)),
    ]


def heavy_imports() -> list[str]:
    """Which heavy packages a fresh interpreter has loaded once it knows the command line."""
    code = f"import sys, bench.__main__; print(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return done.stdout.split()
