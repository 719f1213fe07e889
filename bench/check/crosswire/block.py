"""Some ticks of a run, column by column: the checks look at whole blocks, which costs a fifth of tick by tick."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, compress
from operator import itemgetter
from typing import TypeAlias

from bench.messages import CanFrame, StateRow, TickOutput

BLOCK_TICKS = 100
"""A block begins at a multiple of this, so that a run and its recording are cut alike; the window of every rate."""

Pattern: TypeAlias = tuple[tuple[int, int], ...]
"""What one tick brings: (identifier, length) of each frame, in their order."""


_IDENTIFIER, _DATA = itemgetter(0), itemgetter(1)


class Frames:
    """The frames of one side of the CAN bus in a block. `pattern` is that of every tick; None where ticks differ."""

    __slots__ = ("datas", "every", "ids", "pattern")

    def __init__(self, ticks: Sequence[tuple[CanFrame, ...]]) -> None:
        self.every: list[CanFrame] = list(chain.from_iterable(ticks))
        # Each a pass in C: a third of the cost of taking the pairs apart together.
        self.ids: list[int] = list(map(_IDENTIFIER, self.every))
        self.datas: list[bytes] = list(map(_DATA, self.every))
        self.pattern: Pattern | None = None
        count, first = len(ticks), ticks[0]
        if len(self.every) == len(first) * count and self.ids == self.ids[: len(first)] * count:
            lengths = [len(data) for _, data in first]
            if len(set(map(len, self.datas))) == 1 or list(map(len, self.datas)) == lengths * count:
                self.pattern = tuple(zip(self.ids, lengths, strict=False))


class Block:
    """The columns of consecutive ticks, at least one. `first` is the tick of the first."""

    __slots__ = (
        "answers", "can_commands", "can_feedback", "commands", "feedback", "first", "rc", "requests", "row_places",
        "states", "ticks",
    )  # fmt: skip

    def __init__(self, outs: Sequence[TickOutput]) -> None:
        self.ticks: tuple[int, ...]
        self.rc: tuple[bytes, ...]
        self.requests: tuple[bytes, ...]
        self.answers: tuple[bytes, ...]
        self.can_commands: tuple[tuple[CanFrame, ...], ...]
        self.can_feedback: tuple[tuple[CanFrame, ...], ...]
        self.states: tuple[StateRow | None, ...]
        columns = zip(*outs, strict=True)
        self.ticks, self.rc, self.requests, self.answers, self.can_commands, self.can_feedback, self.states = columns
        self.first = self.ticks[0]
        self.commands = Frames(self.can_commands)
        self.feedback = Frames(self.can_feedback)
        self.row_places = self.places(self.states)
        """Where there is a row of state."""

    def __len__(self) -> int:
        return len(self.ticks)

    def places(self, column: Sequence[object]) -> list[int]:
        """Where a column holds something."""
        return list(compress(range(len(self.ticks)), column))
