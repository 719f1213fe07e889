"""The plant beside closed forms: what it does, what it should do, and how far off it may be.

Each row runs the plant open loop and holds one number against the reference plant model (section beside it) or against
a formula of its section 2, evaluated here. No number on the right-hand side comes from the plant. docs/plant.md shows
the table; tests/test_plant_closed_forms.py runs every row. Exit status 1 where a row is out of bounds.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from arguments import end_with, parser
from plant_rows import grip, inertia, laws, speeds, walls
from plant_rows.check import Check

KINDS = {"inertia": inertia, "speeds": speeds, "grip": grip, "walls": walls, "laws": laws}
ROUNDING = 5e-13


def checks() -> list[Check]:
    """Every row, in the order of the page."""
    return [check for kind in KINDS.values() for check in kind.rows()]


def row_of(check: Check, measured: float) -> str:
    """A line of the table."""
    off = abs(measured - check.expected)
    # The last bits of a zero differ between platforms.
    ends = f"{measured:.8g} | {off:.0e}" if off >= ROUNDING or check.expected else f"below {ROUNDING:.0e} | -"
    return f"| {check.name} | {check.section} | {check.expected:.8g} | {ends} | {check.allowed:.1e} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; 1 where a row is out of bounds."""
    asked = parser(__doc__)
    asked.add_argument("--only", choices=list(KINDS), metavar="KIND", help=f"one of {', '.join(KINDS)}")
    only = asked.parse_args(arguments).only
    print("| check | section | expected | measured | off by | allowed |\n|---|---|---|---|---|---|")
    failed = 0
    for check in KINDS[only].rows() if only else checks():
        measured = check.measure()
        print(row_of(check, measured), flush=True)
        failed += not abs(measured - check.expected) <= check.allowed
    return 1 if failed else 0


if __name__ == "__main__":
    end_with(main)
