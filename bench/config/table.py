"""A TOML table with its address: every value is asked for by name and kind, every refusal says which file and key."""

from __future__ import annotations

import difflib
import errno
import math
import re
import stat
import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

from bench.errors import UsageError

MOST_S = 86_400.0
"""A day: longer than any run, so that a slip of the keyboard is seen."""


class ConfigError(UsageError):
    """A robot, profile or scenario file that cannot be right. The text is one sentence for the user."""


def read_file(path: Path) -> bytes:
    """The file's bytes. Raises OSError; of a device too, which may never end."""
    mode = path.stat().st_mode
    if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
        raise OSError(errno.EINVAL, "it is a device and no file")
    return path.read_bytes()


def read_toml(path: Path) -> dict[str, Any]:
    """The file's tables. Raises ConfigError where it cannot be read or is not TOML."""
    try:
        return tomllib.loads(read_file(path).decode("utf-8-sig"))  # some editors begin a file with a mark of order
    except FileNotFoundError:
        raise ConfigError(f"{path}: there is no such file; check its name and its folder") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not a text file; a TOML file is expected") from None
    except ValueError as error:  # of TOML; and Python reads no whole number of more than 4300 digits
        raise ConfigError(f"{path}: is not valid TOML: {error}") from None
    except RecursionError:
        raise ConfigError(f"{path}: is not valid TOML: brackets within brackets without end") from None


def nearest(word: str, choices: list[str]) -> str:
    """'; did you mean X?' or '; known: A, B, C', to end an error sentence with."""
    close = difflib.get_close_matches(word, choices, n=1)
    return f"; did you mean {close[0]}?" if close else f"; known: {', '.join(choices)}"


_T = TypeVar("_T")
_NOT_IN_A_LINE = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")
"""Names stand in lines of logs, tables and terminals."""
_KIND_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false", list: "a list"}


class Table:
    """One TOML table with its address, so that every refusal says which file and which key.

    `origins` has key, or key[number], -> (file, address) of what stands in another file.
    """

    def __init__(
        self, path: Path, where: str, values: Mapping[str, Any], origins: Mapping[str, tuple[Path, str]] | None = None
    ) -> None:
        self.path = path
        self.origins = origins or {}
        self.where = where
        self.values = dict(values)
        self.known: list[str] = []

    def key(self, name: str) -> str:
        """The key's full address in the file."""
        return f"{self.where}.{name}" if self.where else name

    def fail(self, name: str, what: str) -> ConfigError:
        """The error for one key of this table."""
        path, key = self._origin(self.key(name))
        return ConfigError(f"{path}: {key}: {what}")

    def _origin(self, key: str) -> tuple[Path, str]:
        return self.origins.get(key, (self.path, key))

    def has(self, name: str) -> bool:
        """Whether the file gives this key, which is a known one from now on."""
        self.known.append(name)
        return name in self.values

    def take_schema(self) -> None:
        """Refuse a file of another schema."""
        schema = self.get("schema", int, 1)
        if schema != 1:
            raise self.fail("schema", f"expected 1, got {schema}; this file is for another version of wheelbench")

    def get(self, name: str, kind: type, default: Any = MISSING) -> Any:
        """Take one value out of the table, checked for its kind."""
        self.known.append(name)
        if name not in self.values:
            if default is MISSING:
                unknown = [key for key in self.values if difflib.get_close_matches(key, [name])]
                hint = f"; is {unknown[0]} meant to be it?" if unknown else ""
                raise self.fail(name, f"is missing{hint}")
            return default
        value = self.values.pop(name)
        if kind is float and type(value) is int:
            try:
                value = float(value)
            except OverflowError:
                value = math.inf
        if type(value) is not kind:
            raise self.fail(name, f"expected {_KIND_NAMES[kind]}, got {value!r}")
        if isinstance(value, float) and not math.isfinite(value):
            raise self.fail(name, f"expected a finite number, got {value}")
        if name == "name" and isinstance(value, str) and _NOT_IN_A_LINE.search(value):
            raise self.fail(name, f"expected one line without control characters, got {value!r}")
        return value

    def ticks(self, name: str, default: Any = MISSING, *, least: int = 0) -> Any:
        """Take a time in seconds, as ticks of 1 ms; `least` of them at least."""
        seconds = self.get(name, float, default)
        if seconds is default:
            return default
        if not least / 1000.0 <= seconds <= MOST_S:
            raise self.fail(name, f"expected {least / 1000.0:g} to {MOST_S:g} seconds, got {seconds:g}")
        return round(1000.0 * seconds)

    def table(self, name: str, *, optional: bool = False) -> Table:
        """Take a table out of this one."""
        self.known.append(name)
        value = self.values.pop(name, {} if optional else None)
        if value is None:
            raise self.fail(name, f"the table [{self.key(name)}] is missing")
        if not isinstance(value, dict):
            raise self.fail(name, f"expected a table [{self.key(name)}], got {value!r}")
        return Table(*self._origin(self.key(name)), value)

    def tables(self, name: str, *, optional: bool = False) -> list[Table]:
        """Take an array of tables, at least one long unless `optional`."""
        self.known.append(name)
        value = self.values.pop(name, [] if optional else None)
        if not isinstance(value, list) or not (value or optional) or not all(isinstance(e, dict) for e in value):
            raise self.fail(name, f"expected at least one table [[{self.key(name)}]]")
        return [Table(*self._origin(f"{self.key(name)}[{i}]"), entry) for i, entry in enumerate(value)]

    def into(self, cls: type[_T], **ready: Any) -> _T:
        """Fill a dataclass from this table; keys that it does not have are errors."""
        values = dict(ready)
        for item in fields(cls):  # type: ignore[arg-type]
            if item.name in ready or str(item.type).endswith("| None"):
                continue
            kind = {"str": str, "int": int, "float": float, "bool": bool}[str(item.type)]
            values[item.name] = self.get(item.name, kind, item.default)
        self.refuse_rest()
        return cls(**values)

    def refuse_rest(self) -> None:
        """Raise ConfigError where the file has a key that nobody asked for."""
        for name in self.values:
            if name not in self.known:
                raise self.fail(name, f"unknown key{nearest(name, sorted(set(self.known)))}")
