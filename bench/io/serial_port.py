"""A serial line as a port: bytes that have come, bytes to send, nothing that blocks, and no exception once it is open.

port = open_serial("rc", "serial:/dev/ttyUSB0?baud=100000&format=8E2")
data = port.read()                # a whole block, b"" where nothing has come
port.write(frame)
if port.lost: ...                 # why it cannot be used now; `revive` tries again, at most every half second
"""

from __future__ import annotations

from typing import Protocol

from bench.io.address import SerialAddress, serial_address
from bench.io.kinds.pty_port import PtyPort
from bench.io.kinds.serial_device import DevicePort
from bench.io.kinds.tcp_port import ListenPort, SocketPort
from bench.rc.line import Settings

EIGHT_N_ONE = Settings(115_200)


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

    def write(self, data: bytes, within_s: float = 0.0) -> bool:
        """Send; what the line does not take at once or in this time is dropped and counted. Whether all left."""
        ...

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        ...

    def close(self) -> None:
        """Give it back."""
        ...


def open_serial(name: str, address: str | SerialAddress, settings: Settings = EIGHT_N_ONE) -> SerialPort:
    """Open a serial line; `settings` hold where the address names none. Raises UsageError for an address that is none
    or `sim:`, which has no port; SurroundingsError where this machine cannot do it now.
    """
    if isinstance(address, str):
        address = serial_address(name, address, outside=True)
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
