"""Scenario files: which robot, which RC stream, what the SLAMWARE core asks for and when, for how long.

schema = 1
name = "demo"
robot = "m2006"
rc = "drive.bin"            # a capture beside this file; or, in its place, [[stick]] entries
seconds = 24.0
arena = "course.toml"       # beside this file; or a table [arena]: see `bench.arena`
extends = "base.toml"       # see `inherit`

[[stick]]                   # how a driver holds the sticks, -1 to 1, from then on; encoded by the robot's profile
at_s = 1.0
forward = 0.5               # left, turn (counter-clockwise); aux1 = true, aux2 = true while pressed

[[core]]                    # from then on, until the next one
at_s = 14.0
vx_mps = 0.25

[noise]                     # on the feedback of the motors; see `bench.noise`
loss = 0.01

[wires]                     # the bus and the lines take their time; see `bench.timed.settings`
can_bitrate = 500000

[[fault]]                   # see `faults`
wire = "rc"
kind = "drop"
at_s = 5.0
for_s = 1.0

[[expect]]                  # see `expectations`
when = "link == 'lost'"
then = "speed_mps < 0.05"
within_s = 0.5

[checks]                    # see `crosswire.settings`: on unless switched off
motion = "off"
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from bench.arena import FIELD, Arena, load_arena, read_arena
from bench.check.crosswire.settings import Checks, read_checks
from bench.check.expectations import Expectation, read_expectation
from bench.check.faults import Fault, read_fault
from bench.check.inherit import read_whole
from bench.config import ConfigError, Table
from bench.config.emit import toml_text
from bench.messages import BodyTwist
from bench.noise import SILENT, Noise, read_noise
from bench.rc.transmitter import Sticks
from bench.timed.settings import UNTIMED, Wires, read_wires

MOST_ON_THE_WIRE = 32767
"""m/s and rad/s: what a request of the core can say (Q16)."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """One run, described. Times are ticks; `core` holds (tick, twist) in order of time."""

    path: Path
    name: str
    robot: str
    rc: Path | None
    ticks: int
    core: tuple[tuple[int, BodyTwist], ...]
    profile: str | None = None
    period_ms: int | None = None
    about: str = ""
    seed: int = 0
    expectations: tuple[Expectation, ...] = ()
    controller: str | None = None
    odometry: str | None = None
    faults: tuple[Fault, ...] = ()
    checks: Checks = field(default_factory=Checks)
    arena: Arena = FIELD
    noise: Noise = SILENT
    wires: Wires = UNTIMED
    sticks: tuple[tuple[int, Sticks], ...] = ()
    """(tick, sticks) in order of time; empty where the stream is a capture's."""
    text: bytes = b""
    """What a recording keeps: the file, whole; with what it extends, where it does."""

    @property
    def says_more(self) -> bool:
        """Whether it says what the other files of a recording do not."""
        return bool(self.faults or self.expectations) or self.checks != Checks()


def load_scenario(path: Path, *, alone: bool = False) -> Scenario:
    """Read and check a scenario file; `alone` is a copy in a recording, without its capture beside it.

    Raises ConfigError with file, key and what to try.
    """
    whole = read_whole(path)
    text = path.read_bytes() if whole.is_alone else toml_text(whole.values).encode()
    return _read(Table(path, "", whole.values, whole.origins), text, alone)


def scenario_of(values: Mapping[str, Any]) -> Scenario:
    """A scenario said in Python: the keys of a file, with the values that they have there. Files are looked for in the
    current folder. Raises ConfigError with the key and what to try.
    """
    path = Path(f"scenario {values['name']!r}".replace("/", "_") if values.get("name") else "scenario")
    if "extends" in values:
        raise ConfigError(f"{path}: extends: is for files; in Python, take the keys of another one with **")
    text = toml_text(values)
    return _read(Table(path, "", tomllib.loads(text)), text.encode(), alone=False)


