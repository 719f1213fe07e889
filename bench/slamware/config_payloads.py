"""How a base is built, on the control bus: 0x20 as a fixed table, 0x21 as the vendor's tagged tree.

    0x20  u8 shape (0 round, 1 square) | u32 radius, Q8 mm | u8 drive (0 two wheels, 1 three or more)
          u8 distance sensors | 8 x position | u8 bumpers | 8 x position
    position: s32 x | s32 y | s32 z, Q8 mm | u32 angle, Q8 degrees counter-clockwise

    0x21  10 u8 | 11 u16 | 20 float32 | 30 n text | 31 symbol | 40 n array | 50 n (key, value) object | 60 true

0x21 is meant to be handed on unchanged; the tree was read off the reference base's own answer, in metres and radians.
What the tool calls a distance sensor in it is not known, so a tree made here has bumpers only, and 0x20 has both.
Drive 1 is no vendor's: a public three-wheel base derived from the vendor's uses it.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple, TypeAlias

ROUND, SQUARE = 0, 1
TWO_WHEELS, OMNI = 0, 1
POSITIONS = 8

_HEAD = struct.Struct("<BIBB")
_POSITION = struct.Struct("<3iI")
CONFIGURATION_BYTES = _HEAD.size + 1 + 2 * POSITIONS * _POSITION.size
_Q8 = 256.0

# Keys of the tree, as far as they are known.
BASE, MANUFACTURER_ID, MANUFACTURER, MODEL_ID, MODEL, HARDWARE_VERSION, SIZE = range(7)
CHARGE_BELOW, CHARGED_ABOVE, AUTO_HOMING, SENSORS, TYPE, BUMPER, POSE = range(0x07, 0x0E)
X, Y, Z, YAW = range(0x0E, 0x12)
CLIFF, FEATURE, DOCK_TOWER, LIDAR, ID, MOTION_PLAN, BUMP_STRATEGY, DEFAULT = 0x14, 0x16, 0x17, 0x18, *range(0x19, 0x1D)
SIDE_MARGIN = 0x1E

_U8, _U16, _FLOAT, _TEXT, _SYMBOL, _ARRAY, _OBJECT, _TRUE = 0x10, 0x11, 0x20, 0x30, 0x31, 0x40, 0x50, 0x60
_DEEPEST = 16
_FLOAT32 = struct.Struct("<f")


class Position(NamedTuple):
    """Where something sits on the robot, from its centre, and where it looks."""

    x_m: float
    y_m: float
    z_m: float
    heading_rad: float


class BaseConfiguration(NamedTuple):
    """The answer to 0x20. Of more than eight sensors or bumpers the first eight are told."""

    shape: int
    radius_m: float
    drive: int
    range_sensors: tuple[Position, ...]
    bumpers: tuple[Position, ...]


class Symbol(NamedTuple):
    """A one-byte word of the tree."""

    number: int


Tree: TypeAlias = "int | float | str | bool | Symbol | list[Tree] | dict[int, Tree]"


def configuration_answer(configuration: BaseConfiguration) -> bytes:
    """264 bytes."""
    shape, radius_m, drive, range_sensors, bumpers = configuration
    sensors, strips = range_sensors[:POSITIONS], bumpers[:POSITIONS]
    head = _HEAD.pack(shape, round(radius_m * 1000.0 * _Q8), drive, len(sensors))
    return head + _positions(sensors) + bytes((len(strips),)) + _positions(strips)


def configuration_from_answer(payload: bytes) -> BaseConfiguration:
    """The configuration out of at least 264 bytes; counts above eight are read as eight."""
    shape, radius_q8, drive, sensors = _HEAD.unpack_from(payload)
    bumpers_at = _HEAD.size + POSITIONS * _POSITION.size
    return BaseConfiguration(
        shape,
        radius_q8 / _Q8 / 1000.0,
        drive,
        _positions_from(payload, _HEAD.size, sensors),
        _positions_from(payload, bumpers_at + 1, payload[bumpers_at]),
    )


def encode_tree(tree: Tree) -> bytes:
    """The tagged tree of 0x21. Raises ValueError where a value has no tag or does not fit."""
    if tree is True:
        return bytes((_TRUE,))
    if isinstance(tree, Symbol):
        return bytes((_SYMBOL, tree.number))
    if isinstance(tree, int) and tree is not False and 0 <= tree <= 0xFFFF:
        return bytes((_U8, tree)) if tree <= 0xFF else bytes((_U16, tree & 0xFF, tree >> 8))
    if isinstance(tree, float):
        return bytes((_FLOAT,)) + _FLOAT32.pack(tree)
    if isinstance(tree, str) and len(tree) <= 0xFF and tree.isascii():
        return bytes((_TEXT, len(tree))) + tree.encode()
    if isinstance(tree, list) and len(tree) <= 0xFF:
        return bytes((_ARRAY, len(tree))) + b"".join(map(encode_tree, tree))
    if isinstance(tree, dict) and len(tree) <= 0xFF:
        pairs = (bytes((key,)) + encode_tree(value) for key, value in tree.items())
        return bytes((_OBJECT, len(tree))) + b"".join(pairs)
    raise ValueError(f"{tree!r} does not fit into the tree of a binary configuration")


def decode_tree(data: bytes) -> Tree | None:
    """The tree out of an answer to 0x21; None where it is none, has an unknown tag or is deeper than 16."""
    try:
        tree, end = _value(data, 0, 0)
    except (IndexError, struct.error, _NotATree):
        return None
    return tree if end == len(data) else None


class _NotATree(Exception):
    """An unknown tag, or too deep."""


def _value(data: bytes, at: int, depth: int) -> tuple[Tree, int]:
    tag = data[at]
    at += 1
    if tag == _TRUE:
        return True, at
    if tag == _U8:
        return data[at], at + 1
    if tag == _SYMBOL:
        return Symbol(data[at]), at + 1
    if tag == _U16:
        return data[at] | data[at + 1] << 8, at + 2
    if tag == _FLOAT:
        return _FLOAT32.unpack_from(data, at)[0], at + _FLOAT32.size
    if depth == _DEEPEST:
        raise _NotATree
    count = data[at]
    at += 1
    if tag == _TEXT:
        if at + count > len(data):
            raise _NotATree
        return data[at : at + count].decode("latin-1"), at + count
    if tag == _ARRAY:
        entries: list[Tree] = []
        for _ in range(count):
            entry, at = _value(data, at, depth + 1)
            entries.append(entry)
        return entries, at
    if tag == _OBJECT:
        fields: dict[int, Tree] = {}
        for _ in range(count):
            key = data[at]
            fields[key], at = _value(data, at + 1, depth + 1)
        return fields, at
    raise _NotATree


def _positions(positions: tuple[Position, ...]) -> bytes:
    packed = b"".join(
        _POSITION.pack(
            *(round(value_m * 1000.0 * _Q8) for value_m in position[:3]),
            round(math.degrees(position.heading_rad) * _Q8) % round(360.0 * _Q8),
        )
        for position in positions
    )
    return packed.ljust(POSITIONS * _POSITION.size, b"\0")


def _positions_from(payload: bytes, at: int, count: int) -> tuple[Position, ...]:
    found = []
    for _ in range(min(count, POSITIONS)):
        x_q8, y_q8, z_q8, angle_q8 = _POSITION.unpack_from(payload, at)
        x_m, y_m, z_m = (value_q8 / _Q8 / 1000.0 for value_q8 in (x_q8, y_q8, z_q8))
        found.append(Position(x_m, y_m, z_m, math.radians(angle_q8 / _Q8)))
        at += _POSITION.size
    return tuple(found)
