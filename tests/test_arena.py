"""An arena as data: what is refused, what a robot meets in it, and that a recording brings it along."""

import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from bases import m2006
from desk import scene
from hypothesis import given
from hypothesis import strategies as st

from bench.__main__ import main
from bench.arena import FIELD, Arena, Disc, Obstacle, Patch, Wall, arena_toml, load_arena, read_arena
from bench.check.sources import from_source
from bench.config import ConfigError, Table
from bench.errors import UsageError
from bench.fittings import Bumper, RangeSensor
from bench.messages import BodyTwist, Pose
from bench.plant import STEP_S, Plant
from bench.screen.view import picture
from bench.sensors import ArenaSenses, distance_m, is_pressed

COURSE = Arena(
    length_m=4.0,
    width_m=3.0,
    name="course",
    start=Pose(-1.0, 0.0, 0.0),
    walls=(Wall(1.0, -0.5, 1.0, 0.5, 0.04),),
    discs=(Disc("puck", -0.6, 0.0, 0.05, 0.2, friction=0.2),),
    patches=(
        Patch("ice", 0.0, 1.0, grip=0.1, rolling=0.02, length_m=1.0, width_m=0.4),
        Patch("oil", 0.3, 1.0, grip=0.05, rolling=0.01, radius_m=0.1),
    ),
)


def run(plant: Plant, currents_a, steps: int) -> Plant:
    for _ in range(steps):
        plant.step(currents_a)
    return plant


# --- the file -------------------------------------------------------------------------------------------------------


def test_an_arena_comes_back_from_its_file_as_it_was(tmp_path):
    path = tmp_path / "course.toml"
    path.write_text(arena_toml(COURSE))
    assert load_arena(path) == COURSE
    path.write_text("schema = 1\n")
    assert load_arena(path) == Arena(name="course")


@given(
    st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"])),
    st.decimals(-360, 360, places=2),
    st.floats(-1e3, 1e3),
)
def test_any_name_and_any_start_come_back_to_the_last_bit(name, heading_deg, x_m):
    arena = Arena(name=name, start=Pose(x_m, 0.0, math.radians(float(heading_deg))))
    read = Table(Path("any"), "", tomllib.loads(arena_toml(arena)))
    read.take_schema()
    assert read_arena(read, "") == arena


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("lenght_m = 3.0", "lenght_m: unknown key; did you mean length_m?"),
        ("length_m = 0.0", "length_m: expected more than 0 and at most 1000, got 0"),
        ("width_m = -1", "width_m: expected more than 0"),
        ("width_m = nan", "width_m: expected a finite number"),
        ("friction = -0.1", "friction: expected 0 to 10"),
        ("restitution = 1.5", "restitution: expected 0 to 1, got 1.5"),
        ("[start]\nheading = 3", "start.heading: unknown key; did you mean heading_deg?"),
        ("[[wall]]\nx1_m = 0.0", "wall[0].y1_m: is missing"),
        ("[[wall]]\nx1_m=0\ny1_m=0\nx2_m=1\ny2_m=1\nthickness_m=0", "wall[0].thickness_m: expected more than 0"),
        ("[[disc]]\nname='a'\nx_m=0\ny_m=1\nradius_m=0.05\nmass_kg=0.0", "disc[0].mass_kg: expected more than 0"),
        ("[[disc]]\nname='a'\nx_m=0\ny_m=1\nradius_m=0.05\nmass_kg=1e-9", "disc[0].mass_kg: expected at least 0.001"),
        ("[[disc]]\nname='a'\nx_m=9\ny_m=1\nradius_m=0.05\nmass_kg=1", "disc[0]: the disc 'a' of radius 0.05 m at"),
        ("[[patch]]\nname='a'\nx_m=0\ny_m=1\ngrip=0.1", "patch[0].length_m: is missing"),
        ("[[patch]]\nname='a'\nx_m=0\ny_m=1\nradius_m=1\nlength_m=1\ngrip=0.1", "patch[0].radius_m: a patch is round"),
        ("[[patch]]\nname='a'\nx_m=0\ny_m=1\nradius_m=1\ngrip=0", "patch[0].grip: expected more than 0"),
        ("wall = 3", "wall: expected at least one table [[wall]]"),
        ("schema = 2", "schema: expected 1, got 2"),
    ],
)  # fmt: skip
def test_what_cannot_be_an_arena_is_refused_with_file_and_key(tmp_path, text, sentence):
    path = tmp_path / "odd.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as refusal:
        load_arena(path)
    assert str(refusal.value).startswith(f"{path}: {sentence}")


