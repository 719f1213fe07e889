"""`wheelbench emulate WHAT ADDRESS`: hardware for a driver or a firmware to talk to, until Ctrl-C."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.config import Profile, Robot
    from bench.io.emulated.serve import Device
    from bench.messages import BodyTwist

ABOUT = {
    "escs": "the motors of a robot on a CAN bus: C610 or DM3519 ESCs with motors, wheels and plant",
    "slcan": "an SLCAN (LAWICEL) adapter on a serial line, with a robot's motors or another bus behind it",
    "base": "a robot base that a SLAMWARE core drives over a serial line",
    "firmware": "our own base controller on real wires: an RC and a SLAMWARE line in, a CAN bus of motors out",
    "core": "a SLAMWARE core that drives a base over a serial line",
    "receiver": "an RC receiver on a serial line, with any protocol that we speak",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A parser for each device."""
    devices = parser.add_subparsers(dest="device", metavar="WHAT", required=True)
    made = {name: devices.add_parser(name, help=about, description=about) for name, about in ABOUT.items()}
    made["escs"].add_argument(
        "address", metavar="ADDRESS", help="can:socketcan:can0, can:slcan:/dev/ttyACM0@1000000 ..."
    )
    made["slcan"].add_argument(
        "address", metavar="ADDRESS", nargs="?", default="pty:", help="the adapter's port (pty:)"
    )
    made["slcan"].add_argument(
        "--robot",
        metavar="R",
        help="its motors hang on the adapter's bus; with --bus: they hang there, within its limits",
    )
    made["slcan"].add_argument(
        "--bus",
        metavar="ADDRESS",
        help="the adapter is a way to this bus: can:socketcan:can0 ... (with --robot, --arm)",
    )
    for name in ("base", "core", "receiver"):
        made[name].add_argument("address", metavar="ADDRESS", help="pty:, serial:/dev/ttyUSB0?baud=115200 ...")
    made["firmware"].add_argument("--can", metavar="ADDRESS", required=True, help="the bus of its motors")
    made["firmware"].add_argument("--rc", metavar="ADDRESS", help="where its RC receiver is")
    made["firmware"].add_argument("--slamware", metavar="ADDRESS", help="where its SLAMWARE core is")
    for name in ("slcan", "firmware"):
        made[name].add_argument("--arm", action="store_true", help="real motors may move: they stand clear")
    for name, default in (("escs", "m2006"), ("base", "slamware-a"), ("firmware", "m2006")):
        made[name].add_argument("--robot", metavar="R", default=default, help=f"a name or a .toml file ({default})")
    asks = made["core"].add_mutually_exclusive_group()
    asks.add_argument("--twist", metavar="VX,VY,OMEGA", help="what it asks for: m/s, m/s, rad/s (0.1,0,0)")
    asks.add_argument("--from", dest="source", metavar="FILE", type=Path, help="the [[core]] entries of a scenario")
    made["core"].add_argument("--poll-ms", metavar="N", type=int, default=50, help="from request to request (50)")
    speaks = made["receiver"].add_mutually_exclusive_group(required=True)
    speaks.add_argument("--protocol", metavar="P", help="uart12, sbus, dbus, ibus, crsf")
    speaks.add_argument("--profile", metavar="P", help="a transmitter's profile: a name or a .toml file")
    made["receiver"].add_argument(
        "--from", dest="source", metavar="FILE", type=Path, help="an RC capture or a scenario; else sticks at rest"
    )
    made["receiver"].add_argument("--repeat", action="store_true", help="from the beginning again at its end")
    for parser in made.values():
        parser.add_argument("--seconds", metavar="N", type=float, help="stop by itself after so long")
        parser.add_argument("--json", action="store_true", help="a JSON object for each line")


def run(args: argparse.Namespace) -> int:
    """Build the device, say where it is, and let it live."""
    from bench.cli.headless import asked_to_stop
    from bench.errors import EXIT_OK, UsageError
    from bench.io.emulated.serve import serve

    if args.seconds is not None and not 0.0 < args.seconds < 1e9:
        raise UsageError(f"--seconds {args.seconds:g}: expected a positive number")
    devices, opening = _BUILD[args.device](args)
    told = Teller(args.device, devices, args.json)
    told.beginning(opening)
    with asked_to_stop() as asked:
        ticks = None if args.seconds is None else max(1, round(1000 * args.seconds))
        ran = serve(devices, ticks=ticks, stopped=lambda: bool(asked), every_second=told.second)
    told.end(ran)
    return EXIT_OK


