"""The dashboard in a browser on this machine: `wheelbench drive --web`, by textual-serve (the extra `web`).

One page drives at a time, each with a process of its own; a page that is closed ends its process, which stops the
robot first. The page is ours: textual-serve's own fetches a font from the network. Only pages that came from here may
connect: any page in the same browser could otherwise drive, because websockets know no same-origin rule.
"""

from __future__ import annotations

import asyncio
import shlex
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any

from aiohttp import web
from textual_serve.server import Server

HOST = "127.0.0.1"
DRIVES: web.AppKey[Any] = web.AppKey("drives", object)
OUR_NAMES = ("127.0.0.1", "localhost", "[::1]")
WAIT_S = 5.0
"""A page that is loaded again waits so long for the one before it to end."""
POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src 'self' ws:; worker-src 'self' blob:; frame-ancestors 'none'"
)
"""The page fetches nothing from elsewhere, and stands in nobody's frame."""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>wheelbench</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/static/css/xterm.css">
<script src="/static/js/textual.js"></script>
<style>
@font-face {{ font-family: "Roboto Mono"; src: url("/static/fonts/RobotoMono-VariableFont_wght.ttf"); }}
html, body {{ margin: 0; height: 100%; background: #10141a; color: #c8d0d8; font-family: "Roboto Mono", monospace; }}
.textual-terminal {{ height: 100vh; }}
.ended {{ display: none; position: absolute; inset: 0; z-index: 10; background: #10141a; padding: 3em; }}
body.-closed .ended {{ display: block; }}
a {{ color: #6fc3df; }}
</style>
</head>
<body>
<div class="ended"><p>The drive has ended, and the robot is at rest. The terminal that serves this page says what was
recorded, or why nothing was driven.</p><p>One page drives at a time.
<a href="/">Drive again</a></p></div>
<div id="terminal" class="textual-terminal" data-session-websocket-url="ws://{host}/ws" data-font-size="{size}"></div>
</body>
</html>
"""


class DashboardServer(Server):
    """Serves the dashboard. `command` gives the arguments of the n-th drive's process, n from 1."""

    def __init__(self, command: Callable[[int], Sequence[str]], port: int, tell: Callable[[str], object]) -> None:
        super().__init__(shlex.join(command(1)), host=HOST, port=port, title="wheelbench")
        self._command = command
        self._tell = tell
        self._drives = 0
        self._turn = asyncio.Lock()

    def serve(self, debug: bool = False) -> None:
        """Serve until Ctrl-C, and say where as soon as somebody may come. Raises OSError for a port that is taken."""
        said = f"the dashboard is at http://{self.host}:{self.port} (this machine only); Ctrl-C ends it"

        def say(*_: object) -> None:
            self._tell(said)

        web.run_app(
            self._make_app(),
            host=self.host,
            port=self.port,
            print=say,
            access_log=None,
            shutdown_timeout=WAIT_S,
        )

    async def on_startup(self, app: web.Application) -> None:
        """Nothing is said yet: nobody can come."""

    async def on_shutdown(self, app: web.Application) -> None:
        """Whoever drives is at the end of their drive, and the robot stops."""
        for drive in list(app[DRIVES]):
            drive.cancel()

    async def _make_app(self) -> web.Application:
        app = await super()._make_app()
        app[DRIVES] = set()
        app.middlewares.append(_only_ours)
        return app

    async def handle_index(self, request: web.Request) -> web.Response:
        """The page."""
        size = request.query.get("fontsize", "")
        text = _PAGE.format(host=request.host, size=size if size.isdecimal() else "16")
        return web.Response(text=text, content_type="text/html", headers={"Content-Security-Policy": POLICY})

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """One page's drive, from beginning to end."""
        if request.headers.get("Origin") != f"http://{request.host}":
            raise web.HTTPForbidden(text="only a page that came from here may drive")
        try:
            await asyncio.wait_for(self._turn.acquire(), WAIT_S)
        except TimeoutError:
            raise web.HTTPConflict(text="another page drives") from None
        task = asyncio.current_task()
        try:
            request.app[DRIVES].add(task)
            self._drives += 1
            self.command = shlex.join(self._command(self._drives))
            return await super().handle_websocket(request)
        finally:
            request.app[DRIVES].discard(task)
            self._turn.release()


@web.middleware
async def _only_ours(
    request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
) -> web.StreamResponse:
    """Refuse requests by another name: a foreign name that leads to this machine is somebody's trick."""
    name = request.host.rpartition(":")[0] or request.host
    if name not in OUR_NAMES:
        raise web.HTTPForbidden(text=f"this is for {' or '.join(OUR_NAMES)} only")
    return await handler(request)


def record_directory(first: Path, drive: int) -> Path:
    """Where the n-th drive records: the directory that was asked for, and then others beside it."""
    return first if drive == 1 else first.with_name(f"{first.name}-{drive:03d}")
