"""The comparison of two recordings: what is named first, on which wire, in which field, and what is tolerated."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from recordings import made_run, record, tick_output

from bench.check.compare import Comparison, Difference, compare
from bench.check.fields import TOLERANCES
from bench.check.reading import Recording
from bench.check.recording import RecordingError, RunInfo
from bench.messages import TickOutput
from bench.slamware.payloads import dead_reckon_answer

TICKS = 240
Change = Callable[[TickOutput], TickOutput]


def answer(*fields: float) -> bytes:
    """A long SLAMWARE frame with status OK around a dead-reckoning payload."""
    payload = dead_reckon_answer(*fields)
    body = bytes((0x50, len(payload) + 1, 0, 0x02)) + payload
    checksum = 0
    for byte in body:
        checksum ^= byte
    return body + bytes((checksum,))


def run_with(directory: Path, changes: dict[int, Change], ticks: int = TICKS, info: RunInfo | None = None) -> Recording:
    directory.mkdir(parents=True)
    outputs = made_run(ticks)
    for tick, change in changes.items():
        outputs[tick] = change(outputs[tick])
    return record(directory / "run", outputs, info)


def compared(
    tmp_path: Path, run: dict[int, Change], golden: dict[int, Change] | None = None, **tolerances: float
) -> Comparison:
    """A changed run against the made-up one, exactly unless tolerances are given."""
    golden_run = run_with(tmp_path / "golden", golden or {})
    return compare(run_with(tmp_path / "run", run), golden_run, tolerances or None)


def frame(can_id: int, text: str) -> Change:
    """Put other data in the frame of this identifier; an empty text removes it."""
    data = bytes.fromhex(text)

    def change(out: TickOutput) -> TickOutput:
        commands, feedback = (
            tuple((one, data if one == can_id else old) for one, old in frames if one != can_id or data)
            for frames in (out.can_commands, out.can_feedback)
        )
        return out._replace(can_commands=commands, can_feedback=feedback)

    return change


def cell(column: int, value: float | int | str) -> Change:
    return lambda out: out._replace(state=(*out.state[:column], value, *out.state[column + 1 :]))


def put(**values: object) -> Change:
    return lambda out: out._replace(**values)


# What the made-up run has at these ticks, for reading the table below.
assert tick_output(123).can_commands == ((0x200, bytes.fromhex("002CFFD400160000")),)  # 44, -44, 22, 0 mA
assert tick_output(123).can_feedback[1] == (0x202, bytes.fromhex("05230083002D0000"))  # 1315 counts, 131 rpm, 45 mA
assert tick_output(120).rc == bytes.fromhex("AA 0800 07BD 0843 0800 00 01 55")
assert tick_output(120).state == (0.12, -0.067, 67 / 700, "live", 1)

DIFFERENCES = {
    "command": (
        {123: frame(0x200, "002CFFD300160000")},
        Difference(123, "can 0x200", "current_2_ma", -44, -45),
        "at 0.123 s (tick 123) can 0x200: current 2 expected -44 mA, got -45 mA",
    ),
    "second command group": (
        {123: put(can_commands=((0x200, bytes.fromhex("002CFFD400160000")), (0x1FF, bytes(8))))},
        Difference(123, "can 0x1FF", "frame", None, "00 00 00 00 00 00 00 00"),
        "at 0.123 s (tick 123) can 0x1FF: the run has 00 00 00 00 00 00 00 00 here, the golden has nothing",
    ),
    "angle": (
        {123: frame(0x202, "05240083002D0000")},
        Difference(123, "can 0x202", "angle_counts", 1315, 1316),
        "at 0.123 s (tick 123) can 0x202: angle expected 1315 counts, got 1316 counts",
    ),
    "speed": (
        {123: frame(0x202, "0523FF7D002D0000")},
        Difference(123, "can 0x202", "speed_rpm", 131, -131),
        "at 0.123 s (tick 123) can 0x202: speed expected 131 rpm, got -131 rpm",
    ),
    "current": (
        {123: frame(0x202, "05230083002E0000")},
        Difference(123, "can 0x202", "current_ma", 45, 46),
        "at 0.123 s (tick 123) can 0x202: current expected 45 mA, got 46 mA",
    ),
    "bytes that a C610 leaves empty": (
        {123: frame(0x202, "05230083002D0019")},
        Difference(123, "can 0x202", "byte 7", "0x00", "0x19"),
        "at 0.123 s (tick 123) can 0x202: byte 7 expected 0x00, got 0x19",
    ),
    "a frame that is too short": (
        {123: frame(0x202, "05230083002D")},
        Difference(123, "can 0x202", "byte 6", "0x00", None),
        "at 0.123 s (tick 123) can 0x202: byte 6 expected 0x00, got nothing",
    ),
    "a frame that is missing": (
        {123: frame(0x203, "")},
        Difference(123, "can 0x203", "frame", "07 DF 00 82 00 2E 00 00", None),
        "at 0.123 s (tick 123) can 0x203: the golden has 07 DF 00 82 00 2E 00 00 here, the run has nothing",
    ),
    "frames in another order": (
        {123: lambda out: out._replace(can_feedback=out.can_feedback[::-1])},
        Difference(123, "can 0x201", "order", "0x201 0x202 0x203", "0x203 0x202 0x201"),
        "at 0.123 s (tick 123) can 0x201: order expected 0x201 0x202 0x203, got 0x203 0x202 0x201",
    ),
    "RC byte": (
        {120: put(rc=bytes.fromhex("AA 0800 07BD 0843 0800 01 01 55"))},
        Difference(120, "rc", "byte 9", "0x00", "0x01"),
        "at 0.120 s (tick 120) rc: byte 9 expected 0x00, got 0x01",
    ),
    "RC bytes too many": (
        {120: put(rc=bytes.fromhex("AA 0800 07BD 0843 0800 00 01 55 AA"))},
        Difference(120, "rc", "byte 12", None, "0xAA"),
        "at 0.120 s (tick 120) rc: byte 12 expected nothing, got 0xAA",
    ),
    "RC where there was none": (
        {121: put(rc=b"\xaa\x55")},
        Difference(121, "rc", "frame", None, "AA 55"),
        "at 0.121 s (tick 121) rc: the run has AA 55 here, the golden has nothing",
    ),
    "request": (
        {120: put(core_to_base=bytes.fromhex("10 02 F8 31 DB"))},
        Difference(120, "slamware core->base", "as", "GET_BASE_STATUS request", "GET_BASE_MOTOR_DATA request"),
        "at 0.120 s (tick 120) slamware core->base: as expected GET_BASE_STATUS request, "
        "got GET_BASE_MOTOR_DATA request",
    ),
    "answer of another kind": (
        {120: put(base_to_core=bytes.fromhex("50 03 00 03 00 80 D0"))},
        Difference(120, "slamware base->core", "byte 1", "0x01", "0x03"),
        "at 0.120 s (tick 120) slamware base->core: byte 1 expected 0x01, got 0x03",
    ),
    "answer that is missing": (
        {120: put(base_to_core=b"")},
        Difference(120, "slamware base->core", "frame", "50 01 00 02 53", None),
        "at 0.120 s (tick 120) slamware base->core: the golden has 50 01 00 02 53 here, the run has nothing",
    ),
    "state number": (
        {120: cell(1, 0.011)},
        Difference(120, "state", "x_m", -0.067, 0.011),
        "at 0.120 s (tick 120) state: x_m expected -0.067, got 0.011",
    ),
    "state word": (
        {120: cell(3, "lost")},
        Difference(120, "state", "link", "live", "lost"),
        "at 0.120 s (tick 120) state: link expected live, got lost",
    ),
    "state row that is missing": (
        {120: put(state=None)},
        Difference(120, "state", "frame", "0.120000,-0.067000,0.095714,live,1", None),
        "at 0.120 s (tick 120) state: the golden has 0.120000,-0.067000,0.095714,live,1 here, the run has nothing",
    ),
}


@pytest.mark.parametrize("case", DIFFERENCES)
def test_the_first_difference_is_named(tmp_path, case):
    changes, difference, sentence = DIFFERENCES[case]
    found = compared(tmp_path, changes)
    assert found.first == difference
    assert found.first.text == sentence
    assert found.lines[0] == f"differs: {sentence}"
    assert not found.ok
    assert not found.identical
    differing = {wire.wire: wire.differing for wire in found.wires if wire.differing}
    assert differing == {difference.wire: 1}


@pytest.mark.parametrize("case", DIFFERENCES)
def test_it_is_the_same_difference_from_the_other_side(tmp_path, case):
    changes, difference, _ = DIFFERENCES[case]
    first = compared(tmp_path, {}, golden=changes).first
    if difference.field == "order":
        assert (first.expected, first.got) == (difference.got, difference.expected)
    else:
        assert first == Difference(
            difference.tick, difference.wire, difference.field, difference.got, difference.expected
        )


def test_identical_recordings_give_nothing(tmp_path):
    found = compared(tmp_path, {})
    assert found.identical
    assert found.ok
    assert found.first is None
    # 240 ticks of 4 CAN frames, 24 RC chunks, 5 requests with answers, 24 rows
    assert found.lines == ["identical: 0.240 s, 1018 frames and rows"]
    assert {wire.wire: wire.frames for wire in found.wires} == {"can": 960, "rc": 24, "slamware": 10, "state": 24}


def test_equal_files_are_not_parsed(tmp_path):
    run, golden = run_with(tmp_path / "run", {}), run_with(tmp_path / "golden", {})
    for side in (run, golden):
        (side.directory / "can.log").write_bytes(b"anything\n")
    assert compare(run, golden).identical


def test_the_earliest_counts_and_within_a_tick_the_cause(tmp_path):
    late = {200: frame(0x200, "0000000000000000"), 130: cell(1, 9.0), 123: frame(0x202, "0000000000000000")}
    assert compared(tmp_path / "a", late).first.wire == "can 0x202"
    order = [
        ("rc", put(rc=b"\x01")),
        ("slamware core->base", put(core_to_base=b"\x01")),
        ("can 0x200", frame(0x200, "0000000000000000")),
        ("slamware base->core", put(base_to_core=b"\x01")),
        ("can 0x201", frame(0x201, "0000000000000000")),
        ("can 0x203", frame(0x203, "0000000000000000")),
        ("state", cell(1, 9.0)),
    ]
    for start in range(len(order)):

        def change(out: TickOutput, start: int = start) -> TickOutput:
            for _, one in order[start:]:
                out = one(out)
            return out

        found = compared(tmp_path / str(start), {120: change})
        assert found.first.wire == order[start][0]
        assert [wire.wire for wire in found.wires if wire.differing] == [wire for wire, _ in order[start:]]


def test_after_missing_and_extra_frames_the_rest_is_compared_in_step(tmp_path):
    found = compared(
        tmp_path,
        {
            20: frame(0x202, ""),
            60: put(can_commands=((0x1FF, bytes(8)), *tick_output(60).can_commands)),
            100: put(can_commands=(), can_feedback=()),
            123: frame(0x202, "05240083002D0000"),
        },
    )
    assert found.first == Difference(
        20, "can 0x202", "frame", tick_output(20).can_feedback[1][1].hex(" ").upper(), None
    )
    summary = {wire.wire: (wire.frames, wire.differing) for wire in found.wires}
    assert summary == {
        "rc": (24, 0),
        "can 0x1FF": (0, 1),
        "can 0x200": (240, 1),
        "slamware": (10, 0),
        "can 0x201": (240, 1),
        "can 0x202": (240, 3),
        "can 0x203": (240, 1),
        "state": (24, 0),
    }
    assert next(wire for wire in found.wires if wire.wire == "can 0x202").largest == {"angle_counts": 1}


def test_two_frames_of_one_identifier_in_a_tick_are_compared_in_order(tmp_path):
    twice = put(can_commands=((0x200, b"\x01"), (0x200, b"\x02")))
    other = put(can_commands=((0x200, b"\x01"), (0x200, b"\x03")))
    found = compared(tmp_path, {5: other}, golden={5: twice})
    assert found.first == Difference(5, "can 0x200", "byte 0", "0x02", "0x03")


# --- lengths ------------------------------------------------------------------------------------------------------


def test_different_lengths_are_said_after_all_else(tmp_path):
    golden = run_with(tmp_path / "golden", {})
    shorter = compare(run_with(tmp_path / "shorter", {}, ticks=200), golden)
    assert shorter.first == Difference(200, "run", "ticks", 240, 200)
    assert shorter.lines[0] == "differs: the run has 200 ticks, the golden 240; compared up to 0.200 s"
    assert not shorter.ok
    assert not any(wire.differing for wire in shorter.wires)
    assert sum(wire.frames for wire in shorter.wires) == 200 * 4 + 20 + 8 + 20
    longer = compare(run_with(tmp_path / "longer", {}, ticks=250), golden)
    assert longer.first == Difference(240, "run", "ticks", 240, 250)
    both = compare(run_with(tmp_path / "both", {123: frame(0x202, "05240083002D0000")}, ticks=250), golden)
    assert both.first.wire == "can 0x202"


def test_a_whole_number_that_became_a_decimal_is_another_column_text(tmp_path):
    found = compared(tmp_path / "a", {120: cell(4, 1.0)})
    assert found.first == Difference(120, "state", "armed", 1, 1.0)
    assert compared(tmp_path / "b", {120: cell(4, 1.0)}, **TOLERANCES).ok


def test_equal_files_of_different_length_differ(tmp_path):
    silent = [put(rc=b"", core_to_base=b"", base_to_core=b"", can_commands=(), can_feedback=(), state=None)] * 9
    golden = run_with(tmp_path / "golden", dict(enumerate(silent)), ticks=9)
    run = run_with(tmp_path / "run", dict(enumerate(silent[:7])), ticks=7)
    found = compare(run, golden)
    assert not found.identical
    assert found.first == Difference(7, "run", "ticks", 9, 7)


# --- tolerances ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "granted", "ok"),
    [
        (frame(0x200, "002EFFD400160000"), {"_ma": 2}, True),
        (frame(0x200, "002FFFD400160000"), {"_ma": 2}, False),
        (frame(0x200, "002CFFD400160001"), {"current_4_ma": 1}, True),
        (frame(0x200, "002CFFD400170001"), {"current_4_ma": 1}, False),
        (frame(0x202, "05260083002D0000"), {"angle_counts": 3}, True),
        (frame(0x202, "05270083002D0000"), {"angle_counts": 3}, False),
        (frame(0x202, "05230085002D0000"), {"speed_rpm": 2}, True),
        (frame(0x202, "05230086002D0000"), {"speed_rpm": 2}, False),
        (frame(0x202, "05230081002D0000"), {"_rpm": 5, "speed_rpm": 2}, True),
        (frame(0x202, "05230080002D0000"), {"_rpm": 5, "speed_rpm": 2}, False),
        (frame(0x202, "05240083002D0001"), {"angle_counts": 3}, False),  # what has no field has no tolerance
        (frame(0x202, "05240083002D0100"), {"angle_counts": 3}, False),
        (frame(0x202, "05240083002D00"), {"angle_counts": 3}, False),
        (frame(0x202, "05240083002F0000"), {"angle_counts": 3}, False),
        (frame(0x202, ""), {"_counts": 9999, "_rpm": 9999, "_ma": 9999}, False),
    ],
)
def test_tolerances_of_can_fields_at_and_above_the_edge(tmp_path, change, granted, ok):
    assert compared(tmp_path, {123: change}, **granted).ok is ok


@pytest.mark.parametrize(
    ("column", "expected", "got", "granted", "ok"),
    [
        # Decimal steps that binary floats do not have: 0.8 - 0.7 is more than 0.1, 0.3 - 0.2 is less.
        (1, 0.7, 0.8, {"x_m": 0.1}, True),
        (1, 0.2, 0.3, {"x_m": 0.1}, True),
        (1, 0.7, 0.800001, {"x_m": 0.1}, False),
        (1, -0.7, -0.800001, {"x_m": 0.1}, False),
        (1, 1000.0001, 1000.0, {"_m": 1e-4}, True),
        (1, 1000.000101, 1000.0, {"_m": 1e-4}, False),
        (1, 0.5, float("nan"), {"_m": 1e9}, False),
        (1, float("nan"), float("nan"), {"_m": 0.0, "_rad": 1.0}, True),
        (1, float("inf"), float("inf"), {"_m": 0.0, "_rad": 1.0}, True),
        (1, 0.5, float("inf"), {"_m": 1e9}, False),
        (2, 3.141, -3.141, {"_rad": 0.00119}, True),  # the heading starts again at half a turn: 2 pi - 6.282
        (2, 3.141, -3.141, {"_rad": 0.00118}, False),
        (4, 1, 0, {"_m": 9.0, "_rad": 9.0}, False),
        (4, 1, 1.0, {"_m": 9.0, "_rad": 9.0}, True),
        (3, "live", "lost", {"link": 9.0}, False),
    ],
)
def test_tolerances_of_state_at_and_above_the_edge(tmp_path, column, expected, got, granted, ok):
    # The other column differs within its tolerance, so that the row is always looked into.
    found = compared(
        tmp_path,
        {120: cell(column, got), 130: cell(2, 0.1)},
        {120: cell(column, expected), 130: cell(2, 0.1)},
        **granted,
    )
    assert found.ok is ok


def test_an_angle_is_compared_the_short_way_round(tmp_path):
    golden, run = {123: frame(0x202, "1FFF0083002D0000")}, {123: frame(0x202, "00010083002D0000")}
    assert compared(tmp_path / "a", run, golden, angle_counts=2).ok
    assert not compared(tmp_path / "b", run, golden, angle_counts=1).ok
    wrong = {123: frame(0x202, "20010083002D0000")}  # 8193: the same angle, but not the same frame
    found = compared(tmp_path / "c", wrong, run)
    assert found.first == Difference(123, "can 0x202", "angle_counts", 1, 8193)


def test_slamware_answers_are_compared_by_field_where_they_decode(tmp_path):
    golden = {120: put(base_to_core=answer(0.010, -0.002, 0.05))}
    near = {120: put(base_to_core=answer(0.010001, -0.002, 0.05))}
    exact = compared(tmp_path / "a", near, golden)
    assert (exact.first.wire, exact.first.field) == ("slamware base->core", "dx_m")
    assert exact.first.text.startswith("at 0.120 s (tick 120) slamware base->core: dx expected 0.01")
    assert compared(tmp_path / "b", near, golden, **TOLERANCES).ok
    far = {120: put(base_to_core=answer(0.010, -0.002003, 0.05))}
    assert compared(tmp_path / "c", far, golden, **TOLERANCES).first.field == "dy_m"
    stalled = {120: put(base_to_core=answer(0.010, -0.002, 0.05, 0x02))}
    assert compared(tmp_path / "d", stalled, golden, **TOLERANCES).first.field == "wheel_stalled"
    two = {120: put(base_to_core=answer(0.01, 0.0, 0.0) + answer(0.02, 0.0, 0.0))}
    three = {120: put(base_to_core=answer(0.01, 0.0, 0.0) + answer(0.02, 0.00003, 0.0))}
    assert compared(tmp_path / "e", three, two, **TOLERANCES).first.field == "frame 2 dy_m"
    # With the start of a further frame behind it, nobody knows what it will be: bytes.
    ahead = {120: put(base_to_core=answer(0.010, -0.002, 0.05) + b"\x50")}
    near_ahead = {120: put(base_to_core=answer(0.010001, -0.002, 0.05) + b"\x50")}
    assert compared(tmp_path / "f", near_ahead, ahead, **TOLERANCES).first.field.startswith("byte ")


def test_tolerated_differences_are_still_told(tmp_path):
    found = compared(tmp_path, {123: frame(0x202, "05250084002D0000")}, **TOLERANCES)
    assert found.ok
    assert not found.identical
    assert not found.exact
    assert found.lines == [
        "the same within the tolerances: 0.240 s, 1018 frames and rows",
        "  rc                   24 compared, the same",
        "  can 0x200            240 compared, the same",
        "  can 0x201            240 compared, the same",
        "  can 0x202            240 compared, none differ; largest: angle 2 counts, speed 1 rpm",
        "  can 0x203            240 compared, the same",
        "  slamware             10 compared, the same",
        "  state                24 compared, the same",
    ]


# --- what is told -------------------------------------------------------------------------------------------------


def test_the_summary_names_the_largest_difference_of_each_field(tmp_path):
    found = compared(
        tmp_path,
        {
            123: frame(0x200, "002DFFD400160000"),  # current 1 one more
            150: lambda out: out._replace(can_commands=((0x200, bytes(8)),)),
        },
    )
    [wire] = [wire for wire in found.wires if wire.differing]
    before = [int.from_bytes(tick_output(150).can_commands[0][1][n : n + 2], "big", signed=True) for n in (0, 2, 4)]
    assert (wire.wire, wire.frames, wire.differing, wire.first.tick) == ("can 0x200", 240, 2, 123)
    assert wire.largest == {f"current_{n + 1}_ma": abs(value) for n, value in enumerate(before)}
    a, b, c = (abs(value) for value in before)
    assert found.lines[1:3] == [
        "  rc                   24 compared, the same",
        "  can 0x200            240 compared, 2 differ, first at 0.123 s; "
        f"largest: current 1 {a} mA, current 2 {b} mA, current 3 {c} mA",
    ]


def test_other_runs_are_noted(tmp_path):
    golden = run_with(tmp_path / "golden", {}, info=RunInfo("little", seed=1, wheelbench="0.1.0"))
    run = run_with(tmp_path / "run", {}, info=RunInfo("little", profile="mine", seed=2, wheelbench="0.2.0"))
    (run.directory / "robot.toml").write_text("another")
    (run.directory / "profile.toml").write_text("mine")
    found = compare(run, golden)
    assert found.identical
    assert found.lines[1:] == [
        "note: profile: None in the golden, mine in the run",
        "note: seed: 1 in the golden, 2 in the run",
        "note: wheelbench: 0.1.0 in the golden, 0.2.0 in the run",
        "note: the two have another robot.toml",
        "note: the two have another profile.toml",
    ]


def test_other_columns_are_a_difference_and_the_common_ones_are_compared(tmp_path):
    run, golden = run_with(tmp_path / "run", {120: cell(1, 0.5)}), run_with(tmp_path / "golden", {})
    path = golden.directory / "state.csv"
    path.write_text("\n".join(line.rpartition(",")[0] for line in path.read_text().splitlines()) + "\n")
    found = compare(run, golden)
    assert found.first == Difference(
        0, "state", "columns", "t_s x_m heading_rad link", "t_s x_m heading_rad link armed"
    )
    [state] = [wire for wire in found.wires if wire.wire == "state"]
    assert state.differing == 2
    assert state.largest == {"x_m": 0.567}


def test_a_run_that_was_cut_short_is_said(tmp_path):
    run, golden = run_with(tmp_path / "run", {}), run_with(tmp_path / "golden", {})
    path = run.directory / "run.toml"
    path.write_bytes(path.read_bytes().removesuffix(b"ticks = 240\n"))
    found = compare(Recording.open(run.directory), golden)
    assert found.lines[:2] == [
        "differs: the run has 239 ticks, the golden 240; compared up to 0.239 s",
        "note: run: the run was cut short; what it wrote until then is used",
    ]


def test_never_more_than_forty_lines(tmp_path):
    crowd = put(can_commands=tuple((can_id, b"") for can_id in range(0x300, 0x380)))
    found = compared(tmp_path, {5: crowd})
    assert len(found.wires) > 100
    assert len(found.lines) == 40
    assert found.lines[-1] == f"  ... and {1 + len(found.wires) - 39} lines more"


def test_facts_for_other_programs(tmp_path):
    facts = json.loads(json.dumps(compared(tmp_path, {123: frame(0x202, "05240083002D0000")}).as_dict()))
    assert facts["ok"] is False
    assert facts["identical"] is False
    assert facts["exact"] is True
    assert facts["ticks"] == 240
    assert facts["first"] == {
        "tick": 123,
        "wire": "can 0x202",
        "field": "angle_counts",
        "expected": 1315,
        "got": 1316,
    }
    assert facts["text"] == "differs: at 0.123 s (tick 123) can 0x202: angle expected 1315 counts, got 1316 counts"
    assert facts["wires"][3] == {
        "wire": "can 0x202",
        "frames": 240,
        "differing": 1,
        "first": facts["first"],
        "largest": {"angle_counts": 1},
    }
    assert facts["notes"] == []


def test_a_damaged_line_is_an_error_and_no_difference(tmp_path):
    run, golden = run_with(tmp_path / "run", {}), run_with(tmp_path / "golden", {})
    path = run.directory / "can.log"
    path.write_bytes(path.read_bytes().replace(b"(0.123000) can0 201#", b"(0.123000) can0 201:"))
    with pytest.raises(RecordingError, match=r"run/can\.log:494: expected \(0\.001000\) can0 200#"):
        compare(run, golden)
