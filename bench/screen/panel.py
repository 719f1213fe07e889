"""A Textual widget of lines: what has not changed is not drawn again. The only file of this folder that knows Textual.

A dashboard of such widgets costs a quarter of one made of the ready ones (tables, sparklines, rich text).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.filter import ANSIToTruecolor
from textual.geometry import NULL_REGION, Region
from textual.strip import Strip
from textual.widget import Widget

from bench.screen import text
from bench.screen.ink import RESET, Inks, rewrite
from bench.screen.layout import Place
from bench.screen.text import Line, width_of

if TYPE_CHECKING:
    from rich.console import Console
    from textual.filter import LineFilter

BACKGROUND, FOREGROUND = "#10141a", "#c8d0d8"
_GROUND = Color.parse(BACKGROUND)
_COLOURS = {
    text.PLAIN: Style(color=FOREGROUND),
    text.LABEL: Style(color="#7f8b98"),
    text.TITLE: Style(color="#ffffff", bgcolor="#1f4e79", bold=True),
    text.TAB: Style(color="#000000", bgcolor="#9fd0e8", bold=True),
    text.KEY: Style(color="#6fc3df", bold=True),
    text.GOOD: Style(color="#5fbf77"),
    text.WARN: Style(color="#e5b84b"),
    text.GOOD_BADGE: Style(color="#000000", bgcolor="#5fbf77", bold=True),
    text.WARN_BADGE: Style(color="#000000", bgcolor="#e5b84b", bold=True),
    text.BAD_BADGE: Style(color="#ffffff", bgcolor="#d8123a", bold=True),
    text.ROBOT: Style(color="#ffffff", bold=True),
    text.GHOST: Style(color="#d787d7", bold=True),
    text.TRAIL: Style(color="#4f9fcf"),
    text.GRID: Style(color="#4a5561"),
    text.TRACE: Style(color="#6fc3df"),
    text.OTHER_TRACE: Style(color="#f5f5f5"),
}
"""Chosen so that the nearest of sixteen colours means the same."""
STYLES = {role: Style(bgcolor=BACKGROUND) + style for role, style in _COLOURS.items()}


class Panel(Widget):
    """Lines at a place. `show` or `patch` takes them 20 times a second; only those that are new are drawn."""

    DEFAULT_CSS = "Panel { position: absolute; }"

    def __init__(self, name: str) -> None:
        super().__init__(name=name, id=name)
        self._lines: list[Line] = []
        self._strips: list[Strip | None] = []
        self._place: Place | None = None
        self.display = False

    @property
    def stands(self) -> bool:
        """Whether Textual has drawn the panel where it was put, or has taken it away."""
        return self.region == (self._place or NULL_REGION)

    def put(self, place: Place | None) -> None:
        """Stand there from now on; None hides the panel."""
        if place == self._place:
            return
        self._place = place
        self.display = place is not None
        if place is not None:
            self.styles.offset = (place.x, place.y)
            self.styles.width, self.styles.height = place.width, place.height

    def show(self, lines: list[Line]) -> None:
        """Replace the lines, and have Textual draw what is new."""
        if len(lines) != len(self._lines):
            self._lines, self._strips = lines, [None] * len(lines)
            self.refresh()
            return
        width = self.size.width
        changed = [Region(0, y, width, 1) for y, _ in self._renew(lines)]
        if changed:
            self.refresh(*changed)

    def patch(self, lines: list[Line], inks: Inks) -> str:
        """Replace the lines. What draws the new ones where the panel `stands` on a terminal with nothing over it."""
        place = self._place
        if place is None or len(lines) != len(self._lines):
            self.show(lines)
            return ""
        return "".join([rewrite(place.x, place.y + y, old, lines[y], inks) for y, old in self._renew(lines)])

    def _renew(self, lines: list[Line]) -> list[tuple[int, Line]]:
        """Take as many lines as there were. Rows that are new, each with what it was."""
        before = self._lines
        changed = [(y, old) for y, old in enumerate(before) if old != lines[y]]
        for y, _ in changed:
            self._strips[y] = None
        self._lines = lines
        return changed

    def render_lines(self, crop: Region) -> list[Strip]:
        """These rows, without what Textual does for borders, padding and styles: there are none."""
        strips = [self.render_line(y) for y in range(crop.y, crop.bottom)]
        for filter in self.get_line_filters():
            if not isinstance(filter, ANSIToTruecolor):  # NO_COLOR's; of the sixteen colours we name none
                strips = [strip.apply_filter(filter, _GROUND) for strip in strips]
        if crop.x == 0 and crop.width == self.size.width:
            return strips
        return [strip.crop(crop.x, crop.right) for strip in strips]

    def render_line(self, y: int) -> Strip:
        """One row, as Textual asks for it."""
        if y >= len(self._lines):
            return Strip.blank(self.size.width, STYLES[text.PLAIN])
        strip = self._strips[y]
        if strip is None:
            strip = self._strips[y] = _strip(self._lines[y])
        return strip


def inks_of(console: Console, filters: Sequence[LineFilter]) -> Inks:
    """What sets each role's colours, as Textual would on that console: in as many as there are, or in none."""
    inks = {}
    for role, style in STYLES.items():
        strip = Strip([Segment("x", style)], 1)
        for filter in filters:
            if not isinstance(filter, ANSIToTruecolor):
                strip = strip.apply_filter(filter, _GROUND)
        inks[role] = RESET + strip.render(console).partition("x")[0]
    return inks


def _strip(line: Line) -> Strip:
    """Every character is one cell wide, so that nothing has to be measured."""
    return Strip([Segment(words, STYLES[role]) for words, role in line if words], width_of(line))
