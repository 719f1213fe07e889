"""Plain values to TOML text that reads back as the same values: what Python says becomes a file that a run can keep."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import PurePath
from typing import Any

from bench.errors import UsageError

_BARE_KEY = re.compile("[A-Za-z0-9_-]+")


def toml_text(values: Mapping[str, Any]) -> str:
    """Tables of texts, numbers, truths, lists and tables as TOML. Raises UsageError with the key of what is none."""
    return "\n".join(_table(values, "")).strip("\n") + "\n"


def toml_string(text: str) -> str:
    """A text in quotes."""
    # A JSON string is a TOML string but for DEL, which TOML wants escaped.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _table(values: Mapping[str, Any], where: str) -> Iterator[str]:
    tables, arrays = [], []
    for key, value in values.items():
        address = f"{where}{_key(key, where)}"
        if isinstance(value, Mapping):
            tables.append((address, value))
        elif isinstance(value, list | tuple) and value and all(isinstance(entry, Mapping) for entry in value):
            arrays.append((address, value))
        elif value is not None:  # what is not given
            yield f"{_key(key, where)} = {_value(value, address)}"
    for address, table in tables:
        yield from ("", f"[{address}]", *_table(table, f"{address}."))
    for address, entries in arrays:
        for number, entry in enumerate(entries):
            yield from ("", f"[[{address}]]")
            try:
                yield from _table(entry, f"{address}.")
            except UsageError as error:
                raise UsageError(str(error).replace(address, f"{address}[{number}]", 1)) from None


def _key(key: object, where: str) -> str:
    if not isinstance(key, str):
        raise UsageError(f"{where}{key!r}: a key is a text")
    return key if _BARE_KEY.fullmatch(key) else toml_string(key)


def _value(value: object, address: str) -> str:
    if isinstance(value, str | PurePath):
        if not str(value).isprintable() and any("\ud800" <= letter <= "\udfff" for letter in str(value)):
            raise UsageError(f"{address}: half a character of UTF-16 cannot stand in a file: {value!r}")
        return toml_string(str(value))
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):  # numpy's float is a float; its other numbers are asked for their own
        return repr(int(value) if isinstance(value, int) else float(value))
    item = getattr(value, "item", None)
    if callable(item):
        return _value(item(), address)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(entry, address) for entry in value)}]"
    raise UsageError(f"{address}: expected text, a number, true or false, a list or a table, got {value!r}")
