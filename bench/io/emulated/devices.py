"""Emulated motors, SLAMWARE base, SLAMWARE core and RC receiver, each at the end of a real wire. `step` once a ms.

device = EscsOnBus(load_robot("m2006"), open_can("can", "can:socketcan:can0"))
serve([device])
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bench.base import RC_PAUSE_US, Base
from bench.config import Robot
from bench.io.can_port import LAST_WORD_S, CanPort
from bench.io.limiter import Limiter
from bench.io.paced_writer import PacedWriter
from bench.io.serial_port import SerialPort
from bench.loop import Bench, replayed
from bench.messages import TICK_US, BodyTwist, RcFrame, TickInput
from bench.rc.line import Settings
from bench.rc.transmitter import AT_REST, Sticks, Transmitter
from bench.rc_decode import decoder
from bench.slamware import SlamwareCore
from bench.slamware.schedule import VELOCITY_ONLY, Schedule
from bench.world import SimulatedMotors

ARM_FROM_TICK, ARM_UNTIL_TICK = 300, 400
"""When the base's own transmitter presses AUX1: after a few frames of any protocol, so that the link is live."""


class EscsOnBus:
    """All ESCs of a robot on one bus, with motors and plant: commands in, feedback out every millisecond."""

    def __init__(self, robot: Robot, bus: CanPort) -> None:
        self.robot, self.bus = robot, bus
        self.motors = SimulatedMotors(robot)
        self.commands = self.feedback = 0
        """Frames."""

    def step(self, tick: int) -> None:
        """One millisecond of motors and plant."""
        bus = self.bus
        frames = bus.read()
        if bus.lost:
            bus.revive()
        feedback = self.motors.step(tick, frames)
        bus.write(feedback)
        self.commands += len(frames)
        self.feedback += len(feedback)

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        plant = self.motors.plant
        facts: dict[str, object] = {"commands": self.commands, "feedback": self.feedback, **_pose(plant.pose)}
        facts["wheel_radps"] = [round(speed, 3) for speed in plant.wheel_speeds_radps]
        findings = [finding.text for finding in self.motors.escs.watch.findings]
        return facts | ({"findings": findings} if findings else {})

    def close(self) -> None:
        """Give the bus back."""
        self.bus.close()


class BaseOnLine:
    """A whole simulated robot base that a SLAMWARE core drives. A robot with RC is armed by a transmitter of its own,
    sticks at rest, so that the core has it after half a second.
    """

    def __init__(self, robot: Robot, line: SerialPort) -> None:
        self.line = line
        self.bench: Bench = replayed(robot)
        self._transmitter = Transmitter(robot.rc) if robot.rc else None
        self.bytes_in = self.bytes_out = 0

    def step(self, tick: int) -> None:
        """One millisecond of base and world."""
        line, transmitter = self.line, self._transmitter
        request = line.read()
        if line.lost:
            line.revive()
        rc = b""
        if transmitter is not None:
            rc = transmitter.step(tick, Sticks(aux1=True) if ARM_FROM_TICK <= tick < ARM_UNTIL_TICK else AT_REST)
        answer = self.bench.tick(TickInput(rc, None, request)).base_to_core
        if answer:
            line.write(answer)
        self.bytes_in += len(request)
        self.bytes_out += len(answer)

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        base: Any = self.bench.base
        twist = base.slave.wanted_twist
        return {
            "connected": base.slave.connected,
            "driver": base.drive.driver,
            "requests": sum(base.slave.requests.values()),
            "errors": sum(base.slave.errors.values()),
            "wanted": [round(value, 3) for value in twist],
            **_pose(self.bench.world.plant.pose),
        }

    def close(self) -> None:
        """Give the line back."""
        self.line.close()


