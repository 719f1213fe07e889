"""Whether a socketcand server is there, by its greeting (socketcand's doc/protocol.md, mode NO_BUS).

Asked before python-can is: that one goes on trying a host that refuses for ten seconds, and waits for ever for one
that says nothing.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping

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
    except OSError as error:
        why = error.strerror or str(error)
        raise SurroundingsError(f"{title}: no socketcand answers at {host}:{port} ({why}); start it there") from None
    if not heard.startswith(GREETING):
        raise SurroundingsError(f"{title}: who listens at {host}:{port} is no socketcand; try another port")
