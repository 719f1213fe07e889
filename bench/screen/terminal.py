"""The terminal under the dashboard: Textual's driver with our own reader of keys, and writes that never block for long.

Textual's reader raises on what some terminals send (key releases, bytes that are no UTF-8, numbers too large), takes a
sequence's tail for keys, and believes any size of screen; its writer blocks the program when the terminal is stalled.
Here the bytes go through `terminal_input`, what cannot be written is left out and drawn again later, and a terminal
that has gone is a message. Private names of Textual are used here and nowhere else; tests run the app on a real pty.
"""

from __future__ import annotations

import os
import select
from contextlib import suppress
from queue import Full
from typing import Any

from textual import constants, events, messages
from textual.drivers.linux_driver import LinuxDriver
from textual.keys import _character_to_key
from textual.message import Message

from bench.screen import terminal_input as sent
from bench.screen.guardian import Guardian
from bench.screen.motion import MOTION
from bench.screen.terminal_watch import TerminalWatch

POLL_S = 0.05
ESCAPE_MS = 100
"""After such a pause, ESC was the key."""
BACKLOG = 8
"""More writes than this waiting: the terminal does not take what it is sent. A frame is three or four."""
PATIENCE_S = 1.0
"""So long the last words to a terminal may take."""
REPEATING = frozenset(MOTION) | {"space", "backspace", "delete", "home", "end", "pageup", "pagedown", "tab", *"+-.,[]"}
"""Keys that may repeat where a terminal tells repeats. Any other that is held down counts once: Enter arms."""
ONE_PICTURE, PICTURE_ENDS = "\x1b[?2026h", "\x1b[?2026l"
"""Synchronised output, for terminals that say that they know it: nobody sees half of a frame."""
MOUSE_ON, MOUSE_OFF = "\x1b[?1002h\x1b[?1006h", "\x1b[?1002l\x1b[?1006l"
"""Presses, releases and drags, in SGR form; movement without a button is nobody's business."""


class KeyReleased(Message):
    """A key has been let go."""

    def __init__(self, key: str) -> None:
        super().__init__()
        self.key = key


class CursorReported(Message):
    """The terminal has answered where its cursor stands."""

    def __init__(self, row: int, column: int) -> None:
        super().__init__()
        self.row, self.column = row, column


class KittyReported(Message):
    """The terminal has answered which of Kitty's flags are on."""

    def __init__(self, flags: int) -> None:
        super().__init__()
        self.flags = flags


class TerminalGone(Message):
    """Nothing will ever come from this terminal again."""


