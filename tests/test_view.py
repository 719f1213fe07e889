"""What the dashboard says, as text: whole screens for a fixed scene, and what must hold for every size and value."""

import ast
import math
import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import pytest
from desk import AGREE, LAMPS, LOST_LINK, M2006, SCENE, TABLE, WIRES, armed, scene
from hypothesis import given, settings
from hypothesis import strategies as st

import bench.screen
from bench.config import load_robot
from bench.messages import BodyTwist, Pose, RcFrame
from bench.screen import text
from bench.screen.canvas import Canvas
from bench.screen.dialog import Dialog, Item
from bench.screen.layout import DRIVE, ENDED, HELP, LIVE, PAGES, arrange
from bench.screen.pages import (
    DRIVE_KEYS,
    DRIVE_NOTES,
    HOLD_NOTE,
    LAST_KEYS,
    LEASE_NOTE,
    REPLAY_NOTES,
    RUN_KEYS,
    SEE_KEYS,
    SIGNS,
)
from bench.screen.palette import ACTIONS, WORK_KEYS
from bench.screen.panel import STYLES
from bench.screen.scene import Hands, Menu, Pace, Replay, Shown
from bench.screen.view import PANELS, draw, picture, places
from bench.screen.wires import wires

MENUS = (
    ("wires", Menu("filter", "can")),
    ("scope", Menu("signal", "wheel", tuple(f"wheel{number}_radps" for number in range(1, 12)), 9, 1)),
    ("scope", Menu("trigger", "", ("auto", "rising", "0.5", "200 ms"), 2)),
)


def screen(what, width=80, height=24):
    return "\n".join(picture(what, width, height))


def words_in(rows):
    """What is to be read, digits apart."""
    return set(re.findall(r"[^\W\d_]{3,}", " ".join(rows)))


@pytest.mark.parametrize(
    ("changes", "state", "link"),
    [
        ({}, " ARMED ", "link +live"),
        (LOST_LINK, " DISARMED ", " LOST "),
        ({"link": "never seen", "link_age_ms": None, "armed": False}, " DISARMED ", "(?i) never seen "),
    ],
)
@pytest.mark.parametrize(
    "size", [(60, 16), (59, 16), (60, 15), (79, 23), (40, 12), (40, 50), (100, 10), (20, 5), (20, 4)]
)
def test_robot_arm_state_link_and_stop_are_whole_on_every_terminal(size, changes, state, link):
    for page in PAGES:
        rows = picture(scene(**changes, shown=Shown(page)), *size)
        whole = "\n".join(f" {row} " for row in rows)
        assert " m2006" in whole
        assert state in whole
        assert re.search(link, whole)
        assert " SPACE STOP " in rows[-1]


@pytest.mark.parametrize(
    ("size", "said"), [((8, 2), "ARMED SPACE"), ((17, 1), "ARMED SPACE"), ((10, 3), "ARMED link live SPACE STOP")]
)
def test_the_fewest_rows_tell_whether_it_is_armed_and_how_to_stop(size, said):
    assert screen(SCENE, *size).split() == said.split()


SCENES = (
    SCENE,
    scene(**LOST_LINK, recording="my_run", notice="transmitter off"),
    scene(pace=Pace(paused=True, behind_ticks=2300)),
    scene(hands=None, replay=Replay("demo", 20_000, "identical so far")),
    scene(hands=None, replay=Replay("a stop", 9, "identical", ("drove     5.64 m and turned 812 deg in 12.3 s",))),
    scene(hands=Hands(50, True, False, pad=(0.1, 0.2, 0.3))),
    scene(help=True),
    scene(dialog=Dialog("another robot", [Item("omni4", "", str), Item("m2006", "the default", str)]).shown),
    *(scene(shown=Shown(page), lamps=LAMPS, agree=AGREE) for page in PAGES),
    *(scene(shown=Shown(page, "20", False, menu)) for page, menu in MENUS),
)


