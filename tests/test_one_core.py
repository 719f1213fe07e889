"""A firmware and the thread that steps it share a core while a run lasts, and nothing of it stays behind."""

import os
from contextlib import ExitStack
from pathlib import Path

import pytest
from compilers import needs_compiler

from bench.check.controllers import at_full_speed
from bench.check.sources import from_scenario
from bench.demo import SCENARIO
from bench.dut.firmware import firmware_of
from bench.dut.one_core import REVIEW_TICKS
from bench.errors import ControllerFailed

FIRMWARE = Path(__file__).parents[1] / "docs" / "examples" / "firmware" / "superloop" / "fixed.toml"
HERE = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()

pytestmark = [needs_compiler, pytest.mark.skipif(len(HERE) < 2, reason="one core only: it is shared anyway")]


@pytest.fixture(scope="module")
def firmware():
    return firmware_of(FIRMWARE)


def stepped(base, ticks):
    for tick in ticks:
        base.step(tick, b"", b"", ())


def test_both_are_on_one_core_but_for_the_tick_in_which_the_system_chooses(firmware):
    base = firmware()
    with at_full_speed(base):
        stepped(base, range(5))
        core = os.sched_getaffinity(0)
        assert len(core) == 1
        assert os.sched_getaffinity(base.pid) == core
        stepped(base, range(5, REVIEW_TICKS))
        assert os.sched_getaffinity(0) == HERE, "free to move"
        stepped(base, (REVIEW_TICKS,))
        assert len(os.sched_getaffinity(0)) == 1
        assert os.sched_getaffinity(base.pid) == os.sched_getaffinity(0)
    assert os.sched_getaffinity(0) == os.sched_getaffinity(base.pid) == HERE
    base.close()


def test_runs_that_overlap_leave_the_thread_as_it_was(firmware):
    """Two runs compared tick by tick: the first to begin is the first to end."""
    one, other = firmware(), firmware()
    with ExitStack() as first, ExitStack() as second:
        first.enter_context(at_full_speed(one))
        second.enter_context(at_full_speed(other))
        stepped(one, range(3))
        stepped(other, range(3))
        first.close()
        assert len(os.sched_getaffinity(0)) == 1, "a run is still on"
    assert os.sched_getaffinity(0) == HERE
    one.close()
    other.close()


@pytest.mark.parametrize("blocks", [True, False])
def test_a_run_of_the_benchs_own_does_it_and_one_that_is_given_up_too(blocks):
    job = from_scenario(SCENARIO, controller=str(FIRMWARE))
    outputs = job.blocks() if blocks else iter(job)
    next(outputs)
    assert len(os.sched_getaffinity(0)) == 1
    outputs.close()
    assert os.sched_getaffinity(0) == HERE


def test_a_firmware_that_dies_leaves_the_thread_free(firmware):
    base = firmware()
    with at_full_speed(base):
        stepped(base, range(3))
        os.kill(base.pid, 9)
        with pytest.raises(ControllerFailed, match="SIGKILL"):
            stepped(base, range(3, 1000))
    assert os.sched_getaffinity(0) == HERE
