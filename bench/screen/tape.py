"""Recordings that are started and stopped from the screen. Each holds its run from tick 0, whenever it was started.

What has passed before a start is run again from the inputs that the history holds, a slice a frame; the recording is
`behind` until it has caught up. Then the bench that has written it takes the driven one's place: every line of a
recording comes from one bench that ran from tick 0, as its replay will.

A disk that refuses ends the recording with a sentence, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from bench.check.recording import Recorder, RecordingError
from bench.io.history import History, Subject
from bench.io.link import InlineLink
from bench.messages import TickOutput

SLICE_TICKS = 300
"""So much of the past is run again in a frame: some 10 ms beside a driven bench."""


class Tape:
    """One recording of a run: a link's taker. `failure` is what ended it, if that was not a person.

    `history` is given where the run has begun before: its ticks are run again first. `faults` are the `[[fault]]`
    tables that it had until now, with the seed of their chances. `by_hand`: its replay judges nothing but whether it
    repeats.
    """

    def __init__(
        self,
        recorder: Recorder,
        history: History | None = None,
        faults: Sequence[str] = (),
        seed: int = 0,
        by_hand: bool = False,
    ) -> None:
        self.failure: RecordingError | None = None
        self.ended = False
        self._recorder = recorder
        self._history = history
        self._behind: Subject | None = history.start() if history is not None else None
        if self._behind is not None:
            recorder.log_bus_of(self._behind.bench.world.timing)
        self._seed = seed
        self._until: int | None = None
        self._told: list[str] = []
        if by_hand:
            self._try(lambda: recorder.begin_by_hand(seed))
        for text in faults:
            self.add_fault(text)

    @property
    def directory(self) -> Path:
        """Where it is written."""
        return self._recorder.directory

    @property
    def is_behind(self) -> bool:
        """Whether what has passed is still being run again."""
        return self._behind is not None

    @property
    def share(self) -> float:
        """How much of what is to be in it was written, where it has an end."""
        done = self._behind.bench.now_tick if self._behind is not None else self._until or 0
        return done / max(1, self._until or done)

    def progress(self, newest_tick: int) -> str:
        """A name, and how far it is where it is behind."""
        name = self.directory.name
        if self._behind is None:
            return name
        done = self._behind.bench.now_tick
        return f"{name} {100 * done // max(1, self._until or newest_tick)} %"

    def add(self, out: TickOutput) -> None:
        """One tick of the run."""
        if self._behind is None and self._until is None:
            self._try(lambda: self._recorder.add(out))

    def add_fault(self, text: str) -> None:
        """A fault joins the run."""
        self._try(lambda: self._recorder.add_fault(text, self._seed))

    def witness(self, lines: Sequence[str]) -> None:
        """What faults have touched in the ticks that were added."""
        if lines and self._behind is None:
            self._try(lambda: self._recorder.witness(lines))

    def work(self, link: InlineLink, ticks: int = SLICE_TICKS) -> None:
        """Catch up by so many ticks. Having caught up with the link's own run, its bench becomes the link's."""
        history, subject = self._history, self._behind
        if self.ended or history is None or subject is None:
            return
        goal = self._until if self._until is not None else link.newest_tick
        now = subject.bench.now_tick
        outs = history.go_on(subject, min(now + ticks, goal))
        self._try(lambda: self._recorder.extend(outs))
        touches = [touch.text for touch in subject.take_touches()]
        if touches:
            self._try(lambda: self._recorder.witness(touches))
        if subject.bench.now_tick >= goal:
            self._behind = None
            if self._until is not None:
                self.close()
            elif history is link.history:
                link.take_touches()  # these were witnessed by the bench that has written them
                link.adopt(subject)

    def stop(self, newest_tick: int) -> None:
        """The recording ends with the newest tick: now, or as soon as it has caught up."""
        self._until = newest_tick
        if self._behind is None:
            self.close()

    def close(self) -> None:
        """End the recording with what it holds, whether that is all or not."""
        if not self.ended:
            self.ended = True
            self._behind = None
            self._try(self._recorder.close)

    def _try(self, write: Callable[[], object]) -> None:
        if self.failure is not None:
            return
        try:
            write()
        except RecordingError as error:
            self.failure = error
            self._recorder.abandon()
            self.ended = True
            self._behind = None


def next_directory(folder: Path, robot: str, taken: Sequence[Path] = ()) -> Path:
    """The first free name for a recording: robot and count."""
    number = 1
    while (path := folder / f"{robot}-{number:03d}").exists() or path in taken:
        number += 1
    return path
