"""What a terminal sends, as events: bytes in, values out. Never raises, in bounded memory. No Textual, no clock.

    w  é  \\r                     plain keys, UTF-8, control characters
    ESC [ 119 ; 2 : 3 ; 87 u      Kitty's keyboard protocol: key, modifiers, 1 press 2 repeat 3 release, text
    ESC [ 1 ; 5 A    ESC O A      arrows and function keys, in both of their old forms
    ESC [ < 32 ; 10 ; 4 M         the mouse (SGR): button and movement, column, row, M down or m up
    ESC [ I    ESC [ O            the window has the focus, has lost it
    ESC [ ? 27 u                  answer: which of Kitty's flags are on
    ESC [ 2 ; 17 R                answer: where the cursor stands, which is how a terminal proves that it is alive
    ESC [ 200 ~ ... ESC [ 201 ~   pasted text, which nobody typed

Sources: ECMA-48 for the grammar, xterm's ctlseqs, https://sw.kovidgoyal.net/kitty/keyboard-protocol/. What does not fit
is dropped and counted; it never becomes a key. A blank ends an unfinished sequence and counts as the key that it is,
because it is the one that stops the robot.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, TypeAlias

PRESS, REPEAT, RELEASE = "press", "repeat", "release"
DOWN, MOVE, UP, WHEEL_UP, WHEEL_DOWN = "down", "move", "up", "wheel up", "wheel down"
MOST_PARAMETERS = 64
"""Longer control sequences than any terminal sends to a program that has asked for ours are noise."""
MOST_STRING = 4096
MOST_PASTED = 4096
PASTE_ENDS_MS = 1000
"""A paste whose end has not come after such a pause is over: it must not swallow keys for ever."""
BIGGEST_NUMBER = 0x10FFFF
FLAG_EVENT_TYPES = 2
"""Kitty's flag: tell repeats and releases."""


class Key(NamedTuple):
    """A key: its name (`w`, `W`, `space`, `up`, `ctrl+q`), the character it gives, and what it did."""

    name: str
    character: str | None = None
    kind: str = PRESS


class Mouse(NamedTuple):
    """The mouse at a cell, both counted from 0. `button` is 1 left, 2 middle, 3 right, 0 none."""

    kind: str
    x: int
    y: int
    button: int


class Focus(NamedTuple):
    """The terminal's window has the keyboard, or another one."""

    here: bool


class CursorAt(NamedTuple):
    """The terminal says where its cursor stands, both counted from 1 as on the wire."""

    row: int
    column: int


class KittyFlags(NamedTuple):
    """The terminal speaks Kitty's keyboard protocol, with these flags on."""

    flags: int


class Mode(NamedTuple):
    """What the terminal says of one of its private modes (DECRPM): 0 unknown, 1 set, 2 reset, 3 and 4 for ever so."""

    number: int
    setting: int


class Pasted(NamedTuple):
    """Text that was pasted. Nobody typed it: it drives nothing."""

    text: str


Input: TypeAlias = Key | Mouse | Focus | CursorAt | KittyFlags | Mode | Pasted

