"""Serial lines as ports: bytes that have come, bytes to send, nothing that blocks, and no exception once it is open.

    port = open_serial("rc", "serial:/dev/ttyUSB0?baud=100000&format=8E2")
    data = port.read()                # a whole block, b"" where nothing has come
    port.write(frame)
    if port.lost: ...                 # why it cannot be used now; `revive` tries again, at most every half second

A line that breaks is `lost` until `revive` finds it again: a cable that is pulled and put back. pyserial opens devices
and sets them; blocks are read from the descriptor, because byte by byte costs thirty times as much.
"""

from __future__ import annotations

import array
import errno
import fcntl
import os
import select
import socket
import sys
import termios
import tty
from contextlib import suppress
from typing import Any, Protocol

from bench.errors import SurroundingsError
from bench.io.address import SerialAddress, serial_address
from bench.io.clock import now_ns
from bench.rc.line import Settings

BLOCK_BYTES = 8192
FLOOD_BYTES, FLOOD_READS = 2048, 10
"""So much at once, so often in a row, is more than any line brings in a millisecond (20 Mbaud): somebody floods it."""
RETRY_NS = 500_000_000
EIGHT_N_ONE = Settings(115_200)
CONNECT_S = 2.0
_TROUBLE = (OSError, ValueError, termios.error)
"""What opening may raise; pyserial hands on the last one as it is."""
_TCGETS2 = 0x802C542A
_PARENB, _CSTOPB = 0o400, 0o100


class SerialPort(Protocol):
    """What every serial line can do."""

    name: str
    """Its address, as the user gave it."""
    where: str
    """What the other end opens or connects to; empty where that is the user's own affair."""
    lost: str
    """Why it cannot be used now; empty while it can."""
    losses: int
    """How often it was lost."""
    dropped_bytes: int
    """What could not be sent: nobody there, or the line full."""
    is_flooded: bool
    """Whether more has come than a real line could bring; it stays so."""
    note: str
    """What the user should know of it."""

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        ...

    def write(self, data: bytes) -> None:
        """Send; what the line does not take at once is dropped and counted."""
        ...

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        ...

    def close(self) -> None:
        """Give it back."""
        ...

    def fileno(self) -> int:
        """For `select`; -1 while it is lost."""
        ...


class _Line:
    """What the kinds have in common. They say how to open (`_open`) and let go (`_release`)."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.where = ""
        self.lost = ""
        self.losses = 0
        self.dropped_bytes = 0
        self.is_flooded = False
        self.note = ""
        self._full_reads = 0
        self._fd = -1
        self._poll: select.poll | None = None
        self._retry_ns = 0

    def fileno(self) -> int:
        """For `select`; -1 while it is lost."""
        return self._fd

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        poll = self._poll
        if poll is None:
            return b""
        events = poll.poll(0)
        if not events:
            return b""
        try:
            if events[0][1] & select.POLLIN:
                data = os.read(self._fd, BLOCK_BYTES)
                if data:
                    return self._counted(data)
            self._lose("the other end has closed it")
        except BlockingIOError:
            pass
        except OSError as error:
            self._lose(_why(error))
        return b""

    def write(self, data: bytes) -> None:
        """Send; what the line does not take at once is dropped and counted."""
        if self._fd < 0:
            self.dropped_bytes += len(data)
            return
        left = memoryview(data)
        try:
            while left:
                left = left[os.write(self._fd, left) :]
        except BlockingIOError:
            self.dropped_bytes += len(left)
        except OSError as error:
            self.dropped_bytes += len(left)
            self._lose(_why(error))

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        if not self.lost:
            return True
        if now_ns() < self._retry_ns:
            return False
        self._retry_ns = now_ns() + RETRY_NS
        try:
            self._open()
        except _TROUBLE as error:
            self.lost = _why(error)
            return False
        self.lost = ""
        return True

    def close(self) -> None:
        """Give it back."""
        self._let_go()

    def _counted(self, data: bytes) -> bytes:
        if len(data) < FLOOD_BYTES:
            self._full_reads = 0
        else:
            self._full_reads += 1
            self.is_flooded = self.is_flooded or self._full_reads >= FLOOD_READS
        return data

    def _use(self, fd: int) -> None:
        os.set_blocking(fd, False)
        self._fd = fd
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)

    def _lose(self, why: str) -> None:
        self._let_go()
        self.lost = why
        self.losses += 1
        self._retry_ns = now_ns() + RETRY_NS

    def _let_go(self) -> None:
        self._fd, self._poll = -1, None
        self._release()

    def _open(self) -> None:
        raise NotImplementedError

    def _release(self) -> None:
        raise NotImplementedError


class DevicePort(_Line):
    """A device that the system knows by a path: a USB adapter, a UART, somebody else's pseudo-terminal."""

    def __init__(self, name: str, path: str, settings: Settings) -> None:
        super().__init__(name)
        self._path, self._settings = path, settings
        self._serial: Any = None
        try:
            self._open()
        except _TROUBLE as error:
            if isinstance(error, termios.error):
                wanted = settings._replace(inverted=False)
                raise SurroundingsError(f"{name}: {path} refuses {wanted}; try another ?baud= or &format=") from None
            raise SurroundingsError(f"{name}: {_device_trouble(path, error)}") from None

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
            # A USB adapter keeps bytes back for up to 16 ms otherwise; what is none cannot be asked.
            with suppress(OSError, ValueError, NotImplementedError):
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

    def _release(self) -> None:
        if self._serial is not None:
            self._serial.close()
            self._serial = None


