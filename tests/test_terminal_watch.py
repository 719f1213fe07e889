"""What a terminal's answers prove: fresh or late, releases or not. Times in milliseconds, made nanoseconds."""

import re

from bench.screen.terminal_watch import ASK_KITTY, SET_KITTY, TerminalWatch

MS = 1_000_000


class Asked:
    """A watch, and a terminal that answers after so many milliseconds."""

    def __init__(self, environment=(), width=80):
        self.watch = TerminalWatch(0, dict(environment))
        self.width = width
        self.on_the_way = []

    def ask(self, at_ms):
        text = self.watch.ask(at_ms * MS, self.width)
        if found := re.search(r"\x1b\[(\d+);(\d+)H\x1b\[6n", text):
            self.on_the_way.append((int(found[1]), int(found[2])))
        return text

    def answer(self, at_ms):
        return self.watch.answered(*self.on_the_way.pop(0), at_ms * MS)


def test_an_answer_is_as_old_as_its_question():
    asked = Asked()
    for at in (0, 50, 100):
        asked.ask(at)
    assert asked.answer(120)
    assert asked.watch.age_ms(120 * MS) == 120
    assert asked.watch.round_trip_ms == 120
    assert asked.answer(130)
    assert asked.watch.age_ms(130 * MS) == 80


def test_a_terminal_that_falls_silent_is_stalled_after_400_ms_and_back_with_a_fresh_answer():
    asked = Asked()
    asked.ask(0)
    asked.answer(10)
    asked.ask(50)
    assert not asked.watch.stalled(400 * MS)
    assert asked.watch.stalled(401 * MS)
    assert not asked.answer(5000), "what a connection kept for five seconds is no proof"
    assert asked.watch.stalled(5000 * MS)
    asked.ask(5000)
    assert asked.answer(5020)
    assert not asked.watch.stalled(5020 * MS)


def test_a_stalled_terminal_is_asked_but_not_flooded():
    asked = Asked()
    asked.ask(0)
    asked.answer(10)
    assert len([at for at in range(50, 10_050, 50) if asked.ask(at)]) < 40


def test_answers_nobody_asked_for_prove_nothing():
    watch = TerminalWatch(0, {})
    watch.ask(0, 80)
    for row, column in ((1, 2), (2, 1), (2, 79), (24, 2), (0, 0)):
        assert not watch.answered(row, column, 10 * MS)
    assert not watch.answers
    assert watch.answered(2, 2, 20 * MS)
    assert not watch.answered(2, 2, 30 * MS), "once"


def test_a_lost_answer_does_not_make_the_next_ones_older():
    asked = Asked()
    for at in (0, 50, 100):
        asked.ask(at)
    del asked.on_the_way[:2]
    assert asked.answer(150)
    assert asked.watch.age_ms(150 * MS) == 50


def test_a_terminal_that_never_answers_is_left_alone():
    asked = Asked()
    assert asked.ask(3000)
    assert not asked.ask(3001)
    assert not asked.watch.stalled(60_000 * MS), "it never promised anything"


def test_questions_stay_on_a_narrow_screen():
    asked = Asked(width=10)
    for at in range(0, 1000, 50):
        asked.ask(at)
    assert {column for _, column in asked.on_the_way} == set(range(1, 11))


def test_releases_are_used_once_the_terminal_says_that_they_are_on():
    watch = TerminalWatch(0, {})
    assert watch.ask(0, 80).startswith(ASK_KITTY)
    assert watch.kitty(25, 20 * MS) == SET_KITTY + ASK_KITTY
    assert not watch.releases
    assert watch.kitty(27, 40 * MS) == ""
    assert watch.releases


def test_a_terminal_that_knows_the_protocol_but_no_releases_is_asked_once():
    watch = TerminalWatch(0, {})
    watch.ask(0, 80)
    assert watch.kitty(1, 20 * MS)
    assert watch.kitty(1, 40 * MS) == ""
    assert not watch.releases


def test_an_answer_that_nobody_asked_for_or_that_comes_late_switches_nothing():
    watch = TerminalWatch(0, {})
    assert watch.kitty(27, 10 * MS) == ""
    watch.ask(20 * MS, 80)
    assert watch.kitty(27, 1001 * MS) == ""
    assert not watch.releases


def test_a_terminal_whose_answer_came_late_is_asked_again_and_its_next_is_believed_in_time():
    """The program may have stood still just when it opened: that shall not cost the releases of a whole session."""
    watch = TerminalWatch(0, {})
    watch.ask(0, 80)
    assert watch.kitty(25, 1600 * MS) == ""
    assert watch.ask(1650 * MS, 80).startswith(ASK_KITTY)
    assert watch.kitty(25, 1670 * MS) == SET_KITTY + ASK_KITTY
    assert watch.kitty(27, 2700 * MS) == "", "late again"
    assert not watch.releases
    assert watch.ask(2750 * MS, 80).startswith(ASK_KITTY)
    assert watch.kitty(27, 2770 * MS) == ""
    assert watch.releases


def test_a_program_in_between_is_not_trusted_with_releases():
    for name in ("TMUX", "STY", "ZELLIJ", "WEZTERM_PANE"):
        watch = TerminalWatch(0, {name: "1"})
        assert ASK_KITTY not in watch.ask(0, 80)
        assert watch.kitty(27, 10 * MS) == ""
        assert not watch.releases
