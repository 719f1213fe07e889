"""What the scripts' command lines share: values that are refused in a sentence, and errors that are told in one."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NoReturn


def parser(doc: str | None) -> argparse.ArgumentParser:
    """A parser whose help is the script's docstring."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def at_least_one(text: str) -> int:
    """A whole number, 1 or more."""
    if not (text.isascii() and text.isdecimal() and int(text) >= 1):
        raise argparse.ArgumentTypeError(f"expected a whole number, 1 or more, got {text}")
    return int(text)


def above_zero(text: str) -> float:
    """A number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text}")
    return value


def some_of(known: Iterable[str]) -> Callable[[str], list[str]]:
    """Names of these, with commas between them."""
    names = list(known)

    def asked(text: str) -> list[str]:
        found = [name for name in text.split(",") if name]
        unknown = [name for name in found if name not in names]
        if unknown or not found:
            raise argparse.ArgumentTypeError(f"{', '.join(unknown) or 'nothing'} is not among {', '.join(names)}")
        return found

    return asked


def existing(text: str) -> Path:
    """A file or folder that is there."""
    if not Path(text).exists():
        raise argparse.ArgumentTypeError(f"there is no file or folder {text}")
    return Path(text)


def end_with(main: Callable[[], int]) -> NoReturn:
    """Run a script and end with its status; what the bench refuses is a sentence with its exit status."""
    try:
        status = main()
    except Exception as error:
        from bench.errors import BenchError  # only now: mutate.py runs while nothing of the bench is loaded

        if not isinstance(error, BenchError):
            raise
        print(f"{Path(sys.argv[0]).name}: error: {error}", file=sys.stderr)
        status = error.exit_status
    sys.exit(status)
