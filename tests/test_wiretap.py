"""What the screen is told of the wires: counts, rates and loads against what was put on them, and in bounded memory."""

import struct
import tracemalloc
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench import rc_decode
from bench.canbus.bits import wire_bits
from bench.check.sources import from_scenario
from bench.config import load_robot
from bench.demo import SCENARIO
from bench.io.look import Look
from bench.io.tap import KEPT_TICKS, Tap
from bench.io.wires.counts import MOST_ROWS, Row
from bench.io.wires.log import LOGGED, LOOKED_AT, WireLog
from bench.io.wires.wiretap import Wiretap
from bench.io.wires.words import CanWords
from bench.messages import TickOutput

M2006 = load_robot("m2006")
COMMAND, FEEDBACK = bytes.fromhex("FDA8 0078 FEC9 0000"), bytes.fromhex("04D2 E9F0 FDA8 0000")


def test_a_motors_state_is_not_called_an_error():
    words = CanWords(load_robot("dm3519"))
    for state, said in ((1, "on"), (0, "off"), (0xA, "over-current"), (7, "7")):
        assert words.said(0x201, struct.pack(">HhhBB", 1234, -50, 40, 25, state)).endswith(f"  25 °C  {said}")


def tick(number, rc=b"", to_base=b"", to_core=b"", commands=(), feedback=()):
    return TickOutput(number, rc, to_base, to_core, tuple(commands), tuple(feedback), None)


def fed(outs, robot=M2006):
    tap = Wiretap(robot)
    tap.take(outs)
    return tap


def row(table, key):
    (found,) = (one for one in table.rows if one.key == key)
    return found


def total(table, wire):
    (found,) = (one for one in table.sums if one.wire == wire)
    return found


def test_a_bus_is_counted_to_the_frame_and_its_load_to_the_bit():
    """Two frames a tick for two seconds: 2000 a second, and the share is the bits of both frames, stuffing included."""
    outs = [tick(at, commands=[(0x200, COMMAND)], feedback=[(0x201, FEEDBACK)]) for at in range(2000)]
    table = fed(outs).table()
    command, feedback = row(table, "200"), row(table, "201")
    assert (command.frames, feedback.frames) == (2000, 2000)
    assert command.rate_hz == pytest.approx(1000.0)
    assert command.load == pytest.approx(len(wire_bits(0x200, COMMAND)) * 1000 / 1e6)
    assert total(table, "can").load == pytest.approx(command.load + feedback.load)
    assert total(table, "can").rate_hz == pytest.approx(2000.0)
    assert (feedback.last_tick, feedback.data, feedback.name) == (1999, FEEDBACK, "front right")
    assert feedback.said.split() == ["1234", "cnt", "-5648", "rpm", "-600", "mA"]


def test_changing_frames_are_measured_one_in_four():
    """Random data has many lengths: the load stays within a percent of every frame's own bits."""
    outs, bits = [], 0
    for at in range(1000):
        data = (at * 0x9E3779B97F4A7C15 % (1 << 64)).to_bytes(8, "big")
        bits += len(wire_bits(0x201, data))
        outs.append(tick(at, feedback=[(0x201, data)]))
    assert row(fed(outs).table(), "201").load == pytest.approx(bits / 1e6, rel=0.01)


def test_one_in_four_is_measured_however_many_come_at_once():
    """Looked at in pieces of any size, beside a loop over single frames: each fourth one, from the first on."""
    random, sent, outs = Random(4), [], []
    for at in range(900):
        frames = [(0x201, random.randbytes(8)) for _ in range(random.randrange(3))]
        sent += frames
        outs.append(tick(at, feedback=frames))
    tap, done = Wiretap(M2006), 0
    while done < len(outs):
        some = random.randrange(1, 7)
        tap.take(outs[done : done + some])
        done += some
    bits = [len(wire_bits(*sent[number - number % 4])) for number in range(len(sent))]
    found = row(tap.table(), "201")
    assert (found.frames, found.data) == (len(sent), sent[-1][1])
    assert found.load == pytest.approx(sum(bits) / 0.9 / 1e6)


