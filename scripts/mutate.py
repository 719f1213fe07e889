"""Would the tests notice? One small change at a time in the codecs and the link machine: `make mutate`.

    scripts/mutate.py                          every mutant of every module
    scripts/mutate.py --only sbus,link         some modules
    scripts/mutate.py --sample 60 --seed 1     so many mutants a module, drawn with this seed
    scripts/mutate.py --list --only link       their names

A mutant is one operator, comparison, constant, order or statement changed in one place (mutation/mutants.py). It is
killed where a test of the module's list fails, hangs or takes too much memory (mutation/trial.py). What survives them
all needs a reason in mutation/reasons.toml: a mutant that behaves as the original does, or whose difference nobody may
rely on. Exit status 1 where one has none, or where a reason's mutant is gone or killed.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import time
import tomllib
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from arguments import above_zero, at_least_one, end_with, parser, some_of
from mutation.mutants import Mutant, mutants
from mutation.trial import HUNG, KILLED, SURVIVED, UNREACHED, UNTOLD, Broken, Module, Trial, load_tools

ROOT = Path(__file__).resolve().parent.parent
REASONS = Path(__file__).resolve().parent / "mutation" / "reasons.toml"
SAYS = {SURVIVED: "survives without a reason", UNREACHED: "no test runs it", UNTOLD: "its tests came to no end"}

RC = ("test_rc_vectors", "test_rc_corners", "test_rc_mutants", "test_rc_streams", "test_rc_dbus", "test_rc_decode")
MOTORS = ("test_m2006", "test_can_ends", "test_dm3519", "test_bus_watch")
FEEDBACK = ("test_m2006", "test_can_ends", "test_unwrap")
TABLES = ("test_m2006", "test_can_docs", "test_can_tables")
SLAMWARE = ("test_slamware_base", "test_slamware_core", "test_slamware_reference", "test_slamware_sub_commands")


class Target(NamedTuple):
    """A module and the files of tests that its mutants meet."""

    path: str
    tests: tuple[str, ...]


TARGETS = {
    "uart12": Target("bench/rc/uart12.py", RC),
    "sbus": Target("bench/rc/sbus.py", RC),
    "crsf": Target("bench/rc/crsf.py", RC),
    "ibus": Target("bench/rc/ibus.py", RC),
    "dbus": Target("bench/rc/dbus.py", RC),
    "framing": Target("bench/rc/framing.py", RC),
    "link": Target("bench/link.py", ("test_link", "test_link_mutants", "test_drive")),
    "m2006": Target("bench/m2006.py", (*MOTORS, "test_unwrap")),
    "unwrap": Target("bench/unwrap.py", FEEDBACK),
    "wiring": Target("bench/wiring.py", MOTORS),
    "dm3519": Target("bench/dm3519.py", MOTORS),
    "c610": Target("bench/canbus/c610.py", (*TABLES, "test_bus_watch")),
    "dm3519-can": Target("bench/canbus/dm3519.py", (*TABLES, "test_dm3519", "test_bus_watch")),
    "table": Target("bench/canbus/table.py", TABLES),
    "bits": Target("bench/canbus/bits.py", ("test_can_bits", "test_bus_budget")),
    "can_bus": Target("bench/timed/can_bus.py", ("test_can_bus",)),
    "slamware": Target("bench/slamware/framing.py", ("test_slamware_framing", *SLAMWARE)),
    "payloads": Target("bench/slamware/payloads.py", ("test_slamware_payloads", *SLAMWARE)),
}


def read_reasons(path: Path = REASONS) -> dict[str, dict[str, str]]:
    """Module -> mutant -> why it may survive."""
    data = tomllib.loads(path.read_text()) if path.exists() else {}
    return {
        module: {name: entry["why"] for entry in entries for name in entry["mutants"]}
        for module, entries in data.items()
    }


def report(name: str, given: argparse.Namespace, known: dict[str, str]) -> int:
    """Try a module's mutants and print what became of them; how many survivors and reasons have not each other."""
    target = TARGETS[name]
    tree, made = mutants((ROOT / target.path).read_text())
    chosen = [number for number, mutant in enumerate(made) if any(text in mutant.name for text in given.match)]
    if 0 < given.sample < len(chosen):
        chosen = sorted(random.Random(given.seed).sample(chosen, given.sample))
    begun, out = time.monotonic(), os.dup(1)

    def tell(mutant: Mutant, trial: Trial) -> None:
        if trial.verdict in SAYS and mutant.name not in known:
            os.write(out, f"    {name}, line {mutant.line}, {SAYS[trial.verdict]}: {mutant.name}\n".encode())

    try:
        trials = Module(ROOT, target.path, target.tests, tree, made, tell).try_all(chosen, given.jobs, given.under)
    except Broken as broken:
        print(f"{name}: its tests fail without any mutant, nothing can be told: {broken}", flush=True)
        return 1
    count = Counter(trial.verdict for trial in trials.values())
    left = [number for number in chosen if trials[number].verdict not in (KILLED, HUNG)]
    without = [number for number in left if made[number].name not in known]
    print(
        f"{name:<11}{len(made):>8}{len(chosen):>6}{count[KILLED]:>8}{count[HUNG]:>6}{len(left):>10}{len(without):>11}"
        f"{time.monotonic() - begun:>7.0f}",
        flush=True,
    )
    # A reason whose mutant is gone or killed says nothing any more.
    noticed = {made[number].name for number in chosen} - {made[number].name for number in left}
    gone = [one for one in known if one in noticed or one not in {mutant.name for mutant in made}]
    for one in gone:
        print(f"    reason without a survivor: {one}", flush=True)
    return len(without) + len(gone)


def main() -> int:
    """The command line; 0 where every survivor has its reason."""
    asked = parser(__doc__)
    asked.add_argument(
        "--only", type=some_of(TARGETS), default=list(TARGETS), metavar="A,B", help=f"some of {', '.join(TARGETS)}"
    )
    asked.add_argument(
        "--match", nargs="+", default=[""], metavar="TEXT", help="only mutants whose name holds one of these texts"
    )
    asked.add_argument(
        "--sample", type=at_least_one, default=0, metavar="N", help="so many mutants a module (default: all)"
    )
    asked.add_argument("--seed", type=int, default=1, metavar="N", help="of the sample (default 1)")
    asked.add_argument("--jobs", type=at_least_one, default=2, metavar="N", help="mutants at a time (default 2)")
    asked.add_argument(
        "--under", type=above_zero, default=math.inf, metavar="S", help="a first look: only tests that take less"
    )
    asked.add_argument("--list", action="store_true", help="name the mutants and run nothing")
    given = asked.parse_args()
    names = given.only
    if given.list:
        for name in names:
            print(*(f"{name}  {one.name}" for one in mutants((ROOT / TARGETS[name].path).read_text())[1]), sep="\n")
        return 0
    load_tools(ROOT)
    reasons = read_reasons()
    print(
        f"{'module':<11}{'mutants':>8}{'run':>6}{'killed':>8}{'hung':>6}{'survived':>10}{'no reason':>11}{'s':>7}",
        flush=True,
    )
    bad = [report(name, given, reasons.get(name, {})) for name in names]
    return 1 if any(bad) else 0


if __name__ == "__main__":
    end_with(main)
