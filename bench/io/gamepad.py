"""A gamepad: the kernel's joystick node, or evdev through the extra of that name. Nothing blocks, nothing raises later.

    /dev/input/js0     8 bytes an event: time in ms, value, type, number (Documentation/input/joydev/joystick-api.rst)
    evdev:/dev/input/event5     by python-evdev: pip install wheelbench[gamepad]
    auto               the first joystick node that there is

A pad that is pulled out is `lost` and comes back by `revive`. Both kinds number axes and buttons as joydev does, so
that one map serves both.
"""

from __future__ import annotations

import errno
import glob
import os
import struct
from abc import abstractmethod
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, NamedTuple

from bench.errors import SurroundingsError, UsageError
from bench.io.revival import Revivable

EVENT = struct.Struct("IhBB")
BUTTON, AXIS, INITIAL = 0x01, 0x02, 0x80
FULL_AXIS = 32767
BTN_MISC, BTN_JOYSTICK, KEY_MAX = 0x100, 0x120, 0x2FF
"""From linux/input-event-codes.h: joydev counts buttons from BTN_JOYSTICK up, then those from BTN_MISC."""


class PadEvent(NamedTuple):
    """One axis (-1 to 1, as the kernel counts it) or button (0 or 1) stands so."""

    is_axis: bool
    number: int
    value: float


class Gamepad(Revivable):
    """What both kinds have in common: being there, being lost, being found again."""

    def __init__(self, name: str) -> None:
        super().__init__("not looked for yet")
        self.name = name

    def read(self) -> list[PadEvent]:
        """What has happened since the last call; the first after opening tells how everything stands."""
        if self.lost:
            return []
        try:
            return self._take()
        except BlockingIOError:
            return []
        except OSError as error:
            self._lose(self._why(error))
            return []

    def close(self) -> None:
        """Give it back."""
        self.lost = self.lost or "closed"
        self._release()

    @staticmethod
    def _why(error: Exception) -> str:
        number = getattr(error, "errno", None)
        if number in (errno.EACCES, errno.EPERM):
            return "you may not read it; docs/driving.md has the udev rule"
        if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
            return "it is not there; plug it in"
        return Revivable._why(error)

    @abstractmethod
    def _take(self) -> list[PadEvent]:
        """What has come. Raises BlockingIOError where nothing has, OSError where it has gone."""


class JoystickNode(Gamepad):
    """The kernel's joystick node at a path; an empty path means the first that there is."""

    def __init__(self, path: str = "") -> None:
        super().__init__(path or "the first /dev/input/js*")
        self._path = path
        self._descriptor = -1
        self._rest = b""

    def _open(self) -> None:
        path = self._path or next(iter(sorted(glob.glob("/dev/input/js*"))), "/dev/input/js0")
        self._descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        self._rest = b""

    def _take(self) -> list[PadEvent]:
        data = os.read(self._descriptor, 64 * EVENT.size)
        if not data:
            raise OSError(errno.ENODEV, "the node has ended")
        data = self._rest + data
        whole = len(data) - len(data) % EVENT.size
        self._rest = data[whole:]
        return joystick_events(data[:whole])

    def _release(self) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


class EvdevPad(Gamepad):
    """An event device by python-evdev. Raises SurroundingsError where that package is not installed."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self._path = path
        self._device: Any = None
        try:
            import evdev
        except ImportError:
            raise SurroundingsError(
                f"--gamepad evdev:{path}: needs the package evdev (pip install 'wheelbench[gamepad]'); "
                "a joystick node such as /dev/input/js0 needs nothing"
            ) from None
        self._evdev = evdev

    def _open(self) -> None:
        device = self._device = self._evdev.InputDevice(self._path)
        codes = self._evdev.ecodes
        self._ranges = dict(device.capabilities(absinfo=True).get(codes.EV_ABS, []))
        self._axes = {code: number for number, code in enumerate(sorted(self._ranges))}
        self._buttons = joydev_buttons(device.capabilities().get(codes.EV_KEY, []))
        self._first = [(codes.EV_ABS, code, info.value) for code, info in self._ranges.items()]
        pressed = set(device.active_keys())
        self._first += [(codes.EV_KEY, code, int(code in pressed)) for code in self._buttons]

    def _take(self) -> list[PadEvent]:
        told, self._first = self._first, []
        with suppress(BlockingIOError):
            told += [(event.type, event.code, event.value) for event in self._device.read()]
        events = (self._event(*one) for one in told)
        return [event for event in events if event is not None]

    def _event(self, kind: int, code: int, value: int) -> PadEvent | None:
        codes = self._evdev.ecodes
        if kind == codes.EV_ABS and code in self._axes:
            info = self._ranges[code]
            return PadEvent(True, self._axes[code], scaled(value, info.min, info.max))
        if kind == codes.EV_KEY and code in self._buttons:
            return PadEvent(False, self._buttons[code], float(value != 0))
        return None

    def _release(self) -> None:
        if self._device is not None:
            self._device.close()
            self._device = None


def open_gamepad(address: str) -> Gamepad:
    """The gamepad of an address, looked for at once but not insisted on: it may be plugged in later. Raises UsageError,
    SurroundingsError.
    """
    pad: Gamepad
    if address == "auto":
        pad = JoystickNode()
    elif address.startswith("evdev:"):
        pad = EvdevPad(address.removeprefix("evdev:"))
    elif address.startswith("/"):
        pad = JoystickNode(address)
    else:
        raise UsageError(f"--gamepad {address}: expected auto, /dev/input/js0 or evdev:/dev/input/event0")
    pad.revive()
    return pad


def joystick_events(data: bytes) -> list[PadEvent]:
    """Whole events of the joystick node; those of unknown types are left out."""
    events = []
    for _, value, kind, number in EVENT.iter_unpack(data):
        if kind & ~INITIAL == AXIS:
            events.append(PadEvent(True, number, max(-1.0, value / FULL_AXIS)))
        elif kind & ~INITIAL == BUTTON:
            events.append(PadEvent(False, number, float(value != 0)))
    return events


def joydev_buttons(codes: Iterable[int]) -> dict[int, int]:
    """Button codes -> the numbers that the kernel's joydev would give them."""
    known = sorted(code for code in codes if BTN_MISC <= code <= KEY_MAX)
    ordered = [code for code in known if code >= BTN_JOYSTICK] + [code for code in known if code < BTN_JOYSTICK]
    return {code: number for number, code in enumerate(ordered)}


def scaled(value: int, low: int, high: int) -> float:
    """-1 to 1 over an axis' own range; 0 for one that has none."""
    return max(-1.0, min(1.0, 2.0 * (value - low) / (high - low) - 1.0)) if high > low else 0.0
