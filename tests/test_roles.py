"""Roles: a part of the bench is at the end of real wires. By hand in one process, then in processes of their own."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest
import serial
from patience import DEADLINE_S, until

from bench.check.reading import Recording
from bench.check.sources import from_source
from bench.config import load_robot
from bench.errors import SurroundingsError, UsageError
from bench.io.can_port import open_can
from bench.io.clock import wait_ns
from bench.io.emulated.devices import CoreOnLine, EscsOnBus, FirmwareOnPorts
from bench.io.emulated.slcan import SlcanOnLine
from bench.io.kinds.crossed import crossed
from bench.io.limiter import Limiter
from bench.io.process.child import Prepared
from bench.io.process.link import ProcessLink
from bench.io.process.wire import Beat
from bench.io.rig import OutBus
from bench.io.roles import take_role
from bench.io.serial_port import open_serial
from bench.loop import simulated
from bench.m2006 import decode_command, encode_command
from bench.messages import BodyTwist, TickInput
from bench.rc.transmitter import Sticks, Transmitter
from bench.scenarios import run as run_scenario
from bench.screen.keyboard import Keyboard
from bench.screen.session import Session
from bench.screen.view import draw, places
from bench.world import World

ROOT = Path(__file__).parents[1]
M2006 = load_robot("m2006")

DRIVES = """schema = 1
name = "drives"
robot = "m2006"
seconds = {seconds}
[[stick]]
at_s = 0.3
aux1 = true
[[stick]]
at_s = 0.5
forward = 0.5
[[core]]
at_s = 0.1
vx_mps = 0.2
"""


AGAIN = """[[stick]]
at_s = {at_s}.7
[[stick]]
at_s = {at_s}.9
aux1 = true
[[stick]]
at_s = {at_s}.95
forward = 0.5
"""


def scenario(tmp_path, seconds=1.5, more=""):
    path = tmp_path / "drives.toml"
    path.write_text(DRIVES.format(seconds=seconds) + more)
    return path


# --- the last line before the port ---------------------------------------------------------------------------------


def test_the_limiter_lets_no_current_pass_beyond_the_robots_limit():
    """m2006: 0.6 A, ESCs 1 to 3; the fourth slot is somebody else's motor."""
    limit = Limiter(M2006)
    wild = (0x200, (10000).to_bytes(2, "big") + (-10000).to_bytes(2, "big", signed=True) + bytes.fromhex("0064 2710"))
    assert limit([wild]) == (
        (0x200, (600).to_bytes(2, "big") + (-600).to_bytes(2, "big", signed=True) + b"\0\x64\0\0"),
    )
    assert limit([(0x200, bytes.fromhex("0258 FDA8 0000 0000"))]) == ((0x200, bytes.fromhex("0258FDA800000000")),)
    assert (limit.clamped, limit.refused) == (1, 0)
    assert limit([(0x1FF, bytes(8)), (0x200, bytes(7)), (0x201, bytes(8)), (0x123, b"")]) == ()
    assert limit.refused == 4
    assert limit.stop == ((0x200, bytes(8)),)


def test_of_late_ticks_only_the_newest_frame_of_each_identifier_leaves():
    bus, far = crossed()
    out = OutBus(bus)
    for k in range(3):
        out.put([(0x200, bytes([k])), (0x1FF, bytes([k]))])
    out.put([(0x300, b"\x09"), (0x300, b"\x0a")])
    assert far.read() == ()
    out.flush()
    assert far.read() == ((0x200, b"\x02"), (0x1FF, b"\x02"), (0x300, b"\x09"), (0x300, b"\x0a"))
    assert out.superseded == 4
    out.flush()
    assert far.read() == ()


# --- by hand -------------------------------------------------------------------------------------------------------


class ByHand:
    """A bench in a role and the device at its other end, ticked in turns; wires are real, time is not."""

    def __init__(self, path, role, **wires):
        self.job = from_source(path)
        self.bench, self.rig = take_role(self.job.bench, role, **wires)
        self.inputs = self.rig.gated(self.job.inputs)
        self.outs = []

    def run(self, device, ticks=None, meanwhile=lambda tick: None):
        for _ in range(self.job.ticks if ticks is None else ticks):
            tick = self.bench.now_tick
            self.outs.append(self.bench.tick(self.inputs(tick)))
            self.rig.step()
            self.rig.flush()
            self.rig.look(tick)
            device.step(tick)
            meanwhile(tick)
        return self


