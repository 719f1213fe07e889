"""What our own receiver makes of the RC wire beside a foreign base: for people at a screen. It changes nothing.

Nobody can look into a foreign base. Its wires can be heard, though, and the same decoder and the same rules that our
base has say what the driver holds and whether the link would be alive to us.
"""

from __future__ import annotations

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.config import Robot
from bench.drive import sticks_of
from bench.link import COMMANDING, RcLink
from bench.messages import TICK_US, RcFrame


class Onlooker:
    """Hears one RC wire. `link` is None for a robot that takes no RC."""

    def __init__(self, robot: Robot) -> None:
        self._profile = profile = robot.rc
        self._decoder = rc_decode.decoder(profile.protocol, pause_us=RC_PAUSE_US) if profile else None
        self.link = RcLink(profile, robot.link) if profile else None
        self._frame: RcFrame | None = None  # the last that counted as the driver's will
        self._pending = False  # a frame has begun: time alone may end it

    def step(self, tick: int, rc_bytes: bytes) -> None:
        """Take the bytes of this tick, as our own base does."""
        decoder, link = self._decoder, self.link
        if decoder is None or link is None:
            return
        if rc_bytes or self._pending:
            state = link.step(tick, decoder.feed(rc_bytes, tick * TICK_US))
            self._pending = decoder.pending
        elif tick >= link.review_tick:
            state = link.step(tick, ())
        else:
            return
        if state in COMMANDING:
            self._frame = link.frame

    @property
    def sticks(self) -> tuple[float, float, float]:
        """Forward, left and counter-clockwise, -1 to 1."""
        frame, profile = self._frame, self._profile
        if frame is None or profile is None:
            return 0.0, 0.0, 0.0
        return sticks_of(frame.channels, profile)
