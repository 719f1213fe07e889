"""The dashboard: a session by its keys, then the app around it through Textual's Pilot, at 80x24."""

import os
import signal
from dataclasses import replace

import pytest
from desk import Granted, a_job, armed, at_the_keys, frame, on_screen, pass_ticks, piloted
from textual import events

from bench.check.reading import Recording
from bench.check.recording import RecordingError
from bench.check.sources import from_recording, from_scenario
from bench.check.summary import Summary
from bench.config import load_robot
from bench.demo import SCENARIO
from bench.io.clock import WallPacer
from bench.io.link import BenchStopped, InlineLink
from bench.screen.lamp import GoldenLamp
from bench.screen.session import Session
from bench.screen.view import picture


def words(session, width=80, height=24):
    return "\n".join(picture(session.scene(), width, height))


# --- the session -------------------------------------------------------------------------------------------------


def test_a_session_drives_by_keys_and_shows_it():
    session = armed()
    for _ in range(10):
        session.key("w")
        pass_ticks(session, 50)
    assert "ARMED  the sticks drive" in words(session)
    assert session.link.latest().pose.x_m > 0.05
    pass_ticks(session, 130)
    assert session.link.latest().sticks == (0.0, 0.0, 0.0)


def test_a_key_belongs_to_the_tick_in_which_it_was_pressed():
    """Ticks that were due before the key run before it: its lease is counted from now, not from the last frame."""
    session = armed()
    session.link.pacer.granted = 40  # of the wall, since the last frame
    before = session.link.now_tick
    session.key("w")
    assert session.link.now_tick == before + 40
    assert session.keyboard.sticks.sticks(before + 159).forward == 0.5
    assert session.keyboard.sticks.sticks(before + 160).forward == 0.0


def test_focus_lost_or_asleep_lets_go_of_every_key():
    for leave in ("hands_off", "asleep"):
        session = armed()
        session.key("w")
        session.key("q")
        getattr(session, leave)()
        pass_ticks(session, 11)
        assert session.link.latest().sticks == (0.0, 0.0, 0.0), leave
        assert session.link.latest().armed


def test_a_stall_longer_than_the_burst_lets_go_too():
    class Stalled(Granted):
        def due(self, done):
            self.slipped_ticks += 1000
            return super().due(done)

    session = armed()
    session.key("w")
    session.link.pacer = Stalled()
    pass_ticks(session, 5)
    pass_ticks(session, 11)
    assert session.link.latest().sticks == (0.0, 0.0, 0.0)


def test_paused_nothing_moves_and_only_space_is_heard():
    session = armed()
    session.key("p")
    pass_ticks(session, 100)
    tick = session.link.now_tick
    session.key("w")
    assert "paused: P goes on" in words(session)
    assert "PAUSED" in words(session)
    session.key("space")
    session.key("p")
    pass_ticks(session, 75)
    assert session.link.now_tick > tick
    assert not session.link.latest().armed


def test_time_runs_slower_and_faster_within_limits():
    session = at_the_keys()
    rates = []
    for key in "]]]]" + "[" * 8:
        session.key(key)
        rates.append(session.link.pacer.rate)
    assert rates == [2.0, 4.0, 4.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.1, 0.1, 0.1, 0.1]
    assert "time runs ×0.1" in words(session)


def test_notices_go_by_themselves():
    session = at_the_keys()
    session.key("t")
    assert "transmitter off" in words(session)
    for _ in range(60):
        pass_ticks(session, 1)
    assert "transmitter off" not in words(session)
    assert "T radio OFF" in words(session)


@pytest.mark.parametrize("before", [(), ("w",), ("enter",), ("c",), ("t",), ("p",), ("w", "t")])
def test_leaving_records_a_robot_that_has_been_disarmed(tmp_path, before):
    job, keyboard = a_job()
    recorder = job.recorder(tmp_path / "run")
    session = Session(InlineLink(job.bench, keyboard.inputs, Granted(), takers=[recorder]), keyboard=keyboard)
    pass_ticks(session, 50)
    session.key("enter")
    pass_ticks(session, 100)
    for key in before:
        session.key(key)
    pass_ticks(session, 5)
    session.key("escape")
    assert session.over
    assert session.failure is None
    recording = Recording.open(tmp_path / "run")
    assert recording.complete
    last = max(recording.commands)
    assert last == recording.ticks - 1
    assert recording.commands[last] == ((0x200, bytes(8)),)


def test_a_bench_that_raises_ends_the_session_and_closes_the_recording(tmp_path):
    job, keyboard = a_job()
    recorder = job.recorder(tmp_path / "run")

    def inputs(tick):
        if tick == 30:
            raise ZeroDivisionError("a fault for the test")
        return keyboard.inputs(tick)

    session = Session(InlineLink(job.bench, inputs, Granted(), takers=[recorder]), keyboard=keyboard)
    pass_ticks(session, 50)
    assert session.over
    assert isinstance(session.failure, BenchStopped)
    assert "tick 30" in str(session.failure)
    assert Recording.open(tmp_path / "run").ticks == 30
    session.key("w")
    session.leave()
    assert session.link.now_tick == 30, "nothing runs after a failure"


