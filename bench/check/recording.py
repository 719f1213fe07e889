"""A run on disk, as it happens: a directory of plain text that other tools open. `reading` opens it again.

    can.log        (0.001000) can0 200#0258025802580000      candump format; commands first, then the ESCs' feedback
    rc.log         (0.010000) rc0 > AA 08 00 08 00 ...       bytes that reached the base in this tick
    slamware.log   (0.050000) slamware0 > 10 02 F8 30 DA     core to base; `<` is base to core
    state.csv      t_s,x_m,...                               a row every 10 ms, floats with six decimals
    run.toml       robot, profile, scenario, seed, periods, versions; `ticks` is added when the run ends
    robot.toml, profile.toml                                 the files that were used, byte for byte
    scenario.toml, faults.log                                where a scenario has faults or expectations: the file, and
                                                             (5.000000) "name" rc AA 08 -> -    each touch of a fault
    arena.toml                                               the arena, where it is not the plain field
    firmware.log   (0.000000) | boot 7                       what a firmware printed, for people: a replay needs none
    bus.log        (0.000122) can0 200#0258025802580000      where wires take time: each frame, when it was through

Tick n is time n ms. A recording starts at tick 0 and holds every tick: it is all that a replay needs. Nothing in it
depends on the machine, the Python version or the date. What has been written survives the death of the process.
"""

from __future__ import annotations

import errno
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from io import FileIO
from pathlib import Path
from types import TracebackType

from bench import __version__
from bench.check.firmware_log import FIRMWARE_LOG, PrintedLine, printed_lines
from bench.check.lines import (
    BUS_LOG,
    CAN_LOG,
    RC_LOG,
    SLAMWARE_LOG,
    STATE_CSV,
    StateFormat,
    bus_lines,
    can_lines,
    rc_lines,
    slamware_lines,
)
from bench.config.emit import toml_text
from bench.config.table import read_file
from bench.errors import BenchError, SurroundingsError
from bench.messages import STATE_PERIOD_TICKS, TICK_US, CanFrame, TickOutput
from bench.timed.timing import Timing

SCHEMA = 1
RUN_TOML, ROBOT_TOML, PROFILE_TOML, GOLDEN_TOML = "run.toml", "robot.toml", "profile.toml", "golden.toml"
SCENARIO_TOML, FAULTS_LOG, ARENA_TOML = "scenario.toml", "faults.log", "arena.toml"
# can.log is written last: a tick that has begun there stands in the other files, wherever a run was cut off.
LOGS = (RC_LOG, SLAMWARE_LOG, STATE_CSV, CAN_LOG)
FILES = (*LOGS, RUN_TOML, ROBOT_TOML, PROFILE_TOML, SCENARIO_TOML, FAULTS_LOG, ARENA_TOML, FIRMWARE_LOG, BUS_LOG)

BY_HAND = """schema = 1
name = "by hand"
about = "made by hand in the dashboard; held against itself and nothing else"
seed = {seed}

[checks]
motion = "off"
rest_current = "off"
answers = "off"
bus = "off"
"""
"""Begins the scenario.toml of a run that a person made with faults, or saved as a golden. How long it is says run.toml;
what faults by hand do to the wires is no finding.
"""

# Formatting and writing this many ticks takes about 0.4 ms: less than the tick that a real port has to keep.
BLOCK_TICKS = 100


class RecordingError(BenchError):
    """A recording that cannot be written, read or trusted."""


class RecordingPlaceError(SurroundingsError, RecordingError):
    """The operating system refuses: no room, no permission, no such device."""


@dataclass(frozen=True, slots=True)
class RunInfo:
    """The facts of a run, as run.toml holds them."""

    robot: str
    profile: str | None = None
    scenario: str | None = None
    controller: str | None = None
    """The form in the controller's place, where it is not the speed loop; the same for odometry."""
    odometry: str | None = None
    seed: int = 0
    noise_angle_counts: int | None = None
    """How bad the motors' feedback was made; None: it was not."""
    noise_late_ticks: int | None = None
    noise_loss_ppm: int | None = None
    wires_can_bitrate: int | None = None
    """Where wires took their time; None: they did not."""
    wires_slamware_baud: int | None = None
    wires_also: str | None = None
    role: str | None = None
    """Which part was real, where one was: `base`, `core` or `motors`."""
    tick_us: int = TICK_US
    state_period_ticks: int = STATE_PERIOD_TICKS
    wheelbench: str = __version__
    schema: int = SCHEMA


