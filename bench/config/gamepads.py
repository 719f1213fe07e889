"""What the axes and buttons of a gamepad mean: a small TOML file, one of ours or the user's own. docs/driving.md."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bench.config.table import ConfigError, Table, nearest, read_toml

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
    about: str
    dead_band: float
    forward: PadAxis
    left: PadAxis
    turn: PadAxis
    arm: int
    stop: int
    field_centric: int | None = None
    hold: int | None = None
    """Sticks count only while it is pressed."""


def gamepad_names() -> list[str]:
    """Names of the maps that come with wheelbench."""
    return sorted(path.stem for path in GAMEPADS_DIR.glob("*.toml"))


def load_gamepad_map(name_or_path: str | Path) -> GamepadMap:
    """Read and check a gamepad's map, by name or by path. Raises ConfigError with file, key and what to try."""
    text, names = str(name_or_path), gamepad_names()
    path = GAMEPADS_DIR / f"{text}.toml" if text in names else Path(name_or_path)
    if text not in names and path.suffix != ".toml" and not path.exists():
        raise ConfigError(f"no gamepad map is called {text!r}{nearest(text, names)} (or give the path of a .toml file)")
    data = Table(path, "", read_toml(path))
    data.take_schema()
    buttons = data.table("buttons")
    found = GamepadMap(
        name=data.get("name", str),
        about=data.get("about", str, ""),
        dead_band=data.get("dead_band", float, 0.12),
        **{stick: _axis(data.table(stick)) for stick in ("forward", "left", "turn")},
        arm=_button(buttons, "arm"),
        stop=_button(buttons, "stop"),
        field_centric=_button(buttons, "field_centric") if buttons.has("field_centric") else None,
        hold=_button(buttons, "hold") if buttons.has("hold") else None,
    )
    buttons.refuse_rest()
    data.refuse_rest()
    if not 0.0 <= found.dead_band <= 0.5:
        raise data.fail("dead_band", f"expected 0 to 0.5, got {found.dead_band}")
    used = [number for number in (found.arm, found.stop, found.field_centric, found.hold) if number is not None]
    if len(set(used)) < len(used):
        raise data.fail("buttons", "one button cannot do two things")
    return found


def _axis(table: Table) -> PadAxis:
    axis = PadAxis(table.get("axis", int), table.get("reversed", bool, False))
    table.refuse_rest()
    if not 0 <= axis.axis < MOST_AXES:
        raise table.fail("axis", f"expected 0 to {MOST_AXES - 1}, got {axis.axis}")
    return axis


def _button(table: Table, name: str) -> int:
    number: int = table.get(name, int)
    if not 0 <= number < MOST_BUTTONS:
        raise table.fail(name, f"expected 0 to {MOST_BUTTONS - 1}, got {number}")
    return number