_CONTROL_NAMES = {0x0D: "enter", 0x09: "tab", 0x08: "backspace", 0x7F: "backspace", 0x00: "ctrl+@"} | {
    0x1C: "ctrl+backslash", 0x1D: "ctrl+right_square_bracket", 0x1E: "ctrl+circumflex_accent",
    0x1F: "ctrl+underscore",
}  # fmt: skip
_CONTROL_CHARACTERS = {"enter": "\r", "tab": "\t", "backspace": "\x7f"}
_BY_LETTER = {
    "A": "up", "B": "down", "C": "right", "D": "left", "H": "home", "F": "end", "P": "f1", "Q": "f2", "R": "f3",
    "S": "f4", "E": "center",
}  # fmt: skip
_BY_NUMBER = {
    1: "home", 2: "insert", 3: "delete", 4: "end", 5: "pageup", 6: "pagedown", 7: "home", 8: "end", 11: "f1",
    12: "f2", 13: "f3", 14: "f4", 15: "f5", 17: "f6", 18: "f7", 19: "f8", 20: "f9", 21: "f10", 23: "f11", 24: "f12",
}  # fmt: skip
_BY_CODE = {27: "escape", 13: "enter", 9: "tab", 127: "backspace", 32: "space", 57414: "enter"} | {
    57417: "left", 57418: "right", 57419: "up", 57420: "down", 57421: "pageup", 57422: "pagedown", 57423: "home",
    57424: "end", 57425: "insert", 57426: "delete",
}  # fmt: skip
_KEYPAD = {57399 + i: sign for i, sign in enumerate("0123456789./*-+")} | {57415: "=", 57416: ","}
_PRIVATE_USE = range(0xE000, 0xF900)
"""Kitty's codes for keys without a character: lone modifiers, media keys. None of them is ours."""
_SHIFT, _ALT, _CTRL, _SUPER, _HYPER, _META = 1, 2, 4, 8, 16, 32
_PREFIXES = ((_ALT, "alt"), (_CTRL, "ctrl"), (_HYPER, "hyper"), (_META, "meta"), (_SHIFT, "shift"), (_SUPER, "super"))
_KINDS = {1: PRESS, 2: REPEAT, 3: RELEASE}


class _State(Enum):
    GROUND, ESCAPE, CSI, SS3, STRING, UTF8 = range(6)


class _Paste(Enum):
    BEGINS, ENDS = range(2)