def test_motors_are_driven_within_limits_and_stopped_at_the_end(tmp_path):
    bench = ByHand(scenario(tmp_path), "motors", can="can:virtual:roles-motors")
    escs = EscsOnBus(M2006, open_can("escs", "can:virtual:roles-motors"))
    bench.run(escs)
    assert escs.motors.plant.pose.x_m > 0.1, "the emulated robot has moved"
    assert bench.bench.world.plant.pose.x_m == pytest.approx(escs.motors.plant.pose.x_m, abs=0.02), "the shadow with it"
    assert bench.bench.base.odometry.pose.x_m == pytest.approx(escs.motors.plant.pose.x_m, abs=0.01)
    most = max(abs(raw) for out in bench.outs for _, data in out.can_commands for raw in decode_command(data))
    assert 0 < most <= 600
    bench.rig.close()
    assert escs.bus.read()[-1] == (0x200, bytes(8))
    escs.close()


@pytest.mark.parametrize(
    ("role", "wires", "tells"),
    [
        ("motors", {}, "needs --can"),
        ("motors", {"can": "can:slcan:pty:"}, "add --arm"),
        ("motors", {"can": "can:socketcan:can0"}, "add --arm"),
        ("motors", {"can": "can:udp_multicast:239.0.0.1?remote=yes"}, "add --arm"),
        ("motors", {"can": "can:virtual:x", "rc": "pty:"}, "leave it out"),
        ("base", {}, "needs --can"),
        ("core", {}, "needs --slamware"),
        ("core", {"slamware": "pty:", "can": "can:virtual:x"}, "leave it out"),
    ],
)
def test_wires_that_a_role_cannot_use_are_refused(role, wires, tells):
    with pytest.raises(UsageError, match=tells):
        take_role(simulated(M2006), role, **wires)


def test_a_profile_that_arms_by_its_link_never_meets_real_motors():
    robot = load_robot("m2006", "futaba-sbus2")
    assert robot.rc.arming == "on_link"
    with pytest.raises(UsageError, match="arms by its link alone"):
        take_role(simulated(robot), "motors", can="can:slcan:pty:", armed=True)


def test_faults_of_what_is_real_are_refused(tmp_path):
    path = scenario(tmp_path, more='[[fault]]\nname = "dead"\nwire = "esc"\nkind = "silent"\nesc = 1\nat_s = 1.0\n')
    with pytest.raises(UsageError, match="one of esc, which is real here"):
        take_role(from_source(path).bench, "motors", can="can:virtual:x")


def test_a_firmware_on_three_wires_drives_the_simulated_robot(tmp_path):
    at = {wire: str(tmp_path / wire) for wire in ("rc", "slamware", "can")}
    bench = ByHand(
        scenario(tmp_path),
        "base",
        rc=f"pty:{at['rc']}",
        slamware=f"pty:{at['slamware']}",
        can=f"can:slcan:pty:{at['can']}",
    )
    firmware = FirmwareOnPorts(
        M2006,
        open_can("--can", f"can:slcan:{at['can']}"),
        open_serial("--rc", f"serial:{at['rc']}"),
        open_serial("--slamware", f"serial:{at['slamware']}"),
    )
    bench.run(firmware)
    assert firmware.base.drive.armed
    assert firmware.base.slave.connected
    plant = bench.bench.world.plant
    assert plant.pose.x_m > 0.1
    assert firmware.base.odometry.pose.x_m == pytest.approx(plant.pose.x_m, abs=0.01)
    assert sum(len(out.can_commands) for out in bench.outs) > 1000
    assert bench.bench.snapshot().driver == "foreign base"
    firmware.close()
    bench.rig.close()