@pytest.mark.parametrize(
    ("arena", "why"),
    [
        (Arena(0.1, 4.0), "larger than a field of 0.1 m x 4.0 m"),
        (Arena(start=Pose(2.95, 0.0, 0.0)), "not inside a field of 6.0 m x 4.0 m"),
        (Arena(start=Pose(math.nan, 0.0, 0.0)), "not inside"),
        (Arena(walls=(Wall(-1.0, 0.05, 1.0, 0.05),)), "stands in wall[0]"),
        (Arena(discs=(Disc("puck", 0.1, 0.0, 0.05, 0.2),)), "stands in the disc 'puck'"),
    ],
)
def test_a_robot_that_cannot_begin_there_is_refused(arena, why):
    assert why in arena.in_the_way(0.08, arena.start)
    with pytest.raises(ValueError, match="a robot"):
        Plant(m2006(), arena, arena.start)
    assert FIELD.in_the_way(0.08, Pose(0.0, 0.0, 0.0)) == ""


def test_the_command_line_refuses_it_in_one_sentence(tmp_path, capsys):
    path = tmp_path / "tight.toml"
    path.write_text("length_m = 0.1\n")
    assert main(["replay", "bench/demo/demo.toml", "--arena", str(path)]) == 2
    error = capsys.readouterr().err
    assert "arena 'tight': a robot of radius 0.08 m at (0, 0) m is larger than a field of 0.1 m x 4.0 m" in error
    assert error.endswith("; give it a larger field (--arena FILE, docs/plant.md)\n"), "no start would help"
    assert main(["replay", "bench/demo/demo.toml", "--arena", str(tmp_path / "none.toml")]) == 2
    assert "none.toml: there is no such file" in capsys.readouterr().err


# --- what stands in it ----------------------------------------------------------------------------------------------


def test_a_wall_in_the_field_stops_a_robot_like_one_around_it():
    plant = Plant(m2006(), COURSE, Pose(0.85, 0.0, 0.0))
    run(plant, (0.5, 0.0, -0.5), 800)
    assert plant.pose.x_m == pytest.approx(1.0 - 0.02 - 0.08, abs=2e-4)
    assert plant.twist == (0.0, 0.0, 0.0)
    assert plant.wheel_speeds_radps == [0.0, 0.0, 0.0]
    assert plant.wall_force_n[0] < -5.0


def test_a_wall_with_an_end_lets_a_robot_pass_beside_it():
    plant = run(Plant(m2006(), COURSE, Pose(0.7, -0.65, 0.0)), (0.6, 0.0, -0.6), 1500)
    assert plant.pose.x_m > 1.1


def test_a_pushed_disc_slides_as_far_as_its_friction_lets_it():
    """Thrown off by an elastic robot it coasts v^2 / (2 mu g), and then lies still."""
    arena = Arena(4.0, 3.0, restitution=1.0, friction=0.0, discs=(Disc("puck", 0.2, 0.0, 0.05, 0.2, friction=0.2),))
    plant = Plant(m2006(), arena, Pose(0.0, 0.0, 0.0), BodyTwist(1.0, 0.0, 0.0))
    before = plant.discs[0].x1_m
    assert before == 0.2
    while plant.discs[0].x1_m == before:
        run(plant, (0.0, 0.0, 0.0), 1)
    start = plant.discs[0].x1_m
    run(plant, (0.0, 0.0, 0.0), 1)
    speed_mps = (plant.discs[0].x1_m - start) / STEP_S
    run(plant, (0.0, 0.0, 0.0), 1500)
    coasted_m = plant.discs[0].x1_m - start
    assert speed_mps > 1.0
    assert coasted_m == pytest.approx(speed_mps**2 / (2.0 * 0.2 * 9.81), rel=0.01)
    at_rest_m = plant.discs[0].x1_m
    run(plant, (0.0, 0.0, 0.0), 100)
    assert plant.discs[0].x1_m == pytest.approx(at_rest_m, abs=1e-9)


