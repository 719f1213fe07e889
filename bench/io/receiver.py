"""A real RC receiver on a serial line: its bytes, in their order and untouched, in the ticks in which they belong.

A screen runs its ticks some at a time, and then the bytes of fifty milliseconds lie there at once. They came while as
many ticks passed, so over as many ticks they are given on, a frame at a time: they reach the base as regularly as they
were sent, a picture later. A receiver that is pulled out is a link lost by silence, and judged by the base.
"""

from __future__ import annotations

from collections import deque

from bench import rc_decode
from bench.io.address import serial_address
from bench.io.serial_port import SerialPort, open_serial
from bench.rc.line import USUAL

LONGEST_REST = 128
"""Twice the longest frame (CRSF's)."""
SPREAD_MS = 50
"""A picture of the screen. What lay there for longer is older than that, and not given on."""


class Receiver:
    """`read` once a tick; `look` once a picture: whether the line is there. The decoder tells where frames end."""

    def __init__(self, port: SerialPort, protocol: str) -> None:
        self.port = port
        self.protocol = protocol
        self._was_lost = port.lost
        self._came_tick = 0
        self._begin()

    def read(self, tick: int) -> bytes:
        """What is given on in this tick."""
        data = self.port.read()
        if data:
            self._take(data, tick)
        elif self._rest and not 0 <= tick - self._came_tick <= SPREAD_MS:
            self._due.append((tick, bytes(self._rest)))  # no frame ends there any more: it is what it is
            self._begin(keep=True)
        out = b""
        while self._due and self._due[0][0] <= tick:
            out += self._due.popleft()[1]
        return out

    def _take(self, data: bytes, tick: int) -> None:
        spread = max(1, min(SPREAD_MS, tick - self._came_tick))
        self._came_tick = tick
        self._rest += data
        pieces = []
        for event in self._decoder.feed(data):
            end = event.offset + event.length - self._given
            if end > 0:
                pieces.append(bytes(self._rest[:end]))
                del self._rest[:end]
                self._given += end
        if len(self._rest) > LONGEST_REST:
            pieces.append(bytes(self._rest))
            self._begin(keep=True)
        late = max(0, len(pieces) - SPREAD_MS)  # more than a frame a tick is the past: nobody ran ticks for long
        for i, piece in enumerate(pieces[late:]):
            self._due.append((tick + i * spread // (len(pieces) - late), piece))

    def _begin(self, keep: bool = False) -> None:
        """Count the stream anew."""
        self._decoder = rc_decode.decoder(self.protocol)
        self._rest = bytearray()
        self._given = 0
        if not keep:
            self._due: deque[tuple[int, bytes]] = deque()

    def look(self) -> str:
        """Try to open it again if it is lost; what is to be said of it, where something has changed."""
        port = self.port
        port.revive()
        if bool(port.lost) is bool(self._was_lost):
            return ""
        self._was_lost = port.lost
        return f"{port.name}: {port.lost}; waiting for it" if port.lost else f"{port.name}: there again"

    def forget(self) -> None:
        """What has come so far shall reach nobody."""
        self.port.read()
        self._begin()

    def close(self) -> None:
        """Give the line back."""
        self.port.close()


def open_receiver(address: str, protocol: str) -> Receiver:
    """Open a receiver's line, set as the protocol's makers set it unless the address says otherwise.

    Raises UsageError, SurroundingsError.
    """
    return Receiver(open_serial("--rc", serial_address("--rc", address), USUAL[protocol]), protocol)
