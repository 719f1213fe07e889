"""`wheelbench VERB ...`: finds the verb, hands over, and turns what went wrong into one sentence and an exit status.

Only the verb that was asked for is imported: `wheelbench --help` must not wait for a physics engine.
"""

from __future__ import annotations

if __name__ == "__main__":  # before anything that takes its time
    from bench.cli import interrupt

    interrupt.take_over()

import argparse
import errno
import importlib
import io
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn, TextIO

VERBS = {
    "demo": "the bench in one go: a recorded RC stream drives the default robot, checked against its golden",
    "drive": "the dashboard: drive the simulated robot by keyboard, or watch a recording",
    "replay": "run a scenario, an RC capture or a recording, headless, faster than real time",
    "check": "compare a recording with a golden, and say in words what differs",
    "parity": "one scenario, several bases that hear the same: where they part, in time and in value",
    "goldens": "what is pinned, whether it is whole, and what nothing is held against",
    "dut": "bring your own C: a firmware's project file, and its compiler",
    "failsafe": "every loss in every phase of a drive: does the robot stop when it must?",
    "decode": "any capture to decoded lines or JSON lines",
    "kin": "wheel speeds from a twist and back, matrices, conditioning",
    "errata": "the printed formulas of the source documents, run against geometry and the plant",
    "bus": "does it all fit on the motors' CAN bus: loads, worst-case response times, the verdict",
    "dbc": "a DBC of every message on the motors' CAN bus",
    "robots": "what can be driven",
    "emulate": "hardware for a driver or a firmware to talk to: ESCs, an SLCAN adapter, a base, a core, an RC receiver",
    "doctor": "what this machine can do: ports, permissions, terminal, clock; `doctor timing` measures punctuality",
}

FULL = (errno.ENOSPC, errno.EDQUOT)


def main(arguments: list[str] | None = None) -> int:
    """Run one command; returns its exit status: 0 ok, 1 expectation failed, 2 usage, 3 environment."""
    _prepare_streams()
    given = _with_negative_values(sys.argv[1:] if arguments is None else arguments)
    verb = given[0] if given else ""
    try:
        try:
            return _parse_and_run(verb, given)
        finally:
            sys.stdout.flush()  # what the last line meets is told here, not by the interpreter on its way out
    except KeyboardInterrupt:
        _tell(verb, "interrupted")
        return 130
    except BrokenPipeError:
        # Whoever read our output has left (`| head`): not an error of ours, and nothing more can be said to them.
        _drop(sys.stdout, sys.stderr)
        return 3
    except OSError as error:
        # The verbs tell what they meet at a file; this is what Path.is_dir and its like raise before that: a folder
        # that may not be entered, a name that is too long.
        if error.errno in FULL:
            _drop(sys.stdout)
            status, text = 3, f"output cannot be written ({error.strerror}); free some space"
        elif error.filename is not None:
            status, text = 2, f"{error.filename}: cannot be reached ({error.strerror}); check the path"
        else:
            raise
        _tell(verb, text)
        return status


def _tell(verb: str, text: str) -> None:
    """Where stderr takes no more either (a log on a full disk) the exit status still tells."""
    try:
        print(f"wheelbench {verb}: {text}", file=sys.stderr)
    except OSError:
        _drop(sys.stderr)


def _parse_and_run(verb: str, given: list[str]) -> int:
    parser = _parser(verb)
    args, unknown = parser.parse_known_args(given)
    if unknown:
        getattr(args, "parser", parser).error(f"unrecognized arguments: {' '.join(unknown)}")
    if args.verb is None:
        parser.print_help()
        return 2
    return _run(args)


def _prepare_streams() -> None:
    """A stream that our caller has closed (`2>&-`) is None: what is said there goes nowhere, and no other file. What a
    stream cannot spell (a file's name that is not UTF-8, an arrow in Latin-1) is spelt out.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 (for as long as we run)
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _drop(*streams: TextIO) -> None:
    """What is still in their buffers would fail again when the interpreter ends."""
    for stream in streams:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _run(args: argparse.Namespace) -> int:
    from bench.cli.interrupt import hand_over
    from bench.errors import BenchError, spelt

    hand_over()  # `main` catches it from here on, and what the verb opens shall be closed
    try:
        return int(args.run_verb(args))
    except BenchError as error:
        if getattr(args, "traceback", False) and error.__cause__ is not None:
            _print_whole(error.__cause__)
        # A compiler's own words are several lines.
        _tell(args.verb, "\n".join(map(spelt, str(error).split("\n"))))
        return error.exit_status


def _print_whole(error: BaseException) -> None:
    import traceback

    traceback.print_exception(error)


def _with_negative_values(arguments: list[str]) -> list[str]:
    """`--twist -1,0,0` as `--twist=-1,0,0`: argparse takes what begins with a dash for an option."""
    joined: list[str] = []
    for argument in arguments:
        if argument[:1] == "-" and argument[1:2] in tuple("0123456789.") and joined and joined[-1].startswith("--"):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


class _Parser(argparse.ArgumentParser):
    """Its sentences quote what was given, as ours do; so do those of its verbs' parsers."""

    def error(self, message: str) -> NoReturn:
        from bench.errors import spelt

        super().error(spelt(message))


def _parser(verb: str) -> argparse.ArgumentParser:
    parser = _Parser(
        prog="wheelbench",
        description="Test bench and RC teleop for omni-wheel robot bases: RC bytes in, SLAMWARE and CAN frames out.",
        epilog="wheelbench VERB --help tells about one verb. Start with: wheelbench demo",
    )
    parser.add_argument("--version", action="version", version=_version())
    verbs = parser.add_subparsers(dest="verb", metavar="VERB")
    # A known verb is the only one that is asked: each parser costs as much as a module.
    for name, help_text in {verb: VERBS[verb]}.items() if verb in VERBS else VERBS.items():
        sub = verbs.add_parser(name, help=help_text, description=_sentence(help_text))
        if name == verb:
            module = importlib.import_module(f"bench.cli.{name}")
            module.add_arguments(sub)
            sub.set_defaults(run_verb=module.run, parser=sub)
    return parser


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + ("" if text.endswith("?") else ".")


def _version() -> str:
    from bench import __version__

    return f"wheelbench {__version__}"


if __name__ == "__main__":
    interrupt.end_with(main)
