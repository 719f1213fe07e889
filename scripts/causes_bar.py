"""Does the comparison name the right cause? Twelve kinds of fault, put into recordings of four robots, 20 seeds each.

Every fault is put in as it would happen: late frames are all still there and only later; a rate change takes the newest
value at the new times; noise is random counts. The seed chooses wire, wheel, field, instant, length and size. Nothing
here knows how `bench.check.causes` works: frames are taken apart by the layouts of the documents, written out again as
text, and read as any recording is.

What cannot be told apart is not asked for. An offset on a value that does not change is a stuck value; a swap of two
wheels that do the same is nothing; two lost frames are no rate. So a field must move where it is changed (30 different
values on CAN, 6 on slower wires), a scaled one must be away from zero, swapped ones must differ, and a fault must last
for some dozen frames.

    python scripts/causes_bar.py              960 recordings: the table of what was named for what; exit 1 below the bar
    python scripts/causes_bar.py --seeds 2 --robot m2006
"""

from __future__ import annotations

import argparse
import math
import random
import shutil
import struct
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from make_demo import sticks_at

from bench import rc_decode
from bench.check.causes import causes
from bench.check.reading import Recording
from bench.check.recording import Recorder, RunInfo
from bench.config import load_robot
from bench.loop import simulated
from bench.messages import BodyTwist, RcFrame, TickInput
from bench.rc.transmitter import Transmitter

ROBOTS = ("m2006", "dm3519", "omni4", "mecanum")
SECONDS = 8.0
SEEDS = 20
RIGHT_OF_ALL, RIGHT_OF_EACH = 0.90, 0.70

Frame = list  # [tick, data]; `data` is bytes on a wire, a list of cells in state.csv


# --- a drive -----------------------------------------------------------------------------------------------------


def drive(robot: str, directory: Path, seconds: float = SECONDS) -> Recording:
    """The demo's sticks on any robot, while a SLAMWARE core asks for a wandering twist."""
    bench = simulated(load_robot(robot))
    assert bench.robot.rc is not None
    assert bench.robot.file is not None
    transmitter = Transmitter(bench.robot.rc)
    info = RunInfo(robot=robot, profile=bench.robot.rc.name)
    with Recorder(directory, info, bench.state_columns, bench.robot.file, bench.robot.rc.file) as recorder:
        for tick in range(round(seconds * 1000)):
            t_s = tick / 1000
            # Never quite still, as hands are not.
            sticks = sticks_at(t_s)
            shaken = sticks._replace(
                forward=sticks.forward + 0.03 * math.sin(7.1 * t_s),
                left=sticks.left + 0.03 * math.sin(5.3 * t_s),
                turn=sticks.turn + 0.03 * math.sin(6.1 * t_s),
            )
            wanted = BodyTwist(0.3 * math.sin(1.9 * t_s), 0.2 * math.sin(2.7 * t_s), 0.5 * math.sin(1.3 * t_s))
            core = wanted if tick % 50 == 0 else None
            recorder.add(bench.tick(TickInput(transmitter.step(tick, shaken), core)))
    return Recording.open(directory)


# --- a recording as lists of frames ------------------------------------------------------------------------------


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


# --- the faults --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Place:
    """Where a fault sits: one field of one wire, from a tick to another."""

    wire: str
    name: str
    first: int
    end: int

    def rows(self, log: Log) -> list[tuple[int, int]]:
        """(row, value) of the frames that are meant."""
        return [
            (row, value)
            for row, value in log.numbers(self.wire, self.name)
            if self.first <= log.wires[self.wire][row][0] < self.end
        ]


def _wires(log: Log, chance: random.Random) -> str:
    can = [wire for wire in log.wires if wire in ("200", "201", "202", "203", "204")]
    return chance.choice([*can, *can, "rc>", "slamware>", "slamware<"])


def _span(log: Log, chance: random.Random, shortest: float = 0.5) -> tuple[int, int]:
    """From some instant to the end, or for a while."""
    first = round(1000 * chance.uniform(1.0, 0.75 * log.ticks / 1000))
    if chance.random() < 0.5:
        return first, log.ticks
    return first, min(log.ticks, first + round(1000 * chance.uniform(shortest, 2.5)))


