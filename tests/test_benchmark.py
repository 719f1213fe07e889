"""The benchmark's pieces run, its reference loop does the same work, and its bars can be missed. Nothing is timed."""

import random
import re
import subprocess
import sys
import time
import timeit
from pathlib import Path
from statistics import median

import can
import pytest

from bench import rc_decode
from bench.check.sources import from_scenario
from bench.config import robot_names
from bench.demo import SCENARIO

pytest.importorskip("cantools", reason="the reference loop of the benchmark needs cantools (the dev extra)")
sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import benchmark
import compare_logs
import peers
import simulators
from benchmarks import command_line, dashboard, empty_call, robots, throwaway
from benchmarks.table import Row, table
from beside.reference_loop import LibraryLoop

SHARE = 0.002
SCRIPTS = Path(benchmark.__file__).parent


def demo_factors(*values):
    calls = {f"{what} call_ns": 120.0 for what in ("m2006", "dm3519", "libraries")}
    return calls | dict(
        zip(("m2006 CPU", "m2006 wall", "dm3519 CPU", "dm3519 wall", "libraries CPU"), (*values, 2.0), strict=True)
    )


def lockstep(link, factor, reset):
    styles = ("superloop", "interrupts", "rtos", "(our own base)")
    runs = [f"{style} {clock}" for style in styles for clock in ("CPU", "wall", "call_ns")]
    return {"link": link, **dict.fromkeys(runs, factor), "reset": reset}


def frames(log_file):
    """(tick, id, data) of every frame, as python-can reads them."""
    with can.LogReader(log_file) as log:
        return [(round(frame.timestamp * 1000), frame.arbitration_id, bytes(frame.data)) for frame in log]


def test_both_loops_put_the_same_frames_on_the_bus(tmp_path):
    job = from_scenario(SCENARIO)
    job.ticks = 4200  # armed at 1.0 s, forward from 1.5 s, a standstill at 3.5 s, to the right from 3.8 s
    with job.recorder(tmp_path / "bench") as recorder:
        for out in job:
            recorder.add(out)
    with LibraryLoop(job.bench.robot, tmp_path / "libraries.log") as libraries:
        for tick in range(job.ticks):
            libraries.tick(job.inputs(tick).rc)
    ours = frames(tmp_path / "bench" / "can.log")
    assert len(ours) == 4 * 4200
    assert len({data for _, can_id, data in ours if can_id == 0x200}) > 100, "the robot drives"
    assert frames(tmp_path / "libraries.log") == ours


def test_both_readers_find_the_same_differences(tmp_path):
    compare_logs.make(str(tmp_path), 4000)
    golden = str(tmp_path / "golden")
    for run, first in (("few", "differs: "), ("late", "differs: the feedback of all ESCs comes 3 ms late from 0.10")):
        (ours, said), (theirs, _) = (
            read(str(tmp_path / run), golden) for read in (compare_logs.wheelbench, compare_logs.python_can)
        )
        if run == "few":
            assert ours == theirs == compare_logs.FIELDS
            assert said.startswith(first)
        else:
            # Where frames have moved, message beside message finds nearly every later line different.
            assert theirs > ours > 0


@pytest.mark.parametrize(
    "name", sorted(benchmark.PIECES.keys() - {"peers", "simulators", "dashboard"})
)  # these need a network, terminals
def test_every_piece_measures_and_reports(name):
    piece = benchmark.PIECES[name]
    samples = [piece.measure(random.Random(0), SHARE)]
    assert all(value >= 0.0 for value in samples[0].values())
    rows = piece.report(samples)
    assert rows
    text = table(rows)
    assert all(row.figure in text and row.value in text for row in rows)


def test_the_command_line_loads_nothing_heavy():
    assert command_line.heavy_imports() == []


@pytest.mark.parametrize(
    ("name", "sample", "verdicts"),
    [
        ("demo", demo_factors(30.0, 29.99, 22.0, 21.99), ["ok", "MISSED", "ok", "MISSED", "", "ok", "ok"]),
        ("demo", demo_factors(29.0, 31.0, 21.0, 23.0), ["MISSED", "ok", "MISSED", "ok", "", "ok", "ok"]),
        ("demo", demo_factors(7.2, 31.0, 5.4, 23.0), ["MISSED", "ok", "MISSED", "ok", "", "MISSED", "ok"]),
        ("demo", demo_factors(7.3, 31.0, 5.2, 23.0), ["MISSED", "ok", "MISSED", "ok", "", "ok", "MISSED"]),
        ("reference", {"bench": 1.0, "libraries": 4.0}, ["ok", ""]),
        ("reference", {"bench": 1.0, "libraries": 3.9}, ["MISSED", ""]),
        ("lockstep", lockstep(0.4, 15.0, 5.0), [*["ok"] * 7, "", "", "ok"]),
        ("lockstep", lockstep(0.399, 14.9, 5.01), [*["MISSED"] * 7, "", "", "MISSED"]),
        ("help", {"bare": 0.010, "help": 0.059, "heavy": 0.0}, ["ok", "ok"]),
        ("help", {"bare": 0.010, "help": 0.061, "heavy": 1.0}, ["MISSED", "MISSED"]),
    ],
)
def test_bars(name, sample, verdicts):
    assert [row.verdict for row in benchmark.PIECES[name].report([sample])] == verdicts


