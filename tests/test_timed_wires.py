"""Scenarios whose wires take their time: nothing changes where there is room, and what does not fit is late or lost."""

import re
from argparse import Namespace
from itertools import pairwise

import pytest
from desk import Granted

from bench.canbus.bits import frame_bits
from bench.check.sources import from_recording, from_source
from bench.check.summary import Summary
from bench.cli.on_ports import prepared
from bench.config import load_robot
from bench.io.history import CoreJoins
from bench.io.link import InlineLink
from bench.io.still import again, still
from bench.messages import TickInput
from bench.rc.line import Settings
from bench.rc.transmitter import Sticks, Transmitter
from bench.timed.settings import Wires
from bench.timed.timing import Timing
from bench.timed.uart import Paced

DRIVE = """schema = 1
name = "drive"
robot = "{robot}"
seconds = 2.0
[[stick]]
at_s = 0.3
aux1 = true
[[stick]]
at_s = 0.5
forward = 0.5
turn = 0.3
"""


def scenario(tmp_path, wires="", robot="m2006", name="drive.toml"):
    path = tmp_path / name
    path.write_text(DRIVE.format(robot=robot) + wires)
    return path


def run(path, directory=None):
    job = from_source(path)
    if directory is None:
        return job, list(job)
    with job.recorder(directory) as recorder:
        outs = list(job)
        recorder.extend(outs)
    return job, outs


def test_a_bus_with_room_changes_nothing_that_the_motors_or_the_base_see(tmp_path):
    """At 1 Mbit/s half of the bus is free: every frame is where it was, though each has its time now."""
    plain, without = run(scenario(tmp_path))
    timed, outs = run(scenario(tmp_path, "[wires]\n", name="timed.toml"))
    moving = [out for out in outs if out.tick > 1000]  # RC frames take 2.6 ms now: arming comes a little later
    assert plain.bench.world.plant.pose.x_m == pytest.approx(timed.bench.world.plant.pose.x_m, abs=0.003)
    assert timed.bench.world.timing.lost_commands == timed.bench.world.timing.lost_reports == 0
    assert all([can_id for can_id, _ in out.can_feedback] == [0x201, 0x202, 0x203] for out in moving)
    assert len(outs) == len(without)


def test_rc_bytes_arrive_as_their_line_brings_them(tmp_path):
    """uart12 at 115200 8E2, twelve bits a byte: a millisecond carries 9.6 bytes, so a frame comes in pieces."""
    _, outs = run(scenario(tmp_path, "[wires]\n"))
    _, plain = run(scenario(tmp_path, name="plain.toml"))
    assert b"".join(out.rc for out in outs) == b"".join(out.rc for out in plain)[: sum(len(out.rc) for out in outs)]
    assert max(len(out.rc) for out in outs) <= 10 < max(len(out.rc) for out in plain)


def test_rc_bytes_take_their_time_in_a_fork_of_a_recording_too(tmp_path):
    """The recorded ones have been through the line. Whoever drives on from there has a transmitter before it again."""
    run(scenario(tmp_path, "[wires]\n"), tmp_path / "run")
    job = from_recording(tmp_path / "run")
    robot = job.bench.robot
    given = {
        tick: data for tick in range(1200, 1400) if (data := Transmitter(robot.rc).step(tick, Sticks(forward=0.5)))
    }
    link = InlineLink(job.bench, job.inputs, Granted(), remembers=True)
    link.run(1500)
    link.see(1200)
    link.fork(lambda tick: TickInput(given.get(tick, b"")))
    link.join(CoreJoins())
    link.run(200)
    arrived = [out.rc for out in link.between(1200, 1400)]
    assert max(map(len, given.values())) == 12
    assert max(map(len, arrived)) <= 10, "a millisecond carries 9.6 bytes"
    assert len(b"".join(given.values())) - len(b"".join(arrived)) < 12, "all have come, but for what is on the wire"


