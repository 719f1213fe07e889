"""What `--controller C` and `controller = "C"` name: who stands behind the seam. One option, one meaning everywhere.

    speed-loop, current-as-printed, ...   our base, with a printed form in the place of the speed loop (docs/errata.md)
    no-timeout, wheel-swap, ...           our base, wrong on purpose (`subjects`)
    path/to/file.py:NAME, module:NAME     somebody's own: NAME(robot) gives a `bench.base.ControlledBase`
    path/to/project.toml                  somebody's own in C, compiled and run in a process of its own (`bench.dut`)

A base of somebody's own is held at arm's length: what it raises, or gives that is no frame, ends the run with one
sentence that names its file and line. What was recorded until then stays.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import os
import sys
import sysconfig
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, TypeAlias

from bench.base import Base, ControlledBase
from bench.check.subjects import SUBJECTS
from bench.config import CONTROL_KINDS, SPEED_LOOP, Robot, nearest, with_choices
from bench.errors import ControllerFailed, UsageError, spelt
from bench.messages import CanFrame

Build: TypeAlias = Callable[[Robot], ControlledBase]

HIGHEST_ID, MOST_BYTES = 0x7FF, 8
"""Of a classic CAN frame with an 11-bit identifier."""
_OUR_FOLDER = Path(__file__).parents[1]
_LIBRARIES = tuple(Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib"))


class Controller(NamedTuple):
    """Who stands behind the seam."""

    robot: Robot
    """The robot, with the printed form where one was chosen."""
    build: Build
    """Makes the base. `Base` itself is the bench's own."""
    name: str | None
    """What run.toml calls it; None: the bench's own."""


def is_own(text: str | None) -> bool:
    """Whether this names a base of somebody's own."""
    return text is not None and (":" in text or text.endswith((".py", ".toml")))


def controller_of(robot: Robot, text: str | None, folder: Path = Path()) -> Controller:
    """The controller that a name means; a file is looked for in `folder`. Raises UsageError with the nearest name."""
    if text is not None and text.endswith(".toml"):
        from bench.dut.firmware import firmware_of

        firmware = firmware_of(folder / text)
        return Controller(robot, firmware, firmware.controller_name)
    if text is not None and is_own(text):
        factory = load_factory(text, folder)
        return Controller(robot, _Guarding(factory, text), name_of(factory))
    if text is not None and text in SUBJECTS:
        return Controller(robot, SUBJECTS[text], text)
    if text is not None and text not in CONTROL_KINDS:
        known = [*CONTROL_KINDS, *SUBJECTS]
        raise UsageError(
            f"no controller is called {text!r}{nearest(text, known)} (or give your own: FILE.py:NAME, FILE.toml)"
        )
    chosen = with_choices(robot, text)
    kind = chosen.control.kind
    return Controller(chosen, Base, kind if kind != SPEED_LOOP else None)


def at_full_speed(base: ControlledBase) -> AbstractContextManager[None]:
    """What a base needs for a run that waits for nobody: a firmware's process shares our core."""
    kept: Callable[[], AbstractContextManager[None]] = getattr(base, "kept_on_one_core", nullcontext)
    return kept()


def hears_no_core(build: Build) -> bool:
    """Whether a base is known to have no SLAMWARE line: a firmware whose [wires] name none."""
    return bool(getattr(build, "hears_no_core", False))


def name_of(factory: object) -> str | None:
    """What a recording calls a factory: "file.py:NAME", without the folder, which is the machine's; None: ours."""
    if factory is Base:
        return None
    if isinstance(called := getattr(factory, "controller_name", None), str):  # a firmware's
        return called
    try:
        file = Path(inspect.getfile(factory)).name  # type: ignore[arg-type]
    except (TypeError, OSError):  # an instance with a __call__, or something from C
        file = Path(getattr(sys.modules.get(type(factory).__module__), "__file__", None) or "unknown").name
    name = getattr(factory, "__qualname__", type(factory).__qualname__)
    return f"{spelt(file)}:{name}"


def address_of(factory: object) -> str | None:
    """What `--controller` has to be given for this factory, from the current folder; None: it has no such name."""
    name = getattr(factory, "__qualname__", "<none>")
    try:
        file = Path(inspect.getfile(factory)).resolve()  # type: ignore[arg-type]
    except (TypeError, OSError):
        return None
    return None if "<" in name or file.suffix != ".py" else f"{os.path.relpath(file)}:{name}"


def load_factory(text: str, folder: Path = Path()) -> Callable[[Robot], Any]:
    """What "FILE.py:NAME" or "module:NAME" means. Raises UsageError; runs the user's file."""
    where, colon, name = text.rpartition(":")
    if not colon or not name or not where:
        where, name = text.strip(":"), ""
    module = _load_file(folder / where) if where.endswith(".py") else _load_module(where, folder)
    found: Any = module
    for part in name.split(".") if name else ():
        if not hasattr(found, part):
            raise UsageError(f"{text}: {where} has no {part!r}{nearest(part, _factories(found))}")
        found = getattr(found, part)
    if not name or not callable(found):
        choices = ", ".join(f"{where}:{choice}" for choice in _factories(module)[:5]) or f"{where}:NAME"
        what = "is not callable" if name else "does not say what makes the base"
        raise UsageError(f"{text}: {what}; give a class or function that takes the robot: {choices}")
    return found  # type: ignore[no-any-return]


