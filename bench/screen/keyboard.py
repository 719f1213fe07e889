"""The transmitter in a person's hands: keys, mouse, gamepad in, RC bytes out by the front door. No Textual, no clock.

    w s a d q e, arrows    lease one axis           Enter, f    press AUX1, AUX2 once
    t c                    transmitter, core's arc  Space       everything to rest, disarmed
    m i                    mouse sticks, next source

One source has the sticks at a time: the keys with the mouse, a gamepad, or a real receiver, whose bytes go in as they
come. Space stops whatever drives; a gamepad's own stop button too.
"""

from __future__ import annotations

from bench.config import Profile
from bench.loop import NOTHING
from bench.messages import ZERO_TWIST, BodyTwist, TickInput
from bench.rc.transmitter import Sticks, Transmitter
from bench.screen.key_sticks import KEY_LEASE_MS, MOTION, KeySticks
from bench.screen.mouse_sticks import MouseSticks, Pad
from bench.screen.scene import Hands

PULSE_MS = 60
"""How long a virtual switch is pressed: several frames of any transmitter that we know."""
POWER_STEP_PERCENT = 10
CORE_ARC = BodyTwist(0.2, 0.0, 0.5)
"""What the core asks for on request: a circle of radius 0.4 m, to the left."""
KEYS = "keys"


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
        self.mouse = MouseSticks()
        self.source = KEYS
        self.profile = profile
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
            sticks = self._sticks(tick)
            rc = self.transmitter.step(tick, sticks._replace(aux1=self._aux1.on(tick), aux2=self._aux2.on(tick)))
        return TickInput(rc, twist) if rc or twist is not None else NOTHING

    def release(self) -> None:
        """Nobody is there any more: the sticks spring back, the core stands. Switches stay as they are."""
        self.let_go()
        self.core_asks = False

    def let_go(self) -> None:
        """The sticks spring back."""
        self.sticks.release()
        self.mouse.release()

    def point(self, pressed: bool, x: int, y: int, pad: Pad, now_tick: int, armed: bool) -> str:
        """The mouse's button has gone down on that cell, or the mouse has moved there."""
        if not pressed:
            self.mouse.drag(x, y, pad, now_tick)
            return ""
        taken = self.mouse.press(x, y, pad, now_tick)
        return "disarmed; Enter arms" if taken and not armed else ""

    def alive(self, now_tick: int) -> None:
        """The terminal is there, and what was held still is."""
        self.sticks.alive(now_tick)
        if self.sticks.proven:
            self.mouse.alive(now_tick)

    def set_rate(self, rate: float) -> None:
        """Simulated time runs so fast."""
        self.sticks.set_rate(rate)
        self.mouse.set_rate(rate)

    def hands(self, now_tick: int) -> Hands:
        """What is to be shown of all this."""
        sticks, profile = self._sticks(now_tick), self.profile
        return Hands(
            self.sticks.power_percent,
            self.transmitter.on if self.transmitter is not None else None,
            self.core_asks,
            releases=self.sticks.releases,
            source=self.source,
            pad=(sticks.forward, sticks.left, sticks.turn) if self.mouse.on else None,
            curve=f"expo {profile.expo:.2f}, dead-band {100 * profile.dead_band:.0f} %" if profile is not None else "",
        )

    def _sticks(self, tick: int) -> Sticks:
        """Where the source in use holds them. Of keys and mouse, what the mouse holds counts."""
        keys, mouse = self.sticks.sticks(tick), self.mouse.sticks(tick, self.sticks.power_percent)
        return Sticks(mouse.forward or keys.forward, mouse.left or keys.left, mouse.turn or keys.turn)

    def start_over(self) -> None:
        """Time has gone to another instant: hands off, no switch pressed or due, and the core is told to stand."""
        self.let_go()
        for pulse in (self._aux1, self._aux2):
            pulse.cancel()
        self._stopping_until = 0
        self._heard.clear()
        self.core_asks, self._core_told = False, True

    def set_like(self, other: Keyboard, rate: float) -> None:
        """Take over what a person has set at another robot's keyboard: how far keys push, the mouse, the terminal."""
        self.sticks.power_percent, self.sticks.releases = other.sticks.power_percent, other.sticks.releases
        self.mouse.on = other.mouse.on
        self.set_rate(rate)

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
        self.let_go()
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

    def _show_pad(self) -> str:
        """The mouse's sticks, there or not."""
        if self.transmitter is None:
            return "this robot takes no RC"
        self.mouse.release()
        self.mouse.on = not self.mouse.on
        return "drag the sticks; M gives the mouse back" if self.mouse.on else "the mouse is the terminal's"

    def _switch(self, key: str, now_tick: int) -> str:
        if key == "m":
            return self._show_pad()
        if key == "c":
            self.core_asks = not self.core_asks
            return "the core asks for an arc" if self.core_asks else "the core asks to stand"
        if self.transmitter is None:
            return "this robot takes no RC"
        if key == "t":
            self.transmitter.on = not self.transmitter.on
            self.let_go()
            return "transmitter on" if self.transmitter.on else "transmitter off"
        if not self.transmitter.on:
            return "the transmitter is off; T switches it on"
        pulse, there = (self._aux1, self._has_aux[0]) if key == "enter" else (self._aux2, self._has_aux[1])
        if there:
            pulse.press(now_tick)
            return ""
        return "this profile has no switch for that" + ("; it is armed by its link" if key == "enter" else "")
