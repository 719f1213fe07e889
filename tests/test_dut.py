"""A team's own C behind the seam: its wires, its time, and every way in which it can end badly."""

import json
import math
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from pathlib import Path

import pytest
from compilers import needs_compiler
from desk import M2006, Granted, pass_ticks

from bench.__main__ import main
from bench.check.failsafe import RED, losses, run_cell
from bench.check.reading import Recording
from bench.check.recording import RunInfo
from bench.check.run import Run
from bench.config import load_robot
from bench.dut import build as build_module
from bench.dut import firmware as firmware_module
from bench.dut.build import folder_of
from bench.dut.firmware import FirmwareBase, firmware_of
from bench.dut.project import load_project
from bench.errors import ControllerFailed
from bench.io.link import InlineLink
from bench.loop import Bench, simulated
from bench.messages import TickInput
from bench.screen.keyboard import Keyboard
from bench.screen.layout import PAGES
from bench.screen.scene import Shown
from bench.screen.session import ABANDONED_MS, Session
from bench.screen.stage import to_drive
from bench.screen.status import status
from bench.screen.view import picture
from bench.screen.wheels import wheels
from bench.slamware import FrameDecoder

ROOT = Path(__file__).parents[1]
BAD = ROOT / "tests" / "firmware" / "bad.toml"
EXAMPLES = ROOT / "docs" / "examples" / "firmware"
FEEDBACK = tuple((0x201 + wheel, bytes((0x12, 0x34, 0, 0, 0, 0, 0, 0))) for wheel in range(3))

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def bad():
    return firmware_of(BAD)


def told(base, order, ticks=200):
    """What the firmware does with an order that it gets at tick 5."""
    for tick in range(ticks):
        base.step(tick, order.encode() if tick == 5 else b"", b"", ())


def made(folder, source, toml="", name="fw.toml"):
    """A firmware of one source."""
    (folder / "fw.c").write_text(textwrap.dedent(source))
    text = toml if "sources" in toml else f'sources = ["fw.c"]\n{toml}'
    (folder / name).write_text(f'schema = 1\nname = "fw"\n{text}')
    return firmware_of(folder / name)


def said(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    out = capsys.readouterr()
    return status, out.out, out.err


# --- what ends a run -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("order", "tick", "says"),
    [
        ("n", 5, "crashed: SIGSEGV, a bad pointer (address 0x8) in misbehave (bad.c:45)"),
        ("d", 5, "crashed: SIGFPE, a division by zero or an overflow of one in divide (bad.c:16)"),
        ("s", 5, "in sink (bad.c:19), called from sink (bad.c:22), called from sink"),
        ("a", 5, "SIGABRT, an abort or a failed assert in misbehave (bad.c:54)\nits last output:\n  firmware: "),
        ("o", 5, "loops for ever with interrupts off in misbehave (bad.c:58)"),
        ("x", 5, "ended itself with exit(3); a firmware loops for ever"),
        ("f", 105, "floods the CAN bus: for 100 ms it has sent more than the 8 frames that a millisecond has room for"),
        ("F", 5, "floods the SLAMWARE line: more than 16,384 bytes in one millisecond in misbehave (bad.c:67)"),
        ("c", 5, "closed a file that it had not opened: its line to the bench"),
        ("i", 5, "is in an interrupt handler that does not end in every_ms (bad.c:31)"),
        ("r", 5, "has come to the end of main; a firmware loops for ever"),
        ("w", 5, "waits in an interrupt handler, where no time passes in every_ms (bad.c:34)"),
    ],
)
def test_what_a_firmware_does_to_itself_is_one_sentence_with_its_line(bad, order, tick, says):
    base = bad()
    with pytest.raises(ControllerFailed) as failed:
        told(base, order)
    text = str(failed.value)
    assert text.startswith(f"bad.toml: at tick {tick} ({tick / 1000:.3f} s) the firmware "), text
    assert says in text
    with pytest.raises(ControllerFailed) as again:
        base.step(tick + 1, b"", b"", ())
    assert str(again.value) == text, "it stays what it was"