@lru_cache
def known_words():
    """All that the dashboard can say: what its files say in so many words, and what wide screens show of the scenes."""
    files = Path(bench.screen.__file__).parent.glob("*.py")
    nodes = [node for file in files for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))]
    said = [node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    shown = [row for one in SCENES for row in picture(one, 300, 90)] + picture(SCENE, 160, 45)
    return words_in([*said, *(word.upper() for word in said), *shown])


@given(st.sampled_from(range(len(SCENES))), st.integers(8, 79), st.integers(1, 40))
@settings(max_examples=100)
def test_on_a_small_terminal_a_word_is_whole_or_not_there(number, width, height):
    rows = picture(SCENES[number], width, height)
    assert words_in(rows) <= known_words(), "\n".join(rows)
    assert not re.search(r"\S…", "\n".join(rows)), "\n".join(rows)


@given(
    st.integers(1, 250), st.integers(1, 80), st.integers(3, 8), st.floats(0.3, 4.0), st.booleans(),
    st.sampled_from([LIVE, HELP, ENDED]), st.sampled_from(PAGES), st.booleans(), st.integers(1, 2),
)  # fmt: skip
@settings(max_examples=200)
def test_panels_never_overlap_nor_leave_the_screen(width, height, count, aspect, replay, state, page, pad, rows):
    found = arrange(
        width, height, wheels=count, aspect=aspect, replay=replay, state=state, page=page, pad=pad, strip_rows=rows
    )
    cells = set()
    for name, place in found.items():
        assert place.width > 0, name
        assert place.height > 0, name
        own = {(x, y) for x in range(place.x, place.x + place.width) for y in range(place.y, place.y + place.height)}
        assert not cells & own, name
        cells |= own
    assert all(0 <= x < width and 0 <= y < height for x, y in cells)
    if width >= 60 and height >= 16:
        assert {"title", "footer"} <= found.keys()
        if state == LIVE:
            assert ("pad" in found) is pad
            is_wide = width >= 170 and height - 9 * pad >= 50
            drives = {"status", "wheels"} | ({"wiretable", "scope"} if is_wide else set())
            assert (drives if page == DRIVE else {"strip"}) <= found.keys()


@given(
    st.integers(1, 220), st.integers(1, 70), st.booleans(), st.booleans(), st.sampled_from(PAGES),
    st.sampled_from([None, *(menu for _, menu in MENUS)]),
)  # fmt: skip
@settings(max_examples=80)
def test_every_size_draws_lines_of_exactly_that_width(width, height, page_of_keys, zoom, page, menu):
    shown = scene(help=page_of_keys, zoom=zoom, shown=Shown(page, "can", menu is None, menu), lamps=LAMPS)
    for name, place in places(shown, width, height).items():
        lines = draw(name, shown, place.width, place.height)
        assert len(lines) <= place.height
        assert {text.width_of(line) for line in lines} <= {place.width}, name


any_float = st.one_of(st.floats(-1e9, 1e9), st.sampled_from([0.0, -0.0, -1e-9, 1e300, math.inf, -math.inf, math.nan]))


@given(st.lists(any_float, min_size=16, max_size=16))
@settings(max_examples=50)
def test_no_value_breaks_the_screen(values):
    near = [max(-1e7, min(1e7, value)) if value == value else 0.0 for value in values]
    shown = scene(
        pose=Pose(*near[:3]), odometry=Pose(*near[3:6]), twist=BodyTwist(*values[6:9]),
        wheel_wanted_radps=tuple(near[9:12]), wheel_radps=tuple(near[12:15]), wheel_current_a=(near[15],) * 3,
    )  # fmt: skip
    for zoom in (False, True):
        rows = picture(replace(shown, zoom=zoom), 80, 24)
        assert all(len(row) <= 80 for row in rows)


def test_columns_stand_still_whatever_the_numbers_are():
    """Words begin where they began: numbers keep their width."""
    after = scene(twist=BodyTwist(-0.999, 0.1, -3.25), pose=Pose(-2.9, 1.9, -3.1), wheel_radps=(-40.0, 0.0, 3.0))
    for before_row, after_row in zip(picture(SCENE, 80, 24)[9:], picture(after, 80, 24)[9:], strict=True):
        for word in ("m/s", "rad/s", "deg", "A ", "mA"):
            assert after_row[35:].find(word) == before_row[35:].find(word)


def test_the_whole_screen_at_120x40_has_headings_and_room():
    rows = picture(SCENE, 120, 40)
    assert len(rows) == 40
    assert rows[27] == "" == rows[32]
    assert rows[33].split() == ["wire", "ago", "last", "frame"]
    assert "field-centric" not in rows[39]
    assert rows[39].endswith(" SPACE STOP   ? help  Esc quit")


def test_colour_is_never_all_that_tells():
    """The same words and signs stand in a picture without colour."""
    lost = screen(scene(**LOST_LINK))
    assert " DISARMED " in lost
    assert " LOST " in lost
    assert " LIMIT" in screen(SCENE)
    assert " LIMIT" not in screen(scene(wheel_current_a=(0.58, -0.3, 0.0)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"driver": "core"}, "the core drives"),
        ({"driver": "none"}, "nobody drives"),
        ({"field_centric": True}, "field-centric"),
        ({"link": "hold", "link_reason": "silence"}, "silence"),
        ({"link": "neutral", "link_reason": "failsafe flag"}, " NEUTRAL "),
        ({"link": "never seen", "link_age_ms": None, "rc_frame": None}, "never seen"),
        ({"core_alive": False}, "silent"),
        ({"core_connected": False}, "not connected"),
        ({"armed": False, "why_disarmed": "AUX1"}, "why    AUX1"),
        ({"pace": Pace(paused=True)}, " PAUSED"),
        ({"pace": Pace(1.0, 0.61, 250, 4321)}, "×0.61   slipped 4.3 s"),
        ({"recording": "my_run"}, "● REC my_run"),
        ({"robot": replace(M2006, rc=None)}, "m2006, no RC"),
        ({"notice": "time runs ×2"}, " time runs ×2"),
    ],
)
def test_what_is_said_when(changes, words):
    assert words not in screen(SCENE)
    assert words in screen(scene(**changes))


NO_RC = {
    "robot": replace(M2006, rc=None),
    "link": "no rc",
    "link_age_ms": None,
    "hands": Hands(50, None, False, arms=False),
}


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16), (40, 12)])
def test_a_robot_without_rc_is_offered_no_key_of_a_transmitter_and_its_link_is_no_fault(page, size):
    rows = picture(scene(**NO_RC, shown=Shown(page)), *size)
    assert "NO RC" not in "\n".join(rows)
    assert "no rc" in "\n".join(rows)
    foot = rows[-1]
    assert not re.search("ENTER|WASD| T ", foot)
    assert foot.index("SPACE STOP") == picture(SCENE, *size)[-1].index("SPACE STOP")
    assert ("C core's arc off" in foot) is (size[0] >= 80)
    assert " C " in foot or size[0] == 40


