"""The machine of each fault, and those that change a piece within its tick."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import partial
from typing import Any

from bench.check.faults import FRAME_KINDS, Fault
from bench.check.faulty.keeping import Delay, FrozenFrames, FrozenPieces, Stall, Stuck, Swap
from bench.check.faulty.pieces import Frames, Machine
from bench.check.faulty.rc_frames import WholeFrames
from bench.config import Robot
from bench.motors import family

OVER_CURRENT = b"\x0a"
"""Byte 7 of a DM3519's feedback: `bench.canbus.dm3519.ERRORS`."""


def machine_of(fault: Fault, robot: Robot, chance: random.Random) -> Machine:
    """What a fault does to a wire: (tick, piece, active) -> piece. Objects and no closures: an instant can be kept."""
    if fault.wire in ("esc", "plant"):
        return _untouched
    if fault.wire in ("command", "feedback"):
        return _bus_machine(fault, robot, chance)
    if fault.wire == "rc" and fault.kind in FRAME_KINDS:
        assert robot.rc is not None
        return WholeFrames(fault.kind, robot.rc.protocol)
    return _holder(fault, b"") or _Serial(fault, chance)


def _bus_machine(fault: Fault, robot: Robot, chance: random.Random) -> Machine:
    own: dict[str, Callable[[], Machine]] = {
        "stuck": Stuck, "freeze": FrozenFrames, "flag": partial(_ErrorFlag, robot)
    }  # fmt: skip
    machine = own[fault.kind]() if fault.kind in own else _holder(fault, ()) or _Bus(fault, chance)
    if fault.esc is None:
        return machine
    number = robot.wheels[fault.esc - 1].can_id
    messages = family(robot)
    return _Only({messages.feedback[number - 1].can_id, messages.commands[(number - 1) // 4].can_id}, machine)


def _holder(fault: Fault, empty: bytes | Frames) -> Machine | None:
    """The machines that keep pieces for later."""
    if fault.kind == "delay":
        return Delay(fault.ms, empty)
    if fault.kind == "stall":
        return Stall(empty)
    if fault.kind == "freeze":
        return FrozenPieces()
    return Swap(empty) if fault.kind == "reorder" else None


def _untouched(_tick: int, piece: Any, _active: bool) -> Any:
    return piece


class _Only:
    """The frames of one ESC through a machine; the others as they are, before them."""

    def __init__(self, ids: set[int], machine: Machine) -> None:
        self._ids, self._machine = ids, machine

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        ids = self._ids
        chosen = tuple(frame for frame in frames if frame[0] in ids)
        left: Frames = self._machine(tick, chosen, active)
        return frames if left == chosen else tuple(frame for frame in frames if frame[0] not in ids) + left


class _Serial:
    """Bytes that are changed within their tick."""

    def __init__(self, fault: Fault, chance: random.Random) -> None:
        self._fault, self._chance = fault, chance

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        if not active:
            return piece
        fault, chance = self._fault, self._chance
        match fault.kind:
            case "drop":
                return b"" if piece and chance.random() < fault.probability else piece
            case "duplicate":
                return piece + piece
            case "corrupt":
                return _corrupted(piece, fault.probability, chance)
            case "lose_byte":
                return bytes(byte for byte in piece if chance.random() >= fault.probability)
            case "truncate":
                return piece[: fault.keep]
            case "garbage":
                return chance.randbytes(len(piece) or 1)
        raise ValueError(f"{fault.kind} is no fault of a serial wire")


class _Bus:
    """Frames that are changed within their tick."""

    def __init__(self, fault: Fault, chance: random.Random) -> None:
        self._fault, self._chance = fault, chance

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        if not active:
            return frames
        fault, chance = self._fault, self._chance
        match fault.kind:
            case "drop":
                return tuple(frame for frame in frames if chance.random() >= fault.probability)
            case "duplicate":
                return frames + frames
            case "corrupt":
                return tuple((i, _corrupted(data, fault.probability, chance)) for i, data in frames)
            case "truncate":
                return tuple((i, data[: fault.keep]) for i, data in frames)
        raise ValueError(f"{fault.kind} is no fault of the bus")


class _ErrorFlag:
    """Feedback that reports an error. Raises ValueError where the motor's frames have no place for one."""

    def __init__(self, robot: Robot) -> None:
        if robot.dm3519 is None or robot.dm3519.feedback != "error":
            raise ValueError(
                f"flag: the feedback of {robot.name} cannot report an error; that of a DM3519 can, where its [dm3519] "
                'says feedback = "error"'
            )

    def __call__(self, tick: int, frames: Frames, active: bool) -> Frames:
        return tuple((can_id, data[:7] + OVER_CURRENT) for can_id, data in frames) if active else frames


def _corrupted(piece: bytes, probability: float, chance: random.Random) -> bytes:
    return bytes(byte ^ (1 << chance.randrange(8)) if chance.random() < probability else byte for byte in piece)
