"""Recordings on disk: the text of every file, the way back, and what happens when a run or a disk dies."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import COLUMNS, ROBOT_TEXT, made_run, record

from bench.check.lines import can_lines
from bench.check.reading import Recording, as_outputs
from bench.check.recording import Recorder, RecordingError, RunInfo, write_file
from bench.messages import TickOutput

TESTS = Path(__file__).parent


def one_tick(tick: int = 0, **changes: object) -> TickOutput:
    return TickOutput(tick, b"", b"", b"", (), (), None)._replace(**changes)


def recorder_in(directory: Path, **options: bool) -> Recorder:
    robot_file = directory.parent / "little.toml"
    robot_file.parent.mkdir(parents=True, exist_ok=True)
    robot_file.write_text(ROBOT_TEXT, encoding="utf-8")
    return Recorder(directory, RunInfo("little"), COLUMNS, robot_file, **options)


def texts_of(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


# --- the text -----------------------------------------------------------------------------------------------------


def test_every_file_as_literal_text(tmp_path):
    robot_file = tmp_path / "mine.toml"
    robot_file.write_bytes(b"name = 'mine'\r\n# verbatim, line ends and all\r\n")
    profile_file = tmp_path / "stick.toml"
    profile_file.write_bytes(b"name = 'stick'")
    info = RunInfo("mine", profile="stick", scenario='square "big"', seed=7, wheelbench="0.1.0")
    command = (0x200, bytes.fromhex("0258025802580000"))
    feedback = ((0x201, bytes.fromhex("10E1300C03520000")), (0x202, bytes.fromhex("0011CFF4FCAE0000")))
    with Recorder(tmp_path / "run", info, COLUMNS, robot_file, profile_file) as recorder:
        recorder.add(one_tick(0, state=(0.0, -0.0, 1.25, "live", 0)))
        recorder.add(one_tick(1, can_commands=(command,), can_feedback=feedback))
        for tick in range(2, 10):
            recorder.add(one_tick(tick))
        rc = bytes.fromhex("AA08000800")
        recorder.add(one_tick(10, rc=rc, state=(0.01, -0.0000001, -0.0000009, "no rc", 1)))
        for tick in range(11, 1050):
            recorder.add(one_tick(tick))
        asked, answered = bytes.fromhex("1002F830DA"), bytes.fromhex("5003000 24D001C".replace(" ", ""))
        recorder.add(one_tick(1050, core_to_base=asked, base_to_core=answered, can_feedback=((0x7F, b""),)))
    assert texts_of(tmp_path / "run") == {
        "can.log": (
            b"(0.001000) can0 200#0258025802580000\n"
            b"(0.001000) can0 201#10E1300C03520000\n"
            b"(0.001000) can0 202#0011CFF4FCAE0000\n"
            b"(1.050000) can0 07F#\n"
        ),
        "rc.log": b"(0.010000) rc0 > AA 08 00 08 00\n",
        "slamware.log": b"(1.050000) slamware0 > 10 02 F8 30 DA\n(1.050000) slamware0 < 50 03 00 02 4D 00 1C\n",
        "state.csv": (
            b"t_s,x_m,heading_rad,link,armed\n0.000000,0.000000,1.250000,live,0\n0.010000,0.000000,-0.000001,no rc,1\n"
        ),
        "run.toml": (
            b'robot = "mine"\nprofile = "stick"\nscenario = "square \\"big\\""\nseed = 7\ntick_us = 1000\n'
            b'state_period_ticks = 10\nwheelbench = "0.1.0"\nschema = 1\nticks = 1051\n'
        ),
        "robot.toml": b"name = 'mine'\r\n# verbatim, line ends and all\r\n",
        "profile.toml": b"name = 'stick'",
    }


def test_a_run_without_profile_and_scenario_says_nothing_of_them(tmp_path):
    record(tmp_path / "run", [])
    assert sorted(texts_of(tmp_path / "run")) == [
        "can.log", "rc.log", "robot.toml", "run.toml", "slamware.log", "state.csv",
    ]  # fmt: skip
    assert b"profile" not in (tmp_path / "run" / "run.toml").read_bytes()
    assert (tmp_path / "run" / "run.toml").read_bytes().endswith(b"\nticks = 0\n")


def test_numbers_and_words_of_a_state_row(tmp_path):
    rows = [(0.0, 1e-9, float("nan"), "no rc", True), (0.001, -12345.6789, float("-inf"), "lost", -3)]
    run = record(tmp_path / "run", [one_tick(tick, state=row) for tick, row in enumerate(rows)])
    assert (tmp_path / "run" / "state.csv").read_text().splitlines()[1:] == [
        "0.000000,0.000000,nan,no rc,1",
        "0.001000,-12345.678900,-inf,lost,-3",
    ]
    assert run.state[1] == (0.001, -12345.6789, "-inf", "lost", -3)


@pytest.mark.parametrize("word", ["a,b", 'say "no"', "two\nlines"])
def test_a_word_that_would_shift_the_columns_is_refused(tmp_path, word):
    recorder = recorder_in(tmp_path / "run")
    recorder.add(one_tick(state=(0.0, 0.0, 0.0, word, 0)))
    with pytest.raises(ValueError, match=r"cannot stand in a cell of state\.csv"):
        recorder.close()


def test_calls_that_cannot_be_right_are_refused(tmp_path):
    with pytest.raises(ValueError, match="start with t_s"):
        Recorder(tmp_path / "a", RunInfo("little"), ("x_m",), tmp_path)
    recorder = recorder_in(tmp_path / "b")
    recorder.add(one_tick(state=(0.0, 1.0)))
    with pytest.raises(ValueError, match="2 values for 5 columns"):
        recorder.close()
    for ticks in ([1], [0, 2], [0, 1, 3, 3]):
        recorder = recorder_in(tmp_path / f"c{len(ticks)}")
        for tick in ticks:
            recorder.add(one_tick(tick))
        with pytest.raises(ValueError, match="do not follow"):
            recorder.close()
    recorder = recorder_in(tmp_path / "d")
    recorder.close()
    recorder.add(one_tick())
    with pytest.raises(RecordingError, match="has ended"):
        recorder.flush()
    recorder.close()


# --- the way back -------------------------------------------------------------------------------------------------


def test_round_trip_through_real_files(tmp_path):
    outputs = made_run(1234)
    info = RunInfo("little", profile="p", scenario="Übung \x7f\n", seed=-3)
    run = record(tmp_path / "run", outputs, info)
    assert run.info == info
    assert run.complete
    assert run.notes == []
    assert run.ticks == 1234
    assert run.robot_file.read_text() == ROBOT_TEXT
    assert run.profile_file is None
    assert run.state_columns == COLUMNS
    again = list(as_outputs(run))
    assert [out._replace(state=None) for out in again] == [out._replace(state=None) for out in outputs]
    for out, other in zip(outputs, again, strict=True):
        assert (out.state is None) == (other.state is None)
        assert other.state is None or other.state == pytest.approx(out.state, abs=5e-7)


def test_what_was_read_records_again_to_the_same_bytes(tmp_path):
    first = record(tmp_path / "first", made_run(321))
    record(tmp_path / "second", as_outputs(first))
    assert texts_of(tmp_path / "first") == texts_of(tmp_path / "second")


def test_commands_and_feedback_are_told_apart_by_identifier(tmp_path):
    frames = ((0x1FF, b"\x01"), (0x200, b"\x02"), (0x209, b"\x03"), (0x700, b""))
    feedback = ((0x201, b"\x04"), (0x208, b"\x05"))
    run = record(tmp_path / "run", [one_tick(can_commands=frames, can_feedback=feedback), one_tick(1)])
    assert run.commands == {0: frames}
    assert run.feedback == {0: feedback}
    assert run.can[:2] == [(0, 0x1FF, b"\x01"), (0, 0x200, b"\x02")]


_BYTES = st.binary(max_size=20)
_FRAMES = st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=4).map(tuple)


@given(st.lists(st.tuples(_BYTES, _BYTES, _BYTES, _FRAMES), max_size=5))
def test_any_bytes_come_back(tmp_path_factory, ticks):
    directory = tmp_path_factory.mktemp("any")
    outputs = [
        one_tick(tick, rc=rc, core_to_base=asked, base_to_core=answered, can_commands=frames)
        for tick, (rc, asked, answered, frames) in enumerate(ticks)
    ]
    run = record(directory / "run", outputs)
    assert run.ticks == len(ticks)
    assert [(out.rc, out.core_to_base, out.base_to_core) for out in as_outputs(run)] == [tick[:3] for tick in ticks]
    assert run.can == [(n, can_id, data) for n, tick in enumerate(ticks) for can_id, data in tick[3]]


_BLOCK = st.tuples(
    st.integers(0, 20) | st.integers(880, 1010) | st.integers(0, 10**8),
    st.integers(1, 130),
    st.lists(st.integers(0, 0x7FF), max_size=3),
    st.lists(st.integers(0, 0x7FF), max_size=4),
    st.randoms(use_true_random=False),
)


@given(
    _BLOCK, st.sampled_from(["alike", "a frame more", "a frame less", "a frame moved", "other", "short", "long", "gap"])
)
def test_a_block_in_which_all_ticks_look_alike_has_the_same_lines_as_any_other(block, odd):
    first, count, commands, feedback, rng = block
    ticks = list(range(first, first + count))
    sides = [([(i, rng.randbytes(8)) for i in commands], [(i, rng.randbytes(8)) for i in feedback]) for _ in ticks]
    n = rng.randrange(count)
    sent, answered = sides[n]
    if odd == "gap":
        ticks[n:] = [tick + 3 for tick in ticks[n:]]
    elif odd == "a frame more":
        answered.append((0x203, rng.randbytes(8)))
    elif odd == "a frame moved" and sent:
        sides[n - 1][1].append(sent.pop())
    elif odd != "alike" and sent:
        can_id, data = sent.pop()
        sent += {
            "other": [(can_id ^ 1, data)], "short": [(can_id, data[:-1])], "long": [(can_id, data + b"!")]
        }.get(odd, [])  # fmt: skip
    assert can_lines(ticks, [tuple(s) for s, _ in sides], [tuple(a) for _, a in sides]) == "".join(
        f"({tick // 1000}.{tick % 1000:03d}000) can0 {can_id:03X}#{data.hex().upper()}\n"
        for tick, (s, a) in zip(ticks, sides, strict=True)
        for can_id, data in s + a
    )


def test_python_can_reads_the_same_frames(tmp_path):
    outputs = made_run(400)
    record(tmp_path / "run", outputs)
    with can.LogReader(tmp_path / "run" / "can.log") as reader:
        read = [
            (round(m.timestamp * 1e6), m.channel, m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in reader
        ]
    assert read == [
        (out.tick * 1000, "can0", can_id, False, data)
        for out in outputs
        for can_id, data in out.can_commands + out.can_feedback
    ]


def test_line_ends_that_a_checkout_has_turned_do_no_harm(tmp_path):
    run = record(tmp_path / "run", made_run(60))
    expected = list(as_outputs(run))
    for name in ("can.log", "rc.log", "slamware.log", "state.csv", "run.toml"):
        path = tmp_path / "run" / name
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert list(as_outputs(Recording.open(tmp_path / "run"))) == expected


# --- runs that die ------------------------------------------------------------------------------------------------

_CHILD = """
import sys
sys.path.insert(0, {tests!r})
from pathlib import Path
from recordings import COLUMNS, ROBOT_TEXT, made_run
from bench.check.recording import Recorder, RecordingError, RunInfo
here = Path(sys.argv[1])
(here / "little.toml").write_text(ROBOT_TEXT)
recorder = Recorder(here / "run", RunInfo("little"), COLUMNS, here / "little.toml")
"""


def child(code: str, directory: Path) -> subprocess.Popen[str]:
    script = _CHILD.format(tests=str(TESTS)) + code
    command = [sys.executable, "-c", script, str(directory)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_kill_9_leaves_what_was_flushed(tmp_path):
    code = "for out in made_run(1057): recorder.add(out)\nprint('added', flush=True)\nsys.stdin.read()\n"
    with child(code, tmp_path) as process:
        assert process.stdout.readline() == "added\n"
        process.kill()
    (tmp_path / "whole").mkdir()
    whole = record(tmp_path / "whole" / "run", made_run(999))
    run = Recording.open(tmp_path / "run")
    assert not run.complete
    assert run.notes == ["the run was cut short; what it wrote until then is used"]
    assert run.ticks == 999  # the last tick of a cut run may want a frame, so it is not used
    assert list(as_outputs(run)) == list(as_outputs(whole))


def test_a_run_cut_off_anywhere_is_read_to_its_last_whole_tick(tmp_path):
    outputs = made_run(62)
    whole = list(as_outputs(record(tmp_path / "run", outputs)))
    run_toml = tmp_path / "run" / "run.toml"
    run_toml.write_bytes(run_toml.read_bytes().removesuffix(b"ticks = 62\n"))
    path = tmp_path / "run" / "can.log"
    text = path.read_bytes()
    seen = set()
    for cut in range(len(text), len(text) - 500, -1):  # the last three ticks and a bit, byte by byte
        path.write_bytes(text[:cut])
        run = Recording.open(tmp_path / "run")
        assert list(as_outputs(run)) == whole[: run.ticks]
        assert any("can.log: the last line was cut off" in note for note in run.notes) == (text[cut - 1] != 10)
        assert text[:cut].count(b" can0 200#") - 2 <= run.ticks < 62
        seen.add(run.ticks)
    assert seen == {58, 59, 60, 61}
    for name in ("can.log", "rc.log", "slamware.log", "state.csv"):
        log = tmp_path / "run" / name
        log.write_bytes(b"t_s,x_m,heading_rad,link,armed\n" if name == "state.csv" else b"")
    assert Recording.open(tmp_path / "run").ticks == 0


def test_a_cut_run_without_can_ends_with_its_last_row(tmp_path):
    record(tmp_path / "run", [out._replace(can_commands=(), can_feedback=()) for out in made_run(57)])
    run_toml = tmp_path / "run" / "run.toml"
    run_toml.write_bytes(run_toml.read_bytes().removesuffix(b" = 57\n"))
    run = Recording.open(tmp_path / "run")
    assert run.ticks == 50
    assert run.notes[0] == "run.toml: the last line was cut off and is left out"


def test_a_cut_last_line_of_a_whole_run_is_left_out_with_a_note(tmp_path):
    record(tmp_path / "run", made_run(31))
    path = tmp_path / "run" / "rc.log"
    path.write_bytes(path.read_bytes()[:-4])
    run = Recording.open(tmp_path / "run")
    assert sorted(run.rc) == [0, 10, 20]
    assert run.ticks == 31
    assert run.notes == ["rc.log: the last line was cut off and is left out"]


def test_a_disk_that_is_full_is_one_sentence_and_keeps_what_it_has(tmp_path):
    code = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
try:
    with recorder:
        for out in made_run(5000): recorder.add(out)
except RecordingError as error:
    print(error.exit_status, error, flush=True)
recorder.close()
"""
    with child(code, tmp_path) as process:
        said, _ = process.communicate()
    place = re.escape(str(tmp_path / "run" / "can.log"))
    assert re.fullmatch(
        f"3 {place}: cannot be written \\(File too large\\); "
        "what stands there stays; free some space or record elsewhere\n",
        said,
    )
    assert process.returncode == 0
    run = Recording.open(tmp_path / "run")
    assert (tmp_path / "run" / "can.log").stat().st_size == 40_000
    assert 200 < run.ticks < 300
    (tmp_path / "whole").mkdir()
    whole = record(tmp_path / "whole" / "run", made_run(300))
    assert list(as_outputs(run)) == list(as_outputs(whole))[: run.ticks]
    for name in ("rc.log", "slamware.log", "state.csv", "can.log"):  # nothing was written twice
        assert whole.content(name).startswith(run.content(name))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_no_space_left(tmp_path):
    with pytest.raises(RecordingError, match=r"^/dev/full: cannot be written \(No space left on device\); .*free some"):
        write_file(Path("/dev/full"), b"x")


