"""What the dashboard shows before there is a bench: every pane where it will stand, how to stop and how to leave.

To import and build a bench takes longer than anything else of a start, so the screen comes first. It needs only what a
quick look at the robot's file tells; whatever that gets wrong is put right when the bench is there. Nothing here
imports the bench: that is what it is for.
"""

from __future__ import annotations

import re
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from bench.screen.edges import HELP_AND_QUIT, hands_always, tabs
from bench.screen.layout import DRIVE, Place, arrange
from bench.screen.text import LABEL, PLAIN, TITLE, WARN_BADGE, Line, both_ends, first_that_fits, fit, width_of

ROBOTS = Path(__file__).parents[1] / "robots"
DEFAULT_ROBOT = "m2006"
FIELD_M = (6.0, 4.0)
"""Length and width of `bench.arena.FIELD`."""
BUILDING = "building the bench"
_WAITS = ("a key waits for the bench", "keys wait")
"""Of the foot, in fewer words: the status says the rest."""
_PANES = {"progress": "", "wheels": "wheel", "wires": "wire", "glance": "", "scope": "scope", "wiretable": "wires"}
_NAME, _RC, _WHEEL, _ROBOT, _SCENARIO, _LENGTH, _WIDTH, _TABLE = (
    re.compile(pattern, re.MULTILINE)
    for pattern in (
        r'^name *= *"([^"]*)"', r'^rc *= *"([^"]*)"', r"^\[\[ *wheel *\]\]", r'^robot *= *"([^"]+)"',
        r'^scenario *= *"([^"]+)"', r"^length_m *= *([0-9.]+)", r"^width_m *= *([0-9.]+)", r"^\[",
    )
)  # fmt: skip


class Opening(NamedTuple):
    """A robot as far as the opening picture shows it. `replay` is what a run is called that is shown, not driven."""

    name: str
    rc: str
    wheels: int
    field_m: tuple[float, float] = FIELD_M
    replay: str = ""

    def picture(self, width: int, height: int) -> dict[str, tuple[Place, list[Line]]]:
        """Panel -> where it stands, and its lines."""
        aspect = self.field_m[0] / self.field_m[1]
        places = arrange(width, height, wheels=self.wheels, aspect=aspect, replay=bool(self.replay))
        return {
            name: (place, [fit(line, place.width) for line in self._lines(name, place)])
            for name, place in places.items()
        }

    def whole(self, width: int, height: int) -> list[Line]:
        """The same as one panel: the first picture is there the sooner, the less it is made of."""
        rows: list[list[tuple[int, Line]]] = [[] for _ in range(height)]
        for place, lines in self.picture(width, height).values():
            for y, line in enumerate(lines, place.y):
                rows[y].append((place.x, line))
        return [_joined(sorted(row, key=itemgetter(0)), width) for row in rows]

    def _lines(self, panel: str, place: Place) -> list[Line]:
        width = place.width
        if panel == "title":
            return [self._title(width)]
        if panel == "arena":
            return _field(self.field_m, width, place.height)
        if panel == "footer":
            always = HELP_AND_QUIT if self.replay else hands_always(False, arms=bool(self.rc))
            ways: list[Line] = [[(f" {words}", LABEL)] for words in (f"{BUILDING}; a key waits for it", *_WAITS)]
            return [both_ends(first_that_fits(ways, width - 2 - width_of(always)), always, width)]
        if panel == "status":
            return [[(" ", PLAIN), (f" {BUILDING.upper()} ", WARN_BADGE)]]
        if panel == "small":
            return [[(f" {self.name}", TITLE)], [(f" {BUILDING.upper()} ", WARN_BADGE)]][: place.height]
        return [[(f" {_PANES[panel]}", LABEL)]]

    def _title(self, width: int) -> Line:
        right = [(f"{BUILDING} ", TITLE)]
        told = f" {self.replay}" if self.replay else ""
        for name in (f"{told} {self.name}, {self.rc or 'no RC'}", f"{told} {self.name}"):
            for long in (True, False):
                line = [(name, TITLE), ("  ", TITLE), *tabs(DRIVE, {}, long=long)]
                if width_of(line) + 2 + width_of(right) <= width:
                    return both_ends(line, right, width, TITLE)
        return both_ends([(f"{told} {self.name}", TITLE)], right, width, TITLE)


def _joined(parts: list[tuple[int, Line]], width: int) -> Line:
    """What stands in one row, blanks between."""
    row: Line = []
    for x, line in parts:
        row = [*fit(row, x), *line]
    return fit(row, width)


def opening_of(robot: str | None, profile: str | None, settings: Path, arena: str | None = None) -> Opening | None:
    """The picture for a robot, the remembered one where none is named; None where its file is not found or odd."""
    for text in (robot, None if robot else _first(_ROBOT, _read(settings)), None if robot else DEFAULT_ROBOT):
        if text and (found := _looked_up(text, profile)) is not None:
            return found if arena is None else found._replace(field_m=_field_of(Path(arena)))
    return None


def opening_of_scenario(file: Path, arena: str | None = None) -> Opening | None:
    """The same for a scenario that is shown: with its robot, in the default field or another."""
    text = _read(file)
    found = _looked_up(_first(_ROBOT, text) or DEFAULT_ROBOT, None)
    field_m = FIELD_M if arena is None else _field_of(Path(arena))
    return found and found._replace(replay=_first(_NAME, text) or file.stem, field_m=field_m)


def opening_of_recording(directory: Path) -> Opening | None:
    """The same for a recording that is shown again: with what lies in it."""
    found = _looked_up(str(directory / "robot.toml"), None)
    if found is None:
        return None
    title = _first(_SCENARIO, _read(directory / "run.toml")) or directory.name
    rc = _first(_NAME, _read(directory / "profile.toml"))
    return found._replace(replay=title, rc=rc, field_m=_field_of(directory / "arena.toml"))


def _looked_up(robot: str, profile: str | None) -> Opening | None:
    ours = ROBOTS / f"{robot}.toml"
    file = _read(ours if ours.is_file() else Path(robot))
    wheels = len(_WHEEL.findall(file))
    return Opening(_first(_NAME, file), Path(profile or _first(_RC, file)).stem, wheels) if wheels else None


def _field_of(arena: Path) -> tuple[float, float]:
    """Length and width, which stand before the first table."""
    head = _TABLE.split(_read(arena))[0]
    try:
        length_m, width_m = float(_first(_LENGTH, head)), float(_first(_WIDTH, head))
    except ValueError:
        return FIELD_M
    return (length_m, width_m) if length_m > 0.0 < width_m else FIELD_M


def _first(pattern: re.Pattern[str], text: str) -> str:
    found = pattern.search(text)
    return found[1] if found else ""


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""  # whoever reads it in earnest says what is wrong


def _field(field_m: tuple[float, float], width: int, height: int) -> list[Line]:
    """The empty field in its frame."""
    caption: Line = [(f" field {field_m[0]:g} × {field_m[1]:g} m ", PLAIN)]
    inner = width - 2
    words = caption if width_of(caption) <= inner else []
    rest = "─" * (inner - width_of(words))
    side: Line = [("│", LABEL), (" " * inner, PLAIN), ("│", LABEL)]
    return [[("┌", LABEL), *words, (f"{rest}┐", LABEL)], *[side] * (height - 2), [("└" + "─" * inner + "┘", LABEL)]]
