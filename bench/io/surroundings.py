"""What this machine can do for a bench: ports, CAN, permissions, compiler, extras, clock. It changes nothing."""

from __future__ import annotations

import grp
import importlib.util
import os
import pwd
import shutil
import socket
import sys
from pathlib import Path
from typing import NamedTuple

from bench.io.clock import now_ns, wait_ns
from bench.io.punctual import leaves_a_processor
from bench.io.timing import compiler_here

OK, LACKING, BAD = "ok", "lacking", "bad"
SERIAL_GROUPS = ("dialout", "uucp")
CAN_TYPE = "280"
"""ARPHRD_CAN in /sys/class/net/NAME/type."""
EXTRAS = {
    "multicast": ("msgpack", "can:udp_multicast: between processes"),
    "pictures": ("matplotlib", "scripts/pictures.py"),
}


class Finding(NamedTuple):
    """One thing that was looked at. `what_to_try` is empty where nothing is amiss."""

    topic: str
    state: str
    """ok; lacking (something needs it, most do not); bad."""
    text: str
    what_to_try: str = ""


def look_round() -> list[Finding]:
    """Everything but the terminal, which is the command line's."""
    return [_python(), *serial_ports(), _permission(), *can_buses(), _multicast(), _compiler(), *_extras(), *clock()]


def serial_ports() -> list[Finding]:
    """The serial devices that there are, and whether they can be opened."""
    from serial.tools import list_ports

    found = []
    for port in sorted(list_ports.comports(), key=lambda one: str(one.device)):
        if port.hwid in (None, "n/a"):  # a name without hardware behind it
            continue
        may = os.access(port.device, os.R_OK | os.W_OK)
        what = port.description if port.description not in (None, "n/a") else port.hwid
        advice = "" if may else _join_group(_group_of(port.device))
        found.append(Finding("serial", OK if may else BAD, f"serial:{port.device} ({what})", advice))
    return found or [Finding("serial", LACKING, "no serial adapter is plugged in", "plug one in, or use pty:")]


def _permission() -> Finding:
    user = pwd.getpwuid(os.geteuid()).pw_name
    if os.geteuid() == 0:
        return Finding("permissions", OK, "you are root: every device can be opened")
    groups = {grp.getgrgid(number).gr_name for number in os.getgroups()}
    known = [name for name in SERIAL_GROUPS if any(one.gr_name == name for one in grp.getgrall())]
    if not known or groups & set(known):
        return Finding("permissions", OK, f"{user} is in {', '.join(sorted(groups & set(known))) or 'no serial group'}")
    return Finding("permissions", BAD, f"{user} is not in the group {known[0]}", _join_group(known[0]))


def _join_group(group: str) -> str:
    return f"sudo usermod -aG {group} $USER, and log in anew"


def _group_of(device: str) -> str:
    try:
        return grp.getgrgid(os.stat(device).st_gid).gr_name
    except (OSError, KeyError):
        return SERIAL_GROUPS[0]


def can_buses() -> list[Finding]:
    """SocketCAN's interfaces, or why there are none."""
    if not hasattr(socket, "AF_CAN"):
        return [Finding("can", LACKING, "this system has no SocketCAN", "use can:slcan:/dev/ttyACM0 with the adapter")]
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        why = f"this kernel has no SocketCAN ({error.strerror})"
        return [Finding("can", LACKING, why, "use can:slcan:/dev/ttyACM0 with the adapter, or another kernel")]
    found = []
    for interface in sorted(Path("/sys/class/net").iterdir()):
        if _read(interface / "type") != CAN_TYPE:
            continue
        name, state = interface.name, _read(interface / "operstate")
        up = state in ("up", "unknown")
        advice = "" if up else f"sudo ip link set {name} up type can bitrate 1000000"
        found.append(Finding("can", OK if up else BAD, f"can:socketcan:{name} is {state}", advice))
    return found or [
        Finding("can", LACKING, "SocketCAN has no interface", "plug an adapter in, or: sudo modprobe vcan")
    ]


def _multicast() -> Finding:
    if importlib.util.find_spec("msgpack") is None:
        return Finding("multicast", LACKING, "can:udp_multicast: needs msgpack", "pip install 'wheelbench[multicast]'")
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            group = socket.inet_aton("239.74.163.2") + socket.inet_aton("0.0.0.0")
            probe.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    except OSError as error:
        return Finding("multicast", BAD, f"no multicast here ({error.strerror})", "bring a network up, even lo")
    return Finding("multicast", OK, "can:udp_multicast:239.74.163.2 works between processes")


def _python() -> Finding:
    from bench import __version__

    return Finding("python", OK, f"wheelbench {__version__} on Python {sys.version.split()[0]}")


def _compiler() -> Finding:
    compiler = compiler_here()
    if compiler is None:
        return Finding(
            "compiler", LACKING, "no C compiler, which firmware in C needs", "sudo apt install gcc libc6-dev"
        )
    return Finding("compiler", OK, compiler)


def _extras() -> list[Finding]:
    found = []
    for extra, (module, purpose) in EXTRAS.items():
        if extra != "multicast" and importlib.util.find_spec(module) is None:
            text = f"{extra} is not installed: {purpose}"
            found.append(Finding("extras", LACKING, text, f"pip install 'wheelbench[{extra}]'"))
    missing = [tool for tool in ("candump", "slcand") if shutil.which(tool) is None]
    if missing:
        found.append(
            Finding("extras", LACKING, f"no {' and no '.join(missing)} on the path", "sudo apt install can-utils")
        )
    return found


def clock() -> list[Finding]:
    """How long a short sleep really takes, what the loop may ask of the scheduler, how busy the machine is."""
    late_us = []
    for _ in range(50):
        started = now_ns()
        wait_ns(1_000_000)
        late_us.append((now_ns() - started) / 1000 - 1000)
    late_us.sort()
    text = f"a sleep of 1 ms is {late_us[25]:.0f} us late, at most {late_us[-1]:.0f} us of 50"
    found = [
        Finding("clock", OK if late_us[25] < 500 else BAD, text, "" if late_us[25] < 500 else "close what is busy")
    ]
    load, cores = os.getloadavg()[0], os.cpu_count() or 1
    busy = load > cores
    advice = "close other programs before you run on real ports" if busy else ""
    found.append(Finding("load", BAD if busy else OK, f"{load:.1f} on {cores} cores", advice))
    return [*found, _priority()]


def _priority() -> Finding:
    import resource

    if not sys.platform.startswith("linux"):
        return Finding("priority", LACKING, "real-time priority is asked for on Linux alone")
    if not leaves_a_processor():
        advice = "give it a second one: with one, a loop with priority that falls behind keeps the stop key unheard"
        return Finding("priority", LACKING, "on one processor the real-time loop takes no real-time priority", advice)
    if os.geteuid() == 0 or resource.getrlimit(resource.RLIMIT_RTPRIO)[1] > 0:
        return Finding("priority", OK, "the real-time loop may have real-time priority")
    advice = "add '@dialout - rtprio 20' to /etc/security/limits.conf, and log in anew"
    return Finding("priority", LACKING, "the real-time loop has to do without real-time priority", advice)


def _read(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""
