"""Saves a run as a golden and a test that holds every later version of the bench against it.

goldens/m2006-001/          the recording, pinned: `wheelbench replay` runs it again and compares
test_m2006_001.py           the same, for pytest
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from bench.check.golden import pin
from bench.check.recording import RecordingError, make_directory, write_file
from bench.check.run import Run
from bench.io.history import History
from bench.io.link import InlineLink
from bench.screen.tape import Tape, next_directory

GOLDENS = "goldens"
_TEST = '''"""{about}

Saved from the dashboard. Replays the inputs of {golden} and compares every frame and every row.
"""

from pathlib import Path

from bench.__main__ import main

GOLDEN = Path(__file__).parent / "{folder}" / "{name}"


def test_{function}_is_as_it_was():
    assert main(["replay", str(GOLDEN)]) == 0, f"see what differs: wheelbench replay {{GOLDEN}}"
'''


class GoldenTest:
    """One golden in the making. `work` until it says a sentence. Raises RecordingError, OSError or LostInstant."""

    def __init__(self, folder: Path, job: Run, history: History, faults: Sequence[str], seed: int, ticks: int) -> None:
        robot = job.bench.robot.name
        history.start()  # what cannot be run again is refused before anything is made
        make_directory(folder / GOLDENS)
        self.directory = next_directory(folder / GOLDENS, robot)
        self.told: list[str] = []
        """What is worth telling once the screen is gone."""
        self._folder, self._ticks = folder, ticks
        self._about = f"{job.title}: {ticks / 1000:.3f} s"
        self._scratch = Path(tempfile.mkdtemp(prefix="wheelbench-"))
        self._tape = Tape(job.recorder(self._scratch / "run"), history, faults, seed, by_hand=True)
        self._tape.stop(ticks)

    def work(self, link: InlineLink, ticks: int) -> str:
        """Go on by so many ticks; at the end the sentence about it."""
        self._tape.work(link, ticks)
        if not self._tape.ended:
            return ""
        if self._tape.failure is not None:
            return self.give_up(f"no golden: {self._tape.failure}")
        try:
            pin(self._scratch / "run", self.directory)
            name = self.directory.name.replace("-", "_")
            test = self._folder / f"test_{name}.py"
            text = _TEST.format(
                about=self._about,
                golden=f"{GOLDENS}/{self.directory.name}",
                folder=GOLDENS,
                name=self.directory.name,
                function="".join(letter if letter.isalnum() else "_" for letter in name),
            )
            write_file(test, text.encode())
        except RecordingError as error:
            return self.give_up(f"no golden: {error}")
        self.told = [f"golden    {self.directory}", f"test      pytest {test}"]
        return self.give_up(f"saved: pytest {test}, or wheelbench replay {self.directory}")

    def give_up(self, said: str = "") -> str:
        """Leave nothing behind but what is finished."""
        self._tape.close()
        shutil.rmtree(self._scratch, ignore_errors=True)
        return said
