"""Controllers that are wrong on purpose: each has one defect that real firmware has had, behind the seam of any base.

`wheelbench failsafe --controller NAME` runs one of them, and the matrix must go red where its defect shows, and only
there. They prove that the matrix can fail. Never drive a robot with one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from bench.base import Base
from bench.config import Robot
from bench.messages import RcEvent, RcFrame, RcNoise


def stale_command_kept(robot: Robot) -> Base:
    """Stops on silence, but keeps the command: when the link comes back it drives on, without a re-arm."""
    return Base(_with_link(robot, disarm_ms=10**9))


def failsafe_flag_ignored(robot: Robot) -> Base:
    """Takes the channels of a frame and never looks at its failsafe flag."""
    return _filtered(robot, lambda event: event._replace(failsafe=False) if isinstance(event, RcFrame) else event)


def no_timeout(robot: Robot) -> Base:
    """Acts on frames and has no clock: silence is no event, on either link."""
    limits = {"hold_ms": 10**9, "disarm_ms": 2 * 10**9, "core_timeout_ms": 10**9}
    return Base(_with_link(robot, **limits))


def resync_broken(robot: Robot) -> Base:
    """Counts bytes from the first one on: after a lost byte it never finds a frame again."""
    base = Base(robot)
    decoder, deaf = base.rc_decoder, []
    assert decoder is not None
    feed = decoder.feed

    def counting(data: bytes, *times: object) -> list[RcEvent]:
        events = feed(data, *times)  # type: ignore[arg-type]
        if any(isinstance(event, RcNoise) for event in events):
            deaf.append(True)
        return [] if deaf else events

    decoder.feed = counting  # type: ignore[method-assign,assignment]
    return base


def integrator_wind_up(robot: Robot) -> Base:
    """Its integrators have no limit and no reset; the current has. What was summed up has to be driven off again."""
    base = Base(robot)
    control, limit_a = robot.control, robot.limits.current_a
    summed = [0.0] * len(robot.wheels)

    class WindUp:
        def step(self, wanted_radps: Sequence[float], measured_radps: Sequence[float]) -> list[float]:
            currents = []
            for wheel, (wanted, measured) in enumerate(zip(wanted_radps, measured_radps, strict=True)):
                error = wanted - measured
                summed[wheel] += control.ki_a_per_rad * 0.001 * error
                current = control.kp_a_per_radps * error + summed[wheel]
                currents.append(max(-limit_a, min(limit_a, current)))
            return currents

        def reset(self) -> None:
            """It forgets to."""

    base.controller = WindUp()
    return base


def clamp_missing(robot: Robot) -> Base:
    """The current limit of the robot is not in the code: what the loop asks for goes out."""
    return Base(replace(robot, limits=replace(robot.limits, current_a=robot.motor.max_current_a)))


def wheel_swap(robot: Robot) -> Base:
    """Two connectors changed places: commands and feedback of wheels 1 and 2."""
    one, two, *rest = robot.wheels
    swapped = replace(one, can_id=two.can_id), replace(two, can_id=one.can_id)
    return Base(replace(robot, wheels=(*swapped, *rest)))


def degrees_for_radians(robot: Robot) -> Base:
    """Takes the yaw limit of 2.0 rad/s for degrees a second."""
    return Base(replace(robot, limits=replace(robot.limits, angular_radps=math.radians(robot.limits.angular_radps))))


SUBJECTS: Mapping[str, Callable[[Robot], Base]] = {
    "stale-command-kept": stale_command_kept,
    "failsafe-flag-ignored": failsafe_flag_ignored,
    "no-timeout": no_timeout,
    "resync-broken": resync_broken,
    "integrator-wind-up": integrator_wind_up,
    "clamp-missing": clamp_missing,
    "wheel-swap": wheel_swap,
    "degrees-for-radians": degrees_for_radians,
}
"""By the name that the command line takes."""


def _with_link(robot: Robot, **limits: int) -> Robot:
    return replace(robot, link=replace(robot.link, **limits))


def _filtered(robot: Robot, change: Callable[[RcEvent], RcEvent]) -> Base:
    base = Base(robot)
    decoder = base.rc_decoder
    assert decoder is not None
    feed = decoder.feed

    def changed(data: bytes, *times: object) -> list[RcEvent]:
        return [change(event) for event in feed(data, *times)]  # type: ignore[arg-type]

    decoder.feed = changed  # type: ignore[method-assign,assignment]
    return base
