"""A team's folder as a generator leaves it, from `dut init` to a robot that drives; and words where it stumbles."""

import json
import shutil
import textwrap
from pathlib import Path

import pytest
from compilers import needs_compiler

from bench.__main__ import main
from bench.dut.build import build
from bench.dut.firmware import firmware_of
from bench.dut.project import load_project
from bench.dut.start import look

TEAM = Path(__file__).parent / "firmware" / "team"
DRIVE = """
schema = 1
name = "forward"
seconds = 1.5
[[stick]]
at_s = 0.0
[[stick]]
at_s = 0.3
forward = 0.5
"""

pytestmark = needs_compiler


def said(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    out = capsys.readouterr()
    return status, out.out, out.err


def made(folder, source, toml=""):
    (folder / "fw.c").write_text(textwrap.dedent(source))
    (folder / "fw.toml").write_text(f'schema = 1\nname = "fw"\nsources = ["fw.c"]\n{toml}')
    return folder / "fw.toml"


def test_a_generators_folder_is_guessed_compiles_without_a_word_and_drives(tmp_path, capsys):
    folder = tmp_path / "team"
    shutil.copytree(TEAM, folder, ignore=shutil.ignore_patterns(".wheelbench"))
    status, out, _ = said(capsys, "dut", "init", folder)
    assert status == 0
    assert "7 sources of yours, style interrupt; left to the bench: 2 files" in out
    assert f"failsafe --controller {folder / 'wheelbench.toml'} --profile dr16    # your receiver, by a guess" in out
    project = folder / "wheelbench.toml"
    text = project.read_text()
    assert 'rc = "huart1"\n# slamware = "h..."\ncan = "hcan1"\n# huart3 is no wire: printf goes there' in text
    assert build(load_project(project)).warnings == ""
    (folder / "drive.toml").write_text(DRIVE)
    given = ("--controller", project, "--profile", folder / "level.toml", "--record", tmp_path / "run", "--json")
    status, out, _ = said(capsys, "replay", folder / "drive.toml", *given)
    assert status == 0
    assert json.loads(out)["path_m"] > 0.3
    x_m, y_m, _ = json.loads(out)["end"]
    assert (x_m > 0.3, abs(y_m) < 0.01) == (True, True), "forward is forward"
    log = (tmp_path / "run" / "firmware.log").read_text()
    assert log.startswith("(0.020000) | SSL robot 2026 ready\n"), "20 ms by the cycle counter"
    assert log.count("HAL_ADC_GetValue gives 0 here; define it in wheelbench_port.c") == 1


def test_what_the_port_file_gives_is_what_an_adc_reads(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        ADC_HandleTypeDef hadc1;
        extern CAN_HandleTypeDef hcan1;
        uint32_t HAL_ADC_GetValue(ADC_HandleTypeDef *adc) { (void)adc; return 0xAB; }
        int main(void) {
            CAN_TxHeaderTypeDef header = {.StdId = 0x123, .DLC = 2};
            uint8_t data[2] = {0, 7};
            I2C_HandleTypeDef i2c = {0};
            HAL_CAN_Start(&hcan1);
            data[0] = HAL_ADC_GetValue(&hadc1);
            HAL_I2C_Mem_Read(&i2c, 0x68, 0x75, 1, data + 1, 1, 10);
            HAL_CAN_AddTxMessage(&hcan1, &header, data, 0);
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source, '[wires]\ncan = "hcan1"\n'))()
    assert base.step(0, b"", b"", ())[0] == ((0x123, b"\xab\0"),)
    assert base.output() == "wheelbench: SPI and I2C read 0 here, nobody is there; define the HAL's call in " + (
        "wheelbench_port.c to answer\n"
    )


def test_a_cycle_counter_runs_in_virtual_time_and_may_be_set(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        extern CAN_HandleTypeDef hcan1;
        static void report(int what) {
            CAN_TxHeaderTypeDef header = {.StdId = what, .DLC = 0};
            HAL_CAN_AddTxMessage(&hcan1, &header, 0, 0);
        }
        int main(void) {
            HAL_CAN_Start(&hcan1);
            for (uint32_t start = DWT->CYCCNT; DWT->CYCCNT - start < 168000 * 5;) {}
            report(1);
            DWT->CYCCNT = 0;
            while (DWT->CYCCNT < 168000 * 3) {}
            report(2);
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source, '[wires]\ncan = "hcan1"\n'))()
    sent = [(tick, frame[0]) for tick in range(20) for frame in base.step(tick, b"", b"", ())[0]]
    assert sent == [(5, 1), (8, 2)]


@pytest.mark.parametrize(
    ("source", "says"),
    [
        ('#include "arm_math.h"\n', "no arm_math.h: add the folder to include =, or write a small header of that name"),
        (
            '#include "stm32f4xx_hal.h"\nint unused(void) { int x; return 1; }\nint main(void) { TIM2->CR1 |= 1; }\n',
            "a file that sets up registers belongs to the board: name it in leave_out =",
        ),
    ],
)
def test_what_a_first_build_stumbles_over_is_told_with_what_to_try(tmp_path, capsys, source, says):
    status, _, error = said(capsys, "dut", "build", made(tmp_path, source))
    assert status == 2
    assert says in error
    assert "warning" not in error, "the errors alone"


@pytest.mark.parametrize(
    ("text", "profile"),
    [("DBUS frame", "dr16"), ("sbus_parse(); SBUS", "frsky-sbus"), ("iBus", "flysky"), ("crsf", "elrs"), ("radio", "")],
)
def test_the_receiver_is_guessed_from_what_the_sources_speak_of(tmp_path, text, profile):
    (tmp_path / "main.c").write_text(f"/* {text} */\nint main(void) {{}}\n")
    assert look(tmp_path).receiver == profile
