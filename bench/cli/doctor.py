"""`wheelbench doctor`: what this machine can do, and what to try where it cannot. `doctor timing`: how punctually."""

from __future__ import annotations

import argparse
import json
import os
import re
import select
import sys
import termios
import tty
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.io.surroundings import Finding

MARKS = {"ok": "  ", "lacking": "- ", "bad": "! "}
KITTY_S = 1.5
"""Terminals answer in milliseconds, over a bad line in a second; one that never does is waited for once."""
_TIMING = {"seconds": 20.0, "load": False, "no_dashboard": False, "no_priority": False}
"""What goes with a measurement, and its default."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("what", nargs="?", choices=("all", "timing"), default="all", help="all (default), or timing")
    parser.add_argument(
        "--seconds", type=float, default=_TIMING["seconds"], metavar="N", help="timing: so long for each loop (20)"
    )
    parser.add_argument("--load", action="store_true", help="timing: with one busy process for each core")
    parser.add_argument("--no-dashboard", action="store_true", help="timing: without a dashboard drawing beside it")
    parser.add_argument("--no-priority", action="store_true", help="timing: as where real-time priority is not allowed")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(args: argparse.Namespace) -> int:
    """Look round, or measure."""
    if args.what == "timing":
        from bench.cli.punctuality import run_timing

        return run_timing(args)
    from bench.errors import EXIT_OK, UsageError

    given = [name for name, default in _TIMING.items() if getattr(args, name) != default]
    if given:
        raise UsageError(f"--{given[0].replace('_', '-')}: goes with `wheelbench doctor timing`")
    from bench.io.surroundings import look_round

    findings = [*_terminal(), *look_round()]
    if args.json:
        print(json.dumps({"findings": [one._asdict() for one in findings]}))
        return EXIT_OK
    for one in findings:
        say(f"{MARKS[one.state]}{one.topic:12}{one.text}")
        if one.what_to_try:
            say(f"{'':14}try: {one.what_to_try}")
    return EXIT_OK


def _terminal() -> list[Finding]:
    """Its size, its colours and its keys."""
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
