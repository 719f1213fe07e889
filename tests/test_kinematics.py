"""The wheel equation against vectors worked outside the code, and the properties that every layout must have."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.config import Wheel, load_robot, robot_names
from bench.kinematics import (
    Kinematics,
    axis_rows,
    desaturate,
    rotate_into_body,
    singular_values,
    twist_from_document_002,
    twist_from_document_004,
)
from bench.odometry import Odometry, compose, exponential, wrap

KNOWN = json.loads((Path(__file__).parents[1] / "fixtures/known/kinematics/vectors.json").read_text())


def wheels_of(layout):
    return [
        Wheel(
            name=str(i),
            x_m=wheel["x"],
            y_m=wheel["y"],
            heading_rad=math.radians(wheel["delta_deg"]),
            roller_rad=math.radians(wheel["gamma_deg"]),
            radius_m=wheel["r"],
            can_id=i + 1,
        )
        for i, wheel in enumerate(KNOWN["layouts"][layout])
    ]


def answer(vector):
    """What our code makes of a vector's input, under the names of its expected part."""
    kind, given_ = vector["kind"], vector["input"]
    wheels = wheels_of(vector["layout"]) if "layout" in vector else []
    if kind == "properties":
        values = singular_values(axis_rows(wheels), given_["length_scale"])
        rank = len([v for v in values if v > 1e-9])
        return {
            "rank": rank,
            "singular_values_scaled": values,
            "condition_scaled": values[0] / values[2] if rank == 3 else None,
        }
    kinematics = Kinematics(wheels) if wheels else None
    match kind:
        case "ik":
            return {"wheels": kinematics.wheel_speeds(given_["twist"])}
        case "fk":
            speeds = given_["wheels"]
            return {"twist": list(kinematics.twist(speeds)), "slip_residual": kinematics.slip(speeds)}
        case "ik_field":
            vx, vy, omega = given_["field_twist"]
            body = [*rotate_into_body(vx, vy, given_["heading"]), omega]
            return {"body_twist": body, "wheels": kinematics.wheel_speeds(body)}
        case "ik_about_point":
            (vx, vy, omega), (x, y) = given_["twist_at_point"], given_["point"]
            origin = [vx + omega * y, vy - omega * x, omega]
            return {"twist_at_origin": origin, "wheels": kinematics.wheel_speeds(origin)}
        case "rotate":
            vx, vy, omega = given_["field_twist"]
            return {"body_twist": [*rotate_into_body(vx, vy, given_["heading"]), omega]}
        case "desaturate":
            wheels = desaturate(given_["wheels"], given_["limit"])
            return {"wheels": wheels, "scale": max(map(abs, wheels)) / max(map(abs, given_["wheels"]))}
        case "se2_step":
            return {"pose": list(compose(given_["pose"], given_["delta"]))}
        case "odometry_chain":
            pose = given_["pose"]
            for deltas in given_["wheel_deltas"]:
                pose = compose(pose, kinematics.twist(deltas))
            return {"pose": list(pose)}
        case "torque_to_wrench":
            return {"wrench": list(kinematics.wrench(given_["wheel_torques"]))}
        case "rotor":
            speeds = kinematics.wheel_speeds(given_["twist"])
            gear = given_["gear_ratio"]
            return {
                "wheels": speeds,
                "rotor_rpm": [speed * gear * 60 / math.tau for speed in speeds],
                "encoder_counts_per_ms": [speed * gear * 8192 / math.tau / 1000 for speed in speeds],
            }
        case "seed_frame":
            numbers = [value for key, value in given_.items() if key != "document"]
            convert = twist_from_document_004 if given_["document"] == "004" else twist_from_document_002
            return {"twist": list(convert(*numbers))}
    raise AssertionError(f"no answer for kind {kind}")


def test_there_are_52_vectors():
    assert len(KNOWN["vectors"]) == 52


