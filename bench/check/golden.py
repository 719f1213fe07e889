"""Goldens: recordings that somebody has looked at and pinned, so that later runs are held against them.

A golden is a recording with a golden.toml beside it: where it was made, and the SHA-256 of each file. Only `pin`
writes one, and never in CI: a golden that rewrites itself proves nothing.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from bench import __version__
from bench.check.compare import Comparison, compare
from bench.check.fields import TOLERANCES
from bench.check.reading import Recording, as_outputs
from bench.check.recording import (
    FILES,
    GOLDEN_TOML,
    SCHEMA,
    RecordingError,
    make_directory,
    read_bytes,
    remove_recording,
    toml_lines,
    write_file,
)
from bench.check.tolerances import granted

if TYPE_CHECKING:
    from bench.check.report import Report

Told: TypeAlias = "Comparison | Report"
"""What was found; a report where there is something to explain."""


def pin(run_dir: Path | str, golden_dir: Path | str) -> Told | None:
    """Make a run the golden; what it replaces is gone. Returns how it differs from the golden that it replaced, if any,
    and why.

    Raises RecordingError in CI (the environment variable CI is set), for a run that was cut short, and for a directory
    that holds anything but a golden or the run itself.
    """
    if os.environ.get("CI"):
        raise RecordingError(f"{golden_dir}: a golden is not pinned in CI (the variable CI is set); pin it at a desk")
    golden_dir = Path(golden_dir)
    run = Recording.open(run_dir)
    if not run.complete:
        raise RecordingError(f"{run_dir}: the run was cut short; pin one that came to its end")
    for _ in as_outputs(run):  # what cannot be read is refused here, not at the first check
        pass
    files = {name: read_bytes(run.directory / name) for name in FILES if (run.directory / name).exists()}
    held = make_directory(golden_dir)
    foreign = [name for name in held if name not in (*FILES, GOLDEN_TOML)]
    if foreign or (held and GOLDEN_TOML not in held and not golden_dir.samefile(run_dir)):
        what = f"other files ({', '.join(foreign[:3])})" if foreign else "a recording that is no golden"
        raise RecordingError(f"{golden_dir}: holds {what}; give a directory of its own")
    replaced = _against_old(run, golden_dir) if GOLDEN_TOML in held else None
    remove_recording(golden_dir)
    for name, content in files.items():
        write_file(golden_dir / name, content)
    facts = toml_lines({"schema": SCHEMA, "wheelbench": __version__, **_here()})
    hashes = "".join(f'"{name}" = "{_sha256(run.content(name))}"\n' for name in files)
    write_file(golden_dir / GOLDEN_TOML, f"{facts}\n[sha256]\n{hashes}".encode())
    return replaced


def verdict(run: Recording, golden: Recording | Path | str, tolerance: Sequence[str] = ()) -> Comparison:
    """Hold a run that was made here against a golden.

    Exactly, where the golden was made on a platform like this one with the same physics engine; elsewhere with
    tolerances and a note. A recording without a golden.toml is compared exactly. `tolerance` is what the user grants
    besides ("speed=5rpm"). Raises RecordingError where the golden is not what was pinned, or is another robot's.
    """
    if not isinstance(golden, Recording):
        golden = Recording.open(golden)
    tolerances, note = how_exactly(golden)
    if run.info.robot != golden.info.robot:
        raise RecordingError(
            f"{golden.directory}: is of the robot {golden.info.robot}, and the run {run.directory} is of "
            f"{run.info.robot}; give a golden of the same robot"
        )
    notes = [note] if note else []
    if tolerance:
        tolerances = {**(tolerances or {}), **granted(tolerance, golden)}
        notes.append(f"compared with --tolerance {', '.join(tolerance)}")
    found = compare(run, golden, tolerances)
    return replace(found, notes=(*notes, *found.notes)) if notes else found


def told(run: Recording, golden_dir: Path | str, tolerance: Sequence[str] = ()) -> Told:
    """`verdict`, and where something differs also why: `bench.check.report`."""
    golden = Recording.open(golden_dir)
    return _explained(run, golden, verdict(run, golden, tolerance))


def how_exactly(golden: Recording) -> tuple[Mapping[str, float] | None, str]:
    """What a run that was made here may be off this golden: nothing (None), or tolerances and the note that says why.

    Raises RecordingError where the golden is not what was pinned.
    """
    path = golden.directory / GOLDEN_TOML
    if not path.exists():
        return None, ""
    facts = _read_golden_toml(path)
    for name in FILES:
        there = _sha256(golden.content(name)) if (golden.directory / name).exists() else None
        if there != facts["sha256"].get(name):
            raise RecordingError(f"{golden.directory / name}: is not what was pinned; restore it or pin again")
    here = _here()
    elsewhere = [f"{key} {facts.get(key)}" for key, value in here.items() if facts.get(key) != value]
    if not elsewhere:
        return None, ""
    this = ", ".join(f"{key} {value}" for key, value in here.items())
    return TOLERANCES, f"the golden is from {', '.join(elsewhere)}, this is {this}: compared with tolerances"


def _here() -> dict[str, str | int | None]:
    """What may change the last bit of a float: processor, operating system, C library, physics engine."""
    # Imported here: it costs as much as the bench itself, and only goldens ask.
    from importlib.metadata import version

    machine = platform.machine().lower().replace("amd64", "x86_64").replace("aarch64", "arm64")
    parts = [sys.platform, machine, platform.libc_ver()[0]]
    return {"platform": "-".join(part for part in parts if part), "pymunk": version("pymunk")}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _explained(run: Recording, golden: Recording, found: Comparison) -> Told:
    if found.ok:
        return found
    from bench.check.report import report  # numpy comes with it, which a run that is as it was never needs

    return report(run, golden, found)


def _against_old(run: Recording, golden_dir: Path) -> Told | None:
    try:
        golden = Recording.open(golden_dir)
        return _explained(run, golden, compare(run, golden))
    except RecordingError:
        return None  # damaged: pinning again is the way to mend it


def _read_golden_toml(path: Path) -> dict[str, Any]:
    try:
        facts = tomllib.loads(read_bytes(path).decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RecordingError(f"{path}: is not valid TOML ({error}); restore it or pin again") from None
    if facts.get("schema") != SCHEMA:
        raise RecordingError(f"{path}: schema: expected {SCHEMA}, got {facts.get('schema')}; pin again")
    if not isinstance(facts.get("sha256"), dict):
        raise RecordingError(f"{path}: sha256: expected a table of files; restore it or pin again")
    return facts