@pytest.mark.parametrize(
    ("order", "says"),
    [("z", "waits for something of the host that never comes"), ("b", "computes without end in code that the bench")],
)
def test_what_the_shim_cannot_count_is_ended_by_the_clock(bad, order, says, monkeypatch):
    monkeypatch.setattr(firmware_module, "PATIENCE_MS", 300)
    base = bad()
    with pytest.raises(ControllerFailed, match=says):
        told(base, order)
    assert not Path(f"/proc/{base.pid}/stat").exists(), "and its process is gone"


def test_an_answer_that_comes_when_patience_is_over_but_before_anybody_looks_is_taken(bad, monkeypatch):
    """A busy machine gives the firmware its turn just then; it has answered, and sleeps until it is asked again."""
    monkeypatch.setattr(firmware_module, "PATIENCE_MS", 50)
    base = bad()
    base.step(0, b"", b"", FEEDBACK)
    look, looks = firmware_module._processor_time, []

    def late(pid):
        looks.append(pid)
        if len(looks) == 2:  # the first is before it waits once more
            os.kill(pid, signal.SIGCONT)
            assert select.select([base._link], [], [], 60)[0]
            while not look(pid)[0]:
                time.sleep(0.001)
        return look(pid)

    monkeypatch.setattr(firmware_module, "_processor_time", late)
    os.kill(base.pid, signal.SIGSTOP)
    frames, _ = base.step(1, b"", b"", FEEDBACK)
    assert frames[0][1] == b"\x02" + bytes(7), "its second millisecond"
    assert len(looks) == 2
    base.close()


def test_a_firmware_that_is_killed_from_outside_is_told_so(bad):
    base = bad()
    told(base, "", 3)
    os.kill(base.pid, 9)
    with pytest.raises(ControllerFailed, match=r"SIGKILL, ended from outside"):
        told(base, "")


def test_a_main_loop_that_hangs_does_not_keep_interrupts_out(bad):
    base = bad()
    told(base, "m")  # as on the chip: the frames stop, and nothing else does
    assert base.step(200, b"x", b"", ()) == ((), b"")


def test_a_talkative_firmware_runs_on_and_fills_nothing(bad):
    base = bad()
    told(base, "p", 300)
    assert len(base.output()) <= 65536
    assert os.fstat(base._output.file).st_size == 0


def test_garbage_from_a_firmware_is_what_a_wire_can_carry(bad):
    base = bad()
    for tick in range(5):
        base.step(tick, b"", b"", ())
    frames, slamware = base.step(5, b"g", b"", ())
    assert [can_id for can_id, _ in frames] == list(range(0x7F8, 0x800))
    assert all(len(data) == 8 for _, data in frames)
    assert len(slamware) == 700


