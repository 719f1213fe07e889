"""Faults: each kind does what it says to real bytes, leaves a witness, and a run with faults repeats byte for byte."""

import json
import math
import shutil
from collections import Counter
from dataclasses import replace

import pytest

from bench import rc_decode
from bench.__main__ import main
from bench.check.faults import BUS, Fault
from bench.check.faulty import FaultyWorld, Injector
from bench.check.reading import Recording
from bench.check.sources import from_source
from bench.cli.headless import execute
from bench.config import load_robot
from bench.loop import simulated
from bench.messages import RcFrame

ROBOT = load_robot("m2006")
COLUMNS = simulated(ROBOT).state_columns
PIECES = [bytes((tick, tick + 1, tick + 2)) if tick % 3 == 0 else b"" for tick in range(30)]


def through(wire, pieces, seed=0, **facts):
    """The pieces after one fault that acts in ticks 6 to 17, and how many it touched."""
    facts = {"at": 6, "lasting": 12} | facts
    injector = Injector([Fault("f", wire, **facts)], ROBOT, COLUMNS, seed)
    after = [injector.through(wire, tick, piece) for tick, piece in enumerate(pieces)]
    return after, injector


def outside(pieces):
    return [piece for tick, piece in enumerate(pieces) if not 6 <= tick < 18]


def test_dropped_bytes_are_gone_and_nothing_else():
    after, injector = through("rc", PIECES, kind="drop")
    assert after[6:18] == [b""] * 12
    assert outside(after) == outside(PIECES)
    assert [touch.tick for touch in injector.take_touches()] == [6, 9, 12, 15]
    assert injector.untouched() == []


def test_a_delay_keeps_order_and_content():
    after, _ = through("rc", PIECES, kind="delay", ms=4)
    assert b"".join(after) == b"".join(PIECES)
    assert [tick for tick, piece in enumerate(after) if piece] == [0, 3, 10, 13, 16, 19, 21, 24, 27]
    assert after[19] == PIECES[15] + PIECES[18] or after[19] == PIECES[15]


def test_a_stall_holds_all_and_gives_all():
    after, _ = through("core", PIECES, kind="stall")
    assert after[6:18] == [b""] * 12
    assert after[18] == b"".join(PIECES[6:19])
    assert b"".join(after) == b"".join(PIECES)


def test_reordered_pieces_change_places():
    after, _ = through("answer", PIECES, kind="reorder")
    assert b"".join(after) != b"".join(PIECES)
    assert Counter(b"".join(after)) == Counter(b"".join(PIECES))
    assert after[9] == PIECES[9] + PIECES[6]


def test_truncated_duplicated_and_random_pieces():
    assert through("rc", PIECES, kind="truncate", keep=1)[0][6:18] == [piece[:1] for piece in PIECES[6:18]]
    assert through("rc", PIECES, kind="duplicate")[0][6:18] == [piece * 2 for piece in PIECES[6:18]]
    garbage = through("rc", PIECES, kind="garbage")[0]
    assert [len(piece) for piece in garbage[6:18]] == [3, 1, 1] * 4
    assert garbage[6:18] != through("rc", PIECES, seed=1, kind="garbage")[0][6:18]
    assert garbage == through("rc", PIECES, kind="garbage")[0]


def test_a_corrupt_byte_differs_in_one_bit_and_a_lost_one_is_missing():
    long = [bytes(100)] * 30
    after, _ = through("rc", long, kind="corrupt", probability=0.1)
    changed = [byte for piece in after[6:18] for byte in piece if byte]
    assert 60 < len(changed) < 180
    assert all(byte.bit_count() == 1 for byte in changed)
    assert outside(after) == outside(long)
    lost, _ = through("rc", long, kind="lose_byte", probability=0.1)
    assert 60 < 1200 - sum(map(len, lost[6:18])) < 180


FRAMES = [tuple((0x201 + esc, bytes((tick, esc, 9, 9, 1, 2, 0, 0))) for esc in range(3)) for tick in range(30)]


def test_frames_of_one_esc_can_be_hit_alone():
    after, injector = through("feedback", FRAMES, kind="drop", esc=2)
    assert [[can_id for can_id, _ in frames] for frames in after[6:18]] == [[0x201, 0x203]] * 12
    assert outside(after) == outside(FRAMES)
    assert len(injector.take_touches()) == 12


def test_a_stuck_encoder_keeps_its_angle_and_has_no_speed():
    after, _ = through("feedback", FRAMES, kind="stuck", esc=1)
    found = {can_id: [data for frames in after[6:18] for i, data in frames if i == can_id] for can_id in (0x201, 0x202)}
    assert set(found[0x201]) == {bytes((6, 0, 0, 0, 1, 2, 0, 0))}
    assert found[0x202] == [dict(frames)[0x202] for frames in FRAMES[6:18]]


