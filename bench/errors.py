"""What can go wrong through the user's hands: one sentence that says what, where and what to try, and an exit status.

Nonsense on a wire is no error: it is an event and a counter. A wrong call between our own parts is a plain ValueError.
"""

from __future__ import annotations

EXIT_OK, EXIT_FAILED, EXIT_USAGE, EXIT_ENVIRONMENT = 0, 1, 2, 3


class BenchError(Exception):
    """The text is the sentence for the user; `exit_status` is what the command line ends with."""

    exit_status = EXIT_USAGE


class UsageError(BenchError):
    """A wrong file, key, name or argument."""


class ControllerFailed(BenchError):
    """The base under test raised an error, crashed, or gave what no wire can carry."""

    exit_status = EXIT_FAILED


class SurroundingsError(BenchError):
    """What is asked for is right, but this machine cannot do it now: no such port, no room, no permission."""

    exit_status = EXIT_ENVIRONMENT


def spelt(text: str) -> str:
    """Text from outside, which may hold control characters and halves of characters, as one line may show it."""
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() or letter == "\t" else repr(letter)[1:-1] for letter in text)
