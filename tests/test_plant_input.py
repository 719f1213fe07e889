"""What no robot can be is refused at its file with one sentence; what no current can be is contained, and flagged."""

import math
from dataclasses import replace

import pytest
from bases import m2006

from bench.check.sources import from_source
from bench.check.summary import Summary
from bench.config import ROBOTS_DIR, ConfigError, load_robot, robot_names
from bench.plant import Plant
from bench.scenarios import prepare, run
from bench.world import SimulatedMotors


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("mass_kg", "1e-9", "body.mass_kg: expected 0.01 to 100000, got 1e-09"),
        ("mass_kg", "1e9", "body.mass_kg: expected 0.01 to 100000, got 1e+09"),
        ("mass_kg", "0.0", "body.mass_kg: expected a positive number, got 0.0"),
        ("mass_kg", "-1.6", "body.mass_kg: expected a positive number, got -1.6"),
        ("mass_kg", "nan", "body.mass_kg: expected a finite number, got nan"),
        ("mass_kg", "inf", "body.mass_kg: expected a finite number, got inf"),
        ("radius_m", "1e4", "body.radius_m: expected 0.001 to 100, got 10000"),
        ("grip", "1e-9", "ground.grip: expected 0.001 to 100, got 1e-09"),
        ("grip", "0.0", "ground.grip: expected a positive number, got 0.0"),
        ("resistance_ohm", "0.0", "motor.resistance_ohm: expected a positive number, got 0.0"),
        ("torque_nm_per_a", "-0.18", "motor.torque_nm_per_a: expected a positive number, got -0.18"),
        ("speed_filter_ms", "1e300", "motor.speed_filter_ms: expected 0 to 10000, got 1e+300"),
        ("viscous_nms", "1e300", "motor.viscous_nms: expected 1e-09 to 100000, got 1e+300"),
        ("supply_v", "1e-300", "motor.supply_v: expected 0.1 to 10000, got 1e-300"),
        ("linear_mps", "1e300", "limits.linear_mps: expected 0.001 to 100, got 1e+300"),
        ("gear", "1e-9", "wheel[0].gear: expected 0.01 to 10000, got 1e-09"),
        ("max_current_a", "15.0", "motor.max_current_a: a C610 is told 10 A at most, got 15"),
    ],
)
def test_an_impossible_robot_file_is_refused_with_file_and_key(tmp_path, key, value, sentence):
    path = tmp_path / "odd.toml"
    lines = (ROBOTS_DIR / "m2006.toml").read_text().splitlines()
    path.write_text("\n".join(f"{key} = {value}" if line.startswith(f"{key} =") else line for line in lines))
    with pytest.raises(ConfigError) as refusal:
        load_robot(path)
    assert str(refusal.value) == f"{path}: {sentence}"


@pytest.mark.parametrize(
    ("table", "inertia_kgm2", "says"),
    [
        ("body", 1e-4, ""),  # reference plant model, section 2: J sum H_w^2 = 0.0184, which is 184 times this
        ("body", 5.6e-5, r"body\.inertia_kgm2: the wheels' motor\.inertia_kgm2 weighs 328 times as much"),
        (
            "motor",
            1.2,
            r"body\.mass_kg: the wheels' motor\.inertia_kgm2 weighs 1920 times as much",
        ),  # 3.072 kg of 1.6 kg
    ],
)
def test_wheels_that_outweigh_their_body_by_far_are_refused(table, inertia_kgm2, says):
    """A decimal point or a gear squared twice: a step of the floor's solve was then wrong by half a motor's torque."""
    robot = load_robot("m2006")
    odd = replace(robot, **{table: replace(getattr(robot, table), inertia_kgm2=inertia_kgm2)})
    if not says:
        prepare(robot=odd, seconds=0.1)
        return
    with pytest.raises(ConfigError, match=says):
        prepare(robot=odd, seconds=0.1)


NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("table", "key", "value", "sentence"),
    [
        ("body", "mass_kg", NAN, "body.mass_kg: expected a finite number, got nan"),
        ("body", "mass_kg", 0.0, "body.mass_kg: expected a positive number, got 0.0"),
        ("body", "inertia_kgm2", INF, "body.inertia_kgm2: expected a finite number, got inf"),
        ("body", "cog_height_m", NAN, "body.cog_height_m: expected a finite number, got nan"),
        ("ground", "grip", NAN, "ground.grip: expected a finite number, got nan"),
        ("ground", "grip", -1.0, "ground.grip: expected a positive number, got -1.0"),
        ("ground", "rolling", -1.0, "ground.rolling: expected a positive number, got -1.0"),
        ("motor", "load_friction", 1.5, "motor.load_friction: expected less than 1, got 1.5"),
        ("control", "kp_a_per_radps", NAN, "control.kp_a_per_radps: expected a finite number, got nan"),
        ("limits", "current_a", 12.0, "limits.current_a: 12.0 A is above motor.max_current_a"),
        ("wheel", "radius_m", 0.0, "wheel[0].radius_m: expected a positive number, got 0.0"),
        ("wheel", "radius_m", NAN, "wheel[0].radius_m: expected a positive number, got nan"),
        ("wheel", "x_m", NAN, "wheel[0].x_m: expected a finite number, got nan"),
        ("wheel", "can_id", 9, "wheel[0].can_id: expected 1 to 8 as printed on the ESC, got 9"),
        ("wheel", "roller_rad", math.pi / 2, "wheel[0].roller_deg: a roller axis across the wheel cannot drive"),
        ("motor", "kind", "dm3519", "dm3519: the table [dm3519] is missing"),
        ("forward", "travel", NAN, "rc: forward.travel: expected a positive number"),
    ],
)
def test_an_impossible_robot_made_in_python_is_refused_at_the_same_door(table, key, value, sentence):
    """Where it is let in, a mass that is no number ends Python with it, and a grip that is none drives on."""
    robot = load_robot("m2006")
    if table == "wheel":
        first, *rest = robot.wheels
        changed = replace(robot, wheels=(replace(first, **{key: value}), *rest))
    elif table == "forward":
        changed = replace(robot, rc=replace(robot.rc, forward=replace(robot.rc.forward, **{key: value})))
    else:
        changed = replace(robot, **{table: replace(getattr(robot, table), **{key: value})})
    with pytest.raises(ConfigError) as refusal:
        prepare(robot=changed, seconds=0.1)
    assert str(refusal.value).startswith(f"robot 'm2006': {sentence}")