@pytest.mark.parametrize("kind", BUS)
def test_every_kind_of_bus_fault_touches_frames_and_leaves_what_is_outside(kind):
    facts = {"ms": 2} if kind == "delay" else {"keep": 3} if kind == "truncate" else {}
    after, injector = through("feedback", FRAMES, kind=kind, **facts)
    assert injector.untouched() == []
    assert after[:6] == FRAMES[:6]
    assert after[21:] == FRAMES[21:]
    lengths = {len(data) for frames in after for _, data in frames}
    assert lengths == ({3, 8} if kind == "truncate" else {8})


def sbus_robot():
    return load_robot("m2006", "futaba-sbus2")


@pytest.mark.parametrize("kind", ["flag", "lost_flag", "freeze", "zeros"])
def test_rc_frames_come_whole_with_what_the_fault_changes(kind):
    stream = b"".join(rc_decode.encode("sbus", [400 + 20 * number] * 16) for number in range(40))
    pieces = [stream[at : at + 10] for at in range(0, len(stream), 10)]
    injector = Injector([Fault("f", "rc", kind, at=30, lasting=40)], sbus_robot(), COLUMNS)
    after = b"".join(injector.through("rc", tick, piece) for tick, piece in enumerate(pieces))
    decoder = rc_decode.decoder("sbus")
    frames = [event for event in decoder.feed(after) + decoder.finish() if isinstance(event, RcFrame)]
    changed = [
        frame
        for frame in frames
        if frame.failsafe or frame.frame_lost or set(frame.channels) == {0} or frame.channels == frames[13].channels
    ]
    assert len(changed) in range(14, 18)
    assert all(frame.failsafe == (kind == "flag") for frame in changed if kind in ("flag", "lost_flag"))
    assert len(frames) >= 38


def test_a_condition_begins_a_fault_each_time_it_becomes_true(tmp_path):
    fault = Fault("f", "feedback", "drop", when="rc_age_ms > 5", lasting=3, esc=1)
    injector = Injector([fault], ROBOT, COLUMNS)
    bench = simulated(ROBOT)
    frame = rc_decode.encode("uart12", [2048, 2048, 2048, 2048, 0, 0])
    from bench.messages import TickInput

    hit = []
    for tick in range(60):
        out = bench.tick(TickInput(frame if tick % 20 == 0 else b""))
        if injector.through("feedback", tick, FRAMES[0]) != FRAMES[0]:
            hit.append(tick)
        injector.observe(out)
    assert len(hit) == 9
    assert [tick - hit[0] for tick in hit] == [0, 1, 2, 20, 21, 22, 40, 41, 42]


@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ({"wire": "rcc", "kind": "drop", "at": 0}, "did you mean rc?"),
        ({"wire": "core", "kind": "flag", "at": 0}, "kind: 'flag' is unknown on wire 'core'"),
        ({"wire": "rc", "kind": "drop"}, "give one of the two"),
        ({"wire": "rc", "kind": "drop", "at": 1, "when": "armed"}, "give one of the two"),
        ({"wire": "rc", "kind": "drop", "at": -1}, "at_s: expected 0 to"),
        ({"wire": "rc", "kind": "delay", "at": 1}, "ms: expected 1 to 10000"),
        ({"wire": "esc", "kind": "weak", "at": 1, "factor": 1.5}, "factor: expected 0 to 1"),
        ({"wire": "rc", "kind": "drop", "at": 1, "probability": 2.0}, "probability: expected 0 to 1"),
    ],
)
def test_a_wrong_fault_is_one_sentence(facts, says):
    with pytest.raises(ValueError, match=r"expected|known|mean|give") as caught:
        Fault("f", **facts)
    assert says in str(caught.value)


def test_a_flag_that_the_protocol_cannot_carry_is_refused_before_the_run():
    with pytest.raises(ValueError, match="uart12 frames cannot say failsafe"):
        Injector([Fault("f", "rc", "flag", at=0)], ROBOT, COLUMNS)
    with pytest.raises(ValueError, match="has 3 wheels, got 4"):
        Injector([Fault("f", "esc", "silent", at=0, esc=4)], ROBOT, COLUMNS)


def moved(faults, ticks=600):
    """A bench at rest whose world has these faults, after so many ticks."""
    bench = simulated(ROBOT)
    bench.world = FaultyWorld(bench.world, Injector(faults, ROBOT, COLUMNS))
    for _ in range(ticks):
        bench.tick()
    return bench.world.plant


