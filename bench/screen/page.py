"""Textual's driver for a browser, with what it lacks: when the server is gone, nobody will ever press Space again."""

from __future__ import annotations

from textual.drivers.web_driver import WebDriver

from bench.screen.terminal import TerminalGone


class Page(WebDriver):
    """A page of a browser, by way of textual-serve."""

    def run_input_thread(self) -> None:
        """Read until the app ends, or what it reads from does."""
        super().run_input_thread()
        if not self.exit_event.is_set():
            self._app.post_message(TerminalGone())
