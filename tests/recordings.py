"""Runs made up for the tests of recordings: every wire in use, the same values every time."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

from bench.check.reading import Recording
from bench.check.recording import Recorder, RunInfo
from bench.messages import TickOutput

COLUMNS = ("t_s", "x_m", "heading_rad", "link", "armed")
ROBOT_TEXT = 'schema = 1\nname = "little"  # two robots are rarely the same\n'


def tick_output(tick: int) -> TickOutput:
    """One tick of a robot with three wheels: RC and state every 10 ms, the core every 50 ms."""
    wave = tick * 37 % 601 - 300
    feedback = tuple(
        (0x201 + n, struct.pack(">Hhh2x", (tick * 5 + n * 700) % 8192, wave * 3 - n, wave + n)) for n in range(3)
    )
    return TickOutput(
        tick=tick,
        rc=struct.pack(">B4HBBB", 0xAA, 2048, 2048 + wave, 2048 - wave, 2048, 0, 1, 0x55) if tick % 10 == 0 else b"",
        core_to_base=bytes.fromhex("10 02 F8 30 DA") if tick % 50 == 20 else b"",
        base_to_core=bytes.fromhex("50 01 00 02 53") if tick % 50 == 20 else b"",
        can_commands=((0x200, struct.pack(">4h", wave, -wave, wave // 2, 0)),),
        can_feedback=feedback,
        state=(tick / 1000.0, wave / 1000.0, -wave / 700.0, "live", int(tick > 100)) if tick % 10 == 0 else None,
    )


def made_run(ticks: int) -> list[TickOutput]:
    return [tick_output(tick) for tick in range(ticks)]


def record(directory: Path, outputs: Iterable[TickOutput], info: RunInfo | None = None) -> Recording:
    """Write a recording and open it again."""
    robot_file = directory.parent / "little.toml"
    robot_file.write_text(ROBOT_TEXT, encoding="utf-8")
    with Recorder(directory, info or RunInfo(robot="little"), COLUMNS, robot_file) as recorder:
        for out in outputs:
            recorder.add(out)
    return Recording.open(directory)
