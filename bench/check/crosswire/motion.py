"""Encoder counts on CAN, what the base tells on SLAMWARE, and the truth: they move alike, second by second.

    counts   rotor counts of the feedback frames, through the robot file's wheels: what anybody on the bus can reckon
    dead     the same of three dead wheels or more, where the robot has them
    0x41, 0x31   displacements in the base's answers, put end to end
    truth    the plant's pose, in the rows of state

Two tellings are held against each other over windows of a second or a little more: so a heading that has drifted does
not count as a wrong way for the rest of the run, and a finding says when. They may be apart by a length, and by a share
of the way and of the turn.

A driven wheel that slips counts what the floor never saw, and no base is to blame. The truth shows by how much: wheel
speeds through the kinematics are a twist, and what that is off the body's is slip. Its integral is allowed on top, to
those pairs alone in which one side knows the floor and the other wheels. Leaving windows with slip out would leave out
nearly all of some drives (a robot braked hard slips a little all the time); this way a window always counts, and a
wheel that turns backwards on the wire is seen through any slip. A base without other sensors than its wheels gets no
allowance against their counts: it must tell what they say.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bench.check.crosswire.block import Block
from bench.check.crosswire.counted_way import CountedWay
from bench.check.crosswire.finding import Finding, Outcome, span
from bench.check.crosswire.ledger import Answer, Exchanged
from bench.check.crosswire.settings import MotionCheck
from bench.check.crosswire.truth import Body, Truth
from bench.check.crosswire.way import Way
from bench.check.crosswire.wheels import WheelWords
from bench.config import Robot
from bench.kinematics import Kinematics
from bench.messages import StateRow
from bench.slamware.commands import GET_BASE_MOTOR_DATA, SET_V_AND_GET_DEADRECKON
from bench.slamware.framing import CONTROL_BUS, OK
from bench.slamware.payloads import (
    OMNI_MOTOR_DATA_BYTES,
    DeadReckon,
    Displacement,
    dead_reckon_from_answer,
    motor_data_from_answer,
)

WINDOW_TICKS = 1000
ROWS_EACH = 2
"""Every other row of state will do: between two, 20 ms apart, a body in a bend at 1 m/s and 5 m/s2 is 0.3 mm beside the
even motion that is taken for its own."""
SLIP_SPARE = 1.5
"""Slip is read every 20 ms; what comes and goes between two rows is estimated from their worse one."""
GYRO_DEVIATIONS = 4.0
"""Of a gyro's noise, as its file has it: more comes once in 16,000 windows."""
COUNTS, DEAD, TRUTH = "the encoder counts on CAN", "the dead wheels' counts on CAN", "the truth"
TOLD = {SET_V_AND_GET_DEADRECKON: "SLAMWARE 0x41", GET_BASE_MOTOR_DATA: "SLAMWARE 0x31"}
_TELLING = tuple(bytes((code,)) for code in TOLD)


class Instant(NamedTuple):
    """Where each telling has come to at the end of a tick."""

    tick: int
    counts: Way
    dead: Way | None
    told: Way | None = None
    truth: Body | None = None


@dataclass(slots=True)
class _Pair:
    """Two tellings, and the worst that has come between them."""

    one: str
    other: str
    windows: int = 0
    broken: int = 0
    first_tick: int = 0
    last_tick: int = 0
    worst: float = 0.0
    worst_text: str = ""
    worst_measure: str = ""


