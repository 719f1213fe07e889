"""A terminal as a program sees it: a real pty, with the answers that a real one gives. Which ones, a test says."""

import codecs
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

DEADLINE_S = 120.0
_QUERY = re.compile(rb"\x1b\[(\d+);(\d+)H\x1b\[6n|\x1b\[\?u|\x1b\[=(\d+);1u|\x1b\[>(\d+)u|\x1b\[<u")


class PtyTerminal:
    """`answers`: it tells where its cursor is. `kitty`: it knows that keyboard protocol, flags and all.

    The program runs in `home` and keeps its settings there: some keys write files.
    """

    def __init__(self, home, *command, answers=True, kitty=False, knows=27, size=(24, 80)):
        self.answers, self.kitty, self.knows = answers, kitty, knows
        self.flags = [0]
        self.output = b""
        self.screen = None
        """A `Screen` that is fed what comes, from when it is put here."""
        self.questions = 0
        """How often it was asked where its cursor is: once in a frame, before the frame's picture."""
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
        assert self._told(data), f"the program has ended: {self.output[-3000:]!r}"

    def _told(self, data):
        """Whether the program was there to be told."""
        end = time.monotonic() + DEADLINE_S
        while data:
            assert time.monotonic() < end, f"the program does not read\n{self.output[-2000:]!r}"
            if self.child.poll() is not None:
                return False
            if select.select([], [self.master], [], 0.05)[1]:
                data = data[os.write(self.master, data) :]
        return True

    def serve(self, seconds):
        """Be a terminal for so long: take what is written, answer what is asked. Whatever lies there is taken in any
        case, also where this process had no turn for so long.
        """
        end, left = time.monotonic() + seconds, seconds
        while left > 0:
            left = end - time.monotonic()
            open_end = [self.master] if self.master is not None else []
            if select.select(open_end, [], [], max(0.0, left))[0] and not self._take():
                return

    def _take(self):
        """What has been written by now, or a part of it; False where there is nothing, or nothing will come."""
        try:
            data = os.read(self.master, 65536) if self.master is not None else b""
        except OSError:
            data = b""
        self.output += data
        self._reply()
        if self.screen is not None:
            self.screen.feed(data)
        return bool(data)

    def _reply(self):
        """Answer what has been asked, unless the program has gone since: it asks with each of its last frames too."""
        for match in _QUERY.finditer(self.output, self._seen):
            self._seen = match.end()
            row, column, set_to, pushed = match.groups()
            if row:
                self.questions += 1
                if self.answers:
                    self._told(b"\x1b[%s;%sR" % (row, column))
            elif not self.kitty:
                continue
            elif set_to:
                self.flags[-1] = int(set_to) & self.knows
            elif pushed:
                self.flags.append(int(pushed) & self.knows)
            elif match.group() == b"\x1b[<u":
                self.flags[:] = self.flags[:-1] or [0]
            else:
                self._told(b"\x1b[?%du" % self.flags[-1])

    def wait_to_show(self, what, shows):
        """Until `screen` shows it."""
        end = time.monotonic() + DEADLINE_S
        while not shows(self.screen):
            assert time.monotonic() < end, "\n".join([f"not within {DEADLINE_S:g} s: {what}", *self.screen.lines])
            self.serve(0.05)

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
        while self._take():  # its last words, one read may bring only a part of
            pass
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
_BEGUN = re.compile(r"\x1b(\[[?<>=]?[\d;]*)?$")


class Screen:
    """A screen that was blank: of each cell its character and its colours (ECMA-48: CUP, SGR). `feed` draws on it."""

    def __init__(self, rows, columns):
        self.rows, self.columns = rows, columns
        self._decode = codecs.getincrementaldecoder("utf-8")("replace").decode
        self._rest = ""
        self._x, self._y, self._colours, self._saved = 0, 0, "", (0, 0)
        self._clear()

    def _clear(self):
        self.cells = [[(" ", "")] * self.columns for _ in range(self.rows)]

    @property
    def lines(self):
        """What can be read on it."""
        return ["".join(sign for sign, _ in row) for row in self.cells]

    def feed(self, output):
        """Some more output, cut anywhere."""
        text = self._rest + self._decode(output)
        begun = _BEGUN.search(text)
        self._rest = begun.group() if begun else ""
        for match in _SEQUENCE.finditer(text, 0, len(text) - len(self._rest)):
            self._draw(match.group(), *match.groups())

    def _draw(self, word, private, numbers, final):
        if final == "H" and not private:
            self._y, self._x = (int(number or 1) - 1 for number in (numbers or "1;1").split(";"))
        elif final == "m" and not private:
            self._colours = "" if numbers in ("", "0") else ";".join(filter(None, (self._colours, numbers)))
        elif final == "J":
            self._clear()
        elif word == "\x1b7":
            self._saved = self._x, self._y
        elif word == "\x1b8":
            self._x, self._y = self._saved
        elif word == "\r":
            self._x = 0
        elif word == "\n":
            self._y += 1
        elif not word.startswith("\x1b"):
            if self._x < self.columns and self._y < self.rows:  # it may not know yet that its window has shrunk
                self.cells[self._y][self._x] = word, self._colours
            self._x += 1


def cells(output, rows, columns):
    """What a blank screen shows after that output."""
    screen = Screen(rows, columns)
    screen.feed(output)
    return screen.cells
