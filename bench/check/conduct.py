"""Runs a run: block by block through all that follows it, in one order, whoever asked for it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from bench.check.crosswire import Outcome
from bench.check.expectations import Verdict
from bench.check.faulty import Touch
from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.summary import Summary
from bench.messages import TickOutput


def conduct(
    run: Run,
    recorder: Recorder | None = None,
    *,
    blocks: Iterable[list[TickOutput]] | None = None,
    after_block: Callable[[list[TickOutput], list[Touch]], None] | None = None,
) -> Summary:
    """Run to the end: recorded, summed up, held against its expectations and checks.

    `blocks` are the run's own unless given (one that draws a bar, say). `after_block` hears of each block when all
    this has been done, and of what faults touched in it; what it raises ends the run. The recorder is closed whatever
    happens: nothing already recorded is lost.
    """
    summary = Summary(len(run.bench.robot.wheels))
    judge, injector, checks = run.judge, run.injector, run.checks
    try:
        for block in run.blocks() if blocks is None else blocks:
            if recorder is not None:
                recorder.extend(block)
            summary.extend(block)
            if judge is not None:
                for out in block:
                    judge.add(out)
            touches = injector.take_touches() if injector is not None else []
            if touches and recorder is not None:
                recorder.witness([touch.text for touch in touches])
            if checks is not None:
                for touch in touches:
                    checks.touched(touch.tick, touch.fault, touch.wire)
                checks.extend(block)
            if after_block is not None:
                after_block(block, touches)
    finally:
        if recorder is not None:
            recorder.close()
    return summary


def shortcomings(run: Run) -> list[str]:
    """Why a run that is over is not as its scenario wants it: a sentence each, none where it is."""
    return reasons(
        run.judge.verdicts() if run.judge is not None else (),
        run.injector.untouched() if run.injector is not None else (),
        run.checks.outcomes() if run.checks is not None else (),
    )


def reasons(verdicts: Iterable[Verdict], untouched: Iterable[str], outcomes: Iterable[Outcome]) -> list[str]:
    """A sentence for each expectation that is not met, each fault that touched nothing, each finding of the wires."""
    found = [verdict.text for verdict in verdicts if not verdict.ok]
    found += [f"{name}: this fault touched nothing" for name in untouched]
    return found + [line for outcome in outcomes if not outcome.ok for line in outcome.lines]
