"""Who drives, and how fast: sticks, SLAMWARE core and link state -> one body twist, or no power at all.

    disarmed --rising AUX1, sticks at rest, link live--> armed
    armed    --rising AUX1, wherever the sticks are----> disarmed
             --link lost-------------------------------> disarmed by loss (blocks every source until a re-arm)

Armed, sticks outside the dead-band drive; let go, the twist is zero at once, without a ramp. Sticks at rest for
`handover_ms` hand over to the SLAMWARE core, if it is alive; touching a stick takes over at once. Rising AUX2 toggles
field-centric driving (stick forward is field forward; the heading counts from arming). While the link is neutral the
twist is zero and the wheels brake. A profile with arming = "on_link" is armed while its link is; a robot without RC
takes the core alone.
"""

from __future__ import annotations

import math

from bench.config import Axis, Profile, Robot
from bench.kinematics import rotate_into_body
from bench.link import COMMANDING, LIVE, LOST, NEUTRAL, NEVER_SEEN, RcLink
from bench.messages import ZERO_TWIST, BodyTwist, RcFrame

DT_S = 0.001
# A named tuple's own constructor costs twice as much; this one makes the same value.
_new_twist = tuple.__new__
DRIVER_NONE, DRIVER_RC, DRIVER_CORE = "none", "rc", "core"


