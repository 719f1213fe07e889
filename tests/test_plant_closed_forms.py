"""Every row of `scripts/plant_checks.py`: the plant against closed forms of the reference plant model, and its page."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import plant_checks
from plant_rows.check import LAYOUTS, NO_LOSSES, first_step, robot_with
from plant_rows.grip import DIRECTIONS_DEG, GRIP_TABLE, grip_limit
from plant_rows.inertia import acceleration_under

ROWS = plant_checks.checks()
PAGE = Path(__file__).parents[1] / "docs" / "plant.md"


@pytest.mark.parametrize("check", ROWS, ids=[f"{row.section}: {row.name}" for row in ROWS])
def test_the_plant_does_what_the_closed_form_says(check):
    assert check.measure() == pytest.approx(check.expected, abs=check.allowed, rel=0.0)


def test_the_page_shows_these_rows_with_what_was_measured_within_what_is_allowed():
    lines = [line.strip("| ").split(" | ") for line in PAGE.read_text().splitlines() if line.startswith("|")]
    shown = {cells[0]: cells for cells in lines if len(cells) == 6}
    for row in ROWS:
        name, section, expected, measured, _, allowed = shown[row.name]
        assert (name, section) == (row.name, row.section)
        assert expected == f"{row.expected:.8g}"
        assert allowed == f"{row.allowed:.1e}"
        if not measured.startswith("below"):
            assert abs(float(measured) - row.expected) <= row.allowed * 1.01


@pytest.mark.parametrize("robot", GRIP_TABLE)
def test_the_bound_is_the_linear_programmes(robot):
    """Brute force over the vertices gives the page's table; half a unit of its last digit."""
    built = robot_with(LAYOUTS[robot])
    for deg, limit in zip(DIRECTIONS_DEG, GRIP_TABLE[robot], strict=True):
        assert grip_limit(built, deg)[0] == pytest.approx(limit, abs=6e-4)


def test_a_plant_that_forgets_reflected_inertia_would_fail():
    """The rows can fail: without the wheels' inertia the base would weigh 1.6 kg, not 4.672."""
    light = robot_with(motor_inertia_kgm2=1e-9, **NO_LOSSES)
    heavy = robot_with(**NO_LOSSES)
    torques = (0.02, 0.0, -0.02)
    share = acceleration_under(light, torques)[0] / acceleration_under(heavy, torques)[0]
    assert share == pytest.approx(4.672 / 1.6, abs=1e-3)
    got = first_step(heavy, [t / 0.18 for t in torques])[0]
    assert got != pytest.approx(acceleration_under(light, torques)[0], rel=0.5)
