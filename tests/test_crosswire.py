"""What the wires of a run say of each other: green where they agree, red for the true cause where they do not."""

import json
import math
from dataclasses import replace
from html import escape
from xml.etree import ElementTree as Xml

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.__main__ import main
from bench.check.conduct import conduct, shortcomings
from bench.check.crosswire import Checks, CrossWire
from bench.check.crosswire.block import Block
from bench.check.crosswire.counts import Counts
from bench.check.crosswire.finding import Finding, Outcome, check_lines
from bench.check.crosswire.recorded import outcomes_of
from bench.check.crosswire.settings import AnswersCheck
from bench.check.reading import Recording
from bench.check.sources import from_recording, from_scenario
from bench.check.subjects import integrator_wind_up, wheel_swap
from bench.config import ConfigError, load_robot, robot_names
from bench.loop import Bench, simulated
from bench.messages import BodyTwist, TickInput, TickOutput
from bench.rc.transmitter import Sticks, Transmitter
from bench.slamware.framing import CONTROL_BUS, ERROR, OK, STANDARD, encode_frame

MOTION, REST, ANSWERS, BUS = range(4)
DRIVE = """
schema = 1
name = "drive"
robot = "{robot}"
seconds = {seconds}
[[core]]
at_s = 0.1
vx_mps = 0.2
vy_mps = 0.1
omega_radps = 0.8
[[core]]
at_s = 1.6
vx_mps = -0.1
[[core]]
at_s = 2.0
"""


@pytest.fixture
def run(tmp_path):
    """A run of three seconds by the core, around a bend, back, and to rest; with more text if given."""

    def make(more="", robot="slamware-b", seconds=2.2, **choices):
        path = tmp_path / "drive.toml"
        path.write_text(DRIVE.format(robot=robot, seconds=seconds) + more)
        return from_scenario(path, **choices)

    return make


def outcomes(job, change=lambda out: out):
    """Of a run whose wires have been changed on their way to the checks."""
    for out in job:
        job.checks.add(change(out))
    return job.checks.outcomes()


def texts(outcome):
    return [finding.text for finding in outcome.findings]


# --- motion ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_moves_as_its_wires_say(name, tmp_path):
    robot = load_robot(name)
    bench = simulated(robot)
    sticks = Transmitter(robot.rc) if robot.rc else None
    checks = CrossWire(robot, bench.state_columns)
    for tick in range(2300):
        held = Sticks(0.4, 0.3, 0.5) if 400 <= tick < 1500 else Sticks(aux1=100 <= tick < 200)
        twist = BodyTwist(0.15, 0.1, 0.8) if tick == 400 and sticks is None else None
        twist = BodyTwist(0.0, 0.0, 0.0) if tick == 1500 else twist
        checks.add(bench.tick(TickInput(sticks.step(tick, held) if sticks else b"", twist)))
    assert math.hypot(*bench.world.plant.pose[:2]) > 0.03
    found = checks.outcomes()
    assert [one.lines for one in found if not one.ok] == []
    assert found[MOTION].judged >= 4
    # Where nothing slips the wires agree to a tenth of what is allowed; robots that brake hard slip.
    slips = name in ("m2006", "dm3519", "siegwart", "mecanum")
    assert found[MOTION].used < (0.7 if slips else 0.1)
    assert found[BUS].used < 0.96


def _backwards(out):
    """The angle of ESC 2 counts down where it should count up."""
    turned = tuple(
        (can_id, ((8192 - (data[0] << 8 | data[1])) % 8192).to_bytes(2, "big") + data[2:]) if can_id == 0x202 else frame
        for frame in out.can_feedback
        for can_id, data in [frame]
    )
    return out._replace(can_feedback=turned)


def test_an_encoder_with_the_wrong_sign_is_named(run):
    found = outcomes(run(), _backwards)[MOTION]
    assert not found.ok
    assert any("wheel 2 counts the other way round" in text for text in texts(found))
    assert any(text.startswith("SLAMWARE 0x41 and the encoder counts on CAN part") for text in texts(found))
    assert not any(text.startswith("SLAMWARE 0x41 and the truth") for text in texts(found)), "those two agree"
    assert found.findings[0].first_tick < 1200


