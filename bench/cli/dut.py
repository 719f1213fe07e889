"""`wheelbench dut`: bring your own C. `init` writes a project file, `build` compiles what it names.

What runs a firmware are the verbs that run everything else: `--controller FILE.toml`.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.dut.start import Found


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    about = "write a project file and a port file into a firmware's folder"
    init = actions.add_parser("init", help=about, description=about)
    init.add_argument("folder", metavar="DIR", nargs="?", type=Path, default=Path(), help="the firmware's folder (.)")
    init.add_argument("--style", choices=("superloop", "interrupt", "rtos"), help="how it is built; else a guess")
    about = "compile a firmware for this machine; the compiler's warnings are shown"
    build = actions.add_parser("build", help=about, description=about)
    build.add_argument("project", metavar="FILE", type=Path, help="its project file (.toml)")
    for action in (init, build):
        action.add_argument("--json", action="store_true", help="what was done as one JSON object")


def run(args: argparse.Namespace) -> int:
    """Do it."""
    return _init(args) if args.action == "init" else _build(args)


def _init(args: argparse.Namespace) -> int:
    from bench.dut.start import PORT, PROJECT, start
    from bench.errors import EXIT_OK

    done = start(args.folder, args.style)
    if args.json:
        files = [str(path) for path in done.written]
        facts = {"style": done.style, "written": files, "sources": done.found.sources, "profile": done.found.receiver}
        print(json.dumps(facts))
        return EXIT_OK
    found = done.found
    if found.sources:
        say(
            f"{len(found.sources)} sources of yours, style {done.style}; left to the bench: {len(found.left_out)} files"
        )
    else:
        say("no C file there: one to begin with is written, for the default robot")
    for path in done.written:
        say(f"written   {path}")
    project = args.folder / PROJECT
    say(f"next      check {project}" + (f" and {args.folder / PORT}" if found.sources else ""))
    say(f"          wheelbench dut build {project}")
    say(f"          wheelbench failsafe --controller {project}" + _profile(found))
    return EXIT_OK


def _profile(found: Found) -> str:
    """The option that names the receiver, where it is not the one that a file to begin with is written for."""
    if not found.sources:
        return ""
    if found.receiver:
        return f" --profile {found.receiver}    # your receiver, by a guess"
    return " --profile P    # your receiver: `wheelbench robots` names them, in its last line"


def _build(args: argparse.Namespace) -> int:
    from bench.dut.build import build
    from bench.dut.project import load_project
    from bench.errors import EXIT_OK

    built = build(load_project(args.project))
    if args.json:
        facts = {
            "program": str(built.program),
            "compiled": built.is_new,
            "sources": [str(path) for path in built.project.sources],
            "warnings": built.warnings,
        }
        print(json.dumps(facts))
        return EXIT_OK
    if built.warnings:
        say(*built.warnings.rstrip().split("\n"))
    what = "compiled" if built.is_new else "is as it was"
    say(f"{built.project.name}: {len(built.project.sources)} sources, {what}: {built.program}")
    return EXIT_OK
