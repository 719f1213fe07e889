"""`wheelbench drive`: the dashboard. Drive the simulated robot by keyboard, or watch a recording run again."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bench.cli.choices import add_choices, add_role, check_arm
from bench.cli.output import say
from bench.errors import spelt

if TYPE_CHECKING:
    from bench.check.run import Run
    from bench.config import Robot
    from bench.screen.keyboard import Keyboard
    from bench.screen.session import Session
    from bench.screen.settings import SettingsFile
    from bench.screen.stage import Show

WEB_PORT = 8000
HELP = "the dashboard: drive the simulated robot by keyboard, or watch a recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("--robot", metavar="R", help="a name that `wheelbench robots` lists, or a .toml file (m2006)")
    parser.add_argument("--arena", metavar="FILE", help="where it drives: an arena file (docs/plant.md)")
    parser.add_argument("--profile", metavar="P", help="the transmitter that the keys play: a name or a .toml file")
    parser.add_argument(
        "--gamepad",
        metavar="DEVICE",
        nargs="?",
        const="auto",
        help="drive by a gamepad: a joystick node (the first, if none is named), or evdev:/dev/input/eventN",
    )
    parser.add_argument("--gamepad-map", metavar="MAP", help="what its axes and buttons mean: a name or a .toml file")
    add_choices(parser)
    parser.add_argument("--record", metavar="DIR", type=Path, help="record the run")
    parser.add_argument("--overwrite", action="store_true", help="replace the recording that DIR holds")
    parser.add_argument("--replay", metavar="DIR", type=Path, help="show a recording instead; it runs again, checked")
    parser.add_argument(
        "--can", metavar="FROM", default="sim", help="with --role: the bus; with --replay: recorded, its own feedback"
    )
    parser.add_argument(
        "--rc", metavar="PORT", default="sim:", help="a real receiver that drives; with --role base: where its own is"
    )
    parser.add_argument("--slamware", metavar="PORT", default="sim:", help="with --role: where core or base is")
    add_role(parser)
    parser.add_argument("--web", action="store_true", help="in a browser on this machine (needs the extra `web`)")
    parser.add_argument("--port", metavar="N", type=int, default=WEB_PORT, help=f"with --web: its port ({WEB_PORT})")


def run(args: argparse.Namespace) -> int:
    """Open the dashboard."""
    from bench.cli.terminal import has_terminal
    from bench.errors import SurroundingsError, UsageError

    if args.can == "sim":
        args.can = "sim:"
    check_arm(args.role, args.arm)
    if args.role != "sim" and args.replay is not None:
        raise UsageError("--replay: a recording is watched, not driven; leave --role out")
    if args.role == "sim" and args.can not in ("sim:", "recorded"):
        raise UsageError(f"--can {args.can}: goes with --role base or --role motors")
    if args.replay is None and args.can == "recorded":
        raise UsageError("--can recorded: goes with --replay DIR; while driving, feedback comes from the plant")
    if args.replay is not None and (args.robot is not None or args.profile is not None):
        raise UsageError("--replay: a recording brings its own robot and profile; leave --robot and --profile out")
    if args.replay is not None and args.arena is not None:
        raise UsageError("--replay: a recording brings its own arena; leave --arena out")
    if args.replay is not None and (args.odometry or not _may_replay(args.controller)):
        raise UsageError("--replay: a recording brings its own controller and odometry; leave those options out")
    if args.replay is not None and (args.gamepad is not None or args.rc != "sim:"):
        raise UsageError("--replay: nothing drives a recording; leave --gamepad and --rc out")
    if args.gamepad_map is not None and args.gamepad is None:
        raise UsageError("--gamepad-map: goes with --gamepad")
    if args.web:
        return _serve(args)
    if not has_terminal() and not _in_browser():
        raise SurroundingsError(
            "needs a terminal on stdin, stdout and stderr; without one use `wheelbench demo` or `wheelbench replay`"
        )
    from bench.screen.remembered import settings_path

    # Devices are opened, and others' code started, before the screen: what is wrong with them is told at once.
    if args.replay is not None:
        from bench.screen.opening import opening_of_recording
        from bench.tui import show

        opening = opening_of_recording(args.replay) if args.controller is None else None
        return show(lambda: _watched(args), opening, _tell)
    if args.role != "sim":
        return _drive_ports(args)
    from bench.screen.opening import opening_of

    waits = args.controller is not None or args.gamepad is not None or args.rc != "sim:"
    opening = None if waits else opening_of(args.robot, args.profile, settings_path(), args.arena)
    from bench.tui import drive

    return drive(lambda: _session(args), opening, _tell)


def _watched(args: argparse.Namespace) -> Show:
    """The recording that was asked for, to be shown again."""
    from bench.check.sources import from_recording
    from bench.screen.remembered import settings_path
    from bench.screen.settings import SettingsFile
    from bench.screen.stage import Show

    job = from_recording(args.replay, recorded_can=args.can == "recorded", controller=args.controller)
    recorder = job.recorder(args.record, overwrite=args.overwrite) if args.record else None
    return Show(job, recorder, settings=SettingsFile(settings_path()))


def _drive_ports(args: argparse.Namespace) -> int:
    from bench.cli.on_ports import driven_link
    from bench.screen.remembered import settings_path
    from bench.screen.settings import SettingsFile

    job, keyboard = _job(args, SettingsFile(settings_path()))
    link = driven_link(args, job)  # before the screen: its process shall have nothing of that
    from bench.tui import drive_ports

    return drive_ports(link, job, keyboard, str(args.record or ""), tell=_tell)


def _session(args: argparse.Namespace) -> Session:
    """The bench that was asked for, with somebody at the keys."""
    from bench.io.clock import WallPacer
    from bench.screen.remembered import settings_path
    from bench.screen.session import session_of
    from bench.screen.settings import SettingsFile
    from bench.screen.stage import to_drive

    settings = SettingsFile(settings_path())
    job, keyboard = _job(args, settings)
    recorder = job.recorder(args.record, overwrite=args.overwrite) if args.record else None
    return session_of(to_drive(job, keyboard, WallPacer()), recorder, settings)


def _job(args: argparse.Namespace, settings: SettingsFile) -> tuple[Run, Keyboard]:
    from bench.arena import FIELD, load_arena
    from bench.check.controllers import controller_of
    from bench.check.run import Run, bench_in, info_of
    from bench.config import with_choices

    chosen = controller_of(_robot(args, settings), args.controller)
    robot = with_choices(chosen.robot, None, args.odometry)
    arena = load_arena(args.arena) if args.arena is not None else FIELD
    keyboard = _hands(args, robot)
    info = info_of(robot, chosen.name)
    title = ", ".join(filter(None, (robot.name, info.controller, info.odometry)))
    bench = bench_in(robot, arena, build=chosen.build)
    return Run(title=title, bench=bench, ticks=0, inputs=keyboard.inputs, info=info), keyboard


def _may_replay(controller: str | None) -> bool:
    """Whether a recording may be run with it: with no other of our own."""
    if not controller:
        return True
    from bench.check.controllers import is_own

    return is_own(controller)


def _in_browser() -> bool:
    """Whether this is the process of a page: textual-serve says so."""
    return bool(os.environ.get("TEXTUAL_DRIVER"))


def _tell(line: str) -> None:
    # A page's stdout belongs to textual-serve, which passes on what it finds on stderr.
    print(spelt(line), file=sys.stderr if _in_browser() else sys.stdout)


def _serve(args: argparse.Namespace) -> int:
    """The same dashboard to a browser: each page starts this command again, without --web."""
    from bench.errors import EXIT_OK, SurroundingsError, UsageError

    if args.role != "sim":
        raise UsageError("--web: drives the simulated robot; real parts want a terminal, whose silence stops them")
    if not 1 <= args.port <= 65535:
        raise UsageError(f"--port: expected 1 to 65535, got {args.port}")
    try:
        from bench.screen.web import DashboardServer, record_directory
    except ImportError as error:
        raise SurroundingsError(f"--web: {error.name} is not installed; pip install 'wheelbench[web]'") from None

    def command(drive: int) -> list[str]:
        words = [sys.executable, "-m", "bench", "drive"]
        for name in _PASSED_ON:
            value = getattr(args, name)
            words += [f"--{name.replace('_', '-')}", str(value)] if value is not None else []
        words += ["--record", str(record_directory(args.record, drive))] if args.record is not None else []
        return words + (["--overwrite"] if args.overwrite else [])

    try:
        DashboardServer(command, args.port, lambda line: say(line, flush=True)).serve()
    except OSError as error:
        why = error.strerror or str(error)
        raise SurroundingsError(f"--web: port {args.port} cannot be used ({why}); give another --port") from None
    return EXIT_OK


_PASSED_ON = (
    "robot", "arena", "profile", "controller", "odometry", "replay", "can", "rc", "gamepad", "gamepad_map",
)  # fmt: skip
"""Options of a page's process that are those of the server."""