def test_a_wrong_sign_is_seen_through_slip_and_slip_alone_is_nobodys_fault(run):
    ice = '[[fault]]\nname = "ice"\nwire = "plant"\nkind = "slippery"\nfactor = 0.02\nat_s = 0.0\n'
    sliding = outcomes(run(ice))[MOTION]
    assert sliding.ok
    assert not outcomes(run(ice), _backwards)[MOTION].ok
    job = run(ice)
    conduct(job)
    assert job.bench.base.odometry.pose.x_m - job.bench.world.plant.pose.x_m > 0.005, "it did slip"


@pytest.mark.parametrize(
    ("robot", "form"), [("slamware-a", "document-000-a-as-printed"), ("slamware-b", "document-000-b-as-printed")]
)
def test_the_printed_dead_reckoning_is_caught(run, robot, form):
    """Document 000 leaks R times the rotation into dy: the base tells a way that its wheels did not go."""
    arm = "[[stick]]\nat_s = 0.05\naux1 = true\n[[stick]]\nat_s = 0.15\n" if robot == "slamware-a" else ""
    assert outcomes(run(arm, robot))[MOTION].ok
    found = outcomes(run(arm, robot, odometry=form))[MOTION]
    assert [text.split(" part ")[0] for text in texts(found)] == [
        "SLAMWARE 0x41 and the encoder counts on CAN",
        "SLAMWARE 0x41 and the truth",
    ]


def test_a_base_that_takes_its_wheels_for_each_other_tells_another_way():
    robot = load_robot("m2006")
    bench = simulated(robot)
    bench = Bench(wheel_swap(robot), bench.world)
    checks = CrossWire(robot, bench.state_columns)
    frames = Transmitter(robot.rc)
    for tick in range(1800):
        sticks = Sticks(forward=0.3) if tick > 300 else Sticks(aux1=100 <= tick < 200)
        checks.add(bench.tick(TickInput(frames.step(tick, sticks))))
    found = checks.outcomes()[MOTION]
    assert any(text.startswith("SLAMWARE 0x41 and the encoder counts") for text in texts(found))


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ('kind = "stuck"\nesc = 1\nat_s = 0.5\nfor_s = 0.6', "wheel 1 turned"),
        ('kind = "stuck"\nesc = 1\nat_s = 0.1', "wheel 1 turns, and its counts stand still"),
        ('kind = "drop"\nesc = 1\nat_s = 0.5\nfor_s = 0.3', "wheel 1 was not heard for 301 ms"),
    ],
)
def test_a_faulty_encoder_is_a_finding_with_its_fault_and_may_be_expected(run, tmp_path, fault, says):
    more = f'[[fault]]\nname = "worn cable"\nwire = "feedback"\n{fault}\n'
    job = run(more)
    conduct(job, job.recorder(tmp_path / "run"))
    found = job.checks.outcomes()
    wheels = next(text for text in texts(found[MOTION]) if "encoder counts on CAN and the truth" in text)
    assert says in wheels
    assert wheels.endswith("(the fault 'worn cable' acted then)")
    assert any(line.startswith("motion: ") for line in shortcomings(job))
    offline = outcomes_of(Recording.open(tmp_path / "run"))
    assert [texts(one) for one in offline] == [texts(one) for one in found]
    assert [one.used for one in offline] == pytest.approx([one.used for one in found], rel=1e-3)
    for state, ok in (("off", True), ("expected", True)):
        job = run(f'{more}[checks]\nmotion = "{state}"\n')
        conduct(job)
        assert job.checks.outcomes()[MOTION].ok is ok
        assert shortcomings(job) == []


def test_page_junit_and_json_tell_the_finding(run, tmp_path, capsys):
    run('[[fault]]\nname = "worn cable"\nwire = "feedback"\nkind = "stuck"\nesc = 1\nat_s = 0.1\n')
    path = str(tmp_path / "drive.toml")
    files = ["--html", str(tmp_path / "page.html"), "--junit", str(tmp_path / "junit.xml")]
    assert main(["replay", path, "--json", *files]) == 1
    facts = json.loads(capsys.readouterr().out)
    motion = facts["summary"]["checks"][MOTION]
    assert (motion["name"], motion["ok"]) == ("motion", False)
    said = motion["findings"][0]["text"]
    assert f"motion: {said}" in facts["reasons"]
    case = Xml.parse(tmp_path / "junit.xml").getroot().find(".//testcase[@name='check motion']/failure")
    assert said in case.get("message")
    page = (tmp_path / "page.html").read_text()
    assert escape(said) in page
    assert page.count(">motion</text>") == 2, "across speeds and currents"


