"""Dead-band and curve of a stick, from raw wire values to the base, beside the closed form of docs/driving.md."""

from dataclasses import replace

import pytest
from desk import M2006, scene

from bench.config import load_profile
from bench.config.files import profile_names
from bench.loop import simulated
from bench.messages import TickInput
from bench.rc.transmitter import Sticks, Transmitter
from bench.screen.keyboard import Keyboard
from bench.screen.view import picture


def stick_of(profile, way):
    """What the base makes of a stick pushed so far forward."""
    bench, transmitter = simulated(replace(M2006, rc=profile)), Transmitter(profile)
    for tick in range(0, 60):
        bench.tick(TickInput(transmitter.step(tick, Sticks(forward=way))))
    return bench.base.drive.sticks[0]


@pytest.mark.parametrize(
    ("expo", "dead_band", "way", "expected"),
    [
        (0.0, 0.0, 0.5, 0.5), (1.0, 0.0, 0.5, 0.125), (0.4, 0.0, 0.5, 0.35), (0.4, 0.0, -0.5, -0.35),
        (0.3, 0.2, 0.6, 0.3875), (0.3, 0.2, 0.2, 0.0), (0.7, 0.1, 1.0, 1.0),
    ],
)  # fmt: skip
def test_a_stick_is_bent_as_the_page_says(expo, dead_band, way, expected):
    profile = replace(M2006.rc, expo=expo, dead_band=dead_band)
    assert stick_of(profile, way) == pytest.approx(expected, abs=2e-3)  # a raw step is 1/2048


def test_the_profiles_that_come_with_wheelbench_are_linear():
    assert {load_profile(name).expo for name in profile_names()} == {0.0}


def test_the_curve_stands_on_the_screen():
    bent = replace(M2006, rc=replace(M2006.rc, expo=0.3))
    assert "linear" in "\n".join(picture(scene(), 120, 40))
    assert "expo30%" in "\n".join(picture(scene(robot=bent), 120, 40))
    keyboard = Keyboard(bent.rc)
    keyboard.mouse.on = True
    words = "\n".join(picture(scene(robot=bent, hands=keyboard.hands(0)), 80, 24))
    assert "expo 0.30, dead-band 5 %" in words
