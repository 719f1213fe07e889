"""Coverage-guided attack on every decoder: `make fuzz`, ten minutes for each, two at a time.

    scripts/fuzz.py --seconds 600 --jobs 2      every target; exit status 1 if anything was found
    scripts/fuzz.py --only sbus,crsf            some of them
    scripts/fuzz.py --replay FILE               one finding again: its name begins with the target's

What is found is put into --findings (fixtures/known/fuzz) as target-hash.bin; the tests replay that folder. Inputs that
reached new code are kept in --corpus, so that a later run begins where this one ended. Needs atheris, which `make fuzz`
installs into a place of its own; without it the exit status is 3.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
MAX_INPUT_BYTES = 160
ORDER = ("sbus", "crsf", "uart12", "slamware", "ibus", "dbus", "base", "can", "link", "core", "firmware", "lines")
ATTACKED = [
    "bench.rc",
    "bench.slamware",
    "bench.canbus",
    "bench.m2006",
    "bench.dm3519",
    "bench.link",
    "bench.check.lines",
]
_FOUND = re.compile(r"Test unit written to (\S+)")
_EXECUTED = re.compile(r"stat::number_of_executed_units: (\d+)")
_COVERED = re.compile(r"cov: (\d+) ft: (\d+)")


class Outcome(NamedTuple):
    """What became of one target."""

    name: str
    seconds: float
    executions: int
    covered: int
    features: int
    found: list[str]
    status: int


def attack(name: str, options: Sequence[str]) -> None:
    """Fuzz one target in this process; does not return."""
    import atheris

    with atheris.instrument_imports(include=ATTACKED):
        import attack_targets
    check = attack_targets.TARGETS[name]
    atheris.Setup([sys.argv[0], *options], check)
    atheris.Fuzz()


def run(name: str, seconds: int, corpus: Path, findings: Path) -> Outcome:
    """Fuzz one target in a process of its own."""
    from attack_inputs import seeds

    folder = corpus / name
    folder.mkdir(parents=True, exist_ok=True)
    findings.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(seeds(name)):
        (folder / f"seed-{number:02d}").write_bytes(seed)
    command = [sys.executable, __file__, "--child", name, "--"]
    command += [f"-max_total_time={seconds}", f"-max_len={MAX_INPUT_BYTES}", "-print_final_stats=1", "-timeout=60"]
    command += ["-rss_limit_mb=1024", "-report_slow_units=60", f"-artifact_prefix={findings}/{name}-", str(folder)]
    begun = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", cwd=ROOT)
    took = time.monotonic() - begun
    (corpus / f"{name}.log").write_text(done.stdout + done.stderr)
    executed = _EXECUTED.findall(done.stderr)
    covered = _COVERED.findall(done.stderr)
    return Outcome(
        name,
        took,
        int(executed[-1]) if executed else 0,
        int(covered[-1][0]) if covered else 0,
        int(covered[-1][1]) if covered else 0,
        _FOUND.findall(done.stderr),
        done.returncode,
    )


def replay(path: Path) -> None:
    """One finding again, without atheris."""
    import attack_targets

    attack_targets.TARGETS[path.name.partition("-")[0]](path.read_bytes())


@contextmanager
def corpus_folder(given: Path | None) -> Iterator[Path]:
    """The corpus that was asked for, or one that goes away."""
    if given is not None:
        yield given
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def main() -> int:
    """The command line; the exit status is 1 where something was found and 3 where atheris is missing."""
    if "--child" in sys.argv:
        at = sys.argv.index("--child")
        attack(sys.argv[at + 1], sys.argv[at + 3 :])
    parser = argparse.ArgumentParser(description="Coverage-guided attack on every decoder.")
    parser.add_argument("--seconds", type=int, default=600, help="for each target")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time")
    parser.add_argument("--only", default="", help=f"some of {', '.join(ORDER)}")
    parser.add_argument("--corpus", type=Path, help="keep what reached new code here")
    parser.add_argument("--findings", type=Path, default=ROOT / "fixtures" / "known" / "fuzz")
    parser.add_argument("--replay", type=Path, help="one finding again")
    given = parser.parse_args()
    if given.replay is not None:
        replay(given.replay)
        return 0
    names = [name for name in given.only.split(",") if name] or list(ORDER)
    unknown = sorted(set(names) - set(ORDER))
    if unknown:
        parser.error(f"no target is called {', '.join(unknown)}; known: {', '.join(ORDER)}")
    try:
        import atheris  # noqa: F401
    except ImportError:
        print("scripts/fuzz.py needs atheris; `make fuzz` installs it into .venv-attack", file=sys.stderr)
        return 3
    os.nice(10)
    bad = 0
    print(f"{'target':<10}{'seconds':>9}{'executions':>12}{'edges':>8}{'features':>10}  findings", flush=True)
    with corpus_folder(given.corpus) as corpus, ThreadPoolExecutor(given.jobs) as pool:
        for one in pool.map(lambda name: run(name, given.seconds, corpus, given.findings), names):
            found = ", ".join(one.found) or ("none" if one.status == 0 else f"exit status {one.status}")
            bad += one.status != 0
            print(
                f"{one.name:<10}{one.seconds:>9.0f}{one.executions:>12}{one.covered:>8}{one.features:>10}  {found}",
                flush=True,
            )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main())
