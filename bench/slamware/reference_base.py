"""The vendor's reference base as a whole: two driven wheels, two bumpers, four ultrasonic sensors.

    base = as_reference_firmware()
    answers = base.receive(request_bytes, tick)

Bytes come out as from the base that SLAMTEC publishes the sources of (2018-11-20): its text, its geometry, its wheels
of 6390 encoder edges a metre on a radius of 118 mm, its single precision. Figures are read off that base's answers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.messages import BodyTwist
from bench.slamware import config_payloads as tree
from bench.slamware.config_payloads import BaseConfiguration, Position, Symbol, Tree, encode_tree
from bench.slamware.facts import BaseFacts
from bench.slamware.payloads import Displacement, Identity
from bench.slamware.reference_firmware import ReferenceFirmware, single
from bench.slamware.senses import Motion, Senses, Wanted

EDGES_PER_M = 6390
WHEEL_RADIUS_MM = 118
"""From the centre to each wheel; the outline of 0x20 has 180."""


def as_reference_firmware(senses: Senses | None = None, *, bytes_per_look: int = 1) -> ReferenceFirmware:
    """The vendor's base, freshly booted. Its wheels are its `motion`, a `ReferenceWheels`."""
    senses = senses or Senses()
    return ReferenceFirmware(reference_facts(), ReferenceWheels(senses), senses, bytes_per_look=bytes_per_look)


class ReferenceWheels(Motion):
    """Two wheels with encoders that count edges and no direction: that is taken from what was last asked of a wheel.

    `turn` is the ground, `targets_mmps` what the motors would be told. All as the reference base has it.
    """

    wheel_count = 2

    def __init__(self, senses: Senses) -> None:
        self._senses = senses
        self._targets_mmps = [0, 0]
        self._signs = [1, 1]
        self._edges = [0, 0]
        self._fresh_edges = [0, 0]
        self.lifted_status = 0
        """Status bits: 0x04 while a wheel is off the ground."""

    def turn(self, left_edges: int, right_edges: int) -> None:
        """Encoder edges that pass, whichever way the wheel turns."""
        for wheel, edges in enumerate((left_edges, right_edges)):
            self._edges[wheel] += edges
            self._fresh_edges[wheel] += edges * self._signs[wheel]

    def targets_mmps(self, alive: bool) -> tuple[int, int]:
        """What the main loop leaves of the targets: nothing without a core, nothing forward against a bumper."""
        if not alive:
            self._set(0, 0)
        elif self._is_bumped():
            self._set(*(min(target, 0) for target in self._targets_mmps))
        left, right = self._targets_mmps
        return left, right

    def take_increment(self) -> Displacement:
        """Since the last call, in single precision."""
        left_m, right_m = (single(single(edges) / EDGES_PER_M) for edges in self._fresh_edges)
        self._fresh_edges = [0, 0]
        dtheta = single(single(right_m - left_m) / single(2 * WHEEL_RADIUS_MM / 1000))
        mean_m = single(single(left_m + right_m) / 2)
        dx_m = single(single(math.cos(dtheta)) * mean_m)
        dy_m = single(single(math.sin(dtheta)) * mean_m)
        return Displacement(dx_m, dy_m, dtheta)

    def rim_distances_m(self) -> Sequence[float]:
        """Whole millimetres, and they only ever grow."""
        return tuple(edges * 1000 // EDGES_PER_M / 1000 for edges in self._edges)

    def status(self) -> int:
        """The status bits."""
        return self.lifted_status

    def follow_twist(self, twist: BodyTwist) -> Wanted:
        """Cut to whole mm/s; vy is left out of account."""
        forward_mmps, turn_mmps = 1000.0 * twist.vx_mps, WHEEL_RADIUS_MM * twist.omega_radps
        targets = (int(forward_mmps - turn_mmps), int(forward_mmps + turn_mmps))
        self._set(*(min(target, 0) if self._is_bumped() else target for target in targets))
        return Wanted(twist)

    def follow_rims(self, speeds_mps: Sequence[float]) -> Wanted | None:
        """Refused without a word while a bumper is pressed, if either wheel would go forward."""
        left_mmps, right_mmps = (round(1000.0 * speed) for speed in speeds_mps)
        if self._is_bumped() and (left_mmps > 0 or right_mmps > 0):
            return None
        self._set(left_mmps, right_mmps)
        mean_mps = (left_mmps + right_mmps) / 2000.0
        return Wanted(BodyTwist(mean_mps, 0.0, (right_mmps - left_mmps) / (2.0 * WHEEL_RADIUS_MM)))

    def _is_bumped(self) -> bool:
        return any(self._senses.contacts()[:2])

    def _set(self, *targets: int) -> None:
        self._targets_mmps = list(targets)
        self._signs = [(1 if new > 0 else -1) if new else sign for new, sign in zip(targets, self._signs, strict=True)]


def reference_facts() -> BaseFacts:
    """What the reference base says of itself. Its serial number is its controller's: here that of the vendor frames."""
    identity = Identity("ref base", 0x005A, 1, "303132333435363738394142")
    sensors = ((0.170, 0.0, 0), (0.120, -0.120, 315), (0.120, 0.120, 45), (0.085, 0.147, 75))
    strips = ((0.120, 0.120, 45), (0.120, -0.120, 315))
    configuration = BaseConfiguration(
        tree.ROUND,
        0.180,
        tree.TWO_WHEELS,
        tuple(Position(x_m, y_m, 0.060, math.radians(deg)) for x_m, y_m, deg in sensors),
        tuple(Position(x_m, y_m, 0.050, math.radians(deg)) for x_m, y_m, deg in strips),
    )
    return BaseFacts(identity, configuration, encode_tree(_reference_tree()))


def _reference_tree() -> Tree:
    # The yaws stand in the vendor's blob with six digits, not as exact multiples of 15 degrees.
    bumpers = ((0.12, 0.12, 0.785398), (0.12, -0.12, 5.497787))
    cliffs = [(0.044, 0.1642, 4.974188), (0.147, 0.085, 5.759587)]
    cliffs += [(0.147, -0.085, 0.523599), (0.044, -0.1642, 1.308997)]
    placed = [(tree.BUMPER, x_m, y_m, 0.05, yaw) for x_m, y_m, yaw in bumpers]
    placed += [(tree.CLIFF, x_m, y_m, -0.02, yaw) for x_m, y_m, yaw in cliffs]
    sensors: list[Tree] = [
        {tree.ID: number, tree.TYPE: Symbol(kind), tree.POSE: {tree.X: x_m, tree.Y: y_m, tree.Z: z_m, tree.YAW: yaw}}
        for number, (kind, x_m, y_m, z_m, yaw) in enumerate(placed)
    ]
    return {
        tree.BASE: {
            tree.MANUFACTURER_ID: 255,
            tree.MANUFACTURER: "Slamtec",
            tree.MODEL_ID: 0x1000,
            tree.MODEL: "Slamware SDP",
            tree.HARDWARE_VERSION: 1,
            tree.SIZE: 0.36,
            tree.CHARGE_BELOW: 0.3,
            tree.CHARGED_ABOVE: 0.7,
            tree.AUTO_HOMING: True,
            tree.SENSORS: sensors,
        },
        tree.LIDAR: {tree.POSE: {tree.X: -0.0304, tree.YAW: math.pi}},
        tree.FEATURE: {tree.DOCK_TOWER: True},
        tree.MOTION_PLAN: {tree.SIDE_MARGIN: 0.01, tree.BUMP_STRATEGY: Symbol(tree.DEFAULT)},
    }