class PtyPort(_Line):
    """A pseudo-terminal of our own; `where` is what the other end opens, a link with a steady name if one was given.

    While nobody has it open it counts as lost, and what is sent is dropped: who opens it shall not find the past.
    """

    def __init__(self, name: str, link: str = "") -> None:
        super().__init__(name)
        self._link = ""
        self.lost = "nobody has opened it yet"
        try:
            master, slave = os.openpty()
            self._use(master)
            tty.setraw(slave)  # it stays raw while this end lives
            device = os.ttyname(slave)
            os.close(slave)
            self.where = device
            if link:
                self._make_link(link, device)
        except OSError as error:
            self.close()
            what = f"no link {link} to a pseudo-terminal" if link else "no pseudo-terminal"
            raise SurroundingsError(f"{name}: {what} can be made ({_why(error)}); give another path") from None

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        events = self._look()
        if not events & select.POLLIN:
            return b""
        try:
            return self._counted(os.read(self._fd, BLOCK_BYTES))
        except OSError:  # the other end closed between the two calls
            return b""

    def write(self, data: bytes) -> None:
        """Send, if somebody is there."""
        self._look()
        if self.lost:
            self.dropped_bytes += len(data)
        else:
            super().write(data)

    def revive(self) -> bool:
        """Whether somebody is there."""
        self._look()
        return not self.lost

    def close(self) -> None:
        """Give it back, and take the link away."""
        if self._fd >= 0:
            os.close(self._fd)
        self._fd, self._poll, self.lost = -1, None, "closed"
        if self._link:
            with suppress(OSError):
                os.unlink(self._link)
            self._link = ""

    def _look(self) -> int:
        if self._poll is None:
            return 0
        events = self._poll.poll(0)
        seen = events[0][1] if events else 0
        if not seen & select.POLLHUP:
            self.lost = ""
        elif not self.lost:
            self.lost = "the other end has closed it"
            self.losses += 1
        return seen

    def _make_link(self, link: str, device: str) -> None:
        if os.path.islink(link):
            os.unlink(link)
        os.symlink(device, link)
        self._link = self.where = link

    def _lose(self, why: str) -> None:
        """Nothing is let go: the next look finds out."""

    def _release(self) -> None:
        """Nothing to do before `close`."""