class Drive:
    """Arming, choice of the driver and stick mapping of one robot. `step` once a tick, after the link.

    `armed`, `driver` ("none", "rc", "core"), `field_centric`, `sticks` (forward, left, counter-clockwise, -1 to 1
    after dead-band and curve) and `why_disarmed` are for the screen and the recording.
    """

    __slots__ = (
        "_angular_step",
        "_core_asked",
        "_core_twist",
        "_frame",
        "_handover",
        "_heading_zero_rad",
        "_limits",
        "_linear_step",
        "_moved_tick",
        "_pressed",
        "_profile",
        "_ramped",
        "_stick_twist",
        "armed",
        "driver",
        "field_centric",
        "sticks",
        "why_disarmed",
    )

    def __init__(self, robot: Robot) -> None:
        limits = robot.limits
        self._limits = limits
        self._profile: Profile | None = robot.rc
        self._handover = robot.link.handover_ms
        self._linear_step = limits.linear_acceleration_mps2 * DT_S
        self._angular_step = limits.angular_acceleration_radps2 * DT_S
        self._frame: RcFrame | None = None
        self._pressed: tuple[bool, bool] | None = None
        self._moved_tick = 0
        self._heading_zero_rad = 0.0
        self._ramped = ZERO_TWIST
        # What sticks and core ask for, within the limits: worked out when it changes, not in every tick.
        self._stick_twist = ZERO_TWIST
        self._core_asked = self._core_twist = ZERO_TWIST
        self.armed = robot.rc is None
        self.why_disarmed = "" if self.armed else "not armed since boot"
        self.driver = DRIVER_NONE
        self.field_centric = False
        self.sticks = (0.0, 0.0, 0.0)

    def step(
        self, tick: int, link: RcLink | None, core_twist: BodyTwist, core_alive: bool, heading_rad: float
    ) -> BodyTwist | None:
        """The body twist for this tick; None means no power: zero current, integrators reset."""
        if link is not None and (link.frame is not self._frame or link.state not in COMMANDING):
            self._follow_link(tick, link, heading_rad)
        if not self.armed:
            self.driver = DRIVER_NONE
            self._ramped = ZERO_TWIST
            return None
        wanted = self._choose(tick, link, core_twist, core_alive, heading_rad)
        if wanted is None:  # the ramp is for getting going and for the core's comfort; a driver who lets go means stop
            self._ramped = ZERO_TWIST
        elif wanted is not self._ramped and wanted != self._ramped:
            self._ramped = self._ramp(wanted)
        return self._ramped

    def turned_rad(self, heading_rad: float) -> float:
        """By how much the command of now was turned from the field into the body; 0 where nobody drives so."""
        return heading_rad - self._heading_zero_rad if self.field_centric and self.driver == DRIVER_RC else 0.0

    def _follow_link(self, tick: int, link: RcLink, heading_rad: float) -> None:
        """Arming and sticks, from the link's state and its last good frame: called where there is news."""
        profile = self._profile
        assert profile is not None
        state = link.state
        if state not in COMMANDING:
            if self.armed and state in (LOST, NEVER_SEEN):
                self._disarm(f"link lost: {link.reason}")
            # A press that began while nobody was listening is not a deliberate act.
            self._pressed = None
            return
        self._frame = frame = link.frame
        if frame is None:
            return
        channels = frame.channels
        sticks = sticks_of(channels, profile)
        if any(sticks) or any(self.sticks):  # the frame that finds them back at rest starts the count
            self._moved_tick = tick
        self.sticks = sticks
        self._stick_twist = self._from_sticks(*sticks)
        before = self._pressed
        aux1, aux2 = profile.aux1, profile.aux2
        self._pressed = pressed = (
            aux1 is not None and aux1.is_pressed(channels),
            aux2 is not None and aux2.is_pressed(channels),
        )
        if profile.arming == "on_link":
            if not self.armed and state == LIVE:
                self._arm(tick, heading_rad)
        elif before is not None and pressed[0] and not before[0]:
            if self.armed:
                self._disarm("AUX1")
            elif not any(sticks):
                self._arm(tick, heading_rad)
            else:
                self.why_disarmed = "sticks were not at rest: arm again"
        if before is not None and pressed[1] and not before[1]:
            self.field_centric = not self.field_centric

    def _arm(self, tick: int, heading_rad: float) -> None:
        self.armed = True
        self.why_disarmed = ""
        self._moved_tick = tick
        self._heading_zero_rad = heading_rad

    def _disarm(self, why: str) -> None:
        self.armed = False
        self.why_disarmed = why

    def _choose(
        self, tick: int, link: RcLink | None, core_twist: BodyTwist, core_alive: bool, heading_rad: float
    ) -> BodyTwist | None:
        """What the driver wants; None is a standstill, at once."""
        if link is not None:
            if link.state == NEUTRAL:
                self.driver = DRIVER_NONE
                return None
            forward, left, turn = self.sticks
            if forward or left or turn:
                self.driver = DRIVER_RC
                if not self.field_centric:
                    return self._stick_twist
                forward, left = rotate_into_body(forward, left, heading_rad - self._heading_zero_rad)
                return self._from_sticks(forward, left, turn)
            if tick - self._moved_tick < self._handover:
                self.driver = DRIVER_RC
                return None
        if not core_alive:
            self.driver = DRIVER_NONE
            return None
        self.driver = DRIVER_CORE
        if core_twist is not self._core_asked:
            self._core_asked, self._core_twist = core_twist, self._limited(*core_twist)
        return self._core_twist

    def _from_sticks(self, forward: float, left: float, turn: float) -> BodyTwist:
        limits = self._limits
        return self._limited(forward * limits.linear_mps, left * limits.linear_mps, turn * limits.angular_radps)

    def _limited(self, vx_mps: float, vy_mps: float, omega_radps: float) -> BodyTwist:
        """Within the robot's limits: the direction of travel is kept, yaw is limited by itself."""
        limits = self._limits
        speed = math.sqrt(vx_mps * vx_mps + vy_mps * vy_mps)
        if speed > limits.linear_mps:
            scale = limits.linear_mps / speed
            vx_mps *= scale
            vy_mps *= scale
        omega_radps = max(-limits.angular_radps, min(limits.angular_radps, omega_radps))
        return BodyTwist(vx_mps, vy_mps, omega_radps)

    def _ramp(self, wanted: BodyTwist) -> BodyTwist:
        """One tick towards the wanted twist, at most the robot file's accelerations."""
        vx, vy, omega = self._ramped
        to_vx, to_vy, to_omega = wanted
        dx, dy, turn = to_vx - vx, to_vy - vy, to_omega - omega
        distance = math.sqrt(dx * dx + dy * dy)
        step = self._angular_step
        arrives = -step <= turn <= step
        if distance > self._linear_step:
            share = self._linear_step / distance
            vx += dx * share
            vy += dy * share
        elif arrives:
            return wanted
        else:
            vx, vy = to_vx, to_vy
        return _new_twist(BodyTwist, (vx, vy, to_omega if arrives else omega + math.copysign(step, turn)))


def sticks_of(channels: tuple[int, ...], profile: Profile) -> tuple[float, float, float]:
    """Where a frame has the sticks: forward, left and counter-clockwise, -1 to 1."""
    return (
        _stick(channels, profile.forward, profile),
        -_stick(channels, profile.right, profile),
        -_stick(channels, profile.clockwise, profile),
    )


def _stick(channels: tuple[int, ...], axis: Axis, profile: Profile) -> float:
    """One stick, -1 to 1: zero inside the dead-band, from zero at its edge, bent by the curve."""
    value = (channels[axis.channel] - axis.middle) / axis.travel
    if axis.reversed:
        value = -value
    size = abs(value)
    if size <= profile.dead_band:
        return 0.0
    size = min(1.0, (size - profile.dead_band) / (1.0 - profile.dead_band))
    size = (1.0 - profile.expo) * size + profile.expo * size * size * size
    return math.copysign(size, value)
