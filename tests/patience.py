"""Real wires, kernels and processes take their time, and more of it on a busy machine."""

import time

from bench.io.clock import wait_ns

DEADLINE_S = 60.0


def until(holds, step=lambda: None, deadline_s=DEADLINE_S):
    """Step until something holds."""
    deadline = time.monotonic() + deadline_s
    while not holds():
        assert time.monotonic() < deadline, "it did not come to that"
        step()
        wait_ns(500_000)