def _field(log: Log, chance: random.Random, names: Sequence[str] = (), least: int = 30) -> Place:
    """A field that moves where the fault will sit."""
    fields = [("200", f"slot{n}") for n in (1, 2, 3, 4)]
    fields += [(wire, name) for wire in ("201", "202", "203", "204") for name in ("speed", "current", "angle")]
    fields += [("rc>", f"ch{n}") for n in (0, 2, 3)] + [("slamware>", name) for name in ("vx", "vy", "omega")]
    fields += [("slamware<", name) for name in ("dx", "dy", "dtheta")]
    fields += [("state", name) for name in ("x_m", "vx_mps", "wheel1_radps", "wheel2_current_a", "odo_y_m")]
    fields = [one for one in fields if one[0] in log.wires and (not names or one[1] in names)]
    while True:
        place = Place(*chance.choice(fields), *_span(log, chance))
        values = [value for _, value in place.rows(log)]
        slow = place.wire.startswith(("rc", "slam", "state"))
        if len(set(values)) >= (6 if slow else least):
            return place


def late(log: Log, chance: random.Random) -> None:
    """Every frame from an instant on, some milliseconds later; what would come after the end is not recorded."""
    wires = [_wires(log, chance)]
    if chance.random() < 0.25:
        wires = [wire for wire in log.wires if wire in ("201", "202", "203", "204")]
    first = 0 if chance.random() < 0.2 else _span(log, chance)[0]
    by = chance.randint(1, 25)
    for wire in wires:
        later = [[tick + (by if tick >= first else 0), data] for tick, data in log.wires[wire]]
        log.wires[wire] = [frame for frame in later if frame[0] < log.ticks]


def dropped(log: Log, chance: random.Random) -> None:
    """A burst of frames is lost, or some here and there."""
    while True:
        wire = _wires(log, chance)
        first, end = _span(log, chance)
        there = [row for row, (tick, _) in enumerate(log.wires[wire]) if first <= tick < end]
        if chance.random() < 0.5:
            start = chance.choice(there)
            lost = set(range(start, start + chance.randint(3, 150))) & set(there)
        else:
            share = chance.uniform(0.02, 0.4)
            lost = {row for row in there if chance.random() < share}
        if len(lost) >= 3:
            break
    log.wires[wire] = [frame for row, frame in enumerate(log.wires[wire]) if row not in lost]


def duplicated(log: Log, chance: random.Random) -> None:
    """Some frames are sent twice: at once, or a millisecond later where a line has room for one a tick."""
    wire = _wires(log, chance)
    frames: list[tuple[int, int, bytes]] = []
    twice = 0
    while twice < 3:
        first, end = _span(log, chance)
        share = chance.uniform(0.05, 0.6)
        after = 1 if wire.startswith(("rc", "slam")) else chance.choice((0, 0, 1))
        frames, twice = [], 0
        for tick, data in log.wires[wire]:
            frames.append((tick, 0, data))
            if first <= tick < end and chance.random() < share and tick + after < log.ticks:
                frames.append((tick + after, 1 if after == 0 else -1, data))
                twice += 1
    log.wires[wire] = [[tick, data] for tick, _, data in sorted(frames, key=lambda one: one[:2])]


def swapped(log: Log, chance: random.Random) -> None:
    """Two plugs in each other's socket: feedback of two ESCs, two slots of the command, two words, two columns."""
    while True:
        first, end = _span(log, chance)
        what = chance.choice(("feedback", "feedback", "slots", "words", "columns"))
        if what == "feedback":
            one, other = chance.sample([wire for wire in log.wires if wire in ("201", "202", "203", "204")], 2)
            mine, theirs = log.wires[one], log.wires[other]
            there = [row for row, (tick, _) in enumerate(mine) if first <= tick < end]
            if sum(mine[row][1] != theirs[row][1] for row in there) < 50:
                continue
            for row in there:
                mine[row], theirs[row] = theirs[row], mine[row]
            return
        wire, names = {
            "slots": ("200", [name for name in ("slot1", "slot2", "slot3", "slot4")]),
            "words": ("slamware>", ["vx", "vy"]),
            "columns": ("state", [f"wheel{n}_current_a" for n in (1, 2, 3)]),
        }[what]
        one, other = chance.sample(names, 2)
        pairs = list(zip(Place(wire, one, first, end).rows(log), Place(wire, other, first, end).rows(log), strict=True))
        if sum(mine[1] != theirs[1] for mine, theirs in pairs) < (10 if what != "slots" else 50):
            continue
        for (row, mine_value), (_, their_value) in pairs:
            log.put(wire, row, one, their_value)
            log.put(wire, row, other, mine_value)
        return


_SIGNED = (
    "slot1",
    "slot2",
    "slot3",
    "slot4",
    "speed",
    "current",
    "vx",
    "vy",
    "omega",
    "dx",
    "dy",
    "dtheta",
    "vx_mps",
    "wheel1_radps",
    "wheel2_current_a",
)


