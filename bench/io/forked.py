"""A process of our own for a piece of work: forked, so that it begins with all that is here, and needs no pickling."""

from __future__ import annotations

import os
import signal
import warnings
from contextlib import suppress


def fork() -> int:
    """As `os.fork`, where this process may have threads: the child uses none of theirs."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def leave_the_terminal(*, with_its_own_share: bool = False) -> None:
    """In the child: its keys reach the parent alone, which says when to end. SIGTERM ends it as any process.

    `with_its_own_share`: Linux divides the processor among sessions first (autogroup), and a child in its parent's
    waits for whatever else that terminal runs: the screen, a compiler. In a session of its own it does not.
    """
    if with_its_own_share:
        os.setsid()
    else:
        os.setpgrp()
    for number in (signal.SIGINT, signal.SIGTSTP, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def end_at_once(child: int) -> None:
    """In the parent: wherever it is. It is still to be waited for; one that has ended already is as good."""
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)
