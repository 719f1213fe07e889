"""The dashboard: Textual's keys to a session, 20 frames a second, a scene to the panels. `drive` and `show` open it.

What a key does is in `screen/session.py` and `screen/keyboard.py`, what is shown in `screen/view.py`, how time passes
in `io/`. Here is only what needs Textual.

What needs the bench is imported late: the screen opens first, with every pane where it will stand.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Container
from types import FrameType
from typing import TYPE_CHECKING, TypeAlias

from textual import constants, events
from textual.app import App, ComposeResult
from textual.driver import Driver
from textual.drivers.linux_driver import LinuxDriver

from bench.errors import EXIT_FAILED, EXIT_OK
from bench.screen.ink import Inks
from bench.screen.layout import OVER, PANELS, Place
from bench.screen.motion import MOTION
from bench.screen.opening import Opening
from bench.screen.panel import BACKGROUND, FOREGROUND, Panel, inks_of
from bench.screen.terminal import BACKLOG, CursorReported, KeyReleased, KittyReported, Terminal, TerminalGone
from bench.screen.terminal_watch import STALL_MS

if TYPE_CHECKING:
    from bench.check.run import Run
    from bench.io.process.link import ProcessLink
    from bench.screen.keyboard import Keyboard
    from bench.screen.session import Session
    from bench.screen.stage import Show, Stage

FRAMES_PER_S = 20
ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
READY_TICKS = 100
"""A base arms by a switch that it has seen at rest: what is pressed before its first frames waits for these."""
AT_ONCE = ("space", "escape", "ctrl+q", "ctrl+c")
SIGNS = {"=": "+", "_": "-"}
"""What the keys of + and - give without, or with, shift."""
Tell: TypeAlias = Callable[[str], object]


def _tell_nobody(_: str) -> None:
    pass


class Dashboard(App[None], inherit_bindings=False):
    """A session on the screen."""

    ENABLE_COMMAND_PALETTE = False
    ALLOW_SELECT = False
    CSS = f"Screen {{ background: {BACKGROUND}; color: {FOREGROUND}; overflow: hidden; }}"

    def __init__(
        self,
        session: Session | None = None,
        prepare: Callable[[], Session] | None = None,
        opening: Opening | None = None,
    ) -> None:
        """A session that is there, or one that `prepare` makes while the `opening` picture stands."""
        super().__init__()
        self._session = session
        self._prepare = prepare
        self._opening = opening
        self.refused: Exception | None = None
        """Why there is no session."""
        self._keys_wait = session is None
        self._early: list[tuple[str, float]] = []
        """Keys that wait for it, and when they came."""
        self._curtain: Panel | None = None
        """The opening picture, until the panels stand over it."""
        self._panels: dict[str, Panel] = {}
        self._where: dict[str, Place] = {}
        """Which panels stand where."""
        self._pad_place: Place | None = None
        self._settled = False
        """Every panel stands where it was last put."""
        self._inks: Inks = {}
        self._asked_to_leave = False
        self._handlers: dict[signal.Signals, signal._HANDLER] = {}

    @property
    def session(self) -> Session:
        """What is on the screen. There is none yet while the bench is being built."""
        if self._session is None:
            raise ValueError("there is no session yet")
        return self._session

    @property
    def has_session(self) -> bool:
        """Whether there is a bench."""
        return self._session is not None

    def compose(self) -> ComposeResult:
        """A panel for everything that can be shown; each frame puts those it needs where they belong."""
        if self._session is None:
            self._curtain = Panel("opening")
            yield self._curtain
        else:
            self._panels = {name: Panel(name) for name in PANELS}
            yield from self._panels.values()

    def on_mount(self) -> None:
        """Show what there is; let the system's ways to end a program be as orderly as the keys."""
        for change in (self.app_suspend_signal, self.app_resume_signal):
            change.subscribe(self, lambda _: self._session.asleep() if self._session is not None else None)
        for number in ENDING_SIGNALS:
            self._handlers[number] = signal.signal(number, self._on_signal)
        if self._session is not None:
            self._begin()
        else:
            self._draw_opening()
            self.call_after_refresh(self._build)

    def _build(self) -> None:
        """The opening picture is on the screen: make what it stands for."""
        assert self._prepare is not None
        try:
            self._session = self._prepare()
        except Exception as error:  # raised again once the terminal is back
            self.refused = error
            self.exit()
            return
        if self.terminal is not None:
            self.terminal.watch_anew()  # nothing was asked until now
        self._begin()

    def _begin(self) -> None:
        """Start the frames."""
        if not self._panels:
            self._panels = {name: Panel(name) for name in PANELS}
            self.mount(*self._panels.values())
        self.set_interval(1 / FRAMES_PER_S, self.frame)
        self.frame()

    def on_unmount(self) -> None:
        """Signals mean again what they meant before."""
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    def on_resize(self) -> None:
        """Draw for the new size at once."""
        if self._session is None:
            self._draw_opening()
            return
        picture = self._draw()
        if self.terminal is not None:
            self.terminal.paint(picture)

    def on_app_blur(self) -> None:
        """The keyboard belongs to another window now."""
        if self._session is not None:
            self._session.hands_off()

    async def on_event(self, event: events.Event) -> None:
        """Keys are taken before anything on the screen can, in the order in which they came with their releases.

        A text field that is being typed in gets what is typed; Space stops the robot all the same.
        """
        if isinstance(event, events.Key) and not event.is_forwarded:
            typing = self.focused is not None or len(self.screen_stack) > 1
            stops = event.key.rpartition("+")[2] == "space"
            if stops or not typing:
                self._press("space" if stops else _name(event), event.time)
            if not typing:
                return
        if isinstance(event, events.MouseEvent) and not event.is_forwarded and self._session is not None:
            self._point(event)
        await super().on_event(event)

    def on_key_released(self, message: KeyReleased) -> None:
        """The terminal tells: this key is no longer held."""
        if self._session is not None:
            self._session.let_go(message.key)

    def on_kitty_reported(self, message: KittyReported) -> None:
        """The terminal speaks Kitty's protocol: have it tell releases."""
        terminal = self.terminal
        if terminal is not None:
            terminal.write(terminal.watch.kitty(message.flags, _now_ns()))

    def on_cursor_reported(self, message: CursorReported) -> None:
        """The terminal is alive. What was held when it answered still is."""
        terminal = self.terminal
        answered = terminal is not None and terminal.watch.answered(message.row, message.column, _now_ns())
        if answered and self._session is not None:
            self._session.alive()

    def on_terminal_gone(self, _: TerminalGone) -> None:
        """Nobody will ever press Space again."""
        self._asked_to_leave = True

    @property
    def terminal(self) -> Terminal | None:
        """The terminal that can be asked whether it is alive; None in tests without one, and in a browser."""
        return self._driver if isinstance(self._driver, Terminal) else None

    def get_driver_class(self) -> type[Driver]:
        """Ours in place of Textual's, for terminals and browsers; any other (a test's) as it is."""
        driver = super().get_driver_class()
        if driver is LinuxDriver:
            return Terminal
        if driver.__name__ == "WebDriver":
            from bench.screen.page import Page

            return Page
        return driver

    def frame(self) -> None:
        """One frame: the ticks that are due, then the picture."""
        if self._asked_to_leave:
            self.session.leave(patience=False)
        else:
            self._look_after_terminal()
            self.session.frame()
            self._hear_early()
        if not self._leave_if_over():
            picture, terminal = self._draw(), self.terminal
            if terminal is not None and terminal.backlog <= BACKLOG:
                terminal.paint(picture, terminal.watch.ask(_now_ns(), self.size.width))

    def _hear_early(self) -> None:
        """The keys that came before the bench, once it can heed them: at once, where it is only shown."""
        session = self.session
        if self._keys_wait and (session.keyboard is None or session.link.newest_tick >= READY_TICKS):
            self._keys_wait = False
            early, self._early = self._early, []
            for key, at_s in early:
                if key in MOTION and self.terminal is None:
                    session.too_late(int(_now_ns() / 1e6 - at_s * 1e3))  # a browser's keys do not tell how old they are
                else:
                    self._press(key, at_s)

    def _press(self, key: str, at_s: float) -> None:
        """A key that was received at that time. One that moves something is not heard if it may be an old one."""
        if key == "space":
            self._early.clear()  # a stop takes back what was pressed before it
        if self._session is None or (self._keys_wait and key not in AT_ONCE):
            self._early.append((key, at_s))
            return
        if key == "ctrl+z":
            self.action_suspend_process()
            return
        age_ms = self._age_ms(at_s)
        if key in MOTION and age_ms > STALL_MS and not self.session.stands:
            self.session.too_late(age_ms)
        else:
            self.session.key(key)
        self._leave_if_over()

    def _age_ms(self, at_s: float) -> int:
        """How long ago what was received then may have been done."""
        terminal = self.terminal
        if terminal is None:
            return 0
        now = _now_ns()
        age_ms = int(now / 1e6 - at_s * 1e3)
        return max(age_ms, terminal.watch.age_ms(now)) if terminal.watch.answers else age_ms

    def _point(self, event: events.MouseEvent) -> None:
        """The mouse, for the sticks that are drawn for it. The screen's edge is where it leaves the window."""
        from bench.screen.mouse_sticks import pad_of

        place, session = self._pad_place, self.session
        x, y = int(event.x), int(event.y)
        outside = not (0 < x < self.size.width - 1 and 0 < y < self.size.height - 1)
        if place is None or outside or isinstance(event, events.MouseUp):
            session.drop()
        elif isinstance(event, events.MouseDown | events.MouseMove):
            if (age_ms := self._age_ms(event.time)) > STALL_MS:
                session.drop()
                session.too_late(age_ms)
                return
            pressed = isinstance(event, events.MouseDown)
            session.point(pressed, x - place.x, y - place.y, pad_of(place.width, place.height))

    def _look_after_terminal(self) -> None:
        """Ask it whether it is alive, and let go of everything when it does not answer or takes nothing."""
        terminal, session = self.terminal, self.session
        if terminal is None:
            return
        if terminal.continued:
            terminal.take_again()
            session.asleep()
            self.refresh(layout=True)
        now = _now_ns()
        watch = terminal.watch
        if session.keyboard is not None:
            session.keyboard.sticks.releases = watch.releases and watch.answers
            session.keyboard.sticks.proven = watch.trusted and watch.answers
            terminal.point(session.keyboard.mouse.on)
        is_behind = terminal.backlog > BACKLOG
        if terminal.lost_writes and not is_behind:
            terminal.lost_writes = False
            self.refresh(layout=True)
        if watch.stalled(now):
            session.silence(watch.age_ms(now))
        elif is_behind:
            session.hands_off()

    def _on_signal(self, number: int, stack: FrameType | None) -> None:
        """Only a mark: what a signal interrupts may be the middle of a tick."""
        self._asked_to_leave = True

    def _leave_if_over(self) -> bool:
        if self.session.over:
            self.exit()
        return self.session.over

    def _draw_opening(self) -> None:
        if self._opening is not None and self._curtain is not None:
            width, height = self.size
            self._curtain.put(Place(0, 0, width, height))
            self._curtain.show(self._opening.whole(width, height))

    def _draw(self) -> str:
        """Bring the panels up to date. What of that is to be written to the terminal; Textual sees to the rest."""
        if not self._panels or (self.terminal is not None and self.terminal.backlog > BACKLOG):
            return ""  # a terminal that takes nothing is drawn for when it does again
        from bench.screen.view import draw, places

        self.session.sight.size = self.size
        scene = self.session.scene()
        where = places(scene, *self.size)
        if where != self._where:
            self._where, self._pad_place, self._settled = where, where.get("pad"), False
            for name, panel in self._panels.items():
                panel.put(where.get(name))
        if self._curtain is not None and all(panel.stands for panel in self._panels.values()):
            self._curtain.put(None)
            self._curtain = None
        straight = self._is_plain(where)
        changes = []
        for name, place in where.items():
            panel, lines = self._panels[name], draw(name, scene, place.width, place.height)
            if straight:
                changes.append(panel.patch(lines, self._inks))
            else:
                panel.show(lines)
        return "".join(changes)

    def _is_plain(self, where: Container[str]) -> bool:
        """Whether the panels lie on a terminal as they are: each where it belongs, nothing over them."""
        if self.terminal is None or any(name in where for name in OVER) or len(self.screen_stack) > 1:
            return False
        if not self._settled:
            self._settled = all(panel.stands for panel in self._panels.values())
            self._inks = self._inks or inks_of(self.console, self.get_line_filters())
        return self._settled


