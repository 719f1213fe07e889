"""Many runs, some at a time, in processes of their own: how far each is can be watched, and all can be ended at once.

The processes leave Ctrl-C to the one that started them: it tells them to stop, each ends after a whole block of ticks,
and closes its recording.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, TypeAlias, TypeVar

from bench.errors import EXIT_FAILED, BenchError

Tell: TypeAlias = Callable[[float], None]
"""Called with the share of a run that is done; raises Stopped where the run is to end."""
Watch: TypeAlias = Callable[[Sequence[float]], bool]
"""Called every now and then with the share of each run that is done; whether all of them are to end."""
Given = TypeVar("Given")
Made = TypeVar("Made")

LOOK_EVERY_S = 0.1


class Stopped(BenchError):
    """The run was told to end."""

    exit_status = EXIT_FAILED


def each(
    one: Callable[[Given, Tell], Made], given: Sequence[Given], jobs: int, watch: Watch | None = None
) -> Iterator[Made]:
    """What `one` makes of each of what is given, in that order, so many at a time. `one` tells how far it is."""
    watch = watch or _nobody
    if jobs == 1 or len(given) < 2:
        yield from _one_by_one(one, given, watch)
        return
    # Fresh processes: a fork of a program that has threads or a screen is a risk.
    context = multiprocessing.get_context("spawn")
    shares, stop = context.RawArray("d", len(given)), context.RawValue("b", 0)
    with context.Pool(min(jobs, len(given)), _begin, (shares, stop)) as pool:
        results = pool.imap(partial(_work, one), list(enumerate(given)))
        while True:
            try:
                yield results.next(timeout=LOOK_EVERY_S)
            except multiprocessing.TimeoutError:
                if watch(shares):
                    stop.value = 1
            except StopIteration:
                return


def _nobody(_shares: Sequence[float]) -> bool:
    return False


def _one_by_one(one: Callable[[Given, Tell], Made], given: Sequence[Given], watch: Watch) -> Iterator[Made]:
    shares = [0.0] * len(given)
    stopped: list[bool] = []
    for index, item in enumerate(given):

        def tell(share: float, index: int = index) -> None:
            shares[index] = share
            if stopped or watch(shares):
                stopped.append(True)
                raise Stopped("told to end")

        yield one(item, tell)


# --- in a process of its own -----------------------------------------------------------------------------------------

_here: dict[str, Any] = {}
"""What this process shares with the one that started it."""


def _begin(shares: Any, stop: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _here.update(shares=shares, stop=stop)


def _work(one: Callable[[Given, Tell], Made], numbered: tuple[int, Given]) -> Made:
    index, item = numbered

    def tell(share: float) -> None:
        _here["shares"][index] = share
        if _here["stop"].value:
            raise Stopped("told to end")

    return one(item, tell)
