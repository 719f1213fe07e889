"""What a real motor bus does to feedback and the plain emulation does not: angle noise, late frames, lost frames.

    [noise]                     # in a scenario; its `seed` decides every draw
    angle_counts = 2            # reported rotor angles are off by up to this, evenly
    late_ticks = 3              # a frame comes up to so many ticks late, evenly; frames of one ESC keep their order
    loss = 0.01                 # the probability that a frame never comes

All off by default, and then not in the way at all. The draws come from a counter that the seed starts (SplitMix64,
Steele et al. 2014), so that a run is repeated byte for byte on any machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.config import Table
from bench.messages import CanFrame

COUNTS = 8192
"""Of a rotor's turn, in bytes 0 and 1 of the feedback of C610 and DM3519, high byte first."""
MOST_LATE_TICKS = 1000
_MASK = (1 << 64) - 1


@dataclass(frozen=True, slots=True)
class Noise:
    """How bad the feedback is, and the seed of its draws."""

    angle_counts: int = 0
    late_ticks: int = 0
    loss_ppm: int = 0
    seed: int = 0

    @property
    def is_on(self) -> bool:
        """Whether there is any."""
        return bool(self.angle_counts or self.late_ticks or self.loss_ppm)


SILENT = Noise()


def read_noise(data: Table, seed: int) -> Noise:
    """The settings of a `[noise]` table. Raises ConfigError."""
    noise = Noise(
        _whole(data, "angle_counts", COUNTS // 2),
        _whole(data, "late_ticks", MOST_LATE_TICKS),
        round(_share(data, "loss") * 1e6),
        seed,
    )
    data.refuse_rest()
    return noise


class NoisyFeedback:
    """Feedback frames in, what of them arrives out. `lost` and `late` count."""

    def __init__(self, noise: Noise) -> None:
        self.noise = noise
        self.lost = 0
        self.late = 0
        self._state = noise.seed & _MASK
        self._waiting: list[tuple[int, CanFrame]] = []
        self._due: dict[int, int] = {}

    def step(self, tick: int, frames: Sequence[CanFrame]) -> tuple[CanFrame, ...]:
        """The frames that arrive in this tick: in the order in which they were sent."""
        noise, waiting, due = self.noise, self._waiting, self._due
        for can_id, data in frames:
            if noise.loss_ppm and self._draw(1_000_000) < noise.loss_ppm:
                self.lost += 1
                continue
            if noise.angle_counts:
                off = self._draw(2 * noise.angle_counts + 1) - noise.angle_counts
                angle = ((data[0] << 8 | data[1]) + off) % COUNTS
                data = bytes((angle >> 8, angle & 0xFF)) + data[2:]
            arrives = tick + (self._draw(noise.late_ticks + 1) if noise.late_ticks else 0)
            arrives = due[can_id] = max(arrives, due.get(can_id, 0))
            self.late += arrives > tick
            waiting.append((arrives, (can_id, data)))
        self._waiting = [(arrives, frame) for arrives, frame in waiting if arrives > tick]
        return tuple(frame for arrives, frame in waiting if arrives <= tick)

    def _draw(self, below: int) -> int:
        """A whole number, 0 to below - 1. SplitMix64."""
        self._state = state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & _MASK
        state = (state ^ state >> 27) * 0x94D049BB133111EB & _MASK
        return (state ^ state >> 31) * below >> 64


def _whole(data: Table, key: str, most: int) -> int:
    value: int = data.get(key, int, 0)
    if not 0 <= value <= most:
        raise data.fail(key, f"expected 0 (off) to {most}, got {value}")
    return value


def _share(data: Table, key: str) -> float:
    value: float = data.get(key, float, 0.0)
    if not 0.0 <= value < 1.0:
        raise data.fail(key, f"expected a probability, 0 (off) to less than 1, got {value:g}")
    return value