def test_an_error_in_the_run_still_ends_the_recording(tmp_path):
    def stage_raises() -> None:
        with recorder_in(tmp_path / "run") as recorder:
            recorder.add(one_tick(rc=b"\x01"))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        stage_raises()
    run = Recording.open(tmp_path / "run")
    assert run.complete
    assert run.rc == {0: b"\x01"}


# --- places -------------------------------------------------------------------------------------------------------


def test_parents_are_made_and_an_empty_directory_is_taken(tmp_path):
    recorder_in(tmp_path / "a" / "b" / "run").close()
    assert Recording.open(tmp_path / "a" / "b" / "run").ticks == 0
    (tmp_path / "empty").mkdir()
    recorder_in(tmp_path / "empty").close()
    assert Recording.open(tmp_path / "empty").ticks == 0


def test_what_stands_in_the_way_is_refused(tmp_path):
    record(tmp_path / "old", made_run(3))
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "thesis.txt").write_text("ten years of work")
    (tmp_path / "file").write_text("")
    for name, sentence in {
        "old": r"old: already holds a recording; give another directory, or --overwrite$",
        "foreign": r"foreign: already holds other files \(thesis\.txt\); give another",
        "file": r"file: is a file, and a recording is a directory; give another name$",
        "file/below": r"below: cannot be used for a recording \(Not a directory\); give a directory that you may write",
    }.items():
        with pytest.raises(RecordingError, match=sentence):
            Recorder(tmp_path / name, RunInfo("little"), COLUMNS, tmp_path / "little.toml")
    assert Recording.open(tmp_path / "old").ticks == 3


