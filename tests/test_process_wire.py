"""Between a parent and its real-time child: words over a real socket pair, and how far ahead inputs are made."""

import pytest

from bench.io.process import pace
from bench.io.process.pace import ChildsPacer, Lead
from bench.io.process.wire import Beat, Inputs, Notice, State, Stop, wire_pair
from bench.messages import TickInput

MS = 1_000_000


@pytest.fixture
def ends():
    mine, theirs = wire_pair()
    yield mine, theirs
    mine.close()
    theirs.close()


def test_words_arrive_whole_and_in_order(ends):
    mine, theirs = ends
    words = [Beat(), Inputs(7, [TickInput(b"\x0f" * 25), TickInput()]), Notice(3, "waiting"), Stop()]
    for word in words:
        mine.tell(word)
    heard = list(theirs.heard())
    assert heard == words
    assert [type(word) for word in heard] == [type(word) for word in words], "a tuple equals any other"
    assert not theirs.is_cut
    assert list(theirs.heard()) == []


def test_nobody_waits_for_one_who_does_not_read(ends):
    mine, theirs = ends
    for tick in range(20_000):
        mine.tell(Notice(tick, "x" * 100))
    heard = [word.tick for word in theirs.heard()]
    assert heard == list(range(len(heard))), "what was there first is kept, in order"
    assert 100 < len(heard) < 20_000, "and the rest was dropped"
    mine.tell(Stop())
    assert list(theirs.heard()) == [Stop()]


def test_what_was_said_before_the_other_end_left_is_heard(ends):
    mine, theirs = ends
    theirs.tell(Beat())  # unread by mine when it leaves: the peer is reset
    mine.tell(Notice(1, "last"))
    mine.close()
    theirs.tell(Beat())
    theirs.tell_at_last(Beat())
    assert list(theirs.heard()) == [Notice(1, "last")]
    assert theirs.is_cut


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now_ns = 1000 * MS

    monkeypatch.setattr(pace, "now_ns", lambda: Clock.now_ns)
    return Clock


def test_inputs_are_made_80_ticks_ahead_and_further_where_frames_take_longer(clock):
    lead = Lead()
    assert lead.due(100) == 80
    lead.made_tick = 180
    clock.now_ns += 50 * MS  # a frame of 20 Hz: twice that is 100
    assert lead.due(150) == 150 + 100 - 180
    lead.made_tick = 250
    clock.now_ns += 20 * MS
    assert lead.due(170) == 170 + 99 - 250, "less again, a tick a frame"
    clock.now_ns += 1000 * MS  # it hung: the 919 ticks that nobody asked for are not made
    assert lead.due(1170) == 250
    assert lead.made_tick == 1170


def test_never_further_ahead_than_the_child_keeps(clock):
    lead = Lead()
    lead.made_tick = 400
    assert lead.has_room(30, 100)
    assert not lead.has_room(31, 100)


def test_the_childs_tick_goes_on_between_what_it_tells(clock):
    pacer = ChildsPacer()
    assert (pacer.has_begun, pacer.now_tick(), pacer.speed) == (False, 0, None)
    pacer.take(State(40, clock.now_ns, None, (), 1500.0, 3, ()))
    clock.now_ns += 50 * MS
    assert (pacer.has_begun, pacer.now_tick()) == (True, 90)
    pacer.take(State(65, clock.now_ns, None, (), 900.0, 3, ()))
    assert (pacer.now_tick(), pacer.speed, pacer.late_ticks, pacer.slipped_ticks) == (65, 0.5, 0, 3)
    pacer.set_rate(2.0)
    assert pacer.rate == 1.0, "real time has one rate"
