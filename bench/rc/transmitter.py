"""A transmitter: stick positions in, RC frames at its own period out. The front door for keys, timelines, gamepads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from bench import rc_decode
from bench.config import Axis, Button, Profile


class Sticks(NamedTuple):
    """Where a driver holds the sticks: forward, left and counter-clockwise from -1 to 1, and the two switches."""

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    aux1: bool = False
    aux2: bool = False


AT_REST = Sticks()


class Transmitter:
    """Encodes stick positions by a profile. `step` once a tick; `on = False` is a transmitter switched off."""

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        self.on = True
        self._limits = rc_decode.channel_limits(profile.protocol)
        # Sticks that no axis uses stand in the middle, switches that no button uses are released.
        self._neutral = [profile.forward.middle] * 4 + [max(0, low) for low, _ in self._limits[4:]]

    def step(self, tick: int, sticks: Sticks) -> bytes:
        """The bytes that leave in this tick: one frame each `period_ms`, nothing between."""
        if not self.on or tick % self.profile.period_ms:
            return b""
        return rc_decode.encode(self.profile.protocol, self.channels(sticks))

    def channels(self, sticks: Sticks) -> tuple[int, ...]:
        """Raw wire values for stick positions."""
        profile = self.profile
        channels = list(self._neutral)
        # A profile's sticks count right and clockwise, as hands do; ours count left and counter-clockwise.
        axes = ((profile.forward, sticks.forward), (profile.right, -sticks.left), (profile.clockwise, -sticks.turn))
        for axis, value in axes:
            channels[axis.channel] = self._raw(axis, value)
        for button, pressed in ((profile.aux1, sticks.aux1), (profile.aux2, sticks.aux2)):
            if button is not None:
                channels[button.channel] = self._button_raw(button, pressed)
        return tuple(channels)

    def _raw(self, axis: Axis, value: float) -> int:
        value = max(-1.0, min(1.0, value))
        raw = axis.middle + round(-value * axis.travel if axis.reversed else value * axis.travel)
        low, high = self._limits[axis.channel]
        return max(low, min(high, raw))

    def _button_raw(self, button: Button, pressed: bool) -> int:
        if pressed:
            return button.pressed_from
        low, high = self._limits[button.channel]
        return max(low, min(high, button.pressed_from + (1 if button.reversed else -1)))


def sent_by_tick(profile: Profile, changes: Iterable[tuple[int, Sticks]], ticks: int) -> dict[int, bytes]:
    """What leaves in each tick that has a frame, while a driver changes the sticks at these ticks."""
    transmitter, sticks, at = Transmitter(profile), AT_REST, dict(changes)
    sent = {}
    for tick in range(ticks):
        sticks = at.get(tick, sticks)
        frame = transmitter.step(tick, sticks)
        if frame:
            sent[tick] = frame
    return sent
