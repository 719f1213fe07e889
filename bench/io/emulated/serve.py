"""Runs emulated devices in real time: each is stepped once a millisecond, at absolute deadlines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from bench.io.clock import WallPacer, now_ns, wait_ns

BURST_TICKS = 50
TICK_NS = 1_000_000


class Device(Protocol):
    """Something at the end of a wire."""

    def step(self, tick: int) -> None:
        """One millisecond."""
        ...

    def facts(self) -> dict[str, object]:
        """What has passed."""
        ...

    def close(self) -> None:
        """Give the wire back."""
        ...


def serve(
    devices: Sequence[Device],
    *,
    ticks: int | None = None,
    stopped: Callable[[], bool] = lambda: False,
    every_second: Callable[[int], None] = lambda tick: None,
) -> int:
    """Step the devices until `ticks` have passed or `stopped()`; how many ticks that was. Closes them at the end.

    `every_second` is told the tick each simulated second. Behind by more than `BURST_TICKS`, time slips.
    """
    pacer, tick = WallPacer(burst_ticks=BURST_TICKS), 0
    try:
        while not stopped() and (ticks is None or tick < ticks):
            for _ in range(pacer.due(tick)):
                for device in devices:
                    device.step(tick)
                tick += 1
                if tick % 1000 == 0:
                    every_second(tick)
            wait_ns(TICK_NS - now_ns() % TICK_NS)
    finally:
        for device in devices:
            device.close()
    return tick
