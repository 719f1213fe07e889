"""The bench beside MuJoCo and ir-sim, in a throw-away environment (scripts/simulators.py)."""

from __future__ import annotations

import random
from collections.abc import Sequence
from statistics import median

import simulators

from benchmarks.table import Row, Sample
from benchmarks.throwaway import environment

SIMULATED_S = 0.2


def measure(_order: random.Random, share: float = 1.0) -> Sample:
    """Simulated seconds a CPU second, in one process; nothing where the others cannot be installed."""
    _, python = environment(simulators.PACKAGES)
    if python is None:
        return {}
    factors = simulators.measured(python, SIMULATED_S * share, 1)
    return {name: values[0] for name, values in factors.items()}


def report(samples: Sequence[Sample]) -> list[Row]:
    """For orientation: they simulate other things (scripts/simulators.py says what)."""
    if not all(samples):
        return [Row("the bench beside other simulators", "skipped: they cannot be installed here")]
    factors = {name: [sample[name] for sample in samples] for name in samples[0]}
    ratios = simulators.ratios(factors)
    return [
        Row(
            f"simulated s per CPU s, {name}",
            f"{median(values):.2f}" + (f": the bench is {ratios[name]:.2f} x as fast" if name in ratios else ""),
        )
        for name, values in factors.items()
    ]
