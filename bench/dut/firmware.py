"""A firmware behind the seam: its process answers one packet a tick.

                 bytes
    in     0     | RC bytes u16 | SLAMWARE bytes u16 | frames u16 | 0 | frames, 11 each | RC bytes | SLAMWARE bytes |
    out    0     | 0 | frames u8 | SLAMWARE bytes u16 | frames, 11 each | SLAMWARE bytes |
    out    0     | 2 | the same, from a firmware that has printed: see `output`
    out    0     | 1 | a fault: see `trouble` |
    frame        | identifier u16 | length u8 | data, 8 |

All little-endian. The firmware never sees the host's clock; how long it takes is only looked at when no answer has come
for `PATIENCE_MS`: it is ended where it computes without end, or waits for something that the bench cannot give.
"""

from __future__ import annotations

import os
import socket
import struct
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from bench.check.firmware_log import PrintedLine
from bench.config import Robot
from bench.dut.build import Built, build
from bench.dut.one_core import REVIEW_TICKS, OneCore
from bench.dut.output import Output
from bench.dut.project import load_project
from bench.dut.server import Server, server_of
from bench.dut.trouble import Fault, Stalled, told
from bench.errors import ControllerFailed, spelt
from bench.messages import CanFrame

PATIENCE_MS = 1000
"""Of the wall's time. A loop that the shim can count is found by its count, long before."""
STARVED_ROUNDS = 30
"""So often a firmware that gets no processor is given as much again."""
BUSY_SHARE = 0.25
SIGKILL = 9

_FRAME = "H9p"  # a length and so many bytes
_ANSWER = struct.Struct("<BBH")
_ONE_ANSWER = struct.Struct("<4x" + _FRAME)
_ONE_FRAME = struct.Struct("<" + _FRAME)
_LARGEST_ANSWER = 65536
_ANSWERED, _FAULT, _PRINTED = 0, 1, 2


@lru_cache(maxsize=64)
def _question(frames: int) -> Callable[..., bytes]:
    return struct.Struct("<HHH2x" + _FRAME * frames).pack


class Firmware:
    """A compiled firmware. Called with a robot it gives a fresh one, from reset: what a bench takes for a base."""

    def __init__(self, built: Built) -> None:
        self.built = built
        self.controller_name = spelt(built.project.path.name)
        """What a recording calls it."""
        project = built.project
        self.hears_no_core = bool(project.rc or project.can or project.fdcan) and not project.slamware
        """Its wires are named, and SLAMWARE is none of them."""

    def __call__(self, robot: Robot | None = None) -> FirmwareBase:
        """A fresh one. Raises SurroundingsError where its process does not come up."""
        return FirmwareBase(self.built)


def firmware_of(path: Path | str) -> Firmware:
    """The firmware of a project's TOML file, compiled where something has changed. Raises BenchError."""
    return Firmware(build(load_project(Path(path))))


