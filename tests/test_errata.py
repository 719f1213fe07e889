"""Every printed form against what the kinematics reference says of it, section 6: figures from outside, row by row.

The right form goes through the same check beside it, so that no check can be one that nothing passes.
"""

import json
import math
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.__main__ import main
from bench.as_printed import document_000 as d0
from bench.as_printed import document_001 as d1
from bench.as_printed import document_002 as d2
from bench.as_printed import document_003 as d3
from bench.as_printed import document_004 as d4
from bench.cli.errata import lines_of
from bench.config import load_robot
from bench.errata import DOCUMENTS, ROWS, rows
from bench.errata.algebra import AXES, returned, rows_of, tangential, worst
from bench.errata.document_001 import FOUR, MECANUM, THREE, right_wheels
from bench.errata.document_002 import MENDED, arc_mm, driven
from bench.errata.document_003 import times
from bench.errata.document_004 import right_forward, right_inverse
from bench.errata.trial import drive, robot_for
from bench.messages import BodyTwist

# The figures of the kinematics reference, sections 4 and 6. (row, start of the figure's name): (right, as printed,
# tolerance)
REFERENCE = {
    (1, "dy for (0.5 m, -0.2 m, 1 rad)"): ((-0.2,), (-0.38,), 1e-7),
    (1, "row dy of F H"): ((0, 1, 0), (0, 1, -0.18), 1e-7),
    (1, "sideways in one turn"): ((0,), (-1.131,), 5e-4),
    (2, "row dx of F H"): ((1, 0, 0), (0.875, -0.0722, 0.0260), 5e-5),
    (3, "row dy of F H"): ((0, 1, 0), (-0.433, 0.75, -0.09), 5e-5),
    (4, "row dy of F H"): ((0, 1, 0), (0, 1, 0.18), 1e-7),
    (5, "statements"): ((0,), (3,), 0),
    (6, "first report"): ((0, 0, 0), (2, 0, 0), 1e-12),
    (7, "a report of 32.768 m"): ((32.768,), (-32.768,), 1e-6),
    (8, "half-angle"): ((0,), (math.degrees(math.pi / 2 / 31 / 2),), 1e-9),
    (9, "facing 10 deg"): ((0,), (20,), 1e-9),
    (9, "facing 90 deg: direction"): ((0,), (180,), 1e-9),
    (10, "worst row, facing 30"): ((0,), (1,), 1e-9),
    (10, "worst row, facing 90"): ((0,), (2,), 1e-9),
    (10, "facing 90 deg, 1 m/s"): ((0, 1, 0), (0, -1 / 3, -2 / (3 * 0.15)), 1e-9),
    (11, "row of wheel 3"): ((-0.5, -0.866, -1), (-1, 0, -1), 5e-5),
    (11, "y = 1: speed of wheel 3"): ((-0.866,), (0,), 5e-5),
    (11, "y = 1 drives"): ((0, 1, 0), (-0.433, 0.75, -0.217), 5e-4),
    (11, "y = 1: every contact"): ((0,), (0.217,), 5e-4),
    (11, "x = 1 drives"): ((1, 0, 0), (1.25, 0.144, 0.125), 5e-4),
    (12, "yaw over translation"): ((1,), (1.414,), 5e-4),
    (13, "largest error, -180"): ((0,), (1.09e-3,), 5e-6),
    (13, "largest error of a direction"): ((0,), (0.063,), 5e-4),
    (13, "sin^2"): ((0, 0), (-1.7e-4, 2.0e-3), 5e-5),
    (14, "sin(-240"): ((math.sqrt(0.75),), (2.089,), 5e-4),
    (14, "sin(-300"): ((math.sqrt(0.75),), (7.889,), 5e-4),
    (14, "sin(-450"): ((-1,), (62.25,), 5e-3),
    (15, "heading -300"): ((0.866,), (2.086,), 5e-4),
    (16, "relative error"): ((0,), (-1.89e-4,), 5e-7),
    (17, "a circle of 1 m: heading"): ((360,), (6.28,), 5e-3),
    (17, "a circle of 1 m: right"): ((0, 0), (-344, 6271), 0.5),
    (17, "quarter turn"): ((0,), (566,), 0.5),
    (17, "half turn"): ((0,), (1839,), 0.5),
    (18, "30 turns"): ((0,), (30 * math.tau,), 1e-9),
    (18, "1.5 turns"): ((180,), (540,), 1e-9),
    (19, "quarter turn"): ((0,), (3.53,), 0.01),
    (19, "half turn"): ((0,), (5.00,), 0.01),
    (20, "w of 1 rad/s"): ((0.0573,), (0.001,), 5e-6),
    (21, "3.34: wheels"): ((1.154701, -1.333333, -2.333333), (1.154701, -1.333333, -2.333333), 5e-7),
    (21, "3.34 by 3.33 as scanned"): ((1.154701, -1.333333, -2.333333), (1.154701, -1.333333, -5 / 3), 5e-7),
    (22, "1 m/s right drives"): ((1, 0, 0), (0, 1, 0), 1e-12),
    (22, "1 m/s forward drives"): ((0, 1, 0), (1, 0, 0), 1e-12),
    (23, "row vx of F H"): ((1, 0, 0), (0.622, 0, 0), 5e-4),
    (23, "row vy of F H"): ((0, 1, 0), (0, 0.378, -0.00981), 5e-4),
    (23, "row yaw of F H"): ((0, 0, 1), (0, -2.636, 1), 5e-4),
    (23, "1 m/s forward reads back"): ((0, 1, 0), (0, 0.378, -2.64), 5e-3),
    (24, "diagonal"): ((1, 1, 1), (0.5, 0.5, 1), 1e-12),
    (25, "between neighbours"): ((120, 120, 120), (105, 105, 150), 1e-9),
    (25, "condition"): ((1.4142,), (1.7511,), 5e-5),
    (25, "0.1 N m"): ((0, 0, 0.67778), (0, -1.7865, 0.67778), 5e-5),
    # In the plant: what the geometry above makes of a run, and the closed forms of docs/plant.md.
    (1, "a turn on the spot"): ((0,), (1.131,), 5e-3),
    (1, "half a turn"): ((0,), (2 * 0.18,), 5e-3),
    (4, "half a turn"): ((0,), (2 * 0.18,), 5e-3),
    (12, "0.3 m/s and 1 rad/s"): ((0.3,), (0.3 / math.sqrt(2),), 1e-3),
    (17, "a circle of 0.4 m"): ((360,), (6.28,), 0.2),
    (17, "the same"): ((0,), (math.tau * 0.4,), 0.03),
    (21, "a tenth of"): ((0.4, 0.1, 0.2), (0.4, 0.1, 0.2), 1e-3),
    (22, "0.3 m/s right"): ((0, -0.51), (0.51, 0), 0.01),  # 0.3 m/s for 2 s, less the ramp of 0.6 m/s2
    (23, "the same, wheels by the right inverse"): ((0, 1, 0), (0.622, 0, 0), 5e-4),
    (23, "0.3 m/s forward"): ((0,), (math.degrees(2.636 * 0.51),), 2.5),
    # The rim pushes with what turning the base and its rotors leaves of the torque: less than the rolling resistance.
    (25, "0.6 A"): ((0,), (0,), 1e-9),
    # Forward wants cos 15 deg of the wheel speed that 1.0 m/s is, so 0.58 A for each m/s; from 0.3 A, 1.118 m/s an A.
    (26, "0.3 m/s forward"): ((0.3,), (0.1832 - (0.3 - 0.6 * 0.3 * 0.96593) * 1.118,), 2e-3),
    (26, "0.5 m/s"): ((0.5,), (0.1832 - (0.3 - 0.6 * 0.5 * 0.96593) * 1.118,), 2e-3),
    (26, "0.2 m/s"): ((0.2,), (0,), 1e-3),  # 0.116 A less than what friction and rolling loss want
    (26, "2 rad/s"): ((2,), (0,), 1e-3),
    (26, "standing"): ((0.18 * 0.6,), (0,), 1e-9),  # all that 0.6 A give
    (27, "1.0 m/s forward"): ((1.0,), (0.5186,), 1e-3),
    (27, "current for"): ((1.03,), (0.6,), 5e-3),
    (28, "row of wheel 1"): ((9.58589, -35.77503, 2.25926), (9.58589, -35.77503, 2.25926), 0.04),
    (28, "row of wheel 2"): ((-37.03704, 0, 2.25926), (-37.03704, 0, 2.25926), 1e-5),
}


