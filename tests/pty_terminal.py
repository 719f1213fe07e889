"""A terminal as a program sees it: a real pty, with the answers that a real one gives. Which ones, a test says."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

DEADLINE_S = 30.0
_QUERY = re.compile(rb"\x1b\[(\d+);(\d+)H\x1b\[6n|\x1b\[\?u|\x1b\[=(\d+);1u|\x1b\[>(\d+)u|\x1b\[<u")


class PtyTerminal:
    """`answers`: it tells where its cursor is. `kitty`: it knows that keyboard protocol, flags and all.

    The program runs in `home` and keeps its settings there: some keys write files.
    """

    def __init__(self, home, *command, answers=True, kitty=False, knows=27, size=(24, 80)):
        self.answers, self.kitty, self.knows = answers, kitty, knows
        self.flags = [0]
        self.output = b""
        self._seen = 0
        self.master, slave = pty.openpty()
        os.set_blocking(self.master, False)
        self._size(slave, *size)
        clean = {name: value for name, value in os.environ.items() if name not in ("TMUX", "STY", "COLUMNS", "LINES")}
        self.child = subprocess.Popen(
            [sys.executable, *map(str, command)], stdin=slave, stdout=slave, stderr=slave, cwd=home,
            start_new_session=True,
            env=clean | {"TERM": "xterm-256color", "HOME": str(home), "XDG_CONFIG_HOME": str(home)},
        )  # fmt: skip
        os.close(slave)

    @staticmethod
    def _size(descriptor, rows, columns):
        import fcntl
        import struct
        import termios

        fcntl.ioctl(descriptor, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def resize(self, rows, columns):
        """The window gets another size, and the program is told."""
        self._size(self.master, rows, columns)
        os.kill(self.child.pid, signal.SIGWINCH)  # no shell has made this its controlling terminal

    def type(self, data):
        end = time.monotonic() + DEADLINE_S
        while data:
            assert time.monotonic() < end, f"the program does not read\n{self.output[-2000:]!r}"
            assert self.child.poll() is None, f"the program has ended: {self.output[-3000:]!r}"
            if select.select([], [self.master], [], 0.05)[1]:
                data = data[os.write(self.master, data) :]

    def serve(self, seconds):
        """Be a terminal for so long: take what is written, answer what is asked."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if self.master is None or not select.select([self.master], [], [], left)[0]:
                continue
            try:
                data = os.read(self.master, 65536)
            except OSError:
                return
            self.output += data
            self._reply()

    def _reply(self):
        for match in _QUERY.finditer(self.output, self._seen):
            self._seen = match.end()
            row, column, set_to, pushed = match.groups()
            if row:
                if self.answers:
                    self.type(b"\x1b[%s;%sR" % (row, column))
            elif not self.kitty:
                continue
            elif set_to:
                self.flags[-1] = int(set_to) & self.knows
            elif pushed:
                self.flags.append(int(pushed) & self.knows)
            elif match.group() == b"\x1b[<u":
                self.flags[:] = self.flags[:-1] or [0]
            else:
                self.type(b"\x1b[?%du" % self.flags[-1])

    def wait_for(self, text, since=0):
        wanted, end = text.encode(), time.monotonic() + DEADLINE_S
        while wanted not in self.output[since:]:
            assert time.monotonic() < end, f"not within {DEADLINE_S:g} s: {text}\n{self.output[-2000:]!r}"
            assert self.child.poll() is None, f"the program has ended: {self.output[-3000:]!r}"
            self.serve(0.05)

    def wait_until(self, condition, what):
        end = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < end, f"not within {DEADLINE_S:g} s: {what}\n{self.output[-2000:]!r}"
            self.serve(0.02)

    def ended(self):
        """The exit status, once the program has ended by itself."""
        end = time.monotonic() + DEADLINE_S
        while self.child.poll() is None:
            assert time.monotonic() < end, f"the program does not end\n{self.output[-2000:]!r}"
            self.serve(0.05)
        self.serve(0.05)
        return self.child.returncode

    def vanish(self):
        """The window is closed."""
        os.close(self.master)
        self.master = None

    def close(self):
        if self.child.poll() is None:
            os.kill(self.child.pid, signal.SIGKILL)
            self.child.wait()
        if self.master is not None:
            os.close(self.master)


_SEQUENCE = re.compile(r"\x1b\[([?<>=]?)([\d;]*)([A-Za-z])|\x1b[78]|\x1b.|\r|\n|[^\x1b\r\n]", re.DOTALL)


def cells(output, rows, columns):
    """What a blank screen shows after that output: of each cell its character and its colours (ECMA-48: CUP, SGR)."""
    screen = [[(" ", "")] * columns for _ in range(rows)]
    x, y, colours, saved = 0, 0, "", (0, 0)
    for match in _SEQUENCE.finditer(output.decode("utf-8", "replace")):
        word, (private, numbers, final) = match.group(), match.groups()
        if final == "H" and not private:
            y, x = (int(number or 1) - 1 for number in (numbers or "1;1").split(";"))
        elif final == "m" and not private:
            colours = "" if numbers in ("", "0") else ";".join(filter(None, (colours, numbers)))
        elif final == "J":
            screen = [[(" ", "")] * columns for _ in range(rows)]
        elif word == "\x1b7":
            saved = x, y
        elif word == "\x1b8":
            x, y = saved
        elif word == "\r":
            x = 0
        elif word == "\n":
            y += 1
        elif not word.startswith("\x1b"):
            if x < columns and y < rows:  # the program may not know yet that its window has shrunk
                screen[y][x] = word, colours
            x += 1
    return screen
