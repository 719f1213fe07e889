"""`wheelbench replay SOURCE`: a scenario, an RC capture or a recording through the bench, faster than real time."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from bench.cli.choices import add_choices


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument(
        "source", metavar="SOURCE", help="a scenario (.toml), an RC capture (raw bytes) or a recording (a directory)"
    )
    parser.add_argument("--robot", metavar="R", help="a name that `wheelbench robots` lists, or a .toml file")
    parser.add_argument("--arena", metavar="FILE", help="where it drives: an arena file (docs/plant.md)")
    parser.add_argument("--profile", metavar="P", help="the transmitter's profile: a name or a .toml file")
    parser.add_argument("--protocol", metavar="NAME", help="what an RC capture speaks, where nothing beside it says so")
    parser.add_argument("--period-ms", type=int, metavar="N", help="time between frames of a capture without times")
    parser.add_argument(
        "--can",
        metavar="FROM",
        default="sim:",
        help="sim: (default), recorded (a recording's own feedback instead of the plant's), or can:virtual:NAME",
    )
    parser.add_argument("--rc", metavar="PORT", default="sim:", help="sim: (default) or pty: (through a real pty pair)")
    parser.add_argument("--slamware", metavar="PORT", default="sim:", help="sim: (default) or pty:")
    add_choices(parser)
    parser.add_argument("--record", metavar="DIR", type=Path, help="write a recording")
    parser.add_argument("--overwrite", action="store_true", help="replace the recording that DIR holds")
    parser.add_argument("--golden", metavar="DIR", type=Path, help="compare with this recording or golden at the end")
    parser.add_argument("--json", action="store_true", help="the summary as one JSON object")


def run(args: argparse.Namespace) -> int:
    """Run the source to its end, print what happened, compare where there is something to compare with."""
    import tempfile

    from bench.check.compare import Comparison
    from bench.check.golden import verdict
    from bench.check.reading import Recording
    from bench.check.run import from_source
    from bench.cli.headless import execute
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError
    from bench.io.ports import WiredWorld

    if args.period_ms is not None and args.period_ms < 1:
        raise UsageError(f"--period-ms: expected 1 or more, got {args.period_ms}")
    job = from_source(
        args.source,
        robot=args.robot,
        protocol=args.protocol,
        profile=args.profile,
        period_ms=args.period_ms,
        recorded_can=args.can == "recorded",
        controller=args.controller,
        odometry=args.odometry,
        arena=args.arena,
    )
    # A recording is its own golden: run again from its inputs, it must come out the same.
    golden = args.golden or (job.source.directory if job.source else None)
    if golden is not None:
        Recording.open(golden)  # refuse a wrong directory before the run, not after it
    comparison: Comparison | None = None
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as scratch:
        directory = args.record or (Path(scratch) / "run" if golden else None)
        can = "sim:" if args.can == "recorded" else args.can
        with WiredWorld(job.bench.world, rc=args.rc, slamware=args.slamware, can=can) as world:
            job.bench.world = world
            recorder = job.recorder(directory, overwrite=args.overwrite) if directory else None
            summary, speed = execute(job, recorder, quiet=args.json)
        if golden is not None and directory is not None:
            comparison = verdict(Recording.open(directory), golden)
    verdicts = job.judge.verdicts() if job.judge else []
    untouched = job.injector.untouched() if job.injector else []
    if args.json:
        facts = summary.facts(job) | {"speed_factor": round(speed, 2)}
        if verdicts:
            facts["expectations"] = [one.as_dict() for one in verdicts]
        if job.injector:
            facts["faults"] = job.injector.counts()
        if comparison is not None:
            facts["golden"] = comparison.as_dict()
        print(json.dumps(facts))
    else:
        print("\n".join(summary.lines(job)))
        print(f"speed     {speed:.1f} times real time")
        if args.record:
            print(f"recorded  {args.record}")
        if comparison is not None:
            print("golden    " + "\n".join(comparison.lines))
        for one in verdicts:
            print(f"{'expect' if one.ok else 'EXPECT':10}{one.text}")
        for name in untouched:
            print(
                f"FAULT     {name}: touched nothing, so the run proves nothing about it; check its times and condition"
            )
    met = all(one.ok for one in verdicts) and not untouched
    return EXIT_OK if met and (comparison is None or comparison.ok) else EXIT_FAILED
