"""What happens between a person and a bench: keys in, ticks when they are due, a scene out. No Textual, no clock.

A session drives by a keyboard or shows a run. It ends by a key, or by a failure; either way `over` is set, and the
recording is closed. Leaving a drive stops the robot first: its recording ends with a base that has disarmed.
"""

from __future__ import annotations

from collections.abc import Callable

from bench.arena import FIELD
from bench.check.recording import Recorder
from bench.check.run import Run
from bench.check.summary import Summary
from bench.io.link import InlineLink
from bench.io.process.link import ProcessLink
from bench.screen.keyboard import Keyboard
from bench.screen.lamp import GoldenLamp
from bench.screen.motion import MOTION
from bench.screen.mouse_sticks import Pad
from bench.screen.scene import Pace, Replay, Scene
from bench.screen.settings import SettingsFile
from bench.screen.sight import sight_of
from bench.screen.stage import Stage
from bench.screen.tape import Tape
from bench.screen.wire_lamps import WireLamps
from bench.screen.working import Working

NOTICE_FRAMES = 50
ABANDONED_MS = 1000
"""A terminal that has not answered for so long has nobody at it: the robot is disarmed, not only let go."""
RATES = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
REST_TICKS = 1500
"""Leaving a drive, the bench runs on until its base has disarmed, at most so long: a lost link takes half a second."""
REST_STEP_TICKS = 10
SWITCHES = ("space", "enter", "f", "t", "c", "m", "i")


