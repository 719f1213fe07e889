"""A team's folder as a generator leaves it, from `dut init` to a robot that drives; and words where it stumbles."""

import json
import os
import shutil
import textwrap
from pathlib import Path

import pytest
from compilers import needs_compiler

from bench.__main__ import main
from bench.check.failsafe import losses, run_row
from bench.config import load_robot
from bench.dut.build import build
from bench.dut.firmware import firmware_of
from bench.dut.project import load_project
from bench.dut.start import look, start

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

CORE_SILENT = [loss.name for loss in losses(load_robot("m2006"))].index("core silent")

pytestmark = needs_compiler


def said(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    out = capsys.readouterr()
    return status, out.out, out.err


def made(folder, source, toml=""):
    (folder / "fw.c").write_text(textwrap.dedent(source))
    (folder / "fw.toml").write_text(f'schema = 1\nname = "fw"\nsources = ["fw.c"]\n{toml}')
    return folder / "fw.toml"


def test_a_folder_whose_name_is_no_text_is_begun_and_compiled(tmp_path, capsys):
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    status, _, err = said(capsys, "dut", "init", folder)
    assert (status, err) == (0, "")
    status, _, err = said(capsys, "dut", "build", folder / "wheelbench.toml")
    assert (status, err) == (0, "")
    (folder / os.fsdecode(b"\xe9.c")).write_text("int x;\n")
    for path in folder.glob("*.toml"):
        path.unlink()
    status, out, err = said(capsys, "dut", "init", folder)
    assert (status, out) == (2, "")
    assert "a file's name is not UTF-8" in err


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
    assert (tmp_path / "run" / "slamware.log").read_text() == "", (
        "no core stands beside a firmware that has no line for it"
    )
    x_m, y_m, _ = json.loads(out)["end"]
    assert (x_m > 0.3, abs(y_m) < 0.01) == (True, True), "forward is forward"
    rows = run_row(load_robot("m2006", str(folder / "level.toml")), CORE_SILENT, str(project))
    assert {(cell.verdict, cell.why) for cell in rows} == {
        ("off", ("the firmware has no core: slamware is not among its [wires]",))
    }
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


H7 = """
    #include "stm32h7xx_hal.h"
    FDCAN_HandleTypeDef hfdcan1;
    UART_HandleTypeDef huart5, huart10;
    DMA_HandleTypeDef hdma_uart5_rx;
    typedef enum { PWR_GOOD, RCC_MINE_LOST } power_t;        /* a team's own names */
    static const uint8_t RCC_MINE = 3, RCC_MINE_TOO[2] = {4, 5};
    #define GPIO_AF7_MINE 6
    #define __HAL_RCC_MINE_ENABLE() (GPIO_AF7_MINE)
    void SystemClock_Config(void) {
        RCC_OscInitTypeDef RCC_OscInitStruct = {0};
        RCC_ClkInitTypeDef RCC_ClkInitStruct = {0};
        MPU_Region_InitTypeDef region = {.Enable = MPU_REGION_ENABLE, .Number = MPU_REGION_NUMBER0,
            .Size = MPU_REGION_SIZE_4GB, .DisableExec = MPU_INSTRUCTION_ACCESS_DISABLE, 
            .IsCacheable = MPU_ACCESS_NOT_CACHEABLE};
        HAL_MPU_Disable();
        HAL_MPU_ConfigRegion(&region);
        HAL_MPU_Enable(MPU_PRIVILEGED_DEFAULT);
        SCB_EnableDCache();
        HAL_PWREx_ConfigSupply(PWR_LDO_SUPPLY);
        __HAL_PWR_VOLTAGESCALING_CONFIG(PWR_REGULATOR_VOLTAGE_SCALE0);
        while (!__HAL_PWR_GET_FLAG(PWR_FLAG_VOSRDY)) {}
        RCC_OscInitStruct.OscillatorType = RCC_OSCILLATORTYPE_HSI48 | RCC_OSCILLATORTYPE_HSE;
        RCC_OscInitStruct.HSI48State = RCC_HSI48_ON;
        RCC_OscInitStruct.PLL.PLLRGE = RCC_PLL1VCIRANGE_3;
        if (HAL_RCC_OscConfig(&RCC_OscInitStruct) != HAL_OK) for (;;) {}
        RCC_ClkInitStruct.ClockType = RCC_CLOCKTYPE_HCLK | RCC_CLOCKTYPE_D3PCLK1;
        RCC_ClkInitStruct.APB4CLKDivider = RCC_APB4_DIV2;
        if (HAL_RCC_ClockConfig(&RCC_ClkInitStruct, FLASH_LATENCY_3) != HAL_OK) for (;;) {}
    }
    void HAL_UART_MspInit(UART_HandleTypeDef *uart) {
        GPIO_InitTypeDef pins = {.Mode = GPIO_MODE_AF_PP, .Alternate = GPIO_AF14_UART5};
        RCC_PeriphCLKInitTypeDef clock = {0};
        clock.PeriphClockSelection = RCC_PERIPHCLK_UART5;
        clock.Usart234578ClockSelection = RCC_USART234578CLKSOURCE_D2PCLK1;
        HAL_RCCEx_PeriphCLKConfig(&clock);
        __HAL_RCC_UART5_CLK_ENABLE();
        __HAL_RCC_GPIOB_CLK_ENABLE();
        HAL_GPIO_Init(GPIOB, &pins);
        hdma_uart5_rx.Instance = DMA2_Stream0;
        hdma_uart5_rx.Init.Request = DMA_REQUEST_UART5_RX;
        hdma_uart5_rx.Init.Mode = DMA_CIRCULAR;
        __HAL_LINKDMA(uart, hdmarx, hdma_uart5_rx);
        HAL_NVIC_EnableIRQ(UART5_IRQn);
    }
    void HAL_UART_MspDeInit(UART_HandleTypeDef *uart) {
        __HAL_RCC_UART5_CLK_DISABLE();
        HAL_DMA_DeInit(uart->hdmarx);
    }
    int main(void) {
        SystemClock_Config();
        hfdcan1.Init.FrameFormat = FDCAN_FRAME_CLASSIC;
        huart10.Instance = USART10;
        huart5.Instance = UART5;
        huart5.Init.OneBitSampling = UART_ONE_BIT_SAMPLE_DISABLE;
        huart5.Init.ClockPrescaler = UART_PRESCALER_DIV1;
        huart5.AdvancedInit.AdvFeatureInit = UART_ADVFEATURE_NO_INIT;
        HAL_UART_Init(&huart5);
        HAL_UARTEx_SetRxFifoThreshold(&huart5, UART_RXFIFO_THRESHOLD_1_8);
        HAL_UARTEx_DisableFifoMode(&huart5);
        for (;;) __WFI();
        return PWR_GOOD + RCC_MINE_LOST + RCC_MINE + RCC_MINE_TOO[1] + __HAL_RCC_MINE_ENABLE();
    }
    """
G4 = """
    #include "stm32g4xx_hal.h"
    FDCAN_HandleTypeDef hfdcan1;
    UART_HandleTypeDef huart5;
    TIM_HandleTypeDef htim17;
    void HAL_MspInit(void) {
        __HAL_RCC_SYSCFG_CLK_ENABLE();
        HAL_PWREx_DisableUCPDDeadBattery();
    }
    void HAL_FDCAN_MspInit(FDCAN_HandleTypeDef *can) {
        RCC_PeriphCLKInitTypeDef clock = {0};
        clock.PeriphClockSelection = RCC_PERIPHCLK_FDCAN;
        clock.FdcanClockSelection = RCC_FDCANCLKSOURCE_PCLK1;
        (void)can;
        HAL_RCCEx_PeriphCLKConfig(&clock);
        HAL_NVIC_EnableIRQ(FDCAN1_IT0_IRQn);
    }
    int main(void) {
        TIM_MasterConfigTypeDef master = {.MasterOutputTrigger2 = TIM_TRGO2_RESET};
        TIM_BreakDeadTimeConfigTypeDef dead = {.OffStateRunMode = TIM_OSSR_DISABLE,
            .BreakAFMode = TIM_BREAK_AFMODE_INPUT, .Break2Polarity = TIM_BREAK2POLARITY_HIGH,
            .AutomaticOutput = TIM_AUTOMATICOUTPUT_DISABLE};
        DMA_HandleTypeDef dma = {.Instance = DMA1_Channel1};
        HAL_Init();
        HAL_PWREx_ControlVoltageScaling(PWR_REGULATOR_VOLTAGE_SCALE1_BOOST);
        htim17.Instance = TIM17;
        HAL_TIMEx_MasterConfigSynchronization(&htim17, &master);
        HAL_TIMEx_ConfigBreakDeadTime(&htim17, &dead);
        HAL_FDCAN_Init(&hfdcan1);
        for (;;) __WFI();
        return dma.Instance == DMA1_Channel1;
    }
    """
F1 = """
    #include "stm32f1xx_hal.h"
    CAN_HandleTypeDef hcan;
    UART_HandleTypeDef huart5;
    void HAL_CAN_MspInit(CAN_HandleTypeDef *can) {
        GPIO_InitTypeDef pin = {.Mode = GPIO_MODE_AF_INPUT};
        (void)can;
        __HAL_RCC_CAN1_CLK_ENABLE();
        HAL_GPIO_Init(GPIOA, &pin);
        __HAL_AFIO_REMAP_SWJ_NOJTAG();
        __HAL_DBGMCU_FREEZE_TIM1();
        HAL_NVIC_EnableIRQ(USB_LP_CAN1_RX0_IRQn);
    }
    void HAL_CAN_MspDeInit(CAN_HandleTypeDef *can) {
        (void)can;
        __HAL_RCC_CAN1_CLK_DISABLE();
    }
    int main(void) { for (;;) __WFI(); }
    """


SETTINGS = """
    #include "stm32h7xx_hal.h"
    #include <stdint.h>
    ADC_HandleTypeDef hadc1;
    SPI_HandleTypeDef hspi2;
    I2C_HandleTypeDef hi2c3;
    CRC_HandleTypeDef hcrc;
    RNG_HandleTypeDef hrng;
    RTC_HandleTypeDef hrtc;
    TIM_HandleTypeDef htim8;
    CAN_HandleTypeDef hcan1;
    static const uint32_t TIM_MINE = 7;
    int main(void) {
        ADC_MultiModeTypeDef multimode = {0};
        ADC_ChannelConfTypeDef sConfig = {0};
        RTC_TimeTypeDef sTime = {0};
        RTC_DateTypeDef sDate = {0};
        hadc1.Instance = ADC1;
        hadc1.Init.ClockPrescaler = ADC_CLOCK_ASYNC_DIV16;
        hadc1.Init.Resolution = ADC_RESOLUTION_16B;
        hadc1.Init.LowPowerAutoWait = DISABLE;
        hadc1.Init.ConversionDataManagement = ADC_CONVERSIONDATA_DMA_CIRCULAR;
        multimode.Mode = ADC_MODE_INDEPENDENT;
        sConfig.SamplingTime = ADC_SAMPLETIME_16CYCLES_5;
        sConfig.OffsetSignedSaturation = DISABLE;
        if (HAL_ADC_Init(&hadc1) + HAL_ADCEx_MultiModeConfigChannel(&hadc1, &multimode) != HAL_OK) return 1;
        HAL_ADC_ConfigChannel(&hadc1, &sConfig);
        HAL_ADCEx_Calibration_Start(&hadc1, ADC_CALIB_OFFSET, ADC_SINGLE_ENDED);
        hspi2.Init.NSSPMode = SPI_NSS_PULSE_DISABLE;
        hspi2.Init.IOSwap = SPI_IO_SWAP_DISABLE;
        hi2c3.Init.AnalogFilter = I2C_ANALOGFILTER_ENABLE;
        hcrc.Instance = CRC;
        hcrc.Init.DefaultPolynomialUse = DISABLE;
        HAL_CRC_Init(&hcrc);
        hrng.Instance = RNG;
        HAL_RNG_Init(&hrng);
        hrtc.Init.HourFormat = RTC_HOURFORMAT_24;
        hrtc.Init.AsynchPrediv = 127;
        sTime.DayLightSaving = RTC_DAYLIGHTSAVING_NONE;
        sDate.Month = RTC_MONTH_JANUARY;
        HAL_RTC_SetTime(&hrtc, &sTime, RTC_FORMAT_BCD);
        HAL_RTC_SetDate(&hrtc, &sDate, RTC_FORMAT_BCD);
        htim8.Init.CounterMode = TIM_COUNTERMODE_CENTERALIGNED1;
        htim8.Init.RepetitionCounter = TIM_MINE;                               /* the team's own */
        hcan1.Init.TimeSeg1 = CAN_BS1_8TQ;
        for (;;) __WFI();
    }
    """


@pytest.mark.parametrize("source", [H7, G4, F1, SETTINGS], ids=["H7", "G4", "F1", "settings"])
def test_what_a_generator_sets_up_on_any_family_compiles_without_a_word(tmp_path, source):
    project = load_project(made(tmp_path, source, '[wires]\nrc = "huart5"\n'))
    assert build(project).warnings == ""
    assert not build(project).is_new


@pytest.mark.parametrize(
    ("named", "at", "toml"),
    [
        ("Inc/board.h", "Inc/board.h", ""),
        ("pins/board.h", "lib/pins/board.h", 'include = ["lib"]\n'),
        ("board.h", "more/board.h", 'flags = ["-Imore"]\n'),
        ("board.inc", "board.inc", ""),
    ],
)
def test_names_of_a_chips_set_up_are_read_in_whatever_header_the_compiler_finds(tmp_path, monkeypatch, named, at, toml):
    """And in no other: an older board's header beside it has names of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / at).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / at).write_text("#define RC_PIN_AF GPIO_AF8_UART5\n")
    (tmp_path / "old_board.h").write_text("#define GPIO_AF8_UART5 8\n")
    source = f"""
        #include "stm32f4xx_hal.h"
        #include "{named}"
        int main(void) {{ for (;;) __WFI(); return RC_PIN_AF; }}
        """
    assert build(load_project(made(tmp_path, source, toml))).warnings == ""


@pytest.mark.parametrize("ending", ["c", "cpp"])
def test_a_team_that_defines_the_types_of_stdint_itself_is_let(tmp_path, ending):
    """As Keil's compiler does, and the maker's own code needs it."""
    (tmp_path / "struct_typedef.h").write_text(
        "typedef signed char int8_t;\ntypedef signed short int int16_t;\ntypedef signed int int32_t;\n"
        "typedef signed long long int64_t;\ntypedef unsigned char uint8_t;\ntypedef unsigned short int uint16_t;\n"
        "typedef unsigned int uint32_t;\ntypedef unsigned long long uint64_t;\ntypedef float fp32;\n"
    )
    standard = "#include <stdint.h>\n" if ending == "c" else "#include <chrono>\n#include <cstdint>\n"
    (tmp_path / f"fw.{ending}").write_text(
        f'#include "struct_typedef.h"\n#include "stm32f4xx_hal.h"\n{standard}#include <stdlib.h>\n'
        "extern CAN_HandleTypeDef hcan1;\n"
        "int main(void) {\n    uint64_t wide = (uint64_t)1 << 40;\n    CAN_TxHeaderTypeDef header = {.StdId = 0x100};\n"
        "    header.DLC = sizeof(int64_t) + (wide >> 40) - 1;\n    HAL_CAN_Start(&hcan1);\n"
        "    HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)&wide, 0);\n    for (;;) __WFI();\n}\n"
    )
    (tmp_path / "fw.toml").write_text(f'schema = 1\nname = "fw"\nsources = ["fw.{ending}"]\n[wires]\ncan = "hcan1"\n')
    project = load_project(tmp_path / "fw.toml")
    assert build(project).warnings == ""
    assert firmware_of(project.path)().step(0, b"", b"", ())[0] == ((0x100, (1 << 40).to_bytes(8, "little")),)


def test_handles_of_any_number_are_wires(tmp_path):
    source = """
        #include "stm32g0xx_hal.h"
        extern UART_HandleTypeDef huart9;
        UART_HandleTypeDef huart4;
        int main(void) {
            huart4.Instance = USART4;                                      /* a USART on a G0, a UART on an F4 */
            for (;;) __WFI();
            return huart4.Instance == UART4 && huart9.Instance == UART9;
        }
        """
    toml = '[wires]\nrc = "huart9"\nslamware = "huart"\nfdcan = "hfdcan"\n' + "".join(
        f'[[timer]]\nhandle = "{handle}"\n' for handle in ("htim", "htim20", "htim24")
    )
    assert build(load_project(made(tmp_path, source, toml))).warnings == ""


HALVES = """
    #include "stm32f4xx_hal.h"
    extern UART_HandleTypeDef huart1;
    extern CAN_HandleTypeDef hcan1;
    DMA_HandleTypeDef dma = {.Init.Mode = MODE};
    static uint8_t in[8];
    static void heard(UART_HandleTypeDef *uart, uint16_t size) {
        CAN_TxHeaderTypeDef header = {.StdId = 0x100 + size, .DLC = 1};
        uint8_t what = HAL_UARTEx_GetRxEventType(uart);
        HAL_CAN_AddTxMessage(&hcan1, &header, &what, 0);
    }
    int main(void) {
        HAL_CAN_Start(&hcan1);
        __HAL_LINKDMA(&huart1, hdmarx, dma);
        HAL_UART_RegisterRxEventCallback(&huart1, heard);
        HAL_UARTEx_ReceiveToIdle_DMA(&huart1, in, sizeof in);
        AFTER;
        for (;;) __WFI();
    }
    """
TOLD_FULL, TOLD_HALF, TOLD_IDLE = b"\0", b"\1", b"\2"


@pytest.mark.parametrize(
    ("mode", "after", "told"),
    [
        # Reference manuals and the HAL's documentation: a DMA tells its half, unless that interrupt is switched off.
        ("DMA_NORMAL", "", [(1, 0x104, TOLD_HALF), (2, 0x105, TOLD_IDLE)]),
        ("DMA_NORMAL", "__HAL_DMA_DISABLE_IT(&dma, DMA_IT_HT)", [(2, 0x105, TOLD_IDLE)]),
        (
            "DMA_CIRCULAR",
            "",
            [(1, 0x104, TOLD_HALF), (2, 0x105, TOLD_IDLE), (3, 0x108, TOLD_FULL), (4, 0x102, TOLD_IDLE)],
        ),
    ],
)
def test_a_dma_tells_its_half_to_a_registered_callback_until_it_is_told_not_to(tmp_path, mode, after, told):
    source = HALVES.replace("MODE", mode).replace("AFTER", after)
    base = firmware_of(made(tmp_path, source, '[wires]\nrc = "huart1"\ncan = "hcan1"\n'))()
    line = {1: b"abcde", 3: b"fghij"}
    sent = [(tick, *frame) for tick in range(6) for frame in base.step(tick, line.get(tick, b""), b"", ())[0]]
    assert sent == told


def test_a_line_is_idle_once_and_only_after_a_byte(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        extern UART_HandleTypeDef huart1;
        extern CAN_HandleTypeDef hcan1;
        static uint8_t in[4];
        void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *uart, uint16_t size) {
            CAN_TxHeaderTypeDef header = {.StdId = size};
            HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)"", 0);
            HAL_UARTEx_ReceiveToIdle_IT(uart, in, sizeof in);
        }
        int main(void) {
            HAL_CAN_Start(&hcan1);
            HAL_UARTEx_ReceiveToIdle_IT(&huart1, in, sizeof in);
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source, '[wires]\nrc = "huart1"\ncan = "hcan1"\n'))()
    line = {1: b"full", 4: b"e"}
    told = [[can_id for can_id, _ in base.step(tick, line.get(tick, b""), b"", ())[0]] for tick in range(8)]
    assert told == [[], [4], [], [], [], [1], [], []]


BY_HAND = """
    #include "stm32f4xx_hal.h"
    extern UART_HandleTypeDef huart3;
    extern CAN_HandleTypeDef hcan1;
    static DMA_HandleTypeDef dma = {.Init.Mode = DMA_CIRCULAR};
    static uint8_t in[8];
    static void report(int what) {
        CAN_TxHeaderTypeDef header = {.StdId = what, .DLC = 8};
        HAL_CAN_AddTxMessage(&hcan1, &header, in, 0);
    }
    void HANDLER(void) {
        if (!__HAL_UART_GET_FLAG(&huart3, UART_FLAG_IDLE) || !__HAL_UART_GET_IT_SOURCE(&huart3, UART_IT_IDLE)) return;
        __HAL_UART_CLEAR_IDLEFLAG(&huart3);
        if (__HAL_UART_GET_FLAG(&huart3, UART_FLAG_IDLE)) return;
        report(0x100 + sizeof in - __HAL_DMA_GET_COUNTER(&dma));
        __HAL_DMA_DISABLE(&dma);
        __HAL_DMA_SET_COUNTER(&dma, sizeof in);
        __HAL_DMA_ENABLE(&dma);
    }
    int main(void) {
        HAL_CAN_Start(&hcan1);
        __HAL_LINKDMA(&huart3, hdmarx, dma);
        HAL_UART_Receive_DMA(&huart3, in, sizeof in);
        HAL_Delay(3);                                                 /* nobody has asked to be told */
        __HAL_UART_ENABLE_IT(&huart3, UART_IT_IDLE);
        HAL_Delay(6);
        __HAL_UART_DISABLE_IT(&huart3, UART_IT_IDLE);
        for (;;) __WFI();
    }
    """


@pytest.mark.parametrize("handler", ["USART3_IRQHandler", "UART3_IRQHandler", "HAL_nobody"])
def test_an_idle_line_is_told_to_a_handler_of_the_teams_own(tmp_path, handler):
    base = firmware_of(made(tmp_path, BY_HAND.replace("HANDLER", handler), '[wires]\nrc = "huart3"\ncan = "hcan1"\n'))()
    line = {1: b"ab", 4: b"cde", 5: b"f", 7: b"gh", 11: b"ij"}
    sent = [(tick, *frame) for tick in range(14) for frame in base.step(tick, line.get(tick, b""), b"", ())[0]]
    told = [(6, 0x106, b"abcdef\0\0"), (8, 0x102, b"ghcdef\0\0")]
    assert sent == ([] if handler == "HAL_nobody" else told)
    assert ("no source has the UART's interrupt handler" in base.output()) is (handler == "HAL_nobody")


def test_init_keeps_the_handlers_where_an_idle_line_is_heard_and_the_hals_ticks_go_on(tmp_path):
    """As a generator has it where the HAL's ticks come from a timer: SysTick is the scheduler's."""
    (tmp_path / "main.c").write_text(
        '#include "stm32f4xx_hal.h"\n#include "cmsis_os.h"\nUART_HandleTypeDef huart3;\nCAN_HandleTypeDef hcan1;\n'
        "static void run(void const *unused) { for (;;) osDelay(1000); }\n"
        "int main(void) {\n    CAN_TxHeaderTypeDef header = {.StdId = 0x123};\n    HAL_CAN_Start(&hcan1);\n"
        "    __HAL_UART_ENABLE_IT(&huart3, UART_IT_IDLE);\n    HAL_Delay(3);\n"
        '    HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)"", 0);\n'
        "    osThreadDef(run, run, osPriorityNormal, 0, 128);\n    osThreadCreate(osThread(run), NULL);\n"
        "    osKernelStart();\n}\n"
    )
    (tmp_path / "stm32f4xx_it.c").write_text(
        '#include "stm32f4xx_hal.h"\n#include "FreeRTOS.h"\n#include "task.h"\nextern UART_HandleTypeDef huart3;\n'
        "extern TIM_HandleTypeDef htim14;\nextern PCD_HandleTypeDef hpcd_USB_OTG_FS;\n"
        "void SysTick_Handler(void) {\n"
        "    if (xTaskGetSchedulerState() != taskSCHEDULER_NOT_STARTED) xPortSysTickHandler();\n}\n"
        "void TIM8_TRG_COM_TIM14_IRQHandler(void) { HAL_TIM_IRQHandler(&htim14); }\n"
        "void OTG_FS_IRQHandler(void) { HAL_PCD_IRQHandler(&hpcd_USB_OTG_FS); }\n"
        "void USART3_IRQHandler(void) { HAL_UART_IRQHandler(&huart3); }\n"
    )
    start(tmp_path)
    assert "htim14" not in (tmp_path / "wheelbench.toml").read_text(), "no timer that calls anything back"
    base = firmware_of(tmp_path / "wheelbench.toml")()
    assert [tick for tick in range(9) if base.step(tick, b"", b"", ())[0]] == [4]


def test_the_other_fifo_three_mailboxes_and_what_the_bus_does_not_carry(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        extern CAN_HandleTypeDef hcan1;
        static void report(int what) {
            CAN_TxHeaderTypeDef header = {.StdId = 0x100 + what};
            HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)"", 0);
        }
        static void heard(CAN_HandleTypeDef *can) {
            CAN_RxHeaderTypeDef header;
            uint8_t data[8];
            int other = HAL_CAN_GetRxFifoFillLevel(can, CAN_RX_FIFO0);
            int own = HAL_CAN_GetRxFifoFillLevel(can, CAN_RX_FIFO1);
            if (HAL_CAN_GetRxMessage(can, CAN_RX_FIFO0, &header, data) == HAL_ERROR &&
                HAL_CAN_GetRxMessage(can, CAN_RX_FIFO1, &header, data) == HAL_OK)
                report(other * 256 + own * 16 + (header.StdId & 0xF));
            if (header.StdId == 0x203) HAL_CAN_DeactivateNotification(can, CAN_IT_RX_FIFO1_MSG_PENDING);
        }
        int main(void) {
            CAN_TxHeaderTypeDef remote = {.StdId = 1, .RTR = CAN_RTR_REMOTE}, extended = {.IDE = CAN_ID_EXT};
            HAL_CAN_RegisterCallback(&hcan1, HAL_CAN_RX_FIFO1_MSG_PENDING_CB_ID, heard);
            HAL_CAN_Start(&hcan1);
            HAL_CAN_ActivateNotification(&hcan1, CAN_IT_RX_FIFO1_MSG_PENDING);
            HAL_CAN_AddTxMessage(&hcan1, &remote, (const uint8_t *)"", 0);
            HAL_CAN_AddTxMessage(&hcan1, &extended, (const uint8_t *)"", 0);
            for (int i = 0; i < 6; i++) report(HAL_CAN_GetTxMailboxesFreeLevel(&hcan1));
            report(HAL_CAN_GetTxMailboxesFreeLevel(&hcan1));
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source, '[wires]\ncan = "hcan1"\ncan_fifo = 1\n'))()
    frames = tuple((0x201 + motor, bytes(8)) for motor in range(4))
    told = [[can_id - 0x100 for can_id, _ in base.step(tick, b"", b"", frames)[0]] for tick in range(3)]
    assert told == [[3, 3, 3, 3, 3, 3, 2], [0x11, 0x12, 0x13], []], "what came before it began is lost"
    assert base.output().count("extended or remote CAN frame was sent") == 1


def test_a_mailbox_that_is_empty_again_is_told(tmp_path):
    """The STM32 HAL: after a frame has been sent, and where CAN_IT_TX_MAILBOX_EMPTY is asked for."""
    source = """
        #include "stm32f4xx_hal.h"
        extern CAN_HandleTypeDef hcan1;
        static uint32_t queued = 6, mailbox;
        static void next(int what) {
            CAN_TxHeaderTypeDef header = {.StdId = 0x100 + what};
            if (queued && queued--) HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)"", &mailbox);
        }
        void HAL_CAN_TxMailbox0CompleteCallback(CAN_HandleTypeDef *can) { next(can == &hcan1 ? 0 : 0x7F); }
        void HAL_CAN_TxMailbox1CompleteCallback(CAN_HandleTypeDef *can) { next(1); }
        static void third(CAN_HandleTypeDef *can) { next(2); }
        int main(void) {
            HAL_CAN_RegisterCallback(&hcan1, HAL_CAN_TX_MAILBOX2_COMPLETE_CB_ID, third);
            HAL_CAN_Start(&hcan1);
            next(0x10);
            HAL_Delay(2);                                                 /* nobody has asked to be told */
            HAL_CAN_ActivateNotification(&hcan1, CAN_IT_TX_MAILBOX_EMPTY);
            for (int i = 0; i < 3; i++) next(0x10 << (mailbox == 1u << (i ? i - 1 : 0)));
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source, '[wires]\ncan = "hcan1"\n'))()
    told = [[can_id - 0x100 for can_id, _ in base.step(tick, b"", b"", ())[0]] for tick in range(6)]
    assert told == [[0x10], [], [], [0x20, 0x20, 0x20], [0, 1], []]


