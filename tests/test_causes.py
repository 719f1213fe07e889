"""Why a run differs: the right cause, first, in words with units; nothing where nothing differs."""

from __future__ import annotations

import json
import random
import re
import shutil
import sys
from pathlib import Path

import pytest

from bench.__main__ import main
from bench.check.causes import causes
from bench.check.reading import Recording
from bench.scenarios import run

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import causes_bar
from logs.faults import FAULTS
from logs.frames import Log

ROOT = Path(__file__).parents[1]
SECONDS = 3.2
SEEDS = (3, 7)


@pytest.fixture(scope="module")
def golden(tmp_path_factory):
    return causes_bar.drive("m2006", tmp_path_factory.mktemp("golden") / "m2006", SECONDS)


@pytest.fixture(scope="module")
def log(golden):
    return Log.of(golden.directory, "m2006")


def found(log: Log, golden: Recording, folder: Path):
    log.write(folder / "run")
    return causes(Recording.open(folder / "run"), golden)


@pytest.mark.parametrize("fault", FAULTS)
def test_every_kind_of_fault_is_named_first(fault, golden, log, tmp_path):
    """The whole bar (four robots, 20 seeds) is scripts/causes_bar.py."""
    named = []
    for seed in SEEDS:
        changed = log.copy()
        FAULTS[fault](changed, random.Random(f"{fault} {seed}"))
        named.append(found(changed, golden, tmp_path)[0].kind)
    assert named == [fault] * len(SEEDS)


def between(log: Log, wire: str, first: int, end: int = 10**9):
    return [row for row, (tick, _) in enumerate(log.wires[wire]) if first <= tick < end]


def later(log: Log, *wires: str) -> None:
    for wire in wires:
        log.wires[wire] = [[t + 3 * (t >= 1800), data] for t, data in log.wires[wire] if t < log.ticks - 3]


def swap(log: Log) -> None:
    one, other = log.wires["202"], log.wires["203"]
    for row in between(log, "202", 1800):
        one[row], other[row] = other[row], one[row]


def value(wire: str, name: str, change, first=1800, end=10**9):
    def put(log: Log) -> None:
        for row, old in log.numbers(wire, name):
            if first <= log.wires[wire][row][0] < end:
                log.put(wire, row, name, change(old))

    return put


def lose(log: Log) -> None:
    del log.wires["200"][1800:1840]


def halve(log: Log) -> None:
    log.wires["201"] = [frame for frame in log.wires["201"] if frame[0] < 1800 or frame[0] % 2 == 0]


SENTENCES = {
    "the commands come 3 ms late from 1.800 s on": lambda log: later(log, "200"),
    "the feedback of all ESCs comes 3 ms late from 1.800 s on": lambda log: later(log, "201", "202", "203"),
    "wheel 2 and wheel 3 are swapped in the feedback from 1.800 s on": swap,
    "speed in the feedback of ESC 1 is scaled by 0.9 from 1.800 s on": value(
        "201", "speed", lambda old: round(0.9 * old)
    ),
    "the current of ESC 1 in the commands has the opposite sign from 1.800 s on": value(
        "200", "slot1", lambda old: -old
    ),
    "angle in the feedback of ESC 3 is offset by +40 counts from 1.800 s on": value(
        "203", "angle", lambda old: (old + 40) % 8192
    ),
    "the commands are dropped: 40 frames of the golden missing from 1.800 s to 1.839 s": lose,
    "the feedback of ESC 1 comes every 2 ms instead of every 1 ms from 1.801 s on": halve,
    "speed in the feedback of ESC 1 is quantised to steps of 64 rpm from 1.800 s to 2.799 s": value(
        "201", "speed", lambda old: old // 64 * 64, end=2800
    ),
    "RC channel 0 is offset by -9 counts from 1.800 s on": value("rc>", "ch0", lambda old: old - 9),
    "vx in the SLAMWARE requests has the opposite sign from 1.800 s on": value("slamware>", "vx", lambda old: -old),
}


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_sentence_says_wheel_wire_unit_and_time(sentence, golden, log, tmp_path):
    changed = log.copy()
    SENTENCES[sentence](changed)
    first = found(changed, golden, tmp_path)[0]
    assert first.text == sentence
    assert first.is_sure


