"""`wheelbench doctor timing`: how late the loop's ticks begin, beside a bare loop in C, in figures and a histogram."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext

from bench.cli.output import say
from bench.config import load_robot
from bench.errors import EXIT_OK, UsageError
from bench.io import timing
from bench.io.clock import wait_ns
from bench.io.lateness import Lateness

ROUND_S = 2.0
HISTOGRAM_WIDTH = 40
BEGIN_NS = 2_000_000_000
"""Until a dashboard has begun to draw."""


def run_timing(args: argparse.Namespace) -> int:
    """Measure both loops under the conditions that were asked for, and tell."""
    if not 0.1 <= args.seconds <= 3600.0:
        raise UsageError(f"--seconds {args.seconds:g}: expected 0.1 to 3600")
    rounds = max(1, round(args.seconds / ROUND_S))
    cores = os.cpu_count() or 1
    with ExitStack() as stack:
        stack.enter_context(nullcontext() if args.no_dashboard else _dashboard_beside())
        stack.enter_context(timing.busy(cores) if args.load else nullcontext())
        ours, bare, scheduling = timing.measure(
            load_robot("m2006"),
            args.seconds,
            rounds,
            timing.compiler_here(),
            not args.no_priority,
            _progress(args, rounds),
        )
    if args.json:
        print(json.dumps(_facts(args, cores, ours, bare, scheduling)))
        return EXIT_OK
    beside = [] if args.no_dashboard else ["a dashboard"]
    beside += [f"{cores} busy processes"] if args.load else []
    say(f"{args.seconds:g} s for each loop, {scheduling}, beside {' and '.join(beside) or 'nothing'}")
    say(*_table(ours, bare), *_histogram(ours, bare))
    if bare is None:
        say("no C compiler to compare with; try: sudo apt install gcc libc6-dev")
    return EXIT_OK


def _progress(args: argparse.Namespace, rounds: int) -> Callable[[int], None]:
    def told(done: int) -> None:
        print(f"\r{done} of {rounds} rounds\r", end="", file=sys.stderr, flush=True)

    return told if sys.stderr.isatty() and not args.json else lambda done: None


def _facts(
    args: argparse.Namespace, cores: int, ours: Lateness, bare: Lateness | None, scheduling: str
) -> dict[str, object]:
    facts: dict[str, object] = {
        "scheduling": scheduling,
        "dashboard": not args.no_dashboard,
        "busy_processes": cores if args.load else 0,
        "load_average": round(os.getloadavg()[0], 2),
        "ours": ours.facts(),
    }
    if bare is not None:
        facts["c"] = bare.facts()
        facts["ratios"] = {"p99": _ratio(ours, bare, "p99_us"), "over_1_ms": _ratio(ours, bare, "over_1_ms_percent")}
    return facts


def _ratio(ours: Lateness, bare: Lateness, key: str) -> float | None:
    """How many times the C loop's figure ours is; None where the C loop's is 0."""
    theirs = bare.facts()[key]
    return round(ours.facts()[key] / theirs, 3) if theirs else None


def _table(ours: Lateness, bare: Lateness | None) -> list[str]:
    lines = [f"{'':14}{'p50':>9}{'p99':>9}{'p99.9':>9}{'max':>10}   over 1 ms"]
    for name, lateness in (("this bench", ours), ("a loop in C", bare)):
        if lateness is not None:
            late = lateness.facts()
            figures = "".join(f"{late[key]:>9.0f}" for key in ("p50_us", "p99_us", "p999_us"))
            lines.append(f"{name:14}{figures}{late['max_us']:>10.0f} us {late['over_1_ms_percent']:>8.3f} %")
    return lines


def _histogram(ours: Lateness, bare: Lateness | None) -> list[str]:
    """Ticks by lateness, a row for each step: ours as a bar, both as numbers."""
    rows = ours.bars()
    others = bare.bars() if bare is not None else [(name, 0) for name, _ in rows]
    used = [k for k, ((_, mine), (_, theirs)) in enumerate(zip(rows, others, strict=True)) if mine or theirs]
    lines = ["   up to         ticks" + ("       in C" if bare is not None else "")]
    for k in range(used[0], used[-1] + 1) if used else ():
        name, count = rows[k]
        length = round(HISTOGRAM_WIDTH * count / max(1, ours.ticks))
        in_c = f"{others[k][1]:>11}" if bare is not None else ""
        lines.append(f"{name:>11}{count:>11}{in_c}  {'#' * length}")
    return lines


@contextmanager
def _dashboard_beside() -> Iterator[None]:
    """The demo in a dashboard that nobody sees, in a process of its own: it draws and computes as a real one does."""
    code = "from bench.cli.punctuality import show_demo_to_nobody as show; show()"
    shown = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        wait_ns(BEGIN_NS)
        yield
    finally:
        shown.kill()
        shown.wait()


def show_demo_to_nobody() -> None:
    """The dashboard's loop without a terminal; ends when it is killed."""
    from bench.check.sources import from_source
    from bench.demo import SCENARIO
    from bench.io.clock import WallPacer
    from bench.io.link import InlineLink
    from bench.screen.session import Session
    from bench.tui import Dashboard

    job = from_source(str(SCENARIO))
    link = InlineLink(job.bench, lambda tick: job.inputs(tick % job.ticks), WallPacer())
    Dashboard(Session(link, job=job)).run(headless=True, size=(150, 50))
