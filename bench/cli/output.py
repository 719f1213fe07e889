"""What a verb prints, and the files that it writes besides.

    say(f"recorded  {directory}")
    say(*lines)

Every line for people goes through `say`: what it quotes is named by others, and a name may hold anything but a NUL.
What is for programs is JSON, which spells such letters out itself.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING

from bench.errors import SurroundingsError, UsageError, spelt

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path


def say(*lines: str, flush: bool = False) -> None:
    """Print them, each on a line of its own, whatever is in it. Raises OSError."""
    print("\n".join(map(spelt, lines)), flush=flush)


class Speaker:
    """Prints. Where a page or report is still to be written (`is_kept`), a reader that has left (`| head`) does not end
    the run: `end` raises what was met, when all is done.
    """

    def __init__(self, is_kept: bool) -> None:
        self._is_kept = is_kept
        self._met: OSError | None = None

    def say(self, *lines: str) -> None:
        """For people. Raises OSError."""
        self._print("\n".join(map(spelt, lines)))

    def say_facts(self, *facts: object) -> None:
        """For programs, one JSON object a line. Raises OSError."""
        self._print("\n".join(map(json.dumps, facts)))

    def _print(self, text: str) -> None:
        if self._met is not None:
            return
        try:
            print(text, flush=True)
        except OSError as error:
            if not self._is_kept:
                raise
            self._met = error

    def end(self) -> None:
        """Raises OSError."""
        if self._met is not None:
            raise self._met


def refuse_hopeless(*paths: Path | None, recordings: Iterable[Path] = ()) -> None:
    """Before a long run: what could not be written after it either, and what nobody means to (`--html *.toml`, two
    texts in one file, or one in place of a folder that the run makes: `recordings`). Raises SurroundingsError,
    UsageError.
    """
    seen: set[Path] = set()
    folders = {path.resolve() for path in recordings}
    for path in paths:
        if path is None:
            continue
        if path.suffix == ".toml":
            raise UsageError(
                f"{path}: would be written over, and has the name of a TOML file; give the page's own name"
            )
        if path.resolve() in seen:
            raise UsageError(f"{path}: is given twice, and would be written over; give each its own name")
        seen.add(path.resolve())
        if path.resolve() in folders:
            raise UsageError(f"{path}: will be a recording's directory (--record); give the page another name")
        if path.is_dir():
            why = "it is a directory"
        elif not path.parent.is_dir():
            why = f"there is no directory {path.parent}"
        elif not os.access(path if path.exists() else path.parent, os.W_OK):
            why = "no permission"
        else:
            continue
        raise SurroundingsError(f"{path}: cannot be written ({why}); give another place")


def write_text(path: Path, text: str) -> None:
    """Write a page or report. Raises SurroundingsError where the place refuses."""
    try:
        # A file's name that is no text is spelt out there too.
        path.write_text(text, encoding="utf-8", errors="backslashreplace")
    except OSError as error:
        raise SurroundingsError(f"{path}: cannot be written ({error.strerror}); give another place") from None
