"""What a firmware has done that ended its run, in a sentence, with the place in the team's own files.

A fault packet, little-endian:

    1 | reason u8 | signal u8 | callers u8 | length of the text u32 | address u64 | 24 callers, u64 each | text |

Callers are return addresses, innermost first; addr2line turns them into functions and lines.
"""

from __future__ import annotations

import os
import re
import shutil
import struct
import subprocess
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from bench.dut.project import Project

_HEAD = struct.Struct("<BBBBIQ24Q")
_SHIM = Path(__file__).parent / "shim"
_LAST_LINES, _REPORT_LINES = 8, 16
_MOST_CALLERS = 4
_LINK_CLOSED = 71

SIGNALS = {
    4: "SIGILL, an instruction that there is not", 5: "SIGTRAP", 6: "SIGABRT, an abort or a failed assert",
    7: "SIGBUS, an address that cannot be", 8: "SIGFPE, a division by zero or an overflow of one",
    9: "SIGKILL, ended from outside", 11: "SIGSEGV, a bad pointer", 15: "SIGTERM, ended from outside", 31: "SIGSYS",
}  # fmt: skip
"""Linux's numbers, and what they mean to a firmware."""
_WITH_ADDRESS = (7, 11)

LOOP_IN_INTERRUPT, LOOP_WITH_INTERRUPTS_OFF, MAIN_RETURNED, CAN_FLOOD, UART_FLOOD, WAIT_IN_INTERRUPT, ASSERT = range(
    2, 9
)
_REASONS = {
    LOOP_IN_INTERRUPT: "is in an interrupt handler that does not end",
    LOOP_WITH_INTERRUPTS_OFF: "loops for ever with interrupts off",
    MAIN_RETURNED: "has come to the end of main; a firmware loops for ever",
    CAN_FLOOD: "floods the CAN bus: for 100 ms it has sent more than the 8 frames that a millisecond has room for",
    UART_FLOOD: "floods the SLAMWARE line: more than 16,384 bytes in one millisecond",
    WAIT_IN_INTERRUPT: "waits in an interrupt handler, where no time passes",
}
_PLACED = (LOOP_IN_INTERRUPT, LOOP_WITH_INTERRUPTS_OFF, CAN_FLOOD, UART_FLOOD, WAIT_IN_INTERRUPT, ASSERT)


class Stalled(Enum):
    """Why no answer came."""

    BUSY = "computes without end in code that the bench cannot count (a library, or assembler); ended"
    ASLEEP = "waits for something of the host that never comes (a sleep, a read, a lock); ended"
    STARVED = "got no processor time for half a minute; ended"


class Fault(NamedTuple):
    """What the shim said last."""

    reason: int
    signal: int
    address: int
    callers: tuple[int, ...]
    text: str

    @classmethod
    def read(cls, packet: bytes) -> Fault | None:
        """Out of a packet; None where it is none."""
        if len(packet) < _HEAD.size:
            return None
        _, reason, signal, count, length, address, *callers = _HEAD.unpack_from(packet)
        text = packet[_HEAD.size : _HEAD.size + length].decode("utf-8", "replace")
        return cls(reason, signal, address, tuple(callers[: min(count, len(callers))]), text)


def told(
    project: Project, program: Path, status: int | None, fault: Fault | None, stalled: Stalled | None, output: str
) -> tuple[str, str]:
    """What it did, in a sentence; and below it the sanitizer's report, or the last lines that the firmware printed."""
    said, report = _parted(output) if project.sanitize else (output, "")
    below = _last_lines("the sanitizer's own words", _own_lines(report)) if report else ""
    below += _last_lines("its last output", said.splitlines()[-_LAST_LINES:]) if said.strip() else ""
    return _what(project, program, status, fault, stalled, report), below


