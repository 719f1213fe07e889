"""Twelve kinds of fault, put into a log as they would happen. The seed chooses wire, field, instant, length and size.

Late frames are all still there and only later; a rate change takes the newest value at the new times; noise is random
counts. What cannot be told apart is not asked for. An offset on a value that does not change is a stuck value; a swap
of two wheels that do the same is nothing; two lost frames are no rate. So a field must move where it is changed (30
different values on CAN, 6 on slower wires), a scaled one must be away from zero, swapped ones must differ, and a fault
must last for some dozen frames.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from logs.frames import Log


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
