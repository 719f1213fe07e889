"""Pictures of the running dashboard for the documents: docs/pictures/*.svg, and *.png where a converter is there.

The app runs for real, by a pacer that grants the same ticks each time: the same pictures from the same code. For PNG
one of these is used: rsvg-convert (librsvg2-bin), resvg-py, cairosvg; with the font Fira Code (fonts-firacode).
"""

from __future__ import annotations

import asyncio
import html
import importlib.util
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from arguments import end_with, parser

from bench.check.reading import Recording
from bench.check.recording import RunInfo
from bench.check.run import Run
from bench.check.sources import from_scenario
from bench.config import load_robot
from bench.demo import SCENARIO, golden_directory
from bench.io.clock import FreePacer
from bench.loop import simulated
from bench.screen.keyboard import Keyboard
from bench.screen.session import Session
from bench.screen.stage import Stage, to_drive, to_show
from bench.tui import Dashboard

DOCS = Path(__file__).parents[1] / "docs"
PICTURES, EXAMPLE = DOCS / "pictures", DOCS / "examples" / "link_loss.toml"
FRAME_TICKS = 50
CELL_WIDTH = 12.2
_RUN_OF_CELLS = r'<text class="(\S+)" x="(\S+)" y="(\S+)" textLength="\S+" clip-path="(\S+)">(.*?)</text>'


class Stepped(FreePacer):
    """Grants a frame's ticks when told to, and none by itself."""

    granted = 0

    def due(self, done: int) -> int:
        """What was granted, once."""
        ticks, self.granted = self.granted, 0
        return ticks


def frames(app: Dashboard, count: int, *keys: str) -> None:
    """So many frames, with keys held down all the while."""
    pacer = app.session.link.pacer
    assert isinstance(pacer, Stepped)
    app.session.sight.size = app.size
    for _ in range(count):
        for key in keys:
            app.session.key(key)
        pacer.granted = FRAME_TICKS
        app.frame()


def drive_about(app: Dashboard) -> None:
    """Armed, driven round a bend and on."""
    frames(app, 10)
    app.session.key("enter")
    frames(app, 4)
    frames(app, 30, "w")
    frames(app, 45, "w", "q")
    frames(app, 30, "a")
    frames(app, 12, "w", "e")


def press(app: Dashboard, *keys: str) -> None:
    """Keys, one after the other."""
    for key in keys:
        app.session.key(key)


def driven(app: Dashboard) -> None:
    """Round a bend."""
    drive_about(app)


def by_core(app: Dashboard) -> None:
    """The core drives, seen from close by."""
    drive_about(app)
    press(app, "c", "z")
    frames(app, 60)


def lost(app: Dashboard) -> None:
    """The transmitter went off while driving."""
    drive_about(app)
    press(app, "t")
    frames(app, 60)


def help_page(app: Dashboard) -> None:
    """The page of keys."""
    drive_about(app)
    press(app, "?")
    frames(app, 1)


def bumped(app: Dashboard) -> None:
    """Against the wall, seen from close by: bumpers, beams, slipping wheels."""
    drive_about(app)
    press(app, "z", *"+++++")
    frames(app, 90, "w")


def wires(app: Dashboard) -> None:
    """What crosses the wires."""
    press(app, "2")
    drive_about(app)


def scope(app: Dashboard) -> None:
    """A push of the stick, caught by the trigger; and the current that it takes."""
    press(app, "3", "v", "tab", "tab", *"command1_a", "enter")
    press(app, "n", "right", "down", "down", *"1", "down", "left", "enter")
    drive_about(app)


def everything(app: Dashboard) -> None:
    """A wide terminal."""
    drive_about(app)


def replayed(app: Dashboard) -> None:
    """The demo, some way in."""
    frames(app, 350)


def judged(app: Dashboard) -> None:
    """A scenario's expectations, some way in."""
    press(app, "4")
    frames(app, 60)


class Shot(NamedTuple):
    """A picture: its size in cells, who is on the screen, what happens before it is taken."""

    columns: int
    rows: int
    session: Callable[[], Session]
    play: Callable[[Dashboard], None]


def driving() -> Session:
    """A fresh bench at the keyboard."""
    robot = load_robot("m2006")
    keyboard = Keyboard(robot.rc)
    job = Run("m2006", simulated(robot), 0, keyboard.inputs, RunInfo("m2006", "uart12"))
    return _session(to_drive(job, keyboard, Stepped()))


