"""What a SLAMWARE slave asks of the robot that carries it, and only while it answers a request.

`Senses` is everything around the base: battery, distances, contacts, the dock. `Motion` is its wheels: how they moved,
and how they shall. Both stand for a robot that has none of it; real ones say more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bench.messages import BodyTwist
from bench.slamware.health import Fault
from bench.slamware.payloads import Displacement
from bench.slamware.sense_payloads import Beacons, Power

FULL_BATTERY = Power(100)
DOCK_BEACONS = 3
"""Beacons of the vendor's dock: left, main, right."""
NOWHERE = Displacement(0.0, 0.0, 0.0)


class Senses:
    """A robot that senses nothing; its battery is what it is set to."""

    def __init__(self) -> None:
        self.battery = FULL_BATTERY

    def power(self) -> Power:
        """State of the battery and where current comes from."""
        return self.battery

    def ranges_m(self) -> Sequence[float]:
        """What each range sensor measures, in the order of the configuration."""
        return ()

    def contacts(self) -> Sequence[bool]:
        """Which bumpers are pressed, in the order of the configuration; cliff sensors behind them."""
        return ()

    def beacons(self) -> Beacons:
        """Which of the dock's beacons each receiver sees."""
        return Beacons(DOCK_BEACONS, ())


class Wanted(NamedTuple):
    """What a core wants of the wheels."""

    twist: BodyTwist
    slip_radps: tuple[float, ...] = ()
    """Wheel speeds beyond what the twist needs, in wheel order; empty where they all agree with it."""


class Motion:
    """Wheels that cannot be asked one by one and do not move."""

    wheel_count = 0
    """How many wheels 0x31 and 0x40 can speak of; 0 refuses both."""

    def take_increment(self) -> Displacement:
        """Displacement since the last call."""
        return NOWHERE

    def take_second_increment(self) -> Displacement:
        """The same, told apart from the calls of the other one: 0x31 must not take motion away from 0x41."""
        return NOWHERE

    def rim_distances_m(self) -> Sequence[float]:
        """How far each wheel has rolled since the base was powered."""
        return (0.0,) * self.wheel_count

    def status(self) -> int:
        """Status bits of the answers to 0x31 and 0x41."""
        return 0

    def follow_twist(self, twist: BodyTwist) -> Wanted:
        """A velocity that a core asks for."""
        return Wanted(twist)

    def follow_rims(self, speeds_mps: Sequence[float]) -> Wanted | None:
        """Rim speeds that a core asks for, `wheel_count` of them; None leaves everything as it is."""
        return None

    def faults(self, tick: int) -> Sequence[Fault]:
        """What is wrong with the wheels at this moment."""
        return ()
