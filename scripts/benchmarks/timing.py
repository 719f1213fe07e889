"""Processor time of jobs, alone and side by side."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Mapping


def cpu_s(job: Callable[[], object]) -> float:
    """Processor seconds of this process."""
    start = time.process_time()
    job()
    return time.process_time() - start


def side_by_side(
    order: random.Random, slices: int, contestants: Mapping[str, Callable[[], object]]
) -> dict[str, float]:
    """CPU seconds of each. They take turns slice by slice: whatever else the machine does falls on all of them."""
    seconds = dict.fromkeys(contestants, 0.0)
    for _ in range(slices):
        for name in order.sample(sorted(contestants), len(contestants)):
            seconds[name] += cpu_s(contestants[name])
    return seconds
