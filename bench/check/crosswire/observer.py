"""The four checks together: takes ticks one by one or in blocks, and says at the end what became of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bench.check.crosswire.answers import AnswersJudge
from bench.check.crosswire.block import BLOCK_TICKS, Block
from bench.check.crosswire.buses import BusJudge
from bench.check.crosswire.finding import Finding, Outcome
from bench.check.crosswire.ledger import Ledger
from bench.check.crosswire.motion import MotionJudge
from bench.check.crosswire.rest import RestJudge
from bench.check.crosswire.settings import OFF, Checks
from bench.config import Robot
from bench.messages import TickOutput
from bench.noise import SILENT, Noise

MOST_FAULTS_NAMED = 3


class CrossWire:
    """The checks of one run, which begins at tick 0.

    Without `truth` the rows of state say nothing of these wires; `noise` is that of the run's feedback.
    """

    def __init__(
        self,
        robot: Robot,
        state_columns: Sequence[str],
        checks: Checks | None = None,
        *,
        truth: bool = True,
        noise: Noise = SILENT,
    ) -> None:
        self.checks = checks = checks or Checks()
        self._block: list[TickOutput] = []
        self._touches: dict[str, tuple[int, int]] = {}
        self._ledger = Ledger(checks.answers.within_ms)
        self._motion = MotionJudge(robot, state_columns, checks.motion, truth=truth)
        self._rest = RestJudge(robot, state_columns, checks.rest_current, angles_shake=noise.angle_counts > 0)
        self._answers = AnswersJudge(checks.answers)
        self._bus = BusJudge(robot, checks.bus)
        self._runs_motion = checks.motion.state != OFF
        self._runs_rest = checks.rest_current.state != OFF and truth and not self._rest.is_excused
        self._runs_bus = checks.bus.state != OFF

    def join(self, lead: Sequence[TickOutput]) -> None:
        """Follow a run from the tick after these on: they only tell who has asked what until then."""
        for start in range(0, len(lead), BLOCK_TICKS):
            self._ledger.take(Block(lead[start : start + BLOCK_TICKS]))

    def add(self, out: TickOutput) -> None:
        """The next tick."""
        self._block.append(out)
        if (out.tick + 1) % BLOCK_TICKS == 0:
            self._look()

    def extend(self, outs: Sequence[TickOutput]) -> None:
        """Some ticks, one after the other."""
        if not self._block and len(outs) == BLOCK_TICKS and outs[0].tick % BLOCK_TICKS == 0:
            self._block = list(outs)
            self._look()
            return
        for out in outs:
            self.add(out)

    def touched(self, tick: int, fault: str, wire: str) -> None:
        """A fault of the scenario has touched something in this tick; told before the tick is."""
        first, _ = self._touches.get(fault, (tick, tick))
        self._touches[fault] = first, tick
        if wire == "plant":
            self._rest.disturbed(tick)

    def outcomes(self) -> list[Outcome]:
        """At the end of the run, in the order of the settings."""
        if self._block:
            self._look()
        return self.so_far()

    def so_far(self) -> list[Outcome]:
        """The same while the run goes on: as of its last whole block."""
        found = [self._motion.outcome(), self._rest.outcome(), self._answers.outcome(), self._bus.outcome()]
        return [
            replace(one, findings=() if one.state == OFF else tuple(map(self._with_faults, one.findings)))
            for one in found
        ]

    def _look(self) -> None:
        block = Block(self._block)
        self._block = []
        exchanged = self._ledger.take(block)
        self._answers.take(exchanged)
        if self._runs_motion:
            self._motion.take(block, exchanged)
        if self._runs_rest:
            self._rest.take(block, exchanged)
        if self._runs_bus:
            self._bus.take(block)

    def _with_faults(self, finding: Finding) -> Finding:
        """The finding, and which faults of the scenario acted then or just before."""
        acted = [
            f"{name!r}"
            for name, (first, last) in self._touches.items()
            if first <= finding.last_tick and last >= finding.first_tick - BLOCK_TICKS
        ]
        if not acted:
            return finding
        names = ", ".join(acted[:MOST_FAULTS_NAMED])
        acted_then = (
            f"{'faults' if len(acted) > 1 else 'fault'} {names}{' and more' * (len(acted) > MOST_FAULTS_NAMED)}"
        )
        return replace(finding, text=f"{finding.text} (the {acted_then} acted then)")