def pushed(folder: Path, *sticks: float) -> Recording:
    """The stick forward by so much, half a second each."""
    steps = [{"at_s": 0.3 + 0.5 * number, "forward": forward} for number, forward in enumerate(sticks)]
    run(name="stick", seconds=0.3 + 0.5 * len(sticks), stick=[{"at_s": 0.1, "aux1": True}, *steps], record=folder)
    return Recording.open(folder)


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        # uart12: 2048 - 2048 * 0.40 = 1228.8, 2048 - 2048 * 0.41 = 1208.3 (document 004)
        ((0.40,), (0.41,), "is offset by -21 counts from 0.300 s on"),
        ((0.40, 0.0), (0.41, 0.0), "is offset by -21 counts from 0.300 s to 0.790 s"),
        ((0.40, -0.40), (0.41, -0.41), "is offset by -21 counts from 0.300 s to 0.699 s"),
        ((0.40,), (-0.40,), "is reversed around 2048 counts from 0.300 s on"),
        ((0.40, 0.0), (-0.40, 0.0), "is reversed around 2048 counts from 0.300 s to 0.790 s"),
        ((0.40, -0.30), (-0.40, 0.30), "is reversed around 2048 counts from 0.300 s on"),
    ],
)
def test_a_stick_is_reversed_only_around_its_middle(before, after, says, tmp_path):
    first = causes(pushed(tmp_path / "run", *after), pushed(tmp_path / "golden", *before))[0]
    assert first.text == f"RC channel 2 {says}"


def test_nothing_differs_nothing_is_named(golden, log, tmp_path):
    assert found(log.copy(), golden, tmp_path) == []


def test_a_shorter_run_that_is_the_same_until_then(golden, tmp_path):
    shorter = causes_bar.drive("m2006", tmp_path / "shorter", 1.0)
    [cause] = causes(shorter, golden)
    assert cause.text == "the run ends 2.200 s earlier than the golden; until then they are the same"


def test_the_report_is_short_and_shows_frame_and_traces(golden, log, tmp_path, capsys):
    changed = log.copy()
    SENTENCES["speed in the feedback of ESC 1 is scaled by 0.9 from 1.800 s on"](changed)
    changed.write(tmp_path / "run")
    assert main(["check", str(tmp_path / "run"), str(golden.directory)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 40
    assert lines[0].startswith("differs: speed in the feedback of ESC 1 is scaled by 0.9 from 1.800 s on (explains ")
    assert lines[1].startswith("first: at 1.800 s (tick 1800) can 0x201: speed expected ")
    speed = next(line for line in lines if line.startswith("  speed  "))
    _, before, _, after, *_ = speed.split()
    assert int(after) == round(0.9 * int(before))
    assert speed.endswith("  <")
    assert sum(any(0x2800 < ord(character) < 0x2900 for character in line) for line in lines) >= 2
    assert any(line.strip() == "^ 1.800 s" for line in lines)


def test_the_report_for_machines(golden, log, tmp_path, capsys):
    changed = log.copy()
    swap(changed)
    changed.write(tmp_path / "run")
    assert main(["check", str(tmp_path / "run"), str(golden.directory), "--json"]) == 1
    said = json.loads(capsys.readouterr().out)
    lead = said["causes"][0]
    assert (lead["kind"], lead["wires"], lead["first_tick"], lead["last_tick"]) == (
        "swapped",
        ["can 0x202", "can 0x203"],
        1800,
        None,
    )
    assert said["first"]["wire"] == "can 0x202"
    assert {cell["field"] for cell in said["frame"]} == {"angle", "speed", "current"}
    assert len(said["waveform"]["golden"]) == len(said["waveform"]["run"])
    assert main(["check", str(golden.directory), str(golden.directory), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["causes"] == []


def test_the_page_shows_what_is_said(tmp_path, capsys):
    """docs/goldens.md: its commands are run by test_docs; this is what the last of them prints."""
    pinned = ROOT / "fixtures" / "pinned" / "demo"
    shutil.copytree(pinned, tmp_path / "crossed")
    (tmp_path / "crossed" / "golden.toml").unlink()
    shutil.copytree(tmp_path / "crossed", tmp_path / "walk")
    log = tmp_path / "crossed" / "can.log"
    plugs = {b" 202#": b" 203#", b" 203#": b" 202#"}
    lines = log.read_bytes().splitlines(keepends=True)
    moved = [
        re.sub(rb" 20[23]#", lambda found: plugs[found[0]], line) if _tick(line) >= 4000 else line for line in lines
    ]
    log.write_bytes(b"".join(moved))
    assert main(["check", str(tmp_path / "crossed"), str(tmp_path / "walk")]) == 1
    shown = (ROOT / "docs" / "goldens.md").read_text(encoding="utf-8").split("```text\n")[1].split("```")[0]
    compared, _, checked = capsys.readouterr().out.partition("checks    ")
    assert compared == shown
    assert "wheel 2 turned +12.36 rad and counted -9.32, wheel 3 turned -9.32 rad and counted +12.36" in checked


def _tick(line: bytes) -> int:
    return round(float(line[1 : line.index(b")")]) * 1000)
