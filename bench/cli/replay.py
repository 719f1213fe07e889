"""`wheelbench replay SOURCE`: a scenario, an RC capture or a recording through the bench, faster than real time.

Several scenarios run side by side, each with one line: `bench.cli.many`.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from bench.cli.choices import add_choices, add_role, add_tolerance, check_arm, check_jobs, check_protocol
from bench.cli.on_ports import run_on_ports
from bench.cli.output import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument(
        "source",
        metavar="SOURCE",
        nargs="+",
        help="a scenario (.toml), an RC capture (raw bytes) or a recording (a directory); or several scenarios",
    )
    parser.add_argument(
        "--robot", metavar="R", help="another than the scenario's; a capture's (m2006): a name or a .toml file"
    )
    parser.add_argument("--arena", metavar="FILE", help="where it drives: an arena file (docs/plant.md)")
    parser.add_argument("--profile", metavar="P", help="the transmitter's profile: a name or a .toml file")
    parser.add_argument("--protocol", metavar="NAME", help="what an RC capture speaks, where nothing beside it says so")
    parser.add_argument("--period-ms", type=int, metavar="N", help="time between frames of a capture without times")
    parser.add_argument(
        "--can",
        metavar="FROM",
        default="sim:",
        help="sim: (default), recorded (a recording's own feedback instead of the plant's), or the address of a bus",
    )
    parser.add_argument(
        "--rc", metavar="PORT", default="sim:", help="sim: (default), pty: or any address (docs/ports.md)"
    )
    parser.add_argument("--slamware", metavar="PORT", default="sim:", help="the same for the core's line")
    add_role(parser)
    add_choices(parser)
    parser.add_argument("--record", metavar="DIR", type=Path, help="write a recording; of several, one in DIR for each")
    parser.add_argument("--overwrite", action="store_true", help="replace the recording that DIR holds")
    parser.add_argument("--golden", metavar="DIR", type=Path, help="compare with this recording or golden at the end")
    add_tolerance(parser)
    parser.add_argument("--html", metavar="FILE", type=Path, help="scenarios: a page with verdicts and pictures")
    parser.add_argument("--junit", metavar="FILE", type=Path, help="scenarios: JUnit XML, for a CI server")
    parser.add_argument("--jobs", metavar="N", type=int, default=2, help="scenarios: so many at a time (2)")
    parser.add_argument("--json", action="store_true", help="the summary as one JSON object; of several, one a line")


def run(args: argparse.Namespace) -> int:
    """Run the source to its end, print what happened, compare where there is something to compare with."""
    import tempfile

    from bench.check.conduct import shortcomings
    from bench.check.firmware_log import death
    from bench.check.golden import Told, told
    from bench.check.reading import Recording
    from bench.check.sources import from_source
    from bench.check.tolerances import granted
    from bench.cli.headless import execute
    from bench.cli.many import sources_of, suite_of
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError
    from bench.io.ports import WiredWorld

    if args.period_ms is not None and args.period_ms < 1:
        raise UsageError(f"--period-ms: expected 1 or more, got {args.period_ms}")
    check_jobs(args.jobs)
    check_arm(args.role, args.arm)
    if args.protocol is not None:
        check_protocol(args.protocol)
    args.source = sources_of(args.source)
    if len(args.source) > 1 or args.html or args.junit:
        return suite_of(args)
    job = from_source(
        args.source[0],
        robot=args.robot,
        protocol=args.protocol,
        profile=args.profile,
        period_ms=args.period_ms,
        recorded_can=args.can == "recorded",
        controller=args.controller,
        odometry=args.odometry,
        arena=args.arena,
    )
    if args.tolerance and args.golden is None and job.source is None:
        raise UsageError("--tolerance: there is nothing that the run is held against; add --golden DIR")
    if args.role != "sim":
        return run_on_ports(args, job)
    # A recording is its own golden: run again from its inputs, it must come out the same.
    golden = args.golden or (job.source.directory if job.source else None)
    if golden is not None:
        granted(args.tolerance, Recording.open(golden))  # refuse what is wrong before the run, not after it
        if args.record is not None and args.record.resolve() == golden.resolve():
            raise UsageError(f"--record {args.record}: is what the run is held against; record in another directory")
    comparison: Told | None = None
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as scratch:
        directory = args.record or (Path(scratch) / "run" if golden else None)
        can = "sim:" if args.can == "recorded" else args.can
        with WiredWorld(job.bench.world, rc=args.rc, slamware=args.slamware, can=can) as world:
            job.bench.world = world
            recorder = job.recorder(directory, overwrite=args.overwrite) if directory else None
            summary, speed = execute(job, recorder, quiet=args.json)
        if golden is not None and directory is not None:
            comparison = told(Recording.open(directory), golden, args.tolerance)
    verdicts = job.judge.verdicts() if job.judge else []
    untouched = job.injector.untouched() if job.injector else []
    if args.json:
        facts = summary.facts(job) | {"speed_factor": round(speed, 2)}
        if verdicts:
            facts["expectations"] = [one.as_dict() for one in verdicts]
        if job.injector:
            facts["faults"] = job.injector.counts()
        if job.source is not None:
            facts["complete"] = job.source.complete
        if comparison is not None:
            facts["golden"] = comparison.as_dict()
        print(json.dumps(facts))
    else:
        if job.source is not None and not job.source.complete:
            cut_s = job.source.ticks / 1000
            say(f"cut       the recording was cut short at {cut_s:.3f} s; what follows is about that much")
        if job.source is not None and (died := death(job.source.directory)) is not None:
            say(*died.lines())
        say(*summary.lines(job), f"speed     {speed:.1f} times real time")
        if args.record:
            say(f"recorded  {args.record}")
        if comparison is not None:
            first, *more = comparison.lines
            say(f"golden    {first}", *more)
        for one in verdicts:
            say(f"{'expect' if one.ok else 'EXPECT':10}{one.text}")
        for name in untouched:
            say(f"FAULT     {name}: touched nothing, so the run proves nothing about it; check its times and condition")
    met = not shortcomings(job)
    return EXIT_OK if met and (comparison is None or comparison.ok) else EXIT_FAILED
