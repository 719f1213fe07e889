"""A scene -> the lines of each panel, for any size that `layout` gives. No Textual, no clock: tests compare text.

To show a new value, put it in the `Scene`, add it to the panel that it belongs to, and look at the text snapshots.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.screen import layout
from bench.screen.arena import arena
from bench.screen.bars import footer, notice, notice_rows, progress, title
from bench.screen.checks import checks, glance
from bench.screen.dialog import dialog, dialog_place
from bench.screen.pad import pad
from bench.screen.pages import help_page, summary
from bench.screen.scene import Scene
from bench.screen.scope import scope
from bench.screen.small import small
from bench.screen.status import status
from bench.screen.strip import strip, strip_rows
from bench.screen.text import Line, fit, plain
from bench.screen.wheels import wheels
from bench.screen.wires import wires
from bench.screen.wiretable import wiretable

PANELS: dict[str, Callable[[Scene, int, int], list[Line]]] = {
    "title": title,
    "progress": progress,
    "arena": arena,
    "status": status,
    "glance": glance,
    "wheels": wheels,
    "wires": wires,
    "strip": strip,
    "wiretable": wiretable,
    "scope": scope,
    "checks": checks,
    "pad": pad,
    "footer": footer,
    "help": help_page,
    "summary": summary,
    "small": small,
    "dialog": dialog,
    "notice": notice,
}
"""Every panel by its name in `layout`: a function of scene, width and height."""
_FITTED = ("arena", "scope")
"""Pictures: most of their lines stand, and all are made as wide as they are asked to be."""


def places(scene: Scene, width: int, height: int) -> dict[str, layout.Place]:
    """Which panels this scene needs, and where they stand."""
    replay = scene.replay
    state = layout.HELP if scene.help else layout.ENDED if replay is not None and replay.summary else layout.LIVE
    arranged = layout.arrange(
        width,
        height,
        wheels=len(scene.robot.wheels),
        aspect=scene.arena.length_m / scene.arena.width_m,
        replay=replay is not None,
        state=state,
        page=scene.shown.page,
        pad=scene.hands is not None and scene.hands.pad is not None,
        strip_rows=strip_rows(scene, width),
    )
    places = dict(arranged)
    if "small" in places:
        return layout.small_with_list(width, height) or places if scene.dialog is not None else places
    # Over the others, and so drawn last.
    if scene.dialog is not None:
        places["dialog"] = dialog_place(width, height, len(scene.dialog.rows))
    rows = notice_rows(scene, width)
    if rows:
        places["notice"] = layout.Place(0, height - 1 - rows, width, rows)
    return places


def draw(panel: str, scene: Scene, width: int, height: int) -> list[Line]:
    """A panel's lines: at most `height` of them, each exactly `width` cells."""
    lines = PANELS[panel](scene, width, height)[:height]
    return lines if panel in _FITTED else [fit(line, width) for line in lines]


def picture(scene: Scene, width: int, height: int) -> list[str]:
    """The whole screen as text, as the app puts it together."""
    rows = [[" "] * width for _ in range(height)]
    for name, place in places(scene, width, height).items():
        for row, line in enumerate(draw(name, scene, place.width, place.height), place.y):
            rows[row][place.x : place.x + place.width] = plain(line)
    return ["".join(row).rstrip() for row in rows]
