"""The SLAMWARE control bus: the serial line between a SLAMTEC navigation core and a robot base.

    framing     bytes <-> frames, the checksum, and what to do with a damaged stream
    payloads    fields <-> SI values: sub-commands, errors, every Q16 conversion
    base_side   our slave: answers a core, says what the core wants and whether it lives
    core_side   our master: drives a base, ours or yours, and integrates what it answers
    describe    frames in words, for `wheelbench decode` and the dashboard

A new sub-command is a row in `payloads.SUB_COMMANDS` with its conversions, a handler in `base_side` and its rows in
`describe`. Frames of the vendor's own code, which decide in every doubt: fixtures/known/slamware.
"""

from bench.slamware.base_side import SlamwareBase
from bench.slamware.core_side import SlamwareCore
from bench.slamware.describe import describe, summary
from bench.slamware.framing import FrameDecoder, SlamwareEvent, SlamwareFrame, SlamwareNoise, encode_frame

__all__ = [
    "FrameDecoder",
    "SlamwareBase",
    "SlamwareCore",
    "SlamwareEvent",
    "SlamwareFrame",
    "SlamwareNoise",
    "describe",
    "encode_frame",
    "summary",
]
