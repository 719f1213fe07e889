"""Every SLAMWARE answer belongs to one request: none lost, none twice, none unasked, none out of order, none late."""

from __future__ import annotations

from bench.check.crosswire.finding import Finding, Outcome
from bench.check.crosswire.ledger import Answer, Exchanged
from bench.check.crosswire.settings import AnswersCheck
from bench.slamware.framing import OK


class AnswersJudge:
    """Takes what the ledger has matched."""

    def __init__(self, check: AnswersCheck) -> None:
        self._check = check
        self._requests = self._answered = 0
        self._slowest_ticks = 0
        self._found: dict[str, Finding] = {}
        self._last: Answer | None = None

    def take(self, exchanged: Exchanged) -> None:
        """The next block."""
        self._requests += len(exchanged.requests)
        for request in exchanged.lost:
            if not request.excused:
                text = f"no answer to a request {request.name} within {self._check.within_ms} ms"
                self._note(text, request.tick)
        for answer in exchanged.answers:
            self._answered += 1
            if answer.request is not None:
                self._slowest_ticks = max(self._slowest_ticks, answer.tick - answer.request.tick)
            if not answer.excused:
                self._look_at(answer)
            self._last = answer
        for tick, length in exchanged.noise:
            self._note(f"{length} bytes from the base are no frame", tick)

    def _look_at(self, answer: Answer) -> None:
        request, frame, last = answer.request, answer.frame, self._last
        said = "an OK" if frame.code == OK else f"status 0x{frame.code:02X}"
        if request is None:
            again = last is not None and (last.frame.code, last.frame.payload) == (frame.code, frame.payload)
            if again and last is not None and last.request is not None:
                self._note(f"a second answer to one request {last.request.name}", answer.tick)
            else:
                self._note(f"an answer that nobody asked for ({said}, {len(frame.payload)} bytes)", answer.tick)
        elif not answer.fits:
            what = f"{said} with {len(frame.payload)} bytes answers a request {request.name}"
            self._note(f"{what}, which it cannot: lost, or out of order", answer.tick)

    def _note(self, text: str, tick: int) -> None:
        seen = self._found.get(text)
        if seen is None:
            self._found[text] = Finding(text, tick, tick)
        else:
            self._found[text] = Finding(text, seen.first_tick, tick, seen.count + 1)

    def outcome(self) -> Outcome:
        """At the end of the run."""
        measured = f"{self._requests} requests, {self._answered} answers"
        if self._answered:
            measured += f", the slowest after {self._slowest_ticks} of {self._check.within_ms} ms"
        findings = tuple(_told(one) for one in self._found.values())
        used = self._slowest_ticks / self._check.within_ms
        return Outcome("answers", self._check.state, findings, self._requests, measured, used)


def _told(finding: Finding) -> Finding:
    """With when and how often."""
    at = f"at {finding.first_tick / 1000:.3f} s"
    times = f"{at}, and {finding.count - 1} times more" if finding.count > 1 else at
    return Finding(f"{finding.text}, {times}", finding.first_tick, finding.last_tick, finding.count)
