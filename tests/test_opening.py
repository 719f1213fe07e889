"""The screen before the bench: every pane stands where it will, nothing of the bench is needed, no key is lost."""

import asyncio
import subprocess
import sys

import pytest
from desk import M2006, Granted, at_the_keys, frame, on_screen
from pty_terminal import PtyTerminal
from textual import events

from bench.arena import FIELD, load_arena
from bench.check.run import Run, bench_in, info_of
from bench.check.sources import from_recording, from_scenario
from bench.config import load_robot, robot_names
from bench.demo import SCENARIO
from bench.screen.keyboard import Keyboard
from bench.screen.layout import OVER, PANELS
from bench.screen.opening import (
    BUILDING,
    FIELD_M,
    Opening,
    opening_of,
    opening_of_recording,
    opening_of_scenario,
)
from bench.screen.session import session_of
from bench.screen.stage import to_show
from bench.screen.text import plain
from bench.screen.view import PANELS as DRAWN
from bench.screen.view import draw, picture, places
from bench.tui import READY_TICKS, Dashboard

SIZES = [(59, 20), (60, 16), (80, 24), (120, 40), (200, 60)]


def test_names_are_those_of_the_view():
    assert tuple(DRAWN) == PANELS
    assert PANELS[-len(OVER) :] == OVER
    assert (FIELD.length_m, FIELD.width_m) == FIELD_M


@pytest.mark.parametrize("name", robot_names())
def test_every_pane_stands_where_it_will(name, tmp_path):
    robot = load_robot(name)
    opening = opening_of(name, None, tmp_path / "none")
    assert opening == Opening(name, robot.rc.name if robot.rc else "", len(robot.wheels))
    stands_where_it_will(opening, at_the_keys(robot).scene())


def stands_where_it_will(opening, scene):
    for size in SIZES:
        opened = opening.picture(*size)
        assert {panel: place for panel, (place, _) in opened.items()} == places(scene, *size)
        for place, lines in opened.values():
            assert 0 < len(lines) <= place.height
            assert {len(plain(line)) for line in lines} == {place.width}
        whole = [plain(line) for line in opening.whole(*size)]
        assert {len(line) for line in whole} == {size[0]}
        assert not any("…" in line for line in whole), "it says no more than there is room for"
        for place, lines in opened.values():
            across = slice(place.x, place.x + place.width)
            assert [line[across] for line in whole[place.y : place.y + len(lines)]] == [plain(line) for line in lines]


def test_what_will_not_change_is_there_already(tmp_path):
    opened = opening_of(None, None, tmp_path / "none").picture(120, 40)
    scene = at_the_keys().scene()
    place, lines = opened["footer"]
    always = plain(draw("footer", scene, place.width, 1)[0])[-43:]
    assert "SPACE STOP" in always
    assert plain(lines[0]).endswith(always)
    place, lines = opened["arena"]
    assert lines[0] == draw("arena", scene, place.width, place.height)[0]
    assert plain(opened["title"][1][0])[:40] == plain(draw("title", scene, 120, 1)[0])[:40]


def test_the_remembered_robot_opens_and_one_that_is_gone_does_not(tmp_path):
    settings, own = tmp_path / "settings.toml", tmp_path / "own.toml"
    settings.write_text('robot = "omni4"\npower_percent = 50\n')
    assert opening_of(None, None, settings) == Opening("omni4", load_robot("omni4").rc.name, 4)
    assert opening_of("m2006", "elrs", settings) == Opening("m2006", "elrs", 3)
    settings.write_text(f'robot = "{own}"\n')
    assert opening_of(None, None, settings).name == "m2006"
    own.write_text('name = "mine"\n[[wheel]]\n[[wheel]]\n')
    assert opening_of(None, None, settings) == Opening("mine", "", 2)
    assert opening_of("nobody", None, settings) is None


