"""Goldens: pinned by hand only, trusted only as pinned, exact only where they were made."""

from __future__ import annotations

import hashlib
import tomllib
from pathlib import Path

import pytest
from recordings import made_run, record

import bench
from bench.check.golden import pin, verdict
from bench.check.reading import Recording, as_outputs
from bench.check.recording import RecordingError


@pytest.fixture(autouse=True)
def _at_a_desk(monkeypatch):
    monkeypatch.delenv("CI", raising=False)


def run_in(directory: Path, current_ma: int | None = None) -> Recording:
    """The made-up run; with `current_ma`, its last frame reports that current instead of 46 mA."""
    directory.mkdir()
    outputs = made_run(124)
    if current_ma is not None:
        can_id, data = outputs[-1].can_feedback[-1]
        assert (can_id, data[4:6]) == (0x203, b"\x00\x2e")
        changed = (can_id, data[:4] + current_ma.to_bytes(2, "big") + data[6:])
        outputs[-1] = outputs[-1]._replace(can_feedback=(*outputs[-1].can_feedback[:-1], changed))
    return record(directory / "run", outputs)


def pinned_elsewhere(golden: Path, old: str, new: str) -> None:
    """Make golden.toml say that it comes from somewhere else."""
    path = golden / "golden.toml"
    text = path.read_text()
    start = text.index(old)
    end = text.index("\n", start)
    path.write_text(text[:start] + new + text[end:])


def test_a_golden_is_the_run_and_where_it_was_made(tmp_path):
    run = run_in(tmp_path / "a")
    assert pin(run.directory, tmp_path / "deep" / "golden") is None
    golden = tmp_path / "deep" / "golden"
    names = ["can.log", "rc.log", "robot.toml", "run.toml", "slamware.log", "state.csv"]
    assert sorted(path.name for path in golden.iterdir()) == sorted([*names, "golden.toml"])
    for name in names:
        assert (golden / name).read_bytes() == (run.directory / name).read_bytes()
    facts = tomllib.loads((golden / "golden.toml").read_text())
    assert list(facts) == ["schema", "wheelbench", "platform", "pymunk", "sha256"]
    assert facts["schema"] == 1
    assert facts["wheelbench"] == bench.__version__
    assert facts["sha256"] == {name: hashlib.sha256((run.directory / name).read_bytes()).hexdigest() for name in names}


def test_the_same_run_passes_byte_for_byte(tmp_path):
    pin(run_in(tmp_path / "a").directory, tmp_path / "golden")
    found = verdict(run_in(tmp_path / "b"), tmp_path / "golden")
    assert found.identical
    assert found.exact
    assert found.notes == ()


def test_where_it_was_made_one_milliampere_is_a_difference(tmp_path):
    pin(run_in(tmp_path / "a").directory, tmp_path / "golden")
    found = verdict(run_in(tmp_path / "b", current_ma=47), tmp_path / "golden")
    assert found.exact
    assert found.first.text == "at 0.123 s (tick 123) can 0x203: current expected 46 mA, got 47 mA"


@pytest.mark.parametrize("key", ["platform", "pymunk"])
def test_elsewhere_it_is_compared_with_tolerances_and_says_so(tmp_path, key):
    pin(run_in(tmp_path / "a").directory, tmp_path / "golden")
    pinned_elsewhere(tmp_path / "golden", f"{key} = ", f'{key} = "another"')
    tolerated = verdict(run_in(tmp_path / "b", current_ma=48), tmp_path / "golden")
    assert tolerated.ok
    assert not tolerated.exact
    assert not tolerated.identical
    assert tolerated.notes[0].startswith(f"the golden is from {key} another, this is platform ")
    assert tolerated.notes[0].endswith(": compared with tolerances")
    beyond = verdict(run_in(tmp_path / "c", current_ma=49), tmp_path / "golden")
    assert beyond.first.text == "at 0.123 s (tick 123) can 0x203: current expected 46 mA, got 49 mA"


def test_a_plain_recording_is_compared_exactly(tmp_path):
    golden = run_in(tmp_path / "a")
    found = verdict(run_in(tmp_path / "b", current_ma=47), golden.directory)
    assert found.exact
    assert not found.ok


def test_ci_pins_nothing(tmp_path, monkeypatch):
    run = run_in(tmp_path / "a")
    monkeypatch.setenv("CI", "true")
    with pytest.raises(RecordingError, match=r"golden: a golden is not pinned in CI \(the variable CI is set\)"):
        pin(run.directory, tmp_path / "golden")
    assert not (tmp_path / "golden").exists()


