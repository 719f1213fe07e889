"""Names of a chip's set-up: clocks, pins, interrupt numbers, DMA requests. Every family of chips has hundreds of its
own, and here none of them does anything. So no list of them stands in the shim: what a firmware names is taken from its
own files.

    GPIO_InitStruct.Alternate = GPIO_AF14_UART5;         #define GPIO_AF14_UART5 12
    __HAL_RCC_UART5_CLK_DISABLE();                 ->    #define __HAL_RCC_UART5_CLK_DISABLE(...) ((void)0)
    set.Usart234578ClockSelection = ...;                 a field of RCC_PeriphCLKInitTypeDef
    hspi2.Init.IOSwap = SPI_IO_SWAP_DISABLE;             a field of SPI_HandleTypeDef's Init, and a constant
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

_CONSTANT = re.compile(
    r"\b(?:[A-Z][A-Za-z0-9_]*_IRQn|B?DMA\d?_(?:Stream|Channel)\d+|(?:"
    r"GPIO_AF\d+|RCC|DMA_REQUEST|FLASH_LATENCY|PWR_REGULATOR_VOLTAGE|PWR_FLAG|MPU_REGION|MPU_ACCESS|MPU_TEX"
    r"|UART_ONE_BIT_SAMPLE|UART_PRESCALER|UART_[TR]XFIFO_THRESHOLD|UART_ADVFEATURE"
    r"|TIM_OSSR|TIM_OSSI|TIM_LOCKLEVEL|TIM_BREAK2?|TIM_BREAK2?POLARITY|TIM_AUTOMATICOUTPUT|TIM_TRGO2?"
    r")_[A-Z0-9_]+|PWR_[A-Z0-9_]*SUPPLY|MPU_INSTRUCTION_ACCESS_[A-Z]+|MPU_[A-Z_]*(?:DEFAULT|NONE))\b"
)
_CALL = re.compile(r"\b(?:__HAL_RCC_\w+_(?:ENABLE|DISABLE|RESET|CONFIG)|__HAL_AFIO_\w+|__HAL_DBGMCU_\w+)(?=\s*\()")
_SELECTION = re.compile(r"\.\s*(\w+ClockSelection)\b")
# What goes into a peripheral's settings, in the variables that generators use for them.
_SETTING = re.compile(
    r"(?:\bInit|\bsConfig\w*|\bmultimode|\bs(?:Time|Date))\s*\.\s*\w+\s*=\s*"
    r"((?:ADC|CAN|CRC|DAC|FDCAN|I2C|IWDG|RNG|RTC|SPI|TIM|UART)_[A-Z0-9_]+)\s*;"
)
_PERIPHERALS = ("ADC", "CRC", "DAC", "I2C", "RNG", "RTC", "SPI", "TIM")
_FIELD = re.compile(rf"\bh({'|'.join(map(str.lower, _PERIPHERALS))})\w*\s*(?:\.|->)\s*Init\s*\.\s*(\w+)")
_CHANNEL_FIELD = re.compile(r"\bsConfig\s*\.\s*(\w+)")
# What the firmware names itself: its macros, its constants and variables, what its enums hold.
_THEIRS = re.compile(r"^\s*#\s*define\s+(\w+)|\b([A-Z]\w*)(?:\[[^\]]*\])?\s*=(?!=)", re.MULTILINE)
_ENUM = re.compile(r"\benum\b[^{};]*\{([^}]*)\}")
# Keil's compiler lets a team define stdint.h's types itself: the same on the chip, but of another name here.
_OWN_INT64 = re.compile(r"\btypedef\s+(?:un)?signed\s+long\s+long\s+(?:int\s+)?u?int64_t\b")
_INT64 = (
    "#include <stdint.h>",
    "typedef signed long long wb_int64_t;",
    "typedef unsigned long long wb_uint64_t;",
    "#define int64_t wb_int64_t",
    "#define uint64_t wb_uint64_t",
)
_WORD = re.compile(r"\w+")
_ADDRESS = re.compile(r"B?DMA\d?_(?:Stream|Channel)\d+")


def setup_names_h(files: Iterable[Path], shim_headers: Path) -> str:
    """A header with every such name in these sources and headers that neither they nor the shim define."""
    text = "\n".join(path.read_text(encoding="utf-8", errors="replace") for path in files)
    shim = {word for path in shim_headers.glob("*.h") for word in _WORD.findall(path.read_text(encoding="utf-8"))}
    known = shim | {name for names in _THEIRS.findall(text) for name in names}
    known |= {word for body in _ENUM.findall(text) for word in _WORD.findall(body)}
    named = dict.fromkeys([*_CONSTANT.findall(text), *_SETTING.findall(text)])
    constants = [name for name in named if name not in known]
    calls = [name for name in dict.fromkeys(_CALL.findall(text)) if name not in known]
    lines = [
        f"#define {name} {f'((void *){number})' if _ADDRESS.fullmatch(name) else number}"
        for number, name in enumerate(constants, 1)
    ]
    lines += [f"#define {name}(...) ((void)0)" for name in calls]
    lines.append(_fields("WB_CLOCK_SELECTIONS", (name for name in _SELECTION.findall(text) if name not in shim)))
    board = "\n".join((shim_headers / f"wheelbench_{name}.h").read_text(encoding="utf-8") for name in ("hal", "board"))
    for kind in _PERIPHERALS:
        has = _WORD.findall(_struct(board, rf"}} Init;[^{{}}]*}} {kind}_HandleTypeDef;"))
        wanted = (name for which, name in _FIELD.findall(text) if which.upper() == kind)
        lines.append(_fields(f"WB_{kind}_INIT", (name for name in wanted if name not in has)))
    has = _WORD.findall(_struct(board, r"} ADC_ChannelConfTypeDef;"))
    lines.append(_fields("WB_ADC_CHANNEL", (name for name in _CHANNEL_FIELD.findall(text) if name not in has)))
    return "\n".join([*lines, *(_INT64 if _OWN_INT64.search(text) else ()), ""])


def _fields(macro: str, names: Iterable[str]) -> str:
    return f"#define {macro} " + "".join(f"uint32_t {name}; " for name in dict.fromkeys(names))


def _struct(text: str, end: str) -> str:
    """The fields of the structure that ends so."""
    found = re.search(r"\{([^{}]*)" + end, text)
    return found[1] if found else ""
