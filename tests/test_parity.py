"""Several bases that hear the same: what is late is told as time, what is rounded as value, and nothing else."""

import json
import random
import shutil
from collections import deque
from functools import cache
from pathlib import Path

import pytest
from compilers import needs_compiler

from bench.base import Base
from bench.check.inputs import other_inputs
from bench.check.parity import parity
from bench.check.reading import Recording
from bench.check.scenario import load_scenario
from bench.check.sources import from_recording, from_scenario
from bench.check.worlds import worlds_of
from bench.errors import BenchError, UsageError
from bench.m2006 import decode_command, encode_command
from bench.motors import family

ROOT = Path(__file__).parents[1]

DRIVE = """schema = 1
name = "drive"
robot = "m2006"
seconds = 2.0
[[stick]]
at_s = 0.2
aux1 = true
[[stick]]
at_s = 0.4
forward = 0.5
[[stick]]
at_s = 1.2
left = 0.4
turn = 0.3
[[core]]
at_s = 0.1
vx_mps = 0.2
"""


class Changed:
    """Ours, with every command frame through `change` and all of them `late_ticks` later."""

    def __init__(self, robot, change=lambda raws: raws, late_ticks=0, late_answers=0):
        self.base, self.change = Base(robot), change
        self.commands, self.answers = deque([()] * late_ticks), deque([b""] * late_answers)

    def step(self, tick, rc, slamware, can):
        commands, answer = self.base.step(tick, rc, slamware, can)
        frames = [(can_id, self.change(decode_command(data))) for can_id, data in commands]
        self.commands.append(tuple((can_id, encode_command(raws)) for can_id, raws in frames if raws is not None))
        self.answers.append(answer)
        return self.commands.popleft(), self.answers.popleft()


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A drive of our own base, recorded: what every peer hears."""
    folder = tmp_path_factory.mktemp("parity")
    (folder / "drive.toml").write_text(DRIVE)
    job = from_scenario(folder / "drive.toml")
    with job.recorder(folder / "run") as recorder:
        outs = list(job)
        recorder.extend(outs)
    return folder / "run", outs


def beside(driven, base=None, **changes):
    """What parity finds of ours with these changes."""
    run, ours = driven
    theirs = from_recording(run, recorded_can=True)
    theirs.bench.base = (base or Changed)(theirs.bench.robot, **changes)
    return parity(ours, list(theirs), family(theirs.bench.robot))


def kinds(found):
    return [(one.is_time, one.kind, one.amount) for one in found.findings]


def rounded(raws):
    """Half of all values another count: what truncation makes of a rounded one."""
    return tuple(raw - (raw > 0 and raw % 2) + (raw < 0 and raw % 2) for raw in raws)


def test_the_same_base_is_the_same(driven):
    found = beside(driven)
    assert found.is_same
    assert found.findings == ()


def test_a_delay_and_a_rounding_are_both_named_and_nothing_else(driven):
    """The issue's peer: 3 ms late, and a count off where it rounds otherwise."""
    found = beside(driven, change=rounded, late_ticks=3)
    assert kinds(found) == [(True, "late", 3), (False, "rounding", 1.0)]
    assert found.findings[0].text == "commands 0x200 come 3 ms late, all alike"
    assert found.findings[1].fields == ("current_1_ma", "current_2_ma", "current_3_ma")
    assert (found.first.tick, found.first.wire, found.first.peer) == (0, "can 0x200", "nothing")


@pytest.mark.parametrize("late", [1, 2, 20, 150])
def test_time_alone(driven, late):
    assert kinds(beside(driven, late_ticks=late)) == [(True, "late", late)]


@pytest.mark.parametrize(
    ("change", "kind", "amount"),
    [
        (rounded, "rounding", 1.0),
        (lambda raws: tuple(raw + 7 for raw in raws), "offset", 7),
        (lambda raws: tuple(round(0.9 * raw) for raw in raws), "scale", 0.9),
        (lambda raws: (raws[1], raws[0], *raws[2:]), "other", None),
    ],
)
def test_value_alone(driven, change, kind, amount):
    found = beside(driven, change=change)
    assert {(one.is_time, one.kind) for one in found.findings} == {(False, kind)}
    if amount is not None:
        assert [one.amount for one in found.findings] == [pytest.approx(amount, rel=1e-3)]
    assert found.first.tick > 0 or kind == "offset"