def test_an_emulated_firmware_is_limited_and_leaves_no_current_behind():
    """Who plays a base may have real motors at the other end: the last line before the port is that of the role."""
    bus = open_can("far", "can:virtual:roles-firmware")
    firmware = FirmwareOnPorts(M2006, open_can("--can", "can:virtual:roles-firmware"), None, None)
    wild = (0x200, encode_command((10_000, -10_000, 100, 9999)))
    firmware.base.step = lambda *wires: ((wild, (0x123, b"")), b"")
    firmware.step(0)
    assert bus.read() == ((0x200, encode_command((600, -600, 100, 0))),)
    firmware.close()
    assert bus.read() == ((0x200, bytes(8)),)
    bus.close()


def test_a_core_on_a_wire_drives_the_simulated_robot(tmp_path):
    line = tmp_path / "core"
    quiet = scenario(tmp_path, seconds=3.0)
    quiet.write_text(quiet.read_text().replace("forward = 0.5", "forward = 0.0"))
    bench = ByHand(quiet, "core", slamware=f"pty:{line}")
    core = CoreOnLine(open_serial("core", f"serial:{line}"), {0: BodyTwist(0.2, 0.0, 0.0)})
    bench.run(core)
    assert bench.bench.base.drive.driver == "core"
    assert bench.bench.world.plant.pose.x_m > 0.2
    assert core.core.pose.x_m == pytest.approx(bench.bench.world.plant.pose.x_m, abs=0.05)
    core.close()
    bench.rig.close()


def test_a_pulled_cable_stops_everything_until_somebody_arms_again(tmp_path):
    """The bus goes in the middle of a drive, and comes back while the driver still holds the stick."""
    link = tmp_path / "adapter"

    def adapter():
        bus, far = crossed()
        return SlcanOnLine(open_serial("adapter", f"pty:{link}"), bus), EscsOnBus(M2006, far)

    class Both:
        def __init__(self):
            self.parts = adapter()

        def step(self, tick):
            for part in self.parts:
                part.step(tick)

    both = Both()
    bench = ByHand(scenario(tmp_path, 60.0), "motors", can=f"can:slcan:{link}", armed=True)
    bench.run(both, 1000)
    assert bench.bench.base.drive.armed
    assert both.parts[1].motors.plant.twist.vx_mps > 0.1
    both.parts[0].close()
    bench.run(Quiet(), 700)
    assert not bench.bench.base.drive.armed
    (tick, text), *_ = bench.rig.notices
    assert (tick, "lost" in text, "zero until it is back" in text) == (1000, True, True)
    both.parts = adapter()
    until(lambda: not bench.rig.missing, lambda: bench.run(both, 1))
    bench.run(both, 1000)
    assert bench.rig.notices[-1][1].endswith("back; arm again to go on")
    after = [frame for out in bench.outs[-900:] for frame in out.can_commands]
    assert set(after) == {(0x200, bytes(8))}, "the stick is still pushed, and nothing moves"
    assert both.parts[1].motors.plant.twist.vx_mps == pytest.approx(0.0, abs=1e-6)
    bench.rig.close()
    both.parts[0].close()


def test_why_motors_stand_still_under_a_base_that_is_armed_is_told_until_it_is_armed_anew(tmp_path):
    """An operator who is silent for less than half a second does not disarm the base, and stops the motors."""
    again = AGAIN.format(at_s=1) + AGAIN.format(at_s=2)  # the first press disarms
    bench = ByHand(scenario(tmp_path, 60.0, again), "motors", can="can:virtual:roles-held")
    escs = EscsOnBus(M2006, open_can("escs", "can:virtual:roles-held"))
    bench.run(escs, 1000)
    assert escs.motors.plant.twist.vx_mps > 0.1
    assert bench.rig.missing == ()
    bench.rig.watch_operator(1000, silent=True)
    bench.run(escs, 300)
    bench.rig.watch_operator(1300, silent=False)
    bench.run(escs, 500)
    assert bench.bench.base.drive.armed
    assert escs.motors.plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)
    assert bench.rig.missing == ("real motors are held at zero: disarm and arm again to go on",)
    bench.run(escs, 200)
    assert (bench.bench.base.drive.armed, bench.rig.missing) == (False, ())
    bench.run(escs, 1500)
    assert bench.rig.missing == ()
    assert escs.motors.plant.twist.vx_mps > 0.1
    assert [text for _, text in bench.rig.notices] == [
        "the operator is silent: zero until that changes",
        "the operator is back; arm again to go on",
    ]
    bench.rig.close()
    escs.close()


