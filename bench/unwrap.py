"""What a rotor has turned between two of its reports, whole turns included, when some between them were lost or late.

An angle of 8192 counts says nothing of whole turns. Below 30,000 rpm a rotor turns less than half a turn in a
millisecond, so reports born a tick apart need no more than the shorter way round. Over a longer gap the reported speed
says how many turns it were. It lags: the ESC shows y, its rotor's speed x behind a first-order filter of known share,

    y[n] = y[n-1] + share (x[n] - y[n-1]),   hence over a gap   sum x = sum y + (y[end] - y[begin]) / share

which is exact, but only both ends of y are known. Their mean in place of those between predicts the way. Nothing turns
a rotor but its motor and the floor, both of limited torque, so x has a slope of at most `a`; and what a motion of such
slopes can add up to beside the prediction is a times `stray_ms2` and no more (its worst case exists, and
tests/test_unwrap.py drives it). While that and NOISE_COUNTS are less than half a turn, the whole turns are known.

    m2006:   a = 0.0015 turns/ms^2   known up to 37 ticks           bench/robots, all of them: tests/test_unwrap.py

How long a gap was is not always known: a report may be late. `Births` keeps in which ticks each wheel's last report may
have been born. The way is known where all gaps that agree with the reported speed agree on it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple, Protocol

from bench.canbus.c610 import COUNTS
from bench.config import Robot, Wheel
from bench.ground.loads import GRAVITY_MPS2, load_rows

HALF_TURN = COUNTS // 2
COUNTS_PER_RPM_TICK = COUNTS / 60_000.0
NOISE_COUNTS = COUNTS // 32
"""Allowed beside the bound: angles that are off by up to 128 counts at both ends, rpm cut to whole numbers."""
MOST_GRIP = 1.5
"""No rubber holds better on any floor. Files of more mean a floor on which nothing slips."""
PASSIVE_GAP_TICKS = 72
"""For as long an encoder without gear, below 417 rpm (1.1 m/s on a radius of 25 mm), turns less than half a turn."""
CALM_TICKS = 50
"""So many ticks in a row, each with one report of every wheel: none is late, or all alike, which is as good."""


class Way(NamedTuple):
    """What a rotor has turned, in counts, and between how many ticks before and after that may have been born."""

    counts: int
    least_ticks: int
    most_ticks: int


class Unwrap(Protocol):
    """Decides how far a rotor came."""

    def way(self, wheel: int, apart: int, rpms: tuple[int, int], gaps: range) -> Way | None:
        """The way of this wheel's rotor over one of these gaps, in ticks, with its angle `apart` counts further, the
        speeds reported at both ends; None where it could be another one by whole turns.
        """
        ...


class BySpeed:
    """By the speed that the rotors of a robot's driven wheels report."""

    def __init__(self, robot: Robot) -> None:
        self._share = filter_share(robot.motor.speed_filter_ms)
        # The share of a speed's last change that its sum over a gap has beyond the mean of both ends.
        self._lag_ticks = 1.0 / self._share - 0.5
        self.slopes = tuple(COUNTS * most for most in steepest_turns_per_ms2(robot))
        """Counts/ms^2, for each wheel."""

    def way(self, wheel: int, apart: int, rpms: tuple[int, int], gaps: range) -> Way | None:
        """See `Unwrap`."""
        before, after = rpms[0] * COUNTS_PER_RPM_TICK, rpms[1] * COUNTS_PER_RPM_TICK
        mean, lag, slope = 0.5 * (before + after), self._lag_ticks * (after - before), self.slopes[wheel]
        found: Way | None = None
        for gap in gaps:
            stray = slope * stray_ms2(gap, self._share) + NOISE_COUNTS
            if stray >= HALF_TURN:
                return None
            ahead = gap * mean + lag
            counts = apart + COUNTS * round((ahead - apart) / COUNTS)
            if abs(counts - ahead) > stray:
                continue
            if found is None:
                found = Way(counts, gap, gap)
            elif found.counts == counts:
                found = found._replace(most_ticks=gap)
            else:
                return None
        return found

    def longest_ticks(self, wheel: int) -> int:
        """The longest gap over which this wheel's whole turns are known."""
        gap = 1
        while self.slopes[wheel] * stray_ms2(gap + 1, self._share) + NOISE_COUNTS < HALF_TURN:
            gap += 1
        return gap


class ByShorterWay:
    """The shorter way round, for encoders that are slow: what carries no motor may be stopped at once by a wall."""

    def __init__(self, wheels: Iterable[Wheel]) -> None:
        self._longest = tuple(max(1, int(PASSIVE_GAP_TICKS / wheel.gear)) for wheel in wheels)

    def way(self, wheel: int, apart: int, rpms: tuple[int, int], gaps: range) -> Way | None:
        """See `Unwrap`; speeds are not looked at."""
        return Way(apart, gaps[0], gaps[-1]) if gaps[-1] <= self._longest[wheel] else None