def test_a_finding_that_is_expected_and_does_not_come_fails(run):
    job = run('[checks]\nmotion = "expected"\n')
    conduct(job)
    assert "motion: the scenario expects a finding, and there was none" in shortcomings(job)[0]


# Rotor speeds that change by what a motor can: behind 36:1, 1500 rad/s2 of the wheel are 70 counts a tick, each tick.
PROFILES = st.lists(st.tuples(st.integers(-70, 70), st.integers(1, 60)), min_size=1, max_size=12)


@settings(max_examples=60, deadline=None)
@given(PROFILES, st.integers(0, 8191))
def test_counts_are_those_of_a_sum_tick_by_tick(pushes, start):
    wheel = load_robot("m2006").wheels[0]
    counts, total, speed, sums, outs = Counts([wheel]), 0, 0, [], []
    for push, ticks in pushes:
        for _ in range(ticks):
            speed = max(-2000, min(2000, speed + push))
            total += speed
            sums.append(total - (sums[0] if sums else 0))
            if len(sums) == 1:
                first, sums[0] = total, 0
            else:
                sums[-1] = total - first
            angle = ((start + total) % 8192).to_bytes(2, "big") + bytes(6)
            outs.append(TickOutput(len(outs), b"", b"", b"", (), ((0x201, angle),), None))
    for at in range(0, len(outs), 100):
        block = Block(outs[at : at + 100])
        counts.take(block)
        assert [counts.sums(place)[0] for place in range(len(block))] == sums[at : at + 100]


def test_one_by_one_or_in_blocks_is_the_same(run):
    one, other = run(), run()
    for block in other.blocks():
        other.checks.extend(block)
    assert [each.as_dict() for each in outcomes(one)] == [each.as_dict() for each in other.checks.outcomes()]


@pytest.mark.parametrize(
    ("outcomes", "line"),
    [
        ([("motion", 3, 0.4), ("bus", 9, 0.54)], "the wires agree; used of what is allowed: motion 40%, bus 54%"),
        (
            [("motion", 3, 0.4), ("answers", 0, 0.0)],
            "the wires agree; used of what is allowed: motion 40%; nothing to judge: answers",
        ),
        ([("answers", 0, 0.0)], "the wires agree; nothing to judge: answers"),
        ([("motion", 3, 0.4), ("bus", 9, None)], "the rest agrees; used of what is allowed: motion 40%"),
    ],
)
def test_the_line_of_checks_says_agree_and_how_far_only_of_what_was_judged(outcomes, line):
    bad = (Finding("apart", 1, 2),)
    made = [
        Outcome(name, "on", bad if used is None else (), judged, "", used or 0.0) for name, judged, used in outcomes
    ]
    assert check_lines(made)[0] == f"checks    {line}"


# --- current at rest -------------------------------------------------------------------------------------------------


def test_an_integrator_that_nobody_empties_is_found_at_rest(run, monkeypatch):
    good = outcomes(run(seconds=3.5))[REST]
    assert good.ok
    assert good.judged >= 1
    assert good.used < 0.1
    monkeypatch.setattr("bench.controller.REST_LEAK", 1.0)
    found = outcomes(run(seconds=3.5))[REST]
    assert not found.ok
    assert "mA in a robot that stands as it is told" in texts(found)[0]


def test_the_wound_up_subject_is_found_too():
    robot = load_robot("m2006")
    bench = Bench(integrator_wind_up(robot), simulated(robot).world)
    checks = CrossWire(robot, bench.state_columns)
    frames = Transmitter(robot.rc)
    for tick in range(3000):
        sticks = Sticks(forward=0.3) if 300 < tick < 900 else Sticks(aux1=100 <= tick < 200)
        checks.add(bench.tick(TickInput(frames.step(tick, sticks))))
    found = checks.outcomes()[REST]
    assert found.judged >= 1
    assert not found.ok