def test_a_recorder_that_fails_while_leaving_is_told():
    class Full:
        def add(self, out):
            pass

        def close(self):
            raise RecordingError("no room")

    session = at_the_keys(takers=[Full()])
    session.leave()
    assert session.over
    assert str(session.failure) == "no room"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    directory = tmp_path_factory.mktemp("tui") / "my_run"
    job, keyboard = a_job()
    session = Session(
        InlineLink(job.bench, keyboard.inputs, Granted(), takers=[job.recorder(directory)]), keyboard=keyboard
    )
    pass_ticks(session, 50)
    session.key("enter")
    for _ in range(8):
        pass_ticks(session, 50)
        session.key("w")
    session.leave()
    return directory


def a_replay(directory, **options):
    job = from_recording(directory, **options)
    lamp, summary = GoldenLamp(Recording.open(directory)), Summary(3)
    link = InlineLink(job.bench, job.inputs, Granted(), takers=[lamp, summary], ticks=job.ticks)
    return Session(link, job=job, lamp=lamp, summary=summary)


@pytest.mark.parametrize("recorded_can", [False, True])
def test_a_replay_shows_where_it_is_and_that_it_is_identical(recorded, recorded_can):
    session = a_replay(recorded, recorded_can=recorded_can)
    pass_ticks(session, 200)
    assert "0.2 of 0.5 s  ✓ identical so far" in words(session)
    for key in ("w", "space", "enter", "f", "t", "c", "+", "-", "up"):
        session.key(key)
        assert "a replay: no key drives it" in words(session), key
    pass_ticks(session, 10_000)
    pass_ticks(session, 10_000)
    text = words(session)
    assert "✓ identical" in text
    assert "so far" not in text
    assert " ENDED" in text
    assert "golden    identical" in text
    assert "drove     " in text
    assert "link      live from 0.00 s" in text
    session.key("p")
    assert "the run has ended" in words(session)
    assert not session.over
    session.key("escape")
    assert session.over
    assert session.failure is None


def test_a_run_without_a_golden_says_so():
    job = from_scenario(SCENARIO)
    session = Session(InlineLink(job.bench, job.inputs, Granted(), ticks=job.ticks), job=job)
    pass_ticks(session, 100)
    assert "no golden to compare with" in words(session)
    assert "demo m2006, uart12" in words(session)


# --- the app -------------------------------------------------------------------------------------------------------


EFFECTS = {
    "w": lambda now: now.sticks[0] > 0, "up": lambda now: now.sticks[0] > 0, "s": lambda now: now.sticks[0] < 0,
    "down": lambda now: now.sticks[0] < 0, "a": lambda now: now.sticks[1] > 0, "left": lambda now: now.sticks[1] > 0,
    "d": lambda now: now.sticks[1] < 0, "right": lambda now: now.sticks[1] < 0, "q": lambda now: now.sticks[2] > 0,
    "e": lambda now: now.sticks[2] < 0, "W": lambda now: now.sticks[0] > 0, "f": lambda now: now.field_centric,
    "enter": lambda now: not now.armed, "space": lambda now: not now.armed,
}  # fmt: skip


def test_every_driving_key_reaches_the_robot():
    async def steps(app, pilot):
        for key, has_effect in EFFECTS.items():
            frame(app, 300)
            if not app.session.link.latest().armed:
                app.session.key("enter")
                frame(app, 200)
            assert not has_effect(app.session.link.latest()), key
            await pilot.press(key)
            frame(app)
            assert has_effect(app.session.link.latest()), key

    piloted(armed(), steps)


def test_every_other_key_does_what_it_says():
    async def steps(app, pilot):
        keyboard, link = app.session.keyboard, app.session.link
        seen = []
        for key, look in (
            ("plus", lambda: keyboard.sticks.power_percent), ("=", lambda: keyboard.sticks.power_percent),
            ("minus", lambda: keyboard.sticks.power_percent), ("t", lambda: keyboard.transmitter.on),
            ("c", lambda: keyboard.core_asks), ("p", lambda: link.paused), ("p", lambda: link.paused),
            ("]", lambda: link.pacer.rate), ("[", lambda: link.pacer.rate), ("z", lambda: app.session.scene().zoom),
            ("?", lambda: app.session.scene().help), ("escape", lambda: app.session.scene().help),
        ):  # fmt: skip
            await pilot.press(key)
            seen.append(look())
        assert seen == [60, 70, 60, False, True, True, False, 2.0, 1.0, True, True, False]
        assert not app.session.over, "Escape closed the page of keys, not the dashboard"

    piloted(armed(), steps)


