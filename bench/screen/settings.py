"""What the dashboard remembers of a person: `$XDG_CONFIG_HOME/wheelbench/settings.toml`, else under ~/.config.

    robot = "m2006"             # what `wheelbench drive` opens where no option says so; also profile
    power_percent = 50          # how far a key pushes its stick
    rate = 1.0                  # simulated seconds for one of the wall
    record_dir = "recordings"   # where R records and B saves; relative to where wheelbench is started
    hints_seen = 1              # so many of the first-run hints have been shown

A file that cannot be right is a sentence and the defaults; it is then left as it is.
"""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from bench.errors import UsageError

POWERS = (10, 100)
RATES = (0.1, 4.0)


@dataclass(frozen=True, slots=True)
class Settings:
    """The values; the defaults are those of a first run."""

    robot: str = ""
    profile: str = ""
    power_percent: int = 50
    rate: float = 1.0
    record_dir: str = ""
    hints_seen: int = 0


class SettingsFile:
    """Settings and where they are kept. `why` says in a sentence what is wrong with the file, if anything is."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.why = ""
        self.values = Settings()
        try:
            if path.exists():
                self.values = _read(path)
        except (UsageError, OSError, RuntimeError) as error:
            said = str(error) if isinstance(error, UsageError) else f"{path}: cannot be read"
            self.why = f"{said}; the defaults are used, and nothing is saved there"
        self._on_disk = self.values

    def change(self, **values: str | int | float) -> None:
        """Remember other values; `save` writes them."""
        self.values = replace(self.values, **values)  # type: ignore[arg-type]

    def save(self) -> str:
        """Write what has changed; a sentence where that cannot be done. A damaged file is not written over."""
        if self.why or self.values == self._on_disk:
            return ""
        from bench.config.emit import toml_text

        beside = self.path.with_suffix(f".{os.getpid()}")
        try:
            text = toml_text(asdict(self.values))
            self.path.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(text, encoding="utf-8")
            beside.replace(self.path)
        except UsageError as error:
            return f"{self.path}: the settings cannot be saved ({error})"
        except OSError as error:
            return f"{self.path}: the settings cannot be saved ({error.strerror})"
        self._on_disk = self.values
        return ""


def _read(path: Path) -> Settings:
    from bench.config import Table, read_toml

    table = Table(path, "", read_toml(path))
    found = table.into(Settings)
    for name, value, (least, most) in (("power_percent", found.power_percent, POWERS), ("rate", found.rate, RATES)):
        if not least <= value <= most:
            raise table.fail(name, f"expected {least:g} to {most:g}, got {value:g}")
    if found.hints_seen < 0:
        raise table.fail("hints_seen", f"expected 0 or more, got {found.hints_seen}")
    return found
