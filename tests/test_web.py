"""The dashboard as a page: served on loopback, driven through its websocket, closed; in a browser if there is one."""

import asyncio
import json
import os
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress

import pytest

from bench.__main__ import main
from bench.check.reading import Recording
from bench.screen.opening import BUILDING

DEADLINE_S = 60.0
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture
def aiohttp():
    return pytest.importorskip("aiohttp", reason="textual-serve (the extra `web`) is not installed")


@contextmanager
def served(place, *options):
    """A server of the dashboard, once it says where; its address. Ends with Ctrl-C."""
    held = socket.socket()  # its number is given to nobody else, and may be listened on all the same
    held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    held.bind(("127.0.0.1", 0))
    port = held.getsockname()[1]
    command = [sys.executable, "-m", "bench", "drive", "--web", "--port", str(port), *map(str, options)]
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    server = subprocess.Popen(command, cwd=place, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        assert f"http://127.0.0.1:{port} (this machine only)" in server.stdout.readline().decode()
        yield f"127.0.0.1:{port}", server
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(DEADLINE_S)
        server.stdout.close()
        held.close()


def whole(directory):
    """The recording, once it is complete: the robot stood still and was disarmed at its end."""
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        if (directory / "run.toml").exists() and Recording.open(directory).complete:
            recording = Recording.open(directory)
            assert recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)
            armed = recording.state_columns.index("armed")
            assert recording.state[max(recording.state)][armed] == 0
            return recording
        time.sleep(0.05)
    raise AssertionError(f"{directory}: no whole recording within {DEADLINE_S:g} s")


def drove(directory):
    """Whether a recording, be it one that is still being written, is of a robot that has moved."""
    if not (directory / "run.toml").exists():
        return False
    return max((abs(row[1]) for row in Recording.open(directory).state.values()), default=0.0) > 0.005


class Page:
    """What a page of the server is sent, read as it comes."""

    def __init__(self, wire):
        self.wire, self.seen = wire, b""

    async def type(self, keys):
        await self.wire.send_str(json.dumps(["stdin", keys]))

    async def read(self, seconds):
        message = await self.wire.receive(timeout=seconds)
        assert message.data is not None, self.seen[-300:]
        self.seen += message.data if isinstance(message.data, bytes) else b""

    async def see(self, *texts, since=0):
        """Read until it holds these texts, one after the other."""
        end = time.monotonic() + DEADLINE_S
        wanted = re.compile(b".*".join(re.escape(text.encode()) for text in texts), re.DOTALL)
        while not wanted.search(self.seen, since):
            await self.read(max(0.1, end - time.monotonic()))

    async def arm(self):
        since = len(self.seen)
        await self.type("\r")
        await self.see(" ARMED ", since=since)

    async def hold_w(self, directory):
        """Until the robot has moved; armed again where a busy machine was silent for so long that it was disarmed."""
        end = time.monotonic() + DEADLINE_S
        while not drove(directory):
            assert time.monotonic() < end, "the robot does not move"
            if self.seen.rfind(b" DISARMED ") > self.seen.rfind(b" ARMED "):
                await self.arm()
            for _ in range(10):
                await self.type("w")
                with suppress(TimeoutError):
                    await self.read(0.03)


async def driven(aiohttp, address, directory, after=None):
    """A page that arms and drives until the robot has moved; `after` is done while it is still open."""
    async with aiohttp.ClientSession() as browser:
        headers = {"Origin": f"http://{address}"}
        async with browser.ws_connect(f"ws://{address}/ws?width=80&height=24", headers=headers) as wire:
            page = Page(wire)
            await page.see(BUILDING.upper(), "not armed since boot")
            await wire.send_str(json.dumps(["focus"]))
            await page.arm()
            await page.hold_w(directory)
            if after is not None:
                after()
                async for _ in wire:  # until the server closes it
                    pass


async def strangers(aiohttp, address):
    """Who else may want to come, and what the page asks for."""
    async with aiohttp.ClientSession() as browser:
        async with browser.get(f"http://{address}/") as answer:
            text = await answer.text()
            assert answer.status == 200
            assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
            assert "//" not in text.replace(f"ws://{address}/ws", ""), "no address but its own"
        for part in ("css/xterm.css", "js/textual.js", "fonts/RobotoMono-VariableFont_wght.ttf"):
            async with browser.get(f"http://{address}/static/{part}") as answer:
                assert answer.status == 200, part
        for origin in ("http://elsewhere.example", None):
            headers = {"Origin": origin} if origin else {}
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await browser.ws_connect(f"ws://{address}/ws", headers=headers)
            assert refused.value.status == 403
        async with browser.get(f"http://{address}/", headers={"Host": "elsewhere.example"}) as answer:
            assert answer.status == 403


def test_a_page_drives_and_its_end_stops_the_robot(aiohttp, tmp_path):
    """Whether the page is closed, or the server is asked to end; and only our own page may drive."""
    with served(tmp_path, "--record", tmp_path / "run") as (address, server):
        asyncio.run(strangers(aiohttp, address))
        asyncio.run(driven(aiohttp, address, tmp_path / "run"))
        whole(tmp_path / "run")
        again = tmp_path / "run-002"  # the next page has a recording of its own
        asyncio.run(driven(aiohttp, address, again, lambda: server.send_signal(signal.SIGINT)))
        whole(again)
        assert server.wait(DEADLINE_S) == 0


def test_a_server_that_is_killed_leaves_no_robot_that_drives(aiohttp, tmp_path):
    with served(tmp_path, "--record", tmp_path / "run") as (address, server):
        asyncio.run(driven(aiohttp, address, tmp_path / "run", server.kill))
        whole(tmp_path / "run")


