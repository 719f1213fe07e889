"""All that a base controller meets: ESCs with motors on a floor, and a SLAMWARE core. Bytes in, bytes out.

    World.speak(tick, input) -> (rc_bytes, slamware_bytes, can_in)     what reaches the base in this tick
    World.hear(tick, can_out, slamware_out) -> can_feedback            what the base sent, taken by motors and core

The transmitter stands before this door: whatever moves the sticks (keys, a capture, a timeline) is encoded as RC bytes
and comes in through `TickInput.rc`. Which half of the world is ours and which is real is a matter of which parts are
handed over; there are no flags inside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from bench.config import Robot
from bench.instruments import instruments_of
from bench.messages import CanFrame, TickInput
from bench.motors import emulated_escs
from bench.noise import SILENT, Noise, NoisyFeedback
from bench.plant import Plant
from bench.slamware.core_side import SlamwareCore
from bench.timed.timing import Timing


class Motors(Protocol):
    """The far end of the motor bus."""

    def step(self, tick: int, commands: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """Take the command frames of this tick; answer with the feedback frames born in it."""
        ...


class SimulatedMotors:
    """Emulated ESCs that turn the wheels of the plant; dead wheels and gyro, where the robot has some, beside them."""

    def __init__(self, robot: Robot, plant: Plant | None = None, noise: Noise = SILENT) -> None:
        self.plant = plant or Plant(robot)
        self.escs = emulated_escs(robot)
        self.instruments = instruments_of(robot, self.plant)
        self.noise = NoisyFeedback(noise) if noise.is_on else None

    def step(self, tick: int, commands: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """Commands -> currents -> motion -> feedback."""
        plant = self.plant
        plant.step(self.escs.receive(tick, commands))
        feedback = self.escs.feedback(plant.wheel_angles_rad, plant.wheel_speeds_radps, plant.currents_a)
        if self.noise is not None:
            feedback = self.noise.step(tick, feedback)
        return feedback if self.instruments is None else feedback + self.instruments.step()


def noise_of(motors: Motors) -> Noise:
    """What a scenario's [noise] does to their feedback."""
    noisy = motors.noise if isinstance(motors, SimulatedMotors) else None
    return noisy.noise if noisy is not None else SILENT


class RecordedMotors:
    """Feedback frames of a recording in place of ESCs and plant; the plant only shadows the commands."""

    def __init__(self, robot: Robot, feedback: Mapping[int, tuple[CanFrame, ...]], plant: Plant | None = None) -> None:
        self.plant = plant or Plant(robot)
        self.escs = emulated_escs(robot)
        self.instruments = instruments_of(robot, self.plant)
        self.recorded = feedback

    def step(self, tick: int, commands: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """The frames that the recording has for this tick, whatever was commanded."""
        self.plant.step(self.escs.receive(tick, commands))
        if self.instruments is not None:
            self.instruments.step()
        return self.recorded.get(tick, ())


class World:
    """ESCs, plant and core around one base. `core=None`: requests come in through `TickInput.slamware`."""

    def __init__(self, robot: Robot, *, core: SlamwareCore | None, motors: SimulatedMotors | RecordedMotors) -> None:
        self.robot = robot
        self.core = core
        self.motors = motors
        self.timing: Timing | None = None
        """Set where wires take their time; otherwise all that is sent in a millisecond arrives in it."""
        self._feedback: tuple[CanFrame, ...] = ()
        self._answer = b""

    def take_over(self, world: World) -> None:
        """Stand in another world's place in the middle of a run: what is under way on its wires stays so."""
        self._feedback, self._answer, self.timing = world._feedback, world._answer, world.timing

    @property
    def plant(self) -> Plant:
        """Where the robot really is."""
        return self.motors.plant

    def speak(self, tick: int, given: TickInput) -> tuple[bytes, bytes, tuple[CanFrame, ...]]:
        """RC bytes, core requests and the feedback born in the previous tick."""
        core = self.core
        rc, core_twist, slamware = given
        if core is None:
            return rc, slamware, self._feedback
        if core_twist is not None:
            core.ask(core_twist)
        # Most ticks find the core waiting for an answer or for its time: a call less.
        request = core.step(tick, self._answer) if self._answer or tick >= core.act_tick else b""
        timing = self.timing
        if timing is not None:
            rc, request = timing.rc(rc), timing.requests(request)
        return rc, request, self._feedback

    def hear(self, tick: int, can_out: Sequence[CanFrame], slamware_out: bytes) -> tuple[CanFrame, ...]:
        """Let the motors take the commands; keep the answer for the core. Returns this tick's feedback frames."""
        timing = self.timing
        if timing is None:
            self._answer = slamware_out
            self._feedback = self.motors.step(tick, can_out)
        else:
            self._answer = timing.answers(slamware_out)
            self._feedback = timing.reports(tick, self.motors.step(tick, timing.commands(tick, can_out)))
        return self._feedback
