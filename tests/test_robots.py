"""Every robot file: its geometry against vectors from outside, its numbers against each other, and that it drives."""

import cmath
import dataclasses
import importlib
import json
import math
import re
import sys
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig
from robot_files import EXAMPLE, PAGE, eight_wheels

from bench.canbus.c610 import COUNTS
from bench.config import (
    Body,
    ConfigError,
    Control,
    Ground,
    Limits,
    LinkLimits,
    Motor,
    Wheel,
    load_robot,
    robot_names,
    robot_path,
)
from bench.kinematics import Kinematics, speed_rows
from bench.loop import Bench, simulated
from bench.messages import BodyTwist, TickInput
from bench.odometry import wrap
from bench.plant import Plant
from bench.rc.transmitter import Sticks
from bench.world import SimulatedMotors, World

ROOT = Path(__file__).parents[1]
LAYOUTS = json.loads((ROOT / "fixtures/known/kinematics/vectors.json").read_text())["layouts"]
LAYOUT_OF = {
    "slamware-a": "slam_a",
    "slamware-b": "slam_b",
    "omni3": "k3",
    "omni4": "k4",
    "mecanum": "kmec",
    "siegwart": "siegwart3",
    "m2006": "ssl3",
    "dm3519": "ssl4",
    "deadwheel3": "dead3",
}


def script(name):
    if str(ROOT / "scripts") not in sys.path:
        sys.path.insert(0, str(ROOT / "scripts"))
    return importlib.import_module(name)


# --- the files ---------------------------------------------------------------------------------------------------


def test_the_documents_robots_are_all_there():
    assert robot_names() == sorted(LAYOUT_OF)


@pytest.mark.parametrize("name", robot_names())
def test_wheels_stand_where_the_document_has_them(name):
    robot = load_robot(name)
    wheels = robot.dead_wheels if name == "deadwheel3" else robot.wheels
    layout = LAYOUTS[LAYOUT_OF[name]]
    assert len(wheels) == len(layout)
    for wheel, known in zip(wheels, layout, strict=True):
        assert (wheel.x_m, wheel.y_m) == pytest.approx((known["x"], known["y"]), abs=1e-9)
        assert wrap(wheel.heading_rad - math.radians(known["delta_deg"])) == pytest.approx(0.0, abs=1e-9)
        assert wheel.roller_rad == pytest.approx(math.radians(known["gamma_deg"]), abs=1e-12)
        if known["r"] != 1.0 or name == "siegwart":  # elsewhere 1 stands for rim speeds
            assert wheel.radius_m == known["r"]


@pytest.mark.parametrize("name", robot_names())
def test_what_is_assumed_is_in_the_file_and_the_rest_has_a_source(name):
    tables = tomllib.loads(robot_path(name).read_text())
    assert tables["name"] == name
    assert tables["source"].startswith(("document ", "geometry, "))
    for address in tables["assumed"]:
        first, _, key = address.partition(".")
        table = tables[first]
        for part in table if isinstance(table, list) else [table]:
            # A key that a wheel leaves out has its default, and that is assumed then.
            assert not key or key in part or key == "direction", address


@pytest.mark.parametrize("name", robot_names())
def test_no_wheel_can_outrun_its_encoder(name):
    # Half a turn of the rotor between two reports is the most that can be told from its own reverse.
    robot = load_robot(name)
    no_load_radps = robot.motor.supply_v / robot.motor.back_emf_vs
    for wheel in robot.wheels:
        assert no_load_radps * wheel.gear / math.tau * COUNTS / 1000 < COUNTS / 2
    assert robot.limits.wheel_radps < no_load_radps


@pytest.mark.parametrize("name", robot_names())
def test_full_stick_is_within_the_wheels_limit_or_the_file_says_so(name):
    robot = load_robot(name)
    kinematics, limits = Kinematics(robot.wheels), robot.limits
    fastest = max(
        abs(speed)
        for twist in ((limits.linear_mps, 0, 0), (0, limits.linear_mps, 0), (0, 0, limits.angular_radps))
        for speed in kinematics.wheel_speeds(twist)
    )
    if name == "dm3519":  # 2 m/s forward would need 64 rad/s, says the file
        assert fastest == pytest.approx(64.2, abs=0.1)
    else:
        assert fastest <= limits.wheel_radps * 1.0002


@pytest.mark.parametrize("name", robot_names())
def test_gains_are_what_the_script_gives(name):
    path = robot_path(name)
    assert script("tune").written(path) == path.read_text(), "run scripts/tune.py --write"


