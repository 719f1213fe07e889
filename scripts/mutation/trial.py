"""Trying mutants: which tests meet one, and does any of them notice?

A test that does not run the changed statement tells nothing about it. So every test is first run once, with fixtures of
its own, empty caches and nothing changed, and the statements of the module that it runs are noted. Then each mutant
meets the tests that run its statement, those first that killed most of its neighbours, until one fails; a survivor has
met them all, but for tests of commands, which other processes run.

A statement inside a function is changed in a fork of a process that has all tests loaded: the functions get their new
code in place. A statement that already runs while things are imported (a constant, a table, what builds them) may have
left its mark anywhere, so its mutant is imported anew and meets every test of the list.

No file is changed. Nothing is shrunk or explained: the first failure is enough.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import gc
import importlib
import math
import os
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from mutation.code import Only, caches_of, functions_of, put_in_place
from mutation.forks import Ended, forks, limit
from mutation.mutants import Mutant, marked

SURVIVED, UNREACHED, KILLED, HUNG, UNTOLD = "survived", "unreached", "killed", "hung", "untold"
ANEW = "anew"
"""Not yet tried: must be imported anew."""
MARK = "__ran__"
TEST_CPU_S, TIMES = 2, 4
"""A test that takes so much longer under a mutant than so often its usual time hangs: of processor time, so that a
busy machine kills no mutant."""
UNKNOWN_S = 10.0
IMPORT_CPU_S = 20
TOOLS = (
    "hypothesis.strategies",
    "pytest",
    "_pytest.doctest",
    "can",
    "cantools",
    "numpy",
    "pymunk",
    "serial",
    "textual.app",
)
"""What tests and bench import from outside, loaded once for all forks."""
OPTIONS = ("-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=", "--tb=no")
OPTIONS += ("-p", "no:unraisableexception", "-p", "no:threadexception")  # they collect garbage, which takes long
OPTIONS += ("--assert=plain",)  # pytest would read bench itself, as it does where a plugin is installed from: no mutant


class Trial(NamedTuple):
    """What became of a mutant."""

    verdict: str
    by: str = ""
    """The test that killed it."""


class Broken(Exception):
    """Tests fail without any mutant: nothing can be told."""


def trial_of(ended: Ended) -> Trial:
    """What the end of a fork says about the mutant that it tried: it answers which test failed."""
    if ended.raised:
        raise Broken(ended.raised)
    if ended.answer is None:
        if ended.signal in (signal.SIGALRM, signal.SIGKILL):  # the machine's want of time or memory
            return Trial(UNTOLD)
        return Trial(HUNG if ended.signal == signal.SIGXCPU else KILLED)
    if ended.answer == ANEW:
        return Trial(ANEW)
    return Trial(KILLED, ended.answer) if ended.answer else Trial(SURVIVED)


# --- tests ---------------------------------------------------------------------------------------------------------


class Killers:
    """Which tests killed how many mutants: the likeliest go first, those that take `under_s` or longer not at all.

    A test that mostly waits for commands that it starts takes for ever: no mutant reaches another process.
    """

    def __init__(self, seconds: dict[str, float], under_s: float) -> None:
        self.seconds, self.under_s = seconds, under_s
        self.all: Counter[str] = Counter()
        self.near: Counter[tuple[str, str]] = Counter()

    def add(self, mutant: Mutant, trial: Trial) -> None:
        """What became of a mutant."""
        if trial.verdict == KILLED:
            self.all[trial.by] += 1
            self.near[mutant.function, trial.by] += 1

    def sorted(self, mutant: Mutant, tests: Iterable[str]) -> list[str]:
        """Those that killed neighbours, those that killed others, those that are quick."""
        return sorted(
            (test for test in tests if self.seconds.get(test, 0.0) < self.under_s),
            key=lambda test: (-self.near[mutant.function, test], -self.all[test], self.seconds.get(test, 0.0)),
        )


class Loaded:
    """A pytest plugin: loads tests as they are, then does something else than running them all."""

    def __init__(self, then: Callable[[Loaded], object]) -> None:
        self.then = then
        self.tests: dict[str, Any] = {}
        self.failed = ""

    def pytest_sessionstart(self) -> None:
        """After conftest.py, before any test is made."""
        from hypothesis import HealthCheck, Phase, settings

        settings.register_profile(
            "mutants",
            parent=settings(),
            phases=(Phase.explicit, Phase.generate, Phase.target),
            report_multiple_bugs=False,
            suppress_health_check=[HealthCheck.too_slow],
        )
        settings.load_profile("mutants")

    def pytest_runtestloop(self, session: Any) -> bool:
        """Instead of the usual one."""
        if session.testsfailed:
            self.failed = "import"
        else:
            self.tests = {item.nodeid: item for item in session.items}
            self.then(self)
        return True

    def pytest_runtest_logreport(self, report: Any) -> None:
        """One part of a test is over."""
        if report.failed:
            self.failed = report.nodeid

    def run(self, tests: Iterable[str], seconds: Mapping[str, float]) -> str:
        """One after the other, each with fixtures of its own, until one fails: that one."""
        for test in tests:
            limit(TEST_CPU_S + TIMES * seconds.get(test, UNKNOWN_S))
            item = self.tests[test]
            item.ihook.pytest_runtest_protocol(item=item, nextitem=None)
            if self.failed:
                return self.failed
        return ""


def _load(root: Path, files: Iterable[str], then: Callable[[Loaded], object]) -> str:
    """Load test files and do something with them; the first failure."""
    import pytest

    os.chdir(root)
    plugin = Loaded(then)
    status = pytest.main([*OPTIONS, *(f"tests/{name}.py" for name in files)], plugins=[plugin])
    return plugin.failed or ("" if status in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED) else "pytest")


# --- a module's mutants --------------------------------------------------------------------------------------------


class Module:
    """One module, its tests, and the trial of its mutants; `tell` hears early what became of each, in any process."""

    def __init__(
        self,
        root: Path,
        path: str,
        files: Sequence[str],
        tree: ast.Module,
        made: Sequence[Mutant],
        tell: Callable[[Mutant, Trial], None] = lambda mutant, trial: None,
    ) -> None:
        self.root, self.files, self.tree, self.made, self.tell = root, files, tree, made, tell
        self.file = str(root / path)
        self.name = path.removesuffix(".py").replace("/", ".")

    def try_all(self, chosen: Sequence[int], jobs: int, under_s: float = math.inf) -> dict[int, Trial]:
        """Number of each chosen mutant -> what became of it."""
        (_, ended), *_ = forks(1, [chosen], lambda numbers: self._loaded(numbers, jobs, under_s))
        if ended.answer is None:
            raise Broken(ended.raised or f"ended by signal {ended.signal}")
        if ended.answer["failed"]:
            raise Broken(ended.answer["failed"])
        trials = {number: Trial(*trial) for number, trial in ended.answer["trials"]}
        killers = Killers(ended.answer["seconds"], under_s)
        for number, trial in trials.items():
            killers.add(self.made[number], trial)
        anew = [number for number, trial in trials.items() if trial.verdict == ANEW]
        for number, ended in forks(jobs, anew, functools.partial(self._anew, killers)):
            trials[number] = trial_of(ended)
            killers.add(self.made[number], trial_of(ended))
            self.tell(self.made[number], trial_of(ended))
        return trials

    def _loaded(self, numbers: Sequence[int], jobs: int, under_s: float) -> dict[str, object]:
        """In a fork: load every test, note what each runs, and try what can be changed in place."""
        answer: dict[str, object] = {"failed": "", "trials": [], "seconds": {}}
        ran: set[int] = set()
        """Lines of statements in functions."""
        tree = marked(Path(self.file).read_text(), MARK)
        sys.meta_path.insert(0, Only(self.name, self.file, tree, **{MARK: ran.add}))

        def record(loaded: Loaded, caches: Sequence[Any]) -> dict[str, tuple[list[int], float]]:
            recorded = {}
            for test in loaded.tests:
                ran.clear()
                for cache in caches:
                    cache.cache_clear()
                begun_s, begun_commands_s = sum(os.times()[:2]), sum(os.times()[2:4])
                if loaded.run([test], {}):
                    raise Broken(f"{test} fails")
                took_s = sum(os.times()[:2]) - begun_s
                if sum(os.times()[2:4]) - begun_commands_s > took_s:
                    took_s = math.inf
                recorded[test] = sorted(ran), took_s
            return recorded

        def then(loaded: Loaded) -> None:
            while_loading = ran.copy()
            functions, caches = functions_of(self.file), caches_of(self.root)
            gc.collect()
            gc.freeze()  # what forks share is not looked at in each of them
            ((_, ended),) = forks(1, [loaded], lambda loaded: record(loaded, caches))
            if ended.answer is None:
                loaded.failed = ended.raised or f"signal {ended.signal}"
                return
            lines = {test: set(ran_lines) for test, (ran_lines, _) in ended.answer.items()}
            seconds = {test: took for test, (_, took) in ended.answer.items()}
            answer["seconds"] = seconds
            trials = answer["trials"] = []
            killers = Killers(seconds, under_s)
            for number, trial in self._try_in_place(numbers, jobs, loaded, while_loading, lines, killers, functions):
                trials.append((number, trial))
                self.tell(self.made[number], trial)

        answer["failed"] = _load(self.root, self.files, then)
        return answer

    def _try_in_place(
        self,
        numbers: Sequence[int],
        jobs: int,
        loaded: Loaded,
        while_loading: set[int],
        lines: dict[str, set[int]],
        killers: Killers,
        functions: Sequence[FunctionType],
    ) -> Iterator[tuple[int, Trial]]:
        def tests_of(mutant: Mutant) -> list[str]:
            return [test for test, ran in lines.items() if mutant.line in ran]

        def task(number: int) -> str:
            limit(TEST_CPU_S)
            mutant = self.made[number]
            mutant.apply()  # the tree of this process is its own
            if not put_in_place(functions, ast.fix_missing_locations(self.tree), self.file):
                return ANEW
            return loaded.run(killers.sorted(mutant, tests_of(mutant)), killers.seconds)

        here = []
        for number in numbers:
            mutant = self.made[number]
            if not mutant.line or mutant.line in while_loading:
                yield number, Trial(ANEW)
            elif not tests_of(mutant):
                yield number, Trial(UNREACHED)
            else:
                here.append(number)
        for number, ended in forks(jobs, here, task):
            killers.add(self.made[number], trial_of(ended))
            yield number, trial_of(ended)

    def _anew(self, killers: Killers, number: int) -> str:
        """In a fork: import the module with one mutant, and the tests; the test that fails."""
        limit(IMPORT_CPU_S)
        sys.dont_write_bytecode = True
        mutant = self.made[number]
        mutant.apply()
        sys.meta_path.insert(0, Only(self.name, self.file, ast.fix_missing_locations(self.tree)))
        return _load(
            self.root, self.files, lambda loaded: loaded.run(killers.sorted(mutant, loaded.tests), killers.seconds)
        )


def load_tools(root: Path) -> None:
    """Import what every test run needs, but nothing of the bench."""
    sys.path[:0] = [str(root), str(root / "tests")]
    for name in TOOLS:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    assert not any(name == "bench" or name.startswith("bench.") for name in sys.modules)
