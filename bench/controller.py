"""Wheel speeds wanted and measured -> motor currents: one PI loop a wheel, with friction feed-forward.

The loop runs at 1 kHz on the speed that the encoder shows (the ESC's own rpm lags by its 10 ms filter). The current is
limited to the robot file's value; while it is, the integrator takes nothing that would push it further into the limit.

Each wheel is limited alone. A robot that is asked for more than its motors give turns then: the wheels that need less
current reach their speeds, the others do not. `keep_direction` in the robot file asks of all wheels the same share of
their speeds, as much as the weakest can follow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from bench.config import SPEED_LOOP, Robot
from bench.kinematics import Kinematics

DT_S = 0.001
FRICTION_FADE_RADPS = 0.2
"""Below this wanted speed the friction feed-forward fades to nothing: its sign would be a matter of rounding."""
REST_LEAK = 0.98
"""Share of the integrator that survives each tick of standing still as wanted: a robot at rest must not sit on a
current that static friction happens to balance (it halves in 35 ms)."""


class Inverse(Protocol):
    """Body twist -> wheel speeds."""

    def wheel_speeds(self, twist: Sequence[float]) -> list[float]:
        """Wheel speeds in rad/s, in wheel order."""
        ...


class Controller(Protocol):
    """Wheel speeds wanted and measured, rad/s -> currents, A; wheel order, in the wheels' positive sense."""

    def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
        """Currents for this tick."""
        ...

    def reset(self) -> None:
        """The motors are off: forget what was summed up."""
        ...


def control_of(
    robot: Robot, kinematics: Kinematics, field_heading_rad: Callable[[], float] = lambda: 0.0
) -> tuple[Inverse, Controller]:
    """What the robot's file or a run asks for. Raises UsageError where a printed form is not for this robot.

    `field_heading_rad` tells by how much the command was turned from the field into the body: some printed forms do
    that themselves.
    """
    if robot.control.kind == SPEED_LOOP:
        return kinematics, speed_controller(robot)
    from bench.as_printed.choices import control_as_printed

    return control_as_printed(robot, kinematics, field_heading_rad)


def speed_controller(robot: Robot) -> SpeedController:
    """The speed loops that the robot's file asks for."""
    return DirectionKeeper(robot) if robot.control.keep_direction else SpeedController(robot)


class SpeedController:
    """Per-wheel speed control. Wheel order, rad/s and A, in the wheels' positive sense."""

    __slots__ = (
        "_coulomb_a",
        "_fading_a_per_radps",
        "_integral_a",
        "_ki_dt",
        "_kp",
        "_limit_a",
        "_viscous_a_per_radps",
        "_wheels",
    )

    def __init__(self, robot: Robot) -> None:
        control, motor = robot.control, robot.motor
        self._kp = control.kp_a_per_radps
        self._ki_dt = control.ki_a_per_rad * DT_S
        self._limit_a = robot.limits.current_a
        self._coulomb_a = motor.coulomb_nm / motor.torque_nm_per_a if control.feed_forward else 0.0
        self._viscous_a_per_radps = motor.viscous_nms / motor.torque_nm_per_a if control.feed_forward else 0.0
        self._fading_a_per_radps = self._viscous_a_per_radps + self._coulomb_a / FRICTION_FADE_RADPS
        self._wheels = tuple(range(len(robot.wheels)))
        self._integral_a = [0.0] * len(robot.wheels)

    def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
        """Currents for this tick."""
        kp, ki_dt, limit = self._kp, self._ki_dt, self._limit_a
        viscous, coulomb_a, fading = self._viscous_a_per_radps, self._coulomb_a, self._fading_a_per_radps
        integral_a, currents = self._integral_a, []
        for wheel in self._wheels:
            wanted, measured, integral = wanted_radps[wheel], measured_radps[wheel], integral_a[wheel]
            error = wanted - measured
            if wanted > FRICTION_FADE_RADPS:
                forward_a = viscous * wanted + coulomb_a
            elif wanted < -FRICTION_FADE_RADPS:
                forward_a = viscous * wanted - coulomb_a
            else:
                forward_a = fading * wanted
                if wanted == 0.0 == measured:
                    integral *= REST_LEAK
            current = forward_a + kp * error + integral
            if current > limit:
                current = limit
                if error < 0.0:
                    integral += ki_dt * error
            elif current < -limit:
                current = -limit
                if error > 0.0:
                    integral += ki_dt * error
            else:
                integral += ki_dt * error
            currents.append(current)
            integral_a[wheel] = integral
        return currents

    def reset(self) -> None:
        """Forget the integrators: the motors are off."""
        self._integral_a = [0.0] * len(self._integral_a)


class DirectionKeeper(SpeedController):
    """The same, with all wanted speeds scaled down alike while a wheel would need more current than the limit.

    What it is left with, the same share of every wheel's speed, is the same motion, slower. To a robot that is told to
    stand no share of anything is left: it brakes as the other does.
    """

    __slots__ = ()

    def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
        """Currents for this tick."""
        limit_a, share = self._limit_a, 1.0
        a_per_radps = self._viscous_a_per_radps + self._kp
        for wheel in self._wheels:
            wanted, against_a = wanted_radps[wheel], self._integral_a[wheel] - self._kp * measured_radps[wheel]
            # In the wanted sense: share times the one, and the other, are the current.
            if wanted < 0.0:
                wanted, against_a = -wanted, -against_a
            against_a += self._coulomb_a
            if wanted > FRICTION_FADE_RADPS and a_per_radps * wanted + against_a > limit_a:
                share = min(share, (limit_a - against_a) / (a_per_radps * wanted))
        if share < 1.0:
            share = max(share, 0.0)
            wanted_radps = [share * wanted for wanted in wanted_radps]
        return super().step(wanted_radps, measured_radps)
