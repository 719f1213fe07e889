"""Faults that know RC frames: a flag set, channels frozen or at their lowest."""

from __future__ import annotations

from bench import rc_decode
from bench.base import RC_PAUSE_US
from bench.messages import RcFrame


class WholeFrames:
    """Whole RC frames with something changed. From the moment it acts, bytes wait until their frame is whole."""

    def __init__(self, kind: str, protocol: str) -> None:
        self._kind, self._protocol = kind, protocol
        self._frozen: tuple[int, ...] | None = None
        self._decoder = rc_decode.decoder(protocol, pause_us=RC_PAUSE_US)
        self._lowest = tuple(low for low, _ in rc_decode.channel_limits(protocol))
        self._changed(RcFrame(0, 0, self._lowest))  # refuses a flag that this protocol cannot carry, before the run

    def __call__(self, tick: int, piece: bytes, active: bool) -> bytes:
        """The frames that are whole by now, changed."""
        events = self._decoder.feed(piece, tick * 1000)
        if not active:
            self._frozen = None
            return piece
        return b"".join([self._changed(event) for event in events if isinstance(event, RcFrame)])

    def _changed(self, frame: RcFrame) -> bytes:
        channels = frame.channels
        if self._kind == "zeros":
            channels = self._lowest
        elif self._kind == "freeze":
            if self._frozen is None:
                self._frozen = channels
            channels = self._frozen
        failsafe = frame.failsafe or self._kind == "flag"
        lost = frame.frame_lost or self._kind == "lost_flag"
        return rc_decode.encode(self._protocol, channels, failsafe, lost, frame.digital)
