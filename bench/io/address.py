"""Address strings, one for each wire, and the only place that reads them. Nothing is opened here.

sim:                                     inside the process, the default of every wire
pty:          pty:/tmp/rc                a pseudo-terminal that the bench makes; with a path, a link there leads to it
serial:/dev/ttyUSB0?baud=115200&format=8N1
socket://127.0.0.1:5000                  connect
listen://127.0.0.1:5000                  wait for whoever connects; this machine alone, but for ?remote=yes

can:slcan:/dev/ttyACM0@1000000           an SLCAN adapter on any serial line: a device, pty:, socket://HOST:PORT
can:socketcan:can0
can:socketcand:can0?host=H&port=29536    a bus of another machine
can:virtual:NAME                         python-can's bus within one process
can:udp_multicast:239.74.163.2           stays on this machine, but for ?remote=yes
can:INTERFACE:CHANNEL@BITRATE?key=value  any interface of python-can; the keys go to it as they are
"""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping
from difflib import get_close_matches
from typing import NamedTuple
from urllib.parse import parse_qsl

from bench.errors import UsageError
from bench.rc.line import Settings

CAN_BITRATE = 1_000_000
"""Of the C610 and DM3519: what a bus has where its address says nothing."""
SERIAL_KINDS = "pty:, serial:/dev/NAME?baud=N, socket://HOST:PORT or listen://HOST:PORT"
CAN_KINDS = "can:slcan:/dev/NAME@1000000, can:socketcan:can0, can:virtual:NAME or can:udp_multicast:239.74.163.2"


class SerialAddress(NamedTuple):
    """Where a serial line is. `settings` are those that the address names itself, None where it leaves them open."""

    kind: str
    """sim, pty, serial, socket or listen."""
    place: str = ""
    """Of serial the device, of pty the link's path, of the others the host."""
    port: int = 0
    settings: Settings | None = None
    text: str = "sim:"

    @property
    def is_sim(self) -> bool:
        """Whether it stays inside the process."""
        return self.kind == "sim"


class CanAddress(NamedTuple):
    """Where a CAN bus is. `line` is the serial line that an SLCAN adapter hangs on."""

    interface: str
    """sim, slcan, or python-can's name for it."""
    channel: str = ""
    bitrate: int | None = None
    options: Mapping[str, str | int | bool] = {}
    line: SerialAddress | None = None
    text: str = "sim:"

    @property
    def is_sim(self) -> bool:
        """Whether it stays inside the process."""
        return self.interface == "sim"

    @property
    def is_harmless(self) -> bool:
        """Whether no motor can hang on it: it does not leave the process. A bus between processes may be bridged."""
        return self.interface in ("sim", "virtual", "wheelbench")


def serial_address(name: str, text: str, *, outside: bool = False) -> SerialAddress:
    """Read the address of a serial line; `name` is what the user calls the wire. Raises UsageError in one sentence.

    `outside`: somebody else shall be at its other end, so it is not `sim:`, and nobody is offered that.
    """
    if text == "sim:":
        _refuse_inside(name, outside, SERIAL_KINDS)
        return SerialAddress("sim")
    kinds = SERIAL_KINDS if outside else f"sim:, {SERIAL_KINDS}"
    scheme, colon, rest = text.partition(":")
    if scheme == "can":
        raise UsageError(f"{name} {text}: is a CAN bus, and this wire is a serial line; expected {kinds}")
    if not colon and text.startswith("/"):
        raise UsageError(f"{name} {text}: does not say what it is; try serial:{text}")
    if scheme == "pty" and "?" not in rest:
        return SerialAddress("pty", rest, text=text)
    if scheme == "serial":
        return _device(name, text, rest)
    if scheme in ("socket", "listen"):
        return _network(name, text, scheme, rest)
    known = ("pty", "serial", "socket", "listen") if outside else ("sim", "pty", "serial", "socket", "listen")
    raise UsageError(f"{name} {text}: expected {kinds}{_meant(scheme, known)}")


def can_address(name: str, text: str, *, outside: bool = False) -> CanAddress:
    """Read the address of a CAN bus; as `serial_address`. Raises UsageError in one sentence."""
    if text == "sim:":
        _refuse_inside(name, outside, CAN_KINDS)
        return CanAddress("sim")
    kinds = CAN_KINDS if outside else f"sim:, {CAN_KINDS}"
    scheme, _, rest = text.partition(":")
    interface, colon, rest = rest.partition(":")
    if scheme != "can" or not interface or not colon:
        raise UsageError(f"{name} {text}: expected {kinds}")
    rest, options = _options(name, text, rest)
    rest, bitrate = _bitrate(name, text, rest)
    if not rest:
        raise UsageError(f"{name} {text}: names no channel; expected {kinds}")
    if interface == "slcan":
        line = _adapters_line(name, text, rest, options)
        return CanAddress(interface, rest, bitrate or CAN_BITRATE, options, line, text)
    if interface == "udp_multicast":
        _check_number(name, text, options, "port", 1, 65534)  # the last that python-can takes
        _keep_here(name, text, options)
    return CanAddress(interface, rest, bitrate, options, None, text)


def _refuse_inside(name: str, outside: bool, kinds: str) -> None:
    if outside:
        raise UsageError(f"{name}: sim: is inside the process, where nobody else can meet it; expected {kinds}")


