"""One process for each firmware, which forks a fresh one whenever it is asked: before any of the team's code has run.

So a reset costs a fork of a small process, not the start of one, and nothing of one run can reach the next.
"""

from __future__ import annotations

import atexit
import os
import socket
import struct
import subprocess
from pathlib import Path

from bench.errors import SurroundingsError

_ORDER = struct.Struct("<c3xI")
_REPLY = struct.Struct("<i")


class Server:
    """The fork server of one program."""

    def __init__(self, program: Path) -> None:
        self.program = program
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            # An environment that is always the same: it lies on the firmware's stack.
            self._process = subprocess.Popen(
                [str(program), str(theirs.fileno())],
                env={"LC_ALL": "C"},
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        except OSError as error:
            self._socket.close()
            raise SurroundingsError(f"{program}: cannot be started ({error.strerror})") from None
        finally:
            theirs.close()

    def fork(self, link: int, output: int) -> int:
        """A fresh firmware on these descriptors; its process number. Raises SurroundingsError."""
        try:
            socket.send_fds(self._socket, [_ORDER.pack(b"F", 0)], [link, output])
            pid = self._reply()
        except OSError:
            pid = -1
        if pid <= 0:
            raise SurroundingsError(
                f"{self.program}: the firmware's process does not come up; run the file by hand to see why"
            )
        return pid

    def ended(self, pid: int) -> int | None:
        """Wait for a firmware to be gone; its status as the system gives it, None where nobody knows."""
        try:
            self._socket.send(_ORDER.pack(b"W", pid))
            status = self._reply()
        except OSError:
            return None
        return status if status >= 0 else None

    def close(self) -> None:
        """End the process, and all that it forked."""
        self._socket.close()
        self._process.wait()

    def _reply(self) -> int:
        data = self._socket.recv(_REPLY.size)
        return int(_REPLY.unpack(data)[0]) if len(data) == _REPLY.size else -1


_servers: dict[tuple[int, str, int, int], Server] = {}


def server_of(program: Path) -> Server:
    """The one that runs this program as it is on disk now; started when it is first asked for."""
    found = program.stat()
    key = (os.getpid(), str(program), found.st_ino, found.st_mtime_ns)  # a fork of ours has its own
    server = _servers.get(key)
    if server is None:
        # Another program in the same place: firmwares of the old one that still run stay until their benches go.
        server = _servers[key] = Server(program)
    return server


def _close_all() -> None:
    while _servers:
        _servers.popitem()[1].close()


atexit.register(_close_all)