def recorded(place, arena=FIELD):
    """A recording that ends before a base has seen its first frames, in an arena."""
    keyboard = Keyboard(M2006.rc)
    run = Run("", bench_in(M2006, arena), READY_TICKS // 2, keyboard.inputs, info_of(M2006))
    with run.recorder(place) as recorder:
        recorder.extend(list(run))
    return place


def test_a_run_that_is_shown_opens_under_its_name_in_its_arena(tmp_path):
    assert opening_of_recording(tmp_path) is None
    arena = SCENARIO.parent / "course.toml"
    run = recorded(tmp_path / "run", load_arena(arena))
    again = to_show(from_recording(run), None, Granted())
    demo = to_show(from_scenario(SCENARIO, arena=arena), None, Granted())
    for opening, stage, title in (
        (opening_of_recording(run), again, "run"),
        (opening_of_scenario(SCENARIO, str(arena)), demo, "demo"),
    ):
        assert opening == Opening("m2006", "uart12", 3, (4.0, 3.0), title)
        scene = session_of(stage).scene()
        stands_where_it_will(opening, scene)
        opened = opening.picture(120, 40)
        assert opened["arena"][1][0] == draw("arena", scene, *opened["arena"][0][2:])[0]
        assert plain(opened["footer"][1][0])[-18:] == plain(draw("footer", scene, 120, 1)[0])[-18:]
        assert plain(opened["title"][1][0])[:40] == plain(draw("title", scene, 120, 1)[0])[:40]
    hall = tmp_path / "hall.toml"
    for odd in (
        "length_m = 0.0\nwidth_m = 3.0\n",
        "length_m = 1.2.3\nwidth_m = 3\n",
        "[start]\nlength_m = 3.0\nwidth_m = 3.0\n",
    ):
        hall.write_text(odd)
        assert opening_of("m2006", None, tmp_path, str(hall)).field_m == FIELD_M


def test_the_first_frame_needs_nothing_of_the_bench():
    code = """
import sys, bench.tui
from pathlib import Path
from bench.__main__ import _parser
from bench.demo import SCENARIO
from bench.screen.opening import opening_of_recording, opening_of_scenario
_parser("drive").parse_args(["drive"])
_parser("demo").parse_args(["demo"])
opening_of_scenario(SCENARIO), opening_of_recording(Path("none"))
ours = ("config", "arena", "base", "check", "rc", "messages")
heavy = ("pymunk", "can", "serial", "numpy", *(f"bench.{name}" for name in ours))
print([name for name in heavy if name in sys.modules])"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("keys", "armed"), [(["enter"], True), (["enter", "space"], False), (["space", "enter"], True), (["w", "f"], False)]
)
def test_keys_pressed_while_the_bench_is_built_count_when_it_heeds_them(keys, armed, tmp_path):
    def prepare():
        for key in keys:
            app.post_message(events.Key(key, None))
        return at_the_keys()

    async def run():
        async with app.run_test(size=(80, 24)) as pilot:
            while not app.has_session:
                await pilot.pause()
            for _ in range(30):
                frame(app, 20)
                await pilot.pause()
            assert not app.query_one("#opening").display
            assert on_screen(app, 80, 24) == picture(app.session.scene(), 80, 24)

    app = Dashboard(None, prepare, opening_of(None, None, tmp_path / "none"))
    asyncio.run(run())
    snapshot = app.session.link.latest()
    assert snapshot.armed is armed
    assert snapshot.field_centric is ("f" in keys)


@pytest.fixture
def started(tmp_path):
    terminals = []

    def start(*command):
        terminals.append(PtyTerminal(tmp_path, "-m", "bench", *command))
        return terminals[-1]

    yield start
    for terminal in terminals:
        terminal.close()


SLOWLY = """
import sys, time
from pathlib import Path
from bench.tui import Dashboard
build = Dashboard._build
def slowly(self):
    while not Path("build").exists():
        time.sleep(0.01)
    build(self)
Dashboard._build = slowly
from bench.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def opened(tmp_path):
    """The screen that a command opens, with these keys pressed while its bench is being built."""
    terminals = []

    def start(keys, *command):
        (tmp_path / "build").unlink(missing_ok=True)
        terminal = PtyTerminal(tmp_path, "-c", SLOWLY, *command)
        terminals.append(terminal)
        terminal.wait_for(BUILDING.upper())
        terminal.type(keys)
        terminal.serve(0.1)
        assert not any(said in terminal.output for said in (b"not armed since boot", b"identical so far"))
        (tmp_path / "build").touch()
        return terminal

    yield start
    for terminal in terminals:
        terminal.close()


def test_a_key_that_comes_before_the_bench_waits_for_it(opened):
    terminal = opened(b"\r", "drive")
    terminal.wait_for(" ARMED ")
    terminal.type(b"\x1b")
    assert terminal.ended() == 0


def test_a_run_to_be_shown_is_built_behind_its_picture_and_heeds_the_keys_that_came_before(opened, tmp_path):
    """Also of a recording that ends before a base heeds any: nothing is to be armed."""
    for command in (("demo",), ("drive", "--replay", recorded(tmp_path / "run"))):
        terminal = opened(b"2", *command)
        terminal.wait_for(" id       what ")  # late ticks push the names of pages out of the title
        terminal.type(b"\x1b")
        assert terminal.ended() == 0


def test_what_is_refused_while_it_is_built_is_told_on_a_screen_given_back(started, tmp_path):
    run = recorded(tmp_path / "run")
    text = (run / "run.toml").read_text()
    (run / "run.toml").write_text(text.replace('robot = "m2006"', 'robot = "m2006"\ncontroller = "mine.py:Mine"'))
    for command, said in (
        (("drive", "--profile", "nobody"), "drive: no profile is called 'nobody'"),
        (("drive", "--replay", run), f"drive: {run}: was recorded with the controller mine.py:Mine"),
        (("demo", "--arena", "nowhere.toml"), "demo: nowhere.toml: "),
    ):
        terminal = started(*command)
        assert terminal.ended() == 2
        before, given_back, after = terminal.output.rpartition(b"\x1b[?1049l")
        assert BUILDING.upper().encode() in before
        assert given_back
        assert f"wheelbench {said}".encode() in after
        assert after.count(b"\n") == 1
        assert b"Traceback" not in terminal.output
