"""The failsafe matrix: every loss in every phase of a drive, and whether the robot did what its rules say.

A cell is a run of a few seconds: arm, drive, lose something, go on long enough to see whether the loss lets go of the
robot again. What is judged is what crosses the wires and what the robot does, so any base behind the seam can be put
to it. The rules are those of docs/links.md, with the limits of the robot's own file:

    silence, lost-frame flag      the command stands until hold_ms after the last good frame; no current after disarm_ms
    failsafe flag, zeros, frozen  stop at once; no current after disarm_ms
    the core is silent            stop after core_timeout_ms
    an ESC is silent              no current after feedback_timeout_ms
    restart                       no current from the first tick
    one byte lost                 drive on
    an encoder is stuck           stay within the current limit, and stop when the sticks are let go
    after a lost RC link          nothing moves until somebody arms again, whatever sticks and link do

A robot that has to stop may take as long as one that coasts: what its friction needs with no current at all, and a
tenth of a second for the loop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

from bench.arena import MOST_M, Arena
from bench.base import Base
from bench.check.controllers import Build, at_full_speed, controller_of, hears_no_core
from bench.check.faults import Fault
from bench.check.faulty import FaultyWorld, Injector
from bench.check.signals import Signals
from bench.config import Robot
from bench.errors import ControllerFailed
from bench.kinematics import Kinematics
from bench.loop import Bench, simulated
from bench.messages import BodyTwist, TickInput, TickOutput
from bench.plant import Plant
from bench.rc.transmitter import AT_REST, Sticks, Transmitter

STICK = 0.4
"""Far enough for a clear speed, and below what a weak robot can hold in every direction."""
TREMBLE = 0.01
"""A hand does not hold a stick to the count; what does is a frozen link."""

PHASES: Mapping[str, Sticks] = {
    "rest": AT_REST,
    "cruise": Sticks(forward=STICK),
    "strafe": Sticks(left=STICK),
    "spin": Sticks(turn=STICK),
    "reversal": Sticks(forward=STICK),
}
"""What the sticks say before the loss. In a reversal they go to the other side in the instant of it."""
MOVING = [phase for phase, sticks in PHASES.items() if any(sticks)]

ARM_TICK, DRIVE_TICK, LOSS_TICK = 100, 250, 1200
CORE_LOSS_TICK, CORE_DRIVES_TICKS = 1750, 950
"""The core takes over when the sticks have been at rest for a while, and drives for so long."""
LOST_TICKS, AFTER_TICKS = 1000, 250
CORE_LOST_TICKS = 1900
MOST_TICKS = 60_000
"""Of a run: whoever has more patience in a robot's file is not waited for."""
OPEN_FLOOR = Arena(length_m=MOST_M, width_m=MOST_M, name="open floor")
"""A wall would stop a robot that nothing else stops."""
STANDS_BELOW_MPS, STANDS_BELOW_RADPS = 0.02, 0.15
REACTION_TICKS = 100
HELD_FAST = 10.0
"""Times the loop's own gain: what its integral part comes to in time."""
LEAST_SHARE = 0.3
"""Of the speed asked for: enough to see the direction. Whether a robot reaches its speed is not asked here."""
NO_CURRENT_A = 0.002
DRIVES_ON_SHARE = 0.75

GREEN, RED, OFF = "ok", "RED", "off"


@dataclass(frozen=True, slots=True)
class Loss:
    """One way to lose something, and what has to follow. Times in ticks from the loss; None: it does not have to."""

    name: str
    rule: str
    faults: tuple[Fault, ...] = ()
    stop_after: int | None = None
    """From then on it brakes or coasts."""
    quiet_after: int | None = None
    """From then on there is no current."""
    drives_on: bool = False
    rearm: bool = False
    """Stays stopped when what was lost is back."""
    restarts: bool = False
    by_core: bool = False
    let_go_after: int | None = None
    """The sticks go to rest then."""
    off_because: str = ""
    at: int = LOSS_TICK
    lasting: int = LOST_TICKS
    """How long it is lost."""


