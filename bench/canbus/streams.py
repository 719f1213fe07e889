"""What is on a bus of motors: who sends what, how often, and how long such frames are on the wire.

Four lengths of a frame count: without any stuff bit (least), of a robot that drives (typical), of one at rest (zeros
stuff heavily), and the bound that no frame can exceed (worst).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from bench.canbus.bits import frame_bits, least_bits, worst_bits
from bench.canbus.c610 import GROUP, gm6020_of
from bench.canbus.table import Family, Field, Message

SAMPLES = 512
SPEED_RPM = 6000
CURRENT_A = 2.0
BUSY_SLOTS = 3
"""A typical frame: any angle, rotor speed within +-6000 rpm, currents within +-2 A, three motors in a command."""


class Lengths(NamedTuple):
    """Bits on the wire, gap included."""

    least: int
    typical: float
    resting: float
    worst: int


class Stream(NamedTuple):
    """One message that somebody sends regularly."""

    can_id: int
    name: str
    hz: int
    bits: Lengths


def streams(family: Family, numbers: Sequence[int], *, feedback_hz: int = 1000, command_hz: int = 1000) -> list[Stream]:
    """What a controller and these ESCs (numbers 1 to 8) send: one command frame a group, one report each."""
    found = []
    for group, message in enumerate(family.commands):
        if any((number - 1) // GROUP == group for number in numbers):
            found.append(Stream(message.can_id, message.name, command_hz, command_lengths(family, group)))
    for number in numbers:
        message = family.feedback[number - 1]
        found.append(Stream(message.can_id, message.name, feedback_hz, feedback_lengths(family)))
    return found


def other_stream(can_id: int, hz: int, length: int = 8) -> Stream:
    """Something else on the bus, of which only identifier, rate and length are known."""
    gm6020 = gm6020_of(can_id)
    least, worst = least_bits(length), worst_bits(length)
    middle = (least + worst) / 2
    name = f"GM6020 {gm6020} or the like" if gm6020 is not None else "other"
    return Stream(can_id, name, hz, Lengths(least, middle, middle, worst))


@lru_cache(maxsize=64)
def feedback_lengths(family: Family) -> Lengths:
    """A report of this family: means over all eight identifiers."""
    typical, resting = [], []
    for sample in range(SAMPLES):
        for message in family.feedback:
            typical.append(_bits(message, _driving(message, family, sample, len(message.variables))))
            resting.append(_bits(message, _resting(message, sample)))
    return Lengths(least_bits(8), _mean(typical), _mean(resting), worst_bits(8))


@lru_cache(maxsize=64)
def command_lengths(family: Family, group: int) -> Lengths:
    """A command of this family. Typical: as group 1 to 4 with three motors; at rest: this very frame, all zeros."""
    message = family.commands[0]
    typical = [_bits(message, _driving(message, family, sample, BUSY_SLOTS)) for sample in range(SAMPLES)]
    resting = frame_bits(family.commands[group].can_id, bytes(8))
    return Lengths(least_bits(8), _mean(typical), float(resting), worst_bits(8))


# Multiples of these spread evenly over 0 to 1, independently of each other: plausible values without a random number.
_SPREADS = (0.6180339887498949, 0.7548776662466927, 0.5698402909980532, 0.8191725133961645, 0.6710436067037893)


def _driving(message: Message, family: Family, sample: int, busy: int) -> list[int]:
    """The sample's values; fields from `busy` on are 0."""
    values = []
    for place, one in enumerate(message.variables[:busy]):
        share = (sample + 0.5) * _SPREADS[place] % 1.0
        low, high = _span(one, family)
        values.append(round(low + share * (high - low)))
    return values + [0] * (len(message.variables) - len(values))


def _resting(message: Message, sample: int) -> list[int]:
    """Any angle, no speed, no current; temperatures of a cool room, no error."""
    share = (sample + 0.5) * _SPREADS[0] % 1.0
    return [
        int(share * (one.high + 1)) if one.name == "angle" else _IDLE.get(one.suffix, 0) for one in message.variables
    ]


_IDLE = {"degc": 25}


def _span(one: Field, family: Family) -> tuple[float, float]:
    """Which values of a field are typical."""
    if one.name == "angle":
        return one.low - 0.5, one.high + 0.49
    if one.name == "speed":
        return -SPEED_RPM, SPEED_RPM
    if one.name.startswith("current"):
        return -CURRENT_A * family.raw_per_a, CURRENT_A * family.raw_per_a
    if one.suffix == "degc":
        return 25, 60
    return 1, 1  # a state: on


def _bits(message: Message, values: Sequence[int]) -> int:
    return frame_bits(message.can_id, message.encode(values))


def _mean(values: Sequence[int]) -> float:
    return sum(values) / len(values)