@pytest.mark.parametrize("vector", KNOWN["vectors"], ids=lambda v: f"{v['id']}-{v['kind']}")
def test_vector(vector):
    got = answer(vector)
    for key, expected in vector["expected"].items():
        if key == "pose":  # angles compare modulo a full turn
            assert wrap(got[key][2] - expected[2]) == pytest.approx(0.0, abs=vector["tolerance"])
            assert got[key][:2] == pytest.approx(expected[:2], abs=vector["tolerance"])
        elif expected is None:
            assert got[key] is None
        else:
            assert got[key] == pytest.approx(expected, abs=vector["tolerance"]), key


@pytest.mark.parametrize("name", robot_names())
@given(twist=st.tuples(*[st.floats(-5, 5)] * 3))
def test_forward_undoes_inverse(name, twist):
    kinematics = Kinematics(load_robot(name).wheels)
    assert kinematics.twist(kinematics.wheel_speeds(twist)) == pytest.approx(twist, abs=1e-12)


def test_document_004_matrix():
    rows = Kinematics(load_robot("m2006").wheels).inverse_rows
    expected = [(35.77503, 9.58589, 2.25926), (0, -37.03704, 2.25926), (-35.77503, 9.58589, 2.25926)]
    for row, want in zip(rows, expected, strict=True):
        assert row == pytest.approx(want, abs=1e-5)


def test_a_singular_layout_is_refused():
    with pytest.raises(ValueError, match="singular"):
        Kinematics(wheels_of("mec_diamond"))


@given(speeds=st.lists(st.floats(-100, 100), min_size=3, max_size=4), limit=st.floats(0.1, 50))
def test_desaturation_keeps_the_direction(speeds, limit):
    scaled = desaturate(speeds, limit)
    assert max(map(abs, scaled)) <= limit * (1 + 1e-12)
    fastest = max(map(abs, speeds))
    for before, after in zip(speeds, scaled, strict=True):
        assert after * fastest == pytest.approx(before * max(map(abs, scaled)), abs=1e-9)


@pytest.mark.parametrize("turn", [math.pi / 2, math.pi, math.tau, -math.pi / 2])
def test_an_arc_in_many_steps_ends_where_geometry_says(turn):
    # 1 m/s and 2 rad/s: a circle of 0.5 m. Quarter and half turns expose Euler steps, full circles hide them.
    odometry = Odometry(Kinematics(load_robot("m2006").wheels))
    kinematics = Kinematics(load_robot("m2006").wheels)
    steps = 1000
    length = abs(turn) / 2
    for _ in range(steps):
        odometry.advance(kinematics.wheel_speeds((length / steps, 0.0, turn / steps)))
    radius = math.copysign(0.5, turn)
    assert odometry.pose.x_m == pytest.approx(radius * math.sin(turn), abs=1e-9)
    assert odometry.pose.y_m == pytest.approx(radius * (1 - math.cos(turn)), abs=1e-9)
    assert odometry.heading_rad == pytest.approx(turn, abs=1e-9)


def test_increments_are_in_the_frame_of_the_last_mark():
    kinematics = Kinematics(load_robot("m2006").wheels)
    odometry = Odometry(kinematics)
    odometry.advance(kinematics.wheel_speeds((0.0, 0.0, math.pi / 2)))
    assert odometry.take_increment() == pytest.approx((0, 0, math.pi / 2), abs=1e-12)
    odometry.advance(kinematics.wheel_speeds((0.3, 0.1, 0.0)))
    assert odometry.take_increment() == pytest.approx((0.3, 0.1, 0), abs=1e-12)
    assert odometry.take_increment() == pytest.approx((0, 0, 0), abs=1e-12)


@given(st.floats(-50, 50))
def test_wrap_is_the_same_angle_in_half_open_range(angle):
    wrapped = wrap(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0, abs=1e-9)


@given(st.floats(1e-5, 1e-3))
def test_the_series_meets_the_quotients(dtheta):
    dx, dy = exponential(1.0, 0.0, dtheta)
    assert dx == pytest.approx(math.sin(dtheta) / dtheta, abs=1e-12)
    assert dy == pytest.approx(math.tan(dtheta / 2) * math.sin(dtheta) / dtheta, abs=1e-12)
