"""An SLCAN adapter as a CAN port: its text on any serial line, read in blocks.

python-can has such an interface too, but its reader asks for one byte at a time.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.errors import SurroundingsError, UsageError
from bench.io.clock import now_ns, wait_ns
from bench.io.serial_port import SerialPort
from bench.io.slcan import BITRATES, CLOSING, REFUSED, SlcanReader, encode, opening
from bench.messages import CanFrame
from bench.rc.line import Settings

ANSWER_NS = 300_000_000
ADAPTER_LINE = Settings(115_200)
"""USB adapters ignore it; those on a real UART are set to it by most makers."""


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
        self._is_set = self._is_cut = False
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

    def write(self, frames: Sequence[CanFrame], within_s: float = 0.0) -> bool:
        """All frames in one write. Where a full line has cut the one before, its half frame is ended first."""
        line = self.line
        if line.lost:
            self.dropped_frames += len(frames)
        elif frames:
            if not self._is_set:
                self._set()
            text = (b"\r" if self._is_cut else b"") + b"".join([encode(frame) for frame in frames])
            before = line.dropped_bytes
            self._is_cut = not line.write(text, within_s)
            if self._is_cut:
                cut = text[len(text) - (line.dropped_bytes - before) :].count(b"\r")
                self.dropped_frames += min(cut, len(frames))
            return not self._is_cut
        return not frames

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
            self.line.write(b"\r" + CLOSING if self._is_cut else CLOSING)
        self.line.close()

    def _set(self) -> None:
        self._is_set = self.line.write(self._opening)
        self._is_cut = not self._is_set

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