def demo() -> Session:
    """A fresh demo, held against its golden."""
    return _session(to_show(from_scenario(SCENARIO), Recording.open(golden_directory()), Stepped()))


def link_loss() -> Session:
    """The example of docs/scenarios.md."""
    return _session(to_show(from_scenario(EXAMPLE), None, Stepped()))


def _session(stage: Stage) -> Session:
    return Session(
        stage.link, keyboard=stage.keyboard, job=stage.job, lamp=stage.lamp, summary=stage.summary, agree=stage.agree
    )


SHOTS = {
    "drive-80x24": Shot(80, 24, driving, driven),
    "drive-120x40": Shot(120, 40, driving, driven),
    "everything-200x60": Shot(200, 60, driving, everything),
    "small-40x12": Shot(40, 12, driving, driven),
    "core-80x24": Shot(80, 24, driving, by_core),
    "bumper-80x24": Shot(80, 24, driving, bumped),
    "link-lost-80x24": Shot(80, 24, driving, lost),
    "keys-80x24": Shot(80, 24, driving, help_page),
    "wires-120x40": Shot(120, 40, driving, wires),
    "scope-120x40": Shot(120, 40, driving, scope),
    "checks-100x30": Shot(100, 30, link_loss, judged),
    "demo-120x40": Shot(120, 40, demo, replayed),
}


async def shoot(name: str, folder: Path) -> Path:
    """One picture."""
    shot = SHOTS[name]
    app = Dashboard(shot.session())
    async with app.run_test(size=(shot.columns, shot.rows)) as pilot:
        await pilot.pause()
        shot.play(app)
        await pilot.pause()
        # The identifiers are made from a random number; a fixed one makes pictures that compare.
        svg = re.sub(r"terminal-\d+", "terminal-1", app.export_screenshot(title="wheelbench"))
        svg = svg.replace("font-size: 20px;", "font-size: 20px; font-variant-ligatures: none;")
    path = folder / f"{name}.svg"
    path.write_text(svg, encoding="utf-8")
    return path


def to_png(svg: Path) -> bool:
    """Convert by whatever is there; False where nothing is."""
    png = svg.with_suffix(".png")
    if shutil.which("rsvg-convert"):
        done = subprocess.run(["rsvg-convert"], input=for_rsvg(svg).encode(), stdout=subprocess.PIPE, check=True)
        png.write_bytes(done.stdout)
    elif importlib.util.find_spec("resvg_py"):
        import resvg_py

        png.write_bytes(bytes(resvg_py.svg_to_bytes(svg_path=str(svg))))
    elif importlib.util.find_spec("cairosvg"):
        import cairosvg

        cairosvg.svg2png(url=str(svg), write_to=str(png))
    else:
        return False
    return True


def for_rsvg(svg: Path) -> str:
    """Every character at its own place: librsvg trims blanks, knows no textLength, and not every font has braille."""

    def one_by_one(match: re.Match[str]) -> str:
        role, x, y, clip, words = match.groups()
        places = ((float(x) + CELL_WIDTH * i, sign) for i, sign in enumerate(html.unescape(words)))
        return "".join(
            f'<text class="{role}" x="{at:.1f}" y="{y}" clip-path="{clip}">{html.escape(sign)}</text>'
            for at, sign in places
            if not sign.isspace()
        )

    text = svg.read_text(encoding="utf-8").replace("font-size: 20px", "font-size: 20.333px")
    return re.sub(
        r'<text class="(\S+)" x="(\S+)" y="(\S+)" textLength="\S+" clip-path="(\S+)">(.*?)</text>', one_by_one, text
    )


def main() -> int:
    """Make every picture."""
    asked = parser(__doc__)
    asked.add_argument(
        "folder", nargs="?", type=Path, default=PICTURES, metavar="FOLDER", help="where to (default docs/pictures)"
    )
    folder = asked.parse_args().folder
    if folder.exists() and not folder.is_dir():
        asked.error(f"FOLDER: {folder} is a file; name a folder")
    folder.mkdir(parents=True, exist_ok=True)
    converted = True
    for name in SHOTS:
        svg = asyncio.run(shoot(name, folder))
        converted = to_png(svg) and converted
        print(svg)
    if not converted:
        print("no PNG made: install librsvg2-bin (rsvg-convert), or resvg-py, or cairosvg, and the font fonts-firacode")
    return 0


if __name__ == "__main__":
    end_with(main)
