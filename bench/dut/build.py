"""Compiles a firmware for this machine: the team's files as they are, the shim, and a page of C that names the wires.

What has not changed is not compiled again: beside the program stands a list of every file that went in, with its
digest. The folder is `.wheelbench` beside the project's file, or where that cannot be written one of the system's for
passing files.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from bench.dut.project import Project
from bench.dut.setup_names import setup_names_h
from bench.errors import SurroundingsError, UsageError

SHIM = Path(__file__).parent / "shim"
SHIM_SOURCES = (
    "core.c", "hal.c", "hal_uart.c", "hal_can.c",
    "rtos.c", "rtos_events.c", "rtos_cmsis.c", "rtos_cmsis_1.c", "rtos_pools.c",
)  # fmt: skip
PROGRAM, MANIFEST = "firmware", "manifest.json"
FIRMWARE_MAIN = "wb_firmware_main"

# Like the chip's compiler: plain char is unsigned, an enum as small as it may be. Addresses are the same in each run.
_ABI = ("-funsigned-char", "-fshort-enums", "-fno-pie", "-ffp-contract=off")
# uint32_t is an unsigned long on the chip and not here: its "%lu" is no mistake.
_USUAL = ("-g", "-O2", "-Wall", "-Wno-format")
_COUNTED = "-fsanitize-coverage=trace-pc"
_SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-O1")
# A loop without anything in it is the one thing that the count leaves out: ".L3: jmp .L3", with line numbers between.
_EMPTY_LOOP = re.compile(r"^(\.L\w+):\n((?:[ \t]*(?:[.#]|nop).*\n)*)[ \t]*(jmp|b)[ \t]+\1[ \t]*$", re.MULTILINE)
_CALLS = {"jmp": "call", "b": "bl"}
_UNDEFINED = re.compile(r"undefined reference to [`'‘]([^'’]+)['’]")
_NO_HEADER = re.compile(r"fatal error: ['‘]?([^'’\s]+?)['’]?(?:: No such file|\s+file not found)")
_NO_NAME = re.compile(r"undeclared|unknown type name|implicit declaration|use of undeclared|has no member named")
_MOST_LINES = 40


@dataclass(frozen=True, slots=True)
class Built:
    """A program that can be run. `warnings` are the compiler's own words; empty where nothing was compiled."""

    project: Project
    program: Path
    is_new: bool
    warnings: str = ""


def build(project: Project) -> Built:
    """Compile what has changed. Raises UsageError in the compiler's words, SurroundingsError where there is none."""
    compiler = shutil.which(project.compiler)
    if compiler is None:
        raise SurroundingsError(
            f"{project.path}: there is no C compiler {project.compiler!r} on this machine; install one (on Debian and "
            "Ubuntu: apt-get install gcc libc6-dev), or name another with compiler ="
        )
    folder = folder_of(project)
    program = folder / PROGRAM
    wires = wires_c(project)
    wanted = _digest_of_text(json.dumps([compiler, _commands(project, compiler), wires, _digest_of_shim()]))
    if _is_fresh(folder, wanted):
        return Built(project, program, is_new=False)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        warnings, inputs = _compile(project, compiler, Path(scratch), wires)
        manifest = {"made": wanted, "inputs": {str(path): _digest(path) for path in inputs}}
        # First the program, then the list: between the two it counts as old.
        os.replace(Path(scratch) / PROGRAM, program)
        (Path(scratch) / MANIFEST).write_text(json.dumps(manifest, indent=1), encoding="utf-8")
        os.replace(Path(scratch) / MANIFEST, folder / MANIFEST)
    return Built(project, program, is_new=True, warnings=warnings)


