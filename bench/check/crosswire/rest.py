"""A robot that is told to stand, stands, and is not pushed draws no current to speak of.

At rest is one whose body and wheels have stood still for half a second. Told to stand: in that time nobody asked for
anything; sticks inside the dead-band of the transmitter's profile, no velocity in the core's last request. Not pushed:
no fault of the scenario has touched the plant. What a motor draws is what its ESC reports.

Where the scenario's [noise] shakes the angles that a base hears, its loop answers each shake, and what flows says
nothing of the base: such a run is judged by a `current_a` of its own, or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.canbus.c610 import FEEDBACK_ID
from bench.check.crosswire.block import Block
from bench.check.crosswire.finding import Finding, Outcome, span
from bench.check.crosswire.ledger import Exchanged
from bench.check.crosswire.settings import ON, RestCurrentCheck
from bench.config import Profile, Robot
from bench.messages import STATE_PERIOD_TICKS, TICK_US, RcFrame, StateRow
from bench.motors import family
from bench.slamware.commands import SET_BASE_MOTOR, SET_V_AND_GET_DEADRECKON
from bench.slamware.framing import CONTROL_BUS

SETTLE_TICKS = 500
ROWS_EACH = 2
"""Every other row of state will do."""
STILL_MPS, STILL_RADPS, STILL_WHEEL_RADPS = 1e-3, 1e-2, 5e-2
FRICTION_SHARE = 0.25
"""Of the current that dry friction hides: an M2006 (0.020 N m of 0.18 N m/A at its wheel) may draw 28 mA and stand.