def test_a_robot_pushes_a_disc_that_is_lighter_than_its_grip_and_not_one_that_is_heavier():
    def after(mass_kg: float) -> tuple[float, float]:
        arena = Arena(4.0, 3.0, discs=(Disc("puck", 0.14, 0.0, 0.05, mass_kg, friction=0.5),))
        plant = run(Plant(m2006(), arena, Pose(0.0, 0.0, 0.0)), (0.6, 0.0, -0.6), 1500)
        return plant.discs[0].x1_m, plant.pose.x_m

    pushed, robot = after(0.3)  # 1.5 N of friction against 6.3 N of drive
    assert pushed > 0.4
    assert pushed - robot == pytest.approx(0.13, abs=1e-3)
    assert after(2.0)[0] == pytest.approx(0.14, abs=3e-3)  # 9.8 N; what it moved, it got from the knock


def test_range_sensors_see_walls_and_discs_and_where_a_disc_went():
    ahead = RangeSensor("ahead", 0.08, 0.0, 0.0)
    assert distance_m(ahead, COURSE.start, COURSE) == pytest.approx(1.0 - 0.02 + 1.0 - 0.08)
    plant = Plant(m2006(), COURSE, COURSE.start)
    assert distance_m(ahead, plant.pose, COURSE, plant.discs) == pytest.approx(0.4 - 0.05 - 0.08)
    run(plant, (0.6, 0.0, -0.6), 1500)
    gap_m = ArenaSenses(m2006(), plant, COURSE).ranges_m()[0]
    assert plant.discs[0].x1_m > -0.4
    assert gap_m == pytest.approx(plant.discs[0].x1_m - 0.05 - plant.pose.x_m - 0.08, abs=2e-4)


@pytest.mark.parametrize(
    ("x", "y", "looks_deg", "distance"),
    [
        (0.0, 0.0, 0.0, 0.9),  # a wall of thickness 0.2 from (1, -1) to (1, 1), squarely
        (0.0, 0.5, 0.0, 0.9),
        (2.0, 0.5, 180.0, 0.9),
        (0.0, 0.0, 45.0, 0.9 * math.sqrt(2.0)),
        (1.0, 2.0, -90.0, 0.9),  # its round end
        (1.0, -3.0, 90.0, 1.9),
        (0.0, 1.05, 0.0, 1.0 - math.sqrt(0.01 - 0.0025)),
        (0.0, 1.2, 0.0, math.inf),
        (0.0, 0.0, 180.0, math.inf),
        (1.05, 0.0, 0.0, 0.0),  # within it
    ],
)
def test_beams_against_a_wall_by_hand(x, y, looks_deg, distance):
    arena = Arena(20.0, 20.0, walls=(Wall(1.0, -1.0, 1.0, 1.0, 0.2),))
    sensor = RangeSensor("beam", 0.0, 0.0, math.radians(looks_deg), reach_m=5.0)
    assert distance_m(sensor, Pose(x, y, 0.0), arena) == pytest.approx(min(distance, 5.0), abs=1e-9)


