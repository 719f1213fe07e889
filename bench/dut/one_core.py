"""Keeps the thread that steps a firmware and the firmware's process on one core of the machine while a run lasts.

The two never compute at the same time. On one core a turn is a switch; on two it wakes a core that has gone to sleep,
or waits for one that others use, which costs more than all the rest of a turn. Which core it is, the system chooses:
every so often it is free to, for a tick.
"""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress

REVIEW_TICKS = 1024
"""So often the system may choose again: some 65 ms of the wall's time."""

_libc = ctypes.CDLL(None)


class _Thread:
    """What a thread was allowed before it was kept on one core, and for how many runs it is."""

    def __init__(self) -> None:
        self.allowed = os.sched_getaffinity(0)
        self.runs = 0


_kept: dict[int, _Thread] = {}
"""By the system's number of the thread. Runs of one thread may begin and end in any order."""


class OneCore:
    """For one run of one firmware. Where the system refuses, or there is one core only, it does nothing."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._number = int(os.path.basename(os.readlink("/proc/thread-self")))
        self._thread = _kept.setdefault(self._number, _Thread())
        self._thread.runs += 1
        self._core: int | None = None
        self._gather()

    def review(self, tick: int) -> None:
        """For the ticks on either side of each `REVIEW_TICKS`: in the first the system chooses, then both stay."""
        if tick % REVIEW_TICKS == 0:
            self._gather()
        else:
            with suppress(OSError):
                os.sched_setaffinity(self._number, self._thread.allowed)

    def _gather(self) -> None:
        if len(self._thread.allowed) == 1:
            return
        with suppress(OSError):
            core = _libc.sched_getcpu()
            os.sched_setaffinity(self._number, {core})
            if core != self._core:
                os.sched_setaffinity(self._pid, {core})
                self._core = core

    def release(self, is_alive: bool) -> None:
        """The run is over: the thread is where it may be as before, and the firmware if it is still there."""
        thread = self._thread
        thread.runs -= 1
        if thread.runs == 0:
            _kept.pop(self._number, None)
            with suppress(OSError):
                os.sched_setaffinity(self._number, thread.allowed)
        if is_alive and self._core is not None:
            with suppress(OSError):
                os.sched_setaffinity(self._pid, thread.allowed)