class InputDecoder:
    """Finds events in what a terminal sends. `feed` takes any bytes, cut anywhere; `settle` says that a pause came.

    `dropped` counts sequences and bytes that were no event.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._state = _State.GROUND
        self._buffer = bytearray()
        self._wanted = 0  # bytes that a UTF-8 character still lacks
        self._length = 0  # of a string
        self._paste: list[str] | None = None
        self._pasted = 0

    @property
    def waiting(self) -> bool:
        """Whether something has begun and not ended: call `settle` when a pause follows."""
        return self._state is not _State.GROUND or self._paste is not None

    def feed(self, data: bytes) -> list[Input]:
        """The events in some more bytes."""
        out: list[Input] = []
        if self._paste is not None and data == b" ":  # pasted text does not come a blank at a time: this is the key
            self._paste = None
        for byte in data:
            while not self._take(byte, out):
                pass
        return out

    def settle(self, pause_ms: int = PASTE_ENDS_MS) -> list[Input]:
        """Nothing has followed for so long: a lone ESC was the key, an unfinished sequence was noise."""
        out: list[Input] = []
        if self._state is _State.ESCAPE:
            self._key(out, Key("escape", "\x1b"))
        elif self._state is not _State.GROUND:
            self.dropped += 1
        self._to(_State.GROUND)
        if pause_ms >= PASTE_ENDS_MS:
            self._end_paste(out)
        return out

    # --- the states; each says whether it has taken the byte, else the next state looks at it -----------------------

    def _take(self, byte: int, out: list[Input]) -> bool:
        state = self._state
        if state is _State.GROUND:
            return self._ground(byte, out)
        if state is _State.CSI:
            return self._csi(byte, out)
        if state is _State.ESCAPE:
            return self._escape(byte, out)
        if state is _State.UTF8:
            return self._utf8(byte, out)
        return self._ss3(byte, out) if state is _State.SS3 else self._string(byte)

    def _ground(self, byte: int, out: list[Input]) -> bool:
        if byte == 0x1B:
            self._to(_State.ESCAPE)
        elif byte < 0x80:
            self._key(out, _ascii_key(byte))
        elif 0xC2 <= byte <= 0xF4:
            self._to(_State.UTF8)
            self._buffer.append(byte)
            self._wanted = 1 if byte < 0xE0 else 2 if byte < 0xF0 else 3
        else:
            self.dropped += 1
        return True

    def _escape(self, byte: int, out: list[Input]) -> bool:
        if byte == 0x1B:
            self._key(out, Key("escape", "\x1b"))
            return True
        if byte == 0x5B:  # [
            self._to(_State.CSI)
            return True
        if byte == 0x4F:  # O
            self._to(_State.SS3)
            return True
        if byte in b"]P_^X":
            self._to(_State.STRING)
            return True
        self._to(_State.GROUND)
        if byte < 0x80:
            key = _ascii_key(byte)
            self._key(out, Key("alt+" + key.name))
            return True
        self._key(out, Key("escape", "\x1b"))
        return False

    def _csi(self, byte: int, out: list[Input]) -> bool:
        if 0x40 <= byte <= 0x7E:
            parameters = self._buffer.decode("ascii")
            self._to(_State.GROUND)
            event = _control_sequence(parameters, chr(byte))
            if event is _Paste.BEGINS:
                self._paste, self._pasted = [], 0
            elif event is _Paste.ENDS:
                self._end_paste(out)
            elif event is None:
                self.dropped += 1
            else:
                out.append(event)
            return True
        if 0x21 <= byte <= 0x3F:
            if len(self._buffer) < MOST_PARAMETERS:
                self._buffer.append(byte)
            else:
                self._buffer[0] = 0x21  # too long to mean anything; its end is awaited all the same
            return True
        self.dropped += 1
        self._to(_State.GROUND)
        return False

    def _ss3(self, byte: int, out: list[Input]) -> bool:
        self._to(_State.GROUND)
        name = "enter" if byte == 0x4D else _BY_LETTER.get(chr(byte))
        if name is None:
            self.dropped += 1
            return not (byte < 0x21 or byte >= 0x7F)
        self._key(out, Key(name, _CONTROL_CHARACTERS.get(name)))
        return True

    def _string(self, byte: int) -> bool:
        """An answer of a kind that we never ask for: skipped up to its end."""
        self._length += 1
        if byte == 0x07 or self._length > MOST_STRING:
            self._to(_State.GROUND)
            self.dropped += 1
        elif byte == 0x1B:  # ESC \ ends it; any other sequence is a sequence
            self._to(_State.STRING)
            self._length = MOST_STRING
        elif self._length == MOST_STRING + 1 and byte != 0x5C:
            self._to(_State.ESCAPE)
            return False
        return True

    def _utf8(self, byte: int, out: list[Input]) -> bool:
        if byte & 0xC0 != 0x80:
            self.dropped += 1
            self._to(_State.GROUND)
            return False
        self._buffer.append(byte)
        self._wanted -= 1
        if not self._wanted:
            try:
                character = self._buffer.decode("utf-8")
            except UnicodeDecodeError:
                character = ""
            self._to(_State.GROUND)
            if character.isprintable() and character:
                self._key(out, Key(character, character))
            else:
                self.dropped += 1
        return True

    # --- within ----------------------------------------------------------------------------------------------------

    def _to(self, state: _State) -> None:
        self._state = state
        self._buffer.clear()
        self._length = 0

    def _key(self, out: list[Input], key: Key) -> None:
        if self._paste is None:
            out.append(key)
            return
        self._pasted += 1
        if self._pasted <= MOST_PASTED:
            self._paste.append("\n" if key.name == "enter" else key.character or "")

    def _end_paste(self, out: list[Input]) -> None:
        if self._paste is not None:
            out.append(Pasted("".join(self._paste)))
            self._paste = None


def _ascii_key(byte: int) -> Key:
    if byte == 0x20:
        return Key("space", " ")
    if 0x20 < byte < 0x7F:
        return Key(chr(byte), chr(byte))
    if byte == 0x1B:
        return Key("escape", "\x1b")
    name = _CONTROL_NAMES.get(byte) or f"ctrl+{chr(byte + 0x60)}"
    return Key(name, _CONTROL_CHARACTERS.get(name, chr(byte)))


def _control_sequence(parameters: str, end: str) -> Input | _Paste | None:
    """The event of one control sequence, a mark of a paste, or None."""
    mark, rest = (parameters[0], parameters[1:]) if parameters[:1] in ("<", "?", ">", "=") else ("", parameters)
    if mark == "<":
        return _mouse(rest, end) if end in "Mm" else None
    if mark == "?":
        return _answer(rest, end)
    if mark:
        return None
    if not rest and end in "IO":
        return Focus(end == "I")
    if end == "R":
        return _cursor(rest)
    if end == "Z" and rest in ("", "1"):
        return Key("shift+tab")
    if end == "~" and rest in ("200", "201"):
        return _Paste.BEGINS if rest == "200" else _Paste.ENDS
    return _key(rest, end)


def _numbers(text: str) -> list[int] | None:
    """Numbers between colons; what is empty is 0. None where something else stands there."""
    numbers = [int(part) if part.isdecimal() and len(part) <= 7 else 0 if not part else -1 for part in text.split(":")]
    return numbers if all(0 <= number <= BIGGEST_NUMBER for number in numbers) else None


def _key(rest: str, end: str) -> Key | None:
    fields = [_numbers(field) for field in rest.split(";")]
    if len(fields) > 3 or any(field is None for field in fields) or (fields[1:2] and len(fields[1] or ()) > 2):
        return None
    first, modified, typed = ([field or [0] for field in fields] + [[0], [0]])[:3] if fields else ([0], [0], [0])
    kind = _KINDS.get(modified[1] if len(modified) > 1 else 1)
    if kind is None:
        return None
    modifiers = max(0, modified[0] - 1)
    text = "".join(chr(code) for code in typed if code and not 0xD800 <= code <= 0xDFFF)
    if end == "u":
        return _kitty_key(first[0], modifiers, text, kind)
    if end == "~" and first[0] == 27 and len(fields) == 3:  # xterm's other way: 27 ; modifiers ; code
        return _kitty_key(typed[0], modifiers, "", kind)
    name = _BY_NUMBER.get(first[0]) if end == "~" else _BY_LETTER.get(end) if first[0] in (0, 1) else None
    return Key(_prefixed(name, modifiers), None, kind) if name else None


def _kitty_key(code: int, modifiers: int, text: str, kind: str) -> Key | None:
    modifiers &= 63  # caps lock and num lock are no part of a key's name
    if name := _BY_CODE.get(code):
        character = {"space": " ", "enter": "\r", "tab": "\t"}.get(name) if not modifiers & ~_SHIFT else None
        return Key(_prefixed(name, modifiers), character, kind)
    plain = _KEYPAD.get(code) or (chr(code) if code > 0x20 and not 0xD800 <= code <= 0xDFFF else "")
    if not plain or (code in _PRIVATE_USE and code not in _KEYPAD) or not plain.isprintable():
        return None
    if kind == RELEASE:  # by the key itself: what it would have typed may have changed since
        return Key(plain, None, kind)
    if not modifiers & ~_SHIFT:
        typed = text if len(text) == 1 and text.isprintable() else plain.upper() if modifiers & _SHIFT else plain
        return Key(typed, typed, kind) if len(typed) == 1 else Key(plain, plain, kind)
    return Key(_prefixed(plain, modifiers), None, kind)


def _prefixed(name: str, modifiers: int) -> str:
    return "+".join([*(prefix for bit, prefix in _PREFIXES if modifiers & bit), name])


def _mouse(rest: str, end: str) -> Mouse | None:
    fields = rest.split(";")
    if len(fields) != 3 or not all(field.isdecimal() and 0 < len(field) <= 5 for field in fields):
        return None
    code, column, row = map(int, fields)
    if column < 1 or row < 1:
        return None
    if code & 64:
        return Mouse(WHEEL_DOWN if code & 1 else WHEEL_UP, column - 1, row - 1, 0) if not code & 2 else None
    button = (code + 1) & 3
    kind = MOVE if code & 32 else DOWN if end == "M" else UP
    return Mouse(kind, column - 1, row - 1, button)


def _cursor(rest: str) -> CursorAt | None:
    row, _, column = rest.partition(";")
    if all(part.isdecimal() and len(part) <= 5 for part in (row, column)):
        return CursorAt(int(row), int(column))
    return None


def _answer(rest: str, end: str) -> Input | None:
    if end == "u" and rest.isdecimal() and len(rest) <= 3:
        return KittyFlags(int(rest))
    number, _, setting = rest.removesuffix("$").partition(";")
    if end == "y" and rest.endswith("$") and all(part.isdecimal() and len(part) <= 5 for part in (number, setting)):
        return Mode(int(number), int(setting))
    return None
