"""The pytest plugin: a bench in a fixture, goldens beside the test, scenario files as tests.

    def test_it_stops(bench, rc):
        rc.arm()
        rc.hold(forward=0.4).run(1.5)
        rc.transmitter.on = False
        bench.run(0.6)
        assert bench.plant.twist.vx_mps == 0.0

Fixtures: `bench` (a `bench.check.driven.Driven`), `rc` (the same, by the name of what a driver holds), `can_bus`,
`slamware_link`, `plant`, `golden`; `controller` is the base under test, and yours where you define a fixture of that
name. `@pytest.mark.wheelbench(robot=..., profile=..., arena=...)` chooses the robot and where it is. A file
`*.scenario.toml` is a test. What fails shows the last wire lines and how to run it again. `--update-pinned` pins
goldens anew; it is refused in CI.

Loaded with every pytest run where wheelbench is installed, so it imports nothing heavy before it is asked.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
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
MARKER_KEYS = ("robot", "profile", "arena")
MARKER = (
    "wheelbench(robot='m2006', profile=None, arena=None): the robot, the transmitter's profile and the arena file "
    "(beside the test's file) of this test's bench"
)


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
    from bench.arena import FIELD, load_arena
    from bench.check.driven import Driven
    from bench.config import load_robot
    from bench.errors import UsageError

    marker = request.node.get_closest_marker("wheelbench")
    chosen = {key: value for key, value in marker.kwargs.items() if value is not None} if marker else {}
    unknown = sorted(set(chosen) - set(MARKER_KEYS))
    if unknown or (marker and marker.args):
        takes = ", ".join(f"{key}=" for key in MARKER_KEYS)
        pytest.fail(f"the marker wheelbench takes {takes}; not {', '.join(unknown) or marker.args}", False)
    for key, value in chosen.items():
        if not isinstance(value, str | Path):
            pytest.fail(f"the marker wheelbench: {key} is a name or a file, not {value!r}", pytrace=False)
    try:
        robot = load_robot(chosen.get("robot", "m2006"), chosen.get("profile"))
        arena = load_arena(request.path.parent / chosen["arena"]) if "arena" in chosen else FIELD
        bench = Driven(robot, tmp_path / "run", controller, arena)
    except UsageError as error:
        raise pytest.fail.Exception(str(error), pytrace=False) from None
    with bench as driven:
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
    """`golden()` ends the run and holds it against goldens/<test> beside the test's file; `golden("name")` another.
    `tolerance={"speed": "5 rpm"}` grants what the platform does not.
    """

    def check(name: str = "", *, tolerance: Mapping[str, str] | None = None) -> None:
        bench.close()
        node = request.node
        folder = _golden_folder(node, name)
        twice = node.config.stash[_SAME_GOLDEN].get(folder, []) if not name else []
        if twice:
            pytest.fail(f"{' and '.join(twice)} share the golden {folder.name}; give one a name: golden('...')", False)
        granted = [f"{field}={size}" for field, size in (tolerance or {}).items()]
        told = _hold_against(bench.directory, folder, node.config.getoption("--update-pinned"), granted)
        if told:
            node.user_properties.append((_PINNED, told))

    return check


def _golden_folder(node: pytest.Item, name: str = "") -> Path:
    return node.path.parent / "goldens" / (name or _file_name(node.name))


def _file_name(test: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in test)


def _hold_against(run: Path, folder: Path, update: bool, tolerance: Sequence[str]) -> str:
    """Fail the test where the run is not as its golden. Returns what was pinned and what that changes, if asked for."""
    from bench.check.golden import pin, told
    from bench.check.reading import Recording
    from bench.errors import BenchError

    try:
        if update:
            before = pin(run, folder)
            return f"pinned {_shown(folder)}: " + ("\n  ".join(before.lines) if before else "new")
        if not folder.exists():
            where = _shown(folder)
            pytest.fail(f"there is no golden {where}; look at the run, then pin it: pytest --update-pinned", False)
        found = told(Recording.open(run), folder, tolerance)
    except BenchError as error:
        raise pytest.fail.Exception(str(error), pytrace=False) from None
    if not found.ok:
        pytest.fail("\n".join(found.lines), pytrace=False)
    return ""


def _shown(path: Path) -> str:
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Two tests of one name, in one folder, would have one golden: whoever asks for it is told."""
    found: dict[Path, list[str]] = {}
    for item in items:
        if "golden" in getattr(item, "fixturenames", ()):
            found.setdefault(_golden_folder(item), []).append(item.nodeid)
    config.stash[_SAME_GOLDEN] = {folder: nodes for folder, nodes in found.items() if len(nodes) > 1}


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """What was pinned and what that changed; which goldens nothing is held against. Runs where the reports of all
    processes come together.
    """
    reports = [report for group in terminalreporter.stats.values() for report in group if hasattr(report, "nodeid")]
    lines = [text for report in reports for name, text in getattr(report, "user_properties", ()) if name == _PINNED]
    files = {config.rootpath / report.location[0] for report in reports if getattr(report, "location", None)}
    for folder in sorted({path.parent / "goldens" for path in files}):
        lines += _unused(folder, config.rootpath)
    if lines:
        terminalreporter.section("wheelbench")
        for line in dict.fromkeys(lines):  # a test has a report for each of its phases
            terminalreporter.write_line(line)


