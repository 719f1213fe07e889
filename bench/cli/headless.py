"""A run without a dashboard: every tick, recorded if asked for, a progress bar where stderr is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.summary import Summary
from bench.io.clock import now_ns
from bench.messages import TickOutput

BAR_WIDTH = 32
BAR_EVERY_TICKS = 500


def execute(run: Run, recorder: Recorder | None = None, *, quiet: bool = False) -> tuple[Summary, float]:
    """Run to the end; returns what happened and how many times faster than real time it was.

    Whatever interrupts the run, the recorder is closed first: nothing already recorded is lost.
    """
    summary = Summary()
    started_ns = now_ns()
    try:
        for out in _with_bar(run, quiet):
            if recorder is not None:
                recorder.add(out)
            summary.add(out)
    finally:
        if recorder is not None:
            recorder.close()
    took_ns = max(1, now_ns() - started_ns)
    return summary, summary.ticks * 1e6 / took_ns


def _with_bar(run: Run, quiet: bool) -> Iterable[TickOutput]:
    if quiet or not sys.stderr.isatty():
        return run
    return _bar(run)


def _bar(run: Run) -> Iterable[TickOutput]:
    try:
        for out in run:
            if out.tick % BAR_EVERY_TICKS == 0:
                done = out.tick * BAR_WIDTH // run.ticks
                seconds = f"{out.tick / 1000:.1f}/{run.ticks / 1000:.1f} s"
                print(f"\r{run.title} [{'#' * done}{'.' * (BAR_WIDTH - done)}] {seconds} ", end="", file=sys.stderr)
            yield out
    finally:
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)