@dataclass(frozen=True, slots=True)
class Cell:
    """What one run has shown."""

    loss: str
    phase: str
    verdict: str
    why: tuple[str, ...]
    """Every rule that was broken, as a sentence; or why this cell is off."""
    stop_ms: int | None
    """From the loss until the robot stands for good, at most until what was lost is back; None: it does not stand."""
    stop_m: float
    """Driven until then."""
    residual_a: float
    """The largest commanded current once there should be none; where a rule says nothing of it, at the end."""
    failed: bool = False
    """The controller raised an error: nothing was measured."""

    def as_dict(self) -> dict[str, object]:
        """Plain values for --json."""
        return asdict(self)


def losses(robot: Robot) -> tuple[Loss, ...]:
    """Every loss, with the limits of this robot and its transmitter. Raises ValueError for a robot without RC."""
    profile, link = robot.rc, robot.link
    if profile is None:
        raise ValueError(f"{robot.name} takes no RC; the failsafe matrix needs a transmitter's profile")
    frame = 2 * profile.period_ms + 5
    hold, quiet = link.hold_ms + frame, link.disarm_ms + frame
    flags = {
        kind: "" if profile.protocol in protocols else f"{profile.protocol} frames cannot say it"
        for kind, protocols in (("flag", ("sbus", "ibus")), ("lost_flag", ("sbus",)))
    }
    frozen = "" if profile.frozen_ms else f"frozen_ms is 0 in the profile {profile.name}"
    by_hold = f"stop from {link.hold_ms} ms on, no current from {link.disarm_ms} ms on, stay"
    at_once = f"stop at once, no current from {link.disarm_ms} ms on, stay"

    stand = REACTION_TICKS + max(coast_ticks(robot, _asked_by(sticks, robot)) for sticks in PHASES.values())
    core_at = max(CORE_LOSS_TICK, DRIVE_TICK + link.handover_ms + 50 + CORE_DRIVES_TICKS)

    def rc(kind: str, **facts: float) -> tuple[Fault, ...]:
        return (Fault(kind, "rc", kind, at=LOSS_TICK, lasting=LOST_TICKS, **facts),)  # type: ignore[arg-type]

    def esc(wire: str, kind: str, number: int | None) -> tuple[Fault, ...]:
        return (Fault(kind, wire, kind, at=LOSS_TICK, lasting=LOST_TICKS, esc=number),)

    # The last byte of the first frame after the loss.
    keep = len(Transmitter(profile).step(0, AT_REST)) - 1
    byte = Fault("byte", "rc", "truncate", at=LOSS_TICK, lasting=profile.period_ms, keep=keep)
    silent = f"no current from {link.feedback_timeout_ms} ms on"
    timeout = link.feedback_timeout_ms + 5
    core = (Fault("core", "core", "drop", at=core_at, lasting=CORE_LOST_TICKS),)
    # It stays stuck: how long the robot may roll on is known when the sticks are let go.
    stuck = (Fault("stuck", "feedback", "stuck", at=LOSS_TICK, esc=_always_turning(robot)),)
    rows = (
        Loss("RC silent", by_hold, rc("drop"), hold, quiet, rearm=True),
        Loss("failsafe flag", at_once, rc("flag"), frame, quiet, rearm=True, off_because=flags["flag"]),
        Loss("lost-frame flag", by_hold, rc("lost_flag"), hold, quiet, rearm=True, off_because=flags["lost_flag"]),
        Loss(
            "sticks frozen", f"stop after {profile.frozen_ms} ms of it", rc("freeze"), profile.frozen_ms + frame,
            off_because=frozen,
        ),
        Loss("all channels zero", at_once, rc("zeros"), frame, quiet, rearm=True),
        Loss("garbage", by_hold, rc("garbage"), hold, quiet, rearm=True),
        Loss("one byte lost", "drive on", (byte,), drives_on=True),
        Loss(
            "core silent", f"stop from {link.core_timeout_ms} ms on", core, link.core_timeout_ms + 60, by_core=True,
            at=core_at, lasting=CORE_LOST_TICKS,
        ),
        Loss("one ESC silent", silent, esc("esc", "silent", 1), timeout, timeout),
        Loss("every ESC silent", silent, esc("esc", "silent", None), timeout, timeout),
        Loss("encoder stuck", "keep the current limit; stop when let go", stuck, 300, let_go_after=300),
        Loss("restart", "no current until armed, stay", (), 0, 2, rearm=True, restarts=True),
    )  # fmt: skip

    def for_long_enough(row: Loss) -> Loss:
        stop, silent = max(hold, row.stop_after or 0) + stand, (row.quiet_after or 0) + REACTION_TICKS
        lasting = max(row.lasting, stop, silent)
        if row.at + lasting > MOST_TICKS:
            return replace(row, off_because=row.off_because or f"more than {MOST_TICKS // 1000} s have to pass first")
        faults = tuple(replace(one, lasting=lasting) if one.lasting else one for one in row.faults)
        return replace(row, lasting=lasting, faults=faults)

    return tuple(row if row.drives_on else for_long_enough(row) for row in rows)


