"""Conditions, signals and expectations: margins by hand, and verdicts on the demo as it runs and from its recording."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.__main__ import main
from bench.check.expectations import FAILED, PASSED, VACUOUS, Expectation, Judge, read_expectation
from bench.check.expression import condition, signals_in
from bench.check.reading import Recording, as_outputs
from bench.check.signals import names
from bench.check.sources import from_scenario
from bench.config import ConfigError, Table, load_robot
from bench.demo import SCENARIO

KNOWN = ("vx_mps", "vy_mps", "heading_rad", "link", "armed", "rc0")


def margin(text, **sample):
    return condition(text, KNOWN).margin(sample)


@pytest.mark.parametrize(
    ("text", "sample", "expected"),
    [
        ("vx_mps < 0.5", {"vx_mps": 0.2}, 0.3),
        ("vx_mps > 0.5", {"vx_mps": 0.2}, -0.3),
        ("not vx_mps > 0.5", {"vx_mps": 0.2}, 0.3),
        ("0.1 <= vx_mps <= 0.5", {"vx_mps": 0.2}, 0.1),
        ("abs(vx_mps) + abs(vy_mps) <= 1", {"vx_mps": -0.25, "vy_mps": 0.25}, 0.5),
        ("hypot(vx_mps, vy_mps) < 6", {"vx_mps": 3.0, "vy_mps": -4.0}, 1.0),
        ("wrap(heading_rad - 3) < 0.5", {"heading_rad": 3.0 + math.tau}, 0.5),
        ("vx_mps < 1 and vy_mps < 1", {"vx_mps": 0.0, "vy_mps": 0.75}, 0.25),
        ("vx_mps < 1 or vy_mps < 1", {"vx_mps": 0.0, "vy_mps": 0.75}, 1.0),
        ("not (vx_mps < 1 or vy_mps < 1)", {"vx_mps": 0.0, "vy_mps": 0.75}, -1.0),
        ("vx_mps == 0.5", {"vx_mps": 0.25}, -0.25),
        ("vx_mps != 0.5", {"vx_mps": 0.25}, 0.25),
        ("-vx_mps * 2 / 4 - 1 <= 0", {"vx_mps": 1.0}, 1.5),
        ("min(vx_mps, vy_mps, 3) >= 2", {"vx_mps": 2.5, "vy_mps": 4.0}, 0.5),
        ("link == 'lost'", {"link": "lost"}, math.inf),
        ("link != 'lost'", {"link": "lost"}, -math.inf),
        ("link in ['live', 'hold']", {"link": "hold"}, math.inf),
        ("link not in ['live', 'hold']", {"link": "hold"}, -math.inf),
        ("armed", {"armed": 1}, math.inf),
        ("not armed", {"armed": 1}, -math.inf),
        ("armed or True", {"armed": 0}, math.inf),
    ],
)
def test_margins_by_hand(text, sample, expected):
    assert margin(text, **sample) == pytest.approx(expected)


@pytest.mark.parametrize("text", ["vx_mps < 1", "vx_mps >= 1", "vx_mps == 1", "vx_mps != 1", "abs(vx_mps) < 1"])
@pytest.mark.parametrize("value", [None, math.nan, "lost"])
def test_what_is_no_number_holds_in_neither_direction(text, value):
    atom = condition(text, KNOWN)
    if value != "lost" or text not in ("vx_mps == 1", "vx_mps != 1"):
        assert atom.margin({"vx_mps": value}) < 0.0
        assert atom.opposite({"vx_mps": value}) < 0.0


numbers = st.floats(allow_nan=False) | st.sampled_from((0.0, 1.0, -1.0, math.inf, -math.inf))


@given(
    st.sampled_from(["vx_mps < vy_mps", "vx_mps <= vy_mps", "vx_mps == vy_mps", "vx_mps < 0 < vy_mps"]),
    numbers,
    numbers,
)
def test_a_condition_or_its_opposite_holds_as_python_has_it(text, one, other):
    atom, sample = condition(text, KNOWN), {"vx_mps": one, "vy_mps": other}
    truth = eval(text, {}, sample)
    assert (atom.margin(sample) >= 0.0) == truth
    assert (atom.opposite(sample) >= 0.0) == (not truth)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("vx < 1", "no signal is called 'vx'; known: vx_mps"),
        ("vx_mps <", "is no condition"),
        ("", "is no condition"),
        ("__import__('os')", "expected a comparison"),
        ("vx_mps.real < 1", "expected a signal"),
        ("(lambda: 1)() < 1", "expected a signal"),
        ("vx_mps ** 99 < 1", "expected a signal"),
        ("hypot(vx_mps) < 1", "hypot takes 2 values"),
        ("vx_mps in link", "expected a list"),
        ("vx_mps is 1", "expected <, <="),
        ("(" * 400 + "1" + ")" * 400 + " < 2", "is no condition"),
        ("1 < 2" + " and 1 < 2" * 200, "at most 1000 characters"),
    ],
)
@pytest.mark.filterwarnings("ignore::SyntaxWarning")
def test_a_wrong_condition_is_one_sentence(text, says):
    with pytest.raises(ValueError, match=r"expected|takes|known") as caught:
        condition(text, KNOWN)
    assert says in str(caught.value)
    assert len(str(caught.value)) < 300


@given(st.text(max_size=40))
def test_no_text_does_anything_but_be_refused_or_read(text):
    try:
        atom = condition(text, KNOWN)
    except ValueError:
        return
    assert isinstance(atom.margin({}), float)


def test_text_never_multiplies():
    assert margin("'a' * 1000000000 == 1") == -math.inf


def test_only_named_signals_are_read():
    assert signals_in("abs(vx_mps) < 1 and link == 'vy_mps'", KNOWN) == {"vx_mps", "link"}


def table(text):
    import tomllib
    from pathlib import Path

    return Table(Path("s.toml"), "expect[0]", tomllib.loads(text))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("always = 'armed'\nwihin_s = 1.0", "s.toml: expect[0].wihin_s: unknown key; did you mean within_s?"),
        (
            "always = 'armed'\neventually = 'armed'",
            "expected one of always, eventually, then; got always and eventually",
        ),
        ("name = 'x'", "got none"),
        ("then = 'armed'", "then needs when"),
        ("eventually = 'armed'\nuntil = 'armed'", "until needs always"),
        ("always = 'armed'\nwithin_s = 1.0", "within_s goes with"),
        ("eventually = 'armed'\nwithin_s = -1.0", "expected 0 to 86400 seconds, got -1"),
        ("always = 'armed'\nfrom_s = 2.0\nto_s = 1.0", "times run forwards"),
        ("always = 'armed'\nvacuous = 'yes'", "expected 'fails' or 'allowed'"),
        ("always = 'armed'\nwhen = 'armed'", "when goes with then"),
        ("always = 'armed'\nfor_s = 1.0", "for_s goes with when and then"),
    ],
)
def test_a_wrong_expectation_is_one_sentence(text, says):
    with pytest.raises(ConfigError) as caught:
        read_expectation(table(text))
    assert says in str(caught.value)


def test_an_expectation_without_a_name_is_called_what_it_says():
    assert read_expectation(table("when = 'armed'\nthen = 'vx_mps < 1'")).name == "then vx_mps < 1, when armed"


# --- on the demo ---------------------------------------------------------------------------------------------------

DEMO = (
    Expectation("never faster than asked", always="speed_mps <= 1.0"),
    Expectation("currents stay in their limit", always="max(command1_a, command2_a, command3_a) <= 0.6", first=2000),
    Expectation("silence stops it", when="link == 'neutral'", then="abs(command1_a) < 0.7", within=10, lasting=50),
    Expectation("loss disarms", when="link == 'lost'", then="not armed", within=10),
    Expectation("loss means no current", whilst="link == 'lost' and rc_age_ms > 520", always="command1_a == 0"),
    Expectation("the core drives in the end", eventually="driver == 'core'"),
    Expectation("odometry is right", always="odo_off_m < 0.03"),
    Expectation("disarmed until armed", always="command1_a == 0 and command2_a == 0", until="armed", within=2000),
    Expectation("the ESCs do what they are told", whilst="t_s > 2", always="abs(feedback2_a - command2_a) < 0.7"),
    Expectation("what the core asks for", eventually="core_vx_mps > 0.249 and core_vx_mps < 0.251"),
    Expectation("too much to ask", always="speed_mps <= 0.2"),
    Expectation("never comes", eventually="driver == 'nobody'"),
    Expectation("nobody asks", when="x_m > 100", then="armed"),
    Expectation("nobody asks, and that is all right", when="x_m > 100", then="armed", may_be_vacuous=True),
)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Verdicts on the demo, judged while it runs; and its recording."""
    directory = tmp_path_factory.mktemp("expect") / "run"
    run = from_scenario(SCENARIO)
    judge = Judge(DEMO, run.bench.robot, run.bench.state_columns)
    with run.recorder(directory) as recorder:
        for out in run:
            judge.add(out)
            recorder.add(out)
    return judge.verdicts(), Recording.open(directory)