def test_each_frame_has_its_time_in_the_recording(tmp_path):
    """bus.log: when each frame was through, to the microsecond; no two at once, and each as long as its bits."""
    _, outs = run(scenario(tmp_path, "[wires]\n"), tmp_path / "run")
    lines = (tmp_path / "run" / "bus.log").read_text().splitlines()
    entries = [re.fullmatch(r"\((\d+)\.(\d{6})\) can0 ([0-9A-F]{3})#([0-9A-F]*)", line) for line in lines]
    frames = [(int(m[1]) * 1_000_000 + int(m[2]), int(m[3], 16), bytes.fromhex(m[4])) for m in entries]
    assert len(frames) == sum(len(out.can_commands) + len(out.can_feedback) for out in outs)
    for (before_us, _, _), (us, can_id, data) in pairwise(frames):
        assert us - before_us >= frame_bits(can_id, data)
    first = [us for us, can_id, _ in frames if can_id == 0x200][:3]
    assert first == [tick * 1000 + frame_bits(0x200, bytes(8)) - 3 for tick in range(3)]


def test_a_recording_runs_again_to_the_same_bytes(tmp_path):
    wires = '[wires]\ncan_bitrate = 450000\nslamware_baud = 9600\nalso = ["0x100:500"]\n[[core]]\nat_s = 0.1\n'
    _, outs = run(scenario(tmp_path, wires + "vx_mps = 0.2\n"), tmp_path / "run")
    second = list(from_recording(tmp_path / "run"))
    assert [(out.can_commands, out.can_feedback, out.base_to_core) for out in second] == [
        (out.can_commands, out.can_feedback, out.base_to_core) for out in outs
    ]


def test_a_bus_is_never_more_than_full(tmp_path):
    """A frame that is on the wire at the end of the run has taken what has passed of it."""
    job, outs = run(scenario(tmp_path, "[wires]\ncan_bitrate = 10000\n"))
    assert 0.999 < job.bench.world.timing.load(len(outs)) <= 1.0


def test_a_still_of_a_run_holds_no_log(tmp_path):
    """Nobody takes a log from a copy; with it each instant of the history would be ten times as large."""
    job, _ = run(scenario(tmp_path, "[wires]\n"))
    timing = job.bench.world.timing
    assert timing.take_log() == [], "nobody has asked for one"
    plain = len(still(timing))
    log = timing.start_log()
    for _ in range(50):
        job.bench.tick()
    assert len(still(timing)) < plain + 200
    assert again(still(timing)).take_log() == []
    assert len(log()) == 200


@pytest.mark.parametrize(("bitrate", "lost_share"), [(500_000, 0.01), (375_000, 0.34), (250_000, 0.67)])
def test_what_does_not_fit_is_lost_by_those_who_are_least_urgent(tmp_path, bitrate, lost_share):
    """A command and three reports are some 490 bits; a bus of 375 a millisecond has no room for the third report."""
    job, outs = run(scenario(tmp_path, f"[wires]\ncan_bitrate = {bitrate}\n"))
    timing = job.bench.world.timing
    assert timing.lost_commands == 0
    assert timing.lost_reports == pytest.approx(lost_share * 3 * len(outs), abs=0.04 * 3 * len(outs))
    heard = [can_id for out in outs for can_id, _ in out.can_feedback]
    assert heard.count(0x201) >= heard.count(0x202) >= heard.count(0x203)
    assert timing.load(len(outs)) > 0.95


def test_other_nodes_take_room_and_say_nothing_to_the_base(tmp_path):
    alone, _ = run(scenario(tmp_path, "[wires]\n"))
    shared, outs = run(scenario(tmp_path, '[wires]\nalso = ["0x100:1000", "0x7FF:500"]\n', name="shared.toml"))
    more = shared.bench.world.timing.load(2000) - alone.bench.world.timing.load(2000)
    bits = 1000 * frame_bits(0x100, bytes(8)) + 500 * frame_bits(0x7FF, bytes(8))
    assert more == pytest.approx(bits / 1e6, rel=0.02)
    assert {can_id for out in outs for can_id, _ in out.can_feedback} == {0x201, 0x202, 0x203}
    assert shared.bench.bus_findings == ()


@pytest.mark.parametrize("baud", [115_200, 19_200])
def test_a_request_that_takes_several_ticks_is_one_request(tmp_path, baud):
    """As the core itself counts what it sends and hears; the last ones may be on their way at the end."""
    job, outs = run(scenario(tmp_path, f"[wires]\nslamware_baud = {baud}\n[[core]]\nat_s = 0.1\nvx_mps = 0.2\n"))
    assert sum(out.core_to_base != b"" for out in outs) > 1.4 * sum(job.bench.world.core.requests.values())
    summary = Summary(len(job.bench.robot.wheels))
    for at in range(0, len(outs), 7):
        summary.extend(outs[at : at + 7])
    frames = summary.facts(job)["frames"]
    sent, heard = sum(job.bench.world.core.requests.values()), sum(job.bench.world.core.answers.values())
    assert 0 <= sent - frames["core_requests"] <= 1
    assert 0 <= frames["core_answers"] - heard <= 1
    assert sent > 30