def test_every_row_of_the_reference_is_there_once():
    assert [row.number for row in ROWS] == list(range(1, 29))
    assert {row.document for row in ROWS} == set(DOCUMENTS)
    assert {number for number, _ in REFERENCE} == set(range(1, 29))


@cache
def evidence(number):
    """Runs of the plant take a while: once for all tests of this process."""
    (row,) = rows(number=number)
    return row.measure()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.number)
def test_a_row_has_the_references_figures_shows_a_difference_and_fits_80_columns(row):
    figures = evidence(row.number).figures
    for (number, name), (right, printed, tolerance) in REFERENCE.items():
        if number == row.number:
            (one,) = (one for one in figures if one.name.startswith(name))
            assert one.right == pytest.approx(right, abs=max(tolerance, 1e-9)), name
            assert one.printed == pytest.approx(printed, abs=max(tolerance, 1e-9)), name
    # Where the arithmetic holds, what differs is a comment's figure or the scan's.
    assert any(one.error > 1e-4 for one in figures)
    lines = lines_of(row, evidence(row.number))
    assert max(map(len, lines)) <= 80
    assert lines[0].split()[:3] == [str(row.number), "document", row.document + "," * row.holds + ":" * (not row.holds)]


def figure(number, name):
    return next(figure for figure in evidence(number).figures if figure.name.startswith(name))


