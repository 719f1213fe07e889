"""An SLCAN adapter, as drivers meet it: the command set of the LAWICEL CAN232 (manual, version 3), on any serial line.

    S0 .. S8   bitrate        only while closed        Z0 Z1   time stamps     only while closed
    sxxyy      BTR registers  only while closed        V v     version         always
    O  L       open, listen   only when set, closed    N       serial number   always
    C          close          only while open          F       status flags    only while open
    t T r R    transmit       only while open, not after L

Done is answered with CR (V, N, F with their text; a frame with z or Z in front), refused with BEL. An empty line is
answered with CR. What is no command, and what is longer than any command, is refused; nothing is kept of it.
"""

from __future__ import annotations

from binascii import unhexlify
from collections.abc import Sequence

from bench.io.can_port import LAST_WORD_S, CanPort
from bench.io.limiter import Limiter
from bench.io.serial_port import SerialPort
from bench.io.slcan import BITRATES
from bench.messages import CanFrame

OK, REFUSED = b"\r", b"\a"
VERSION, SERIAL_NUMBER = b"V1013\r", b"NA123\r"
MOST_COMMAND_BYTES = 32
STAMP_TURN_MS = 60_000
"""Time stamps count milliseconds and begin anew each minute."""
_BITRATE_OF = {b"%d" % digit: bitrate for bitrate, digit in BITRATES.items()}
_HEX = frozenset(b"0123456789ABCDEFabcdef")


class SlcanAdapter:
    """The adapter itself: text in, text and frames out. No port, no clock: `tick` is its millisecond counter.

    `sent` holds the standard data frames that the host has put on the bus, until `take_sent`; `other_frames` counts
    extended and remote ones. `commands` counts what was understood, `refused` what was not.
    """

    def __init__(self) -> None:
        self.bitrate: int | None = None
        self.is_open = False
        self.listens_only = False
        self.stamps = False
        self.commands = 0
        self.refused = 0
        self.other_frames = 0
        self.sent: list[CanFrame] = []
        self._line = b""
        self._is_set = False
        self._too_long = False

    def feed(self, data: bytes) -> bytes:
        """Text from the host -> the answers to what it completes."""
        lines = (self._line + data).split(OK)
        self._line = lines.pop()
        answers = []
        for line in lines:
            too_long = self._too_long or len(line) > MOST_COMMAND_BYTES
            self._too_long = False
            answer = REFUSED if too_long else self._command(line)
            if answer == REFUSED:
                self.refused += 1
            else:
                self.commands += 1
            answers.append(answer)
        if len(self._line) > MOST_COMMAND_BYTES:
            self._line, self._too_long = b"", True
        return b"".join(answers)

    def take_sent(self) -> tuple[CanFrame, ...]:
        """The frames that have gone onto the bus since this was last called."""
        sent, self.sent = self.sent, []
        return tuple(sent)

    def deliver(self, frames: Sequence[CanFrame], tick: int = 0) -> bytes:
        """Frames of the bus -> text to the host, nothing while closed."""
        if not self.is_open:
            return b""
        stamp = b"%04X\r" % (tick % STAMP_TURN_MS) if self.stamps else OK
        return b"".join(
            [b"t%03X%d%b%b" % (can_id, len(data), data.hex().upper().encode(), stamp) for can_id, data in frames]
        )

    def _command(self, line: bytes) -> bytes:
        if not line:
            return OK
        letter, rest = line[:1], line[1:]
        if letter in b"tTrR":
            return self._transmit(letter, rest)
        if letter in b"VvNF" and rest:
            return REFUSED
        if letter == b"V":
            return VERSION
        if letter == b"v":
            return b"v" + VERSION[1:]
        if letter == b"N":
            return SERIAL_NUMBER
        if letter == b"F":
            return b"F00\r" if self.is_open else REFUSED
        if letter == b"C" and not rest and self.is_open:
            self.is_open = self.listens_only = False
            return OK
        if self.is_open:
            return REFUSED
        return self._set_up(letter, rest)

    def _set_up(self, letter: bytes, rest: bytes) -> bytes:
        """The commands of a closed channel."""
        if letter == b"S" and rest in _BITRATE_OF:
            self.bitrate, self._is_set = _BITRATE_OF[rest], True
        elif letter == b"s" and len(rest) == 4 and _HEX.issuperset(rest):
            self.bitrate, self._is_set = None, True
        elif letter == b"Z" and rest in (b"0", b"1"):
            self.stamps = rest == b"1"
        elif letter in (b"O", b"L") and not rest and self._is_set:
            self.is_open, self.listens_only = True, letter == b"L"
        else:
            return REFUSED
        return OK

    def _transmit(self, letter: bytes, rest: bytes) -> bytes:
        if not self.is_open or self.listens_only or not _HEX.issuperset(rest):
            return REFUSED
        is_extended, is_remote = letter in b"TR", letter in b"rR"
        digits = 8 if is_extended else 3
        length = rest[digits : digits + 1]
        if length not in b"012345678" or len(rest) != digits + 1 + (0 if is_remote else 2 * int(length or b"9")):
            return REFUSED
        can_id = int(rest[:digits], 16)
        if can_id >= (1 << 29 if is_extended else 1 << 11):
            return REFUSED
        if letter == b"t":
            self.sent.append((can_id, unhexlify(rest[digits + 1 :])))
        else:
            self.other_frames += 1
        return b"Z\r" if is_extended else b"z\r"


