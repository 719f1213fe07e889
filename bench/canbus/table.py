"""Messages as data: one table per motor family, from which the codec, the words, the DBC and the documents' bytes come.

    Field    where a number lies in the eight bytes, its sign, range, unit and scale
    Message  an identifier, a length and its fields; `encode`, `decode`, `describe`, and the precompiled `layout`
    Family   the messages of one kind of motor, and what its currents are scaled by

All fields are big-endian. Decoding never raises and checks only what makes a frame another frame: its length, its
constants and, for an `exact` message, every byte. A value outside of its range comes out as it is on the wire, because
a peer that sends it is what a bench has to show; only `encode` refuses it.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

Described: TypeAlias = dict[str, int | str]


@dataclass(frozen=True, slots=True)
class Field:
    """One number of a message: `size` bytes from `first_byte` on, most significant first.

    `low` and `high` limit what may be sent, in counts. A count is worth `scale` of `unit`. `suffix` ends the field's
    name where people and JSON read it in counts: current_1 with suffix ma is current_1_ma. A field with `low == high`
    is a constant: a frame that has something else there is not this message.
    """

    name: str
    first_byte: int
    size: int
    signed: bool
    low: int
    high: int
    suffix: str = ""
    unit: str = ""
    scale: float = 1.0
    about: str = ""
    words: Mapping[int, str] = field(default_factory=dict)
    """What single values mean: an error's name."""

    @property
    def key(self) -> str:
        """The name under which `describe` has it: with its unit where it has one."""
        return f"{self.name}_{self.suffix}" if self.suffix else self.name

    @property
    def is_constant(self) -> bool:
        """True where only one value is possible."""
        return self.low == self.high

    @property
    def code(self) -> str:
        """Its letter for struct."""
        letter = {1: "B", 2: "H", 4: "I"}[self.size]
        return letter.lower() if self.signed else letter

    @property
    def place(self) -> str:
        """Its bytes in words: 6, or 0-1."""
        last = self.first_byte + self.size - 1
        return str(self.first_byte) if self.size == 1 else f"{self.first_byte}-{last}"