class SocketPort(_Line):
    """A TCP connection to somebody who listens."""

    def __init__(self, name: str, host: str, port: int) -> None:
        super().__init__(name)
        self._place = (host, port)
        self._socket: socket.socket | None = None
        self._timeout_s = CONNECT_S
        try:
            self._open()
        except OSError as error:
            raise SurroundingsError(
                f"{name}: nobody can be reached at {host}:{port} ({_why(error)}); start the other end first"
            ) from None
        self._timeout_s = 0.05  # coming back must not hold up a loop for long

    def _open(self) -> None:
        made = socket.create_connection(self._place, self._timeout_s)
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = made
        self._use(made.fileno())

    def _release(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class ListenPort(_Line):
    """A TCP listener with room for one; the next one may connect when it has left."""

    def __init__(self, name: str, host: str, port: int) -> None:
        super().__init__(name)
        self._client: socket.socket | None = None
        self.lost = "nobody has connected yet"
        try:
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._listener = socket.create_server((host, port), family=family, backlog=1)
        except OSError as error:
            raise SurroundingsError(f"{name}: cannot listen there ({_why(error)}); give another port") from None
        self._listener.setblocking(False)
        self.where = f"socket://{host}:{self._listener.getsockname()[1]}"

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        if self._client is None and not self._accept():
            return b""
        return super().read()

    def write(self, data: bytes) -> None:
        """Send, if somebody is there."""
        if self._client is None:
            self._accept()
        super().write(data)

    def close(self) -> None:
        """Leave, and listen no more."""
        super().close()
        self._listener.close()

    def _accept(self) -> bool:
        try:
            client, _ = self._listener.accept()
        except OSError:
            return False
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client
        self._use(client.fileno())
        self.lost = ""
        return True

    def _open(self) -> None:
        if self._client is None and not self._accept():
            raise ConnectionError(errno.ENOTCONN, "nobody has connected again")

    def _release(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


def open_serial(name: str, address: str | SerialAddress, settings: Settings = EIGHT_N_ONE) -> SerialPort:
    """Open a serial line; `settings` hold where the address names none. Raises UsageError for an address that is none
    (or is `sim:`), SurroundingsError where this machine cannot do it now.
    """
    if isinstance(address, str):
        address = serial_address(name, address)
    title = f"{name} {address.text}"
    if address.kind == "pty":
        return PtyPort(title, address.place)
    if address.kind == "serial":
        return DevicePort(title, address.place, address.settings or settings)
    if address.kind == "socket":
        return SocketPort(title, address.place, address.port)
    if address.kind == "listen":
        return ListenPort(title, address.place, address.port)
    raise ValueError(f"{title}: a wire inside the process has no port")


class PacedWriter:
    """Sends bytes no faster than their line would: where nothing paces them (a pty, a socket), so that frames have a
    duration at the other end too. `step` once a millisecond.
    """

    def __init__(self, port: SerialPort, settings: Settings) -> None:
        self.port = port
        bits = 9 + settings.even_parity + settings.stop_bits
        self._bytes_per_tick = settings.baud / bits / 1000.0
        self._credit = 0.0
        self._waiting = bytearray()

    def put(self, data: bytes) -> None:
        """Queue; more than half a second's worth is dropped from the front and counted by the port."""
        self._waiting += data
        surplus = len(self._waiting) - round(500 * self._bytes_per_tick) - 64
        if surplus > 0:
            del self._waiting[:surplus]
            self.port.dropped_bytes += surplus

    def step(self) -> bytes:
        """Send what a millisecond carries; what that was."""
        if not self._waiting:
            self._credit = 0.0
            return b""
        self._credit += self._bytes_per_tick
        count = int(self._credit)
        self._credit -= count
        data = bytes(self._waiting[:count])
        del self._waiting[:count]
        self.port.write(data)
        return data


def _why(error: Exception) -> str:
    if isinstance(error, termios.error) and len(error.args) == 2:
        return str(error.args[1])
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


def _device_trouble(path: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return f"there is no device {path}; plug it in, or see `wheelbench doctor` for those there are"
    if number in (errno.EACCES, errno.EPERM):
        return f"you may not open {path}; join its group (sudo usermod -aG dialout $USER) and log in anew"
    if number == errno.EBUSY:
        return f"{path} is in use; close the other program (a serial monitor, ModemManager)"
    if number == errno.ENOTTY or "tcgetattr" in str(error) or "Could not configure port" in str(error):
        return f"{path} is no serial port; see `wheelbench doctor` for those there are"
    return f"{path} {error if isinstance(error, ValueError) else 'cannot be opened (' + _why(error) + ')'}"
