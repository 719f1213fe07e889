"""`wheelbench replay` of several scenarios, or of one with a page: side by side, a line for each, a report of all."""

from __future__ import annotations

import argparse
import glob
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bench.check.suite import Result

_ALONE: dict[str, object] = {
    "robot": None, "arena": None, "profile": None, "protocol": None, "period_ms": None, "can": "sim:", "rc": "sim:",
    "slamware": "sim:", "role": "sim", "arm": False, "controller": None, "odometry": None, "golden": None,
    "tolerance": [],
}  # fmt: skip
"""What goes with a single source, and its default."""


def sources_of(given: Sequence[str]) -> list[str]:
    """What was meant: a pattern that the shell has left alone is every file that it fits. Raises UsageError."""
    from bench.errors import UsageError

    sources: list[str] = []
    for source in given:
        is_pattern = any(mark in source for mark in "*?[") and not Path(source).exists()
        fitting = sorted(glob.glob(source)) if is_pattern else [source]
        if not fitting:
            raise UsageError(f"{source}: no scenario fits this pattern")
        if not is_pattern and Path(source).is_dir() and not (Path(source) / "run.toml").exists():
            if any(Path(source).glob("*.toml")):
                what = f"the scenarios in it are replayed by {Path(source) / '*.toml'}"
            else:
                what = "give a scenario (.toml), an RC capture or the directory of a recording"
            raise UsageError(f"{source or '.'}: is a directory without a recording; {what}")
        sources += fitting
    return sources


def suite_of(args: argparse.Namespace) -> int:
    """Run them; exit status 1 where one is not as expected. Ctrl-C ends all: recordings are whole up to there."""
    from bench.check.junit import junit_xml
    from bench.check.page import page
    from bench.check.suite import run_scenarios
    from bench.cli.headless import asked_to_stop
    from bench.cli.output import Speaker, refuse_hopeless, write_text
    from bench.cli.progress import Progress
    from bench.errors import EXIT_FAILED, EXIT_OK

    paths = _paths(args)
    recordings = (args.record, *(args.record / path.stem for path in paths)) if args.record else ()
    refuse_hopeless(args.html, args.junit, recordings=recordings)
    results: list[Result] = []
    speaker = Speaker(is_kept=args.html is not None or args.junit is not None)
    progress = Progress([path.stem for path in paths], is_shown=not args.json)
    with asked_to_stop() as asked:

        def watch(shares: Sequence[float]) -> bool:
            progress.draw(shares)
            return bool(asked)

        for result in run_scenarios(paths, jobs=args.jobs, record=args.record, overwrite=args.overwrite, watch=watch):
            results.append(result)
            progress.failed += not result.ok
            progress.clear()
            if args.json:
                speaker.say_facts(result.as_dict())
            else:
                speaker.say(*_lines(result))
        progress.clear()
    if not args.json:
        speaker.say(*_below(results))
    for path, text in ((args.html, page), (args.junit, junit_xml)):
        if path is not None:
            write_text(path, text(results))
    speaker.end()
    if asked:
        raise KeyboardInterrupt
    return EXIT_OK if all(result.ok for result in results) else EXIT_FAILED


def _paths(args: argparse.Namespace) -> list[Path]:
    from bench.errors import UsageError

    given = [name for name, default in _ALONE.items() if getattr(args, name) != default]
    if given:
        raise UsageError(f"--{given[0].replace('_', '-')}: goes with one source; several scenarios say it themselves")
    other = next((source for source in args.source if not source.endswith(".toml")), None)
    if other is not None:
        advice = "captures and recordings are replayed one at a time, without --html and --junit"
        raise UsageError(f"{other}: is no scenario (.toml); {advice}")
    paths = [Path(source) for source in args.source]
    seen: dict[Path, Path] = {}
    folders: dict[str, Path] = {}
    for path in paths:
        same = seen.setdefault(path.resolve(), path)
        if same is not path:
            raise UsageError(f"{path}: is given twice" + (f", as {same} too" if str(same) != str(path) else ""))
        same = folders.setdefault(path.stem, path)
        if args.record and same is not path:
            raise UsageError(
                f"--record: {same} and {path} would both be recorded in {args.record / path.stem}; rename one of them"
            )
    return paths


def _lines(result: Result) -> list[str]:
    word = "ok" if result.ok else "FAILED" if result.stopped_tick is None else "stopped"
    # A compiler's own words are several lines.
    return [f"{word:8}{result.name}", *(f"        {line}" for reason in result.reasons for line in reason.split("\n"))]


def _below(results: Sequence[Result]) -> list[str]:
    """The count, and what a reader could stumble over."""
    ok = [result for result in results if result.ok]
    lines = [f"{len(ok)} of {len(results)} scenarios as expected"]
    stopped = [result for result in results if result.stopped_tick is not None]
    if stopped:
        begun = sum(bool(result.stopped_tick) for result in stopped)
        ran = len(results) - len(stopped)
        lines.append(f"interrupted: {ran} ran to the end, {begun} until then, {len(stopped) - begun} not at all")
    for name, times in Counter(result.name for result in results if not result.error).items():
        if times > 1:
            files = ", ".join(result.path for result in results if result.name == name)
            lines.append(f"note: {times} scenarios are called {name!r}: {files}")
    return lines
