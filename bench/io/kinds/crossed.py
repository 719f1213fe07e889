"""A CAN bus inside the process, as two ports: what one writes, the other reads."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from bench.io.can_port import CanPort
from bench.messages import CanFrame

CROSSED_FRAMES = 2000


class _Crossed:
    """One end of a bus inside the process."""

    def __init__(self, name: str, mine: deque[CanFrame], theirs: deque[CanFrame]) -> None:
        self.name, self.where, self.lost, self.note = name, "", "", ""
        self.losses = self.dropped_frames = self.other_frames = self.noise = 0
        self.is_flooded = False
        self._mine, self._theirs = mine, theirs

    def read(self) -> tuple[CanFrame, ...]:
        """What the other end has sent."""
        frames = tuple(self._mine)
        self._mine.clear()
        return frames

    def write(self, frames: Sequence[CanFrame], within_s: float = 0.0) -> bool:
        """To the other end, which always has room."""
        self._theirs.extend(frames)
        return True

    def revive(self) -> bool:
        """It is never lost."""
        return True

    def close(self) -> None:
        """Nothing to give back."""


def crossed() -> tuple[CanPort, CanPort]:
    """The two ends of one bus."""
    left: deque[CanFrame] = deque(maxlen=CROSSED_FRAMES)
    right: deque[CanFrame] = deque(maxlen=CROSSED_FRAMES)
    return _Crossed("sim:", left, right), _Crossed("sim:", right, left)
