"""A run without a dashboard: every tick, recorded if asked for, a progress bar where stderr is a terminal."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from bench.check.conduct import conduct
from bench.check.faulty import Touch
from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.summary import Summary
from bench.errors import spelt
from bench.io.clock import now_ns
from bench.messages import TickOutput

BAR_WIDTH = 32
BAR_EVERY_BLOCKS = 5


def execute(run: Run, recorder: Recorder | None = None, *, quiet: bool = False) -> tuple[Summary, float]:
    """Run to the end; returns what happened and how many times faster than real time it was.

    Ctrl-C and SIGTERM end the run after a whole block of ticks, with its recording closed. Raises KeyboardInterrupt for
    either.
    """
    started_ns = now_ns()
    with asked_to_stop() as asked:

        def stop_if_asked(_block: list[TickOutput], _touches: list[Touch]) -> None:
            if asked:
                raise KeyboardInterrupt

        summary = conduct(run, recorder, blocks=_with_bar(run, quiet), after_block=stop_if_asked)
    took_ns = max(1, now_ns() - started_ns)
    return summary, summary.ticks * 1e6 / took_ns


@contextmanager
def asked_to_stop() -> Iterator[list[int]]:
    """A list that holds the first signal to stop. A second one acts as usual, at once.

    An exception out of a signal can strike inside a callback of the engine, where it is swallowed; a list cannot.
    """
    asked: list[int] = []
    if threading.current_thread() is not threading.main_thread():  # only there may signals be caught
        yield asked
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def note(number: int, _frame: object) -> None:
        asked.append(number)
        for each, handler in before.items():
            signal.signal(each, handler)

    for number in before:
        signal.signal(number, note)
    try:
        yield asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _with_bar(run: Run, quiet: bool) -> Iterable[list[TickOutput]]:
    if quiet or not sys.stderr.isatty():
        return run.blocks()
    return _bar(run)


def _bar(run: Run) -> Iterable[list[TickOutput]]:
    try:
        for number, block in enumerate(run.blocks()):
            if number % BAR_EVERY_BLOCKS == 0 and block:
                tick = block[0].tick
                done = tick * BAR_WIDTH // run.ticks
                seconds = f"{tick / 1000:.1f}/{run.ticks / 1000:.1f} s"
                print(
                    f"\r{spelt(run.title)} [{'#' * done}{'.' * (BAR_WIDTH - done)}] {seconds} ", end="", file=sys.stderr
                )
            yield block
    finally:
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)
