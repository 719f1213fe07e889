"""Working with a run by its keys: back in it, forks, recordings, faults, another robot, goldens, palette, settings."""

import os
import signal
import subprocess
import sys
import time
import tomllib
from dataclasses import replace

import pytest
from desk import M2006, Granted, a_job, frame, pass_ticks, piloted

from bench.__main__ import main
from bench.check.compare import compare
from bench.check.golden import pin
from bench.check.reading import Recording, as_outputs
from bench.check.recording import RecordingError
from bench.check.sources import from_recording, from_scenario
from bench.config import load_robot
from bench.io.history import mark_of
from bench.screen.dialog import Dialog, Item, fits
from bench.screen.fault_list import known_faults, table_text
from bench.screen.layout import Place
from bench.screen.palette import ACTIONS, HINT
from bench.screen.remembered import settings_path
from bench.screen.session import Session
from bench.screen.settings import Settings, SettingsFile
from bench.screen.stage import to_drive, to_show
from bench.screen.tape import Tape
from bench.screen.view import picture, places


@pytest.fixture
def settings(tmp_path):
    """Settings of a person who has seen the hint, with a folder of their own."""
    file = SettingsFile(tmp_path / "settings.toml")
    file.change(record_dir=str(tmp_path), hints_seen=1)
    return file


def a_session(settings=None, robot=M2006, tape=None):
    job, keyboard = a_job(robot)
    stage = to_drive(job, keyboard, Granted())
    return Session(stage.link, keyboard=keyboard, job=job, settings=settings, tape=tape)


