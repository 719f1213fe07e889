"""Draws what docs/plant.md shows of the robots' speed loops, into docs/pictures/.

    pip install -e '.[pictures]'
    python scripts/pictures.py

The same picture comes out the same to the byte, with one version of matplotlib.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from arguments import end_with, parser
from tune import PUSHED_TICKS, response

from bench.config import Robot, load_robot

try:
    import matplotlib
    import matplotlib.pyplot as plt
except ImportError:
    plt = None

FOLDER = Path(__file__).parents[1] / "docs" / "pictures"
ROBOTS = ("m2006", "mecanum", "siegwart")
AXES = (("forward", "m/s"), ("to the left", "m/s"), ("turning", "rad/s"))
EVERY = 6
"""Of the ticks, one is drawn."""
WANTED, IS, LIMIT, PRINTED = "#8a93a0", "#1f4e79", "#c0392b", "#d98200"
WHEELS = ("#1f4e79", "#d98200", "#3a8f5c", "#8e4fa8", "#7f8b98")
STYLE = {
    "svg.hashsalt": "wheelbench",
    "svg.fonttype": "path",
    "path.simplify_threshold": 0.5,
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "axes.edgecolor": "#8a93a0",
    "axes.titlesize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def draw_steps(robot: Robot) -> Any:
    """A stick pushed and let go, along each axis: speed above, the wheels' currents below."""
    figure, panels = plt.subplots(2, 3, figsize=(10, 4.7), sharex=True)
    for axis, (name, unit) in enumerate(AXES):
        samples = response(robot, axis)
        speed, current = panels[0][axis], panels[1][axis]
        _plot(speed, [sample.wanted for sample in samples], color=WANTED, linestyle="--", label="wanted")
        _plot(speed, [sample.is_ for sample in samples], color=IS, label="robot")
        speed.set_title(f"{name}, {unit}", loc="left")
        for wheel, (place, colour) in enumerate(zip(robot.wheels, WHEELS, strict=False)):
            amperes = [sample.currents_a[wheel] for sample in samples]
            _plot(current, amperes, color=colour, label=place.name, linewidth=1.0)
        for sign in (1, -1):
            current.axhline(sign * robot.limits.current_a, color=LIMIT, linewidth=0.8, linestyle=":")
        current.set_ylim(-1.15 * robot.limits.current_a, 1.15 * robot.limits.current_a)
        current.set_title("currents, A; dotted: the limit", loc="left")
        current.set_xlabel("s")
    panels[0][0].text(PUSHED_TICKS / 1000.0 + 0.05, panels[0][0].get_yticks()[-2], "let go", color=WANTED, va="center")
    panels[0][2].legend(loc="upper right")
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    figure.legend(*panels[1][2].get_legend_handles_labels(), loc="lower center", ncols=len(robot.wheels))
    return figure


def draw_controllers(robot: Robot) -> Any:
    """Document 004's current proportional to speed, beside the speed loop: forward, and turning."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 2.8), sharex=True)
    printed = replace(robot, control=replace(robot.control, kind="current-as-printed"))
    for panel, axis in zip(panels, (0, 2), strict=True):
        loop = response(robot, axis)
        _plot(panel, [sample.wanted for sample in loop], color=WANTED, linestyle="--", label="wanted")
        _plot(panel, [sample.is_ for sample in loop], color=IS, label="speed loop")
        _plot(panel, [sample.is_ for sample in response(printed, axis)], color=PRINTED, label="as printed")
        name, unit = AXES[axis]
        panel.set_title(f"{name}, {unit}", loc="left")
        panel.set_xlabel("s")
    panels[1].legend(loc="upper right")
    figure.tight_layout()
    return figure


def main() -> int:
    """Draw them all."""
    parser(__doc__).parse_args()
    if plt is None:
        print("scripts/pictures.py needs matplotlib: pip install -e '.[pictures]'", file=sys.stderr)
        return 3
    matplotlib.use("svg")
    with plt.rc_context(STYLE):
        for name in ROBOTS:
            _save(draw_steps(load_robot(name)), f"steps-{name}")
        _save(draw_controllers(load_robot("m2006")), "current-as-printed")
    return 0


def _plot(panel: Any, values: list[float], **how: Any) -> None:
    seconds = [tick / 1000.0 for tick in range(0, len(values), EVERY)]
    panel.plot(seconds, values[::EVERY], **how)
    panel.axvline(PUSHED_TICKS / 1000.0, color="#c8ccd2", linewidth=0.8)


def _save(figure: Any, name: str) -> None:
    path = FOLDER / f"{name}.svg"
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    print(path.relative_to(FOLDER.parents[1]))


if __name__ == "__main__":
    end_with(main)