def wires_c(project: Project) -> str:
    """The page of C that says which of the firmware's names are what."""
    lines = ['#include "hal.h"', ""]
    for kind, handles in (
        ("UART_HandleTypeDef", (project.rc, project.slamware)),
        ("CAN_HandleTypeDef", (project.can,)),
        ("FDCAN_HandleTypeDef", (project.fdcan,)),
        ("TIM_HandleTypeDef", tuple(handle for handle, _ in project.timers)),
    ):
        # The firmware's own, where a source defines it; else this one.
        lines += [f"__weak {kind} {handle}{_instance(handle)};" for handle in handles if handle]
    uarts = ", ".join(f"&{handle}" if handle else "NULL" for handle in (project.rc, project.slamware))
    lines += [
        f"UART_HandleTypeDef *const wb_hal_uarts[WB_UARTS] = {{{uarts}}};",
        f"CAN_HandleTypeDef *const wb_hal_can = {f'&{project.can}' if project.can else 'NULL'};",
        f"FDCAN_HandleTypeDef *const wb_hal_fdcan = {f'&{project.fdcan}' if project.fdcan else 'NULL'};",
        f"const uint32_t wb_hal_fifo = {project.can_fifo};",
        "const struct wb_hal_timer wb_hal_timers[] = {",
        *(f"    {{&{handle}, {period_ms}}}," for handle, period_ms in project.timers),
        "    {NULL, 0},",
        "};",
        f"const long wb_blocks_per_ms = {project.blocks_per_ms};",
    ]
    runs = [name for name in (project.main, project.setup, project.loop, project.every_ms) if name]
    lines += [f"void {_called(name)}(void);" for name in dict.fromkeys(runs)]
    lines += ["void wb_entry(void) {"]
    lines += [f"    {_called(name)}();" for name in (project.main, project.setup) if name]
    if project.loop:
        lines += ["    for (;;)", f"        {project.loop}();"]
    elif not project.main:
        lines += ["    for (;;)", "        wb_wait();"]
    lines += ["}", "void wb_every_ms(void) {"]
    lines += [f"    {project.every_ms}();"] if project.every_ms else []
    return "\n".join([*lines, "}", ""])


def _called(name: str) -> str:
    return FIRMWARE_MAIN if name == "main" else name


def _instance(handle: str) -> str:
    """huart3 is on USART3, as every generator of such code has it."""
    if not re.fullmatch(r"h(uart|fdcan|tim)\d+|hcan\d*", handle):
        return ""
    return f" = {{.Instance = {handle[1:].upper().replace('UART', 'USART')}}}"


# --- the compiler -----------------------------------------------------------------------------------------------------


def _commands(project: Project, compiler: str) -> list[list[str]]:
    """The compiler's arguments: for the team's files, for the shim and the program, for the program alone."""
    sanitize = _SANITIZE if project.sanitize else ()
    include = [f"-I{path}" for path in (SHIM / "include", *project.include)]
    defines = [f"-D{define}" for define in project.defines]
    here = f"-fmacro-prefix-map={project.path.resolve().parent}/="  # __FILE__ is the same on another machine
    theirs = [compiler, *_USUAL, *_ABI, _COUNTED, here, *sanitize, *include, *defines, *project.flags]
    ours = [compiler, *_USUAL, *_ABI, f"-I{SHIM / 'include'}", f"-I{SHIM}"]
    ours += ["-DWB_SANITIZE"] if project.sanitize else []
    link = [*sanitize]
    libraries = ["-lm"] + (["-lstdc++"] if any(path.suffix != ".c" for path in project.sources) else [])
    return [theirs, ours, link, libraries, [str(path) for path in project.sources]]


