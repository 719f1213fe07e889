"""The checks of the wires as lamps, beside a run on the screen: the same ones as in a run without a screen.

A tick costs a place in a list; the work is done once a frame, in whole blocks, as a run without a screen does it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bench.check.crosswire import CrossWire, Outcome
from bench.check.crosswire.block import BLOCK_TICKS
from bench.check.crosswire.settings import EXPECTED, OFF
from bench.check.expectations import FAILED, HOLDS, NOT_YET, PASSED, UNTESTED
from bench.check.faulty import Touch
from bench.messages import TickOutput

NAMES = {"motion": "motion", "rest_current": "current at rest", "answers": "answers", "bus": "ids, rates, bus time"}
SWITCHED_OFF = "off"
BLOCKS_TOLD = 5
"""Words cost as much as half a block's checks: half a second is soon enough for them."""
LEAD_TICKS = 1000
"""So much of a run is looked at before its checks begin in the middle of it: who has asked what."""


class WireLamp(NamedTuple):
    """One check: its state is that of an expectation, or `SWITCHED_OFF`; `reasons` has a sentence or more.

    `short` says less, where there is no room.
    """

    name: str
    state: str
    reasons: tuple[str, ...]
    short: str = ""


class WireLamps:
    """A link's taker. `since_tick`: the run is judged from there on, and `lead` are ticks before it."""

    def __init__(self, checks: CrossWire, since_tick: int = 0, lead: Sequence[TickOutput] = ()) -> None:
        self.checks = checks
        self.since_tick = since_tick
        self._ticks: list[TickOutput] = []
        self.add = self._ticks.append
        """One more tick."""
        self._seen = 0
        self._untold = 0
        """Blocks since the lamps were put into words; and how many ticks were waiting for theirs."""
        self._ended = False
        self._lamps: tuple[WireLamp, ...] | None = None
        self._failed: set[str] = set()
        checks.join(lead)

    def touched(self, touch: Touch) -> None:
        """A fault has touched something, in the newest tick or one that is still to come."""
        self.checks.touched(touch.tick, touch.fault, touch.wire)

    @property
    def lamps(self) -> tuple[WireLamp, ...]:
        """How each check stands, half a second ago or less."""
        self._catch_up()
        if self._lamps is None:
            outcomes = self.checks.outcomes() if self._ended else self.checks.so_far()
            self._lamps = tuple(_lamp(one, self._ended) for one in outcomes)
        return self._lamps

    def news(self) -> str:
        """A sentence where a check has failed since the last call."""
        fresh = [lamp for lamp in self.lamps if lamp.state == FAILED and lamp.name not in self._failed]
        self._failed |= {lamp.name for lamp in fresh}
        return f"a check of the wires failed ({', '.join(lamp.name for lamp in fresh)}): 4 says why" if fresh else ""

    def close(self) -> None:
        """The run has ended: what was not broken until now has passed."""
        self._catch_up()
        self.checks.extend(self._ticks)
        self._ticks.clear()
        self._ended, self._lamps = True, None

    def _catch_up(self) -> None:
        """In whole blocks. What came of some is put into words at once, and where time has come to stand."""
        ticks = self._ticks
        stands, self._seen = len(ticks) == self._seen, len(ticks)
        while ticks and (count := BLOCK_TICKS - ticks[0].tick % BLOCK_TICKS) <= len(ticks):
            self.checks.extend(ticks[:count])
            del ticks[:count]
            self._untold += 1
            self._seen = -1
        if self._untold >= BLOCKS_TOLD or (self._untold and stands):
            self._untold, self._lamps = 0, None


def _lamp(one: Outcome, ended: bool) -> WireLamp:
    name = NAMES[one.name]
    if one.state == OFF:
        return WireLamp(name, SWITCHED_OFF, ("switched off by the scenario",))
    if one.findings:
        expected = one.state == EXPECTED
        texts = tuple(finding.text for finding in one.findings)
        return WireLamp(name, PASSED if expected else FAILED, texts)
    if one.state == EXPECTED:
        return WireLamp(name, FAILED if ended else NOT_YET, ("the scenario expects it to fail, and it has not",))
    if not one.judged:
        return WireLamp(name, UNTESTED, (one.measured,))
    return WireLamp(name, PASSED if ended else HOLDS, (one.measured,), f"{one.used:.0%} of the limit")