def test_bumpers_close_on_walls_and_discs():
    front, rear = Bumper("front", 0.0, math.radians(60.0)), Bumper("rear", math.pi, math.radians(60.0))
    at_wall = Pose(1.0 - 0.02 - 0.08, 0.3, 0.0)
    assert is_pressed(front, 0.08, at_wall, COURSE)
    assert not is_pressed(rear, 0.08, at_wall, COURSE)
    disc = [Obstacle(0.0, 0.0, 0.0, 0.0, 0.05)]
    assert is_pressed(rear, 0.08, Pose(0.13, 0.0, 0.0), COURSE, disc)
    assert not is_pressed(front, 0.08, Pose(0.13, 0.0, 0.0), COURSE, disc)
    assert not is_pressed(rear, 0.08, Pose(0.133, 0.0, 0.0), COURSE, disc)


# --- patches --------------------------------------------------------------------------------------------------------


def test_the_later_patch_lies_on_top():
    ice, oil = COURSE.patches
    assert ice.carries(0.3, 1.0)
    assert oil.carries(0.3, 1.0)
    assert not oil.carries(0.41, 1.0)
    assert not ice.carries(0.3, 1.21)
    plant = Plant(m2006(), COURSE, Pose(0.3, 1.0, 0.0))
    run(plant, (3.0, 0.0, -3.0), 1)
    (right, _), _, (left, _) = plant.contact_forces_n
    assert (right, left) == pytest.approx((0.05 * 6.23441, -0.05 * 6.23441), abs=1e-4)


def test_a_robot_on_ice_all_over_accelerates_as_the_closed_form_says():
    """All wheels spinning at mu 0.15: 1.1291 m/s^2 (reference 4.1); and no patch under a wheel changes no bit."""
    ice = Patch("ice", 0.0, 0.0, grip=0.15, rolling=1e-12, length_m=2.0, width_m=2.0)
    plant = Plant(m2006(body_cog_height_m=0.0), Arena(patches=(ice,)))
    assert run(plant, (3.0, 0.0, -3.0), 100).twist.vx_mps == pytest.approx(0.11291, abs=1e-5)
    far = Patch("ice", 2.5, 1.5, grip=0.15, rolling=0.01, radius_m=0.2)
    plain, patched = Plant(m2006()), Plant(m2006(), Arena(patches=(far,)))
    for _ in range(500):
        plain.step((1.0, 0.3, -0.5))
        patched.step((1.0, 0.3, -0.5))
        assert plain.twist == patched.twist
    assert plain.pose == patched.pose


def test_one_wheel_on_ice_turns_the_robot():
    """The left front wheel spins on ice, the right one drives: the robot yaws to the left."""
    ice = Patch("left", 0.0, 0.3, grip=0.05, rolling=0.05, length_m=4.0, width_m=0.5)
    plant = run(Plant(m2006(), Arena(patches=(ice,))), (0.6, 0.0, -0.6), 300)
    assert abs(plant.slip_mps[2]) > 0.1
    assert abs(plant.slip_mps[0]) < 1e-6
    assert plant.twist.omega_radps > 0.5


# --- through the bench ----------------------------------------------------------------------------------------------


def scenario(tmp_path, arena: str):
    path = tmp_path / "push.toml"
    path.write_text(
        f'schema = 1\nname = "push"\nrobot = "slamware-b"\nseconds = 2.0\n{arena}\n[[core]]\nat_s = 0.2\nvx_mps = 0.3\n'
    )
    return path  # fmt: skip


INLINE = "[arena]\n[[arena.disc]]\nname = 'puck'\nx_m = 0.45\ny_m = 0.0\nradius_m = 0.05\nmass_kg = 0.2\n"


