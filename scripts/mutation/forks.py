"""Work done in forks of this process, some at a time: what each answers, raises, or which signal ends it.

A fork has everything loaded that its parent has, and whatever it does to itself is gone with it.
"""

from __future__ import annotations

import json
import math
import os
import resource
import select
import signal
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple, TypeVar

MEMORY_BYTES = 2 << 30
WALL_S = 900
"""A fork without an end after so long by the wall clock tells nothing: it waits, or the machine is busy."""
Piece = TypeVar("Piece")


class Ended(NamedTuple):
    """How a fork ended: what it answered, what it raised, or the signal that ended it before it could do either."""

    answer: Any = None
    raised: str = ""
    signal: int = 0


def forks(jobs: int, pieces: Iterable[Piece], task: Callable[[Piece], object]) -> Iterator[tuple[Piece, Ended]]:
    """Do each piece of work in a fork of this process, `jobs` at a time; pieces come back as they are done."""
    waiting = iter(pieces)
    running: dict[int, tuple[int, Piece]] = {}
    while True:
        while len(running) < jobs:
            piece = next(waiting, None)
            if piece is None:
                break
            read, write = os.pipe()
            child = os.fork()
            if child == 0:
                _in_fork(write, task, piece)
            os.close(write)
            running[read] = (child, piece)
        if not running:
            return
        for read in select.select(list(running), [], [])[0]:
            child, piece = running.pop(read)
            with os.fdopen(read) as pipe:
                text = pipe.read()
            _, status = os.waitpid(child, 0)
            if text:
                yield piece, Ended(*json.loads(text))
            else:
                yield piece, Ended(signal=os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0)


def _in_fork(write: int, task: Callable[[Piece], object], piece: Piece) -> None:
    try:
        sink = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(sink, stream)
        try:
            answer, raised = task(piece), ""
        except BaseException:
            answer, raised = None, traceback.format_exc()
        with os.fdopen(write, "wb") as pipe:
            pipe.write(json.dumps((answer, raised)).encode())
    finally:
        os._exit(0)


def limit(cpu_s: float) -> None:
    """End this process if it takes so much processor time from now on, waits for ever, or eats the machine's memory."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(time.process_time() + cpu_s), resource.RLIM_INFINITY))
    signal.alarm(WALL_S)
