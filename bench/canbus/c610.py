"""DJI C610 (motor M2006): its messages, and who else answers on the same identifiers.

                 byte  0      1      2      3      4      5      6      7
    0x200   command  | current 1   | current 2   | current 3   | current 4   |   1 count = 1 mA, -10000 .. 10000
    0x1FF   command  | current 5   | current 6   | current 7   | current 8   |
    0x200+n feedback | rotor angle | rotor speed | current     |  0   |  0   |   0 .. 8191, rpm, 1 count = 1 mA
    0x700   quick id |  0   |  0   |  0   |  0   |  0   |  0   |  0   |  0   |   not in the maker's manual

C610 user guide V1.0; the last line is from the maker's example firmware. Bytes 6 and 7 of the feedback are empty on a
C610 (a C620 has temperature and error there), so they are sent as zero and not looked at.
"""

from __future__ import annotations

from bench.canbus.table import Family, Field, Message

COMMAND_IDS = (0x200, 0x1FF)
"""For controllers 1 to 4, and 5 to 8."""
FEEDBACK_ID = 0x200
"""Plus the controller's number, 1 to 8."""
QUICK_ID = 0x700
GM6020_FEEDBACK_ID = 0x204
"""Plus the motor's number, 1 to 7: GM6020 gimbal motors 1 to 4 answer where controllers 5 to 8 do."""
ESCS = 8
GROUP = 4
"""Controllers that one command frame sets."""
MAX_RAW = 10_000
FULL_SCALE_A = 10.0
COUNTS = 8192
"""Counts in one rotor turn."""

CONTROLLER = "Controller"


def esc_name(number: int) -> str:
    """The node of controller 1 to 8 in a DBC."""
    return f"ESC_{number}"


def gm6020_of(can_id: int) -> int | None:
    """The number of the GM6020 that answers on this identifier, or None."""
    number = can_id - GM6020_FEEDBACK_ID
    return number if 1 <= number <= 7 else None


def command(group: int, *, kind: str, low: int, high: int, suffix: str, unit: str, scale: float) -> Message:
    """The command frame of group 0 (controllers 1 to 4) or 1 (5 to 8), for any family with this layout."""
    first = 1 + GROUP * group
    numbers = range(first, first + GROUP)
    return Message(
        name=f"{kind}_Command_{first}_{first + GROUP - 1}",
        can_id=COMMAND_IDS[group],
        sender=CONTROLLER,
        receivers=tuple(esc_name(number) for number in numbers),
        period_ms=1,
        about="Torque currents of four motors. A frame sets all four: the slot of an absent motor is 0.",
        fields=tuple(
            Field(
                f"current_{number}", 2 * slot, 2, True, low, high, suffix, unit, scale, f"torque current, ESC {number}"
            )
            for slot, number in enumerate(numbers)
        ),
    )


def feedback(number: int, *, kind: str, current: Field, tail: tuple[Field, ...] = ()) -> Message:
    """The report of controller 1 to 8, for any family with this layout."""
    return Message(
        name=f"{kind}_Feedback_{number}",
        can_id=FEEDBACK_ID + number,
        sender=esc_name(number),
        receivers=(CONTROLLER,),
        period_ms=1,
        about=f"What motor {number} does.",
        fields=(
            Field("angle", 0, 2, False, 0, COUNTS - 1, "counts", "counts", 1.0, "rotor angle, 8192 counts a turn"),
            Field("speed", 2, 2, True, -32768, 32767, "rpm", "rpm", 1.0, "rotor speed, before the gear"),
            current,
            *tail,
        ),
    )


_CURRENT = Field("current", 4, 2, True, -32768, 32767, "ma", "mA", 1.0, "current, on the scale of the command")

FAMILY = Family(
    name="c610",
    about="DJI C610 speed controllers with M2006 motors",
    full_scale_raw=MAX_RAW,
    full_scale_a=FULL_SCALE_A,
    commands=(
        command(0, kind="C610", low=-MAX_RAW, high=MAX_RAW, suffix="ma", unit="mA", scale=1.0),
        command(1, kind="C610", low=-MAX_RAW, high=MAX_RAW, suffix="ma", unit="mA", scale=1.0),
    ),
    feedback=tuple(feedback(number, kind="C610", current=_CURRENT) for number in range(1, ESCS + 1)),
    others=(
        Message(
            name="C610_QuickId",
            can_id=QUICK_ID,
            sender=CONTROLLER,
            receivers=tuple(esc_name(number) for number in range(1, ESCS + 1)),
            fields=(),
            exact=True,
            about="Eight zero bytes put every ESC into quick-ID mode. From the maker's examples, not in the manual.",
        ),
    ),
)
