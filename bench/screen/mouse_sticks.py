"""Two sticks for the mouse, drawn on the screen: a pad for forward and left, a strip for the turn. No Textual.

    press on one of them    the stick goes there        let go                 it springs back
    drag                    it follows                  the screen's edge      as if let go

A button held on a dead connection looks like one held still. So a drag has the keys' lease: a movement renews it, and
where the terminal itself proves that it is alive, that does too, for `SILENT_DRAG_MS` without a movement.
"""

from __future__ import annotations

from typing import NamedTuple

from bench.rc.transmitter import Sticks
from bench.screen.key_sticks import KEY_LEASE_MS, lease_ticks

SILENT_DRAG_MS = 3000
"""The longest that the mouse may hold a stick without moving by a cell."""
STICK_COLUMNS = 29
NARROW = 80


class Box(NamedTuple):
    """The inside of a stick, in cells of its panel; a frame of one cell is around it."""

    x: int
    y: int
    width: int
    height: int

    def holds(self, x: int, y: int) -> bool:
        """Whether a cell lies in it."""
        return self.x <= x < self.x + self.width and self.y <= y < self.y + self.height


class Pad(NamedTuple):
    """Where the two sticks stand in a panel. Odd numbers of cells: the middle is a cell, and it is rest."""

    stick: Box
    turn: Box


def pad_of(width: int, height: int) -> Pad:
    """For a panel of that size."""
    columns = STICK_COLUMNS if width >= NARROW else STICK_COLUMNS - 8
    rows = max(1, (height - 2 - (height - 1) % 2))
    stick = Box(2, 1, columns, rows)
    return Pad(stick, Box(columns + 5, 1 + rows // 2, columns, 1))


class MouseSticks:
    """The sticks as the mouse holds them. `on` while the pad is shown."""

    def __init__(self) -> None:
        self.on = False
        self._lease_ticks, self._silent_ticks = KEY_LEASE_MS, SILENT_DRAG_MS
        self._turning: bool | None = None  # which one is held, if any
        self._at = (0.0, 0.0)
        self._until = 0
        self._moved_tick = 0

    def set_time(self, rate: float, lead_ticks: int) -> None:
        """As `KeySticks.set_time`."""
        self._lease_ticks = lease_ticks(rate, lead_ticks)
        self._silent_ticks = round(SILENT_DRAG_MS * rate)

    def press(self, x: int, y: int, pad: Pad, now_tick: int) -> bool:
        """The button goes down on that cell of the panel. Whether a stick is there."""
        self.release()
        if pad.stick.holds(x, y):
            self._turning = False
        elif pad.turn.holds(x, y):
            self._turning = True
        else:
            return False
        self.drag(x, y, pad, now_tick)
        return True

    def drag(self, x: int, y: int, pad: Pad, now_tick: int) -> None:
        """The mouse moves with the button down."""
        if self._turning is None or (self._until and now_tick >= self._until):
            self.release()  # the lease has ended: only a new press takes a stick again
            return
        box = pad.turn if self._turning else pad.stick
        self._at = (_share(x - box.x, box.width), _share(y - box.y, box.height))
        self._moved_tick = now_tick
        self._until = now_tick + self._lease_ticks

    def alive(self, now_tick: int) -> None:
        """The terminal is there, and no release has come from it."""
        if now_tick < self._until and now_tick - self._moved_tick <= self._silent_ticks:
            self._until = now_tick + self._lease_ticks

    def release(self) -> None:
        """Nothing is held."""
        self._turning, self._at, self._until = None, (0.0, 0.0), 0

    def sticks(self, now_tick: int, power_percent: int) -> Sticks:
        """Where the sticks stand in this tick."""
        if self._turning is None or not 0 < self._until - now_tick <= KEY_LEASE_MS:
            return Sticks()
        right, down = (share * power_percent / 100.0 for share in self._at)
        return Sticks(turn=-right) if self._turning else Sticks(forward=-down, left=-right)


def _share(cell: int, cells: int) -> float:
    """-1 to 1 from one end to the other; 0 in the middle cell."""
    half = cells // 2
    return max(-1.0, min(1.0, (cell - half) / half)) if half else 0.0