def test_who_is_pushed_or_told_to_go_may_draw_what_it_needs(run, tmp_path):
    push = '[[fault]]\nwire = "plant"\nkind = "push"\nforce_n = 8.0\nbearing_deg = 30.0\nat_s = 2.6\nfor_s = 0.9\n'
    job = run(push, seconds=3.5)
    conduct(job)
    assert job.checks.outcomes()[REST].ok
    # Against a wall: it stands, draws all it may, and was asked to.
    sticks = "[[stick]]\nat_s = 0.1\naux1 = true\n[[stick]]\nat_s = 0.3\nforward = 0.8"
    wall = f"[arena]\nlength_m = 1.0\nwidth_m = 1.0\n{sticks}"
    text = f'schema = 1\nname = "wall"\nseconds = 4.0\n{wall}\n'
    (tmp_path / "wall.toml").write_text(text)
    leaning = from_scenario(tmp_path / "wall.toml")
    conduct(leaning)
    found = leaning.checks.outcomes()
    assert leaning.bench.world.plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)
    assert max(map(abs, leaning.bench.world.plant.currents_a)) > 0.2
    assert found[REST].ok


@pytest.mark.parametrize("name", ["m2006", "mecanum"])
def test_who_sets_off_is_not_at_rest_whichever_frame_of_whatever_protocol_told_it(name):
    """A DBUS frame ends with silence: the base goes 14 ms before the next one comes, and draws current by then."""
    robot = load_robot(name)
    bench = simulated(robot)
    checks = CrossWire(robot, bench.state_columns)
    frames = Transmitter(robot.rc)
    for tick in range(5 * 770):
        sticks = Sticks(forward=0.5) if tick % 770 > 700 else Sticks(aux1=100 <= tick < 200)
        checks.add(bench.tick(TickInput(frames.step(tick, sticks))))
    found = checks.outcomes()[REST]
    assert found.judged >= 4
    assert texts(found) == []


SHAKEN = "[noise]\nangle_counts = 2\n"


def test_a_loop_that_answers_shaken_angles_is_not_blamed_unless_the_scenario_says_what_it_may_draw(run, tmp_path):
    job = run(SHAKEN, seconds=3.5)
    conduct(job, job.recorder(tmp_path / "run"))
    found = job.checks.outcomes()[REST]
    assert (found.ok, found.judged, shortcomings(job)) == (True, 0, [])
    assert found.measured.startswith("not judged: the scenario's [noise] shakes the angles")
    assert outcomes_of(Recording.open(tmp_path / "run"))[REST] == found
    again = from_recording(tmp_path / "run")
    conduct(again)
    assert again.checks.outcomes()[REST] == found
    strict = outcomes(run(f"{SHAKEN}[checks.rest_current]\ncurrent_a = 0.01\n", seconds=3.5))[REST]
    assert not strict.ok
    assert outcomes(run(f"{SHAKEN}[checks.rest_current]\ncurrent_a = 1.0\n", seconds=3.5))[REST].judged >= 1
    late = outcomes(run("[noise]\nlate_ticks = 3\nloss = 0.01\n", seconds=3.5))[REST]
    assert (late.ok, late.judged >= 1) == (True, True)


# --- answers ---------------------------------------------------------------------------------------------------------

POLL = encode_frame(CONTROL_BUS, b"\x41" + bytes(12), STANDARD)
TOLD = encode_frame(OK, bytes(13))
POWER, POWER_TOLD = encode_frame(CONTROL_BUS, b"\x30", STANDARD), encode_frame(OK, bytes(6))


def exchange(*said, ticks=1000, within_ms=200):
    """The answers check after (tick, request, answer) triples."""
    by_tick = {tick: (request, answer) for tick, request, answer in said}
    checks = CrossWire(
        load_robot("m2006"), simulated("m2006").state_columns, Checks(answers=AnswersCheck("on", within_ms))
    )
    for tick in range(ticks):
        request, answer = by_tick.get(tick, (b"", b""))
        checks.add(TickOutput(tick, b"", request, answer, (), (), None))
    return checks.outcomes()[ANSWERS]


