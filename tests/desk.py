"""A person at a desk, without the desk: a pacer that grants ticks when told, a session on a bench, a fixed scene."""

import asyncio
import math
from dataclasses import replace

from bench.check.expectations import Standing
from bench.check.recording import RunInfo
from bench.check.run import Run
from bench.config import load_robot
from bench.io.clock import FreePacer
from bench.io.link import InlineLink, Wires
from bench.io.look import Seen
from bench.io.scope import ScopePicture, ScopeSettings, Trace
from bench.io.wires.table import Logged, WireRow, WireSum, WireTable
from bench.loop import simulated
from bench.messages import BodyTwist, Pose, RcFrame, Snapshot
from bench.screen.keyboard import Keyboard
from bench.screen.scene import Hands, Pace, Scene
from bench.screen.session import Session
from bench.screen.view import PANELS
from bench.screen.wire_lamps import WireLamp
from bench.slamware import FrameDecoder
from bench.tui import Dashboard

M2006 = load_robot("m2006")


class Granted(FreePacer):
    """So many ticks as were granted since the last time."""

    granted = 0

    def due(self, done):
        ticks, self.granted = self.granted, 0
        return ticks


def a_job(robot=M2006, keyboard=None):
    keyboard = keyboard or Keyboard(robot.rc)
    info = RunInfo(robot.name, robot.rc.name if robot.rc else None)
    return Run(robot.name, simulated(robot), 0, keyboard.inputs, info), keyboard


def at_the_keys(robot=M2006, takers=(), **options):
    """A session that drives a fresh bench; `pass_ticks` is how its time goes on."""
    job, keyboard = a_job(robot)
    return Session(InlineLink(job.bench, keyboard.inputs, Granted(), takers=takers), keyboard=keyboard, **options)


def pass_ticks(session, ticks):
    session.link.pacer.granted = ticks
    session.frame()


def armed(robot=M2006, **options):
    session = at_the_keys(robot, **options)
    pass_ticks(session, 50)
    session.key("enter")
    pass_ticks(session, 100)
    assert session.link.latest().armed
    return session


