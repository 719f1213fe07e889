"""Saves a run as a golden and a test that holds every later version of the bench against it.

goldens/m2006-001/          the recording, pinned: `wheelbench replay` runs it again and compares
test_m2006_001.py           the same, for pytest

Running it again and writing it takes as long as it takes: it is done in a process of its own. Either both are there in
the end, whole, or neither is.
"""

from __future__ import annotations

import errno
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from bench.check.golden import pin
from bench.check.recording import make_directory, write_file
from bench.check.run import Run
from bench.io.errand import Errand, Tell
from bench.io.history import LostInstant
from bench.io.link import InlineLink
from bench.screen.tape import Tape, next_directory

GOLDENS = "goldens"
PART_TICKS = 500
"""So much is run again between two words about it."""
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
    """One golden in the making, in a process of its own. `look` until it says a sentence.

    Raises RecordingError, OSError or LostInstant.
    """

    def __init__(self, folder: Path, job: Run, link: InlineLink, faults: Sequence[str], seed: int) -> None:
        history, ticks = link.history, link.now_tick
        if history is None:
            raise LostInstant("this run cannot be taken back")
        history.start()  # what cannot be run again is refused before anything is made
        make_directory(folder / GOLDENS)
        self.name = next_directory(folder / GOLDENS, job.bench.robot.name).name
        """As it will be called, unless somebody else takes that name first."""
        self.told: list[str] = []
        """What is worth telling once the screen is gone."""
        self._scratch = Path(tempfile.mkdtemp(prefix=".saving-", dir=folder))

        def work(tell: Tell) -> list[str]:
            try:
                tape = Tape(job.recorder(self._scratch / "run"), history, faults, seed, by_hand=True)
                tape.stop(ticks)
                while not tape.ended:
                    tape.work(link, PART_TICKS)
                    tell(tape.share)
                if tape.failure is not None:
                    raise tape.failure
                return _save(self._scratch, folder, job, ticks)
            finally:  # whoever started this may be gone
                shutil.rmtree(self._scratch, ignore_errors=True)

        self._errand = Errand(work)

    @property
    def progress(self) -> str:
        """How far it is."""
        return f"{100 * self._errand.share:.0f} %"

    def look(self) -> str:
        """How it is going: nothing, or at the end the sentence about it."""
        self._errand.look()
        if not self._errand.is_over:
            return ""
        shutil.rmtree(self._scratch, ignore_errors=True)
        if self._errand.said is None:
            return f"no golden: {self._errand.failed}"
        golden, test = self._errand.said
        self.told = [f"golden    {golden}", f"test      pytest {test}"]
        return f"saved: pytest {test}, or wheelbench replay {golden}"

    def give_up(self) -> None:
        """Leave nothing behind."""
        self._errand.give_up()
        shutil.rmtree(self._scratch, ignore_errors=True)


def _save(scratch: Path, folder: Path, job: Run, ticks: int) -> list[str]:
    """Pin it under a name that nobody looks at, and rename it when it is whole; then the test. Both paths."""
    pin(scratch / "run", scratch / "golden")
    while True:
        directory = next_directory(folder / GOLDENS, job.bench.robot.name)
        try:
            (scratch / "golden").rename(directory)
            break
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
    name = directory.name.replace("-", "_")
    text = _TEST.format(
        about=f"{job.title}: {ticks / 1000:.3f} s",
        golden=f"{GOLDENS}/{directory.name}",
        folder=GOLDENS,
        name=directory.name,
        function="".join(letter if letter.isalnum() else "_" for letter in name),
    )
    write_file(scratch / "test.py", text.encode())
    return [str(directory), str((scratch / "test.py").replace(folder / f"test_{name}.py"))]