class Recorder:
    """Writes one recording. A context manager; `close` ends the run.

    `robot_file` and `profile_file` are copied in, `scenario` and `arena` are the texts of their files; `heard` gives
    what a firmware has printed since the last call, and is told whether the run is over; `on_bus` gives what has been
    on a timed CAN bus since the last call, (time in us, frame). The directory is made; one
    that already holds something is refused unless `overwrite`, which removes the files of a recording and nothing else,
    and never a golden. Raises RecordingError where the place cannot be written, at once or later from `add`; what is on
    disk then stays.
    """

    def __init__(
        self,
        directory: Path | str,
        info: RunInfo,
        state_columns: Sequence[str],
        robot_file: Path,
        profile_file: Path | None = None,
        *,
        scenario: bytes | None = None,
        arena: str = "",
        heard: Callable[[bool], Sequence[PrintedLine]] | None = None,
        on_bus: Callable[[], Sequence[tuple[int, CanFrame]]] | None = None,
        overwrite: bool = False,
    ) -> None:
        if not state_columns or state_columns[0] != "t_s":
            raise ValueError(f"state columns start with t_s, got {list(state_columns)[:1]}")
        self.directory = Path(directory)
        self.ticks = 0
        """How many ticks are on disk."""
        self._block: list[TickOutput] = []
        self._files: dict[str, FileIO] = {}
        self._heard = heard
        self._on_bus = on_bus
        self._state = StateFormat(len(state_columns))
        header = (",".join(state_columns) + "\n").encode()
        copies = {ROBOT_TOML: read_bytes(robot_file)}
        if profile_file is not None:
            copies[PROFILE_TOML] = read_bytes(profile_file)
        if scenario is not None:
            copies |= {SCENARIO_TOML: scenario, FAULTS_LOG: b""}
        if arena:
            copies[ARENA_TOML] = arena.encode()
        _make_room(self.directory, overwrite)
        try:
            for name in LOGS:
                self._open(name)
            self._write(STATE_CSV, header)
            # run.toml comes last: where it stands, the recording has begun.
            for name, content in (*copies.items(), (RUN_TOML, run_toml(info).encode("utf-8", "replace"))):
                self._open(name)
                self._write(name, content)
        except RecordingError:
            self._release()
            raise

    def add(self, out: TickOutput) -> None:
        """Take one tick. Raises RecordingError where the disk refuses, ValueError where a tick was left out."""
        self.extend((out,))

    def extend(self, outs: Sequence[TickOutput]) -> None:
        """Take some ticks. Raises as `add` does."""
        block = self._block
        block += outs
        if len(block) >= BLOCK_TICKS:
            self.flush()

    def log_bus_of(self, timing: Timing | None) -> None:
        """The ticks come from another bench from now on, with these wires: what was on its bus goes into the log."""
        self._on_bus = timing.start_log() if timing is not None else None

    def begin_by_hand(self, seed: int = 0) -> None:
        """For a run that a person made: a scenario.toml of its own, once. Raises RecordingError."""
        if SCENARIO_TOML not in self._files:
            for name, content in ((FAULTS_LOG, ""), (SCENARIO_TOML, BY_HAND.format(seed=seed))):
                self._open(name)
                self._write(name, content.encode())

    def add_fault(self, text: str, seed: int = 0) -> None:
        """A fault that joined the run: its `[[fault]]` table for scenario.toml, so that the replay has it too.

        Raises RecordingError.
        """
        self.begin_by_hand(seed)
        self._write(SCENARIO_TOML, f"\n{text}".encode())

    def witness(self, lines: Sequence[str]) -> None:
        """What faults did, one line each, for a recording with a scenario. Raises RecordingError."""
        self._write(FAULTS_LOG, "".join(f"{line}\n" for line in lines).encode())

    def flush(self) -> None:
        """Write what has been added until now."""
        block = self._block
        if not block:
            return
        if not self._files:
            raise RecordingError(f"{self.directory}: the recording has ended; start another one")
        ticks, rc, core_to_base, base_to_core, commands, feedback, states = zip(*block, strict=True)
        if ticks != tuple(range(self.ticks, self.ticks + len(block))):
            raise ValueError(f"ticks {ticks[0]}..{ticks[-1]} do not follow tick {self.ticks - 1} one by one")
        texts = (
            rc_lines(ticks, rc),
            slamware_lines(ticks, core_to_base, base_to_core),
            self._state.lines([row for row in states if row is not None]),
            can_lines(ticks, commands, feedback),
        )
        try:
            self._write_heard(is_over=False)  # first: what a firmware said is there where its frames are
            self._write_on_bus()
            for name, text in zip(LOGS, texts, strict=True):
                self._write(name, text.encode())
        except RecordingError:
            self._release()
            raise
        self.ticks += len(block)
        block.clear()

    def close(self) -> None:
        """Write the rest and the number of ticks. Does nothing after an error or a second time."""
        if not self._files:
            return
        try:
            self.flush()
            self._write_heard(is_over=True)
            # Appended, so that run.toml is whole at every instant.
            self._write(RUN_TOML, f"ticks = {self.ticks}\n".encode())
        finally:
            self._release()

    def abandon(self) -> None:
        """Write nothing more: what is there reads like a run that was cut short."""
        self._release()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_heard(self, is_over: bool) -> None:
        lines = self._heard(is_over) if self._heard is not None else ()
        if not lines:
            return
        if FIRMWARE_LOG not in self._files:
            self._open(FIRMWARE_LOG)
        self._write(FIRMWARE_LOG, printed_lines(lines).encode())

    def _write_on_bus(self) -> None:
        if self._on_bus is None:
            return
        if BUS_LOG not in self._files:
            self._open(BUS_LOG)
        self._write(BUS_LOG, bus_lines(self._on_bus()).encode())

    def _open(self, name: str) -> None:
        path = self.directory / name
        try:
            self._files[name] = open(path, "xb", buffering=0)  # noqa: SIM115 (kept open for the whole run)
        except OSError as error:
            raise cannot(path, "written", error) from None

    def _write(self, name: str, data: bytes) -> None:
        # Unbuffered: what this call has passed on survives a kill, and there is nothing left to fail in close().
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._files[name].write(rest) :]
        except OSError as error:
            raise cannot(self.directory / name, "written", error) from None

    def _release(self) -> None:
        for file in self._files.values():
            file.close()
        self._files.clear()


