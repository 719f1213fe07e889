"""What may go wrong in a run: `[[fault]]` in a scenario. Values and their reading; `faulty` makes them happen.

    wire      what goes wrong                                      kinds
    rc        bytes from the receiver to the base                  SERIAL, and flag, lost_flag, freeze, zeros
    core      bytes from the SLAMWARE core to the base             SERIAL, and freeze
    answer    bytes from the base to the core                      SERIAL, and freeze
    command   CAN frames from the base to the motors               BUS, and freeze
    feedback  CAN frames from the motors to the base               BUS, and freeze, stuck, flag
    esc       a motor with its controller                          silent, weak
    plant     the world                                            slippery, push

    drop           nothing gets through (with `probability`: of each piece)
    delay          by `ms`                        duplicate   every piece twice
    reorder        a piece changes places with the next (of a bus: the frames of a tick are turned round, where there
                   are several)
    corrupt        one bit of a byte turns over, with `probability` for each byte
    lose_byte      a byte is missing, with `probability` for each byte
    truncate       only the first `keep` bytes of every piece
    garbage        random bytes in place of every piece, or where there is none
    stall          everything is held back, and comes at once when the fault ends
    flag, lost_flag, freeze, zeros     whole RC frames with the failsafe or the frame-lost flag set, with the channels
                                       of the first one, with all channels at their lowest
    freeze         on the other wires: every piece, or every frame of an identifier, is the first one again
    flag           on feedback: the motor reports an error (a DM3519 whose file says feedback = "error")
    stuck          the encoder of `esc` stands still: angle as it was, speed 0
    silent         `esc` neither drives nor reports   weak      `esc` gives only `factor` of the current it is told
    slippery       the grip of the floor is `factor` of what it was
    push           a force of `force_n` towards `bearing_deg` in the field

`at_s` or `when` (a condition over the signals: each time it becomes true) begins a fault, `for_s` ends it; without it
the fault stays. A piece is what crosses the wire in one tick. Chance comes from the scenario's seed and the fault's
name.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.config import ConfigError, Table, nearest

SERIAL = ("drop", "delay", "duplicate", "reorder", "corrupt", "lose_byte", "truncate", "garbage", "stall")
BUS = ("drop", "delay", "duplicate", "reorder", "corrupt", "truncate", "stall")
FRAME_KINDS = ("flag", "lost_flag", "freeze", "zeros")
KINDS: dict[str, tuple[str, ...]] = {
    "rc": (*SERIAL, *FRAME_KINDS),
    "core": (*SERIAL, "freeze"),
    "answer": (*SERIAL, "freeze"),
    "command": (*BUS, "freeze"),
    "feedback": (*BUS, "freeze", "stuck", "flag"),
    "esc": ("silent", "weak"),
    "plant": ("slippery", "push"),
}
_WITH_PROBABILITY = {"drop": 1.0, "corrupt": 0.02, "lose_byte": 0.02}
_NEEDS = {"delay": "ms", "truncate": "keep", "weak": "factor", "slippery": "factor", "push": "force_n"}
_MAY_NAME_ESC = ("command", "feedback", "esc")
MOST_MS = 10_000


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault. Times in ticks; `lasting` None: to the end of the run."""

    name: str
    wire: str
    kind: str
    at: int | None = None
    when: str = ""
    lasting: int | None = None
    probability: float = 1.0
    ms: int = 0
    keep: int = 0
    factor: float = 1.0
    force_n: float = 0.0
    bearing_rad: float = 0.0
    esc: int | None = None
    """Wheel number from 1; None: all of them."""

    def __post_init__(self) -> None:
        if self.wire not in KINDS:
            raise ValueError(f"wire: {self.wire!r} is unknown{nearest(self.wire, list(KINDS))}")
        if self.kind not in KINDS[self.wire]:
            raise ValueError(
                f"kind: {self.kind!r} is unknown on wire {self.wire!r}{nearest(self.kind, list(KINDS[self.wire]))}"
            )
        if (self.at is None) == (not self.when):
            raise ValueError("a fault begins at_s, or when a condition becomes true: give one of the two")
        for what, value, least, most in (
            ("at_s", self.at, 0, math.inf),
            ("for_s", self.lasting, 1, math.inf),
            ("probability", self.probability, 0.0, 1.0),
            ("ms", self.ms, 1 if self.kind == "delay" else 0, MOST_MS),
            ("keep", self.keep, 0, 1000),
            ("factor", self.factor, 0.0, 1.0),
            ("esc", self.esc, 1, 8),
        ):
            if value is not None and not least <= value <= most:
                raise ValueError(f"{what}: expected {least:g} to {most:g}, got {value}")
        if not math.isfinite(self.force_n):
            raise ValueError("force_n: expected a finite number")


def read_fault(entry: Table) -> Fault:
    """One `[[fault]]` table. Raises ConfigError with file, key and what to try."""
    wire, kind = entry.get("wire", str), entry.get("kind", str)
    if wire not in KINDS:
        raise entry.fail("wire", f"{wire!r} is unknown{nearest(wire, list(KINDS))}")
    if kind not in KINDS[wire]:
        raise entry.fail("kind", f"{kind!r} is unknown on wire {wire!r}{nearest(kind, list(KINDS[wire]))}")
    ticks = {"at_s": entry.ticks("at_s", None), "for_s": entry.ticks("for_s", None, least=1)}
    given: dict[str, object] = {}
    if kind in _WITH_PROBABILITY:
        given["probability"] = entry.get("probability", float, _WITH_PROBABILITY[kind])
    needs = _NEEDS.get(kind)
    if needs is not None:
        given[needs] = entry.get(needs, int if needs in ("ms", "keep") else float)
    if kind == "push":
        given["bearing_rad"] = math.radians(entry.get("bearing_deg", float, 0.0))
    if wire in _MAY_NAME_ESC:
        given["esc"] = entry.get("esc", int, None)
    name = entry.get("name", str, f"{wire} {kind}")
    when = entry.get("when", str, "")
    entry.refuse_rest()
    try:
        return Fault(name, wire, kind, ticks["at_s"], when, ticks["for_s"], **given)  # type: ignore[arg-type]
    except ValueError as error:
        raise ConfigError(f"{entry.path}: {entry.where}: {error}") from None
