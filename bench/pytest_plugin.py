"""The pytest plugin: a bench in a fixture, goldens beside the test, scenario files as tests.

    def test_it_stops(bench, rc):
        rc.arm()
        rc.hold(forward=0.4).run(1.5)
        rc.transmitter.on = False
        bench.run(0.6)
        assert bench.plant.twist.vx_mps == 0.0

Fixtures: `bench` (a `bench.check.driven.Driven`), `rc` (the same, by the name of what a driver holds), `can_bus`,
`slamware_link`, `plant`, `golden`; `controller` is the base under test, and yours where you define a fixture of that
name. `@pytest.mark.wheelbench(robot=..., profile=...)` chooses the robot. A file `*.scenario.toml` is a test. What
fails shows the last wire lines and how to run it again. `--update-pinned` pins goldens anew; it is refused in CI.

Loaded with every pytest run where wheelbench is installed, so it imports nothing heavy before it is asked.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from bench.base import ControlledBase
    from bench.check.driven import Driven
    from bench.config import Robot
    from bench.messages import CanFrame
    from bench.plant import Plant

SCENARIO_ENDING = ".scenario.toml"
LAST_LINES = 50
MARKER = "wheelbench(robot='m2006', profile=None): the robot, and the transmitter's profile, of this test's bench"


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--update-pinned`."""
    parser.getgroup("wheelbench").addoption(
        "--update-pinned", action="store_true", help="make the runs of this session the goldens (refused in CI)"
    )


def pytest_configure(config: pytest.Config) -> None:
    """The marker; and no pinning where nobody looks."""
    config.addinivalue_line("markers", MARKER)
    if config.getoption("--update-pinned") and os.environ.get("CI"):
        raise pytest.UsageError("--update-pinned: a golden is not pinned in CI (the variable CI is set); pin at a desk")


@pytest.fixture
def controller() -> Callable[[Robot], ControlledBase]:
    """Makes the base under test out of a robot: the bench's own. Define a fixture of this name for yours."""
    from bench.base import Base

    return Base


@pytest.fixture
def bench(
    request: pytest.FixtureRequest, tmp_path: Path, controller: Callable[[Robot], ControlledBase]
) -> Iterator[Driven]:
    """A bench at rest, disarmed, recorded into the test's own folder."""
    from bench.check.driven import Driven
    from bench.config import load_robot
    from bench.errors import UsageError

    marker = request.node.get_closest_marker("wheelbench")
    chosen: dict[str, Any] = dict(marker.kwargs) if marker else {}
    unknown = sorted(set(chosen) - {"robot", "profile"})
    if unknown or (marker and marker.args):
        pytest.fail(f"the marker wheelbench takes robot= and profile=, not {', '.join(unknown) or marker.args}", False)
    try:
        robot = load_robot(chosen.get("robot", "m2006"), chosen.get("profile"))
    except UsageError as error:
        pytest.fail(str(error), pytrace=False)
    with Driven(robot, tmp_path / "run", controller) as driven:
        request.node.stash[_DRIVEN] = driven
        yield driven


@pytest.fixture
def rc(bench: Driven) -> Driven:
    """The bench, as its driver sees it: `arm`, `hold`, `run`, `transmitter`."""
    if bench.transmitter is None:
        pytest.fail(f"{bench.robot.name} takes no RC; use slamware_link, or give the marker a profile", pytrace=False)
    return bench


class CanBus:
    """What crossed the motors' bus until now."""

    def __init__(self, driven: Driven) -> None:
        self._driven = driven

    def frames(self, can_id: int | None = None) -> list[tuple[int, CanFrame]]:
        """(tick, (identifier, data)), commands and feedback; of one identifier, or all."""
        return self._driven.frames(can_id)

    def decoded(self, can_id: int) -> list[tuple[int, dict[str, int | str]]]:
        """(tick, fields) of every frame of an identifier, by the messages of the robot's motors."""
        from bench.motors import family

        messages = family(self._driven.robot)
        found = []
        for tick, (_, data) in self.frames(can_id):
            message = messages.message(can_id, len(data))
            found.append((tick, message.describe(data) if message else {}))
        return found


