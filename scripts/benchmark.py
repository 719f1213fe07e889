"""How fast the bench is, against what stands beside it in the same run: `make bench`.

Every round runs every piece once, in shuffled order, and what is compared takes turns in small slices; a figure is the
median of the rounds. CPU time, unless it says wall. What has a bar is a ratio; absolute speeds are for orientation: the
load average and an empty Python call are printed because they move them all. Exit status 1 if a bar is missed.
"""

from __future__ import annotations

import os
import platform
import random
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from types import ModuleType

from arguments import at_least_one, end_with, parser
from benchmarks import (
    beside_peers,
    beside_simulators,
    command_line,
    compare,
    dashboard,
    decoders,
    demo,
    empty_call,
    lockstep,
    reference,
    robots,
)
from benchmarks.table import Row, Sample, table

PIECES: dict[str, ModuleType] = {
    "demo": demo,
    "reference": reference,
    "help": command_line,
    "robots": robots,
    "decoders": decoders,
    "dashboard": dashboard,
    "lockstep": lockstep,
    "compare": compare,
    "peers": beside_peers,
    "simulators": beside_simulators,
}
"""A file for each. `measure(order, share)` runs once a round, on a share of its full length; `report(samples)` turns
all rounds into lines; its first line says what it is."""

NEED_CANTOOLS = frozenset({"demo", "reference"})


def run(pieces: Sequence[str], rounds: int, share: float = 1.0) -> list[Row]:
    """Measure these pieces round by round; the lines of the table, in the order of `PIECES`."""
    samples: dict[str, list[Sample]] = {name: [] for name in PIECES if name in pieces}
    for number in range(rounds):
        order = random.Random(number)
        for name in order.sample(list(samples), len(samples)):
            samples[name].append(PIECES[name].measure(order, share))
    return [row for name in samples for row in PIECES[name].report(samples[name])]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print, judge."""
    names = "\n".join(f"  {name:<12}{(piece.__doc__ or '').splitlines()[0]}" for name, piece in PIECES.items())
    asked = parser(__doc__)
    asked.epilog = f"pieces:\n{names}"
    asked.add_argument(
        "--rounds", type=at_least_one, default=5, metavar="N", help="medians of how many rounds (default 5)"
    )
    asked.add_argument(
        "--only", action="append", choices=list(PIECES), metavar="NAME", help="a piece of those below; may be repeated"
    )
    args = asked.parse_args(arguments)
    pieces = args.only or list(PIECES)
    if not NEED_CANTOOLS.isdisjoint(pieces) and find_spec("cantools") is None:
        print(
            "scripts/benchmark.py needs cantools for the loop from libraries: pip install -e '.[dev]'", file=sys.stderr
        )
        return 3
    print(f"{_surroundings()}; medians of {args.rounds} interleaved rounds", flush=True)
    rows = run(pieces, args.rounds)
    print(table(rows))
    missed = [row for row in rows if row.verdict == "MISSED"]
    print(f"afterwards: {_surroundings()}" + (f"; {len(missed)} bar(s) MISSED" if missed else "; every bar met"))
    return 1 if missed else 0


def _surroundings() -> str:
    load = ", ".join(f"{value:.2f}" for value in os.getloadavg())
    return (
        f"{platform.python_implementation()} {platform.python_version()}, load average {load}, {os.cpu_count()} cores, "
        f"an empty Python call {empty_call.now_ns():.0f} ns"
    )


if __name__ == "__main__":
    end_with(main)
