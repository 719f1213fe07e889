"""Working with a run: going back in it, driving on from any instant, recordings, faults, another robot, goldens.

The keys that are ours, and the lists that some of them open. Everything that can go wrong here (no room on the disk, an
instant that is no longer held, a file that is none) is a sentence on the screen, and driving goes on.

A fork starts with hands off: sticks at rest, no switch pressed, the core told to stand, and time standing still.
Whether the robot is armed is part of the instant and stays so: it brakes if it was driving, and Space disarms it before
P lets time go on.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from bench.arena import FIELD
from bench.check.crosswire import CrossWire
from bench.check.recording import RecordingError
from bench.check.run import Run
from bench.errors import BenchError
from bench.io.history import CoreJoins
from bench.io.link import InlineLink, LostInstant
from bench.screen.choosing import choices
from bench.screen.dialog import Dialog, Item
from bench.screen.fault_list import SECONDS, Values, fault_at, known_faults, table_text
from bench.screen.golden_test import GoldenTest
from bench.screen.keyboard import Keyboard
from bench.screen.palette import ACTIONS, HINT
from bench.screen.settings import SettingsFile
from bench.screen.stage import Stage
from bench.screen.tape import SLICE_TICKS, Tape, next_directory
from bench.screen.wire_lamps import LEAD_TICKS, WireLamps
from bench.world import RecordedMotors, noise_of

if TYPE_CHECKING:
    from bench.screen.session import Session

STEP_TICKS, STRIDE_TICKS = 100, 1000
IDLE_SLICE_TICKS = 5 * SLICE_TICKS
"""While nothing else runs, what has passed is run again so much at a time: some 50 ms."""
BACK = {
    ",": -1, ".": 1, "left": -STEP_TICKS, "right": STEP_TICKS, "up": -STRIDE_TICKS, "down": STRIDE_TICKS,
    "pageup": -STRIDE_TICKS, "pagedown": STRIDE_TICKS,
}  # fmt: skip


class Working:
    """The part of a session that goes beyond driving. `key` takes the keys that are ours."""

    def __init__(self, session: Session, settings: SettingsFile | None, tape: Tape | None) -> None:
        self._session = session
        self._settings = settings
        self.dialog: Dialog | None = None
        self.tape = tape
        self.told: list[str] = []
        """What is worth telling once the screen is gone."""
        self.leaving = False
        """Everything is at rest; what is not yet written is being written."""
        self._must_record = tape is not None
        self._finishing: list[Tape] = []
        self._golden: GoldenTest | None = None
        self._faults: list[tuple[int, str]] = []
        self._seed = 0
        self._seconds = SECONDS.index(2.0)
        self.hint = ""
        self._keys: dict[str, Callable[[], str]] = {
            "g": self._fork, "r": self._record, "x": self._choose_fault, "o": self._choose_run, "b": self._save_golden,
            ":": self._open_palette, "ctrl+p": self._open_palette,
        }  # fmt: skip
        if tape is not None:
            session.link.takers.append(tape)
        if settings is not None:
            self.hint = settings.why
            if not self.hint and not settings.values.hints_seen and session.keyboard is not None:
                self.hint = HINT
                settings.change(hints_seen=1)
                settings.save()  # what cannot be remembered is shown again

    # --- what comes in -------------------------------------------------------------------------------------------

    def key(self, key: str) -> bool:
        """Take a key; whether it was ours."""
        session = self._session
        self.hint = ""
        if key == "space":
            return False
        if self.leaving:
            if key in ("escape", "ctrl+q", "ctrl+c"):
                self._abandon()
            return True
        if self.dialog is not None and key in ("ctrl+q", "ctrl+c"):
            self.dialog = None
            return False
        if self.dialog is not None:
            session.say(self.dialog.key(key))
            if self.dialog is not None and not self.dialog.open:
                self.dialog = None
            return True
        if session.sight.has_menu:
            return False
        if key in (",", ".", "home", "end") or (key in BACK and session.stands):
            session.say(self._go(key))
        elif key in self._keys:
            session.say(self._keys[key]())
        else:
            return False
        return True

    def frame(self) -> None:
        """A frame has begun and its ticks have run: witness faults, catch up with what is being written."""
        session = self._session
        link, tape = session.link, self.tape
        touches = link.take_touches()
        if tape is not None:
            tape.witness([touch.text for touch in touches])
        ticks = IDLE_SLICE_TICKS if session.stands or self.leaving else SLICE_TICKS
        busy = next((one for one in (*self._finishing, tape) if one is not None and one.is_behind), None)
        if busy is not None and isinstance(link, InlineLink):  # only simulated time can be run again
            busy.work(link, ticks)
        self._finishing = [one for one in self._finishing if not self._is_done(one)]
        if tape is not None and tape.failure is not None:
            session.say(f"recording ended: {tape.failure}; driving goes on")
            link.takers = [taker for taker in link.takers if taker is not tape]
            if self._must_record:
                session.failure = tape.failure  # told by the exit status too, once the person leaves
            self.tape = None
        golden = self._golden
        if golden is not None and (said := golden.look()):
            self._golden = None
            session.say(said)
            self.told += golden.told

    def leave(self, patience: bool) -> bool:
        """The session ends: end the recording. Whether all is written; without patience it is when this returns."""
        session = self._session
        if not self.leaving:
            self.leaving = True
            self.dialog = None
            self._end_tape()
            self._save_settings()
        if not patience:
            self._give_up_golden()
        while self._finishing or self._golden is not None:
            self.frame()
            if patience:
                break
        left = [one.progress(session.link.newest_tick) for one in self._finishing]
        if left:
            session.say(f"writing {left[0]}; Esc ends it there")
        elif self._golden is not None:
            session.say(f"saving the golden {self._golden.name}, {self._golden.progress}; Esc gives it up")
        return not left and self._golden is None

    @property
    def recording(self) -> str:
        """Of the recording that is being written: its name, and how far it is where it is behind."""
        if self.tape is not None:
            return self.tape.progress(self._session.link.newest_tick)
        return self._finishing[0].progress(0) if self._finishing else ""

    @property
    def saving(self) -> str:
        """Of the golden that is being saved: how far it is."""
        return self._golden.progress if self._golden is not None else ""

    # --- time ----------------------------------------------------------------------------------------------------

    @property
    def goes_back(self) -> bool:
        """Whether an earlier instant can be shown."""
        history = self._session.link.history
        return history is not None and not history.why_blind

    def _go(self, key: str) -> str:
        """To another instant of the run. Running, it stands still first."""
        session = self._session
        link = session.link
        if key != "." and not self.goes_back:
            why = link.history.why_blind if link.history is not None else "this run cannot be taken back in time"
            return f"{why}: P stands still and goes on" + ", . steps on" * isinstance(link, InlineLink)
        if not session.stands:
            session.pause()
            if key == ".":
                return ""
        now, newest = link.now_tick, link.newest_tick
        goal = {"home": 0, "end": newest}.get(key, now + BACK.get(key, 0))
        try:
            if key == "." and now == newest:
                session.step()
                return ""
            if key == "home" and link.history is not None:
                goal = link.history.first
            link.see(goal)
        except LostInstant as lost:
            return str(lost)
        if goal < 0:
            return "the run begins here"
        return "this is the newest instant" if goal >= newest and key in BACK else ""

    def _fork(self) -> str:
        """Drive on from the instant that is shown."""
        session = self._session
        link = session.link
        if not isinstance(link, InlineLink) or link.history is None:
            return "this run cannot be taken back in time, so there is nothing to drive on from"
        if link.history.why_blind:
            return f"{link.history.why_blind}, so there is nothing to drive on from"
        if not session.stands:
            return "P stands still, ← → , . go back; then G drives on from there"
        if session.keyboard is not None and not link.looks_back:
            return "this is the newest instant: P goes on from here"
        if isinstance(link.bench.world.motors, RecordedMotors):
            return "its motors are a recording's; open it without --can recorded to drive on"
        recorded = self.tape is not None
        self._end_tape()
        keyboard = session.keyboard
        if keyboard is None:
            keyboard = self._take_the_sticks()
        keyboard.start_over()
        link.fork(keyboard.inputs)
        link.takers, link.witness = [], None
        if link.bench.world.core is None:
            link.join(CoreJoins())
        link.take_touches()
        self._faults = [(tick, text) for tick, text in self._faults if tick < link.now_tick]
        if session.job is not None:
            agree = _judge_from_here(link)
            link.takers, link.witness = [agree], agree.touched
            session.restage(Stage(link, _by_hand(session.job), keyboard, agree=agree), keyboard)
        else:
            session.restage(None, keyboard)
        said = self._record() if recorded else ""
        armed = (
            "armed, as it was" + ": Space disarms" * (keyboard.transmitter is not None)
            if link.latest().armed
            else "disarmed"
        )
        return f"forked at {link.now_tick / 1000:.3f} s, sticks at rest, {armed}; P goes on" + (
            f"; {said}" if "cannot" in said else ""
        )

    def _take_the_sticks(self) -> Keyboard:
        """A replay becomes a drive: a keyboard, and a core in the place of the recorded one's bytes."""
        session = self._session
        if session.job is not None:
            texts, self._seed = _faults_of(session.job)
            self._faults = [(-1, text) for text in texts]
        return Keyboard(session.link.bench.robot.rc)

    # --- recordings ----------------------------------------------------------------------------------------------

    @property
    def folder(self) -> Path:
        """Where recordings and goldens go."""
        return Path(self._settings.values.record_dir if self._settings is not None else "")

    def _record(self) -> str:
        session = self._session
        link, job = session.link, session.job
        if self.tape is not None:
            directory = self.tape.directory
            self._end_tape()
            return f"recorded {directory}" if not self._finishing else f"{directory} is being written out"
        if job is None or link.history is None:
            return "this run is recorded only from its start: --record DIR"
        directory = next_directory(self.folder, link.bench.robot.name)
        try:
            tape = self._new_tape(job, directory)
        except (LostInstant, BenchError) as error:
            return f"not recording: {error}"
        self.tape = tape
        link.takers.append(tape)
        return f"recording {directory}" + (", from its first tick on" if link.newest_tick else "")

    def _new_tape(self, job: Run, directory: Path) -> Tape:
        link = self._session.link
        history = link.history if link.newest_tick else None
        if history is not None and history.why_blind:
            raise LostInstant(f"{history.why_blind}; record it from its start: --record DIR")
        if link.newest_tick and (history is None or history.first):
            raise LostInstant("the beginning of this run is no longer held")
        return Tape(job.recorder(directory), history, [text for _, text in self._faults], self._seed)

    def _end_tape(self) -> None:
        tape, link = self.tape, self._session.link
        if tape is None:
            return
        link.takers = [taker for taker in link.takers if taker is not tape]
        tape.witness([touch.text for touch in link.take_touches()])
        tape.stop(link.newest_tick)
        self.tape = None
        self.told.append(f"recorded  {tape.directory}")
        if not self._is_done(tape):
            self._finishing.append(tape)

    def _is_done(self, tape: Tape) -> bool:
        if tape.ended and tape.failure is not None:
            self._session.say(f"recording ended: {tape.failure}")
            self._session.failure = self._session.failure or tape.failure
        return tape.ended

    def _abandon(self) -> None:
        """Nobody wants to wait: what is written is a whole recording of a shorter run."""
        for tape in self._finishing:
            tape.close()
        self._give_up_golden()

    def _give_up_golden(self) -> None:
        if self._golden is not None:
            self._golden.give_up()
            self.told.append(f"no golden: left at {self._golden.progress} of {self._golden.name}")
            self._golden = None

    # --- faults --------------------------------------------------------------------------------------------------

    def _choose_fault(self) -> str:
        session = self._session
        link = session.link
        if session.keyboard is None:
            return "a replay is as it was: P, G drive on from here, and then X"
        if link.looks_back:
            return "an earlier instant is as it was: G drives on from here, and then X"
        session.hands_off()

        def item(words: str, values: Values) -> Item:
            return Item(words, "", lambda: self._inject(values))

        items = [item(words, values) for words, values in known_faults(link.bench.robot)]
        self.dialog = Dialog("inject a fault", items, self._how_long(0), self._how_long)
        return ""

    def _how_long(self, step: int) -> str:
        self._seconds = max(0, min(len(SECONDS) - 1, self._seconds + step))
        return f"for {SECONDS[self._seconds]:g} s (← →) · Esc leaves · Enter injects · type to narrow"

    def _inject(self, values: Values) -> str:
        link, seconds = self._session.link, SECONDS[self._seconds]
        number = len(self._faults) + 1
        try:
            fault, text = fault_at(link.bench, values, number, seconds)
            link.join(fault)
        except (ValueError, BenchError) as error:
            return str(error)
        self._faults.append((link.newest_tick, text))
        if self.tape is not None:
            self.tape.add_fault(text)
        return f"fault: {fault.wire} {fault.kind} for {seconds:g} s"

    # --- another run ---------------------------------------------------------------------------------------------

    def _choose_run(self) -> str:
        session = self._session
        session.hands_off()
        arena = session.link.bench.world.plant.arena or FIELD

        def item(words: str, note: str, build: Callable[[], Stage], robot: str) -> Item:
            return Item(words, note, lambda: self._restart(build, robot))

        found = choices(session.link.bench.robot, arena, session.link.pacer)
        self.dialog = Dialog("choose a robot, an arena or a scenario", [item(*one) for one in found])
        return ""

    def _restart(self, build: Callable[[], Stage], robot: str) -> str:
        session = self._session
        try:
            stage = build()
        except (BenchError, ValueError) as error:
            return str(error)
        session.come_to_rest()
        self._end_tape()
        session.link.close()
        self._faults, self._seed = [], 0
        session.restage(stage, stage.keyboard)
        session.link.pause(False)
        if self._settings is not None and robot:
            self._settings.change(robot=robot, profile="")
        return f"{stage.job.title}: at its start"

    # --- goldens -------------------------------------------------------------------------------------------------

    def _save_golden(self) -> str:
        session = self._session
        link, job = session.link, session.job
        if not session.stands:
            return "P stands still first: the golden holds the run up to the instant that is shown"
        if self._golden is not None:
            return f"busy: the golden {self._golden.name} is being saved, {self._golden.progress}"
        if job is None or not isinstance(link, InlineLink) or link.history is None or link.now_tick == 0:
            return "there is nothing to save yet"
        try:
            texts, seed = _faults_of(job) if job.scenario is not None else ([], self._seed)
            faults = texts + [text for tick, text in self._faults if tick < link.now_tick]
            self._golden = GoldenTest(self.folder, _by_hand(job), link, faults, seed)
        except (LostInstant, RecordingError, OSError) as error:
            return f"no golden: {error}"
        return f"saving the golden {self._golden.name}; go on meanwhile"

    # --- finding one's way ---------------------------------------------------------------------------------------

    def _open_palette(self) -> str:
        session = self._session
        session.hands_off()

        def press(key: str) -> Callable[[], str]:
            def act() -> str:
                self.dialog = None
                session.key(key)
                return ""

            return act

        driving = session.keyboard is not None
        actions = [action for action in ACTIONS if driving or not action.driving]
        items = [Item(action.words, action.printed, press(action.key)) for action in actions]
        self.dialog = Dialog("every action", items)
        return ""

    def _save_settings(self) -> None:
        settings, session = self._settings, self._session
        if settings is None:
            return
        settings.change(rate=session.link.pacer.rate)
        if session.keyboard is not None:
            settings.change(power_percent=session.keyboard.sticks.power_percent)
        said = settings.save()
        if said:
            self.told.append(said)


def _judge_from_here(link: InlineLink) -> WireLamps:
    """The checks of the wires for what comes: what they have seen of the run is no more."""
    bench, now = link.bench, link.now_tick
    lead = link.between(max(0, now - LEAD_TICKS), now)
    checks = CrossWire(bench.robot, bench.state_columns, noise=noise_of(bench.world.motors))
    return WireLamps(checks, now, lead)


def _by_hand(job: Run) -> Run:
    """The same run as one that a person goes on with: its scenario has no say in it any more."""
    info = replace(job.info, scenario=None)
    return replace(job, info=info, source=None, judge=None, injector=None, checks=None, scenario=None)


def _faults_of(job: Run) -> tuple[list[str], int]:
    """The `[[fault]]` tables of a run's scenario, and the seed of their chances."""
    tables = tomllib.loads(job.scenario.decode()) if job.scenario is not None else {}
    return [table_text(table) for table in tables.get("fault", ())], int(tables.get("seed", 0))