class SlamwareLink:
    """The control bus until now, and what the core asks for from now on."""

    def __init__(self, driven: Driven) -> None:
        self._driven = driven

    def ask(self, vx_mps: float = 0.0, vy_mps: float = 0.0, omega_radps: float = 0.0) -> None:
        """A velocity request, from now on."""
        self._driven.ask(vx_mps, vy_mps, omega_radps)

    @property
    def requests(self) -> list[tuple[int, bytes]]:
        """(tick, bytes) from the core."""
        return [(out.tick, out.core_to_base) for out in self._driven.outputs if out.core_to_base]

    @property
    def answers(self) -> list[tuple[int, bytes]]:
        """(tick, bytes) from the base."""
        return [(out.tick, out.base_to_core) for out in self._driven.outputs if out.base_to_core]


@pytest.fixture
def can_bus(bench: Driven) -> CanBus:
    """What crossed the motors' bus."""
    return CanBus(bench)


@pytest.fixture
def slamware_link(bench: Driven) -> SlamwareLink:
    """The control bus."""
    return SlamwareLink(bench)


@pytest.fixture
def plant(bench: Driven) -> Plant:
    """Where the robot really is."""
    return bench.plant


@pytest.fixture
def golden(request: pytest.FixtureRequest, bench: Driven) -> Callable[..., None]:
    """`golden()` ends the run and holds it against goldens/<test> beside the test's file; `golden("name")` another."""

    def check(name: str = "") -> None:
        bench.close()
        folder = request.path.parent / "goldens" / (name or _file_name(request.node.name))
        _hold_against(bench.directory, folder, request.config.getoption("--update-pinned"))

    return check


def _file_name(test: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in test)


def _hold_against(run: Path, folder: Path, update: bool) -> None:
    from bench.check.golden import pin, told
    from bench.check.reading import Recording
    from bench.errors import BenchError

    try:
        if update:
            before = pin(run, folder)
            print(f"pinned {folder}: " + (before.lines[0] if before else "new"))
            return
        if not folder.exists():
            pytest.fail(f"there is no golden {folder}; look at the run, then pin it: pytest --update-pinned", False)
        found = told(Recording.open(run), folder)
    except BenchError as error:
        pytest.fail(str(error), pytrace=False)
    if not found.ok:
        pytest.fail("\n".join(found.lines), pytrace=False)


_DRIVEN: pytest.StashKey[Driven] = pytest.StashKey()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A failed test shows what crossed the wires last, and how to run it again."""
    report = yield
    driven = item.stash.get(_DRIVEN, None)
    if report.when == "call" and report.failed and driven is not None:
        driven.close()
        report.sections.append(("wires", "\n".join(driven.last_lines(LAST_LINES))))
        report.sections.append(("again", f"wheelbench replay {driven.directory}"))
    return report


# --- scenario files ------------------------------------------------------------------------------------------------


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """A file `*.scenario.toml` is a test."""
    if file_path.name.endswith(SCENARIO_ENDING):
        return ScenarioFile.from_parent(parent, path=file_path)
    return None


class ScenarioFile(pytest.File):
    """A scenario file: one test."""

    def collect(self) -> Iterator[pytest.Item]:
        """The test."""
        yield ScenarioItem.from_parent(self, name=self.path.name.removesuffix(SCENARIO_ENDING))


class NotMet(Exception):
    """A scenario whose expectations are not met; the text is the report."""


class ScenarioItem(pytest.Item):
    """Runs a scenario; fails where an expectation is not met or a fault touched nothing."""

    def runtest(self) -> None:
        """Run it, recorded."""
        import tempfile

        from bench.check.driven import wire_lines
        from bench.check.reading import Recording, as_outputs
        from bench.check.run import from_scenario

        job = from_scenario(self.path)
        with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder:
            directory = Path(folder) / "run"
            with job.recorder(directory) as recorder:
                for out in job:
                    recorder.add(out)
                    if job.judge is not None:
                        job.judge.add(out)
            failed = [verdict.text for verdict in job.judge.verdicts() if not verdict.ok] if job.judge else []
            if job.injector is not None:
                failed += [f"{name}: this fault touched nothing" for name in job.injector.untouched()]
            if failed:
                last = wire_lines(list(as_outputs(Recording.open(directory)))[-LAST_LINES:], LAST_LINES)
                again = f"again: wheelbench replay {self.path} --record DIR"
                raise NotMet("\n".join([*failed, "", *last, "", again]))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> str:
        """What was not met; a wrong file in its own words."""
        from bench.errors import BenchError

        if isinstance(excinfo.value, NotMet | BenchError):
            return str(excinfo.value)
        return str(super().repr_failure(excinfo, style))

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Where it stands."""
        return self.path, None, f"scenario {self.name}"
