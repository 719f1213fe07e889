"""A robot file as a MuJoCo model in three dimensions, with every roller of every wheel as a body of its own.

Nothing of the bench's ground contact is in it: no wheel equation, no roller axis on the ground, no load formula. What
the wheels do follows from free rollers on a floor. Only geometry, masses and inertias come from the robot file.

A wheel is a hub on a hinge with ROLLERS ellipsoids around it, each free to turn about its own axis. An ellipsoid of
half-axes (a, b, b), its axis at gamma to the rim, reaches out to the radius r where it stands and follows the rim to
both sides where a^2 / b = (r - b sin^2 gamma) / cos^2 gamma. What is left is a small ripple from one to the next.

Frame: x forward, y left, z up, the floor at z = 0; wheel angles positive as in the robot file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.config import Robot
from bench.messages import BodyTwist, Pose

STEP_S = 0.0002
ROLLERS = 16
"""With 10 the speed ripples by 1 %, with 16 by a quarter of that."""
ROLLER_SHARE = 0.2
"""The roller's largest radius, as a share of the wheel's."""
ROLLERS_KG, HUB_KG = 0.01 / 3, 0.01
"""Of one wheel. Small, and taken from the body, so that the whole weighs what the robot file says."""
GRAVITY_MPS2 = 9.81


class RollerRobot:
    """One robot on explicit rollers; `torques_nm` act on the wheels, `step` advances by STEP_S."""

    def __init__(self, robot: Robot) -> None:
        import mujoco  # here: the model's text can be made, and tested, without it

        self._step = mujoco.mj_step
        self.model = mujoco.MjModel.from_xml_string(model_xml(robot))
        self.data = mujoco.MjData(self.model)
        self._wheels = [self.model.joint(f"wheel{number}") for number in range(len(robot.wheels))]
        self._speeds_at = [int(joint.dofadr[0]) for joint in self._wheels]
        mujoco.mj_forward(self.model, self.data)

    def step(self, torques_nm: Sequence[float]) -> None:
        """One step with these wheel torques."""
        self.data.ctrl[:] = torques_nm
        self._step(self.model, self.data)

    def settle(self, seconds: float = 0.2) -> None:
        """Let the wheels find the floor; the clock and the place start from here."""
        for _ in range(round(seconds / STEP_S)):
            self.step([0.0] * len(self._wheels))

    @property
    def wheel_speeds_radps(self) -> list[float]:
        """In wheel order."""
        return [float(self.data.qvel[at]) for at in self._speeds_at]

    @property
    def pose(self) -> Pose:
        """Of the body, seen from above."""
        x, y, _, w, i, j, k = (float(value) for value in self.data.qpos[:7])
        return Pose(x, y, math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)))

    @property
    def twist(self) -> BodyTwist:
        """Of the body, in its own frame."""
        heading = self.pose.heading_rad
        c, s = math.cos(heading), math.sin(heading)
        vx, vy = float(self.data.qvel[0]), float(self.data.qvel[1])
        return BodyTwist(c * vx + s * vy, c * vy - s * vx, float(self.data.qvel[5]))


def model_xml(robot: Robot) -> str:
    """The model in MuJoCo's own XML. The body's masses are what is left of the robot file's after the wheels."""
    body, wheels = robot.body, robot.wheels
    wheel_kg = HUB_KG + ROLLERS_KG
    base_kg = body.mass_kg - wheel_kg * len(wheels)
    # The base stands where the whole robot's centre of gravity comes to lie above the origin, at the file's height.
    x, y, z = 0.0, 0.0, body.mass_kg * body.cog_height_m
    yaw = body.inertia_kgm2
    for wheel in wheels:
        x, y, z = x - wheel_kg * wheel.x_m, y - wheel_kg * wheel.y_m, z - wheel_kg * wheel.radius_m
        yaw -= wheel_kg * (wheel.x_m**2 + wheel.y_m**2) + _wheel_yaw_kgm2(wheel.radius_m)
    tilt = 0.6 * yaw  # of a thick disc; nothing tips, so it enters nowhere
    parts = [_wheel_xml(robot, number) for number in range(len(wheels))]
    motors = [f'<motor joint="wheel{number}"/>' for number in range(len(wheels))]
    return f"""<mujoco model="{robot.name}">
  <option timestep="{STEP_S}" cone="elliptic" impratio="100" solver="Newton" iterations="50" tolerance="1e-12"
          integrator="implicitfast" gravity="0 0 -{GRAVITY_MPS2}"/>
  <default><geom solref="0.0008 1" friction="{robot.ground.grip} 0 0" condim="3"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="50 50 1" contype="1" conaffinity="2"/>
    <body name="base">
      <freejoint/>
      <inertial pos="{x / base_kg} {y / base_kg} {z / base_kg}" mass="{base_kg}" diaginertia="{tilt} {tilt} {yaw}"/>
      {"".join(parts)}
    </body>
  </worldbody>
  <actuator>{"".join(motors)}</actuator>
</mujoco>"""


def _wheel_yaw_kgm2(radius_m: float) -> float:
    """A thin ring standing on edge, about the vertical through its centre; hub and rollers alike."""
    return (HUB_KG / 2.0 + ROLLERS_KG) * radius_m**2 / 2.0


def _wheel_xml(robot: Robot, number: int) -> str:
    wheel = robot.wheels[number]
    radius, roller = wheel.radius_m, wheel.radius_m * ROLLER_SHARE
    rim = radius - roller * math.sin(wheel.roller_rad) ** 2
    half_length = math.sqrt(roller * rim) / math.cos(wheel.roller_rad)
    ring = radius - roller
    # What the file says of the wheel, gear and rotor; the rollers' own share of it goes off.
    armature = robot.motor.inertia_kgm2 - (HUB_KG / 2.0 + ROLLERS_KG) * radius**2
    each_kg = ROLLERS_KG / ROLLERS
    spin, swing = each_kg * roller**2 * 0.4, each_kg * (roller**2 + half_length**2) * 0.2
    rollers = []
    for place in range(ROLLERS):
        turn = math.tau * place / ROLLERS
        x, z = -ring * math.sin(turn), -ring * math.cos(turn)
        rollers.append(
            f'<body pos="{x} 0 {z}" quat="{_quaternion(turn, wheel.roller_rad)}"><joint type="hinge" axis="1 0 0"/>'
            f'<inertial pos="0 0 0" mass="{each_kg}" diaginertia="{spin} {swing} {swing}"/>'
            f'<geom type="ellipsoid" size="{half_length} {roller} {roller}" contype="2" conaffinity="1"/></body>'
        )
    half = wheel.heading_rad / 2.0
    disc = HUB_KG * radius**2 / 2.0
    return (
        f'<body pos="{wheel.x_m} {wheel.y_m} {radius}" quat="{math.cos(half)} 0 0 {math.sin(half)}">'
        f'<joint name="wheel{number}" type="hinge" axis="0 1 0" armature="{armature}"/>'
        f'<inertial pos="0 0 0" mass="{HUB_KG}" diaginertia="{disc / 2.0} {disc} {disc / 2.0}"/>'
        f"{''.join(rollers)}</body>"
    )


def _quaternion(about_y_rad: float, then_about_own_z_rad: float) -> str:
    """Around the wheel to the roller's place, then round to the roller's axis."""
    cy, sy = math.cos(about_y_rad / 2.0), math.sin(about_y_rad / 2.0)
    cz, sz = math.cos(then_about_own_z_rad / 2.0), math.sin(then_about_own_z_rad / 2.0)
    return f"{cy * cz} {sy * sz} {sy * cz} {cy * sz}"
