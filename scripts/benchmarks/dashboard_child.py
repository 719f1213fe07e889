"""One app in a terminal of its own, for benchmarks/dashboard.py: measures itself and writes JSON into a file.

    python dashboard_child.py KIND PAGE COLUMNS ROWS FRAMES RESULT SPAWNED_S

    ours    the dashboard
    driven  the same as it is after a minute of `wheelbench drive`: a whole trail, wires checked, the run remembered
    stock   the same lines in Textual's ready widgets: Static, DataTable (only cells that changed), Sparkline
    empty   an app that shows nothing

All but `empty` look at the same bench, which is driven about all the time and ticks in both: every frame grants it
the ticks of its 50 ms, however late the frame comes, so that a busy machine measures the same work.
"""

from __future__ import annotations

import fcntl
import json
import math
import signal
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

WARM_FRAMES = 20
EMPTY_CALLS = 500
"""Timed in each frame, and not counted in it."""
FRAMES_PER_S = 20
FRAME_TICKS = 1000 // FRAMES_PER_S
LAST_OF_A_PICTURE, FIRST_VALUE = " quit", "not armed since boot"
"""The footer's last word, which stands in the lowest row of every picture; what the bench says of itself at tick 0."""
UNREACHED_LEVEL = ("n", "down", "down", "9", "9", "9", "enter")
"""Keys: the scope's trigger is never reached. It runs free, and its picture moves; one that is caught stands."""
TABLES = ("wheels", "wires", "wiretable")


class Start:
    """How long it took since the process began, in CPU and on the wall; written into a file when all is told."""

    def __init__(self, result: Path, spawned_s: float) -> None:
        self._result, self._spawned_s = result, spawned_s
        self._facts: dict[str, float] = {}

    def reached(self, prefix: str = "") -> None:
        """It has come so far."""
        self._facts[f"{prefix}wall_s"] = time.monotonic() - self._spawned_s
        self._facts[f"{prefix}cpu_s"] = time.process_time()

    def ends(self, app: Any) -> None:
        """That was all."""
        self._result.write_text(json.dumps(self._facts))
        app.exit()


def tell_first_refresh(app: Any, start: Start) -> None:
    """An app of this class is ready and refreshed: it tells, and ends."""

    def painted(one: Any) -> None:
        start.reached()
        start.ends(one)

    app.on_ready = lambda one: one.call_after_refresh(painted, one)


def tell_writes(driver: Any, start: Start) -> None:
    """The dashboard gives its terminal the first whole picture, then the first with values: it tells, and ends."""
    write = driver.write
    left = {"": LAST_OF_A_PICTURE, "live_": FIRST_VALUE}

    def noting(one: Any, data: str) -> None:
        write(one, data)
        for prefix in [prefix for prefix, words in left.items() if words in data]:
            del left[prefix]
            start.reached(prefix)
            if not left:
                start.ends(one._app)

    driver.write = noting


def session_driven_about(page: str, whole: bool = False) -> Any:
    """A session at the dashboard whose robot drives all the time; `whole` with all that `wheelbench drive` does."""
    from bench.check.run import Run, info_of
    from bench.io.clock import FreePacer
    from bench.io.follower import TRAIL_POINTS
    from bench.io.link import InlineLink
    from bench.loop import simulated
    from bench.messages import TickInput
    from bench.rc.transmitter import Sticks, Transmitter
    from bench.screen.keyboard import Keyboard
    from bench.screen.session import Session, session_of
    from bench.screen.stage import to_drive

    bench = simulated("m2006")
    transmitter = Transmitter(bench.robot.rc)

    def inputs(tick: int) -> TickInput:
        forward, left = 0.6 * math.cos(tick / 300.0), 0.6 * math.sin(tick / 300.0)
        sticks = Sticks(forward, left, 0.4) if tick >= 300 else Sticks(aux1=100 <= tick < 200)
        return TickInput(transmitter.step(tick, sticks))

    keyboard = Keyboard(bench.robot.rc)
    run = Run("m2006", bench, 0, inputs, info_of(bench.robot))
    session = Session(InlineLink(bench, inputs, FreePacer(FRAME_TICKS)), keyboard=keyboard)
    if whole:
        stage = to_drive(run, keyboard, FreePacer(FRAME_TICKS))
        stage.link.inputs = inputs
        session = session_of(stage)
        trail: Any = session.link.trail
        trail.extend((2.0 * math.cos(k / 190.0), 1.2 * math.sin(k / 190.0)) for k in range(TRAIL_POINTS))
    for key in UNREACHED_LEVEL:
        session.key(key)
    session.key(str(1 + ("drive", "wires", "scope", "checks").index(page)))
    return session


