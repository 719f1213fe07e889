"""What each wheel on the floor may be doing, and the linear system that the body is under while all of them do so.

A wheel's drive STANDS, ROLLS or SLIPS, its rolling loss HOLDS or SLIDES (the laws: `contact`). With these modes given,
momentum -> velocity is one 3 x 3 matrix. It depends on the modes and the floor alone, so it is worked out once for each
combination that a drive meets, together with all else that a step reads of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from bench.ground.linear import ZERO, Matrix, dot, resisted, times
from bench.kinematics import Row

MAX_LAYOUTS = 4096
"""Combinations of modes whose systems are kept. Three wheels have at most 3375, and a drive uses some 70."""
DEPENDENT_BELOW = 1e-9
"""A fixed row whose inverse mass is below this share of its free value is already held by the rows before it."""

STANDS, ROLLS, SLIPS = 0.0, 1.0, 2.0
"""Drive modes. The sign of ROLLS is that of the contact's speed along a, the sign of SLIPS that of the impulse."""
HOLDS, SLIDES = 0.0, 1.0
"""Rolling-loss modes. The sign of SLIDES is that of the contact's speed across a."""

Mode: TypeAlias = tuple[float, float]
"""Drive mode and rolling-loss mode of one wheel."""
WheelRow: TypeAlias = tuple[float, float, float, float, float, float, float, float]
"""Of one wheel: ax, ay (its roller axis), arm (p x a), arm_across (p x b, with b = (-ay, ax)), rc, 1 / rc, its inertia
as the floor feels it (J / rc^2), 1 / J."""
WheelState: TypeAlias = tuple[float, float, float]
"""Of one wheel in one step: momentum N m s, dry friction limit N m s, load on the floor N s."""
Impulses: TypeAlias = tuple[float, float]
"""What the floor gave the body through one wheel in one step, N s: along the roller axis, across it."""
Floor: TypeAlias = tuple[float, float]
"""Under one wheel: grip, rolling loss, each as a share of the load."""
Push: TypeAlias = tuple[int, float, float, float, float, float, float, float]
"""Wheel, drive mode; what the body gets (x, y, yaw) for each N m s that drives a wheel, and for each N s of load."""
Fixed: TypeAlias = tuple[tuple[Row, Row], float, float]
"""Momentum -> minus the impulses (along, across) of fixed rows; rc; 1 / J."""
Check: TypeAlias = tuple[int, float, float, float, float, float, float, float, float, float, float, Fixed]
"""Wheel, modes, ax, ay, arm, arm_across, 1 / rc if it rolls, inertia, grip, rolling loss (signed if it slides)."""
Keep: TypeAlias = tuple[int, bool, bool, float, float, float, float]
"""Wheel, whether its drive stands, whether its loss holds, ax, ay, arm, arm_across."""


class Layout(NamedTuple):
    """All that a step reads of one combination of modes; the lists have a row for each wheel, `keeps` for some."""

    inverse: Matrix
    """Momentum -> velocity."""
    freedoms: int
    """Directions in which the body can still move: 0 to 3."""
    pushes: list[Push]
    checks: list[Check]
    keeps: list[Keep]


class Layouts:
    """The systems of one base on a floor, by modes."""

    __slots__ = ("_floor", "_free", "_known", "_rows")

    def __init__(
        self, rows: Sequence[WheelRow], floor: Sequence[Floor], mass_kg: float, yaw_inertia_kgm2: float
    ) -> None:
        self._rows = rows
        self._free: Matrix = (1.0 / mass_kg, 0.0, 0.0), (0.0, 1.0 / mass_kg, 0.0), (0.0, 0.0, 1.0 / yaw_inertia_kgm2)
        self._floor = floor
        self._known: dict[tuple[Mode, ...], Layout] = {}

    def stand_on(self, floor: Sequence[Floor]) -> None:
        """Another floor: what was known of the old one goes."""
        self._floor = floor
        self._known.clear()

    def of(self, modes: Sequence[Mode]) -> Layout:
        """What a step reads with these modes, in wheel order."""
        key = tuple(modes)
        layout = self._known.get(key)
        if layout is None:
            if len(self._known) >= MAX_LAYOUTS:
                self._known.clear()
            layout = self._known[key] = self._lay_out(key)
        return layout

    def _lay_out(self, modes: tuple[Mode, ...]) -> Layout:
        shape = tuple((abs(drive), abs(roll)) for drive, roll in modes)  # no sign enters the inverse
        inverse, reactions, freedoms = self._invert(shape)
        pushes: list[Push] = []
        checks: list[Check] = []
        keeps: list[Keep] = []
        for wheel, ((drive, roll), row, (grip, rolling), reaction) in enumerate(
            zip(modes, self._rows, self._floor, reactions, strict=True)
        ):
            ax, ay, arm, arm_across, rc, per_rc, stiffness, per_inertia = row
            driven = per_rc if abs(drive) == ROLLS else 0.0
            slipping = drive / SLIPS * grip if abs(drive) == SLIPS else 0.0
            sliding = -roll * rolling
            per_load = (
                ax * slipping - ay * sliding,
                ay * slipping + ax * sliding,
                arm * slipping + arm_across * sliding,
            )
            pushes.append((wheel, drive, ax * driven, ay * driven, arm * driven, *per_load))
            checks.append(
                # In the place of the impulse while it slides, the limit of one that holds.
                (wheel, drive, roll, ax, ay, arm, arm_across, driven, stiffness, grip, sliding if roll else rolling,
                 (reaction, rc, per_inertia))
            )  # fmt: skip
            if drive == STANDS or roll == HOLDS:
                keeps.append((wheel, drive == STANDS, roll == HOLDS, ax, ay, arm, arm_across))
        return Layout(inverse, freedoms, pushes, checks, keeps)

    def _invert(self, shape: tuple[Mode, ...]) -> tuple[Matrix, list[tuple[Row, Row]], int]:
        """Momentum -> velocity with these modes; for each wheel, momentum -> minus the impulses of fixed rows; and
        how many freedoms the fixed rows leave the body.
        """
        free = self._free
        drives: list[tuple[int, int, Row]] = []
        losses: list[tuple[int, int, Row]] = []
        for wheel, ((ax, ay, arm, arm_across, _, _, stiffness, _), (drive, roll)) in enumerate(
            zip(self._rows, shape, strict=True)
        ):
            if drive == ROLLS:
                free = resisted(free, (ax, ay, arm), 1.0 / stiffness)
            elif drive == STANDS:
                drives.append((wheel, 0, (ax, ay, arm)))
            if roll == HOLDS:
                losses.append((wheel, 1, (-ay, ax, arm_across)))

        inverse = free
        carrying: list[tuple[int, int, Row]] = []
        for entry in drives + losses:
            row = entry[2]
            if dot(row, times(inverse, row)) > DEPENDENT_BELOW * dot(row, times(free, row)):
                inverse = resisted(inverse, row, 0.0)
                carrying.append(entry)
        if len(carrying) == 3:
            inverse = (ZERO, ZERO, ZERO)

        reactions = [[ZERO, ZERO] for _ in shape]
        for number, (wheel, which, row) in enumerate(carrying):
            others = free
            for _, _, other in carrying[:number] + carrying[number + 1 :]:
                others = resisted(others, other, 0.0)
            x, y, w = times(others, row)
            size = dot(row, (x, y, w))
            reactions[wheel][which] = (x / size, y / size, w / size)
        return inverse, [(along, across) for along, across in reactions], 3 - len(carrying)
