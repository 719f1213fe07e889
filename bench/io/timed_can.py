"""A bus with time for any python-can program: `can.Bus("NAME", interface="wheelbench", bitrate=500_000)`.

All buses of one process with the same channel are nodes of one wire, which takes the time that a real one would: bits,
stuff bits, arbitration between the nodes' first frames. A message is received when its last bit is through, with that
time as its timestamp, in seconds since the channel was opened first. Real time passes: who receives waits.

A node sends in the order in which it was told, as an operating system's queue does; `tx_frames` have room, and one more
raises CanOperationError, once `timeout` is over. It keeps `rx_frames` that nobody has received; what comes then is lost
and counted in `overruns`. python-can's own `virtual` bus has no time and no end at all. A forked process has a wire of
its own from then on.
"""

from __future__ import annotations

import os
import threading
import weakref
from collections import deque
from typing import Any

import can

from bench.io.clock import now_ns
from bench.timed.can_bus import Arbitration, Frame, Queue, Sent

TX_FRAMES = 10
"""Room in a node's queue: what Linux gives a CAN interface (its txqueuelen)."""
RX_FRAMES = 1000
"""Room for what is not received yet: an eighth of a second of a full bus of 1 Mbit/s."""
_NS = 1_000_000_000
_LOCK = threading.RLock()
"""One for all wires, and re-entrant: a bus may be collected, and so shut down, in the middle of anything here."""


class _Wire:
    """One channel: the arbitration and everybody on it, by one clock. The lock guards all of that."""

    def __init__(self, name: str, bitrate: int) -> None:
        self.name, self.bitrate = name, bitrate
        self.changed = threading.Condition(_LOCK)
        self.bus = Arbitration()
        self.nodes: dict[Queue, weakref.ref[TimedBus]] = {}
        """Weakly, so that a bus which nobody holds any more leaves, though nobody has shut it down."""
        self._began_ns = now_ns()

    def now_bits(self) -> int:
        """Bit times since the channel was opened."""
        return (now_ns() - self._began_ns) * self.bitrate // _NS

    def seconds_until(self, bits: int) -> float:
        """How long from now; negative if it is over."""
        return (bits * _NS // self.bitrate - (now_ns() - self._began_ns)) / _NS

    def catch_up(self) -> None:
        """Give everybody what has come through by now."""
        for sent in self.bus.run(self.now_bits()):
            self._deliver(sent)

    def _deliver(self, sent: Sent) -> None:
        for station, held in tuple(self.nodes.items()):
            node = held()
            if node is not None and (station is not sent.station or node.hears_itself):
                node.take(sent, sent.end / self.bitrate, station is not sent.station)
        self.changed.notify_all()


_WIRES: dict[str, _Wire] = {}


def _begin_anew() -> None:
    """In a forked process: of its parent's threads, whichever held a lock is not there to let go of it."""
    global _LOCK
    _LOCK = threading.RLock()
    for wire in _WIRES.values():
        wire.changed = threading.Condition(_LOCK)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_anew)


