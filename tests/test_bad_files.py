"""Files as people and accidents make them: whatever stands in one, there is an answer or one sentence."""

import contextlib
import io
import os
import shutil
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.__main__ import main
from bench.config import PROFILES_DIR, ROBOTS_DIR
from bench.errors import UsageError
from bench.scenarios import run

SCENARIO = """schema = 1
name = "all"
robot = "m2006"
seconds = 0.02
seed = 3
[noise]
loss = 0.01
[arena]
length_m = 5.0
[[stick]]
at_s = 0.01
aux1 = true
[[core]]
at_s = 0.01
vx_mps = 0.25
[[fault]]
wire = "rc"
kind = "delay"
ms = 4
at_s = 0.005
for_s = 0.01
[[fault]]
wire = "plant"
kind = "push"
force_n = 2.0
bearing_deg = 30.0
when = "speed_mps >= 0"
[[expect]]
always = "speed_mps < 0.25"
[[expect]]
when = "link == 'lost'"
then = "speed_mps < 0.05"
within_s = 0.5
for_s = 0.01
vacuous = "allowed"
"""
ARENA = """name = "course"
length_m = 6.0
[start]
x_m = 0.5
[[wall]]
x1_m = 1.0
y1_m = -1.0
x2_m = 1.0
y2_m = 1.0
[[disc]]
name = "ball"
x_m = -1.0
y_m = 0.0
radius_m = 0.1
mass_kg = 0.2
[[patch]]
name = "ice"
x_m = 1.5
y_m = 0.0
radius_m = 0.4
grip = 0.1
rolling = 0.01
"""
TEXTS = {
    "scenario": [SCENARIO],
    "arena": [ARENA],
    "robot": [path.read_text() for path in sorted(ROBOTS_DIR.glob("*.toml"))],
    "profile": [path.read_text() for path in sorted(PROFILES_DIR.glob("*.toml"))],
}
VALUES = [
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "0", "-1", "-0.0", "9" * 23, "0x7fffffffffffffff", "true", "[]",
    "{}", "[1, 2]", "{a = 1}", "1979-05-27", "12:30:00", '""', '"x"', '"é\U0001f916"', '"\\u0000"', '"../.."', '"/"',
    '"/dev/zero"', '"abs("', '"1 +"', f'"{"(" * 500}"', '"m2006"', "3.5", "8", "[[[[", "",
]  # fmt: skip


@st.composite
def spoilt(draw, kind):
    """A good file with one to three things done to it."""
    lines = draw(st.sampled_from(TEXTS[kind])).splitlines()
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        line = lines[at]
        match draw(st.sampled_from(["value", "value", "value", "gone", "twice", "moved", "typed", "backwards"])):
            case "value" if "=" in line:
                lines[at] = f"{line.partition('=')[0]}= {draw(st.sampled_from(VALUES) | st.text(max_size=5))}"
            case "gone" if len(lines) > 1:
                del lines[at]
            case "twice":
                lines.insert(draw(st.integers(0, len(lines))), line)
            case "moved":
                lines[at], lines[0] = lines[0], line
            case "typed":
                to = draw(st.integers(0, len(line)))
                lines[at] = line[:to] + draw(st.sampled_from("=[]{}\"'#\x00\t.é\u202e")) + line[to:]
            case _:
                lines[at] = line[::-1]
    return "\n".join(lines).encode("utf-8", "replace")


