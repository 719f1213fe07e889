"""The checks of the wires as lamps: live while driving, the same verdicts as without a screen, and no more cost."""

import pytest
from desk import M2006, Granted, a_job, frame, pass_ticks, piloted

from bench.check.conduct import conduct
from bench.check.crosswire import Finding, Outcome
from bench.check.sources import from_scenario
from bench.screen import wire_lamps
from bench.screen.session import Session
from bench.screen.stage import to_drive, to_show
from bench.screen.view import picture
from bench.screen.wire_lamps import SWITCHED_OFF, WireLamps

MOTION, REST, ANSWERS, BUS = range(4)
ALL_FOUR = ("motion", "current at rest", "answers", "ids, rates, bus time")


def session_of(stage):
    parts = {"keyboard": stage.keyboard, "job": stage.job, "lamp": stage.lamp, "summary": stage.summary}
    return Session(stage.link, **parts, agree=stage.agree)


def at_the_keys():
    job, keyboard = a_job(M2006)
    session = session_of(to_drive(job, keyboard, Granted()))
    pass_ticks(session, 50)
    session.key("enter")
    pass_ticks(session, 200)
    assert session.link.latest().armed
    return session


def drive(session, keys, frames):
    for _ in range(frames):
        for key in keys:
            session.key(key)
        pass_ticks(session, 50)


def text(session, width=80, height=24):
    return "\n".join(picture(session.scene(), width, height))


def states(session):
    return [lamp.state for lamp in session.scene().agree]


def inject(session, words):
    session.key("x")
    for letter in words.replace(" ", ""):
        session.key(letter)
    session.key("enter")
    assert session.scene().dialog is None


def test_while_somebody_drives_each_check_has_a_lamp_with_word_and_reason():
    session = at_the_keys()

    async def steps(app, pilot):
        await pilot.press("4")
        assert "never stood long enough to be judged" in text(session)
        for _ in range(30):
            await pilot.press("w")
            frame(app, 50)
        frame(app, 1200)
        rows = text(session).splitlines()
        for name in ALL_FOUR:
            assert any(name in row and "✓ holds" in row for row in rows), name
        assert " agree   ✓ 4  … 0  ✗ 0" in text(session)
        assert "mm between" in text(session), "what was measured, and of how much"
        await pilot.press("1")
        assert "checks  ✓ 4" in text(session, 120, 40)

    piloted(session, steps)


def test_a_failed_check_is_a_word_a_reason_a_sentence_and_a_mark_on_every_page():
    session = at_the_keys()
    drive(session, "w", 10)
    inject(session, "feedback stuck")
    for _ in range(12):
        drive(session, "w", 4)
        if "failed" in states(session):
            break
    assert session.scene().agree[MOTION].state == "failed"
    pass_ticks(session, 0)
    assert "a check of the wires failed (motion" in text(session, 200, 60)
    assert "4 checks✗" in text(session, 100)
    session.key("4")
    assert " ✗ FAILED  motion" in text(session)
    assert " ✗ 1 FAILED " in text(session)
    assert "acted then" in text(session, 120, 40), "and the fault that somebody injected is named"
    drive(session, "", 60)
    session.key("p")
    pass_ticks(session, 0)
    assert "a check of the wires failed" not in text(session, 200, 60), "it is said once"


SCENARIO = """
schema = 1
name = "pushed"
seed = 3
seconds = 3.05
[[core]]
at_s = 0.1
vx_mps = 0.2
[[fault]]
wire = "feedback"
kind = "stuck"
at_s = 0.8
for_s = 0.9
[[fault]]
wire = "plant"
kind = "push"
at_s = 2.6
for_s = 0.2
force_n = 1.0
[checks]
bus = "off"
answers = "expected"
"""


