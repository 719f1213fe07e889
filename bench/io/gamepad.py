"""A gamepad: the kernel's joystick node, or evdev through the extra of that name. Nothing blocks, nothing raises later.

    /dev/input/js0     8 bytes an event: time in ms, value, type, number (Documentation/input/joydev/joystick-api.rst)
    evdev:/dev/input/event5     by python-evdev: pip install wheelbench[gamepad]
    auto               the first joystick node that there is

A pad that is pulled out is `lost` and comes back by `revive`. Both kinds number axes and buttons as joydev does, so
that one map serves both.
"""

from __future__ import annotations

import errno
import fcntl
import glob
import os
import stat
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
MOST_EVENTS = 1024
"""Taken at once. On opening the node tells of every axis and button, 576 at most; its queue behind has 64 events."""
JSIOCGAXES, JSIOCGBUTTONS, JSIOCGNAME_64 = 0x80016A11, 0x80016A12, 0x80406A13
"""linux/joystick.h, the name in 64 bytes."""
NO_PAD = "it is no gamepad: {}; `cat /proc/bus/input/devices` lists what there is"


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
        self.axes: int | None = None
        self.buttons: int | None = None
        """How many it has; None where nothing tells."""

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
        there = sorted(glob.glob("/dev/input/js*"), key=lambda path: (len(path), path))
        path = self._path or next(iter(there), "/dev/input/js0")
        self._descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        self._rest = b""
        if stat.S_ISCHR(os.fstat(self._descriptor).st_mode):
            self._introduce(path)

    def _introduce(self, path: str) -> None:
        """What the node tells of its pad. A pipe in its place tells nothing, and any other device that it is none."""
        try:
            axes, buttons = (fcntl.ioctl(self._descriptor, ask, b"\0")[0] for ask in (JSIOCGAXES, JSIOCGBUTTONS))
            name = fcntl.ioctl(self._descriptor, JSIOCGNAME_64, bytes(64)).partition(b"\0")[0]
        except OSError:
            self._release()
            raise OSError(NO_PAD.format("no joystick node")) from None
        self.name = f"{path} ({name.decode('utf-8', 'replace')})"
        self.axes, self.buttons = axes, buttons

    def _take(self) -> list[PadEvent]:
        data = os.read(self._descriptor, MOST_EVENTS * EVENT.size)
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
        try:
            device = self._device = self._evdev.InputDevice(self._path)
        except OSError as error:
            if error.errno in (errno.ENOTTY, errno.EINVAL):
                raise OSError(NO_PAD.format("no event device")) from None
            raise
        codes = self._evdev.ecodes
        able: dict[int, Any] = device.capabilities()
        self._ranges = dict(able.get(codes.EV_ABS, []))
        if not self._ranges:
            self._release()
            raise OSError(NO_PAD.format("it has no sticks"))
        self._axes = {code: number for number, code in enumerate(sorted(self._ranges))}
        self._buttons = joydev_buttons(able.get(codes.EV_KEY, []))
        self._first = self._standing()
        self.name = f"{self._path} ({device.name})"
        self.axes, self.buttons = len(self._axes), len(self._buttons)

    def _standing(self) -> list[tuple[int, int, int]]:
        """How everything stands now, as events."""
        device, codes = self._device, self._evdev.ecodes
        pressed = set(device.active_keys())
        told = [(codes.EV_ABS, code, device.absinfo(code).value) for code in self._ranges]
        return told + [(codes.EV_KEY, code, int(code in pressed)) for code in self._buttons]

    def _take(self) -> list[PadEvent]:
        told, self._first = self._first, []
        codes = self._evdev.ecodes
        with suppress(BlockingIOError):
            while len(told) < MOST_EVENTS:  # 64 at a time
                told += [(event.type, event.code, event.value) for event in self._device.read()]
        if (codes.EV_SYN, codes.SYN_DROPPED, 0) in told:  # its queue was full, and what was in it has gone
            told += self._standing()
        events = (self._event(*one) for one in told)
        return [event for event in events if event is not None]

    def _event(self, kind: int, code: int, value: int) -> PadEvent | None:
        codes = self._evdev.ecodes
        if kind == codes.EV_ABS and code in self._axes:
            info = self._ranges[code]
            return PadEvent(True, self._axes[code], scaled(value, info.min, info.max, info.flat))
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


def scaled(value: int, low: int, high: int, flat: int = 0) -> float:
    """-1 to 1 over an axis' own range, rest in its dead zone: in integers, as drivers/input/joydev.c sets up its own
    correction, so that an event device stands where the joystick node does. 0 for an axis that has no range.
    """
    middle, way = int((low + high) / 2), (high - low) // 2 - 2 * flat
    if way <= 0 or middle - flat <= value < middle + flat:
        return 0.0
    beyond = value - (middle + flat if value > middle - flat else middle - flat)
    return max(-FULL_AXIS, min(FULL_AXIS, (1 << 29) // way * beyond >> 14)) / FULL_AXIS
