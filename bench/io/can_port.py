"""A CAN bus as a port: frames that have come, frames to send, nothing that blocks, and no exception once it is open.

    port = open_can("can", "can:slcan:/dev/ttyACM0@1000000")
    frames = port.read()              # (identifier, data) of all that has come
    port.write(frames)
    if port.lost: ...                 # why it cannot be used now; `revive` tries again, at most every half second

Extended, remote, error and FD frames are no motor's of ours: counted and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from bench.io.address import CAN_BITRATE, CanAddress, can_address
from bench.io.kinds.bus_port import BusPort
from bench.io.kinds.slcan_port import ADAPTER_LINE, SlcanPort
from bench.io.serial_port import open_serial
from bench.messages import CanFrame

LAST_WORD_S = 1.0
"""A line may be full for a moment, and an ESC keeps its last current: so long the last word waits for room."""


class CanPort(Protocol):
    """What every bus can do."""

    @property
    def name(self) -> str:
        """Its address, as the user gave it."""
        ...

    @property
    def where(self) -> str:
        """What the other end opens, where that is not the address itself."""
        ...

    @property
    def lost(self) -> str:
        """Why it cannot be used now; empty while it can."""
        ...

    @property
    def losses(self) -> int:
        """How often it was lost."""
        ...

    @property
    def dropped_frames(self) -> int:
        """What could not be sent."""
        ...

    @property
    def other_frames(self) -> int:
        """Extended, remote, error and FD frames that came."""
        ...

    @property
    def noise(self) -> int:
        """What came and was no frame."""
        ...

    @property
    def is_flooded(self) -> bool:
        """Whether more has come than a real bus could bring; it stays so."""
        ...

    @property
    def note(self) -> str:
        """What the user should know of it."""
        ...

    def read(self) -> tuple[CanFrame, ...]:
        """What has come since the last call; never waits."""
        ...

    def write(self, frames: Sequence[CanFrame], within_s: float = 0.0) -> bool:
        """Send; what the bus does not take at once or in this time is dropped and counted. Whether all left."""
        ...

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        ...

    def close(self) -> None:
        """Give it back."""
        ...


def open_can(name: str, address: str | CanAddress) -> CanPort:
    """Open a CAN bus. Raises UsageError for an address that is none or `sim:`, which has no port;
    SurroundingsError where this machine cannot do it now.
    """
    if isinstance(address, str):
        address = can_address(name, address, outside=True)
    if address.is_sim:
        raise ValueError(f"{name}: a bus inside the process has no port")
    title = f"{name} {address.text}"
    if address.line is not None:
        line = open_serial(name, address.line._replace(text=address.text), ADAPTER_LINE)
        return SlcanPort(title, line, address.bitrate or CAN_BITRATE)
    return BusPort(title, address)
