"""Real wires between our own base and our own world, in the role `sim`: proof that the bytes are real.

    sim:                 in the process, the default
    pty:                 a pseudo-terminal pair, pyserial at the base's end
    can:virtual:NAME     python-can's in-process bus, a real `can.Bus` at either end

Each wire carries a tick's bytes from one end to the other and waits for them, so that a run over real ports has the
same recording as one without. Where a part is foreign, `roles` has the ports.
"""

from __future__ import annotations

import os
import tty
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING

from bench.errors import SurroundingsError, UsageError
from bench.io.address import can_address, serial_address
from bench.messages import CanFrame, TickInput
from bench.world import World

if TYPE_CHECKING:
    import can

TIMEOUT_S = 2.0
"""How long a wire may take for bytes that are on their way; on a busy machine a pty needs some milliseconds."""
PIECE_BYTES = 1024
"""A pty holds 4095 bytes; more at once would block the writer for ever, there being one thread."""


class PtyWire:
    """A pseudo-terminal pair: the device writes to one end, the base reads the other through pyserial."""

    def __init__(self, name: str) -> None:
        import serial

        self._name = name
        try:
            self._device, base_end = os.openpty()
            tty.setraw(base_end)
            self._base = serial.Serial(os.ttyname(base_end), 115200, timeout=TIMEOUT_S, write_timeout=TIMEOUT_S)
            os.close(base_end)
            os.set_blocking(self._device, True)
        except (OSError, serial.SerialException) as error:
            raise SurroundingsError(f"{name}: no pseudo-terminal can be opened ({error}); use sim: instead") from None

    def to_base(self, data: bytes) -> bytes:
        """Through the pair, from the device's end."""
        received = b""
        for start in range(0, len(data), PIECE_BYTES):
            piece = data[start : start + PIECE_BYTES]
            os.write(self._device, piece)
            received += self._base.read(len(piece))
        return self._whole(data, received)

    def from_base(self, data: bytes) -> bytes:
        """Through the pair, from the base's end."""
        received = b""
        for start in range(0, len(data), PIECE_BYTES):
            piece = data[start : start + PIECE_BYTES]
            self._base.write(piece)
            arrived = b""
            while len(arrived) < len(piece):
                arrived += os.read(self._device, len(piece) - len(arrived))
            received += arrived
        return self._whole(data, received)

    def close(self) -> None:
        """Close both ends."""
        self._base.close()
        os.close(self._device)

    def _whole(self, sent: bytes, received: bytes) -> bytes:
        if len(received) < len(sent):
            raise SurroundingsError(
                f"{self._name}: {len(sent) - len(received)} bytes did not arrive in {TIMEOUT_S:g} s"
            )
        return received


class VirtualCanWire:
    """python-can's `virtual` interface: two buses on one channel."""

    def __init__(self, channel: str) -> None:
        import can

        self._channel = channel
        self._base: can.BusABC = can.Bus(interface="virtual", channel=channel)
        self._motors: can.BusABC = can.Bus(interface="virtual", channel=channel)

    def to_base(self, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """Sent by the motors' bus, received by the base's."""
        return self._carry(self._motors, self._base, frames)

    def from_base(self, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """Sent by the base's bus, received by the motors'."""
        return self._carry(self._base, self._motors, frames)

    def close(self) -> None:
        """Shut both buses down."""
        self._base.shutdown()
        self._motors.shutdown()

    def _carry(self, sender: can.BusABC, receiver: can.BusABC, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        import can

        received = []
        for can_id, data in frames:
            sender.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))
        for _ in frames:
            message = receiver.recv(TIMEOUT_S)
            if message is None:
                raise SurroundingsError(f"can:virtual:{self._channel}: a frame did not arrive in {TIMEOUT_S:g} s")
            received.append((message.arbitration_id, bytes(message.data)))
        return tuple(received)


class WiredWorld(World):
    """A world whose bytes cross real ports on their way to and from the base. A context manager; closes its wires."""

    def __init__(self, world: World, *, rc: str = "sim:", slamware: str = "sim:", can: str = "sim:") -> None:
        super().__init__(world.robot, core=world.core, motors=world.motors)
        self._inner = world
        self.timing = world.timing
        self._rc = self._slamware = None
        self._can: VirtualCanWire | None = None
        try:
            self._rc = serial_wire("rc", rc)
            self._slamware = serial_wire("slamware", slamware)
            self._can = can_wire(can)
        except BaseException:
            self.close()
            raise

    def speak(self, tick: int, given: TickInput) -> tuple[bytes, bytes, tuple[CanFrame, ...]]:
        """As `World.speak`, through the ports."""
        rc, core_to_base, feedback = self._inner.speak(tick, given)
        if self._rc is not None and rc:
            rc = self._rc.to_base(rc)
        if self._slamware is not None and core_to_base:
            core_to_base = self._slamware.to_base(core_to_base)
        if self._can is not None and feedback:
            feedback = self._can.to_base(feedback)
        return rc, core_to_base, feedback

    def hear(self, tick: int, can_out: Sequence[CanFrame], slamware_out: bytes) -> tuple[CanFrame, ...]:
        """As `World.hear`, through the ports."""
        if self._can is not None and can_out:
            can_out = self._can.from_base(can_out)
        if self._slamware is not None and slamware_out:
            slamware_out = self._slamware.from_base(slamware_out)
        return self._inner.hear(tick, can_out, slamware_out)

    def close(self) -> None:
        """Close every port."""
        for wire in (self._rc, self._slamware, self._can):
            if wire is not None:
                wire.close()
        self._rc = self._slamware = self._can = None

    def __enter__(self) -> WiredWorld:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def serial_wire(name: str, text: str) -> PtyWire | None:
    """The serial wire of an address; None is a wire inside the process. Raises UsageError for another address."""
    address = serial_address(f"--{name}", text)
    if address.is_sim:
        return None
    if address.kind == "pty" and not address.place:
        return PtyWire(name)
    role = "base" if name == "rc" else "base or core"
    raise UsageError(f"--{name} {text}: whoever is there is no part of the simulation; give --role {role}")


def can_wire(text: str) -> VirtualCanWire | None:
    """The CAN wire of an address; None is a wire inside the process. Raises UsageError for another address."""
    if text == "recorded":
        raise UsageError("--can recorded: goes with a recording; give its directory as SOURCE")
    address = can_address("--can", text)
    if address.is_sim:
        return None
    if address.interface == "virtual":
        return VirtualCanWire(address.channel)
    raise UsageError(f"--can {text}: whoever is there is no part of the simulation; give --role base or --role motors")