def drive(session, *keys, each=200):
    """Arm where that is still to be done, then hold each key for a while."""
    if not session.link.latest().armed:
        pass_ticks(session, 50)
        session.key("enter")
        pass_ticks(session, 100)
    for key in keys:
        for _ in range(each // 50):
            session.key(key)
            pass_ticks(session, 50)
    return session


def settle(session, frames=3000):
    """Frames in which no time passes, until nothing is being written any more."""
    for _ in range(frames):
        pass_ticks(session, 0)
        tape, working = session.working.tape, session.working
        if not ((tape and tape.is_behind) or working._golden or working._finishing):
            return
        if working._golden:
            time.sleep(0.02)  # another process writes it
    raise AssertionError("still writing")


def words(session, width=80, height=24):
    return "\n".join(picture(session.scene(), width, height))


def said(session):
    """The last sentence, as the screen has it."""
    scene = session.scene()
    place = places(scene, 300, 24).get("notice", Place(0, 23, 300, 1))
    return " ".join(" ".join(picture(scene, 300, 24)[place.y : place.y + place.height]).split())


def repeats(directory):
    """Whether a recording, run again from its inputs, comes out the same, byte for byte."""
    again = directory.parent / f"{directory.name}-again"
    job = from_recording(directory)
    with job.recorder(again) as recorder:
        recorder.extend(list(job))
    found = compare(Recording.open(again), Recording.open(directory))
    for name in ("can.log", "rc.log", "slamware.log", "state.csv"):
        assert (again / name).read_bytes() == (directory / name).read_bytes(), (name, found.lines)
    return Recording.open(directory)


# --- time ------------------------------------------------------------------------------------------------------------

SCRUBS = {
    ",": -1, "left": -100, "up": -1000, "pageup": -1000, "home": -1_000_000,
}  # fmt: skip


def test_every_key_of_time_goes_where_it_says():
    async def steps(app, pilot):
        session = app.session
        drive(session, "w", "q", "w", "a", "s", "w")
        newest = session.link.newest_tick
        marks = {}
        await pilot.press("p")
        assert "go on" in words(session, 120).splitlines()[-1]
        for key, step in SCRUBS.items():
            await pilot.press(key)
            expected = max(0, newest + step)
            assert session.link.now_tick == expected, key
            assert session.link.newest_tick == newest, key
            assert f"BACK {(newest - expected) / 1000:.3f} s" in words(session, 100), key
            marks[key] = mark_of(session.link.bench)
            await pilot.press("end")
            assert session.link.now_tick == newest
        await pilot.press("home")
        for key, step in (("right", 100), ("down", 1000), ("pagedown", 1000), (".", 1)):
            before = session.link.now_tick
            await pilot.press(key)
            assert session.link.now_tick == min(newest, before + step), key
            await pilot.press("home")
        await pilot.press("end", ".")
        assert session.link.newest_tick == newest + 1, "at the newest instant a step is a tick of the run"
        await pilot.press("p")
        frame(app, 20)
        assert session.link.newest_tick == newest + 21
        await pilot.press(",")
        assert session.link.paused, "a step back stands still first"
        assert session.link.now_tick == newest + 20

    piloted(a_session(), steps)


def test_what_is_shown_of_the_past_is_the_recording(tmp_path, settings):
    """Rows and frames as the recording has them, to the last bit of what it writes."""
    session = a_session(settings)
    session.key("r")
    drive(session, "w", "q", "d", "s")
    session.key("p")
    session.key("r")
    outs = {out.tick: out for out in as_outputs(Recording.open(tmp_path / "m2006-001"))}
    columns = session.link.bench.state_columns
    for key in ("left", ",", ",", "left", "up", "."):
        session.key(key)
        tick = session.link.now_tick
        history = session.link.history
        subject = history.at(tick, session.link.newest_tick, session.link.mark())
        for out in history.go_on(subject, min(tick + 30, session.link.newest_tick)):
            there = outs[out.tick]
            assert out[:-1] == there[:-1]
            if out.state is not None:
                shown = [f"{value:.6f}" if isinstance(value, float) else str(value) for value in out.state]
                written = [f"{value:.6f}" if isinstance(value, float) else str(value) for value in there.state]
                assert dict(zip(columns, shown, strict=True)) | {"t_s": 0} == dict(
                    zip(columns, written, strict=True)
                ) | {"t_s": 0}


def test_space_stops_the_robot_whatever_instant_is_shown():
    session = drive(a_session(), "w", "w")
    session.key("p")
    session.key("left")
    session.key("space")
    assert not session.link.looks_back
    session.key("p")
    pass_ticks(session, 100)
    assert not session.link.latest().armed


def test_a_replay_is_scrubbed_too_even_after_its_end(tmp_path, settings):
    session = a_session(settings)
    session.key("r")
    drive(session, "w", "q")
    session.leave()
    stage = to_show(from_recording(tmp_path / "m2006-001"), None, Granted())
    shown = Session(stage.link, job=stage.job, lamp=stage.lamp, summary=stage.summary)
    pass_ticks(shown, 10_000)
    assert "ENDED" in words(shown)
    shown.key("left")
    assert "BACK 0.100 s" in words(shown, 100)
    assert "drove " not in words(shown), "the summary is of the end"
    shown.key("end")
    assert "identical" in words(shown)
    assert "ENDED" in words(shown)


# --- forks -----------------------------------------------------------------------------------------------------------


def test_a_fork_starts_with_hands_off_and_its_recording_is_whole(tmp_path, settings):
    session = a_session(settings)
    session.key("r")
    drive(session, "w", "q", "w")
    session.key("c")
    drive(session, "d")
    session.key("p")
    session.key("enter")
    for _ in range(3):
        session.key("left")
    at = session.link.now_tick
    was = session.link.mark(), mark_of(session.link.bench)
    session.key("g")
    assert "forked at" in said(session)
    assert "armed, as it was" in said(session)
    assert session.link.newest_tick == at
    assert session.link.mark() == was[1] != was[0]
    assert session.link.paused
    session.key("p")
    pass_ticks(session, 60)
    settle(session)
    assert session.link.latest().sticks == (0.0, 0.0, 0.0)
    assert session.link.latest().armed, "no switch is pressed that nobody pressed"
    pass_ticks(session, 700)
    assert session.link.latest().core_twist == (0.0, 0.0, 0.0), "and no core drives on by itself"
    drive(session, "s", "e")
    session.leave()
    old, new = Recording.open(tmp_path / "m2006-001"), Recording.open(tmp_path / "m2006-002")
    assert old.complete
    assert new.complete
    assert new.ticks > at + 500
    for tick in range(at):
        assert old.commands.get(tick) == new.commands.get(tick)
    repeats(tmp_path / "m2006-001")
    repeats(tmp_path / "m2006-002")
    assert new.commands[new.ticks - 1] == ((0x200, bytes(8)),)


def test_a_replay_is_driven_on_by_hand(tmp_path, settings):
    session = a_session(settings)
    session.key("r")
    drive(session, "w", "q")
    session.leave()
    stage = to_show(from_recording(tmp_path / "m2006-001"), None, Granted())
    shown = Session(stage.link, job=stage.job, lamp=stage.lamp, summary=stage.summary, settings=settings)
    pass_ticks(shown, 400)
    shown.key("x")
    assert "as it was" in words(shown)
    shown.key("p")
    shown.key("left")
    shown.key("g")
    shown.key("r")
    shown.key("p")
    pass_ticks(shown, 50)
    settle(shown)
    x_m = shown.link.latest().pose.x_m
    drive(shown, "w", "w")
    assert shown.link.latest().pose.x_m > x_m
    shown.key("c")
    pass_ticks(shown, 1500)
    assert shown.link.latest().driver == "core", "the core of the fork is one of our own"
    shown.leave()
    assert shown.failure is None
    assert repeats(tmp_path / "m2006-002").ticks > 1900


def test_a_replay_of_recorded_feedback_cannot_be_driven(tmp_path, settings):
    session = a_session(settings)
    session.key("r")
    drive(session, "w")
    session.leave()
    stage = to_show(from_recording(tmp_path / "m2006-001", recorded_can=True), None, Granted())
    shown = Session(stage.link, job=stage.job)
    pass_ticks(shown, 200)
    shown.key("p")
    shown.key("left")
    assert shown.link.now_tick == 100
    shown.key("g")
    assert "motors are a recording's" in words(shown)
    assert shown.link.newest_tick == 200


def test_what_cannot_be_forked_says_why():
    session = drive(a_session(), "w")
    session.key("g")
    assert "P stands still" in words(session)
    session.key("p")
    session.key("g")
    assert "this is the newest instant" in words(session)


# --- recordings ------------------------------------------------------------------------------------------------------


def test_a_recording_that_was_started_late_holds_the_run_from_its_first_tick(tmp_path, settings):
    session = drive(a_session(settings), "w", "q", "d")
    begun = session.link.newest_tick
    session.key("r")
    assert "from its first tick on" in said(session)
    pass_ticks(session, 20)
    assert "m2006-001" in words(session, 120).splitlines()[0]
    assert " %" in words(session, 120).splitlines()[0], "it is behind"
    drive(session, "s")
    settle(session)
    drive(session, "w", "a")
    session.key("r")
    assert "recorded" in words(session)
    assert "REC" not in words(session, 120)
    ticks = session.link.newest_tick
    drive(session, "w")
    recording = repeats(tmp_path / "m2006-001")
    assert recording.complete
    assert recording.ticks == ticks > begun
    session.key("r")
    session.leave()
    while not session.over:
        pass_ticks(session, 0)
    assert repeats(tmp_path / "m2006-002").ticks == session.link.newest_tick
    assert session.working.told == [f"recorded  {tmp_path / f'm2006-00{n}'}" for n in (1, 2)]


def test_each_recording_of_a_timed_bus_has_the_frames_of_its_own_ticks(tmp_path, settings):
    """One that begins late, and one after a fork: bus.log is as that of the same run, run again."""
    (tmp_path / "timed.toml").write_text(TIMED)
    with (job := from_scenario(tmp_path / "timed.toml")).recorder(tmp_path / "whole") as recorder:
        recorder.extend(list(job))
    stage = to_show(from_recording(tmp_path / "whole"), None, Granted())
    shown = Session(stage.link, job=stage.job, lamp=stage.lamp, summary=stage.summary, settings=settings)
    pass_ticks(shown, 300)
    shown.key("r")
    settle(shown)
    pass_ticks(shown, 200)
    for key in ("p", "left", "g", "p"):
        shown.key(key)
    settle(shown)
    pass_ticks(shown, 150)
    settle(shown)
    shown.key("r")
    shown.leave()
    while not shown.over:
        pass_ticks(shown, 0)
    whole = (tmp_path / "whole" / "bus.log").read_text().splitlines()
    for number in (1, 2):
        repeats(tmp_path / f"m2006-00{number}")
        ours = (tmp_path / f"m2006-00{number}" / "bus.log").read_bytes()
        assert ours == (tmp_path / f"m2006-00{number}-again" / "bus.log").read_bytes()
    first = (tmp_path / "m2006-001" / "bus.log").read_text().splitlines()
    assert len(first) > 1500
    assert first == whole[: len(first)]


TIMED = """schema = 1
name = "timed"
robot = "m2006"
seconds = 1.0
[[stick]]
at_s = 0.1
aux1 = true
[[stick]]
at_s = 0.3
forward = 0.5
[wires]
can_bitrate = 450000
"""


def test_leaving_waits_for_what_is_behind_and_a_second_time_does_not(tmp_path, settings):
    for impatient in (False, True):
        session = drive(a_session(settings), *["w", "q"] * 5)
        session.key("r")
        session.key("escape")
        assert not session.over
        assert "writing" in words(session)
        assert not session.link.latest().armed, "the robot stands at once"
        if impatient:
            session.key("escape")
        while not session.over:
            pass_ticks(session, 0)
        recording = Recording.open(tmp_path / f"m2006-00{1 + impatient}")
        assert recording.complete
        assert (recording.ticks == session.link.newest_tick) is not impatient
        repeats(recording.directory)


def test_a_full_disk_is_a_sentence_and_driving_goes_on(tmp_path, settings, monkeypatch):
    session = drive(a_session(settings))
    session.key("r")
    settle(session)

    def full(*_):
        raise RecordingError("m2006-001/can.log: cannot be written (No space left on device); free some space")

    monkeypatch.setattr(session.working.tape._recorder, "extend", full)
    drive(session, "w")
    assert "No space left on device" in said(session)
    assert "REC" not in words(session, 120)
    x_m = session.link.latest().pose.x_m
    drive(session, "w", "w")
    assert session.link.latest().pose.x_m > x_m
    session.leave()
    assert session.over
    assert session.failure is None, "nobody has asked for this recording on the command line"


def test_a_recording_of_the_command_line_that_fails_is_told_by_the_exit_status(tmp_path, settings):
    job, keyboard = a_job()
    recorder = job.recorder(tmp_path / "run")
    stage = to_drive(job, keyboard, Granted())
    session = Session(stage.link, keyboard=keyboard, job=job, settings=settings, tape=Tape(recorder))
    recorder._files["can.log"].close()
    recorder._files["can.log"] = open("/dev/full", "wb", buffering=0)  # noqa: SIM115
    drive(session, "w")
    assert "driving goes on" in said(session)
    session.leave()
    assert isinstance(session.failure, RecordingError)
    assert "No space left" in str(session.failure)


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path, settings):
    (tmp_path / "file").write_text("")
    settings.change(record_dir=str(tmp_path / "file"))
    session = drive(a_session(settings))
    session.key("r")
    assert "not recording: " in said(session)
    session.key("p")
    session.key("b")
    assert "no golden: " in said(session)


