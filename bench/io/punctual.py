"""What a process asks of the kernel so that it is woken on time; it changes nothing but this process."""

from __future__ import annotations

import gc
import os
import struct
import sys

REAL_TIME = "real-time priority"
PRIORITY = 10
"""Above everything ordinary, below the kernel's own threads."""
SLICE_NS = 100_000
_PR_SET_TIMERSLACK = 29
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}
"""From linux/prctl.h and the system call tables of these architectures."""


def leaves_a_processor() -> bool:
    """Whether real-time priority leaves the others a processor.

    On a single one a loop that falls behind leaves them a twentieth (the kernel's `sched_rt_runtime_us`), among them
    the process that hears the stop key.
    """
    return len(os.sched_getaffinity(0)) > 1


def be_punctual(with_priority: bool = True) -> str:
    """What a process needs that shall be woken on time; what it got, in words.

    No timer slack (50 us by default), and no garbage collection: a tick makes no cycles, so nothing piles up. Then
    real-time priority, where that is allowed and safe; else a short time slice, which newer kernels (6.12) honour by
    waking the process earlier among others that compute. Children have none of it.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    if not sys.platform.startswith("linux"):
        return "ordinary scheduling"
    import ctypes

    libc = ctypes.CDLL(None)
    libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    if with_priority and leaves_a_processor():
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(PRIORITY))
            return REAL_TIME
        except OSError:
            pass
    number = _SCHED_SETATTR.get(os.uname().machine)
    # struct sched_attr: size, policy, flags (reset on fork), nice, priority, runtime (the slice), and what is not ours
    attributes = struct.pack("<IIQiIQQQII", 56, 0, 1, os.getpriority(os.PRIO_PROCESS, 0), 0, SLICE_NS, 0, 0, 0, 0)
    if number is not None and libc.syscall(number, 0, attributes, 0) == 0:
        return "ordinary priority, short time slice"
    return "ordinary scheduling"


def be_ordinary() -> None:
    """Give real-time priority back: who cannot keep up with it shall not keep others from running."""
    if sys.platform.startswith("linux") and os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
