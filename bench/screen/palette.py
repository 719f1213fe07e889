"""Every action of the dashboard with its key, for the command palette and the page of keys."""

from __future__ import annotations

from typing import NamedTuple


class Action(NamedTuple):
    """What it does, the key as it is printed, and as `Session.key` takes it. `driving`: not while a run is shown."""

    words: str
    printed: str
    key: str
    driving: bool = False


ACTIONS = (
    Action("stop: sticks to rest, disarm", "Space", "space", True),
    Action("arm, disarm (AUX1)", "Enter", "enter", True),
    Action("field-centric driving on, off (AUX2)", "F", "f", True),
    Action("transmitter off, on", "T", "t", True),
    Action("let the core ask for an arc, or not", "C", "c", True),
    Action("push the sticks further", "+", "+", True),
    Action("push the sticks less far", "-", "-", True),
    Action("sticks for the mouse, or not", "M", "m", True),
    Action("next source of the sticks: keys, gamepad, receiver", "I", "i", True),
    Action("pause, go on", "P", "p"),
    Action("one tick on", ".", "."),
    Action("one tick back", ",", ","),
    Action("to the first instant", "Home", "home"),
    Action("to the newest instant", "End", "end"),
    Action("drive on from the instant shown (fork)", "G", "g"),
    Action("slower: slow motion", "[", "["),
    Action("faster", "]", "]"),
    Action("start or stop recording", "R", "r"),
    Action("inject a fault", "X", "x", True),
    Action("choose another robot, arena or scenario", "O", "o"),
    Action("save the run up to here as a golden test", "B", "b"),
    Action("follow the robot with the map, or not", "Z", "z"),
    Action("the page to drive by", "1", "1"),
    Action("the page of the wires", "2", "2"),
    Action("the page of the scope", "3", "3"),
    Action("the page of the checks", "4", "4"),
    Action("hold the page still, or let it go", "H", "h"),
    Action("filter the wires' frames", "/", "/"),
    Action("choose the scope's signals", "V", "v"),
    Action("set the scope's trigger and time", "N", "n"),
    Action("all keys", "?", "?"),
    Action("quit", "Ctrl-Q", "ctrl+q"),
)
WORK_KEYS = (
    ("← → , .", "paused: 0.1 s, a tick"),
    ("↑ ↓", "paused: a second back, on"),
    ("Home End", "first, newest instant"),
    ("G", "drive on from there"),
    ("R", "record, or end that"),
    ("X", "inject a fault"),
    ("O", "another robot, scenario"),
    ("B", "save as a golden test"),
    (": Ctrl-P", "find any action"),
)
"""For the page of keys."""
HINT = "First time? Enter arms, hold W to drive, Space stops. ? has all keys, : finds any action."
