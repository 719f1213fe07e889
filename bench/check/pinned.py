"""The goldens of a folder, and who uses each: one that nothing is held against only looks like a safety net.

A golden is in use where a test, a scenario, a program or a build file of the same project names it behind the name of
the folder that it lies in: "pinned/walk", or "pinned" / "walk". The plugin's fixture takes its golden by the name of
the test, so a test of that name is a user too, and so is `golden("walk")`. What a page of prose says of it is no use.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bench.check.golden import how_exactly
from bench.check.reading import Recording
from bench.check.recording import GOLDEN_TOML, RecordingError, cannot

_ENDINGS = (".py", ".toml", ".cfg", ".ini", ".sh", ".yml", ".yaml", ".json")
_NAMES = ("Makefile", "run")
_NOT_OURS = ("node_modules", "site-packages", "__pycache__", "build", "dist")
_LARGEST_BYTES = 1 << 20
_NOT_THERE = (errno.ENOENT, errno.ENOTDIR, errno.ELOOP)
_MOST_UNREAD = 3


@dataclass(frozen=True, slots=True)
class Golden:
    """One golden. `damage` says why it cannot be trusted, and is empty where it can."""

    directory: Path
    users: tuple[str, ...]
    """Files that name it, relative to the project."""
    robot: str = ""
    ticks: int = 0
    damage: str = ""
    unread: tuple[str, ...] = ()
    """What might name it and cannot be read, relative to the project."""

    @property
    def ok(self) -> bool:
        """Whether it is whole and in use."""
        return bool(self.users) and not self.damage

    @property
    def text(self) -> str:
        """One line for people."""
        if self.damage:
            return f"{self.directory.name:20} {self.damage}"
        what = f"{self.robot}, {self.ticks / 1000:.1f} s"
        return f"{self.directory.name:20} {what:20} {self.use}"

    @property
    def use(self) -> str:
        """Who holds something against it."""
        if self.users:
            return f"used by {', '.join(self.users)}"
        if self.unread:
            more = f" and {len(self.unread) - _MOST_UNREAD} more" if len(self.unread) > _MOST_UNREAD else ""
            return f"UNUSED, as far as can be read: not {', '.join(self.unread[:_MOST_UNREAD])}{more}"
        return "UNUSED: nothing is held against it; delete it"


def goldens(folder: Path, project: Path | None = None) -> list[Golden]:
    """Every golden in a folder, by name, and what may be one and cannot be looked into; `project` is where users are
    looked for, and found unless given. Raises RecordingError where there is no such folder, or it cannot be read.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder}: is no folder; give the one that your goldens lie in")
    directories, closed = _directories(folder)
    if not directories:
        return closed  # and nobody need be looked for
    project = project.resolve() if project is not None else _project_of(folder)
    users: dict[Path, list[str]] = {directory: [] for directory in directories}
    mentions = {directory: _mention(directory) for directory in directories}
    unread: list[Path] = []
    for path in _readers(project, folder.resolve(), unread):
        try:
            text = path.read_text(encoding="utf-8", errors="replace")
        except OSError:
            unread.append(path)
            continue
        for directory, mention in mentions.items():
            if mention.search(text):
                users[directory].append(path.relative_to(project).as_posix())
    missed = tuple(path.relative_to(project).as_posix() for path in unread)
    found = [_looked_at(directory, tuple(users[directory]), missed) for directory in directories]
    return sorted(found + closed, key=lambda one: one.directory)


def _directories(folder: Path) -> tuple[list[Path], list[Golden]]:
    """Those that hold a golden, and those of which nobody here can say."""
    try:
        inside = sorted(folder.iterdir())
    except OSError as error:
        raise cannot(folder, "read", error) from None
    if folder / GOLDEN_TOML in inside:
        raise RecordingError(f"{folder}: is a golden itself; give the folder that it lies in")
    directories, closed = [], []
    for path in inside:
        try:
            (path / GOLDEN_TOML).stat()
        except OSError as error:
            if error.errno not in _NOT_THERE:
                closed.append(Golden(path, (), damage=str(cannot(path, "read", error))))
        else:
            directories.append(path)
    return directories, closed


def _looked_at(directory: Path, users: tuple[str, ...], unread: tuple[str, ...]) -> Golden:
    try:
        recording = Recording.open(directory)
        how_exactly(recording)
    except RecordingError as error:
        return Golden(directory, users, damage=str(error), unread=unread)
    return Golden(directory, users, recording.info.robot, recording.ticks, unread=unread)


def _mention(directory: Path) -> re.Pattern[str]:
    folder, name = (re.escape(part) for part in directory.resolve().parts[-2:])
    by_path = rf"{folder}[\W_]{{1,6}}{name}(?![\w-])"
    by_fixture = rf"golden\(\s*[\"']{name}[\"']"
    # A parametrised test has its parameters behind its own name.
    tests = "|".join(re.escape(test) for test in _beginnings(directory.name))
    return re.compile(rf"{by_path}|{by_fixture}|def (?:{tests})\(" if tests else f"{by_path}|{by_fixture}")


def _beginnings(name: str) -> list[str]:
    """What the test may be called whose golden has this name: all of it, or up to one of its underscores."""
    if not name.startswith("test_"):
        return []
    return [name, *(name[: at.start()] for at in re.finditer("_", name) if at.start() > len("test"))]


def _project_of(folder: Path) -> Path:
    """The nearest folder above that looks like a project's own; else the one two above: fixtures/pinned."""
    above = folder.resolve().parents or (folder.resolve(),)
    marked = (path for path in above if any((path / mark).exists() for mark in ("pyproject.toml", ".git", "setup.cfg")))
    return next(marked, above[min(1, len(above) - 1)])


def _readers(project: Path, pinned: Path, unread: list[Path]) -> Iterator[Path]:
    """Files that may name a golden; folders that cannot be read join `unread`."""
    for at, folders, files in os.walk(project, onerror=lambda error: unread.append(Path(error.filename))):
        folders[:] = sorted(
            name
            for name in folders
            if name not in _NOT_OURS
            and (not name.startswith(".") or name in (".ci", ".github"))
            and (Path(at) / name).resolve() != pinned
        )
        for name in sorted(files):
            path = Path(at) / name
            if (path.suffix in _ENDINGS or name in _NAMES) and _is_small(path):
                yield path


def _is_small(path: Path) -> bool:
    """Whether it is a file of a size that people write; a pipe or a link that leads nowhere is none."""
    try:
        return path.is_file() and path.stat().st_size <= _LARGEST_BYTES
    except OSError:
        return False
