"""Which ESC turns which wheel, in which sense, through which gear; where its current stands in the command frames.

Both ends of the motors' wire read this one table, so that a sign is applied once on the way out and once on the way in.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from bench.canbus.c610 import COMMAND_IDS, COUNTS, FAMILY, GROUP
from bench.canbus.table import Family
from bench.config import Robot

RPM_PER_RADPS = 30.0 / math.pi


class Wiring:
    """Which ESC turns which wheel and in which sense: the one table that knows `direction` and the gear."""

    __slots__ = (
        "can_ids", "command_ids", "commands", "counts_per_rad", "outputs", "rad_per_count", "raw_per_a",
        "rpm_per_radps", "slots",
    )  # fmt: skip

    def __init__(self, robot: Robot, family: Family = FAMILY) -> None:
        wheels = robot.wheels
        self.can_ids = tuple(wheel.can_id for wheel in wheels)
        self.raw_per_a = tuple(wheel.direction * family.raw_per_a for wheel in wheels)
        self.counts_per_rad = tuple(wheel.direction * wheel.gear * COUNTS / (2.0 * math.pi) for wheel in wheels)
        self.rad_per_count = tuple(1.0 / counts for counts in self.counts_per_rad)
        self.rpm_per_radps = tuple(wheel.direction * wheel.gear * RPM_PER_RADPS for wheel in wheels)
        # Each wheel's place in its command frame: (index of the frame among those sent, slot 0 to 3).
        groups = sorted({(can_id - 1) // GROUP for can_id in self.can_ids})
        self.command_ids = tuple(COMMAND_IDS[group] for group in groups)
        self.slots = tuple((groups.index((can_id - 1) // GROUP), (can_id - 1) % GROUP) for can_id in self.can_ids)
        # Where currents go, in the order of their places: wheel, raw per A. Slots of absent motors are padding.
        places = sorted((place, wheel) for wheel, place in enumerate(self.slots))
        self.outputs = tuple((wheel, self.raw_per_a[wheel]) for _, wheel in places)
        self.commands = _command_layouts(self.command_ids, [place for place, _ in places])


def _command_layouts(
    command_ids: Sequence[int], places: Sequence[tuple[int, int]]
) -> tuple[tuple[int, struct.Struct, int, int], ...]:
    """For each command frame: identifier, layout, and which of the currents, in the order of `places`, are in it."""
    layouts = []
    start = 0
    for frame, can_id in enumerate(command_ids):
        codes = ["h" if (frame, slot) in places else "2x" for slot in range(GROUP)]
        end = start + codes.count("h")
        layouts.append((can_id, struct.Struct(">" + "".join(codes)), start, end))
        start = end
    return tuple(layouts)