def test_a_push_below_what_the_wheels_hold_moves_nothing_and_a_strong_one_does():
    # Sideways the dry friction of three motors and the rollers hold; the grip could not be the limit here.
    assert moved([Fault("push", "plant", "push", at=10, lasting=300, force_n=0.3)]).pose.x_m == pytest.approx(
        0.0, abs=1e-5
    )
    plant = moved([Fault("push", "plant", "push", at=10, lasting=300, force_n=8.0, bearing_rad=math.pi)])
    assert plant.pose.x_m < -0.05
    assert abs(plant.pose.y_m) < 1e-6


def test_a_push_accelerates_as_newton_says():
    # On a floor without grip and with hardly any rolling loss nothing else acts: 0.2 s of 8 N on 1.6 kg is 1 m/s.
    smooth = replace(ROBOT, ground=replace(ROBOT.ground, rolling=1e-9))
    bench = simulated(smooth)
    faults = [
        Fault("ice", "plant", "slippery", at=0, factor=1e-9),
        Fault("push", "plant", "push", at=10, lasting=200, force_n=8.0, bearing_rad=0.5),
    ]
    bench.world = FaultyWorld(bench.world, Injector(faults, smooth, COLUMNS))
    for _ in range(220):
        bench.tick()
    vx, vy, omega = bench.world.plant.twist
    assert (vx, vy, omega) == pytest.approx((math.cos(0.5), math.sin(0.5), 0.0), abs=1e-5)


def test_a_slippery_floor_lasts_as_long_as_the_fault():
    # Reference plant-model, 4.1: forward with all wheels spinning at mu 0.15, without rolling loss and load transfer.
    robot = replace(ROBOT, ground=replace(ROBOT.ground, rolling=1e-12), body=replace(ROBOT.body, cog_height_m=1e-9))
    plant = simulated(robot).world.plant
    plant.set_grip(0.15)
    for _ in range(300):
        plant.step([10.0, 0.0, -10.0])
    assert abs(plant.twist.vx_mps) / 0.3 == pytest.approx(1.1291, rel=1e-3)
    plant.set_grip(0.7)
    before = plant.twist.vx_mps
    for _ in range(100):
        plant.step([10.0, 0.0, -10.0])
    assert abs(plant.twist.vx_mps - before) / 0.1 == pytest.approx(5.269, rel=1e-3)


def test_a_silent_esc_neither_drives_nor_reports():
    bench = simulated(ROBOT)
    injector = Injector([Fault("f", "esc", "silent", at=20, esc=2)], ROBOT, COLUMNS)
    bench.world = FaultyWorld(bench.world, injector)
    ids = [sorted(can_id for can_id, _ in bench.tick().can_feedback) for _ in range(40)]
    assert ids == [[0x201, 0x202, 0x203]] * 20 + [[0x201, 0x203]] * 20
    assert injector.counts() == {"f": 20}


# --- in a scenario -------------------------------------------------------------------------------------------------

SCENARIO = """
schema = 1
name = "faulty"
rc = "drive.bin"
seconds = 4.0
seed = 7
"""


@pytest.fixture
def scenario(tmp_path):
    from bench import demo

    for name in ("drive.bin", "drive.json"):
        shutil.copy(demo.SCENARIO.parent / name, tmp_path / name)

    def write(text):
        path = tmp_path / "faulty.toml"
        path.write_text(SCENARIO + text)
        return path

    return write


FOUR = """
[[fault]]
wire = "rc"
kind = "corrupt"
at_s = 0.2
for_s = 0.5
probability = 0.05

[[fault]]
wire = "feedback"
kind = "drop"
esc = 1
at_s = 2.0
for_s = 0.005

[[fault]]
name = "weak"
wire = "esc"
kind = "weak"
esc = 1
factor = 0.5
when = "speed_mps > 0.2"
for_s = 0.3

[[fault]]
wire = "command"
kind = "delay"
ms = 3
at_s = 2.5
for_s = 0.2
"""


def recorded(path, directory):
    run = from_source(path)
    execute(run, run.recorder(directory), quiet=True)
    return {file.name: file.read_bytes() for file in sorted(directory.iterdir())}


def test_a_run_with_faults_repeats_byte_for_byte_and_so_does_its_recording(scenario, tmp_path):
    first = recorded(scenario(FOUR), tmp_path / "a")
    assert recorded(scenario(FOUR), tmp_path / "b") == first
    again = recorded(tmp_path / "a", tmp_path / "c")
    for name in ("can.log", "rc.log", "slamware.log", "state.csv"):
        assert again[name] == first[name], name
    clean = recorded(scenario(""), tmp_path / "d")
    assert clean["can.log"] != first["can.log"]
    assert "faults.log" not in clean


