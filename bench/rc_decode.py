"""RC bytes to frames and back, for every protocol we speak. This is the face; the protocols live in `bench/rc/`.

    decoder = rc_decode.decoder("sbus")
    for event in decoder.feed(data, at_us) + decoder.finish(): ...    # RcFrame, RcNoise, RcLinkStatistics, RcOther
    data = rc_decode.encode("sbus", channels, failsafe=True)

To add a protocol: one file in `bench/rc/` with a subclass of `Decoder` and an `encode`, and one line in `_CODECS`.
What a frame means for the robot is not decided here but in `link` and `drive`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from bench.rc import crsf, sbus, uart12
from bench.rc.framing import Counters, Decoder

__all__ = ["PROTOCOLS", "Counters", "Decoder", "decoder", "encode"]


class _Codec(NamedTuple):
    decoder: type[Decoder]
    encode: Callable[..., bytes]
    has_flags: bool = False


_CODECS = {
    "uart12": _Codec(uart12.Uart12Decoder, uart12.encode),
    "sbus": _Codec(sbus.SbusDecoder, sbus.encode, has_flags=True),
    "crsf": _Codec(crsf.CrsfDecoder, crsf.encode),
}
PROTOCOLS = tuple(_CODECS)


def decoder(protocol: str, pause_us: float | None = None) -> Decoder:
    """A decoder at the beginning of a stream. Raises ValueError for a protocol that is not one of `PROTOCOLS`."""
    return _codec(protocol).decoder(pause_us)


def encode(protocol: str, channels: Sequence[int], failsafe: bool = False, frame_lost: bool = False) -> bytes:
    """One frame from raw wire values in wire order.

    Raises ValueError for an unknown protocol, a wrong number of channels, a value outside of its range, and for a flag
    that the protocol cannot carry.
    """
    codec = _codec(protocol)
    if codec.has_flags:
        return codec.encode(channels, failsafe, frame_lost)
    if failsafe or frame_lost:
        raise ValueError(f"{protocol} frames cannot say failsafe or frame lost; the link shows loss in another way")
    return codec.encode(channels)


def _codec(protocol: str) -> _Codec:
    try:
        return _CODECS[protocol]
    except KeyError:
        raise ValueError(f"no RC protocol is called {protocol!r}; known: {', '.join(PROTOCOLS)}") from None