def _unused(folder: Path, project: Path) -> list[str]:
    if not any(folder.glob("*/golden.toml")):
        return []
    from bench.check.pinned import goldens

    return [
        f"golden {_shown(golden.directory)}: {golden.damage or golden.use}"
        for golden in goldens(folder, project)
        if not golden.ok
    ]


_PINNED = "wheelbench pinned"
_SAME_GOLDEN: pytest.StashKey[dict[Path, list[str]]] = pytest.StashKey()
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
        report.sections.append(("the last lines of the wires", "\n".join(driven.last_lines(LAST_LINES))))
        again = driven.again or f"python -m pytest {item.nodeid!r}\n(its recording: {driven.directory})"
        report.sections.append(("run it again", again))
    return report


# --- scenario files ------------------------------------------------------------------------------------------------


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """A file `*.scenario.toml` is a test."""
    if file_path.name.endswith(SCENARIO_ENDING):
        return ScenarioFile.from_parent(parent, path=file_path)
    return None


class NotMet(Exception):
    """A scenario whose expectations are not met; the text is the report."""


class ScenarioFile(pytest.File):
    """A scenario file: one test."""

    def collect(self) -> Iterator[pytest.Item]:
        """The test."""
        path = self.path

        def scenario(
            request: pytest.FixtureRequest, tmp_path: Path, controller: Callable[[Robot], ControlledBase]
        ) -> None:
            _run_scenario(path, request.node, tmp_path / "run", controller)

        yield ScenarioItem.from_parent(self, name=path.name.removesuffix(SCENARIO_ENDING), callobj=scenario)


class ScenarioItem(pytest.Function):
    """Runs a scenario with the project's controller; fails where an expectation is not met, a fault touched nothing, or
    the wires do not agree.

    It is a test function as others are: `tmp_path`, `controller` and what a conftest applies to every test are there.
    """

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What was not met; a wrong file, and an error in a controller, in one sentence each."""
        from bench.errors import BenchError

        if isinstance(excinfo.value, NotMet | BenchError):
            return str(excinfo.value)
        return super().repr_failure(excinfo)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Where it stands."""
        return self.path, None, f"scenario {self.name}"


def _run_scenario(
    path: Path, node: pytest.Item, directory: Path, controller: Callable[[Robot], ControlledBase]
) -> None:
    from bench.base import Base
    from bench.check.driven import replay_command, wire_lines
    from bench.check.reading import Recording, as_outputs
    from bench.check.scenario import load_scenario
    from bench.check.sources import run_of
    from bench.check.suite import run_to_end

    scenario = load_scenario(path)
    # A scenario that names its own controller has that one.
    build = Base if scenario.controller else controller
    job = run_of(scenario, controller=None if build is Base else build)
    again = replay_command(Path(_shown(path)), build) or f"python -m pytest {node.nodeid!r}"
    recorder = job.recorder(directory)
    result = None
    try:
        result = run_to_end(job, recorder)
    finally:
        # Up to where the first expectation fails; of an error, up to it.
        failed = [one.at_tick for one in result.verdicts if not one.ok and one.at_tick is not None] if result else []
        outs = list(as_outputs(Recording.open(directory)))[: min(failed) + 1 if failed else None]
        title = f"the last lines of the wires until {outs[-1].tick / 1000 if outs else 0:g} s"
        node.add_report_section("call", title, "\n".join(wire_lines(outs, LAST_LINES)))
        node.add_report_section("call", "run it again", f"{again}\n(its recording: {directory})")
    if result.reasons:
        raise NotMet("\n".join(result.reasons))