def answered(*arguments):
    """Run a command; what it said to stderr. It must end as commands end, with at most one line there."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([str(argument) for argument in arguments])
    assert status in (0, 1, 2, 3)
    assert err.getvalue().count("\n") == (status in (2, 3)), err.getvalue()
    return err.getvalue()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("bad")
    (place / "good.toml").write_text(SCENARIO)
    return place


@pytest.mark.parametrize("kind", TEXTS)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_spoilt_file_has_an_answer(folder, kind, data):
    path = folder / f"{kind}.toml"
    path.write_bytes(data.draw(spoilt(kind)))
    if kind == "scenario":
        answered("replay", path)
    else:
        answered("replay", folder / "good.toml", f"--{kind}", path)


@pytest.fixture(scope="module")
def golden(folder):
    run(record=folder / "golden", seconds=0.1, stick=[{"at_s": 0.01, "aux1": True}])
    shutil.copytree(folder / "golden", folder / "run")
    return folder / "golden"


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_spoilt_recording_has_an_answer(folder, golden, data):
    name = data.draw(st.sampled_from(sorted(os.listdir(golden))))
    kept = (golden / name).read_bytes()
    changed = bytearray(kept)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(changed)))
        changed[at : at + data.draw(st.integers(0, 40))] = data.draw(st.binary(max_size=6) | st.just(b"\n9"))
    try:
        (golden / name).write_bytes(changed)
        answered("check", folder / "run", golden)
        answered("replay", golden)
    finally:
        (golden / name).write_bytes(kept)


def test_what_is_no_file_to_read_is_said(folder, monkeypatch):
    monkeypatch.chdir(folder)
    Path("loop.toml").symlink_to("loop.toml")
    Path("folder.toml").mkdir()
    Path("bytes.toml").write_bytes(b"\xff\xfe\x00")
    Path("deep.toml").write_text("a = " + "[" * 5000)
    Path("empty.toml").write_text("")
    for name, says in {
        "loop.toml": "cannot be read (Too many levels of symbolic links)",
        "bytes.toml": "is not a text file; a TOML file is expected",
        "deep.toml": "is not valid TOML: brackets within brackets without end",
        "none.toml": "there is no such file; check its name and its folder",
    }.items():
        assert says in answered("replay", name), name
        for option in ("--robot", "--profile", "--arena"):
            assert says in answered("replay", "good.toml", option, name), (name, option)
    assert "is a directory without a recording" in answered("replay", "folder.toml")
    assert "folder.toml: is a directory; a robot is a .toml file" in answered(
        "replay", "good.toml", "--robot", "folder.toml"
    )
    assert "folder.toml: cannot be read (Is a directory); check the path" in answered(
        "replay", "good.toml", "--arena", "folder.toml"
    )
    assert "seconds: is missing" in answered("replay", "empty.toml")
    if Path("/dev/zero").exists():
        for arguments in (["/dev/zero"], ["good.toml", "--robot", "/dev/zero"], ["good.toml", "--arena", "/dev/zero"]):
            assert "/dev/zero: cannot be read (it is a device and no file)" in answered("replay", *arguments)
    if os.geteuid():
        Path("locked.toml").write_text(SCENARIO)
        Path("locked.toml").chmod(0)
        assert "locked.toml: cannot be read (Permission denied)" in answered("replay", "locked.toml")


def test_a_mark_of_byte_order_before_a_file_does_no_harm(folder):
    (folder / "marked.toml").write_bytes(b"\xef\xbb\xbf" + SCENARIO.encode())
    assert answered("replay", folder / "marked.toml") == ""


def test_a_recording_is_not_written_over_while_it_is_run_again(folder, golden):
    """Held against another one, too."""
    run = folder / "run again"
    assert main(["replay", str(golden), "--record", str(run)]) == 0
    before = (run / "can.log").read_bytes()
    told = answered("replay", run, "--golden", golden, "--record", folder / "." / "run again", "--overwrite")
    assert f"--record {run}: is the recording that is run again; record in another directory" in told
    assert (run / "can.log").read_bytes() == before


def test_a_recording_is_not_written_over_what_it_is_held_against(folder, golden):
    before = {path.name: path.read_bytes() for path in golden.iterdir()}
    for arguments in ([golden], [folder / "good.toml", "--golden", golden]):
        said = answered("replay", *arguments, "--record", golden, "--overwrite")
        assert f"--record {golden}: is what the run is held against; record in another directory" in said
    assert {path.name: path.read_bytes() for path in golden.iterdir()} == before


@pytest.mark.parametrize(
    ("condition", "says"),
    [
        ("speed_mps < 'fast'", "a text is compared with ==, != or in; got 'fast'"),
        ("vx_mps == 'lost'", "only link and driver are texts, so nothing else equals one; got vx_mps"),
        ("not " * 5000 + "armed", "expected a condition of at most 1000 characters"),
        ("armed \ud800", "half a character of UTF-16"),
        ("vx_mps > 10**9", "expected a signal, a number"),
    ],
)
def test_a_condition_that_means_nothing_is_one_sentence(condition, says):
    with pytest.raises(UsageError) as caught:
        run(seconds=0.01, expect=[{"always": condition}])
    assert says in str(caught.value)