# --- faults ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wanted", ["rc drop", "feedback corrupt", "esc weak, rear", "push: ", "core delay", "esc silent"]
)
def test_a_fault_by_hand_is_in_the_recording_and_so_in_its_replay(tmp_path, settings, wanted):
    session = a_session(settings)
    drive(session, "w", each=100)
    session.key("x")
    assert "inject a fault" in words(session)
    for letter in wanted.replace(" ", ""):
        session.key(letter)
    assert wanted.split(",")[0].rstrip(": ") in words(session)
    session.key("left")
    session.key("left")
    assert "for 0.5 s" in words(session)
    session.key("enter")
    assert "for 0.5 s" in said(session)
    session.key("r")  # started after the fault began: it is in it all the same
    drive(session, "q", "w")
    settle(session)
    session.key("x")
    session.key("enter")
    drive(session, "w")
    session.leave()
    while not session.over:
        pass_ticks(session, 0)
    recording = repeats(tmp_path / "m2006-001")
    assert (recording.directory / "faults.log").stat().st_size > 0
    assert (recording.directory / "scenario.toml").read_text().count("[[fault]]") == 2
    assert main(["replay", str(recording.directory), "--json"]) == 0


def test_every_kind_of_fault_can_be_injected_or_does_not_fit():
    kinds = {(values["wire"], values["kind"]) for _, values in known_faults(load_robot("m2006"))}
    assert {
        ("rc", "drop"),
        ("core", "stall"),
        ("command", "reorder"),
        ("feedback", "stuck"),
        ("plant", "push"),
    } <= kinds
    assert ("rc", "flag") not in kinds, "uart12 has no failsafe flag"
    assert ("rc", "flag") in {(v["wire"], v["kind"]) for _, v in known_faults(load_robot("m2006", "frsky-sbus"))}
    assert not any(v["wire"] == "rc" for _, v in known_faults(replace(M2006, rc=None)))
    session = drive(a_session())
    for number in range(len(known_faults(M2006))):
        session.key("x")
        for _ in range(number):
            session.key("down")
        session.key("enter")
        drive(session, "w", each=50) if number % 4 == 0 else pass_ticks(session, 10)
    assert session.failure is None


