"""The transmitter in a person's hands: keys, mouse, gamepad in, RC bytes out by the front door. No Textual, no clock.

    w s a d q e, arrows    lease one axis           Enter, f    press AUX1, AUX2 once
    t c                    transmitter, core's arc  Space       everything to rest, disarmed
    m i                    mouse sticks, next source

One source has the sticks at a time: the keys with the mouse, a gamepad, or a real receiver, whose bytes go in as they
come. Space stops whatever drives; a gamepad's own stop button too.
"""

from __future__ import annotations

from bench.config import Profile
from bench.config.gamepads import GamepadMap
from bench.io.gamepad import Gamepad
from bench.io.receiver import Receiver
from bench.loop import NOTHING
from bench.messages import ZERO_TWIST, BodyTwist, TickInput
from bench.rc.transmitter import Sticks, Transmitter
from bench.screen.gamepad_sticks import GamepadSticks
from bench.screen.key_sticks import KEY_LEASE_MS, KeySticks
from bench.screen.motion import MOTION
from bench.screen.mouse_sticks import MouseSticks, Pad
from bench.screen.scene import Hands

PULSE_MS = 60
"""How long a virtual switch is pressed: several frames of any transmitter that we know."""
POWER_STEP_PERCENT = 10
CORE_ARC = BodyTwist(0.2, 0.0, 0.5)
"""What the core asks for on request: a circle of radius 0.4 m, to the left."""
KEYS, GAMEPAD, RECEIVER = "keys", "gamepad", "receiver"
FOREIGN_STOP = "sticks at rest, the core asks for nothing; whether it is armed only the base knows: T cuts its link"
REAL_CORE = "the core is a real one: nothing here makes it drive, or stand"
MARGIN_MS = 100
"""Between a receiver and our own transmitter nothing is sent until the link is lost, and so much longer."""


class Pulse:
    """A virtual switch that is pressed for a moment."""

    def __init__(self, length_ticks: int) -> None:
        self.length = length_ticks
        self._from = self._to = 0

    def on(self, tick: int) -> bool:
        """Whether the switch is pressed in this tick."""
        return self._from <= tick < self._to

    def press(self, tick: int) -> None:
        """Press from now on; while a press is on or due, nothing."""
        if not self._from - self.length <= tick < self._to:  # time may have gone back, to drive on from there
            self._from, self._to = tick, tick + self.length

    def press_again(self, tick: int) -> int:
        """A press of its own even while another one is on: released first, so that there is an edge. When it ends."""
        wait = self.length if self.on(tick) else 0
        self._from, self._to = tick + wait, tick + wait + self.length
        return self._to

    def cancel(self) -> None:
        """Released, and nothing due."""
        self._from = self._to = 0


