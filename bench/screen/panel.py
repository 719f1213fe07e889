"""A Textual widget of lines: what has not changed is not drawn again. The only file of this folder that knows Textual.

A dashboard of such widgets costs a quarter of one made of the ready ones (tables, sparklines, rich text).
"""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.filter import ANSIToTruecolor
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from bench.screen import text
from bench.screen.layout import Place
from bench.screen.text import Line, width_of

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
    """Lines at a place. `show` takes them 20 times a second and repaints those that are new."""

    DEFAULT_CSS = "Panel { position: absolute; }"

    def __init__(self, name: str) -> None:
        super().__init__(name=name, id=name)
        self._lines: list[Line] = []
        self._strips: list[Strip] = []
        self._place: Place | None = None
        self.display = False

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
        """Replace the lines."""
        old = self._lines
        if len(lines) != len(old):
            self._strips = [_strip(line) for line in lines]
            self._lines = lines
            self.refresh()
            return
        width = self.size.width
        changed = []
        for y, line in enumerate(lines):
            if line != old[y]:
                self._strips[y] = _strip(line)
                changed.append(Region(0, y, width, 1))
        if changed:
            self._lines = lines
            self.refresh(*changed)

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
        return self._strips[y] if y < len(self._strips) else Strip.blank(self.size.width, STYLES[text.PLAIN])


def _strip(line: Line) -> Strip:
    """Every character is one cell wide, so that nothing has to be measured."""
    return Strip([Segment(words, STYLES[role]) for words, role in line if words], width_of(line))
