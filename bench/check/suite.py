"""Scenarios, many at once: each in a process of its own turn, with a result that can be printed, counted and drawn.

A scenario that cannot be read or run is a result too, with its sentence: the others go on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from xml.etree import ElementTree as Xml

from bench.check.conduct import conduct
from bench.check.crosswire import Outcome
from bench.check.crosswire.settings import OFF
from bench.check.expectations import Verdict
from bench.check.faulty import Touch
from bench.check.recording import Recorder
from bench.check.run import Run, from_scenario
from bench.errors import BenchError
from bench.messages import TickOutput

Given = TypeVar("Given")

DRAWN_ROWS = 600
"""Rows of state that a picture gets, at most."""


@dataclass(frozen=True, slots=True)
class FaultSpan:
    """When a fault touched something first and last, in ticks, and how often."""

    name: str
    first: int
    last: int
    touched: int


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one scenario."""

    path: str
    name: str
    about: str = ""
    robot: str = ""
    error: str = ""
    """Why it could not be run; all else is empty then."""
    ticks: int = 0
    current_limit_a: float = 0.0
    summary: dict[str, Any] = field(default_factory=dict)
    verdicts: tuple[Verdict, ...] = ()
    faults: tuple[FaultSpan, ...] = ()
    untouched: tuple[str, ...] = ()
    checks: tuple[Outcome, ...] = ()
    """Of what its wires say of each other."""
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[float | int | str, ...], ...] = ()
    """Rows of state, thinned for drawing."""

    @property
    def ok(self) -> bool:
        """It ran, every expectation is met, every fault touched something, and its wires agree."""
        met = all(verdict.ok for verdict in self.verdicts) and all(outcome.ok for outcome in self.checks)
        return met and not self.error and not self.untouched

    @property
    def reasons(self) -> list[str]:
        """Every reason why it is not."""
        reasons = [self.error] if self.error else []
        reasons += [verdict.text for verdict in self.verdicts if not verdict.ok]
        reasons += [f"{name}: this fault touched nothing" for name in self.untouched]
        return reasons + [line for outcome in self.checks if not outcome.ok for line in outcome.lines]

    def as_dict(self) -> dict[str, object]:
        """Plain values for --json, without the rows."""
        facts: dict[str, object] = {"path": self.path, "name": self.name, "ok": self.ok, "reasons": self.reasons}
        facts["expectations"] = [verdict.as_dict() for verdict in self.verdicts]
        facts["faults"] = [asdict(span) for span in self.faults]
        return facts | {"summary": self.summary}


def run_scenario(path: Path, record: Path | None = None, overwrite: bool = False) -> Result:
    """Run one scenario; `record` is the folder that gets a recording of its name."""
    try:
        return _run(path, record, overwrite)
    except BenchError as error:
        return Result(str(path), path.stem, error=str(error))


def run_scenarios(
    paths: Sequence[Path], *, jobs: int, record: Path | None = None, overwrite: bool = False
) -> Iterator[Result]:
    """All of them, so many at a time; the results come in the order of the paths."""
    yield from in_processes(partial(run_scenario, record=record, overwrite=overwrite), paths, jobs)


def in_processes(one: Callable[[Given], Result], given: Sequence[Given], jobs: int) -> Iterator[Result]:
    """One result for each of what is given, in that order, so many at a time."""
    import multiprocessing

    if jobs == 1 or len(given) < 2:
        yield from map(one, given)
        return
    # Fresh processes: a fork of a program that has threads or a screen is a risk.
    with multiprocessing.get_context("spawn").Pool(min(jobs, len(given))) as pool:
        yield from pool.imap(one, given)


def junit_xml(results: Sequence[Result]) -> str:
    """The results as JUnit XML, as CI servers read it: a test case for each expectation."""
    suites = Xml.Element("testsuites", name="wheelbench")
    for result in results:
        cases = [(verdict.name, "" if verdict.ok else verdict.text) for verdict in result.verdicts]
        cases += [(f"fault {name}", "touched nothing") for name in result.untouched]
        for outcome in result.checks:
            if outcome.state != OFF:
                cases.append((f"check {outcome.name}", "" if outcome.ok else "; ".join(outcome.lines)))
        if result.error or not cases:
            cases.append(("runs", result.error))
        failed = sum(bool(why) for _, why in cases)
        seconds = f"{result.ticks / 1000:.3f}"  # simulated: how long a machine took is not a fact of the run
        suite = Xml.SubElement(
            suites, "testsuite", name=result.name, tests=str(len(cases)), failures=str(failed), time=seconds
        )
        for name, why in cases:
            case = Xml.SubElement(suite, "testcase", classname=result.path, name=name)
            if why:
                Xml.SubElement(case, "failure", message=why)
    Xml.indent(suites)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + Xml.tostring(suites, encoding="unicode") + "\n"


def _run(path: Path, record: Path | None, overwrite: bool) -> Result:
    job = from_scenario(path)
    recorder = job.recorder(record / path.stem, overwrite=overwrite) if record is not None else None
    result = run_to_end(job, recorder)
    return replace(result, path=str(path), rows=result.rows[:: max(1, len(result.rows) // DRAWN_ROWS)])


def run_to_end(job: Run, recorder: Recorder | None = None) -> Result:
    """Run it, record it, judge it. `rows` holds every row of state; the recording ends with it, whatever happens."""
    robot = job.bench.robot
    rows: list[tuple[float | int | str, ...]] = []
    spans: dict[str, list[int]] = {}

    def keep(block: list[TickOutput], touches: list[Touch]) -> None:
        rows.extend(tuple(out.state) for out in block if out.state is not None)
        for touch in touches:
            span = spans.setdefault(touch.fault, [touch.tick, touch.tick, 0])
            span[1], span[2] = touch.tick, span[2] + 1

    summary = conduct(job, recorder, after_block=keep)
    return Result(
        path="",
        name=job.title,
        about=job.about,
        robot=robot.name,
        ticks=job.ticks,
        current_limit_a=robot.limits.current_a,
        summary=summary.facts(job),
        verdicts=tuple(job.judge.verdicts()) if job.judge else (),
        faults=tuple(FaultSpan(name, *span) for name, span in spans.items()),
        untouched=tuple(job.injector.untouched()) if job.injector else (),
        checks=tuple(job.checks.outcomes()) if job.checks else (),
        columns=job.bench.state_columns,
        rows=tuple(rows),
    )
