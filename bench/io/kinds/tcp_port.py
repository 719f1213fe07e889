"""A TCP connection as a serial line, from either side: one that connects, and one that waits to be connected to."""

from __future__ import annotations

import array
import errno
import fcntl
import socket
import termios
from contextlib import suppress

from bench.errors import SurroundingsError
from bench.io.clock import TICK_NS, now_ns, wait_ns
from bench.io.kinds.serial_line import BLOCK_BYTES, MOST_BLOCKS, SerialLine

CONNECT_S, RECONNECT_S = 2.0, 0.05
"""Coming back must not hold up a loop for long."""
LEAVE_S = 0.5


class _Connection(SerialLine):
    """What both sides have once they are connected."""

    def __init__(self, name: str, lost: str = "") -> None:
        super().__init__(name, lost)
        self._socket: socket.socket | None = None

    def _connected(self, made: socket.socket) -> None:
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        made.setblocking(False)
        self._socket = made
        self._use(made.fileno())

    def close(self) -> None:
        """Give it back, when what was said last has arrived."""
        if self._socket is not None:
            _leave(self._socket)
        super().close()

    def _shut(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class SocketPort(_Connection):
    """Connects to somebody who listens. Raises SurroundingsError where nobody does."""

    def __init__(self, name: str, host: str, port: int) -> None:
        super().__init__(name)
        self._place = (host, port)
        self._timeout_s = CONNECT_S
        try:
            self._open()
        except OSError as error:
            raise SurroundingsError(
                f"{name}: nobody can be reached at {host}:{port} ({self._why(error)}); start the other end first"
            ) from None
        self._timeout_s = RECONNECT_S

    def _open(self) -> None:
        self._connected(socket.create_connection(self._place, self._timeout_s))


class ListenPort(_Connection):
    """Listens, with room for one; the next one may connect when it has left. Raises SurroundingsError where the place
    is taken.
    """

    def __init__(self, name: str, host: str, port: int) -> None:
        super().__init__(name, "nobody has connected yet")
        try:
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._listener = socket.create_server((host, port), family=family, backlog=1)
        except OSError as error:
            raise SurroundingsError(f"{name}: cannot listen there ({self._why(error)}); give another port") from None
        self._listener.setblocking(False)
        self.where = f"socket://{host}:{self._listener.getsockname()[1]}"

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        if self._socket is None and not self._unread and not self._accept():
            return b""
        return super().read()

    def write(self, data: bytes, within_s: float = 0.0) -> bool:
        """Send, if somebody is there."""
        if self._socket is None:
            self._accept()
        return super().write(data, within_s)

    def close(self) -> None:
        """Leave, and listen no more."""
        super().close()
        self._listener.close()

    def _accept(self) -> bool:
        try:
            client, _ = self._listener.accept()
        except OSError:
            return False
        self._connected(client)
        self.lost = ""
        return True

    def _open(self) -> None:
        if self._socket is None and not self._accept():
            raise ConnectionError(errno.ENOTCONN, "nobody has connected again")


def _leave(made: socket.socket) -> None:
    """Say no more, and wait until what was said has arrived, at most `LEAVE_S`; at once where nobody is there.

    A connection that is closed over something unread, or hears more after that, is reset: what had not arrived by then
    is thrown away, and that may be a zero for motors.
    """
    deadline_ns = now_ns() + int(LEAVE_S * 1e9)
    with suppress(OSError):  # it has broken, or this system cannot tell
        made.shutdown(socket.SHUT_WR)
        while now_ns() < deadline_ns:
            with suppress(BlockingIOError):
                for _ in range(MOST_BLOCKS):
                    if not made.recv(BLOCK_BYTES):
                        break
            if not _unsent(made):
                return
            wait_ns(TICK_NS)


def _unsent(made: socket.socket) -> int:
    """How many bytes the other end has not confirmed. Raises OSError where only Linux could tell."""
    told = array.array("i", [0])
    fcntl.ioctl(made.fileno(), termios.TIOCOUTQ, told)
    return told[0]
