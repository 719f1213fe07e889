"""A recording as lists of frames, taken apart by the layouts of the documents and written out again as text.

Nothing here knows how the bench reads or compares recordings: what a fault is put into must not share its mistakes.
"""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from bench import rc_decode
from bench.config import load_robot
from bench.messages import RcFrame

Frame = list  # [tick, data]; `data` is bytes on a wire, a list of cells in state.csv


class Layout(NamedTuple):
    """Where a wire's numbers lie: how to read them out of a frame, and how to put one back."""

    names: tuple[str, ...]
    read: Callable[[bytes], list[int]]
    write: Callable[[bytes, list[int]], bytes]


@dataclass
class Log:
    """Every wire of a recording: can.log by identifier, rc, the two directions of slamware, state."""

    directory: Path
    wires: dict[str, list[Frame]] = field(default_factory=dict)
    layouts: dict[str, Layout] = field(default_factory=dict)
    order: dict[int, list[str]] = field(default_factory=dict)
    """Tick -> order of the CAN identifiers in it, where it is not the usual one."""
    header: str = ""
    ticks: int = 0

    @classmethod
    def of(cls, directory: Path, robot: str) -> Log:
        """Read one, by the layouts of its robot."""
        log = cls(directory)
        log.ticks = int(next(line for line in _lines(directory, "run.toml") if line.startswith("ticks")).split()[-1])
        for line in _lines(directory, "can.log"):
            stamp, _, frame = line.split()
            can_id, _, data = frame.partition("#")
            log.wires.setdefault(can_id, []).append([_tick(stamp), bytes.fromhex(data)])
        for name in ("rc", "slamware"):
            for line in _lines(directory, f"{name}.log"):
                stamp, _, way, *data = line.split()
                log.wires.setdefault(f"{name}{way}", []).append([_tick(stamp), bytes.fromhex("".join(data))])
        log.header, *rows = _lines(directory, "state.csv")
        log.wires["state"] = [[round(float(row.split(",")[0]) * 1000), row.split(",")[1:]] for row in rows]
        log._know_layouts(robot)
        return log

    def _know_layouts(self, robot: str) -> None:
        feedback = ">HhhBB" if robot == "dm3519" else ">Hhh2x"
        for wire in self.wires:
            if wire == "200":
                self.layouts[wire] = _packed(">4h", ("slot1", "slot2", "slot3", "slot4"))
            elif wire in ("201", "202", "203", "204"):
                self.layouts[wire] = _packed(feedback, ("angle", "speed", "current", "hot", "hotter"))
        profile = load_robot(robot).rc
        assert profile is not None
        self.layouts["rc>"] = _rc_layout(profile.protocol)
        self.layouts["slamware>"] = _slamware_layout(b"\x10\x0e\xf8\x41", ("vx", "vy", "omega"))
        self.layouts["slamware<"] = _slamware_layout(b"\x50\x0e\x00\x02", ("dx", "dy", "dtheta"))

    def copy(self) -> Log:
        """One to put a fault into."""
        wires = {name: [list(frame) for frame in frames] for name, frames in self.wires.items()}
        return Log(self.directory, wires, self.layouts, {}, self.header, self.ticks)

    def write(self, directory: Path) -> None:
        """As a recording, with the files that the faults did not touch."""
        if directory.exists():
            shutil.rmtree(directory)
        shutil.copytree(self.directory, directory)
        rank: dict[str, int] = {"200": 0}
        lines = []
        for can_id in sorted(name for name in self.wires if name.isalnum() and name != "state"):
            for nth, (tick, data) in enumerate(self.wires[can_id]):
                order = self.order.get(tick)
                place = order.index(can_id) if order else rank.get(can_id, int(can_id, 16))
                lines.append((tick, place, nth, f"({_stamp(tick)}) can0 {can_id}#{data.hex().upper()}"))
        _write(directory, "can.log", [line for *_, line in sorted(lines)])
        _write(directory, "rc.log", [f"({_stamp(t)}) rc0 > {d.hex(' ').upper()}" for t, d in self.wires["rc>"]])
        words = []
        for way in "><":
            words += [
                (t, way == "<", f"({_stamp(t)}) slamware0 {way} {d.hex(' ').upper()}")
                for t, d in self.wires[f"slamware{way}"]
            ]
        _write(directory, "slamware.log", [line for *_, line in sorted(words)])
        rows = [",".join((_stamp(tick), *cells)) for tick, cells in self.wires["state"]]
        _write(directory, "state.csv", [self.header, *rows])

    def numbers(self, wire: str, name: str) -> list[tuple[int, int]]:
        """(row, value) of a field: whole numbers; of state.csv millionths."""
        if wire == "state":
            column = self.header.split(",").index(name) - 1
            return [(row, round(float(cells[column]) * 1e6)) for row, (_, cells) in enumerate(self.wires[wire])]
        layout = self.layouts[wire]
        place = layout.names.index(name)
        found = []
        for row, (_, data) in enumerate(self.wires[wire]):
            values = layout.read(data)
            if values:
                found.append((row, values[place]))
        return found

    def put(self, wire: str, row: int, name: str, value: int) -> None:
        """Another value for a field of one frame."""
        tick, data = self.wires[wire][row]
        if wire == "state":
            cells = list(data)
            cells[self.header.split(",").index(name) - 1] = f"{value / 1e6:.6f}"
            self.wires[wire][row] = [tick, cells]
            return
        layout = self.layouts[wire]
        values = layout.read(data)
        values[layout.names.index(name)] = value
        self.wires[wire][row] = [tick, layout.write(data, values)]


