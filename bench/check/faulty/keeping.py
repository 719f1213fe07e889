"""Machines that keep pieces: for later, or in the place of what follows."""

from __future__ import annotations

from collections import deque
from typing import Any

from bench.check.faulty.pieces import Frames


class Delay:
    """Pieces come later; what is still under way when the fault ends comes before what follows."""

    def __init__(self, ms: int, empty: Any) -> None:
        self._ms, self._empty = ms, empty
        self._waiting: deque[tuple[int, Any]] = deque()

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        """What is due by now."""
        waiting = self._waiting
        if not active and not waiting:
            return piece
        if piece:
            # After the fault nothing waits longer than what is before it.
            due = tick + self._ms if active else max(tick, waiting[-1][0] if waiting else tick)
            waiting.append((due, piece))
        out = self._empty
        while waiting and waiting[0][0] <= tick:
            out += waiting.popleft()[1]
        return out


class Stall:
    """Nothing comes, then everything."""

    def __init__(self, empty: Any) -> None:
        self._empty: Any = empty
        self._held: Any = empty

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        """Nothing; when the fault ends, everything."""
        held = self._held + piece
        self._held = held if active else self._empty
        return self._empty if active else held


class Swap:
    """Every piece waits for the next one and comes after it. Several frames of one tick change places at once."""

    def __init__(self, empty: Any) -> None:
        self._empty: Any = empty
        self._held: Any = empty

    def __call__(self, tick: int, piece: Any, active: bool) -> Any:
        """Nothing yet, or this piece and the one that waited for it."""
        held = self._held
        if active and piece and not held:
            if isinstance(piece, tuple) and len(piece) > 1:
                return piece[::-1]
            self._held = piece
            return self._empty
        if held and (piece or not active):
            self._held = self._empty
            return piece + held
        return piece


class FrozenPieces:
    """Every piece is the first one again."""

    def __init__(self) -> None:
        self._first = b""

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        """The first piece, wherever one comes."""
        if not active:
            self._first = b""
            return piece
        self._first = self._first or piece
        return self._first if piece else piece


class FrozenFrames:
    """Every frame of an identifier is the first one again."""

    def __init__(self) -> None:
        self._first: dict[int, bytes] = {}

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        """Each identifier's first bytes."""
        if not active:
            self._first.clear()
            return frames
        return tuple((can_id, self._first.setdefault(can_id, data)) for can_id, data in frames)


class Stuck:
    """Feedback frames with the angle of the first one, and no speed: bytes 0 to 3 in every family."""

    def __init__(self) -> None:
        self._angles: dict[int, bytes] = {}

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        """Each identifier's first angle, no speed, and what else the frame says."""
        if not active:
            self._angles.clear()
            return frames
        return tuple((i, self._angles.setdefault(i, data[:2]) + b"\0\0" + data[4:]) for i, data in frames)