def _what(
    project: Project, program: Path, status: int | None, fault: Fault | None, stalled: Stalled | None, report: str
) -> str:
    if report:
        return _sanitized(report)
    if stalled is not None:
        return stalled.value
    if fault is not None and fault.signal:
        address = f" (address 0x{fault.address:x})" if fault.signal in _WITH_ADDRESS else ""
        return f"crashed: {_signal(fault.signal)}{address}{_place(project, program, fault)}"
    if fault is not None:
        what = _REASONS.get(fault.reason, "was ended by the shim")
        if fault.text:
            what = f"stopped itself: {fault.text}"
        return what + (_place(project, program, fault) if fault.reason in _PLACED else "")
    if status is None:
        return "is gone"
    if os.WIFSIGNALED(status):
        return f"crashed: {_signal(os.WTERMSIG(status))}"
    if os.WEXITSTATUS(status) == _LINK_CLOSED:
        return "closed a file that it had not opened: its line to the bench"
    return f"ended itself with exit({os.WEXITSTATUS(status)}); a firmware loops for ever"


def _signal(number: int) -> str:
    return SIGNALS.get(number, f"signal {number}")


def _sanitized(report: str) -> str:
    """The sanitizer's finding in a line: its kind and its place, which is the innermost line of the team's own."""
    found = re.search(r"^(\S+?): runtime error: (.+)$", report, re.MULTILINE)
    if found is not None:
        where, what = found.groups()
        return f"broke a rule that UndefinedBehaviorSanitizer watches: {what} ({_file(where)})"
    kind = re.search(r"ERROR: (\w+): ([\w-]+)", report)
    tool, what = kind.groups() if kind is not None else ("a sanitizer", "see below")
    for function, where in re.findall(r"^ +#\d+ 0x[0-9a-f]+ in (.+) (\S+?:\d+)", report, re.MULTILINE):
        if "libsanitizer" not in where and not where.startswith(str(_SHIM)):
            shown = "main" if function == "wb_firmware_main" else function
            return f"broke a rule that {tool} watches: {what} in {shown} ({_file(where)})"
    return f"broke a rule that {tool} watches: {what}"


def _parted(output: str) -> tuple[str, str]:
    """What the firmware printed, and the sanitizer's report behind it."""
    found = re.search(r"^(=+\n==\d+==ERROR: |\S+:\d+:\d+: runtime error: )", output, re.MULTILINE)
    return (output[: found.start()], output[found.start() :]) if found else (output, "")


def _own_lines(report: str) -> list[str]:
    """The lines of a report but for those that tell of the shim and of the C library."""
    ours = (str(_SHIM), "libc", "wb_entry", "_start (")
    return [line for line in report.splitlines() if not any(name in line for name in ours)][:_REPORT_LINES]


def _file(where: str) -> str:
    """ "/a/b/base.c:41:7" as "base.c:41"."""
    return ":".join(Path(where).name.split(":")[:2])


def _last_lines(title: str, lines: Sequence[str]) -> str:
    return f"\n{title}:\n" + "\n".join(f"  {line}" for line in lines)


def _place(project: Project, program: Path, fault: Fault) -> str:
    """ " in f (base.c:41), called from g (base.c:77)"; empty where nobody knows."""
    own = [f"{function} ({file})" for function, file in _functions(program, fault)]
    if not own:
        return ""
    return f" in {own[0]}" + "".join(f", called from {each}" for each in own[1:_MOST_CALLERS])


def _functions(program: Path, fault: Fault) -> list[tuple[str, str]]:
    """(function, file:line) of the firmware's own callers, innermost first."""
    tool = shutil.which("addr2line")
    if tool is None or not fault.callers:
        return []
    # A return address lies behind the call. The instruction that a signal struck is the one after the handler's frames.
    addresses = [f"0x{caller - 1:x}" for caller in fault.callers]
    done = subprocess.run(
        [tool, "-e", str(program), "-f", *addresses], capture_output=True, text=True, check=False, env={"LC_ALL": "C"}
    )
    lines = done.stdout.splitlines()
    found = []
    for function, where in zip(lines[::2], lines[1::2], strict=False):
        file, _, line = where.partition(" ")[0].rpartition(":")
        if file in ("", "??") or Path(file).is_relative_to(_SHIM) or Path(file).name == "wires.c":
            continue
        shown = "main" if function == "wb_firmware_main" else function
        found.append((shown, f"{Path(file).name}:{line}"))
    return found
