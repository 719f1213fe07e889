"""Several scenarios: side by side, a line for each, JUnit XML, and a page that needs nothing else."""

import json
import re
from xml.etree import ElementTree as Xml

import pytest

from bench.__main__ import main
from bench.check.reading import Recording

GOOD = """
schema = 1
name = "stands <well>"
seconds = 0.3
[[expect]]
name = "stands"
always = "speed_mps < 0.25"
"""
BAD = """
schema = 1
name = "cannot"
about = "Nobody drives it"
seconds = 0.3
[[expect]]
name = "moves & how"
eventually = "x_m >= 2"
[[fault]]
name = "late"
wire = "rc"
kind = "drop"
at_s = 9.0
"""


@pytest.fixture
def files(tmp_path):
    texts = {"good": GOOD, "bad": BAD, "wrong": "schema = 1\nname = 'w'\nsecnds = 1.0"}
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    return [str(tmp_path / f"{name}.toml") for name in texts]


def test_each_scenario_has_its_line_and_a_wrong_one_stops_no_other(files, capsys):
    assert main(["replay", *files, "--jobs", "2"]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "ok      stands <well>"
    assert said[1] == "FAILED  cannot"
    assert said[2] == "        moves & how: failed at 0.000 s, by 2"
    assert said[3] == "        late: this fault touched nothing"
    assert said[4] == "FAILED  wrong"
    assert "wrong.toml: seconds: is missing; is secnds meant to be it?" in said[5]
    assert said[6] == "1 of 3 scenarios as expected"


def test_the_order_and_the_results_do_not_depend_on_the_processes(files, capsys):
    main(["replay", *files, "--json", "--jobs", "1"])
    alone = capsys.readouterr().out
    main(["replay", *files, "--json", "--jobs", "3"])
    assert capsys.readouterr().out == alone
    facts = [json.loads(line) for line in alone.splitlines()]
    assert [fact["ok"] for fact in facts] == [True, False, False]
    assert facts[1]["expectations"][0]["margin"] == -2.0


def test_junit_has_a_case_for_each_expectation_fault_and_check(files, tmp_path):
    report = tmp_path / "junit.xml"
    main(["replay", *files, "--jobs", "1", "--junit", str(report)])
    suites = Xml.parse(report).getroot()
    assert [(s.get("name"), s.get("tests"), s.get("failures")) for s in suites] == [
        ("stands <well>", "5", "0"),
        ("cannot", "6", "2"),
        ("wrong", "1", "1"),
    ]
    assert suites.find(".//failure").get("message") == "moves & how: failed at 0.000 s, by 2"


def test_the_page_needs_nothing_else_and_shows_what_was_violated(files, tmp_path):
    page = tmp_path / "page.html"
    main(["replay", *files, "--jobs", "1", "--html", str(page)])
    text = page.read_text()
    assert not re.search(r"https?://|<script|<link |@import|url\(", text)
    assert "stands &lt;well&gt;" in text
    assert "2 of 3 scenarios failed" in text
    assert text.count("<svg") == 6, "two runs: the way, the speeds, the currents"
    assert ">moves &amp; how</text>" in text
    for picture in re.findall(r"<svg.*?</svg>", text, re.DOTALL):
        Xml.fromstring(picture)


def test_recordings_are_kept_by_name(files, tmp_path):
    main(["replay", *files[:2], "--jobs", "1", "--record", str(tmp_path / "runs")])
    assert Recording.open(tmp_path / "runs" / "good").ticks == 300
    assert Recording.open(tmp_path / "runs" / "bad").complete


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--robot", "m2006"], "--robot: goes with one source"),
        (["--period-ms", "5"], "--period-ms: goes with one source"),
        (["bench/demo/drive.bin"], "drive.bin: is no scenario"),
        (["--jobs", "0"], "--jobs: expected 1 or more"),
        (["--html", "/nowhere/page.html", "--jobs", "1"], "/nowhere/page.html: cannot be written"),
    ],
)
def test_a_wrong_argument_is_one_sentence(files, capsys, options, says):
    assert main(["replay", files[0], files[1], *options]) in (2, 3)
    assert says in capsys.readouterr().err