def test_forward_travel_on_layout_a_is_told_short_and_aside_by_the_text():
    told, aside = figure(2, "2 s forward"), figure(3, "2 s forward")
    assert told.right[0] > 0.6
    assert told.printed[0] / told.right[0] == pytest.approx(0.875, abs=1e-3)
    assert aside.printed[0] / told.right[0] == pytest.approx(-0.433, abs=1e-3)


def test_field_centric_driving_goes_where_it_should_not():
    clockwise, detailed, far = (
        figure(9, "facing 90 deg, 0.3"),
        figure(10, "facing 90 deg, 0.3"),
        figure(15, "0.3 m/s"),
    )
    for one in (clockwise, detailed, far):
        assert one.right == pytest.approx((0.3 * (1.5 - 0.25), 0, 0), abs=0.01)  # less the ramp of half a second
    assert clockwise.printed == pytest.approx((-0.3 * (1.5 - 0.25), 0, 0), abs=0.02)
    assert detailed.printed[2] < -60
    assert far.printed[2] > 45


def test_four_wheels_by_the_compact_code_fight_at_their_limit():
    driven, current = figure(11, "0.3 m/s forward"), figure(11, "the same")
    assert driven.right == pytest.approx((0.3, 0, 0), abs=1e-3)
    assert driven.printed[1] > 0.05
    assert driven.printed[2] < -0.3
    assert current.printed[0] == pytest.approx(load_robot("omni4").limits.current_a, abs=1e-3)
    assert current.right[0] < 0.5


# --- each printed form fails the check that the right one passes ---------------------------------------------------

WHEELS_A, WHEELS_B = tangential(d0.BEARINGS_A_DEG, 0.18), tangential(d0.BEARINGS_B_DEG, 0.18)


def right_a(da, db, dc):
    return (dc - db) / math.sqrt(3), (2 * da - db - dc) / 3, (da + db + dc) / 0.54


def right_b(da, db, dc):
    return (db - dc) / math.sqrt(3), (-2 * da + db + dc) / 3, (da + db + dc) / 0.54


@pytest.mark.parametrize(
    ("form", "base", "undoes"),
    [
        (right_a, WHEELS_A, True),
        (d0.layout_a_code_as_printed, WHEELS_A, False),
        (d0.layout_a_text_as_printed, WHEELS_A, False),
        (right_b, WHEELS_B, True),
        (d0.layout_b_text_as_printed, WHEELS_B, False),
    ],
)
def test_document_000_forward_undoes_the_wheels(form, base, undoes):
    assert (worst(returned(lambda rims: form(*rims), base.wheel_speeds), AXES) < 1e-6) is undoes


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler here to ask")
@pytest.mark.parametrize(("end", "compiles"), [("", False), (";", True)])
def test_document_000_compiles_once_its_semicolons_are_there(end, compiles, tmp_path):
    lines = "\n".join(line + end for line in d0.CODE_LINES_AS_PRINTED)
    names = "#define COS30f 0.86602540f\n#define SIN30f 0.5f\n#define R 0.18f\n"
    code = names + "float f(float da, float db, float dc) {\n" + lines + "\nreturn dx + dy + dtheta; }\n"
    (tmp_path / "code.c").write_text(code)
    done = subprocess.run(["cc", "-fsyntax-only", str(tmp_path / "code.c")], capture_output=True, check=False)
    assert (done.returncode == 0) is compiles, done.stderr