@pytest.mark.parametrize("key", ["escape", "ctrl+q", "ctrl+c"])
def test_every_way_out_ends_the_app_with_a_stopped_robot(key):
    async def steps(app, pilot):
        await pilot.press("w")
        await pilot.press(key)
        await pilot.pause()

    app = piloted(armed(), steps)
    assert app.session.over
    assert app.session.failure is None
    assert not app.session.link.latest().armed
    assert not app.return_code


def test_a_signal_to_end_is_as_good_as_a_key():
    before = signal.getsignal(signal.SIGTERM)

    async def steps(app, pilot):
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(100):
            if app.session.over:
                break
            await pilot.pause(0.02)

    app = piloted(armed(), steps)
    assert app.session.over
    assert not app.session.link.latest().armed
    assert signal.getsignal(signal.SIGTERM) is before


def test_losing_the_focus_lets_go_of_the_keys():
    async def steps(app, pilot):
        await pilot.press("w")
        app.post_message(events.AppBlur())
        await pilot.pause()
        frame(app, 11)
        assert app.session.link.latest().sticks == (0.0, 0.0, 0.0)

    piloted(armed(), steps)


def test_the_screen_holds_what_the_view_says_and_survives_every_size():
    async def steps(app, pilot):
        for width, height in ((80, 24), (120, 40), (60, 16), (50, 10), (10, 3), (200, 60), (80, 24)):
            await pilot.resize_terminal(width, height)
            await pilot.pause()
            frame(app)
            await pilot.pause()
            assert on_screen(app, width, height) == picture(app.session.scene(), width, height), (width, height)
        await pilot.press("?")
        frame(app)
        await pilot.pause()
        assert on_screen(app, 80, 24) == picture(app.session.scene(), 80, 24)

    piloted(armed(), steps)


def test_only_lines_that_changed_are_drawn_again():
    async def steps(app, pilot):
        frame(app)
        await pilot.pause()
        arena, title = app.query_one("#arena"), app.query_one("#title")
        before = [arena.render_line(y) for y in range(arena.size.height)], title.render_line(0)
        frame(app)
        await pilot.pause()
        assert all(arena.render_line(y) is strip for y, strip in enumerate(before[0]))
        assert title.render_line(0) is not before[1]

    piloted(armed(), steps)


def test_a_frame_never_runs_more_than_the_burst():
    class Clock:
        ns = 0

        def __call__(self):
            self.ns += 10_000_000_000
            return self.ns

    job, keyboard = a_job()
    link = InlineLink(job.bench, keyboard.inputs, WallPacer(burst_ticks=30, read_ns=Clock()))
    session = Session(link, keyboard=keyboard)
    session.frame()
    for frames in (1, 2, 3):
        session.frame()
        assert link.now_tick == 30 * frames
    assert "slipped 29910 ms" in words(session, 120)
    assert "slipped 29.9 s" in words(session)


def test_a_failure_ends_the_app():
    job, keyboard = a_job()

    def inputs(tick):
        raise ZeroDivisionError("a fault for the test")

    async def steps(app, pilot):
        frame(app)
        await pilot.pause()

    app = piloted(Session(InlineLink(job.bench, inputs, Granted()), keyboard=keyboard), steps)
    assert "ZeroDivisionError" in str(app.session.failure)


def test_what_was_said_last_does_not_stand_before_the_keys_of_time():
    session = at_the_keys()
    pass_ticks(session, 100)
    session.key("m")
    assert "M gives the mouse back" in words(session)
    session.key("p")
    assert "P go on" in words(session)
    assert "M gives the mouse back" not in words(session)
    session.leave()


def test_a_robot_without_rc_can_be_watched():
    session = at_the_keys(replace(load_robot("m2006"), rc=None))
    pass_ticks(session, 100)
    session.key("w")
    assert "this robot takes no RC" in words(session)
    session.key("c")
    pass_ticks(session, 900)
    assert "the core drives" in words(session)
    session.leave()
    assert session.failure is None


@pytest.mark.parametrize("keys", ["", "?", "2", "3", "4", "2/20", "3v", "3n", ":", ":go", "x", "o", "m", "p", "p,"])
def test_space_stops_the_robot_whatever_is_open_and_enter_is_there_to_arm(keys):
    session = armed()
    pass_ticks(session, 600)
    for key in keys:
        session.key(key)
        pass_ticks(session, 20)
    assert session.link.bench.base.drive.armed
    assert " SPACE STOP " in words(session)
    assert " ENTER " in words(session)
    session.key("space")
    if session.link.paused:
        session.link.pause(False)
    pass_ticks(session, 75)
    assert not session.link.latest().armed