@pytest.mark.parametrize("where", ["inline", "beside", "option"])
def test_a_recording_brings_its_arena_and_runs_again_byte_for_byte(tmp_path, capsys, where):
    beside = tmp_path / "course.toml"
    beside.write_text(INLINE.replace("[arena]\n", "").replace("arena.", ""))
    path = scenario(tmp_path, {"inline": INLINE, "beside": 'arena = "course.toml"', "option": ""}[where])
    option = ["--arena", str(beside)] if where == "option" else []
    directory = tmp_path / "run"
    assert main(["replay", str(path), "--record", str(directory), "--json", *option]) == 0
    facts = json.loads(capsys.readouterr().out)
    plain = Plant(from_source(path).bench.robot)
    assert plain.discs == []
    assert load_arena(directory / "arena.toml").discs[0].name == "puck"
    again = tmp_path / "again"
    assert main(["replay", str(directory), "--record", str(again), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["end"] == facts["end"]
    for file in sorted(directory.iterdir()):
        assert (again / file.name).read_bytes() == file.read_bytes(), file.name


def test_a_plain_recording_has_no_arena_and_refuses_another(tmp_path, capsys):
    path = scenario(tmp_path, "")
    assert main(["replay", str(path), "--record", str(tmp_path / "run"), "--json"]) == 0
    assert not (tmp_path / "run" / "arena.toml").exists()
    with pytest.raises(UsageError, match="brings its own arena"):
        from_source(tmp_path / "run", arena=tmp_path / "course.toml")


def test_a_scenario_with_a_wrong_arena_names_file_and_key(tmp_path):
    with pytest.raises(ConfigError, match=r"push\.toml: arena\.discs: unknown key; did you mean disc\?"):
        from_source(scenario(tmp_path, "[arena]\ndiscs = 1\n"))
    with pytest.raises(ConfigError, match=r"none\.toml: there is no such file"):
        from_source(scenario(tmp_path, 'arena = "none.toml"'))
    with pytest.raises(UsageError, match="arena 'push': a robot of radius"):
        from_source(scenario(tmp_path, "[arena]\n[arena.start]\nx_m = 2.99\n"))


def test_a_disc_slides_on_while_the_robot_rests():
    arena = Arena(4.0, 3.0, restitution=1.0, friction=0.0, discs=(Disc("puck", 0.14, 0.0, 0.05, 1.6, friction=0.05),))
    plant = Plant(m2006(), arena, Pose(0.0, 0.0, 0.0), BodyTwist(0.5, 0.0, 0.0))
    run(plant, (0.0, 0.0, 0.0), 600)
    assert plant.twist == (0.0, 0.0, 0.0)
    before = plant.discs[0].x1_m
    run(plant, (0.0, 0.0, 0.0), 10)
    assert plant.discs[0].x1_m > before + 1e-4


def test_the_dashboard_draws_what_stands_and_lies_there():
    plant = Plant(m2006(), COURSE, COURSE.start)
    plain = picture(scene(arena=replace(COURSE, walls=(), discs=(), patches=())), 120, 40)
    drawn = picture(scene(arena=COURSE, discs=plant.discs), 120, 40)
    assert "field 4 × 3 m" in "\n".join(drawn)
    assert sum(a != b for a, b in zip(plain, drawn, strict=True)) > 5
    assert picture(scene(arena=COURSE, discs=plant.discs, zoom=True), 120, 40) != plain


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, -135.0])
def test_odometry_is_told_in_the_field_wherever_the_robot_began(tmp_path, capsys, heading_deg):
    arena = tmp_path / "arena.toml"
    arena.write_text(
        f"schema = 1\nlength_m = 6.0\nwidth_m = 4.0\n[start]\nx_m = -1.0\ny_m = 0.5\nheading_deg = {heading_deg}\n"
    )
    scenario = tmp_path / "s.toml"
    scenario.write_text(
        """
schema = 1
name = "s"
seconds = 2.0
arena = "arena.toml"
[[stick]]
at_s = 0.2
aux1 = true
[[stick]]
at_s = 0.4
forward = 0.4
turn = 0.2
[[expect]]
always = "odo_off_m < 0.005 and abs(wrap(odo_heading_rad - heading_rad)) < 0.01"
[[expect]]
eventually = "hypot(x_m + 1, y_m - 0.5) > 0.3"
"""
    )
    assert main(["replay", str(scenario)]) == 0, capsys.readouterr().out
