"""The scope's picture: a lane of braille for each signal, its scale at the left, the time below; and its menus."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache

from bench.io.scope import CAUGHT, FREE, MOST_TRACES, TRIGGERED, WAITING, ScopePicture
from bench.screen.canvas import Canvas
from bench.screen.scene import Menu, Scene
from bench.screen.text import (
    GOOD_BADGE,
    GRID,
    KEY,
    LABEL,
    OTHER_TRACE,
    PLAIN,
    TITLE,
    TRACE,
    WARN,
    WARN_BADGE,
    Line,
    both_ends,
    first_that_fits,
    fit,
    width_of,
)
from bench.screen.wiretable import WIDE_FROM, building

GUTTER = 9
"""Columns at the left for the scale."""
DIVISIONS = 10
LEAST_SPAN = 1e-3
"""Of a lane, in whatever unit: the last digits of a robot at rest are no signal."""
UNITS = {
    "radps": "rad/s", "mps": "m/s", "rad": "rad", "m": "m", "a": "A", "ms": "ms", "s": "s",
}  # fmt: skip
_STATES = {FREE: "runs free", TRIGGERED: "triggered", WAITING: "waits for its trigger", CAUGHT: "caught one"}
_SHORT = {FREE: "free", TRIGGERED: "triggered", WAITING: "waits", CAUGHT: "caught"}
_TRIGGER_WORDS = ("mode", "edge", "level", "time across")
_MENU_ROWS = 7


def scope(scene: Scene, width: int, height: int) -> list[Line]:
    """Head, lanes, time; a menu takes rows from the lanes."""
    picture, menu = scene.seen.scope, scene.shown.menu
    if picture is None:
        return [fit([(" no tick has run yet", LABEL)], width)]
    below = _menu(menu, picture, width) if menu is not None and menu.kind in ("signal", "trigger") else []
    lines = _head(scene, picture, width)
    rows = height - len(lines) - len(below) - 1
    lines += _lanes(picture, width, rows)
    return [*lines, _time(picture, width), *below]


def unit_of(name: str) -> str:
    """A signal's unit, by the end of its name; a raw channel has none."""
    return UNITS.get(name.rpartition("_")[2], "")


def bounds(low: float, high: float) -> tuple[float, float]:
    """Round numbers around what is there: the picture does not breathe with every sample."""
    if not low <= high:
        return -1.0, 1.0
    if high == low:
        return low - 1.0, high + 1.0
    span = max(high - low, LEAST_SPAN, 1e-6 * max(abs(low), abs(high)))
    step = _nice(span / 4.0)
    least, most = math.floor(low / step) * step, math.ceil(high / step) * step
    return (least, most) if most > least else (least - step, most + step)


