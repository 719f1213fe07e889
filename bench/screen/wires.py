"""The last frame of each wire in words, one line each: how old it is and what it says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from bench import m2006
from bench.canbus.c610 import COMMAND_IDS
from bench.canbus.instruments import GYRO_ID, GYROS, RATE_PER_RADPS, gyro
from bench.messages import CanFrame
from bench.motors import family
from bench.screen.scene import Scene
from bench.screen.text import LABEL, PLAIN, Line, age, hexed
from bench.slamware import summary

T = TypeVar("T")

NAME_WIDTH = 8
GYRO_IDS = range(GYRO_ID + 1, GYRO_ID + GYROS + 1)
AGE_WIDTH = 7
USUAL = "201 -9999/-999"
"""As much as an ESC says of its speed and current, in few words."""


def wires(scene: Scene, width: int, height: int) -> list[Line]:
    """RC, CAN both ways, the control bus both ways; with a heading where there is room for it."""
    last = scene.wires
    room = width - 1 - NAME_WIDTH - AGE_WIDTH - 2 - 1
    now = scene.snapshot.tick - 1
    # An answer does not say what it answers: the request before it does.
    asked = getattr(last.core_to_base[1], "payload", b"") if last.core_to_base is not None else b""
    ma_per_raw = 1000.0 / family(scene.robot).raw_per_a
    lines = [
        _line("rc", now, last.rc, lambda data: _rc(scene, data, room)),
        _line("command", now, last.can_commands, lambda frames: _commands(frames, ma_per_raw)),
        _line("feedback", now, last.can_feedback, lambda frames: _feedback(frames, room, ma_per_raw)),
        _line("request", now, last.core_to_base, summary),
        _line("answer", now, last.base_to_core, lambda event: summary(event, asked)),
    ]
    if height > len(lines):
        lines.insert(0, [(f" {'wire':{NAME_WIDTH}}{'ago':>{AGE_WIDTH}}  last frame", LABEL)])
    return lines


def _line(name: str, now: int, last: tuple[int, T] | None, words: Callable[[T], str]) -> Line:
    old, text = (age(now - last[0]), words(last[1])) if last is not None else ("never", "")
    return [(f" {name:{NAME_WIDTH}}{old:>{AGE_WIDTH}}  ", LABEL), (text, PLAIN)]


def _rc(scene: Scene, data: bytes, room: int) -> str:
    frame = scene.snapshot.rc_frame
    channels = " ".join(map(str, frame.channels)) if frame else "no frame yet"
    raw = hexed(data)
    return f"{channels}   {raw}" if len(channels) + 3 + len(raw) <= room else channels


def _commands(frames: Sequence[CanFrame], ma_per_raw: float) -> str:
    parts = []
    for can_id, data in frames:
        raws = m2006.decode_command(data) if can_id in COMMAND_IDS else None
        words = " ".join(f"{raw * ma_per_raw:+5.0f}" for raw in raws) + " mA" if raws else hexed(data)
        parts.append(f"{can_id:03X} {words}")
    return "   ".join(parts)


def _feedback(frames: Sequence[CanFrame], room: int, ma_per_raw: float) -> str:
    """Every ESC's and encoder's frame, and a gyro's; with less room the units go first, then angle and current."""
    fields = [(can_id, m2006.decode_feedback(data)) for can_id, data in frames if can_id not in GYRO_IDS]
    wide, middle, narrow, speeds = [], [], [], []
    for can_id, values in fields:
        if values is None:
            return "   ".join(f"{one:03X} {data.hex(' ').upper()}" for one, data in frames)
        angle, rpm, raw = values
        current = round(raw * ma_per_raw)
        wide.append(f"{can_id:03X} {angle:4d} cnt {rpm:+6d} rpm {current:+5d} mA")
        middle.append(f"{can_id:03X} {rpm:+6d} rpm {current:+5d} mA")
        narrow.append(f"{can_id:03X} {rpm:+d}/{current:+d}")
        speeds.append(f"{can_id:03X} {rpm:+d}")
    turning = [f"{can_id:03X} {_gyro(can_id, data)}" for can_id, data in frames if can_id in GYRO_IDS]
    for parts in (wide, middle):
        text = "   ".join(parts + turning)
        if len(text) <= room:
            return text
    text = "  ".join([*turning, *narrow]) + " rpm/mA"
    # By the usual digits and not those of now: it would change its form with every turn of a wheel.
    usual = len("  ".join([*turning, *[USUAL] * len(narrow)]) + " rpm/mA")
    return text if max(usual, len(text)) <= room else "  ".join([*turning, *speeds]) + " rpm"


def _gyro(can_id: int, data: bytes) -> str:
    values = gyro(can_id - GYRO_ID).decode(data)
    return f"{values[0] / RATE_PER_RADPS:+.2f} rad/s" if values is not None else hexed(data)