@dataclass(frozen=True, slots=True)
class Message:
    """One frame: identifier, length, who sends it, and its fields in byte order with zeros between them."""

    name: str
    can_id: int
    sender: str
    receivers: tuple[str, ...]
    fields: tuple[Field, ...]
    length: int = 8
    period_ms: int = 0
    """How often it comes unless configured otherwise; 0: on request."""
    about: str = ""
    exact: bool = False
    """True where a frame that is not byte for byte what we would send is not this message."""
    layout: struct.Struct = field(init=False, repr=False, compare=False)
    """All fields at once, for code that packs a thousand frames a second. Checks nothing."""
    variables: tuple[Field, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 0 <= self.can_id <= 0x7FF:
            raise ValueError(f"{self.name}: identifier {self.can_id:#x} outside 0..0x7ff")
        object.__setattr__(self, "layout", _compiled(self))
        object.__setattr__(self, "variables", tuple(one for one in self.fields if not one.is_constant))

    def encode(self, values: Sequence[int]) -> bytes:
        """The values of all fields but the constants, in byte order -> the frame's bytes. ValueError out of range."""
        given = iter(values)
        if len(values) != len(self.variables):
            raise ValueError(f"{self.name} has {len(self.variables)} values, got {len(values)}")
        return self.layout.pack(*(one.low if one.is_constant else _checked(one, next(given)) for one in self.fields))

    def decode(self, data: bytes) -> tuple[int, ...] | None:
        """The frame's bytes -> the values as they are on the wire; None where it is not this message."""
        if len(data) != self.length:
            return None
        values: tuple[int, ...] = self.layout.unpack(data)
        if self.exact and self.layout.pack(*values) != data:
            return None
        if len(self.variables) == len(values):
            return values
        if any(one.is_constant and one.low != value for one, value in zip(self.fields, values, strict=True)):
            return None
        return tuple(value for one, value in zip(self.fields, values, strict=True) if not one.is_constant)

    def describe(self, data: bytes) -> Described:
        """The fields by name, for people and for JSON; empty where the frame is not this message."""
        values = self.decode(data)
        if values is None:
            return {}
        if not values:
            return {"message": self.name}
        said: Described = {}
        for one, value in zip(self.variables, values, strict=True):
            said[one.key] = value
            if one.words:
                said[f"{one.name}_name"] = one.words.get(value, "unknown")
        return said

    def outside(self, values: Sequence[int]) -> tuple[str, ...]:
        """Names of the fields whose values no device of this family should send."""
        pairs = zip(self.variables, values, strict=True)
        return tuple(one.key for one, value in pairs if not one.low <= value <= one.high)


@dataclass(frozen=True, slots=True, eq=False)
class Family:
    """The messages of one kind of motor and speed controller on a bus of up to eight."""

    name: str
    about: str
    full_scale_raw: int
    """The largest current that a command may ask for, in counts."""
    full_scale_a: float
    """The same in A."""
    commands: tuple[Message, Message]
    """For controllers 1 to 4, and 5 to 8."""
    feedback: tuple[Message, ...]
    """Of controllers 1 to 8."""
    others: tuple[Message, ...] = ()
    alternatives: tuple[Message, ...] = ()
    """Other lengths of a message above that sources also have: decoded, never sent, not in a DBC."""
    _by_frame: Mapping[tuple[int, int], Message] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        known = {(one.can_id, one.length): one for one in (*self.messages, *self.alternatives)}
        object.__setattr__(self, "_by_frame", known)

    @property
    def messages(self) -> tuple[Message, ...]:
        """Everything that may be sent, in the order of identifiers."""
        return tuple(sorted((*self.commands, *self.feedback, *self.others), key=lambda one: one.can_id))

    @property
    def raw_per_a(self) -> float:
        """Counts for one ampere."""
        return self.full_scale_raw / self.full_scale_a

    def message(self, can_id: int, length: int = 8) -> Message | None:
        """The message with this identifier and length, if the family has one."""
        return self._by_frame.get((can_id, length))

    def describe(self, can_id: int, data: bytes) -> Described:
        """A frame's fields by name, for people and for JSON; empty for a frame that is none of this family's."""
        message = self._by_frame.get((can_id, len(data)))
        return message.describe(data) if message is not None else {}


def byte_table(message: Message) -> list[str]:
    """The message's bytes as lines of a Markdown table: the documents hold them, a test holds the documents to it."""
    lines = ["| Bytes | Field | Kind | Range | One count | Meaning |", "|---|---|---|---|---|---|"]
    at = 0
    for one in message.fields:
        if one.first_byte > at:
            lines.append(_padding(at, one.first_byte))
        at = one.first_byte + one.size
        kind = f"{'i' if one.signed else 'u'}{8 * one.size}"
        limits = f"always {one.low:#04x}" if one.is_constant else f"{one.low} .. {one.high}"
        count = f"{one.scale:.9g} {one.unit}" if one.unit not in ("", "counts") else ""
        lines.append(f"| {one.place} | {one.key} | {kind} | {limits} | {count} | {one.about} |")
    if at < message.length:
        lines.append(_padding(at, message.length))
    return lines


def _padding(start: int, end: int) -> str:
    place = str(start) if end == start + 1 else f"{start}-{end - 1}"
    return f"| {place} | | | sent as 0 | | not used |"


def _checked(one: Field, value: int) -> int:
    if not one.low <= value <= one.high:
        raise ValueError(f"{one.name} {value} outside {one.low}..{one.high}")
    return value


def _compiled(message: Message) -> struct.Struct:
    code, at = ">", 0
    for one in message.fields:
        if one.first_byte < at:
            raise ValueError(f"{message.name}: {one.name} overlaps the field before it")
        code += "x" * (one.first_byte - at) + one.code
        at = one.first_byte + one.size
    if at > message.length:
        raise ValueError(f"{message.name}: {at} bytes do not fit into {message.length}")
    return struct.Struct(code + "x" * (message.length - at))
