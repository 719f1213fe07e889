"""Any instant of a run again: what is shown is what was, to the last bit, through walls, discs, faults and forks."""

import pickle
from dataclasses import replace

import pytest
from desk import M2006, Granted
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.arena import FIELD, Disc
from bench.check.faults import Fault
from bench.config import load_robot
from bench.io import history
from bench.io.history import Inputs, LostInstant, Subject, mark_of
from bench.io.link import InlineLink
from bench.io.still import again, still
from bench.loop import NOTHING, simulated
from bench.messages import BodyTwist, TickInput
from bench.screen.keyboard import Keyboard

BOX = replace(FIELD, length_m=0.9, width_m=0.8)
"""So small that a robot is soon in a corner."""
DISCS = replace(BOX, length_m=1.6, discs=(Disc("a", 0.4, 0.0, 0.08, 0.5), Disc("b", 0.4, 0.3, 0.1, 1.0)))


class Outs:
    def __init__(self):
        self.outs = []
        self.add = self.outs.append


def exact(outs):
    """Outputs with every float to the last bit, and no -0.0 taken for 0.0."""
    return [(*out[:-1], repr(out.state)) for out in outs]


def driven(keys, arena=FIELD, robot=M2006, ticks_each=250, faults=()):
    """A remembering link that was driven: at full power, each entry of `keys` held for a while."""
    keyboard = Keyboard(robot.rc)
    keyboard.sticks.power_percent = 100
    outs = Outs()
    link = InlineLink(simulated(robot, arena), keyboard.inputs, Granted(), takers=[outs], remembers=True)
    link.run(50)
    keyboard.press("enter", 50, False)
    link.run(100)
    marks = {}
    faults = dict(faults)
    for number, held in enumerate(keys):
        if number in faults:
            link.join(faults[number])
        for _ in range(ticks_each // 50):
            for key in held:
                keyboard.press(key, link.now_tick, link.latest().armed)
            link.run(50)
            marks[link.now_tick] = mark_of(link.bench)
    return link, keyboard, outs.outs, marks


HELD = st.lists(
    st.sampled_from(["w", "s", "a", "d", "q", "wd", "sa", "wq", "de", "c", "f", "t", ""]), min_size=5, max_size=7
)


@settings(max_examples=3, deadline=None)
@given(keys=HELD, arena=st.sampled_from([FIELD, BOX, DISCS]), data=st.data())
def test_every_instant_is_shown_as_it_was(keys, arena, data):
    link, _, outs, marks = driven(keys, arena)
    newest = link.mark()
    for _ in range(3):
        tick = data.draw(st.sampled_from(sorted(marks)))
        link.see(tick)
        assert link.now_tick == tick
        assert mark_of(link.bench) == marks[tick]
        assert link.looks_back == (tick != len(outs))
    start = data.draw(st.integers(0, len(outs) - 200))
    subject = link.history.at(start, len(outs), link.mark())
    assert exact(link.history.go_on(subject, start + 200)) == exact(outs[start : start + 200])
    link.see(link.newest_tick)
    assert mark_of(link.bench) == newest


FAULTS = [
    Fault("rc drop 1", "rc", "drop", at=500, lasting=300),
    Fault("rc corrupt 1", "rc", "corrupt", at=500, lasting=600, probability=0.1),
    Fault("feedback corrupt 1", "feedback", "corrupt", at=500, lasting=600, probability=0.02),
    Fault("core delay 1", "core", "delay", at=450, lasting=600, ms=70),
    Fault("esc weak 1", "esc", "weak", at=500, lasting=600, factor=0.3, esc=2),
    Fault("plant push 1", "plant", "push", at=500, lasting=100, force_n=8.0),
    Fault("plant slippery 1", "plant", "slippery", at=500, lasting=500, factor=0.2),
    Fault("feedback stuck 1", "feedback", "stuck", at=500, lasting=200, esc=1),
    Fault("rc freeze 1", "rc", "freeze", at=500, lasting=300),
]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_faults_are_part_of_what_was(fault):
    link, _, outs, marks = driven(["w", "wd", "q"], faults={1: fault}, ticks_each=300)
    assert link.take_touches(), "the fault has done something"
    for tick in (850, 600):
        link.see(tick)
        assert mark_of(link.bench) == marks[tick]
    subject = link.history.at(0, len(outs), link.mark())
    assert exact(link.history.go_on(subject, len(outs))) == exact(outs)


def test_a_still_that_does_not_lead_to_what_was_is_not_used(monkeypatch):
    """In a corner the engine may meet two walls in another order after a copy: such a still is found and dropped."""
    link, _, _, marks = driven(["w", "wd", "s", "q"] * 2)
    kept = link.history._stills
    assert len(kept) > 1
    wrong = link.history.start().bench  # a still of another instant, as if it were this one's
    wrong.now_tick = kept[1].tick
    kept[1].taken = still((wrong, link.history.start().seen))
    tick = max(marks) - 100
    link.see(tick)
    assert mark_of(link.bench) == marks[tick]
    assert link.history.first == 0


def test_a_step_forward_costs_a_tick_and_no_more():
    link, *_ = driven(["w", "wd"])
    start = 50
    link.see(start)
    shown = link.bench
    for tick in range(start + 1, start + 10):
        link.see(tick)
        assert link.bench is shown
    link.see(start + 8)
    assert link.bench is not shown, "there is no running backwards"
    assert link.now_tick == start + 8


def test_looking_back_changes_nothing_of_the_run():
    one, keyboard, outs, _ = driven(["w", "wd", "q", "s"])
    other, other_keyboard, other_outs, _ = driven(["w", "wd", "q", "s"])
    for tick in (700, 3, 1150):
        one.see(tick)
    for link, hands in ((one, keyboard), (other, other_keyboard)):
        hands.press("w", link.newest_tick, True)
        link.run(300)
    assert exact(outs) == exact(other_outs)


@pytest.mark.parametrize("arena", [FIELD, BOX], ids=["field", "box"])
def test_a_fork_is_the_run_that_would_have_been(arena):
    """Driven on from an instant, the bench does what a run with the same inputs does from its start."""
    link, _, outs, marks = driven(["w", "wd", "q", "s"], arena)
    at = sorted(marks)[9]
    link.see(at)
    hands = Keyboard(M2006.rc)
    hands.sticks.power_percent = 70
    taken = Outs()
    link.fork(hands.inputs)
    link.takers = [taken]
    assert link.paused
    assert link.newest_tick == at
    assert link.mark() == marks[at]
    for key in ("d", "e", "w"):
        hands.press(key, link.now_tick, True)
        link.run(200)
    whole = link.history.go_on(link.history.start(), link.newest_tick)
    assert exact(whole[:at]) == exact(outs[:at])
    assert exact(whole[at:]) == exact(taken.outs)
    link.see(at + 150)
    assert link.now_tick == at + 150
    link.see(at - 400)
    assert mark_of(link.bench) == marks[at - 400]


@pytest.mark.parametrize("name", ["omni4", "dm3519", "slamware-a", "deadwheel3", "mecanum"])
def test_every_kind_of_robot_can_be_kept(name):
    robot = load_robot(name)
    link, _, outs, _ = driven(["w", "wq", "c", ""], robot=robot) if robot.rc else (None,) * 4
    if link is None:
        outs = Outs()
        asks = {10: BodyTwist(0.2, 0.0, 0.4)}
        link = InlineLink(
            simulated(robot), lambda tick: TickInput(b"", asks.get(tick)), Granted(), takers=[outs], remembers=True
        )
        link.run(1300)
        outs = outs.outs
    subject = link.history.at(700, len(outs), link.mark())
    assert exact(link.history.go_on(subject, len(outs))) == exact(outs[700:])


def test_what_a_still_cannot_hold_is_refused_and_not_guessed():
    with pytest.raises((pickle.PicklingError, AttributeError)):
        still([lambda: 1])


def test_a_still_is_a_thing_of_its_own():
    bench = simulated(M2006)
    for _ in range(30):
        bench.tick()
    kept = still(bench)
    one, two = again(kept), again(kept)
    assert one.robot is two.robot is bench.robot, "what never changes is not copied"
    for _ in range(500):
        one.tick()
    assert two.now_tick == 30
    assert mark_of(two) == mark_of(bench)


def test_inputs_are_kept_packed_cut_and_bounded(monkeypatch):
    monkeypatch.setattr(history, "PACKED_AT_ONCE", 50)
    inputs, expected = Inputs(), {}
    for tick in range(0, 5000, 7):
        expected[tick] = TickInput(bytes([tick % 256]) * 12, BodyTwist(tick, 0.0, -0.0) if tick % 70 == 0 else None)
        inputs.add(tick, expected[tick])
        inputs.add(tick + 1, NOTHING)
    assert inputs.between(0, 5000) == expected
    assert inputs.between(1234, 2345) == {tick: one for tick, one in expected.items() if 1234 <= tick < 2345}
    assert inputs.bytes < 12 * len(expected)
    branch = inputs.branch(2000)
    branch.add(2000, TickInput(b"new"))
    assert inputs.between(0, 5000) == expected, "the other branch is not touched"
    inputs = branch
    assert inputs.between(0, 9999) == {t: one for t, one in expected.items() if t < 2000} | {2000: TickInput(b"new")}
    inputs.forget_the_oldest()
    assert inputs.first == 350
    assert min(inputs.between(0, 9999)) == 350


def test_memory_is_bounded_and_says_what_it_no_longer_holds(monkeypatch):
    for name, value in (("PACKED_AT_ONCE", 20), ("MOST_INPUT_BYTES", 600), ("STILL_TICKS", 50), ("MOST_STILLS", 20)):
        monkeypatch.setattr(history, name, value)
    monkeypatch.setattr(history, "YOUNG_STILLS", 5)
    link, _, _, marks = driven(["w", "wd"] * 4)
    assert link.history.first > 0
    assert len(link.history._stills) <= 21
    assert link.history.inputs.bytes <= 600
    with pytest.raises(LostInstant, match="the run is held from"):
        link.see(0)
    with pytest.raises(LostInstant, match="no longer held"):
        link.history.start()
    tick = max(marks) - 50
    link.see(tick)
    assert mark_of(link.bench) == marks[tick]


def test_a_link_without_a_history_says_so():
    link = InlineLink(simulated(M2006), lambda tick: NOTHING, Granted())
    link.run(20)
    with pytest.raises(LostInstant, match="cannot be taken back"):
        link.see(10)
    link.see(20)
    assert Subject(link.bench, None).bench.now_tick == 20
