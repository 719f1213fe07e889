"""The last line before a port with motors: who may send there at all, and what may leave, whatever a base commands."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from bench.config import Robot
from bench.errors import UsageError
from bench.io.address import can_address
from bench.messages import CanFrame
from bench.motors import family

_WORDS = struct.Struct(">hhhh")


def refuse_unarmed(option: str, address: str, armed: bool) -> None:
    """Raise UsageError where real motors may hang on a bus and nobody has said that they may move."""
    if not armed and not can_address(option, address, outside=True).is_harmless:
        raise UsageError(f"{option} {address}: may move real motors; lift the robot off the floor and add --arm")


def refuse_arming_by_link(option: str, address: str, robot: Robot) -> None:
    """Raise UsageError where the robot's transmitter would arm real motors by being there."""
    if (
        robot.rc is not None
        and robot.rc.arming != "switch"
        and not can_address(option, address, outside=True).is_harmless
    ):
        raise UsageError(
            f"{option} {address}: the profile {robot.rc.name} arms by its link alone; give one with a switch"
        )


class Limiter:
    """Lets currents within the robot's limit pass, and nothing that is no command. `stop` is no current for anybody."""

    def __init__(self, robot: Robot) -> None:
        known = family(robot)
        self.limit_raw = math.floor(robot.limits.current_a * known.raw_per_a)
        self.clamped = self.refused = 0
        """Frames."""
        ids = {wheel.can_id for wheel in robot.wheels}
        groups = sorted({(can_id - 1) // 4 for can_id in ids})
        self._commands = {known.commands[group].can_id: group for group in groups}
        self._slots = {
            command: tuple(group * 4 + slot + 1 in ids for slot in range(4))
            for command, group in self._commands.items()
        }
        self._others = {message.can_id: message.length for message in known.others}
        self.stop = tuple((can_id, bytes(8)) for can_id in self._commands)

    def __call__(self, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """What may leave."""
        passed = []
        for can_id, data in frames:
            if can_id in self._commands and len(data) == 8:
                passed.append((can_id, self._limited(can_id, data)))
            elif self._others.get(can_id) == len(data):
                passed.append((can_id, data))
            else:
                self.refused += 1
        return tuple(passed)

    def _limited(self, can_id: int, data: bytes) -> bytes:
        most, slots = self.limit_raw, self._slots[can_id]
        given = _WORDS.unpack(data)
        # Slots of motors that are not this robot's stay empty: somebody else's may hang there.
        kept = [max(-most, min(most, raw)) if mine else 0 for raw, mine in zip(given, slots, strict=True)]
        limited = _WORDS.pack(*kept)
        self.clamped += limited != data
        return limited