@pytest.mark.parametrize("name", ["can.log", "robot.toml", "scenario.toml"])
def test_a_file_of_somebody_elses_by_one_of_our_names_is_not_overwritten(tmp_path, name):
    """Somebody's candump, or the robot file that they have tuned by hand, in the folder they work in."""
    (tmp_path / name).write_text("ten years of work")
    with pytest.raises(RecordingError, match=f"holds {name}, which is of no recording .*; give another directory$"):
        recorder_in(tmp_path, overwrite=True)
    assert (tmp_path / name).read_text() == "ten years of work"


def test_overwriting_removes_a_recording_and_nothing_else(tmp_path):
    record(tmp_path / "old", made_run(300))
    (tmp_path / "old" / "profile.toml").write_text("of the old run")
    (tmp_path / "old" / "thesis.txt").write_text("ten years of work")
    recorder_in(tmp_path / "old", overwrite=True).close()
    assert Recording.open(tmp_path / "old").ticks == 0
    assert (tmp_path / "old" / "can.log").read_bytes() == b""
    assert not (tmp_path / "old" / "profile.toml").exists()
    assert (tmp_path / "old" / "thesis.txt").read_text() == "ten years of work"


def test_a_recording_may_be_made_again_in_its_own_place(tmp_path):
    run = record(tmp_path / "run", made_run(12))
    outputs = list(as_outputs(run))
    with Recorder(run.directory, run.info, run.state_columns, run.robot_file, overwrite=True) as recorder:
        for out in outputs:
            recorder.add(out)
    assert list(as_outputs(Recording.open(tmp_path / "run"))) == outputs