def _compile(project: Project, compiler: str, scratch: Path, wires: str) -> tuple[str, set[Path]]:
    """Make the program; what the compiler had to say, and every file that went in."""
    theirs, ours, link, libraries, _ = _commands(project, compiler)
    names = [f"{number}" for number in range(len(project.sources))]
    setup_names = scratch / "wheelbench_setup_names.h"
    setup_names.write_text(setup_names_h(_files_of(project, theirs), SHIM / "include"), encoding="utf-8")
    commands = [
        [
            *theirs,
            "-include",
            str(setup_names),
            "-S",
            str(source),
            "-o",
            f"{scratch / name}.s",
            "-MMD",
            "-MF",
            f"{scratch / name}.d",
        ]
        for source, name in zip(project.sources, names, strict=True)
    ]
    said = _run_all(commands)
    refused = [[*command, "-w"] for command, (status, _) in zip(commands, said, strict=True) if status]
    if refused:  # once more, for the errors without the warnings between them
        text = "".join(text for _, text in _run_all(refused))
        raise UsageError(
            f"{project.path}: the compiler refuses the firmware; its own words:\n{_shortened(text)}{_advice(text)}"
        )
    (scratch / "wires.c").write_text(wires, encoding="utf-8")
    _assemble(project, compiler, [scratch / f"{name}.s" for name in names])
    objects = [str(scratch / f"{name}.o") for name in names]
    if project.main == "main":
        _rename_main(project, objects)
    shim = _shim_objects(project, ours)
    command = [*ours, str(scratch / "wires.c"), *objects, *map(str, shim), "-no-pie", *link, *libraries]
    status, text = _run_all([[*command, "-o", str(scratch / PROGRAM)]])[0]
    if status:
        raise UsageError(f"{project.path}: {_unlinked(project, text)}")
    inputs = set(project.sources)
    for name in names:
        inputs |= set(_read_list(scratch / f"{name}.d"))
    inputs.discard(setup_names)
    return "".join(text for _, text in said), inputs


def _files_of(project: Project, theirs: Sequence[str]) -> list[Path]:
    """The team's sources and every header of theirs that goes in: the compiler knows which, wherever they lie."""
    command = [*theirs, "-MM", "-MG", *map(str, project.sources)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    # What it stumbles over, it says once more when it compiles.
    named = {path for path in _listed(done.stdout.decode("utf-8", "surrogateescape")) if not path.is_relative_to(SHIM)}
    headers = sorted(path for path in named - {*project.sources} if path.is_file())
    return [*project.sources, *headers]


def _shim_objects(project: Project, ours: Sequence[str]) -> list[Path]:
    """The shim, compiled: once for all firmwares of this compiler."""
    folder = _common_folder() / f"shim-{_digest_of_text(json.dumps([*ours, _digest_of_shim()]))[:16]}"
    objects = [folder / f"{name}.o" for name in SHIM_SOURCES]
    if all(each.exists() for each in objects):
        return objects
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        made = [Path(scratch) / each.name for each in objects]
        commands = [[*ours, "-c", str(SHIM / name), "-o", str(to)] for name, to in zip(SHIM_SOURCES, made, strict=True)]
        for status, text in _run_all(commands):
            if status:
                raise UsageError(
                    f"{project.path}: the compiler refuses the bench's own C; another one, perhaps (compiler =)? Its "
                    f"own words:\n{_shortened(text)}"
                )
        for one, other in zip(made, objects, strict=True):
            os.replace(one, other)
    return objects


def _advice(text: str) -> str:
    """What to try, for what a first build stumbles over."""
    advice = ""
    if missing := _NO_HEADER.findall(text):
        names = ", ".join(dict.fromkeys(missing))
        advice += f"\nno {names}: add the folder to include =, or write a small header of that name"
    if _NO_NAME.search(text):
        advice += (
            "\nwhat the bench knows of the HAL is in wheelbench_hal.h and wheelbench_board.h "
            f"({SHIM / 'include'}); a file that sets up registers belongs to the board: name it in leave_out ="
        )
    return advice


def _digest_of_shim() -> str:
    """Of all of it, headers too: a program that was made with another one may not understand this bench."""
    return _digest_of_text("".join(_digest(path) for path in sorted(SHIM.rglob("*.[ch]"))))


def _assemble(project: Project, compiler: str, listings: Sequence[Path]) -> None:
    """Make objects of the compiler's listings, with a call in every loop that has nothing in it."""
    for listing in listings:
        text = listing.read_text(encoding="utf-8", errors="surrogateescape")
        text = _EMPTY_LOOP.sub(lambda found: f"{found[1]}:\n{found[2]}\t{_CALLS[found[3]]}\twb_spin", text)
        listing.write_text(text, encoding="utf-8", errors="surrogateescape")
    for status, text in _run_all([[compiler, "-c", str(each), "-o", str(each.with_suffix(".o"))] for each in listings]):
        if status:
            raise UsageError(f"{project.path}: the assembler refuses what the compiler wrote:\n{_shortened(text)}")


def _rename_main(project: Project, objects: Sequence[str]) -> None:
    """The firmware's main is not the program's: the object files are told so, the sources are not touched."""
    objcopy = shutil.which("objcopy")
    if objcopy is None:
        raise SurroundingsError(f"{project.path}: there is no objcopy on this machine; install binutils")
    for status, text in _run_all([[objcopy, "--redefine-sym", f"main={FIRMWARE_MAIN}", each] for each in objects]):
        if status:
            raise SurroundingsError(f"{project.path}: objcopy refuses: {text.strip()}")


def _run_all(commands: Iterable[Sequence[str]]) -> list[tuple[int, str]]:
    """Run them side by side: (exit status, what was written), in order."""
    english = os.environ | {"LC_ALL": "C"}
    started = [
        subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=english
        )
        for command in commands
    ]
    done = []
    for process in started:
        out, _ = process.communicate()
        done.append((process.returncode, out.decode("utf-8", "replace")))
    return done