class TimedBus(can.BusABC):
    """One node. `bitrate` is the wire's: the first node sets it, and one that asks for another is refused."""

    def __init__(
        self,
        channel: Any = "wheelbench",
        bitrate: int = 1_000_000,
        tx_frames: int = TX_FRAMES,
        rx_frames: int = RX_FRAMES,
        receive_own_messages: bool = False,
        **kwargs: Any,
    ) -> None:
        if not 1000 <= bitrate <= 1_000_000:
            raise can.CanInitializationError(f"bitrate {bitrate}: classic CAN has 1000 to 1000000")
        for key, frames in (("tx_frames", tx_frames), ("rx_frames", rx_frames)):
            if frames < 1:
                raise can.CanInitializationError(f"{key} {frames}: a node needs room for one frame")
        name = str(channel)
        self.hears_itself = receive_own_messages
        self.channel_info = f"wheelbench: {name} at {bitrate} bit/s"
        self._can_protocol = can.CanProtocol.CAN_20
        self._queue = Queue(tx_frames)
        self._rx_frames = rx_frames
        self._received: deque[can.Message] = deque()
        self.overruns = 0
        """Messages that came when there was no room for them."""
        with _LOCK:
            wire = self._wire = _WIRES.get(name) or _Wire(name, bitrate)
            if wire.bitrate != bitrate:
                raise can.CanInitializationError(f"{name} runs at {wire.bitrate} bit/s, not {bitrate}")
            super().__init__(channel=channel, **kwargs)  # raises for filters that are none: before it joins
            _WIRES[name] = wire
            wire.catch_up()
            wire.bus.join(self._queue)
            wire.nodes[self._queue] = weakref.ref(self)

    @property
    def load(self) -> float:
        """Share of the wire that has been used since the channel was opened, gaps included."""
        with self._wire.changed:
            self._wire.catch_up()
            now = self._wire.now_bits()
            return self._wire.bus.busy_bits / now if now else 0.0

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queue a message; with a timeout, wait so long for room. Raises CanOperationError where there is none."""
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("this wire carries classic data and remote frames only")
        remote_length = msg.dlc if msg.is_remote_frame else None
        frame = Frame(msg.arbitration_id, bytes(msg.data), msg.is_extended_id, remote_length)
        wire = self._wire
        deadline_ns = now_ns() + int((timeout or 0.0) * _NS)
        with wire.changed:
            while True:
                self._catch_up()
                if self._queue.has_room:
                    break
                left_s = (deadline_ns - now_ns()) / _NS
                if left_s <= 0.0:
                    raise can.CanOperationError(f"no room to send: {self._queue.most_frames} frames wait already")
                self._wait(left_s)
            self._queue.offer(wire.now_bits(), frame)
            wire.changed.notify_all()

    def take(self, sent: Sent, at_s: float, is_rx: bool) -> None:
        """The wire's word to a node: this frame is through."""
        if len(self._received) >= self._rx_frames:
            self.overruns += 1
            return
        frame = sent.frame
        self._received.append(
            can.Message(
                timestamp=at_s,
                arbitration_id=frame.can_id,
                is_extended_id=frame.extended,
                is_remote_frame=frame.remote_length is not None,
                dlc=len(frame.data) if frame.remote_length is None else frame.remote_length,
                data=frame.data,
                channel=self._wire.name,
                is_rx=is_rx,
            )
        )

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        wire = self._wire
        deadline_ns = None if timeout is None else now_ns() + int(timeout * _NS)
        with wire.changed:
            while True:
                self._catch_up()
                if self._received:
                    return self._received.popleft(), False
                left_s = None if deadline_ns is None else (deadline_ns - now_ns()) / _NS
                if left_s is not None and left_s <= 0.0:
                    return None, False
                self._wait(left_s)

    def _catch_up(self) -> None:
        """Hear what has come through. Raises CanOperationError where this bus is shut down, perhaps meanwhile."""
        if self._queue not in self._wire.nodes:
            raise can.CanOperationError(f"{self.channel_info}: this bus is shut down")
        self._wire.catch_up()

    def _wait(self, left_s: float | None) -> None:
        """Until a frame is through, somebody sends, or this time is over. Holds the wire's lock."""
        end = self._wire.bus.next_end
        if end is not None:
            through_s = max(0.0, self._wire.seconds_until(end))
            left_s = through_s if left_s is None else min(left_s, through_s)
        self._wire.changed.wait(left_s)

    def shutdown(self) -> None:
        """Leave the wire, with what has not been sent; the last one takes it down."""
        super().shutdown()
        with self._wire.changed:
            if self._wire.nodes.pop(self._queue, None) is not None:
                self._wire.bus.leave(self._queue)
            if not self._wire.nodes and _WIRES.get(self._wire.name) is self._wire:
                del _WIRES[self._wire.name]
            self._wire.changed.notify_all()
