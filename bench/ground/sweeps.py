"""Projected Gauss-Seidel over the rows of a base on the floor: each row in turn solved exactly, the others as they are.

It finds the modes of a step from any state. It is slow to find the numbers, which the inverse then has at once.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.ground.modes import HOLDS, ROLLS, SLIDES, SLIPS, STANDS, Floor, Impulses, Mode, WheelRow, WheelState
from bench.ground.walls import WallRows
from bench.kinematics import Row


class Sweeps:
    """The sweeps of one step, started from the impulses of the step before; `start` is the velocity before the step.

    After each `sweep`: `modes` and `impulses_ns` in wheel order, `velocity` of the body, and `largest_mps`, by how much
    the contact speed of a row has changed at most.
    """

    __slots__ = ("_per_mass", "_per_yaw", "_rows", "_walls", "impulses_ns", "largest_mps", "modes", "velocity")

    def __init__(
        self,
        start: Row,
        impulses_ns: list[Impulses],
        rows: Sequence[WheelRow],
        floor: Sequence[Floor],
        wheels: Sequence[WheelState],
        mass_kg: float,
        yaw_inertia_kgm2: float,
        walls: WallRows | None,
    ) -> None:
        self._per_mass, self._per_yaw = per_mass, per_yaw = 1.0 / mass_kg, 1.0 / yaw_inertia_kgm2
        self._walls = walls
        self.impulses_ns = impulses_ns
        self.modes: list[Mode] = []
        self.largest_mps = 0.0
        vx, vy, omega = start
        for (ax, ay, arm, arm_across, *_), (along, across) in zip(rows, impulses_ns, strict=True):
            vx += (ax * along - ay * across) * per_mass
            vy += (ay * along + ax * across) * per_mass
            omega += (arm * along + arm_across * across) * per_yaw
        if walls is not None:
            px, py, pw = walls.push_ns()
            vx += px * per_mass
            vy += py * per_mass
            omega += pw * per_yaw
        self.velocity: Row = vx, vy, omega
        # A spin on the spot takes hundreds of sweeps: what does not change from one to the next is worked out before.
        self._rows = []
        for row, (most_grip, most_loss), (momentum, dry, load) in zip(rows, floor, wheels, strict=True):
            ax, ay, arm, arm_across, _, per_rc, stiffness, _ = row
            free = per_mass + arm * arm / yaw_inertia_kgm2
            free_across = per_mass + arm_across * arm_across / yaw_inertia_kgm2
            forth, back = (momentum - dry) * per_rc, (momentum + dry) * per_rc
            grip, loss = most_grip * load, most_loss * load
            softened = 1.0 / (1.0 + stiffness * free)
            self._rows.append(
                (ax, ay, arm, arm_across, free, free_across, stiffness, softened, forth, back, grip, -grip, loss, -loss)
            )

    def sweep(self) -> None:
        """Every row once."""
        vx, vy, omega = self.velocity
        per_mass, per_yaw = self._per_mass, self._per_yaw
        largest = 0.0
        if self._walls is not None:  # first, so that the wheels find the body where it is held
            vx, vy, omega, largest = self._walls.sweep(vx, vy, omega)
        modes: list[Mode] = []
        impulses: list[Impulses] = []
        for (
            (ax, ay, arm, arm_across, k, k_across, stiffness, softened, forth, back, grip, no_grip, loss, no_loss),
            (along, across),
        ) in zip(self._rows, self.impulses_ns, strict=True):
            free = ax * vx + ay * vy + arm * omega - k * along
            forwards = (forth - stiffness * free) * softened
            backwards = (back - stiffness * free) * softened
            new, drive = -free / k, STANDS
            if new < forwards:
                new, drive = forwards, ROLLS
            elif new > backwards:
                new, drive = backwards, -ROLLS
            if new > grip:
                new, drive = grip, SLIPS
            elif new < no_grip:
                new, drive = no_grip, -SLIPS
            change = new - along
            vx += ax * change * per_mass
            vy += ay * change * per_mass
            omega += arm * change * per_yaw
            moved = change * k
            if moved > largest or -moved > largest:
                largest = abs(moved)

            new_across, roll = across - (ax * vy - ay * vx + arm_across * omega) / k_across, HOLDS
            if new_across > loss:
                new_across, roll = loss, -SLIDES
            elif new_across < no_loss:
                new_across, roll = no_loss, SLIDES
            change = new_across - across
            vx -= ay * change * per_mass
            vy += ax * change * per_mass
            omega += arm_across * change * per_yaw
            moved = change * k_across
            if moved > largest or -moved > largest:
                largest = abs(moved)
            modes.append((drive, roll))
            impulses.append((new, new_across))
        self.modes, self.impulses_ns = modes, impulses
        self.velocity = vx, vy, omega
        self.largest_mps = largest
