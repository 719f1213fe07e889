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

from bench.rc import crsf, dbus, ibus, sbus, uart12
from bench.rc.framing import ELEVEN_BIT_LIMITS, Counters, Decoder

__all__ = ["PROTOCOLS", "Counters", "Decoder", "channel_limits", "decoder", "encode"]


class _Codec(NamedTuple):
    decoder: type[Decoder]
    encode: Callable[..., bytes]
    limits: tuple[tuple[int, int], ...]
    flags: tuple[str, ...] = ()
    """What `encode` takes besides the channels."""


_CODECS = {
    "uart12": _Codec(uart12.Uart12Decoder, uart12.encode, uart12.LIMITS),
    "sbus": _Codec(sbus.SbusDecoder, sbus.encode, ELEVEN_BIT_LIMITS, ("failsafe", "frame_lost", "digital")),
    "crsf": _Codec(crsf.CrsfDecoder, crsf.encode, ELEVEN_BIT_LIMITS),
    "ibus": _Codec(ibus.IbusDecoder, ibus.encode, ibus.LIMITS, ("failsafe",)),
    "dbus": _Codec(dbus.DbusDecoder, dbus.encode, dbus.LIMITS),
}
PROTOCOLS = tuple(_CODECS)


def decoder(protocol: str, pause_us: float | None = None) -> Decoder:
    """A decoder at the beginning of a stream. Raises ValueError for a protocol that is not one of `PROTOCOLS`."""
    return _codec(protocol).decoder(pause_us)


def channel_limits(protocol: str) -> tuple[tuple[int, int], ...]:
    """Lowest and highest raw value of every channel, in wire order. Raises ValueError for an unknown protocol."""
    return _codec(protocol).limits


def encode(
    protocol: str,
    channels: Sequence[int],
    failsafe: bool = False,
    frame_lost: bool = False,
    digital: Sequence[bool] = (),
) -> bytes:
    """One frame from raw wire values in wire order; `digital` as in `RcFrame`.

    Raises ValueError for an unknown protocol, a wrong number of channels, a value outside of its range, and for a flag
    that the protocol cannot carry.
    """
    codec = _codec(protocol)
    flags: dict[str, bool | Sequence[bool]] = {}
    for name, value in (("failsafe", failsafe), ("frame_lost", frame_lost), ("digital", digital)):
        if name in codec.flags:
            flags[name] = value
        elif value:
            raise ValueError(f"{protocol} frames cannot say {name}")
    return codec.encode(channels, **flags)


def _codec(protocol: str) -> _Codec:
    try:
        return _CODECS[protocol]
    except KeyError:
        raise ValueError(f"no RC protocol is called {protocol!r}; known: {', '.join(PROTOCOLS)}") from None