def test_a_wheel_too_light_for_its_back_emf_is_refused(tmp_path):
    """Stable below 2 J R/(Kt Ke) = 1 ms: J above 0.18 x 0.448 x 1e-3/0.8 = 1.0e-4 kg m^2; below, the plant explodes."""
    for inertia, is_fine in (("1.02e-4", True), ("1.0e-4", False)):
        path = tmp_path / "light.toml"
        path.write_text(
            (ROBOTS_DIR / "m2006.toml").read_text().replace("inertia_kgm2 = 1.2e-3", f"inertia_kgm2 = {inertia}")
        )
        if is_fine:
            assert load_robot(path).motor.inertia_kgm2 == 1.02e-4
        else:
            with pytest.raises(ConfigError, match=r"motor\.inertia_kgm2: expected at least 0\.0001 with this torque"):
                load_robot(path)


@pytest.mark.parametrize("name", robot_names())
def test_our_own_robots_pass_and_stay_finite_under_nonsense(name):
    plant = Plant(load_robot(name))
    count = len(plant.currents_a)
    for _ in range(100):
        plant.step([math.nan, math.inf, -math.inf, 1e308, -1e308, 0.0][:count])
    assert plant.bad_currents >= min(count, 3)  # a robot at rest is not asked again
    assert all(map(math.isfinite, (*plant.pose, *plant.twist, *plant.wheel_speeds_radps, *plant.currents_a)))


def test_a_run_says_that_currents_were_no_numbers(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text('schema = 1\nname = "short"\nseconds = 0.1\n')
    job = from_source(path)
    assert isinstance(job.bench.world.motors, SimulatedMotors)
    summary = Summary(len(job.bench.robot.wheels))
    for out in job:
        summary.add(out)
    assert "bad_currents" not in summary.facts(job)
    job.bench.world.plant.step((math.nan, 0.0, math.inf))
    assert summary.facts(job)["bad_currents"] == 2
    assert any("2 commanded currents were no finite number" in line for line in summary.lines(job))


@pytest.mark.parametrize(("cog_height_m", "lifts"), [(0.035, False), (0.3, True)])
def test_a_run_says_that_a_wheel_would_have_left_the_floor(cog_height_m, lifts):
    """Sideways at 2 (6.234 N)(0.061 m sin 75)/(m h): 13 m/s2 for m2006 as it is, above its grip; at 0.3 m, 1.5 m/s2."""
    robot = load_robot("m2006")
    tall = replace(robot, body=replace(robot.body, cog_height_m=cog_height_m))
    drive = {"seconds": 1.5, "stick": [{"at_s": 0.1, "aux1": True}, {"at_s": 0.2, "left": 1.0}, {"at_s": 1.0}]}
    job = prepare(robot=tall, **drive)
    summary = Summary(len(robot.wheels))
    for out in job:
        summary.add(out)
    assert ("wheel_lift_s" in summary.facts(job)) == lifts
    assert any("a wheel would have left the floor for" in line for line in summary.lines(job)) == lifts
    again = run(robot=tall, **drive).summary  # in blocks
    assert again.get("wheel_lift_s") == summary.facts(job).get("wheel_lift_s")


@pytest.mark.parametrize(("inertia_kgm2", "inexact"), [(0.0012, False), (0.1, True)])
def test_a_run_says_that_the_floor_s_forces_were_not_exact(inertia_kgm2, inexact):
    """Heavy wheels at odd places under a light body, on rollers that turn hard: some steps end at the most sweeps."""
    robot = load_robot("omni4")
    wheels = [
        replace(
            wheel, x_m=0.15 * math.cos(bearing), y_m=0.15 * math.sin(bearing), heading_rad=bearing + math.pi / 2,
            roller_rad=roller_rad,
        )
        for wheel, bearing, roller_rad in zip(
            robot.wheels, map(math.radians, (2, 89, 208, 250)), (math.pi / 6, 0.0, 0.0, 0.0), strict=True
        )
    ]  # fmt: skip
    heavy = replace(
        robot, wheels=tuple(wheels), body=replace(robot.body, mass_kg=3.0),
        motor=replace(robot.motor, inertia_kgm2=inertia_kgm2), ground=replace(robot.ground, grip=0.5, rolling=1.0),
    )  # fmt: skip
    stick = [{"at_s": 0.1, "aux1": True}, {"at_s": 0.3, "forward": 0.5}, {"at_s": 0.7, "forward": 0.0, "left": 0.5}]
    job = prepare(robot=heavy, seconds=1.5, stick=[*stick, {"at_s": 1.1, "left": 0.0, "turn": 0.5}])
    summary = Summary(len(robot.wheels))
    for out in job:
        summary.add(out)
    assert ("inexact_steps" in summary.facts(job)) == inexact
    assert any("before the forces of the floor were exact" in line for line in summary.lines(job)) == inexact


def test_wrong_calls_are_refused():
    with pytest.raises(ValueError, match="2 currents for 3 wheels"):
        Plant(m2006()).step((0.0, 0.0))
