"""A cause as one sentence: what it happened to, what happened, how much in its unit, from when on.

Wires and fields get the names that people have for them: the commands, the feedback of ESC 1, RC channel 2. A wheel has
its number in the robot file, from 1; its ESC the number on its CAN identifier.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from bench.check.fields import shown
from bench.check.lines import BASE_TO_CORE, CORE_TO_BASE, FEEDBACK_IDS, RC, STATE, can_id_of
from bench.check.reading import Recording
from bench.config import ConfigError, load_robot

if TYPE_CHECKING:
    from bench.check.causes import Cause

_AT_THE_START_TICKS = 20
_COMMAND_IDS = (0x200, 0x1FF)
_ESC_IDS = range(0x201, 0x209)
_SLOT = re.compile(r"current_(\d)_")
_WHEEL = re.compile(r"wheel_?(\d)_")


class Speaker:
    """Knows a robot's wheels by their CAN identifiers."""

    def __init__(self, recording: Recording) -> None:
        try:
            robot = load_robot(recording.robot_file, recording.profile_file)
            self._wheels = {wheel.can_id: number for number, wheel in enumerate(robot.wheels, 1)}
        except ConfigError:
            self._wheels = {}
        self._all_feedback = {f"can 0x{0x200 + can_id:03X}" for can_id in self._wheels}

    def sentence(self, cause: Cause) -> str:
        """The cause in words with units."""
        return _SAY[cause.kind](self, cause)

    def subject(self, cause: Cause) -> tuple[str, bool]:
        """What it happened to, and whether that is plural."""
        if len(cause.fields) == 1 and len(cause.wires) == 1:
            return self.field(cause.wires[0], cause.fields[0]), False
        names = []
        wires = list(cause.wires)
        if len(self._all_feedback) > 1 and self._all_feedback <= set(wires):
            names.append("the feedback of all ESCs")
            wires = [wire for wire in wires if wire not in self._all_feedback]
        names += [self.wire(wire) for wire in wires]
        if cause.kind != "changed" and len(names) > 3 and len(set(cause.wires)) > len(self._all_feedback) + 2:
            return "everything", False
        return _listed(names), len(names) > 1 or _is_plural(names[0])

    def wire(self, wire: str) -> str:
        """A wire's name."""
        names = {
            RC: "the RC frames",
            CORE_TO_BASE: "the SLAMWARE requests",
            BASE_TO_CORE: "the SLAMWARE answers",
            STATE: "state.csv",
        }
        if wire in names:
            return names[wire]
        can_id = can_id_of(wire)
        if can_id in _ESC_IDS:
            return f"the feedback of ESC {can_id - 0x200}"
        if can_id in _COMMAND_IDS:
            return "the commands" if can_id == 0x200 else "the commands to ESC 5 to 8"
        return f"CAN 0x{can_id:03X}"

    def field(self, wire: str, name: str) -> str:
        """A field's name, with the wire it is on."""
        if wire == STATE:
            return f"{name} in state.csv"
        if wire == RC:
            return f"RC {shown(wire, name)[0]}"
        slot = _SLOT.match(name)
        if slot and wire.startswith("can ") and can_id_of(wire) not in FEEDBACK_IDS:
            return f"the current of ESC {slot[1]} in the commands"
        return f"{shown(wire, name)[0]} in {self.wire(wire)}"

    def wheel(self, esc: int) -> str:
        """The wheel that an ESC drives, if the robot has it; else the ESC."""
        return f"wheel {self._wheels[esc]}" if esc in self._wheels else f"ESC {esc}"

    def swapped(self, cause: Cause) -> str:
        """Both partners, as wheels where they are wheels."""
        if len(cause.wires) > 1:
            escs = [can_id_of(wire) - 0x200 for wire in cause.wires]
            if all(esc + 0x200 in _ESC_IDS for esc in escs):
                return f"{_listed([self.wheel(esc) for esc in escs])} are swapped in the feedback"
            return f"{_listed([self.wire(wire) for wire in cause.wires])} are swapped"
        wire, fields = cause.wires[0], cause.fields
        slots = [match[1] for match in map(_SLOT.match, fields) if match]
        if len(slots) == len(fields) and wire.startswith("can "):
            return f"{_listed([self.wheel(int(slot)) for slot in slots])} are swapped in the commands"
        wheels = sorted({match[1] for match in map(_WHEEL.match, fields) if match})
        if len(wheels) == 2 and all(map(_WHEEL.match, fields)):
            return f"wheel {wheels[0]} and wheel {wheels[1]} are swapped in {self.wire(wire)}"
        return f"{_listed([shown(wire, name)[0] for name in fields])} in {self.wire(wire)} are swapped"


def when(cause: Cause) -> str:
    """From when on, or from when to when; empty where it is the whole run."""
    if cause.last_tick is None:
        return " from the start" if cause.first_tick <= _AT_THE_START_TICKS else f" from {seconds(cause.first_tick)} on"
    if cause.last_tick == cause.first_tick:
        return f" at {seconds(cause.first_tick)}"
    return f" from {seconds(cause.first_tick)} to {seconds(cause.last_tick)}"


