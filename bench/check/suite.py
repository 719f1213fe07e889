"""Scenarios, many at once: each in a process of its own turn, with a result that can be printed, counted and drawn.

A scenario that cannot be read or run is a result too, with its sentence: the others go on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from bench.check.conduct import conduct, reasons
from bench.check.crosswire import Outcome
from bench.check.crowd import Stopped, Tell, Watch, each
from bench.check.expectations import Verdict
from bench.check.faulty import Touch
from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.sources import from_scenario
from bench.errors import BenchError
from bench.messages import TickOutput

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
    stopped_tick: int | None = None
    """How many ticks had run when it was interrupted."""
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
        told = [self.error] if self.error else []
        return told + reasons(self.verdicts, self.untouched, self.checks)

    def as_dict(self) -> dict[str, object]:
        """Plain values for --json, without the rows."""
        facts: dict[str, object] = {"path": self.path, "name": self.name, "ok": self.ok, "reasons": self.reasons}
        facts["expectations"] = [verdict.as_dict() for verdict in self.verdicts]
        facts["faults"] = [asdict(span) for span in self.faults]
        return facts | {"summary": self.summary}


def run_scenario(path: Path, tell: Tell | None = None, record: Path | None = None, overwrite: bool = False) -> Result:
    """Run one scenario; `record` is the folder that gets a recording of its name."""
    ticks: list[int] = [0]
    try:
        return _run(path, record, overwrite, _counting(tell, ticks))
    except Stopped:
        kept = f"interrupted at {ticks[0] / 1000:.3f} s" if ticks[0] else "interrupted before it began"
        return Result(str(path), path.stem, error=kept, stopped_tick=ticks[0])
    except BenchError as error:
        return Result(str(path), path.stem, error=str(error))


def _counting(tell: Tell | None, ticks: list[int]) -> Callable[[int, int], None] | None:
    """Tells the share of so many ticks of all; `ticks[0]` keeps the last."""
    if tell is None:
        return None

    def count(done: int, of_all: int) -> None:
        ticks[0] = done
        tell(done / of_all)

    return count


def run_scenarios(
    paths: Sequence[Path],
    *,
    jobs: int,
    record: Path | None = None,
    overwrite: bool = False,
    watch: Watch | None = None,
) -> Iterator[Result]:
    """All of them, so many at a time; the results come in the order of the paths. `watch` sees how far each is, and may
    end them all.
    """
    yield from each(partial(run_scenario, record=record, overwrite=overwrite), paths, jobs, _lost, watch)


def _lost(path: Path, why: str) -> Result:
    return Result(str(path), path.stem, error=why)


def _run(path: Path, record: Path | None, overwrite: bool, count: Callable[[int, int], None] | None) -> Result:
    if count is not None:
        count(0, 1)  # one that is told to end before it begins leaves nothing behind
    job = from_scenario(path)
    recorder = job.recorder(record / path.stem, overwrite=overwrite) if record is not None else None
    result = run_to_end(job, recorder, count)
    return replace(result, path=str(path), rows=result.rows[:: max(1, len(result.rows) // DRAWN_ROWS)])


def run_to_end(job: Run, recorder: Recorder | None = None, count: Callable[[int, int], None] | None = None) -> Result:
    """Run it, record it, judge it. `rows` holds every row of state; the recording ends with it, whatever happens.
    `count` hears after each block how many ticks of all are done.
    """
    robot = job.bench.robot
    rows: list[tuple[float | int | str, ...]] = []
    spans: dict[str, list[int]] = {}

    def keep(block: list[TickOutput], touches: list[Touch]) -> None:
        rows.extend(tuple(out.state) for out in block if out.state is not None)
        for touch in touches:
            span = spans.setdefault(touch.fault, [touch.tick, touch.tick, 0])
            span[1], span[2] = touch.tick, span[2] + 1
        if count is not None and block:
            count(block[-1].tick + 1, job.ticks)

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
