"""Would the tests notice? One small change at a time in the codecs and the link machine: `make mutate`.

    scripts/mutate.py                          every mutant of every module
    scripts/mutate.py --only sbus,link         some modules
    scripts/mutate.py --sample 60 --seed 1     so many mutants a module, drawn with this seed
    scripts/mutate.py --list --only link       their names

A mutant is one operator, comparison, constant, order or statement changed in one place. It is killed where a test
fails, hangs or takes too much memory. Each module has a few quick test files of its own; what survives them meets the
wider ones. What survives these too needs a reason in mutate_reasons.toml: a mutant that behaves as the original does,
or whose difference nobody may rely on. Exit status 1 where one has none, or where a reason's mutant is gone or killed.

No file is changed: each mutant lives in a process of its own, forked from one that has the test tools loaded.
"""

from __future__ import annotations

import argparse
import ast
import importlib.abc
import importlib.machinery
import importlib.util
import os
import random
import resource
import signal
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
REASONS = Path(__file__).resolve().with_name("mutate_reasons.toml")
SURVIVED, KILLED, HUNG = "survived", "killed", "hung"
CPU_S = 25
"""A mutant that takes longer hangs; the slowest list of tests takes less than half of it."""
MEMORY_BYTES = 2 << 30

RC_QUICK = ("test_rc_vectors", "test_rc_corners", "test_rc_mutants", "test_rc_streams")
RC_WIDE = ("test_rc_decode",)
SLAMWARE_WIDE = ("test_slamware_base", "test_slamware_core", "test_slamware_reference", "test_slamware_sub_commands")


class Target(NamedTuple):
    """A module, the tests that meet its mutants first, and those that only survivors meet."""

    path: str
    quick: tuple[str, ...]
    wide: tuple[str, ...] = ()


TARGETS = {
    "uart12": Target("bench/rc/uart12.py", RC_QUICK, RC_WIDE),
    "sbus": Target("bench/rc/sbus.py", RC_QUICK, RC_WIDE),
    "crsf": Target("bench/rc/crsf.py", RC_QUICK, RC_WIDE),
    "ibus": Target("bench/rc/ibus.py", RC_QUICK, RC_WIDE),
    "dbus": Target("bench/rc/dbus.py", RC_QUICK, RC_WIDE),
    "framing": Target("bench/rc/framing.py", RC_QUICK, RC_WIDE),
    "link": Target("bench/link.py", ("test_link", "test_link_mutants"), ("test_drive",)),
    "m2006": Target("bench/m2006.py", ("test_m2006",), ("test_can_ends", "test_dm3519", "test_bus_watch")),
    "c610": Target("bench/canbus/c610.py", ("test_m2006", "test_can_docs"), ("test_can_tables", "test_bus_watch")),
    "table": Target("bench/canbus/table.py", ("test_m2006", "test_can_docs"), ("test_can_tables",)),
    "slamware": Target("bench/slamware/framing.py", ("test_slamware_framing",), SLAMWARE_WIDE),
    "payloads": Target("bench/slamware/payloads.py", ("test_slamware_payloads",), SLAMWARE_WIDE),
}


# --- making mutants ------------------------------------------------------------------------------------------------


class Mutant(NamedTuple):
    """One change: where and what."""

    name: str
    """Function, what was there and what is there now; a number where the same is found more than once."""
    parent: ast.AST
    field: str
    place: int | None
    """In the field, where that is a list."""
    change: ast.AST

    def apply(self) -> None:
        """Put the change into the tree that the mutant was made from."""
        if self.place is None:
            setattr(self.parent, self.field, self.change)
        else:
            getattr(self.parent, self.field)[self.place] = self.change


COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Everything that is done to one node, each as a new node in its place."""
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            for other in COMPARISONS[type(operator)]:
                yield ast.Compare(node.left, [*node.ops[:i], other(), *node.ops[i + 1 :]], node.comparators)
    elif isinstance(node, ast.BinOp):
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
    elif isinstance(node, ast.AugAssign):
        yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)
        yield ast.Pass()
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.And() if isinstance(node.op, ast.Or) else ast.Or(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub | ast.Invert):
        yield node.operand
    elif isinstance(node, ast.Constant):
        value = node.value
        if isinstance(value, bool):
            yield ast.Constant(not value)
        elif isinstance(value, int | float):
            yield ast.Constant(value + 1)
            yield ast.Constant(value - 1)
        elif isinstance(value, str) and value[:1] in ("<", ">") and len(value) > 1:
            yield ast.Constant("<>"["><".index(value[0])] + value[1:])  # the byte order of a struct
        elif isinstance(value, str) and value:
            yield ast.Constant(value + "?")
        elif isinstance(value, bytes) and value:
            yield ast.Constant(bytes((value[0] ^ 1,)) + value[1:])
    elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield ast.Return(ast.Constant(None))
    elif _is_call(node) or (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute)):
        yield ast.Pass()
    elif isinstance(node, ast.Continue):
        yield ast.Break()
    elif isinstance(node, ast.Break):
        yield ast.Continue()


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)


def sites(tree: ast.Module) -> Iterator[tuple[str, ast.AST, str, int | None]]:
    """Where a change is possible: function, parent, its field and the place in that. What only people read is left."""

    def walk(node: ast.AST, function: str) -> Iterator[tuple[str, ast.AST, str, int | None]]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            function = f"{function}.{node.name}" if function else node.name
        if isinstance(node, ast.Raise | ast.JoinedStr):
            return  # the words of a refusal
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("__slots__", "__all__"):
            return
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "bases"):
                continue
            for i, child in enumerate(value) if isinstance(value, list) else ((None, value),):
                if not isinstance(child, ast.AST):
                    continue
                if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                    continue  # a docstring
                yield function, node, field, i
                yield from walk(child, function)

    return walk(tree, "")


def mutants(source: str) -> tuple[ast.Module, list[Mutant]]:
    """The tree, and all that can be done to it, in the order of the source."""
    tree = ast.parse(source)
    made: list[Mutant] = []
    seen: Counter[str] = Counter()
    for function, parent, field, place in list(sites(tree)):
        node = getattr(parent, field) if place is None else getattr(parent, field)[place]
        for change in changes(node):
            name = f"{function or 'module'}: {_text(node)} -> {_text(change)}"
            seen[name] += 1
            if seen[name] > 1:
                name += f" #{seen[name]}"
            made.append(Mutant(name, parent, field, place, change))
    return tree, made


def _text(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= 100 else text[:97] + "..."


# --- running tests -------------------------------------------------------------------------------------------------


class Only(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives one module its mutated code."""

    def __init__(self, path: str, tree: ast.Module) -> None:
        self.name = path.removesuffix(".py").replace("/", ".")
        self.file = str(ROOT / path)
        self.code = compile(tree, self.file, "exec")

    def find_spec(self, name, path=None, target=None):  # type: ignore[no-untyped-def]
        """The mutated module's own place, so that what it is asked for is found."""
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.file, loader=self)

    def exec_module(self, module) -> None:  # type: ignore[no-untyped-def]
        """Run the mutated code as the module."""
        exec(self.code, module.__dict__)


def load_tools() -> None:
    """Import what every test run needs, but nothing of the bench."""
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    import pytest  # noqa: F401

    assert not any(name == "bench" or name.startswith("bench.") for name in sys.modules)


def survives(path: str, tests: Sequence[str], tree: ast.Module | None = None, mutant: Mutant | None = None) -> str:
    """Run tests in a fork of this process with one module mutated; "survived", "killed" or "hung"."""
    files = [f"{ROOT}/tests/{name}.py" for name in tests if (ROOT / "tests" / f"{name}.py").exists()]
    child = os.fork()
    if child == 0:
        status = 3
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S + 5))
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
            sink = os.open(os.devnull, os.O_RDWR)
            for stream in (0, 1, 2):
                os.dup2(sink, stream)
            os.chdir(ROOT)
            sys.dont_write_bytecode = tree is not None
            if tree is not None and mutant is not None:
                mutant.apply()  # the tree of this process is its own
                sys.meta_path.insert(0, Only(path, ast.fix_missing_locations(tree)))
            import pytest

            options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=", "--tb=no"]
            status = int(pytest.main([*options, *files]))
        finally:
            os._exit(status)
    _, ended = os.waitpid(child, 0)
    if os.WIFSIGNALED(ended):
        return HUNG if os.WTERMSIG(ended) in (signal.SIGXCPU, signal.SIGKILL) else KILLED
    return SURVIVED if os.WEXITSTATUS(ended) == 0 else KILLED