def test_document_000_a_first_call_is_no_motion():
    counters = [3.0, 1.0, -2.0]
    assert any(d0.odometer_increments_as_printed(counters))
    assert not any(d0.odometer_increments_as_printed(counters, counters))


@given(st.floats(-200, 200))
def test_document_000_numbers_come_back_as_long_as_they_fit(dx_m):
    q16 = d0.displacement_q16_as_printed(dx_m, 0.0, 0.0)[0]
    fits = abs(dx_m) < 32.768
    assert (abs(q16 / 65536 / 1000 - dx_m) < 1e-4) is fits


HEADINGS = st.floats(-170, 170)


@given(HEADINGS)
def test_document_001_omni_equations_want_the_heading_counter_clockwise(heading):
    for base, form in ((THREE, d1.three_wheels_as_printed), (FOUR, d1.four_wheels_detailed_as_printed)):
        right = rows_of(lambda command, base=base: right_wheels(base, 0.15, *command, heading))
        assert worst(right, rows_of(lambda command, form=form: form(*command, heading, d1.EXACT))) < 1e-12
        clockwise = worst(right, rows_of(lambda command, form=form: form(*command, -heading, d1.EXACT)))
        # A turn by twice the heading: the chord of it, at least in one of the columns.
        assert clockwise >= abs(math.sin(math.radians(heading))) - 1e-12


@given(HEADINGS)
def test_document_001_the_detailed_third_wheel_and_the_compact_fourth_robot_are_off(heading):
    three = rows_of(lambda command: right_wheels(THREE, 0.15, *command, heading))
    detailed = rows_of(lambda command: d1.three_wheels_detailed_as_printed(*command, heading, d1.EXACT))
    assert worst(three, detailed) == pytest.approx(2 * abs(math.sin(math.radians(heading))), abs=1e-12)
    four = rows_of(lambda command: right_wheels(FOUR, 0.15, *command, heading))
    assert worst(four, rows_of(lambda command: d1.four_wheels_as_printed(*command, heading, d1.EXACT))) > 0.5


def test_document_001_mecanum_is_consistent_once_z_is_scaled_too():
    root2 = math.sqrt(2)
    right = rows_of(lambda command: right_wheels(MECANUM, 0.22, *command, 20.0))

    def as_printed(z_scale):
        return rows_of(lambda c: d1.mecanum_as_printed(root2 * c[0], root2 * c[1], z_scale * c[2], -20.0, d1.EXACT))

    assert worst(right, as_printed(1.0)) < 1e-12
    plain = rows_of(lambda command: d1.mecanum_as_printed(*command, -20.0, d1.EXACT))
    assert worst(right, plain) > 0.25


@given(st.floats(-math.pi, 2 * math.pi))
def test_document_001_the_fast_sine_is_near_the_sine_in_its_range(angle):
    assert d1.my_sin_as_printed(angle) == pytest.approx(math.sin(angle), abs=1.1e-3)
    assert d1.my_cos_as_printed(angle) == pytest.approx(math.cos(angle), abs=1.1e-3)


@given(st.floats(-720, -205))
def test_document_001_the_fast_sine_fails_below_its_range_and_passes_once_wrapped(degrees):
    angle = math.radians(degrees)
    assert d1.my_sin_as_printed(math.remainder(angle, math.tau)) == pytest.approx(math.sin(angle), abs=1.1e-3)
    assert abs(d1.my_sin_as_printed(angle) - math.sin(angle)) > 0.1


@given(st.floats(-math.pi, math.pi), st.tuples(*[st.floats(-2, 2)] * 3))
def test_document_002_closed_formulas_are_right(theta, twist):
    base = tangential(d2.BEARINGS_DEG, 0.1)
    vx, vy, w = twist  # in the body: right, forward
    rims = base.wheel_speeds((vy, -vx, w))
    c, s = math.cos(theta), math.sin(theta)
    field = (c * vx - s * vy, s * vx + c * vy, w / 1000)
    assert d2.velocity_as_printed(theta, *rims) == pytest.approx(field, abs=1e-9)