def of_peers(ours_us, rival_us):
    return {
        f"{protocol} {reader}": us
        for protocol in peers.RANGES
        for reader, us in (
            ("slow", 2.0 * rival_us),
            ("rival", rival_us),
            ("wheelbench, blocks of 64", ours_us),
            ("wheelbench, blocks of 4096", ours_us / 2.0),
        )
    }


@pytest.mark.parametrize(("rival_us", "value", "verdict"), [(13.0, "1.3", "ok"), (12.9, "1.3", "MISSED")])
def test_the_fastest_package_is_beaten_by_the_slower_of_our_two(rival_us, value, verdict):
    rows = benchmark.PIECES["peers"].report([of_peers(10.0, rival_us)] * 3)
    assert [row.figure.rpartition(", ")[2] for row in rows] == [f"{protocol} (rival)" for protocol in peers.RANGES]
    assert {(row.value, row.bar, row.verdict) for row in rows} == {(value, "at least 1.3", verdict)}


def test_packages_that_cannot_be_installed_are_a_line_and_no_failure(monkeypatch, capsys):
    without_pip = peers.environment
    monkeypatch.setattr(peers, "environment", lambda folder, packages: without_pip(folder, packages, False))
    throwaway.environment.cache_clear()
    assert benchmark.main(["--rounds", "2", "--only", "peers"]) == 0
    throwaway.environment(peers.PACKAGES)[0].cleanup()
    throwaway.environment.cache_clear()
    out, err = capsys.readouterr()
    assert "skipped: they cannot be installed here" in out
    assert err.count("the peers cannot be installed here: rfrx") == 1, "tried once, not in every round"


def test_our_readers_beside_the_peers_deliver_every_frame():
    rows = peers.walking("sbus", 50)
    frames = [rc_decode.encode("sbus", row) for row in rows]
    for block in peers.BLOCKS:
        assert peers.delivered(peers.ours("sbus", block), frames, rows, lose=False) == (50, 50, 0)


def test_a_figure_is_the_median_of_the_rounds():
    rounds = [{"bench": 1.0, "libraries": value} for value in (1.0, 4.0, 100.0)]
    assert benchmark.PIECES["reference"].report(rounds)[0].value == "4.0"


@pytest.mark.parametrize(("heavy", "status", "word"), [(0.0, 0, "ok"), (1.0, 1, "MISSED")])
def test_a_missed_bar_is_an_exit_status(monkeypatch, capsys, heavy, status, word):
    sample = {"bare": 1.0, "help": 1.0, "heavy": heavy}
    monkeypatch.setattr(command_line, "measure", lambda _order, _share: sample)
    assert benchmark.main(["--rounds", "2", "--only", "help"]) == status
    out = capsys.readouterr().out
    assert re.search(rf"imports .* none +{word}$", out, re.MULTILINE)
    assert "load average" in out
    assert re.search(r"an empty Python call \d+ ns", out)


def test_an_absolute_number_is_also_told_for_the_reference_machine():
    """Five times slower calls: 1/5 of the speed. Each round by its own call: the median of the ratios."""
    assert empty_call.told_for_reference([10.0, 5.0, 1.0], [120.0, 240.0, 600.0]) == ("50.0", "25.0")
    assert empty_call.told_for_reference([20.0], [96.0], "{:.1f} %", is_cost=True) == ("5.0 %", "10.0 %")


def test_what_is_calculated_is_not_called_measured():
    demo = benchmark.PIECES["demo"].report([demo_factors(10.0, 8.0, 6.0, 4.0)])
    head, first, *others = table(demo).splitlines()
    assert re.split("  +", head) == ["figure", "measured", "if a call took 24 ns", "if a call took 48 ns", "bar"]
    assert re.split("  +", first)[1:] == ["10.0", "50.0", "25.0", "at least 30", "MISSED"]
    assert "calculated, not measured" in " ".join(others)
    assert [row.value for row in demo[4:]] == ["2.0", "5.0", "3.0"], "the libraries, and both robots by them"
    for name, sample in (("lockstep", lockstep(0.4, 15.0, 5.0)), ("dashboard", dashboard_samples()[0])):
        told = [row.told_for_reference for row in benchmark.PIECES[name].report([sample]) if row.told_for_reference[0]]
        assert len(told) == {"lockstep": 8, "dashboard": len(dashboard.VIEWS)}[name]
    assert told[0] == ("2.0 %", "4.0 %")
    assert "if a call" not in table([Row("a ratio", "2.0")])


