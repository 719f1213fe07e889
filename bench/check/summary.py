"""What a run did, in numbers a person wants: distance, turn, frames on each wire, how far odometry was off."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from bench.base import Base
from bench.check.crosswire.finding import check_lines
from bench.check.run import Run
from bench.config import CONTROL_KINDS
from bench.messages import StateRow, TickOutput
from bench.odometry import wrap
from bench.slamware.framing import FrameDecoder, SlamwareFrame

X, Y, HEADING = 1, 2, 3  # places in a state row, after Bench.state_columns
ODO = 7
LINK = 10
INEXACT_SHARE = 0.001
"""A single step that was not exact is beyond a person's eye; more say something of the robot's file."""
SAID_SHOWN = 8
LINK_CHANGES_SHOWN = 8


@dataclass(slots=True)
class Summary:
    """Follows a run of a base with so many `wheels`, tick by tick, with `add`.

    Distances in m, angles in rad; path and turn are sums of sizes.
    """

    wheels: int
    ticks: int = 0
    path_m: float = 0.0
    turn_rad: float = 0.0
    rc_bytes: int = 0
    core_requests: int = 0
    core_answers: int = 0
    can_commands: int = 0
    can_feedback: int = 0
    top_current_a: float = 0.0
    odometry_off_m: float = 0.0
    odometry_off_rad: float = 0.0
    end: tuple[float, float, float] = (0.0, 0.0, 0.0)
    link_changes: list[tuple[float, str]] = field(default_factory=list)
    _last: StateRow | None = None
    _to_base: FrameDecoder = field(default_factory=FrameDecoder)
    _to_core: FrameDecoder = field(default_factory=FrameDecoder)

    def add(self, out: TickOutput) -> None:
        """Take one tick."""
        self.extend((out,))

    def extend(self, outs: Sequence[TickOutput]) -> None:
        """Take some ticks, one after the other: column by column, which costs a fifth of tick by tick."""
        if not outs:
            return
        ticks, rc, core_to_base, base_to_core, commands, feedback, states = zip(*outs, strict=True)
        count = len(ticks)
        self.ticks += count
        self.rc_bytes += sum(map(len, rc))
        self.core_requests += _whole(self._to_base, core_to_base)
        self.core_answers += _whole(self._to_core, base_to_core)
        self.can_commands += sum(map(len, commands))
        self.can_feedback += sum(map(len, feedback))
        for row in states:
            if row is not None:
                self._add_state(row)

    def _add_state(self, row: StateRow) -> None:
        x, y, heading, odo_x, odo_y, odo_heading = map(float, row[X : HEADING + 1] + row[ODO : ODO + 3])
        last = self._last
        if last is not None:
            self.path_m += math.dist((x, y), (float(last[X]), float(last[Y])))
            self.turn_rad += abs(wrap(heading - float(last[HEADING])))
        currents_a = map(float, row[LINK + 5 : LINK + 3 + 3 * self.wheels : 3])
        self.top_current_a = max(self.top_current_a, max(map(abs, currents_a)))
        if last is None or row[LINK] != last[LINK]:
            self.link_changes.append((float(row[0]), str(row[LINK])))
        self.end = (x, y, heading)
        self.odometry_off_m = math.dist((x, y), (odo_x, odo_y))
        self.odometry_off_rad = abs(wrap(heading - odo_heading))
        self._last = row

    def facts(self, run: Run) -> dict[str, object]:
        """The numbers by name, for --json; what only our own base knows of itself is None of another."""
        ours = isinstance(run.bench.base, Base)
        return {
            "seconds": self.ticks / 1000.0,
            "path_m": round(self.path_m, 4),
            "turn_rad": round(self.turn_rad, 4),
            "end": [round(value, 4) for value in self.end],
            "odometry_off_m": round(self.odometry_off_m, 6) if ours else None,
            "odometry_off_rad": round(self.odometry_off_rad, 6) if ours else None,
            "top_current_a": round(self.top_current_a, 3),
            "frames": {
                "rc_bytes": self.rc_bytes,
                "can_commands": self.can_commands,
                "can_feedback": self.can_feedback,
                "core_requests": self.core_requests,
                "core_answers": self.core_answers,
            },
            "link": [[at_s, state] for at_s, state in self.link_changes] if ours else None,
            "controller": run.info.controller or run.bench.robot.control.kind,
            "odometry": run.bench.robot.odometry,
            "bus_findings": list(run.bench.bus_findings),
            "checks": [outcome.as_dict() for outcome in run.checks.outcomes()] if run.checks else [],
            **({"wires": timing.facts(self.ticks)} if (timing := run.bench.world.timing) else {}),
            **({"output": said} if (said := _said(run)) else {}),
            **({"bad_currents": bad} if (bad := run.bench.world.plant.bad_currents) else {}),
            **({"inexact_steps": inexact} if (inexact := run.bench.world.plant.inexact_steps) else {}),
            **({"wheel_lift_s": run.lifted_ticks / 1000.0} if run.lifted_ticks else {}),
        }

    def lines(self, run: Run) -> list[str]:
        """The same for people, a few lines."""
        lines = [*self._way(run), *self._wires(run), *self._in_place_of_ours(run), *_trouble(run)]
        said = _said(run).splitlines()[-SAID_SHOWN:]
        lines += [f"{'' if at else 'said':<10}{line}" for at, line in enumerate(said)]
        return lines + (check_lines(run.checks.outcomes()) if run.checks is not None else [])

    def _way(self, run: Run) -> Iterator[str]:
        x, y, heading = self.end
        yield (
            f"drove     {self.path_m:.2f} m and turned {math.degrees(self.turn_rad):.0f} deg"
            f" in {self.ticks / 1000:.1f} s; stands at x {x:+.3f} m, y {y:+.3f} m, {math.degrees(heading):+.1f} deg"
        )
        if isinstance(run.bench.base, Base):
            off_mm, off_deg = self.odometry_off_m * 1000, math.degrees(self.odometry_off_rad)
            yield f"odometry  off by {off_mm:.2f} mm and {off_deg:.3f} deg at the end"

    def _wires(self, run: Run) -> Iterator[str]:
        link = getattr(run.bench.onlooker or run.bench.base, "link", None)
        heard = f"{link.frames} frames, {link.noise_bytes} bytes of noise" if link else f"{self.rc_bytes} bytes"
        yield f"rc        {heard}"
        if link and link.noise_bytes and not link.frames:
            yield "          not one frame: wheelbench decode auto FILE says what such bytes may be"
        yield f"slamware  {self.core_requests} requests, {self.core_answers} answers"
        yield (
            f"can       {self.can_commands} commands, {self.can_feedback} feedback frames;"
            f" at most {self.top_current_a:.2f} A in a motor"
        )
        timing = run.bench.world.timing
        if timing is not None:
            yield (
                f"wires     the bus was {100 * timing.load(self.ticks):.1f} % full; never sent: {timing.lost_commands}"
                f" commands, {timing.lost_reports} feedback frames, {timing.lost_bytes} bytes on serial lines"
            )
        if self.link_changes and isinstance(run.bench.base, Base):
            changes = self.link_changes[:LINK_CHANGES_SHOWN]
            yield "link      " + ", ".join(f"{state} from {at_s:.2f} s" for at_s, state in changes)

    def _in_place_of_ours(self, run: Run) -> Iterator[str]:
        """A printed form, or somebody's own base."""
        info = run.info
        if info.controller in CONTROL_KINDS:
            yield f"printed   the controller is {info.controller}, not the speed loop"
        elif info.controller is not None:
            yield f"base      {info.controller}, not the bench's own"
        if info.odometry is not None:
            yield (
                f"printed   the odometry is {info.odometry}; it ends {self.odometry_off_m:.2f} m and"
                f" {math.degrees(self.odometry_off_rad):.0f} deg from the truth"
            )