def test_a_core_that_is_real_is_not_offered_to_be_asked():
    for hands in (Hands(50, None, None, arms=False), Hands(50, True, None)):
        assert "core's" not in screen(scene(hands=hands), 160, 40)


def test_the_robot_is_where_it_is_and_looks_where_it_looks():
    for x, y, heading, arrow, column, row in (
        (0.0, 0.0, 0.0, "→", 17, 7), (2.9, 1.9, math.pi / 2, "↑", 32, 2), (-2.9, -1.9, math.pi, "←", 1, 12),
        (-2.9, 1.9, -math.pi / 4, "↘", 1, 2),
    ):  # fmt: skip
        pose = Pose(x, y, heading)
        rows = picture(scene(pose=pose, odometry=pose, trail=[]), 80, 24)
        found = [(line.index(arrow), number) for number, line in enumerate(rows) if arrow in line[:34] and number != 13]
        assert len(found) == 1, (arrow, rows)
        assert abs(found[0][0] - column) <= 1
        assert abs(found[0][1] - row) <= 1


def test_a_robot_outside_of_the_picture_is_left_out():
    far = Pose(40.0, 0.0, 0.0)
    assert "→" not in screen(scene(pose=far, odometry=far))


def test_odometry_that_went_astray_is_a_cross_of_its_own():
    rows = picture(scene(odometry=Pose(-2.0, 1.0, 0.0)), 80, 24)[2:13]
    crosses = [(row.index("+"), number) for number, row in enumerate(rows) if "+" in row[:34]]
    assert crosses == [(6, 2)]


def test_zoomed_the_robot_is_a_ring_in_the_middle_and_walls_are_drawn():
    pose = Pose(2.8, 0.0, 0.0)
    rows = picture(scene(zoom=True, pose=pose, odometry=pose, trail=[]), 80, 24)
    assert rows[7][17] == "+"
    assert "1 m across" in rows[1]
    wall = [row[1:34] for row in rows[2:13]]
    assert all(any(sign in "⡇⢸" for sign in row[20:]) for row in wall)


def test_a_canvas_of_braille():
    canvas = Canvas(2, 1)
    for u, v in ((0, 0), (1, 3), (2, 0), (3, 0), (-1, 0), (4, 0), (0, 4), (0.5, -0.5)):
        canvas.dot(u, v, text.TRAIL)
    assert [text.plain(line) for line in canvas.lines()] == ["⢁⠉"]


def test_a_trace_is_joined_to_the_column_before_it_but_not_over_a_gap_and_has_its_own_colour():
    canvas = Canvas(4, 2)
    canvas.stipple(text.GRID, y=7)
    canvas.trace([(0, 0), (3, 3), None, (7, 7), (0, 0), None, None, (4, 5)], text.OTHER_TRACE)
    upper, lower = canvas.lines()
    assert (text.plain(upper), text.plain(lower)) == ("⢱ ⡇ ", "⡀⣀⡇⡘")  # the grid: the left dot of each lowest row
    assert upper == [("⢱ ⡇ ", text.OTHER_TRACE)]
    assert lower == [("⡀", text.GRID), ("⣀⡇⡘", text.OTHER_TRACE)]


def test_bars():
    assert text.swing_bar(0.0, 0.0, 10.0, 9) == "····│····"
    assert text.swing_bar(5.0, 10.0, 10.0, 9) == "····│██·◆"
    assert text.swing_bar(-99.0, -5.0, 10.0, 9) == "██◆█│····"
    assert text.fill_bar(0.0, 4) == "····"
    assert text.fill_bar(0.5, 4) == "██··"
    assert text.fill_bar(7.0, 4) == "████"
    assert text.fill_bar(3 / 32, 4) == "▍···"


def test_numbers_keep_their_width():
    assert text.signed(0.0, 7, 3) == text.signed(-0.0001, 7, 3) == " +0.000"
    assert text.signed(-12.5, 7, 3) == "-12.500"
    assert text.signed(-123456.0, 7, 3) == "->>>>>>"


def test_lines_are_cut_with_an_ellipsis():
    line = [("abc", text.PLAIN), ("defg", text.GOOD)]
    assert text.plain(text.fit(line, 7)) == "abcdefg"
    assert text.plain(text.fit(line, 9)) == "abcdefg  "
    assert text.fit([*line, (" hij", text.WARN)], 10) == [*line, (" …", text.WARN), (" ", text.PLAIN)]
    assert text.plain(text.both_ends([("ab ", text.PLAIN), *line], [("xy", text.PLAIN)], 11)) == "ab …     xy"


@pytest.mark.parametrize(
    ("width", "shown"),
    [(10, "to 3.5 rpm"), (9, "to 3.5 …"), (8, "to 3.5 …"), (7, "to …"), (4, "to …"), (3, "…"), (1, "…"), (0, "")],
)
def test_a_line_is_cut_between_words_and_a_number_is_one(width, shown):
    assert text.plain(text.fit([("to 3", text.PLAIN), (".5 rpm", text.GOOD)], width)) == shown.ljust(width)


def test_what_is_too_long_for_a_word_is_cut_where_the_room_ends():
    path = [("in " + "x" * 40, text.PLAIN)]
    assert text.plain(text.fit(path, 30)) == "in " + "x" * 26 + "…"
    assert text.plain(text.fit(path, 15)) == "in …".ljust(15)