def flipped(log: Log, chance: random.Random) -> None:
    """A motor wired the other way round; a reversed stick turns around its middle, where it rests at the start."""
    while True:
        place = _field(log, chance, (*_SIGNED, "ch0", "ch2", "ch3"))
        middle = log.numbers(place.wire, place.name)[0][1] if place.wire == "rc>" else 0
        rows = place.rows(log)
        if sum(value != middle for _, value in rows) > 0.5 * len(rows):
            break
    for row, value in rows:
        log.put(place.wire, row, place.name, 2 * middle - value)


def scaled(log: Log, chance: random.Random) -> None:
    """A wrong gear, a wrong unit: everything times a factor, cut or rounded to counts."""
    factor = chance.choice((chance.uniform(0.3, 0.95), chance.uniform(1.05, 2.0)))
    whole = chance.choice((int, round, math.floor))
    while True:
        place = _field(log, chance, (*_SIGNED, "x_m", "odo_y_m"))
        rows = place.rows(log)
        if sum(abs((factor - 1.0) * value) > 3.0 for _, value in rows) > 0.5 * len(rows):
            break
    for row, value in rows:
        log.put(place.wire, row, place.name, whole(value * factor))


def offset(log: Log, chance: random.Random) -> None:
    """A sensor's zero is elsewhere."""
    place = _field(log, chance)
    values = [value for _, value in place.rows(log)]
    reach = max(values) - min(values)
    amount = max(3, round(reach * chance.uniform(0.02, 0.4))) * chance.choice((-1, 1))
    for row, value in place.rows(log):
        moved = value + amount
        log.put(place.wire, row, place.name, moved % 8192 if place.name == "angle" else moved)


def order(log: Log, chance: random.Random) -> None:
    """Another order on the bus in every tick, or neighbours on one wire that now and then change places."""
    first, end = _span(log, chance)
    if chance.random() < 0.5:
        ids = [wire for wire in log.wires if wire in ("200", "201", "202", "203", "204")]
        usual = list(ids)
        while ids == usual:
            chance.shuffle(ids)
        log.order = {tick: ids for tick in range(first, end)}
        return
    while True:
        wire = _wires(log, chance)
        first, end = _span(log, chance)
        frames = log.wires[wire]
        there = [row for row, (tick, _) in enumerate(frames[:-1]) if first <= tick < end]
        share = chance.uniform(0.1, 0.5)
        moved, last = 0, -2
        for row in there:
            if row > last + 1 and chance.random() < share:
                moved += frames[row][1] != frames[row + 1][1]
                frames[row][1], frames[row + 1][1] = frames[row + 1][1], frames[row][1]
                last = row
        if moved >= 3:
            return


def stuck(log: Log, chance: random.Random) -> None:
    """A field, or the whole frame, stays at what it last was."""
    place = _field(log, chance)
    if place.wire != "state" and chance.random() < 0.4:
        frames = log.wires[place.wire]
        there = [row for row, (tick, _) in enumerate(frames) if place.first <= tick < place.end]
        for row in there:
            frames[row][1] = frames[there[0] - 1][1]
        return
    rows = place.rows(log)
    before = [value for row, value in log.numbers(place.wire, place.name) if row < rows[0][0]][-1]
    for row, _ in rows:
        log.put(place.wire, row, place.name, before)


def quantised(log: Log, chance: random.Random) -> None:
    """Fewer bits: cut or rounded to a step."""
    whole = chance.choice((math.floor, round))
    while True:
        place = _field(log, chance)
        values = [value for _, value in place.rows(log)]
        reach = max(values) - min(values)
        step = round(reach / chance.uniform(5, 40))
        if step >= 4 and len({whole(value / step) for value in values}) >= 4:
            break
    for row, value in place.rows(log):
        log.put(place.wire, row, place.name, step * whole(value / step))


def rate(log: Log, chance: random.Random) -> None:
    """Another period from an instant on; each frame has the newest value of its time."""
    wire = _wires(log, chance)
    first, _ = _span(log, chance)
    frames = log.wires[wire]
    usual = (frames[-1][0] - frames[0][0]) / (len(frames) - 1)
    if usual < 2:
        period = float(chance.choice((2, 3, 4, 5, 2.5)))
    else:
        period = usual * chance.choice((chance.uniform(0.4, 0.85), chance.uniform(1.2, 3.0)))
    slower = [frame for frame in frames if frame[0] < first]
    newest, at = len(slower) - 1, float(first)
    while at < log.ticks:
        while newest + 1 < len(frames) and frames[newest + 1][0] <= at:
            newest += 1
        slower.append([int(at), frames[newest][1]])
        at += period
    log.wires[wire] = slower