def _asked_by(sticks: Sticks, robot: Robot) -> BodyTwist:
    limits = robot.limits
    return BodyTwist(
        sticks.forward * limits.linear_mps, sticks.left * limits.linear_mps, sticks.turn * limits.angular_radps
    )


def _speeds(robot: Robot, phase: str) -> list[float]:
    """How fast each wheel turns, whichever way, in rad/s; what is nothing but rounding is none."""
    speeds = Kinematics(robot.wheels).wheel_speeds(_asked_by(PHASES[phase], robot))
    return [round(abs(speed), 9) for speed in speeds]


def _always_turning(robot: Robot) -> int:
    """The wheel, from 1, that turns in every phase but rest: one that stands is none the worse for a stuck encoder."""
    slowest = [min(of_wheel) for of_wheel in zip(*(_speeds(robot, phase) for phase in MOVING), strict=True)]
    return 1 + slowest.index(max(slowest))


def _where_it_turns(robot: Robot, loss: Loss, phase: str) -> Loss:
    """Of four wheels in a cross none turns in every phase: then it is the encoder of another wheel that gets stuck."""
    speeds = _speeds(robot, phase)
    faults = tuple(
        replace(fault, esc=1 + speeds.index(max(speeds)))
        if fault.kind == "stuck" and fault.esc is not None and not speeds[fault.esc - 1]
        else fault
        for fault in loss.faults
    )
    return replace(loss, faults=faults)


def run_cell(robot: Robot, loss: Loss, phase: str, build: Build = Base) -> Cell:
    """One run, judged. Raises ControllerFailed where the base under test does."""
    if loss.off_because:
        return Cell(loss.name, phase, OFF, (loss.off_because,), None, 0.0, 0.0)
    drive = _Drive(robot, _where_it_turns(robot, loss, phase), phase, build)
    with at_full_speed(drive.base):
        return drive.judge()


