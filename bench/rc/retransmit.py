"""An RC stream in another transmitter's words: frames are read as stick positions by one profile and sent by another.

What has no words in the other protocol is left out: telemetry, noise, channels that no stick or switch uses. A frame
that says failsafe is not sent either, so that the other receiver falls silent where the first one said so.
"""

from __future__ import annotations

from collections.abc import Mapping

from bench.config import Axis, Profile
from bench.messages import TICK_US, RcFrame
from bench.rc.transmitter import Sticks, Transmitter
from bench.rc_decode import decoder

PAUSE_US = 2000
"""Silence that ends a frame of the stream: its bytes have the time of their tick, so two ticks are the least."""
SILENT_TICKS = 100
"""After so long without a frame the other transmitter sends nothing until the next one."""


def retransmitted(stream: Mapping[int, bytes], read_by: Profile, sent_by: Profile) -> dict[int, bytes]:
    """Bytes by tick -> the bytes by tick of the other transmitter, at its own period."""
    if not stream:
        return {}
    reader, transmitter = decoder(read_by.protocol, PAUSE_US), Transmitter(sent_by)
    sticks: Sticks | None = None
    heard_tick, sent = 0, {}
    for tick in range(max(stream) + 1):
        events = reader.feed(stream.get(tick, b""), tick * TICK_US)
        for event in events:
            if isinstance(event, RcFrame):
                sticks = None if event.failsafe else sticks_of(event.channels, read_by)
                heard_tick = tick
        if sticks is not None and tick - heard_tick < SILENT_TICKS:
            frame = transmitter.step(tick, sticks)
            if frame:
                sent[tick] = frame
    return sent


def sticks_of(channels: tuple[int, ...], profile: Profile) -> Sticks:
    """Where the sticks stood that gave these raw channels: `Transmitter.channels` backwards."""
    return Sticks(
        forward=_deflection(channels, profile.forward),
        left=0.0 - _deflection(channels, profile.right),
        turn=0.0 - _deflection(channels, profile.clockwise),
        aux1=profile.aux1 is not None and profile.aux1.is_pressed(channels),
        aux2=profile.aux2 is not None and profile.aux2.is_pressed(channels),
    )


def _deflection(channels: tuple[int, ...], axis: Axis) -> float:
    value = (channels[axis.channel] - axis.middle) / axis.travel
    return max(-1.0, min(1.0, -value if axis.reversed else value))
