"""Foreign firmware in C, in lock-step: the link, a whole run, a reset.

    link        a step of a firmware that only answers, against two C programs that pass each other the same packets,
                in turns in the same run: how much of their speed it reaches. Either pair shares one core, as in a run
    run         each example firmware, driven and recorded, faster than real time by so much; our own base beside them
    reset       a fresh firmware until it has answered its first tick

Wall time, because two processes share the work; a run by the CPU of both, too: a busy machine keeps them waiting.
"""

from __future__ import annotations

import random
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path
from statistics import median

from bench.base import Base, ControlledBase
from bench.check.controllers import Build, at_full_speed
from bench.check.recording import BLOCK_TICKS, Recorder
from bench.check.run import info_of
from bench.config import load_robot
from bench.dut.firmware import Firmware, FirmwareBase, firmware_of
from bench.loop import Bench, simulated
from bench.messages import TickInput, TickOutput
from bench.rc.transmitter import Sticks, Transmitter
from benchmarks.empty_call import beside, told_for_reference
from benchmarks.table import Row, Sample, row_at_least, verdict

LINK_AT_LEAST, RUN_AT_LEAST, RESET_MS_AT_MOST = 0.4, 15.0, 5.0
SLICES, SLICE_TICKS = 10, 2000
RUN_TICKS, RESETS = 10_000, 50
QUESTION_BYTES, ANSWER_BYTES = 8 + 3 * 11, 4 + 11
"""Three feedback frames there, one command frame back."""

OURS = "(our own base)"
"""The same drive, for orientation."""
HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parents[1] / "docs" / "examples" / "firmware"
STYLES = {"superloop": "uart12", "interrupts": "frsky-sbus", "rtos": "flysky"}
FEEDBACK = tuple((0x201 + wheel, bytes((0x12, 0x34, 0, 0, 0, 0, 0, 0))) for wheel in range(3))


def measure(order: random.Random, share: float = 1.0) -> Sample:
    """The link's share of C, each example's factor, a reset in ms; nothing where there is no compiler."""
    if not all(shutil.which(tool) for tool in ("cc", "objcopy")):
        return {}
    sample = {"link": _link(order, share)}
    runs: dict[str, tuple[Build, str]] = {
        style: (firmware_of(EXAMPLES / style / "fixed.toml"), profile) for style, profile in STYLES.items()
    }
    runs[OURS] = (Base, STYLES["superloop"])
    for style in order.sample(sorted(runs), len(runs)):
        (wall, cpu), call_ns = beside(partial(_run_factors, *runs[style], share))
        sample |= {f"{style} wall": wall, f"{style} CPU": cpu, f"{style} call_ns": call_ns}
    return sample | {"reset": _reset_ms(firmware_of(EXAMPLES / "interrupts" / "fixed.toml"), share)}


def report(samples: Sequence[Sample]) -> list[Row]:
    """The three bars, the examples one by one."""
    if not all(samples):
        return [Row("firmware in lock-step", "skipped: no gcc or binutils here")]
    link, reset_ms = (median(sample[name] for sample in samples) for name in ("link", "reset"))
    rows = [
        Row(
            "lock-step link, of two C programs' speed",
            f"{link:.2f}",
            f"at least {LINK_AT_LEAST:g}",
            verdict(link >= LINK_AT_LEAST),
        )
    ]
    for style in (*STYLES, OURS):
        calls_ns = [sample[f"{style} call_ns"] for sample in samples]
        for clock in ("CPU", "wall"):
            factors = [sample[f"{style} {clock}"] for sample in samples]
            row = row_at_least(f"times real time, firmware recorded, {style} {clock}", factors, RUN_AT_LEAST)
            if style == OURS:
                row = row._replace(bar="", verdict="")
            rows.append(row._replace(told_for_reference=told_for_reference(factors, calls_ns)))
    is_met = reset_ms <= RESET_MS_AT_MOST
    return [*rows, Row("reset of a firmware, ms", f"{reset_ms:.2f}", f"at most {RESET_MS_AT_MOST:g}", verdict(is_met))]


def _link(order: random.Random, share: float) -> float:
    """C's time over ours, both summed over slices that take turns."""
    base, ticks = firmware_of(HERE / "lockstep_c" / "answer.toml")(), max(1, round(SLICE_TICKS * share))
    base.step(0, b"", b"", FEEDBACK)
    ours_s = theirs_s = 0.0
    for _ in range(SLICES):
        for ours in order.sample((True, False), 2):
            if ours:
                with at_full_speed(base):
                    ours_s += _steps_s(base, ticks)
            else:
                theirs_s += ticks * _pingpong_s(ticks)
    base.close()
    return theirs_s / ours_s


def _steps_s(base: ControlledBase, ticks: int) -> float:
    begin = time.perf_counter()
    for tick in range(ticks):
        base.step(tick, b"", b"", FEEDBACK)
    return time.perf_counter() - begin


def _pingpong_s(rounds: int) -> float:
    sizes = map(str, (rounds, QUESTION_BYTES, ANSWER_BYTES))
    return float(subprocess.run([_pingpong()[1], *sizes], check=True, capture_output=True, text=True).stdout)


@cache
def _pingpong() -> tuple[tempfile.TemporaryDirectory[str], Path]:
    """The C program; it goes when this process ends."""
    folder = tempfile.TemporaryDirectory(prefix="wheelbench-")
    program = Path(folder.name) / "pingpong"
    subprocess.run(["cc", "-O2", HERE / "lockstep_c" / "pingpong.c", "-o", program], check=True)
    return folder, program


def _run_factors(build: Build, profile: str, share: float) -> tuple[float, float]:
    """Driven by sticks that move all the time, every frame recorded: by the wall, and by both processes' CPU."""
    robot = load_robot("m2006", profile)
    assert robot.rc is not None
    base, transmitter, ticks = build(robot), Transmitter(robot.rc), max(1, round(RUN_TICKS * share))
    bench = Bench(base, simulated(robot).world)
    with tempfile.TemporaryDirectory(prefix="wheelbench-") as folder:
        assert robot.file is not None
        begin, begin_cpu = time.perf_counter(), time.process_time()
        with Recorder(Path(folder) / "run", info_of(robot), bench.state_columns, robot.file, robot.rc.file) as recorder:
            block: list[TickOutput] = []
            with at_full_speed(base):  # as a run from the command line does, and in blocks as it does
                for tick in range(ticks):
                    speed = 0.5 * ((tick // 500 + 1) % 3 - 1)
                    sticks = Sticks(speed, -speed / 2, speed / 3) if tick > 400 else Sticks(aux1=100 < tick < 200)
                    block.append(bench.tick(TickInput(transmitter.step(tick, sticks))))
                    if len(block) == BLOCK_TICKS:
                        recorder.extend(block)
                        block = []
        wall_s, cpu_s = time.perf_counter() - begin, time.process_time() - begin_cpu
    if isinstance(base, FirmwareBase):
        cpu_s += base.processor_s()
        base.close()
    if ticks > 1000:
        assert max(map(abs, bench.world.plant.wheel_speeds_radps)) > 1.0, "it drives"
    return ticks / 1000.0 / wall_s, ticks / 1000.0 / cpu_s


def _reset_ms(firmware: Firmware, share: float) -> float:
    took_ms = []
    for _ in range(max(1, round(RESETS * share))):
        begin = time.perf_counter()
        base = firmware()
        base.step(0, b"", b"", FEEDBACK)
        took_ms.append(1000 * (time.perf_counter() - begin))
        base.close()
    return median(took_ms)
