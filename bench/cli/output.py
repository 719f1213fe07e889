"""Files that a verb writes besides what it prints."""

from __future__ import annotations

from pathlib import Path

from bench.errors import SurroundingsError


def write_text(path: Path, text: str) -> None:
    """Write a page or report. Raises SurroundingsError where the place refuses."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SurroundingsError(f"{path}: cannot be written ({error.strerror}); give another place") from None