NO_RC = """schema = 1
name = "no transmitter"
robot = "slamware-b"
seconds = 60.0
""" + "".join(f"[[core]]\nat_s = {at_s}\nvx_mps = {vx_mps}\n" for at_s, vx_mps in ((0.1, 0.2), (3.0, 0.0), (3.5, 0.2)))


def test_motors_of_a_robot_without_rc_move_as_its_core_asks_and_after_a_silence_when_it_has_stood(tmp_path):
    """Nobody can disarm it: what has to be asked for first, before it moves again, is that it stands."""
    (tmp_path / "no_rc.toml").write_text(NO_RC)
    bench = ByHand(tmp_path / "no_rc.toml", "motors", can="can:virtual:roles-no-rc")
    escs = EscsOnBus(load_robot("slamware-b"), open_can("escs", "can:virtual:roles-no-rc"))
    plant = escs.motors.plant
    bench.run(escs, 1000)
    assert plant.twist.vx_mps > 0.1
    bench.rig.watch_operator(1000, silent=True)
    bench.run(escs, 100)
    bench.rig.watch_operator(1100, silent=False)
    bench.run(escs, 1700)
    assert plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)
    assert bench.rig.missing == ("real motors are held at zero: ask it to stand to go on",)
    assert bench.rig.notices[-1] == (1100, "the operator is back; ask it to stand to go on")
    bench.run(escs, 500)
    assert bench.rig.missing == ()
    assert plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)
    bench.run(escs, 1200)
    assert plant.twist.vx_mps > 0.1
    bench.rig.close()
    assert escs.bus.read()[-1] == (0x200, bytes(8))
    escs.close()


def test_a_recordings_core_does_not_move_motors_again_after_a_silence(tmp_path):
    """Its requests are bytes that go on as they were: nobody has asked for anything anew."""
    run_scenario(robot="slamware-b", seconds=2.0, core=[{"at_s": 0.1, "vx_mps": 0.2}], record=tmp_path / "asked")
    bench = ByHand(tmp_path / "asked", "motors", can="can:virtual:roles-recorded-core")
    escs = EscsOnBus(load_robot("slamware-b"), open_can("escs", "can:virtual:roles-recorded-core"))
    bench.run(escs, 1000)
    assert escs.motors.plant.twist.vx_mps > 0.1
    bench.rig.watch_operator(1000, silent=True)
    bench.run(escs, 100)
    bench.rig.watch_operator(1100, silent=False)
    bench.run(escs, 900)
    assert escs.motors.plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)
    assert bench.rig.missing == ("real motors are held at zero: start this run anew to go on",)
    bench.rig.close()
    escs.close()


class Quiet:
    def step(self, tick):
        pass


def test_a_core_that_floods_is_named_and_the_base_goes_on(tmp_path):
    """64 KB a millisecond of its own poll, cut anywhere; then of junk: half frames, another protocol."""
    line = tmp_path / "core"
    bench = ByHand(scenario(tmp_path), "core", slamware=f"pty:{line}")
    rng = random.Random("flood 1")
    poll = bytes.fromhex("1002f830da")
    with serial.Serial(str(line), 115200, write_timeout=0) as peer:

        def flood(tick):
            with suppress(serial.SerialTimeoutException, BlockingIOError):
                os.write(peer.fileno(), (poll * 4000)[rng.randrange(5) :] if tick % 2 else rng.randbytes(8000))

        bench.run(Quiet(), 100, flood)
        assert any("floods" in text for _, text in bench.rig.notices)
        bench.run(Quiet(), 1000)
    assert bench.bench.base.drive.armed
    assert bench.bench.world.plant.twist.vx_mps > 0.1
    assert len([text for _, text in bench.rig.notices if "floods" in text]) == 1
    bench.rig.close()


def test_a_bus_that_floods_is_named_and_the_firmware_is_heard(tmp_path):
    bench = ByHand(scenario(tmp_path), "base", can="can:virtual:roles-flood")
    peer = open_can("peer", "can:virtual:roles-flood")
    bench.run(
        Quiet(), 15, lambda tick: peer.write([(0x123, bytes(8))] * 300 + [(0x200, bytes([2, 88, 0, 0, 0, 0, 0, 0]))])
    )
    assert [text for _, text in bench.rig.notices if "floods" in text]
    bench.run(Quiet(), 40)
    assert bench.outs[-1].can_commands == ()
    assert sum(can_id == 0x200 for out in bench.outs for can_id, _ in out.can_commands) == 15, "no command is lost"
    bench.rig.close()
    peer.close()