@pytest.mark.parametrize(("unit", "within_mm"), [(1.0, None), (MENDED, 5.1)])
def test_document_002_ends_where_the_arc_does_once_its_unit_is_mended(unit, within_mm):
    off = math.dist(driven(1.0, 2.0, math.pi, unit)[:2], arc_mm(1.0, 2.0, math.pi))
    assert off < within_mm if within_mm else off > 1000


def test_document_003_holds_and_its_scan_does_not():
    for inverse, holds in ((d3.inverse_j1f_as_printed, True), (d3.inverse_j1f_scan_as_printed, False)):
        for l_m in (1.0, 0.3):
            back = returned(
                lambda wheels, f=inverse, l_m=l_m: times(f(l_m), wheels),
                lambda twist, l_m=l_m: times(d3.j1f_as_printed(l_m), twist),
            )
            assert (worst(back, AXES) < 1e-12) is holds


EVEN = tuple(map(math.radians, (0, 120, 240)))
PRINTED_004 = tuple(map(math.radians, d4.BEARINGS_DEG))


def test_document_004_its_pair_is_no_pair_and_ours_is():
    assert worst(returned(right_forward, right_inverse), AXES) < 1e-12
    for bearings in (PRINTED_004, EVEN):
        back = returned(
            lambda wheels, b=bearings: d4.forward_as_printed(wheels, b),
            lambda twist, b=bearings: d4.inverse_as_printed(*twist, b),
        )
        assert worst(back, AXES) > 0.4


def test_document_004_the_printed_pair_tells_a_turn_where_forward_is_asked_and_none_where_right_is():
    """By its F H: column forward is (0, 0.378, -2.636), column right (0.622, 0, 0)."""
    pair = robot_for("m2006", controller="inverse-004-as-printed", odometry="forward-004-as-printed")
    forward, right = (drive(pair, BodyTwist(x, y, 0.0), ticks=2000) for x, y in ((0.3, 0.0), (0.0, -0.3)))
    assert figure(23, "0.3 m/s forward").printed == (math.degrees(forward.believed_turned_rad),)
    assert right.believed_turned_rad == pytest.approx(0.0, abs=1e-9)
    assert right.believed.y_m == pytest.approx(-0.622 * right.pose.x_m, rel=2e-3)


def test_document_004_the_firmware_drives_as_the_wheel_equation_says():
    firmware = rows_of(lambda twist: d4.firmware_wheels_as_printed(*twist))
    assert worst(firmware, rows_of(right_inverse)) < 0.04  # of 37: cosines with three digits
    assert worst(firmware, rows_of(lambda twist: d4.inverse_as_printed(*twist, PRINTED_004))) > 20


# --- what the forms are printed as -----------------------------------------------------------------------------------

QUOTES = {
    "000": [
        *d0.CODE_LINES_AS_PRINTED,
        *(row.printed for row in rows("000")[1:4]),
        "resp.base_dx_mm_q16 = (_s32)(dx * 1000 * 65536)",
        "static float wheel_odometer[3];",
        "#define R           0.18f",
    ],
    "001": [
        "-my_cos((0 -ang_motion)*angle_to_radian)*motion[x].v - my_sin((0 -ang_motion)*angle_to_radian)*motion[y].v",
        "c = (a - b)*0.5f;",
        "sine = rad * (1.27323954f + 0.405284735f * rad);",
        "sine = sine*(-0.225f * (sine + 1) + 1);",
        "while(rad > 2*ONE_PI)",
        "ang_motion=imu[z].Relative_Dist",
        "angle_to_radian = 0.01745f",
        "方程默认顺时针为正",
    ],
    "002": [
        "position_yaw += w*delta_t;",
        "float position_yaw = 0; //角度（-180~180）",
        "float w; //底盘旋转角速度(°/ms)",
        "v_x = -2*cos(theta)/3*v_f + (cos(theta)+sqrt(3)*sin(theta))/3*v_i + (cos(theta)-sqrt(3)*sin(theta))/3*v_r;",
        "v_y = -2*sin(theta)/3*v_f + (sin(theta)-sqrt(3)*cos(theta))/3*v_i + (sin(theta)+sqrt(3)*cos(theta))/3*v_r;",
    ],
    "003": ["spin at speeds", "with positive speed and along"],
    "004": [
        r"\sin(\theta_1) & \cos(\theta_1) & L",
        r"\frac{r}{3} \begin{bmatrix} \sin(\theta_1) & \sin(\theta_2) & \sin(\theta_3)",
        "similar to traditional 3 wheel omnidirectial setup",
        r"I = \frac{\omega}{\omega_{max}} \cdot I_{max}",
        "Maximum Current: 0.6A",
        "Maximum Linear Velocity: 1.0 m/s",
    ],
}


