"""A file that is given by name or by path: one of ours, or the user's own."""

from __future__ import annotations

from pathlib import Path

from bench.config.table import ConfigError, nearest


def names_in(folder: Path) -> list[str]:
    """The names that files of ours have."""
    return sorted(path.stem for path in folder.glob("*.toml"))


def named_file(name_or_path: str | Path, folder: Path, what: str) -> Path:
    """Where it is; `what` it is, for the sentence of the ConfigError that is raised where it can be neither."""
    text, names = str(name_or_path), names_in(folder)
    if text in names:
        return folder / f"{text}.toml"
    path = Path(name_or_path)
    if path.is_dir():
        raise ConfigError(f"{path}: is a directory; a {what} is a .toml file, or one of: {', '.join(names)}")
    if path.suffix == ".toml" or path.exists():
        return path
    raise ConfigError(f"no {what} is called {text!r}{nearest(text, names)} (or give the path of a .toml file)")
