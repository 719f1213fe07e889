"""`extends = "base.toml"` in a scenario: what many scenarios share stands once.

A key of the file takes the place of the base's. `[[fault]]` and `[[expect]]` come on top of the base's, and one with
the `name` of one of the base's takes its place. `rc` and `[[stick]]` are one driver: either replaces either. `name` and
`about` are each file's own. Files named in a base lie beside the base. A base may extend another; not in a circle.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bench.config import ConfigError, read_toml

OWN_KEYS = ("name", "about", "extends")
ADDED_KEYS = ("fault", "expect")
DRIVER_KEYS = ("rc", "stick")
FILE_KEYS = ("rc", "arena", "robot", "profile")


class Whole(NamedTuple):
    """A scenario with what it has from others."""

    values: dict[str, Any]
    origins: Mapping[str, tuple[Path, str]]
    """Key, or key[number], -> file and address in it, of what is not the file's own."""
    is_alone: bool
    """It extends nothing."""


def read_whole(path: Path) -> Whole:
    """Read a scenario file and all that it extends. Raises ConfigError."""
    return _read(path, (path,))


def _read(path: Path, chain: tuple[Path, ...]) -> Whole:
    values = read_toml(path)
    if "extends" not in values:
        return Whole(values, {}, True)
    said = values.pop("extends")
    if not isinstance(said, str) or not said:
        raise ConfigError(f"{path}: extends: expected the name of a scenario file, got {said!r}")
    base = path.parent / said
    if any(_same(base, one) for one in chain):
        raise ConfigError(f"{path}: extends: goes round in a circle: {' -> '.join(map(str, (*chain, base)))}")
    if not base.is_file():
        raise ConfigError(f"{path}: extends: there is no scenario {base}")
    return _with(path, values, base, _read(base, (*chain, base)), Path(said).parent)


def _same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False


def _with(path: Path, own: dict[str, Any], base_path: Path, base: Whole, folder: Path) -> Whole:
    """A file's own values on top of its base's, which lies in `folder` as seen from the file."""
    values: dict[str, Any] = {}
    origins: dict[str, tuple[Path, str]] = {}
    replaced = {*OWN_KEYS, *own}
    if replaced & set(DRIVER_KEYS):
        replaced.update(DRIVER_KEYS)
    for key, value in base.values.items():
        if key in ADDED_KEYS and key in own:
            values[key] = _added(path, key, own[key], base_path, base, origins)
        elif key not in replaced:
            values[key] = _seen_from(folder, key, value)
            _keep_origins(key, value, base_path, base, origins)
    return Whole({**own, **values}, origins, False)


def _keep_origins(key: str, value: object, base_path: Path, base: Whole, origins: dict[str, tuple[Path, str]]) -> None:
    origins[key] = base.origins.get(key, (base_path, key))
    for number in range(len(value)) if isinstance(value, list) else ():
        address = f"{key}[{number}]"
        origins[address] = base.origins.get(address, (base_path, address))


def _added(
    path: Path, key: str, own: object, base_path: Path, base: Whole, origins: dict[str, tuple[Path, str]]
) -> object:
    """The base's entries but for those that the file names anew, then its own."""
    theirs = base.values[key]
    if not isinstance(own, list) or not isinstance(theirs, list):
        return own  # refused where it is read
    names = {entry.get("name") for entry in own if isinstance(entry, dict)} - {None}
    both: list[object] = []
    for number, entry in enumerate(theirs):
        if isinstance(entry, dict) and entry.get("name") in names:
            continue
        address = f"{key}[{number}]"
        origins[f"{key}[{len(both)}]"] = base.origins.get(address, (base_path, address))
        both.append(entry)
    for number in range(len(own)):
        origins[f"{key}[{len(both) + number}]"] = (path, f"{key}[{number}]")
    return [*both, *own]


def _seen_from(folder: Path, key: str, value: object) -> object:
    """A file that the base names, as its heir has to name it; anything else as it is."""
    if not isinstance(value, str) or folder == Path():
        return value
    if key == "controller":
        file, colon, name = value.rpartition(":")
        return f"{os.path.normpath(folder / file)}:{name}" if colon and file.endswith(".py") else value
    is_file = key == "rc" or (key in FILE_KEYS and value.endswith(".toml"))
    return os.path.normpath(folder / value) if is_file else value