class Keyboard:
    """A person at the keys: `inputs` gives what enters each tick; the rest is called as keys come.

    `profile` is the transmitter that is played; None where the robot takes no RC. Methods named for keys return a
    sentence for the person where the key did not do what they may expect, and otherwise nothing.
    """

    def __init__(
        self,
        profile: Profile | None,
        *,
        gamepad: tuple[Gamepad, GamepadMap] | None = None,
        receiver: Receiver | None = None,
        disarm_ms: int = 500,
        core_is_real: bool = False,
    ) -> None:
        self.sticks = KeySticks()
        self.mouse = MouseSticks()
        self.pad = gamepad[0] if gamepad is not None else None
        self.pad_sticks = GamepadSticks(gamepad[1]) if gamepad is not None else None
        self.receiver = receiver
        self.cut = False
        """Nothing of the receiver's is let through."""
        self.profile = profile
        self.sources = self._there()
        self.source = self.sources[-1]
        self._pad_was_lost = ""
        self._silent_until = 0
        self._silence_ticks = disarm_ms + MARGIN_MS
        self.transmitter = Transmitter(profile) if profile is not None else None
        self.core_is_real = core_is_real
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
        if self.source == RECEIVER or self._is_silent(tick):
            rc = self._received(tick)
        elif self.transmitter is not None and tick % self._period_ticks == 0:
            sticks = self._sticks(tick)  # between frames nobody looks at them
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
        if self.pad_sticks is not None:
            self.pad_sticks.release()

    def look(self, now_tick: int, armed: bool | None, paused: bool = False) -> str:
        """Once a frame: what gamepad and receiver say. A sentence where something has changed."""
        said = self.receiver.look() if self.receiver is not None else ""
        return self._look_at_pad(now_tick, armed, paused) or said

    def next_source(self, now_tick: int) -> str:
        """Give the sticks to the next source. A receiver's switches may stand anyhow: the link is lost in between."""
        if len(self.sources) == 1:
            return "there are only the keys and the mouse; --gamepad and --rc bring more"
        before = self.source
        self.source = self.sources[(self.sources.index(before) + 1) % len(self.sources)]
        self.let_go()
        if RECEIVER in (before, self.source):
            self._silent_until = now_tick + self._silence_ticks
            self._aux1.cancel()
            self._aux2.cancel()
        return f"the {self.source} {'have' if self.source == KEYS else 'has'} the sticks"

    def point(self, pressed: bool, x: int, y: int, pad: Pad, now_tick: int, armed: bool | None) -> str:
        """The mouse's button has gone down on that cell, or the mouse has moved there."""
        if not pressed:
            self.mouse.drag(x, y, pad, now_tick)
            return ""
        taken = self.mouse.press(x, y, pad, now_tick)
        return "disarmed; Enter arms" if taken and armed is False else ""

    def alive(self, now_tick: int) -> None:
        """The terminal is there, and what was held still is."""
        self.sticks.alive(now_tick)
        if self.sticks.proven:
            self.mouse.alive(now_tick)

    def set_time(self, rate: float, lead_ticks: int) -> None:
        """Simulated time runs so fast, and what is done now counts so many ticks later."""
        self.sticks.set_time(rate, lead_ticks)
        self.mouse.set_time(rate, lead_ticks)

    def hands(self, now_tick: int) -> Hands:
        """What is to be shown of all this."""
        sticks, profile = self._sticks(now_tick), self.profile
        return Hands(
            self.sticks.power_percent,
            self.transmitter.on if self.transmitter is not None else None,
            None if self.core_is_real else self.core_asks,
            arms=self._has_aux[0] and self.source != RECEIVER,
            releases=self.sticks.releases,
            source=self.source,
            source_state=self._state(),
            pad=(sticks.forward, sticks.left, sticks.turn) if self.mouse.on else None,
            curve=_curve(profile) if profile is not None else "",
        )

    def _sticks(self, tick: int) -> Sticks:
        """Where the source in use holds them. Of keys and mouse, what the mouse holds counts."""
        if self.source == GAMEPAD and self.pad_sticks is not None:
            return self.pad_sticks.sticks()
        if self.source == RECEIVER:
            return Sticks()
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
        if self.source == RECEIVER:
            self.cut = True  # nobody knows how its sticks and switches stand

    def set_like(self, other: Keyboard) -> None:
        """Take over what a person has set at another robot's keyboard: how far keys push, the mouse, the terminal."""
        self.sticks.power_percent, self.sticks.releases = other.sticks.power_percent, other.sticks.releases
        self.mouse.on = other.mouse.on
        self.pad, self.pad_sticks, self.receiver = other.pad, other.pad_sticks, other.receiver
        self.sources = self._there()
        self.source = other.source if other.source in self.sources else KEYS
        self.cut = self.receiver is not None  # what it says now was not meant for that instant
        self.let_go()

    def _there(self) -> tuple[str, ...]:
        """The sources that can drive this robot. A receiver speaks one protocol."""
        profile = self.profile
        if profile is None:
            return (KEYS,)
        hears = self.receiver is not None and self.receiver.protocol == profile.protocol
        there = ((KEYS, True), (GAMEPAD, self.pad is not None), (RECEIVER, hears))
        return tuple(name for name, is_there in there if is_there)

    def press(self, key: str, now_tick: int, armed: bool | None) -> str:
        """One press or repeat of a key. `armed` is the base's state now; None where only the base knows."""
        if key in MOTION:
            if self.transmitter is None:
                return "this robot takes no RC; " + (REAL_CORE if self.core_is_real else "C lets the core drive")
            if self.source != KEYS:
                return f"the {self.source} has the sticks; I gives them to the next source"
            self.sticks.press(key, now_tick)
            if not self.transmitter.on:
                return "the transmitter is off; T switches it on"
            return "disarmed; Enter arms" if armed is False else ""
        if key == "space":
            return self.stop(now_tick, armed)
        # A key that comes again within its lease is still held: it acts once.
        held = 0 <= now_tick - self._heard.get(key, -KEY_LEASE_MS) < KEY_LEASE_MS
        self._heard[key] = now_tick
        return "" if held else self._switch(key, now_tick)

    def stop(self, now_tick: int, armed: bool | None) -> str:
        """Everything to rest and, by the switch that the profile has for it, disarmed."""
        self.let_go()
        self.core_asks = False
        if self.source == RECEIVER:
            self.cut = True
            return "stopped: the receiver is cut off; Enter lets it through again"
        if self.transmitter is None:
            return REAL_CORE if self.core_is_real else "stopped: the core asks for nothing"
        if not self._has_aux[0]:
            self.transmitter.on = False
            return "stopped: transmitter off, because this profile has no arming switch; T switches it on"
        if armed:
            if not 0 < self._stopping_until - now_tick <= 2 * self._aux1.length:
                self._stopping_until = self._aux1.press_again(now_tick)
        else:
            self._aux1.cancel()  # an arming press that has not left yet shall not
        return FOREIGN_STOP if armed is None else "stopped"

    def abandon(self, now_tick: int, armed: bool | None) -> None:
        """Nobody is there: disarmed, or where only the base knows whether it is armed, its link cut."""
        if armed is not False:
            self.stop(now_tick, armed)
        if armed is None and self.transmitter is not None:
            self.transmitter.on = False

    def change_power(self, steps: int) -> str:
        """Push the sticks further, or less far: 10 to 100 percent."""
        power = self.sticks.power_percent + steps * POWER_STEP_PERCENT
        self.sticks.power_percent = max(POWER_STEP_PERCENT, min(100, power))
        return f"keys push the sticks to {self.sticks.power_percent} %"

    def _received(self, tick: int) -> bytes:
        """The receiver's bytes as they came, unless they are kept from the robot."""
        if self.receiver is None:
            return b""
        if self.source == RECEIVER and not self.cut and not self._is_silent(tick):
            return self.receiver.read(tick)
        self.receiver.forget()
        return b""

    def _is_silent(self, tick: int) -> bool:
        return 0 < self._silent_until - tick <= self._silence_ticks

    def _admit(self) -> str:
        """Let the receiver's bytes through again after a stop."""
        if not self.cut:
            return "the receiver arms by its own switch"
        self.cut = False
        return "the receiver is let through; arm by its own switch"

    def _look_at_pad(self, now_tick: int, armed: bool | None, paused: bool) -> str:
        pad, sticks = self.pad, self.pad_sticks
        if pad is None or sticks is None:
            return ""
        pad.revive()
        for key in sticks.feed(pad.read()):
            if key == "space":
                self.stop(now_tick, armed)
            elif self.source == GAMEPAD and not paused:
                self._switch(key, now_tick)
        if pad.lost:
            sticks.forget()
        said = ""
        if bool(pad.lost) is not bool(self._pad_was_lost):
            said = f"gamepad {pad.name}: {pad.lost}" if pad.lost else f"gamepad {pad.name}: there"
        self._pad_was_lost = pad.lost
        return said

    def _state(self) -> str:
        """How the source in use is."""
        if self.source == GAMEPAD and self.pad is not None and self.pad_sticks is not None:
            at_rest_first = "let its sticks go first" if self.pad_sticks.at_rest_first else ""
            return self.pad.lost or at_rest_first or self.pad_sticks.lacking(self.pad.axes, self.pad.buttons)
        if self.source == RECEIVER and self.receiver is not None:
            return "cut off; Enter lets it through" if self.cut else self.receiver.port.lost
        return "held until let go" if self.sticks.releases else f"each worth {KEY_LEASE_MS} ms"

    def close(self) -> None:
        """Give gamepad and receiver back."""
        for device in (self.pad, self.receiver):
            if device is not None:
                device.close()

    def _show_pad(self) -> str:
        """The mouse's sticks, there or not."""
        if self.transmitter is None:
            return "this robot takes no RC"
        self.mouse.release()
        self.mouse.on = not self.mouse.on
        return "drag the sticks; M gives the mouse back" if self.mouse.on else "the mouse selects text again"

    def _switch(self, key: str, now_tick: int) -> str:
        if key == "m":
            return self._show_pad()
        if key == "i":
            return self.next_source(now_tick)
        if key == "c" and self.core_is_real:
            return REAL_CORE
        if key == "c":
            self.core_asks = not self.core_asks
            return "the core asks for an arc" if self.core_asks else "the core asks to stand"
        if self.transmitter is None:
            return "this robot takes no RC"
        if self.source == RECEIVER:
            return self._admit() if key == "enter" else "the receiver has the sticks, and its own switches"
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


def _curve(profile: Profile) -> str:
    """What the base makes of a stick's way."""
    bend = f"expo {profile.expo:.2f}" if profile.expo else "linear"
    return f"{bend}, dead-band {100 * profile.dead_band:.0f} %"