# --- in a process of its own -----------------------------------------------------------------------------------------


def wheelbench(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "bench", *map(str, arguments)],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def adapter(tmp_path):
    """An SLCAN adapter with the robot's motors, stepped by the test; `commands` are what the motors were told."""

    class Adapter:
        link = tmp_path / "adapter"

        def __init__(self):
            self.commands, self.tick = [], 0
            self.plug_in()

        def plug_in(self):
            bus, far = crossed()
            self.line = SlcanOnLine(open_serial("adapter", f"pty:{self.link}"), bus)
            self.escs = EscsOnBus(M2006, far)
            read = far.read

            def noted():
                frames = read()
                self.commands += frames
                return frames

            far.read = noted

        def pull(self):
            self.line.close()

        def step(self):
            self.line.step(self.tick)
            self.escs.step(self.tick)
            self.tick += 1

    made = Adapter()
    yield made
    made.pull()


@pytest.fixture
def long_drive(tmp_path):
    """Longer than any test takes. It arms in its first second, and where the machine stood still just then (the
    operator was silent, and real motors got nothing) once more every ten seconds.
    """
    return scenario(tmp_path, 100.0, "".join(AGAIN.format(at_s=at_s) for at_s in range(9, 90, 10)))


def moving(commands):
    return any(data != bytes(8) for _, data in commands)


def test_a_run_says_that_its_cable_was_pulled_and_goes_on_when_it_is_back(tmp_path, adapter, long_drive):
    recording = tmp_path / "run"
    running = wheelbench(
        "replay", long_drive, "--role", "motors", "--can", f"can:slcan:{adapter.link}", "--arm", "--record", recording
    )
    try:
        until(lambda: moving(adapter.commands), adapter.step)
        adapter.pull()
        said = ""
        while "zero until it is back" not in said:
            said = running.stdout.readline()
            assert said or running.poll() is None
        adapter.commands.clear()
        adapter.plug_in()
        until(lambda: len(adapter.commands) > 20, adapter.step)
        assert not moving(adapter.commands)
        while "back; arm again" not in said:
            said = running.stdout.readline()
            assert said
        running.send_signal(signal.SIGINT)
        until(lambda: running.poll() is not None, adapter.step)
        out, err = running.communicate()
        assert running.returncode == 130
        assert "interrupted" in err
        assert re.search(r"role +motors; ports were lost 1 times", out)
        assert "late      p50" in out
    finally:
        running.kill()
        running.communicate()
    kept = Recording.open(recording)
    assert kept.ticks > 500
    assert kept.info.role == "motors"


@pytest.mark.parametrize("what", ["killed", "stopped"])
def test_when_the_operators_process_is_gone_the_motors_stop(tmp_path, adapter, long_drive, what):
    wires = ("--role", "motors", "--can", f"can:slcan:{adapter.link}", "--arm")
    running = wheelbench("replay", long_drive, *wires, "--record", tmp_path / "run")
    try:
        until(lambda: moving(adapter.commands), adapter.step)
        running.send_signal(signal.SIGKILL if what == "killed" else signal.SIGSTOP)

        def stands():
            adapter.commands.clear()
            for _ in range(100):
                adapter.step()
                wait_ns(1_000_000)
            told = list(adapter.commands)
            currents_a = adapter.escs.motors.plant.currents_a
            return (told or what == "killed") and not moving(told) and max(map(abs, currents_a)) < 1e-6

        until(stands)
        if what == "killed":
            until(lambda: not adapter.line.adapter.is_open, adapter.step)
    finally:
        running.kill()
        running.communicate()
    until(lambda: not adapter.line.adapter.is_open, adapter.step)
    recorded = (tmp_path / "run" / "run.toml").read_text()
    until(lambda: "ticks = " in (tmp_path / "run" / "run.toml").read_text())
    assert 'role = "motors"' in recorded


