"""The bench: a base and its world, ticked together, 1 ms at a time. Everything else only feeds or watches this.

    bench = simulated("m2006")
    out = bench.tick(TickInput(rc=some_bytes))

A run is a function of its inputs: nothing under this file reads a clock, a file or a random number.
"""

from __future__ import annotations

import math
from pathlib import Path

from bench.arena import FIELD, ORIGIN, Arena
from bench.base import Base, ControlledBase
from bench.canbus.watch import Finding
from bench.config import Robot, load_robot
from bench.link import NO_RC
from bench.messages import FOREIGN_BASE, STATE_PERIOD_TICKS, ZERO_TWIST, Pose, Snapshot, TickInput, TickOutput
from bench.noise import SILENT, Noise
from bench.odometry import wrap
from bench.onlooker import Onlooker
from bench.plant import Plant
from bench.reckoning import DRIVEN_WHEELS
from bench.sensors import ArenaSenses
from bench.slamware.core_side import SlamwareCore
from bench.slamware.schedule import SCHEDULES
from bench.world import RecordedMotors, SimulatedMotors, World

NOTHING = TickInput()
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_output = tuple.__new__


class Bench:
    """One base under test, one world around it, one tick counter."""

    def __init__(self, base: ControlledBase, world: World) -> None:
        self.base = base
        self.world = world
        self.robot = world.robot
        self.now_tick = 0
        more = _more_columns(world.robot)
        self.state_columns = (*_state_columns(world.robot), *more)
        self._has_more = bool(more)
        start = world.plant.pose
        self._start = start if start != ORIGIN else None
        self.onlooker = None if isinstance(base, Base) else Onlooker(world.robot)
        if isinstance(base, Base):  # a foreign base has sensors of its own
            base.slave.senses = ArenaSenses(world.robot, world.plant, world.plant.arena)

    def tick(self, given: TickInput = NOTHING) -> TickOutput:
        """Run one millisecond. Feedback born in it reaches the base in the next one, like on the real bus."""
        tick = self.now_tick
        rc, core_to_base, can_in = self.world.speak(tick, given)
        can_commands, base_to_core = self.base.step(tick, rc, core_to_base, can_in)
        can_feedback = self.world.hear(tick, can_commands, base_to_core)
        if self.onlooker is not None:
            self.onlooker.step(tick, rc)
        state = self._state_row(tick) if tick % STATE_PERIOD_TICKS == 0 else None
        self.now_tick = tick + 1
        return _new_output(TickOutput, (tick, rc, core_to_base, base_to_core, can_commands, can_feedback, state))

    @property
    def bus_findings(self) -> tuple[str, ...]:
        """What the two ends of the CAN bus cannot explain, each thing once, as sentences in the order of its tick."""
        found: dict[tuple[str, int], Finding] = {}
        ends = [self.world.motors.escs.watch]
        if isinstance(self.base, Base):  # a foreign base keeps what it sees to itself
            ends.insert(0, self.base.motors.watch)
        for watch in ends:
            for finding in watch.findings:
                found.setdefault((finding.kind, finding.can_id), finding)
        return tuple(finding.text for finding in sorted(found.values(), key=lambda finding: finding.first_tick))

    def snapshot(self) -> Snapshot:
        """What a screen shows of the bench at this instant; of a foreign base, what its wires and the plant tell."""
        return _snapshot(self)

    def believed_pose(self, base: Base) -> Pose:
        """Where the base believes the robot is, in the field: its odometry counts from where the robot began."""
        x_m, y_m, heading_rad = base.odometry.pose
        if self._start is None:
            return Pose(x_m, y_m, heading_rad)
        cos, sin = math.cos(self._start.heading_rad), math.sin(self._start.heading_rad)
        return Pose(
            self._start.x_m + cos * x_m - sin * y_m,
            self._start.y_m + sin * x_m + cos * y_m,
            wrap(self._start.heading_rad + heading_rad),
        )

    def _state_row(self, tick: int) -> tuple[float | int | str, ...]:
        plant = self.world.plant
        row: list[float | int | str] = [tick / 1000.0, *plant.pose, *plant.twist]
        base = self.base
        if isinstance(base, Base):
            link = base.link
            row += base.odometry.pose if self._start is None else self.believed_pose(base)
            row += (link.state if link else NO_RC, int(base.drive.armed), base.drive.driver)
            wanted = base.wanted_radps
        else:
            row += (0.0, 0.0, 0.0, FOREIGN_BASE, 0, FOREIGN_BASE)
            wanted = [0.0] * len(plant.wheel_speeds_radps)
        for speeds in zip(wanted, plant.wheel_speeds_radps, plant.currents_a, strict=True):
            row += speeds
        return (*row, *_more(self)) if self._has_more else tuple(row)


def simulated(robot: Robot | str | Path = "m2006", arena: Arena = FIELD, noise: Noise = SILENT) -> Bench:
    """The role `sim`: our base, our ESCs and plant, our SLAMWARE core. Raises ConfigError for an impossible robot,
    ValueError for one that cannot begin where the arena puts it.
    """
    if not isinstance(robot, Robot):
        robot = load_robot(robot)
    core = SlamwareCore(poll_ms=robot.slamware.poll_ms, schedule=SCHEDULES[robot.slamware.polls])
    return Bench(Base(robot), World(robot, core=core, motors=simulated_motors(robot, arena, noise)))


def replayed(robot: Robot, motors: SimulatedMotors | RecordedMotors | None = None) -> Bench:
    """Like `simulated`, but the core's bytes come from `TickInput.slamware`: they are a recording's."""
    return Bench(Base(robot), World(robot, core=None, motors=motors or SimulatedMotors(robot)))