class Teller:
    """Says what the devices hear: a line a second, where something has changed that is worth a line."""

    def __init__(self, what: str, devices: list[Device], as_json: bool) -> None:
        self._what, self._devices, self._json = what, devices, as_json
        self._last: dict[str, object] = {}

    def beginning(self, facts: dict[str, object]) -> None:
        """What and where."""
        if self._json:
            self._print({"event": "listening", "device": self._what, **facts})
            return
        self._print(" ".join(str(value) for value in facts.values() if value != ""))

    def second(self, tick: int) -> None:
        """One more second has passed."""
        facts = self._facts()
        if facts != self._last:
            self._last = facts
            self._line("heard", tick, facts)

    def end(self, tick: int) -> None:
        """It has stopped."""
        self._line("stopped", tick, self._facts())

    def _facts(self) -> dict[str, object]:
        return {key: value for device in self._devices for key, value in device.facts().items()}

    def _line(self, event: str, tick: int, facts: dict[str, object]) -> None:
        if self._json:
            self._print({"event": event, "t_s": tick / 1000, **facts})
        else:
            said = ", ".join(f"{key} {_said(value)}" for key, value in facts.items())
            self._print(f"{tick / 1000:7.1f} s  {'stopped: ' if event == 'stopped' else ''}{said}")

    def _print(self, line: str | dict[str, object]) -> None:
        import json

        if isinstance(line, dict):
            print(json.dumps(line), flush=True)
        else:
            say(line, flush=True)


