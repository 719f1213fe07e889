"""A world whose wires fail, with motors that fall silent or weak, on a floor that may be slippery."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.check.faulty.injector import Injector
from bench.check.faulty.pieces import Frames
from bench.config import Robot
from bench.messages import CanFrame, TickInput
from bench.motors import family
from bench.world import SimulatedMotors, World


class FaultyWorld(World):
    """A world in which the faults of an injector happen."""

    def __init__(self, world: World, injector: Injector) -> None:
        motors = world.motors
        if isinstance(motors, SimulatedMotors):
            motors = _FaultyMotors(world.robot, motors, injector)
        super().__init__(world.robot, core=world.core, motors=motors)
        self.take_over(world)
        self.injector = injector

    def speak(self, tick: int, given: TickInput) -> tuple[bytes, bytes, Frames]:
        """As `World.speak`, over failing wires."""
        rc, core, feedback = super().speak(tick, given)
        through = self.injector.through
        return through("rc", tick, rc), through("core", tick, core), feedback

    def hear(self, tick: int, can_out: Sequence[CanFrame], slamware_out: bytes) -> Frames:
        """As `World.hear`, over failing wires. The feedback that it gives is what reaches the base."""
        through = self.injector.through
        commands = through("command", tick, tuple(can_out))
        feedback = super().hear(tick, commands, through("answer", tick, slamware_out))
        self._feedback = feedback = through("feedback", tick, feedback)
        return feedback


class _FaultyMotors(SimulatedMotors):
    """Motors that may fall silent or weak, on a floor that may be slippery, under a robot that may be pushed."""

    def __init__(self, robot: Robot, motors: SimulatedMotors, injector: Injector) -> None:
        self.plant, self.escs, self.instruments = motors.plant, motors.escs, motors.instruments
        self.noise = motors.noise
        self._injector = injector
        self._ids = [family(robot).feedback[wheel.can_id - 1].can_id for wheel in robot.wheels]
        self._grip, self._full_grip = 1.0, robot.ground.grip

    def step(self, tick: int, commands: Sequence[CanFrame]) -> Frames:
        """As `SimulatedMotors.step`."""
        plant = self.plant
        currents = list(self.escs.receive(tick, commands))
        silent = self._touch_the_motors(tick, currents)
        self._touch_the_plant(tick)
        plant.step(currents)
        feedback = self.escs.feedback(plant.wheel_angles_rad, plant.wheel_speeds_radps, plant.currents_a)
        if self.noise is not None:
            feedback = self.noise.step(tick, feedback)
        if silent:
            feedback = tuple(frame for frame in feedback if frame[0] not in silent)
        return feedback if self.instruments is None else feedback + self.instruments.step()

    def _touch_the_motors(self, tick: int, currents: list[float]) -> set[int]:
        """Changes the currents; gives the identifiers from which no feedback comes."""
        silent: set[int] = set()
        for fault in self._injector.acting("esc", tick):
            for wheel in range(len(currents)) if fault.esc is None else (fault.esc - 1,):
                before = currents[wheel]
                if fault.kind == "silent":
                    silent.add(self._ids[wheel])
                    currents[wheel], after = 0.0, "silent"
                else:
                    currents[wheel] *= fault.factor
                    after = f"{currents[wheel]:.3f} A"
                if before or fault.kind == "silent":
                    self._injector.note(fault, tick, f"wheel {wheel + 1}: {before:.3f} A", after)
        return silent

    def _touch_the_plant(self, tick: int) -> None:
        grip = 1.0
        for fault in self._injector.acting("plant", tick):
            if fault.kind == "slippery":
                grip *= fault.factor
                self._injector.note(fault, tick, "grip 1", f"grip {fault.factor:g}")
                continue
            x_n, y_n = fault.force_n * math.cos(fault.bearing_rad), fault.force_n * math.sin(fault.bearing_rad)
            self.plant.push(x_n, y_n)
            self._injector.note(fault, tick, "0 N", f"{x_n:.2f} N, {y_n:.2f} N")
        if grip != self._grip:
            self._grip = grip
            self.plant.set_grip(grip * self._full_grip)