def test_a_golden_is_never_recorded_over(tmp_path):
    record(tmp_path / "golden", made_run(3))
    (tmp_path / "golden" / "golden.toml").write_text("")
    with pytest.raises(RecordingError, match="holds a golden; record elsewhere and pin that run"):
        recorder_in(tmp_path / "golden", overwrite=True)
    assert Recording.open(tmp_path / "golden").ticks == 3


def test_a_missing_robot_file_leaves_everything_as_it_was(tmp_path):
    record(tmp_path / "old", made_run(3))
    with pytest.raises(RecordingError, match=r"no\.toml: cannot be read \(No such file or directory\)"):
        Recorder(tmp_path / "old", RunInfo("little"), COLUMNS, tmp_path / "no.toml", overwrite=True)
    assert Recording.open(tmp_path / "old").ticks == 3


# --- what is no recording, or a damaged one -----------------------------------------------------------------------


def test_what_is_no_recording_is_said(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    record(tmp_path / "half", made_run(3))
    (tmp_path / "half" / "slamware.log").unlink()
    for name, sentence in {
        "nothing": "does not exist; give the directory of a recording",
        "empty": "empty: is no recording: it has no run.toml",
        "file": "file: is a file; a recording is a directory with a run.toml in it",
        "half": "half: is no recording: it has no slamware.log",
    }.items():
        with pytest.raises(RecordingError, match=sentence):
            Recording.open(tmp_path / name)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("schema = 1", "schema = 2", r"schema: expected 1, got 2; the recording is of another version of wheelbench"),
        ("schema = 1\n", "", r"schema: expected 1, got None"),
        ("seed = 0", 'seed = "0"', r"seed: expected a whole number, got '0'"),
        ('robot = "little"\n', "", r"robot: expected text, got None"),
        ("tick_us = 1000", "tick_us = 500", r"tick_us: expected 1000, got 500"),
        ("ticks = 3\n", "ticks = -3\n", r"ticks: expected the number of ticks, got -3"),
        ("ticks = 3\n", "ticks = true\n", r"ticks: expected the number of ticks, got True"),
        ("seed = 0", "seed 0", r"is not valid TOML \(.*line 2.*\); expected the facts of a run"),
        ("seed = 0", "seed = \udcff", r"is not valid TOML"),
    ],
)
def test_a_damaged_run_toml_is_named(tmp_path, old, new, sentence):
    record(tmp_path / "run", made_run(3))
    path = tmp_path / "run" / "run.toml"
    text = path.read_text()
    assert old in text
    path.write_bytes(text.replace(old, new).encode("utf-8", "surrogateescape"))
    with pytest.raises(RecordingError, match=r"run\.toml: " + sentence):
        Recording.open(tmp_path / "run")