def _nice(value: float) -> float:
    """1, 2 or 5 times a power of ten, not less than the value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= value * (1.0 - 1e-9))


def _head(scene: Scene, picture: ScopePicture, width: int) -> list[Line]:
    settings = picture.settings
    role = GOOD_BADGE if picture.state in (TRIGGERED, CAUGHT) else WARN_BADGE if picture.state == WAITING else LABEL
    held: Line = [(" ", PLAIN), (" HELD ", WARN_BADGE), (" H lets go ", WARN)] if scene.shown.held else []
    # Where there is no room for its name, the first trace is called by its number.
    wide = width >= WIDE_FROM
    first, state = settings.signals[0] if wide else "trace 1", (_STATES if wide else _SHORT)[picture.state]
    trigger = f" {settings.mode}: {first} {settings.edge} through {settings.level:g}"
    line: Line = [*held, (" ", PLAIN), (f" {state} ", role), (trigger, PLAIN)]
    if scene.seen.building is not None and not held:
        line = building(scene)
    keys = (("V", "signals "), ("N", "trigger "), ("H", "hold "))
    ways = [_keys(keys), _keys(keys[:-1]), _keys((key, "") for key, _ in keys)]
    return [both_ends(line, first_that_fits(ways, width - 2 - width_of(line)) or ways[-1], width)]


def _keys(keys: Iterable[tuple[str, str]]) -> Line:
    return [span for key, words in keys for span in ((f"{key} ", KEY), (words, LABEL))]


def _lanes(picture: ScopePicture, width: int, rows: int) -> list[Line]:
    traces = picture.traces
    each, more = divmod(rows, len(traces))
    if each < 2:
        return [fit([(" too low for a picture; a taller terminal shows it", WARN)], width)][: max(rows, 0)]
    # Lanes with one unit have one scale: what is wanted and what is compare by eye.
    lows: dict[str, list[float]] = {}
    highs: dict[str, list[float]] = {}
    for trace in traces:
        unit = unit_of(trace.name) or trace.name
        lows.setdefault(unit, []).extend(_extreme(trace.low, min))
        highs.setdefault(unit, []).extend(_extreme(trace.high, max))
    lines: list[Line] = []
    for place, trace in enumerate(traces):
        unit = unit_of(trace.name) or trace.name
        scale = bounds(min(lows[unit], default=math.nan), max(highs[unit], default=math.nan))
        lines += _lane(picture, place, scale, width, each + (place < more))
    return lines


def _extreme(values: Sequence[float], choose: Callable[[Sequence[float]], float]) -> tuple[float, ...]:
    """The least, or the greatest, of all columns that have a value; nothing where none has."""
    if any(map(math.isnan, values)):
        values = [value for value in values if value == value]
    return (choose(values),) if values else ()


def _lane(picture: ScopePicture, place: int, scale: tuple[float, float], width: int, rows: int) -> list[Line]:
    trace = picture.traces[place]
    role = TRACE if place % 2 == 0 else OTHER_TRACE
    unit = unit_of(trace.name)
    now = f"{trace.last:+.3f} {unit}" if trace.last == trace.last else "no value yet"
    head: Line = [(f" {place + 1} ", KEY), (trace.name, role), (f"  {now}", PLAIN)]
    settings = picture.settings
    level = settings.level if place == 0 and picture.state != FREE else None
    at = None
    if picture.trigger_tick is not None:
        at = picture.trigger_tick - picture.start_tick, settings.span_ms
    return [fit(head, width), *_drawn(trace.low, trace.high, scale, role, width, rows - 1, level, at)]


@lru_cache(maxsize=2 * MOST_TRACES)
def _drawn(
    low: Sequence[float],
    high: Sequence[float],
    scale: tuple[float, float],
    role: str,
    width: int,
    rows: int,
    level: float | None,
    trigger: tuple[int, int] | None,
) -> list[Line]:
    """A trace between divisions of time, with lines for zero, the trigger's level and its tick (of how many).

    One that has been triggered stands for many pictures.
    """
    least, most = scale
    canvas = _divided(max(1, width - GUTTER - 1), rows).copy()
    bottom = canvas.height - 1
    per_dot = (most - least) / max(1, bottom)
    if least < 0.0 < most:
        canvas.stipple(GRID, y=bottom - round(-least / per_dot))
    if level is not None and least <= level <= most:
        canvas.stipple(WARN, y=bottom - round((level - least) / per_dot))
    if trigger is not None:
        tick, span = trigger
        canvas.stipple(WARN, x=tick * canvas.width // span)
    # Of each column the dots of its greatest and its least sample.
    spans = [
        (bottom - round((upper - least) / per_dot), bottom - round((lower - least) / per_dot))
        if lower == lower
        else None
        for lower, upper in zip(low, high, strict=True)
    ]
    canvas.trace(map(spans.__getitem__, _sources(len(spans), canvas.width)), role)
    marks = {rows - 1: f"{least:.4g}", 0: f"{most:.4g}"}
    return [
        fit([(f"{marks.get(row, ''):>{GUTTER - 1}}", LABEL), ("│", GRID), *dots], width)
        for row, dots in enumerate(canvas.lines())
    ]


@lru_cache(maxsize=8)
def _divided(columns: int, rows: int) -> Canvas:
    """The lines between divisions of time, drawn once for each size."""
    canvas = Canvas(columns, rows)
    for division in range(1, DIVISIONS):
        canvas.stipple(GRID, x=division * canvas.width // DIVISIONS)
    return canvas


@lru_cache(maxsize=8)
def _sources(count: int, width: int) -> tuple[int, ...]:
    """For each column of dots the column of the trace that it shows."""
    return tuple(x * count // width for x in range(width))


def _time(picture: ScopePicture, width: int) -> Line:
    span = picture.settings.span_ms
    left = picture.start_tick - (picture.trigger_tick or 0)
    per, across = f"{_ms(span / DIVISIONS)} a division", f", {_ms(span)} across"
    at = f", trigger at {picture.trigger_tick / 1000:.3f} s" if picture.trigger_tick is not None else ""
    ends = (_ms(left), _ms(left + span)) if picture.trigger_tick is not None else (f"-{_ms(span)}", "now")
    middles = (f"{per}{across}{at}", f"{per}{at}", per, "")
    lines: list[Line] = [[(" " * GUTTER + ends[0] + "  ", LABEL), (middle, PLAIN)] for middle in middles]
    right: Line = [(ends[1] + " ", LABEL)]
    return both_ends(first_that_fits(lines, width - width_of(right) - 2), right, width)


def _ms(milliseconds: float) -> str:
    return f"{milliseconds / 1000:g} s" if abs(milliseconds) >= 1000 else f"{milliseconds:g} ms"


def _menu(menu: Menu, picture: ScopePicture, width: int) -> list[Line]:
    if menu.kind == "trigger":
        long = " trigger: ↑↓ choose, ←→ change, Esc closes, Enter arms again, digits set a level"
        head = long if len(long) <= width else " ↑↓ choose, ←→ change, Esc closes, Enter arms, 0-9 level"
        words = [f"{word:12} {value}" for word, value in zip(_TRIGGER_WORDS, menu.choices, strict=True)]
        return [fit([(head, TITLE)], width, TITLE), *_list(words, menu.row, width)]
    now = picture.settings.signals
    there = now[menu.trace] if menu.trace < len(now) else "a new one"
    typed = f" trace {menu.trace + 1}, now {there}: {menu.text}▏"
    keys = " ↑↓ choose, Enter takes, Esc leaves, Tab next trace, Backspace removes"
    keys = keys if len(keys) <= width else " ↑↓, Enter takes, Esc leaves, Tab next, Backspace removes"
    names = _list(menu.choices or ("no signal has that in its name",), menu.row, width)
    return [fit([(typed, TITLE)], width, TITLE), fit([(keys, LABEL)], width), *names]


def _list(words: Sequence[str], row: int, width: int) -> list[Line]:
    """As many as there is room for, the chosen one among them."""
    first = max(0, min(row - _MENU_ROWS // 2, len(words) - _MENU_ROWS))
    part = list(enumerate(words))[first : first + _MENU_ROWS]
    return [
        fit([(" ▸ " if at == row else "   ", KEY), (text, KEY if at == row else PLAIN)], width) for at, text in part
    ]
