"""Whatever comes in: nothing raises, no byte is lost, cutting never matters, memory stays put; and the attackers work.

The targets are those of `make fuzz`; here Hypothesis drives them, and every finding so far comes again.
"""

import ast
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import fuzz
import mutate
import noise
from attacks import inputs, targets
from mutation import mutants

ROOT = Path(__file__).parents[1]
FINDINGS = sorted((ROOT / "fixtures" / "known" / "fuzz").glob("*-*"))


@pytest.mark.parametrize("name", targets.ORDER)
@settings(max_examples=40)
@given(st.binary(min_size=8, max_size=8), st.binary(max_size=120))
def test_any_bytes_keep_every_promise(name, head, rest):
    targets.TARGETS[name](head + rest)


@pytest.mark.parametrize("name", targets.ORDER)
def test_the_inputs_that_a_fuzzer_begins_with_keep_every_promise(name):
    for seed in inputs.seeds(name):
        targets.TARGETS[name](seed)


def test_what_was_found_stays_mended(tmp_path):
    (tmp_path / "crsf-of-this-test").write_bytes(bytes(8) + b"\xc8\x18\x16")
    for path in [*FINDINGS, tmp_path / "crsf-of-this-test"]:
        fuzz.replay(path)


def traced_kb():
    return tracemalloc.get_traced_memory()[1] // 1024


@pytest.mark.parametrize("name", noise.MAKERS)
def test_noise_leaves_nothing_behind(name):
    tracemalloc.start()
    try:
        result = noise.run(name, 80_000, traced_kb)
    finally:
        tracemalloc.stop()
    assert noise.is_good(result), result
    assert result.fed_bytes >= 80_000


def test_noise_that_is_kept_is_seen(monkeypatch):
    kept = []

    def take(piece, tick):
        kept.append(piece * 50)
        return len(piece), 0

    monkeypatch.setitem(noise.MAKERS, "keeps all", lambda: take)
    tracemalloc.start()
    try:
        assert not noise.is_good(noise.run("keeps all", 80_000, traced_kb))
    finally:
        tracemalloc.stop()


def test_a_decoder_that_breaks_a_promise_is_found():
    class Greedy:
        """Loses the last byte of what it is given."""

        def __init__(self, inner):
            self.inner, self.counters = inner, inner.counters

        def feed(self, data, at_us=None):
            return self.inner.feed(data[:-1])

        def finish(self):
            return self.inner.finish()

    decoder = Greedy(targets.rc_decode.decoder("crsf"))
    events = decoder.feed(b"\x01\x02\x03") + decoder.finish()
    with pytest.raises(AssertionError, match="missing"):
        targets.check_rc_events("crsf", b"\x01\x02\x03", decoder, events)


