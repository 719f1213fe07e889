"""The comparison of whole CAN logs at once finds what the comparison line by line finds, to the word."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from recordings import made_run, record

from bench.check.arrays import can_arrays
from bench.check.compare import compare
from bench.check.fields import TOLERANCES
from bench.check.reading import Recording
from bench.messages import TickOutput

TICKS = 60


def shaken(outputs: list[TickOutput], chance: random.Random) -> list[TickOutput]:
    """Some frames lost, doubled, moved, cut, changed by a little or a lot, strangers among them."""
    changed = []
    for out in outputs:
        sides = []
        for frames in (out.can_commands, out.can_feedback):
            new = []
            for can_id, data in frames:
                match chance.randrange(60):
                    case 0:
                        continue
                    case 1:
                        new.append((can_id, data))
                    case 2:
                        data = data[: chance.randrange(8)]
                    case 3:
                        at = chance.randrange(8)
                        data = data[:at] + bytes((chance.randrange(256),)) + data[at + 1 :]
                    case 4:
                        data = data[:5] + bytes((data[5] ^ 1,)) + data[6:]
                    case 5:
                        new.append((chance.choice((0x001, 0x1FF, 0x203, 0x7FF)), data))
                new.append((can_id, data))
            if chance.randrange(12) == 0:
                chance.shuffle(new)
            sides.append(tuple(new))
        changed.append(out._replace(can_commands=sides[0], can_feedback=sides[1]))
    return changed


def line_by_line(recording: Recording) -> Recording:
    again = Recording.open(recording.directory)
    again.__dict__["can_arrays"] = None
    return again


@pytest.mark.parametrize("seed", range(25))
def test_both_ways_say_the_same(tmp_path, seed):
    chance = random.Random(seed)
    sides = []
    for name in ("golden", "run"):
        (tmp_path / name).mkdir()
        ticks = TICKS - chance.choice((0, 0, 7))
        outputs = made_run(ticks) if seed % 3 == 0 and name == "golden" else shaken(made_run(ticks), chance)
        sides.append(record(tmp_path / name / "run", outputs))
    golden, run = sides
    for tolerances in (None, TOLERANCES, {"_ma": 300.0, "_rpm": 9999.0, "_counts": 9999.0}):
        at_once, by_line = (
            compare(run, golden, tolerances),
            compare(line_by_line(run), line_by_line(golden), tolerances),
        )
        assert at_once == by_line
        assert at_once.lines == by_line.lines
    assert run.can_arrays is not None


def lines(*texts: str) -> bytes:
    return "".join(f"{text}\n" for text in texts).encode()


def test_a_log_as_columns():
    log = lines(
        "(0.000000) can0 200#0258025802580000",
        "(9.999000) can0 7FF#",
        "(10.000000) can0 001#FF",
        "(10.000000) can0 20A#0102030405060708",
        "(123456.789000) can0 201#1FFF",
    )
    found = can_arrays(log)
    assert found.tick.tolist() == [0, 9999, 10000, 10000, 123456789]
    assert found.can_id.tolist() == [0x200, 0x7FF, 0x001, 0x20A, 0x201]
    assert found.length.tolist() == [8, 0, 1, 8, 2]
    assert [f"{data:016X}" for data in found.data.tolist()] == [
        "0258025802580000",
        "0000000000000000",
        "FF00000000000000",
        "0102030405060708",
        "1FFF000000000000",
    ]
    assert len(can_arrays(b"").tick) == 0


GOOD = "(1.002000) can0 200#0258025802580000"


@pytest.mark.parametrize(
    "line",
    [
        "",
        "(1.002000) can1 200#0258025802580000",
        "(1.002001) can0 200#0258025802580000",
        "(01.002000) can0 200#0258025802580000",
        "(1.00200) can0 200#0258025802580000",
        "(1,002000) can0 200#0258025802580000",
        "(x.002000) can0 200#0258025802580000",
        "(1.00x000) can0 200#0258025802580000",
        "(1.002000) can0 800#0258025802580000",
        "(1.002000) can0 2g0#0258025802580000",
        "(1.002000) can0 20a#0258025802580000",
        "(1.002000) can0 200#02580258025800",
        "(1.002000) can0 200#025802580258000",
        "(1.002000) can0 200#025802580258000G",
        "(1.002000) can0 200#025802580258000a",
        "(1.002000) can0 200#025802580258000000",
        "(1.002000) can0 00000200#02580258025800",
        "[1.002000) can0 200#0258025802580000",
        "(1.002000) can0 200#0258025802580000\r",
    ],
)
def test_a_line_that_we_do_not_write_is_left_to_the_line_reader(line):
    read_anyway = line == "(1.002000) can0 200#02580258025800"
    assert (can_arrays(lines(GOOD, line, GOOD)) is not None) is read_anyway


def test_time_that_goes_back_is_left_to_the_line_reader(tmp_path):
    (tmp_path / "a").mkdir()
    run = record(tmp_path / "a" / "run", made_run(20))
    path = Path(run.directory) / "can.log"
    texts = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join((*texts[4:8], *texts[:4], *texts[8:])))
    assert Recording.open(run.directory).can_arrays is None