class Session:
    """One bench and one person. `keyboard` drives it; without one the run `job` is shown as it is.

    `over` says that it has ended; `failure` is what ended it, if that was no key.
    """

    def __init__(
        self,
        link: InlineLink | ProcessLink,
        *,
        keyboard: Keyboard | None = None,
        job: Run | None = None,
        lamp: GoldenLamp | None = None,
        summary: Summary | None = None,
        agree: WireLamps | None = None,
        recording: str = "",
        tape: Tape | None = None,
        settings: SettingsFile | None = None,
    ) -> None:
        self.link = link
        self.keyboard = keyboard
        self.over = False
        self.failure: Exception | None = None
        self.unmet = False
        """Whether an expectation of the run that was shown has not been met."""
        self.job = job
        self._lamp = lamp
        self._summary = summary
        self._agree = agree
        self._recording = recording
        self.sight = sight_of(link.bench.robot, link.bench.state_columns)
        self._help = False
        self._zoom = False
        self._notice = ""
        self._notice_frames = 0
        self._result: tuple[str, ...] = ()
        self.working = Working(self, settings, tape)

    @property
    def stands(self) -> bool:
        """Whether time stands still: paused, or a run that has ended."""
        return self.link.paused or bool(self._result)

    # --- what comes in -------------------------------------------------------------------------------------------

    def frame(self) -> None:
        """A screen's frame has begun: look at the devices, run what is due."""
        if self.working.leaving:
            self.leave()
            return
        if self.keyboard is not None and not self.over:
            self.say(self.keyboard.look(self.link.now_tick, self.link.latest().armed, self.link.paused))
        self._advance()
        if self._agree is not None:
            self.say(self._agree.news())
        self.working.frame()
        if self._notice_frames:
            self._notice_frames -= 1
        else:
            self._notice = ""

    def key(self, key: str) -> None:
        """A press or a repeat: a lower-case letter, a sign, or one of the names space, enter, escape, up, down, ..."""
        if self.over or self.working.key(key):
            return
        if key != "space" and (said := self.sight.key(key)) is not None:
            if self.sight.typing:
                self.hands_off()  # letters are text now, and drive nothing
            self.say(said)
            return
        if key in MOTION or key in SWITCHES:
            self._drive(key)
        elif key in ("+", "-"):
            self.say(self.keyboard.change_power(1 if key == "+" else -1) if self.keyboard else REPLAY_NOTICE)
        elif key in ("[", "]"):
            self._change_rate(-1 if key == "[" else 1)
        elif key == "p":
            self.pause()
        elif key == "z":
            self._zoom = not self._zoom
        elif key == "?":
            self._help = not self._help
        elif key == "escape" and self._help:
            self._help = False
        elif key in ("escape", "ctrl+q", "ctrl+c"):
            self.leave()

    def let_go(self, key: str) -> None:
        """The terminal says that a key is no longer held."""
        if self.keyboard is not None and not self.over:
            self._advance()
            self.keyboard.sticks.let_go(key)

    def point(self, pressed: bool, x: int, y: int, pad: Pad) -> None:
        """The mouse is on that cell of the pad's panel: its button has just gone down there, or it has moved."""
        if self.keyboard is None or self.over or not self.keyboard.mouse.on or self.link.paused:
            return
        self._advance()
        self.say(self.keyboard.point(pressed, x, y, pad, self.link.now_tick, self.link.latest().armed))

    def drop(self) -> None:
        """The mouse has let go, or has left the window."""
        if self.keyboard is not None and not self.over:
            self._advance()
            self.keyboard.mouse.release()

    def too_late(self, age_ms: int) -> None:
        """A key that moves something has come, but it may have been pressed so long ago."""
        self.say(f"key not heard: {age_ms} ms late")

    def alive(self) -> None:
        """The terminal has proved that it is there, and that whoever holds a key still holds it."""
        if self.keyboard is not None and not self.over:
            self._advance()
            self.keyboard.alive(self.link.now_tick)

    def silence(self, age_ms: int) -> None:
        """The terminal used to answer and has not for so long: nobody knows what the hands do."""
        keyboard = self.keyboard
        if keyboard is None or self.over:
            return
        self.hands_off()
        if not self._notice:
            self.say("the terminal does not answer: sticks at rest, only Space is heard")
        if age_ms > ABANDONED_MS:
            self.link.see(self.link.newest_tick)
            keyboard.abandon(self.link.now_tick, self.link.latest().armed)

    def hands_off(self) -> None:
        """Nobody is at the keys: another window has them, or the program was asleep."""
        if self.keyboard is not None:
            self.keyboard.release()

    def asleep(self) -> None:
        """The program is about to be stopped, or goes on: what passes between is no delay of ours."""
        self.hands_off()
        self.link.pacer.restart()

    def leave(self, patience: bool = True) -> None:
        """Stop the robot, close the recording, end. One that is still behind is written on, a frame at a time, where
        there is patience for that.
        """
        if self.over:
            return
        try:
            if not self.working.leaving:
                self.come_to_rest()
            if not self.working.leave(patience):
                return
            self.link.close()
        except Exception as error:
            self.failure = error
        self.over = True

    def come_to_rest(self) -> None:
        """Stop the robot, and let time pass until it is disarmed; all of it where nobody knows that."""
        keyboard, link = self.keyboard, self.link
        if keyboard is None:
            return
        link.see(link.newest_tick)
        keyboard.stop(link.now_tick, link.latest().armed)
        for _ in range(REST_TICKS // REST_STEP_TICKS):
            link.run(REST_STEP_TICKS)
            if link.latest().armed is False:
                return

    def step(self) -> None:
        """One tick, whatever the time."""
        self._run(lambda: self.link.run(1))

    def restage(self, stage: Stage | None, keyboard: Keyboard | None) -> None:
        """Work on another run from now on, or on the same with hands at it."""
        if keyboard is not None and self.keyboard is not None:
            keyboard.set_like(self.keyboard)
        self.keyboard = keyboard
        self._result = ()
        self._recording = ""
        self._lamp = self._summary = self._agree = None
        self.unmet = False
        if stage is None:
            return
        if stage.link is not self.link:
            bench, size = stage.link.bench, self.sight.size
            self.sight = sight_of(bench.robot, bench.state_columns)
            self.sight.size = size
        self.link, self.job, self._lamp, self._summary = stage.link, stage.job, stage.lamp, stage.summary
        self._agree = stage.agree

    # --- what goes out -------------------------------------------------------------------------------------------

    def scene(self) -> Scene:
        """What is to be shown now."""
        link, pacer, keyboard = self.link, self.link.pacer, self.keyboard
        plant = link.bench.world.plant
        behind = link.newest_tick - link.now_tick
        dialog = self.working.dialog
        hands = replay = None
        if keyboard is not None:
            hands = keyboard.hands(link.now_tick)
        elif self.job is not None:
            verdict = self._lamp.text if self._lamp is not None else ""
            replay = Replay(self.job.title, self.job.ticks, verdict, () if link.looks_back else self._result)
        return Scene(
            robot=link.bench.robot,
            snapshot=link.latest(),
            wires=link.wires,
            trail=link.trail,
            slips=link.slips,
            shown=self.sight.shown,
            seen=self.sight.see(link.look(self.sight.look)),
            lamps=self.job.judge.standings() if self.job is not None and self.job.judge is not None else (),
            agree=self._agree.lamps if self._agree is not None else (),
            agree_since_tick=self._agree.since_tick if self._agree is not None else 0,
            pace=Pace(
                pacer.rate,
                pacer.speed,
                pacer.late_ticks,
                pacer.slipped_ticks,
                link.paused,
                behind,
                isinstance(link, InlineLink),
                self.working.goes_back,
            ),
            arena=plant.arena or FIELD,
            discs=plant.discs,
            hands=hands,
            replay=replay,
            recording=self.working.recording or self._recording,
            saving=self.working.saving,
            notice=self._notice or "; ".join(link.missing) or self.working.hint,
            dialog=dialog.shown if dialog is not None else None,
            help=self._help,
            zoom=self._zoom,
        )

    # --- within --------------------------------------------------------------------------------------------------

    def _drive(self, key: str) -> None:
        keyboard, link = self.keyboard, self.link
        if keyboard is None:
            self.say(REPLAY_NOTICE)
            return
        if key == "space":
            link.see(link.newest_tick)  # the robot is there, whatever instant is shown
        if link.paused and key != "space":
            self.say("paused: P goes on")
        else:
            self._advance()  # the key belongs to the tick in which it was pressed, not to the last frame's
            self.say(keyboard.press(key, link.now_tick, link.latest().armed))

    def pause(self) -> None:
        """Stand still, or go on."""
        if self._result:
            self.say("the run has ended; ← → go back in it, Esc quits")
            return
        if self.keyboard is not None:
            self.keyboard.let_go()
        self._notice = ""  # the foot is for the keys of time now
        self.link.pause(not self.link.paused)

    def _change_rate(self, step: int) -> None:
        pacer = self.link.pacer
        nearest = min(range(len(RATES)), key=lambda i: abs(RATES[i] - pacer.rate))
        pacer.set_rate(RATES[max(0, min(len(RATES) - 1, nearest + step))])
        self.say(f"time runs ×{pacer.rate:g}")

    def say(self, notice: str) -> None:
        """A sentence for the person, for a while."""
        if notice:
            self._notice, self._notice_frames = notice, max(NOTICE_FRAMES, len(notice))  # what is longer takes longer

    def _advance(self) -> None:
        link = self.link
        if self.over or self._result:
            return
        slipped = link.pacer.slipped_ticks
        try:
            due = link.due()
        except Exception as error:  # what ended a run in another process
            self._fail(error)
            return
        if self.keyboard is not None:
            self.keyboard.set_time(link.pacer.rate, link.lead_ticks)
        if link.pacer.slipped_ticks != slipped:
            self.hands_off()  # away for longer than a burst: no key is held any more
        self._run(lambda: link.run(due))

    def _run(self, some: Callable[[], object]) -> None:
        """Let ticks run."""
        if self.over or self._result:
            return
        try:
            some()
            for notice in self.link.take_notices():
                self.say(notice)
            if self.link.ended:
                self._end()
        except Exception as error:
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        """It ends; whoever started the screen raises it again, once the terminal is back."""
        self.failure = error
        self.over = True

    def _end(self) -> None:
        """The run that is shown has come to its last tick."""
        self.link.close()
        lines: list[str] = []
        if self._lamp is not None:
            self._lamp.finish(self.link.now_tick)
            lines.append(f"golden    {self._lamp.text}")
        if self.job is not None and self.job.judge is not None:
            verdicts = self.job.judge.verdicts()
            self.unmet = not all(one.ok for one in verdicts)
            lines += [f"{'expect' if one.ok else 'EXPECT':10}{one.text}" for one in verdicts]
        if self._summary is not None and self.job is not None:
            lines += self._summary.lines(self.job)
        self._result = tuple(lines) or ("no more ticks",)


REPLAY_NOTICE = "a replay: no key drives it; P, then ← → go through it"


def session_of(
    stage: Stage, recorder: Recorder | None = None, settings: SettingsFile | None = None, recording: str = ""
) -> Session:
    """A session at a stage, with the settings that are kept. What records elsewhere says so in `recording`."""
    tape = Tape(recorder) if recorder is not None else None
    keyboard = stage.keyboard
    if settings is not None and keyboard is not None:
        keyboard.sticks.power_percent = settings.values.power_percent
        stage.link.pacer.set_rate(settings.values.rate)
    return Session(
        stage.link,
        keyboard=keyboard,
        job=stage.job,
        lamp=stage.lamp,
        summary=stage.summary,
        agree=stage.agree,
        recording=recording,
        tape=tape,
        settings=settings,
    )
