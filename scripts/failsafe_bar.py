"""Can the failsafe matrix fail? Ours must be green in every cell, each wrong controller red where its defect shows.

    scripts/failsafe_bar.py                    all of them; exit status 1 where a cell is not as expected
    scripts/failsafe_bar.py --only no-timeout  one of them

The robot is m2006 with an SBUS transmitter that has a failsafe flag and, for this, frozen_ms = 300: every loss can be
said. What is expected is written here, from what each controller does wrong; the matrix does not know it. The example
firmwares in C come with their own transmitters (without a compiler they are left out); frozen sticks they do not watch.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from arguments import at_least_one, end_with, parser, some_of

from bench.check.failsafe import PHASES, RED, Cell, losses, run_row
from bench.config import Robot, load_robot

FROZEN_MS = 300
MOVING = ("cruise", "strafe", "spin", "reversal")
ALONG = ("cruise", "strafe", "reversal")
RC_LOST = ("RC silent", "failsafe flag", "lost-frame flag", "all channels zero", "garbage")
SILENT = ("RC silent", "lost-frame flag", "garbage")
ALL = (
    *RC_LOST, "sticks frozen", "one byte lost", "core silent", "one ESC silent", "every ESC silent", "encoder stuck",
    "restart",
)  # fmt: skip


def cells(names: tuple[str, ...], phases: tuple[str, ...]) -> frozenset[tuple[str, str]]:
    """Every pair."""
    return frozenset((name, phase) for name in names for phase in phases)


EXPECTED: Mapping[str, frozenset[tuple[str, str]]] = {
    "ours": frozenset(),
    # It stops; what it lacks is the disarming, and that shows when the link is back.
    "stale-command-kept": cells(RC_LOST, MOVING),
    "failsafe-flag-ignored": cells(("failsafe flag",), MOVING),
    # Flag and zeros stop it, but it never disarms; it goes on when they end.
    "no-timeout": cells((*RC_LOST, "core silent"), MOVING),
    "resync-broken": cells(("one byte lost",), MOVING),
    # What a stuck encoder lets the integrators sum up has to be driven off when the sticks are let go.
    "integrator-wind-up": cells(("encoder stuck",), MOVING),
    # Where the loop asks for more than 0.6 A: in every start and brake along a line, in a spin where it brakes.
    "clamp-missing": cells(ALL, ALONG) | cells(tuple(set(ALL) - {"one byte lost", "restart"}), ("spin",)),
    # Equal wheel speeds turn the robot, whoever is who.
    "wheel-swap": cells(ALL, ALONG),
    "degrees-for-radians": cells(ALL, ("spin",)),
}


FIRMWARE = Path(__file__).resolve().parents[1] / "docs" / "examples" / "firmware"
PROFILES = {"superloop": "uart12", "interrupts": "frsky-sbus", "rtos": "flysky"}
FIRMWARES: Mapping[str, frozenset[tuple[str, str]]] = {
    "superloop": cells(("RC silent", "all channels zero", "garbage"), MOVING),
    "interrupts": cells(("failsafe flag",), MOVING),
    "rtos": cells(("RC silent",), MOVING),
    "superloop/fixed": frozenset(),
    "interrupts/fixed": frozenset(),
    "rtos/fixed": frozenset(),
}


def robot(name: str = "ours") -> Robot:
    """The robot of the bar; a firmware's has the transmitter that it understands."""
    if name in FIRMWARES:
        return load_robot("m2006", PROFILES[name.partition("/")[0]])
    found = load_robot("m2006", "frsky-sbus")
    assert found.rc is not None
    return replace(found, rc=replace(found.rc, frozen_ms=FROZEN_MS))


def row(number: int, name: str) -> list[Cell]:
    """One loss of one controller; a process of its own may run it."""
    controller = None if name == "ours" else name
    if name in FIRMWARES:
        style, _, variant = name.partition("/")
        controller = str(FIRMWARE / style / f"{variant or style}.toml")
    return run_row(robot(name), number, controller)


def main() -> int:
    """The command line; 0 where every cell is as expected."""
    expected = {**EXPECTED, **(FIRMWARES if shutil.which("cc") else {})}
    asked = parser(__doc__)
    asked.add_argument(
        "--only", type=some_of(expected), default=list(expected), metavar="A,B", help=f"some of {', '.join(expected)}"
    )
    asked.add_argument("--jobs", type=at_least_one, default=2, metavar="N", help="rows at a time (default 2)")
    given = asked.parse_args()
    rows, wrong = len(losses(robot())), 0
    with ProcessPoolExecutor(given.jobs) as pool:
        for name in given.only:
            matrix = [cell for cells in pool.map(row, range(rows), [name] * rows) for cell in cells]
            red = {(cell.loss, cell.phase) for cell in matrix if cell.verdict == RED}
            missing, surplus = expected[name] - red, red - expected[name]
            wrong += len(missing) + len(surplus)
            print(f"{name:<24}{len(red):>3} of {rows * len(PHASES)} red, {len(expected[name]):>3} expected", flush=True)
            for what, pairs in (("not red", missing), ("red, not expected", surplus)):
                for loss, phase in sorted(pairs):
                    why = next(cell.why for cell in matrix if (cell.loss, cell.phase) == (loss, phase))
                    print(f"    {what}: {loss}, {phase}: {'; '.join(why)}")
    print("every cell as expected" if not wrong else f"{wrong} cells are not as expected")
    return 1 if wrong else 0


if __name__ == "__main__":
    end_with(main)
