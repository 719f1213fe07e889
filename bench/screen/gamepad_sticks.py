"""A gamepad as sticks: its events in, stick positions and presses of buttons out. No file, no clock.

Whatever made it let go (unplugged, plugged in, out of focus, another source before), it drives only after its sticks
have been seen at rest, so that no robot starts because a pad lay on its face.
"""

from __future__ import annotations

from collections.abc import Iterable

from bench.config.gamepads import GamepadMap, PadAxis
from bench.io.gamepad import PadEvent
from bench.rc.transmitter import Sticks

ARM, STOP, FIELD_CENTRIC = "enter", "space", "f"
"""What its buttons do, by the key that does the same."""


class GamepadSticks:
    """`at_rest_first`: the sticks count for nothing until they have been seen at rest."""

    def __init__(self, layout: GamepadMap) -> None:
        self._layout = layout
        self.at_rest_first = True
        self._axes: dict[int, float] = {}
        self._pressed: dict[int, bool] = {}

    def feed(self, events: Iterable[PadEvent]) -> list[str]:
        """Take events, in order; which keys their buttons stand for. How a button stands at first is no press."""
        layout, keys = self._layout, []
        meanings = {layout.arm: ARM, layout.stop: STOP, layout.field_centric: FIELD_CENTRIC}
        for is_axis, number, value in events:
            if is_axis:
                self._axes[number] = value
                continue
            before, self._pressed[number] = self._pressed.get(number, True), value > 0.0
            if value and not before and number in meanings:
                keys.append(meanings[number])
        if self.at_rest_first and self._axes and not any(self._position()):
            self.at_rest_first = False
        return keys

    def forget(self) -> None:
        """It has gone: nothing is known of it any more."""
        self._axes.clear()
        self._pressed.clear()
        self.at_rest_first = True

    def release(self) -> None:
        """Nobody holds it, as far as we know."""
        self.at_rest_first = True

    def lacking(self, axes: int | None, buttons: int | None) -> str:
        """What the map names and a pad with so many axes and buttons has not, in words."""
        layout, missing = self._layout, []
        for what in ("forward", "left", "turn"):
            number = getattr(layout, what).axis
            missing += [f"axis {number} ({what})"] if axes is not None and number >= axes else []
        for what in ("arm", "stop", "field_centric", "hold"):
            pressed = getattr(layout, what)
            missing += [f"button {pressed} ({what})"] if None not in (pressed, buttons) and pressed >= buttons else []
        return f"it has no {', no '.join(missing)}; another --gamepad-map may fit" if missing else ""

    def sticks(self) -> Sticks:
        """Where its sticks stand."""
        hold = self._layout.hold
        if self.at_rest_first or (hold is not None and not self._pressed.get(hold, False)):
            return Sticks()
        return Sticks(*self._position())

    def _position(self) -> tuple[float, float, float]:
        layout = self._layout
        return self._stick(layout.forward), self._stick(layout.left), self._stick(layout.turn)

    def _stick(self, axis: PadAxis) -> float:
        """Zero inside the dead-band, from zero at its edge."""
        value = self._axes.get(axis.axis, 0.0)
        dead_band = self._layout.dead_band
        size = max(0.0, (abs(value) - dead_band) / (1.0 - dead_band))
        return -size if (value < 0.0) is not axis.reversed and size else size