def test_the_first_divergence_is_the_first_byte_that_differs(driven):
    """In the 900th frame, one count of one motor."""
    count = iter(range(1 << 30))
    found = beside(driven, change=lambda raws: (raws[0], raws[1] + (next(count) == 900), *raws[2:]))
    first = found.first
    assert (first.tick, first.wire, first.field) == (900, "can 0x200", "current 2")
    assert int(first.peer.split()[0]) == int(first.reference.split()[0]) + 1
    assert kinds(found) == [(False, "rounding", 1.0)]
    assert "in 1 of 2000 frames, first at 0.900 s" in found.findings[0].text


def test_frames_that_never_come_are_time_and_no_wrong_value(driven):
    random_ = random.Random(5)
    found = beside(driven, change=lambda raws: None if random_.random() < 0.1 else raws, late_ticks=2)
    assert [(one.kind, one.is_time) for one in found.findings] == [("late", True), ("missing", True)]
    assert found.findings[1].amount == pytest.approx(200, abs=50)


def test_a_delay_that_changes_is_said_to(driven):
    """2 ms at first, 6 ms from the middle of the drive on."""

    class Slower(Changed):
        def step(self, tick, *wires):
            if tick == 1000:
                self.commands.extendleft([()] * 4)
            return super().step(tick, *wires)

    found = beside(driven, Slower, late_ticks=2)
    assert found.findings[0].kind == "varies"
    assert "come 2 to 6 ms late" in found.findings[0].text


def test_late_answers_are_told_apart_from_commands(driven):
    found = beside(driven, late_answers=4)
    assert [(one.wire, one.kind, one.amount) for one in found.findings] == [("answers", "late", 4)]


class Losing(Changed):
    """Ours, without its 20th answer, and perhaps with all answers in pieces of five bytes a millisecond."""

    def __init__(self, robot, pieces):
        super().__init__(robot)
        self.count, self.size, self.rest = 0, 5 if pieces else 1000, b""

    def step(self, *wires):
        commands, answer = super().step(*wires)
        self.count += bool(answer)
        if self.count != 20:
            self.rest += answer
        answer, self.rest = self.rest[: self.size], self.rest[self.size :]
        return commands, answer


@pytest.mark.parametrize("pieces", [False, True])
def test_an_answer_that_never_comes_shifts_no_other(driven, pieces):
    found = beside(driven, Losing, pieces=pieces)
    late = [one for one in found.findings if one.kind != "missing"]
    assert [one.text for one in found.findings if one.kind == "missing"] == ["answers: 1 never comes"]
    assert all(one.is_time for one in found.findings), "no answer is held against its neighbour's"
    assert bool(late) == pieces, "a long answer is whole some milliseconds later"
    assert all(0 < one.amount < 10 for one in late)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("m2006", "dm3519"), "was made with another robot \\(m2006\\) .*; give --robot, or record"),
        (('"m2006"', '"m2006"\nprofile = "futaba-sbus2"'), "was made with another profile \\(uart12\\) .*; record"),
        (('"drive"', '"walk"'), "is a recording of the scenario 'drive', not of 'walk'"),
        (("2.0", "2.5"), "holds 2 s and the scenario lasts 2.5 s"),
        ((DRIVE, ""), "is missing"),
    ],
)
def test_a_recording_of_another_run_is_no_world(driven, tmp_path, change, words):
    """It would be held against itself, and be found the same."""
    (tmp_path / "other.toml").write_text(DRIVE.replace(*change))
    with pytest.raises(BenchError, match=words):
        list(worlds_of(tmp_path / "other.toml", ["sim", str(driven[0])]))


FAULT = '[[fault]]\nwire = "{}"\nkind = "drop"\nat_s = 1.0\nfor_s = 0.1\n'
WIRES = "[wires]\n"


@pytest.fixture(scope="module")
def recorded(driven, tmp_path_factory):
    """The recording of a scenario's text, made once."""

    @cache
    def record(text):
        if text == DRIVE:
            return driven[0]
        folder = tmp_path_factory.mktemp("recorded")
        (folder / "drive.toml").write_text(text)
        job = from_scenario(folder / "drive.toml")
        with job.recorder(folder / "run") as recorder:
            recorder.extend(list(job))
        return folder / "run"

    return record