# --- another run -----------------------------------------------------------------------------------------------------


def test_another_robot_closes_the_recording_with_a_robot_at_rest(tmp_path, settings):
    session = a_session(settings)
    session.key("r")
    drive(session, "w", "w")
    session.key("o")
    for letter in "omni4":
        session.key(letter)
    assert "drive omni4" in words(session)
    session.key("enter")
    pass_ticks(session, 20)
    assert "omni4" in words(session).splitlines()[0]
    assert session.link.newest_tick == 20
    recording = Recording.open(tmp_path / "m2006-001")
    assert recording.complete
    assert recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)
    drive(session, "w", "w")
    assert session.link.latest().pose.x_m > 0.02
    session.leave()
    assert settings.values.robot == "omni4"
    assert SettingsFile(settings.path).values.robot == "omni4"


def test_scenarios_arenas_and_robots_of_the_folder_are_offered(tmp_path, settings, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "course.toml").write_text('schema = 1\nname = "course"\nlength_m = 3.0\nwidth_m = 2.0\n')
    (tmp_path / "broken.toml").write_text("length_m = \n")
    (tmp_path / "small.toml").write_text('schema = 1\nname = "small"\nlength_m = 0.1\nwidth_m = 0.1\n')
    (tmp_path / "turn.scenario.toml").write_text(
        'schema = 1\nname = "turn"\nseconds = 1.0\n[[stick]]\nat_s = 0.1\nturn = 0.5\n'
    )
    session = drive(a_session(settings))
    session.key("o")
    rows = [row for row, _ in session.scene().dialog.rows]
    assert {"drive in course.toml", "show turn.scenario.toml", "show the demo", "drive mecanum"} <= set(rows)
    assert not any("broken" in row for row in rows)
    for letter in "small":
        session.key(letter)
    session.key("enter")
    assert "small" in said(session)
    assert session.link.newest_tick > 0, "what cannot be opened leaves everything as it is"
    for choice, look in (("course", "m2006"), ("turn.sc", "turn m2006"), ("drive mec", "mecanum")):
        session.key("o")
        for letter in choice.replace(" ", ""):
            session.key(letter)
        session.key("enter")
        pass_ticks(session, 10)
        assert look in words(session).splitlines()[0]
    assert session.keyboard is not None
    assert session.failure is None


