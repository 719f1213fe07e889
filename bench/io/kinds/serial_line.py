"""What all serial lines have in common: a descriptor that is read in blocks and written to; only a last word waits.

Blocks are read from the descriptor, because byte by byte costs thirty times as much.
"""

from __future__ import annotations

import os
import select
import termios
from abc import abstractmethod
from contextlib import suppress

from bench.io.clock import TICK_NS, now_ns, wait_ns
from bench.io.revival import Revivable

BLOCK_BYTES = 8192
FLOOD_BYTES, FLOOD_READS = 2048, 10
"""So much at once, so often in a row, is more than any line brings in a millisecond (20 Mbaud): somebody floods it."""
MOST_BLOCKS = 32
"""Of one who has left so much is read at once: more than Linux keeps of a pty (16 kB), or a second of a fast line."""


class SerialLine(Revivable):
    """The kinds say how to open (`_open`, which ends in `_use`) and what to close (`_shut`)."""

    _refusals = (OSError, ValueError, termios.error)  # pyserial hands on the last one as it is

    def __init__(self, name: str, lost: str = "") -> None:
        super().__init__(lost)
        self.name = name
        self.where = ""
        self.dropped_bytes = 0
        self.is_flooded = False
        self.note = ""
        self._full_reads = 0
        self._unread = b""
        self._fd = -1
        self._poll: select.poll | None = None

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        poll = self._poll
        if poll is None:
            unread, self._unread = self._unread, b""
            return unread
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
            self._lose(self._why(error))
        return b""

    def write(self, data: bytes, within_s: float = 0.0) -> bool:
        """Send; what the line does not take at once or in this time is dropped and counted. Whether all left."""
        left = memoryview(data)
        if self._fd >= 0:
            deadline_ns = now_ns() + int(within_s * 1e9)
            try:
                while left:
                    try:
                        left = left[os.write(self._fd, left) :]
                    except BlockingIOError:
                        if now_ns() >= deadline_ns:
                            break
                        wait_ns(TICK_NS)
            except OSError as error:
                self._unread = self._remains()
                self._lose(self._why(error))
        self.dropped_bytes += len(left)
        return not left

    def close(self) -> None:
        """Give it back."""
        self._release()

    @staticmethod
    def _why(error: Exception) -> str:
        if isinstance(error, termios.error) and len(error.args) == 2:
            return str(error.args[1])
        return Revivable._why(error)

    @abstractmethod
    def _shut(self) -> None:
        """Close what `_open` has opened; there may be nothing."""

    def _use(self, fd: int) -> None:
        os.set_blocking(fd, False)
        self._unread = b""
        self._fd = fd
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)

    def _release(self) -> None:
        self._fd, self._poll = -1, None
        self._shut()

    def _remains(self) -> bytes:
        """All that one who has left had sent and nobody has read: its end, a zero for motors, counts most."""
        blocks: list[bytes] = []
        with suppress(OSError):  # there is no more
            while len(blocks) < MOST_BLOCKS and (block := os.read(self._fd, BLOCK_BYTES)):
                blocks.append(block)
        return b"".join(blocks)

    def _counted(self, data: bytes) -> bytes:
        if len(data) < FLOOD_BYTES:
            self._full_reads = 0
        else:
            self._full_reads += 1
            self.is_flooded = self.is_flooded or self._full_reads >= FLOOD_READS
        return data
