"""A bus of python-can as a CAN port, and what its interfaces refuse in one sentence."""

from __future__ import annotations

import errno
import logging
import socket
from collections import deque
from collections.abc import Sequence
from difflib import get_close_matches
from functools import partial
from typing import TYPE_CHECKING, Any

from bench.errors import SurroundingsError, UsageError
from bench.io.address import CAN_BITRATE, CanAddress
from bench.io.clock import TICK_NS, now_ns, wait_ns
from bench.io.kinds import socketcand
from bench.io.kinds.tcp_port import CONNECT_S, RECONNECT_S
from bench.io.revival import Revivable
from bench.messages import CanFrame

if TYPE_CHECKING:
    import can

MOST_FRAMES = 200
"""Read at once, so that a flood cannot hold a loop: a bus at 1 Mbit/s brings at most 22 in a millisecond."""
FLOOD_READS = 10
"""So often in a row as much as that: somebody floods the bus."""
MOST_FAILURES = 16
"""In a row, until a bus counts as lost: one junk datagram or one full queue is no lost bus."""
MOST_ECHOES = 4096
_UNTIMED = ("socketcan", "virtual", "udp_multicast")
"""Interfaces that set no bitrate: one is given on only where the address has it."""


class BusPort(Revivable):
    """Message by message, as python-can has it. Raises UsageError, SurroundingsError."""

    _refusals = (SurroundingsError, UsageError)

    def __init__(self, name: str, address: CanAddress) -> None:
        super().__init__()
        self.name = name
        self.where = ""
        self.dropped_frames = 0
        self.other_frames = 0
        self.noise = 0
        self.note = ""
        self.is_flooded = False
        self._address = address
        self._failures = self._full_reads = 0
        self._bus: can.BusABC | None = None
        # Over multicast a sender hears itself: what comes back of ours, in the order sent, is not news.
        self._echoes: deque[CanFrame] | None = None
        if address.interface == "udp_multicast":
            self._echoes = deque(maxlen=MOST_ECHOES)
        self._opening = socketcand.Opening() if address.interface == "socketcand" else None
        self._timeout_s = CONNECT_S
        self._open()
        self._timeout_s = RECONNECT_S

    def read(self) -> tuple[CanFrame, ...]:
        """What has come since the last call, at most `MOST_FRAMES`; never waits."""
        frames: list[CanFrame] = []
        for _ in range(MOST_FRAMES):
            bus = self._bus
            if bus is None:
                break
            try:
                message = bus.recv(0)
            except Exception as error:  # interfaces raise what their drivers raise
                self._fail(error)
                continue
            if message is None:
                break
            self._take(message, frames)
        else:
            self._full_reads += 1
            self.is_flooded = self.is_flooded or self._full_reads >= FLOOD_READS
            return tuple(frames)
        self._full_reads = 0
        if frames:
            self._failures = 0
        return tuple(frames)

    def write(self, frames: Sequence[CanFrame], within_s: float = 0.0) -> bool:
        """Send; what the bus does not take at once or in this time is dropped and counted. Whether all left."""
        deadline_ns = now_ns() + int(within_s * 1e9)
        dropped = self.dropped_frames
        for frame in frames:
            bus = self._bus
            if bus is None:
                self.dropped_frames += 1
                continue
            error = _refused(bus, frame)
            while error is not None and now_ns() < deadline_ns:
                wait_ns(TICK_NS)
                error = _refused(bus, frame)
            if error is not None:
                self.dropped_frames += 1
                self._fail(error)
                continue
            if self._echoes is not None:
                self._echoes.append(frame)
            self._failures = 0
        return self.dropped_frames == dropped

    def close(self) -> None:
        """Shut the bus down."""
        self._release()
        if self._opening is not None:
            self._opening.give_up()

    def _take(self, message: can.Message, frames: list[CanFrame]) -> None:
        if message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd:
            self.other_frames += 1
            return
        frame = (message.arbitration_id, bytes(message.data))
        if not self._echoes or not self._is_echo(self._echoes, frame):
            frames.append(frame)

    @staticmethod
    def _is_echo(echoes: deque[CanFrame], frame: CanFrame) -> bool:
        if frame not in echoes:
            return False
        while echoes.popleft() != frame:  # those before it went missing
            pass
        return True

    def _fail(self, error: Exception) -> None:
        self.noise += 1
        self._failures += 1
        gone = isinstance(error, OSError) or self._failures >= MOST_FAILURES
        if gone and self._bus is not None:
            self._lose(self._why(error))

    @staticmethod
    def _why(error: Exception) -> str:
        return str(error) or type(error).__name__

    def _open(self) -> None:
        import can

        # Its modules print to stderr where nobody listens to their logs; what matters is in our sentence.
        logger = logging.getLogger("can")
        if not logger.handlers:
            logger.addHandler(logging.NullHandler())
        address = self._address
        options: dict[str, Any] = dict(address.options)
        if address.bitrate is not None or address.interface not in _UNTIMED:
            options.setdefault("bitrate", address.bitrate or CAN_BITRATE)
        if self._opening is not None:
            socketcand.ask(self.name, options, self._timeout_s)
        try:
            if address.interface == "socketcan":
                _ask_kernel(address.channel)
            make = partial(can.Bus, interface=address.interface, channel=address.channel, **options)
            self._bus = make() if self._opening is None else self._opening.within(self._timeout_s, make)
        except Exception as error:  # anything at all, from a missing library's NameError on
            raise _refusal(self.name, address, error) from None

    def _release(self) -> None:
        self._failures = 0
        if self._echoes is not None:
            self._echoes.clear()
        bus, self._bus = self._bus, None
        if bus is not None:
            try:
                bus.shutdown()
            except Exception as error:
                self.note = f"did not close well: {error}"


