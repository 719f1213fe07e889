"""Whole screens as text, at three sizes and a few at small ones, against fixtures/pinned/screens: to the cell.

After a deliberate change: `pytest tests/test_screens.py --update-pinned`, then look at the difference.
"""

from pathlib import Path

import pytest
from desk import AGREE, LAMPS, LOST_LINK, M2006, SCENE, scene

from bench.screen.dialog import Dialog, Item
from bench.screen.fault_list import known_faults
from bench.screen.scene import Hands, Menu, Pace, Replay, Shown
from bench.screen.view import picture

FOLDER = Path(__file__).parents[1] / "fixtures" / "pinned" / "screens"
SIZES = ((80, 24), (120, 40), (200, 60))
SMALL_SIZES = ((60, 16), (40, 12), (20, 5))
SMALL = ("driving", "link-lost", "replay", "wires", "list")

VERDICT = "differs: 0x200 current 1 -599 not -600 mA at 1.234 s"
SUMMARY = (
    f"golden    {VERDICT}",
    "drove     5.64 m and turned 812 deg in 12.3 s; stands at x +1.250 m, y -0.500 m, +45.0 deg",
)
NOTICE = "recording ended: m2006-001/can.log: cannot be written (No space left on device); free some; driving goes on"
LIST = Dialog("inject a fault", [Item(words, "", str) for words, _ in known_faults(M2006)], "for 2 s (← →)")
for _ in range(12):
    LIST.key("down")
SCREENS = {
    "driving": scene(),
    "link-lost": scene(**LOST_LINK, hands=Hands(100, False, True), notice="transmitter off", recording="my_run"),
    "followed": scene(zoom=True),
    "gamepad": scene(hands=Hands(50, True, False, source="gamepad", source_state="it is not there; plug it in")),
    "mouse": scene(hands=Hands(50, True, False, pad=(0.25, -0.5, 0.0), curve="expo 0.30, dead-band 5 %")),
    "replay": scene(hands=None, replay=Replay("demo", 20_000, VERDICT)),
    "ended": scene(hands=None, replay=Replay("demo", 12_346, VERDICT, SUMMARY)),
    "keys": scene(help=True),
    "wires": scene(shown=Shown("wires")),
    "wires-filtered": scene(shown=Shown("wires", "20", False, Menu("filter", "20"))),
    "wires-held": scene(shown=Shown("wires", "", True)),
    "scope": scene(shown=Shown("scope")),
    "scope-signals": scene(
        shown=Shown("scope", menu=Menu("signal", "wheel1", ("wheel1_radps", "wheel1_current_a"), 1))
    ),
    "scope-trigger": scene(shown=Shown("scope", menu=Menu("trigger", "", ("auto", "rising", "5", "500 ms"), 2))),
    "back": scene(pace=Pace(paused=True, behind_ticks=2300), recording="m2006-002"),
    "list": scene(dialog=LIST.shown),
    "long-notice": scene(notice=NOTICE, pace=Pace(paused=True)),
    "checks": scene(
        shown=Shown("checks"),
        hands=None,
        lamps=LAMPS,
        agree=AGREE,
        replay=Replay("stops", 20_000, "identical so far"),
    ),
    "checks-driving": scene(shown=Shown("checks"), agree=AGREE[1:]),
    "scrubbed": scene(
        shown=Shown("wires"), seen=SCENE.seen._replace(building=0.4), pace=Pace(paused=True, behind_ticks=2300)
    ),
}


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize("name", SCREENS)
def test_a_screen_is_as_pinned(name, width, height, request):
    hold(name, SCREENS[name], width, height, request)


@pytest.mark.parametrize(("width", "height"), SMALL_SIZES)
@pytest.mark.parametrize("name", SMALL)
def test_a_small_screen_is_as_pinned(name, width, height, request):
    hold(name, SCREENS[name], width, height, request)


def test_every_pinned_screen_is_looked_at():
    known = {f"{name}-{width}x{height}.txt" for name in SCREENS for width, height in SIZES}
    known |= {f"{name}-{width}x{height}.txt" for name in SMALL for width, height in SMALL_SIZES}
    assert {path.name for path in FOLDER.iterdir()} == known


def hold(name, what, width, height, request):
    file = FOLDER / f"{name}-{width}x{height}.txt"
    text = "\n".join(picture(what, width, height)) + "\n"
    if request.config.getoption("--update-pinned"):
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    assert text.splitlines() == file.read_text(encoding="utf-8").splitlines()