class Births:
    """In which ticks each wheel's last report may have been born. Reports of one wheel keep their order, one a tick.

    A report is taken to be as late as any was seen to be, later only where its speed says so: at first not at all.
    """

    __slots__ = ("_born", "_calm", "_late")

    def __init__(self, count: int) -> None:
        self._born = [(-1, -1)] * count
        self._late = self._calm = 0

    def exactly(self, tick: int) -> None:
        """All of them were born in this tick."""
        self._born = [(tick, tick)] * len(self._born)
        self._calm = 0

    def first(self, wheel: int, born: int) -> None:
        """A wheel is heard for the first time."""
        self._born[wheel] = (born, born)

    def gaps(self, wheel: int, tick: int, behind: int) -> range:
        """The ticks that may lie between a report of this tick, with `behind` more after it, and the one before."""
        least, most = self._born[wheel]
        newest = tick - behind
        if most >= newest:  # so that one was later than it was taken to be
            most = newest - 1
            least = min(least, most)
            self._born[wheel] = least, most
        oldest = min(tick - self._late, newest)
        return range(max(1, oldest - most), newest - least + 1)

    def heard(self, wheel: int, tick: int, behind: int, least_ticks: int, most_ticks: int) -> None:
        """That report came so many ticks after the one before."""
        least, most = self._born[wheel]
        newest = min(tick - behind, most + most_ticks)
        self._late = max(self._late, tick - newest)
        self._born[wheel] = max(least + least_ticks, min(tick - self._late, newest)), newest

    def settled(self, tick: int, alone: bool) -> bool:
        """Whether every wheel's last report was born in this tick. `alone`: each brought one, and nobody else any."""
        self._calm = self._calm + 1 if alone else 0
        if self._calm >= CALM_TICKS:
            self._late = 0
            return True
        return all(born == (tick, tick) for born in self._born)


def filter_share(filter_ms: float) -> float:
    """Of a first-order filter, what comes through in a tick."""
    return 1.0 if filter_ms == 0.0 else 1.0 - math.exp(-1.0 / filter_ms)


@lru_cache(maxsize=1024)
def stray_ms2(gap_ticks: int, share: float) -> float:
    """By how much a motion of slope 1 may miss its prediction over a gap, at most.

    Way and prediction are sums over the speed's changes d[k], so is what they differ by; it is largest where every
    change is as large as may be and has the sign of its weight. Those before the gap (j ticks before its end and
    further, to the beginning of time) weigh q^j times one number; those in it, m ticks before its end, m less what the
    prediction makes of them. For a filter of 10 ms: 0.19 gap^2 after 10 ticks, 0.23 gap^2 after 50.
    """
    q = 1.0 - share
    reach = 0.5 * gap_ticks + 1.0 / share - 0.5
    passed = q**gap_ticks
    before = 0.5 * gap_ticks * (1.0 + passed) - (reach - 0.5 * gap_ticks) * (1.0 - passed)
    total = abs(before) * q / share
    for m in range(gap_ticks):
        total += abs(m - reach * (1.0 - q ** (m + 1)))
    return total


def steepest_turns_per_ms2(robot: Robot) -> list[float]:
    """By how much each rotor can change its speed: motor with all its friction, and the floor under the most load, turn
    a wheel against nothing but its own inertia. (Viscous friction has no part: it bends both ways of a motion alike.)
    """
    motor, grip, weight_n = robot.motor, min(robot.ground.grip, MOST_GRIP), robot.body.mass_kg * GRAVITY_MPS2
    slides = grip + robot.ground.rolling
    torque_nm = motor.torque_nm_per_a * (1.0 + motor.load_friction) / (1.0 - motor.load_friction)
    motor_nm = robot.limits.current_a * torque_nm + motor.coulomb_nm
    steepest = []
    rows = load_rows(robot.wheels, robot.body.mass_kg, robot.body.cog_height_m)
    for wheel, (rest_n, per_ax, per_ay) in zip(robot.wheels, rows, strict=True):
        load_n = min(weight_n, rest_n + math.hypot(per_ax, per_ay) * slides * GRAVITY_MPS2)
        torque_nm = motor_nm + slides * load_n * wheel.radius_m
        steepest.append(torque_nm / motor.inertia_kgm2 * wheel.gear / math.tau * 1e-6)
    return steepest


def shorter_way(apart: int) -> int:
    """Counts, modulo a turn, into [-4096, 4096)."""
    return (apart + HALF_TURN) % COUNTS - HALF_TURN