class _Outlet:
    """Where the writer's thread writes. A terminal that has gone takes everything in silence."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self.gone = False

    def write(self, text: str) -> None:
        data = text.encode("utf-8", "replace")
        while data and not self.gone:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:
                select.select([], [self._descriptor], [], POLL_S)
            except OSError:
                self.gone = True

    def flush(self) -> None:
        """Nothing is kept back."""

    def fileno(self) -> int:
        return self._descriptor

    def isatty(self) -> bool:
        return True


class Terminal(LinuxDriver):
    """Textual's driver for a terminal that may send anything and stop at any time. `watch` knows whether it lives."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._outlet = _Outlet(self._file.fileno())
        self._file: Any = self._outlet
        self._guardian: Guardian | None = None
        self._in_use = False
        self._pointer_on = False
        self._synchronises = False
        self.lost_writes = False
        """Something was left out: the screen has to be drawn whole, once it is taken again."""
        self.continued = False
        """The process was stopped and goes on, without a word to us before."""
        self.stuck = False
        """The terminal took nothing to the last: whatever else is written to it will wait for ever."""
        self._watch: TerminalWatch | None = None

    @property
    def watch(self) -> TerminalWatch:
        """What the terminal's answers prove, since somebody first asked after it was taken."""
        if self._watch is None:
            from bench.io.clock import now_ns  # with its pacers, which nobody needs before there is a bench

            environment = {"STY": "off"} if constants.DISABLE_KITTY_KEY else os.environ
            self._watch = TerminalWatch(now_ns(), environment)
        return self._watch

    # --- what goes out -------------------------------------------------------------------------------------------

    @property
    def backlog(self) -> int:
        """Writes that the terminal has not taken yet."""
        return self._writer_thread._queue.qsize() if self._writer_thread is not None else 0

    def write(self, data: str) -> None:
        """Queue it for the writer; leave it out where the terminal takes nothing."""
        writer = self._writer_thread
        if writer is None:
            return
        patience_s = 0.0 if self.lost_writes else POLL_S if self._in_use else PATIENCE_S
        try:
            writer._queue.put(data, block=patience_s > 0.0, timeout=patience_s)
        except Full:
            self.lost_writes = True

    def paint(self, picture: str, question: str = "") -> None:
        """Write the changes of one picture, of which nobody shall see a part, and what is to be asked: as one write."""
        if picture and self._synchronises:
            picture = ONE_PICTURE + picture + PICTURE_ENDS
        if picture or question:
            self.write(question + picture)

    def close(self) -> None:
        """End the writer's thread, which may be waiting for a terminal that never takes its bytes."""
        writer = self._writer_thread
        if writer is None:
            return
        with suppress(Full):
            writer._queue.put(None, timeout=PATIENCE_S)
            writer.join(timeout=PATIENCE_S)
        self.stuck = writer.is_alive()
        if self._guardian is not None:
            self._guardian.dismiss()
            self._guardian = None

    def point(self, on: bool) -> None:
        """Have the mouse reported, or leave it to the terminal, for selecting text."""
        if on is not self._pointer_on:
            self._pointer_on = on
            self.write(MOUSE_ON if on else MOUSE_OFF)

    def start_application_mode(self) -> None:
        """Take the terminal, at the start and after every suspension."""
        self._guardian = Guardian(self._outlet.fileno())
        super().start_application_mode()  # type: ignore[no-untyped-call]
        self._in_use = True
        self.watch_anew()
        if self._pointer_on:
            self.write(MOUSE_ON)

    def stop_application_mode(self) -> None:
        """Give the terminal back as it was."""
        self._in_use = False
        if self._pointer_on:
            self.write(MOUSE_OFF)
        super().stop_application_mode()

    def take_again(self) -> None:
        """After an unannounced stop somebody else may have used the terminal: take it as if anew."""
        self.continued = False
        self.suspend_application_mode()
        self.resume_application_mode()

    def watch_anew(self) -> None:
        """Nothing is known of the terminal yet."""
        self._watch = None

    def _sigcont_application(self, *_: object) -> None:
        """The process goes on. Textual would take a terminal twice that it has never given back."""
        if self._in_use:
            self.continued = True
        else:
            super()._sigcont_application()

    def _query_in_band_window_resize(self) -> None:
        """Not asked: sizes come from the system, which can be believed."""

    # --- what comes in, in a thread of its own ---------------------------------------------------------------------

    def run_input_thread(self) -> None:
        """Read until told to stop or until the terminal has gone."""
        decoder = sent.InputDecoder()
        quiet_ms = 0
        while not self.exit_event.is_set():
            if select.select([self.fileno], [], [], POLL_S)[0]:
                quiet_ms = 0
                try:
                    data = os.read(self.fileno, 4096)
                except BlockingIOError:
                    continue
                except OSError:
                    data = b""
                if not data:
                    self.process_message(TerminalGone())
                    return
                self._pass_on(decoder.feed(data))
            elif decoder.waiting:
                quiet_ms += round(POLL_S * 1000)
                if quiet_ms >= ESCAPE_MS:
                    self._pass_on(decoder.settle(quiet_ms))

    def _pass_on(self, inputs: list[sent.Input]) -> None:
        for one in inputs:
            message = self._message(one)
            if message is not None:
                self.process_message(message)

    def _message(self, one: sent.Input) -> Message | None:
        match one:
            case sent.Key(name, _, sent.REPEAT) if name.lower() not in REPEATING:
                return None
            case sent.Key(name, character, kind):
                return KeyReleased(name.lower()) if kind == sent.RELEASE else events.Key(_textual_name(name), character)
            case sent.CursorAt(row, column):
                return CursorReported(row, column)
            case sent.KittyFlags(flags):
                return KittyReported(flags)
            case sent.Focus(here):
                return events.AppFocus() if here else events.AppBlur()
            case sent.Mouse():
                return _mouse_event(one)
            case sent.Pasted(text):
                return events.Paste(text)
            case sent.Mode(2026, setting) if setting > 0:
                self._synchronises = True
                return messages.TerminalSupportsSynchronizedOutput()
        return None


def _textual_name(name: str) -> str:
    """Signs have names in Textual: full_stop, question_mark."""
    modifiers, plus, last = name.rpartition("+") if len(name) > 1 and not name.endswith("+") else ("", "", name)
    return modifiers + plus + (_character_to_key(last) if len(last) == 1 else last)


_MOUSE_EVENTS: dict[str, type[events.MouseEvent]] = {
    sent.DOWN: events.MouseDown,
    sent.MOVE: events.MouseMove,
    sent.UP: events.MouseUp,
    sent.WHEEL_UP: events.MouseScrollUp,
    sent.WHEEL_DOWN: events.MouseScrollDown,
}


def _mouse_event(mouse: sent.Mouse) -> events.MouseEvent:
    x, y = float(mouse.x), float(mouse.y)
    return _MOUSE_EVENTS[mouse.kind](None, x, y, 0, 0, mouse.button, False, False, False, screen_x=x, screen_y=y)