def test_the_demo_does_what_it_shall(demo):
    results = {verdict.name: verdict.result for verdict in demo[0]}
    failing = {"too much to ask": FAILED, "never comes": FAILED}
    vacuous = dict.fromkeys(("nobody asks", "nobody asks, and that is all right"), VACUOUS)
    assert results == dict.fromkeys(results, PASSED) | failing | vacuous
    assert [verdict.ok for verdict in demo[0][-2:]] == [False, True]


def test_its_recording_gets_the_same_verdicts(demo):
    verdicts, recording = demo
    judge = Judge(DEMO, load_robot(recording.robot_file), recording.state_columns)
    for out in as_outputs(recording):
        judge.add(out)
    for live, again in zip(verdicts, judge.verdicts(), strict=True):
        # state.csv has six decimals.
        assert (again.name, again.result, again.ok) == (live.name, live.result, live.ok)
        assert again.margin == pytest.approx(live.margin, abs=2e-6)


def test_the_instant_of_least_margin_is_where_the_recording_has_it(demo):
    verdicts, recording = demo
    found = next(verdict for verdict in verdicts if verdict.name == "too much to ask")
    columns = recording.state_columns
    speeds = {
        tick: math.hypot(row[columns.index("vx_mps")], row[columns.index("vy_mps")])
        for tick, row in recording.state.items()
    }
    fastest = max(speeds, key=speeds.get)
    assert found.margin == pytest.approx(0.2 - speeds[fastest], abs=2e-6)
    assert speeds[found.at_tick - found.at_tick % 10] == pytest.approx(speeds[fastest], abs=2e-6)
    assert found.text.startswith(f"too much to ask: failed at {found.at_tick / 1000:.3f} s, by 0.")


