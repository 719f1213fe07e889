"""A firmware project's TOML file: which sources, for which compiler, which of its names are the bench's wires.

schema = 1
name = "my base"
sources = ["Core/Src/*.c"]     # beside this file; patterns with * and **
leave_out = ["Core/Src/sys*"]  # of them
include = ["Core/Inc"]
defines = ["STM32F407xx"]
flags = []                     # more for the compiler
compiler = "cc"
sanitize = false               # AddressSanitizer and UndefinedBehaviorSanitizer
blocks_per_ms = 5000           # how much the firmware computes in a millisecond: see docs/dut.md

[entry]                        # what runs
main = "main"                  # from reset on; or setup, once, and loop, again and again
every_ms = "control_step"      # as from an interrupt, each millisecond

[wires]                        # the names of the firmware's HAL handles; without them: wheelbench_port.c
rc = "huart1"
slamware = "huart6"
can = "hcan1"                  # or fdcan = "hfdcan1"
can_fifo = 0                   # that its filters lead to

[[timer]]                      # calls HAL_TIM_PeriodElapsedCallback
handle = "htim6"
period_ms = 1
"""

from __future__ import annotations

import fnmatch
import re
from dataclasses import dataclass
from pathlib import Path

from bench.config import Table, read_toml

BLOCKS_PER_MS = 5000
LEAST_BLOCKS_PER_MS = 100
C_ENDINGS = (".c", ".cc", ".cpp", ".cxx")
_NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True, slots=True)
class Project:
    """One firmware, described. Paths are absolute; names are C names, empty where there is none."""

    path: Path
    name: str
    sources: tuple[Path, ...]
    include: tuple[Path, ...]
    defines: tuple[str, ...]
    flags: tuple[str, ...]
    compiler: str
    sanitize: bool
    blocks_per_ms: int
    main: str
    setup: str
    loop: str
    every_ms: str
    rc: str
    slamware: str
    can: str
    fdcan: str
    can_fifo: int
    timers: tuple[tuple[str, int], ...]
    """(handle, period in ms)."""


def load_project(path: Path) -> Project:
    """Read and check a project's file. Raises ConfigError with file, key and what to try."""
    data = Table(path, "", read_toml(path))
    data.take_schema()
    folder = path.resolve().parent
    entry, wires = data.table("entry", optional=True), data.table("wires", optional=True)
    timers = []
    for table in data.tables("timer", optional=True):
        timers.append((_c_name(table, "handle"), table.get("period_ms", int, 1)))
        if timers[-1][1] < 1:
            raise table.fail("period_ms", f"expected 1 or more, got {timers[-1][1]}")
        table.refuse_rest()
    setup, loop = _c_name(entry, "setup", ""), _c_name(entry, "loop", "")
    project = Project(
        path=path,
        name=data.get("name", str),
        sources=_sources(data, folder),
        include=tuple(folder / each for each in _texts(data, "include")),
        defines=tuple(_texts(data, "defines")),
        flags=tuple(_texts(data, "flags")),
        compiler=data.get("compiler", str, "cc"),
        sanitize=data.get("sanitize", bool, False),
        blocks_per_ms=data.get("blocks_per_ms", int, BLOCKS_PER_MS),
        main=_c_name(entry, "main", "" if setup or loop else "main"),
        setup=setup,
        loop=loop,
        every_ms=_c_name(entry, "every_ms", ""),
        rc=_c_name(wires, "rc", ""),
        slamware=_c_name(wires, "slamware", ""),
        can=_c_name(wires, "can", ""),
        fdcan=_c_name(wires, "fdcan", ""),
        can_fifo=wires.get("can_fifo", int, 0),
        timers=tuple(timers),
    )
    for table in (entry, wires, data):
        table.refuse_rest()
    if project.main and (setup or loop):
        raise entry.fail("main", "a firmware begins at one place: give main, or setup and loop")
    if project.blocks_per_ms < LEAST_BLOCKS_PER_MS:
        raise data.fail("blocks_per_ms", f"expected {LEAST_BLOCKS_PER_MS} or more, got {project.blocks_per_ms}")
    if project.can and project.fdcan:
        raise wires.fail("fdcan", "the motors are on one bus: give can or fdcan")
    if project.can_fifo not in (0, 1):
        raise wires.fail("can_fifo", f"expected 0 or 1, got {project.can_fifo}")
    return project


def _texts(data: Table, key: str) -> list[str]:
    values = data.get(key, list, [])
    if not all(isinstance(value, str) for value in values):
        raise data.fail(key, f"expected a list of texts, got {values!r}")
    return values  # type: ignore[no-any-return]


def _c_name(table: Table, key: str, *default: str) -> str:
    name = table.get(key, str, *default)
    if name and not _NAME.fullmatch(name):
        raise table.fail(key, f"expected a name of the firmware, as C writes it, got {name!r}")
    return str(name)


def _sources(data: Table, folder: Path) -> tuple[Path, ...]:
    """The files that the patterns match, in order of their names. Raises ConfigError where one matches nothing."""
    patterns, leave_out = _texts(data, "sources"), _texts(data, "leave_out")
    found: dict[Path, None] = {}
    for pattern in patterns:
        if Path(pattern).is_absolute():
            matches = [Path(pattern)] if Path(pattern).is_file() else []
        elif "*" in pattern or "?" in pattern:
            matches = sorted(path for path in folder.glob(pattern) if path.suffix in C_ENDINGS)
        else:
            matches = [folder / pattern] if (folder / pattern).is_file() else []
        if not matches:
            raise data.fail("sources", f"no file is called {pattern!r} in {folder}; expected C files beside this one")
        found |= dict.fromkeys(matches)
    kept = [path for path in found if not any(_matches(path, folder, pattern) for pattern in leave_out)]
    if not kept:
        raise data.fail("sources", "names no file; give the firmware's own C files")
    for path in kept:
        if path.suffix not in C_ENDINGS:
            raise data.fail("sources", f"{path.name} is no C file; expected {', '.join(C_ENDINGS)}")
    return tuple(kept)


def _matches(path: Path, folder: Path, pattern: str) -> bool:
    return path.is_relative_to(folder) and fnmatch.fnmatch(path.relative_to(folder).as_posix(), pattern)