def judge(target: Target, tree: ast.Module, mutant: Mutant) -> str:
    """The quick tests first, the wider ones for what they let through."""
    verdict = survives(target.path, target.quick, tree, mutant)
    if verdict == SURVIVED and target.wide:
        verdict = survives(target.path, target.wide, tree, mutant)
    return verdict


def read_reasons(path: Path = REASONS) -> dict[str, dict[str, str]]:
    """Module -> mutant -> why it may survive."""
    data = tomllib.loads(path.read_text()) if path.exists() else {}
    return {
        module: {name: entry["why"] for entry in entries for name in entry["mutants"]}
        for module, entries in data.items()
    }


def main() -> int:
    """The command line; 0 where every survivor has its reason."""
    parser = argparse.ArgumentParser(description="Mutate the codecs and the link machine.")
    parser.add_argument("--only", default="", help=f"some of {', '.join(TARGETS)}")
    parser.add_argument("--sample", type=int, default=0, help="so many mutants a module; 0: all")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--list", action="store_true", help="name the mutants and run nothing")
    given = parser.parse_args()
    names = [name for name in given.only.split(",") if name] or list(TARGETS)
    unknown = sorted(set(names) - set(TARGETS))
    if unknown:
        parser.error(f"no module is called {', '.join(unknown)}; known: {', '.join(TARGETS)}")
    made = {name: mutants((ROOT / TARGETS[name].path).read_text()) for name in names}
    if given.list:
        for name in names:
            print(*(f"{name}  {mutant.name}" for mutant in made[name][1]), sep="\n")
        return 0
    load_tools()
    reasons, bad = read_reasons(), 0
    print(
        f"{'module':<10}{'mutants':>8}{'run':>6}{'killed':>8}{'hung':>6}{'survived':>10}{'no reason':>11}{'s':>7}",
        flush=True,
    )
    for name in names:
        target, known = TARGETS[name], reasons.get(name, {})
        tree, every_mutant = made[name]
        begun = time.monotonic()
        if survives(target.path, (*target.quick, *target.wide)) != SURVIVED:
            print(f"{name}: its tests fail without any mutant; nothing can be told", flush=True)
            bad += 1
            continue
        chosen = every_mutant
        if given.sample and given.sample < len(chosen):
            chosen = random.Random(given.seed).sample(chosen, given.sample)
        with ThreadPoolExecutor(given.jobs) as pool:
            verdicts = list(pool.map(lambda mutant: judge(target, tree, mutant), chosen))  # noqa: B023
        count = Counter(verdicts)
        left = [mutant.name for mutant, verdict in zip(chosen, verdicts, strict=True) if verdict == SURVIVED]
        without = [one for one in left if one not in known]
        took = time.monotonic() - begun
        print(
            f"{name:<10}{len(every_mutant):>8}{len(chosen):>6}{count[KILLED]:>8}{count[HUNG]:>6}{len(left):>10}"
            f"{len(without):>6}{took:>7.0f}",
            flush=True,
        )
        # A reason whose mutant is gone or killed says nothing any more.
        run = {mutant.name for mutant in chosen}
        gone = [
            one
            for one in known
            if one not in {mutant.name for mutant in every_mutant} or (one in run and one not in left)
        ]
        for one in without:
            print(f"    survived without a reason: {one}", flush=True)
        for one in gone:
            print(f"    reason without a survivor: {one}", flush=True)
        bad += len(without) + len(gone)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