@pytest.mark.parametrize(
    ("before", "change", "words"),
    [
        (DRIVE, ("forward = 0.5", "forward = 0.6"), "other RC bytes from 0.4[0-9]* s on"),
        (DRIVE, ("at_s = 1.2", "at_s = 1.3"), "other RC bytes from 1.2[0-9]* s on"),
        (DRIVE, ("vx_mps = 0.2", "vx_mps = 0.3"), "other velocities from the core from 0.1[0-9]* s on"),
        (DRIVE, (DRIVE[-30:], DRIVE[-30:] + "[noise]\nloss = 0.01\n"), "other noise"),
        (DRIVE, (DRIVE[-30:], DRIVE[-30:] + WIRES), "other wires"),
        (DRIVE, (DRIVE[-30:], DRIVE[-30:] + "[arena]\nlength_m = 3.0\n"), "another arena"),
        (DRIVE, (DRIVE[-30:], DRIVE[-30:] + FAULT.format("rc")), "other faults"),
        (DRIVE + FAULT.format("rc"), ("at_s = 1.0", "at_s = 1.1"), "other faults"),
        (DRIVE + FAULT.format("rc"), ("schema = 1", "schema = 1\nseed = 2"), "another seed"),
        (DRIVE + FAULT.format("rc"), ("left = 0.4", "left = 0.5"), "other sticks"),
        (DRIVE + FAULT.format("core"), ("vx_mps = 0.2", "vx_mps = 0.3"), "another core"),
        (DRIVE + WIRES, ("forward = 0.5", "forward = 0.6"), "other RC bytes from 0.4[0-9]* s on"),
        (DRIVE + WIRES, ("vx_mps = 0.2", "vx_mps = 0.3"), "other velocities from the core from 0.1[0-9]* s on"),
    ],
)
def test_a_recording_of_a_scenario_that_was_edited_is_no_world(recorded, tmp_path, before, change, words):
    """Under its old name, and as long as it was: what the recording says was said to something else."""
    drive, run = tmp_path / "drive.toml", recorded(before)
    drive.write_text(before.replace(*change))
    assert drive.read_text() != before
    with pytest.raises(UsageError, match=f"{run}: was made with {words} than .*drive.toml says now; record"):
        list(worlds_of(drive, ["sim", str(run)]))


@pytest.mark.parametrize("before", [DRIVE, DRIVE + FAULT.format("rc"), DRIVE + FAULT.format("core"), DRIVE + WIRES])
def test_what_judges_a_run_is_no_input_of_it(recorded, tmp_path, before):
    drive, run = tmp_path / "drive.toml", recorded(before)
    drive.write_text(f'{before}[[expect]]\nalways = "speed_mps < 9.0"\n# read again\n')
    assert other_inputs(Recording.open(run), load_scenario(drive), from_scenario(drive)) == ""


def test_a_recording_of_a_base_that_is_late_is_of_the_same_scenario(driven, tmp_path):
    """Its core asks later, because it is answered later."""
    drive = tmp_path / "drive.toml"
    drive.write_text(DRIVE)
    job = from_scenario(drive)
    job.bench.base = Changed(job.bench.robot, late_ticks=3, late_answers=70)
    with job.recorder(tmp_path / "run") as recorder:
        recorder.extend(list(job))
    run = Recording.open(tmp_path / "run")
    assert run.core_to_base.keys() != Recording.open(driven[0]).core_to_base.keys()
    assert other_inputs(run, load_scenario(drive), from_scenario(drive)) == ""


def test_what_was_found_is_told_before_the_next_world_fails(call, tmp_path):
    (tmp_path / "drive.toml").write_text(DRIVE.replace("2.0", "1.6"))
    (tmp_path / "mine.py").write_text(
        "class Mine:\n    def __init__(self, robot): pass\n    def step(self, *wires): raise RuntimeError('boom')\n"
    )
    kept = tmp_path / "kept"
    worlds = f"sim,sim,{tmp_path / 'mine.py'}:Mine"
    for more in ((), ("--overwrite",)):
        status, out, err = call("parity", tmp_path / "drive.toml", "--worlds", worlds, "--record", kept, *more)
        assert status == 1
        assert out == "sim: the same as sim, byte for byte, for 1.6 s\n"
        assert "failed at tick 0" in err
        assert "boom" in err


