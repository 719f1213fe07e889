"""A pseudo-terminal of our own: a serial line for whoever opens its other end."""

from __future__ import annotations

import os
import select
import tty
from contextlib import suppress

from bench.errors import SurroundingsError
from bench.io.kinds.serial_line import BLOCK_BYTES, SerialLine


class PtyPort(SerialLine):
    """`where` is what the other end opens, a link with a steady name if one was given. It is never opened anew.

    While nobody has it open it counts as lost, and what is sent is dropped: who opens it shall not find the past.
    Raises SurroundingsError where none can be made.
    """

    def __init__(self, name: str, link: str = "") -> None:
        super().__init__(name, "nobody has opened it yet")
        self._master = -1
        self._wanted_link, self._link = link, ""
        try:
            self._open()
        except OSError as error:
            self.close()
            what = f"no link {link} to a pseudo-terminal" if link else "no pseudo-terminal"
            raise SurroundingsError(f"{name}: {what} can be made ({self._why(error)}); give another path") from None

    def read(self) -> bytes:
        """What has come since the last call; never waits."""
        events = self._look()
        if not events & select.POLLIN:
            return b""
        if events & select.POLLHUP:
            # A read brings 4095 bytes at most, on a busy machine only a part of what was sent; `lost` is told already.
            return self._counted(self._remains())
        try:
            return self._counted(os.read(self._fd, BLOCK_BYTES))
        except OSError:  # the other end closed between the two calls
            return b""

    def write(self, data: bytes, within_s: float = 0.0) -> bool:
        """Send, if somebody is there."""
        self._look()
        if not self.lost:
            return super().write(data, within_s)
        self.dropped_bytes += len(data)
        return not data

    def revive(self) -> bool:
        """Whether somebody is there."""
        self._look()
        return not self.lost

    def close(self) -> None:
        """Give it back, and take the link away."""
        super().close()
        self.lost = "closed"

    def _look(self) -> int:
        poll = self._poll
        if poll is None:
            return 0
        seen = _seen(poll)
        if seen & select.POLLHUP and not seen & select.POLLIN:
            # The kernel looks for input first: who wrote and left between its two looks has written all the same.
            seen = _seen(poll)
        if not seen & select.POLLHUP:
            self.lost = ""
        elif not self.lost:
            self.lost = "the other end has closed it"
            self.losses += 1
        return seen

    def _lose(self, why: str) -> None:
        """Nothing is let go: the next look finds out."""

    def _open(self) -> None:
        self._master, slave = os.openpty()
        self._use(self._master)
        tty.setraw(slave)  # it stays raw while this end lives
        self.where = os.ttyname(slave)
        os.close(slave)
        if self._wanted_link:
            self._make_link(self._wanted_link)

    def _make_link(self, link: str) -> None:
        if os.path.islink(link):
            os.unlink(link)
        os.symlink(self.where, link)
        self._link = self.where = link

    def _shut(self) -> None:
        if self._master >= 0:
            os.close(self._master)
            self._master = -1
        if self._link:
            with suppress(OSError):
                os.unlink(self._link)
            self._link = ""


def _seen(poll: select.poll) -> int:
    """The events of the one descriptor."""
    events = poll.poll(0)
    return events[0][1] if events else 0