class _Drive:
    """The run of one cell, and what is measured on the way."""

    def __init__(self, robot: Robot, loss: Loss, phase: str, build: Build) -> None:
        assert robot.rc is not None
        self._robot, self._loss, self._phase, self._build = robot, loss, phase, build
        self._bench = _bench(robot, build)
        self.base = self._bench.base
        self._at = loss.at
        columns = self._bench.state_columns
        self._injector = Injector(loss.faults, robot, columns) if loss.faults else None
        if self._injector is not None:
            self._bench.world = FaultyWorld(self._bench.world, self._injector)
        self._transmitter = Transmitter(robot.rc)
        self._commands = [f"command{number}_a" for number in range(1, len(robot.wheels) + 1)]
        self._signals = Signals(robot, columns, self._commands)
        self._moved_tick = 0
        self._path_m = 0.0
        self._stop_m = 0.0
        self._residual_a = self._most_a = 0.0
        self._why: list[str] = []

    def judge(self) -> Cell:
        """Run it and say what happened."""
        loss, at = self._loss, self._at
        for tick in range(at):
            self._tick(tick)
        self._check_direction()
        before = reacted = self._bench.world.plant.twist
        if loss.restarts:
            self._bench.base = self._build(self._robot)
        end = at + loss.lasting
        self._moved_tick, self._path_m, self._stop_m = at, 0.0, 0.0
        for tick in range(at, end):
            self._tick(tick)
            self._follow(tick)
            if tick - at == loss.let_go_after:
                before = self._bench.world.plant.twist
            if loss.let_go_after is not None and tick - at == loss.let_go_after + REACTION_TICKS:
                reacted = self._bench.world.plant.twist
        after = self._bench.world.plant.twist
        rolls_on = 0 if loss.stop_after is None else max(map(self._rolls_on, {before, reacted}))
        allowed = 0 if loss.stop_after is None else loss.stop_after + REACTION_TICKS + rolls_on
        if loss.let_go_after is not None:  # how fast a robot runs that cannot feel a wheel, nobody knew before
            for tick in range(end, at + allowed + 1):
                self._tick(tick)
                self._follow(tick)
            end = max(end, at + allowed + 1)
        stop_ms = self._moved_tick - at if self._moved_tick < end - 1 else None
        stop_m = self._stop_m
        self._check_stop(before, after, stop_ms, allowed)
        for tick in range(end, end + AFTER_TICKS):
            self._tick(tick)
            if loss.rearm:
                self._follow(tick)
        if loss.rearm and self._moved_tick >= end:
            self._why.append("drives again without having been armed")
        # An encoder that stands still in a robot at rest is none the worse for being stuck.
        if self._injector is not None and self._injector.untouched() and self._phase != "rest":
            self._why.append("the loss touched nothing")
        limit_a = self._robot.limits.current_a
        if self._most_a > limit_a + NO_CURRENT_A:
            self._why.append(f"commands {self._most_a:.2f} A, over the limit of {limit_a:g} A")
        if loss.quiet_after is not None and self._residual_a > NO_CURRENT_A:
            self._why.append(f"still commands {self._residual_a:.3f} A {loss.quiet_after} ms after the loss")
        verdict = RED if self._why else GREEN
        return Cell(loss.name, self._phase, verdict, tuple(self._why), stop_ms, stop_m, self._residual_a)

    def _tick(self, tick: int) -> TickOutput:
        sticks, twist = self._driver(tick)
        out = self._bench.tick(TickInput(self._transmitter.step(tick, sticks), twist))
        if self._injector is not None:
            self._injector.observe(out)
        sample = self._signals.take(out)
        amperes = max(abs(sample[name] or 0.0) for name in self._commands)
        self._most_a = max(self._most_a, amperes)
        quiet = self._loss.quiet_after
        since = tick - self._at
        if quiet is not None and quiet <= since < self._loss.lasting:
            self._residual_a = max(self._residual_a, amperes)
        return out

    def _driver(self, tick: int) -> tuple[Sticks, BodyTwist | None]:
        """Sticks and core request of this tick."""
        loss, wanted = self._loss, PHASES[self._phase]
        if self._phase == "reversal" and tick >= self._at:
            wanted = Sticks(-wanted.forward)
        if tick < DRIVE_TICK:
            return AT_REST._replace(aux1=ARM_TICK <= tick < DRIVE_TICK), None
        if loss.by_core:
            return AT_REST, _asked_by(wanted, self._robot) if tick >= self._at - CORE_DRIVES_TICKS else None
        if loss.let_go_after is not None and tick >= self._at + loss.let_go_after:
            return AT_REST, None
        tremble = TREMBLE if tick // self._transmitter.profile.period_ms % 2 else -TREMBLE
        forward, left, turn = (value + tremble if value else 0.0 for value in wanted[:3])
        return Sticks(forward, left, turn), None

    def _follow(self, tick: int) -> None:
        """How far the robot goes, and when it moved last."""
        vx, vy, omega = self._bench.world.plant.twist
        speed = math.hypot(vx, vy)
        self._path_m += speed * 0.001
        if speed > STANDS_BELOW_MPS or abs(omega) > STANDS_BELOW_RADPS:
            self._moved_tick = tick + 1
            self._stop_m = self._path_m

    def _check_direction(self) -> None:
        """Before the loss the robot moves the way the sticks say."""
        limits = self._robot.limits
        wanted = _asked_by(PHASES[self._phase], self._robot)
        units = (1.0, 1.0, limits.linear_mps / limits.angular_radps)
        moves = [value * unit for value, unit in zip(self._bench.world.plant.twist, units, strict=True)]
        asked = [value * unit for value, unit in zip(wanted, units, strict=True)]
        size = math.hypot(*asked)
        if not size:
            if math.hypot(*moves) > STANDS_BELOW_MPS:
                self._why.append("moves although the sticks are at rest")
            return
        along = sum(one * other for one, other in zip(moves, asked, strict=True)) / size
        aside = math.sqrt(max(0.0, math.hypot(*moves) ** 2 - along**2))
        if along < LEAST_SHARE * size or aside > 0.5 * abs(along):
            twist = ", ".join(f"{value:.2f}" for value in self._bench.world.plant.twist)
            self._why.append(f"does not move as the sticks say before the loss: {twist} (m/s, m/s, rad/s)")

    def _rolls_on(self, twist: BodyTwist) -> int:
        """For how many ticks it may roll on after the reaction."""
        coasting = coast_ticks(self._robot, twist)
        unfelt = [fault.esc for fault in self._loss.faults if fault.kind == "stuck"]
        return max(coasting, coast_ticks(self._robot, twist, unfelt[0])) if unfelt else coasting

    def _check_stop(self, before: BodyTwist, after: BodyTwist, stop_ms: int | None, allowed: int) -> None:
        loss = self._loss
        if loss.drives_on and self._phase not in ("rest", "reversal"):
            shares = [b and a / b for a, b in zip(after, before, strict=True)]
            if max(shares) < DRIVES_ON_SHARE:
                self._why.append("stops although it should drive on")
        elif loss.drives_on and self._phase == "reversal" and not after.vx_mps < -STANDS_BELOW_MPS:
            self._why.append("does not follow the sticks any more")
        if loss.stop_after is None:
            return
        if stop_ms is None or stop_ms > allowed:
            took = "does not stand" if stop_ms is None else f"stands after {stop_ms} ms"
            self._why.append(f"{took}; {allowed} ms are allowed")


