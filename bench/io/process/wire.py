"""What a real-time loop in a process of its own and its parent say to each other, and the wire that carries it.

parent                                        child
Inputs of the operator, a little ahead  --->  one for each tick; none there: silence
Beat, at every `advance`                --->  none for a quarter of a second: silence
Stop                                    --->  the run ends
Ready, once                             <---  the ports are made; ticks begin when they are there
State, twenty times a second; Notice    <---  dropped while the parent does not read
End, once                               <---  error or result
"""

from __future__ import annotations

import pickle
import select
import socket
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias

from bench.errors import BenchError
from bench.io.lateness import Lateness
from bench.messages import Snapshot, TickInput, TickOutput

MOST_BYTES = 1 << 18


class Inputs(NamedTuple):
    """What enters this tick and the next ones."""

    first_tick: int
    inputs: Sequence[TickInput]


class Beat(NamedTuple):
    """The parent lives."""


class Stop(NamedTuple):
    """Come to an end."""


class PortNote(NamedTuple):
    """A port, as the person should know it."""

    name: str
    where: str
    note: str


class Ready(NamedTuple):
    """What the child has opened."""

    ports: tuple[PortNote, ...]


class Notice(NamedTuple):
    """A sentence for the person."""

    tick: int
    text: str


class State(NamedTuple):
    """What the child tells while it runs."""

    tick: int
    at_ns: int
    """When that was; the clock is the same in both processes."""
    snapshot: Snapshot | None
    outs: tuple[TickOutput, ...]
    """The ticks since the last one, as far as somebody watches them: what is made of them is made by the parent."""
    late_us: float
    """The most since the last one."""
    slipped_ticks: int
    missing: tuple[str, ...]


class End(NamedTuple):
    """The child's last word."""

    tick: int
    error: BenchError | None
    result: object
    """What `Prepared.finish` gave."""
    lateness: Lateness
    scheduling: str


Word: TypeAlias = Inputs | Beat | Stop | Ready | Notice | State | End


class Wire:
    """One end: words arrive whole and in their order. `is_cut` once the other end is gone and all it said is heard."""

    def __init__(self, end: socket.socket) -> None:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_BYTES)
        self.is_cut = False
        self._end = end

    def tell(self, word: Word) -> None:
        """Say it if there is room; dropped where the other end does not read, or is gone."""
        with suppress(OSError):
            self._end.send(pickle.dumps(word), socket.MSG_DONTWAIT)

    def tell_at_last(self, word: Word) -> None:
        """Say what has to arrive: waits for room, as long as there is another end."""
        self._end.setblocking(True)
        with suppress(OSError):
            self._end.send(pickle.dumps(word))

    def heard(self) -> Iterator[Word]:
        """What has come; never waits."""
        while not self.is_cut:
            try:
                data = self._end.recv(MOST_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except ConnectionResetError:
                continue  # it left before it read all of ours; what it had said is still there
            except OSError:
                data = b""
            if data:
                yield pickle.loads(data)
            else:
                self.is_cut = True

    def wait(self, seconds: float) -> None:
        """Until something has come, at most so long."""
        select.select([self._end], [], [], seconds)

    def close(self) -> None:
        """Leave."""
        self._end.close()


def wire_pair() -> tuple[Wire, Wire]:
    """Both ends of a new wire."""
    one, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    return Wire(one), Wire(other)
