"""The keyboard as a transmitter: keys and ticks in, RC bytes out by the front door. No Textual, no clock.

Most terminals report presses and repeats, never releases. So a key grants motion for `KEY_LEASE_MS` and no longer; a
held key lives by its repeats. Between the first press and the first repeat (250 to 660 ms on common systems) the stick
returns to rest: a tap nudges, only holding drives. Whoever lets go, or loses the keyboard, stops the robot.

A terminal that reports releases (`KeySticks.releases`) holds a key from its press to its release. The lease stays: what
renews it is each proof that the terminal is alive and has reported no release (`alive`), and no proof is worth anything
once the keyboard itself has been silent for `SILENT_HOLD_MS`. docs/driving.md.

    w s a d q e, arrows    lease one axis           Enter, f    press AUX1, AUX2 once
    t c                    transmitter, core's arc  Space       everything to rest, disarmed
"""

from __future__ import annotations

from bench.config import Profile
from bench.loop import NOTHING
from bench.messages import ZERO_TWIST, BodyTwist, TickInput
from bench.rc.transmitter import Sticks, Transmitter

KEY_LEASE_MS = 120
SILENT_HOLD_MS = 1000
"""The longest that a key is held without any event of the keyboard: longer than the longest delay before repeats."""
PULSE_MS = 60
"""How long a virtual switch is pressed: several frames of any transmitter that we know."""
POWER_STEP_PERCENT = 10
CORE_ARC = BodyTwist(0.2, 0.0, 0.5)
"""What the core asks for on request: a circle of radius 0.4 m, to the left."""

FORWARD, LEFT, TURN = 0, 1, 2
MOTION = {
    "w": (FORWARD, 1.0), "s": (FORWARD, -1.0), "up": (FORWARD, 1.0), "down": (FORWARD, -1.0),
    "a": (LEFT, 1.0), "d": (LEFT, -1.0), "left": (LEFT, 1.0), "right": (LEFT, -1.0),
    "q": (TURN, 1.0), "e": (TURN, -1.0),
}  # fmt: skip
"""Key -> axis and sense: forward, left and counter-clockwise are positive."""


class KeySticks:
    """Which way the sticks stand, from keys alone. `power_percent` is how far a key pushes its stick.

    `releases` says that the terminal reports when a key is let go.
    """

    def __init__(self, power_percent: int = 50) -> None:
        self.power_percent = power_percent
        self.releases = False
        self._lease_ticks, self._silent_ticks = KEY_LEASE_MS, SILENT_HOLD_MS
        self._until: dict[str, int] = {}  # the key pressed last stands last
        self._heard_tick = 0

    def set_rate(self, rate: float) -> None:
        """Simulated time runs so fast: a lease is never longer than its milliseconds, neither theirs nor the wall's."""
        self._lease_ticks = max(1, round(KEY_LEASE_MS * min(1.0, rate)))
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
            if now_tick < until:
                axis, sense = MOTION[key]
                axes[axis] = sense * power
        return Sticks(axes[FORWARD], axes[LEFT], axes[TURN])


class Pulse:
    """A virtual switch that is pressed for a moment."""

    def __init__(self, length_ticks: int) -> None:
        self._length = length_ticks
        self._from = self._to = 0

    def on(self, tick: int) -> bool:
        """Whether the switch is pressed in this tick."""
        return self._from <= tick < self._to

    def press(self, tick: int) -> None:
        """Press from now on; while a press is on or due, nothing."""
        if tick >= self._to:
            self._from, self._to = tick, tick + self._length

    def press_again(self, tick: int) -> int:
        """A press of its own even while another one is on: released first, so that there is an edge. When it ends."""
        wait = self._length if self.on(tick) else 0
        self._from, self._to = tick + wait, tick + wait + self._length
        return self._to

    def cancel(self) -> None:
        """Released, and nothing due."""
        self._from = self._to = 0


