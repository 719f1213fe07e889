"""Every transmitter profile that ships: arms, drives the way its sticks are held, and stops when it falls silent."""

import dataclasses
import re
import tomllib
from pathlib import Path

import pytest
from rig import Rig

from bench.config import Axis, Button, Profile, load_profile, load_robot, profile_names
from bench.loop import simulated
from bench.rc.transmitter import AT_REST, Sticks


@pytest.mark.parametrize("name", profile_names())
def test_the_profile_drives_the_robot(name):
    rig = Rig(bench=simulated(load_robot("m2006", name)))
    rig.run(100)
    if load_profile(name).arming == "switch":
        assert not rig.bench.base.drive.armed
        rig.run(100, Sticks(aux1=True))
        assert rig.bench.base.drive.armed, "pressed, not released, is what arms"
        rig.run(100)
    assert rig.bench.base.drive.armed
    rig.run(500, Sticks(forward=0.4))
    assert rig.truth.x_m > 0.03
    assert abs(rig.truth.y_m) < 1e-3
    heading = rig.truth.heading_rad
    rig.run(800)
    rig.run(300, Sticks(turn=0.5))
    assert rig.truth.heading_rad > heading + 0.1
    rig.run(800)
    y_m = rig.truth.y_m
    rig.run(600, Sticks(left=0.4))
    assert rig.truth.y_m > y_m + 0.03
    rig.transmitter.on = False
    rig.run(700, AT_REST)
    assert not rig.bench.base.drive.armed
    link = rig.bench.base.link
    assert (link.state, link.noise_bytes, link.flagged_frames) == ("lost", 0, 0)


def test_the_page_has_every_key_and_its_default():
    page = (Path(__file__).parents[1] / "docs" / "rc" / "README.md").read_text(encoding="utf-8")
    part = page.partition("## A profile for your transmitter\n")[2].partition("\n## ")[0]
    said = {
        key: row[1] for row in re.findall(r"^\| (`.+?`) \| (.+?) \|", part, re.M) for key in re.findall(r"\w+", row[0])
    }
    known = {item.name: item.default for item in dataclasses.fields(Profile) if item.name != "file"}
    assert said.keys() == known.keys() | {"schema"}
    for key, default in known.items():
        if default is dataclasses.MISSING:
            assert said[key] == "needed", key
        elif default is not None:
            assert tomllib.loads(f"x = {said[key].strip('`')}")["x"] == default, key
    for table in (Axis, Button):
        assert all(f"`{item.name}" in part for item in dataclasses.fields(table))
