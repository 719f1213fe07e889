"""A gamepad of the kernel's own making, by /dev/uinput (linux/uinput.h): joydev and evdev make nodes of it."""

import fcntl
import os
import struct
from pathlib import Path
from typing import NamedTuple

EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
X, Y, Z, RX, RY, RZ, HAT_X, HAT_Y = 0, 1, 2, 3, 4, 5, 0x10, 0x11
A, B, START, KEY_A, KEY_Z = 0x130, 0x131, 0x13B, 0x1E, 0x2C
"""linux/input-event-codes.h"""
UI_DEV_CREATE, UI_DEV_DESTROY, UI_DEV_SETUP, UI_ABS_SETUP = 0x5501, 0x5502, 0x405C5503, 0x401C5504
UI_SET_EVBIT, UI_SET_KEYBIT, UI_SET_ABSBIT, UI_GET_SYSNAME_32 = 0x40045564, 0x40045565, 0x40045567, 0x8020552C


class Range(NamedTuple):
    """What a driver tells of an axis: its ends, its dead zone, where it stands at first."""

    low: int
    high: int
    flat: int = 0
    first: int = 0


STICK, TRIGGER, HAT = Range(-32768, 32767, 128), Range(0, 255), Range(-1, 1)
XPAD_AXES = {X: STICK, Y: STICK, RX: STICK, RY: STICK, Z: TRIGGER, RZ: TRIGGER, HAT_X: HAT, HAT_Y: HAT}
XPAD_BUTTONS = (A, B, 0x133, 0x134, 0x136, 0x137, 0x13A, START, 0x13C, 0x13D, 0x13E)
"""As drivers/input/joystick/xpad.c sets up a wired one."""


class VirtualPad:
    """Plugged in from the first; what it is told to do, the kernel hears as if a driver had said it."""

    def __init__(self, axes=XPAD_AXES, buttons=XPAD_BUTTONS, name="Pad of the tests"):
        self._uinput = os.open("/dev/uinput", os.O_WRONLY | os.O_NONBLOCK)
        for kind, code_ioctl, codes in ((EV_KEY, UI_SET_KEYBIT, buttons), (EV_ABS, UI_SET_ABSBIT, axes)):
            if codes:
                fcntl.ioctl(self._uinput, UI_SET_EVBIT, kind)
            for code in codes:
                fcntl.ioctl(self._uinput, code_ioctl, code)
        for code, (low, high, flat, first) in axes.items():
            fcntl.ioctl(self._uinput, UI_ABS_SETUP, struct.pack("H2x6i", code, first, low, high, 0, flat, 0))
        bus_usb = 3
        fcntl.ioctl(self._uinput, UI_DEV_SETUP, struct.pack("4H80sI", bus_usb, 0x1209, 1, 1, name.encode(), 0))
        fcntl.ioctl(self._uinput, UI_DEV_CREATE)
        sysname = fcntl.ioctl(self._uinput, UI_GET_SYSNAME_32, bytes(32)).split(b"\0")[0].decode()
        self._sys = Path("/sys/devices/virtual/input", sysname)

    def node(self, kind):
        """The path of its "js" or "event" node."""
        (found,) = self._sys.glob(f"{kind}[0-9]*")
        return f"/dev/input/{found.name}"

    def nodes(self):
        return sorted(path.name for path in self._sys.glob("*[0-9]"))

    def report(self, *events):
        """One report of the hardware: (kind, code, value) each. The kernel passes on what has changed."""
        for event in (*events, (EV_SYN, 0, 0)):
            os.write(self._uinput, struct.pack("llHHi", 0, 0, *event))

    def move(self, code, value):
        self.report((EV_ABS, code, value))

    def press(self, code):
        self.report((EV_KEY, code, 1))
        self.report((EV_KEY, code, 0))

    def unplug(self):
        if self._uinput >= 0:
            fcntl.ioctl(self._uinput, UI_DEV_DESTROY)
            os.close(self._uinput)
            self._uinput = -1