def _whole(decoder: FrameDecoder, pieces: Sequence[bytes]) -> int:
    """How many frames these bytes complete: on a wire that takes its time one lasts several ticks."""
    return sum(isinstance(event, SlamwareFrame) for event in decoder.feed(b"".join(pieces)))


def _trouble(run: Run) -> Iterator[str]:
    plant = run.bench.world.plant
    bad = plant.bad_currents
    if bad:
        yield f"plant     {bad} commanded currents were no finite number; each was taken for 0 A"
    if plant.inexact_steps > INEXACT_SHARE * run.ticks:
        yield (
            f"plant     {plant.inexact_steps} steps ended before the forces of the floor were exact: wheels are heavy"
            " for this body, whose motion is near, not to the last digit; check both inertias and the body's mass"
        )
    if run.lifted_ticks:
        yield (
            f"plant     a wheel would have left the floor for {run.lifted_ticks / 1000:.3f} s, first at"
            f" {run.first_lift_tick / 1000:.3f} s: the motion from there on is a guess; accelerate it less, or lower"
            " its centre of gravity"
        )
    findings = run.bench.bus_findings
    if findings:
        yield f"bus       {len(findings)} finding{'s' * (len(findings) > 1)}; the newest: {findings[-1]}"


def _said(run: Run) -> str:
    """What a firmware has printed; other bases print for themselves."""
    output = getattr(run.bench.base, "output", None)
    return str(output()) if callable(output) else ""
