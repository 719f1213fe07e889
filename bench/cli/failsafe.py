"""`wheelbench failsafe`: every loss in every phase of a drive, and whether the robot did what its rules say."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bench.cli.choices import add_controller, check_jobs

if TYPE_CHECKING:
    from bench.check.crowd import Tell
    from bench.check.failsafe import Cell, Loss
    from bench.config import Robot

NAME_WIDTH, CELL_WIDTH = 18, 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument(
        "--robot", metavar="R", default="m2006", help="a name that `wheelbench robots` lists, or a .toml file (m2006)"
    )
    parser.add_argument("--profile", metavar="P", help="the transmitter's profile: a name or a .toml file")
    add_controller(parser)
    parser.add_argument("--only", metavar="LOSS", help="only the losses whose name contains this text")
    parser.add_argument(
        "--frozen-ms",
        metavar="N",
        type=int,
        help="sticks off the middle that do not change for so long are frozen",
    )
    parser.add_argument("--jobs", metavar="N", type=int, default=2, help="losses: so many at a time (2)")
    parser.add_argument("--html", metavar="FILE", type=Path, help="write the matrix as a page too")
    parser.add_argument("--json", action="store_true", help="one object a cell")


def run(args: argparse.Namespace) -> int:
    """Run the matrix; exit status 1 where a cell is red."""
    from bench.check.controllers import controller_of
    from bench.check.failsafe import RED, losses
    from bench.cli.output import Speaker, refuse_hopeless, write_text
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError

    robot = _robot(args)
    refuse_hopeless(args.html)
    try:
        rows = losses(robot)
    except ValueError as error:
        raise UsageError(f"{error}; give --profile") from None
    numbers = [number for number, loss in enumerate(rows) if (args.only or "").lower() in loss.name.lower()]
    if not numbers:
        raise UsageError(f"--only: no loss is called {args.only!r}; known: {', '.join(loss.name for loss in rows)}")
    chosen = controller_of(robot, args.controller)
    chosen.build(chosen.robot)  # one that does not come up is told once, not in every cell
    speaker = Speaker(is_kept=args.html is not None)
    if not args.json:
        speaker.say(*_header(robot, args.controller))
    matrix = []
    for number, cells in zip(numbers, _rows(robot, rows, numbers, args), strict=True):
        matrix.append((rows[number], cells))
        if args.json:
            speaker.say_facts(*(cell.as_dict() for cell in cells))
        else:
            speaker.say(_line(cells))
    if not args.json:
        speaker.say(*_below(matrix))
    if args.html:
        write_text(args.html, _page(robot, args.controller, matrix))
    speaker.end()
    return EXIT_FAILED if any(cell.verdict == RED for _, cells in matrix for cell in cells) else EXIT_OK


def _robot(args: argparse.Namespace) -> Robot:
    from dataclasses import replace

    from bench.config import load_robot
    from bench.errors import UsageError

    check_jobs(args.jobs)
    robot = load_robot(args.robot, args.profile)
    if args.frozen_ms is None or robot.rc is None:
        return robot
    if args.frozen_ms < 1:
        raise UsageError(f"--frozen-ms: expected 1 or more, got {args.frozen_ms}")
    return replace(robot, rc=replace(robot.rc, frozen_ms=args.frozen_ms))


def _rows(
    robot: Robot, losses: Sequence[Loss], numbers: Sequence[int], args: argparse.Namespace
) -> Iterator[list[Cell]]:
    """Row by row in order, several at a time. To show a traceback, all of it happens here, and ends with the first
    error.
    """
    from functools import partial

    from bench.check.crowd import each
    from bench.check.failsafe import failed_row

    def lost(number: int, why: str) -> list[Cell]:
        return failed_row(losses[number], why)

    jobs = 1 if args.traceback else args.jobs
    return each(partial(_row, robot, args.controller, args.traceback), numbers, jobs, lost)


def _row(robot: Robot, controller: str | None, raises: bool, number: int, _tell: Tell) -> list[Cell]:
    from bench.check.failsafe import run_row

    return run_row(robot, number, controller=controller, raises=raises)


def _who(controller: str | None) -> str:
    from bench.check.subjects import SUBJECTS

    if controller is None:
        return "the bench's own controller"
    return f"wrong on purpose: {controller}" if controller in SUBJECTS else f"controller {controller}"


def _header(robot: Robot, controller: str | None) -> list[str]:
    from bench.check.failsafe import PHASES

    who = _who(controller)
    profile = robot.rc.name if robot.rc else ""
    names = "".join(f"{phase:<{CELL_WIDTH}}" for phase in PHASES).rstrip()
    return [f"{robot.name} with {profile}, {who}: from loss to stop", "", f"{'':{NAME_WIDTH}}{names}"]


def _line(cells: Sequence[Cell]) -> str:
    shown = "".join(f"{_words(cell):<{CELL_WIDTH}}" for cell in cells)
    return f"{cells[0].loss:<{NAME_WIDTH}}{shown}".rstrip()


def _words(cell: Cell) -> str:
    if cell.verdict == "off":
        return "off"
    if cell.failed:
        return f"{cell.verdict} failed"
    return f"{cell.verdict} {'goes on' if cell.stop_ms is None else f'{cell.stop_ms} ms'}"


def _below(matrix: Sequence[tuple[Loss, Sequence[Cell]]]) -> Iterator[str]:
    """The rules, and every red cell with its reasons."""
    yield ""
    for loss, cells in matrix:
        rule = f"off: {cells[0].why[0]}" if cells[0].verdict == "off" else loss.rule
        yield f"{loss.name:<{NAME_WIDTH}}{rule}"
    red = [cell for _, cells in matrix for cell in cells if cell.verdict == "RED"]
    told: dict[tuple[str, tuple[str, ...]], list[str]] = {}  # a row's cells that are red for the same reason: one line
    for cell in red:
        told.setdefault((cell.loss, cell.why), []).append(cell.phase)
    judged = [cell for _, cells in matrix for cell in cells if cell.verdict != "off"]
    yield ""
    for (loss_name, why), phases in told.items():
        yield from f"RED  {loss_name}, {', '.join(phases)}: {'; '.join(why)}".split("\n")  # a crash has its own words
    yield f"{len(judged) - len(red)} of {len(judged)} cells as their rules say"


def _page(robot: Robot, controller: str | None, matrix: Sequence[tuple[Loss, Sequence[Cell]]]) -> str:
    """One self-contained page."""
    from html import escape

    from bench.check.failsafe import PHASES

    rows = []
    for loss, cells in matrix:
        boxes = "".join(
            f'<td class="{cell.verdict.lower()}" title="{escape("; ".join(cell.why))}"><b>{cell.verdict}</b>'
            f"{'' if cell.verdict == 'off' else _facts(cell)}</td>"
            for cell in cells
        )
        rows.append(f"<tr><th>{escape(loss.name)}<small>{escape(loss.rule)}</small></th>{boxes}</tr>")
    reasons = "".join(
        f"<li><b>{escape(cell.loss)}, {cell.phase}</b>: {escape('; '.join(cell.why))}</li>"
        for _, cells in matrix
        for cell in cells
        if cell.verdict == "RED"
    )
    who = _who(controller)
    title = f"Failsafe matrix: {robot.name} with {robot.rc.name if robot.rc else ''}"
    head = "".join(f"<th>{phase}</th>" for phase in PHASES)
    return f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{escape(title)}</title>
<style>
 body {{ font: 15px/1.45 system-ui, sans-serif; margin: 2rem; color: #1c2430; background: #fff }}
 table {{ border-collapse: collapse }} td, th {{ border: 1px solid #cfd6df; padding: .45rem .7rem; text-align: left }}
 thead th {{ background: #eef2f6 }} th small {{ display: block; font-weight: 400; color: #5a6675; max-width: 22rem }}
 td {{ white-space: nowrap; font-variant-numeric: tabular-nums }} td b {{ display: block }}
 .ok {{ background: #e5f4ea }} .red {{ background: #f9d9d6; outline: 2px solid #b3261e }} .off {{ color: #8a94a0 }}
</style>
<h1>{escape(title)}</h1><p>{escape(who)}. Each cell: from the loss until the robot stands, how far it went, and the
largest commanded current where there should be none.</p>
<table><thead><tr><th>what is lost</th>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table>
{f"<h2>Red</h2><ul>{reasons}</ul>" if reasons else ""}
</html>
"""


def _facts(cell: Cell) -> str:
    if cell.failed:
        return "failed"
    stop = "drives on" if cell.stop_ms is None else f"{cell.stop_ms} ms"
    return f"{stop}<br>{100 * cell.stop_m:.1f} cm<br>{cell.residual_a:.3f} A"
