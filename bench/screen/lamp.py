"""The golden's lamp: holds every tick of a run against a recording while it runs. `check.compare` judges it afterwards.

Every frame on every wire and every row of state.csv is compared, as exactly as `check.golden` does it: where the golden
comes from another platform and a decoded field is off by no more than its rounding may make it, the lamp says so and
stays on.
"""

from __future__ import annotations

from bench.check.compare import Difference
from bench.check.fields import distance, fields_of_pair, shown, shown_value, tolerance
from bench.check.golden import how_exactly
from bench.check.lines import BASE_TO_CORE, CORE_TO_BASE, RC, STATE, STATE_CSV, StateFormat
from bench.check.reading import Recording
from bench.messages import CanFrame, TickOutput


class GoldenLamp:
    """Give it every tick by `add`; `text` is the verdict so far, `first` the first difference that counts.

    Raises RecordingError where the golden is not what was pinned.
    """

    def __init__(self, golden: Recording) -> None:
        self._golden = golden
        self._tolerances, _ = how_exactly(golden)
        # Read now what is read lazily, and not between two frames of a screen.
        self._wires = (golden.rc, golden.core_to_base, golden.base_to_core, golden.commands, golden.feedback)
        self._rows = {tick: row for tick, _, row in golden.entries(STATE_CSV)}
        self._format = StateFormat(len(golden.state_columns))
        self._within: Difference | None = None
        self.first: Difference | None = None
        self.ended = False

    @property
    def text(self) -> str:
        """A few words: "identical so far", or what differs first."""
        if self.first is not None:
            return f"differs: {_words(self.first)}"
        so_far = "" if self.ended else " so far"
        if self._within is not None:
            return f"within tolerances{so_far}: {_words(self._within)}"
        return f"identical{so_far}"

    def add(self, out: TickOutput) -> None:
        """Compare one tick; after the first difference nothing more."""
        if self.first is not None:
            return
        tick = out.tick
        if tick >= self._golden.ticks:
            self.first = Difference(tick, "run", "ticks", self._golden.ticks, tick + 1)
            return
        rc, core_to_base, base_to_core, commands, feedback = self._wires
        expected = (rc.get(tick, b""), core_to_base.get(tick, b""), base_to_core.get(tick, b""))
        got = (out.rc, out.core_to_base, out.base_to_core)
        can_expected = commands.get(tick, ()) + feedback.get(tick, ())
        can_got = out.can_commands + out.can_feedback
        if got != expected or can_got != can_expected:
            for wire, before, after in zip((RC, CORE_TO_BASE, BASE_TO_CORE), expected, got, strict=True):
                self._compare(tick, [(wire, before)], [(wire, after)])
            self._compare(tick, _named(can_expected), _named(can_got))
        if out.state is not None and self.first is None:
            self._compare_row(out)

    def finish(self, ticks: int) -> None:
        """The run came to its end after so many ticks."""
        self.ended = True
        if self.first is None and ticks != self._golden.ticks:
            self.first = Difference(min(ticks, self._golden.ticks), "run", "ticks", self._golden.ticks, ticks)

    def _compare(self, tick: int, expected: list[tuple[str, bytes]], got: list[tuple[str, bytes]]) -> None:
        wires = [" ".join(wire.removeprefix("can ") for wire, _ in frames) or "no frame" for frames in (expected, got)]
        if wires[0] != wires[1]:
            self.first = self.first or Difference(tick, "can", "frames", wires[0], wires[1])
            return
        for (wire, before), (_, after) in zip(expected, got, strict=True):
            if before != after and self.first is None:
                self._compare_frame(tick, wire, before, after)

    def _compare_row(self, out: TickOutput) -> None:
        expected, columns = self._rows.get(out.tick), len(self._golden.state_columns)
        row = out.state or ()
        if expected is None or len(row) != columns:
            self.first = Difference(out.tick, STATE, "values", columns if expected else None, len(row))
            return
        got = self._format.lines([row]).rstrip("\n").encode()
        if got != expected:
            self._compare_frame(out.tick, STATE, expected, got)

    def _compare_frame(self, tick: int, wire: str, expected: bytes, got: bytes) -> None:
        columns = (self._golden.state_columns,) * 2
        before, after = fields_of_pair(wire, expected, got, columns, self._golden.family)
        for name, one in before.items():
            other = after[name]
            if one == other and type(one) is type(other):
                continue
            found = Difference(tick, wire, name, one, other)
            apart = distance(name, one, other)
            if self._tolerances is None or apart is None or apart > tolerance(name, self._tolerances):
                self.first = found
                return
            self._within = self._within or found


def _named(frames: tuple[CanFrame, ...]) -> list[tuple[str, bytes]]:
    return [(f"can 0x{can_id:03X}", data) for can_id, data in frames]


def _words(difference: Difference) -> str:
    name, unit = shown(difference.wire, difference.field)
    at = f"{difference.tick // 1000}.{difference.tick % 1000:03d} s"
    got, expected = shown_value(difference.got), shown_value(difference.expected)
    return f"{difference.wire.removeprefix('can ')} {name} {got} not {expected}{unit} at {at}"
