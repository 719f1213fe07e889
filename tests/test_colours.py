"""Colours that survive: sixteen of them, none of them, and eyes that see fewer. Against WCAG and Machado et al."""

import math
import re
from itertools import combinations

import pytest
from desk import at_the_keys, frame, piloted
from rich.color import Color, ColorSystem
from rich.console import Console
from rich.segment import Segment
from textual.color import Color as TextualColor
from textual.filter import Monochrome
from textual.geometry import Region

from bench.screen import text
from bench.screen.panel import BACKGROUND, STYLES, inks_of

STATES = (text.GOOD, text.WARN, text.BAD_BADGE, text.GOOD_BADGE, text.WARN_BADGE)
QUIET = (text.GRID,)
"""What may fade: nothing is read off it."""

# Machado, Oliveira, Fernandes 2009, severity 1.0, on linear RGB.
EYES = {
    "protan": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deutan": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritan": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}


def linear(color):
    return [
        value / 12.92 if (value := part / 255) <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
        for part in color.get_truecolor()
    ]


def luminance(rgb):
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]


def contrast(one, other):
    """WCAG 2: (L1 + 0.05) / (L2 + 0.05)."""
    high, low = sorted((luminance(linear(one)), luminance(linear(other))), reverse=True)
    return (high + 0.05) / (low + 0.05)


def lab(rgb):
    """CIE L*a*b* of linear sRGB, D65."""
    x = 0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2]
    y = luminance(rgb)
    z = 0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2]
    fx, fy, fz = (max(value, 0.0) ** (1 / 3) if value > 0.008856 else 7.787 * value + 16 / 116 for value in
                  (x / 0.95047, y, z / 1.08883))  # fmt: skip
    return 116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)


def seen_by(matrix, color):
    rgb = linear(color)
    return lab([sum(part * value for part, value in zip(line, rgb, strict=True)) for line in matrix])


@pytest.mark.parametrize("role", text.ROLES)
def test_every_role_can_be_read(role):
    """4.5 is WCAG's least contrast for text, 3 for what is large or only helps."""
    style = STYLES[role]
    assert contrast(style.color, style.bgcolor) >= (2.0 if role in QUIET else 4.5)


@pytest.mark.parametrize("role", text.ROLES)
def test_sixteen_colours_leave_everything_readable(role):
    style = STYLES[role]
    fore, back = (color.downgrade(ColorSystem.STANDARD) for color in (style.color, style.bgcolor))
    assert fore.number != back.number


def test_in_sixteen_colours_states_still_differ():
    shown = set()
    for role in STATES:
        style = STYLES[role]
        shown.add(tuple(color.downgrade(ColorSystem.STANDARD).number for color in (style.color, style.bgcolor)))
    assert len(shown) == len(STATES)


def outstanding(role):
    """What the eye meets first: a badge's ground, else the letters."""
    style = STYLES[role]
    return style.bgcolor if style.bgcolor != Color.parse(BACKGROUND) else style.color


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("roles", [*combinations((text.GOOD_BADGE, text.WARN_BADGE, text.BAD_BADGE), 2),
                                   (text.GOOD, text.WARN), (text.TRACE, text.OTHER_TRACE)])  # fmt: skip
def test_eyes_that_see_fewer_colours_tell_the_states_apart(eyes, roles):
    """A distance of 10 in L*a*b* is plain to see side by side; a just noticeable one is 2.3."""
    one, other = (seen_by(EYES[eyes], outstanding(role)) for role in roles)
    assert math.dist(one, other) >= 10.0


def test_without_colour_badges_are_still_badges():
    """NO_COLOR: Textual turns everything to greys; a badge keeps a ground that stands out."""
    background = TextualColor.parse(BACKGROUND)
    for role in (text.GOOD_BADGE, text.WARN_BADGE, text.BAD_BADGE, text.TAB):
        (segment,) = Monochrome().apply([Segment(" x ", STYLES[role])], background)
        assert len(set(segment.style.bgcolor.get_truecolor())) == 1, "grey"
        assert contrast(segment.style.bgcolor, Color.parse(BACKGROUND)) >= 1.5, role
        assert contrast(segment.style.color, segment.style.bgcolor) >= 4.5, role


def test_the_dashboard_heeds_no_color(monkeypatch):
    def colours(app):
        title = app.query_one("#title")
        (strip,) = title.render_lines(Region(0, 0, title.size.width, 1))
        inks.append("".join(inks_of(terminal, app.get_line_filters()).values()))
        return {color.get_truecolor() for segment in strip for color in (segment.style.color, segment.style.bgcolor)}

    async def steps(app, pilot):
        frame(app)
        await pilot.pause()
        found.append(colours(app))

    found, inks, terminal = [], [], Console(color_system="truecolor", force_terminal=True)
    piloted(at_the_keys(), steps)
    monkeypatch.setenv("NO_COLOR", "1")
    piloted(at_the_keys(), steps)
    assert any(len(set(colour)) > 1 for colour in found[0])
    assert all(len(set(colour)) == 1 for colour in found[1])
    colourful, grey = (re.findall(r"[34]8;2;(\d+);(\d+);(\d+)", ink) for ink in inks)
    assert any(len(set(colour)) > 1 for colour in colourful)
    assert len(grey) == len(colourful)
    assert all(len(set(colour)) == 1 for colour in grey)
