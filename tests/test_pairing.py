"""Which answers of two bases belong together: by the shift that most of them share; what has no partner is counted."""

from bench.check.pairing import Answer, answers_of, paired
from bench.messages import TickOutput
from bench.slamware.framing import STANDARD, encode_frame

MOST_TICKS = 200
EVERY = [Answer(100 * number, bytes([number])) for number in range(10)]


def later(answers, ticks):
    return [Answer(tick + ticks, data) for tick, data in answers]


def test_each_is_paired_however_late_they_all_are():
    """80 of the 100 ticks until the next one."""
    assert paired(EVERY, later(EVERY, 80), MOST_TICKS) == (list(zip(EVERY, later(EVERY, 80), strict=True)), 0, 0)


def test_the_same_bytes_tell_where_the_times_do_not():
    """A whole period late, and something in the place of the first: by their times alone none is late."""
    peer = [Answer(0, b"boot"), *later(EVERY, 100)]
    assert paired(EVERY, peer, MOST_TICKS) == (list(zip(EVERY, peer[1:], strict=True)), 0, 1)


def test_of_two_shifts_that_are_as_good_it_is_the_least():
    one, near, far = Answer(100, b"x"), Answer(90, b"x"), Answer(130, b"x")
    assert paired([one], [near, far], MOST_TICKS) == ([(one, near)], 0, 1)


def test_what_one_side_has_after_the_other_has_ended_is_counted():
    pairs = [(answer, answer) for answer in EVERY[:7]]
    assert paired(EVERY, EVERY[:7], MOST_TICKS) == (pairs, 3, 0)
    assert paired(EVERY[:7], EVERY, MOST_TICKS) == (pairs, 0, 3)


def test_answers_are_frames_in_whatever_pieces_and_half_a_one_at_the_end_is_told():
    whole = encode_frame(0x10, b"\x41" + bytes(12), STANDARD)
    said = {3: whole[:5], 4: whole[5:], 9: whole[:7]}
    outs = [TickOutput(tick, b"", b"", said.get(tick, b""), (), (), None) for tick in range(12)]
    assert answers_of(outs) == [Answer(4, whole), Answer(11, whole[:7])]
