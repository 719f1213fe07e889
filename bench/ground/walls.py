"""The walls that a base leans on, as rows of the same solve as its wheels. Pure arithmetic: no engine, no time.

A wall that touches the body's disc may push it away, and rub along its rim:

    AWAY   no impulse; the body may move away from the wall
    LEANS  the body does not move into the wall; the impulse along the normal is whatever that takes, never a pull
    and while it leans: STICKS (the rim does not slide) or SLIDES (+- friction times the normal impulse, against it)

Floor and wall have to be solved together. A floor that does not know of the wall moves a stalled body a little in every
step and the engine takes that back, but the wheels have turned by then (reference plant-model, 3.3). `Contact` calls
`lean`, `agree` and `keep` where its modes are known, `sweep` and `relent` where it looks for them. An impact is the
engine's: a wall becomes a row in the step after it was hit.

Frame: the body's, standing still during a step. A normal points from the wall to the body. Impulses in N s.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from typing import TypeAlias

from bench.ground.linear import Matrix, dot, times
from bench.kinematics import Row

AWAY, LEANS = 0.0, 1.0
STICKS, SLIDES = 0.0, 1.0
"""The sign of SLIDES is that of the impulse."""
HELD_MPS = 2e-7
"""So still along a wall's normal counts as held. A normal that lies a hair's breadth beside a row of the floor would
take sweeps by the thousand to tell which of the two holds; the engine takes back what this leaves."""
ROUNDING_MPS = 1e-12
DEPENDENT_BELOW = 1e-12
"""A row whose inverse mass is below this share of its free value is already held by other rows."""

Touch: TypeAlias = tuple[Hashable, float, float, float]
"""Which wall, its normal (x, y), its friction against the body."""


class WallRows:
    """The walls that touch one body in a step. `touch` says which, then `Contact.solve` takes them along."""

    __slots__ = (
        "_denied",
        "_impulses",
        "_modes",
        "_per_mass",
        "_per_tangent",
        "_per_yaw",
        "_radius",
        "_touches",
        "_tried",
        "held",
    )

    def __init__(self, mass_kg: float, yaw_inertia_kgm2: float, radius_m: float) -> None:
        self._radius = radius_m
        self._per_mass, self._per_yaw = 1.0 / mass_kg, 1.0 / yaw_inertia_kgm2
        self._per_tangent = 1.0 / (self._per_mass + radius_m * radius_m * self._per_yaw)
        self._touches: Sequence[Touch] = ()
        self._impulses: list[tuple[float, float]] = []
        self._tried: list[tuple[float, float]] = []
        self._modes: list[tuple[float, float]] = []
        self._denied: list[tuple[int, tuple[float, float]]] = []
        self.held = False
        """The rows that were just tried leave the body no motion at all."""

    def touch(self, touches: Sequence[Touch]) -> None:
        """The walls of this step. One that was there in the step before starts with its impulses and modes."""
        before = {touch[0]: known for touch, *known in zip(self._touches, self._impulses, self._modes, strict=True)}
        known = [before.get(touch[0], [(0.0, 0.0), (LEANS, STICKS)]) for touch in touches]
        self._impulses = [impulses for impulses, _ in known]
        self._modes = [mode for _, mode in known]
        self._touches = touches

    @property
    def modes(self) -> tuple[tuple[float, float], ...]:
        """What each wall does: (AWAY or LEANS, STICKS or +-SLIDES)."""
        return tuple(self._modes)

    @property
    def impulses_ns(self) -> list[tuple[float, float]]:
        """What each wall gave the body in the last step: along its normal, and along the normal turned left."""
        return list(self._impulses)

    def push_ns(self) -> Row:
        """All of that together: (x, y, moment)."""
        x = y = moment = 0.0
        for (_, nx, ny, _), (normal, tangent) in zip(self._touches, self._impulses, strict=True):
            x += nx * normal - ny * tangent
            y += ny * normal + nx * tangent
            moment -= self._radius * tangent
        return x, y, moment

    def lean(self, px: float, py: float, pw: float, inverse: Matrix, freedoms: int) -> Row | None:
        """The momentum with the walls' impulses in it, their modes as they are; None where an impulse denies its mode.

        `inverse` turns momentum into velocity with the floor's modes, which leave the body so many `freedoms`. Where a
        row is already held by others (a robot between a wall and wheels that stand), its impulse stays as it was.
        """
        self._denied.clear()
        rows: list[tuple[Row, float]] = []
        pushes: list[Row] = []
        radius = self._radius
        for (_, nx, ny, friction), (normal, tangent), (leans, slides) in zip(
            self._touches, self._impulses, self._modes, strict=True
        ):
            if not leans:
                continue
            sliding = slides * friction
            if slides:
                tangent = sliding * normal
            px += nx * normal - ny * tangent
            py += ny * normal + nx * tangent
            pw -= radius * tangent
            rows.append(((nx, ny, 0.0), self._per_mass))
            pushes.append((nx - ny * sliding, ny + nx * sliding, -radius * sliding))
            if not slides:
                rows.append(((-ny, nx, -radius), 1.0 / self._per_tangent))
                pushes.append((-ny, nx, -radius))
        changes, independent = [0.0] * len(rows), 0
        if freedoms:
            changes, independent = _changes(rows, pushes, (px, py, pw), inverse)
        self.held = independent == freedoms
        return self._within(changes, (px, py, pw), pushes)

    def agree(self, vx: float, vy: float, omega: float) -> bool:
        """Whether no body with this velocity moves into a wall or slides against the way it is rubbed."""
        for (_, nx, ny, friction), (leans, slides) in zip(self._touches, self._modes, strict=True):
            if not leans:
                if nx * vx + ny * vy < -HELD_MPS:
                    return False
                continue
            if not -HELD_MPS < nx * vx + ny * vy < HELD_MPS:
                return False
            if slides and friction and (nx * vy - ny * vx - self._radius * omega) * slides > ROUNDING_MPS:
                return False
        return True

    def relent(self) -> bool:
        """Give the walls whose impulses denied their mode in the last `lean` the one that the impulse asks for.

        False where none did. Rows that all but say the same (a wall just beside a wheel's axis) would take sweeps by
        the thousand to find out which of them has to let go.
        """
        for i, mode in self._denied:
            self._modes[i] = mode
        return bool(self._denied)

    def keep(self) -> None:
        """The impulses of the last `lean` are those of this step."""
        self._impulses = self._tried

    def sweep(self, vx: float, vy: float, omega: float) -> tuple[float, float, float, float]:
        """Solve each row in turn, the others as they are. The velocity after it, and the largest change of a speed."""
        per_mass, per_yaw, radius = self._per_mass, self._per_yaw, self._radius
        largest = 0.0
        for i, (_, nx, ny, friction) in enumerate(self._touches):
            normal, tangent = self._impulses[i]
            new = normal - (nx * vx + ny * vy) / per_mass
            leans = LEANS
            if new <= 0.0:
                new, leans = 0.0, AWAY
            change = new - normal
            vx += nx * change * per_mass
            vy += ny * change * per_mass
            largest = max(largest, abs(change) * per_mass)

            limit = friction * new
            rubs, slides = tangent - (nx * vy - ny * vx - radius * omega) * self._per_tangent, STICKS
            if rubs >= limit:
                rubs, slides = limit, SLIDES
            elif rubs <= -limit:
                rubs, slides = -limit, -SLIDES
            change = rubs - tangent
            vx -= ny * change * per_mass
            vy += nx * change * per_mass
            omega -= radius * change * per_yaw
            largest = max(largest, abs(change) / self._per_tangent)
            self._impulses[i] = new, rubs
            self._modes[i] = leans, slides if leans else STICKS
        return vx, vy, omega, largest

    def _within(self, changes: Sequence[float], momentum: Row, pushes: Sequence[Row]) -> Row | None:
        """Add the changes to impulses and momentum, unless a wall would pull or rub more than it can."""
        px, py, pw = momentum
        for change, (x, y, moment) in zip(changes, pushes, strict=True):
            px += x * change
            py += y * change
            pw += moment * change
        rest = iter(changes)
        tried = []
        for i, (leans, slides) in enumerate(self._modes):
            normal, tangent = self._impulses[i]
            friction = self._touches[i][3]
            if not leans:
                tried.append((0.0, 0.0))
                continue
            normal += next(rest)
            if slides:
                tangent = slides * friction * normal
            else:
                tangent += next(rest)
            if normal < 0.0:
                self._denied.append((i, (AWAY, STICKS)))
            elif not slides and abs(tangent) > friction * normal:
                self._denied.append((i, (LEANS, math.copysign(SLIDES, tangent))))
            tried.append((normal, tangent))
        if self._denied:
            return None
        self._tried = tried
        return px, py, pw


def _changes(
    rows: Sequence[tuple[Row, float]], pushes: Sequence[Row], momentum: Row, inverse: Matrix
) -> tuple[list[float], int]:
    """Impulses along the pushes that bring the speeds along the rows to zero; and how many rows that took.

    A row comes with its inverse mass on a free body. Rows that others hold already get no impulse.
    """
    velocity = times(inverse, momentum)
    count = len(rows)
    system = []
    for row, _ in rows:
        x, y, w = times(inverse, row)  # symmetric
        system.append([x * push[0] + y * push[1] + w * push[2] for push in pushes] + [-dot(row, velocity)])
    solved = []
    for i, (_, free) in enumerate(rows):
        pivot = system[i][i]
        if abs(pivot) <= DEPENDENT_BELOW * free:  # may be negative: rubbing can push a body that others guide
            continue
        solved.append(i)
        for k in range(count):
            if k != i:
                share = system[k][i] / pivot
                system[k] = [a - share * b for a, b in zip(system[k], system[i], strict=True)]
    changes = [0.0] * count
    for i in solved:
        changes[i] = system[i][count] / system[i][i]
    return changes, len(solved)