@pytest.mark.parametrize("name", robot_names())
def test_the_open_loop_has_the_margins_that_the_rule_promises(name):
    # Worked again, as a whole and with viscous friction, on a fine grid of frequencies.
    robot, tune = load_robot(name), script("tune")
    motor, control = robot.motor, robot.control

    def margin_deg(per_inertia):
        def loop(w):
            s = 1j * w
            lag = cmath.exp(-0.002 * s) / (1 + motor.current_lag_ms / 1e3 * s)
            plant = motor.torque_nm_per_a * per_inertia / (s + motor.viscous_nms * per_inertia)
            return (control.kp_a_per_radps + control.ki_a_per_rad / s) * plant * lag

        crossover = next(w for w in (1.002**i for i in range(1, 4000)) if abs(loop(w)) < 1.0)
        return 180 + math.degrees(cmath.phase(loop(crossover)))

    for per_inertia in tune.directions(robot):
        assert margin_deg(per_inertia) > 58.5
    assert margin_deg(1.0 / motor.inertia_kgm2) > 43.5


def test_inertia_of_each_direction_is_the_closed_form():
    # plant-model section 2: 4.672 kg forward; sideways and yaw are coupled, so only their product is plain.
    robot = load_robot("m2006")
    rows = Kinematics(robot.wheels).inverse_rows
    forward = sum(hx * hx for hx, _, _ in rows) / 4.672
    directions = script("tune").directions(robot)
    assert min(abs(value - forward) / forward for value in directions) < 1e-3


@pytest.mark.parametrize(("name", "axis"), [(name, i % 3) for i, name in enumerate(robot_names())])
def test_the_table_of_responses_is_what_the_plant_does(name, axis):
    page = (ROOT / "docs" / "plant.md").read_text()
    row = re.search(rf"^\| {name} \| ((?:[-\d., ]+\|){{5}})$", page, re.MULTILINE).group(1)
    speed, lag, overshoot, settled, standing = (float(cell.split(",")[axis]) for cell in row.strip("|").split("|"))
    tune = script("tune")
    got = tune.judged(tune.response(load_robot(name), axis))
    assert got.speed == pytest.approx(speed, abs=0.005)
    assert 1000 * got.lag == pytest.approx(lag, abs=0.6)
    assert 100 * got.overshoot == pytest.approx(overshoot, abs=0.6)
    assert (got.settled_ms, got.standing_ms) == pytest.approx((settled, standing), abs=3), "scripts/tune.py --check"
    assert got.overshoot < 0.1
    assert got.standing_ms < 200


# --- that they drive ---------------------------------------------------------------------------------------------


class Driver:
    """One robot in its field, driven as its file has it: by sticks, or by a core where it has no RC."""

    def __init__(self, name):
        robot = load_robot(name)
        self.limits = robot.limits
        self.rig = Rig(bench=simulated(robot)) if robot.rc else None
        self.bench = self.rig.bench if self.rig else simulated(robot)
        if self.rig:
            self.rig.arm()
        else:
            self.run(200, (0.0, 0.0, 0.0))

    def run(self, ticks, shares):
        """So many ticks at these shares of full speed (forward, left, turn); the twist that this asks for."""
        forward, left, turn = shares
        linear, angular = self.limits.linear_mps, self.limits.angular_radps
        asked = BodyTwist(forward * linear, left * linear, turn * angular)
        if self.rig:
            dead_band = self.bench.robot.rc.dead_band
            travels = [share + math.copysign(dead_band * (1 - abs(share)), share) if share else 0.0 for share in shares]
            self.rig.run(ticks, Sticks(*travels))
        else:
            for _ in range(ticks):
                self.bench.tick(TickInput(core_twist=asked))
        return asked


@pytest.mark.parametrize("name", robot_names())
def test_it_goes_where_it_is_told(name):
    driver = Driver(name)
    plant, base = driver.bench.world.plant, driver.bench.base
    kinematics = Kinematics(driver.bench.robot.wheels)
    slower = min(0.25, 0.3 / driver.limits.linear_mps)
    size_m = kinematics.length_m
    for axis in range(3):
        start, believed = plant.pose, base.odometry.pose
        asked = driver.run(900, [(slower, slower, 0.3)[axis] if i == axis else 0.0 for i in range(3)])
        # Settled within 3 % of the speed, on the other axes too; yaw counts by the speed that it gives the wheels.
        lever_m = (1.0, 1.0, size_m)
        off = [abs(is_ - wanted) * lever for is_, wanted, lever in zip(plant.twist, asked, lever_m, strict=True)]
        assert max(off) < 0.03 * asked[axis] * lever_m[axis]
        # The wheels turn as the equation says.
        wheels = kinematics.wheel_speeds(plant.twist)
        assert plant.wheel_speeds_radps == pytest.approx(wheels, abs=0.02 * max(map(abs, wheels)))
        # The way is along the body's axis, and odometry knows all of it but the last tick's, on its way as feedback.
        way, known = _moved(start, plant.pose), _moved(believed, base.odometry.pose)
        assert way[axis] > 0.5 * 0.9 * asked[axis]
        for there, here, speed, lever in zip(way, known, plant.twist, lever_m, strict=True):
            assert here + speed * 1e-3 == pytest.approx(there, abs=5e-5 * size_m / 0.061 / lever)
        driver.run(220, (0.0, 0.0, 0.0))  # no robot takes longer to stand


