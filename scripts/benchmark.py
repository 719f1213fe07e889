"""How fast the bench is, against what stands beside it in the same run: `make bench`.

    demo        the demo, headless, every frame encoded, decoded and recorded: simulated seconds a second
    reference   its RC part against the same loop built from python-can and cantools (scripts/reference_loop.py)
    help        `wheelbench --help` against `python -c pass`
    robots      each robot that drives all the time: its whole tick, recorded, and its plant's step, against real time
                and against a bare pymunk step of the same body
    simulators  the bench beside MuJoCo and ir-sim, in a throw-away environment (scripts/simulators.py)
    decoders    an RC frame through its decoder
    lockstep    foreign firmware in C: the link, a whole run, a reset (benchmarks/lockstep.py)
    compare     two logs of a million frames compared, causes and all, against python-can's reader and a plain loop
    dashboard   its share of a core, its drawing beside stock widgets, its start (benchmarks/dashboard.py)
    peers       the decoders beside other Python packages, in a throw-away environment (scripts/peers.py)

Every round runs every piece once, in shuffled order, and what is compared takes turns in small slices; a figure is the
median of the rounds. CPU time, unless it says wall. What has a bar is a ratio; microseconds are for orientation, and
the load average is printed because it moves them all. Exit status 1 if a bar is missed.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import islice
from pathlib import Path
from statistics import median
from typing import NamedTuple

import pymunk
from benchmarks import dashboard, lockstep
from benchmarks.table import Row, Sample, table, verdict

from bench import rc_decode
from bench.check.recording import BLOCK_TICKS, Recorder, RunInfo
from bench.check.run import Run, from_scenario
from bench.cli.headless import execute
from bench.config import Robot, robot_names
from bench.demo import SCENARIO
from bench.loop import simulated
from bench.messages import BodyTwist, TickInput, TickOutput
from bench.plant import FIELD, STEP_S, Plant
from bench.rc.transmitter import Sticks, Transmitter

DEMO_FACTORS_AT_LEAST = {"m2006": 30.0, "dm3519": 22.0}
"""Three wheels, four wheels."""
REFERENCE_FACTOR_AT_LEAST = 4.0
HELP_FACTOR_AT_MOST, HELP_EXTRA_S = 3.0, 0.030
COMPARE_FACTOR_AT_LEAST, COMPARE_PEAK_MB_AT_MOST = 10.0, 500.0
HEAVY = ("can", "cantools", "numpy", "pymunk", "serial", "textual")

RC_PART_TICKS = 13_000
"""How long the demo is driven by sticks alone: the reference loop has no SLAMWARE core to hand over to."""
SLICE_TICKS = 200
ROBOT_TICKS, ROBOT_SLICE = 1500, BLOCK_TICKS
ARMING_TICKS = 300
SIMULATED_S = 0.2
DECODER_FRAMES = 1000
PEER_FRAMES = 10_000
COMPARE_FRAMES = 1_000_000
HELP_RUNS = 5


class Piece(NamedTuple):
    """`measure` runs once a round, on a share of its full length; `report` turns all rounds into lines."""

    measure: Callable[[random.Random, float], Sample]
    report: Callable[[Sequence[Sample]], list[Row]]


# --- the pieces --------------------------------------------------------------------------------------------------


def measure_demo(order: random.Random, share: float = 1.0) -> Sample:
    """The demo as `wheelbench demo --headless --record DIR` runs it, and the same sticks on four wheels."""
    sample = {}
    for robot in order.sample(sorted(DEMO_FACTORS_AT_LEAST), len(DEMO_FACTORS_AT_LEAST)):
        job = from_scenario(SCENARIO, robot=robot)
        job.ticks = round(job.ticks * share)
        with tempfile.TemporaryDirectory(prefix="wheelbench-") as directory:
            recorder = job.recorder(Path(directory) / "run")
            wall = time.perf_counter()
            cpu_s = _cpu_s(partial(execute, job, recorder, quiet=True))
            wall_s = time.perf_counter() - wall
        simulated_s = job.ticks / 1000.0
        sample |= {f"{robot} CPU": simulated_s / cpu_s, f"{robot} wall": simulated_s / wall_s}
    return sample


def report_demo(samples: Sequence[Sample]) -> list[Row]:
    """How many times faster than real time."""
    return [
        _row_at_least(
            f"demo on {robot}, recorded: simulated s per {kind} s", [s[f"{robot} {kind}"] for s in samples], bar
        )
        for robot, bar in DEMO_FACTORS_AT_LEAST.items()
        for kind in ("CPU", "wall")
    ]


def measure_reference(order: random.Random, share: float = 1.0) -> Sample:
    """CPU s a simulated s of the RC part of the demo, recorded: by the bench, and by the loop built from libraries."""
    from reference_loop import LibraryLoop

    slices = max(1, round(RC_PART_TICKS * share) // SLICE_TICKS)
    job = from_scenario(SCENARIO)
    job.ticks = slices * SLICE_TICKS
    rc = [job.inputs(tick).rc for tick in range(job.ticks)]
    blocks = job.blocks()
    with (
        tempfile.TemporaryDirectory(prefix="wheelbench-") as directory,
        job.recorder(Path(directory) / "run") as recorder,
        LibraryLoop(job.bench.robot, Path(directory) / "can.log") as libraries,
    ):

        def bench_slice() -> None:
            for block in islice(blocks, SLICE_TICKS // BLOCK_TICKS):
                recorder.extend(block)

        def libraries_slice() -> None:
            for rc_bytes in rc[libraries.now_tick : libraries.now_tick + SLICE_TICKS]:
                libraries.tick(rc_bytes)

        seconds = _side_by_side(order, slices, {"bench": bench_slice, "libraries": libraries_slice})
        return {name: value / (job.ticks / 1000.0) for name, value in seconds.items()}


def report_reference(samples: Sequence[Sample]) -> list[Row]:
    """How many times the bench is as fast as the reference."""
    return [
        _row_at_least(
            "times as fast as the same loop from libraries",
            [s["libraries"] / s["bench"] for s in samples],
            REFERENCE_FACTOR_AT_LEAST,
        ),
        Row(
            "  simulated s per CPU s, turn by turn: bench, libraries",
            ", ".join(f"{1.0 / median(s[name] for s in samples):.1f}" for name in ("bench", "libraries")),
        ),
    ]


def measure_help(order: random.Random, share: float = 1.0) -> Sample:
    """Wall seconds of fresh processes, and how many heavy packages the command line loads before it needs them."""
    installed = shutil.which("wheelbench", path=str(Path(sys.executable).parent))
    wheelbench = [installed] if installed else [sys.executable, "-m", "bench"]
    commands = {"help": [*wheelbench, "--help"], "bare": [sys.executable, "-c", "pass"]}
    walls: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(max(1, round(HELP_RUNS * share))):
        for name in order.sample(sorted(commands), len(commands)):
            start = time.perf_counter()
            subprocess.run(commands[name], check=True, stdout=subprocess.DEVNULL)
            walls[name].append(time.perf_counter() - start)
    return {name: median(times) for name, times in walls.items()} | {"heavy": len(heavy_imports())}


def report_help(samples: Sequence[Sample]) -> list[Row]:
    """Whether `--help` stays near the interpreter's own start."""
    bare, shown = median(s["bare"] for s in samples), median(s["help"] for s in samples)
    allowed = HELP_FACTOR_AT_MOST * bare + HELP_EXTRA_S
    heavy = max(s["heavy"] for s in samples)
    return [
        Row(
            "`wheelbench --help`, wall, against `python -c pass`",
            f"{shown / bare:.1f} x ({shown * 1000:.0f} ms)",
            f"at most {HELP_FACTOR_AT_MOST:g} x + {HELP_EXTRA_S * 1000:g} ms",
            verdict(shown <= allowed),
        ),
        Row("  heavy packages that bench.__main__ imports", f"{heavy:.0f}", "none", verdict(heavy == 0)),
    ]


