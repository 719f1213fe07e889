"""CAN buses as ports: frames that have come, frames to send, nothing that blocks, and no exception once it is open.

    port = open_can("can", "can:slcan:/dev/ttyACM0@1000000")
    frames = port.read()              # (identifier, data) of all that has come
    port.write(frames)
    if port.lost: ...                 # why it cannot be used now; `revive` tries again, at most every half second

python-can brings the interfaces; SLCAN adapters are read by `slcan` in blocks, because python-can's reader asks for one
byte at a time. Extended, remote, error and FD frames are no motor's of ours: counted and left out.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Protocol

from bench.errors import SurroundingsError, UsageError
from bench.io.address import CAN_BITRATE, CanAddress, can_address
from bench.io.clock import now_ns, wait_ns
from bench.io.serial_port import RETRY_NS, SerialPort, open_serial
from bench.io.slcan import BITRATES, CLOSING, REFUSED, SlcanReader, encode, opening
from bench.messages import CanFrame
from bench.rc.line import Settings

if TYPE_CHECKING:
    import can

MOST_FRAMES = 200
"""Read at once, so that a flood cannot hold a loop: a bus at 1 Mbit/s brings at most 22 in a millisecond."""
FLOOD_READS = 10
"""So often in a row as much as that: somebody floods the bus."""
CROSSED_FRAMES = 2000
MOST_FAILURES = 16
"""In a row, until a bus counts as lost: one junk datagram or one full queue is no lost bus."""
ANSWER_NS = 300_000_000
ADAPTER_LINE = Settings(115_200)
"""USB adapters ignore it; those on a real UART are set to it by most makers."""


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

    def write(self, frames: Sequence[CanFrame]) -> None:
        """Send; what the bus does not take at once is dropped and counted."""
        ...

    def revive(self) -> bool:
        """Try to open it again if it is lost and the time has come; whether it is open now."""
        ...

    def close(self) -> None:
        """Give it back."""
        ...


class SlcanPort:
    """An SLCAN adapter on a serial line. Opening sets its bitrate; coming back from a loss does so again."""

    def __init__(self, name: str, line: SerialPort, bitrate: int) -> None:
        if bitrate not in BITRATES:
            line.close()
            raise UsageError(f"{name}: an SLCAN adapter knows {', '.join(map(str, BITRATES))} bit/s; take one of them")
        self.name = name
        self.line = line
        self.where = line.where
        self.dropped_frames = 0
        self.note = line.note
        self._reader = SlcanReader()
        self._opening = opening(bitrate)
        self._is_set = False
        if not line.lost:
            self._greet()

    @property
    def lost(self) -> str:
        """Of the line."""
        return self.line.lost

    @property
    def losses(self) -> int:
        """Of the line."""
        return self.line.losses

    @property
    def other_frames(self) -> int:
        """Extended and remote frames."""
        return self._reader.other_frames

    @property
    def noise(self) -> int:
        """Lines that were neither a frame nor an answer."""
        return self._reader.noise_lines

    @property
    def is_flooded(self) -> bool:
        """Of the line."""
        return self.line.is_flooded

    def read(self) -> tuple[CanFrame, ...]:
        """A block, cut into its frames."""
        data = self.line.read()
        if self.line.lost:
            self._is_set = False
        elif not self._is_set:
            self._set()
        return tuple(self._reader.feed(data)) if data else ()

    def write(self, frames: Sequence[CanFrame]) -> None:
        """All frames in one write."""
        if self.line.lost:
            self.dropped_frames += len(frames)
        elif frames:
            if not self._is_set:
                self._set()
            self.line.write(b"".join([encode(frame) for frame in frames]))

    def revive(self) -> bool:
        """The line again, and then the adapter, which may have lost its power with it."""
        if not self.line.revive():
            self._is_set = False
            return False
        if not self._is_set:
            self._set()
        return True

    def close(self) -> None:
        """Close the adapter's channel and the line."""
        if not self.line.lost:
            self.line.write(CLOSING)
        self.line.close()

    def _set(self) -> None:
        self.line.write(self._opening)
        self._is_set = True

    def _greet(self) -> None:
        """Open the channel and see whether an adapter is there. Some never answer: they are believed, and noted."""
        self.line.read()
        self._set()
        self.line.write(b"V\r")
        heard = b""
        deadline_ns = now_ns() + ANSWER_NS
        while b"V" not in heard and now_ns() < deadline_ns and not self.line.lost:
            wait_ns(1_000_000)
            heard += self.line.read()
        # C on a closed channel is refused by right; S and O are the last two before V.
        before = heard.partition(b"V")[0]
        if REFUSED in before[-2:]:
            self.line.close()
            raise SurroundingsError(
                f"{self.name}: the adapter refuses to open; try another bitrate, or plug it in anew"
            )
        if not heard:
            self.note = "the adapter answers nothing; some do not, but check that it is one if no frames come"
        self._reader.feed(heard)