SNAPSHOT = Snapshot(
    tick=12_346,
    pose=Pose(1.25, -0.5, 0.7853981633974483),
    twist=BodyTwist(0.4012, -0.0204, 0.55),
    odometry=Pose(1.248, -0.501, 0.7880),
    link="live",
    link_reason="",
    link_age_ms=4,
    armed=True,
    why_disarmed="",
    driver="rc",
    field_centric=False,
    sticks=(0.5, 0.0, -0.25),
    rc_frame=RcFrame(14_808, 12, (2176, 2048, 1024, 2048, 0, 1)),
    rc_frames=1235,
    rc_noise_bytes=7,
    wheel_names=("front right", "rear", "front left"),
    wheel_wanted_radps=(18.5, -2.0, -17.25),
    wheel_radps=(17.4, -2.0, -16.9),
    wheel_current_a=(0.6, -0.12, -0.31),
    current_limit_a=0.6,
    core_alive=True,
    core_connected=True,
    core_twist=BodyTwist(0.2, 0.0, 0.5),
)
WIRES = Wires(
    rc=(12_341, bytes.fromhex("AA 0880 0800 0400 0800 00 01 55")),
    can_commands=(12_345, ((0x200, bytes.fromhex("FDA8 0078 FEC9 0000")),)),
    can_feedback=(
        12_345,
        (
            (0x201, bytes.fromhex("04D2 E9F0 FDA8 0000")),
            (0x202, bytes.fromhex("1FFF 02B0 0078 0000")),
            (0x203, bytes.fromhex("0000 1677 0136 0000")),
        ),
    ),
    # The vendor's own frames: fixtures/known/slamware, dr1-first.
    core_to_base=(12_300, FrameDecoder().feed(bytes.fromhex("100ef841cd4c0000000000000000000026"))[0]),
    base_to_core=(12_300, FrameDecoder().feed(bytes.fromhex("500e0002000000000000000000000000005c"))[0]),
)
_SAID = "1234 cnt   -5648 rpm    -600 mA"
TABLE = WireTable(
    12_345,
    (
        WireSum("rc", "uart12 115200 8E2", 1235, 100.0, 0.125, 7),
        WireSum("can", "1 Mbit/s", 49_384, 4000.0, 0.4807, 0),
        WireSum("core", "115200 8N1", 496, 40.0, 0.0608, 0),
    ),
    (
        WireRow("rc", "channels", "uart12", 1235, 100.0, 0.125, 12_341, WIRES.rc[1], "2176 2048 1024 2048 0 1"),
        WireRow(
            "can",
            "200",
            "motors 1 to 4",
            12_346,
            1000.0,
            0.1215,
            12_345,
            bytes.fromhex("FDA80078FEC90000"),
            "  -600    +120    -311      +0 mA",
        ),
        WireRow("can", "201", "front right", 12_346, 1000.0, 0.12, 12_345, bytes.fromhex("04D2E9F0FDA80000"), _SAID),
        WireRow("core", "< 41", "SET_V_AND_GET_DEADRECKON", 247, 20.0, 0.03, 12_300, bytes(13), "OK dx +0.00 mm"),
        WireRow("core", "> 41", "SET_V_AND_GET_DEADRECKON", 247, 20.0, 0.03, 12_300, bytes(13), "0x41 vx +0.300"),
    ),
    tuple(Logged(12_330 + i, "can", "201", bytes.fromhex("04D2E9F0FDA80000"), _SAID) for i in range(16)),
)
_SWING = tuple(18.0 * math.sin(column / 20) for column in range(160))
PICTURE = ScopePicture(
    ScopeSettings(("wheel1_wanted_radps", "wheel1_radps"), 500, "auto", "rising", 5.0),
    "triggered",
    11_800,
    11_900,
    (
        Trace("wheel1_wanted_radps", _SWING, _SWING, 18.5),
        Trace("wheel1_radps", tuple(value - 1.0 for value in _SWING), tuple(value + 1.0 for value in _SWING), 17.4),
    ),
)
LAMPS = (
    Standing("never faster than 1 m/s", "holds", 0.412, 9_876),
    Standing("a lost link stops it", "untested", math.inf, None),
    Standing("it arrives", "not yet", -0.75, 12_000),
    Standing("arms within a second", "passed", math.inf, None),
    Standing("currents stay below 0.5 A", "failed", -0.1, 4_321),
)
AGREE = (
    WireLamp(
        "motion",
        "failed",
        (
            "the encoder counts on CAN and the truth part in 2 of 9 windows, worst: 8.000 to 9.010 s the encoder counts"
            " on CAN say +12.1, -3.0 mm, +0.52 deg, the truth +101.9, -3.0 mm, +0.55 deg; 3.0 mm and 0.5 deg are"
            " allowed; wheel 2 turns, and its counts stand still",
        ),
    ),
    WireLamp("current at rest", "untested", ("never stood long enough to be judged",)),
    WireLamp("answers", "holds", ("231 requests, 231 answers, the slowest after 1 of 200 ms",), "0% of the limit"),
    WireLamp(
        "ids, rates, bus time",
        "holds",
        ("busiest 100 ms: CAN 53%, requests to the base 3%, answers of the base 4%, RC bytes (uart12) 12%",),
        "53% of the limit",
    ),
)
SCENE = Scene(
    robot=M2006,
    snapshot=SNAPSHOT,
    wires=WIRES,
    seen=Seen(TABLE, PICTURE),
    trail=[(x / 20, -x / 50) for x in range(26)],
    pace=Pace(rate=1.0, speed=1.0, late_ticks=52, slipped_ticks=0),
    hands=Hands(50, True, False),
)

LOST_LINK = {
    "armed": False,
    "why_disarmed": "link lost: no good frame for 500 ms",
    "link": "lost",
    "link_reason": "no good frame for 500 ms",
    "link_age_ms": 1234,
    "driver": "none",
}


def scene(**changes):
    """The fixed scene with some of its snapshot, or of itself, changed."""
    of_snapshot = {name: value for name, value in changes.items() if hasattr(SNAPSHOT, name)}
    of_scene = {name: value for name, value in changes.items() if name not in of_snapshot}
    return replace(SCENE, snapshot=replace(SNAPSHOT, **of_snapshot), **of_scene)


def piloted(session, steps, size=(80, 24)):
    """Run the app on a screen of memory, do the steps, give the app back."""
    app = Dashboard(session)

    async def run():
        async with app.run_test(size=size) as pilot:
            await steps(app, pilot)

    asyncio.run(run())
    return app


def frame(app, ticks=20):
    app.session.link.pacer.granted = ticks
    app.frame()


def on_screen(app, width, height):
    """What the widgets hold, where they stand."""
    rows = [[" "] * width for _ in range(height)]
    for panel in (app.query_one(f"#{name}") for name in PANELS):
        if panel.display:
            region = panel.region
            for y in range(region.height):
                rows[region.y + y][region.x : region.right] = panel.render_line(y).text.ljust(region.width)
    return ["".join(row).rstrip() for row in rows]
