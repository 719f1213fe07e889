"""What crosses a wire in one tick, and what a machine does to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from bench.messages import CanFrame

Frames: TypeAlias = tuple[CanFrame, ...]
Machine: TypeAlias = Callable[[int, Any, bool], Any]
"""Tick, what came in it, whether the fault acts -> what is left. Bytes to bytes, frames to frames."""


def shown(piece: bytes | Frames) -> str:
    """A piece for a person."""
    if isinstance(piece, bytes):
        return piece.hex(" ").upper() or "-"
    return " ".join(f"{can_id:03X}#{data.hex().upper()}" for can_id, data in piece) or "-"