def test_each_answer_to_its_request():
    assert exchange(
        (10, POLL, TOLD), (60, POWER, b""), (70, b"", POWER_TOLD), (100, POLL + POWER, TOLD + POWER_TOLD)
    ).ok


@pytest.mark.parametrize(
    ("said", "says"),
    [
        (
            [(10, POLL, TOLD), (60, POLL, b""), (400, POLL, TOLD)],
            "no answer to a request 0x41 within 200 ms, at 0.060 s",
        ),
        ([(10, POLL, TOLD + TOLD)], "a second answer to one request 0x41, at 0.010 s"),
        ([(10, b"", POWER_TOLD)], "an answer that nobody asked for (an OK, 6 bytes), at 0.010 s"),
        ([(10, POLL + POWER, POWER_TOLD + TOLD)], "an OK with 6 bytes answers a request 0x41, which it cannot"),
        ([(10, POLL, b""), (260, b"", TOLD)], "no answer to a request 0x41 within 200 ms"),
        ([(10, POLL, b"\x11\x22"), (20, b"", TOLD)], "2 bytes from the base are no frame"),
    ],
)
def test_an_answer_that_is_lost_twice_unasked_out_of_order_or_late(said, says):
    found = exchange(*said)
    assert not found.ok
    assert texts(found)[0].startswith(says)


def test_a_late_answer_is_one_finding_and_what_follows_is_in_order():
    found = exchange((10, POLL, b""), (260, b"", TOLD), (300, POLL, TOLD), (350, POWER, POWER_TOLD))
    assert len(found.findings) == 1
    assert exchange((10, POLL, b""), (260, b"", TOLD), within_ms=300).ok


def test_after_a_damaged_request_nobody_knows_what_the_base_made_of_it():
    damaged = POLL[:5] + b"\xff" + POLL[6:]
    refused = encode_frame(ERROR, b"\x40\x00")
    assert exchange((10, damaged, refused), (60, POLL, b""), (110, POLL, TOLD)).ok
    assert not exchange((10, damaged, refused), (900, POLL, b""), ticks=1400).ok


def test_faults_on_the_way_to_the_base_make_no_findings_of_their_own(run):
    for kind in (
        'kind = "corrupt"\nprobability = 0.1',
        'kind = "truncate"\nkeep = 5',
        'kind = "duplicate"',
        'kind = "drop"',
    ):
        job = run(f'[[fault]]\nwire = "core"\n{kind}\nat_s = 0.5\nfor_s = 0.6\n')
        conduct(job)
        assert job.injector.untouched() == [], kind
        found = job.checks.outcomes()[ANSWERS]
        assert found.judged, kind
        assert found.ok, (kind, found.lines)


# --- buses -----------------------------------------------------------------------------------------------------------


def bus(*, robot="m2006", ticks=300, **columns):
    """The bus check of a run whose every tick brings the same."""
    checks = CrossWire(load_robot(robot), simulated(robot).state_columns)
    plain = TickOutput(0, b"", b"", b"", ((0x200, bytes(8)),), tuple((0x200 + n, bytes(8)) for n in (1, 2, 3)), None)
    for tick in range(ticks):
        checks.add(plain._replace(tick=tick, **{name: value(tick) for name, value in columns.items()}))
    return checks.outcomes()[BUS]


REPORTS = tuple((0x200 + n, bytes(8)) for n in (1, 2, 3))


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"can_feedback": lambda _: (*REPORTS, REPORTS[0])}, "0x201 200 times within 100 ms, where 1000 a second"),
        ({"can_feedback": lambda t: REPORTS * (1 + (t % 6 == 0))}, "0x201 117 times within 100 ms"),
        ({"can_commands": lambda _: ((0x200, bytes(8)), (0x203, bytes(8)))}, "0x203 came from the base"),
        ({"can_feedback": lambda _: (*REPORTS[:2], (0x200, bytes(8)))}, "0x200 came from a motor's side"),
        ({"can_feedback": lambda t: (*REPORTS, *([(0x205, bytes(8))] * (t == 7)))}, "0x205 unknown ESC, once"),
        ({"can_feedback": lambda _: ((0x201, bytes(7)), *REPORTS[1:])}, "0x201 wrong length"),
        ({"can_feedback": lambda _: ((0x201, bytes(9)), *REPORTS[1:])}, "0x201 with 9 bytes is no classic CAN frame"),
        ({"rc": lambda _: bytes(11)}, "1100 RC bytes (uart12) within 100 ms, where the line carries 960"),
        ({"base_to_core": lambda _: bytes(13)}, "1300 answers of the base within 100 ms, where the line carries 1152"),
        ({"core_to_base": lambda t: bytes(1400) if t == 150 else b""}, "1400 requests to the base within 100 ms"),
    ],
)
def test_what_no_wire_can_carry(columns, says):
    assert bus().ok
    found = bus(**columns)
    assert not found.ok
    assert any(text.startswith(says) for text in texts(found)), texts(found)


