"""What a check of the wires found, in words, and what became of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from bench.check.crosswire.settings import EXPECTED, OFF, ON


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that two wires do not agree about, or that cannot be; ticks of its first and last sight."""

    text: str
    first_tick: int
    last_tick: int
    count: int = 1


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one check."""

    name: str
    state: str
    """on, off or expected."""
    findings: tuple[Finding, ...]
    judged: int
    """How many windows, rests, requests it has looked at."""
    measured: str
    """The worst that it saw, and what is allowed, for people."""
    used: float
    """The worst as a share of what is allowed; 0 where nothing was judged."""

    @property
    def ok(self) -> bool:
        """Nothing found; or something, where the scenario expects that."""
        if self.state == OFF:
            return True
        return bool(self.findings) == (self.state == EXPECTED)

    @property
    def lines(self) -> list[str]:
        """For people: one line, or one for each finding."""
        if self.state == OFF:
            return [f"{self.name}: switched off"]
        if self.findings:
            return [f"{self.name}: {finding.text}" for finding in self.findings]
        if self.state == EXPECTED:
            return [f"{self.name}: the scenario expects a finding, and there was none ({self.measured})"]
        return [f"{self.name}: {self.measured}"]

    def as_dict(self) -> dict[str, object]:
        """Plain values for --json."""
        facts: dict[str, object] = {"name": self.name, "state": self.state, "ok": self.ok, "judged": self.judged}
        facts |= {"used": round(self.used, 4), "measured": self.measured}
        return facts | {"findings": [asdict(finding) for finding in self.findings]}


def span(first_tick: int, last_tick: int) -> str:
    """A stretch of time for people."""
    return f"{first_tick / 1000:.3f} to {last_tick / 1000:.3f} s"


def check_lines(outcomes: Sequence[Outcome]) -> list[str]:
    """One line for the checks that found nothing, one for each finding: capitals where a run fails by it."""
    quiet = [one for one in outcomes if one.state == ON and one.ok]
    lines = []
    if quiet:
        agree = "the rest agrees" if any(one.findings for one in outcomes) else "the wires agree"
        used = ", ".join(f"{one.name} {one.used:.0%}" for one in quiet if one.judged)
        idle = ", ".join(one.name for one in quiet if not one.judged)
        told = [f"used of what is allowed: {used}"] if used else []
        lines = ["checks    " + "; ".join([agree, *told, *([f"nothing to judge: {idle}"] if idle else [])])]
    for one in outcomes:
        if one not in quiet:
            lines += [f"{'check' if one.ok else 'CHECK':10}{line}" for line in one.lines]
    return lines
