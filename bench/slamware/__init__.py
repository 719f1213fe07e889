"""The SLAMWARE control bus: the serial line between a SLAMTEC navigation core and a robot base.

    framing              bytes <-> frames, the checksum, and what to do with a damaged stream
    commands             the numbers: sub-commands and sizes, errors, events, dialects
    payloads             fields <-> SI values: identity, motion, errors; every Q16 conversion
    config_payloads      how a base is built (0x20, 0x21); sense_payloads: what it senses; health: its faults
    base_side            our slave: answers a core, says what the core wants and whether it lives
    answers              ... what it does for each sub-command, out of `facts`, `senses` and `omni_base`
    reference_firmware   the vendor's slave, defects and all; reference_base: the whole robot around it
    core_side            our master: drives a base, ours or yours; `schedule`, `knowledge`, `answer_table`, `resync`
    describe             frames in words, for `wheelbench decode` and the dashboard; their fields in `fields`

A new sub-command is a row in `commands.SUB_COMMANDS` and `answer_table.ANSWERS` with its conversions, a handler in
`answers`, a reader in `knowledge` and its rows in `fields`. Frames of the vendor's own code, which decide in every
doubt: fixtures/known/slamware.
"""

from bench.slamware.base_side import SlamwareBase
from bench.slamware.core_side import SlamwareCore
from bench.slamware.describe import Conversation, describe, summary
from bench.slamware.framing import FrameDecoder, SlamwareEvent, SlamwareFrame, SlamwareNoise, encode_frame
from bench.slamware.reference_base import as_reference_firmware

__all__ = [
    "Conversation",
    "FrameDecoder",
    "SlamwareBase",
    "SlamwareCore",
    "SlamwareEvent",
    "SlamwareFrame",
    "SlamwareNoise",
    "as_reference_firmware",
    "describe",
    "encode_frame",
    "summary",
]
