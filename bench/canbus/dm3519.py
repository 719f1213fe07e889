"""DaMiao DM3519 in its group mode: the messages of a C610 on another scale, with what sources do not agree on as names.

                 byte  0      1      2      3      4      5      6            7
    0x200   command  | current 1   | current 2   | current 3   | current 4             |   +-16384 = full scale
    0x1FF   command  | current 5   | current 6   | current 7   | current 8             |
    0x200+n feedback | rotor angle | rotor speed | current     | coil degC  | MOSFET degC|   feedback = "temperatures"
                     |             |             |             | temperature| error      |   feedback = "error"
    0x7FF   clear    | id low | id high | 55 | 3C |  0  |  0  |  0  |  0  |                clear_error = "long"
                     | id x 16|    0    | 55 | 3C |                                        clear_error = "short"

Full scale is 20 A in the maker's example and 20.5 A in a README; the two halves of each pair above come from firmware
that runs (m2006-c610 reference, section 6). The robot file says which of them its motors speak, in [dm3519].
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from bench.canbus.c610 import CONTROLLER, ESCS, command, esc_name, feedback
from bench.canbus.table import Family, Field, Message

MAX_RAW = 16384
FULL_SCALES_A = (20.0, 20.5)
FEEDBACK_VARIANTS = ("temperatures", "error")
CLEAR_VARIANTS = ("long", "short")
CLEAR_ID = 0x7FF
GEAR = 3591 / 187
"""The maker's reduction, 19.2032; 19.227 is printed too."""

OFF, ON, LINK_LOST = 0x0, 0x1, 0xD
ERRORS: Mapping[int, str] = {
    OFF: "off",
    ON: "on",
    0x5: "sensor",
    0x6: "parameter",
    0x8: "over-voltage",
    0x9: "under-voltage",
    0xA: "over-current",
    0xB: "MOSFET hot",
    0xC: "coil hot",
    LINK_LOST: "link lost",
    0xE: "overload",
}
"""Byte 7 of the feedback in the variant "error": 0 and 1 are states, the rest are faults."""


def _temperature(name: str, first_byte: int, about: str) -> Field:
    return Field(name, first_byte, 1, False, 0, 255, "degc", "degC", 1.0, about)


_TAILS: Mapping[str, tuple[Field, ...]] = {
    "temperatures": (_temperature("coil", 6, "coil temperature"), _temperature("mosfet", 7, "MOSFET temperature")),
    "error": (
        _temperature("temperature", 6, "temperature"),
        Field("error", 7, 1, False, 0, 255, about="state or fault", words=ERRORS),
    ),
}


def _constant(name: str, first_byte: int, value: int, about: str) -> Field:
    return Field(name, first_byte, 1, False, value, value, about=about)


def _clear(variant: str) -> Message:
    if variant == "long":
        fields = (
            Field("id_low", 0, 1, False, 1, ESCS, about="the ESC's number, 1 to 8"),
            _constant("id_high", 1, 0x00, "high byte of the number"),
        )
    else:
        fields = (
            Field("id_x16", 0, 1, False, 16, 16 * ESCS, about="16 times the ESC's number"),
            _constant("id_high", 1, 0x00, "0"),
        )
    return Message(
        name="DM3519_ClearError",
        can_id=CLEAR_ID,
        sender=CONTROLLER,
        receivers=tuple(esc_name(number) for number in range(1, ESCS + 1)),
        length=8 if variant == "long" else 4,
        fields=(*fields, _constant("write", 2, 0x55, "write"), _constant("register", 3, 0x3C, "clear the error")),
        exact=True,
        about="Lets one motor that is in an error state run again.",
    )


_CLEAR = {variant: _clear(variant) for variant in CLEAR_VARIANTS}


@lru_cache(maxsize=16)
def family(full_scale_a: float = 20.0, feedback_variant: str = "temperatures", clear_error: str = "long") -> Family:
    """The messages in one of the variants. Raises ValueError with what is known where a variant is unknown."""
    for value, known in ((feedback_variant, FEEDBACK_VARIANTS), (clear_error, CLEAR_VARIANTS)):
        if value not in known:
            raise ValueError(f"variant {value!r} is none of {', '.join(known)}")
    if not FULL_SCALES_A[0] <= full_scale_a <= FULL_SCALES_A[1]:
        raise ValueError(f"full scale {full_scale_a} A outside {FULL_SCALES_A[0]}..{FULL_SCALES_A[1]}")
    scale = full_scale_a / MAX_RAW
    current = Field("current", 4, 2, True, -32768, 32767, "raw", "A", scale, "current, on the scale of the command")
    return Family(
        name="dm3519",
        about="DaMiao DM3519 motors in group mode",
        full_scale_raw=MAX_RAW,
        full_scale_a=full_scale_a,
        commands=(
            command(0, kind="DM3519", low=-MAX_RAW, high=MAX_RAW, suffix="raw", unit="A", scale=scale),
            command(1, kind="DM3519", low=-MAX_RAW, high=MAX_RAW, suffix="raw", unit="A", scale=scale),
        ),
        feedback=tuple(
            feedback(number, kind="DM3519", current=current, tail=_TAILS[feedback_variant])
            for number in range(1, ESCS + 1)
        ),
        others=(_CLEAR[clear_error],),
        alternatives=tuple(message for variant, message in _CLEAR.items() if variant != clear_error),
    )


def clear_error(number: int, variant: str = "long") -> tuple[int, bytes]:
    """The frame that clears the error of ESC 1 to 8. Raises ValueError for any other number."""
    if not 1 <= number <= ESCS:
        raise ValueError(f"ESC {number} outside 1..{ESCS}")
    message = _CLEAR[variant]
    return message.can_id, message.encode((number if variant == "long" else 16 * number,))


def cleared_esc(can_id: int, data: bytes) -> int | None:
    """The number of the ESC that this frame clears, in either length; None for any other frame."""
    if can_id != CLEAR_ID:
        return None
    for variant, message in _CLEAR.items():
        values = message.decode(data)
        if values is not None:
            number, rest = divmod(values[0], 1 if variant == "long" else 16)
            return number if rest == 0 and 1 <= number <= ESCS else None
    return None
