"""Results of scenarios as one self-contained page: verdicts, and pictures of each run. No script, no network."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import TypeAlias

from bench.check.crosswire.settings import OFF
from bench.check.suite import Result

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 760, 150, 52, 12, 10, 20
COLOURS = ("#0b62a8", "#c2541b", "#2b7a3d", "#7a3fa0", "#8a6d00", "#b0285f", "#167a80", "#555f6b")
"""Told apart by colour-blind eyes too; the legend names them in order."""
LINK_COLOURS = {"live": "#bfe3c8", "degraded": "#f3e3a6", "hold": "#f3e3a6", "neutral": "#f5c79b", "lost": "#efa9a4"}
Scale: TypeAlias = Callable[[float], float]
"""A value -> where it stands in the picture."""
_STYLE = """
 body { font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 62rem; padding: 2rem 1.5rem; color: #1c2430 }
 h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin: 2.4rem 0 .2rem; border-top: 1px solid #d5dbe3 }
 h2 { padding-top: 1.2rem }
 p { margin: .3rem 0 } .mark { font-size: .8rem; padding: .1rem .5rem; border-radius: .3rem; vertical-align: middle }
 .ok { background: #dff2e5; color: #14532a } .failed { background: #f9d9d6; color: #7d120b } small { color: #5a6675 }
 table { border-collapse: collapse; margin: .6rem 0 } td, th { text-align: left; padding: .2rem 1.1rem .2rem 0 }
 td, th { vertical-align: top }
 th { font-weight: 600; color: #5a6675 } td.number { font-variant-numeric: tabular-nums }
 figure { margin: .8rem 0 } figcaption { color: #5a6675; font-size: .87rem } svg { max-width: 100%; height: auto }
 svg text { font: 11px system-ui, sans-serif; fill: #5a6675 }
"""


def page(results: Sequence[Result]) -> str:
    """The whole page."""
    failed = [result for result in results if not result.ok]
    total = "every scenario as expected" if not failed else f"{len(failed)} of {len(results)} scenarios failed"
    rows = "".join(
        f'<tr><td>{_mark(result)}</td><td><a href="#s{number}">{escape(result.name)}</a></td>'
        f"<td>{escape(result.robot)}</td><td>{escape('; '.join(result.reasons)) or escape(result.about)}</td></tr>"
        for number, result in enumerate(results)
    )
    bodies = "".join(_section(number, result) for number, result in enumerate(results))
    return (
        '<!doctype html>\n<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>wheelbench: {escape(total)}</title><style>{_STYLE}</style>\n<h1>wheelbench: {escape(total)}</h1>"
        f"<table>{rows}</table>\n{bodies}</html>\n"
    )


def _mark(result: Result) -> str:
    return '<span class="mark ok">ok</span>' if result.ok else '<span class="mark failed">FAILED</span>'


def _section(number: int, result: Result) -> str:
    head = f'<h2 id="s{number}">{escape(result.name)} {_mark(result)}</h2><p>{escape(result.about)}</p>'
    if result.error:
        return f"{head}<p>{escape(result.error)}</p>"
    where = f"{escape(result.path)}, robot {escape(result.robot)}, {result.ticks / 1000:.1f} s"
    tables = _verdicts(result) + _checks(result) + _faults(result)
    return f"{head}<p><small>{where}</small></p>{tables}{''.join(_pictures(result))}"


def _verdicts(result: Result) -> str:
    if not result.verdicts:
        return ""
    rows = "".join(
        f'<tr><td><span class="mark {"ok" if one.ok else "failed"}">{one.result}</span></td><td>{escape(one.name)}</td>'
        f'<td class="number">{f"{one.margin:+.4g}" if math.isfinite(one.margin) else ""}</td>'
        f'<td class="number">{f"{one.at_tick / 1000:.3f} s" if one.at_tick is not None else ""}</td></tr>'
        for one in result.verdicts
    )
    return f"<table><tr><th></th><th>expectation</th><th>margin</th><th>least at</th></tr>{rows}</table>"


def _checks(result: Result) -> str:
    """What the wires say of each other: a row a check, each finding on a line of its own."""
    rows = ""
    for one in result.checks:
        word = one.state if one.state == OFF else "found" if one.findings else "agrees"
        lines = [line.removeprefix(f"{one.name}: ") for line in one.lines]
        rows += (
            f'<tr><td><span class="mark {"ok" if one.ok else "failed"}">{word}</span></td><td>{escape(one.name)}</td>'
            f"<td>{'<br>'.join(map(escape, lines))}</td></tr>"
        )
    return f"<table><tr><th></th><th>wires</th><th>what they say of each other</th></tr>{rows}</table>" if rows else ""


def _faults(result: Result) -> str:
    rows = "".join(
        f'<tr><td>{escape(span.name)}</td><td class="number">{span.first / 1000:.3f} to {span.last / 1000:.3f} s</td>'
        f'<td class="number">{span.touched} touched</td></tr>'
        for span in result.faults
    )
    return f"<table><tr><th>fault</th></tr>{rows}</table>" if rows else ""


def _pictures(result: Result) -> Iterator[str]:
    column = {name: place for place, name in enumerate(result.columns)}

    def take(name: str) -> list[float]:
        return [float(row[column[name]]) for row in result.rows]

    times = take("t_s")
    if len(times) < 2:
        return
    wheels = [name for name in result.columns if name.endswith("_current_a")]
    yield _path(take("x_m"), take("y_m"), take("odo_x_m"), take("odo_y_m"))
    speeds = {"vx, m/s": take("vx_mps"), "vy, m/s": take("vy_mps"), "omega, rad/s": take("omega_radps")}
    yield _over_time("how it moves", times, speeds, result)
    limit = result.current_limit_a
    currents = {f"wheel {number}, A": take(name) for number, name in enumerate(wheels, 1)}
    yield _over_time(f"motor currents; the limit is {limit:g} A", times, currents, result, (-limit, limit))


def _over_time(
    caption: str, times: list[float], curves: dict[str, list[float]], result: Result, lines: Sequence[float] = ()
) -> str:
    """Curves over time, above them the link's state, behind them the faults, across them what was violated."""
    low = min(min(values) for values in (*curves.values(), lines or (0.0,)))
    high = max(max(values) for values in (*curves.values(), lines or (0.0,)))
    spare = 0.06 * (high - low) or 0.1
    low, high, end = low - spare, high + spare, times[-1]

    def x(seconds: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * seconds / end

    def y(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (high - value) / (high - low)

    parts = [*_fault_bars(result, x), _link_bar(result, x)]
    for value in _labels(low + spare, high - spare):
        parts.append(_level(y(value), "#d5dbe3"))
        parts.append(f'<text x="{LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:.3g}</text>')
    for seconds in _ticks(end):
        parts.append(f'<text x="{x(seconds):.1f}" y="{HEIGHT - 5}" text-anchor="middle">{seconds:g} s</text>')
    parts += [_level(y(value), "#8a94a0", "5 4") for value in lines]
    for colour, values in zip(_colours(), curves.values(), strict=False):
        points = " ".join(f"{x(t):.1f},{y(value):.1f}" for t, value in zip(times, values, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
    parts += _violations(result, x)
    legend = ", ".join(
        f'<span style="color:{colour}">■ {escape(name)}</span>'
        for colour, name in zip(_colours(), curves, strict=False)
    )
    svg = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" role="img">{"".join(parts)}</svg>'
    return f"<figure>{svg}<figcaption>{escape(caption)}: {legend}</figcaption></figure>"


def _labels(low: float, high: float) -> list[float]:
    """Which values are written at the side: the ends, and zero; what would stand on another is left out."""
    labels = [high, low]
    if low < 0.0 < high:
        labels = [0.0, *(value for value in labels if abs(value) > 0.12 * (high - low))]
    return labels


def _level(y: float, colour: str, dashes: str = "none") -> str:
    return (
        f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}"'
        f' stroke-dasharray="{dashes}"/>'
    )


def _fault_bars(result: Result, x: Scale) -> Iterator[str]:
    for span in result.faults:
        start, width = x(span.first / 1000), max(1.0, x(span.last / 1000) - x(span.first / 1000))
        yield (
            f'<rect x="{start:.1f}" y="{TOP}" width="{width:.1f}" height="{HEIGHT - TOP - BOTTOM}" fill="#e4e8ee">'
            f"<title>{escape(span.name)}</title></rect>"
        )


def _violations(result: Result, x: Scale) -> Iterator[str]:
    for verdict in result.verdicts:
        if not verdict.ok and verdict.at_tick is not None:
            yield _violation(x(verdict.at_tick / 1000), verdict.name)
    for check in result.checks:
        if check.findings and not check.ok:
            yield _violation(x(check.findings[0].first_tick / 1000), check.name)


def _violation(x: float, name: str) -> str:
    return (
        f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}" stroke="#b3261e" stroke-width="2"/>'
        f'<text x="{x + 4:.1f}" y="{TOP + 14}" style="fill:#b3261e">{escape(name)}</text>'
    )


def _link_bar(result: Result, x: Scale) -> str:
    """The link's state as a strip along the top, named where there is room."""
    place = result.columns.index("link")
    changes: list[tuple[float, str]] = []
    for row in result.rows:
        if not changes or changes[-1][1] != row[place]:
            changes.append((float(row[0]), str(row[place])))
    end = float(result.rows[-1][0])
    strips = []
    for (start, state), following in zip(changes, [*(at for at, _ in changes[1:]), end], strict=True):
        width = x(following) - x(start)
        strips.append(
            f'<rect x="{x(start):.1f}" y="0" width="{max(0.5, width):.1f}" height="{TOP - 2}"'
            f' fill="{LINK_COLOURS.get(state, "#e4e8ee")}"><title>link {escape(state)}</title></rect>'
        )
        if width > 60:
            strips.append(
                f'<text x="{x(start) + 4:.1f}" y="{TOP - 2}" style="font-size:9px">link {escape(state)}</text>'
            )
    return "".join(strips)


def _path(xs: list[float], ys: list[float], odo_xs: list[float], odo_ys: list[float]) -> str:
    """The way from above, forward up; dashed where the robot believed to be."""
    side, margin = 260.0, 16.0
    low_x, high_x = min(xs + odo_xs), max(xs + odo_xs)
    low_y, high_y = min(ys + odo_ys), max(ys + odo_ys)
    span = max(high_x - low_x, high_y - low_y, 0.05)
    scale = (side - 2 * margin) / span

    def points(along: list[float], aside: list[float]) -> str:
        return " ".join(
            f"{side / 2 - (b - (low_y + high_y) / 2) * scale:.1f},{side / 2 - (a - (low_x + high_x) / 2) * scale:.1f}"
            for a, b in zip(along, aside, strict=True)
        )

    way = points(xs, ys)
    first, last = way.split(" ")[0].split(","), way.split(" ")[-1].split(",")
    svg = (
        f'<svg viewBox="0 0 {side:g} {side:g}" width="{side:g}" role="img">'
        f'<rect width="{side:g}" height="{side:g}" fill="#f5f7f9"/>'
        f'<polyline points="{points(odo_xs, odo_ys)}" fill="none" stroke="#c2541b" stroke-dasharray="4 3"/>'
        f'<polyline points="{way}" fill="none" stroke="#0b62a8" stroke-width="2"/>'
        f'<circle cx="{first[0]}" cy="{first[1]}" r="4" fill="#fff" stroke="#0b62a8"/>'
        f'<circle cx="{last[0]}" cy="{last[1]}" r="4" fill="#0b62a8"/></svg>'
    )
    caption = f"the way from above, forward up, {span:.2f} m across; dashed: where the robot believed to be"
    return f"<figure>{svg}<figcaption>{caption}</figcaption></figure>"


def _ticks(end: float) -> list[float]:
    step = next(step for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 1e9) if end / step <= 9)
    return [step * number for number in range(int(end / step) + 1)]


def _colours() -> Iterator[str]:
    while True:
        yield from COLOURS
