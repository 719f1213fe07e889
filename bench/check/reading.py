"""Opens a recording: text in, ticks and bytes out. `recording` has the layout and writes it.

A run that was killed is read up to its last whole tick, with a note. Anything else that does not belong is refused
with file, line and what was expected: a comparison with a damaged file would prove nothing.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.arena import FIELD, Arena, load_arena
from bench.canbus import c610
from bench.canbus.table import Family
from bench.check import recording
from bench.check.lines import (
    BASE_TO_CORE,
    CAN_LOG,
    CORE_TO_BASE,
    EXPECTED,
    FEEDBACK_IDS,
    PARSERS,
    RC_LOG,
    SLAMWARE_LOG,
    STATE_CSV,
    Entry,
    can_id_of,
    cell_value,
)
from bench.check.recording import LOGS, RUN_TOML, RecordingError, RunInfo
from bench.config import ConfigError, Table, load_robot
from bench.messages import TICK_US, CanFrame, TickOutput
from bench.motors import family
from bench.noise import Noise
from bench.timed.settings import UNTIMED, Wires, read_wires

if TYPE_CHECKING:
    from bench.check.arrays import CanArrays

_WITNESS = re.compile(r'\((\d+)\.(\d{6})\) "(.*)" (\w+) .* -> ')


class Recording:
    """A recording on disk. `open` reads run.toml; everything else is read when it is first asked for.

    `ticks` counts from 0 to the end of the run. `notes` holds a sentence for everything that was left out.
    """

    def __init__(self, directory: Path, info: RunInfo, said_ticks: int | None, notes: list[str]) -> None:
        self.directory = directory
        self.info = info
        self.notes = notes
        self._said_ticks = said_ticks
        self._contents: dict[str, bytes] = {}
        self._lines: dict[str, list[bytes]] = {}

    @classmethod
    def open(cls, directory: Path | str) -> Recording:
        """Open a recording. Raises RecordingError where the directory is none, or is of another schema."""
        directory = Path(directory)
        if not directory.exists():
            raise RecordingError(f"{directory}: does not exist; give the directory of a recording")
        if not directory.is_dir():
            raise RecordingError(f"{directory}: is a file; a recording is a directory with a {RUN_TOML} in it")
        for name in (RUN_TOML, *LOGS):
            if not (directory / name).exists():
                raise RecordingError(f"{directory}: is no recording: it has no {name}")
        info, ticks, notes = _read_run_toml(directory / RUN_TOML)
        return cls(directory, info, ticks, notes)

    @property
    def complete(self) -> bool:
        """Whether the run came to its end, and was not killed on the way."""
        return self._said_ticks is not None

    @property
    def robot_file(self) -> Path:
        """The robot file that was used."""
        return self.directory / recording.ROBOT_TOML

    @property
    def profile_file(self) -> Path | None:
        """The transmitter profile that was used, if the robot had one."""
        path = self.directory / recording.PROFILE_TOML
        return path if path.exists() else None

    @property
    def scenario_file(self) -> Path | None:
        """The scenario that was run, where it had faults or expectations."""
        path = self.directory / recording.SCENARIO_TOML
        return path if path.exists() else None

    @property
    def arena(self) -> Arena:
        """Where the robot drove. Raises ConfigError where the file cannot be right."""
        path = self.directory / recording.ARENA_TOML
        return load_arena(path) if path.exists() else FIELD

    @property
    def noise(self) -> Noise:
        """What was done to the motors' feedback."""
        info = self.info
        return Noise(info.noise_angle_counts or 0, info.noise_late_ticks or 0, info.noise_loss_ppm or 0, info.seed)

    @property
    def wires(self) -> Wires:
        """How long things took on the wires. Raises ConfigError where run.toml says what no scenario may."""
        info = self.info
        if info.wires_can_bitrate is None:
            return UNTIMED
        said: dict[str, object] = {"can_bitrate": info.wires_can_bitrate, "also": (info.wires_also or "").split()}
        if info.wires_slamware_baud is not None:
            said["slamware_baud"] = info.wires_slamware_baud
        return read_wires(Table(self.directory / RUN_TOML, "wires", said))

    @cached_property
    def family(self) -> Family:
        """The CAN messages of the robot's motors; a C610's where the robot file cannot be read any more."""
        try:
            return family(load_robot(self.robot_file, self.profile_file))
        except ConfigError:
            return c610.FAMILY

    @cached_property
    def ticks(self) -> int:
        """Number of ticks. For a killed run: those that every file holds completely."""
        if self._said_ticks is not None:
            return self._said_ticks
        for name in reversed(LOGS):  # can.log was written last, so its end is the safe one
            count = len(self.lines(name))
            if count:
                return self.entry(name, count - 1)[0]  # not this tick itself: it may want a frame
        return 0

    @cached_property
    def can(self) -> list[tuple[int, int, bytes]]:
        """Every CAN frame in order: (tick, identifier, data)."""
        entries = list(self.entries(CAN_LOG))
        ids = {wire: can_id_of(wire) for wire in {entry[1] for entry in entries}}
        return [(tick, ids[wire], data) for tick, wire, data in entries]

    @cached_property
    def can_arrays(self) -> CanArrays | None:
        """The frames of can.log as columns; None where a line is not as we write it, or its time goes back."""
        from bench.check.arrays import can_arrays  # numpy, which only a comparison needs

        content = self.content(CAN_LOG)
        found = can_arrays(content[: content.rfind(b"\n") + 1] if not content.endswith(b"\n") else content)
        return None if found is None or found.goes_back else found

    @cached_property
    def commands(self) -> dict[int, tuple[CanFrame, ...]]:
        """Tick -> the frames that the base sent in it."""
        return _by_tick(entry for entry in self.can if entry[1] not in FEEDBACK_IDS)

    @cached_property
    def feedback(self) -> dict[int, tuple[CanFrame, ...]]:
        """Tick -> the frames that ESCs, encoders and gyro sent in it (0x201 to 0x208, 0x301 to 0x308)."""
        return _by_tick(entry for entry in self.can if entry[1] in FEEDBACK_IDS)

    @cached_property
    def rc(self) -> dict[int, bytes]:
        """Tick -> RC bytes that reached the base in it."""
        return {tick: data for tick, _, data in self.entries(RC_LOG)}

    @cached_property
    def core_to_base(self) -> dict[int, bytes]:
        """Tick -> bytes from the SLAMWARE core."""
        return {tick: data for tick, wire, data in self.entries(SLAMWARE_LOG) if wire == CORE_TO_BASE}

    @cached_property
    def base_to_core(self) -> dict[int, bytes]:
        """Tick -> bytes to the SLAMWARE core."""
        return {tick: data for tick, wire, data in self.entries(SLAMWARE_LOG) if wire == BASE_TO_CORE}

    @cached_property
    def state_columns(self) -> tuple[str, ...]:
        """The header of state.csv."""
        header = self.content(STATE_CSV).partition(b"\n")[0]
        columns = tuple(header.decode("utf-8", "replace").split(","))
        if columns[0] != "t_s":
            raise RecordingError(f"{self.directory / STATE_CSV}:1: expected a header that starts with t_s")
        return columns

    @cached_property
    def state(self) -> dict[int, tuple[float | int | str, ...]]:
        """Tick -> row of state.csv, numbers as numbers."""
        return {tick: tuple(map(cell_value, row.decode().split(","))) for tick, _, row in self.entries(STATE_CSV)}

    @cached_property
    def touches(self) -> list[tuple[int, str, str]]:
        """(tick, fault, wire) of every touch of a fault; what is no witness is left out."""
        if not (self.directory / recording.FAULTS_LOG).exists():
            return []
        witnesses = map(_WITNESS.match, self.content(recording.FAULTS_LOG).decode("utf-8", "replace").splitlines())
        return [(int(one[1]) * 1000 + int(one[2]) // 1000, one[3], one[4]) for one in witnesses if one]

    def content(self, name: str) -> bytes:
        """A file of the recording, whole; line ends that a checkout has turned are turned back."""
        content = self._contents.get(name)
        if content is None:
            content = recording.read_bytes(self.directory / name)
            if b"\r" in content:  # a search is a tenth of the cost of a replacement that replaces nothing
                content = content.replace(b"\r\n", b"\n")
            self._contents[name] = content
        return content

    def lines(self, name: str) -> list[bytes]:
        """The lines of a log, without the header of state.csv and without a last line that was cut off."""
        lines = self._lines.get(name)
        if lines is None:
            lines = self.content(name).split(b"\n")
            if lines.pop():
                self.notes.append(f"{name}: the last line was cut off and is left out")
            self._lines[name] = lines = lines[1:] if name == STATE_CSV else lines
        return lines

    def entry(self, name: str, index: int) -> Entry:
        """One line of a log, parsed. Raises RecordingError with file, line and what was expected."""
        line = self.lines(name)[index]
        entry = PARSERS[name](line)
        if entry is None:
            raise self._refuse(name, index, f"expected {EXPECTED[name]}; got {line[:60].decode('ascii', 'replace')!r}")
        if name == STATE_CSV and line.count(b",") != len(self.state_columns) - 1:
            values = line.count(b",") + 1
            raise self._refuse(name, index, f"expected {len(self.state_columns)} values, got {values}")
        return entry

    def entries(self, name: str) -> Iterator[Entry]:
        """The lines of a log, parsed and checked: time never goes back, and none lies after the end."""
        end, newest = self.ticks, 0
        last: dict[str, int] = {}
        parse = PARSERS[name]
        for index, line in enumerate(self.lines(name)):
            # `entry` says what is wrong with a line, and counts the cells of a row.
            entry = (parse(line) if name != STATE_CSV else None) or self.entry(name, index)
            tick, wire, _ = entry
            if tick >= end:
                if not self.complete:
                    return
                raise self._refuse(name, index, f"tick {tick} lies after the end of the run ({end} ticks)")
            if tick < newest:
                raise self._refuse(name, index, f"time goes back, from tick {newest} to {tick}")
            if name != CAN_LOG and last.get(wire) == tick:
                raise self._refuse(name, index, f"a second line for tick {tick}; expected one for each tick")
            newest = last[wire] = tick
            yield entry

    def _refuse(self, name: str, index: int, what: str) -> RecordingError:
        line = index + (2 if name == STATE_CSV else 1)
        return RecordingError(f"{self.directory / name}:{line}: {what}")


def as_outputs(run: Recording) -> Iterator[TickOutput]:
    """Every tick of a recording, the empty ones too, as the bench gave it out."""
    rc, core_to_base, base_to_core = run.rc, run.core_to_base, run.base_to_core
    commands, feedback, state = run.commands, run.feedback, run.state
    for tick in range(run.ticks):
        yield TickOutput(
            tick,
            rc.get(tick, b""),
            core_to_base.get(tick, b""),
            base_to_core.get(tick, b""),
            commands.get(tick, ()),
            feedback.get(tick, ()),
            state.get(tick),
        )


def _by_tick(frames: Iterable[tuple[int, int, bytes]]) -> dict[int, tuple[CanFrame, ...]]:
    found: dict[int, list[CanFrame]] = {}
    for tick, can_id, data in frames:
        found.setdefault(tick, []).append((can_id, data))
    return {tick: tuple(group) for tick, group in found.items()}


def _read_run_toml(path: Path) -> tuple[RunInfo, int | None, list[str]]:
    """run.toml -> the facts, the number of ticks where the run ended, and notes."""
    notes = []
    text, _, cut = recording.read_bytes(path).replace(b"\r\n", b"\n").rpartition(b"\n")
    if cut:
        notes.append(f"{RUN_TOML}: the last line was cut off and is left out")
    try:
        values: dict[str, Any] = tomllib.loads(text.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RecordingError(f"{path}: is not valid TOML ({error}); expected the facts of a run") from None
    if values.get("schema") != recording.SCHEMA:
        raise RecordingError(
            f"{path}: schema: expected {recording.SCHEMA}, got {values.get('schema')}; "
            "the recording is of another version of wheelbench"
        )
    for item in fields(RunInfo):
        kind, given = (int if str(item.type).startswith("int") else str), values.get(item.name)
        if type(given) is not kind and not (given is None and item.default is None):
            raise RecordingError(
                f"{path}: {item.name}: expected {'a whole number' if kind is int else 'text'}, got {given!r}"
            )
    if values["tick_us"] != TICK_US:
        raise RecordingError(f"{path}: tick_us: expected {TICK_US}, got {values['tick_us']}")
    ticks = values.get("ticks")
    if ticks is None:
        notes.append("the run was cut short; what it wrote until then is used")
    elif type(ticks) is not int or ticks < 0:
        raise RecordingError(f"{path}: ticks: expected the number of ticks, got {ticks!r}")
    facts: dict[str, Any] = {item.name: values.get(item.name) for item in fields(RunInfo)}
    return RunInfo(**facts), ticks, notes