class FirmwareOnPorts:
    """Our own base controller as a firmware on a bench: RC and SLAMWARE lines in, a CAN bus of motors out. For whoever
    wants to see the role `base` work before their own firmware does. Real motors may hang on that bus: currents are
    limited on their way out, and the last word is that there is none.
    """

    def __init__(self, robot: Robot, bus: CanPort, rc: SerialPort | None, slamware: SerialPort | None) -> None:
        self.base = Base(robot)
        self.bus, self.rc, self.slamware = bus, rc, slamware
        self._limiter = Limiter(robot)
        self.commands = self.feedback = 0
        """Frames."""

    def step(self, tick: int) -> None:
        """One millisecond of the controller."""
        rc, slamware, bus = self.rc, self.slamware, self.bus
        feedback = bus.read()
        commands, answer = self.base.step(
            tick, rc.read() if rc is not None else b"", slamware.read() if slamware is not None else b"", feedback
        )
        bus.write(self._limiter(commands))
        if slamware is not None and answer:
            slamware.write(answer)
        for port in (bus, rc, slamware):
            if port is not None and port.lost:
                port.revive()
        self.commands += len(commands)
        self.feedback += len(feedback)

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        base = self.base
        facts: dict[str, object] = {"commands": self.commands, "feedback": self.feedback}
        if base.link is not None:
            facts |= {"rc_frames": base.link.frames, "link": base.link.state}
        return facts | {"armed": base.drive.armed, "driver": base.drive.driver, **_pose(base.odometry.pose)}

    def close(self) -> None:
        """No current, and the ports back."""
        self.bus.write(self._limiter.stop, LAST_WORD_S)
        for port in (self.bus, self.rc, self.slamware):
            if port is not None:
                port.close()


class CoreOnLine:
    """A SLAMWARE core that asks a base for velocities: `twists` from their ticks on."""

    def __init__(
        self,
        line: SerialPort,
        twists: Mapping[int, BodyTwist],
        poll_ms: int = 50,
        schedule: Schedule = VELOCITY_ONLY,
    ) -> None:
        self.line = line
        self.core = SlamwareCore(poll_ms=poll_ms, schedule=schedule)
        self._twists = twists

    def step(self, tick: int) -> None:
        """Read the base's answers, ask when it is time."""
        line, core = self.line, self.core
        answer = line.read()
        if line.lost:
            line.revive()
        twist = self._twists.get(tick)
        if twist is not None:
            core.ask(twist)
        request = core.step(tick, answer)
        if request:
            line.write(request)

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        core = self.core
        facts: dict[str, object] = {"connected": core.connected}
        if core.identity is not None:
            facts["base"] = core.identity.model
        facts |= {
            "requests": sum(core.requests.values()),
            "answers": sum(core.answers.values()),
            "timeouts": core.timeouts,
            "errors": sum(core.errors.values()),
        }
        return facts | _pose(core.pose)

    def close(self) -> None:
        """Give the line back."""
        self.line.close()


class ReceiverOnLine:
    """An RC receiver: `frames` holds the bytes of each tick that has any. They leave no faster than the line allows.

    `repeat_ticks` begins the stream again after so long; without it the receiver falls silent at its end.
    """

    def __init__(
        self,
        line: SerialPort,
        protocol: str,
        frames: Mapping[int, bytes],
        settings: Settings,
        repeat_ticks: int | None = None,
    ) -> None:
        self.line = line
        self._frames, self._repeat = frames, repeat_ticks
        self._writer = PacedWriter(line, settings)
        self._decoder = decoder(protocol, RC_PAUSE_US)
        self.bytes_out = self.frames_out = 0
        self._channels: tuple[int, ...] = ()

    def step(self, tick: int) -> None:
        """Send what belongs to this millisecond. What comes back (telemetry) is read, so that the line never fills."""
        line = self.line
        line.read()
        if line.lost:
            line.revive()
        data = self._frames.get(tick if self._repeat is None else tick % self._repeat)
        if data:
            self._writer.put(data)
        sent = self._writer.step()
        self.bytes_out += len(sent)
        for event in self._decoder.feed(sent, tick * TICK_US):
            if isinstance(event, RcFrame):
                self.frames_out += 1
                self._channels = event.channels

    def facts(self) -> dict[str, object]:
        """What has passed, for people and --json."""
        dropped = self.line.dropped_bytes
        facts: dict[str, object] = {"frames": self.frames_out, "bytes": self.bytes_out}
        return facts | {"bytes_to_nobody": dropped, "channels": list(self._channels)}

    def close(self) -> None:
        """Give the line back."""
        self.line.close()


def _pose(pose: tuple[float, float, float]) -> dict[str, object]:
    x_m, y_m, heading_rad = pose
    return {"x_m": round(x_m, 3), "y_m": round(y_m, 3), "heading_rad": round(heading_rad, 3)}
