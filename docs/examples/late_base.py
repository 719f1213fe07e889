"""A base that is wrong in two ways, for docs/parity.md: 3 ms late, and without the last bit of each current."""

from collections import deque

from bench.base import Base
from bench.m2006 import decode_command, encode_command


class LateBase:
    """The bench's own base behind three milliseconds of delay."""

    def __init__(self, robot):
        self.base, self.kept = Base(robot), deque([()] * 3)

    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        commands, answer = self.base.step(tick, rc_bytes, slamware_bytes, can_in)
        self.kept.append(tuple((can_id, even(data)) for can_id, data in commands))
        return self.kept.popleft(), answer


def even(data):
    """Each current, in counts of 1 mA, without its last bit."""
    return encode_command([current & ~1 for current in decode_command(data)])
