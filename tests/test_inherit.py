"""`extends`: what many scenarios share stands once, errors name the file that said it, and nothing goes in a circle."""

import shutil
import tomllib
from pathlib import Path

import pytest

from bench import demo
from bench.__main__ import main
from bench.check.scenario import load_scenario

BASE = """
name = "base"
about = "what they share"
seconds = 1.0
seed = 4

[[stick]]
at_s = 0.1
aux1 = true
[[stick]]
at_s = 0.2
forward = 0.5

[[fault]]
name = "jam"
wire = "rc"
kind = "drop"
at_s = 0.5
for_s = 0.1

[[expect]]
name = "it drives"
eventually = "vx_mps > 0.1"
[[expect]]
name = "it arms"
eventually = "armed"
"""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Writes files by path; the current folder."""
    monkeypatch.chdir(tmp_path)

    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name.replace('__', '/')}.toml"
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        return tmp_path

    return write


def test_an_heir_has_what_its_base_says_and_what_it_says_itself(files):
    files(
        base=BASE,
        heir='name = "heir"\nextends = "base.toml"\nseconds = 0.8\n[[fault]]\nwire = "rc"\nkind = "stall"\nat_s = 0.7',
    )
    heir, base = load_scenario(Path("heir.toml")), load_scenario(Path("base.toml"))
    assert (heir.name, heir.about, heir.ticks, heir.seed) == ("heir", "", 800, 4)
    assert heir.sticks == base.sticks
    assert heir.expectations == base.expectations
    assert [fault.name for fault in heir.faults] == ["jam", "rc stall"]


def test_a_name_of_the_base_is_replaced_and_a_driver_replaces_a_driver(files):
    for name in ("drive.bin", "drive.json"):
        shutil.copy(demo.SCENARIO.parent / name, files() / name)
    files(
        base=BASE,
        heir="""
name = "heir"
extends = "base.toml"
rc = "drive.bin"
[[expect]]
name = "it drives"
always = "vx_mps < 5"
""",
        sticks='name = "sticks"\nextends = "heir.toml"\n[[stick]]\nat_s = 0.4\nturn = 1',
    )
    heir = load_scenario(Path("heir.toml"))
    assert heir.sticks == ()
    assert heir.rc == Path("drive.bin")
    assert [(one.name, one.always) for one in heir.expectations] == [("it arms", ""), ("it drives", "vx_mps < 5")]
    sticks = load_scenario(Path("sticks.toml"))
    assert sticks.rc is None
    assert [tick for tick, _ in sticks.sticks] == [400]


def test_files_that_a_base_names_lie_beside_the_base(files, capsys):
    folder = files(
        shared__base=BASE.replace("[[stick]]", "x = 1\n[[stick]]", 1).replace(
            "x = 1", 'arena = "hall.toml"\nrobot = "mine.toml"\nprofile = "stick.toml"', 1
        ),
        shared__hall='name = "hall"\nlength_m = 5.0',
        cases__heir='name = "heir"\nextends = "../shared/base.toml"',
    )
    shutil.copy(Path(demo.__file__).parents[1] / "robots" / "m2006.toml", folder / "shared" / "mine.toml")
    shutil.copy(Path(demo.__file__).parents[1] / "profiles" / "uart12.toml", folder / "shared" / "stick.toml")
    assert main(["replay", "cases/heir.toml", "--record", "run"]) == 0
    kept = tomllib.loads(Path("run/scenario.toml").read_text())
    assert "extends" not in kept
    assert [fault["name"] for fault in kept["fault"]] == ["jam"]
    shutil.rmtree("shared")
    capsys.readouterr()
    assert main(["replay", "run"]) == 0, "the recording holds the whole of it"
    assert "golden    identical" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("texts", "says"),
    [
        ({"a": 'extends = "a.toml"'}, "a.toml: extends: goes round in a circle: a.toml -> a.toml"),
        (
            {"a": 'extends = "b.toml"', "b": 'extends = "sub/../c.toml"', "c": 'extends = "a.toml"', "sub__x": ""},
            "c.toml: extends: goes round in a circle: a.toml -> b.toml -> sub/../c.toml -> sub/../a.toml",
        ),
        ({"a": 'extends = "none.toml"'}, "a.toml: extends: there is no scenario none.toml"),
        ({"a": "extends = 3"}, "a.toml: extends: expected the name of a scenario file, got 3"),
        ({"a": 'extends = "sub"', "sub__x": ""}, "a.toml: extends: there is no scenario sub"),
        ({"a": 'extends = "b.toml"', "b": "x ="}, "b.toml: is not valid TOML"),
        ({"a": 'extends = "b.toml"', "b": BASE}, "a.toml: name: is missing"),
        ({"a": 'name = "a"\nextends = "b.toml"', "b": "secnds = 1"}, "a.toml: seconds: is missing; is secnds meant"),
        ({"a": 'name = "a"\nextends = "b.toml"', "b": "seconds = -1"}, "b.toml: seconds: expected 0.001 to 86400"),
        (
            {
                "a": 'name = "a"\nextends = "b.toml"\n[[fault]]\nwire = "rx"\nkind = "drop"\nat_s = 0',
                "b": BASE.replace('"jam"', '"jam"\nfro_s = 1'),
            },
            "b.toml: fault[0].fro_s: unknown key; did you mean for_s?",
        ),
        (
            {"a": 'name = "a"\nextends = "b.toml"\n[[fault]]\nwire = "rx"\nkind = "drop"\nat_s = 0', "b": BASE},
            "a.toml: fault[0].wire: 'rx' is unknown; known: rc, core",
        ),
        ({"a": 'name = "a"\nextends = "b.toml"', "b": BASE + "[[expcet]]"}, "b.toml: expcet: unknown key"),
        ({"a": 'name = "a"\nextends = "b.toml"\nfault = 3', "b": BASE}, "a.toml: fault: expected at least one"),
    ],
)
def test_what_cannot_be_is_said_with_the_file_that_says_it(files, capsys, texts, says):
    files(**texts)
    assert main(["replay", "a.toml"]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