def test_a_plain_dma_its_halves_and_a_timer_by_a_registered_callback(tmp_path):
    source = """
        #include "stm32f4xx_hal.h"
        extern UART_HandleTypeDef huart1;
        extern CAN_HandleTypeDef hcan1;
        extern TIM_HandleTypeDef htim6;
        static DMA_HandleTypeDef dma = {.Init.Mode = DMA_NORMAL};
        static uint8_t in[4];
        static void report(int what) {
            CAN_TxHeaderTypeDef header = {.StdId = what};
            HAL_CAN_AddTxMessage(&hcan1, &header, (const uint8_t *)"", 0);
        }
        void HAL_UART_RxHalfCpltCallback(UART_HandleTypeDef *uart) {
            report(0x10 + __HAL_DMA_GET_COUNTER(uart->hdmarx));
        }
        void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart) {
            report(0x20 + __HAL_DMA_GET_COUNTER(uart->hdmarx));
            __HAL_DMA_DISABLE_IT(&dma, DMA_IT_HT);
            HAL_UART_Receive_DMA(uart, in, sizeof in);                /* which lets the half be told again */
        }
        void HAL_TIM_Base_MspInit(TIM_HandleTypeDef *timer) { HAL_TIM_Base_Start_IT(timer); }
        static void elapsed(TIM_HandleTypeDef *timer) { report(0x30); }
        void HAL_MspInit(void) { __HAL_LINKDMA(&huart1, hdmarx, dma); }
        int main(void) {
            HAL_Init();
            HAL_CAN_Start(&hcan1);
            HAL_UART_Receive_DMA(&huart1, in, sizeof in);
            HAL_TIM_RegisterCallback(&htim6, HAL_TIM_PERIOD_ELAPSED_CB_ID, elapsed);
            HAL_TIM_Base_Init(&htim6);
            for (;;) __WFI();
        }
        """
    toml = '[wires]\nrc = "huart1"\ncan = "hcan1"\n[[timer]]\nhandle = "htim6"\nperiod_ms = 3\n'
    base = firmware_of(made(tmp_path, source, toml))()
    line = {1: b"ab", 2: b"cde", 4: b"f"}
    told = [[can_id for can_id, _ in base.step(tick, line.get(tick, b""), b"", ())[0]] for tick in range(6)]
    assert told == [[], [0x12], [0x20], [0x30], [0x12], []]