def seconds(tick: int) -> str:
    """A tick as people read it."""
    return f"{tick // 1000}.{tick % 1000:03d} s"


def number(value: float) -> str:
    """A figure without digits that mean nothing."""
    return f"{value:.4g}" if abs(value) < 1000 else f"{value:.0f}"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _is_plural(name: str) -> bool:
    return name.startswith("the commands") or (name.endswith("s") and not name.startswith("the feedback"))


def _with_unit(cause: Cause, value: float) -> str:
    unit = shown(cause.wires[0], cause.fields[0])[1] if cause.fields else ""
    if cause.wires[0] == STATE and cause.fields:
        unit = shown("", cause.fields[0])[1]
    return f"{number(value)}{unit}"


def _said(verb: str, plural_verb: str) -> Callable[[Speaker, Cause], str]:
    def say(speaker: Speaker, cause: Cause) -> str:
        subject, is_plural = speaker.subject(cause)
        return f"{subject} {plural_verb if is_plural else verb}{when(cause)}"

    return say


def _late(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    how = "late" if cause.amount > 0 else "early"
    return f"{subject} {'come' if is_plural else 'comes'} {abs(cause.amount):.0f} ms {how}{when(cause)}"


def _counted(what: str) -> Callable[[Speaker, Cause], str]:
    def say(speaker: Speaker, cause: Cause) -> str:
        subject, is_plural = speaker.subject(cause)
        frames = "rows" if cause.wires[0] == STATE else "frames"
        frames = f"{cause.amount:.0f} {frames if cause.amount != 1 else frames[:-1]}"
        return f"{subject} {'are' if is_plural else 'is'} {what.format(frames=frames)}{when(cause)}"

    return say


def _flipped(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    if cause.amount and len(cause.fields) == 1:
        return f"{subject} is reversed around {_with_unit(cause, cause.amount)}{when(cause)}"
    return f"{subject} {'have' if is_plural else 'has'} the opposite sign{when(cause)}"


def _valued(what: str) -> Callable[[Speaker, Cause], str]:
    def say(speaker: Speaker, cause: Cause) -> str:
        subject, is_plural = speaker.subject(cause)
        return f"{subject} {'are' if is_plural else 'is'} {what.format(_with_unit(cause, cause.amount))}{when(cause)}"

    return say


def _offset(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    sign = "+" if cause.amount > 0 else ""
    return f"{subject} {'are' if is_plural else 'is'} offset by {sign}{_with_unit(cause, cause.amount)}{when(cause)}"


def _stuck(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    at = f" at {_with_unit(cause, cause.amount)}" if len(cause.fields) == 1 else ""
    return f"{subject} {'are' if is_plural else 'is'} stuck{at}{when(cause)}"


def _scaled(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    return f"{subject} {'are' if is_plural else 'is'} scaled by {cause.amount:.3g}{when(cause)}"


def _noise(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = speaker.subject(cause)
    size = f" of {_with_unit(cause, cause.amount)} (rms)" if len(cause.fields) == 1 else ""
    return f"{subject} {'have' if is_plural else 'has'} noise{size}{when(cause)}"


def _rate(speaker: Speaker, cause: Cause) -> str:
    subject, is_plural = _whole(speaker, cause)
    new, usual = (f"{period:.3f}".rstrip("0").rstrip(".") for period in (cause.amount, cause.usual))
    return f"{subject} {'come' if is_plural else 'comes'} every {new} ms instead of every {usual} ms{when(cause)}"


def _whole(speaker: Speaker, cause: Cause) -> tuple[str, bool]:
    name = speaker.wire(cause.wires[0])
    return name, _is_plural(name)


def _order(speaker: Speaker, cause: Cause) -> str:
    if len(cause.wires) == 1:
        subject, is_plural = _whole(speaker, cause)
        return f"{subject} {'come' if is_plural else 'comes'} in another order{when(cause)}"
    ids = _listed([wire.removeprefix("can ") for wire in cause.wires])
    return f"{ids} come in another order within {cause.amount:.0f} ticks{when(cause)}"


def _length(_: Speaker, cause: Cause) -> str:
    how = "ends {} later" if cause.amount > 0 else "ends {} earlier"
    return f"the run {how.format(seconds(abs(int(cause.amount))))} than the golden; until then they are the same"


_SAY: dict[str, Callable[[Speaker, Cause], str]] = {
    "late": _late,
    "dropped": _counted("dropped: {frames} of the golden missing"),
    "duplicated": _counted("duplicated: {frames} twice"),
    "added": _counted("not alone: {frames} that the golden has not"),
    "swapped": lambda speaker, cause: f"{speaker.swapped(cause)}{when(cause)}",
    "flipped": _flipped,
    "scaled": _scaled,
    "offset": _offset,
    "order": _order,
    "stuck": _stuck,
    "quantised": _valued("quantised to steps of {}"),
    "rate": _rate,
    "noise": _noise,
    "changed": _said("differs in no way that has a name", "differ in no way that has a name"),
    "length": _length,
}
