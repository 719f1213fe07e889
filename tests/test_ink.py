"""What is written past Textual: any line becomes any other of its width, on a screen that knows what it was sent."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st
from pty_terminal import cells

from bench.screen.ink import RESET, rewrite
from bench.screen.text import BAD_BADGE, GOOD, PLAIN, fit

INKS = {PLAIN: RESET + "\x1b[37m", GOOD: RESET + "\x1b[32m", BAD_BADGE: RESET + "\x1b[1;31m"}
SPANS = st.tuples(st.text("ab │█", max_size=4), st.sampled_from(list(INKS)))


def blank(width):
    return [(" " * width, PLAIN)]


@given(st.lists(st.lists(SPANS, max_size=6), min_size=1, max_size=5), st.integers(1, 12), st.integers(0, 9))
def test_a_line_becomes_the_next_one_and_nothing_else_changes(lines, width, x):
    pictures = [blank(width), *(fit(line, width) for line in lines)]
    sent = rewrite(x, 1, [], pictures[0], INKS)
    for old, new in pairwise(pictures):
        sent += rewrite(x, 1, old, new, INKS)
        whole = cells(rewrite(x, 1, [], new, INKS).encode(), 3, 24)
        assert cells(sent.encode(), 3, 24) == whole
        assert whole[0] == whole[2] == [(" ", "")] * 24


def test_only_the_spans_that_are_new_are_sent():
    old = [(" forward ", PLAIN), ("+0.100", GOOD), (" m/s ", PLAIN), ("left", PLAIN)]
    new = [old[0], ("+0.200", GOOD), *old[2:]]
    assert rewrite(3, 4, old, new, INKS) == f"\x1b[5;13H{INKS[GOOD]}+0.200"
