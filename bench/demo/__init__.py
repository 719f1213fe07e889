"""The demo's data: its scenario, its RC stream (made by scripts/make_demo.py), and where its golden lies."""

from __future__ import annotations

from pathlib import Path

SCENARIO = Path(__file__).parent / "demo.toml"


def golden_directory() -> Path:
    """The golden recording: inside the package where it is installed, in fixtures/ where it is a checkout."""
    installed = Path(__file__).parent / "golden"
    return installed if installed.is_dir() else Path(__file__).parents[2] / "fixtures" / "pinned" / "demo"
