"""What the rows of state say of the body: where it is, and how much its wheels have slipped until then."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, cast

from bench.check.crosswire.way import Way, fitted
from bench.config import Robot
from bench.kinematics import Kinematics
from bench.messages import StateRow
from bench.odometry import wrap


class Body(NamedTuple):
    """The truth at the end of a tick. Slip is summed: metres and radians by which wheels and floor disagreed."""

    tick: int
    way: Way
    slip_m: float
    slip_rad: float


class Truth:
    """Takes the rows in order; `now` and `before` are the newest two.

    Slip is what the wheels' speeds, as a twist, are off the body's. Between two rows the worse of both counts: an
    estimate from above, but for what comes and goes within 10 ms.
    """

    def __init__(self, robot: Robot, columns: Sequence[str], kinematics: Kinematics) -> None:
        self._rows = kinematics.forward_rows
        self._pose = columns.index("x_m")
        self._speeds = [columns.index(f"wheel{number}_radps") for number in range(1, len(robot.wheels) + 1)]
        self._slip = (0.0, 0.0)
        self.before: Body | None = None
        self.now: Body | None = None

    def take(self, tick: int, row: StateRow) -> Body:
        """The row of a tick."""
        x_m, y_m, heading, vx, vy, omega = cast(Sequence[float], row[self._pose : self._pose + 6])
        speeds = cast(list[float], [row[place] for place in self._speeds])
        slip = 0.0, 0.0
        if vx or vy or omega or any(speeds):
            rolled_x, rolled_y, rolled_turn = fitted(self._rows, speeds)
            slip = math.hypot(rolled_x - vx, rolled_y - vy), abs(rolled_turn - omega)
        last, self.before = self.now, self.now
        slip_m = slip_rad = 0.0
        if last is not None:
            seconds = (tick - last.tick) / 1000.0
            slip_m = last.slip_m + seconds * max(slip[0], self._slip[0])
            slip_rad = last.slip_rad + seconds * max(slip[1], self._slip[1])
            heading = last.way.heading_rad + wrap(heading - last.way.heading_rad)
        self._slip = slip
        self.now = now = Body(tick, Way(x_m, y_m, heading), slip_m, slip_rad)
        return now

    def at(self, tick: int) -> Body | None:
        """The truth of a tick between the newest two rows, where it moves evenly; None while there are none."""
        before, now = self.before, self.now
        if before is None or now is None:
            return None
        part = min(1.0, max(0.0, (tick - before.tick) / (now.tick - before.tick)))
        return now._replace(tick=tick, way=before.way.towards(now.way, part))