@pytest.mark.parametrize(
    ("names", "shown"),
    [
        (("front right", "a very_good", "rear"), ("front right", "a very_good", "rear")),
        (("wheel_front_right", "wheel_front_left", "wheel_rear"), ("front_right", "front_left", "rear")),
        (("front right wheel", "front left wheel", "rear wheel"), ("front right", "front left", "rear")),
        (("front right outermost drive wheel", "rear"), ("front right…", "rear")),
        (("wheel_of_mine_a", "wheel_of_mine_"), ("wheel_of_mi…", "wheel_of_mi…")),
        (("right_behind", "right_before_"), ("behind", "before_")),
        (("an only wheel",), ("an only whe…",)),
    ],
)
def test_wheels_are_told_apart_in_a_narrow_column(names, shown):
    assert text.short_names(names) == shown


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16), (40, 12)])
def test_a_wheel_with_a_long_name_has_its_row(size):
    names = ("wheel_front_right", "wheel_rear_in_the_middle", "wheel_front_left")
    rows = picture(scene(wheel_names=names), *size)
    for name in ("front_right", "rear_in_the…", "front_left"):
        (row,) = (row for row in rows if f" {name} " in row)
        assert " A" in row


def wire_rows(width, **changes):
    shown = scene(wires=replace(WIRES, **changes))
    return [text.plain(line) for line in wires(shown, width, 5)]


def test_wires_say_how_old_and_what():
    rc, command, feedback, request, answer = wire_rows(120)
    assert rc == " rc         4 ms  2176 2048 1024 2048 0 1   AA 08 80 08 00 04 00 08 00 00 01 55"
    assert command == " command    0 ms  200  -600  +120  -311    +0 mA"
    assert feedback.endswith("201  -5648 rpm  -600 mA   202   +688 rpm  +120 mA   203  +5751 rpm  +310 mA")
    assert request == " request   45 ms  0x41 vx +0.300 vy +0.000 w +0.000"
    assert answer.startswith(" answer    45 ms  OK dx +0.00 mm")


def test_wires_that_were_never_used_say_never():
    rows = wire_rows(80, rc=None, can_commands=None, can_feedback=None, core_to_base=None, base_to_core=None)
    assert [row.split() for row in rows] == [
        ["rc", "never"], ["command", "never"], ["feedback", "never"], ["request", "never"], ["answer", "never"],
    ]  # fmt: skip


def test_frames_that_are_none_of_the_codecs_are_shown_as_bytes():
    odd = (12_345, ((0x200, b"\x01\x02"),))
    rows = wire_rows(80, can_commands=odd, can_feedback=odd)
    assert rows[1].endswith("200 01 02")
    assert rows[2].endswith("200 01 02")


def test_old_frames_are_counted_in_seconds():
    rows = [wire_rows(80, rc=(tick, b"\x00"))[0][10:17].strip() for tick in (12_345, 11_346, 11_345, 2_345)]
    assert rows == ["0 ms", "999 ms", "1.0 s", "10.0 s"]


def test_sixteen_channels_find_their_sticks():
    channels = tuple(range(100, 116))
    rows = picture(scene(rc_frame=RcFrame(0, 25, channels)), 80, 24)
    assert "ch2  102    ch3  103    ch0  100" in rows[6]


@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40), (80, 16)])
def test_strangers_on_the_bus_are_counted_and_the_newest_is_named(width, height):
    findings = ("0x205 unknown ESC, once since 0.001 s: an ESC", "0x20C foreign frame, 2 times since 0.010 s: no motor")
    (row,) = (row for row in picture(scene(bus_findings=findings), width, height) if " bus " in row)
    assert " 2  0x20C foreign frame, 2 times" in row
    assert not [row for row in picture(SCENE, width, height) if " bus " in row]


PAD = Hands(50, True, False, pad=(0.25, -0.5, 0.0), curve="expo 0.30, dead-band 5 %")


def test_every_role_has_a_style_and_every_panel_a_place():
    assert set(STYLES) == set(text.ROLES)
    everywhere = set()
    pages = [scene(shown=Shown(page)) for page in PAGES]
    listed = scene(dialog=Dialog("inject a fault", [Item("rc drop", "x", str)]).shown)
    ended = scene(hands=None, replay=Replay("x", 1, "", ("end",)))
    for shown in (*pages, listed, ended, scene(notice="long " * 30), scene(help=True), scene(hands=PAD)):
        for size in ((80, 24), (120, 40), (10, 3)):
            everywhere |= places(shown, *size).keys()
    assert everywhere == set(PANELS)


@pytest.mark.parametrize("releases", [False, True])
@pytest.mark.parametrize("drives", [False, True])
@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40), (200, 60)])
def test_the_page_of_keys_is_whole(width, height, drives, releases):
    hands = Hands(50, True, False, releases=releases) if drives else None
    replay = None if drives else Replay("demo", 20_000)
    words = screen(scene(help=True, hands=hands, replay=replay), width, height)
    assert "…" not in words
    keys = [*SEE_KEYS, *RUN_KEYS, *WORK_KEYS, *LAST_KEYS, *SIGNS, *(DRIVE_KEYS if drives else ())]
    for key, meaning in keys:
        assert f"{key:10}{meaning}" in words, key
    note = HOLD_NOTE if releases else LEASE_NOTE
    for sentence in (note, *DRIVE_NOTES) if drives else REPLAY_NOTES:
        assert sentence in " ".join(words.split())


