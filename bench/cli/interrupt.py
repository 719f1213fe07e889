"""The command's first and last moments, in which nobody could catch a Ctrl-C: it ends with status 130, no traceback.

`command` is what `wheelbench` runs, and `python -m bench` takes the same way. Between those moments Ctrl-C is what it
is in any Python, so that a verb can tidy up. Who calls `bench.__main__.main` from a program of their own keeps their
signals as they are. What Python does before a line of ours is run (its `site`) is not ours to catch.
"""

from __future__ import annotations

import _thread
import os
import sys

# `signal` reads `enum` and half a library first, and `typing` more: long enough for a Ctrl-C.
from _signal import SIGINT, default_int_handler, getsignal, pthread_kill, signal  # type: ignore[import-not-found]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

INTERRUPTED = 130
"""What a shell says of a command that Ctrl-C has ended."""
SOON_S = 0.01


def command() -> None:
    """What the command `wheelbench` runs; it does not come back."""
    take_over()
    end_with(_main)


def take_over() -> None:
    """From here on Ctrl-C ends us here and now. Whoever started us deaf to it (`nohup`, a shell's `&`) is obeyed."""
    if getsignal(SIGINT) is default_int_handler:
        signal(SIGINT, _leave)


def hand_over() -> None:
    """There is somebody to catch it: KeyboardInterrupt again, where it was ours."""
    if getsignal(SIGINT) is _leave:
        sys.unraisablehook = _strike_again
        signal(SIGINT, default_int_handler)


def end_with(main: Callable[[], int]) -> None:
    """Run it, and exit with its status."""
    try:
        status = main()
        take_over()
    except KeyboardInterrupt:  # a second one, while the first was being told
        status = INTERRUPTED
    sys.exit(status)


def _main() -> int:
    from bench.__main__ import main

    return main()


def _leave(_number: int, _frame: object) -> None:
    """Nothing has begun yet, or all is done."""
    try:
        os.write(2, f"wheelbench {' '.join(sys.argv[1:2])}: interrupted\n".encode(errors="replace"))
    finally:
        os._exit(INTERRUPTED)


def _strike_again(met: Any) -> None:
    """Ctrl-C can strike where Python can raise nothing, in a callback of its own import, and would be lost there.

    And here too: what is raised in a hook goes nowhere. So it comes from elsewhere, once this has been left.
    """
    if met.exc_type is KeyboardInterrupt:
        _thread.start_new_thread(_strike_soon, (_thread.get_ident(),))
    else:
        sys.__unraisablehook__(met)


def _strike_soon(thread: int) -> None:
    nobody_lets_go = _thread.allocate_lock()
    nobody_lets_go.acquire()
    nobody_lets_go.acquire(timeout=SOON_S)
    pthread_kill(thread, SIGINT)  # which wakes who waits; `interrupt_main` does not
