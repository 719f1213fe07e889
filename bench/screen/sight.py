"""What the person looks at: the page, a filter, the scope's settings, what is held still. Keys in, a `Look` out.

    Tab, 1..4    pages                      h    hold what moves on this page, or let it go
    /            filter the wires' frames   v, n the scope's signals, its trigger

While a filter or a signal's name is typed, letters are text and drive nothing; Space is never asked here.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from bench.config import Robot
from bench.io.look import Look, Seen
from bench.io.scope import EDGES, MODES, MOST_TRACES, SPANS_MS, ScopeSettings, scope_signals
from bench.screen.layout import DRIVE, PAGES, SCOPE, WIRES, panes
from bench.screen.scene import Menu, Shown

FILTER, SIGNAL, TRIGGER = "filter", "signal", "trigger"
TRIGGER_ROWS = ("mode", "edge", "level", "time")
MODE, EDGE, LEVEL, TIME = range(len(TRIGGER_ROWS))
LONGEST_TEXT = 40
LEVEL_STEPS = 20
"""Of the height of the picture."""
_NUMBER = set("0123456789.-+e")


class Sight:
    """`signals` are the names that the scope may show. `size` is the screen's, in cells; whoever draws sets it."""

    def __init__(self, signals: tuple[str, ...], first: tuple[str, ...]) -> None:
        self.size = (80, 24)
        self._signals = signals
        self._page = DRIVE
        self._filter = ""
        self._scope = ScopeSettings(first)
        self._open = ""
        self._text = ""
        self._row = 0
        self._trace = 0
        self._held: dict[str, Seen] = {}
        self._hold = False
        self._seen = Seen()

    @property
    def typing(self) -> bool:
        """Whether letters are text now."""
        return self._open in (FILTER, SIGNAL)

    @property
    def has_menu(self) -> bool:
        """Whether something is being typed or chosen, so that arrows and letters are for that."""
        return bool(self._open)

    @property
    def look(self) -> Look:
        """What has to be sampled for the page."""
        wanted = panes(self._page, *self.size)
        scope = self._scope if "scope" in wanted else None
        log = self.size[1] if "wiretable" in wanted else 0
        return Look(wanted != {"scope"}, self._filter, log, scope, 2 * self.size[0])

    def see(self, seen: Seen) -> Seen:
        """What to show of what was sampled: the same as before where it is held."""
        if self._page in self._held:
            return self._held[self._page]
        if seen.building is not None:  # what was shown stays until all of the other instant is there
            return self._seen._replace(building=seen.building)
        self._seen = seen
        return seen

    @property
    def shown(self) -> Shown:
        """What the panels show of all this."""
        return Shown(self._page, self._filter, self._page in self._held, self._menu(), self._scope)

    def key(self, key: str) -> str | None:
        """A key's effect: a sentence for the person, or nothing; None where the key means nothing here."""
        if self._open == FILTER:
            return self._type_filter(key)
        if self._open == SIGNAL:
            return self._choose_signal(key)
        if self._open == TRIGGER and (done := self._set_trigger(key)) is not None:
            return done
        if key in ("tab", "shift+tab"):
            step = 1 if key == "tab" else -1
            return self._turn_to(PAGES[(PAGES.index(self._page) + step) % len(PAGES)])
        if key.isdecimal() and key != "0":
            number = int(key) - 1
            return self._turn_to(PAGES[number]) if number < len(PAGES) else f"there are {len(PAGES)} pages"
        if key == "h":
            return self._hold_or_let_go()
        if key in _OPENS:
            self._open, page = _OPENS[key]
            self._text, self._row = (self._filter if key == "/" else ""), 0
            return self._turn_to(page, keep_open=True)
        return None

    # --- pages ---------------------------------------------------------------------------------------------------

    def _turn_to(self, page: str, *, keep_open: bool = False) -> str:
        self._page = page
        if not keep_open:
            self._open = ""
        return ""

    def _hold_or_let_go(self) -> str:
        if not {"wiretable", "scope"} & panes(self._page, *self.size):
            return f"nothing to hold here: {PAGES.index(WIRES) + 1} wires, {PAGES.index(SCOPE) + 1} scope"
        if self._page in self._held:
            del self._held[self._page]
            return "the page goes on"
        self._held[self._page] = self._seen
        return "held: H lets go; the bench goes on"

    # --- the filter ----------------------------------------------------------------------------------------------

    def _type_filter(self, key: str) -> str | None:
        if key in ("enter", "tab"):
            self._open = ""
        elif key == "escape":
            self._open = self._filter = ""
        elif (text := _edited(self._filter, key)) is not None:
            self._filter = text
        else:
            return None
        return ""

    # --- the scope -----------------------------------------------------------------------------------------------

    def _matching(self) -> tuple[str, ...]:
        return tuple(name for name in self._signals if self._text in name)

    def _choose_signal(self, key: str) -> str | None:
        names, now = self._matching(), self._scope.signals
        if key in ("up", "down"):
            self._row = max(0, min(len(names) - 1, self._row + (1 if key == "down" else -1)))
        elif key == "tab":
            self._trace = (self._trace + 1) % min(MOST_TRACES, len(now) + 1)
        elif key == "escape":
            self._open, self._trace = "", 0
        elif key == "enter":
            return self._take(names)
        elif key == "backspace" and not self._text:
            return self._drop()
        elif (text := _edited(self._text, key)) is not None:
            self._text, self._row = text, 0
        else:
            return None
        return ""

    def _take(self, names: tuple[str, ...]) -> str:
        if not names:
            return f"no signal has {self._text!r} in its name"
        chosen, now = names[min(self._row, len(names) - 1)], list(self._scope.signals)
        if chosen in now:
            return f"{chosen} is there already"
        now[self._trace : self._trace + 1] = [chosen]
        self._scope = self._scope._replace(signals=tuple(now))
        self._open, self._trace = "", 0
        return ""

    def _drop(self) -> str:
        now = list(self._scope.signals)
        if len(now) == 1 or self._trace >= len(now):
            return "one signal has to stay"
        gone = now.pop(self._trace)
        self._scope = self._scope._replace(signals=tuple(now))
        self._trace = 0
        return f"{gone} is gone"

    def _set_trigger(self, key: str) -> str | None:
        scope = self._scope
        if key in ("up", "down"):
            self._row = max(0, min(len(TRIGGER_ROWS) - 1, self._row + (1 if key == "down" else -1)))
            self._text = ""
        elif key in ("left", "right"):
            self._scope = self._stepped(scope, 1 if key == "right" else -1)
            self._text = ""
        elif key in ("enter", "n", "escape"):
            self._open = ""
            if key == "enter":
                self._scope = scope._replace(shot=scope.shot + 1)
        elif self._row == LEVEL and (key == "backspace" or key in _NUMBER):
            self._text = _edited(self._text, key) or ""
            with suppress(ValueError):  # not a number yet
                self._scope = scope._replace(level=float(self._text))
        else:
            return None
        return ""

    def _stepped(self, scope: ScopeSettings, step: int) -> ScopeSettings:
        if self._row == MODE:
            return scope._replace(mode=MODES[(MODES.index(scope.mode) + step) % len(MODES)], shot=scope.shot + 1)
        if self._row == EDGE:
            return scope._replace(edge=EDGES[(EDGES.index(scope.edge) + step) % len(EDGES)])
        if self._row == TIME:
            place = max(0, min(len(SPANS_MS) - 1, SPANS_MS.index(scope.span_ms) + step))
            return scope._replace(span_ms=SPANS_MS[place])
        low, high = _range(self._seen)
        return scope._replace(level=round(scope.level + step * (high - low) / LEVEL_STEPS, 9))

    def _menu(self) -> Menu | None:
        if self._open == FILTER:
            return Menu(FILTER, self._filter)
        if self._open == SIGNAL:
            return Menu(SIGNAL, self._text, self._matching(), self._row, self._trace)
        if self._open == TRIGGER:
            scope = self._scope
            level = self._text or f"{scope.level:g}"
            return Menu(TRIGGER, "", (scope.mode, scope.edge, level, f"{scope.span_ms} ms"), self._row)
        return None


def sight_of(robot: Robot, state_columns: Sequence[str]) -> Sight:
    """The sight of a run: at first the scope shows what the first wheel wants and does."""
    return Sight(scope_signals(robot, state_columns), ("wheel1_wanted_radps", "wheel1_radps"))


_OPENS = {"/": (FILTER, WIRES), "v": (SIGNAL, SCOPE), "n": (TRIGGER, SCOPE)}


def _edited(text: str, key: str) -> str | None:
    """The text after a key; None where the key is none of writing."""
    if key == "backspace":
        return text[:-1]
    return text + key if len(key) == 1 and len(text) < LONGEST_TEXT else None


def _range(seen: Seen) -> tuple[float, float]:
    """Between what the first trace moves, at least a little."""
    picture = seen.scope
    low = [value for value in picture.traces[0].low if value == value] if picture is not None else []
    high = [value for value in picture.traces[0].high if value == value] if picture is not None else []
    least, most = (min(low), max(high)) if low else (0.0, 0.0)
    return (least, most) if most > least else (least, least + 1.0)