@pytest.mark.parametrize("count", [1, 11, 61])
@pytest.mark.parametrize("size", [(120, 40), (100, 30), (80, 24), (60, 16), (40, 12)])
def test_a_list_fills_its_place_and_hides_no_more(size, count):
    """What a panel leaves over of its place is blank, and hides a row of those below."""
    listed = scene(dialog=Dialog("a list", [Item(f"thing {number}", "", str) for number in range(count)]).shown)
    place = places(listed, *size)["dialog"]
    rows = [text.plain(line) for line in draw("dialog", listed, place.width, place.height)]
    assert len(rows) == place.height
    assert sum("thing" in row for row in rows) == min(count, place.height - 3)
    assert (place.width == size[0]) is (size[0] < 100), "fragments of words beside it tell nothing"


@pytest.mark.parametrize("size", [(80, 24), (60, 16), (40, 12)])
def test_how_to_leave_a_list_or_a_menu_is_not_what_is_cut(size):
    working = armed().working
    for key in (":", "x"):
        working.key(key)
        assert " Esc leaves " in screen(scene(dialog=working.dialog.shown), *size)
        working.key("escape")
    for page, menu in MENUS:
        assert re.search(r"Esc (shows|leaves|closes)", screen(scene(shown=Shown(page, menu=menu)), *size))


def test_a_page_of_keys_that_is_not_whole_says_so():
    assert "more lines: 80x24 shows them" in screen(scene(help=True), 60, 16)


def test_a_title_has_its_pages_whatever_is_being_done():
    busy = scene(recording="m2006-001", saving="39 %", pace=Pace(paused=True, behind_ticks=200))
    row = screen(busy).splitlines()[0]
    assert "● REC m2006-001  SAVING 39 %  [1] 2  3  4 " in row
    assert "BACK 0.200 s" in row


ENDED_RUN = Replay("a stop", 12_346, "identical", tuple(f"fact{number}    of the run" for number in range(11)))


@pytest.mark.parametrize(("size", "facts"), [((120, 40), 11), ((80, 24), 8), ((60, 16), 3)])
def test_a_summary_that_is_not_whole_says_so_and_the_foot_has_the_keys_of_an_ended_run(size, facts):
    rows = picture(scene(hands=None, replay=ENDED_RUN), *size)
    assert sum("fact" in row for row in rows) == facts
    assert (f" … {11 - facts} more lines: a taller terminal shows them" in rows) is (facts < 11)
    assert rows[-1].startswith(f" ← → go back in it · G {'drive on from here' if size[0] > 60 else 'fork'}  ")


@pytest.mark.parametrize("size", [(80, 24), (40, 12)])
def test_an_ended_run_offers_no_pause_and_no_way_back_that_there_is_not(size):
    for goes_back in (True, False):
        foot = picture(scene(hands=None, replay=ENDED_RUN, pace=Pace(goes_back=goes_back)), *size)[-1]
        assert "P " not in foot
        assert ("← →" in foot) is goes_back
        assert foot.endswith("Esc quit")


def test_the_frame_of_a_narrow_arena_says_what_it_has_room_for():
    slips = ((0.0, 0.0),)
    assert "└ ↑ robot  + odometry ─" in screen(SCENE)
    assert "└ ↑ robot  + odometry × slipped ─" in screen(scene(slips=slips))
    assert "└ × slipped ─" in screen(scene(slips=slips, hands=None, replay=Replay("demo", 20_000)))


@pytest.mark.parametrize(
    ("width", "middle"),
    [
        (80, "  50 ms a division, 500 ms across, trigger at 11.900 s  "),
        (66, "  50 ms a division, trigger at 11.900 s  "),
        (45, "  50 ms a division  "),
    ],
)
def test_the_time_below_the_scope_is_cut_by_its_least_words(width, middle):
    row = text.plain(draw("scope", scene(shown=Shown("scope")), width, 12)[-1])
    assert row.startswith(f"{'':9}-100 ms{middle}")
    assert row.endswith("  400 ms ")


def test_a_pressed_bumper_is_a_word_in_the_frame_and_an_arc_outside_of_the_ring():
    against = Pose(3.0 - M2006.body.radius_m, 0.0, 0.0)
    apart = against._replace(x_m=2.0)
    for size, said in (((80, 24), "└ BUMPER left right ─"), ((60, 16), "└ BUMPER ─")):
        assert said in screen(scene(pose=against, odometry=against), *size)
        assert "BUMPER" not in screen(scene(pose=apart, odometry=apart), *size)
    here = scene(pose=against, odometry=against, zoom=True, trail=[])
    blind = replace(here, robot=replace(M2006, fittings=replace(M2006.fittings, bumpers=())))
    orange, none = (
        sum(role == text.WARN for line in draw("arena", one, 60, 30) for _, role in line) for one in (here, blind)
    )
    assert orange > none == 0


LONG = replace(M2006, name="champion-of-the-regional-preliminaries-2026")


@pytest.mark.parametrize("robot", [M2006, LONG])
@pytest.mark.parametrize("width", [60, 80, 100])
def test_a_title_has_its_pages_and_tells_a_recording_and_an_earlier_instant(width, robot):
    """A name, the robot's or the recording's, gives way."""
    back = Pace(paused=True, behind_ticks=200)
    row = picture(scene(robot=robot, recording=f"{robot.name}-001 21 %", pace=back), width, 24)[0]
    assert row.startswith(f" {robot.name[:9]}")
    assert "  ● REC" in row
    assert "  [1] 2  3  4 " in row
    assert row.endswith("  12.346 s  BACK 0.200 s")