def run_toml(info: RunInfo) -> str:
    """RunInfo as the text of run.toml; facts that are None are left out."""
    return toml_lines({item.name: getattr(info, item.name) for item in fields(info)})


def toml_lines(values: dict[str, str | int | None]) -> str:
    """One `key = value` line for each value that is not None."""
    return toml_text(values) if any(value is not None for value in values.values()) else ""


def read_bytes(path: Path) -> bytes:
    """The file's content. Raises RecordingError where it cannot be read."""
    try:
        return read_file(path)
    except OSError as error:
        raise cannot(path, "read", error) from None


def write_file(path: Path, content: bytes) -> None:
    """Write a whole file. Raises RecordingError."""
    try:
        path.write_bytes(content)
    except OSError as error:
        raise cannot(path, "written", error) from None


def remove_recording(directory: Path) -> None:
    """Remove the files of a recording from a directory, and no other. Raises RecordingError."""
    for name in FILES:
        try:
            (directory / name).unlink(missing_ok=True)
        except OSError as error:
            raise cannot(directory / name, "removed", error) from None


def make_directory(directory: Path) -> list[str]:
    """Make the directory and its parents where they are missing; the names of what it holds. Raises RecordingError."""
    if directory.exists() and not directory.is_dir():
        raise RecordingError(f"{directory}: is a file, and a recording is a directory; give another name")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        return sorted(path.name for path in directory.iterdir())
    except OSError as error:
        raise cannot(directory, "used for a recording", error) from None


def _make_room(directory: Path, overwrite: bool) -> None:
    held = make_directory(directory)
    if GOLDEN_TOML in held:
        raise RecordingError(f"{directory}: holds a golden; record elsewhere and pin that run")
    is_recording = RUN_TOML in held
    mine = [] if is_recording else [name for name in held if name in FILES]
    if mine:
        what = f"{mine[0]}, which is of no recording and would be written over"
        raise RecordingError(f"{directory}: holds {what}; give another directory")
    if held and not overwrite:
        what = "a recording" if is_recording else f"other files ({', '.join(held[:3])})"
        raise RecordingError(f"{directory}: already holds {what}; give another directory, or --overwrite")
    remove_recording(directory)


def cannot(path: Path, done: str, error: OSError) -> RecordingPlaceError:
    """What to say where the operating system lets nobody have this `done`: read, written, removed."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        advice = "what stands there stays; free some space or record elsewhere"
    elif done == "read":
        advice = "check the path and its permissions"
    else:
        advice = "give a directory that you may write to"
    return RecordingPlaceError(f"{path}: cannot be {done} ({error.strerror}); {advice}")