def _packed(form: str, names: tuple[str, ...]) -> Layout:
    layout = struct.Struct(form)
    many = len(layout.unpack(bytes(8)))
    return Layout(names[:many], lambda data: list(layout.unpack(data)), lambda _, values: layout.pack(*values))


def _rc_layout(protocol: str) -> Layout:
    def read(data: bytes) -> list[int]:
        decoder = rc_decode.decoder(protocol)
        frames = [event for event in (*decoder.feed(data), *decoder.finish()) if isinstance(event, RcFrame)]
        return list(frames[0].channels[:4]) if len(frames) == 1 else []

    def write(data: bytes, values: list[int]) -> bytes:
        decoder = rc_decode.decoder(protocol)
        events = [event for event in (*decoder.feed(data), *decoder.finish()) if isinstance(event, RcFrame)]
        limits = rc_decode.channel_limits(protocol)
        clipped = [max(low, min(high, value)) for value, (low, high) in zip(values, limits, strict=False)]
        return rc_decode.encode(protocol, (*clipped, *events[0].channels[4:]))

    return Layout(("ch0", "ch1", "ch2", "ch3"), read, write)


def _slamware_layout(start: bytes, names: tuple[str, ...]) -> Layout:
    """Little-endian 32-bit words behind flag, length and code, as the vendor's samples have them."""
    form, at = struct.Struct(f"<{len(names)}i"), len(start)

    def read(data: bytes) -> list[int]:
        return list(form.unpack_from(data, at)) if data[: len(start)] == start else []

    def write(data: bytes, values: list[int]) -> bytes:
        body = bytearray(data[:-1])
        form.pack_into(body, at, *values)
        check = 0
        for byte in body:
            check ^= byte
        return bytes((*body, check))

    return Layout(names, read, write)


def _lines(directory: Path, name: str) -> list[str]:
    return (directory / name).read_text().splitlines()


def _write(directory: Path, name: str, lines: Sequence[str]) -> None:
    (directory / name).write_text("".join(f"{line}\n" for line in lines))


def _tick(stamp: str) -> int:
    return round(float(stamp.strip("()")) * 1000)


def _stamp(tick: int) -> str:
    return f"{tick / 1000:.6f}"