# --- goldens ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("with_fault", [False, True])
def test_a_golden_of_the_window_passes_at_once(tmp_path, settings, monkeypatch, with_fault, capsys):
    monkeypatch.delenv("CI", raising=False)
    session = drive(a_session(settings), "w", "q")
    session.key("b")
    assert "stands still first" in words(session)
    if with_fault:
        session.key("x")
        for letter in "plantslippery":
            session.key(letter)
        session.key("enter")
    drive(session, "d")
    session.key("p")
    session.key("left")
    ticks = session.link.now_tick
    session.key("b")
    settle(session)
    assert "saved: pytest " in said(session)
    golden = tmp_path / "goldens" / "m2006-001"
    assert Recording.open(golden).ticks == ticks
    assert (golden / "golden.toml").exists()
    assert main(["replay", str(golden)]) == 0
    assert "identical" in capsys.readouterr().out
    test = tmp_path / "test_m2006_001.py"
    again = tmp_path / "again"
    assert main(["replay", str(golden), "--record", str(again)]) == 0
    assert main(["check", str(again), str(golden)]) == 0
    if not with_fault:
        run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n0", str(test)]
        done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        log = golden / "can.log"  # and it can fail
        log.write_bytes(log.read_bytes().replace(b"200#0000000000000000", b"200#0001000000000000", 1))
        done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 1
    session.leave()
    assert f"test      pytest {test}" in session.working.told


