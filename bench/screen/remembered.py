"""Where the dashboard keeps what it remembers of a person; `settings` says what that is."""

from __future__ import annotations

import os
from pathlib import Path


def settings_path() -> Path:
    """Where the file is, whether or not there is one."""
    home = os.environ.get("XDG_CONFIG_HOME", "")
    # The XDG specification: a relative path is to be ignored.
    return (Path(home) if os.path.isabs(home) else Path("~/.config").expanduser()) / "wheelbench" / "settings.toml"
