"""The floor under a base on omni or mecanum wheels: one step of Coulomb friction with true stick, solved exactly.

What enters: the body's velocity and, for each wheel, its momentum, its dry friction and its load. What leaves: the
body's velocity and the wheel speeds at the end of the step, and the impulses in between. No engine, no motor, no clock.

The floor pushes the body along a wheel's roller axis a (drive) and against its rolling across it. The wheel has a motor
and gear with dry friction behind it. With the wheel's momentum W (motor torque included), its dry friction limit phi,
its inertia J (the viscous friction of the step included, which makes that implicit) and u the speed of the contact
along a, the drive impulse is a falling, piecewise linear function of u, vertical where the wheel stands and flat where
the grip ends:

    STANDS  u = 0, wheel at rest               lambda anywhere with |W - rc lambda| <= phi
    ROLLS   lambda = (W -+ phi)/rc - u J/rc^2  wheel and floor move together; phi acts against that motion
    SLIPS   lambda = +- grip limit             against the slip; the wheel's speed follows from W and lambda

The rolling loss is a plain box: HOLDS (q = 0) or SLIDES (+- limit, against the speed q across a). Exactly one velocity
satisfies all rows. Modes rarely change from one step to the next, and with the modes given the problem is linear in
three unknowns, with an inverse that depends on the modes alone and is kept. So a step multiplies by the inverse of the
last modes and checks that every row agrees with its mode. Where one does not, projected Gauss-Seidel over all rows,
started from the last impulses, finds the new modes.

Walls that the base leans on (`walls`) are further rows of the same system; without one not a bit is another.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from bench.config import Ground, Wheel
from bench.kinematics import Kinematics, Row
from bench.messages import ZERO_TWIST, BodyTwist
from bench.walls import WallRows

TOLERANCE_MPS = 1e-12
"""Sweeps end with the one in which no row changed its contact speed by more, if the modes did not settle it before."""
MAX_SWEEPS = 1000
"""Cap of the sweeps of one step, so that a step's work is bounded. The last sweep's result is then used as it is."""
MAX_WALL_SWEEPS = 250
"""The same at a wall. What a capped step leaves (some 1e-5 m/s into the wall) the engine and the next step take."""
MAX_LAYOUTS = 4096
"""Combinations of modes whose inverses are kept. Three wheels have at most 3375, and a drive uses some 70."""
DEPENDENT_BELOW = 1e-9
"""A fixed row whose inverse mass is below this share of its free value is already held by the rows before it."""

RECENT_MODES = 4
"""Modes of earlier steps that are tried before sweeping. One saves most sweeps of a base on three wheels, four of one
on four, where more rows change at a time; a failed trial costs less than two sweeps."""

STANDS, ROLLS, SLIPS = 0.0, 1.0, 2.0
"""Drive modes. The sign of ROLLS is that of u, the sign of SLIPS that of the impulse."""
HOLDS, SLIDES = 0.0, 1.0
"""Rolling-loss modes. The sign of SLIDES is that of q."""

Mode: TypeAlias = tuple[float, float]
"""Drive mode and rolling-loss mode of one wheel."""
WheelState: TypeAlias = tuple[float, float, float]
"""Of one wheel in one step: momentum N m s, dry friction limit N m s, load on the floor N s."""
Impulses: TypeAlias = tuple[float, float]
"""What the floor gave the body through one wheel in one step, N s: along the roller axis, across it."""
Matrix: TypeAlias = tuple[Row, Row, Row]
_Push: TypeAlias = tuple[int, float, float, float, float, float, float, float]
_Fixed: TypeAlias = tuple[tuple[Row, Row], float, float]
_Check: TypeAlias = tuple[int, float, float, float, float, float, float, float, float, float, float, _Fixed]
_Keeps: TypeAlias = tuple[int, bool, bool, float, float, float, float]
_Layout: TypeAlias = tuple[Matrix, int, list[_Push], list[_Check], list[_Keeps]]
"""What `_direct` and `_adopt` read with certain modes: the inverse, the freedoms left, and a row for each wheel."""
_ZERO: Row = (0.0, 0.0, 0.0)


class Contact:
    """The wheels of one base on the floor.

    `wheel_inertia_kgm2` is that of wheel, motor and gear plus viscous friction times the length of a step.
    """

    __slots__ = (
        "_checks",
        "_floor",
        "_freedoms",
        "_inverse",
        "_kept",
        "_kept_ns",
        "_layouts",
        "_mass",
        "_modes",
        "_pushes",
        "_recent",
        "_rows",
        "_sweep_rows",
        "_yaw_inertia",
        "impulses_ns",
        "speeds_radps",
        "sweeps",
    )  # fmt: skip

    def __init__(
        self,
        wheels: Sequence[Wheel],
        ground: Ground,
        mass_kg: float,
        yaw_inertia_kgm2: float,
        wheel_inertia_kgm2: float,
        twist: BodyTwist = ZERO_TWIST,
    ) -> None:
        kinematics = Kinematics(wheels)
        self._mass, self._yaw_inertia = mass_kg, yaw_inertia_kgm2
        self._floor = [(ground.grip, ground.rolling)] * len(wheels)
        self._rows = []
        self._sweep_rows = []
        for wheel, (ax, ay, arm), rc in zip(wheels, kinematics.axes, kinematics.radii, strict=True):
            arm_across = wheel.x_m * ax + wheel.y_m * ay  # p x b, with b = (-ay, ax)
            stiffness = wheel_inertia_kgm2 / (rc * rc)
            self._rows.append((ax, ay, arm, arm_across, rc, 1.0 / rc, stiffness, 1.0 / wheel_inertia_kgm2))
            along = 1.0 / mass_kg + arm * arm / yaw_inertia_kgm2
            across = 1.0 / mass_kg + arm_across * arm_across / yaw_inertia_kgm2
            self._sweep_rows.append((along, across, 1.0 / (1.0 + stiffness * along)))
        self.speeds_radps = kinematics.wheel_speeds(twist)
        """Wheel speeds at the end of the last step; rolling with `twist` before the first."""
        self.impulses_ns: list[Impulses] = [(0.0, 0.0)] * len(wheels)
        self.sweeps = 0
        """Gauss-Seidel sweeps of the last step: 0 where the last modes, or those before them, still held."""
        self._kept_ns = list(self.impulses_ns)
        self._layouts: dict[tuple[Mode, ...], _Layout] = {}
        self._adopt([(STANDS, HOLDS)] * len(wheels), self.impulses_ns)
        self._recent: list[Sequence[Mode]] = []

    def solve(
        self, vx: float, vy: float, omega: float, wheels: Sequence[WheelState], walls: WallRows | None = None
    ) -> Row:
        """Body velocity (vx, vy, omega), in a frame that stands still during the step, before -> after the step."""
        self.sweeps = 0
        return self._direct(vx, vy, omega, wheels, walls) or self._search(vx, vy, omega, wheels, walls)

    def stand_on(self, floor: Sequence[tuple[float, float]]) -> None:
        """From now on each wheel stands on a floor of this grip and rolling loss, in wheel order."""
        if list(floor) != self._floor:
            self._floor = list(floor)
            self._layouts.clear()
            self._adopt(self._modes, self.impulses_ns)

    def slips_mps(self, vx: float, vy: float, omega: float) -> list[float]:
        """Along each roller axis: the body's speed over the floor minus what the wheel rolls."""
        return [
            ax * vx + ay * vy + arm * omega - rc * speed
            for (ax, ay, arm, _, rc, *_), speed in zip(self._rows, self.speeds_radps, strict=True)
        ]

    def _direct(
        self, vx: float, vy: float, omega: float, wheels: Sequence[WheelState], walls: WallRows | None
    ) -> Row | None:
        """The step with the modes as they are, or None if a row does not agree with its mode."""
        # The bench's hottest lines: to pair two lists of three with zip would cost as much as a wheel's arithmetic.
        px, py, pw = self._kept
        px += self._mass * vx
        py += self._mass * vy
        pw += self._yaw_inertia * omega
        for wheel, way, tx, ty, tw, nx, ny, nw in self._pushes:
            momentum, dry, load = wheels[wheel]
            driven = momentum - way * dry
            px += tx * driven + nx * load
            py += ty * driven + ny * load
            pw += tw * driven + nw * load
        if walls is not None:
            leaning = walls.lean(px, py, pw, self._inverse, self._freedoms)
            if leaning is None:
                return None
            px, py, pw = leaning

        (ixx, ixy, ixw), (_, iyy, iyw), (_, _, iww) = self._inverse
        new_vx = ixx * px + ixy * py + ixw * pw
        new_vy = ixy * px + iyy * py + iyw * pw
        new_omega = ixw * px + iyw * py + iww * pw
        if walls is not None:
            if walls.held:
                new_vx = new_vy = new_omega = 0.0  # what is left is rounding
            if not walls.agree(new_vx, new_vy, new_omega):
                return None

        speeds = []
        impulses = []
        for wheel, drive, roll, ax, ay, arm, arm_across, per_rc, stiffness, grip, sliding, fixed in self._checks:
            momentum, dry, load = wheels[wheel]
            grip *= load
            if per_rc:  # is 0 unless the wheel rolls
                u = ax * new_vx + ay * new_vy + arm * new_omega
                along = (momentum - drive * dry) * per_rc - stiffness * u
                if u * drive < 0.0 or along > grip or along < -grip:
                    return None
                speed = u * per_rc
            elif drive:
                _, rc, per_inertia = fixed
                along = grip if drive > 0.0 else -grip
                speed = _free_speed(momentum - rc * along, dry, per_inertia)
                if (ax * new_vx + ay * new_vy + arm * new_omega - rc * speed) * drive > 0.0:
                    return None
            else:
                ((hx, hy, hw), _), rc, _ = fixed
                along = self._kept_ns[wheel][0] - (hx * px + hy * py + hw * pw)
                if not (-grip <= along <= grip and -dry <= momentum - rc * along <= dry):
                    return None
                speed = 0.0
            if roll:
                if (ax * new_vy - ay * new_vx + arm_across * new_omega) * roll < 0.0:
                    return None
                across = sliding * load
            else:
                (_, (hx, hy, hw)), _, _ = fixed
                across = self._kept_ns[wheel][1] - (hx * px + hy * py + hw * pw)
                if abs(across) > sliding * load:
                    return None
            speeds.append(speed)
            impulses.append((along, across))
        self.speeds_radps = speeds
        self.impulses_ns = impulses
        if walls is not None:
            walls.keep()
        return new_vx, new_vy, new_omega

    def _search(self, vx: float, vy: float, omega: float, wheels: Sequence[WheelState], walls: WallRows | None) -> Row:
        """Sweep over the rows, each in turn solved exactly with the others as they are, until the modes are found."""
        start = vx, vy, omega
        impulses = self.impulses_ns
        recent, failed = self._recent, self._modes
        if failed in recent:
            recent.remove(failed)
        if walls is None:  # a wheel at the edge of a mode goes to and fro
            for held_before in recent:
                self._adopt(held_before, impulses)
                found = self._direct(*start, wheels, walls)
                if found:
                    recent.remove(held_before)
                    recent.insert(0, failed)
                    return found
        recent.insert(0, failed)
        del recent[RECENT_MODES:]
        per_mass, per_yaw = 1.0 / self._mass, 1.0 / self._yaw_inertia
        for (ax, ay, arm, arm_across, *_), (along, across) in zip(self._rows, impulses, strict=True):
            vx += (ax * along - ay * across) * per_mass
            vy += (ay * along + ax * across) * per_mass
            omega += (arm * along + arm_across * across) * per_yaw
        if walls is not None:
            px, py, pw = walls.push_ns()
            vx += px * per_mass
            vy += py * per_mass
            omega += pw * per_yaw
        # A spin on the spot takes hundreds of sweeps: what does not change from one to the next is worked out before.
        prepared = [
            (
                *row[:4], k, k_across, row[6], softened, (momentum - dry) * row[5], (momentum + dry) * row[5],
                most_grip * load, -(most_grip * load), most_loss * load, -(most_loss * load),
            )
            for row, (k, k_across, softened), (most_grip, most_loss), (momentum, dry, load) in zip(
                self._rows, self._sweep_rows, self._floor, wheels, strict=True
            )
        ]  # fmt: skip
        modes: list[Mode] = []
        tried: list[Mode] = []
        for sweep in range(1, (MAX_SWEEPS if walls is None else MAX_WALL_SWEEPS) + 1):
            self.sweeps = sweep
            modes = []
            solved = []
            largest = 0.0
            if walls is not None:  # first, so that the wheels find the body where it is held
                vx, vy, omega, largest = walls.sweep(vx, vy, omega)
            for (
                (ax, ay, arm, arm_across, k, k_across, stiffness, softened, forth, back, grip, no_grip, loss, no_loss),
                (along, across),
            ) in zip(prepared, impulses, strict=True):
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
                solved.append((new, new_across))
            impulses = solved
            # Sweeps have the modes long before they have the numbers; the inverse then has the numbers at once.
            # Modes that it denied may hold later: sweeps move impulses between rows that the body cannot tell apart
            # (a spin on the spot of four wheels), and a wall's impulse grows.
            again = sweep & (sweep - 1) == 0 if walls is None else sweep <= 8 or sweep % 16 == 0
            if modes != tried or again:
                tried = modes
                self._adopt(modes, impulses)
                found = self._direct(*start, wheels, walls)
                while not found and walls is not None and walls.relent():
                    found = self._direct(*start, wheels, walls)
                if found:
                    return found
            if largest <= TOLERANCE_MPS:
                break

        self._adopt(modes, impulses)
        self.impulses_ns = impulses
        if all(drive == STANDS for drive, _ in modes):
            vx = vy = omega = 0.0  # three independent drive rows at rest leave the body nothing but rounding
        self.speeds_radps = []
        for row, (drive, _), (momentum, dry, _), (along, _) in zip(self._rows, modes, wheels, impulses, strict=True):
            ax, ay, arm, _, rc, per_rc, _, per_inertia = row
            if drive == STANDS:
                speed = 0.0
            elif abs(drive) == ROLLS:
                speed = (ax * vx + ay * vy + arm * omega) * per_rc
            else:
                speed = _free_speed(momentum - rc * along, dry, per_inertia)
            self.speeds_radps.append(speed)
        return vx, vy, omega

    def _adopt(self, modes: Sequence[Mode], impulses: Sequence[Impulses]) -> None:
        """Make these the modes that are tried first. Fixed rows keep the impulses that they have now.

        Where more rows are fixed than the body has freedoms, the surplus ones keep theirs for good; what changes is
        carried by the others.
        """
        self._modes = modes
        key = tuple(modes)
        layout = self._layouts.get(key)
        if layout is None:
            if len(self._layouts) >= MAX_LAYOUTS:
                self._layouts.clear()
            layout = self._layouts[key] = self._lay_out(key)
        self._inverse, self._freedoms, self._pushes, self._checks, fixed = layout
        px = py = pw = 0.0
        for wheel, keeps_along, keeps_across, ax, ay, arm, arm_across in fixed:
            along, across = self._kept_ns[wheel] = impulses[wheel]
            if not keeps_along:
                along = 0.0
            if not keeps_across:
                across = 0.0
            px += ax * along - ay * across
            py += ay * along + ax * across
            pw += arm * along + arm_across * across
        self._kept = px, py, pw

    def _lay_out(self, modes: tuple[Mode, ...]) -> _Layout:
        """What `_direct` reads with these modes on this floor."""
        shape = tuple((abs(drive), abs(roll)) for drive, roll in modes)  # no sign enters the inverse
        inverse, reactions, freedoms = self._invert(shape)
        pushes, checks, fixed = [], [], []
        for wheel, ((drive, roll), row, (grip, rolling), reaction) in enumerate(
            zip(modes, self._rows, self._floor, reactions, strict=True)
        ):
            ax, ay, arm, arm_across, rc, per_rc, stiffness, per_inertia = row
            # What the body gets for each N m s that drives a rolling wheel, and for each N s of load.
            driven = per_rc if abs(drive) == ROLLS else 0.0
            slipping = drive / SLIPS * grip if abs(drive) == SLIPS else 0.0
            sliding = -roll * rolling
            pushes.append(
                (
                    wheel,
                    drive,
                    ax * driven,
                    ay * driven,
                    arm * driven,
                    ax * slipping - ay * sliding,
                    ay * slipping + ax * sliding,
                    arm * slipping + arm_across * sliding,
                )
            )
            checks.append(
                # In the place of the impulse while it slides, the limit of one that holds.
                (wheel, drive, roll, ax, ay, arm, arm_across, driven, stiffness, grip, sliding if roll else rolling,
                 (reaction, rc, per_inertia))
            )  # fmt: skip
            if drive == STANDS or roll == HOLDS:
                fixed.append((wheel, drive == STANDS, roll == HOLDS, ax, ay, arm, arm_across))
        return inverse, freedoms, pushes, checks, fixed

    def _invert(self, shape: tuple[Mode, ...]) -> tuple[Matrix, list[tuple[Row, Row]], int]:
        """Momentum -> velocity with these modes; for each wheel, momentum -> minus the impulses of fixed rows; and
        how many freedoms the fixed rows leave the body.
        """
        free = ((1.0 / self._mass, 0.0, 0.0), (0.0, 1.0 / self._mass, 0.0), (0.0, 0.0, 1.0 / self._yaw_inertia))
        drives: list[tuple[int, int, Row]] = []
        losses: list[tuple[int, int, Row]] = []
        for wheel, ((ax, ay, arm, arm_across, _, _, stiffness, _), (drive, roll)) in enumerate(
            zip(self._rows, shape, strict=True)
        ):
            if drive == ROLLS:
                free = _held(free, (ax, ay, arm), 1.0 / stiffness)
            elif drive == STANDS:
                drives.append((wheel, 0, (ax, ay, arm)))
            if roll == HOLDS:
                losses.append((wheel, 1, (-ay, ax, arm_across)))

        inverse = free
        carrying: list[tuple[int, int, Row]] = []
        for entry in drives + losses:
            row = entry[2]
            if _dot(row, _times(inverse, row)) > DEPENDENT_BELOW * _dot(row, _times(free, row)):
                inverse = _held(inverse, row, 0.0)
                carrying.append(entry)
        if len(carrying) == 3:
            inverse = (_ZERO, _ZERO, _ZERO)

        reactions = [[_ZERO, _ZERO] for _ in shape]
        for entry in carrying:
            wheel, which, row = entry
            others = free
            for other in carrying:
                if other is not entry:
                    others = _held(others, other[2], 0.0)
            x, y, w = _times(others, row)
            size = _dot(row, (x, y, w))
            reactions[wheel][which] = (x / size, y / size, w / size)
        return inverse, [(along, across) for along, across in reactions], 3 - len(carrying)


def _free_speed(momentum: float, dry: float, per_inertia: float) -> float:
    """Wheel speed once dry friction has taken what it can from the momentum."""
    if momentum > dry:
        return (momentum - dry) * per_inertia
    if momentum < -dry:
        return (momentum + dry) * per_inertia
    return 0.0


def _dot(a: Row, b: Row) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _times(matrix: Matrix, row: Row) -> Row:
    return _dot(matrix[0], row), _dot(matrix[1], row), _dot(matrix[2], row)


def _held(inverse: Matrix, row: Row, compliance: float) -> Matrix:
    """The inverse mass once motion along a row is resisted with this compliance (0: not possible any more)."""
    x, y, w = _times(inverse, row)
    size = compliance + _dot(row, (x, y, w))
    (xx, xy, xw), (_, yy, yw), (_, _, ww) = inverse
    xy, xw, yw = xy - x * y / size, xw - x * w / size, yw - y * w / size
    return (xx - x * x / size, xy, xw), (xy, yy - y * y / size, yw), (xw, yw, ww - w * w / size)