def _now_ns() -> int:
    from bench.io.clock import now_ns  # late, like all that the first picture does not need

    return now_ns()


def _name(event: events.Key) -> str:
    """A lower-case letter, a sign as it is printed, or the name of a key without a character."""
    sign = event.character or ""
    printed = len(sign) == 1 and sign.isprintable() and not sign.isspace()
    return SIGNS.get(sign, sign.lower()) if printed else event.key


def drive(prepare: Callable[[], Session], opening: Opening | None = None, tell: Tell = _tell_nobody) -> int:
    """Drive until the person leaves. Returns the exit status; raises what ended it.

    `prepare` makes the session while the opening picture is on the screen; at once, where there is none. `tell` gets
    what is worth saying once the screen is gone.
    """
    return _run(Dashboard(prepare()) if opening is None else Dashboard(None, prepare, opening), tell)


def drive_ports(link: ProcessLink, job: Run, keyboard: Keyboard, recording: str = "", tell: Tell = _tell_nobody) -> int:
    """The same, where a part is real and the loop has a process of its own, which records too."""
    from bench.screen.session import session_of
    from bench.screen.stage import Stage

    return drive(lambda: session_of(Stage(link, job, keyboard), recording=recording), tell=tell)


def show(prepare: Callable[[], Show], opening: Opening | None = None, tell: Tell = _tell_nobody) -> int:
    """Play a run as it happens; at its end wait for the person to leave. Returns the exit status; raises what ended it.

    `prepare`, `opening` and `tell` are as those of `drive`. Every frame is held against the golden, or against the
    recording that the run repeats. The status is 1 where it differs beyond the tolerances, and where an expectation was
    not met.
    """
    stages: list[Stage] = []

    def staged() -> Session:
        from bench.io.clock import WallPacer
        from bench.screen.session import session_of
        from bench.screen.stage import to_show

        run, recorder, golden, settings = prepare()
        stages.append(to_show(run, golden, WallPacer()))
        return session_of(stages[0], recorder, settings)

    status = drive(staged, opening, tell)
    return EXIT_FAILED if any(map(_has_failed, stages)) else status