@pytest.mark.parametrize(
    ("profile", "bytes_per_100_ms"),
    # 100 ms of the line by its settings: start, eight bits, parity, stop bits.
    [("uart12", 960), ("frsky-sbus", 833), ("dr16", 909), ("flysky", 1152), ("elrs", 4200)],
)
def test_each_rc_line_has_its_own_rate(profile, bytes_per_100_ms):
    robot = load_robot("m2006", profile)
    for most, ok in ((bytes_per_100_ms, True), (bytes_per_100_ms + 70, False)):
        checks = CrossWire(robot, simulated(robot).state_columns)
        for tick in range(100):
            checks.add(TickOutput(tick, bytes(most) if tick == 0 else b"", b"", b"", (), (), None))
        assert checks.outcomes()[BUS].ok is ok


def test_more_motors_than_a_bus_carries_at_1_khz():
    """docs/bus.md: seven motors at 1 kHz both ways do not fit, and six do."""
    motors = tuple(replace(load_robot("m2006").wheels[0], can_id=n, name=str(n)) for n in range(1, 9))
    for count, ok in ((6, True), (8, False)):
        robot = replace(load_robot("m2006"), wheels=motors[:count])
        columns = [*simulated("m2006").state_columns, *(f"wheel{n}_radps" for n in range(4, 9))]
        checks = CrossWire(load_robot("m2006"), columns)
        checks = type(checks._bus)(robot, checks.checks.bus)
        commands = ((0x200, bytes(8)), (0x1FF, bytes(8)))
        reports = tuple((0x200 + n, bytes((n, 7, 1, 200, 3, 9, 0, 0))) for n in range(1, count + 1))
        checks.take(Block([TickOutput(t, b"", b"", b"", commands, reports, None) for t in range(100)]))
        assert checks.outcome().ok is ok, checks.outcome().lines


# --- in a scenario ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('moton = "off"', "checks.moton: unknown key; did you mean motion?"),
        ('motion = "of"', "checks.motion: expected 'on', 'off', 'expected' or a table; got 'of'; did you mean off?"),
        ("motion = {lenght_m = 0.1}", "checks.motion.lenght_m: unknown key; did you mean length_m?"),
        ("rest_current = {current_a = -1.0}", "checks.rest_current.current_a: expected more than 0, got -1.0"),
        ("bus = {rate_hz = 1.5}", "checks.bus.rate_hz: expected a whole number, got 1.5"),
        ("answers = 5", "checks.answers: expected text, got 5"),
    ],
)
def test_a_wrong_table_names_file_and_key(run, text, says):
    with pytest.raises(ConfigError) as refused:
        run(f"[checks]\n{text}\n")
    assert says in str(refused.value)


def test_a_table_changes_what_is_allowed_and_the_recording_keeps_it(run, tmp_path):
    more = "[checks]\nmotion = {angle_deg = 90.0, length_m = 1.0}\nbus = {bitrate = 250000}\n"
    job = run(more)
    assert job.checks.checks.motion.angle_rad == pytest.approx(math.pi / 2)
    for out in job:
        job.checks.add(_backwards(out))
    found = job.checks.outcomes()
    assert found[MOTION].ok
    assert not found[BUS].ok, "at 250 kbit/s four frames a millisecond do not fit"
    again = run(more)
    conduct(again, again.recorder(tmp_path / "run"))
    assert not outcomes_of(Recording.open(tmp_path / "run"))[BUS].ok