def _said(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return " ".join(map(str, value)) or "none"
    return str(value)


def _escs(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.config import load_robot
    from bench.io.can_port import open_can
    from bench.io.emulated.devices import EscsOnBus

    robot = load_robot(args.robot)
    bus = open_can("address", args.address)
    ids = ", ".join(str(wheel.can_id) for wheel in robot.wheels)
    what = f"{robot.motor.kind} ESCs {ids} of {robot.name} on"
    return [EscsOnBus(robot, bus)], _told(what, args.address, bus.where, bus.note)


def _slcan(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.config import load_robot
    from bench.errors import UsageError
    from bench.io.emulated.devices import EscsOnBus
    from bench.io.emulated.slcan import SlcanOnLine
    from bench.io.kinds.crossed import crossed
    from bench.io.serial_port import open_serial

    if args.arm and args.bus is None:
        raise UsageError("--arm: goes with --bus; behind an adapter without one there is nothing real that could move")
    robot = load_robot(args.robot) if args.robot is not None else None
    if args.bus is not None:
        return _slcan_to_bus(args, robot)
    bus, far = crossed()
    line = open_serial("address", args.address)
    devices: list[Device] = [SlcanOnLine(line, bus)]
    if robot is not None:
        devices.append(EscsOnBus(robot, far))
    behind = f"with the ESCs of {robot.name} behind it" if robot is not None else "on an empty bus"
    return devices, _told(f"SLCAN adapter {behind}, on", args.address, line.where, line.note)


def _slcan_to_bus(args: argparse.Namespace, robot: Robot | None) -> tuple[list[Device], dict[str, object]]:
    """A bridge. Whoever is on the line is no part of the bench, so the last line before real motors is ours to hold."""
    from bench.errors import UsageError
    from bench.io.address import can_address
    from bench.io.can_port import open_can
    from bench.io.emulated.slcan import SlcanOnLine
    from bench.io.limiter import Limiter, refuse_unarmed
    from bench.io.serial_port import open_serial

    refuse_unarmed("--bus", args.bus, args.arm)
    if robot is None and not can_address("--bus", args.bus, outside=True).is_harmless:
        raise UsageError(
            f"--bus {args.bus}: nothing says what motors there may take; add --robot, whose current limit then holds"
        )
    bus = open_can("--bus", args.bus)
    try:
        line = open_serial("address", args.address)
    except BaseException:
        bus.close()
        raise
    within = f", within the limits of {robot.name}" if robot is not None else ""
    device = SlcanOnLine(line, bus, limiter=Limiter(robot) if robot is not None else None)
    return [device], _told(f"SLCAN adapter to {args.bus}{within}, on", args.address, line.where, line.note)


def _base(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.config import load_robot
    from bench.io.emulated.devices import BaseOnLine
    from bench.io.serial_port import open_serial

    robot = load_robot(args.robot)
    line = open_serial("address", args.address)
    return [BaseOnLine(robot, line)], _told(f"SLAMWARE base {robot.name} on", args.address, line.where, line.note)


def _firmware(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.config import load_robot
    from bench.errors import UsageError
    from bench.io.can_port import open_can
    from bench.io.emulated.devices import FirmwareOnPorts
    from bench.io.limiter import refuse_arming_by_link, refuse_unarmed
    from bench.io.serial_port import open_serial
    from bench.rc.line import USUAL

    robot = load_robot(args.robot)
    if args.rc and robot.rc is None:
        raise UsageError(f"--rc: {robot.name} takes no RC; leave it out, or take a robot whose file has an rc")
    refuse_unarmed("--can", args.can, args.arm)
    refuse_arming_by_link("--can", args.can, robot)
    bus = open_can("--can", args.can)
    rc = open_serial("--rc", args.rc, USUAL[robot.rc.protocol]) if args.rc and robot.rc else None
    slamware = open_serial("--slamware", args.slamware) if args.slamware else None
    where = ", ".join(port.where or port.name for port in (bus, rc, slamware) if port is not None)
    device = FirmwareOnPorts(robot, bus, rc, slamware)
    return [device], _told(f"base controller of {robot.name} on", where, "", bus.note)


def _core(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.errors import UsageError
    from bench.io.emulated.devices import CoreOnLine
    from bench.io.serial_port import open_serial

    if args.poll_ms < 1:
        raise UsageError(f"--poll-ms {args.poll_ms}: expected 1 or more")
    twists = _twists(args.twist, args.source)
    line = open_serial("address", args.address)
    return [CoreOnLine(line, twists, args.poll_ms)], _told("SLAMWARE core on", args.address, line.where, line.note)


def _receiver(args: argparse.Namespace) -> tuple[list[Device], dict[str, object]]:
    from bench.config import load_profile
    from bench.io.emulated.devices import ReceiverOnLine
    from bench.io.serial_port import open_serial
    from bench.rc.line import USUAL

    profile = load_profile(args.profile) if args.profile is not None else _usual_profile(args.protocol)
    frames = _frames(args.source, profile)
    settings = USUAL[profile.protocol]
    repeat = max(frames) + profile.period_ms if args.repeat or args.source is None else None
    line = open_serial("address", args.address, settings)
    device = ReceiverOnLine(line, profile.protocol, frames, settings, repeat)
    wire = "; real ones invert it, which no port can: put an inverter in" if settings.inverted else ""
    what = f"{profile.protocol} receiver ({profile.name}, {settings._replace(inverted=False)}{wire}) on"
    return [device], _told(what, args.address, line.where, line.note)


_BUILD: Mapping[str, Callable[[argparse.Namespace], tuple[list[Device], dict[str, object]]]] = {
    "escs": _escs,
    "slcan": _slcan,
    "base": _base,
    "firmware": _firmware,
    "core": _core,
    "receiver": _receiver,
}


def _told(what: str, address: str, where: str, note: str) -> dict[str, object]:
    """The first line: for people its values in order, for programs by name."""
    return {"what": what, "where": where or address, "note": f"({note})" if note else ""}


def _twists(twist: str | None, source: Path | None) -> dict[int, BodyTwist]:
    from bench.check.scenario import MOST_ON_THE_WIRE, load_scenario
    from bench.errors import UsageError
    from bench.messages import BodyTwist

    if source is not None:
        return dict(load_scenario(source).core)
    try:
        vx_mps, vy_mps, omega_radps = map(float, (twist or "0.1,0,0").split(","))
    except ValueError:
        raise UsageError(f"--twist {twist}: expected VX,VY,OMEGA such as 0.1,0,0") from None
    if not all(abs(value) <= MOST_ON_THE_WIRE for value in (vx_mps, vy_mps, omega_radps)):
        raise UsageError(f"--twist {twist}: expected numbers from -{MOST_ON_THE_WIRE} to {MOST_ON_THE_WIRE}")
    return {0: BodyTwist(vx_mps, vy_mps, omega_radps)}


def _usual_profile(protocol: str) -> Profile:
    """One of ours that speaks it. Raises UsageError."""
    from bench.cli.choices import check_protocol
    from bench.config import load_profile, profile_names

    check_protocol(protocol)
    fitting = [known for known in map(load_profile, profile_names()) if known.protocol == protocol]
    return min(fitting, key=lambda known: known.aux1 is None)  # one that can arm, where there is one


def _frames(source: Path | None, profile: Profile) -> dict[int, bytes]:
    """The bytes of each tick that has any, in the profile's protocol."""
    from bench.check.scenario import load_scenario
    from bench.check.sources import robot_of
    from bench.errors import UsageError
    from bench.rc.capture import by_tick, load_capture
    from bench.rc.retransmit import retransmitted
    from bench.rc.transmitter import sent_by_tick

    if source is None:
        return sent_by_tick(profile, (), 1)
    read_by, path = None, source
    if source.suffix == ".toml":
        scenario = load_scenario(source)
        if scenario.rc is None:
            return sent_by_tick(profile, scenario.sticks, scenario.ticks)
        path = scenario.rc
        read_by = robot_of(scenario).rc
    capture = load_capture(path)
    protocol = capture.protocol or (read_by.protocol if read_by else profile.protocol)
    if read_by is None or read_by.protocol != protocol:
        read_by = _usual_profile(protocol)
    stream = by_tick(capture, protocol, read_by.period_ms)
    frames = stream if protocol == profile.protocol else retransmitted(stream, read_by, profile)
    if not frames:
        raise UsageError(f"{source}: holds no frame to send")
    return frames