def test_an_empty_call_takes_as_long_as_timeit_says():
    """A busy machine may move one of them by some times for a moment, a wrong unit or count by thousands for ever."""
    ratios = []
    for _ in range(5):
        timed_s, call_ns = empty_call.beside(
            lambda: timeit.timeit("f()", "def f(): pass", timer=time.thread_time, number=100_000)
        )
        ratios.append(call_ns / (timed_s * 1e4))
    assert median(ratios) == pytest.approx(1.0, abs=0.8)


def test_without_cantools_it_says_how_to_get_it(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "cantools", None)
    assert benchmark.main(["--only", "demo"]) == 3
    assert "pip install -e '.[dev]'" in capsys.readouterr().err


def test_every_piece_is_named_in_the_help(capsys):
    with pytest.raises(SystemExit):
        benchmark.main(["--help"])
    out = capsys.readouterr().out
    for name, piece in benchmark.PIECES.items():
        assert re.search(rf"^  {name} +{re.escape(piece.__doc__.splitlines()[0])}$", out, re.MULTILINE)


def test_no_rounds_are_refused(capsys):
    with pytest.raises(SystemExit):
        benchmark.main(["--rounds", "0"])
    assert "--rounds" in capsys.readouterr().err


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_is_driven_about(name):
    """A robot that stood would be timed for standing."""
    job = robots.driving(name, robots.ARMING_TICKS + 400)
    for _ in job:
        pass
    assert job.bench.base.drive.driver == ("rc" if job.bench.robot.rc else "core")
    assert max(map(abs, job.bench.world.plant.twist)) > 0.1


def test_the_bench_is_timed_beside_the_other_simulators():
    factors = simulators.measure(0.002, 2, ("bench", "plant"))
    assert [len(values) for values in factors.values()] == [2, 2]
    rows = benchmark.PIECES["simulators"].report([{"bench": 10.0, "plant": 40.0, "mujoco": 2.0}] * 3)
    assert [row.value for row in rows] == [
        "10.00",
        "40.00: the bench is 0.25 x as fast",
        "2.00: the bench is 5.00 x as fast",
    ]
    assert benchmark.PIECES["simulators"].report([{}, {}])[0].value.startswith("skipped")


def dashboard_samples(**changed):
    sample = {"first cpu_s": 0.26, "first wall_s": 0.3, "empty cpu_s": 0.21, "empty wall_s": 0.25}
    sample |= {"first live_cpu_s": 0.6, "first live_wall_s": 0.7}
    for view in dashboard.VIEWS:
        for kind, frame_s in (("ours", 0.004), ("stock", 0.03)):
            sample |= {f"{view.name} {kind} {key}_s": frame_s for key in ("frame", "drawing", "frame_p99")}
            sample |= {f"{view.name} {kind} call_ns": 96.0}
    return [sample | changed]


@pytest.mark.parametrize(
    ("changed", "missed"),
    [
        ({}, 0),
        ({"drive 120x40 ours frame_s": 0.0076}, 1),
        ({"wires 120x40 stock drawing_s": 0.0132}, 1),
        ({"scope 120x40 ours frame_p99_s": 0.026}, 1),
        ({"first cpu_s": 0.28}, 1),
        ({"drive 200x60 ours frame_s": 0.0076}, 0),
    ],
)
def test_each_bar_of_the_dashboard_can_be_missed(changed, missed):
    rows = dashboard.report(dashboard_samples(**changed))
    assert [row.verdict for row in rows].count("MISSED") == missed


@pytest.mark.parametrize("kind", ["ours", "driven", "stock", "first"])
def test_apps_measure_themselves_in_a_terminal(kind):
    facts = dashboard._Child(kind, dashboard.VIEWS[0], 3).facts()
    assert facts
    assert all(value > 0.0 for value in facts.values())


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks for a process in /proc, which is Linux's")
def test_an_app_does_not_outlive_a_benchmark_that_was_killed():
    code = f"""
import os, sys, time
sys.path.insert(0, {str(SCRIPTS)!r})
from benchmarks import dashboard
child = dashboard._Child("stock", dashboard.VIEWS[0], 100000)
while b"\\x1b[" not in child._app.said:  # it draws
    time.sleep(0.05)
print(child._app._process.pid, flush=True)
os.kill(os.getpid(), 9)
"""
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    end = time.monotonic() + 60.0
    while is_running(int(done.stdout)):
        assert time.monotonic() < end
        time.sleep(0.05)


def is_running(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False
