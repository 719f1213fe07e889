"""Coverage-guided attack on every decoder: `make fuzz`, ten minutes for each, two at a time.

    scripts/fuzz.py --seconds 600 --jobs 2      every target; exit status 1 if anything was found
    scripts/fuzz.py --only sbus,crsf            some of them
    scripts/fuzz.py --replay FILE               one finding again: its name begins with the target's

What is found is put into --findings (fixtures/known/fuzz) as target-hash.bin; the tests replay that folder. Inputs that
reached new code are kept in --corpus, so that a later run begins where this one ended. Needs atheris, which `make fuzz`
installs into a place of its own; without it the exit status is 3.
"""

from __future__ import annotations

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

from arguments import at_least_one, end_with, existing, parser, some_of

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
        from attacks.targets import TARGETS
    check = TARGETS[name]
    atheris.Setup([sys.argv[0], *options], check)
    atheris.Fuzz()


def run(name: str, seconds: int, corpus: Path, findings: Path) -> Outcome:
    """Fuzz one target in a process of its own."""
    from attacks.inputs import seeds

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
    from attacks.targets import TARGETS

    TARGETS[path.name.partition("-")[0]](path.read_bytes())


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
    asked = parser(__doc__)
    asked.add_argument("--seconds", type=at_least_one, default=600, metavar="S", help="for each target (default 600)")
    asked.add_argument("--jobs", type=at_least_one, default=2, metavar="N", help="targets at a time (default 2)")
    asked.add_argument(
        "--only", type=some_of(ORDER), default=list(ORDER), metavar="A,B", help=f"some of {', '.join(ORDER)}"
    )
    asked.add_argument("--corpus", type=Path, metavar="DIR", help="keep what reached new code here")
    asked.add_argument("--findings", type=Path, metavar="DIR", default=ROOT / "fixtures" / "known" / "fuzz")
    asked.add_argument("--replay", type=existing, metavar="FILE", help="one finding again")
    given = asked.parse_args()
    if given.replay is not None:
        if given.replay.name.partition("-")[0] not in ORDER:
            asked.error(f"--replay: the name of a finding begins with its target, as sbus-..., not {given.replay.name}")
        replay(given.replay)
        return 0
    try:
        import atheris  # noqa: F401
    except ImportError:
        print("scripts/fuzz.py needs atheris; `make fuzz` installs it into .venv-attack", file=sys.stderr)
        return 3
    os.nice(10)
    bad = 0
    print(f"{'target':<10}{'seconds':>9}{'executions':>12}{'edges':>8}{'features':>10}  findings", flush=True)
    with corpus_folder(given.corpus) as corpus, ThreadPoolExecutor(given.jobs) as pool:
        for one in pool.map(lambda name: run(name, given.seconds, corpus, given.findings), given.only):
            found = ", ".join(one.found) or ("none" if one.status == 0 else f"exit status {one.status}")
            bad += one.status != 0
            print(
                f"{one.name:<10}{one.seconds:>9.0f}{one.executions:>12}{one.covered:>8}{one.features:>10}  {found}",
                flush=True,
            )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    end_with(main)
