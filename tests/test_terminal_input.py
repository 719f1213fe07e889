"""Bytes of a terminal to events. Vectors: the examples of Kitty's keyboard protocol page, xterm's ctlseqs, ECMA-48."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.screen.terminal_input import (
    DOWN,
    MOVE,
    RELEASE,
    REPEAT,
    UP,
    WHEEL_DOWN,
    WHEEL_UP,
    CursorAt,
    Focus,
    InputDecoder,
    Key,
    KittyFlags,
    Mode,
    Mouse,
    Pasted,
)

VECTORS = [
    (b"w", Key("w", "w")), (b"W", Key("W", "W")), (b" ", Key("space", " ")), (b"\r", Key("enter", "\r")),
    (b"\t", Key("tab", "\t")), (b"\x7f", Key("backspace", "\x7f")), (b"\x11", Key("ctrl+q", "\x11")),
    ("é".encode(), Key("é", "é")), ("ю".encode(), Key("ю", "ю")), ("€".encode(), Key("€", "€")),
    (b"\x1b[A", Key("up")), (b"\x1bOA", Key("up")), (b"\x1b[1;1B", Key("down")), (b"\x1b[1;5C", Key("ctrl+right")),
    (b"\x1b[3~", Key("delete")), (b"\x1b[5;5~", Key("ctrl+pageup")), (b"\x1bOP", Key("f1")), (b"\x1b[15~", Key("f5")),
    (b"\x1b[H", Key("home")), (b"\x1b[F", Key("end")), (b"\x1b[Z", Key("shift+tab")), (b"\x1bx", Key("alt+x")),
    (b"\x1b[97u", Key("a", "a")), (b"\x1b[97;2u", Key("A", "A")), (b"\x1b[97;2;65u", Key("A", "A")),
    (b"\x1b[97;1:1;97u", Key("a", "a")), (b"\x1b[97;1:2;97u", Key("a", "a", REPEAT)),
    (b"\x1b[97;1:3u", Key("a", None, RELEASE)), (b"\x1b[97;2:3u", Key("a", None, RELEASE)),
    (b"\x1b[97;5u", Key("ctrl+a")), (b"\x1b[97;129u", Key("a", "a")), (b"\x1b[97:65;2;65u", Key("A", "A")),
    (b"\x1b[27u", Key("escape")), (b"\x1b[13u", Key("enter", "\r")), (b"\x1b[13;1:3u", Key("enter", "\r", RELEASE)),
    (b"\x1b[32u", Key("space", " ")), (b"\x1b[32;1:2;32u", Key("space", " ", REPEAT)),
    (b"\x1b[127u", Key("backspace", None)),
    (b"\x1b[1;1:3A", Key("up", None, RELEASE)), (b"\x1b[1;1:2D", Key("left", None, REPEAT)),
    (b"\x1b[57417u", Key("left")), (b"\x1b[57413;;43u", Key("+", "+")), (b"\x1b[27;5;113~", Key("ctrl+q")),
    (b"\x1b[<0;19;4M", Mouse(DOWN, 18, 3, 1)), (b"\x1b[<32;12;9M", Mouse(MOVE, 11, 8, 1)),
    (b"\x1b[<0;12;9m", Mouse(UP, 11, 8, 1)), (b"\x1b[<2;1;1M", Mouse(DOWN, 0, 0, 3)),
    (b"\x1b[<64;5;6M", Mouse(WHEEL_UP, 4, 5, 0)), (b"\x1b[<65;5;6M", Mouse(WHEEL_DOWN, 4, 5, 0)),
    (b"\x1b[I", Focus(True)), (b"\x1b[O", Focus(False)), (b"\x1b[?27u", KittyFlags(27)),
    (b"\x1b[2;17R", CursorAt(2, 17)),
    (b"\x1b[?2026;2$y", Mode(2026, 2)), (b"\x1b[200~wsad \r\x1b[201~", Pasted("wsad \n")),
]  # fmt: skip
NOISE = [
    b"\xff", b"\x80", b"\xc3(", b"\xf8\x88", b"\xed\xa0\x80", b"\x1b[", b"\x1b[1;", b"\x1b[97;1:9u",
    b"\x1b[97;1:1:1:1:u",
    b"\x1b[99999999999999999999u", b"\x1b[1114112u", b"\x1b[55296u", b"\x1b[57441u", b"\x1b[;;;;u", b"\x1b[-1u",
    b"\x1b[~", b"\x1b[999~", b"\x1b[<0;0;0M", b"\x1b[<0;19M", b"\x1b[<;;M", b"\x1b[<99999999;1;1M",
    b"\x1b[<0;-3;4M", b"\x1b[48;99999;99999;1;1t", b"\x1b[?62;c", b"\x1b[>1;2c", b"\x1b[?2026$y", b"\x1b[R", b"\x1b[;R",
    b"\x1b]52;c;d3dk\x07", b"\x1b]11;rgb:0/0/0\x1b\\", b"\x1bP>|kitty(0.35)\x1b\\", b"\x1b[" + b"1" * 5000 + b"u",
]  # fmt: skip


def events(data, chunk=None):
    decoder = InputDecoder()
    pieces = [data] if chunk is None else [data[i : i + chunk] for i in range(0, len(data), chunk)]
    return [event for piece in pieces for event in decoder.feed(piece)]


@pytest.mark.parametrize(("data", "event"), VECTORS)
def test_what_terminals_send_whole_and_byte_by_byte(data, event):
    assert events(data) == [event]
    if data[0] != 0x1B or b" " not in data:  # a blank that comes alone within a paste is the key
        assert events(data, 1) == [event]


@pytest.mark.parametrize("data", NOISE)
def test_noise_is_no_key_and_space_behind_it_is_one(data):
    decoder = InputDecoder()
    heard = decoder.feed(data) + decoder.settle()
    assert not [event for event in heard if isinstance(event, Key) and event.name not in ("(", "escape")]
    assert decoder.feed(b" ") == [Key("space", " ")]


@pytest.mark.parametrize(
    "data", [b"\x1b[", b"\x1b[1;", b"\x1b[97;1:1", b"\x1b[<0;1", b"\x1bO", b"\xe2\x82", b"\x1b[200~abc"]
)
def test_space_is_heard_behind_anything_unfinished_without_a_pause(data):
    decoder = InputDecoder()
    decoder.feed(data)
    assert decoder.feed(b" ")[-1] == Key("space", " ")


def test_a_lone_escape_is_the_key_after_a_pause():
    decoder = InputDecoder()
    assert decoder.feed(b"\x1b") == []
    assert decoder.waiting
    assert decoder.settle(100) == [Key("escape", "\x1b")]
    assert not decoder.waiting


def test_a_paste_that_never_ends_does_not_swallow_keys_for_ever():
    decoder = InputDecoder()
    assert decoder.feed(b"\x1b[200~wwww") == []
    assert decoder.settle(500) == []
    assert decoder.settle(1000) == [Pasted("wwww")]
    assert decoder.feed(b"w") == [Key("w", "w")]


def test_a_key_of_the_protocol_is_heard_even_within_a_paste():
    assert events(b"\x1b[200~wq\x1b[32u")[-1] == Key("space", " ")


PIECES = st.lists(
    st.one_of(st.binary(max_size=12), st.sampled_from([data for data, _ in VECTORS] + NOISE)), max_size=12
).map(b"".join)


@given(PIECES, st.lists(st.integers(1, 9), max_size=20))
def test_any_bytes_give_the_same_however_they_are_cut_and_never_raise(data, cuts):
    if b" " in data:  # alone within a paste it means the key, and only then
        data = data.replace(b"\x1b[200~", b"")
    decoder, out, start = InputDecoder(), [], 0
    for cut in [*cuts, len(data)]:
        out += decoder.feed(data[start : start + cut])
        start += cut
    assert out == events(data)
    assert len(decoder._buffer) <= 64
    for event in out:
        assert isinstance(event, (Key, Mouse, Focus, CursorAt, KittyFlags, Mode, Pasted))
        if isinstance(event, Mouse):
            assert 0 <= event.x < 99999
            assert 0 <= event.y < 99999