class FirmwareBase:
    """A `ControlledBase`: one fresh firmware. `step` raises ControllerFailed, once; what it sent before stands."""

    def __init__(self, built: Built) -> None:
        self.program = built.program
        self._project = built.project
        self._server: Server = server_of(built.program)
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._patience_s = PATIENCE_MS / 1000.0
        patience = struct.pack("ll", PATIENCE_MS // 1000, PATIENCE_MS % 1000 * 1000)
        self._link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, patience)
        self._output = Output(watches_reports=built.project.sanitize)
        self._release = weakref.finalize(self, _release, self._link, self._output)
        try:
            self.pid = self._server.fork(theirs.fileno(), self._output.file)
        finally:
            theirs.close()
        self._buffer = bytearray(_LARGEST_ANSWER)
        self._failed: ControllerFailed | None = None
        self._core: OneCore | None = None

    @contextmanager
    def kept_on_one_core(self) -> Iterator[None]:
        """For a run at full speed: firmware and calling thread share a core of the machine, which is twice as fast."""
        core = self._core = OneCore(self.pid)
        try:
            yield
        finally:
            self._core = None
            core.release(is_alive=self._failed is None)

    def step(
        self, tick: int, rc_bytes: bytes, slamware_bytes: bytes, can_in: Sequence[CanFrame]
    ) -> tuple[tuple[CanFrame, ...], bytes]:
        """A packet there, a packet back. Raises ControllerFailed with what the firmware has done, and where."""
        if self._core is not None and (tick + 1) % REVIEW_TICKS < 2:
            self._core.review(tick)
        count = len(can_in)
        packet = _question(count)(len(rc_bytes), len(slamware_bytes), count, *sum(can_in, ()))
        if rc_bytes or slamware_bytes:
            packet += rc_bytes + slamware_bytes
        buffer = self._buffer
        try:
            self._link.send(packet)
            size = self._link.recv_into(buffer)
        except OSError:  # nobody is there any more, or nobody has answered for a while
            size = self._wait(tick)
        if size == _ONE_ANSWER.size and not buffer[0]:
            return (_ONE_ANSWER.unpack_from(buffer),), b""
        return self._taken(tick, size)

    def output(self) -> str:
        """The last that the firmware has printed until now, at most 64 KiB."""
        return self._output.text()

    def log_lines(self, is_over: bool = False) -> list[PrintedLine]:
        """What it has printed since the last call, and how it died; for the recording's firmware.log."""
        if is_over and self._failed is None:
            self._output.end()
        return self._output.new_lines()

    def processor_s(self) -> float:
        """Processor time that the firmware has used."""
        return _processor_time(self.pid)[1]

    def __reduce__(self) -> str:
        raise TypeError("a firmware's process cannot be copied")

    def close(self) -> None:
        """Let the firmware go; it ends by itself when nobody listens."""
        self._release()

    def _taken(self, tick: int, size: int) -> tuple[tuple[CanFrame, ...], bytes]:
        buffer = self._buffer
        if size >= _ANSWER.size and buffer[0] in (_ANSWERED, _PRINTED):
            kind, count, said = _ANSWER.unpack_from(buffer)
            if kind == _PRINTED:
                self._output.take(tick)
            end = _ANSWER.size + _ONE_FRAME.size * count
            if size == end + said:
                frames = [_ONE_FRAME.unpack_from(buffer, at) for at in range(_ANSWER.size, end, _ONE_FRAME.size)]
                return tuple(frames), bytes(buffer[end:size])
        fault = Fault.read(bytes(buffer[:size])) if size and buffer[0] == _FAULT else None
        raise self._failure(tick, fault)

    def _wait(self, tick: int) -> int:
        """The packet that is late; 0 where none can come. Raises ControllerFailed for a firmware that never answers."""
        _, last_s = _processor_time(self.pid)
        for _ in range(STARVED_ROUNDS):
            size = self._answer()
            if size is None:
                is_asleep, used_s = _processor_time(self.pid)
                # On a busy machine it may have had its turn since: then it sleeps because it has answered.
                size = self._answer(socket.MSG_DONTWAIT)
            if size is not None:
                return size
            if used_s - last_s >= BUSY_SHARE * self._patience_s:
                raise self._failure(tick, stalled=Stalled.BUSY)
            if is_asleep:
                raise self._failure(tick, stalled=Stalled.ASLEEP)
        raise self._failure(tick, stalled=Stalled.STARVED)

    def _answer(self, flags: int = 0) -> int | None:
        """The size of the packet that has come; 0 where none can come any more, None where none has come in time."""
        try:
            return self._link.recv_into(self._buffer, 0, flags)
        except BlockingIOError:
            return None
        except OSError:
            return 0

    def _failure(self, tick: int, fault: Fault | None = None, stalled: Stalled | None = None) -> ControllerFailed:
        """What happened, once the process is gone."""
        if self._failed is None:
            if stalled is not None:
                os.kill(self.pid, SIGKILL)
            self._link.close()
            status = self._server.ended(self.pid)
            self._output.take(tick)
            what, below = told(self._project, self.program, status, fault, stalled, self.output())
            self._output.died(tick, f"the firmware {what}")
            when = f"{self._project.path.name}: at tick {tick} ({tick / 1000:.3f} s)"
            self._failed = ControllerFailed(f"{when} the firmware {what}{below}")
        return self._failed


def _release(link: socket.socket, output: Output) -> None:
    link.close()
    output.close()


def _processor_time(pid: int) -> tuple[bool, float]:
    """Whether the process sleeps, and the processor time that it has used, in s."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
    except OSError:
        return True, 0.0
    return fields[0] in "STt", (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
