"""What can be opened: robots, arenas and scenarios, ours and those in the folder where wheelbench was started."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

from bench.arena import Arena, load_arena
from bench.check.sources import from_scenario
from bench.config import ConfigError, Robot, load_robot, read_toml, robot_names
from bench.demo import SCENARIO
from bench.io.clock import Pacer
from bench.screen.stage import Stage, to_drive_robot, to_show

MOST_FILES = 200
DEPTHS = ("*.toml", "*/*.toml")
Choice: TypeAlias = tuple[str, str, Callable[[], Stage], str]
"""Words, a note, what opens it, and the robot to remember (or none)."""


def choices(robot: Robot, arena: Arena, pacer: Pacer) -> list[Choice]:
    """Everything that can be opened from here; `robot` and `arena` are those of now."""

    def drive(name: str) -> Callable[[], Stage]:
        return lambda: to_drive_robot(load_robot(name), arena, pacer)

    def show(path: Path) -> Callable[[], Stage]:
        return lambda: to_show(from_scenario(path), None, pacer)

    def enter(path: Path) -> Callable[[], Stage]:
        return lambda: to_drive_robot(robot, load_arena(path), pacer)

    def own(path: Path) -> Callable[[], Stage]:
        return lambda: to_drive_robot(load_robot(path), arena, pacer)

    found: list[Choice] = [(f"drive {name}", "robot", drive(name), name) for name in robot_names()]
    found.append(("drive again, from the start", "this robot", lambda: to_drive_robot(robot, arena, pacer), ""))
    found.append(("show the demo", "scenario", show(SCENARIO), ""))
    for path, kind in _files(Path()):
        if kind == "scenario":
            found.append((f"show {path}", kind, show(path), ""))
        elif kind == "arena":
            found.append((f"drive in {path}", kind, enter(path), ""))
        else:
            found.append((f"drive {path}", kind, own(path), str(path.resolve())))
    return found


def _files(folder: Path) -> Iterator[tuple[Path, str]]:
    """The TOML files of a folder and those one below, by what they are. What cannot be read is none of ours."""
    paths = sorted(path for depth in DEPTHS for path in folder.glob(depth) if not path.parent.name.startswith("."))
    for path in paths[:MOST_FILES]:
        try:
            keys = read_toml(path).keys()
        except ConfigError:
            continue
        kind = "scenario" if {"name", "seconds"} <= keys else "arena" if {"length_m", "width_m"} <= keys else ""
        kind = "robot" if {"wheel", "body"} <= keys else kind
        if kind and not (path.parent / "run.toml").exists():
            yield path, kind