def test_a_golden_of_a_scenario_is_held_against_itself_alone(tmp_path, settings, monkeypatch):
    """Its expectations are of the whole run, and may not be met by a part of it; its faults stay."""
    monkeypatch.delenv("CI", raising=False)
    path = tmp_path / "pushed.scenario.toml"
    path.write_text(PUSHED)
    stage = to_show(from_scenario(path), None, Granted())
    session = Session(stage.link, job=stage.job, summary=stage.summary, settings=settings)
    pass_ticks(session, 700)
    session.key("p")
    session.key("b")
    settle(session)
    golden = tmp_path / "goldens" / "m2006-001"
    assert (golden / "faults.log").stat().st_size > 0
    assert main(["replay", str(golden)]) == 0


PUSHED = """
schema = 1
name = "pushed"
seed = 7
seconds = 2.0
[[stick]]
at_s = 0.1
[[fault]]
wire = "rc"
kind = "corrupt"
at_s = 0.2
for_s = 0.2
probability = 0.2
[[fault]]
wire = "feedback"
kind = "corrupt"
at_s = 0.3
for_s = 0.3
[[expect]]
eventually = "speed_mps > 1.0"
"""


def test_a_run_whose_faults_wait_for_a_condition_goes_on_but_not_back(tmp_path, settings):
    path = tmp_path / "waits.scenario.toml"
    path.write_text(PUSHED.replace("at_s = 0.3", "when = \"link == 'live'\""))
    stage = to_show(from_scenario(path), None, Granted())
    session = Session(stage.link, job=stage.job, settings=settings)
    pass_ticks(session, 700)
    session.key("p")
    for key in ("left", "g", "b", "r"):
        session.key(key)
        assert "waits for a condition" in said(session) or "cannot" in said(session) or "no longer" in said(session), (
            key
        )
    session.key("p")
    pass_ticks(session, 2000)
    assert "ENDED" in words(session)


@pytest.fixture
def held_pin(monkeypatch):
    """Pinning waits until it is let go: the call that lets it. The process that pins inherits both."""
    monkeypatch.delenv("CI", raising=False)
    ends = os.pipe()
    monkeypatch.setattr("bench.io.errand._let_go_of_everything_but", lambda _: None)
    monkeypatch.setattr("bench.screen.golden_test.pin", lambda *paths: (os.read(ends[0], 1), pin(*paths)))
    yield lambda: os.write(ends[1], b"!")
    for end in ends:
        os.close(end)


def left_in(folder):
    """Everything that a golden may have left there."""
    found = {path.name for path in (*folder.iterdir(), *(folder / "goldens").iterdir())}
    return sorted(found - {"goldens", "settings.toml"})


def until_pinning(session):
    for _ in range(3000):
        pass_ticks(session, 0)
        if session.working.saving == "100 %":
            return
        time.sleep(0.02)
    raise AssertionError(session.working.saving)


def test_while_a_golden_is_saved_every_key_is_alive(tmp_path, settings, held_pin):
    session = drive(a_session(settings), "w")

    async def steps(app, pilot):
        await pilot.press("p", "b")
        until_pinning(session)
        assert "SAVING 100 %" in words(session).splitlines()[0]
        await pilot.press("b")
        assert said(session).startswith("busy: the golden m2006-001 is being saved")
        assert left_in(tmp_path)[0].startswith(".saving-"), "under its own name only when it is whole"
        assert len(left_in(tmp_path)) == 1
        await pilot.press("left", "p")
        tick = session.link.newest_tick
        frame(app, 50)
        assert session.link.newest_tick == tick + 50
        held_pin()
        settle(session)
        assert "saved: pytest " in said(session)
        assert "SAVING" not in words(session)
        assert left_in(tmp_path) == ["m2006-001", "test_m2006_001.py"]

    piloted(session, steps)
    assert main(["replay", str(tmp_path / "goldens" / "m2006-001")]) == 0