def _moved(before, after):
    """The change of pose as the robot saw it at the start."""
    c, s = math.cos(before.heading_rad), math.sin(before.heading_rad)
    dx, dy = after.x_m - before.x_m, after.y_m - before.y_m
    return c * dx + s * dy, c * dy - s * dx, wrap(after.heading_rad - before.heading_rad)


def test_the_textbooks_wheels_at_4_1_and_2_rad_per_second():
    # Document 003, equation 3.34, all the way: rim speeds from a core, speed loops, CAN frames, motors, floor.
    robot = load_robot("siegwart", "crossfire")
    plain = simulated(robot)
    world = World(robot, core=plain.world.core, motors=SimulatedMotors(robot, Plant(robot, arena=None)))
    plain.world.core.ask_wheels([4.0, 1.0, 2.0])  # r = 1 m: a rim speed is the wheel's
    rig = Rig(bench=Bench(plain.base, world))
    rig.run(3500)
    assert world.plant.wheel_speeds_radps == pytest.approx([4.0, 1.0, 2.0], rel=0.005)
    assert world.plant.twist == pytest.approx([2 / math.sqrt(3), -4 / 3, -7 / 3], rel=0.005)


# --- a robot of one's own ----------------------------------------------------------------------------------------

KEYS = re.compile(r"^\| (`\w+`(?:, `\w+`)*) \| ([^|]+) \|", re.MULTILINE)


@pytest.fixture
def my_robot(tmp_path):
    """Writes a robot file: the page's example, changed."""

    def write(text=EXAMPLE):
        path = tmp_path / "my_robot.toml"
        path.write_text(text)
        return path

    return write


def textbook_rows(wheels):
    """Document 003's own form of the wheel equation: alpha and l say where, beta and gamma how a wheel stands."""
    for wheel in wheels:
        alpha, length = math.atan2(wheel.y_m, wheel.x_m), math.hypot(wheel.x_m, wheel.y_m)
        beta = wheel.heading_rad - alpha + math.pi / 2
        gamma = wheel.roller_rad
        row = (math.sin(alpha + beta + gamma), -math.cos(alpha + beta + gamma), -length * math.cos(beta + gamma))
        yield [value / (wheel.radius_m * math.cos(gamma)) for value in row]


def turned_by_textbook(wheels, twist):
    return [sum(h * v for h, v in zip(row, twist, strict=True)) for row in textbook_rows(wheels)]


WHEELS = st.builds(
    Wheel,
    name=st.just("any"),
    x_m=st.floats(-1, 1),
    y_m=st.floats(-1, 1),
    heading_rad=st.floats(-4, 4),
    radius_m=st.floats(0.01, 1),
    can_id=st.just(1),
    roller_rad=st.floats(-1.2, 1.2),
)


