"""Health management, 0x90: which faults a base has, in codes and in words.

    90 01             u8 levels (bit 0 warning, 1 error, 2 fatal) | u8 number of faults
    90 02 index       u32 code | u8[32] text, zero-terminated
    90 03 u32 code    nothing

    code: bits 27..24 level (1, 2, 4) | 19..16 component | 15..8 kind | 7..0 unit

A fault whose cause lasts stays cleared until the cause has gone once. Source: SLAMTEC's base reference firmware of
2018-11-20, executed; its masks for level and component, its byte for kind and unit.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import NamedTuple

from bench.slamware.commands import CLEAR_FAULT, GET_FAULT, GET_HEALTH, HEALTH_MGMT
from bench.slamware.payloads import printable

WARNING, ERROR, FATAL = 1, 2, 4
MOST_FAULTS = 32
_TEXT_BYTES = 32
_FAULT = struct.Struct("<I32s")
_CODE = struct.Struct("<I")
FAULT_BYTES = _FAULT.size
_LEVEL_BITS = 0x0F000000

BATTERY_LOW = 0x00020100
MOTOR_CONTROLLER_DOWN = 0x00030000

_LEVELS = {WARNING: "warning", ERROR: "error", FATAL: "fatal"}
_COMPONENTS = {0: "user", 1: "system", 2: "power", 3: "motion", 4: "sensor"}
_KINDS = {
    (1, 1): "emergency stop",
    (1, 2): "hot",
    (1, 3): "cold",
    (1, 7): "brake released",
    (2, 0): "controller down",
    (2, 1): "battery low",
    (2, 2): "over-current",
    (3, 0): "controller down",
    (3, 1): "motor alarm",
    (3, 2): "odometry down",
    (3, 4): "brush stalled",
    (4, 0): "controller down",
    (4, 1): "bumper",
    (4, 2): "cliff",
    (4, 3): "sonar",
    (4, 5): "magnetic tape",
    (4, 6): "magnetic self-test",
    (4, 0x11): "dust bin",
}


class Fault(NamedTuple):
    """One fault of a base: its code, level included, and what it says of it."""

    code: int
    text: str

    @property
    def level(self) -> int:
        """1 warning, 2 error, 4 fatal."""
        return (self.code & _LEVEL_BITS) >> 24

    @property
    def identity(self) -> int:
        """The code without its level: the same fault, whether it warns or is fatal."""
        return self.code & ~_LEVEL_BITS


class Health(NamedTuple):
    """Levels of all faults, as bits, and how many there are."""

    levels: int
    number: int


class HealthRegister:
    """The faults of one base: those that were raised by hand, and those whose causes were given last."""

    def __init__(self) -> None:
        self._raised: dict[int, Fault] = {}
        self._caused: dict[int, Fault] = {}
        self._cleared: set[int] = set()

    @property
    def faults(self) -> tuple[Fault, ...]:
        """In the order of their indices, at most 32."""
        lasting = (fault for key, fault in self._caused.items() if key not in self._cleared and key not in self._raised)
        return (*self._raised.values(), *lasting)[:MOST_FAULTS]

    def take_causes(self, faults: Iterable[Fault]) -> None:
        """Those whose causes last at this moment."""
        self._caused = {fault.identity: fault for fault in faults}
        self._cleared &= self._caused.keys()

    def raise_fault(self, fault: Fault) -> None:
        """A fault that stays until it is cleared. Raises ValueError for one that does not fit, or for one too many."""
        fault_answer(fault)
        if fault.identity not in self._raised and len(self._raised) == MOST_FAULTS:
            raise ValueError(f"{MOST_FAULTS} faults are raised already")
        self._raised[fault.identity] = fault

    def clear(self, code: int) -> bool:
        """Forget a fault, its level bits left out of account; False where it is not registered."""
        key = code & ~_LEVEL_BITS
        if not any(fault.identity == key for fault in self.faults):
            return False
        self._raised.pop(key, None)
        if key in self._caused:
            self._cleared.add(key)
        return True


def battery_faults(percent: int) -> tuple[Fault, ...]:
    """The one fault that the reference base knows: a warning below 30 %, an error below 10 %."""
    if percent >= 30:
        return ()
    return (Fault((WARNING if percent >= 10 else ERROR) << 24 | BATTERY_LOW, "Low battery."),)


def health_request() -> bytes:
    """0x90 01: the summary."""
    return bytes((HEALTH_MGMT, GET_HEALTH))


def fault_request(index: int) -> bytes:
    """0x90 02: one fault, 0 to count - 1."""
    return bytes((HEALTH_MGMT, GET_FAULT, index))


def clear_request(code: int) -> bytes:
    """0x90 03: forget a fault."""
    return bytes((HEALTH_MGMT, CLEAR_FAULT)) + _CODE.pack(code)


def code_from_fields(fields: bytes) -> int:
    """The fault code out of the 5 bytes after 0x90."""
    code: int = _CODE.unpack_from(fields, 1)[0]
    return code


def health_answer(faults: Iterable[Fault]) -> bytes:
    """2 bytes."""
    levels = count = 0
    for fault in faults:
        levels |= fault.level
        count += 1
    return bytes((levels, count))


def health_from_answer(payload: bytes) -> Health:
    """The summary out of at least 2 bytes."""
    return Health(payload[0], payload[1])


def fault_answer(fault: Fault) -> bytes:
    """36 bytes. Raises ValueError where code or text do not fit."""
    text = fault.text.encode("ascii", "replace")
    if text.decode() != fault.text or len(text) >= _TEXT_BYTES:
        raise ValueError(f"fault text {fault.text!r} is not ASCII text of 0..{_TEXT_BYTES - 1} characters")
    if not 0 <= fault.code <= 0xFFFFFFFF or not fault.identity:
        raise ValueError(f"fault code {fault.code:#x} names no fault of 32 bits")
    return _FAULT.pack(fault.code, text)


def fault_from_answer(payload: bytes) -> Fault:
    """One fault out of at least 5 bytes."""
    return Fault(_CODE.unpack_from(payload)[0], printable(payload[_CODE.size : FAULT_BYTES]))


def fault_in_words(code: int) -> str:
    """A fault code for people: "power warning: battery low, unit 0"."""
    component, kind = code >> 16 & 0x0F, code >> 8 & 0xFF
    level = _LEVELS.get(code >> 24 & 0x0F, "fault")
    what = _KINDS.get((component, kind), f"kind {kind}")
    return f"{_COMPONENTS.get(component, f'component {component}')} {level}: {what}, unit {code & 0xFF}"