def test_what_is_refused_while_the_bench_is_built_ends_the_page_which_says_where_it_is_told(aiohttp, tmp_path):
    async def refused(address):
        seen = b""
        async with aiohttp.ClientSession() as browser:
            headers = {"Origin": f"http://{address}"}
            async with browser.ws_connect(f"ws://{address}/ws?width=80&height=24", headers=headers) as page:
                async with browser.get(f"http://{address}/") as answer:
                    assert "says what was\nrecorded, or why nothing was driven" in await answer.text()
                while (message := await page.receive(timeout=DEADLINE_S)).type is aiohttp.WSMsgType.BINARY:
                    seen += message.data
        return seen

    with served(tmp_path, "--profile", "nobody") as (address, server):
        assert BUILDING.upper().encode() in asyncio.run(refused(address))
        assert select.select([server.stdout], [], [], DEADLINE_S)[0], "the server says nothing of it"
        assert b"no profile is called 'nobody'" in server.stdout.readline()


def test_a_port_that_is_taken_is_a_sentence(aiohttp, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        command = [sys.executable, "-m", "bench", "drive", "--web", "--port", str(port)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert done.stderr.startswith(f"wheelbench drive: --web: port {port} cannot be used")
    assert done.stderr.count("\n") == 1


def test_without_the_extra_there_is_one_sentence(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "textual_serve.server", None)
    monkeypatch.delitem(sys.modules, "bench.screen.web", raising=False)
    assert main(["drive", "--web"]) == 3
    assert "pip install 'wheelbench[web]'" in capsys.readouterr().err
    assert main(["drive", "--web", "--port", "0"]) == 2


# --- a real browser --------------------------------------------------------------------------------------------------


class Browser:
    """Headless Chromium by its debugging protocol: what it fetches, what is on the page, keys."""

    def __init__(self, aiohttp, folder):
        self.aiohttp, self.folder = aiohttp, folder
        self.fetched = []
        self._number = 0

    async def __aenter__(self):
        flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"]
        flags += ["--disable-background-networking", "--disable-component-update", "--window-size=1000,700"]
        flags += ["--remote-debugging-port=0"]
        self.process = subprocess.Popen(
            [BROWSER, *flags, f"--user-data-dir={self.folder}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        told = self.folder / "DevToolsActivePort"
        end = time.monotonic() + DEADLINE_S
        while not (told.exists() and told.read_text().count("\n")):
            assert time.monotonic() < end, "the browser does not start"
            await asyncio.sleep(0.05)
        self.http = self.aiohttp.ClientSession()
        async with self.http.get(f"http://127.0.0.1:{told.read_text().split()[0]}/json") as answer:
            page = next(one for one in await answer.json() if one["type"] == "page")
        self.wire = await self.http.ws_connect(page["webSocketDebuggerUrl"], max_msg_size=0)
        return self

    async def __aexit__(self, *_):
        await self.wire.close()
        await self.http.close()
        self.process.terminate()
        await asyncio.to_thread(self.process.wait, DEADLINE_S)

    async def do(self, method, **parameters):
        self._number += 1
        await self.wire.send_json({"id": self._number, "method": method, "params": parameters})
        while True:
            said = json.loads((await self.wire.receive(timeout=DEADLINE_S)).data)
            if said.get("method") == "Network.requestWillBeSent":
                self.fetched.append(said["params"]["request"]["url"])
            if said.get("id") == self._number:
                return said["result"]

    async def ask(self, expression):
        return (await self.do("Runtime.evaluate", expression=expression))["result"].get("value")

    async def until(self, expression):
        end = time.monotonic() + DEADLINE_S
        while not await self.ask(expression):
            assert time.monotonic() < end, expression
            await asyncio.sleep(0.1)

    async def key(self, key, code, text):
        number = ord(text.upper())
        await self.do(
            "Input.dispatchKeyEvent", type="keyDown", key=key, code=code, text=text, windowsVirtualKeyCode=number
        )
        await self.do("Input.dispatchKeyEvent", type="keyUp", key=key, code=code, windowsVirtualKeyCode=number)


@pytest.mark.skipif(BROWSER is None, reason="chromium is not installed: no browser to open the page in")
def test_in_a_browser_it_loads_drives_and_stops_when_the_page_is_closed(aiohttp, tmp_path):
    async def look(address):
        async with Browser(aiohttp, tmp_path / "profile") as browser:
            await browser.do("Network.enable")
            await browser.do("Page.enable")
            await browser.do("Page.navigate", url=f"http://{address}/")
            await browser.until("document.body.classList.contains('-first-byte')")
            await browser.until("document.fonts.check('16px \"Roboto Mono\"')")
            await asyncio.sleep(1.0)
            await browser.ask("document.querySelector('textarea').focus()")
            await browser.key("Enter", "Enter", "\r")
            await asyncio.sleep(0.5)
            end = time.monotonic() + DEADLINE_S
            while not drove(tmp_path / "run"):
                assert time.monotonic() < end, "the robot does not move"
                for _ in range(10):
                    await browser.key("w", "KeyW", "w")
                    await asyncio.sleep(0.03)
            picture = await browser.do("Page.captureScreenshot")
            await browser.do("Page.navigate", url="about:blank")
            assert browser.fetched
            assert all(url.startswith((f"http://{address}/", "data:", "about:", "blob:")) for url in browser.fetched)
            return picture["data"]

    with served(tmp_path, "--record", tmp_path / "run") as (address, _):
        picture = asyncio.run(look(address))
        whole(tmp_path / "run")
    assert len(picture) > 20_000, "there is something to be seen"
    if os.environ.get("WHEELBENCH_PICTURE"):
        import base64

        with open(os.environ["WHEELBENCH_PICTURE"], "wb") as file:
            file.write(base64.b64decode(picture))