def test_the_lamps_of_a_run_that_is_shown_say_what_a_run_without_a_screen_says(tmp_path):
    path = tmp_path / "pushed.toml"
    path.write_text(SCENARIO)
    alone = from_scenario(path, robot="slamware-b")
    conduct(alone)
    shown = from_scenario(path, robot="slamware-b")
    session = session_of(to_show(shown, None, Granted()))
    for ticks in (1, 49, 333, 50, 50, 900, 7, 1600):
        pass_ticks(session, ticks)
        session.scene()
    assert not session.link.ended
    assert states(session) == ["failed", session.scene().agree[REST].state, "not yet", SWITCHED_OFF]
    pass_ticks(session, 500)
    assert session.link.ended
    found = alone.checks.outcomes()
    assert shown.checks.outcomes() == found
    assert "acted then" in found[MOTION].findings[0].text
    assert states(session)[ANSWERS] == "failed", "expected, and it never came"
    assert "passed" in states(session) or states(session)[REST] == "untested"


def test_a_push_by_hand_is_no_current_at_rest():
    session = at_the_keys()
    drive(session, "", 16)
    inject(session, "push: ")
    drive(session, "", 60)
    assert states(session)[REST] == "holds"


def test_a_tick_costs_a_place_in_a_list_and_nothing_is_worked_out_twice(monkeypatch):
    session = at_the_keys()
    worked = []
    lamps = session._agree
    assert lamps.add.__self__ is lamps._ticks, "the list's own method"
    extend, told = lamps.checks.extend, lamps.checks.so_far
    monkeypatch.setattr(lamps.checks, "extend", lambda outs: (worked.append(len(outs)), extend(outs)))
    monkeypatch.setattr(lamps.checks, "so_far", lambda: (worked.append("told"), told())[1])
    session.link.run(350)
    assert worked == [], "not in the tick"
    for _ in range(3):
        session.scene()
    assert worked == [100, 100, 100, 100, "told"], "whole blocks, and time stands still"
    for _ in range(20):
        session.link.run(30)
        session.scene()
    assert worked[5:].count("told") == 1, "nobody reads faster than twice a second"
    for _ in range(3):
        session.scene()
    assert worked[5:] == [100] * 5 + ["told", 100, "told"]


def test_a_fork_is_judged_from_where_it_is_driven_on():
    session = at_the_keys()
    session.key("c")
    drive(session, "", 20)
    inject(session, "feedback stuck")
    drive(session, "w", 30)
    assert "failed" in states(session)
    session.key("p")
    for _ in range(16):
        session.key("left")
    assert "as they stand at the newest instant" in (session.key("4"), text(session))[1]
    session.key("g")
    at_s = session.link.now_tick / 1000
    assert f"since {at_s:.3f} s, where it was driven on" in text(session)
    session.key("p")
    session.key("c")
    drive(session, "w", 30)
    assert states(session) == ["holds", "untested", "holds", "holds"]
    assert session.scene().agree[ANSWERS].reasons[0].startswith("29 requests, 29 answers")


def test_a_run_on_real_ports_says_where_its_wires_are_judged():
    job, keyboard = a_job(M2006)
    stage = to_drive(job, keyboard, Granted())
    session = Session(stage.link, keyboard=keyboard, job=job)
    session.key("4")
    assert "its recording is: wheelbench check DIR" in text(session)


@pytest.mark.parametrize(
    ("state", "findings", "judged", "ended", "word"),
    [
        ("on", 0, 0, False, "untested"), ("on", 0, 3, False, "holds"), ("on", 0, 3, True, "passed"),
        ("on", 1, 3, False, "failed"), ("expected", 0, 3, False, "not yet"), ("expected", 1, 3, False, "passed"),
        ("expected", 0, 3, True, "failed"), ("off", 0, 0, False, SWITCHED_OFF),
    ],
)  # fmt: skip
def test_every_outcome_has_its_word(state, findings, judged, ended, word):
    outcome = Outcome("bus", state, (Finding("why", 1, 2),) * findings, judged, "measured", 0.5)
    lamp = wire_lamps._lamp(outcome, ended)
    assert lamp.state == word
    assert lamp.reasons


def test_a_lamp_needs_no_ticks():
    job, _ = a_job(M2006)
    lamps = WireLamps(wire_lamps.CrossWire(M2006, job.bench.state_columns))
    assert [lamp.name for lamp in lamps.lamps] == list(ALL_FOUR)
    assert lamps.news() == ""
    lamps.close()
    assert {lamp.state for lamp in lamps.lamps} == {"untested"}