def _has_failed(stage: Stage) -> bool:
    differs = stage.lamp is not None and stage.lamp.first is not None
    # Whoever goes back and on from there has no run to its end any more.
    checks = stage.job.checks if stage.agree in stage.link.takers and stage.link.ended else None
    return differs or (checks is not None and not all(outcome.ok for outcome in checks.outcomes()))


def _run(app: Dashboard, tell: Tell) -> int:
    in_browser = constants.DRIVER is not None
    for name in () if in_browser else ("COLUMNS", "LINES"):
        os.environ.pop(name, None)  # where they are set (readline does), they would stand for the size for ever
    try:
        # A terminal's mouse stays its own, for selecting text, until M asks for it; a browser's has nothing else to do.
        app.run(mouse=in_browser)
    finally:
        if app.has_session:
            app.session.leave(patience=False)  # a page that was closed, or a screen that failed, asks for nothing more
            app.session.link.close()
            if app.session.keyboard is not None:
                app.session.keyboard.close()
    if app.refused is not None:
        raise app.refused
    if not app.has_session:
        return app.return_code or EXIT_OK
    session = app.session
    for line in session.working.told if app.terminal is None or not app.terminal.stuck else ():
        tell(line)
    if session.failure is not None:
        raise session.failure
    return app.return_code or (EXIT_FAILED if session.unmet else EXIT_OK)
