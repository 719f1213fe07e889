"""A real terminal on a screen of its own: kitty under Xvfb, drawn by software, its keyboard pressed by xdotool."""

import os
import shutil
import subprocess
import sys
import time

DEADLINE_S = 90.0
NEEDS = ("kitty", "Xvfb", "xdotool")
MISSING = [name for name in NEEDS if shutil.which(name) is None]
_OPTIONS = (
    "allow_remote_control=yes", "confirm_os_window_close=0", "remember_window_size=no", "initial_window_width=100c",
    "initial_window_height=30c", "font_size=6", "update_check_interval=0", "shell_integration=disabled",
)  # fmt: skip


class KittyWindow:
    """One window with one program in it, which runs in `home`. Raises OSError where kitty cannot draw."""

    def __init__(self, home, *command):
        self._processes = []
        self._said = home / "said"
        try:
            self._start(home, command)
        except BaseException:
            self.close()
            raise

    def _start(self, home, command):
        ours, told = os.pipe()
        self._run(  # without -noreset it begins anew, and drops kitty, when the first xdotool goes
            ["Xvfb", "-displayfd", str(told), "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"],
            pass_fds=(told,),
        )
        os.close(told)
        with os.fdopen(ours) as answer:
            display = answer.readline().strip()
        assert display, "Xvfb has no display to give"
        others = ("TMUX", "STY", "COLUMNS", "LINES")
        self.environment = {name: value for name, value in os.environ.items() if name not in others} | {
            "DISPLAY": f":{display}", "LIBGL_ALWAYS_SOFTWARE": "1", "HOME": str(home), "XDG_CONFIG_HOME": str(home),
            "XDG_CACHE_HOME": str(home / "cache"), "XDG_RUNTIME_DIR": str(home), "KITTY_CONFIG_DIRECTORY": str(home),
            "LC_ALL": "C.UTF-8",
        }  # fmt: skip
        self._socket = f"unix:@wheelbench-{os.getpid()}-{display}"
        options = [word for option in _OPTIONS for word in ("-o", option)]
        words = ["kitty", "--config", "NONE", *options, "--listen-on", self._socket, sys.executable]
        kitty = self._run([*words, *map(str, command)], cwd=home, env=self.environment)
        self.window = self.wait_until(lambda: self._shown(kitty), "a window")
        self.do("mousemove", "1279", "799")  # a key goes to the window under the mouse where none has the focus
        self.do("windowfocus", "--sync", self.window)

    def _run(self, words, **options):
        with open(self._said, "ab") as said:
            process = subprocess.Popen(words, stdout=said, stderr=said, **options)
        self._processes.append(process)
        return process

    def _shown(self, kitty):
        if kitty.poll() is not None:
            said = self._said.read_text(errors="replace").strip()[-300:]
            raise OSError(f"kitty does not start (software OpenGL is libgl1-mesa-dri): {said}")
        return (self.do("search", "--onlyvisible", "--class", "kitty").split() or [""])[-1]

    def do(self, *words):
        """One command of xdotool, done; what it says."""
        return subprocess.run(["xdotool", *words], env=self.environment, capture_output=True, text=True).stdout

    @property
    def rows(self):
        """What stands on the screen; nothing where kitty does not tell."""
        asked = ["kitty", "@", "--to", self._socket, "get-text"]
        return subprocess.run(asked, env=self.environment, capture_output=True, text=True).stdout

    def wait_for(self, text):
        self.wait_until(lambda: text in self.rows, text)

    def wait_until(self, condition, what):
        end = time.monotonic() + DEADLINE_S
        while not (found := condition()):
            assert time.monotonic() < end, f"not within {DEADLINE_S:g} s: {what}\n{self.rows}"
            time.sleep(0.1)
        return found

    def close(self):
        for process in reversed(self._processes):
            process.terminate()  # killed, Xvfb would leave its lock behind
            try:
                process.wait(DEADLINE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
