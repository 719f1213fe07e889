"""`wheelbench doctor`: what this machine can do, and what to try where it cannot. `doctor timing`: how punctually."""

from __future__ import annotations

import argparse
import json
from contextlib import ExitStack, contextmanager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from bench.io.clock import Lateness
    from bench.io.surroundings import Finding

MARKS = {"ok": "  ", "lacking": "- ", "bad": "! "}
BAR = 1.5
ROUND_S = 2.0
KITTY_S = 1.5
"""Terminals answer in milliseconds, over a bad line in a second; one that never does is waited for once."""
HISTOGRAM_WIDTH = 40


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("what", nargs="?", choices=("all", "timing"), default="all", help="all (default), or timing")
    parser.add_argument("--seconds", type=float, default=20.0, metavar="N", help="timing: so long for each loop (20)")
    parser.add_argument("--load", action="store_true", help="timing: with one busy process for each core")
    parser.add_argument("--no-dashboard", action="store_true", help="timing: without a dashboard drawing beside it")
    parser.add_argument("--no-priority", action="store_true", help="timing: as where real-time priority is not allowed")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Look round, or measure."""
    from bench.errors import EXIT_OK, UsageError

    if args.what == "timing":
        if not 0.1 <= args.seconds <= 3600.0:
            raise UsageError(f"--seconds {args.seconds:g}: expected 0.1 to 3600")
        return _timing(args)
    from bench.io.surroundings import look_round

    findings = [*_terminal(), *look_round()]
    if args.json:
        print(json.dumps({"findings": [one._asdict() for one in findings]}))
        return EXIT_OK
    for one in findings:
        print(f"{MARKS[one.state]}{one.topic:12}{one.text}")
        if one.what_to_try:
            print(f"{'':14}try: {one.what_to_try}")
    return EXIT_OK


# --- the terminal ------------------------------------------------------------------------------------------------


def _terminal() -> list[Finding]:
    import os
    import sys

    from bench.cli.terminal import has_terminal
    from bench.io.surroundings import BAD, LACKING, OK, Finding

    if not has_terminal():
        text = "none on stdin, stdout and stderr: no dashboard; replay, check and doctor work"
        return [Finding("terminal", LACKING, text, "run this in a terminal")]
    size = os.get_terminal_size(sys.stdout.fileno())  # not what COLUMNS and LINES once were
    fits = size.columns >= 80 and size.lines >= 24
    true_colour = os.environ.get("COLORTERM", "") in ("truecolor", "24bit")
    text = f"{os.environ.get('TERM', 'unknown')}, {size.columns}x{size.lines}"
    found = [Finding("terminal", OK if fits else BAD, text, "" if fits else "make the window 80x24 or larger")]
    colours = "16 million colours" if true_colour else "COLORTERM is not set: perhaps 256 colours"
    found.append(
        Finding("colours", OK if true_colour else LACKING, colours, "" if true_colour else "export COLORTERM=truecolor")
    )
    kitty = _speaks_kitty()
    told = "tells when a key is let go (Kitty's protocol)" if kitty else "does not tell when a key is let go"
    advice = "" if kitty else "kitty, foot, Ghostty, WezTerm or Alacritty do, outside of tmux"
    return [*found, Finding("keys", OK if kitty else LACKING, told, advice)]


def _speaks_kitty() -> bool:
    """Ask for the protocol's flags, and then for what every terminal answers: who knows the first answers it first."""
    import os
    import re
    import select
    import sys
    import termios
    import tty

    from bench.io.clock import now_ns

    fd = sys.stdin.fileno()
    before = termios.tcgetattr(fd)
    heard = b""
    try:
        tty.setcbreak(fd)
        os.write(sys.stderr.fileno(), b"\x1b[?u\x1b[c")
        deadline_ns = now_ns() + int(KITTY_S * 1e9)
        while not re.search(rb"\x1b\[\?[\d;]*c", heard) and now_ns() < deadline_ns:
            if select.select([fd], [], [], 0.02)[0]:
                heard += os.read(fd, 256)
    finally:
        termios.tcsetattr(fd, termios.TCSAFLUSH, before)
    return re.search(rb"\x1b\[\?\d+u", heard) is not None


# --- timing --------------------------------------------------------------------------------------------------------


def _timing(args: argparse.Namespace) -> int:
    import os
    import sys

    from bench.config import load_robot
    from bench.errors import EXIT_OK
    from bench.io.timing import busy, compiler_here, measure

    compiler = compiler_here()
    rounds = max(1, round(args.seconds / ROUND_S))
    on_terminal = sys.stderr.isatty() and not args.json

    def told(done: int) -> None:
        if on_terminal:
            print(f"\r{done} of {rounds} rounds\r", end="", file=sys.stderr, flush=True)

    cores = os.cpu_count() or 1
    with ExitStack() as stack:
        stack.enter_context(nullcontext() if args.no_dashboard else _dashboard_beside())
        stack.enter_context(busy(cores) if args.load else nullcontext())
        ours, bare, scheduling = measure(
            load_robot("m2006"), args.seconds, rounds, compiler, not args.no_priority, told
        )
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
    if args.json:
        print(json.dumps(facts))
        return EXIT_OK
    beside = [] if args.no_dashboard else ["a dashboard"]
    beside += [f"{cores} busy processes"] if args.load else []
    print(f"{args.seconds:g} s for each loop, {scheduling}, beside {' and '.join(beside) or 'nothing'}")
    print(f"{'':14}{'p50':>9}{'p99':>9}{'p99.9':>9}{'max':>10}   over 1 ms")
    for name, lateness in (("this bench", ours), ("a loop in C", bare)):
        if lateness is not None:
            late = lateness.facts()
            figures = "".join(f"{late[key]:>9.0f}" for key in ("p50_us", "p99_us", "p999_us"))
            print(f"{name:14}{figures}{late['max_us']:>10.0f} us {late['over_1_ms_percent']:>8.3f} %")
    print("\n".join(_histogram(ours, bare)))
    if bare is None:
        print("no C compiler to compare with; try: sudo apt install gcc libc6-dev")
    return EXIT_OK


def _ratio(ours: Lateness, bare: Lateness, key: str) -> float | None:
    """How many times the C loop's figure ours is; None where the C loop's is 0."""
    theirs = bare.facts()[key]
    return round(ours.facts()[key] / theirs, 3) if theirs else None


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
    import subprocess
    import sys

    code = "from bench.cli.doctor import show_demo_to_nobody as show; show()"
    shown = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        from bench.io.clock import wait_ns

        wait_ns(2_000_000_000)  # until it has begun to draw
        yield
    finally:
        shown.kill()
        shown.wait()


def show_demo_to_nobody() -> None:
    """The dashboard's loop without a terminal; ends when it is killed."""
    from importlib.resources import files

    from bench.check.run import from_source
    from bench.io.clock import WallPacer
    from bench.io.link import InlineLink
    from bench.screen.session import Session
    from bench.tui import Dashboard

    job = from_source(str(files("bench") / "demo" / "demo.toml"))
    link = InlineLink(job.bench, lambda tick: job.inputs(tick % job.ticks), WallPacer())
    Dashboard(Session(link, job=job)).run(headless=True, size=(150, 50))