class SlcanOnLine:
    """The adapter at the end of a serial line, with `bus` behind it. `step` once a millisecond.

    Where real motors may hang on that bus, a `limiter` is the last line before it. A motor keeps its last current when
    its commands stop, so whoever has commanded and then closes the channel or leaves the line leaves none behind. A
    host that merely falls silent is not judged: what its motors do then is theirs, and what it is tested for.
    """

    def __init__(
        self,
        line: SerialPort,
        bus: CanPort,
        adapter: SlcanAdapter | None = None,
        *,
        limiter: Limiter | None = None,
    ) -> None:
        self.line, self.bus = line, bus
        self.adapter = adapter or SlcanAdapter()
        self.limiter = limiter
        self.from_host = self.to_host = 0
        """Frames."""
        self._has_commanded = False

    def step(self, tick: int) -> None:
        """Host to bus, bus to host. Whoever leaves the line leaves a closed channel to the next one."""
        line, bus, adapter = self.line, self.bus, self.adapter
        data = line.read()
        answers = adapter.feed(data) if data else b""
        if adapter.sent:
            self._to_bus(adapter.take_sent())
        if line.lost:  # what had been sent before counts: a controller may leave with a last word
            line.revive()
            adapter.is_open = False
        if not adapter.is_open:
            self._stop()
        frames = bus.read()
        if bus.lost:
            bus.revive()
        if frames and adapter.is_open:
            self.to_host += len(frames)
            answers += adapter.deliver(frames, tick)
        if answers:
            line.write(answers)

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        adapter, limiter = self.adapter, self.limiter
        facts: dict[str, object] = {
            "open": adapter.is_open,
            "bitrate": adapter.bitrate,
            "adapter_commands": adapter.commands,
            "adapter_refused": adapter.refused,
            "frames_from_host": self.from_host,
            "frames_to_host": self.to_host,
        }
        if limiter is not None:
            facts |= {"frames_limited": limiter.clamped, "frames_not_passed": limiter.refused}
        return facts

    def close(self) -> None:
        """No current where it was ours to give, then line and bus."""
        self._stop(LAST_WORD_S)
        self.line.close()
        self.bus.close()

    def _to_bus(self, frames: tuple[CanFrame, ...]) -> None:
        self.from_host += len(frames)
        if self.limiter is not None:
            frames = self.limiter(frames)
            self._has_commanded = self._has_commanded or bool(frames)
        self.bus.write(frames)

    def _stop(self, within_s: float = 0.0) -> None:
        if self.limiter is not None and self._has_commanded:
            # A bus that is away, or full, hears it when it is back.
            self._has_commanded = bool(self.bus.lost) or not self.bus.write(self.limiter.stop, within_s)