def test_a_crash_ends_the_run_and_keeps_the_recording(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = """
        #include "wheelbench.h"
        int main(void) {
            for (;;) {
                wb_can_write(0x200, (const uint8_t[8]){0}, 8);
                if (wb_millis() == 321)
                    __builtin_trap();
                wb_wait();
            }
        }
        """
    made(tmp_path, source)
    Path("run.scenario.toml").write_text('schema = 1\nname = "short"\nseconds = 1.0\ncontroller = "fw.toml"\n')
    status, _, error = said(capsys, "replay", "run.scenario.toml", "--record", "run")
    assert status == 1
    assert error == (
        "wheelbench replay: fw.toml: at tick 321 (0.321 s) the firmware crashed: "
        "SIGILL, an instruction that there is not in main (fw.c:7)\n"
    )
    recording = Recording.open("run")
    assert (recording.ticks, recording.complete) == (321, True)
    assert len(recording.commands) == 321
    status, _, error = said(capsys, "replay", "run")
    assert "was recorded with the controller fw.toml; give its place" in error
    status, _, error = said(capsys, "replay", "run", "--controller", "fw.toml")
    assert (status, error) == (0, ""), "up to the crash it is the same run"


# --- the compiler ----------------------------------------------------------------------------------------------------


def test_what_the_compiler_says_is_shown_in_its_words(tmp_path, capsys):
    with pytest.raises(Exception, match="the compiler refuses the firmware; its own words:\n") as failed:
        made(tmp_path, "int main(void) { return speed; }\n")
    assert "error: 'speed' undeclared" in str(failed.value)
    status, _, error = said(capsys, "dut", "build", tmp_path / "fw.toml")
    assert status == 2
    assert "fw.c:1:25: error" in error


def test_what_no_source_defines_is_named(tmp_path):
    source = "void board(void); void led(int);\nint main(void) { for (;;) { board(); led(1); } }\n"
    with pytest.raises(Exception, match="calls what no source defines: board, led; add their files"):
        made(tmp_path, source)
    with pytest.raises(Exception, match="no source has a main"):
        made(tmp_path, "void f(void) {}\n")


@pytest.mark.parametrize(
    ("toml", "says"),
    [
        ('sources = ["none.c"]', "sources: no file is called 'none.c'"),
        ("sources = []", "sources: names no file"),
        ('sources = ["fw.c"]\nsanitise = true', "sanitise: unknown key; did you mean sanitize?"),
        ('sources = ["fw.c"]\n[wires]\nrc = "huart1, x"', "wires.rc: expected a name of the firmware, as C writes it"),
        ('sources = ["fw.c"]\n[entry]\nmain = "main"\nloop = "loop"', "a firmware begins at one place"),
        ('sources = ["fw.c"]\nblocks_per_ms = 3', "blocks_per_ms: expected 100 or more, got 3"),
        ('sources = ["fw.c"]\n[[timer]]\nhandle = "htim1"\nperiod_ms = 0', "period_ms: expected 1 or more, got 0"),
        ('sources = ["fw.toml"]', "fw.toml is no C file"),
        ('sources = ["fw.c"]\ncompiler = "no-such-cc"', "there is no C compiler 'no-such-cc' on this machine; install"),
    ],
)
def test_a_wrong_project_file_is_one_sentence(tmp_path, capsys, toml, says):
    (tmp_path / "fw.c").write_text("int main(void) { for (;;) {} }\n")
    (tmp_path / "fw.toml").write_text(f'name = "fw"\n{toml}\n')
    status, _, error = said(capsys, "dut", "build", tmp_path / "fw.toml")
    assert status == (3 if "compiler" in toml else 2)
    assert says in error
    assert error.count("\n") == 1


def test_only_what_changed_is_compiled_again(tmp_path):
    source = '#include "limit.h"\n#include "wheelbench.h"\nint main(void) { for (;;) wb_wait(); }\n'
    (tmp_path / "limit.h").write_text("#define LIMIT 1\n")
    first = made(tmp_path, source).built
    assert (first.is_new, first.program.exists()) == (True, True)
    assert not made(tmp_path, source).built.is_new
    (tmp_path / "limit.h").write_text("#define LIMIT 2\n")
    assert made(tmp_path, source).built.is_new, "a header counts"
    first.program.unlink()
    assert made(tmp_path, source).built.is_new


def test_a_program_that_was_made_with_another_shim_is_made_again(tmp_path, monkeypatch):
    """The bench was updated: the two would not understand each other."""
    source = '#include "wheelbench.h"\nint main(void) { for (;;) wb_wait(); }\n'
    shim = tmp_path / "shim"
    shutil.copytree(build_module.SHIM, shim)
    monkeypatch.setattr(build_module, "SHIM", shim)
    assert made(tmp_path, source).built.is_new
    assert not made(tmp_path, source).built.is_new
    with open(shim / "core.h", "a") as header:
        header.write("/* newer */\n")
    assert made(tmp_path, source).built.is_new


def test_a_folder_that_cannot_be_written_is_no_obstacle(tmp_path, monkeypatch):
    (tmp_path / "fw.c").write_text("int main(void) { for (;;) {} }\n")
    (tmp_path / "fw.toml").write_text('name = "fw"\nsources = ["fw.c"]\n')
    project = load_project(tmp_path / "fw.toml")
    assert folder_of(project) == tmp_path / ".wheelbench" / "fw"
    shutil.rmtree(tmp_path / ".wheelbench")
    (tmp_path / ".wheelbench").write_text("in the way")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "passing"))
    (tmp_path / "passing").mkdir()
    assert folder_of(project).parent == tmp_path / "passing" / f"wheelbench-{os.getuid()}"