class Meter:
    """CPU of each frame, after some that warm up; ends the app."""

    def __init__(self, app: Any, frames: int, result: Path) -> None:
        from empty_call import reading_ns  # here: an app whose start is measured does not import it

        self._app, self._result, self._reading_ns = app, result, reading_ns
        self._left = frames + WARM_FRAMES
        self._wanted = frames
        self._seconds: list[float] = []
        self._ticks_s: list[float] = []
        self._calls_ns: list[float] = []
        self._last = 0.0

    def frame(self, run_ticks: Callable[[], None]) -> None:
        """A frame begins, with its ticks."""
        now = time.process_time()
        if self._last:
            self._seconds.append(now - self._last)
        run_ticks()
        self._ticks_s.append(time.process_time() - now)
        begin = time.thread_time()
        self._calls_ns.append(self._reading_ns(EMPTY_CALLS))
        self._last = now + time.thread_time() - begin
        self._left -= 1
        if self._left == 0:
            frames = sorted(self._seconds[-self._wanted :])
            mean_s = math.fsum(frames) / len(frames)
            ticks_s = math.fsum(self._ticks_s[-self._wanted :]) / self._wanted
            longest_s = frames[int(0.99 * (len(frames) - 1))]
            call_ns = sorted(self._calls_ns[-self._wanted :])[self._wanted // 2]
            facts = {
                "frame_s": mean_s,
                "drawing_s": mean_s - ticks_s,
                "frame_p99_s": longest_s,
                "call_ns": call_ns,
            }
            self._result.write_text(json.dumps(facts))
            self._app.exit()


def ours(page: str, frames: int, result: Path, whole: bool) -> None:
    """The dashboard, measured."""
    from bench.tui import Dashboard

    session = session_driven_about(page, whole)
    app = Dashboard(session)
    meter = Meter(app, frames, result)
    frame = session.frame
    session.frame = lambda: meter.frame(frame)
    app.run(mouse=False)


def stock(page: str, frames: int, result: Path, size: tuple[int, int]) -> None:
    """The same content in Textual's own widgets, measured."""
    from textual.app import App, ComposeResult
    from textual.widgets import DataTable, Sparkline, Static

    from bench.screen.text import plain
    from bench.screen.view import draw, places

    session = session_driven_about(page)
    session.sight.size = size
    where = places(session.scene(), *size)

    class Stock(App[None]):
        """Each panel in the widget that a plain app would take for it, at the same place."""

        CSS = "Static, DataTable, Sparkline { position: absolute; }"

        def compose(self) -> ComposeResult:
            for name, place in where.items():
                if name == "scope":
                    half = place.height // 2
                    for number in range(2):
                        line = Sparkline([0.0], id=f"scope{number}")
                        line.styles.offset = (place.x, place.y + number * half)
                        line.styles.width, line.styles.height = place.width, half
                        yield line
                    continue
                widget: Any = DataTable(id=name, show_header=False) if name in TABLES else Static(id=name)
                widget.styles.offset = (place.x, place.y)
                widget.styles.width, widget.styles.height = place.width, place.height
                yield widget

        def on_mount(self) -> None:
            self.meter = Meter(self, frames, result)
            self.cells: dict[str, list[list[str]]] = {}
            self.set_interval(1 / FRAMES_PER_S, self.frame)

        def frame(self) -> None:
            self.meter.frame(session.frame)
            scene = session.scene()
            for name, place in where.items():
                if name == "scope":
                    for number, trace in enumerate(scene.seen.scope.traces):
                        data = [value for value in trace.high if value == value]
                        self.query_one(f"#scope{number}", Sparkline).data = data
                    continue
                lines = draw(name, scene, place.width, place.height)
                if name in TABLES:
                    self.fill(name, [[words for words, _ in line] for line in lines])
                else:
                    self.query_one(f"#{name}", Static).update("\n".join(map(plain, lines)))

        def fill(self, name: str, rows: list[list[str]]) -> None:
            table = self.query_one(f"#{name}", DataTable)
            old = self.cells.get(name)
            width = max(map(len, rows))
            rows = [row + [""] * (width - len(row)) for row in rows]
            if old is None or len(old) != len(rows) or len(old[0]) < width:
                table.clear(columns=True)
                table.add_columns(*[str(column) for column in range(width)])
                for row in rows:
                    table.add_row(*row)
            else:
                rows = [row + [""] * (len(old[0]) - len(row)) for row in rows]
                for y, (before, after) in enumerate(zip(old, rows, strict=True)):
                    for x, (one, other) in enumerate(zip(before, after, strict=True)):
                        if one != other:
                            table.update_cell_at((y, x), other)
            self.cells[name] = rows

    Stock().run(mouse=False)


def main() -> None:
    """Run what the arguments say."""
    # The terminal becomes the one that hangs up on this process: an app must not outlive a benchmark that was killed,
    # not even where all began under nohup.
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    kind, page, columns, rows, frames, result, spawned_s = sys.argv[1:]
    if kind == "empty":
        from textual.app import App

        class Empty(App[None]):
            """Nothing."""

        tell_first_refresh(Empty, Start(Path(result), float(spawned_s)))
        Empty().run(mouse=False)
    elif kind == "first":
        from bench.__main__ import main as wheelbench
        from bench.screen.terminal import Terminal

        tell_writes(Terminal, Start(Path(result), float(spawned_s)))
        wheelbench(["drive"])
    elif kind in ("ours", "driven"):
        ours(page, int(frames), Path(result), kind == "driven")
    else:
        stock(page, int(frames), Path(result), (int(columns), int(rows)))


if __name__ == "__main__":
    main()
