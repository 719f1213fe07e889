"""Wires and scope at an earlier instant: what they showed then, wherever in the run it lies."""

import random
import re
import sys
from pathlib import Path

import pytest
from desk import M2006, Granted, a_job, frame, pass_ticks, piloted

from bench.io import tap
from bench.io.follower import TRAIL_POINTS
from bench.io.look import Look
from bench.io.scope import ScopeSettings
from bench.io.still import again, still
from bench.io.wires import counts
from bench.io.wires.wiretap import Wiretap
from bench.screen.session import Session
from bench.screen.stage import to_drive
from bench.screen.view import picture

DASHBOARD = Path(__file__).parents[1] / "docs" / "dashboard.md"
SIGNALS = ("wheel1_wanted_radps", "wheel1_radps")
LOOK = Look(True, "", 30, ScopeSettings(SIGNALS, 500, "normal", "rising", 2.0), 160)
FREE = LOOK.scope._replace(mode="auto", level=1e6)
HELD = ("w", "", "q", "", "s", "wq", "c", "t", "t", "w", "")


@pytest.fixture(scope="module")
def drive():
    """A session on a link that forgets its ticks soon; 3 s driven, and what its wires and scope said after each 250."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tap, "KEPT_TICKS", 400)
        return a_drive()


def a_drive():
    job, keyboard = a_job(M2006)
    stage = to_drive(job, keyboard, Granted())
    session, said = Session(stage.link, keyboard=keyboard, job=job, agree=stage.agree), {}
    link = session.link
    pass_ticks(session, 50)
    session.key("enter")
    pass_ticks(session, 200)
    assert link.latest().armed
    for held in HELD:
        for _ in range(5):
            for key in held:
                session.key(key)
            pass_ticks(session, 50)
            seen = link.look(LOOK)
        said[link.now_tick] = seen
    session.key("p")
    return session, said


def built(link, wanted):
    """Ask, as a screen does, until all is there."""
    for _ in range(60):
        seen = link.look(wanted)
        if seen.building is None:
            return seen
        assert seen.wires is None
    raise AssertionError("never built")


def test_the_wires_at_any_instant_are_what_they_were(drive):
    session, said = drive
    link = session.link
    for tick in (2750, 1000, 1250, 500, 2250, 2000, 2500):
        link.see(tick)
        then, now = said[tick].wires, built(link, LOOK).wires
        assert now.tick == then.tick == tick - 1
        assert now.sums == then.sums, tick
        assert now.rows == then.rows, tick
        assert now.log == then.log[-len(now.log) :], tick
        assert len(now.log) == 30
    assert said[1000].wires.rows != said[2500].wires.rows
    link.see(link.newest_tick)
    assert link.look(LOOK).wires.rows == said[link.newest_tick].wires.rows


def test_the_scope_at_any_instant_is_what_it_was(drive):
    session, said = drive
    link = session.link
    triggers = set()
    for tick in (2750, 1250, 1750, 2250):
        link.see(tick)
        then, now = said[tick].scope, built(link, LOOK).scope
        assert now == then, tick
        triggers.add(now.trigger_tick)
        free = built(link, LOOK._replace(scope=FREE)).scope
        assert (free.state, free.start_tick) == ("free", tick - 500)
        (row,) = [out.state for out in link.between(tick - 10, tick) if out.state is not None]
        assert free.traces[1].last == row[link.bench.state_columns.index("wheel1_radps")], tick
    assert len(triggers) > 2


def test_steps_back_and_on_show_each_instant_and_a_filter_reaches_back(drive):
    session, _ = drive
    link = session.link
    link.see(2000)
    for step in (-100, -100, 1, -1, 100, -1000, 700):
        link.see(link.now_tick + step)
        table = built(link, LOOK).wires
        assert table.tick == link.now_tick - 1
        assert next(row for row in table.rows if row.key == "201").last_tick == link.now_tick - 1
    log = built(link, LOOK._replace(filter="core", scope=None)).wires.log
    assert {one.wire for one in log} == {"core"}
    assert log[0].tick < link.now_tick - 400 < log[-1].tick < link.now_tick


def test_a_fork_of_long_ago_goes_on_with_the_figures_of_then(monkeypatch):
    monkeypatch.setattr(tap, "KEPT_TICKS", 400)
    session, said = a_drive()
    link = session.link
    link.see(1250)
    session.key("g")
    assert link.newest_tick == 1250
    assert link.look(LOOK).wires.rows == said[1250].wires.rows
    session.key("p")
    pass_ticks(session, 200)
    rows = {row.key: row for row in link.look(LOOK).wires.rows}
    assert rows["201"].frames == 1450
    link.see(700)
    assert next(row for row in built(link, LOOK).wires.rows if row.key == "201").frames == 700


def test_the_past_is_bounded(monkeypatch):
    monkeypatch.setattr(counts, "MOST_KEPT", 4)
    job, _ = a_job(M2006)
    one = Wiretap(M2006)
    ticks = [job.bench.tick(job.inputs(tick)) for tick in range(200)]
    for start in range(0, 9000, 200):
        one.take([out._replace(tick=start + out.tick) for out in ticks])
    assert [kept.tick for kept in one._counts.kept] == [2000, 4000, 6000, 8000]
    assert (one.kept_before(7999), one.kept_before(8000), one.kept_before(1999)) == (6000, 8000, 0)


@pytest.mark.parametrize(("page", "words"), [("2", "newest frames"), ("3", "wheel1_radps")])
def test_scrubbed_pages_say_what_they_are_building_and_then_show_it(monkeypatch, page, words):
    monkeypatch.setattr("bench.io.past.PARTS_AT_ONCE", 1)
    monkeypatch.setattr(tap, "KEPT_TICKS", 400)
    session, _ = a_drive()

    async def steps(app, pilot):
        await pilot.press(page)
        frame(app, 0)
        for key in ("home", "pagedown", "pagedown", "left"):
            session.key(key)

        def text():
            return "\n".join(picture(session.scene(), 80, 24))

        assert "BUILDING 1.900 s AGAIN" in text()
        assert words in text(), "nothing jumps: what was shown stays until then"
        for _ in range(12):
            frame(app, 0)
        assert "BUILDING" not in text()
        assert words in text()
        await pilot.press("space", "p")
        assert "BUILDING" not in text()

    piloted(session, steps)


def size_of(kept):
    """Bytes of a value that is made of tuples and dicts."""
    parts = [*kept, *kept.values()] if isinstance(kept, dict) else kept if isinstance(kept, tuple) else ()
    return sys.getsizeof(kept) + sum(map(size_of, parts))


def test_ten_minutes_of_driving_take_what_the_page_says(drive):
    """What is kept once a second where the trail is as long as it can be, and what enters."""
    (told,) = re.findall(r"ten minutes of driving take some (\d+) MB", DASHBOARD.read_text(encoding="utf-8"))
    link = drive[0].link
    inputs = link.history.inputs.branch(link.newest_tick)
    inputs._pack()
    subject = again(link.history._stills[-1].taken)
    places = random.Random("a long trail")
    subject[1].trail.extend((places.uniform(-3.0, 3.0), places.uniform(-2.0, 2.0)) for _ in range(TRAIL_POINTS))
    wires = link._tap._wiretap._counts.kept[-1]
    a_second = len(still(subject)) + size_of(wires) + 1000 * inputs.bytes / link.newest_tick
    assert 600 * a_second == pytest.approx(float(told) * 1e6, rel=0.3)
