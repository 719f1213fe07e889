"""A terminal that speaks Kitty's protocol and is not ours: what is held, let go, out of focus and closed there.

Nothing here is a matter of milliseconds of the wall: what the session is told is written down with its tick, and the
recording says what the stick did at that tick. Where this machine pauses for longer than a key is worth without a sign
of the terminal, the key rests before its release, as it must, and is pressed again.
"""

import json
import re
import time

import pytest
from kitty_window import DEADLINE_S, MISSING, KittyWindow

from bench.check.reading import Recording

pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)} (apt-get install kitty)")

DRIVE = """
import json, sys
from bench.screen.session import Session
log = open(sys.argv[1], "w", buffering=1)
def told(name):
    method = getattr(Session, name)
    def also(self, *words):
        method(self, *words)
        log.write(json.dumps([self.link.now_tick, name, *words]) + "\\n")
    setattr(Session, name, also)
for name in ("key", "let_go", "hands_off"):
    told(name)
from bench.__main__ import main
sys.exit(main(["drive", "--record", sys.argv[2]]))
"""
FORWARD, LEFT = slice(5, 7), slice(7, 9)
"""Of uart12's frame: channels 2 and 3, which rest at 2048."""
TRIES = 20
HELD_S = 0.3
"""Below the 660 ms after which X repeats a key: it lives by what the terminal answers."""


class Drive:
    """A drive in a real window: what its session was told, and what was sent by radio."""

    def __init__(self, place):
        self.run, self.log = place / "run", place / "told"
        self.window = KittyWindow(place, "-c", DRIVE, self.log, self.run)

    @property
    def told(self):
        return [tuple(json.loads(line)) for line in self.log.read_text().splitlines()]

    def stick(self, channel):
        """(tick, whether it is pushed) of every frame that is on disk."""
        found = re.findall(r"\((\d+)\.(\d{3})\d*\) \S+ > (.*)", (self.run / "rc.log").read_text())
        return [(int(s + ms), int("".join(data.split()[channel]), 16) != 2048) for s, ms, data in found]

    def around(self, channel, tick):
        """Whether the stick is pushed in the last frame before a tick, and in the first one from then on."""
        frames = self.window.wait_until(
            lambda: (stick := self.stick(channel)) and stick[-1][0] >= tick and stick, f"tick {tick} on disk"
        )
        return [pushed for at, pushed in frames if at < tick][-1], next(pushed for at, pushed in frames if at >= tick)

    def do(self, *words):
        self.window.do(*words)

    def until_told(self, what, since):
        """The tick at which the session was told so."""
        return self.window.wait_until(
            lambda: [(tick,) for tick, *told in self.told[since:] if tuple(told) == what], f"{what} in {self.told}"
        )[0][0]


@pytest.fixture
def drive(tmp_path):
    """Armed, in a terminal that has said in time that it tells releases."""
    for number in range(5):
        place = tmp_path / str(number)
        place.mkdir()
        try:
            one = Drive(place)
        except OSError as error:
            pytest.skip(str(error))
        try:
            one.window.wait_for("not armed since boot")
            one.do("key", "f")
            one.do("key", "Return")
            one.window.wait_for(" ARMED ")
            one.do("key", "f")
            one.window.wait_until(lambda one=one: [told for _, *told in one.told].count(["key", "f"]) == 2, "F twice")
            if ["let_go", "f"] in [told for _, *told in one.told]:
                yield one
                return
        finally:
            one.window.close()
    raise AssertionError("kitty was never heard to tell a release")


def test_zero_follows_the_release_and_the_robot_stops_where_nobody_can_hold_a_key(drive):
    for act in (hold, hold_two, look_away):
        assert any(act(drive) for _ in range(TRIES)), f"never held up to its end: {act.__name__}"
    close_while_held(drive)


def hold(drive):
    """The stick is pushed up to the release, and at rest in the next frame."""
    since = len(drive.told)
    drive.do("keydown", "w")
    time.sleep(HELD_S)
    drive.do("keyup", "w")
    released = drive.until_told(("let_go", "w"), since)
    before, after = drive.around(FORWARD, released)
    assert not after
    return before


def hold_two(drive):
    """Each stick follows its own key; the one that is still held stays."""
    since = len(drive.told)
    for word, key in (("keydown", "w"), ("keydown", "d"), ("keyup", "w"), ("keyup", "d")):
        drive.do(word, key)
        time.sleep(HELD_S)
    last = drive.until_told(("let_go", "d"), since)
    first = drive.until_told(("let_go", "w"), since)
    heard = [what for _, *what in drive.told[since:] if what[0] == "let_go"]
    assert heard == [["let_go", "w"], ["let_go", "d"]]
    (forward, then), (left, still) = drive.around(FORWARD, first), drive.around(LEFT, first)
    later, rests = drive.around(LEFT, last)
    assert not then
    assert not rests
    return forward and left and still and later


def look_away(drive):
    """Another window has the keyboard: the stick rests, though the key is still down."""
    window = drive.window
    root = window.do("search", "--maxdepth", "0", "").split()[0]
    drive.do("keydown", "w")
    time.sleep(HELD_S)
    since = len(drive.told)
    drive.do("windowfocus", root)
    drive.until_told(("hands_off",), since)
    time.sleep(2 * HELD_S)  # X repeats the key meanwhile, to nobody
    drive.do("keyup", "w")
    drive.do("windowfocus", "--sync", window.window)
    drive.do("key", "z")
    again = drive.until_told(("key", "z"), since)
    # What a terminal tells comes in its order: the last before Z is that of the focus, or a later one.
    gone = [tick for tick, what, *_ in drive.told if what == "hands_off" and tick <= again][-1]
    before, _ = drive.around(FORWARD, gone)
    drive.around(FORWARD, again)
    assert not any(pushed for at, pushed in drive.stick(FORWARD) if gone <= at < again)
    return before


def close_while_held(drive):
    """The robot stands and is disarmed, and the recording is whole."""
    since = len(drive.told)
    drive.do("keydown", "w")
    drive.until_told(("key", "w"), since)
    drive.do("windowclose", drive.window.window)
    end = time.monotonic() + DEADLINE_S
    while not Recording.open(drive.run).complete:
        assert time.monotonic() < end, f"it drives on: {drive.told[-3:]}"
        time.sleep(0.1)
    recording = Recording.open(drive.run)
    assert recording.commands[recording.ticks - 1] == ((0x200, bytes(8)),)
    assert recording.state[max(recording.state)][recording.state_columns.index("armed")] == 0
    assert not drive.stick(FORWARD)[-1][1]