def noise(log: Log, chance: random.Random) -> None:
    """Random counts on every frame."""
    place = _field(log, chance)
    values = [value for _, value in place.rows(log)]
    size = max(2.0, (max(values) - min(values)) * chance.uniform(0.01, 0.2))
    bell = chance.random() < 0.5
    for row, value in place.rows(log):
        moved = value + round(chance.gauss(0.0, size) if bell else chance.uniform(-size, size))
        log.put(place.wire, row, place.name, moved % 8192 if place.name == "angle" else moved)


FAULTS: dict[str, Callable[[Log, random.Random], None]] = {
    "late": late,
    "dropped": dropped,
    "duplicated": duplicated,
    "swapped": swapped,
    "flipped": flipped,
    "scaled": scaled,
    "offset": offset,
    "order": order,
    "stuck": stuck,
    "quantised": quantised,
    "rate": rate,
    "noise": noise,
}


# --- the bar -----------------------------------------------------------------------------------------------------


class Trial(NamedTuple):
    """What was put in, what was named first, and the sentence."""

    fault: str
    robot: str
    seed: int
    named: str
    text: str


def trials(robots: Sequence[str], seeds: Sequence[int], faults: Sequence[str], folder: Path) -> Iterator[Trial]:
    """Every fault on every robot with every seed."""
    for robot in robots:
        golden = drive(robot, folder / robot)
        log = Log.of(golden.directory, robot)
        for fault in faults:
            for seed in seeds:
                changed = log.copy()
                FAULTS[fault](changed, random.Random(f"{fault} {robot} {seed}"))
                changed.write(folder / "run")
                found = causes(Recording.open(folder / "run"), golden)
                first = found[0] if found else None
                yield Trial(fault, robot, seed, first.kind if first else "nothing", first.text if first else "")


def table(done: Sequence[Trial]) -> str:
    """Rows: what was put in. Columns: what was named first."""
    faults = list(dict.fromkeys(trial.fault for trial in done))
    named = [*FAULTS, *sorted({trial.named for trial in done} - FAULTS.keys())]
    lines = [" " * 11 + "".join(f"{name[:7]:>8}" for name in named) + "   right"]
    for fault in faults:
        counts = Counter(trial.named for trial in done if trial.fault == fault)
        cells = "".join(f"{counts[name] or '.':>8}" for name in named)
        lines.append(f"{fault:11}{cells}   {counts[fault] / counts.total():6.1%}")
    return "\n".join(lines)


def shares(done: Sequence[Trial]) -> tuple[float, float]:
    """The share of all that was named right, and of the class that fared worst."""
    each = []
    for fault in {trial.fault for trial in done}:
        right = [trial.named == fault for trial in done if trial.fault == fault]
        each.append(sum(right) / len(right))
    return sum(trial.named == trial.fault for trial in done) / len(done), min(each)


def main(arguments: Sequence[str] | None = None) -> int:
    """Inject, ask, print the table, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=SEEDS, metavar="N", help=f"seeds for each (default {SEEDS})")
    parser.add_argument("--first-seed", type=int, default=0, metavar="N", help="the first of them (default 0)")
    parser.add_argument("--robot", action="append", metavar="R", help="a robot; may be repeated (default: four)")
    parser.add_argument("--fault", action="append", choices=list(FAULTS), metavar="F", help="a fault; may be repeated")
    parser.add_argument("--wrong", action="store_true", help="print the sentence of each that was named wrong")
    args = parser.parse_args(arguments)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder:
        done = list(trials(args.robot or ROBOTS, seeds, args.fault or list(FAULTS), Path(folder)))
    if args.wrong:
        for trial in done:
            if trial.named != trial.fault:
                print(f"{trial.fault} on {trial.robot}, seed {trial.seed}: {trial.named}: {trial.text}")
    print(table(done))
    of_all, of_worst = shares(done)
    ok = of_all >= RIGHT_OF_ALL and of_worst >= RIGHT_OF_EACH
    print(
        f"{of_all:.1%} of {len(done)} named right (bar {RIGHT_OF_ALL:.0%}), the worst class {of_worst:.1%}"
        f" (bar {RIGHT_OF_EACH:.0%}): {'ok' if ok else 'MISSED'}; {time.perf_counter() - started:.0f} s"
    )
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
