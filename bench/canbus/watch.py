"""Who is on the bus that should not be: foreign frames, wrong lengths, and two senders on one identifier.

An end of the wire reports what it cannot explain; `hear` explains a whole bus frame by frame, for a log. Nothing is
ever raised, and the memory does not grow: one finding for each kind and identifier, 64 of them, the rest is counted.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from bench.canbus.c610 import COMMAND_IDS, ESCS, FEEDBACK_ID, QUICK_ID, gm6020_of

MAX_FINDINGS = 64
TWICE_IN_A_ROW = 8
"""Ticks one after the other in which an identifier came more than once, until it counts as two senders.

A single one proves nothing: after a late tick a reader finds two frames of one sender. But then one tick found none, so
a lone sender at 1 kHz cannot come twice in every tick for long.
"""


class Kind(StrEnum):
    """What is wrong."""

    TWO_SENDERS = "two senders"
    OTHER_CONTROLLER = "another controller"
    UNKNOWN_ESC = "unknown ESC"
    QUICK_ID = "quick-ID frame"
    LENGTH = "wrong length"
    FOREIGN = "foreign frame"
    LOST_COUNT = "lost count"


@dataclass(slots=True)
class Finding:
    """One thing that is wrong with one identifier, from its first tick to its last."""

    kind: Kind
    can_id: int
    first_tick: int
    last_tick: int
    count: int = 1

    @property
    def text(self) -> str:
        """The sentence for people."""
        times = "once" if self.count == 1 else f"{self.count} times"
        since = f"{times} since {self.first_tick / 1000:.3f} s"
        return f"0x{self.can_id:03X} {self.kind}, {since}: {_explained(self)}"


class BusWatch:
    """Collects findings for a bus to which the ESCs `numbers` belong, and whatever sends the identifiers `also`."""

    __slots__ = ("_at", "_expected", "_found", "_twice", "unlisted")

    def __init__(self, numbers: Iterable[int], also: Iterable[int] = ()) -> None:
        self._expected = frozenset([*COMMAND_IDS, *(FEEDBACK_ID + number for number in numbers), *also])
        self._found: dict[tuple[Kind, int], Finding] = {}
        self._twice: dict[int, tuple[int, int]] = {}
        self._at: dict[int, int] = {}
        self.unlisted = 0
        """Findings for which there was no room."""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Everything so far, in the order in which it was found."""
        return tuple(self._found.values())

    def hear(self, tick: int, can_id: int, length: int) -> None:
        """Any frame of the bus, command or feedback, whoever sent it."""
        if can_id not in self._expected:
            self.foreign(tick, can_id)
        elif length != 8 and can_id <= FEEDBACK_ID + ESCS:
            self.report(Kind.LENGTH, tick, can_id)
        if self._at.get(can_id) == tick:
            self.again(tick, can_id)
        elif can_id in self._at or len(self._at) < MAX_FINDINGS:
            self._at[can_id] = tick

    def foreign(self, tick: int, can_id: int) -> None:
        """A frame that this end does not expect: at the controller's end, a command is foreign too."""
        if can_id in COMMAND_IDS:
            kind = Kind.OTHER_CONTROLLER
        elif can_id == QUICK_ID:
            kind = Kind.QUICK_ID
        elif FEEDBACK_ID < can_id <= FEEDBACK_ID + ESCS or gm6020_of(can_id) is not None:
            kind = Kind.UNKNOWN_ESC
        else:
            kind = Kind.FOREIGN
        self.report(kind, tick, can_id)

    def again(self, tick: int, can_id: int) -> None:
        """An identifier came once more within one tick. Reported when that goes on tick after tick."""
        last, run = self._twice.get(can_id, (-2, 0))
        if tick == last:
            return
        run = run + 1 if tick == last + 1 else 1
        if can_id in self._twice or len(self._twice) < MAX_FINDINGS:
            self._twice[can_id] = (tick, run)
        if run >= TWICE_IN_A_ROW:
            self.report(Kind.TWO_SENDERS, tick, can_id)

    def report(self, kind: Kind, tick: int, can_id: int) -> None:
        """Count one finding."""
        finding = self._found.get((kind, can_id))
        if finding is not None:
            finding.count += 1
            finding.last_tick = tick
        elif len(self._found) < MAX_FINDINGS:
            self._found[kind, can_id] = Finding(kind, can_id, tick, tick)
        else:
            self.unlisted += 1


def _esc_or_gm6020(can_id: int) -> str:
    number, gm6020 = can_id - FEEDBACK_ID, gm6020_of(can_id)
    names = [f"an ESC with ID {number}"] if 1 <= number <= ESCS else []
    names += [f"a GM6020 with ID {gm6020}"] if gm6020 is not None else []
    return " or ".join(names)


def _two_senders(finding: Finding) -> str:
    if finding.can_id in COMMAND_IDS:
        return "two controllers command this group, and each sets all four currents"
    gm6020 = gm6020_of(finding.can_id)
    number = finding.can_id - FEEDBACK_ID
    if not 1 <= number <= ESCS:
        return "two nodes use this identifier"
    rival = f", or a GM6020 with ID {gm6020}" if gm6020 is not None else ""
    return f"two ESCs with ID {number}{rival}; a C610 whose ID is taken stops and blinks orange twice"


def _explained(finding: Finding) -> str:
    match finding.kind:
        case Kind.TWO_SENDERS:
            return _two_senders(finding)
        case Kind.OTHER_CONTROLLER:
            return "a command that this base did not send; it sets all four currents of its group"
        case Kind.UNKNOWN_ESC:
            return f"{_esc_or_gm6020(finding.can_id)}, which the robot file does not have"
        case Kind.QUICK_ID:
            return "puts every C610 into quick-ID mode"
        case Kind.LENGTH:
            return "command and feedback frames have 8 bytes"
        case Kind.FOREIGN:
            return "no motor or controller of this bus"
        case Kind.LOST_COUNT:
            return "silent for so long that its whole turns are not known: what it turned meanwhile is not counted"