def test_every_touch_has_a_witness_in_the_recording(scenario, tmp_path):
    files = recorded(scenario(FOUR), tmp_path / "a")
    witnesses = files["faults.log"].decode().splitlines()
    assert '(2.000000) "feedback drop" feedback 201#' in next(line for line in witnesses if "feedback drop" in line)
    assert sum("feedback drop" in line for line in witnesses) == 5
    assert any('"weak" esc wheel 1: ' in line for line in witnesses)
    arrived = Recording.open(tmp_path / "a").feedback
    assert [can_id for can_id, _ in arrived[2002]] == [0x202, 0x203]


def test_a_fault_that_touched_nothing_fails_the_run(scenario, capsys):
    path = scenario('[[fault]]\nname = "late"\nwire = "rc"\nkind = "drop"\nwhen = "speed_mps > 50"')
    assert main(["replay", str(path)]) == 1
    assert "FAULT     late: touched nothing" in capsys.readouterr().out


def test_counts_are_told_to_machines(scenario, capsys):
    path = scenario('[[fault]]\nwire = "rc"\nkind = "drop"\nat_s = 1.0\nfor_s = 1.0')
    assert main(["replay", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["faults"] == {"rc drop": 200}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('wire = "rx"\nkind = "drop"\nat_s = 1.0', "fault[0].wire: 'rx' is unknown; known: rc, core"),
        ('wire = "rc"\nkind = "dorp"\nat_s = 1.0', "did you mean drop?"),
        ('wire = "rc"\nkind = "drop"\nat_s = 1.0\nfro_s = 1.0', "fault[0].fro_s: unknown key; did you mean for_s?"),
        (
            'wire = "rc"\nkind = "drop"\nwhen = "sped_mps > 1"',
            "no signal is called 'sped_mps'; did you mean speed_mps?",
        ),
        ('wire = "esc"\nkind = "silent"\nesc = 4\nat_s = 1.0', "m2006 has 3 wheels, got 4"),
        ('wire = "rc"\nkind = "delay"\nat_s = 1.0', "fault[0].ms: is missing"),
    ],
)
def test_a_wrong_table_names_file_and_key(scenario, capsys, text, says):
    assert main(["replay", str(scenario(f"[[fault]]\n{text}"))]) == 2
    said = capsys.readouterr().err
    assert says in said
    assert "faulty.toml: " in said


def test_two_faults_of_one_name_are_refused(scenario, capsys):
    text = '[[fault]]\nwire = "rc"\nkind = "drop"\nat_s = 1.0\n' * 2
    assert main(["replay", str(scenario(text))]) == 2
    assert "two are called 'rc drop'" in capsys.readouterr().err


# --- a driver in the scenario --------------------------------------------------------------------------------------

STICKS = """
schema = 1
name = "sticks"
seconds = 1.5
{more}
[[stick]]
at_s = 0.2
aux1 = true

[[stick]]
at_s = 0.3
forward = 0.5

[[expect]]
always = "{channel} == {raw}"
from_s = 0.35

[[expect]]
eventually = "vx_mps > 0.2"
"""


@pytest.mark.parametrize(
    ("more", "channel", "raw"),
    [
        ("", "rc2", 1024),  # uart12: forward is below the middle, by half of 2048
        ('profile = "frsky-sbus"', "rc1", 1402),  # 992 + 819.5 / 2
        ('profile = "elrs"', "rc1", 1402),
    ],
)
def test_a_timeline_of_sticks_drives_in_whatever_the_transmitter_speaks(tmp_path, capsys, more, channel, raw):
    path = tmp_path / "sticks.toml"
    path.write_text(STICKS.format(more=more, channel=channel, raw=raw))
    status = main(["replay", str(path)])
    assert status == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('rc = "drive.bin"\n[[stick]]\nat_s = 0.1', "a run has one driver"),
        ("[[stick]]\nat_s = 0.1\nforward = 2.0", "stick[0].forward: expected -1 to 1"),
        (
            "[[stick]]\nat_s = 0.2\n[[stick]]\nat_s = 0.1",
            "stick[1].at_s: the times must rise from entry to entry: 0.1 s comes after 0.2 s",
        ),
        ("[[stick]]\nat_s = -0.1", "expected 0 to 86400 seconds, got -0.1"),
        ('robot = "slamware-b"\n[[stick]]\nat_s = 0.1', "takes no RC"),
    ],
)
def test_a_wrong_timeline_is_one_sentence(tmp_path, capsys, text, says):
    path = tmp_path / "sticks.toml"
    path.write_text(f'schema = 1\nname = "s"\nseconds = 1.0\n{text}')
    assert main(["replay", str(path)]) == 2
    assert says in capsys.readouterr().err
