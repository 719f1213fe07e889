"""The dashboard: Textual's keys to a session, 20 frames a second, a scene to the panels. `drive` and `show` open it.

What a key does is in `screen/session.py` and `screen/keyboard.py`, what is shown in `screen/view.py`, how time passes
in `io/`. Here is only what needs Textual.
"""

from __future__ import annotations

import os
import signal
from types import FrameType

from textual import events
from textual.app import App, ComposeResult

from bench.check.reading import Recording
from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.summary import Summary
from bench.errors import EXIT_FAILED, EXIT_OK
from bench.io.clock import Pacer, WallPacer
from bench.io.link import InlineLink, Taker
from bench.screen.keyboard import Keyboard
from bench.screen.lamp import GoldenLamp
from bench.screen.panel import BACKGROUND, FOREGROUND, Panel
from bench.screen.session import Session
from bench.screen.view import PANELS, draw, places

FRAMES_PER_S = 20
ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SIGNS = {"=": "+", "_": "-"}
"""What the keys of + and - give without, or with, shift."""


class Dashboard(App[None], inherit_bindings=False):
    """A session on the screen."""

    ENABLE_COMMAND_PALETTE = False
    CSS = f"Screen {{ background: {BACKGROUND}; color: {FOREGROUND}; overflow: hidden; }}"

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self._panels: dict[str, Panel] = {}
        self._asked_to_leave = False
        self._handlers: dict[signal.Signals, signal._HANDLER] = {}

    def compose(self) -> ComposeResult:
        """A panel for everything that can be shown; each frame puts those it needs where they belong."""
        self._panels = {name: Panel(name) for name in PANELS}
        yield from self._panels.values()

    def on_mount(self) -> None:
        """Start the frames; let the system's ways to end a program be as orderly as the keys."""
        for change in (self.app_suspend_signal, self.app_resume_signal):
            change.subscribe(self, lambda _: self.session.asleep())
        for number in ENDING_SIGNALS:
            self._handlers[number] = signal.signal(number, self._on_signal)
        self.set_interval(1 / FRAMES_PER_S, self.frame)
        self.frame()

    def on_unmount(self) -> None:
        """Signals mean again what they meant before."""
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    def on_resize(self) -> None:
        """Draw for the new size at once."""
        self._draw()

    def on_app_blur(self) -> None:
        """The keyboard belongs to another window now."""
        self.session.hands_off()

    def on_key(self, event: events.Key) -> None:
        """Every key ends here: there is nothing on the screen that could take one. The next frame shows its effect."""
        event.stop()
        if event.key == "ctrl+z":
            self.action_suspend_process()
            return
        sign = event.character or ""
        printed = len(sign) == 1 and sign.isprintable() and not sign.isspace()
        self.session.key(SIGNS.get(sign, sign.lower()) if printed else event.key)
        self._leave_if_over()

    def frame(self) -> None:
        """One frame: the ticks that are due, then the picture."""
        if self._asked_to_leave:
            self.session.leave()
        else:
            self.session.frame()
        if not self._leave_if_over():
            self._draw()

    def _on_signal(self, number: int, stack: FrameType | None) -> None:
        """Only a mark: what a signal interrupts may be the middle of a tick."""
        self._asked_to_leave = True

    def _leave_if_over(self) -> bool:
        if self.session.over:
            self.exit()
        return self.session.over

    def _draw(self) -> None:
        if not self._panels:
            return
        self.session.sight.size = self.size
        scene = self.session.scene()
        where = places(scene, *self.size)
        for name, panel in self._panels.items():
            place = where.get(name)
            panel.put(place)
            if place is not None:
                panel.show(draw(name, scene, place.width, place.height))


def drive(job: Run, keyboard: Keyboard, recorder: Recorder | None = None, pacer: Pacer | None = None) -> int:
    """Drive a run's bench by keyboard until the person leaves. Returns the exit status; raises what ended it."""
    link = InlineLink(job.bench, keyboard.inputs, pacer or WallPacer(), takers=[recorder] if recorder else [])
    return _open(Session(link, keyboard=keyboard, recording=str(recorder.directory) if recorder else ""))


def show(
    run: Run, recorder: Recorder | None = None, golden: Recording | None = None, pacer: Pacer | None = None
) -> int:
    """Play a run as it happens; at its end wait for the person to leave. Returns the exit status; raises what ended it.

    Every frame is held against `golden`, or against the recording that the run repeats. The status is 1 where it
    differs beyond the tolerances.
    """
    golden = golden or run.source
    lamp = GoldenLamp(golden) if golden is not None else None
    summary = Summary(len(run.bench.robot.wheels))
    takers: list[Taker] = [summary, *(taker for taker in (recorder, lamp) if taker is not None)]
    link = InlineLink(run.bench, run.inputs, pacer or WallPacer(), takers=takers, ticks=run.ticks)
    directory = str(recorder.directory) if recorder else ""
    status = _open(Session(link, job=run, lamp=lamp, summary=summary, recording=directory))
    return EXIT_FAILED if lamp is not None and lamp.first is not None else status


def _open(session: Session) -> int:
    app = Dashboard(session)
    for name in ("COLUMNS", "LINES"):
        os.environ.pop(name, None)  # where they are set (readline does), they would stand for the size for ever
    try:
        app.run(mouse=False)  # nothing takes the mouse: it stays the terminal's, for selecting text
    finally:
        session.link.close()
    if session.failure is not None:
        raise session.failure
    return app.return_code or EXIT_OK