@pytest.mark.skipif(
    not Path(f"/proc/self/task/{os.getpid()}/children").exists(),
    reason="no /proc/PID/task/PID/children here: that takes a kernel with CONFIG_PROC_CHILDREN",
)
def test_when_the_loops_own_process_is_killed_the_motors_are_stopped_by_its_parent(adapter, long_drive):
    running = wheelbench("replay", long_drive, "--role", "motors", "--can", f"can:slcan:{adapter.link}", "--arm")
    try:
        until(lambda: moving(adapter.commands), adapter.step)
        (loop,) = Path(f"/proc/{running.pid}/task/{running.pid}/children").read_text().split()
        os.kill(int(loop), signal.SIGKILL)
        until(lambda: running.poll() is not None, adapter.step)
        _, err = running.communicate()
        assert running.returncode == 3
        assert "ended without a word" in err
        for _ in range(50):
            adapter.step()
        assert adapter.commands[-1] == (0x200, bytes(8))
    finally:
        running.kill()
        running.communicate()


def logged(recording, name, pattern):
    """How often this stands in a log of a recording that is being written."""
    path = recording / name
    return len(re.findall(pattern, path.read_text(), re.MULTILINE)) if path.exists() else 0


def ended(process, how=signal.SIGINT):
    """What it says at its end, the last line read as JSON; asked to end by Ctrl-C, unless it does so by itself."""
    if how is not None:
        process.send_signal(how)
    out, err = process.communicate(timeout=DEADLINE_S)
    assert process.returncode in ((0, 130) if how is not None else (0,)), err
    return json.loads(out.splitlines()[-1]), err


def test_motors_and_bench_meet_over_multicast_between_processes(tmp_path, multicast, long_drive):
    recording = tmp_path / "run"
    wires = ("--role", "motors", "--can", multicast, "--arm", "--json")
    escs = wheelbench("emulate", "escs", multicast, "--json")
    run = None
    try:
        assert json.loads(escs.stdout.readline())["event"] == "listening"
        run = wheelbench("replay", long_drive, *wires, "--record", recording)
        until(lambda: logged(recording, "can.log", r" 20[1-4]#") > 200)
        until(lambda: logged(recording, "can.log", r" 201#.{8}(?!0000)") > 10)
        facts, _ = ended(run)
        assert facts["role"] == "motors"
        assert facts["frames"]["can_feedback"] > 200
        assert 0.0 < facts["top_current_a"] <= 0.6
        facts, _ = ended(wheelbench("replay", scenario(tmp_path, 0.6), *wires), None)
        assert facts["lateness"]["ticks"] == 600, "it ends by itself"
        last, _ = ended(escs)
        assert last["commands"] > 10
    finally:
        for one in filter(None, (run, escs)):
            one.kill()
            one.communicate()


def test_a_firmware_in_another_process_meets_the_bench_on_three_wires(tmp_path):
    at, recording = {wire: tmp_path / wire for wire in ("rc", "slamware", "can")}, tmp_path / "run"
    run = wheelbench(
        "replay", scenario(tmp_path, 100.0), "--role", "base", "--json", "--record", recording,
        "--rc", f"pty:{at['rc']}", "--slamware", f"pty:{at['slamware']}", "--can", f"can:slcan:pty:{at['can']}",
    )  # fmt: skip
    firmware = None
    try:
        until(lambda: all(link.exists() for link in at.values()) or run.poll() is not None)
        firmware = wheelbench(
            "emulate", "firmware", "--json", "--arm", "--seconds", "200",
            "--rc", f"serial:{at['rc']}", "--slamware", f"serial:{at['slamware']}", "--can", f"can:slcan:{at['can']}",
        )  # fmt: skip
        until(lambda: logged(recording, "can.log", r" 200#") > 100 and logged(recording, "slamware.log", r" < ") > 10)
        heard = {"feedback": 0, "rc_frames": 0}
        while heard["feedback"] <= 100 or heard["rc_frames"] <= 10:
            heard |= json.loads(firmware.stdout.readline())
        facts, err = ended(run)
        assert facts["frames"]["can_commands"] > 100
        assert facts["frames"]["core_answers"] > 3
        assert "waiting" in err, "it began when the firmware was there"
        last, _ = ended(firmware)
        assert last["feedback"] > 100
        assert last["rc_frames"] > 10
    finally:
        for one in (run, firmware):
            if one is not None:
                one.kill()
                one.communicate()