def coast_ticks(robot: Robot, twist: BodyTwist, unfelt: int | None = None) -> int:
    """How long this robot rolls on from a twist with no current at all; asked of the plant.

    With a wheel (from 1) that it cannot feel: that one rolls, the others are held, and one wheel's friction is all it
    has.
    """
    plant = Plant(robot, arena=None, twist=twist)
    most_a, gain = robot.limits.current_a, HELD_FAST * robot.control.kp_a_per_radps
    currents = [0.0] * len(robot.wheels)
    for tick in range(LOST_TICKS * 10):
        vx, vy, omega = plant.twist
        if math.hypot(vx, vy) <= STANDS_BELOW_MPS and abs(omega) <= STANDS_BELOW_RADPS:
            return tick
        if unfelt is not None:
            currents = [max(-most_a, min(most_a, -gain * speed)) for speed in plant.wheel_speeds_radps]
            currents[unfelt - 1] = 0.0
        plant.step(currents)
    return LOST_TICKS * 10


def _bench(robot: Robot, build: Build) -> Bench:
    bench = simulated(robot, OPEN_FLOOR)
    return bench if build is Base else Bench(build(robot), bench.world)


def run_row(robot: Robot, number: int, controller: str | None = None, raises: bool = False) -> list[Cell]:
    """Every phase of one loss, by its place in `losses`; `controller` as `controller_of` takes it. One that fails on
    the way is red in that cell and comes up anew in the next; with `raises` it ends the matrix.
    """
    chosen = controller_of(robot, controller)
    loss = losses(chosen.robot)[number]
    if loss.by_core and hears_no_core(chosen.build):
        loss = replace(loss, off_because="the firmware has no core: slamware is not among its [wires]")
    cells = []
    for phase in PHASES:
        try:
            cells.append(run_cell(chosen.robot, loss, phase, chosen.build))
        except ControllerFailed as error:
            if raises:
                raise
            cells.append(_failed(loss, phase, str(error)))
    return cells


def failed_row(loss: Loss, why: str) -> list[Cell]:
    """Every phase of a loss, where the process in which the controller ran has died."""
    return [_failed(loss, phase, why) for phase in PHASES]


def _failed(loss: Loss, phase: str, why: str) -> Cell:
    return Cell(loss.name, phase, RED, (why,), None, 0.0, 0.0, failed=True)