def test_init_keeps_the_file_that_links_a_uart_to_its_dma(tmp_path):
    for name in ("main.c", "stm32f4xx_hal_msp.c", "stm32f4xx_it.c", "stm32f4xx_hal_timebase_tim.c"):
        (tmp_path / name).write_text("")
    assert look(tmp_path).sources == ("main.c", "stm32f4xx_hal_msp.c")


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


def test_what_is_sent_by_dma_is_sent_when_its_callback_says_so_and_not_before(tmp_path):
    """The STM32 HAL: HAL_BUSY while it goes on. A console is a UART like any other."""
    source = """
        #include "stm32f4xx_hal.h"
        UART_HandleTypeDef huart3;
        static volatile int sent;
        static void second(UART_HandleTypeDef *uart) { sent += uart == &huart3; }
        void HAL_UART_TxCpltCallback(UART_HandleTypeDef *uart) {
            sent += uart == &huart3;
            HAL_UART_Transmit_DMA(&huart3, (const uint8_t *)"c", 1);
            HAL_UART_RegisterCallback(&huart3, HAL_UART_TX_COMPLETE_CB_ID, second);
        }
        int main(void) {
            HAL_UART_Transmit_DMA(&huart3, (const uint8_t *)"a", 1);
            if (HAL_UART_Transmit_IT(&huart3, (const uint8_t *)"-", 1) != HAL_BUSY) return 1;
            if (HAL_UART_Transmit(&huart3, (const uint8_t *)"-", 1, 10) != HAL_BUSY) return 2;
            while (sent < 2) {}
            if (HAL_UART_Transmit(&huart3, (const uint8_t *)(sent == 2 ? "d" : "x"), 1, 10) != HAL_OK) return 3;
            for (;;) __WFI();
        }
        """
    base = firmware_of(made(tmp_path, source))()
    printed = []
    for tick in range(4):
        base.step(tick, b"", b"", ())
        printed.append(base.output())
    assert printed == ["a", "ac", "acd", "acd"]


def test_what_goes_out_by_usb_is_printed(tmp_path, capsys):
    for folder in ("Core", "USB_DEVICE/App", "Src"):
        (tmp_path / folder).mkdir(parents=True)
    for name in ("USB_DEVICE/App/usb_device.c", "USB_DEVICE/App/usb_device.h", "Src/usbd_cdc_if.c"):
        (tmp_path / name).write_text("#error the vendor's\n")
    (tmp_path / "Core" / "main.c").write_text(
        '#include "stm32h7xx_hal.h"\n#include "usb_device.h"\n#include "usbd_cdc_if.h"\n'
        "int main(void) {\n    MX_USB_DEVICE_Init();\n"
        '    if (CDC_Transmit_HS((uint8_t *)"ready\\n", 6) == USBD_OK) CDC_Transmit_FS((uint8_t *)"steady\\n", 7);\n'
        "    for (;;) __WFI();\n}\n"
    )
    assert said(capsys, "dut", "init", tmp_path)[0] == 0
    base = firmware_of(tmp_path / "wheelbench.toml")()
    base.step(0, b"", b"", ())
    assert base.output() == "ready\nsteady\n"


@pytest.mark.parametrize(
    "text",
    [
        "UART_HandleTypeDef huart1;\nUART_HandleTypeDef huart6;\nCAN_HandleTypeDef hcan1;",
        "UART_HandleTypeDef huart1, huart6 = {0};\nextern CAN_HandleTypeDef hcan1;",
        'extern "C" { UART_HandleTypeDef huart1; UART_HandleTypeDef huart6; }\nextern "C" CAN_HandleTypeDef hcan1;',
        "UART_HandleTypeDef huart1;UART_HandleTypeDef huart6;\nCAN_HandleTypeDef hcan1;\nvoid f(UART_HandleTypeDef *);",
    ],
)
def test_handles_are_found_however_they_are_declared(tmp_path, text):
    (tmp_path / "main.cpp").write_text(text + "\nint main() {}\n")
    found = look(tmp_path)
    assert (found.uarts, found.cans) == (("huart1", "huart6"), ("hcan1",))


