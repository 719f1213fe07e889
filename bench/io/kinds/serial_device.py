"""A serial device that the system knows by a path: opened and set by pyserial, and what it refuses in one sentence."""

from __future__ import annotations

import array
import errno
import fcntl
import os
import sys
import termios
from contextlib import suppress
from typing import Any

from bench.errors import SurroundingsError
from bench.io.kinds.serial_line import SerialLine
from bench.rc.line import Settings

_TCGETS2 = 0x802C542A
_PARENB, _CSTOPB = 0o400, 0o100
"""From Linux's asm-generic/ioctls.h and asm-generic/termbits.h."""


class DevicePort(SerialLine):
    """A USB adapter, a UART, somebody else's pseudo-terminal. Raises SurroundingsError where it cannot be opened."""

    def __init__(self, name: str, path: str, settings: Settings) -> None:
        super().__init__(name)
        self._path, self._settings = path, settings
        self._serial: Any = None
        try:
            self._open()
        except self._refusals as error:
            raise SurroundingsError(f"{name}: {self._trouble(error)}") from None

    def _open(self) -> None:
        import serial

        settings = self._settings
        # A pty has no line: it takes no parity (the second opening fails), and its speed means nothing.
        is_pty = os.path.realpath(self._path).startswith("/dev/pts/")
        even = settings.even_parity and not is_pty
        self._serial = serial.Serial(
            self._path,
            settings.baud,
            parity=serial.PARITY_EVEN if even else serial.PARITY_NONE,
            stopbits=1 if is_pty else settings.stop_bits,
            timeout=0,
            write_timeout=0,
        )
        fd = self._serial.fileno()
        if is_pty:
            self.note = "is a pseudo-terminal: baud rate and parity mean nothing on it"
        else:
            self._check(fd)
            # A USB adapter keeps bytes back for up to 16 ms otherwise; what is none cannot be asked. Linux alone can.
            if sys.platform.startswith("linux"):
                with suppress(OSError, ValueError):
                    self._serial.set_low_latency_mode(True)
        self._use(fd)

    def _check(self, fd: int) -> None:
        """Some drivers take any setting and keep another: read it back."""
        if not sys.platform.startswith("linux"):
            return
        got = array.array("I", [0] * 11)
        try:
            fcntl.ioctl(fd, _TCGETS2, got)
        except OSError:  # another architecture has another number for it
            return
        flags, baud, wanted = got[2], got[10], self._settings
        kept = Settings(baud, bool(flags & _PARENB), 2 if flags & _CSTOPB else 1)
        if abs(baud - wanted.baud) * 50 > wanted.baud or kept[1:3] != wanted[1:3]:
            self._release()
            raise ValueError(f"was set to {wanted._replace(inverted=False)}, but the driver made it {kept}")

    def _shut(self) -> None:
        if self._serial is not None:
            self._serial.close()
            self._serial = None

    def _trouble(self, error: Exception) -> str:
        """Why it cannot be opened, and what to try."""
        path, number = self._path, getattr(error, "errno", None)
        if isinstance(error, termios.error):
            return f"{path} refuses {self._settings._replace(inverted=False)}; try another ?baud= or &format="
        if number == errno.ENOENT:
            return f"there is no device {path}; plug it in, or see `wheelbench doctor` for those there are"
        if number in (errno.EACCES, errno.EPERM):
            return f"you may not open {path}; join its group (sudo usermod -aG dialout $USER) and log in anew"
        if number == errno.EBUSY:
            return f"{path} is in use; close the other program (a serial monitor, ModemManager)"
        if number == errno.ENOTTY or "tcgetattr" in str(error) or "Could not configure port" in str(error):
            return f"{path} is no serial port; see `wheelbench doctor` for those there are"
        if isinstance(error, ValueError):
            return f"{path} {error}"
        return f"{path} cannot be opened ({self._why(error)}); see `wheelbench doctor` for the ports there are"
