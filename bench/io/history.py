"""The run so far, so that any instant of it can be shown again: every input of every tick, and stills at intervals.

An instant is built from the last still before it and the inputs since. Two things make that exact. A still is taken
while the physics engine has no contact alive (`Plant.is_free`), if there is such an instant soon: of contacts it keeps
more than a copy can hold (the order in which it meets two walls of a corner is one such thing). And nothing is trusted:
before a stretch between two stills is shown for the first time, it is run to its end and compared with what the run was
like there, to the last bit. A still that does not lead there is thrown away, and the one before it takes its place. The
first is the bench at the start of the run, which leads everywhere.

Measured on the default robot: a still takes 1.5 ms and, by the length of the trail, 10 to 35 kB, once a second of the
run; an instant of ten minutes comes back in 0.1 s, a step back in 5 ms; leaning on a wall for a minute in 0.3 s.
"""

from __future__ import annotations

import pickle
import zlib
from bisect import bisect_right
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

from bench.check.faults import Fault
from bench.check.faulty import FaultyWorld, Injector, Touch
from bench.io.follower import Follower
from bench.io.still import again, still
from bench.loop import NOTHING, Bench
from bench.messages import BodyTwist, TickInput, TickOutput
from bench.slamware.core_side import SlamwareCore
from bench.slamware.schedule import SCHEDULES

STILL_TICKS = 1000
PATIENCE_TICKS = 200
"""So long an instant without contacts is waited for; then a still is taken all the same. It may be a good one."""
FINE_STILL_TICKS = 100
"""Within a stretch that somebody looks at, so that a step back costs no more than this."""
MOST_STILLS = 1500
YOUNG_STILLS = 600
"""The newest ones stay; of the others every second one goes when there are too many."""
MOST_INPUT_BYTES = 64_000_000
"""Of packed inputs: days of driving. What is older is forgotten, and the run then begins later."""
PACKED_AT_ONCE = 2000

Mark: TypeAlias = tuple[object, ...]
"""What a bench is like, to the last bit: enough to tell two runs apart."""


class CoreJoins(NamedTuple):
    """A SLAMWARE core of our own takes the place of a recorded one's bytes; it begins as after power-up. RC bytes are a
    transmitter's from then on, too, and take their time where wires do.
    """


Event: TypeAlias = Fault | CoreJoins
"""What joins a run on its way, and is no input of a tick."""


class LostInstant(Exception):
    """An instant that the history does not hold; the text is the reason, for a person."""


class Subject(NamedTuple):
    """What is kept: a bench, and what a screen has seen of it."""

    bench: Bench
    seen: Follower

    def take_touches(self) -> list[Touch]:
        """What faults have touched since the last call."""
        world = self.bench.world
        return world.injector.take_touches() if isinstance(world, FaultyWorld) else []


class Inputs:
    """What entered each tick; ticks in which nothing did take no room."""

    def __init__(self) -> None:
        self.bytes = 0
        """Of what is packed."""
        self.first = 0
        """Before this tick nothing is known any more."""
        self._packed: list[tuple[int, bytes]] = []  # first tick, and the rows from there to the next one's
        self._open: list[tuple[int, TickInput]] = []

    def add(self, tick: int, given: TickInput) -> None:
        """What entered a tick, in order of time."""
        if given is NOTHING or given == NOTHING:
            return
        self._open.append((tick, given))
        if len(self._open) >= PACKED_AT_ONCE:
            self._pack()

    def between(self, first: int, end: int) -> dict[int, TickInput]:
        """Tick -> what entered it, for first <= tick < end."""
        found: dict[int, TickInput] = {}
        for index, (start, packed) in enumerate(self._packed):
            after = self._packed[index + 1][0] if index + 1 < len(self._packed) else None
            if start < end and (after is None or after > first):
                found |= {tick: given for tick, given in _unpack(packed) if first <= tick < end}
        return found | {tick: given for tick, given in self._open if first <= tick < end}

    def branch(self, end: int) -> Inputs:
        """The same up to this tick, and then another run's. Ours stay as they are."""
        other = copy(self)
        other._packed = list(self._packed)
        kept = [(tick, given) for tick, given in self._open if tick < end]
        while other._packed and not kept:
            _, packed = other._packed.pop()
            other.bytes -= len(packed)
            kept = [(tick, given) for tick, given in _unpack(packed) if tick < end]
        other._open = kept
        return other

    def forget_the_oldest(self) -> None:
        """Give up the first packed part."""
        if len(self._packed) > 1:
            self.bytes -= len(self._packed.pop(0)[1])
            self.first = self._packed[0][0]

    def _pack(self) -> None:
        rows = [(tick, given.rc, given.core_twist, given.slamware) for tick, given in self._open]
        packed = zlib.compress(pickle.dumps([(t, rc, twist and tuple(twist), core) for t, rc, twist, core in rows]), 1)
        self._packed.append((rows[0][0], packed))
        self.bytes += len(packed)
        self._open = []