More is what an integrator leaves behind that nothing empties: the wheel stays only as long as friction wins, and jumps
when somebody lifts the robot. A C610 resolves 1 mA; our own loop ends at 0.
"""


class RestJudge:
    """Takes blocks, and what the ledger made of their SLAMWARE bytes."""

    def __init__(
        self, robot: Robot, columns: Sequence[str], check: RestCurrentCheck, *, angles_shake: bool = False
    ) -> None:
        self._check = check
        self.is_excused = angles_shake and check.state == ON and not check.current_a
        motor = robot.motor
        self._allowed_a = check.current_a or FRICTION_SHARE * motor.coulomb_nm / motor.torque_nm_per_a
        self._profile = robot.rc
        self._decoder: rc_decode.Decoder | None = None
        messages = family(robot)
        self._raw_per_a = messages.raw_per_a
        self._wheels = {FEEDBACK_ID + wheel.can_id: number for number, wheel in enumerate(robot.wheels, 1)}
        # Wheels first: a wheel that turns says it soonest.
        self._still = [(columns.index(f"wheel{number}_radps"), STILL_WHEEL_RADPS) for number in self._wheels.values()]
        self._still += [(columns.index(name), STILL_MPS) for name in ("vx_mps", "vy_mps")]
        self._still.append((columns.index("omega_radps"), STILL_RADPS))
        self._still_since: int | None = None
        self._asked_tick = -SETTLE_TICKS
        self._core_asks = False
        self._rests = 0
        self._in_rest = False
        self._rest_ms = 0
        self._most_a = 0.0
        self._found: dict[int, Finding] = {}
        self._worst: dict[int, float] = {}

    def disturbed(self, tick: int) -> None:
        """Somebody pushed, or changed the floor."""
        self._asked_tick = max(self._asked_tick, tick)

    def take(self, block: Block, exchanged: Exchanged) -> None:
        """The next block."""
        asks = [(one.tick, _moves(one.payload)) for one in exchanged.requests if _is_motion(one.code, one.payload)]
        deflected: list[int] = []
        # While the robot moves nobody needs to know why; what the sticks say matters from the first block at rest on.
        if self._still_since is not None and self._profile is not None:
            deflected = self._deflections(block, self._profile)
        else:
            self._decoder = None
        for index in block.row_places[::ROWS_EACH]:
            tick, row = block.first + index, block.states[index]
            assert row is not None
            while asks and asks[0][0] <= tick:
                self._core_asks = asks.pop(0)[1]
            if self._core_asks:
                self._asked_tick = tick
            while deflected and deflected[0] <= tick:
                self._asked_tick = max(self._asked_tick, deflected.pop(0))
            self._look_at(tick, row, block, index)
        for tick in deflected:
            self._asked_tick = tick
        if asks:
            self._core_asks = asks[-1][1]

    def _look_at(self, tick: int, row: StateRow, block: Block, index: int) -> None:
        for place, most in self._still:
            if not -most < row[place] < most:  # type: ignore[operator]
                self._still_since, self._in_rest = None, False
                return
        if self._still_since is None:
            self._still_since = tick
        if tick - max(self._still_since, self._asked_tick) < SETTLE_TICKS:
            self._in_rest = False
            return
        self._rests += not self._in_rest
        self._in_rest = True
        self._rest_ms += ROWS_EACH * STATE_PERIOD_TICKS
        for can_id, data in block.can_feedback[index]:
            wheel = self._wheels.get(can_id)
            if wheel is not None and len(data) == 8:
                self._draws(tick, wheel, abs(int.from_bytes(data[4:6], "big", signed=True)) / self._raw_per_a)

    def _draws(self, tick: int, wheel: int, current_a: float) -> None:
        self._most_a = max(self._most_a, current_a)
        if current_a <= self._allowed_a:
            return
        seen = self._found.get(wheel)
        self._worst[wheel] = max(self._worst.get(wheel, 0.0), current_a)
        first, count = (seen.first_tick, seen.count + 1) if seen else (tick, 1)
        self._found[wheel] = Finding("", first, tick, count)

    def _deflections(self, block: Block, profile: Profile) -> list[int]:
        """Ticks in which a frame came whose sticks are not at rest."""
        decoder = self._decoder
        if decoder is None:
            decoder = self._decoder = rc_decode.decoder(profile.protocol, pause_us=RC_PAUSE_US)
        found = []
        for index, data in enumerate(block.rc):
            if data or decoder.pending:  # what waits for silence (DBUS) is a frame before the next one comes
                tick = block.first + index
                for event in decoder.feed(data, tick * TICK_US):
                    if isinstance(event, RcFrame) and _deflected(event, profile):
                        found.append(tick)
        return found

    def outcome(self) -> Outcome:
        """At the end of the run."""
        allowed_ma = 1000 * self._allowed_a
        findings = []
        for wheel, one in sorted(self._found.items()):
            when = span(one.first_tick, one.last_tick)
            text = f"motor {wheel} draws up to {1000 * self._worst[wheel]:.0f} mA in a robot that stands as it is told,"
            text += f" where {allowed_ma:.0f} mA are allowed, {when}"
            findings.append(Finding(text, one.first_tick, one.last_tick, one.count))
        if self._rests:
            measured = (
                f"at most {1000 * self._most_a:.0f} of {allowed_ma:.0f} mA in {self._rest_ms / 1000:.1f} s of standing"
            )
        elif self.is_excused:
            measured = "not judged: the scenario's [noise] shakes the angles; give a current_a that it may draw"
        else:
            measured = "never stood long enough to be judged"
        used = self._most_a / self._allowed_a if self._allowed_a else 0.0
        return Outcome("rest_current", self._check.state, tuple(findings), self._rests, measured, used)


def _is_motion(code: int, payload: bytes) -> bool:
    return code == CONTROL_BUS and payload[:1] in (bytes((SET_BASE_MOTOR,)), bytes((SET_V_AND_GET_DEADRECKON,)))


def _moves(payload: bytes) -> bool:
    """Whether a velocity or any rim speed in a request is not zero."""
    return any(payload[1:])


def _deflected(frame: RcFrame, profile: Profile) -> bool:
    """Whether a stick is outside of its dead-band."""
    for axis in (profile.forward, profile.right, profile.clockwise):
        most = profile.dead_band * axis.travel
        if axis.channel < len(frame.channels) and abs(frame.channels[axis.channel] - axis.middle) > most:
            return True
    return False