def measure_robots(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds for each robot: a whole tick, recorded; a step of its plant; the engine alone with the same body."""
    names = robot_names()
    slices = max(1, round(ROBOT_TICKS * share) // ROBOT_SLICE)
    sample: Sample = {}
    for name in order.sample(names, len(names)):
        job = driving(name, ARMING_TICKS + slices * ROBOT_SLICE)
        robot = job.bench.robot
        plant, space = Plant(robot), _bare_space(robot)
        currents_a = [robot.limits.current_a / 2.0] * len(robot.wheels)
        with (
            tempfile.TemporaryDirectory(prefix="wheelbench-") as folder,
            job.recorder(Path(folder) / "run") as recorder,
        ):
            blocks = job.blocks()
            for block in islice(blocks, ARMING_TICKS // ROBOT_SLICE):
                recorder.extend(block)

            def tick(blocks: Iterator[list[TickOutput]] = blocks, recorder: Recorder = recorder) -> None:
                recorder.extend(next(blocks))

            def step(plant: Plant = plant, currents_a: Sequence[float] = tuple(currents_a)) -> None:
                for _ in range(ROBOT_SLICE):
                    plant.step(currents_a)

            def bare(space: pymunk.Space = space) -> None:
                for _ in range(ROBOT_SLICE):
                    space.step(STEP_S)

            seconds = _side_by_side(order, slices, {"tick": tick, "plant": step, "pymunk": bare})
        sample |= {f"{name} {what}": value / (slices * ROBOT_SLICE) for what, value in seconds.items()}
    return sample


def report_robots(samples: Sequence[Sample]) -> list[Row]:
    """For orientation."""
    rows = []
    for name in robot_names():
        for what, title in (("tick", "a whole tick, recorded"), ("plant", "a step of the plant")):
            us = 1e6 * median(s[f"{name} {what}"] for s in samples)
            ratio = median(s[f"{name} {what}"] / s[f"{name} pymunk"] for s in samples)
            value = f"{us:.1f} µs: {1000.0 / us:.0f} x real time, {ratio:.1f} bare pymunk steps"
            rows.append(Row(f"{name}, {title}", value))
    return rows


def driving(name: str, ticks: int) -> Run:
    """A run in which this robot is driven about all the time, by its own kind of transmitter, or by the core alone."""
    bench = simulated(name)
    profile, limits = bench.robot.rc, bench.robot.limits
    transmitter = Transmitter(profile) if profile else None

    def inputs(tick: int) -> TickInput:
        forward, left = 0.6 * math.cos(tick / 300.0), 0.6 * math.sin(tick / 300.0)
        if transmitter is None:
            asked = BodyTwist(forward * limits.linear_mps, left * limits.linear_mps, 0.4 * limits.angular_radps)
            return TickInput(core_twist=asked)
        sticks = Sticks(forward, left, 0.4) if tick >= ARMING_TICKS else Sticks(aux1=100 <= tick < 200)
        return TickInput(transmitter.step(tick, sticks))

    return Run(name, bench, ticks, inputs, RunInfo(robot=name, profile=profile.name if profile else None))


def measure_simulators(_order: random.Random, share: float = 1.0) -> Sample:
    """Simulated seconds a CPU second, in one process; nothing where the others cannot be installed."""
    import simulators

    _, python = _environment(simulators.PACKAGES)
    if python is None:
        return {}
    factors = simulators.measured(python, SIMULATED_S * share, 1)
    return {name: values[0] for name, values in factors.items()}


def report_simulators(samples: Sequence[Sample]) -> list[Row]:
    """For orientation: they simulate other things (scripts/simulators.py says what)."""
    import simulators

    if not all(samples):
        return [Row("the bench beside other simulators", "skipped: they cannot be installed here")]
    factors = {name: [sample[name] for sample in samples] for name in samples[0]}
    ratios = simulators.ratios(factors)
    return [
        Row(
            f"simulated s per CPU s, {name}",
            f"{median(values):.2f}" + (f": the bench is {ratios[name]:.2f} x as fast" if name in ratios else ""),
        )
        for name, values in factors.items()
    ]


def measure_decoders(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds a frame, fed frame by frame with times, as a port does it."""
    frames = max(2, round(DECODER_FRAMES * share))
    protocols = sorted(_CHANNELS)
    order.shuffle(protocols)
    return {protocol: _decode_s(protocol, frames) for protocol in protocols}


def report_decoders(samples: Sequence[Sample]) -> list[Row]:
    """For orientation."""
    return [
        Row(f"decoder, {protocol}", f"{1e6 * median(s[protocol] for s in samples):.2f} µs a frame")
        for protocol in _CHANNELS
    ]


def measure_compare(order: random.Random, share: float = 1.0) -> Sample:
    """CPU seconds of whole processes that compare two logs, one that differs in 40 fields and one that comes late."""
    frames = max(1000, round(COMPARE_FRAMES * share))
    jobs = {"few": "wheelbench", "late": "wheelbench", "python-can": "python-can"}
    folder = _large_logs(frames)
    sample: Sample = {}
    for name in order.sample(sorted(jobs), len(jobs)):
        run = "few" if name == "python-can" else name
        facts = _compare_logs(jobs[name], f"{folder.name}/{run}", f"{folder.name}/golden")
        sample |= {name: facts["cpu_s"], f"{name} MB": facts["peak_mb"]}
    return sample


def report_compare(samples: Sequence[Sample]) -> list[Row]:
    """How many times as fast as python-can's reader, and in how much memory."""
    named = {"few": "40 fields differ", "late": "feedback 3 ms late"}
    rows = []
    for name, what in named.items():
        ratios = [s["python-can"] / s[name] for s in samples]
        figure = f"comparing two logs, {what}: times as fast as python-can's reader"
        rows.append(_row_at_least(figure, ratios, COMPARE_FACTOR_AT_LEAST))
    peak_mb = max(s[f"{name} MB"] for s in samples for name in named)
    fits = verdict(peak_mb <= COMPARE_PEAK_MB_AT_MOST)
    rows.append(Row("  peak memory", f"{peak_mb:.0f} MB", f"at most {COMPARE_PEAK_MB_AT_MOST:g} MB", fits))
    times = ", ".join(f"{median(s[name] for s in samples):.2f}" for name in (*named, "python-can"))
    rows.append(Row("  CPU s: few, late, python-can (whole processes)", times))
    return rows


@cache
def _large_logs(frames: int) -> tempfile.TemporaryDirectory[str]:
    """The recordings for all rounds; they go when this process ends."""
    folder = tempfile.TemporaryDirectory(prefix="wheelbench-logs-")
    _compare_logs("make", folder.name, str(frames))
    return folder


def _compare_logs(*arguments: str) -> dict[str, float]:
    script = Path(__file__).with_name("compare_logs.py")
    done = subprocess.run([sys.executable, script, *arguments], check=True, capture_output=True, text=True)
    facts: dict[str, float] = json.loads(done.stdout)
    return facts


def measure_peers(_order: random.Random, share: float = 1.0) -> Sample:
    """Microseconds a frame by "protocol reader"; nothing where the peers cannot be installed."""
    import peers

    _, python = _environment(peers.PACKAGES)
    if python is None:
        return {}
    rows = peers.measured(python, max(2, round(PEER_FRAMES * share)), 1)
    return {f"{row['protocol']} {row['reader']}": row["us_per_frame"] for row in rows}


def report_peers(samples: Sequence[Sample]) -> list[Row]:
    """How many times as fast as the fastest package of each protocol."""
    import peers

    if not all(samples):
        return [Row("decoders beside other packages", "skipped: they cannot be installed here")]
    rows = []
    for name in samples[0]:
        times_us = [sample[name] for sample in samples]
        protocol, _, reader = name.partition(" ")
        rows.append({"protocol": protocol, "reader": reader, "us_per_frame": median(times_us), "times_us": times_us})
    return [
        Row(
            f"times as fast as the fastest package, {result['protocol']} ({result['fastest_peer']})",
            f"{result['ratio']:.1f}",
            f"at least {peers.BAR:g}",
            verdict(result["holds"]),
        )
        for result in peers.verdicts(rows)
    ]


@cache
def _environment(packages: tuple[str, ...]) -> tuple[tempfile.TemporaryDirectory[str], Path | None]:
    """One environment for all rounds; it goes when this process ends."""
    import peers

    folder = tempfile.TemporaryDirectory(prefix="wheelbench-peers-")
    return folder, peers.environment(folder.name, packages)


PIECES = {
    "demo": Piece(measure_demo, report_demo),
    "reference": Piece(measure_reference, report_reference),
    "help": Piece(measure_help, report_help),
    "robots": Piece(measure_robots, report_robots),
    "decoders": Piece(measure_decoders, report_decoders),
    "dashboard": Piece(dashboard.measure, dashboard.report),
    "lockstep": Piece(lockstep.measure, lockstep.report),
    "compare": Piece(measure_compare, report_compare),
    "peers": Piece(measure_peers, report_peers),
    "simulators": Piece(measure_simulators, report_simulators),
}


# --- what they run -----------------------------------------------------------------------------------------------


def heavy_imports() -> list[str]:
    """Which heavy packages a fresh interpreter has loaded once it knows the command line."""
    code = f"import sys, bench.__main__; print(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return done.stdout.split()


def _bare_space(robot: Robot) -> pymunk.Space:
    body = robot.body
    space = pymunk.Space()
    disc = pymunk.Body(body.mass_kg, body.inertia_kgm2)
    disc.angular_velocity = 5.0
    space.add(disc, pymunk.Circle(disc, body.radius_m))
    x, y = FIELD.length_m / 2.0, FIELD.width_m / 2.0
    corners = ((-x, -y), (x, -y), (x, y), (-x, y))
    for start, end in zip(corners, (*corners[1:], corners[0]), strict=True):
        space.add(pymunk.Segment(space.static_body, start, end, 0.05))
    return space


def _sticks(i: int, span: int) -> list[int]:
    """Four channels that move all the time, 0 to span - 1."""
    return [round((span - 1) * (0.5 + 0.5 * math.sin(0.1 * i + phase))) for phase in range(4)]


_CHANNELS: dict[str, Callable[[int], list[int]]] = {
    "uart12": lambda i: [*_sticks(i, 4096), 0, 1],
    "sbus": lambda i: [*_sticks(i, 2048), *[992] * 12],
    "crsf": lambda i: [*_sticks(i, 2048), *[992] * 12],
}


def _decode_s(protocol: str, frames: int) -> float:
    pieces = [rc_decode.encode(protocol, _CHANNELS[protocol](i)) for i in range(frames)]
    decoder = rc_decode.decoder(protocol, pause_us=2000)

    def feed() -> None:
        for i, piece in enumerate(pieces):
            decoder.feed(piece, i * 7000)
        decoder.finish()

    seconds = _cpu_s(feed) / frames
    assert decoder.counters.frames == frames
    return seconds


# --- the table ---------------------------------------------------------------------------------------------------


def _cpu_s(job: Callable[[], object]) -> float:
    start = time.process_time()
    job()
    return time.process_time() - start


def _side_by_side(order: random.Random, slices: int, contestants: Mapping[str, Callable[[], object]]) -> Sample:
    """CPU seconds of each. They take turns slice by slice: whatever else the machine does falls on all of them."""
    seconds = dict.fromkeys(contestants, 0.0)
    for _ in range(slices):
        for name in order.sample(sorted(contestants), len(contestants)):
            seconds[name] += _cpu_s(contestants[name])
    return seconds


def _row_at_least(figure: str, values: Sequence[float], bar: float) -> Row:
    value = median(values)
    return Row(figure, f"{value:.1f}", f"at least {bar:g}", verdict(value >= bar))


def run(pieces: Sequence[str], rounds: int, share: float = 1.0) -> list[Row]:
    """Measure these pieces round by round; the lines of the table, in the order of `PIECES`."""
    samples: dict[str, list[Sample]] = {name: [] for name in PIECES if name in pieces}
    for number in range(rounds):
        order = random.Random(number)
        for name in order.sample(list(samples), len(samples)):
            samples[name].append(PIECES[name].measure(order, share))
    return [row for name in samples for row in PIECES[name].report(samples[name])]


def _surroundings() -> str:
    load = ", ".join(f"{value:.2f}" for value in os.getloadavg())
    return (
        f"{platform.python_implementation()} {platform.python_version()}, load average {load}, {os.cpu_count()} cores"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="medians of how many rounds (default 5)")
    parser.add_argument(
        "--only", action="append", choices=list(PIECES), metavar="NAME", help="a piece; may be repeated"
    )
    args = parser.parse_args(arguments)
    if args.rounds < 1:
        parser.error(f"--rounds: expected 1 or more, got {args.rounds}")
    print(f"{_surroundings()}; medians of {args.rounds} interleaved rounds", flush=True)
    rows = run(args.only or list(PIECES), args.rounds)
    print(table(rows))
    missed = [row for row in rows if row.verdict == "MISSED"]
    print(f"afterwards: {_surroundings()}" + (f"; {len(missed)} bar(s) MISSED" if missed else "; every bar met"))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
