"""What the axes and buttons of a gamepad mean: a small TOML file, one of ours or the user's own. docs/driving.md."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bench.config.named import named_file
from bench.config.table import Table, read_toml

GAMEPADS_DIR = Path(__file__).parents[1] / "gamepads"
MOST_AXES, MOST_BUTTONS = 64, 512
"""The kernel's own limits (ABS_CNT, KEY_MAX - BTN_MISC)."""


@dataclass(frozen=True, slots=True)
class PadAxis:
    """An axis by the kernel's number, reversed where it counts right or down."""

    axis: int
    reversed: bool = False


@dataclass(frozen=True, slots=True)
class GamepadMap:
    """Which axis is which stick, which button does what. Buttons that are None do not exist."""

    name: str
    forward: PadAxis
    left: PadAxis
    turn: PadAxis
    arm: int
    stop: int
    about: str = ""
    dead_band: float = 0.12
    field_centric: int | None = None
    hold: int | None = None
    """Sticks count only while it is pressed."""


def load_gamepad_map(name_or_path: str | Path) -> GamepadMap:
    """Read and check a gamepad's map, by name or by path. Raises ConfigError with file, key and what to try."""
    path = named_file(name_or_path, GAMEPADS_DIR, "gamepad map")
    data = Table(path, "", read_toml(path))
    data.take_schema()
    table = data.table("buttons")
    sticks = {name: _axis(data.table(name)) for name in ("forward", "left", "turn")}
    buttons = {name: _button(table, name) for name in ("arm", "stop")}
    buttons |= {name: _button(table, name) for name in ("field_centric", "hold") if table.has(name)}
    table.refuse_rest()
    found = data.into(GamepadMap, **sticks, **buttons)
    if not 0.0 <= found.dead_band <= 0.5:
        raise data.fail("dead_band", f"expected 0 to 0.5, got {found.dead_band}")
    if len(set(buttons.values())) < len(buttons):
        raise data.fail("buttons", "one button cannot do two things")
    return found


def _axis(table: Table) -> PadAxis:
    axis = table.into(PadAxis)
    if not 0 <= axis.axis < MOST_AXES:
        raise table.fail("axis", f"expected 0 to {MOST_AXES - 1}, got {axis.axis}")
    return axis


def _button(table: Table, name: str) -> int:
    number: int = table.get(name, int)
    if not 0 <= number < MOST_BUTTONS:
        raise table.fail(name, f"expected 0 to {MOST_BUTTONS - 1}, got {number}")
    return number