def _adapters_line(name: str, text: str, rest: str, options: Mapping[str, object]) -> SerialAddress:
    if options:
        raise UsageError(f"{name} {text}: an SLCAN adapter takes no ?{next(iter(options))}=; give only @BITRATE")
    if rest == "sim:":
        raise UsageError(f"{name} {text}: an adapter hangs on a serial line; try can:slcan:/dev/ttyACM0@1000000")
    return serial_address(name, f"serial:{rest}" if rest.startswith("/") else rest, outside=True)


def _keep_here(name: str, text: str, options: dict[str, str | int | bool]) -> None:
    """Give datagrams a time to live of 0, which keeps them on this machine, unless the address says otherwise."""
    remote = options.pop("remote", False)
    if remote not in (True, False):
        raise UsageError(f"{name} {text}: remote={remote}: expected yes or no")
    options.setdefault("hop_limit", 1 if remote else 0)
    _check_number(name, text, options, "hop_limit", 0, 255)
    if options["hop_limit"] != 0 and not remote:
        raise UsageError(f"{name} {text}: would leave this machine; add ?remote=yes if that is meant")


def _check_number(name: str, text: str, options: Mapping[str, object], key: str, least: int, most: int) -> None:
    value = options.get(key, least)
    if type(value) is not int or not least <= value <= most:
        raise UsageError(f"{name} {text}: {key}={value}: expected {least} to {most}")


def _device(name: str, text: str, rest: str) -> SerialAddress:
    device, given = _options(name, text, rest)
    if not device:
        raise UsageError(f"{name} {text}: names no device; try serial:/dev/ttyUSB0 (`wheelbench doctor` lists them)")
    settings = None
    if given:
        settings = Settings(_baud(name, text, given.pop("baud", 115_200)))
        settings = _format(name, text, settings, str(given.pop("format", "8N1")))
    if given:
        key = next(iter(given))
        raise UsageError(f"{name} {text}: knows no {key!r}; expected baud or format{_meant(key, ('baud', 'format'))}")
    return SerialAddress("serial", device, 0, settings, text)


def _network(name: str, text: str, kind: str, rest: str) -> SerialAddress:
    place, options = _options(name, text, rest.removeprefix("//"))
    host, colon, digits = place.rpartition(":")
    if not rest.startswith("//") or not colon or not host or not digits.isdecimal() or not 0 < int(digits) < 65536:
        raise UsageError(f"{name} {text}: expected {kind}://HOST:PORT, such as {kind}://127.0.0.1:5000")
    remote = options.pop("remote", False)
    if options or remote not in (True, False):
        raise UsageError(f"{name} {text}: the only option here is ?remote=yes")
    host = host.strip("[]")
    if not _can_be_asked_for(host):
        raise UsageError(f"{name} {text}: no host can have this name; expected such as {kind}://127.0.0.1:5000")
    if kind == "listen" and not remote and not _is_loopback(host):
        raise UsageError(f"{name} {text}: would be open to the network; listen on 127.0.0.1, or add ?remote=yes")
    return SerialAddress(kind, host, int(digits), None, text)


def _can_be_asked_for(host: str) -> bool:
    """Whether the system's resolver takes the name at all: Python raises UnicodeError for others, not OSError."""
    try:
        host.encode("idna")
    except UnicodeError:
        return False
    return True


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _options(name: str, text: str, rest: str) -> tuple[str, dict[str, str | int | bool]]:
    """What stands before the question mark, and the options behind it: whole numbers, yes and no, or text."""
    place, mark, query = rest.partition("?")
    if not mark:
        return place, {}
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=True)
    except ValueError:
        raise UsageError(f"{name} {text}: after the question mark expected key=value, joined by &") from None
    keys = [key for key, _ in pairs]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise UsageError(f"{name} {text}: gives {twice} twice")
    return place, {key: _value(value) for key, value in pairs}


def _value(text: str) -> str | int | bool:
    known = {"yes": True, "true": True, "no": False, "false": False}
    if text.lower() in known:
        return known[text.lower()]
    return int(text) if text.isdecimal() and text.isascii() else text


def _bitrate(name: str, text: str, rest: str) -> tuple[str, int | None]:
    channel, at, digits = rest.rpartition("@")
    if not at:
        return rest, None
    if not digits.isdecimal() or not 10_000 <= int(digits) <= 1_000_000:
        raise UsageError(f"{name} {text}: @{digits}: expected a bitrate from 10000 to 1000000, such as @1000000")
    return channel, int(digits)


def _baud(name: str, text: str, value: str | int | bool) -> int:
    if type(value) is not int or not 50 <= value <= 20_000_000:
        raise UsageError(f"{name} {text}: baud={value}: expected a number such as 115200")
    return value


def _format(name: str, text: str, settings: Settings, value: str) -> Settings:
    known = {"8N1": (False, 1), "8N2": (False, 2), "8E1": (True, 1), "8E2": (True, 2)}
    if value.upper() not in known:
        raise UsageError(f"{name} {text}: format={value}: expected {', '.join(known)}")
    even_parity, stop_bits = known[value.upper()]
    return settings._replace(even_parity=even_parity, stop_bits=stop_bits)


def _meant(word: str, known: tuple[str, ...]) -> str:
    near = get_close_matches(word, known, 1)
    return f"; did you mean {near[0]}?" if near else ""