def test_by_the_command(call, tmp_path):
    (tmp_path / "drive.toml").write_text(DRIVE)
    (tmp_path / "late.py").write_text(
        "from bench.base import Base\n"
        "class Late:\n"
        "    def __init__(self, robot): self.base, self.kept = Base(robot), [()] * 3\n"
        "    def step(self, *wires):\n"
        "        commands, answer = self.base.step(*wires)\n"
        "        self.kept.append(commands)\n"
        "        return self.kept.pop(0), answer\n"
    )
    worlds = f"sim,sim,{tmp_path / 'late.py'}:Late"
    drive, kept = tmp_path / "drive.toml", tmp_path / "run"
    status, out, err = call("parity", drive, "--worlds", worlds, "--record", kept, "--json")
    assert (status, err) == (1, "")
    same, late = json.loads(out)["worlds"]
    assert (same["same"], same["timing"], same["values"]) == (True, [], [])
    assert [(one["kind"], one["amount"]) for one in late["timing"]] == [("late", 3)]
    assert late["values"] == []
    status, out, _ = call("parity", drive, "--worlds", f"sim,{kept}")
    assert (status, out) == (0, f"{kept}: the same as sim, byte for byte, for 2.0 s\n")


@needs_compiler
def test_a_firmware_beside_its_mended_twin(tmp_path):
    """Two firmwares in C that differ in nothing that this drive asks for, each in a process of its own."""
    from pathlib import Path

    (tmp_path / "drive.toml").write_text(DRIVE)
    folder = Path(__file__).parents[1] / "docs/examples/firmware/superloop"
    (found,) = worlds_of(tmp_path / "drive.toml", [str(folder / "superloop.toml"), str(folder / "fixed.toml")])
    assert found.parity.is_same, found.parity


@pytest.mark.parametrize(
    ("worlds", "words"),
    [
        ("sim", "two or more"),
        ("", "two or more"),
        (",,", "two or more"),
        ("sim,nobody", "nobody"),
        ("sim,sim,nobody", "nobody"),
        ("sim,no_such_file.py:Base", "there is no such file"),
        ("sim,no_such_module:Base", "there is no such module"),
    ],
)
def test_what_is_no_world_is_said_in_a_sentence_before_any_has_run(call, tmp_path, worlds, words):
    (tmp_path / "drive.toml").write_text(DRIVE)
    kept = tmp_path / "kept"
    status, out, err = call("parity", tmp_path / "drive.toml", "--worlds", worlds, "--record", kept)
    assert (status, out) == (2, "")
    assert words in err
    assert len(err.splitlines()) == 1
    assert not kept.exists()


def test_a_path_that_has_a_comma_is_a_world(call, tmp_path):
    folder = tmp_path / "mine, and yours"
    folder.mkdir()
    (tmp_path / "drive.toml").write_text(DRIVE.replace("2.0", "1.3"))
    (folder / "base,1.py").write_text("from bench.base import Base\n")
    path = f"{folder / 'base,1.py'}:Base"
    status, out, err = call("parity", tmp_path / "drive.toml", "--worlds", "sim,sim", "--world", path, "--json")
    assert (status, err) == (0, "")
    assert [one["world"] for one in json.loads(out)["worlds"]] == ["sim", path]
    status, out, err = call("parity", tmp_path / "drive.toml", "--world", path, "--world", "sim")
    assert (status, err) == (0, "")
    assert out == f"sim: the same as {path}, byte for byte, for 1.3 s\n"
    status, out, err = call("parity", tmp_path / "drive.toml", "--worlds", f"sim,{path}")
    assert status == 2


def test_a_world_is_not_recorded_over(call, driven, tmp_path):
    """It would then be held against itself."""
    run = tmp_path / "run"
    shutil.copytree(driven[0], run)
    (tmp_path / "drive.toml").write_text(DRIVE)
    for record in (run, tmp_path / "." / "run"):
        status, out, err = call(
            "parity", tmp_path / "drive.toml", "--worlds", f"sim,{run}", "--record", record, "--overwrite"
        )
        assert (status, out) == (2, "")
        assert err == f"wheelbench parity: --record {run}: is one of the worlds; record in another directory\n"
    assert (run / "can.log").read_bytes() == (driven[0] / "can.log").read_bytes()


def test_a_recording_does_not_drive(driven):
    with pytest.raises(UsageError, match="is a recording; put sim"):
        list(worlds_of(driven[0], [str(driven[0]), "sim"]))


def test_the_page_shows_what_the_command_says(call, monkeypatch):
    """docs/parity.md, word for word: its figures are measured here."""
    monkeypatch.chdir(ROOT)
    base = "docs/examples/late_base.py:LateBase"
    status, out, _ = call("parity", "docs/examples/link_loss.toml", "--worlds", f"sim,{base}")
    assert status == 1
    assert f"```text\n{out}```" in (ROOT / "docs/parity.md").read_text()
