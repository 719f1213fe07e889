"""Several scenarios: side by side, a line for each, JUnit XML, and a page that needs nothing else."""

import contextlib
import json
import multiprocessing
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from bench.__main__ import main
from bench.check.reading import Recording
from bench.check.suite import run_scenarios
from bench.cli.progress import progress_line

ROOT = Path(__file__).parents[1]
DEADLINE_S = 60.0

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


def test_junit_of_an_error_with_terminal_colours_is_xml(tmp_path, capsys):
    scenario, report = tmp_path / "red.toml", tmp_path / "junit.xml"
    (tmp_path / "red.py").write_text("def base(robot):\n    raise ValueError('\\x1b[31mno\\x1b[0m')\n")
    scenario.write_text('name = "red"\nseconds = 0.1\ncontroller = "red.py:base"\n')
    assert main(["replay", str(scenario), "--junit", str(report)]) == 1
    assert "\ufffd[31mno\ufffd[0m" in Xml.parse(report).getroot().find(".//failure").get("message")


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
        (["--arm"], "--arm: lets real motors move, and in the role sim the bench drives none; leave it out"),
        (["--html", "/nowhere/page.html", "--jobs", "1"], "/nowhere/page.html: cannot be written"),
    ],
)
def test_a_wrong_argument_is_one_sentence(files, capsys, options, says):
    assert main(["replay", files[0], files[1], *options]) in (2, 3)
    out, err = capsys.readouterr()
    assert says in err
    assert out == "", "before anything runs"


def test_what_was_not_meant_is_one_sentence_before_anything_runs(files, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "good.toml").write_text(GOOD)
    (tmp_path / "empty").mkdir()
    for given, says in (
        (["none/*.toml"], "none/*.toml: no scenario fits this pattern"),
        (["good.toml", "bad.toml", "sub/../good.toml"], "sub/../good.toml: is given twice, as good.toml too"),
        (["good.toml", "good.toml"], "good.toml: is given twice\n"),
        (
            ["good.toml", "sub/good.toml", "--record", "runs"],
            "--record: good.toml and sub/good.toml would both be recorded in runs/good; rename one of them",
        ),
        (["sub"], "sub: is a directory without a recording; the scenarios in it are replayed by sub/*.toml"),
        (["empty"], "empty: is a directory without a recording; give a scenario (.toml), an RC capture"),
    ):
        assert main(["replay", *given, "--jobs", "1"]) == 2, given
        out = capsys.readouterr()
        assert says in out.err, given
        assert out.out == ""
    assert not (tmp_path / "runs").exists()


def test_a_pattern_that_the_shell_left_alone_is_all_that_fits_and_one_name_for_two_is_noted(files, tmp_path, capsys):
    (tmp_path / "goose.toml").write_text(GOOD)
    assert main(["replay", str(tmp_path / "goo*.toml"), "--jobs", "1"]) == 0
    said = capsys.readouterr().out
    assert "2 of 2 scenarios as expected" in said
    assert "note: 2 scenarios are called 'stands <well>': " in said


def test_the_line_of_progress_says_how_many_how_far_and_how_long():
    names, shares = ["ice", "push", "walls", "wind"], [1.0, 0.5, 0.1, 0.0]
    line = progress_line(names, shares, 1, 20.0, 79)
    assert line == "[#########...............] 1 of 4 done, 1 failed; about 30 s left; push 50 %, walls 10 %"[:79]
    assert progress_line(names, shares, 0, 20.0, 30) == line[:30]
    assert progress_line(names, [0.0] * 4, 0, 1.0, 79) == f"[{'.' * 24}] 0 of 4 done"


LONG = GOOD.replace("seconds = 0.3", "seconds = 600.0")


def test_a_run_whose_process_is_killed_is_a_failure_and_the_others_go_on(tmp_path):
    texts = {"long": LONG, "good": GOOD, "also": GOOD, "last": GOOD}
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    killed = []

    def watch(shares):
        workers = multiprocessing.active_children()  # who has nothing left to do has gone, once its answer is taken
        if not killed and shares[0] > 0.0 and all(share == 1.0 for share in shares[1:]) and len(workers) == 1:
            os.kill(workers[0].pid, signal.SIGKILL)
            killed.append(workers[0].pid)
        return False

    results = list(run_scenarios([tmp_path / f"{name}.toml" for name in texts], jobs=2, watch=watch))
    assert killed
    assert [(result.name, result.ok) for result in results] == [("long", False)] + [("stands <well>", True)] * 3
    assert results[0].reasons == [
        "its process ended by signal 9 (Killed) before the run was over; run it again, alone where memory is short"
    ]
    assert not multiprocessing.active_children()


DIES = """
import os, signal
from bench.base import Base

class Dies(Base):
    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        os.kill(os.getpid(), signal.SIGKILL)
"""


def test_who_kills_its_own_process_is_told_by_the_verb_and_another_takes_its_place(tmp_path, capsys):
    (tmp_path / "dies.py").write_text(DIES)
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(GOOD.replace("seconds", 'controller = "dies.py:Dies"\nseconds', 1))
    (tmp_path / "good.toml").write_text(GOOD)
    files = [str(tmp_path / f"{name}.toml") for name in ("a", "b", "good")]
    assert main(["replay", *files, "--jobs", "2"]) == 1
    said = capsys.readouterr().out
    assert said.count("its process ended by signal 9 (Killed)") == 2
    assert "ok      stands <well>\n1 of 3 scenarios as expected" in said


def wait_for(what, process):
    end = time.monotonic() + DEADLINE_S
    while not what():
        assert process.poll() is None, "it ended before that"
        assert time.monotonic() < end, "not within a minute"
        time.sleep(0.02)


def test_ctrl_c_ends_all_with_whole_recordings_and_says_what_ran(tmp_path):
    for name, text in (("a", GOOD), ("b", LONG), ("c", LONG), ("d", LONG)):
        (tmp_path / f"{name}.toml").write_text(text)
    files = [f"{name}.toml" for name in "abcd"]
    screen, stderr = pty.openpty()
    os.set_blocking(screen, False)
    process = subprocess.Popen(
        [sys.executable, "-m", "bench", "replay", *files, "--record", "runs", "--junit", "junit.xml"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        start_new_session=True,
    )
    seen = bytearray()

    def both_run():
        with contextlib.suppress(BlockingIOError):
            seen.extend(os.read(screen, 65536))
        logs = [tmp_path / "runs" / name / "can.log" for name in "bc"]
        return all(log.exists() and log.stat().st_size > 20_000 for log in logs)

    with process:
        os.close(stderr)
        wait_for(both_run, process)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
        out, _ = process.communicate(timeout=DEADLINE_S)
    try:
        while more := os.read(screen, 65536):
            seen.extend(more)
    except OSError:  # the other end has closed
        pass
    os.close(screen)
    assert process.returncode == 130, out
    assert out.splitlines()[0] == "ok      stands <well>"
    assert "interrupted: 1 ran to the end, 2 until then, 1 not at all" in out
    assert len(re.findall(r"^        interrupted at \d+\.\d{3} s$", out, re.MULTILINE)) == 2
    for name in "bc":
        assert Recording.open(tmp_path / "runs" / name).complete
    assert not (tmp_path / "runs" / "d").exists()
    assert len(list(Xml.parse(tmp_path / "junit.xml").getroot())) == 4
    text = seen.decode()
    assert re.search(r"\[#*\.*\] [01] of 4 done", text)
    assert "Traceback" not in text
    assert text.rstrip().endswith("wheelbench replay: interrupted")