@pytest.mark.parametrize("how", ["twice", "a signal", "killed", "nobody listens"])
def test_a_golden_that_is_left_in_the_middle_leaves_nothing(tmp_path, settings, held_pin, how):
    session = drive(a_session(settings), "w")
    session.key("p")
    session.key("b")
    until_pinning(session)
    golden = session.working._golden
    child = golden._errand._child
    if how == "twice":
        session.key("escape")
        assert not session.over
        assert "saving the golden m2006-001, 100 %; Esc gives it up" in said(session)
        session.key("escape")
        pass_ticks(session, 0)
    elif how == "a signal":
        session.leave(patience=False)
    elif how == "killed":
        os.kill(child, signal.SIGKILL)
        settle(session)
        assert "no golden: its process was ended from outside" in said(session)
        session.leave()
    else:  # as when this process is killed
        golden.give_up = lambda: os.close(golden._errand._pipe)
        session.leave(patience=False)
        held_pin()
        os.waitpid(child, 0)
    assert session.over
    assert left_in(tmp_path) == (["m2006-001", "test_m2006_001.py"] if how == "nobody listens" else [])
    assert any("no golden: left at 100 %" in line for line in session.working.told) is (how != "killed")


def test_who_is_not_listened_to_before_it_pins_takes_everything_away(tmp_path, settings):
    session = drive(a_session(settings), "w")
    session.key("p")
    session.key("b")
    golden = session.working._golden
    os.close(golden._errand._pipe)
    os.waitpid(golden._errand._child, 0)
    assert left_in(tmp_path) == []


def test_in_ci_no_golden_is_pinned(settings, monkeypatch):
    monkeypatch.setenv("CI", "1")
    session = drive(a_session(settings), "w")
    session.key("p")
    session.key("b")
    settle(session)
    assert "not pinned in CI" in said(session)


# --- finding one's way -----------------------------------------------------------------------------------------------


def test_the_palette_finds_every_action_and_does_it():
    for opens in (":", "ctrl+p"):
        session = drive(a_session())
        session.key(opens)
        rows = session.scene().dialog.rows
        assert rows == tuple((action.words, action.printed) for action in ACTIONS)
        for letter in "slow":
            session.key(letter)
        session.key("enter")
        assert session.link.pacer.rate == 0.5
        assert session.scene().dialog is None
    session.key(":")
    session.key("space")
    assert session.scene().dialog is not None, "Space stops, whatever is open"
    pass_ticks(session, 100)
    assert not session.link.latest().armed
    session.key("escape")
    assert session.scene().dialog is None
    assert not session.over


@pytest.mark.parametrize("opens", [":", "x", "o"])
def test_letters_in_a_list_drive_nothing_and_ctrl_q_still_leaves(opens):
    session = drive(a_session(), "w")
    session.key(opens)
    for key in ("w", "a", "up", "down", "enter") if opens == "zz" else ("w", "e", "backspace", "down", "up", "tab"):
        session.key(key)
        pass_ticks(session, 50)
        assert session.link.latest().sticks == (0.0, 0.0, 0.0)
    session.key("ctrl+q")
    assert session.over


def test_fuzzy_means_letters_in_order_and_beginnings_first():
    assert fits("", "anything") == 0
    assert fits("xyz", "pause") is None
    assert fits("fk", "drive on from the instant shown (fork)") is not None
    best = min(("esc weak, rear", "feedback corrupt", "seldom weaker"), key=lambda one: fits("ew", one) or 10**6)
    assert best == "esc weak, rear"
    dialog = Dialog("t", [Item("rc drop", "", str), Item("core drop", "", str), Item("plant push", "", str)])
    for letter in "rcd":
        dialog.key(letter)
    assert [words for words, _ in dialog.shown.rows] == ["rc drop"]
    dialog.key("z")
    assert dialog.shown.rows == ()
    assert dialog.key("enter") == ""
    assert dialog.open