def test_a_sanitizer_names_its_finding_and_its_line(tmp_path):
    source = """
        #include "wheelbench.h"
        #include <stdlib.h>
        #include <string.h>
        static uint8_t frame[12];
        static volatile int count = 12, more = 5;
        static void past(uint8_t value) { frame[count] = value; }
        static void over(uint8_t value) { uint8_t *four = malloc(4); memset(four, value, more); frame[0] = four[1]; }
        int main(void) {
            for (uint8_t in;;)
                if (wb_uart_read(WB_RC, &in, 1)) { if (in == 'p') past(in); else over(in); }
        }
        """
    firmware = made(tmp_path, source, "sanitize = true\nflags = ['-fno-inline']\n")
    for order, says in (
        (b"p", "UndefinedBehaviorSanitizer watches: index 12 out of bounds for type 'uint8_t [12]' (fw.c:7)"),
        (b"o", "AddressSanitizer watches: heap-buffer-overflow in over (fw.c:8)"),
    ):
        base = firmware()
        base.step(0, b"", b"", ())
        with pytest.raises(ControllerFailed) as failed:
            base.step(1, order, b"", ())
        first, _, below = str(failed.value).partition("\n")
        assert first == f"fw.toml: at tick 1 (0.001 s) the firmware broke a rule that {says}"
        assert below.startswith("the sanitizer's own words:\n")


# --- time ------------------------------------------------------------------------------------------------------------


def test_a_loop_that_only_waits_for_a_flag_lets_time_pass(tmp_path):
    """No call of the bench's in it: the count of its blocks is what ends its millisecond."""
    source = """
        #include "wheelbench.h"
        static volatile int flag;
        static uint8_t n[8];
        void tick(void) { flag = 1; }
        int main(void) {
            for (;;) {
                while (!flag) {}
                flag = 0;
                n[0]++;
                wb_can_write(0x200, n, 8);
            }
        }
        """
    base = made(tmp_path, source, '[entry]\nevery_ms = "tick"\n')()
    sent = [base.step(tick, b"", b"", ())[0] for tick in range(50)]
    assert [frames[0][1][0] for frames in sent] == list(range(1, 51))