@given(WHEELS)
def test_any_wheel_turns_as_the_textbook_has_it(wheel):
    assert speed_rows([wheel])[0] == pytest.approx(next(textbook_rows([wheel])), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("twist", [(0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.1, -0.1, 0.8)])
def test_an_odd_robot_drives_where_the_textbooks_form_says(my_robot, twist):
    robot = load_robot(my_robot())
    assert len({wheel.radius_m for wheel in robot.wheels}) == 3
    assert len({wheel.gear for wheel in robot.wheels}) == 2
    rig = Rig(bench=simulated(robot)).arm()
    full = (robot.limits.linear_mps, robot.limits.linear_mps, robot.limits.angular_radps)
    travels = (math.copysign(0.05 + 0.95 * abs(v) / most, v) if v else 0.0 for v, most in zip(twist, full, strict=True))
    rig.run(1000, Sticks(*travels))
    plant = rig.bench.world.plant
    assert plant.twist == pytest.approx(twist, abs=0.005)
    assert plant.wheel_speeds_radps == pytest.approx(turned_by_textbook(robot.wheels, twist), abs=0.15)
    assert rig.believed == pytest.approx(rig.truth, abs=2e-3)


def test_eight_driven_wheels_take_two_command_frames_and_drive(my_robot):
    rig = Rig(bench=simulated(load_robot(my_robot(eight_wheels())))).arm()
    out = rig.run(800, Sticks(left=0.3))
    assert [can_id for can_id, _ in out.can_commands] == [0x200, 0x1FF]
    assert [can_id for can_id, _ in out.can_feedback] == [0x201 + i for i in range(8)]
    assert rig.bench.world.plant.twist == pytest.approx((0.0, 0.8 * 0.25 / 0.95, 0.0), abs=0.005)
    assert rig.believed == pytest.approx(rig.truth, abs=2e-3)


@pytest.mark.parametrize(("name", "ratio"), [("m2006", (36, 1)), ("dm3519", (3591, 187))])
def test_a_wheel_without_a_gear_has_its_motors(tmp_path, name, ratio):
    """By the makers: P36 of the M2006, and the teeth of the DM3519 (docs/dm3519.md)."""
    shipped = robot_path(name).read_text()
    mine = tmp_path / "mine.toml"
    mine.write_text(re.sub(r"^gear = .*\n", "", shipped, flags=re.MULTILINE))
    robot = load_robot(mine)
    assert [wheel.gear for wheel in robot.wheels] == [ratio[0] / ratio[1]] * len(robot.wheels)
    assert robot.wheels == load_robot(name).wheels


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (EXAMPLE.replace('kind = "c610"', 'kind = "c620"'), r"motor.kind: 'c620' is unknown; did you mean c610"),
        (eight_wheels(9), "wheel: a CAN bus has the ids 1 to 8, got 9 wheels"),
        (EXAMPLE.replace("can_id = 8", "can_id = 9"), r"wheel\[4\].can_id: expected 1 to 8"),
        (EXAMPLE.replace("can_id = 8", "can_id = 4"), "wheel.can_id: 4 is given to more than one wheel"),
        (EXAMPLE.replace("wheel_radps = 40", "wheel_radps = 90"), "90 rad/s turn the rotor of 'nose' at 30940 rpm"),
        (EXAMPLE.replace("roller_deg = 30", "roller_deg = 90"), r"wheel\[1\].roller_deg: a roller axis across"),
        (
            EXAMPLE.replace("radius_m = 0.06", "radius_m = 60"),
            "'left rear' has a radius of 60 m under a body of 0.2 m; is",
        ),
        (EXAMPLE.replace("y_m = -0.15", "y_m = -150"), "'right' stands 150 m from the centre of a body of 0.2 m; is"),
        (
            EXAMPLE.replace("x_m = 0.06\ny_m = -0.15", "x_m = 0.18\ny_m = 0.02"),
            "wheel: 'right' stands where 'nose' does; two wheels need two places",
        ),
        (EXAMPLE.replace("roller_deg", "roler_deg"), r"wheel\[1\].roler_deg: unknown key; did you mean roller_deg"),
    ],
)
def test_what_cannot_be_is_refused(my_robot, text, says):
    with pytest.raises(ConfigError, match=says):
        load_robot(my_robot(text))


def documented(heading):
    """The page's table under a heading: key -> what holds without it."""
    part = PAGE[PAGE.index(f"\n## {heading}\n") :]
    part = part[: part.find("\n## ", 1)]
    return {key: without for keys, without in KEYS.findall(part) for key in re.findall(r"\w+", keys)}


@pytest.mark.parametrize(
    ("heading", "classes"),
    [
        ("`[body]` and `[ground]`", (Body, Ground)),
        ("`[motor]`", (Motor,)),
        ("`[limits]`", (Limits,)),
        ("`[control]`", (Control,)),
        ("`[link]`", (LinkLimits,)),
    ],
)
def test_the_page_has_every_key_and_its_default(heading, classes):
    known = {item.name: item.default for cls in classes for item in dataclasses.fields(cls)}
    page = documented(heading)
    assert page.keys() == known.keys()
    for key, default in known.items():
        expected = "needed" if default is dataclasses.MISSING else tomllib.loads(f"x = {page[key].strip('`')}")["x"]
        assert expected == ("needed" if default is dataclasses.MISSING else default), key


def test_the_page_has_every_key_of_a_wheel_and_of_the_top(my_robot):
    wheel = documented("`[[wheel]]`").keys() | {"x_m", "y_m"}
    with pytest.raises(ConfigError) as refused:
        load_robot(my_robot(EXAMPLE.replace("can_id = 8", "can_id = 8\nqqqqqq = 1")))
    assert wheel == set(str(refused.value).partition("known: ")[2].split(", ")) | {"bearing_deg", "distance_m"}
    with pytest.raises(ConfigError) as refused:
        load_robot(my_robot("qqqqqq = 1\n" + EXAMPLE))
    tables = set(re.findall(r"`\[\[?(\w+)\]", PAGE)) | {"bumper", "range_sensor", "dock_receiver", "dock", "gyro"}
    assert documented("At the top").keys() | tables == set(str(refused.value).partition("known: ")[2].split(", ")) | {
        "dm3519"
    }
