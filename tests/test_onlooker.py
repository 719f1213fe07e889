"""What a screen shows of a foreign base's driver is what our own base makes of the same wire."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.base import Base
from bench.config import load_robot
from bench.onlooker import Onlooker
from bench.rc.transmitter import Sticks, Transmitter

ROBOTS = {name: load_robot("m2006", name) for name in ("uart12", "frsky-sbus", "flysky")}
PIECES = st.tuples(
    st.sampled_from(("driven", "silent", "cut", "garbage")),
    st.integers(1, 700),
    st.sampled_from((-1.0, -0.3, 0.0, 0.02, 1.0)),
)


@pytest.mark.parametrize("profile", ROBOTS)
@settings(max_examples=15, deadline=None)
@given(pieces=st.lists(PIECES, min_size=1, max_size=5))
def test_it_has_the_sticks_and_the_link_that_our_own_base_has(profile, pieces):
    robot = ROBOTS[profile]
    ours, onlooker, transmitter = Base(robot), Onlooker(robot), Transmitter(robot.rc)
    tick = 0
    for kind, ticks, stick in pieces:
        for _ in range(ticks):
            sent = transmitter.step(tick, Sticks(stick, -stick, stick / 2))
            heard = {"driven": sent, "silent": b"", "cut": sent[:-1], "garbage": bytes((tick % 251,)) * len(sent)}[kind]
            ours.step(tick, heard, b"", ())
            onlooker.step(tick, heard)
            assert onlooker.sticks == ours.drive.sticks
            assert (onlooker.link.state, onlooker.link.frames) == (ours.link.state, ours.link.frames)
            tick += 1