def test_a_list_fits_every_size_and_keeps_its_cursor_in_sight():
    session = a_session()
    session.key("x")
    for _ in range(20):
        session.key("down")
    for width, height in ((60, 16), (80, 24), (120, 40), (200, 60)):
        lines = picture(session.scene(), width, height)
        assert any("▶" in line for line in lines), (width, height)
        assert "SPACE" in lines[-1]
        assert "m2006" in lines[0]


# --- settings --------------------------------------------------------------------------------------------------------


def test_settings_are_kept_and_applied(tmp_path):
    path = tmp_path / "wheelbench" / "settings.toml"
    session = drive(a_session(SettingsFile(path)))
    session.key("+")
    session.key("[")
    session.leave()
    again = SettingsFile(path)
    assert again.values == Settings(power_percent=60, rate=0.5, hints_seen=1)
    assert again.why == ""


def test_the_first_run_has_a_hint_once(tmp_path):
    path = tmp_path / "settings.toml"
    first = a_session(SettingsFile(path))
    assert HINT in said(first)
    pass_ticks(first, 20)
    assert HINT in said(first)
    first.key("w")
    assert HINT not in said(first)
    assert HINT not in said(a_session(SettingsFile(path)))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"power_percent = ", "not valid TOML"), (b"power_percent = 900", "expected 10 to 100"),
        (b"rate = -1.0", "expected 0.1 to 4"), (b"rat = 1.0", "unknown key; did you mean rate?"),
        (b"robot = 7", "expected text"), (b"\xff\xfe", "not a text file"), (b"hints_seen = -1", "0 or more"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_a_sentence_and_defaults_and_stays(tmp_path, content, sentence):
    path = tmp_path / "settings.toml"
    path.write_bytes(content)
    file = SettingsFile(path)
    assert file.values == Settings()
    session = a_session(file)
    assert sentence in said(session)
    session.key("+")
    session.leave()
    assert path.read_bytes() == content


def test_settings_that_cannot_be_saved_are_told(tmp_path):
    (tmp_path / "file").write_text("")
    file = SettingsFile(tmp_path / "file" / "settings.toml")
    file.change(robot="omni4")
    assert "cannot be saved" in file.save()


@pytest.mark.parametrize("name", ["a\x7fb", 'say "no"', "ü\n", "\\"])
def test_settings_with_any_name_are_read_back(tmp_path, name):
    file = SettingsFile(tmp_path / "settings.toml")
    file.change(record_dir=name)
    assert file.save() == ""
    again = SettingsFile(file.path)
    assert (again.why, again.values) == ("", Settings(record_dir=name))


def test_settings_with_a_name_that_is_no_text_are_told(tmp_path):
    """As the file system hands over a folder whose name is not UTF-8."""
    file = SettingsFile(tmp_path / "settings.toml")
    file.change(record_dir=os.fsdecode(b"caf\xe9"))
    assert "the settings cannot be saved (record_dir: half a character" in file.save()
    assert not file.path.exists()


def test_a_faults_table_is_what_it_was_when_it_is_read_back():
    values = {"name": "by hand\x7f", "wire": "rc", "kind": "delay", "ms": 100, "at_s": 0.3, "for_s": 1e-7}
    assert tomllib.loads(table_text(values)) == {"fault": [values]}


def test_the_place_is_that_of_the_xdg_specification(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert settings_path() == tmp_path / "wheelbench" / "settings.toml"
    monkeypatch.setenv("XDG_CONFIG_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert settings_path() == tmp_path / "home" / ".config" / "wheelbench" / "settings.toml"


def test_a_late_arrow_moves_no_robot_and_still_goes_back_in_time(monkeypatch):
    """What is built again may take longer than a key that drives may be late."""

    async def steps(app, pilot):
        session = app.session
        monkeypatch.setattr(app, "_age_ms", lambda _: 900)
        await pilot.press("left")
        assert "not heard: 900 ms late" in words(session)
        await pilot.press("p", "left")
        assert session.link.newest_tick - session.link.now_tick == 100

    piloted(drive(a_session(), "w"), steps)
