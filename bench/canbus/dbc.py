"""A family's messages as a DBC file, for SavvyCAN, cantools, CANalyzer and whatever else reads one.

Written from the table that the codec uses, so the file and the bench cannot disagree. Signals are Motorola (big-endian)
with their start bit at the most significant one, as DBC counts it.
"""

from __future__ import annotations

from bench.canbus.table import Family, Field, Message

CYCLE_TIME = "GenMsgCycleTime"


def dbc(family: Family, about: str = "") -> str:
    """The whole file as text, ASCII, one message after the other in the order of identifiers."""
    messages = family.messages
    nodes = dict.fromkeys(name for message in messages for name in (message.sender, *message.receivers))
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", f"BU_: {' '.join(sorted(nodes))}", ""]
    for message in messages:
        lines.append(f"BO_ {message.can_id} {message.name}: {message.length} {message.sender}")
        lines += [_signal(message, index) for index in range(len(message.fields))]
        lines.append("")
    lines.append(f"CM_ {_text(about or family.about)};")
    for message in messages:
        if message.about:
            lines.append(f"CM_ BO_ {message.can_id} {_text(message.about)};")
        lines += [f"CM_ SG_ {message.can_id} {one.name} {_text(one.about)};" for one in message.fields if one.about]
    lines.append(f'BA_DEF_ BO_ "{CYCLE_TIME}" INT 0 3600000;')
    lines.append(f'BA_DEF_DEF_ "{CYCLE_TIME}" 0;')
    lines += [f'BA_ "{CYCLE_TIME}" BO_ {one.can_id} {one.period_ms};' for one in messages if one.period_ms]
    for message in messages:
        lines += [_values(message, one) for one in message.fields if one.words]
    return "\n".join(lines) + "\n"


def _signal(message: Message, index: int) -> str:
    one = message.fields[index]
    # In a group command each slot is for one motor; everything else is for all who listen.
    slots = len(message.receivers) == len(message.fields) > 1
    receivers = message.receivers[index] if slots else ",".join(message.receivers)
    start = 8 * one.first_byte + 7
    sign = "-" if one.signed else "+"
    limits = f"{_number(one.low * one.scale)}|{_number(one.high * one.scale)}"
    return (
        f' SG_ {one.name} : {start}|{8 * one.size}@0{sign} ({_factor(one.scale)},0) [{limits}] "{one.unit}" {receivers}'
    )


def _values(message: Message, one: Field) -> str:
    words = " ".join(f"{value} {_text(word)}" for value, word in sorted(one.words.items()))
    return f"VAL_ {message.can_id} {one.name} {words} ;"


def _factor(value: float) -> str:
    """Exact: what is read back is the same float."""
    return repr(value).removesuffix(".0")


def _number(value: float) -> str:
    return f"{value:.12g}"


def _text(words: str) -> str:
    """A quoted string; a DBC has no way to escape a quote."""
    return '"' + words.replace('"', "'") + '"'
