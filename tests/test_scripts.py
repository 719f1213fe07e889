"""Every command in scripts/ says what it is, and refuses wrong arguments in a sentence."""

import ast
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("cantools", reason="the benchmark needs cantools (the dev extra)")
ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "scripts"
COMMANDS = sorted(path.name for path in SCRIPTS.glob("*.py") if path.name != "arguments.py")
sys.path.insert(0, str(SCRIPTS))


@pytest.fixture
def ended(monkeypatch, capsys):
    """Runs a command with arguments: its exit status, what it printed, what it complained of."""

    def run(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        with pytest.raises(SystemExit) as end:
            runpy.run_path(str(SCRIPTS / name), run_name="__main__")
        out, err = capsys.readouterr()
        return end.value.code, out, err

    return run


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_says_what_it_is(name, ended):
    doc = ast.get_docstring(ast.parse((SCRIPTS / name).read_text()))
    assert doc
    status, out, err = ended(name, "--help")
    assert (status, err) == (0, "")
    assert f"usage: {name}" in out
    assert doc.splitlines()[0] in " ".join(out.split())


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_is_dead(name):
    """Whoever looks for it finds it: a page, the Makefile, or a file of the bench names it."""
    readers = [ROOT / "Makefile", ROOT / "README.md", *(ROOT / "docs").glob("*.md"), ROOT / "bench/demo/demo.toml"]
    readers += (SCRIPTS / "benchmarks").glob("*.py")
    assert any(name in reader.read_text() for reader in readers)


@pytest.mark.parametrize("path", sorted(SCRIPTS.rglob("*.py")), ids=lambda path: str(path.relative_to(SCRIPTS)))
def test_every_file_named_in_a_docstring_is_there(path):
    doc = ast.get_docstring(ast.parse(path.read_text()))
    assert doc
    words = [word.strip("`(),.:;") for word in doc.split()]
    for one in (word for word in words if word.endswith((".py", ".toml")) and "/" in word):
        assert (ROOT / one).exists() or (SCRIPTS / one).exists(), one


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("benchmark.py --only nothing", "invalid choice: 'nothing' (choose from"),
        ("benchmark.py --rounds 0", "argument --rounds: expected a whole number, 1 or more, got 0"),
        ("causes_bar.py --seeds none", "argument --seeds: expected a whole number, 1 or more, got none"),
        ("causes_bar.py --robot m2007", "m2006"),
        ("compare_logs.py wheelbench nowhere nowhere", "argument RUN: there is no file or folder nowhere"),
        ("compare_logs.py", "required: JOB"),
        ("compiled.py --robots m2007", "argument --robots: m2007 is not among "),
        ("compiled.py --rounds 0", "argument --rounds: expected a whole number, 1 or more, got 0"),
        ("failsafe_bar.py --only me", "argument --only: me is not among ours, "),
        ("failsafe_bar.py --jobs -1", "argument --jobs: expected a whole number, 1 or more, got -1"),
        ("fuzz.py --only ,", "argument --only: nothing is not among sbus, "),
        ("fuzz.py --replay nowhere", "argument --replay: there is no file or folder nowhere"),
        ("fuzz.py --replay Makefile", "the name of a finding begins with its target"),
        ("make_demo.py now", "unrecognized arguments: now"),
        ("mutate.py --only morse", "argument --only: morse is not among "),
        ("mutate.py --jobs 0", "argument --jobs: expected a whole number, 1 or more, got 0"),
        ("noise.py --mb 0", "argument --mb: expected a number above 0, got 0"),
        ("noise.py --mb much", "argument --mb: expected a number above 0, got much"),
        ("peers.py --frames 0", "argument --frames: expected a whole number, 1 or more, got 0"),
        ("pictures.py here", "unrecognized arguments: here"),
        ("plant_checks.py --only speed", "invalid choice: 'speed' (choose from"),
        ("screenshots.py Makefile", "Makefile is a file; name a folder"),
        ("scripted_replay.py", "required: directory"),
        ("scripted_replay.py Makefile", "Makefile"),
        ("simulators.py --seconds nan", "argument --seconds: expected a number above 0, got nan"),
        ("simulators.py --seconds 1e3", "the demo is over after"),
        ("slcan_bar.py --rounds 0", "argument --rounds: expected a whole number, 1 or more, got 0"),
        ("tune.py m2007", "m2006"),
        ("validate.py --only r2d2", "argument --only: r2d2 is not among m2006, "),
    ],
)
def test_a_wrong_argument_is_refused_in_a_sentence(arguments, words, ended, monkeypatch):
    monkeypatch.chdir(ROOT)
    name, *rest = arguments.split()
    status, out, err = ended(name, *rest)
    *usage, sentence = err.splitlines()
    assert (status, out) == (2, "")
    assert sentence.startswith((f"{name}: error: ", f"{name} wheelbench: error: "))
    assert words in sentence
    assert all(line.startswith(("usage: ", " ")) for line in usage)


def test_a_command_starts_with_nothing_of_the_bench_loaded():
    """mutate.py puts changed modules in its place; a bench that is there already would hide them."""
    script = "import sys, arguments; arguments.end_with(lambda: sum(name.startswith('bench') for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", script], cwd=SCRIPTS, check=False).returncode == 0


def test_what_is_to_be_compiled_is_there_and_what_a_tick_imports():
    import compiled

    assert [name for name in compiled.CORE if not (ROOT / "bench" / f"{name}.py").exists()] == []
    ground = {f"ground/{path.stem}" for path in (ROOT / "bench/ground").glob("[!_]*.py")}
    assert ground <= set(compiled.CORE)


def test_what_cannot_be_compiled_is_told_in_the_compilers_words(tmp_path, monkeypatch):
    import compiled

    from bench.errors import SurroundingsError

    monkeypatch.setattr(compiled, "CORE", ("nothing_of_this_name",))
    with pytest.raises(SurroundingsError, match="could not compile the core") as refused:
        compiled.compiled_copy(tmp_path / "copy")
    assert "nothing_of_this_name" in str(refused.value)