def test_a_core_in_another_process_meets_the_bench(tmp_path):
    line = tmp_path / "core"
    core, run = wheelbench("emulate", "core", f"pty:{line}", "--twist", "0.1,0,0", "--json"), None
    try:
        assert json.loads(core.stdout.readline())["where"] == str(line)
        wires = ("--role", "core", "--slamware", f"serial:{line}", "--json", "--record", tmp_path / "run")
        run = wheelbench("replay", scenario(tmp_path, 100.0), *wires)
        until(lambda: all(logged(tmp_path / "run", "slamware.log", way) > 20 for way in (" > ", " < ")))
        frames = ended(run)[0]["frames"]
        assert frames["core_requests"] > 3
        assert frames["core_answers"] > 3
    finally:
        for one in filter(None, (run, core)):
            one.kill()
            one.communicate()


def test_ports_that_do_not_open_are_told_before_anything_runs(tmp_path):
    running = wheelbench("replay", scenario(tmp_path), "--role", "core", "--slamware", "serial:/dev/no-such-thing")
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out) == (3, "")
    assert "plug it in" in err
    assert len(err.splitlines()) == 1


# --- the link of a screen --------------------------------------------------------------------------------------------


def paced(prepare, inputs=lambda tick: TickInput(), **options):
    return ProcessLink(simulated(M2006), inputs, prepare, **options)


def test_the_link_shows_what_the_child_does():
    link = paced(lambda: Prepared(simulated(M2006), None), operator=True)
    try:
        until(lambda: link.advance() >= 0 and link.latest().tick > 100)
        assert link.wires.can_commands is not None
        assert link.latest().link
        assert len(link.trail) > 0
        assert not link.ended
        with pytest.raises(Exception, match="cannot be taken back"):
            link.see(0)
    finally:
        link.close()
    assert link.ended


def test_the_loop_has_a_share_of_the_processor_of_its_own():
    """Beside a screen and a compiler in one terminal it would wait for both: Linux divides by sessions first."""
    group = Path("/proc/self/autogroup")

    def told():
        return os.getpid(), os.getsid(0), group.read_text() if group.exists() else None

    link = paced(lambda: Prepared(simulated(M2006), None, finish=told), ticks=5)
    try:
        until(lambda: link.poll() or link.ended)
        child, session, its_group = link.result
    finally:
        link.close()
    assert session == child
    assert os.getsid(0) != child
    assert its_group is None or its_group != group.read_text()


def test_an_operator_drives_through_the_process_and_silence_stops_the_robot():
    transmitter = Transmitter(M2006.rc)
    drives = False

    def inputs(tick):
        """The switch is pressed every second until the base is armed; where this process is held up, anew."""
        arming = not drives and tick % 1000 >= 800
        return TickInput(transmitter.step(tick, Sticks(forward=0.5 * drives, aux1=arming)))

    def moves():
        nonlocal drives
        link.advance()
        drives = link.latest().armed
        return drives and link.latest().twist.vx_mps > 0.1

    link = paced(lambda: Prepared(simulated(M2006), None), inputs, operator=True)
    try:
        until(moves)
        link.poll()  # the last for a while: the screen hangs
        hung_tick = link.latest().tick
        until(lambda: link.latest().tick > hung_tick + 1200, link.poll)
        assert not link.latest().armed
        assert link.latest().twist.vx_mps == pytest.approx(0.0, abs=1e-3)
        until(lambda: link.advance() >= 0 and link.latest().link == "live")
        assert not link.latest().armed, "lost means lost until somebody arms"
    finally:
        link.close()