LATE = (Pace(1.0, 0.61, 52, 432), Pace(1.0, 0.61, 250, 4_321), Pace(0.5, 0.42, 9_999, 987_654))


@pytest.mark.parametrize("pace", LATE)
def test_lateness_takes_no_page_from_the_title_nor_a_key_from_the_foot(pace):
    assert "×0.61   late 250 ms, slipped 4321 ms" in screen(scene(pace=LATE[1]), 120)
    for width, robot in ((60, M2006), (60, LONG), (80, M2006), (80, LONG), (120, LONG)):
        late, in_time = (
            picture(scene(robot=robot, pace=one), width, 24) for one in (pace, replace(pace, slipped_ticks=0))
        )
        tabs = re.search(r"\[1.*4( checks)? ", in_time[0])[0]
        assert ("checks" in tabs) is (width > 80 or (robot is M2006 and width > 60))
        assert tabs in late[0], late[0]
        assert f"×{pace.speed:.2f}" in late[0]
        assert late[-1] == in_time[-1]
        assert late[-1].endswith("? help  Esc quit")
    for width in (60, 80):
        assert f"slipped {text.age(pace.slipped_ticks)}" in screen(scene(pace=pace), width)


def test_a_failed_check_is_marked_in_the_title_of_every_size_that_has_pages():
    for width, robot in ((60, M2006), (60, LONG), (80, LONG), (120, LONG)):
        row = picture(scene(robot=robot, recording="run 21 %", agree=AGREE), width, 24)[0]
        assert re.search(" 4( checks)?✗ ", row), row


@pytest.mark.parametrize(
    ("size", "address"),
    [
        ((80, 24), "can:slcan:/dev/serial/by-id/usb-CANable-adapter-01234567-if00-port0:"),
        ((40, 12), "slcan:/dev/ttyCAN-01-of-the-robot:"),
    ],
)
def test_a_port_in_a_notice_is_not_broken_where_its_name_has_a_hyphen(size, address):
    rows = picture(
        scene(notice=f"--can is what {address} was: lost (the other end has closed it); zero until it is back"), *size
    )
    assert any(address in row for row in rows), rows


LACKS = "it has no axis 2 (turn), no button 1 (stop); another --gamepad-map may fit"


@pytest.mark.parametrize(
    ("source", "state"),
    [("gamepad", "let its sticks go first"), ("gamepad", LACKS), ("receiver", "cut off; Enter lets it through")],
)
@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16), (40, 12), (170, 50)])
def test_why_what_has_the_sticks_does_not_drive_is_told_on_every_size(size, source, state):
    stands = Hands(50, True, False, arms=source == "gamepad", source=source, source_state=state)
    rows = picture(scene(hands=stands), *size)
    told = " ".join(" ".join(row[row.rfind("│") + 1 :] for row in rows).split())
    assert f"{source}: {state[: 40 if state == LACKS else None]}" in told
    assert size[0] == 40 or rows[-1].startswith(f" I {source}")
    assert "…" not in rows[-1]
    assert state not in screen(scene(hands=stands, pace=Pace(paused=True)), 60, 16), "time stands still anyhow"
    said = screen(scene(hands=stands, notice="transmitter off"), *size)
    assert "transmitter off" in said
    silent = "the terminal does not answer: sticks at rest, only Space is heard, and whatever else one could say of it"
    told = " ".join(screen(scene(hands=stands, notice=silent), *size).split())
    assert "the terminal does not answer" in told
    assert size[0] in (40, 170) or f"{source}: {state[:40]}" in told, "below it, since it may stand for long"
    drives = picture(scene(hands=replace(stands, source_state="")), *size)
    assert size[0] == 40 or drives[-1].startswith(f" I {source}")
    assert f"{source}:" not in "\n".join(drives)


@pytest.mark.parametrize("size", [(59, 16), (40, 12)])
def test_on_a_small_terminal_what_has_failed_is_told_and_what_has_the_mouse(size):
    words = " ".join(screen(scene(agree=AGREE, lamps=LAMPS), *size).split())
    red = [lamp.name for lamp in (*LAMPS, *AGREE) if lamp.state == "failed"]
    assert red
    assert f"✗ FAILED: {', '.join(red)}" in words
    assert "FAILED" not in screen(SCENE, *size)
    assert "the mouse's sticks; M gives the mouse back" in " ".join(screen(scene(hands=PAD), *size).split())
    assert "mouse" not in screen(SCENE, *size)


@pytest.mark.parametrize(
    ("width", "height", "pace", "shown"),
    [
        (40, 12, Pace(), " champion-of-the…  ● REC 12.346 s ×1.00"),
        (40, 12, Pace(paused=True, behind_ticks=200), " champion-of-the…  ● REC 12.346 s  BACK "),
        (24, 6, Pace(paused=True, behind_ticks=200), " champion…  ● REC  BACK "),
        (20, 5, Pace(paused=True), " champion…   PAUSED "),
        (9, 4, Pace(paused=True), "champion…"),
    ],
)
def test_on_a_small_terminal_a_long_name_hides_nothing_that_matters(width, height, pace, shown):
    assert picture(scene(robot=LONG, recording="run", pace=pace), width, height)[0] == shown.rstrip()