class BusPort:
    """A bus of python-can."""

    def __init__(self, name: str, address: CanAddress) -> None:
        self.name = name
        self.where = ""
        self.lost = ""
        self.losses = 0
        self.dropped_frames = 0
        self.other_frames = 0
        self.noise = 0
        self.note = ""
        self.is_flooded = False
        self._address = address
        self._failures = self._full_reads = 0
        self._retry_ns = 0
        self._bus: can.BusABC | None = None
        # Over multicast a sender hears itself: what comes back of ours, in the order sent, is not news.
        self._echoes: deque[CanFrame] | None = deque(maxlen=4096) if address.interface == "udp_multicast" else None
        self._open()

    def read(self) -> tuple[CanFrame, ...]:
        """Message by message, as python-can has it."""
        bus = self._bus
        if bus is None:
            return ()
        frames: list[CanFrame] = []
        for _ in range(MOST_FRAMES):
            try:
                message = bus.recv(0)
            except Exception as error:  # interfaces raise what their drivers raise
                self._fail(error)
                if self._bus is None:
                    break
                continue
            if message is None:
                break
            if message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd:
                self.other_frames += 1
                continue
            frame = (message.arbitration_id, bytes(message.data))
            if not self._echoes or not self._is_echo(frame):
                frames.append(frame)
        else:
            self._full_reads += 1
            self.is_flooded = self.is_flooded or self._full_reads >= FLOOD_READS
            return tuple(frames)
        self._full_reads = 0
        if frames:
            self._failures = 0
        return tuple(frames)

    def write(self, frames: Sequence[CanFrame]) -> None:
        """Message by message."""
        import can

        for frame in frames:
            bus = self._bus
            if bus is None:
                self.dropped_frames += 1
                continue
            can_id, data = frame
            try:
                bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=0)
            except Exception as error:
                self.dropped_frames += 1
                self._fail(error)
            else:
                if self._echoes is not None:
                    self._echoes.append(frame)
                self._failures = 0

    def revive(self) -> bool:
        """Open it anew."""
        if not self.lost:
            return True
        if now_ns() < self._retry_ns:
            return False
        self._retry_ns = now_ns() + RETRY_NS
        try:
            self._open()
        except (SurroundingsError, UsageError) as error:
            self.lost = str(error)
            return False
        self.lost = ""
        return True

    def close(self) -> None:
        """Shut the bus down."""
        bus, self._bus = self._bus, None
        if bus is not None:
            try:
                bus.shutdown()
            except Exception as error:
                self.note = f"did not close well: {error}"

    def _is_echo(self, frame: CanFrame) -> bool:
        echoes = self._echoes
        assert echoes is not None
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
            self.close()
            self.lost = str(error) or type(error).__name__
            self.losses += 1
            self._failures = 0
            self._retry_ns = now_ns() + RETRY_NS
            if self._echoes is not None:
                self._echoes.clear()

    def _open(self) -> None:
        import can

        # Its modules print to stderr where nobody listens to their logs; what matters is in our sentence.
        logger = logging.getLogger("can")
        if not logger.handlers:
            logger.addHandler(logging.NullHandler())
        address = self._address
        options: dict[str, Any] = dict(address.options)
        if address.bitrate is not None or address.interface not in ("socketcan", "virtual", "udp_multicast"):
            options.setdefault("bitrate", address.bitrate or CAN_BITRATE)
        try:
            self._bus = can.Bus(interface=address.interface, channel=address.channel, **options)
        except Exception as error:  # anything at all, from a missing library's NameError on
            raise _refusal(self.name, address, error) from None


class _Crossed:
    """One end of a bus inside the process."""

    def __init__(self, name: str, mine: deque[CanFrame], theirs: deque[CanFrame]) -> None:
        self.name, self.where, self.lost, self.note = name, "", "", ""
        self.losses = self.dropped_frames = self.other_frames = self.noise = 0
        self.is_flooded = False
        self._mine, self._theirs = mine, theirs

    def read(self) -> tuple[CanFrame, ...]:
        """What the other end has sent."""
        frames = tuple(self._mine)
        self._mine.clear()
        return frames

    def write(self, frames: Sequence[CanFrame]) -> None:
        """To the other end."""
        self._theirs.extend(frames)

    def revive(self) -> bool:
        """It is never lost."""
        return True

    def close(self) -> None:
        """Nothing to give back."""


def crossed() -> tuple[CanPort, CanPort]:
    """Two ends of one bus inside the process: what one writes, the other reads."""
    left: deque[CanFrame] = deque(maxlen=CROSSED_FRAMES)
    right: deque[CanFrame] = deque(maxlen=CROSSED_FRAMES)
    return _Crossed("sim:", left, right), _Crossed("sim:", right, left)


def open_can(name: str, address: str | CanAddress) -> CanPort:
    """Open a CAN bus. Raises UsageError for an address that is none, SurroundingsError where this machine cannot do it
    now; ValueError for `sim:`, which has no port.
    """
    if isinstance(address, str):
        address = can_address(name, address)
    if address.is_sim:
        raise ValueError(f"{name}: a bus inside the process has no port")
    title = f"{name} {address.text}"
    if address.line is not None:
        line = open_serial(name, address.line._replace(text=address.text), ADAPTER_LINE)
        return SlcanPort(title, line, address.bitrate or CAN_BITRATE)
    return BusPort(title, address)


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
    if interface == "socketcan":
        number = getattr(error, "errno", None) or getattr(error, "error_code", None)
        if number == 97:
            return SurroundingsError(
                f"{title}: this kernel has no SocketCAN; use can:slcan:/dev/ttyACM0 with the adapter"
            )
        up = f"sudo ip link set {address.channel} up type can bitrate {address.bitrate or CAN_BITRATE}"
        return SurroundingsError(f"{title}: {address.channel} cannot be used ({said}); bring it up: {up}")
    if interface == "udp_multicast" and "msgpack" in said:
        return SurroundingsError(f"{title}: needs msgpack; try: pip install 'wheelbench[multicast]'")
    if interface == "udp_multicast":
        return SurroundingsError(f"{title}: {said}; a group such as 239.74.163.2 is needed, and a network that is up")
    missing = isinstance(error, (ImportError, NameError)) or "No module named" in said or "not found" in said
    if missing:
        return SurroundingsError(f"{title}: python-can lacks the driver of {interface} ({said}); install its maker's")
    return SurroundingsError(f"{title}: {interface} will not open ({said}); is the adapter plugged in and free?")