def _factories(module: object) -> list[str]:
    """Names that could be meant: what is callable and made there."""
    own = getattr(module, "__name__", None)
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_") and callable(value) and getattr(value, "__module__", own) == own
    ]


def _load_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise UsageError(f"{path}: there is no such file; a controller is FILE.py:NAME or module:NAME")
    resolved = path.resolve()
    # Two files of one name are two modules; one file is loaded once.
    name = f"{path.stem}_{hashlib.sha256(os.fsencode(resolved)).hexdigest()[:8]}"
    known = sys.modules.get(name)
    if known is not None:
        return known
    spec = importlib.util.spec_from_file_location(name, resolved)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    _look_in(resolved.parent)  # for what the file imports from beside itself, as when Python runs it
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        del sys.modules[name]
        raise _not_loaded(str(path), error) from error
    return module


def _load_module(name: str, folder: Path) -> ModuleType:
    _look_in(folder.resolve())
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(f"{error.name}.")):
            raise UsageError(
                f"{name}: there is no such module here; install it, or give its file: path/to/file.py:NAME"
            ) from None
        raise _not_loaded(name, error) from error
    except BaseException as error:
        raise _not_loaded(name, error) from error


def _look_in(folder: Path) -> None:
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


def _not_loaded(what: str, error: BaseException) -> BaseException:
    if isinstance(error, KeyboardInterrupt):
        return error
    return UsageError(f"{what}: cannot be loaded: {_told(error)}; --traceback shows all of it")


# --- at arm's length -------------------------------------------------------------------------------------------------


class _Guarding:
    """Builds bases of a factory, each held at arm's length."""

    def __init__(self, factory: Callable[[Robot], Any], text: str) -> None:
        self._factory, self._text = factory, text

    def __call__(self, robot: Robot) -> ControlledBase:
        try:
            base = self._factory(robot)
        except Exception as error:
            raise ControllerFailed(
                f"{self._text}: did not come up: {_told(error)}; --traceback shows all of it"
            ) from error
        step = getattr(base, "step", None)
        if not callable(step):
            raise UsageError(
                f"{self._text}: gives {type(base).__name__!r}, which has no step(tick, rc_bytes, slamware_bytes, "
                "can_in); docs/scenarios.md shows one"
            )
        guarded = _Guarded(step)
        if isinstance(base, Base):  # one of ours with something changed: what it knows is shown as ever
            base.step = guarded.step  # type: ignore[method-assign]
            return base
        return guarded


class _Guarded:
    """A foreign base's `step`, with its errors told in one sentence, and its answer in the bench's own types."""

    def __init__(self, step: Callable[..., Any]) -> None:
        self._step = step

    def step(
        self, tick: int, rc_bytes: bytes, slamware_bytes: bytes, can_in: Sequence[CanFrame]
    ) -> tuple[tuple[CanFrame, ...], bytes]:
        """As `ControlledBase.step`. Raises ControllerFailed."""
        try:
            given = self._step(tick, rc_bytes, slamware_bytes, can_in)
        except (Exception, SystemExit) as error:
            raise ControllerFailed(
                f"the controller failed at tick {tick} ({tick / 1000:.3f} s): {_told(error)}; "
                "--traceback shows all of it"
            ) from error
        return _checked(given, tick)


def _checked(given: Any, tick: int) -> tuple[tuple[CanFrame, ...], bytes]:
    """(frames, bytes) as a wire carries them. Raises ControllerFailed that says what they are instead."""
    try:
        can_out, slamware_out = given
        frames = tuple([(can_id, bytes(memoryview(data))) for can_id, data in can_out])
        answer = bytes(memoryview(slamware_out))
    except (TypeError, ValueError):
        raise ControllerFailed(
            f"the controller gave no frames at tick {tick}: step gives ((id, data), ...) and bytes, not {given!r:.60}"
        ) from None
    for can_id, data in frames:
        if type(can_id) is not int or not 0 <= can_id <= HIGHEST_ID or len(data) > MOST_BYTES:
            raise ControllerFailed(
                f"the controller gave a frame at tick {tick} that no bus carries: id {can_id!r}, {len(data)} bytes; "
                f"an id is 0 to 0x{HIGHEST_ID:X}, and a frame holds at most {MOST_BYTES} bytes"
            )
    return frames, answer


def _told(error: BaseException) -> str:
    """What was raised and in which line of the user's own files."""
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.msg} in {Path(error.filename).name}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    foreign = [frame for frame in frames if not Path(frame.filename).is_relative_to(_OUR_FOLDER)]
    theirs = [frame for frame in foreign if not _is_library(Path(frame.filename))] or foreign
    if not theirs:
        return what
    return f"{what.splitlines()[0]} in {Path(theirs[-1].filename).name}:{theirs[-1].lineno} ({theirs[-1].name})"


def _is_library(path: Path) -> bool:
    if not path.is_absolute():  # <frozen importlib._bootstrap>
        return True
    return any(path.is_relative_to(folder) for folder in _LIBRARIES)
