"""A piece of work in a process of its own, for a screen that must not wait: forked, it begins with all that is here.

    child    {"share": 0.4} as often as it likes, then {"said": ...} or {"failed": ...}   --->   parent, when it looks

The child has nothing of the terminal: no descriptor but its end of the pipe, a process group of its own. It ends when
nobody listens any more. A fork of a program with threads may not use what a thread of it held: no screen, no logging.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import TypeAlias

from bench.errors import BenchError
from bench.io.forked import end_at_once, fork, leave_the_terminal

Tell: TypeAlias = Callable[[float], None]
"""Called with the share that is done; raises BrokenPipeError where nobody wants the rest."""
STANDARD = (0, 1, 2)
MOST_DESCRIPTORS = 4096
READ_BYTES = 1 << 16
NICER = 5


class Errand:
    """Starts the child; `look` takes what it has told. `work` gives the lines that are worth saying at its end.

    What it raises comes back as a sentence.
    """

    def __init__(self, work: Callable[[Tell], list[str]]) -> None:
        self.share = 0.0
        self.said: list[str] | None = None
        """What `work` gave, once it has ended well."""
        self.failed = ""
        """Why it did not."""
        self._told = b""
        self._pipe, theirs = os.pipe()
        self._child = fork()
        if self._child == 0:
            os.close(self._pipe)
            _work(work, theirs)
        os.close(theirs)
        os.set_blocking(self._pipe, False)

    @property
    def is_over(self) -> bool:
        """Whether it has said its last word, or cannot any more."""
        return not self._child

    def look(self) -> None:
        """Take what the child has told; never waits for it."""
        while self._child:
            try:
                data = os.read(self._pipe, READ_BYTES)
            except BlockingIOError:
                return
            *lines, self._told = (self._told + data).split(b"\n")
            for line in lines:
                self._take(json.loads(line))
            if not data:
                if self.said is None and not self.failed:
                    self.failed = "its process was ended from outside"
                self._reap()

    def give_up(self) -> None:
        """End it at once, wherever it is."""
        if self._child:
            end_at_once(self._child)
            self._reap()

    def _take(self, told: dict[str, object]) -> None:
        if "share" in told:
            self.share = float(str(told["share"]))
        elif "said" in told:
            said = told["said"]
            assert isinstance(said, list)
            self.said = [str(line) for line in said]
        else:
            self.failed = str(told["failed"])

    def _reap(self) -> None:
        child, self._child = self._child, 0
        os.waitpid(child, 0)
        os.close(self._pipe)


def _work(work: Callable[[Tell], list[str]], pipe: int) -> None:
    """All that the child does; it never returns."""
    status = 1
    try:
        leave_the_terminal()
        os.nice(NICER)  # whoever drives meanwhile comes first
        _let_go_of_everything_but(pipe)

        def tell(**what: object) -> None:
            os.write(pipe, json.dumps(what).encode() + b"\n")

        try:
            tell(said=work(lambda share: tell(share=share)))
        except BrokenPipeError:
            raise
        except (BenchError, OSError) as error:
            tell(failed=str(error))
        except Exception as error:
            tell(failed=f"{type(error).__name__}: {error}")
        status = 0
    finally:
        os._exit(status)


def _let_go_of_everything_but(pipe: int) -> None:
    """A guardian that waits for the end of this program shall not wait for us."""
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in STANDARD:
        os.dup2(nothing, number)
    os.closerange(len(STANDARD), pipe)
    os.closerange(pipe + 1, MOST_DESCRIPTORS)
