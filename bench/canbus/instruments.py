"""What else reports on the motors' bus: encoder boards of dead wheels, and a gyro.

                 byte  0      1      2      3      4      5      6      7
    0x200+n encoder  | axle angle  | axle speed  | current 0   |  0   |  0   |   an ESC's report, without a motor
    0x300+n gyro     | yaw rate    | heading, 2^32 counts a turn             |   six bytes; a frame of our own

The encoder boards speak as a C610 does and share its numbers 1 to 8 with the ESCs. The gyro sums its rate itself, so
that a lost frame loses no turn; its heading starts anywhere and wraps with its 32 bits. docs/gyro.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from bench.canbus.bits import frame_bits, least_bits, worst_bits
from bench.canbus.c610 import CONTROLLER, FAMILY, feedback
from bench.canbus.streams import Lengths, Stream, feedback_lengths
from bench.canbus.table import Family, Field, Message

GYRO_ID = 0x300
"""Plus the gyro's number, 1 to 8."""
GYROS = 8
HEADING_COUNTS = 1 << 32
"""Counts in one turn: the 32 bits wrap with it."""
RATE_PER_RADPS = 1000
"""Counts for 1 rad/s."""


def gyro(number: int) -> Message:
    """The report of gyro 1 to 8. Raises ValueError for any other number."""
    if not 1 <= number <= GYROS:
        raise ValueError(f"gyro {number} outside 1..{GYROS}")
    return Message(
        name=f"Gyro_{number}",
        can_id=GYRO_ID + number,
        sender=f"Gyro_{number}",
        receivers=(CONTROLLER,),
        length=6,
        period_ms=1,
        about="How fast the robot turns, and how far it has turned: counter-clockwise positive.",
        fields=(
            Field("rate", 0, 2, True, -32768, 32767, "mradps", "rad/s", 1.0 / RATE_PER_RADPS, "yaw rate"),
            Field(
                "heading", 2, 4, False, 0, HEADING_COUNTS - 1, "counts", "rad", math.tau / HEADING_COUNTS,
                "sum of the rate, wraps after a turn",
            ),
        ),
    )  # fmt: skip


def encoder(number: int) -> Message:
    """The report of a dead wheel's encoder board, which has the number of an ESC, 1 to 8."""
    current = Field("current", 4, 2, True, -32768, 32767, "ma", "mA", 1.0, "no motor: sent as 0")
    board = f"Encoder_{number}"
    return replace(
        feedback(number, kind="Encoder", current=current),
        name=board,
        sender=board,
        about=f"What dead wheel {number} does: angle and speed of its encoder.",
    )


@lru_cache(maxsize=64)
def with_instruments(family: Family, encoders: tuple[int, ...], gyro_number: int | None) -> Family:
    """The motors' messages, with encoder boards in place of the ESCs that have these numbers, and a gyro's."""
    reports = tuple(
        encoder(number) if number in encoders else message for number, message in enumerate(family.feedback, 1)
    )
    others = family.others if gyro_number is None else (*family.others, gyro(gyro_number))
    return replace(family, feedback=reports, others=others)


def instrument_streams(encoders: Sequence[int], gyro_number: int | None, hz: int = 1000) -> list[Stream]:
    """What they put on the bus, for a budget of it."""
    found = []
    for number in encoders:
        message = encoder(number)
        found.append(Stream(message.can_id, message.name, hz, feedback_lengths(FAMILY)))
    if gyro_number is not None:
        message = gyro(gyro_number)
        found.append(Stream(message.can_id, message.name, hz, _gyro_lengths(message)))
    return found


_SAMPLES = 256
_TURNING_MRADPS = 2000


def _gyro_lengths(message: Message) -> Lengths:
    """Typical: any heading, within 2 rad/s. At rest: any heading, no rate."""
    typical = resting = 0
    for sample in range(_SAMPLES):
        # Multiples of these spread evenly over 0 to 1, independently of each other.
        heading = int((sample + 0.5) * 0.6180339887498949 % 1.0 * HEADING_COUNTS)
        rate = round(((sample + 0.5) * 0.7548776662466927 % 1.0 * 2.0 - 1.0) * _TURNING_MRADPS)
        typical += frame_bits(message.can_id, message.encode((rate, heading)))
        resting += frame_bits(message.can_id, message.encode((0, heading)))
    return Lengths(least_bits(message.length), typical / _SAMPLES, resting / _SAMPLES, worst_bits(message.length))
