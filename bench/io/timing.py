"""How punctual a loop can be on this machine: ours, and the barest loop in C, in turns under the same conditions.

Each round runs a simulated bench in a process of its own for a while, then the C program. What disturbs one disturbs
the other; figures from different runs of a machine that others use cannot be compared.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from bench.config import Robot
from bench.errors import SurroundingsError
from bench.io.clock import wait_ns
from bench.io.lateness import Lateness
from bench.io.process.child import Prepared
from bench.io.process.link import ProcessLink
from bench.io.punctual import PRIORITY, REAL_TIME
from bench.loop import simulated
from bench.messages import TickInput

SOURCE = Path(__file__).with_name("bare_loop.c")
POLL_NS = 50_000_000
COMPILE_S = 60.0
_BUSY = "while True: pass"


def measure(
    robot: Robot,
    seconds: float,
    rounds: int,
    compiler: str | None,
    with_priority: bool = True,
    told: Callable[[int], None] = lambda done: None,
) -> tuple[Lateness, Lateness | None, str]:
    """Our lateness and that of the C loop (None without a compiler), each over so many seconds in all; and the
    scheduling that ours had. Where that is real-time priority, the C loop has the same; else it is an ordinary process.

    Raises SurroundingsError where the C program cannot be built or run.
    """
    ours, bare = Lateness(), Lateness() if compiler else None
    scheduling = ""
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as scratch:
        program = compiled(compiler, Path(scratch)) if compiler else None
        for done in range(rounds):
            late, scheduling = our_loop(robot, seconds / rounds, with_priority)
            ours.join(late)
            if program is not None and bare is not None:
                bare.join(bare_loop(program, seconds / rounds, PRIORITY if scheduling == REAL_TIME else 0))
            told(done + 1)
    return ours, bare, scheduling


def our_loop(robot: Robot, seconds: float, with_priority: bool = True) -> tuple[Lateness, str]:
    """A simulated bench in a child process, watched as a screen watches it: how late it was, and its scheduling."""

    def prepare() -> Prepared:
        return Prepared(simulated(robot), None)

    ticks = max(1, round(1000 * seconds))
    link = ProcessLink(simulated(robot), lambda tick: TickInput(), prepare, ticks=ticks, with_priority=with_priority)
    try:
        while not link.ended:
            wait_ns(POLL_NS)
            link.poll()
    finally:
        link.close()
    return link.counted or Lateness(), link.scheduling


def compiled(compiler: str, directory: Path) -> Path:
    """The C loop as a program. Raises SurroundingsError."""
    program = directory / "bare_loop"
    try:
        done = subprocess.run(
            [compiler, "-O2", "-o", program, SOURCE], capture_output=True, text=True, timeout=COMPILE_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SurroundingsError(f"{compiler}: cannot be run ({error}); install gcc") from None
    if done.returncode:
        first = next(iter(done.stderr.splitlines()), "no reason given")
        raise SurroundingsError(f"{compiler}: does not compile {SOURCE.name} ({first}); install gcc and libc6-dev")
    return program


def bare_loop(program: Path, seconds: float, priority: int = 0) -> Lateness:
    """Run the C loop, with real-time priority where that is not 0; what it counted."""
    done = subprocess.run([program, f"{seconds:.3f}", str(priority)], capture_output=True, text=True, check=False)
    lateness = Lateness()
    for line in done.stdout.splitlines():
        word, number = line.split()
        if word == "max":
            lateness.most_us = int(number) / 1000
        else:
            lateness.add_many(int(word), int(number))
    if done.returncode or not lateness.ticks:
        raise SurroundingsError(f"{program.name}: the C loop ended with status {done.returncode}; try again")
    return lateness


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes that do nothing but compute."""
    running = [subprocess.Popen([sys.executable, "-c", _BUSY]) for _ in range(processes)]
    try:
        yield
    finally:
        for one in running:
            one.kill()
            one.wait()


def compiler_here() -> str | None:
    """A C compiler of this machine."""
    return next(filter(None, map(shutil.which, ("gcc", "cc", "clang"))), None)