def _shortened(text: str) -> str:
    lines = text.rstrip().splitlines()
    if len(lines) > _MOST_LINES:
        lines = [*lines[:_MOST_LINES], f"... and {len(lines) - _MOST_LINES} more lines"]
    return "\n".join(f"  {line}" for line in lines)


def _unlinked(project: Project, text: str) -> str:
    missing = list(dict.fromkeys(_UNDEFINED.findall(text)))
    if not missing:
        return f"the firmware does not link; the linker's own words:\n{_shortened(text)}"
    if FIRMWARE_MAIN in missing:
        return "no source has a main; add its file to sources, or name setup and loop in [entry]"
    return (
        f"the firmware calls what no source defines: {', '.join(missing)}; add their files to sources, or define "
        f"them in a wheelbench_port.c (`wheelbench dut init` writes one)"
    )


# --- what is still fresh ----------------------------------------------------------------------------------------------


def folder_of(project: Project) -> Path:
    """A folder for this project's program, made where it is missing."""
    place = project.path.resolve()
    beside = place.parent / ".wheelbench"
    try:
        (beside / place.stem).mkdir(parents=True, exist_ok=True)
        ignore = beside / ".gitignore"
        if not ignore.exists():
            ignore.write_text("*\n", encoding="utf-8")
        if os.access(beside / place.stem, os.W_OK):
            return beside / place.stem
    except OSError:
        pass
    elsewhere = _common_folder() / _digest_of_text(str(place))[:16]
    elsewhere.mkdir(exist_ok=True)
    return elsewhere


def _common_folder() -> Path:
    """A folder of this user's among the system's passing files. Raises SurroundingsError."""
    folder = Path(tempfile.gettempdir()) / f"wheelbench-{os.getuid()}"
    try:
        folder.mkdir(exist_ok=True, mode=0o700)
        if folder.stat().st_uid == os.getuid():
            return folder
    except OSError as error:
        raise SurroundingsError(f"{folder}: cannot be made ({error.strerror}); free some room there") from None
    raise SurroundingsError(f"{folder}: belongs to somebody else; set TMPDIR to a folder of yours")


def _is_fresh(folder: Path, wanted: str) -> bool:
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        inputs = manifest["inputs"].items()
        same = all(_digest(Path(path)) == digest for path, digest in inputs)
        return manifest["made"] == wanted and same and (folder / PROGRAM).exists()
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        return False


def _read_list(path: Path) -> Iterable[Path]:
    """The files that a compiler's list of dependencies names."""
    return _listed(path.read_text(encoding="utf-8", errors="surrogateescape"))


def _listed(text: str) -> Iterable[Path]:
    words = text.replace("\\\n", " ").replace("\\ ", "\0").split()
    return (Path(word.replace("\0", " ")) for word in words if not word.endswith(":"))


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _digest_of_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