def simulated_motors(robot: Robot, arena: Arena = FIELD, noise: Noise = SILENT) -> SimulatedMotors:
    """Motors and plant in an arena, at its start."""
    return SimulatedMotors(robot, Plant(robot, arena, arena.start), noise)


def _snapshot(bench: Bench) -> Snapshot:
    base, plant = bench.base, bench.world.plant
    if not isinstance(base, Base):
        return _foreign_snapshot(bench)
    link, drive, last_tick = base.link, base.drive, bench.now_tick - 1
    return Snapshot(
        tick=bench.now_tick,
        pose=plant.pose,
        twist=plant.twist,
        odometry=bench.believed_pose(base),
        link=link.state if link else NO_RC,
        link_reason=link.reason if link else "this robot takes the core alone",
        link_age_ms=link.age_ticks(last_tick) if link else None,
        armed=drive.armed,
        why_disarmed=drive.why_disarmed,
        driver=drive.driver,
        field_centric=drive.field_centric,
        sticks=drive.sticks,
        rc_frame=link.frame if link else None,
        rc_frames=link.frames if link else 0,
        rc_noise_bytes=link.noise_bytes if link else 0,
        wheel_names=tuple(wheel.name for wheel in bench.robot.wheels),
        wheel_wanted_radps=tuple(base.wanted_radps),
        wheel_radps=tuple(plant.wheel_speeds_radps),
        wheel_current_a=tuple(plant.currents_a),
        current_limit_a=bench.robot.limits.current_a,
        core_alive=base.slave.alive(last_tick),
        core_connected=base.slave.connected,
        core_twist=base.slave.wanted_twist,
        bus_findings=bench.bus_findings,
        slip_radps=base.slip_radps if bench.robot.sees_slip else None,
        slip_limit_radps=bench.robot.limits.slip_radps,
        odometry_source=base.reckoning.source if base.reckoning else DRIVEN_WHEELS,
        heading_source=base.reckoning.heading_source if base.reckoning else DRIVEN_WHEELS,
    )


def _foreign_snapshot(bench: Bench) -> Snapshot:
    """Nobody can look into a foreign base: where it believes to be, and what it means to do, are not known. `driver`
    says so. The RC link is shown as our own receiver has it, the core as it sees itself.
    """
    plant, wheels, core = bench.world.plant, bench.robot.wheels, bench.world.core
    onlooker, last_tick = bench.onlooker or Onlooker(bench.robot), bench.now_tick - 1
    link = onlooker.link
    return Snapshot(
        tick=bench.now_tick,
        pose=plant.pose,
        twist=plant.twist,
        odometry=plant.pose,
        link=link.state if link else NO_RC,
        link_reason=link.reason if link else "this robot takes the core alone",
        link_age_ms=link.age_ticks(last_tick) if link else None,
        armed=None,
        why_disarmed="only the base itself knows",
        driver=FOREIGN_BASE,
        field_centric=False,
        sticks=onlooker.sticks,
        rc_frame=link.frame if link else None,
        rc_frames=link.frames if link else 0,
        rc_noise_bytes=link.noise_bytes if link else 0,
        wheel_names=tuple(wheel.name for wheel in wheels),
        wheel_wanted_radps=(0.0,) * len(wheels),
        wheel_radps=tuple(plant.wheel_speeds_radps),
        wheel_current_a=tuple(plant.currents_a),
        current_limit_a=bench.robot.limits.current_a,
        core_alive=core is not None,
        core_connected=core is not None and core.connected,
        core_twist=ZERO_TWIST,
        bus_findings=bench.bus_findings,
    )


def _state_columns(robot: Robot) -> tuple[str, ...]:
    """The header of state.csv: truth (x_m .. omega_radps) beside the base's own estimate (odo_*)."""
    columns = ["t_s", "x_m", "y_m", "heading_rad", "vx_mps", "vy_mps", "omega_radps"]
    columns += ["odo_x_m", "odo_y_m", "odo_heading_rad", "link", "armed", "driver"]
    for number in range(1, len(robot.wheels) + 1):
        columns += [f"wheel{number}_wanted_radps", f"wheel{number}_radps", f"wheel{number}_current_a"]
    return tuple(columns)


def _more_columns(robot: Robot) -> tuple[str, ...]:
    """What only some robots have: slip where it can be seen, dead wheels (truth, then decoded), a gyro."""
    columns = ["slip_radps", "slipping"] if robot.sees_slip else []
    for number in range(1, len(robot.dead_wheels) + 1):
        columns += [f"dead{number}_rad", f"dead{number}_encoder_rad"]
    return (*columns, "gyro_heading_rad") if robot.gyro is not None else tuple(columns)


def _more(bench: Bench) -> list[float | int]:
    """The values of `_more_columns`; what only our own base could know is 0 for a foreign one."""
    robot, instruments = bench.robot, bench.world.motors.instruments
    base = bench.base if isinstance(bench.base, Base) else None
    row: list[float | int] = []
    if robot.sees_slip:
        slip_radps = base.slip_radps if base else 0.0
        row += (slip_radps, int(slip_radps > robot.limits.slip_radps))
    reckoning = base.reckoning if base else None
    if instruments is not None and robot.dead_wheels:
        decoded_rad = reckoning.dead_turned_rad if reckoning else [0.0] * len(robot.dead_wheels)
        for angles_rad in zip(instruments.dead_wheel_angles_rad, decoded_rad, strict=True):
            row += angles_rad
    if robot.gyro is not None:
        row.append(wrap(reckoning.gyro.turned_rad) if reckoning and reckoning.gyro else 0.0)
    return row