def _read(data: Table, text: bytes, alone: bool) -> Scenario:
    path = data.path
    data.take_schema()
    rc = data.get("rc", str, None)
    ticks = data.ticks("seconds", least=1) if data.has("seconds") or not alone else 1  # a recording says it itself
    core = [_read_core(entry) for entry in data.tables("core", optional=True)]
    sticks = [_read_sticks(entry) for entry in data.tables("stick", optional=True)]
    if sticks and rc is not None:
        raise data.fail("stick", "a run has one driver: give rc or [[stick]]")
    for key, times in (("core", [tick for tick, _ in core]), ("stick", [tick for tick, _ in sticks])):
        _refuse_times(data, key, times, ticks)
    name = data.get("name", str)
    seed = data.get("seed", int, 0)
    scenario = Scenario(
        path=path,
        name=name,
        robot=data.get("robot", str, "m2006"),
        rc=path.parent / rc if rc is not None else None,
        ticks=ticks,
        core=tuple(core),
        sticks=tuple(sticks),
        profile=data.get("profile", str, None),
        period_ms=data.get("period_ms", int, None),
        about=data.get("about", str, ""),
        seed=seed,
        arena=_read_arena(data, path, name, alone),
        noise=read_noise(data.table("noise", optional=True), seed),
        wires=read_wires(data.table("wires")) if data.has("wires") else UNTIMED,
        expectations=tuple(map(read_expectation, data.tables("expect", optional=True))),
        controller=data.get("controller", str, None),
        odometry=data.get("odometry", str, None),
        faults=tuple(map(read_fault, data.tables("fault", optional=True))),
        checks=read_checks(data.table("checks", optional=True)),
        text=text,
    )
    data.refuse_rest()
    _refuse_one_name_for_two(data, "fault", [fault.name for fault in scenario.faults])
    _refuse_one_name_for_two(data, "expect", [expectation.name for expectation in scenario.expectations])
    if scenario.rc is not None and not alone and not scenario.rc.is_file():
        raise ConfigError(f"{path}: rc: there is no capture {scenario.rc}")
    return scenario


def _read_arena(data: Table, path: Path, name: str, alone: bool) -> Arena:
    if not data.has("arena"):
        return FIELD
    if isinstance(data.values["arena"], dict):
        return read_arena(data.table("arena"), name)
    beside = path.parent / data.get("arena", str)
    return FIELD if alone else load_arena(beside)  # a recording has its arena in a file of its own


def _read_sticks(entry: Table) -> tuple[int, Sticks]:
    axes = {key: entry.get(key, float, 0.0) for key in ("forward", "left", "turn")}
    for key, value in axes.items():
        if not -1.0 <= value <= 1.0:
            raise entry.fail(key, f"expected -1 to 1, got {value}")
    buttons = {key: entry.get(key, bool, False) for key in ("aux1", "aux2")}
    at_tick = entry.ticks("at_s")
    entry.refuse_rest()
    return at_tick, Sticks(**axes, **buttons)


def _read_core(entry: Table) -> tuple[int, BodyTwist]:
    twist = {key: entry.get(key, float, 0.0) for key in BodyTwist._fields}
    for key, value in twist.items():
        if abs(value) > MOST_ON_THE_WIRE:
            raise entry.fail(key, f"expected -{MOST_ON_THE_WIRE} to {MOST_ON_THE_WIRE}, got {value:g}")
    at_tick = entry.ticks("at_s")
    entry.refuse_rest()
    return at_tick, BodyTwist(**twist)


def _refuse_one_name_for_two(data: Table, key: str, names: Sequence[str]) -> None:
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise data.fail(key, f"two are called {twice!r}; give each a name of its own")


def _refuse_times(data: Table, key: str, times: Sequence[int], end: int) -> None:
    """Times run forwards, and what comes after the end of the run is a mistake."""
    for number, (earlier, later) in enumerate(pairwise(times), 1):
        if later <= earlier:
            at = f"{later / 1000:g} s comes after {earlier / 1000:g} s"
            raise data.fail(f"{key}[{number}].at_s", f"the times must rise from entry to entry: {at}")
    if times and times[-1] >= end:
        last = f"{key}[{len(times) - 1}].at_s"
        raise data.fail(last, f"{times[-1] / 1000:g} s is not before the end of the run (seconds = {end / 1000:g})")