def test_a_rate_is_that_of_the_last_second_and_falls_to_nothing():
    tap = fed([tick(at, commands=[(0x200, COMMAND)]) for at in range(3000)])
    tap.take([tick(at) for at in range(3000, 3500)])
    assert row(tap.table(), "200").rate_hz == pytest.approx(500.0)
    tap.take([tick(at) for at in range(3500, 4500)])
    quiet = row(tap.table(), "200")
    assert (quiet.rate_hz, quiet.frames, quiet.last_tick) == (0.0, 3000, 2999)


def test_rc_frames_and_what_is_none_are_told_apart():
    """uart12 has 12 bytes of 12 bits each (8E2 with its start bit) on a line of 115200."""
    frame = rc_decode.encode("uart12", [2048, 2048, 1024, 3072, 0, 1])
    outs = [tick(at, rc=frame if at % 10 == 0 else b"\x01\x02" if at == 1005 else b"") for at in range(2000)]
    table = fed(outs).table()
    assert row(table, "channels").frames == 200
    assert row(table, "channels").rate_hz == pytest.approx(100.0)
    assert row(table, "channels").load == pytest.approx(100 * 12 * 12 / 115_200)
    assert row(table, "channels").data == frame
    assert row(table, "channels").said == "2048 2048 1024 3072 0 1"
    assert total(table, "rc").errors == 2
    assert total(table, "rc").about == "uart12 115200 8E2"
    assert "2 bytes refused" in row(table, "noise").said


def test_requests_and_answers_of_the_demo_are_paired():
    job = from_scenario(SCENARIO)
    outs = [out for _, out in zip(range(2000), job, strict=False)]
    table = fed(outs).table()
    requests = sum(bool(out.core_to_base) for out in outs)
    assert row(table, "> 41").frames + row(table, "> 10").frames == requests
    assert row(table, "< 41").frames == row(table, "> 41").frames
    assert row(table, "< 41").said.startswith("OK dx ")
    assert [one.key for one in table.rows if one.wire == "core"] == ["> 10", "< 10", "> 41", "< 41"]
    assert total(table, "core").errors == 0
    bits = sum(len(wire_bits(*frame)) for out in outs[1000:] for frame in (*out.can_commands, *out.can_feedback))
    assert total(table, "can").load == pytest.approx(bits / 1e6, rel=0.01)


def test_damaged_bytes_on_the_control_bus_are_errors():
    good = bytes.fromhex("100ef841cd4c0000000000000000000026")
    table = fed([tick(0, to_base=good), tick(1, to_base=b"\xff\xfe" + good)]).table()
    assert total(table, "core").errors == 2
    assert row(table, "> 41").frames == 2


def test_the_log_has_the_newest_frames_and_only_what_the_filter_finds():
    outs = [tick(at, commands=[(0x200, COMMAND)], feedback=[(0x201, FEEDBACK), (0x202, FEEDBACK)]) for at in range(50)]
    tap = fed(outs)
    assert [(one.tick, one.key) for one in tap.table("", 4).log] == [(48, "202"), (49, "200"), (49, "201"), (49, "202")]
    tap = fed(outs)
    assert {one.key for one in tap.table("201,rear").log} == {"201", "202"}
    tap = fed(outs)
    assert {one.key for one in tap.table("-311").log} == {"200"}
    tap.take([tick(50, feedback=[(0x201, FEEDBACK)])])
    assert tap.table("-311").log[-1].tick == 49, "what was found before stays, and what does not match does not come"
    assert tap.table("nowhere").log == ()


frames = st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=6)


