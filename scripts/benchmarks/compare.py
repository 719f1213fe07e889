"""Two logs of a million frames compared, causes and all, against python-can's reader and a plain loop."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from statistics import median

from benchmarks.table import Row, Sample, row_at_least, verdict

FACTOR_AT_LEAST, PEAK_MB_AT_MOST = 10.0, 500.0
FRAMES = 1_000_000
_SCRIPT = Path(__file__).parents[1] / "compare_logs.py"


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds of whole processes that compare two logs, one that differs in 40 fields and one that comes late."""
    frames = max(1000, round(FRAMES * share))
    jobs = {"few": "wheelbench", "late": "wheelbench", "python-can": "python-can"}
    folder = _large_logs(frames)
    sample: Sample = {}
    for name in order.sample(sorted(jobs), len(jobs)):
        run = "few" if name == "python-can" else name
        facts = json.loads(_compare_logs(jobs[name], f"{folder.name}/{run}", f"{folder.name}/golden"))
        sample |= {name: facts["cpu_s"], f"{name} MB": facts["peak_mb"]}
    return sample


def report(samples: Sequence[Sample]) -> list[Row]:
    """How many times as fast as python-can's reader, and in how much memory."""
    named = {"few": "40 fields differ", "late": "feedback 3 ms late"}
    rows = []
    for name, what in named.items():
        ratios = [s["python-can"] / s[name] for s in samples]
        figure = f"comparing two logs, {what}: times as fast as python-can's reader"
        rows.append(row_at_least(figure, ratios, FACTOR_AT_LEAST))
    peak_mb = max(s[f"{name} MB"] for s in samples for name in named)
    fits = verdict(peak_mb <= PEAK_MB_AT_MOST)
    rows.append(Row("  peak memory", f"{peak_mb:.0f} MB", f"at most {PEAK_MB_AT_MOST:g} MB", fits))
    times = ", ".join(f"{median(s[name] for s in samples):.2f}" for name in (*named, "python-can"))
    rows.append(Row("  CPU s: few, late, python-can (whole processes)", times))
    return rows


@cache
def _large_logs(frames: int) -> tempfile.TemporaryDirectory[str]:
    """The recordings for all rounds; they go when this process ends."""
    folder = tempfile.TemporaryDirectory(prefix="wheelbench-logs-")
    _compare_logs("make", folder.name, str(frames))
    return folder


def _compare_logs(*arguments: str) -> str:
    return subprocess.run([sys.executable, _SCRIPT, *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout
