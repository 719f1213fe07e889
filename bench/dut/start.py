"""What `wheelbench dut init` writes into a firmware's folder: a project file, filled in from what the sources say, and
the port file, the one page of C that is the bench's and yours.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from bench.dut.project import C_ENDINGS
from bench.errors import SurroundingsError, UsageError, spelt

STYLES = ("superloop", "interrupt", "rtos")
PROJECT, PORT, STARTER = "wheelbench.toml", "wheelbench_port.c", "main.c"
_TEMPLATES = Path(__file__).parent / "templates"

# What a generator puts beside a team's own files, and the bench has instead; stm32..._hal_msp.c links DMA to its UART.
_NOT_THEIRS = re.compile(
    r"(stm32\w*_(hal(?!_msp\.c)|ll|it)\w*|system_stm32\w*|startup\w*|syscalls|sysmem|usbd_\w+|usb_device|wheelbench_port)\.c"
)
# But for the file of interrupt handlers, where a UART's idle line is heard in one of them.
_HANDLERS = re.compile(r"stm32\w*_it\.c")
_ASKS_IDLE = re.compile(r"\bUART_IT_IDLE\b")
_UARTS_HANDLER = re.compile(r"\bUS?ART\d+_IRQHandler\s*\(")
_EXTERN = re.compile(r"\bextern\s+(\w+_HandleTypeDef)\s+(\w+)\s*;")
_NOT_FOLDERS = {"Drivers", "Middlewares", "USB_DEVICE", "build", "Debug", "Release", "test", "tests"}
_MOST_FILES = 500
_HANDLE = r"(?:^|[;{{])\s*(?:extern\s+(?:\"C\"\s+)?)?{}_HandleTypeDef\s+(\w+(?:\s*,\s*\w+)*)(?=\s*[;=])"
# Where printf goes, in every project that has put it somewhere.
_CONSOLE = re.compile(r"\b(?:__io_putchar|_write|fputc)\s*\([^)]*\)\s*\{[^}]*?&\s*(\w+)")
_RECEIVES = re.compile(r"\b(?:HAL_UART(?:Ex)?_Receive\w*|__HAL_UART_ENABLE_IT)\s*\(\s*&\s*(\w+)")
_RECEIVERS = (
    ("dbus|dr16", "dr16"),
    ("sbus", "frsky-sbus"),
    ("i_?bus|flysky", "flysky"),
    ("crsf|crossfire|elrs", "elrs"),
)
"""Words of a team's files, and the profile of the bench that they mean."""
_MOUSE = re.compile(r"\bmouse\b")
"""Of the receivers DBUS alone tells of a mouse, whatever its maker's own code calls it."""


@dataclass(frozen=True, slots=True)
class Found:
    """What the sources of a folder say of themselves. Paths are relative to it."""

    sources: tuple[str, ...]
    left_out: tuple[str, ...]
    include: tuple[str, ...]
    uarts: tuple[str, ...]
    """That may be wires, those first on which something is received."""
    heard: tuple[str, ...]
    """On which something is received, as far as that can be seen."""
    consoles: tuple[str, ...]
    """That printf goes to."""
    receiver: str
    """The profile of the RC receiver that the sources speak of; empty where they speak of none."""
    cans: tuple[str, ...]
    fdcans: tuple[str, ...]
    timers: tuple[str, ...]
    style: str
    has_main: bool
    has_setup: bool
    missing: tuple[str, ...] = ()
    """Handles that its interrupt handlers speak of and no source defines, as C: "TIM_HandleTypeDef htim14;"."""


@dataclass(frozen=True, slots=True)
class Started:
    """What was written, and how."""

    style: str
    written: tuple[Path, ...]
    found: Found


def start(folder: Path, style: str | None = None) -> Started:
    """Write the files. Raises UsageError where one of them is there already, SurroundingsError where none can be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = look(folder)
    except OSError as error:
        raise SurroundingsError(f"{folder}: cannot be used ({error.strerror}); give another folder") from None
    chosen = style or found.style
    texts = {}
    if not found.sources:
        texts[STARTER] = _template("starter")
    else:
        texts[PORT] = _template("superloop" if chosen == "superloop" else "board")
        if found.missing:
            texts[PORT] += "\n".join(["\n/* Your interrupt handlers speak of them. */", *found.missing, ""])
    texts[PROJECT] = project_toml(spelt(folder.resolve().name), found, chosen)
    for name in texts:
        if (folder / name).exists():
            raise UsageError(f"{folder / name}: is there already; remove it, or go on with it")
    try:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    except UnicodeEncodeError as error:
        name = error.object[max(0, error.start - 20) : error.end + 20]
        raise UsageError(
            f"{folder}: a file's name is not UTF-8, which no project file can say; rename it (near {name!r})"
        ) from None
    except OSError as error:
        raise SurroundingsError(f"{folder}: cannot be written ({error.strerror}); give another folder") from None
    return Started(chosen, tuple(folder / name for name in texts), found)


def look(folder: Path) -> Found:
    """Read the C files of a folder, as far as is good for a guess."""
    files = sorted(path for path in _walk(folder) if path.suffix in (*C_ENDINGS, ".h", ".hpp"))[:_MOST_FILES]
    code = [path for path in files if path.suffix in C_ENDINGS]
    kept, text, missing = _kept(code)
    handles, cans, fdcans, timers = (_names(text, kind) for kind in ("UART", "CAN", "FDCAN", "TIM"))
    consoles = tuple(name for name in handles if name in _CONSOLE.findall(text))
    heard = tuple(dict.fromkeys(_RECEIVES.findall(text)))
    uarts = tuple(sorted((name for name in handles if name not in consoles), key=lambda name: name not in heard))
    if re.search(r"FreeRTOS\.h|cmsis_os2?\.h", text):
        style = "rtos"
    elif handles or cans or fdcans or "_hal.h" in text:
        style = "interrupt"
    else:
        style = "superloop"
    headers = {path.parent.relative_to(folder).as_posix() for path in files if path.suffix in (".h", ".hpp")}
    return Found(
        sources=tuple(path.relative_to(folder).as_posix() for path in kept),
        left_out=tuple(path.relative_to(folder).as_posix() for path in code if path not in kept),
        include=tuple(sorted(headers)),
        uarts=uarts,
        heard=heard,
        consoles=consoles,
        receiver=_receiver(text, kept),
        cans=cans,
        fdcans=fdcans,
        timers=tuple(name for name in timers if name not in missing),
        style=style,
        has_main=bool(re.search(r"^\s*(int|void)\s+main\s*\(", text, re.MULTILINE)),
        has_setup=bool(re.search(r"^\s*void\s+setup\s*\(", text, re.MULTILINE)),
        missing=tuple(f"{kind} {name};" for name, kind in missing.items()),
    )


def _kept(code: Sequence[Path]) -> tuple[list[Path], str, dict[str, str]]:
    """Which of the sources are the team's, all that they say, and {name: type} of handles that nobody defines."""
    kept = [path for path in code if not _NOT_THEIRS.fullmatch(path.name)]
    handlers = [path for path in code if _HANDLERS.fullmatch(path.name)]
    own, of_handlers = ("".join(f"{_read(path)}\n" for path in paths) for paths in (kept, handlers))
    if not _ASKS_IDLE.search(own + of_handlers) or _UARTS_HANDLER.search(own):
        return kept, own, {}
    defined = _EXTERN.sub("", own)
    missing = {
        name: kind
        for kind, name in _EXTERN.findall(of_handlers)
        if not re.search(rf"\b{kind}\b[^;()]*\b{name}\b", defined)
    }
    return sorted([*kept, *handlers]), own + of_handlers, missing


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def _receiver(text: str, files: Sequence[Path]) -> str:
    words = " ".join([*(path.stem for path in files), text])
    counts = {profile: len(re.findall(pattern, words, re.IGNORECASE)) for pattern, profile in _RECEIVERS}
    most = max(counts, key=counts.__getitem__)
    if most == "frsky-sbus" and _MOUSE.search(words):
        return "dr16"
    return most if counts[most] else ""


def _walk(folder: Path) -> Iterable[Path]:
    for path in folder.iterdir():
        if path.name.startswith(".") or path.name in _NOT_FOLDERS:
            continue
        if path.is_dir():
            yield from _walk(path)
        else:
            yield path


def _names(text: str, kind: str) -> tuple[str, ...]:
    lists = re.findall(_HANDLE.format(kind), text, re.MULTILINE)
    return tuple(dict.fromkeys(name.strip() for names in lists for name in names.split(",")))


def _template(name: str) -> str:
    return (_TEMPLATES / f"{name}.c").read_text(encoding="utf-8")


def project_toml(name: str, found: Found, style: str) -> str:
    """The project file, with what was found and a word on what to check."""
    sources = [*found.sources, PORT] if found.sources else [STARTER]
    lines = [
        "schema = 1",
        f"name = {_text(name)}",
        "# Your own files, unchanged. Not the vendor's HAL, start-up code or scheduler: the bench has its own.",
        _list("sources", sources),
    ]
    lines += [_list("include", found.include)] if found.include else []
    lines += ['defines = []                  # ["STM32F407xx"]', 'compiler = "cc"']
    lines += ["sanitize = false              # true: AddressSanitizer and UndefinedBehaviorSanitizer watch", ""]
    lines += ["[entry]"]
    if found.has_setup and not found.has_main:
        lines += ['setup = "setup"', 'loop = "loop"']
    else:
        lines += ['main = "main"']
    lines += ['# every_ms = "control_step"   # a function that a timer of yours calls each millisecond']
    if style != "superloop" or found.uarts or found.consoles or found.cans or found.fdcans:
        lines += ["", "[wires]                       # check: which handle is which line"]
        # A core asks: a line on which nothing is received is not its.
        names = (*(name for name in found.uarts if name in found.heard or not found.heard), "", "")
        can = ("fdcan", found.fdcans[0]) if found.fdcans else ("can", (*found.cans, "")[0])
        for key, handle in (("rc", names[0]), ("slamware", names[1]), can):
            lines += [f"{key} = {_text(handle)}" if handle else f'# {key} = "h..."']
        lines += [
            f"# {name} is no wire: printf goes there, and what it sends is kept as output" for name in found.consoles
        ]
    for timer in found.timers:
        lines += ["", "[[timer]]", f"handle = {_text(timer)}", "period_ms = 1                 # check"]
    return "\n".join([*lines, ""])


def _list(key: str, values: Sequence[str]) -> str:
    if len(values) < 4:
        return f"{key} = [{', '.join(map(_text, values))}]"
    return f"{key} = [\n" + "".join(f"    {_text(value)},\n" for value in values) + "]"


def _text(value: str) -> str:
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
