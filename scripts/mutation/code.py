"""Running a mutant's code without changing a file: in place in functions that exist, or as what an import gives."""

from __future__ import annotations

import ast
import functools
import gc
import importlib.abc
import importlib.util
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any


class Only(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives one module another code, and names that this code knows besides its own."""

    def __init__(self, name: str, file: str, tree: ast.Module, **names: object) -> None:
        self.name, self.file, self.names = name, file, names
        self.code = compile(tree, file, "exec")

    def find_spec(self, name, path=None, target=None):  # type: ignore[no-untyped-def]
        """The module's own place, so that what it is asked for is found."""
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.file, loader=self)

    def exec_module(self, module) -> None:  # type: ignore[no-untyped-def]
        """Run the other code as the module."""
        module.__dict__.update(self.names)
        exec(self.code, module.__dict__)


def _codes(code: CodeType) -> Iterator[tuple[tuple[str, int], CodeType]]:
    """All code inside of a module's, by name and line."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield (constant.co_qualname, constant.co_firstlineno), constant
            yield from _codes(constant)


def functions_of(file: str) -> list[FunctionType]:
    """Every function that was made from this file."""
    return [one for one in gc.get_objects() if isinstance(one, FunctionType) and one.__code__.co_filename == file]


def caches_of(root: Path) -> list[Any]:
    """What functions of this tree keep of earlier calls: a test that finds an answer there would not run the code."""
    wrapper = type(functools.cache(len))
    return [
        one
        for one in gc.get_objects()
        if isinstance(one, wrapper) and getattr(one.__wrapped__, "__code__", None)
        if one.__wrapped__.__code__.co_filename.startswith((f"{root}/bench/", f"{root}/tests/"))
    ]


def put_in_place(functions: Sequence[FunctionType], tree: ast.Module, file: str) -> bool:
    """Give functions the code of this tree; False where that cannot be done."""
    codes: dict[tuple[str, int], list[CodeType]] = {}
    for key, code in _codes(compile(tree, file, "exec")):
        codes.setdefault(key, []).append(code)
    for one in functions:
        now = codes.get((one.__code__.co_qualname, one.__code__.co_firstlineno), [])
        if one.__code__ in now:
            continue
        if len(now) != 1:
            return False  # two lambdas of one line
        try:
            one.__code__ = now[0]
        except ValueError:  # another number of free variables
            return False
    return True
