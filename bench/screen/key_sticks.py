"""Keys as sticks: presses, repeats and releases in, stick positions out. No Textual, no clock.

Most terminals report presses and repeats, never releases. So a key grants motion for `KEY_LEASE_MS` and no longer; a
held key lives by its repeats. Between the first press and the first repeat (250 to 660 ms on common systems) the stick
returns to rest: a tap nudges, only holding drives. Whoever lets go, or loses the keyboard, stops the robot.

A terminal that reports releases (`KeySticks.releases`) holds a key from its press to its release. The lease stays: what
renews it is each proof that the terminal is alive and has reported no release (`alive`), and no proof is worth anything
once the keyboard itself has been silent for `SILENT_HOLD_MS`. docs/driving.md.
"""

from __future__ import annotations

from bench.rc.transmitter import Sticks
from bench.screen.motion import FORWARD, LEFT, MOTION, TURN

KEY_LEASE_MS = 120
LEAST_LEASE_MS = 10
WITHIN_MS, FRAME_MS = 150, 10
SILENT_HOLD_MS = 1000
"""The longest that a key is held without any event of the keyboard: longer than the longest delay before repeats."""


def lease_ticks(rate: float, lead_ticks: int) -> int:
    """A lease is never longer than its milliseconds, neither the robot's nor the wall's, and it makes room for a lead:
    zero is commanded `WITHIN_MS` after the last sign of a hand, a frame of the transmitter included.
    """
    return max(LEAST_LEASE_MS, min(round(KEY_LEASE_MS * min(1.0, rate)), WITHIN_MS - FRAME_MS - lead_ticks))


class KeySticks:
    """Which way the sticks stand, from keys alone. `power_percent` is how far a key pushes its stick.

    `releases` says that the terminal reports when a key is let go, `proven` that nothing answers in its place.
    """

    def __init__(self, power_percent: int = 50) -> None:
        self.power_percent = power_percent
        self.releases = self.proven = False
        self._lease_ticks, self._silent_ticks = KEY_LEASE_MS, SILENT_HOLD_MS
        self._until: dict[str, int] = {}  # the key pressed last stands last
        self._heard_tick = 0

    def set_time(self, rate: float, lead_ticks: int) -> None:
        """Simulated time runs so fast, and what is done now counts so many ticks later."""
        self._lease_ticks = lease_ticks(rate, lead_ticks)
        self._silent_ticks = round(SILENT_HOLD_MS * rate)

    def press(self, key: str, now_tick: int) -> None:
        """Lease the key's axis from now on. Raises KeyError for a key that moves nothing."""
        MOTION[key]
        self._until.pop(key, None)
        self._until[key] = now_tick + self._lease_ticks
        self._heard_tick = now_tick

    def let_go(self, key: str) -> None:
        """That key is no longer held."""
        self._until.pop(key, None)

    def alive(self, now_tick: int) -> None:
        """The terminal is there, and says that what was held still is. A lease that has ended stays so."""
        if self.releases and now_tick - self._heard_tick <= self._silent_ticks:
            until = now_tick + self._lease_ticks
            self._until = {key: until for key, end in self._until.items() if now_tick < end}

    def release(self) -> None:
        """Let go of every key at once."""
        self._until.clear()

    def sticks(self, now_tick: int) -> Sticks:
        """Where the sticks stand in this tick: of two keys of one axis, the one pressed last counts."""
        power = self.power_percent / 100.0
        axes = [0.0, 0.0, 0.0]
        for key, until in self._until.items():
            if 0 < until - now_tick <= KEY_LEASE_MS:  # time may have gone back, to drive on from there
                axis, sense = MOTION[key]
                axes[axis] = sense * power
        return Sticks(axes[FORWARD], axes[LEFT], axes[TURN])