def test_a_line_that_is_too_slow_loses_from_the_front():
    line = Paced(Settings(9600))
    assert line.put(bytes(100)) == 0
    assert sum(len(line.step()) for _ in range(100)) == 96, "8N1 is ten bits a byte"
    assert line.put(bytes(1000)) == 460, "4 wait; 480, half a second's worth, and 64 more find room"
    assert line.lost == 460


def test_a_command_that_comes_late_is_late_for_its_motor_too():
    """A bus that others keep busy: the command is in its motor's hands when it is through, and not before."""
    timing = Timing(Wires(1_000_000, also=tuple((can_id, 1000) for can_id in range(6))), None)
    arrived = []
    for tick in range(3):
        arrived.append(timing.commands(tick, [(0x200, bytes([tick] * 8))]))
        timing.reports(tick, ())
    assert arrived[0] == (), "six frames of 124 bits and more come first"
    assert arrived[1][0] == (0x200, bytes(8))


@pytest.mark.parametrize(
    ("wires", "words"),
    [
        ("can_bitrate = 2000000", "expected 10000 to 1000000 in whole thousands"),
        ("can_bitrate = 83333", "in whole thousands"),
        ("slamware_baud = 1", "expected 1200 to"),
        ('also = ["205"]', 'like "0x205:1000"'),
        ('also = ["0x900:10"]', 'like "0x205:1000"'),
        ("bitrate = 500000", "can_bitrate"),
    ],
)
def test_wrong_settings_name_the_key(call, tmp_path, wires, words):
    path = scenario(tmp_path, f"[wires]\n{wires}\n")
    status, _, err = call("replay", path)
    assert status == 2
    assert "wires" in err
    assert words in err


def test_real_wires_take_their_own_time(tmp_path):
    """With a role the table has no say: a report would be late twice, run.toml would tell of no real bus."""
    job = from_source(scenario(tmp_path, "[wires]\ncan_bitrate = 450000\n"))
    said = {"rc": "sim:", "slamware": "sim:", "can": "can:virtual:timed-role", "record": tmp_path / "run"}
    ready = prepared(Namespace(role="motors", arm=True, overwrite=False, **said), job)
    ready.takers[0].close()
    ready.rig.close()
    assert job.bench.world.timing is None
    assert "wires" not in (tmp_path / "run" / "run.toml").read_text()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("wires_can_bitrate = 7", "expected 10000 to 1000000"),
        ("wires_slamware_baud = -5", "expected 1200 to"),
        ('wires_also = "zz"', 'like "0x205:1000"'),
    ],
)
def test_a_damaged_recording_is_a_sentence(call, tmp_path, line, words):
    """run.toml is read as strictly as the scenario was; a bitrate of 7 was a division by zero."""
    run(scenario(tmp_path, '[wires]\nalso = ["0x100:10"]\n'), tmp_path / "run")
    said, key = tmp_path / "run" / "run.toml", line.split()[0]
    said.write_text(re.sub(f"(?m)^{key} = .*$", line, said.read_text()))
    status, _, err = call("replay", tmp_path / "run")
    assert status == 2
    assert "run.toml: wires." in err
    assert words in err
    assert len(err.splitlines()) == 1


def test_a_person_is_told_what_did_not_fit(call, tmp_path):
    path = scenario(tmp_path, '[wires]\ncan_bitrate = 375000\n[checks]\nmotion = "off"\n')
    _, out, _ = call("replay", path)
    assert re.search(
        r"wires +the bus was (9\d|100)\.\d % full; never sent: 0 commands, [1-9]\d+ feedback frames, 0 b", out
    )


def test_every_robot_drives_over_timed_wires(tmp_path):
    for robot in ("dm3519", "omni4", "mecanum"):
        profile = load_robot(robot).rc
        assert profile is not None
        job, outs = run(scenario(tmp_path, "[wires]\n", robot, f"{robot}.toml"))
        assert job.bench.world.timing.lost_commands == 0
        assert any(any(data) for out in outs for _, data in out.can_commands), robot