def _robot(args: argparse.Namespace, settings: SettingsFile) -> Robot:
    """The robot that was asked for; where none was, the one that is remembered, or the default."""
    from bench.config import ConfigError, load_robot

    remembered = settings.values
    if args.robot is None and remembered.robot:
        try:
            return load_robot(remembered.robot, args.profile or remembered.profile or None)
        except ConfigError as error:
            settings.why = f"the remembered robot is not there: {error}"
    return load_robot("m2006" if args.robot is None else args.robot, args.profile)


def _hands(args: argparse.Namespace, robot: Robot) -> Keyboard:
    """Keys, and whatever else is to drive."""
    from bench.config.gamepads import load_gamepad_map
    from bench.errors import UsageError
    from bench.io.gamepad import open_gamepad
    from bench.io.receiver import open_receiver
    from bench.screen.keyboard import Keyboard

    drives = args.rc != "sim:" and args.role == "sim"
    if robot.rc is None and (args.gamepad is not None or drives):
        raise UsageError(f"--gamepad, --rc: {robot.name} takes no RC; give it a transmitter with --profile")
    layout = load_gamepad_map(args.gamepad_map or "standard")
    gamepad = (open_gamepad(args.gamepad), layout) if args.gamepad is not None else None
    receiver = open_receiver(args.rc, robot.rc.protocol) if drives and robot.rc is not None else None
    return Keyboard(
        robot.rc,
        gamepad=gamepad,
        receiver=receiver,
        disarm_ms=robot.link.disarm_ms,
        core_is_real=args.role == "core",
    )