@pytest.mark.parametrize(
    ("name", "old", "new", "sentence"),
    [
        (
            "can.log",
            "(0.001000) can0 200#",
            "(0.001000) can0 G00#",
            r"can\.log:5: expected \(0\.001000\) can0 200#0258",
        ),
        (
            "can.log",
            "(0.001000) can0 200#",
            "(0.001500) can0 200#",
            r"can\.log:5: expected .*; got '\(0\.001500\) can0",
        ),
        ("can.log", "(0.001000) can0 200#", "(0.001000) can0 200#0", r"can\.log:5: expected"),
        ("can.log", "(0.001000) can0 200#", "(0.001000) can0 800#", r"can\.log:5: expected"),
        ("can.log", "(0.001000) can0 200#", "\n(0.001000) can0 200#", r"can\.log:5: expected .*; got ''"),
        ("can.log", "(0.001000) can0 201#", "(0.000000) can0 201#", r"can\.log:6: time goes back, from tick 1 to 0"),
        (
            "can.log",
            "(0.019000) can0 203#",
            "(0.021000) can0 203#",
            r"can\.log:80: tick 21 lies after the end .*21 ticks",
        ),
        ("rc.log", "(0.010000) rc0 >", "(0.010000) rc0 <", r"rc\.log:2: expected \(0\.010000\) rc0 > AA 08 00"),
        ("rc.log", "(0.010000) rc0", "(0.000000) rc0", r"rc\.log:2: a second line for tick 0"),
        ("slamware.log", "10 02 F8 30 DA", "10 02 F8 30 D", r"slamware\.log:1: expected"),
        ("state.csv", ",live,0\n0.010000", ",0\n0.010000", r"state\.csv:2: expected 5 values, got 4"),
        ("state.csv", "0.010000,", "0.01,", r"state\.csv:3: expected the time in seconds with six decimals"),
        ("state.csv", "0.010000,", "0.010000,\udcff", r"state\.csv:3: expected the time .* as UTF-8 text; got"),
        ("state.csv", "t_s,", "time,", r"state\.csv:1: expected a header that starts with t_s"),
    ],
)
def test_a_damaged_line_is_named(tmp_path, name, old, new, sentence):
    record(tmp_path / "run", made_run(21))
    path = tmp_path / "run" / name
    text = path.read_bytes().decode()
    assert old in text
    path.write_bytes(text.replace(old, new, 1).encode("utf-8", "surrogateescape"))
    with pytest.raises(RecordingError, match=sentence):
        list(as_outputs(Recording.open(tmp_path / "run")))


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    record(tmp_path / "run", made_run(3))
    (tmp_path / "run" / "can.log").unlink()
    (tmp_path / "run" / "can.log").mkdir()
    with pytest.raises(RecordingError, match=r"can\.log: cannot be read \(Is a directory\); check the path"):
        _ = Recording.open(tmp_path / "run").can
