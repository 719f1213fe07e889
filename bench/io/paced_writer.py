"""The pace of a serial line, for wires that have none of their own: a pty, a socket."""

from __future__ import annotations

from bench.io.serial_port import SerialPort
from bench.rc.line import Settings


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