def test_every_signal_of_every_motor_kind_can_be_asked_for():
    for name in ("m2006", "dm3519"):
        run = from_scenario(SCENARIO, robot=name)
        run.ticks = 1300
        known = names(run.bench.robot, run.bench.state_columns)
        everything = [
            Expectation(one, eventually=f"{one} >= -9e9 or {one} in ['live', 'rc', 'core', 'none']") for one in known
        ]
        judge = Judge(everything, run.bench.robot, run.bench.state_columns)
        for out in run:
            judge.add(out)
        assert [verdict.name for verdict in judge.verdicts() if not verdict.ok] == []


def test_a_wrong_signal_is_refused_with_the_nearest():
    run = from_scenario(SCENARIO)
    with pytest.raises(ValueError, match="did you mean speed_mps"):
        Judge([Expectation("x", always="sped_mps < 1")], run.bench.robot, run.bench.state_columns)


# --- in a scenario -------------------------------------------------------------------------------------------------


def replayed(tmp_path, capsys, expectations, *options):
    scenario = tmp_path / "short.toml"
    scenario.write_text(f'schema = 1\nname = "short"\nseconds = 0.3\n{expectations}')
    status = main(["replay", str(scenario), *options])
    return status, capsys.readouterr()


def test_a_scenario_that_is_not_met_says_which_and_by_how_much(tmp_path, capsys):
    status, said = replayed(
        tmp_path,
        capsys,
        """
[[expect]]
name = "stands"
always = "speed_mps < 0.25"

[[expect]]
name = "moves"
eventually = "x_m >= 2"
""",
    )
    assert status == 1
    assert "expect    stands: passed, with 0.25 to spare at 0.000 s" in said.out
    assert "EXPECT    moves: failed at 0.000 s, by 2" in said.out


def test_a_scenario_that_is_met_ends_well_and_tells_machines(tmp_path, capsys):
    status, said = replayed(tmp_path, capsys, "[[expect]]\nalways = 'not armed'", "--json")
    assert status == 0
    assert json.loads(said.out)["expectations"] == [
        {"name": "always not armed", "result": "passed", "margin": None, "at_tick": None, "ok": True}
    ]


def test_a_scenario_with_a_wrong_signal_names_file_and_signal(tmp_path, capsys):
    status, said = replayed(tmp_path, capsys, "[[expect]]\nalways = 'sped_mps < 1'")
    assert status == 2
    assert "short.toml: expect: in 'sped_mps < 1': no signal is called 'sped_mps'; did you mean speed_mps?" in said.err
