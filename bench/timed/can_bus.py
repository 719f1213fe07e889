"""One CAN bus in bit times: who begins when the wire falls free, how long each frame lasts, what never gets its turn.

    bus = Arbitration()
    motors, base = bus.join(Mailboxes()), bus.join(Mailboxes())
    base.offer(0, Frame(0x200, bytes(8)))
    for sent in bus.run(until=1000): ...          # 1000 bits are a millisecond at 1 Mbit/s

Time is a whole number of bits, so that nothing rounds. Every frame has its exact length, stuff bits included. When the
wire falls free, the most urgent of all frames that wait begins, and is not interrupted (ISO 11898-1). There are no
errors on this wire: two stations that send one identifier at once would collide on a real one, and here go in order.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple, Protocol, TypeAlias, TypeVar

from bench.canbus.bits import GAP, frame_bits

Urgency: TypeAlias = tuple[int, bool, int, bool]


class Frame(NamedTuple):
    """A classic frame. `remote_length` makes it a remote frame that asks for so many bytes."""

    can_id: int
    data: bytes
    extended: bool = False
    remote_length: int | None = None

    @property
    def urgency(self) -> Urgency:
        """Bit by bit as the wire decides: eleven bits of identifier, a plain frame before an extended one, the other
        eighteen bits, data before a request for it. The least wins.
        """
        is_remote = self.remote_length is not None
        if self.extended:  # its substitute bit is recessive where a plain frame says data or remote
            return self.can_id >> 18, True, self.can_id & 0x3FFFF, is_remote
        return self.can_id, False, is_remote, is_remote

    @property
    def bits(self) -> int:
        """From its start to the earliest start of the next frame."""
        return frame_bits(self.can_id, self.data, extended=self.extended, remote_length=self.remote_length)


class Waiting(NamedTuple):
    """A frame that wants to go, and since when."""

    ready: int
    frame: Frame


class Sent(NamedTuple):
    """A frame that has been on the wire from `begin` to `end`, in bits; then everybody has it. `station` sent it."""

    begin: int
    end: int
    station: Station
    frame: Frame


class Station(Protocol):
    """A node's transmit side."""

    def offer(self, at: int, frame: Frame) -> bool:
        """A frame wants to go from now on; False where one is lost by that."""
        ...

    def waiting(self) -> Iterator[Waiting]:
        """The frames that take part in the next arbitration."""
        ...

    def take(self, frame: Waiting) -> None:
        """This one begins: it waits no more."""
        ...


AnyStation = TypeVar("AnyStation", bound=Station)


class Mailboxes:
    """A controller with a buffer for each identifier, as ESCs and most firmware have: a newer value takes the place of
    one that still waits. `lost` counts these.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._boxes: dict[tuple[bool, int], Waiting] = {}

    def offer(self, at: int, frame: Frame) -> bool:
        """Put it into its box."""
        box = frame.extended, frame.can_id
        is_free = box not in self._boxes
        self.lost += not is_free
        self._boxes[box] = Waiting(at, frame)
        return is_free

    def waiting(self) -> Iterator[Waiting]:
        """Every box."""
        return iter(self._boxes.values())

    def take(self, frame: Waiting) -> None:
        """Empty its box."""
        del self._boxes[frame.frame.extended, frame.frame.can_id]


class Queue:
    """A node that sends in the order in which it was told, as an operating system's queue does: an urgent frame waits
    behind a patient one. What finds the queue full is `lost`.
    """

    def __init__(self, most_frames: int) -> None:
        self.lost = 0
        self.most_frames = most_frames
        self._frames: deque[Waiting] = deque()

    @property
    def has_room(self) -> bool:
        """Whether one more frame finds a place."""
        return len(self._frames) < self.most_frames

    def offer(self, at: int, frame: Frame) -> bool:
        """To the end of the queue, where there is room."""
        if not self.has_room:
            self.lost += 1
            return False
        self._frames.append(Waiting(at, frame))
        return True

    def waiting(self) -> Iterator[Waiting]:
        """Its first frame alone."""
        return iter(tuple(self._frames)[:1])

    def take(self, frame: Waiting) -> None:
        """The first one goes."""
        self._frames.popleft()


class Arbitration:
    """The wire between stations. `busy_bits` is how long it was taken, gaps included."""

    def __init__(self) -> None:
        self.busy_bits = 0
        self._free_at = 0
        self._stations: list[Station] = []
        self._on_wire: Sent | None = None

    def join(self, station: AnyStation) -> AnyStation:
        """One more node; the same object comes back."""
        self._stations.append(station)
        return station

    def leave(self, station: Station) -> None:
        """A node is gone, with what it had not sent."""
        self._stations.remove(station)

    def run(self, until: int) -> list[Sent]:
        """All frames that are through before this time, in their order on the wire. Time never goes back."""
        sent: list[Sent] = []
        while True:
            now = self._on_wire or self._begin(until)
            if now is None:
                return sent
            if now.end > until:
                self._on_wire = now
                return sent
            self._on_wire = None
            sent.append(now)

    def busy_until(self, now: int) -> int:
        """How many bits of the time before `now` the wire was taken; what has begun goes on after it."""
        return self.busy_bits - max(0, self._free_at - now)

    @property
    def next_end(self) -> int | None:
        """When the next frame will be through as things stand; None where nobody wants to send. Nothing begins by it:
        what is offered before the wire falls free takes part.
        """
        if self._on_wire is not None:
            return self._on_wire.end
        first = self._next()
        return first[0] + first[1].frame.bits - GAP if first is not None else None

    def _next(self) -> tuple[int, Waiting, Station] | None:
        """When the wire is free and somebody wants it, and who gets it then."""
        wanting = [(one, station) for station in self._stations for one in station.waiting()]
        if not wanting:
            return None
        begin = max(self._free_at, min(one.ready for one, _ in wanting))
        chosen, station = min(
            ((one, station) for one, station in wanting if one.ready <= begin),
            key=lambda each: each[0].frame.urgency,
        )
        return begin, chosen, station

    def _begin(self, until: int) -> Sent | None:
        """Arbitrate once, at the first time before `until` at which the wire is free and somebody wants it."""
        first = self._next()
        if first is None or first[0] >= until:
            return None
        begin, chosen, station = first
        station.take(chosen)
        bits = chosen.frame.bits
        self._free_at = begin + bits
        self.busy_bits += bits
        return Sent(begin, begin + bits - GAP, station, chosen.frame)