def _refused(bus: can.BusABC, frame: CanFrame) -> Exception | None:
    """Why this frame could not be sent now."""
    import can

    can_id, data = frame
    try:
        bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=0)
    except Exception as error:  # interfaces raise what their drivers raise
        return error
    return None


def _ask_kernel(channel: str) -> None:
    """Raise OSError where SocketCAN has no such interface: python-can's bus would leave its socket open then."""
    if not hasattr(socket, "AF_CAN"):
        raise OSError(errno.EAFNOSUPPORT, "no SocketCAN on this system")
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
        probe.bind((channel,))


def _refusal(title: str, address: CanAddress, error: Exception) -> SurroundingsError | UsageError:
    """What an interface says when it will not open, as one sentence with what to try."""
    import can

    said = " ".join(str(error).split()) or type(error).__name__
    interface = address.interface
    if interface not in can.VALID_INTERFACES:
        near = get_close_matches(interface, can.VALID_INTERFACES, 1)
        meant = f"; did you mean {near[0]}?" if near else f"; it knows {', '.join(sorted(can.VALID_INTERFACES))}"
        return UsageError(f"{title}: python-can has no interface {interface!r}{meant}")
    if isinstance(error, TypeError) or "unexpected keyword" in said:
        return UsageError(f"{title}: python-can's {interface} does not take these options ({said})")
    return SurroundingsError(f"{title}: {_trouble(address, error, said)}")


def _trouble(address: CanAddress, error: Exception, said: str) -> str:
    """What this machine lacks for an interface that there is, and what to try."""
    interface = address.interface
    if interface == "socketcan":
        number = getattr(error, "errno", None) or getattr(error, "error_code", None)
        if number == errno.EAFNOSUPPORT:
            return "this kernel has no SocketCAN; use can:slcan:/dev/ttyACM0 with the adapter"
        up = f"sudo ip link set {address.channel} up type can bitrate {address.bitrate or CAN_BITRATE}"
        return f"{address.channel} cannot be used ({said}); bring it up: {up}"
    if interface == "socketcand":
        where = f"{address.options['host']}:{address.options['port']}"
        what = "greets and then says nothing" if isinstance(error, TimeoutError) else f"greets, but no more ({said})"
        return f"socketcand at {where} {what}; restart it there, with {address.channel} among its buses"
    if interface == "udp_multicast" and "msgpack" in said:
        return "needs msgpack; try: pip install 'wheelbench[multicast]'"
    if interface == "udp_multicast":
        return f"{said}; a group such as 239.74.163.2 is needed, and a network that is up"
    if isinstance(error, (ImportError, NameError)) or "No module named" in said or "not found" in said:
        return f"python-can lacks the driver of {interface} ({said}); install its maker's"
    return f"{interface} will not open ({said}); is the adapter plugged in and free?"