def test_on_a_small_terminal_an_instant_that_is_past_is_told_before_the_end_of_a_name():
    robot = replace(M2006, name="of_19_characters_in")
    for pace, row in ((Pace(), " of_19_characters_in"), (Pace(paused=True, behind_ticks=9), " of_19_char…   BACK")):
        assert picture(scene(robot=robot, pace=pace), 20, 5)[0] == row


@pytest.mark.parametrize("link", ["live", "hold", "lost", "neutral", "never seen", "degraded"])
@pytest.mark.parametrize("armed", [True, False])
def test_the_sticks_are_never_cut_on_the_line_of_every_page(link, armed):
    old = None if link == "never seen" else 99_999
    rows = screen(
        scene(
            shown=Shown("scope"), link=link, link_age_ms=old, armed=armed, why_disarmed="link lost: " + "why " * 20,
            sticks=(-1.0, 1.0, -1.0),
        )
    ).splitlines()[1:3]  # fmt: skip
    row = rows[0 if armed else 1]
    said = "sticks" if link in ("live", "degraded") else "were at"
    assert row.endswith(f" {said} -100 +100 -100 %")
    assert (" link live" if link == "live" else f"  {link.upper()} ") in row
    assert "…" in rows[0] or armed


@pytest.mark.parametrize("width", [60, 72, 80, 100, 200])
@pytest.mark.parametrize(
    "why",
    [
        "AUX1",
        "not armed since boot",
        "sticks were not at rest: arm again",
        "link lost: no good frame for 500 ms",
        "link lost: sticks frozen for 1000 ms",
    ],
)
def test_why_it_is_disarmed_is_whole_at_every_width_and_so_are_link_and_sticks(width, why):
    for link, state in (("live", " link live 9.9 s "), ("lost", " link  LOST  9.9 s ")):
        what = {"armed": False, "why_disarmed": why, "link": link, "link_age_ms": 9_900}
        assert why in screen(scene(**what), width)
        said = "  sticks " if link == "live" else " were at "
        rows = picture(scene(**what, shown=Shown("wires")), width, 24)
        assert rows[1].startswith(f"  DISARMED  {why}")
        last = 1 if width >= 100 or rows[1].endswith(" %") else 2
        assert state in rows[last]
        assert rows[last].endswith(f"{said} +50   +0  -25 %")
        assert rows[last + 1].split()[:2] == ["id", "what"], "and nothing of the page below is hidden"


def test_a_robot_without_rc_has_no_sticks_on_the_line_of_every_page():
    row = screen(scene(**NO_RC, shown=Shown("wires"))).splitlines()[1]
    assert row.endswith(" link no rc")


@pytest.mark.parametrize("pace", [Pace(), Pace(paused=True), Pace(paused=True, goes_back=False)])
@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_foot_offers_what_there_is_room_for_and_cuts_nothing(width, driven, pace):
    parts = {} if driven else {"hands": None, "replay": Replay("demo", 20_000)}
    foot = screen(scene(pace=pace, **parts), width, 24).splitlines()[-1]
    assert "…" not in foot
    assert ("go on" in foot or "P on" in foot) is pace.paused
    assert ("G " in foot) is (pace.paused and pace.goes_back and width > 60 - 30 * (not driven))


# --- what a person at a desk stumbled over ------------------------------------------------------------------------


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_columns_of_the_wires_stand_still_while_they_are_held(width):
    free, held = (picture(scene(shown=Shown("wires", held=one)), width, 24)[2] for one in (False, True))
    assert free.startswith(" id       what")
    assert held.startswith(free)
    assert re.search(r"  HELD ( at 12.345 s, )?H lets go$", held)
    assert (" at 12.345 s" in held) is (width > 60)


INVERTED = TABLE._replace(sums=(TABLE.sums[0]._replace(about="sbus 100000 8E2 inverted"), *TABLE.sums[1:]))


@pytest.mark.parametrize("table", [TABLE, INVERTED])
@pytest.mark.parametrize("width", [60, 72, 80, 100, 120])
def test_what_a_wire_is_called_moves_no_column_and_hides_no_error(width, table):
    rows = picture(scene(shown=Shown("wires"), seen=SCENE.seen._replace(wires=table)), width, 24)
    names = (" rc ", " can bus ", " control bus ")
    rc, *others = (next(row for row in rows if row.startswith(name)) for name in names)
    assert len({re.search(r"\d/s  ", row).start() for row in (rc, *others)}) == 1
    assert rc.endswith(" 12.5 % full  7 bytes refused" if width >= 110 else " 12.5 %  7 bytes refused")
    assert (table.sums[0].about in rc) is (width >= 72 + 8 * (table is INVERTED))


def test_one_is_no_plural():
    assert " 1 frame, 1 byte of noise" in screen(scene(rc_frames=1, rc_noise_bytes=1))
    one = TABLE._replace(sums=(TABLE.sums[0]._replace(errors=1), *TABLE.sums[1:]))
    assert " 1 byte refused" in screen(scene(shown=Shown("wires"), seen=SCENE.seen._replace(wires=one)))


def test_four_wheels_tell_their_speed_in_a_row_that_has_no_room_for_more():
    frames = tuple((0x201 + number, bytes.fromhex("04D2 E9F0 FDA8 0000")) for number in range(4))
    for width, each in ((120, "-5648 rpm  -600 mA"), (90, "-5648/-600"), (80, "-5648")):
        row = wire_rows(width, can_feedback=(12_345, frames))[2]
        assert re.findall(r"20\d +(-5648(?:/-600| rpm  -600 mA)?)", row) == [each] * 4, width
    still = tuple((can_id, bytes(8)) for can_id, _ in frames)
    assert wire_rows(80, can_feedback=(12_345, still))[2].endswith("  201 +0  202 +0  203 +0  204 +0 rpm")


