"""The benchmark's pieces run, its reference loop does the same work, and its bars can be missed. Nothing is timed."""

import random
import re
import sys
from pathlib import Path

import can
import pytest

from bench import rc_decode
from bench.check.run import from_scenario
from bench.demo import SCENARIO

pytest.importorskip("cantools", reason="the reference loop of the benchmark needs cantools (the dev extra)")
sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))

import benchmark
import peers
from reference_loop import LibraryLoop

SHARE = 0.002


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


@pytest.mark.parametrize("name", [name for name in benchmark.PIECES if name != "peers"])  # it needs a network
def test_every_piece_measures_and_reports(name):
    piece = benchmark.PIECES[name]
    samples = [piece.measure(random.Random(0), SHARE)]
    assert all(value >= 0.0 for value in samples[0].values())
    rows = piece.report(samples)
    assert rows
    text = benchmark.table(rows)
    assert all(row.figure in text and row.value in text for row in rows)


def test_the_command_line_loads_nothing_heavy():
    assert benchmark.heavy_imports() == []


@pytest.mark.parametrize(
    ("name", "sample", "verdicts"),
    [
        ("demo", {"CPU": 15.0, "wall": 14.99}, ["ok", "MISSED"]),
        ("demo", {"CPU": 14.0, "wall": 16.0}, ["MISSED", "ok"]),
        ("reference", {"bench": 1.0, "libraries": 3.0}, ["ok", ""]),
        ("reference", {"bench": 1.0, "libraries": 2.9}, ["MISSED", ""]),
        ("help", {"bare": 0.010, "help": 0.059, "heavy": 0.0}, ["ok", "ok"]),
        ("help", {"bare": 0.010, "help": 0.061, "heavy": 1.0}, ["MISSED", "MISSED"]),
        ("plant", {"plant": 9.0, "pymunk": 1.0}, ["", ""]),
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
    monkeypatch.setattr(peers, "environment", lambda folder: without_pip(folder, with_pip=False))
    benchmark._peers_environment.cache_clear()
    assert benchmark.main(["--rounds", "2", "--only", "peers"]) == 0
    benchmark._peers_environment()[0].cleanup()
    benchmark._peers_environment.cache_clear()
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
    piece = benchmark.PIECES["help"]._replace(measure=lambda _order, _share: sample)
    monkeypatch.setitem(benchmark.PIECES, "help", piece)
    assert benchmark.main(["--rounds", "2", "--only", "help"]) == status
    out = capsys.readouterr().out
    assert re.search(rf"imports .* none +{word}$", out, re.MULTILINE)
    assert "load average" in out


def test_no_rounds_are_refused(capsys):
    with pytest.raises(SystemExit):
        benchmark.main(["--rounds", "0"])
    assert "--rounds" in capsys.readouterr().err
