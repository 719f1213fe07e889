"""Keys that choose what is seen: pages, filter, hold, the scope's signals and trigger. Through the app, by Pilot."""

import pytest
from desk import armed, at_the_keys, frame, pass_ticks, piloted

from bench.screen.sight import Sight
from bench.screen.view import picture

FIRST = ("wheel1_wanted_radps", "wheel1_radps")


def words(session, width=80, height=24):
    session.sight.size = (width, height)
    return "\n".join(picture(session.scene(), width, height))


def typed(session, *keys):
    for key in keys:
        session.key(key)


def test_every_page_has_a_key_and_tab_goes_round():
    async def steps(app, pilot):
        seen = []
        for key in ("2", "3", "4", "1", "tab", "tab", "tab", "tab", "shift+tab"):
            await pilot.press(key)
            seen.append(app.session.scene().shown.page)
        pages = ["wires", "scope", "checks", "drive"]
        assert seen == [*pages, *pages, "checks"]
        await pilot.press("9")
        assert "there are 4 pages" in words(app.session)

    piloted(armed(), steps)


def test_a_filter_is_typed_as_text_and_drives_nothing():
    async def steps(app, pilot):
        session = app.session
        await pilot.press("/", "2", "0", "1", "w")
        assert session.scene().shown.filter == "201w"
        frame(app, 50)
        assert session.link.latest().sticks == (0.0, 0.0, 0.0), "w was a letter"
        await pilot.press("backspace")
        frame(app)
        text = words(session)
        assert " 201      front right" in text
        assert " 202      rear" not in text
        await pilot.press("enter", "w")
        frame(app, 50)
        assert session.link.latest().sticks[0] > 0.0, "the filter is kept, and w drives again"
        assert " 202      rear" not in words(session)
        await pilot.press("/", "escape")
        assert " 202      rear" in words(session)
        assert not session.over, "Escape left the filter, not the dashboard"

    piloted(armed(), steps)


def test_space_stops_whatever_is_being_typed():
    for opened in ("/", "v", "n"):

        async def steps(app, pilot, opened=opened):
            await pilot.press(opened)
            assert app.session.link.latest().armed
            await pilot.press("space")
            frame(app, 150)
            assert not app.session.link.latest().armed, opened

        piloted(armed(), steps)


def test_opening_a_text_lets_go_of_the_keys():
    session = armed()
    session.key("w")
    session.key("v")
    pass_ticks(session, 11)
    assert session.link.latest().sticks == (0.0, 0.0, 0.0)


def test_a_held_page_stands_still_while_the_bench_goes_on():
    async def steps(app, pilot):
        session = app.session
        await pilot.press("2")
        frame(app, 100)
        await pilot.press("h")
        before = words(session)
        tick = session.link.now_tick
        frame(app, 100)
        assert session.link.now_tick == tick + 100
        held = words(session)
        assert " HELD " in held
        assert held.splitlines()[3:-1] == before.splitlines()[3:-1]
        await pilot.press("h")
        frame(app, 100)
        assert " HELD " not in words(session)
        assert words(session).splitlines()[3:-1] != before.splitlines()[3:-1]
        await pilot.press("1", "h")
        assert "nothing to hold here" in words(session)

    piloted(armed(), steps)


def test_a_signal_is_chosen_by_a_part_of_its_name():
    async def steps(app, pilot):
        session = app.session
        await pilot.press("v", "o", "d", "o")
        assert " ▸ odo_x_m" in words(session)
        await pilot.press("down", "down", "up", "enter")
        frame(app)
        assert session.scene().shown.scope.signals == ("odo_y_m", FIRST[1])
        assert " 1 odo_y_m  +0.000 m" in words(session)
        await pilot.press("v", "tab", "tab", "a", "g", "e", "enter")
        frame(app)
        assert session.scene().shown.scope.signals == ("odo_y_m", FIRST[1], "command_age_ms")
        await pilot.press("v", "backspace")
        assert session.scene().shown.scope.signals == (FIRST[1], "command_age_ms")
        await pilot.press("escape", "v", "escape")
        assert not app.session.over

    piloted(armed(), steps)


def test_there_are_never_more_than_four_traces_nor_fewer_than_one():
    sight = Sight(tuple(f"s{number}" for number in range(9)), ("s0",))
    for number in range(1, 9):
        for key in ("v", *["tab"] * (len(sight.shown.scope.signals) % 4), *f"s{number}", "enter"):
            sight.key(key)
    assert len(sight.shown.scope.signals) == 4
    for _ in range(9):
        for key in ("v", "backspace", "escape"):
            sight.key(key)
    assert len(sight.shown.scope.signals) == 1


def test_a_name_that_no_signal_has_is_told_and_one_that_is_there_too():
    session = at_the_keys()
    typed(session, "v", "q", "q", "q", "enter")
    assert "no signal has 'qqq' in its name" in words(session)
    typed(session, "escape", "v", *"wheel1_radps", "enter")
    assert "wheel1_radps is there already" in words(session)


def test_the_trigger_is_set_by_arrows_and_digits():
    async def steps(app, pilot):
        session = app.session
        await pilot.press("n", "right", "down", "right", "down", *"1.5", "down", "left")
        scope = session.scene().shown.scope
        assert (scope.mode, scope.edge, scope.level, scope.span_ms) == ("normal", "falling", 1.5, 500)
        await pilot.press("up", *["backspace"] * 3, "minus", "2", "enter")
        assert session.scene().shown.scope.level == -2.0
        assert session.scene().shown.scope.shot == scope.shot + 1, "Enter arms it again"
        assert session.scene().shown.menu is None
        assert app.session.link.latest().armed, "Enter was the menu's"
        await pilot.press("n", "w")
        frame(app, 50)
        assert session.link.latest().sticks[0] > 0.0, "in the trigger's menu letters still drive"
        await pilot.press("escape")
        assert not session.over

    piloted(armed(), steps)


def test_arrows_step_the_level_by_a_part_of_what_is_shown():
    session = armed()
    typed(session, "3")
    for _ in range(20):
        session.key("w")
        pass_ticks(session, 50)
    picture = session.scene().seen.scope
    low = min(value for value in picture.traces[0].low if value == value)
    high = max(value for value in picture.traces[0].high if value == value)
    typed(session, "n", "down", "down", "right")
    assert session.scene().shown.scope.level == pytest.approx((high - low) / 20, abs=1e-6)


def test_the_scope_triggers_on_a_drive_of_the_robot():
    """A push of the stick: what wheel 1 wants rises through 1 rad/s, and the picture begins a fifth before that."""
    session = at_the_keys()
    typed(session, "3", "n", "right", "down", "down", *"1", "enter")
    pass_ticks(session, 50)
    session.key("enter")
    pass_ticks(session, 100)
    for _ in range(40):
        session.key("w")
        pass_ticks(session, 50)
    found = session.scene().seen.scope
    assert found.state == "triggered"
    assert found.start_tick == found.trigger_tick - 200
    assert "triggered" in words(session)
    at = len(found.traces[0].high) // 5
    assert max(found.traces[0].high[: at - 2]) <= 1.0 < max(found.traces[0].high[at : at + 3])


def test_only_what_a_page_shows_is_sampled():
    sight = Sight(FIRST, FIRST)
    assert (sight.look.wires, sight.look.log, sight.look.scope) == (True, 0, None)
    sight.key("2")
    assert sight.look.log == 24
    sight.key("3")
    assert sight.look.scope is not None
    assert not sight.look.wires
    sight.key("1")
    sight.size = (200, 60)
    assert sight.look.scope is not None
    assert sight.look.log == 60