def test_a_screen_drives_real_motors_and_leaves_them_at_rest(tmp_path, adapter):
    """The dashboard's session, its keyboard and its drawing, on the link of a process with a port."""
    job = from_source(scenario(tmp_path))
    keyboard = Keyboard(M2006.rc)

    def prepare():
        bench, rig = take_role(job.bench, "motors", can=f"can:slcan:{adapter.link}", armed=True)
        return Prepared(bench, rig)

    link = ProcessLink(job.bench, keyboard.inputs, prepare, operator=True)
    session = Session(link, keyboard=keyboard)

    drawn = iter(range(1_000_000))
    heeded_tick = 0

    def frame():
        session.frame()
        if next(drawn) % 50 == 0:  # a busy machine cannot draw every one of these
            scene = session.scene()
            for name in places(scene, 120, 40):
                draw(name, scene, 60, 20)
        adapter.step()

    def drive():
        """Arm and push, as a person does: again where the machine stood still and the link was lost meanwhile, or
        real motors are held, as this process was silent.
        """
        nonlocal heeded_tick
        now = link.latest()
        if now.armed and not link.missing:
            session.key("w")
        elif now.tick > heeded_tick:  # a second press before the first is heeded would disarm
            session.key("enter")
            heeded_tick = link.now_tick + 1000
        for _ in range(10):
            frame()

    try:
        until(lambda: link.has_begun and link.latest().link == "live", frame)
        until(lambda: moving(adapter.commands), drive)
        assert not session.failure
        leaving = threading.Thread(target=session.leave)  # it waits for the base to disarm: the motors go on meanwhile
        leaving.start()
        until(lambda: not leaving.is_alive(), adapter.step)
        for _ in range(20):
            adapter.step()
        assert adapter.commands[-1] == (0x200, bytes(8))
        assert link.ended
        assert not session.failure
    finally:
        link.close()


def test_an_exception_in_the_loop_is_a_sentence_and_the_recording_is_closed():
    class Broken(World):
        def hear(self, tick, can_out, slamware_out):
            if tick == 50:
                raise ZeroDivisionError("wheel")
            return super().hear(tick, can_out, slamware_out)

    def prepare():
        bench = simulated(M2006)
        bench.world = Broken(bench.robot, core=None, motors=bench.world.motors)
        return Prepared(bench, None, (), lambda: bench.now_tick)

    link = paced(prepare)
    with pytest.raises(Exception, match="stopped at tick 50: ZeroDivisionError in"):
        until(lambda: link.poll() or link.ended)
    assert link.result == 50
    link.close()


def test_the_last_word_arrives_though_more_was_said_to_the_child_than_it_read():
    """A socket that is closed with unread messages resets its peer, before the peer has read what was sent to it."""
    link = paced(lambda: Prepared(simulated(M2006), None, (), lambda: "done"), ticks=3)
    for _ in range(100):  # it runs for three milliseconds and ends; these go on
        link._wire.tell(Beat())
        wait_ns(1_000_000)
    until(lambda: link.poll() or link.ended)
    assert link.result == "done"
    link.close()


def test_a_child_that_dies_is_told():
    link = paced(lambda: Prepared(simulated(M2006), None, (), lambda: None, lambda: os.kill(os.getpid(), 9)))
    with pytest.raises(SurroundingsError, match="ended without a word"):
        until(lambda: link.poll() or link.ended)
    link.close()


def test_a_refused_port_reaches_the_parent_as_it_was():
    def prepare():
        raise SurroundingsError("--rc serial:/dev/x: there is no device /dev/x; plug it in")

    with pytest.raises(SurroundingsError, match="plug it in"):
        paced(prepare)


@pytest.mark.parametrize("what", ["space", "gone"])
def test_a_person_at_a_terminal_stops_a_run_on_real_ports(tmp_path, what):
    """By space, also where a look finds another key in front of it; by a terminal that has gone."""
    line = tmp_path / "core"
    master, slave = os.openpty()
    peer = open_serial("core", f"pty:{line}")
    running = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "bench",
            "replay",
            scenario(tmp_path, 60.0),
            "--role",
            "core",
            "--slamware",
            f"serial:{line}",
        ],
        cwd=ROOT,
        stdin=slave,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        said = ""
        while "space stops" not in said:
            said = running.stdout.readline()
            assert said
        if what == "space":
            os.write(master, b"w ")
        else:
            os.close(master)
        out, err = running.communicate(timeout=DEADLINE_S)
        assert running.returncode == 130
        assert "stopped   at" in out
        assert "Traceback" not in err
    finally:
        running.kill()
        running.communicate()
        peer.close()
        os.close(slave)
        if what == "space":
            os.close(master)