@pytest.mark.parametrize("width", [60, 67, 80])
def test_the_head_of_the_scope_and_of_its_menus_is_whole(width):
    head = picture(scene(shown=Shown("scope")), width, 24)[2]
    assert head.startswith("  triggered  auto: trace 1 rising through 5  ")
    assert head.endswith({60: " V N H", 67: " V signals N trigger", 80: " V signals N trigger H hold"}[width])
    for page, menu in MENUS:
        assert "…" not in "\n".join(picture(scene(shown=Shown(page, menu=menu)), width, 24)[-12:-1])


@pytest.mark.parametrize("width", [60, 80])
def test_a_list_cuts_no_action_and_no_key_of_its_own(width):
    for action in ACTIONS:
        listed = scene(dialog=Dialog("every action", [Item(action.words, action.printed, str)]).shown)
        assert re.search(f"▶ {re.escape(action.words)} +{re.escape(action.printed)} │", screen(listed, width))
    working = armed().working
    working.key("x")
    foot = next(row for row in picture(scene(dialog=working.dialog.shown), width, 24) if "Esc leaves" in row)
    assert re.fullmatch(r"└ for 2 s \(← →\) · Esc leaves · Enter injects( · type to narrow)? ─*┘", foot)


@pytest.mark.parametrize("size", [(60, 16), (60, 20), (80, 24)])
def test_what_the_mouses_sticks_make_of_a_way_is_whole(size):
    words = screen(scene(hands=PAD), *size)
    assert "full way 50 %" in words
    assert "expo 0.30, dead-band 5 %" in words


def test_since_when_the_wires_are_checked_is_whole_on_a_narrow_screen():
    forked = scene(shown=Shown("checks"), agree=AGREE, agree_since_tick=19_438)
    assert "since 19.438 s, where it was driven on" in screen(forked)
    (row,) = (row for row in picture(forked, 60, 24) if " agree " in row)
    assert row.endswith("  since 19.438 s")


def test_a_page_offers_no_key_that_does_nothing_to_be_seen_there():
    for parts in ({}, {"hands": None, "replay": Replay("demo", 20_000)}):
        feet = {page: picture(scene(shown=Shown(page), **parts), 120, 40)[-1] for page in PAGES}
        assert [page for page, foot in feet.items() if "Z follow" in foot] == ["drive"]
        assert [page for page, foot in feet.items() if "/ filter" in foot] == ["wires"]


@pytest.mark.parametrize(("name", "across"), [("m2006", 1), ("deadwheel3", 1), ("siegwart", 5)])
def test_from_close_by_the_whole_robot_is_there(name, across):
    robot = load_robot(name)
    here = scene(robot=robot, zoom=True, trail=[], pose=Pose(0.0, 0.0, 0.0), odometry=Pose(0.0, 0.0, 0.0))
    lines = draw("arena", here, 60, 22)
    assert f" {across} m across, around the robot " in text.plain(lines[0])
    inked = [[at for at, cell in enumerate(cells(line)) if cell[1] == text.ROBOT and cell[0] != " "] for line in lines]
    rows = [number for number, found in enumerate(inked) if found]
    assert 1 < rows[0] < 11 < rows[-1] < 20, "above and below there is room"
    columns = [at for found in inked for at in found]
    assert 1 < min(columns) < 30 < max(columns) < 58


def cells(line):
    return [(sign, role) for words, role in line for sign in words]


@pytest.mark.parametrize("width", range(58, 82, 3))
def test_a_number_and_its_unit_stay_together(width):
    reason = "at most 0 of 28 mA in 0.7 s of standing, in 3 windows of 9 deg"
    stood = AGREE[1]._replace(state="holds", reasons=(reason,))
    rows = [text.plain(line) for line in draw("checks", scene(shown=Shown("checks"), agree=[stood]), width, 40)]
    first = next(number for number, row in enumerate(rows) if stood.name in row)
    told = rows[first : rows.index(" wires".ljust(width)) - 1]
    assert len(told) > 1
    assert not [row for row in told if re.search(r"\d$", row.rstrip())]
    assert reason in " ".join(" ".join(told).split())


@pytest.mark.parametrize("size", [(60, 16), (60, 20), (80, 24), (120, 40)])
@pytest.mark.parametrize("hands", [PAD, replace(PAD, pad=None)])
def test_no_wheel_is_left_out_in_silence(size, hands):
    """Under the mouse's sticks there are few rows: the heading goes before a wheel does."""
    for count in (3, 4, 6):
        names = tuple(f"wheel {letter}" for letter in "abcdef"[:count])
        four = {f"wheel_{what}": (1.0,) * count for what in ("radps", "wanted_radps", "current_a")}
        wheeled = replace(M2006, wheels=(M2006.wheels * 2)[:count])
        rows = picture(scene(robot=wheeled, hands=hands, wheel_names=names, **four), *size)
        there = sum(row.startswith(f" {name} ") for row in rows for name in names)
        assert there == count or any(f"… {count - there} more lines: a taller terminal" in row for row in rows)
        assert there == count or (hands is PAD and size[0] == 60), "only under the sticks, and on a low screen"
