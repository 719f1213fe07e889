"""The dashboard: its share of a core, its drawing beside stock widgets, its start beside an empty app.

Each app runs in a terminal of its own, the robot driven about all the time; the two of a pair run at the same time. A
share of a core is the CPU of a frame, 20 times a second: bench, sampling, drawing, Textual. What is compared with the
stock widgets is all of that but the bench's ticks, which are the same in both. The empty call is timed by the app in
every frame, where the clock is as the frame finds it.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

from benchmarks.empty_call import told_for_reference
from benchmarks.table import Row, Sample, verdict
from benchmarks.terminal import InTerminal

FRAMES, FRAMES_PER_S = 120, 20
STARTS = 3
CPU_SHARE_AT_MOST, STOCK_RATIO_AT_MOST, FIRST_FRAME_AT_MOST = 0.15, 0.30, 1.3
FRAME_BUDGET_S = 0.025
"""Half a frame: so long a tick may wait for a picture to be drawn."""
_CHILD = Path(__file__).with_name("dashboard_child.py")


class View(NamedTuple):
    """A page at a size."""

    page: str
    columns: int
    rows: int
    has_stock: bool = True
    """Whether stock widgets can show the same: a sparkline is no scope."""
    whole: bool = False
    """With all that `wheelbench drive` does besides: the wires' checks, the run's memory; and a minute's trail."""

    @property
    def name(self) -> str:
        """For people, and for the samples."""
        return f"{self.page} {self.columns}x{self.rows}{', checks and a minute of trail' * self.whole}"


VIEWS = (
    View("drive", 120, 40),
    View("wires", 120, 40),
    View("scope", 120, 40, False),
    View("drive", 120, 40, False, whole=True),
    View("drive", 200, 60),
)
"""The last has every pane there is: arena, status, scope, wheels, all wires."""


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """CPU of frames and of starts, in seconds."""
    sample: Sample = {}
    frames = max(5, round(FRAMES * share))
    for view in order.sample(VIEWS, len(VIEWS)):
        kinds = ["ours", "stock"] if view.has_stock else ["ours"]
        children = {"ours": "driven" if view.whole else "ours", "stock": "stock"}
        both = {kind: _Child(children[kind], view, frames) for kind in order.sample(kinds, len(kinds))}
        for kind, child in both.items():
            sample |= {f"{view.name} {kind} {name}": value for name, value in child.facts().items()}
    starts: dict[str, list[Sample]] = {"first": [], "empty": []}
    for _ in range(max(1, round(STARTS * share))):
        for name in order.sample(list(starts), len(starts)):  # in turn: a machine's speed changes within seconds
            starts[name].append(_Child(name, VIEWS[0], 0).facts())
    for name, facts in starts.items():
        sample |= {f"{name} {key}": median(one[key] for one in facts) for key in facts[0]}
    return sample


def report(samples: Sequence[Sample]) -> list[Row]:
    """Each view against its bars."""
    rows = [row for view in VIEWS for row in _rows(view, samples)]
    cpu, wall = (median(s[f"first {key}"] / s[f"empty {key}"] for s in samples) for key in ("cpu_s", "wall_s"))
    seconds = median(s["first cpu_s"] for s in samples)
    rows.append(
        Row(
            "`wheelbench drive`, CPU to the first frame, times an empty Textual app",
            f"{cpu:.2f} ({1000 * seconds:.0f} ms; wall {wall:.2f})",
            f"at most {FIRST_FRAME_AT_MOST:g}",
            verdict(cpu <= FIRST_FRAME_AT_MOST),
        )
    )
    live_cpu, live_wall = (
        median(s[f"first live_{key}"] / s[f"empty {key}"] for s in samples) for key in ("cpu_s", "wall_s")
    )
    live_s = median(s["first live_cpu_s"] for s in samples)
    words = f"{live_cpu:.2f} ({1000 * live_s:.0f} ms; wall {live_wall:.2f})"
    rows.append(Row("  and to the first values of the bench in it", words))
    return rows


def _rows(view: View, samples: Sequence[Sample]) -> list[Row]:
    def all_of(key: str) -> list[float]:
        return [sample[f"{view.name} {key}"] for sample in samples]

    shares = [FRAMES_PER_S * frame_s for frame_s in all_of("ours frame_s")]
    ours, longest = median(shares), median(all_of("ours frame_p99_s"))
    drawing = FRAMES_PER_S * median(all_of("ours drawing_s"))
    at_most = f"at most {100 * CPU_SHARE_AT_MOST:g} %" if view.columns <= 120 and not view.whole else ""
    rows = [
        Row(
            f"dashboard, {view.name}: share of a core at {FRAMES_PER_S} frames/s",
            f"{100 * ours:.1f} % (drawing {100 * drawing:.1f} %)",
            at_most,
            verdict(ours <= CPU_SHARE_AT_MOST) if at_most else "",
            told_for_reference([100 * one for one in shares], all_of("ours call_ns"), "{:.1f} %", is_cost=True),
        ),
        Row(
            "  CPU of a frame, ticks and all, 99 of 100",
            f"{1000 * longest:.1f} ms",
            f"at most {1000 * FRAME_BUDGET_S:g} ms",
            verdict(longest <= FRAME_BUDGET_S),
        ),
    ]
    if view.has_stock:
        pairs = zip(all_of("ours drawing_s"), all_of("stock drawing_s"), strict=True)
        ratio = median(one / other for one, other in pairs)
        rows.append(
            Row(
                "  drawing, times the same content in stock widgets",
                f"{ratio:.2f}",
                f"at most {STOCK_RATIO_AT_MOST:g}",
                verdict(ratio <= STOCK_RATIO_AT_MOST),
            )
        )
    return rows


class _Child:
    """A measured app that runs."""

    def __init__(self, kind: str, view: View, frames: int) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="wheelbench-")
        self._result = Path(self._folder.name) / "facts.json"
        what = [kind, view.page, str(view.columns), str(view.rows), str(frames), str(self._result)]
        command = [sys.executable, str(_CHILD), *what, str(time.monotonic())]
        self._app = InTerminal(command, view.columns, view.rows, self._folder.name)

    def facts(self) -> Sample:
        """What it measured, at its end."""
        try:
            self._app.wait(120.0)
            if not self._result.exists():
                raise RuntimeError(f"{_CHILD.name} measured nothing: {bytes(self._app.said[-2000:])!r}")
            facts: Sample = json.loads(self._result.read_text())
            return facts
        finally:
            self._folder.cleanup()
