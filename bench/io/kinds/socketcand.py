"""Whether a socketcand server is there, by its greeting (socketcand's doc/protocol.md, mode NO_BUS).

Asked before python-can is: that one goes on trying a host that refuses for ten seconds, and waits for ever for one
that says nothing. One that greets and then says nothing is known only by trying: `Opening`.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Mapping
from typing import Any

from bench.errors import SurroundingsError, UsageError

GREETING = b"< hi >"
EXAMPLE = "can:socketcand:can0?host=127.0.0.1&port=29536"


def ask(title: str, options: Mapping[str, object], timeout_s: float) -> None:
    """Connect, wait for the greeting, leave. Raises UsageError where the options name no host and port,
    SurroundingsError where no socketcand answers there in time.
    """
    host, port = options.get("host"), options.get("port")
    if not isinstance(host, str) or type(port) is not int or not 0 < port < 65536:
        raise UsageError(f"{title}: socketcand needs a host and a port; expected such as {EXAMPLE}")
    try:
        # IPv4 alone, as python-can will connect.
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.settimeout(timeout_s)
            probe.connect((host, port))
            heard = probe.recv(256)
    except (OSError, UnicodeError) as error:  # the latter of names that no resolver takes
        why = getattr(error, "strerror", None) or str(error)
        raise SurroundingsError(f"{title}: no socketcand answers at {host}:{port} ({why}); start it there") from None
    if not heard.startswith(GREETING):
        raise SurroundingsError(f"{title}: who listens at {host}:{port} is no socketcand; try another port")


class Opening:
    """Opens python-can's bus, and does not wait for it longer than it may: in a thread, because its socket is blocking
    and nobody else's to close. One that hangs is the only one; what comes of it late is taken up by the next `within`.
    """

    def __init__(self) -> None:
        self._thread: threading.Thread | None = None
        self._came: list[Any] = []
        self._lock = threading.Lock()
        self._given_up = False

    def within(self, timeout_s: float, make: Callable[[], Any]) -> Any:
        """The bus. Raises what `make` raises, and TimeoutError."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._open, args=(make,), daemon=True, name="socketcand")
            self._thread.start()
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            raise TimeoutError("timed out")
        self._thread = None
        came = self._came.pop()
        if isinstance(came, Exception):
            raise came
        return came

    def give_up(self) -> None:
        """Nobody wants it any more, should it come yet."""
        with self._lock:
            self._given_up = True
            self._close()

    def _open(self, make: Callable[[], Any]) -> None:
        try:
            came: Any = make()
        except Exception as error:
            came = error
        with self._lock:
            self._came.append(came)
            if self._given_up:
                self._close()

    def _close(self) -> None:
        while self._came:
            came = self._came.pop()
            if not isinstance(came, Exception):
                came.shutdown()
