"""The pace of a serial line, for wires that have none of their own: a pty, a socket."""

from __future__ import annotations

from bench.io.serial_port import SerialPort
from bench.rc.line import Settings
from bench.timed.uart import Paced


class PacedWriter:
    """Sends bytes no faster than their line would: where nothing paces them (a pty, a socket), so that frames have a
    duration at the other end too. `step` once a millisecond.
    """

    def __init__(self, port: SerialPort, settings: Settings) -> None:
        self.port = port
        self._line = Paced(settings)

    def put(self, data: bytes) -> None:
        """Queue; more than half a second's worth is dropped from the front and counted by the port."""
        self.port.dropped_bytes += self._line.put(data)

    def step(self) -> bytes:
        """Send what a millisecond carries; what that was."""
        data = self._line.step()
        if data:
            self.port.write(data)
        return data