class MotionJudge:
    """Takes blocks, and what the ledger made of their SLAMWARE bytes. Without `truth` only the wires are compared."""

    def __init__(self, robot: Robot, columns: Sequence[str], check: MotionCheck, *, truth: bool = True) -> None:
        self._check = check
        kinematics = Kinematics(robot.wheels)
        self._driven = CountedWay(robot.wheels, kinematics)
        self._dead = None
        if robot.follows_dead_wheels:
            self._dead = CountedWay(robot.dead_wheels, Kinematics(robot.dead_wheels))
        self._truth = Truth(robot, columns, kinematics) if truth else None
        self._wheels = WheelWords(robot, columns, self._driven.counts)
        gyro = robot.gyro
        self._has_more_than_wheels = robot.follows_dead_wheels or gyro is not None
        self._gyro_radps = (abs(gyro.bias_radps), gyro.rate_noise_radps) if gyro is not None else (0.0, 0.0)
        self._since_row: Instant | None = None
        self._told = dict.fromkeys(TOLD, Way())
        self._since_told: dict[int, Instant | None] = dict.fromkeys(TOLD)
        self._waiting: list[tuple[int, Instant]] = []
        self._pairs: dict[tuple[str, str], _Pair] = {}

    def take(self, block: Block, exchanged: Exchanged) -> None:
        """The next block."""
        self._driven.take(block)
        if self._dead is not None:
            self._dead.take(block)
        answers = deque(answer for answer in exchanged.answers if _tells(answer))
        for place in block.row_places[::ROWS_EACH]:
            tick, row = block.first + place, block.states[place]
            assert row is not None
            # An answer speaks of the feedback that the base has had: of the tick before it.
            while answers and answers[0].tick - 1 < tick:
                self._take_answer(answers.popleft())
            self._take_row(tick, row)
        while answers:
            self._take_answer(answers.popleft())
        self._driven.release()
        if self._dead is not None:
            self._dead.release()

    def _instant(self, tick: int, told: Way | None = None, truth: Body | None = None) -> Instant:
        dead = self._dead.at(tick) if self._dead is not None else None
        return Instant(tick, self._driven.at(tick), dead, told, truth)

    def _take_row(self, tick: int, row: StateRow) -> None:
        """A row of state: the truth, which also places the answers since the row before it."""
        self._driven.at(tick)
        if self._dead is not None:
            self._dead.at(tick)
        truth = self._truth
        if truth is None:
            return
        body = truth.take(tick, row)
        self._wheels.take_row(tick, row, self._driven.reached)
        if self._waiting:
            for code, instant in self._waiting:
                self._end_told(code, instant._replace(truth=truth.at(instant.tick)))
            self._waiting.clear()
        since = self._since_row
        if since is None:
            self._since_row = self._instant(tick, None, body) if self._driven.counts.complete else None
        elif tick - since.tick >= WINDOW_TICKS:
            assert since.truth is not None
            now, moved = self._instant(tick, None, body), body.way.since(since.truth.way)
            self._compare(COUNTS, TRUTH, since, now, now.counts.since(since.counts), moved, slips=True)
            if now.dead is not None and since.dead is not None:
                self._compare(DEAD, TRUTH, since, now, now.dead.since(since.dead), moved)
            self._since_row = now

    def _take_answer(self, answer: Answer) -> None:
        """A displacement that the base tells; it may end a window."""
        assert answer.request is not None
        code, told = answer.request.payload[0], _displacement(answer)
        way = self._told[code]
        if told.dx_m or told.dy_m or told.dtheta_rad:
            self._told[code] = way = way.moved_by(told.dx_m, told.dy_m, told.dtheta_rad)
        tick, since = answer.tick - 1, self._since_told[code]
        if since is not None and tick - since.tick < WINDOW_TICKS:
            return
        now = self._instant(tick, way)
        if self._truth is None:
            self._end_told(code, now)
        elif not any(waiting == code for waiting, _ in self._waiting):
            self._waiting.append((code, now))

    def _end_told(self, code: int, now: Instant) -> None:
        """An answer that begins or ends a window, and whose place in the truth is known where there is one."""
        since = self._since_told[code]
        if since is None:
            # The first answer after boot throws earlier motion away.
            self._since_told[code] = now if self._driven.counts.complete else None
            return
        assert since.told is not None
        assert now.told is not None
        told, name = now.told.since(since.told), TOLD[code]
        slips = self._has_more_than_wheels
        self._compare(name, COUNTS, since, now, told, now.counts.since(since.counts), slips=slips)
        if now.truth is not None and since.truth is not None:
            moved = now.truth.way.since(since.truth.way)
            self._compare(name, TRUTH, since, now, told, moved, slips=True)
        self._since_told[code] = now

    def _compare(
        self, one: str, other: str, since: Instant, now: Instant, first: Way, second: Way, *, slips: bool = False
    ) -> None:
        """Judge one window of two tellings."""
        pair = self._pairs.setdefault((one, other), _Pair(one, other))
        pair.windows += 1
        allowed_m, allowed_rad = self._allowed(since, now, (first, second), slips)
        apart_m = math.hypot(first.x_m - second.x_m, first.y_m - second.y_m)
        apart_rad = abs(first.heading_rad - second.heading_rad)
        used_m, used_rad = apart_m / allowed_m, apart_rad / allowed_rad
        used = max(used_m, used_rad)
        if used > 1.0:
            pair.first_tick = pair.first_tick if pair.broken else since.tick
            pair.last_tick = now.tick
            pair.broken += 1
        if used >= pair.worst:
            pair.worst = used
            pair.worst_measure = (
                f"{1000 * apart_m:.2f} of {1000 * allowed_m:.2f} mm"
                if used_m >= used_rad
                else f"{math.degrees(apart_rad):.3f} of {math.degrees(allowed_rad):.3f} deg"
            )
            if used > 1.0:
                pair.worst_text = (
                    f"{span(since.tick, now.tick)} {one} say {_said(first)}, {other} {_said(second)};"
                    f" {1000 * allowed_m:.1f} mm and {math.degrees(allowed_rad):.1f} deg are allowed"
                )
                if (one, other) == (COUNTS, TRUTH):
                    pair.worst_text += self._wheels.between(since.tick, now.tick)

    def _allowed(self, since: Instant, now: Instant, ways: tuple[Way, Way], slips: bool) -> tuple[float, float]:
        """How far two tellings of a window may be apart: metres, radians."""
        check = self._check
        way_m = max(math.hypot(way.x_m, way.y_m) for way in ways)
        turn_rad = max(abs(way.heading_rad) for way in ways)
        slip_m = slip_rad = 0.0
        if slips and now.truth is not None and since.truth is not None:
            slip_m = SLIP_SPARE * (now.truth.slip_m - since.truth.slip_m)
            slip_rad = SLIP_SPARE * (now.truth.slip_rad - since.truth.slip_rad)
        seconds = (now.tick - since.tick) / 1000.0
        bias_radps, noise_radps = self._gyro_radps
        gyro_rad = bias_radps * seconds + GYRO_DEVIATIONS * noise_radps * math.sqrt(seconds / 1000.0)
        allowed_rad = check.angle_rad + check.share * turn_rad + slip_rad + gyro_rad
        # A heading that may be off by so much bends the way by it.
        return check.length_m + (check.share + slip_rad + gyro_rad) * way_m + slip_m, allowed_rad

    def outcome(self) -> Outcome:
        """At the end of the run."""
        pairs = list(self._pairs.values())
        findings = []
        for pair in pairs:
            if pair.broken:
                many = f"in {pair.broken} of {pair.windows} windows" if pair.windows > 1 else "in the only window"
                text = f"{pair.one} and {pair.other} part {many}, worst: {pair.worst_text}"
                findings.append(Finding(text, pair.first_tick, pair.last_tick, pair.broken))
        judged = sum(pair.windows for pair in pairs)
        measured = "nothing to compare: the run is shorter than a second, or nothing was told"
        if judged:
            worst = max(pairs, key=lambda pair: pair.worst)
            measured = f"{judged} windows; at most {worst.worst_measure} between {worst.one} and {worst.other}"
        used = max((pair.worst for pair in pairs), default=0.0)
        return Outcome("motion", self._check.state, tuple(findings), judged, measured, used)


def _tells(answer: Answer) -> bool:
    """Whether an answer tells the way since the one before it."""
    request, frame = answer.request, answer.frame
    if request is None or request.code != CONTROL_BUS or frame.code != OK or request.payload[:1] not in _TELLING:
        return False
    return answer.fits and (request.payload[0] != GET_BASE_MOTOR_DATA or len(frame.payload) >= OMNI_MOTOR_DATA_BYTES)


def _displacement(answer: Answer) -> Displacement | DeadReckon:
    assert answer.request is not None
    if answer.request.payload[0] == SET_V_AND_GET_DEADRECKON:
        return dead_reckon_from_answer(answer.frame.payload)
    told = motor_data_from_answer(answer.frame.payload).displacement
    assert told is not None  # `_tells` has looked at the size
    return told


def _said(way: Way) -> str:
    return f"{1000 * way.x_m:+.1f}, {1000 * way.y_m:+.1f} mm, {math.degrees(way.heading_rad):+.2f} deg"
