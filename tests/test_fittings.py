"""Bumpers, range sensors, receivers and dock of a robot file: what is read, what is usual, what is refused."""

import math

import pytest

from bench.config import ROBOTS_DIR, ConfigError, load_robot

M2006 = (ROBOTS_DIR / "m2006.toml").read_text()


def load(tmp_path, more="", slamware=""):
    """The default robot's file with more in it: keys before its tables, tables and [slamware] keys behind them."""
    path = tmp_path / "mine.toml"
    keys, tables = ("", more) if more.startswith("[") else (more, "")
    head, _, rest = M2006.partition("[[wheel]]")
    path.write_text(f"{head}{keys}\n[[wheel]]{rest}{slamware}\n{tables}")
    return load_robot(path)


def test_the_usual_set():
    fittings = load_robot("m2006").fittings
    assert [bumper.name for bumper in fittings.bumpers] == ["left", "right"]
    assert [sensor.name for sensor in fittings.range_sensors] == ["front", "left", "rear", "right"]
    assert [receiver.name for receiver in fittings.receivers] == ["left", "main", "right"]
    assert fittings.dock is None
    left = fittings.range_sensors[1]
    assert (left.x_m, left.y_m, left.heading_rad) == pytest.approx((0.0, 0.08, math.pi / 2))


def test_none_at_all(tmp_path):
    fittings = load(tmp_path, "bumper = []\nrange_sensor = []\ndock_receiver = []\n").fittings
    assert fittings.bumpers == fittings.range_sensors == fittings.receivers == ()


def test_all_of_ones_own(tmp_path):
    fittings = load(
        tmp_path,
        """
[[bumper]]
name = "nose"
bearing_deg = 0
span_deg = 30
height_m = 0.02
[[range_sensor]]
name = "up front"
bearing_deg = 90
distance_m = 0.05
heading_deg = 0
reach_m = 2
[[range_sensor]]
name = "rim"
bearing_deg = 180
[[dock_receiver]]
name = "one"
bearing_deg = 180
view_deg = 90
[dock]
x_m = 1.5
y_m = -1
heading_deg = 90
""",
    ).fittings
    (nose,) = fittings.bumpers
    assert (nose.name, nose.bearing_rad, nose.height_m) == ("nose", 0.0, 0.02)
    assert nose.span_rad == pytest.approx(math.pi / 6)
    up_front, rim = fittings.range_sensors
    assert (up_front.x_m, up_front.y_m, up_front.heading_rad, up_front.reach_m) == pytest.approx((0.0, 0.05, 0.0, 2.0))
    assert (rim.x_m, rim.heading_rad, rim.height_m, rim.reach_m) == pytest.approx((-0.08, math.pi, 0.05, 4.0))
    assert fittings.receivers[0].view_rad == pytest.approx(math.pi / 2)
    dock = fittings.dock
    assert (dock.x_m, dock.y_m, dock.heading_rad, dock.reach_m) == pytest.approx((1.5, -1.0, math.pi / 2, 3.0))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "[[range_sensor]]\nname = 'a'\nbearing_deg = 0\ndistance_m = 1e9\n",
            r"range_sensor\[0\]\.distance_m: expected -100 to 100, got 1e\+09",
        ),
        (
            "[[bumper]]\nname = 'a'\nbearing_deg = 0\nspan_deg = 9\nheight_m = -1e300\n",
            r"bumper\[0\]\.height_m: expected -100 to 100",
        ),
        ("[[bumper]]\nname = 'a'\nbearing_deg = 0\n", r"bumper\[0\]\.span_deg: is missing"),
        ("[[bumper]]\nname = 'a'\nbearing_deg = 0\nspan_deg = 0\n", "more than 0 and at most 360 degrees, got 0"),
        ("[[bumper]]\nname = 'a'\nbearing_deg = 0\nspan_deg = 361\n", "more than 0 and at most 360 degrees, got 361"),
        ("[[bumper]]\nname = 'a'\nbearing_deg = 0\nspan_deg = 9\nspam = 1\n", r"bumper\[0\]\.spam: unknown key"),
        ("[[range_sensor]]\nname = 'a'\nbearing_deg = 0\nreach_m = 0\n", "reach_m: expected a positive number"),
        ("[[dock_receiver]]\nname = 'a'\nbearing_deg = 0\nview_deg = -1\n", "view_deg: expected more than 0"),
        ("[dock]\nx_m = 0\ny_m = 0\n", "dock.heading_deg: is missing"),
        ("[dock]\nx_m = 0\ny_m = 0\nheading_deg = 0\nreach_m = -1\n", "dock.reach_m: expected a positive number"),
        ("bumper = 3\n", r"bumper: expected at least one table \[\[bumper\]\]"),
        ("[[bumpre]]\nname = 'a'\n", "bumpre: unknown key; did you mean bumper"),
        ("[[bumper]]\nname = 'a'\nbearing_deg = 0\nspan_deg = 9\n" * 9, "bumper: expected at most 8, got 9"),
        ("[[range_sensor]]\nname = 'a'\nbearing_deg = 0\n" * 17, "range_sensor: expected at most 16, got 17"),
    ],
)
def test_refusals(tmp_path, text, sentence):
    with pytest.raises(ConfigError, match=sentence):
        load(tmp_path, text)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ('dialect = "firmware-2017"', r"slamware\.dialect: 'firmware-2017' is unknown; did you mean firmware-201"),
        ('behaviour = "lax"', r"slamware\.behaviour: 'lax' is unknown; known: strict, as_reference_firmware"),
        ('polls = "all"', r"slamware\.polls: 'all' is unknown; did you mean full|known: velocity, full"),
        (
            'firmware_suffix = "much too long"',
            "firmware_suffix 'much too long' is not ASCII text",
        ),
        ('binary_configuration = "5G"', r"slamware\.binary_configuration: expected pairs of hexadecimal digits"),
        (f'binary_configuration = "{"00" * 1020}"', "expected at most 1019 bytes, got 1020"),
    ],
)
def test_slamware_settings_that_cannot_be(tmp_path, line, sentence):
    with pytest.raises(ConfigError, match=sentence):
        load(tmp_path, slamware=line)


def test_slamware_settings(tmp_path):
    said = load(tmp_path, slamware='dialect = "sdk-2020"\nfirmware_suffix = "rc1"\npolls = "full"\n').slamware
    assert (said.dialect, said.firmware_suffix, said.polls, said.behaviour) == ("sdk-2020", "rc1", "full", "strict")