def test_pinning_again_tells_what_changes(tmp_path):
    golden = tmp_path / "golden"
    first = run_in(tmp_path / "a")
    (first.directory / "profile.toml").write_text("of the first run")
    pin(first.directory, golden)
    changed = pin(run_in(tmp_path / "b", current_ma=47).directory, golden)
    assert changed.first.text == "at 0.123 s (tick 123) can 0x203: current expected 46 mA, got 47 mA"
    assert not (golden / "profile.toml").exists()
    assert verdict(run_in(tmp_path / "c", current_ma=47), golden).identical


def test_a_run_can_be_pinned_where_it_stands(tmp_path):
    run = run_in(tmp_path / "a")
    outputs = list(as_outputs(run))
    assert pin(run.directory, run.directory) is None
    assert list(as_outputs(Recording.open(run.directory))) == outputs
    assert verdict(run_in(tmp_path / "b"), run.directory).identical


@pytest.mark.parametrize("name", ["can.log", "rc.log", "state.csv", "run.toml", "robot.toml"])
def test_a_golden_that_somebody_edited_is_not_trusted(tmp_path, name):
    golden = tmp_path / "golden"
    run = run_in(tmp_path / "a")
    pin(run.directory, golden)
    text = (golden / name).read_bytes()
    (golden / name).write_bytes(text.replace(b"0", b"1", 1) if b"0" in text else text + b"\n")
    with pytest.raises(RecordingError, match=rf"golden/{name}: is not what was pinned; restore it or pin again"):
        verdict(run, golden)
    pin(run.directory, golden)
    assert verdict(run, golden).identical


def test_a_golden_that_lost_a_file_is_not_trusted(tmp_path):
    run = run_in(tmp_path / "a")
    pin(run.directory, tmp_path / "golden")
    (tmp_path / "golden" / "robot.toml").unlink()
    with pytest.raises(RecordingError, match=r"golden/robot\.toml: is not what was pinned"):
        verdict(run, tmp_path / "golden")


def test_a_file_that_was_put_into_a_golden_is_not_trusted(tmp_path):
    run = run_in(tmp_path / "a")
    pin(run.directory, tmp_path / "golden")
    (tmp_path / "golden" / "profile.toml").write_text("")
    with pytest.raises(RecordingError, match=r"golden/profile\.toml: is not what was pinned"):
        verdict(run, tmp_path / "golden")


def test_line_ends_that_a_checkout_has_turned_do_no_harm(tmp_path):
    run = run_in(tmp_path / "a")
    pin(run.directory, tmp_path / "golden")
    for path in (tmp_path / "golden").iterdir():
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert verdict(run, tmp_path / "golden").identical


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("schema = 2\n", r"schema: expected 1, got 2; pin again"),
        ("schema = 1\n", r"sha256: expected a table of files; restore it or pin again"),
        ("schema\n", r"is not valid TOML \(.*\); restore it or pin again"),
    ],
)
def test_a_damaged_golden_toml_is_named(tmp_path, text, sentence):
    run = run_in(tmp_path / "a")
    pin(run.directory, tmp_path / "golden")
    (tmp_path / "golden" / "golden.toml").write_text(text)
    with pytest.raises(RecordingError, match=r"golden\.toml: " + sentence):
        verdict(run, tmp_path / "golden")


def test_what_must_not_be_pinned_or_pinned_over(tmp_path):
    run, other = run_in(tmp_path / "a"), run_in(tmp_path / "b")
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "thesis.txt").write_text("ten years of work")
    with pytest.raises(RecordingError, match=r"work: holds other files \(thesis\.txt\); give a directory of its own"):
        pin(run.directory, tmp_path / "work")
    with pytest.raises(RecordingError, match=r"run: holds a recording that is no golden; give a directory of its own"):
        pin(run.directory, other.directory)
    path = run.directory / "run.toml"
    path.write_bytes(path.read_bytes().removesuffix(b"ticks = 124\n"))
    with pytest.raises(RecordingError, match="the run was cut short; pin one that came to its end"):
        pin(run.directory, tmp_path / "golden")
    (other.directory / "rc.log").write_text("nonsense\n")
    with pytest.raises(RecordingError, match=r"rc\.log:1: expected"):
        pin(other.directory, tmp_path / "golden")
    assert not (tmp_path / "golden").exists()
