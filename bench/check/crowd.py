"""Many runs, some at a time, in processes of their own: how far each is can be watched, and all can be ended at once.

The processes leave Ctrl-C to the one that started them: it tells them to stop, each ends after a whole block of ticks,
and closes its recording. One that dies takes its run with it, and no other: its place is taken by a new one.
"""

from __future__ import annotations

import multiprocessing
import signal
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

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
    one: Callable[[Given, Tell], Made],
    given: Sequence[Given],
    jobs: int,
    lost: Callable[[Given, str], Made],
    watch: Watch | None = None,
) -> Iterator[Made]:
    """What `one` makes of each of what is given, in that order, so many at a time. `one` tells how far it is; what it
    raises is raised in its turn. `lost` makes the result of a run whose process died, from a sentence that says how.
    """
    watch = watch or _nobody
    if jobs == 1 or len(given) < 2:
        yield from _one_by_one(one, given, watch)
        return
    crowd = _Crowd(one, given, lost)
    try:
        yield from crowd.results(jobs, watch)
    finally:
        crowd.end()


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

        made = one(item, tell)
        shares[index] = 1.0
        yield made


class _Answer(NamedTuple):
    """What a run made, or raised."""

    made: Any
    error: Exception | None = None


class _Crowd(Generic[Given, Made]):
    """All runs and the processes that work on them. A process never waits: without a next run it is sent away."""

    def __init__(
        self, one: Callable[[Given, Tell], Made], given: Sequence[Given], lost: Callable[[Given, str], Made]
    ) -> None:
        # Fresh processes: a fork of a program that has threads or a screen is a risk.
        self._context = multiprocessing.get_context("spawn")
        self._one, self._given, self._lost = one, given, lost
        self._shares = self._context.RawArray("d", len(given))
        self._stop = self._context.RawValue("b", 0)
        self._waiting = deque(range(len(given)))
        self._workers: dict[Connection, _Worker] = {}
        self._answers: dict[int, _Answer] = {}

    def results(self, jobs: int, watch: Watch) -> Iterator[Made]:
        """All of them, in order; raises what a run has raised."""
        for index in range(len(self._given)):
            while index not in self._answers:
                self._work(jobs)
                if watch(self._shares):
                    self._stop.value = 1
            made, error = self._answers.pop(index)
            if error is not None:
                raise error
            yield made

    def _work(self, jobs: int) -> None:
        """Keep all busy for a moment, and take what answers there are."""
        while self._waiting and len(self._workers) < jobs:
            worker = _Worker(self._context, _serve, (self._one, self._shares, self._stop))
            self._workers[worker.connection] = worker
            self._give(worker)
        for connection in wait(list(self._workers), LOOK_EVERY_S):
            assert isinstance(connection, Connection)
            worker = self._workers[connection]
            answer = worker.answer()
            self._answers[worker.index] = answer or _Answer(self._lost(self._given[worker.index], worker.fate()))
            self._shares[worker.index] = 1.0
            if answer and self._waiting:
                self._give(worker)
            else:
                self._workers.pop(connection).end()

    def _give(self, worker: _Worker) -> None:
        index = self._waiting.popleft()
        worker.give(index, self._given[index])

    def end(self) -> None:
        """Send all away, wherever they are."""
        for worker in self._workers.values():
            worker.end()


class _Worker:
    """A process that takes one run after another. Where it dies, its connection ends."""

    def __init__(self, context: Any, target: Callable[..., None], shared: tuple[Any, ...]) -> None:
        self.index = -1
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=target, args=(theirs, *shared), daemon=True)
        resource_tracker.ensure_running()  # started below, it would unblock the signal
        # A Ctrl-C before the process can ignore it would kill it: what is blocked here is blocked in what is started.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        theirs.close()

    def give(self, index: int, item: object) -> None:
        """The next run."""
        self.index = index
        with suppress(ConnectionError):  # it has died: that is its answer
            self.connection.send((index, item))

    def answer(self) -> _Answer | None:
        """What became of the run; None where the process died of it."""
        try:
            answer: _Answer = self.connection.recv()
        except (EOFError, OSError):
            return None
        return answer

    def fate(self) -> str:
        """How the process died."""
        self._process.join()
        status = self._process.exitcode
        how = f"by signal {-status} ({signal.strsignal(-status)})" if status < 0 else f"with status {status}"
        return f"its process ended {how} before the run was over; run it again, alone where memory is short"

    def end(self) -> None:
        """Whatever it is at."""
        self._process.terminate()
        self._process.join()
        self.connection.close()


# --- in a process of its own -----------------------------------------------------------------------------------------


def _serve(connection: Connection, one: Callable[[Any, Tell], Any], shares: Any, stop: Any) -> None:
    """One run after another, until the one that gives them is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    with suppress(EOFError, ConnectionError):
        while True:
            index, item = connection.recv()
            connection.send(_done(one, index, item, shares, stop))


def _done(one: Callable[[Any, Tell], Any], index: int, item: object, shares: Any, stop: Any) -> _Answer:
    def tell(share: float) -> None:
        shares[index] = share
        if stop.value:
            raise Stopped("told to end")

    try:
        return _Answer(one(item, tell))
    except Exception as error:
        error.add_note(traceback.format_exc())  # a traceback does not cross to another process
        return _Answer(None, error)