@given(st.lists(st.tuples(st.binary(max_size=40), st.binary(max_size=40), st.binary(max_size=40), frames, frames)))
@settings(max_examples=60)
def test_no_bytes_break_it(ticks):
    tap = Wiretap(M2006)
    for at, (rc, to_base, to_core, commands, feedback) in enumerate(ticks):
        tap.take([tick(at, rc, to_base, to_core, commands, feedback)])
        table = tap.table()
        assert len(table.rows) <= MOST_ROWS
        assert len(table.log) <= LOGGED
        assert all(one.rate_hz >= 0.0 and one.load >= 0.0 for one in table.rows)


def test_no_more_frames_are_put_into_words_than_are_shown():
    """Words cost more than all the counting: none where no log is asked for, and a filter looks through so many."""
    said = []
    stranger = Row("can", "123", "", 0)
    log = WireLog(lambda can_id: stranger, lambda row, data, words: said.append(data) or "")
    for filter, most, in_words in (("", 0, 0), ("", 5, 5), ("nothing of that name", 5, LOOKED_AT)):
        for at in range(2000):
            log.note((at, [(0x123, b"")]))
        said.clear()
        log.write(filter, most)
        assert len(said) == in_words


def test_a_bus_full_of_strangers_is_counted_in_bounded_rows():
    table = fed([tick(at, feedback=[(at, b"")]) for at in range(0x7FF)]).table()
    assert len(table.rows) == MOST_ROWS
    assert total(table, "can").errors == 0x7FF - MOST_ROWS


# --- the tap ---------------------------------------------------------------------------------------------------------


def tapped(count):
    job = from_scenario(SCENARIO)
    tap = Tap(job.bench.robot, job.bench.state_columns)
    for out, _ in zip(job, range(count), strict=False):
        tap.add(out)
        if out.tick % 50 == 49:
            tap.look(Look(True))
    return tap


def test_an_earlier_instant_shows_the_wires_as_they_were():
    tap = tapped(3000)
    table = tap.look(Look(True, log=5), 2500).wires
    assert table.tick == 2499
    assert max(one.tick for one in table.log) == 2499
    assert row(table, "200").rate_hz == pytest.approx(1000.0)
    now = tap.look(Look(True), 3000).wires
    assert (now.tick, row(now, "200").frames) == (2999, 3000)


def test_after_a_cut_the_run_goes_on_from_there():
    tap = tapped(3000)
    tap.cut(2000)
    assert tap.look(Look(True)).wires.tick == 1999
    tap.add(tick(2000, commands=[(0x7FF, b"")]))
    table = tap.look(Look(True)).wires
    assert (table.tick, row(table, "7FF").frames) == (2000, 1)


def test_nobody_looking_takes_no_more_than_some_megabytes():
    job = from_scenario(SCENARIO)
    outs = [out for _, out in zip(range(500), job, strict=False)]
    tap = Tap(job.bench.robot, job.bench.state_columns)
    tracemalloc.start()
    for again in range(4 * KEPT_TICKS // len(outs)):
        for out in outs:
            tap.add(out._replace(tick=out.tick + again * len(outs)))
    used = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert used < 5e6
    assert len(tap._ticks) == KEPT_TICKS


def test_who_looks_or_filters_while_time_stands_still_sees_the_newest_frames():
    """A pause on another page, then this one; a filter that is typed in a pause."""
    outs = [tick(at, commands=[(0x200, COMMAND)], feedback=[(0x201, FEEDBACK)]) for at in range(5000)]
    tap = fed(outs[:2000])
    assert tap.table(log=4).log[-1].tick == 1999
    for start in range(2000, 5000, 50):
        tap.take(outs[start : start + 50])
        assert tap.table(log=0).log == ()
    assert [(one.tick, one.key) for one in tap.table(log=3).log] == [(4998, "201"), (4999, "200"), (4999, "201")]
    assert [(one.tick, one.key) for one in tap.table("200", 2).log] == [(4998, "200"), (4999, "200")]
    assert [(one.tick, one.key) for one in tap.table("", 2).log] == [(4999, "200"), (4999, "201")]
