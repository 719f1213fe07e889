"""The wires of one bench in time: what is put onto each in a millisecond, and what of it is through.

    tick t      .0  the base sends its commands                 .5  the motors send their reports         tick t + 1
                |-- commands that are through: to the motors --|-- reports that are through: to the base --|

A bus with room brings everything where it was: commands to the motors in their own tick, reports to the base in the
next. What is not through by then comes a tick later. The base has a buffer for each of its identifiers, and so has
every motor: a newer value takes the place of one that still waits, which is then lost. That reports come half a
millisecond after the commands is assumed: real ESCs run by clocks of their own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from bench.messages import CanFrame
from bench.rc.line import USUAL, Settings
from bench.timed.can_bus import Arbitration, Frame, Mailboxes, Sent, Station
from bench.timed.settings import Wires
from bench.timed.uart import Paced

MOST_LOGGED = 20_000
"""Frames that are kept for whoever logs until it takes them: two seconds of a full bus."""


class Timing:
    """The CAN bus between a base and its motors, the SLAMWARE line both ways, and the RC line.

    `lost_commands` and `lost_reports` count frames whose place a newer one took before their turn came; `lost_bytes`
    what found no room on a serial line.
    """

    def __init__(self, wires: Wires, rc_protocol: str | None) -> None:
        self.wires = wires
        self._bits_per_tick = wires.can_bitrate // 1000
        self._bus = Arbitration()
        self._base = self._bus.join(Mailboxes())
        self._motors = self._bus.join(Mailboxes())
        self._others = [(self._bus.join(Mailboxes()), Frame(can_id, bytes(8)), hz) for can_id, hz in wires.also]
        line = Settings(wires.slamware_baud)
        self._requests, self._answers = Paced(line), Paced(line)
        self._rc = Paced(USUAL[rc_protocol]) if rc_protocol is not None else None
        self._log: deque[Sent] | None = None
        self._early_reports: list[CanFrame] = []
        self._late_commands: list[CanFrame] = []

    @property
    def lost_commands(self) -> int:
        """Command frames that never went."""
        return self._base.lost

    @property
    def lost_reports(self) -> int:
        """Feedback frames that never went."""
        return self._motors.lost

    @property
    def lost_bytes(self) -> int:
        """Bytes that the serial lines could not carry."""
        return self._requests.lost + self._answers.lost + (self._rc.lost if self._rc is not None else 0)

    def load(self, ticks: int) -> float:
        """Share of the bus that has been used in so many ticks since the start, gaps included."""
        return self._bus.busy_until(self._bits_per_tick * ticks) / (self._bits_per_tick * ticks) if ticks else 0.0

    def facts(self, ticks: int) -> dict[str, float]:
        """The same for --json, after so many ticks."""
        return {
            "bus_load": round(self.load(ticks), 4),
            "lost_commands": self.lost_commands,
            "lost_reports": self.lost_reports,
            "lost_bytes": self.lost_bytes,
        }

    def take_up_rc(self, protocol: str | None) -> None:
        """From now on RC bytes come from a transmitter, not from a recording whose line has carried them already."""
        if self._rc is None and protocol is not None:
            self._rc = Paced(USUAL[protocol])

    def rc(self, data: bytes) -> bytes:
        """RC bytes that the transmitter sends in this millisecond -> those that are through at its end."""
        if self._rc is None:
            return data
        self._rc.put(data)
        return self._rc.step()

    def requests(self, data: bytes) -> bytes:
        """The same from core to base."""
        self._requests.put(data)
        return self._requests.step()

    def answers(self, data: bytes) -> bytes:
        """The same from base to core."""
        self._answers.put(data)
        return self._answers.step()

    def commands(self, tick: int, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """What the base sends at the beginning of this tick -> what reaches the motors in it."""
        start = tick * self._bits_per_tick
        for frame in frames:
            self._base.offer(start, Frame(*frame))
        for station, filler, hz in self._others:
            if tick * hz // 1000 != (tick - 1) * hz // 1000:
                station.offer(start, filler)
        arrived = self._late_commands
        commands, self._early_reports = self._through(start + self._bits_per_tick // 2)
        self._late_commands = []
        return (*arrived, *commands)

    def reports(self, tick: int, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """What the motors send in the middle of this tick -> what reaches the base at its end."""
        start = tick * self._bits_per_tick
        for frame in frames:
            self._motors.offer(start + self._bits_per_tick // 2, Frame(*frame))
        self._late_commands, reports = self._through(start + self._bits_per_tick)
        return (*self._early_reports, *reports)

    def start_log(self) -> Callable[[], list[tuple[int, CanFrame]]]:
        """From now on keep what was on the bus, for one who takes it: what this gives is `take_log`."""
        self._log = deque(maxlen=MOST_LOGGED)
        return self.take_log

    def take_log(self) -> list[tuple[int, CanFrame]]:
        """(time in us at which it was through, frame) of all that has been on the bus since the last call."""
        rate = self.wires.can_bitrate
        log = [(sent.end * 1_000_000 // rate, (sent.frame.can_id, sent.frame.data)) for sent in self._log or ()]
        if self._log is not None:
            self._log.clear()
        return log

    def __getstate__(self) -> dict[str, Any]:
        """A copy (a still of the history) goes on as this one would; nobody takes its log."""
        return {**self.__dict__, "_log": None}

    def _through(self, until: int) -> tuple[list[CanFrame], list[CanFrame]]:
        """Run the bus; frames of the base, and of the motors, that are through."""
        sent = self._bus.run(until)
        if self._log is not None:
            self._log += sent
        return self._of(self._base, sent), self._of(self._motors, sent)

    @staticmethod
    def _of(station: Station, sent: Sequence[Sent]) -> list[CanFrame]:
        return [(one.frame.can_id, one.frame.data) for one in sent if one.station is station]