class Keyboard:
    """A person at the keys: `inputs` gives what enters each tick; the rest is called as keys come.

    `profile` is the transmitter that is played; None where the robot takes no RC. Methods named for keys return a
    sentence for the person where the key did not do what they may expect, and otherwise nothing.
    """

    def __init__(self, profile: Profile | None) -> None:
        self.sticks = KeySticks()
        self.transmitter = Transmitter(profile) if profile is not None else None
        self.core_asks = False
        self._period_ticks = profile.period_ms if profile is not None else 1
        pulse = max(PULSE_MS, 3 * self._period_ticks)
        self._aux1, self._aux2 = Pulse(pulse), Pulse(pulse)
        self._has_aux = (False, False)
        if profile is not None:
            self._has_aux = (profile.arming == "switch" and profile.aux1 is not None, profile.aux2 is not None)
        self._core_told = False
        self._stopping_until = 0
        self._heard: dict[str, int] = {}

    def inputs(self, tick: int) -> TickInput:
        """What the person, through transmitter and core, gives to this tick."""
        twist: BodyTwist | None = None
        if self.core_asks is not self._core_told:
            self._core_told = self.core_asks
            twist = CORE_ARC if self.core_asks else ZERO_TWIST
        rc = b""
        if self.transmitter is not None and tick % self._period_ticks == 0:  # between frames nobody looks at the sticks
            sticks = self.sticks.sticks(tick)
            rc = self.transmitter.step(tick, sticks._replace(aux1=self._aux1.on(tick), aux2=self._aux2.on(tick)))
        return TickInput(rc, twist) if rc or twist is not None else NOTHING

    def release(self) -> None:
        """Nobody is at the keys any more: the sticks spring back, the core stands. Switches stay as they are."""
        self.sticks.release()
        self.core_asks = False

    def press(self, key: str, now_tick: int, armed: bool) -> str:
        """One press or repeat of a key. `armed` is the base's state now, for Space."""
        if key in MOTION:
            if self.transmitter is None:
                return "this robot takes no RC; C lets the core drive"
            self.sticks.press(key, now_tick)
            if not self.transmitter.on:
                return "the transmitter is off; T switches it on"
            return "" if armed else "disarmed; Enter arms"
        if key == "space":
            return self.stop(now_tick, armed)
        # A key that comes again within its lease is still held: it acts once.
        held = now_tick - self._heard.get(key, -KEY_LEASE_MS) < KEY_LEASE_MS
        self._heard[key] = now_tick
        return "" if held else self._switch(key, now_tick)

    def stop(self, now_tick: int, armed: bool) -> str:
        """Everything to rest and, by the switch that the profile has for it, disarmed."""
        self.sticks.release()
        self.core_asks = False
        if self.transmitter is None:
            return "stopped: the core asks for nothing"
        if not self._has_aux[0]:
            self.transmitter.on = False
            return "stopped: transmitter off, because this profile has no arming switch; T switches it on"
        if armed:
            if now_tick >= self._stopping_until:
                self._stopping_until = self._aux1.press_again(now_tick)
        else:
            self._aux1.cancel()  # an arming press that has not left yet shall not
        return "stopped"

    def change_power(self, steps: int) -> str:
        """Push the sticks further, or less far: 10 to 100 percent."""
        power = self.sticks.power_percent + steps * POWER_STEP_PERCENT
        self.sticks.power_percent = max(POWER_STEP_PERCENT, min(100, power))
        return f"keys push the sticks to {self.sticks.power_percent} %"

    def _switch(self, key: str, now_tick: int) -> str:
        if key == "c":
            self.core_asks = not self.core_asks
            return "the core asks for an arc" if self.core_asks else "the core asks to stand"
        if self.transmitter is None:
            return "this robot takes no RC"
        if key == "t":
            self.transmitter.on = not self.transmitter.on
            self.sticks.release()
            return "transmitter on" if self.transmitter.on else "transmitter off"
        if not self.transmitter.on:
            return "the transmitter is off; T switches it on"
        pulse, there = (self._aux1, self._has_aux[0]) if key == "enter" else (self._aux2, self._has_aux[1])
        if there:
            pulse.press(now_tick)
            return ""
        return "this profile has no switch for that" + ("; it is armed by its link" if key == "enter" else "")