def _unpack(packed: bytes) -> list[tuple[int, TickInput]]:
    rows = pickle.loads(zlib.decompress(packed))
    return [(tick, TickInput(rc, twist and BodyTwist(*twist), core)) for tick, rc, twist, core in rows]


@dataclass(slots=True)
class _Still:
    tick: int
    taken: bytes
    mark: Mark
    leads_to: int = field(default=-1)
    """The tick up to which what follows from it is known to be what was."""


class History:
    """The run of one bench. `note` every tick's input before it runs, `keep` after each stretch, `at` an instant.

    `shared` are values that never change and are too large for a still (a recording's frames).
    """

    def __init__(self, subject: Subject, shared: Sequence[object] = ()) -> None:
        self.inputs = Inputs()
        self.events: list[tuple[int, Event]] = []
        """(tick before which it happened, what joined the run)."""
        self.why_blind = ""
        """Why there is no way back, where there is none."""
        self._shared = tuple(shared)
        self._stills: list[_Still] = []
        self.due_tick = subject.bench.now_tick
        """From this tick on `keep` is to be called."""
        self._free = 0
        try:
            self._take(subject)
        except (pickle.PicklingError, TypeError, AttributeError):
            what = "a foreign base" if subject.bench.onlooker else "a run with a fault that waits for a condition"
            self.why_blind = f"{what} cannot be taken back in time"
        self.note = self.inputs.add
        """(tick, what enters it)."""

    @property
    def first(self) -> int:
        """The earliest instant that can be shown."""
        return self._stills[0].tick if self._stills else 0

    def start(self) -> Subject:
        """The bench as it was at the start of the run. Raises LostInstant where that is no longer known."""
        if self.why_blind:
            raise LostInstant(self.why_blind)
        if self.first > 0:
            raise LostInstant(f"the first {self.first / 1000:.0f} s of this run are no longer held")
        return self._alive(self._stills[0])

    def keep(self, subject: Subject) -> None:
        """After a tick from `due_tick` on: take a still if it can be exact."""
        bench = subject.bench
        if self.why_blind:
            self.due_tick = bench.now_tick + STILL_TICKS
            return
        # Contacts outlive their end by three steps.
        self._free = self._free + 1 if bench.world.plant.is_free else 0
        if self._free > 5 or bench.now_tick >= self.due_tick + PATIENCE_TICKS:
            self._take(subject)
            self._thin()

    def joined(self, tick: int, event: Event) -> None:
        """Something joined the run before this tick."""
        self.events.append((tick, event))

    def join_again(self, bench: Bench) -> None:
        """Let join a bench what has joined the run since its last tick."""
        for at, event in self.events:
            if at == bench.now_tick:
                join(bench, event)

    def at(self, tick: int, end: int, mark: Mark) -> Subject:
        """The bench before this tick ran, as it was. `end` and `mark` are the newest instant, which is not kept here.

        Raises LostInstant where the history does not reach so far.
        """
        if self.why_blind:
            raise LostInstant(self.why_blind)
        while True:
            index = bisect_right(self._stills, tick, key=lambda one: one.tick) - 1
            if index < 0:
                raise LostInstant(f"the run is held from {self.first / 1000:.1f} s on")
            chosen = self._stills[index]
            after = self._stills[index + 1] if index + 1 < len(self._stills) else None
            goal = after.tick if after else end
            if chosen.leads_to >= goal:
                subject = self._alive(chosen)
                self.go_on(subject, tick)
                return subject
            if self._leads(chosen, goal, after.mark if after else mark):
                continue  # finer ones may have come
            if index == 0:
                raise LostInstant("this instant cannot be built again to the last bit")
            del self._stills[index]

    def go_on(self, subject: Subject, tick: int) -> list[TickOutput]:
        """Run a bench of this history on with what entered its ticks; the ticks that ran."""
        bench, seen = subject
        given = self.inputs.between(bench.now_tick, tick)
        events = [(at, event) for at, event in self.events if bench.now_tick <= at < tick]
        outs = []
        for now in range(bench.now_tick, tick):
            while events and events[0][0] <= now:
                join(bench, events.pop(0)[1])
            out = bench.tick(given.get(now, NOTHING))
            observe(bench, out)
            seen.add(out)
            outs.append(out)
        return outs

    def ticks(self, first: int, stop: int, end: int, mark: Mark) -> list[TickOutput]:
        """The ticks first <= tick < stop as they ran; `end` and `mark` as in `at`. Raises LostInstant like it."""
        outs: list[TickOutput] = []
        while (now := first + len(outs)) < stop:
            subject = self.at(now, end, mark)
            index = bisect_right(self._stills, now, key=lambda one: one.tick) - 1
            outs += self.go_on(subject, min(stop, self._stills[index].leads_to))
        return outs

    def reaches(self, bench: Bench, tick: int) -> bool:
        """Whether a bench that was built here may run on to this tick: the stretch is known to be what was."""
        index = bisect_right(self._stills, bench.now_tick, key=lambda one: one.tick) - 1
        return index >= 0 and bench.now_tick <= tick <= self._stills[index].leads_to

    def branch(self, tick: int) -> History:
        """The history of a run that was the same up to this tick. Ours stays as it is."""
        other = copy(self)
        other.inputs = self.inputs.branch(tick)
        other.note = other.inputs.add
        other.events = [(at, event) for at, event in self.events if at < tick]
        other._stills = [replace(one, leads_to=min(one.leads_to, tick)) for one in self._stills if one.tick <= tick]
        other.due_tick = tick + STILL_TICKS
        return other

    def _leads(self, chosen: _Still, goal: int, mark: Mark) -> bool:
        """Run the stretch after a still to its end; whether it ends as the run did. Leaves finer stills in it."""
        subject = self._alive(chosen)
        fine: list[_Still] = []
        free = 0
        given = self.inputs.between(chosen.tick, goal)
        events = [(at, event) for at, event in self.events if chosen.tick <= at < goal]
        bench, seen = subject
        for now in range(chosen.tick, goal):
            while events and events[0][0] <= now:
                join(bench, events.pop(0)[1])
            out = bench.tick(given.get(now, NOTHING))
            observe(bench, out)
            seen.add(out)
            free = free + 1 if goal - chosen.tick > FINE_STILL_TICKS and bench.world.plant.is_free else 0
            since = now + 1 - (fine[-1].tick if fine else chosen.tick)
            if (
                since >= FINE_STILL_TICKS
                and (free > 5 or since >= 2 * FINE_STILL_TICKS)
                and goal - now > FINE_STILL_TICKS // 2
            ):
                fine.append(_Still(now + 1, still(subject, self._shared), mark_of(bench)))
        if mark_of(bench) != mark:
            return False
        chosen.leads_to = fine[0].tick if fine else goal
        self._stills[self._stills.index(chosen) + 1 : self._stills.index(chosen) + 1] = fine
        return True

    def _alive(self, one: _Still) -> Subject:
        return Subject(*again(one.taken))

    def _take(self, subject: Subject) -> None:
        bench = subject.bench
        self._stills.append(_Still(bench.now_tick, still(tuple(subject), self._shared), mark_of(bench)))
        self.due_tick, self._free = bench.now_tick + STILL_TICKS, 0

    def _thin(self) -> None:
        if len(self._stills) > MOST_STILLS:
            old, young = self._stills[:-YOUNG_STILLS], self._stills[-YOUNG_STILLS:]
            for one in old:
                one.leads_to = -1
            self._stills = old[::2] + young
        while self.inputs.bytes > MOST_INPUT_BYTES and len(self._stills) > 1:
            self.inputs.forget_the_oldest()
            while len(self._stills) > 1 and self._stills[0].tick < self.inputs.first:
                del self._stills[0]


def mark_of(bench: Bench) -> Mark:
    """What a bench is like, to the last bit."""
    plant, snapshot = bench.world.plant, bench.snapshot()
    discs = tuple(map(tuple, plant.discs))
    return (snapshot, tuple(plant.wheel_angles_rad), plant.wall_force_n, discs)


def join(bench: Bench, event: Event) -> None:
    """Let a fault, or a core, join a run. Raises ValueError for a wheel or a wire that the robot does not have."""
    world = bench.world
    if isinstance(event, CoreJoins):
        settings = bench.robot.slamware
        world.core = SlamwareCore(poll_ms=settings.poll_ms, schedule=SCHEDULES[settings.polls])
        if world.timing is not None:
            world.timing.take_up_rc(bench.robot.rc.protocol if bench.robot.rc is not None else None)
        return
    if isinstance(world, FaultyWorld):
        world.injector.inject(event)
        return
    injector = Injector((), bench.robot, bench.state_columns)
    injector.inject(event)
    bench.world = FaultyWorld(world, injector)


def observe(bench: Bench, out: TickOutput) -> None:
    """Let faults that wait for a condition see what came of a tick."""
    if isinstance(bench.world, FaultyWorld):
        bench.world.injector.observe(out)
