"""Scenarios from Python: what a file can say, without a file. For loops: a sweep over friction, delay, a gain.

    from bench.scenarios import run

    drive = {"seconds": 2.0, "stick": [{"at_s": 0.2, "aux1": True}, {"at_s": 0.3, "forward": 0.5}]}
    for delay_ms in (1, 5, 20):
        late = {"wire": "command", "kind": "delay", "ms": delay_ms, "at_s": 0.0}
        result = run(name=f"{delay_ms} ms", **drive, fault=[late], expect=[{"always": "speed_mps < 0.6"}])
        print(delay_ms, result.ok, result.verdicts[0].margin)

The keys are those of a scenario file (docs/scenarios.md), tables are dicts, lists of tables lists of dicts. What Python
can say besides: a `Robot` changed with `dataclasses.replace`, and a controller that is a class or a function.

These names are here to stay: `run`, `run_many`, `prepare`, `Result`, `Verdict`, `Robot`, `load_robot`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from bench.check.controllers import Build
from bench.check.crowd import Tell, each
from bench.check.expectations import Verdict
from bench.check.run import Run
from bench.check.scenario import scenario_of
from bench.check.sources import run_of
from bench.check.suite import Result, run_to_end
from bench.config import Robot, load_robot
from bench.errors import BenchError, UsageError

__all__ = ["Result", "Robot", "Run", "Verdict", "load_robot", "prepare", "run", "run_many"]


def prepare(*, robot: str | Path | Robot = "m2006", controller: str | Build | None = None, **keys: Any) -> Run:
    """A run of a scenario with these keys. Iterate over it, once, for the `TickOutput` of every tick; its `bench` is
    there to be looked at meanwhile. Raises BenchError in one sentence that names the key.
    """
    said = dict(keys)
    if not isinstance(robot, Robot):
        said["robot"] = str(robot)
    if isinstance(controller, str):
        said["controller"] = controller
    return run_of(
        scenario_of({"name": "", **said}),
        robot=robot if isinstance(robot, Robot) else None,
        controller=None if isinstance(controller, str) else controller,
    )


def run(*, record: str | Path | None = None, overwrite: bool = False, **keys: Any) -> Result:
    """Run a scenario with these keys to its end. `record` is the directory of its recording.

    The result has `ok`, `verdicts` (each with its `margin`), `untouched` faults, `summary` (numbers by name), `columns`
    and `rows` (state every 10 ms). Raises BenchError as `prepare` does, and where the recording cannot be written.
    """
    job = prepare(**keys)
    return run_to_end(job, job.recorder(record, overwrite=overwrite) if record is not None else None)


def run_many(scenarios: Iterable[Mapping[str, Any]], *, jobs: int = 2) -> Iterator[Result]:
    """The same for many, some at a time in processes of their own; results in order, each as soon as it is there.

    A scenario that cannot be run is a result with its `error`: the others go on. What is given has to cross to another
    process: a controller is a text or a class of a module, and the calling script has a `__name__ == "__main__"` guard.
    """
    if jobs < 1:
        raise UsageError(f"jobs: expected 1 or more, got {jobs}")
    return each(_result, list(scenarios), jobs, _failed)


def _result(keys: Mapping[str, Any], _tell: Tell) -> Result:
    try:
        return run(**keys)
    except BenchError as error:
        return _failed(keys, str(error))


def _failed(keys: Mapping[str, Any], why: str) -> Result:
    return Result("", str(keys.get("name", "scenario")), error=why)
