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

from bench.config import Ground, Wheel
from bench.ground.modes import HOLDS, ROLLS, STANDS, Floor, Impulses, Layouts, Mode, WheelRow, WheelState
from bench.ground.sweeps import Sweeps
from bench.ground.walls import WallRows
from bench.kinematics import Kinematics, Row
from bench.messages import ZERO_TWIST, BodyTwist

TOLERANCE_MPS = 1e-12
"""Sweeps end with the one in which no row changed its contact speed by more, if the modes did not settle it before."""
MAX_SWEEPS = 1000
"""Cap of the sweeps of one step, so that a step's work is bounded. The last sweep's result is then used as it is."""
MAX_WALL_SWEEPS = 250
"""The same at a wall. What a capped step leaves (some 1e-5 m/s into the wall) the engine and the next step take."""
RECENT_MODES = 4
"""Modes of earlier steps that are tried before sweeping. One saves most sweeps of a base on three wheels, four of one
on four, where more rows change at a time; a failed trial costs less than two sweeps."""


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
        "_yaw_inertia",
        "impulses_ns",
        "inexact_steps",
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
        self._rows: list[WheelRow] = []
        for wheel, (ax, ay, arm), rc in zip(wheels, kinematics.axes, kinematics.radii, strict=True):
            arm_across = wheel.x_m * ax + wheel.y_m * ay
            stiffness = wheel_inertia_kgm2 / (rc * rc)
            self._rows.append((ax, ay, arm, arm_across, rc, 1.0 / rc, stiffness, 1.0 / wheel_inertia_kgm2))
        self._floor = [(ground.grip, ground.rolling)] * len(wheels)
        self._layouts = Layouts(self._rows, self._floor, mass_kg, yaw_inertia_kgm2)
        self.speeds_radps = kinematics.wheel_speeds(twist)
        """Wheel speeds at the end of the last step; rolling with `twist` before the first."""
        self.impulses_ns: list[Impulses] = [(0.0, 0.0)] * len(wheels)
        self.sweeps = 0
        """Gauss-Seidel sweeps of the last step: 0 where the last modes, or those before them, still held."""
        self.inexact_steps = 0
        """How many steps ended at `MAX_SWEEPS`. Beside a wall the engine takes back what is left; here nobody does."""
        self._kept_ns = list(self.impulses_ns)
        self._adopt([(STANDS, HOLDS)] * len(wheels), self.impulses_ns)
        self._recent: list[Sequence[Mode]] = []

    def solve(
        self, vx: float, vy: float, omega: float, wheels: Sequence[WheelState], walls: WallRows | None = None
    ) -> Row:
        """Body velocity (vx, vy, omega), in a frame that stands still during the step, before -> after the step."""
        self.sweeps = 0
        return self._direct(vx, vy, omega, wheels, walls) or self._search(vx, vy, omega, wheels, walls)

    def stand_on(self, floor: Sequence[Floor]) -> None:
        """From now on each wheel stands on a floor of this grip and rolling loss, in wheel order."""
        if list(floor) != self._floor:
            self._floor = list(floor)
            self._layouts.stand_on(self._floor)
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
        """Find the modes: those of earlier steps are tried first, then rows are swept."""
        recent, failed = self._recent, self._modes
        if failed in recent:
            recent.remove(failed)
        if walls is None:  # a wheel at the edge of a mode goes to and fro
            for held_before in recent:
                self._adopt(held_before, self.impulses_ns)
                found = self._direct(vx, vy, omega, wheels, walls)
                if found:
                    recent.remove(held_before)
                    recent.insert(0, failed)
                    return found
        recent.insert(0, failed)
        del recent[RECENT_MODES:]
        return self._sweep(vx, vy, omega, wheels, walls)

    def _sweep(self, vx: float, vy: float, omega: float, wheels: Sequence[WheelState], walls: WallRows | None) -> Row:
        """Sweep, and ask the inverse whenever other modes come out, until it agrees."""
        start = vx, vy, omega
        sweeps = Sweeps(start, self.impulses_ns, self._rows, self._floor, wheels, self._mass, self._yaw_inertia, walls)
        tried: list[Mode] = []
        for sweep in range(1, (MAX_SWEEPS if walls is None else MAX_WALL_SWEEPS) + 1):
            self.sweeps = sweep
            sweeps.sweep()
            # Modes that the inverse denied may hold later: sweeps move impulses between rows that the body cannot tell
            # apart (a spin on the spot of four wheels), and a wall's impulse grows.
            again = sweep & (sweep - 1) == 0 if walls is None else sweep <= 8 or sweep % 16 == 0
            if sweeps.modes != tried or again:
                tried = sweeps.modes
                self._adopt(tried, sweeps.impulses_ns)
                found = self._direct(vx, vy, omega, wheels, walls)
                while not found and walls is not None and walls.relent():
                    found = self._direct(vx, vy, omega, wheels, walls)
                if found:
                    return found
            if sweeps.largest_mps <= TOLERANCE_MPS:
                break
        else:
            self.inexact_steps += walls is None
        return self._as_swept(sweeps, wheels)

    def _as_swept(self, sweeps: Sweeps, wheels: Sequence[WheelState]) -> Row:
        """The step as the sweeps have it, where the inverse agrees with none of their modes."""
        modes, impulses = sweeps.modes, sweeps.impulses_ns
        self._adopt(modes, impulses)
        self.impulses_ns = impulses
        vx, vy, omega = sweeps.velocity
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
        self._inverse, self._freedoms, self._pushes, self._checks, keeps = self._layouts.of(modes)
        px = py = pw = 0.0
        for wheel, keeps_along, keeps_across, ax, ay, arm, arm_across in keeps:
            along, across = self._kept_ns[wheel] = impulses[wheel]
            if not keeps_along:
                along = 0.0
            if not keeps_across:
                across = 0.0
            px += ax * along - ay * across
            py += ay * along + ax * across
            pw += arm * along + arm_across * across
        self._kept = px, py, pw


def _free_speed(momentum: float, dry: float, per_inertia: float) -> float:
    """Wheel speed once dry friction has taken what it can from the momentum."""
    if momentum > dry:
        return (momentum - dry) * per_inertia
    if momentum < -dry:
        return (momentum + dry) * per_inertia
    return 0.0
