"""An environment with packages that only a comparison needs; it goes when this process ends."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import peers


@cache
def environment(packages: tuple[str, ...]) -> tuple[tempfile.TemporaryDirectory[str], Path | None]:
    """One for all rounds: its folder, and its Python, or None where the packages cannot be installed here."""
    folder = tempfile.TemporaryDirectory(prefix="wheelbench-peers-")
    return folder, peers.environment(folder.name, packages)