def script(name, *arguments):
    return subprocess.run(
        [sys.executable, str(ROOT / "scripts" / name), *arguments], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("name", ["fuzz.py", "mutate.py"])
def test_what_is_not_known_is_refused_with_what_is(name):
    done = script(name, "--only", "morse")
    assert done.returncode == 2
    assert "sbus" in done.stderr
    assert "Traceback" not in done.stderr


def test_both_lists_of_targets_agree():
    assert set(fuzz.ORDER) == set(targets.ORDER) == set(targets.TARGETS)


# --- mutants -------------------------------------------------------------------------------------------------------

SOURCE = '''
def f(a: int, b=2):
    """What it does."""
    if a < b and not a:
        raise ValueError(f"{a} is less than {b}")
    return a + 1
'''


def test_a_mutant_is_one_change_of_what_runs():
    assert [mutant.name for mutant in mutants.mutants(SOURCE)[1]] == [
        "f: 2 -> 3",
        "f: 2 -> 1",
        "f: a < b and (not a) -> a < b or not a",
        "f: a < b -> a <= b",
        "f: a < b -> a >= b",
        "f: not a -> a",
        "f: return a + 1 -> return None",
        "f: a + 1 -> a - 1",
        "f: 1 -> 2",
        "f: 1 -> 0",
    ]


def test_each_mutant_differs_from_the_original_and_from_the_others():
    texts = {ast.unparse(ast.parse(SOURCE))}
    for number in range(10):
        tree, made = mutants.mutants(SOURCE)
        made[number].apply()
        texts.add(ast.unparse(tree))
    assert len(texts) == 11


def test_a_mutant_knows_its_statement_and_what_runs_on_import():
    lines = {mutant.name: mutant.line for mutant in mutants.mutants(SOURCE)[1]}
    assert lines["f: 2 -> 3"] == 0
    assert lines["f: a < b -> a <= b"] == 4
    assert lines["f: 1 -> 2"] == 6


def test_marks_tell_which_statements_ran():
    names = {}
    exec(compile(mutants.marked(SOURCE, "ran"), "here", "exec"), names)
    seen = []
    names["ran"] = seen.append
    assert names["f"](5) == 6
    assert seen == [4, 6]


TRIED = """
LIMIT = 3
TABLE = [place * 2 for place in range(LIMIT)]


def double(place):
    return TABLE[place]


def wait(left):
    while left > 0:
        left -= 1
    return left


def idle(value):
    return value + 0


def unused(value):
    return -value
"""
ITS_TESTS = """
import tried


def test_double():
    assert [tried.double(place) for place in range(3)] == [0, 2, 4]


def test_wait():
    assert tried.wait(5) == 0


def test_idle():
    assert tried.idle(7) >= 7
"""
TRY_IT = """
import os, pathlib, signal, sys
sys.path.insert(0, sys.argv[1])
from mutation import forks, mutants, trial
root = pathlib.Path(sys.argv[2])
trial.TOOLS = ("pytest", "hypothesis")
trial.load_tools(root)
trial.TEST_CPU_S = 1
tree, made = mutants.mutants((root / "tried.py").read_text())
asked = sys.argv[3:]
chosen = [number for number, mutant in enumerate(made) if mutant.name in asked]
trials = trial.Module(root, "tried.py", ["test_tried"], tree, made).try_all(chosen, 2)
for number, one in sorted(trials.items()):
    print(made[number].name, "|", one.verdict, "|", one.by.removeprefix("tests/test_tried.py::"))
signals = [signal.SIGXCPU, signal.SIGALRM, signal.SIGKILL, signal.SIGSEGV]
for number, ended in forks.forks(1, signals, lambda number: os.kill(os.getpid(), number)):
    print(number.name, "|", trial.trial_of(ended).verdict, "| ")
"""


BECAME = {
    "module: 3 -> 2": "killed | test_double",  # a table that is built on import
    "module: 3 -> 4": "survived | ",
    "double: return TABLE[place] -> return None": "killed | test_double",
    "wait: left -= 1 -> left += 1": "hung | ",
    "idle: value + 0 -> value - 0": "survived | ",
    "idle: 0 -> -1": "killed | test_idle",
    "unused: -value -> value": "unreached | ",
    "SIGXCPU": "hung | ",  # too much processor time, however busy the machine is
    "SIGALRM": "untold | ",
    "SIGKILL": "untold | ",
    "SIGSEGV": "killed | ",
}


def test_what_becomes_of_a_mutant(tmp_path):
    (tmp_path / "tests").mkdir()
    (tmp_path / "tried.py").write_text(TRIED)
    (tmp_path / "tests" / "test_tried.py").write_text(ITS_TESTS)
    command = [sys.executable, "-c", TRY_IT, str(ROOT / "scripts"), str(tmp_path), *BECAME]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert dict(line.split(" | ", 1) for line in done.stdout.splitlines()) == BECAME


def test_every_reason_names_a_mutant_that_exists():
    reasons = mutate.read_reasons()
    assert set(reasons) <= set(mutate.TARGETS)
    for module, whys in reasons.items():
        names = {mutant.name for mutant in mutants.mutants((ROOT / mutate.TARGETS[module].path).read_text())[1]}
        assert set(whys) <= names, sorted(set(whys) - names)
        assert all(len(why) > 20 for why in whys.values())


def test_every_module_and_test_file_of_the_mutation_run_exists():
    for target in mutate.TARGETS.values():
        assert (ROOT / target.path).is_file()
        for name in target.tests:
            assert (ROOT / "tests" / f"{name}.py").is_file(), name
