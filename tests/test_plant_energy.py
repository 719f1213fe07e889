"""Energy comes from the motors and nowhere else: reference plant model, 4.1 and 4.3, on every layout."""

import sys
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

from plant_rows.check import LAYOUTS, robot_with
from plant_rows.laws import energy

from bench.arena import Arena
from bench.messages import BodyTwist
from bench.plant import STEP_S, Plant


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_step_balances_and_no_friction_gives(layout):
    """Motor work + losses = change of kinetic energy, to rounding; dry, viscous, tyre and rolling work each <= 0."""
    imbalance_j, gain = energy(LAYOUTS[layout], steps=600, seed=5)
    assert imbalance_j < 1e-12
    assert gain < 1e-9


def kinetic_j(plant: Plant, robot) -> float:
    vx, vy, omega = plant.twist
    body = 0.5 * robot.body.mass_kg * (vx * vx + vy * vy) + 0.5 * robot.body.inertia_kgm2 * omega * omega
    return body + sum(0.5 * robot.motor.inertia_kgm2 * speed * speed for speed in plant.wheel_speeds_radps)


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=12)
@given(vx=st.floats(-3, 3), vy=st.floats(-3, 3), omega=st.floats(-20, 20), restitution=st.sampled_from((0.0, 0.5)))
def test_without_current_energy_never_grows_walls_included(layout, vx, vy, omega, restitution):
    robot = robot_with(LAYOUTS[layout])
    plant = Plant(robot, Arena(0.6, 0.5, restitution=restitution), twist=BodyTwist(vx, vy, omega))
    energy_j = kinetic_j(plant, robot)
    for _ in range(120):
        plant.step((0.0,) * len(robot.wheels))
        before, energy_j = energy_j, kinetic_j(plant, robot)
        assert energy_j <= before * (1.0 + 1e-12) + 1e-15


sane = st.fixed_dictionaries(
    {
        "body_mass_kg": st.floats(0.5, 30.0),
        "body_inertia_kgm2": st.floats(0.002, 1.0),
        "body_cog_height_m": st.floats(0.0, 0.06),
        "ground_grip": st.floats(0.05, 1.2),
        "ground_rolling": st.floats(0.0, 0.1),
        "motor_inertia_kgm2": st.floats(1.1e-4, 1e-2),
        "motor_coulomb_nm": st.floats(0.0, 0.1),
        "motor_viscous_nms": st.floats(0.0, 0.01),
        "motor_current_lag_ms": st.floats(0.0, 5.0),
    }
)


@pytest.mark.parametrize("layout", LAYOUTS)
@settings(deadline=None, max_examples=12, phases=(Phase.explicit, Phase.reuse, Phase.generate))  # shrinking takes long
@given(changes=sane, data=st.data())
def test_any_sane_robot_with_any_currents_moves_by_what_its_motors_give(layout, changes, data):
    """No number runs away, and kinetic energy grows by no more than the motors' torque times the wheels' speed.

    The speed at the end of the step, for which friction is solved: that way no step can give more than it was given.
    """
    robot = robot_with(LAYOUTS[layout], **changes)
    count = len(robot.wheels)
    plant = Plant(robot, Arena(0.8, 0.6))
    amperes = st.floats(-12.0, 12.0) | st.sampled_from((0.0, float("nan"), float("inf"), -float("inf"), 1e300))
    energy_j = 0.0
    for _ in range(3):
        currents = data.draw(st.tuples(*[amperes] * count))
        for _ in range(60):
            plant.step(currents)
            before, energy_j = energy_j, kinetic_j(plant, robot)
            given_j = sum(
                STEP_S * robot.motor.torque_nm_per_a * amps * speed
                for amps, speed in zip(plant.currents_a, plant.wheel_speeds_radps, strict=True)
            )
            assert energy_j - before <= given_j + 1e-9 * (1.0 + energy_j)
    x, y, _ = plant.pose
    assert abs(x) <= 0.4
    assert abs(y) <= 0.3
    assert energy_j < 1e6
    assert all(load >= 0.0 for load in plant.wheel_loads_n)