def test_waiting_with_a_time_limit_lasts_as_long_as_it_says(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        CAN_HandleTypeDef hcan1;
        static void report(int what) {
            CAN_TxHeaderTypeDef header = {.StdId = 0x100 + what, .DLC = 0};
            HAL_CAN_AddTxMessage(&hcan1, &header, 0, 0);
        }
        int main(void) {
            uint8_t byte;
            HAL_CAN_Start(&hcan1);
            for (uint32_t start = HAL_GetTick(); HAL_GetTick() - start < 7;) {}
            report(HAL_GetTick());
            HAL_Delay(5);
            report(HAL_GetTick());
            int status = HAL_UART_Receive(&huart1, &byte, 1, 10);
            report(0x40 + status);
            report(HAL_GetTick());
            status = HAL_UART_Receive(&huart1, &byte, 1, 100);
            report(0x40 + status);
            report(HAL_GetTick());
            for (;;) __WFI();
        }
        """
    source = source.replace("CAN_HandleTypeDef hcan1;", "CAN_HandleTypeDef hcan1;\nextern UART_HandleTypeDef huart1;")
    base = made(tmp_path, source, '[wires]\nrc = "huart1"\ncan = "hcan1"\n')()
    sent = [
        (tick, frame[0]) for tick in range(60) for frame in base.step(tick, b"x" if tick == 40 else b"", b"", ())[0]
    ]
    # HAL_Delay lasts a tick more than it is told, as the vendor's does; 3 is HAL_TIMEOUT.
    assert sent == [(7, 0x107), (13, 0x10D), (23, 0x143), (23, 0x117), (40, 0x140), (40, 0x128)]


def test_handlers_that_nobody_arms_hear_nothing(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        extern UART_HandleTypeDef huart1;
        extern CAN_HandleTypeDef hcan1;
        static uint8_t in[4], heard;
        void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart) {
            heard = in[0];
            if (in[0] != 'q')
                HAL_UART_Receive_IT(uart, in, 1);
        }
        int main(void) {
            CAN_TxHeaderTypeDef header = {.StdId = 0x200, .DLC = 1};
            HAL_UART_Receive_IT(&huart1, in, 1);
            for (;;) {
                HAL_CAN_AddTxMessage(&hcan1, &header, &heard, 0);
                if (HAL_GetTick() >= 3)
                    HAL_CAN_Start(&hcan1);
                __WFI();
            }
        }
        """
    base = made(tmp_path, source, '[wires]\nrc = "huart1"\ncan = "hcan1"\n')()
    sent = []
    for tick, byte in enumerate(b"abcdefqrst"):
        sent.append(base.step(tick, bytes((byte,)), b"", ())[0])
    assert sent[:4] == [()] * 4, "a controller that was not started is silent"
    assert b"".join(frames[0][1] for frames in sent[4:]) == b"efqqqq", "a reception that was not armed again is deaf"


def test_fdcan_carries_classic_frames(tmp_path, capsys):
    source = """
        #include "stm32g4xx_hal.h"
        FDCAN_HandleTypeDef hfdcan1;
        static uint8_t heard;
        void HAL_FDCAN_RxFifo0Callback(FDCAN_HandleTypeDef *can, uint32_t which) {
            FDCAN_RxHeaderTypeDef header;
            uint8_t data[8];
            while (HAL_FDCAN_GetRxFifoFillLevel(can, FDCAN_RX_FIFO0))
                if (HAL_FDCAN_GetRxMessage(can, FDCAN_RX_FIFO0, &header, data) == HAL_OK)
                    heard += header.Identifier & 0xF;
        }
        int main(void) {
            FDCAN_TxHeaderTypeDef header = {.Identifier = 0x200, .DataLength = FDCAN_DLC_BYTES_1};
            FDCAN_TxHeaderTypeDef old = {.Identifier = 0x1FF, .DataLength = 0x00020000};
            HAL_FDCAN_Init(&hfdcan1);
            HAL_FDCAN_Start(&hfdcan1);
            HAL_FDCAN_ActivateNotification(&hfdcan1, FDCAN_IT_RX_FIFO0_NEW_MESSAGE, 0);
            HAL_FDCAN_AddMessageToTxFifoQ(&hfdcan1, &old, (const uint8_t *)"ab");
            old.FDFormat = FDCAN_FD_CAN;
            HAL_FDCAN_AddMessageToTxFifoQ(&hfdcan1, &old, (const uint8_t *)"cd");
            for (;;) {
                HAL_FDCAN_AddMessageToTxFifoQ(&hfdcan1, &header, &heard);
                __WFI();
            }
        }
        """
    (tmp_path / "fw.c").write_text(textwrap.dedent(source))
    assert said(capsys, "dut", "init", tmp_path)[0] == 0
    assert 'fdcan = "hfdcan1"' in (tmp_path / "wheelbench.toml").read_text()
    base = firmware_of(tmp_path / "wheelbench.toml")()
    assert base.step(0, b"", b"", FEEDBACK)[0] == ((0x1FF, b"ab"), (0x200, b"\0")), "nobody listened yet"
    assert base.step(1, b"", b"", FEEDBACK)[0] == ((0x200, b"\x06"),)
    assert base.output().count("a frame in FD format was sent") == 1


def test_tasks_run_by_priority_and_queues_wake_them(tmp_path):
    source = """
        #include "FreeRTOS.h"
        #include "queue.h"
        #include "task.h"
        #include "wheelbench.h"
        static QueueHandle_t queue;
        static void put(int what) { wb_can_write(0x100 + what, (const uint8_t *)"", 0); }
        static void high(void *unused) {
            uint8_t item;
            for (;;) {
                if (xQueueReceive(queue, &item, 4) == pdTRUE) put(item);
                else put(0x77);
            }
        }
        static void low(void *unused) {
            vTaskDelay(2);
            for (uint8_t i = 1;; i++) {
                put(0x10 + i);
                xQueueSend(queue, &i, 0);
                put(0x20 + i);
                vTaskDelay(i < 3 ? 1 : 1000);
            }
        }
        static void busy(void *unused) { for (;;) {} }
        int main(void) {
            queue = xQueueCreate(2, 1);
            xTaskCreate(busy, "busy", 128, NULL, 0, NULL);
            xTaskCreate(low, "low", 128, NULL, 1, NULL);
            xTaskCreate(high, "high", 128, NULL, 2, NULL);
            vTaskStartScheduler();
        }
        """
    base = made(tmp_path, source)()
    sent = [(tick, frame[0] - 0x100) for tick in range(10) for frame in base.step(tick, b"", b"", ())[0]]
    assert sent == [
        (2, 0x11), (2, 1), (2, 0x21),
        (3, 0x12), (3, 2), (3, 0x22),
        (4, 0x13), (4, 3), (4, 0x23),
        (8, 0x77),
    ]  # fmt: skip


def test_a_fresh_firmware_remembers_nothing_and_comes_in_milliseconds(bad):
    bad().step(0, b"", b"", ())
    took_s, end = [], time.monotonic() + 60.0
    while len(took_s) < 20 or (min(took_s) >= 0.005 and time.monotonic() < end):  # more, where others have the machine
        begin = time.perf_counter()
        base = bad()
        frames, _ = base.step(0, b"", b"", FEEDBACK)
        took_s.append(time.perf_counter() - begin)
        assert frames[0][1] == b"\x01" + bytes(7), "its first millisecond"
        base.close()
    assert min(took_s) < 0.005, "usually one; the bar is in scripts/benchmark.py"


# --- the examples ----------------------------------------------------------------------------------------------------

STYLES = {
    "superloop": ("superloop", "uart12", "RC silent"),
    "interrupts": ("interrupts", "frsky-sbus", "failsafe flag"),
    "rtos": ("rtos", "flysky", "RC silent"),
}


@pytest.mark.parametrize("style", STYLES)
def test_the_matrix_finds_the_fault_of_an_example_and_nothing_in_the_mended_one(style):
    name, profile, red = STYLES[style]
    robot = load_robot("m2006", profile)
    loss = next(loss for loss in losses(robot) if loss.name == red)
    wrong = run_cell(robot, loss, "cruise", firmware_of(EXAMPLES / style / f"{name}.toml"))
    assert wrong.verdict == RED
    assert "drives again without having been armed" in wrong.why
    fixed = run_cell(robot, loss, "cruise", firmware_of(EXAMPLES / style / "fixed.toml"))
    assert (fixed.verdict, fixed.why) == ("ok", ())


SHORT = """
schema = 1
name = "short"
seconds = 1.0
[[stick]]
at_s = 0.1
aux1 = true
[[stick]]
at_s = 0.3
forward = 0.5
turn = 0.2
"""


def test_a_recording_is_the_same_in_another_process_with_another_hash_seed(tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    runs = []
    for seed in ("1", "2"):
        command = [sys.executable, "-m", "bench", "replay", "short.toml", "--record", seed, "--json"]
        command += ["--controller", str(EXAMPLES / "superloop" / "fixed.toml")]
        environment = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["path_m"] > 0.05
        runs.append({path.name: path.read_bytes() for path in (tmp_path / seed).iterdir()})
    assert runs[0] == runs[1]
    assert b"200#" in runs[0]["can.log"]
    assert b'controller = "fixed.toml"' in runs[0]["run.toml"]


def test_what_a_firmware_prints_is_told_after_the_run(tmp_path, capsys):
    source = """
        #include "stm32f4xx_hal.h"
        #include <stdio.h>
        UART_HandleTypeDef huart2; /* a console */
        int main(void) {
            printf("boot %d\\n", 7);
            HAL_UART_Transmit(&huart2, (const uint8_t *)"over a UART\\n", 12, 10);
            for (;;) __WFI();
        }
        """
    made(tmp_path, source)
    (tmp_path / "short.toml").write_text(SHORT)
    given = ("replay", tmp_path / "short.toml", "--controller", tmp_path / "fw.toml")
    out = said(capsys, *given)[1]
    assert "said      boot 7\n          over a UART\n" in out
    assert json.loads(said(capsys, *given, "--json")[1])["output"] == "boot 7\nover a UART\n"


def test_a_pytest_of_the_teams_own_takes_it(tmp_path):
    (tmp_path / "conftest.py").write_text(
        "import pytest\n"
        "from bench.dut.firmware import firmware_of\n"
        "@pytest.fixture\n"
        f"def controller():\n    return firmware_of({str(EXAMPLES / 'superloop' / 'fixed.toml')!r})\n"
    )
    (tmp_path / "test_mine.py").write_text(
        "def test_it_drives_forward(bench, rc, plant):\n"
        "    rc.arm().hold(forward=0.5).run(0.8)\n"
        "    assert plant.twist.vx_mps > 0.2\n"
    )
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "1 passed" in done.stdout, done.stdout


def test_odometry_of_the_example_is_the_robots_own_way(tmp_path, capsys):
    """The core's answers add up to where the plant has gone: the example's own inverse is right."""
    (tmp_path / "core.toml").write_text(
        'schema = 1\nname = "core"\nseconds = 3.0\n[[stick]]\nat_s = 0.0\n[[stick]]\nat_s = 0.2\naux1 = true\n'
        "[[stick]]\nat_s = 0.4\n[[core]]\nat_s = 1.2\nvx_mps = 0.2\nvy_mps = 0.1\nomega_radps = 0.5\n"
        "[[core]]\nat_s = 2.3\n"
    )
    given = ("--controller", EXAMPLES / "superloop" / "fixed.toml", "--record", tmp_path / "run", "--json")
    status, out, _ = said(capsys, "replay", tmp_path / "core.toml", *given)
    assert status == 0
    assert json.loads(out)["path_m"] > 0.2
    x = y = heading = 0.0
    decoder = FrameDecoder()
    for _, answer in sorted(Recording.open(tmp_path / "run").base_to_core.items()):
        for event in decoder.feed(answer, 0):
            if len(getattr(event, "payload", b"")) != 13:
                continue
            dx, dy, turn_deg = (
                int.from_bytes(event.payload[at : at + 4], "little", signed=True) / 65536 for at in (0, 4, 8)
            )
            middle = heading + math.radians(turn_deg) / 2
            x += (dx * math.cos(middle) - dy * math.sin(middle)) / 1000
            y += (dx * math.sin(middle) + dy * math.cos(middle)) / 1000
            heading += math.radians(turn_deg)
    end = json.loads(out)["end"]
    assert (x, y, heading) == pytest.approx(end, abs=0.003)


def driven_by_keys():
    """(bench, session): a firmware, armed and driven."""
    fixed = firmware_of(EXAMPLES / "superloop" / "fixed.toml")
    keyboard = Keyboard(M2006.rc)
    bench = Bench(fixed(M2006), simulated(M2006).world)
    link = InlineLink(bench, keyboard.inputs, Granted(), remembers=True)
    session = Session(link, keyboard=keyboard)
    pass_ticks(session, 300)
    session.key("enter")
    pass_ticks(session, 300)
    for _ in range(20):
        session.key("w")
        pass_ticks(session, 30)
    assert bench.snapshot().twist.vx_mps > 0.2
    return bench, session


def test_the_dashboard_shows_its_wires_and_the_truth(tmp_path):
    """Nothing is told of it that only our own base would know."""
    bench, session = driven_by_keys()
    scene = session.scene()
    assert scene.snapshot.pose.x_m > 0.05, "it drives"
    assert scene.snapshot.rc_frames == bench.now_tick // 10
    for page in PAGES:  # the line of every page, and the page for little room
        for size in ((100, 30), (60, 16), (40, 12)):
            shown = "\n".join(picture(replace(scene, shown=Shown(page)), *size))
            assert " FOREIGN BASE " in shown
            assert "ENTER AUX1" in shown
            assert not re.search("(?i)disarm| armed", shown)
            assert ("only the base itself" in shown) is (page == "drive" and size != (40, 12))
    session.key("space")
    assert "whether it is armed only the base knows" in session.scene().notice
    text = ["".join(word for word, _ in line) for panel in (status, wheels) for line in panel(scene, 100, 20)]
    assert any("FOREIGN BASE  seen by its wires" in line for line in text), text
    assert any("odo off" in line and "mm" not in line for line in text)
    assert any(line.startswith(" front right       - ") for line in text)
    assert not any("ARMED" in line or "robot-centric" in line for line in text)


def test_firmware_loses_its_link_where_the_terminal_has_been_silent_for_a_second():
    """Only it knows whether it is armed: its own watch over the link is what stops it for good."""
    bench, session = driven_by_keys()
    session.silence(ABANDONED_MS)
    pass_ticks(session, 100)
    assert bench.world.plant.currents_a != [0.0] * 3, "it is powered still"
    session.silence(ABANDONED_MS + 1)
    pass_ticks(session, M2006.link.disarm_ms + 200)
    assert max(map(abs, bench.world.plant.currents_a)) < 1e-6


def test_whoever_leaves_leaves_firmware_at_rest():
    """Only it knows whether it is armed: the sticks are at rest for as long as any base takes."""
    bench, session = driven_by_keys()
    session.leave()
    assert session.over
    assert bench.snapshot().twist.vx_mps == pytest.approx(0.0, abs=0.01)


def test_in_the_dashboard_firmware_pauses_and_steps_on_and_says_that_it_does_not_go_back(tmp_path):
    """Every key of time: one sentence each, and the run goes on."""
    fixed = firmware_of(EXAMPLES / "superloop" / "fixed.toml")
    keyboard = Keyboard(M2006.rc)
    bench = Bench(fixed(M2006), simulated(M2006).world)
    job = Run("mine", bench, 0, keyboard.inputs, RunInfo(M2006.name, M2006.rc.name))
    stage = to_drive(job, keyboard, Granted())
    session = Session(stage.link, keyboard=keyboard, job=job, agree=stage.agree)
    link = session.link

    def said(key):
        session.key(key)
        return " ".join("\n".join(picture(session.scene(), 200, 60)[-3:]).split())

    pass_ticks(session, 300)
    assert ". one tick on · P go on" in said("p")
    session.key("p")
    assert "a foreign base cannot be taken back in time: P stands still and goes on, . steps on" in said(",")
    assert not link.paused
    session.key("p")
    for key in ("left", "up", "home", ","):
        assert "a foreign base cannot be taken back in time" in said(key), key
        assert link.now_tick == link.newest_tick == 300
    assert "so there is nothing to drive on from" in said("g")
    assert "no golden: a foreign base cannot be taken back in time" in said("b")
    assert "record it from its start: --record DIR" in said("r")
    session.key(".")
    assert link.newest_tick == 301
    session.key("p")
    pass_ticks(session, 50)
    assert link.newest_tick == 351
    assert session.failure is None


def test_a_crash_under_the_dashboard_is_the_same_sentence(bad):
    bench = Bench(bad(), simulated(M2006).world)
    link = InlineLink(bench, lambda tick: TickInput(b"n" if tick == 5 else b""), Granted())
    with pytest.raises(ControllerFailed, match="crashed: SIGSEGV"):
        link.run(100)


# --- dut init --------------------------------------------------------------------------------------------------------


def test_init_reads_a_firmwares_folder_and_what_it_writes_runs(tmp_path, capsys):
    folder = tmp_path / "mine"
    shutil.copytree(EXAMPLES / "interrupts", folder, ignore=shutil.ignore_patterns("*.toml", ".wheelbench"))
    for path in (EXAMPLES / "common").iterdir():
        shutil.copy(path, folder)
    (folder / "Drivers").mkdir()
    (folder / "Drivers" / "stm32f4xx_hal_can.c").write_text("#error not here\n")
    (folder / "system_stm32f4xx.c").write_text("#error nor here\n")
    before = {path.name: path.read_bytes() for path in folder.glob("*.[ch]")}
    status, out, _ = said(capsys, "dut", "init", folder)
    assert status == 0
    assert "5 sources of yours, style interrupt" in out
    text = (folder / "wheelbench.toml").read_text()
    for line in ('rc = "huart1"', 'slamware = "huart6"', 'can = "hcan1"', 'handle = "htim6"'):
        assert line in text
    assert all((folder / name).read_bytes() == content for name, content in before.items()), "not a byte is changed"
    status, out, error = said(capsys, "dut", "build", folder / "wheelbench.toml")
    assert (status, error) == (0, "")
    assert isinstance(firmware_of(folder / "wheelbench.toml")(), FirmwareBase)
    status, _, error = said(capsys, "dut", "init", folder)
    assert status == 2
    assert "is there already; remove it, or go on with it" in error


def test_init_gives_an_empty_folder_something_to_begin_with(tmp_path, capsys):
    status, out, _ = said(capsys, "dut", "init", tmp_path / "new", "--json")
    assert status == 0
    assert json.loads(out)["sources"] == []
    given = ("--controller", tmp_path / "new" / "wheelbench.toml", "--only", "RC silent", "--jobs", "1")
    status, out, _ = said(capsys, "failsafe", *given)
    assert status == 1
    assert "RC silent         ok 0 ms     RED" in out