@pytest.mark.parametrize("document", DOCUMENTS)
def test_what_is_quoted_stands_in_the_document(document):
    captures = os.environ.get("WHEELBENCH_CAPTURES")
    if captures is None:
        pytest.skip("WHEELBENCH_CAPTURES is not set: the documents lie beside the captures")
    found = list((Path(captures).parent / "seeds").glob(f"{document}_*"))
    if not found:
        pytest.skip(f"document {document} does not lie beside the captures")
    text = found[0].read_text(encoding="utf-8")
    for quote in QUOTES[document]:
        assert quote in text, quote


def test_the_code_of_document_000_is_what_its_lines_say():
    names = {"da": 0.1, "db": 0.3, "dc": -0.2, "R": 0.18, "COS30f": 0.86602540, "SIN30f": 0.5}
    worked = [eval(line.partition("=")[2], {}, names) for line in d0.CODE_LINES_AS_PRINTED]
    assert d0.layout_a_code_as_printed(0.1, 0.3, -0.2) == pytest.approx(worked, abs=1e-15)


def test_printed_forms_say_so_in_their_names_and_which_row_they_are():
    for module in (d0, d1, d2, d3, d4):
        functions = [value for value in vars(module).values() if getattr(value, "__module__", "") == module.__name__]
        functions = [value for value in functions if callable(value) and value.__name__ not in ("Trig",)]
        assert functions
        for function in functions:
            assert "asprinted" in function.__name__.lower().replace("_", ""), function
            if not function.__name__.startswith(("_", "Position")):
                assert "Row" in function.__doc__, function


def test_the_page_says_what_is_measured():
    """docs/errata.md: the table of the speed loop beside document 004's current, line by line."""
    page = (Path(__file__).parents[1] / "docs" / "errata.md").read_text()
    section = page[page.index("## Current proportional") :]
    table = [line.split("|")[1:4] for line in section.splitlines() if line.startswith("| ")][1:]
    measured = [pair for one in evidence(26).figures for pair in zip(one.right, one.printed, strict=True)]
    assert len(table) == len(measured) == 8
    for (asked, *said), pair in zip(table, measured, strict=True):
        assert [float(cell.split()[0]) for cell in said] == pytest.approx(pair, abs=6e-4, rel=0.002), asked


# --- the verb ----------------------------------------------------------------------------------------------------


def errata(capsys, *arguments):
    status = main(["errata", *arguments])
    return status, capsys.readouterr().out


def test_the_verb_prints_the_rows_that_were_asked_for(capsys):
    status, out = errata(capsys, "--document", "002", "--row", "19")
    assert status == 0
    assert out.startswith("19  document 002: ")
    assert "5.003" in out


def test_json_is_an_object_a_row_with_every_figure(capsys):
    status, out = errata(capsys, "--document", "003", "--json")
    (facts,) = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert (facts["row"], facts["arithmetic_holds"]) == (21, True)
    assert {one["ground"] for one in facts["figures"]} == {"geometry", "plant"}
    (scan,) = [one for one in facts["figures"] if one["name"] == "3.34 by 3.33 as scanned"]
    assert scan["right"] == pytest.approx([1.154701, -1.333333, -2.333333], abs=1e-6)
    assert scan["printed"][2] == pytest.approx(-5 / 3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--row", "29"), "expected 1 to 28"),
        (("--document", "005"), "known: 000, 001"),
        (("--row", "1", "--document", "004"), "row of document 000"),
    ],
)
def test_a_wrong_choice_is_one_sentence(capsys, arguments, said):
    assert main(["errata", *arguments]) == 2
    assert said in capsys.readouterr().err