@pytest.mark.parametrize(
    ("text", "profile"),
    [
        ("DBUS frame", "dr16"),
        ("sbus_to_rc(sbus_buf, rc); rc->mouse.x = sbus_buf[6]", "dr16"),
        ("sbus_parse(); SBUS", "frsky-sbus"),
        ("iBus", "flysky"),
        ("crsf", "elrs"),
        ("radio", ""),
    ],
)
def test_the_receiver_is_guessed_from_what_the_sources_speak_of(tmp_path, text, profile):
    (tmp_path / "main.c").write_text(f"/* {text} */\nint main(void) {{}}\n")
    assert look(tmp_path).receiver == profile


@pytest.mark.parametrize(
    ("heard", "slamware"),
    [
        ("HAL_UARTEx_ReceiveToIdle_DMA(&huart3, in, 36);", '# slamware = "h..."'),
        ("HAL_UART_Receive_DMA(&huart3, in, 18); HAL_UART_Receive_IT(&huart6, &byte, 1);", 'slamware = "huart6"'),
        ("receive(&huart3);", 'slamware = "huart3"'),
    ],
)
def test_a_line_on_which_nothing_is_received_is_not_guessed_to_be_a_cores(tmp_path, heard, slamware):
    """Unless it cannot be seen on which something is."""
    (tmp_path / "main.c").write_text(f"UART_HandleTypeDef huart1, huart3, huart6;\nint main(void) {{ {heard} }}\n")
    start(tmp_path)
    assert f"\n{slamware}\n" in (tmp_path / "wheelbench.toml").read_text()
