"""Nonsense on every wire at once, for long: nothing raises, nothing moves that was not asked to, memory stays put."""

import gc
import random
import tracemalloc

from hypothesis import given
from hypothesis import strategies as st

from bench.base import Base
from bench.config import load_robot
from bench.m2006 import decode_command

ROBOT = load_robot("m2006")

some_bytes = st.binary(max_size=40)
can_frames = st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=6)


@given(st.lists(st.tuples(some_bytes, some_bytes, can_frames), max_size=40))
def test_any_bytes_on_any_wire_are_survived(ticks):
    base = Base(ROBOT)
    for tick, (rc, slamware, can) in enumerate(ticks):
        commands, _ = base.step(tick, rc, slamware, can)
        assert all(can_id == 0x200 and len(data) == 8 for can_id, data in commands)


def noise(seed):
    """Endless ticks of noise that knows the headers: harder than uniform bytes."""
    chance = random.Random(seed)
    heads = [b"\xaa", b"\x55", b"\x10", b"\x50", b"\x0f", b"\xf8", b""]
    for tick in range(10**9):
        yield (
            tick,
            chance.choice(heads) + chance.randbytes(chance.randrange(20)),
            chance.choice(heads) + chance.randbytes(chance.randrange(20)),
            [(chance.choice((0x200, 0x201, 0x202, 0x203, 0x7FF)), chance.randbytes(chance.choice((0, 7, 8))))],
        )


def test_noise_for_long_keeps_memory_and_motors_still():
    base = Base(ROBOT)
    stream = noise(seed=7)
    for _ in range(1500):
        base.step(*next(stream))
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        for _ in range(6000):
            commands, _ = base.step(*next(stream))
            assert decode_command(commands[0][1]) == (0, 0, 0, 0), "noise does not arm a robot"
        gc.collect()  # which also empties Python's own stores of freed tuples and floats, 100 kB by themselves
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 16 * 1024
    assert base.link.noise_bytes > 10_000
    assert base.motors.malformed_frames > 1000
