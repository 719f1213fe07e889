"""Runs that die, as they really die: killed in the middle, on a full disk, under a quota. What was written reads, runs
again and compares up to its last tick, and every one of these says that it is cut."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.__main__ import main
from bench.check.reading import Recording, as_outputs
from bench.scenarios import run

ROOT = Path(__file__).parents[1]
DEADLINE_S = 60.0
LONG = """
schema = 1
name = "long"
seconds = {seconds}

[[stick]]
at_s = 0.1
aux1 = true
[[stick]]
at_s = 0.2
forward = 0.3
turn = 0.5

[[fault]]
wire = "feedback"
kind = "duplicate"
at_s = 0.3
for_s = 0.02

[[expect]]
name = "it turns"
eventually = "omega_radps > 0.3"
[[expect]]
name = "it comes to rest"
always = "speed_mps < 0.01"
from_s = 3.0
"""


def wheelbench(capsys, *arguments):
    capsys.readouterr()
    status = main(list(map(str, arguments)))
    return status, *capsys.readouterr()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The same run, let live until 2.5 s: what the ones that died have to begin with."""
    import tomllib

    folder = tmp_path_factory.mktemp("whole")
    run(record=folder / "run", **{**tomllib.loads(LONG.format(seconds=2.5)), "expect": []})
    return folder / "run"


def holds_what_was_run(cut, whole):
    """Every tick of a cut recording is the tick of the whole one; how many there are."""
    recording = Recording.open(cut)
    assert not recording.complete
    assert "the run was cut short; what it wrote until then is used" in recording.notes
    begun = list(as_outputs(Recording.open(whole)))
    kept = list(as_outputs(recording))[: len(begun)]
    assert kept == begun[: len(kept)]
    return recording.ticks


def can_be_worked_with(capsys, cut, whole, ticks):
    status, out, err = wheelbench(capsys, "replay", cut)
    assert status == 1, "an expectation about what comes later is not met"
    assert f"cut       the recording was cut short at {ticks / 1000:.3f} s; what follows is about that much" in out
    assert f"golden    the same: {ticks / 1000:.3f} s" in out
    assert "note: golden: the run was cut short; what it wrote until then is used" in out
    assert err == ""
    status, out, _ = wheelbench(capsys, "check", cut, whole)
    assert status == 1
    assert "note: run: the run was cut short" in out
    assert "until then they are the same" in out.splitlines()[0]


def test_kill_9_in_the_middle_of_a_run_loses_nothing_that_was_flushed(tmp_path, whole, capsys):
    (tmp_path / "long.toml").write_text(LONG.format(seconds=200.0))
    command = [sys.executable, "-m", "bench", "replay", tmp_path / "long.toml", "--record", tmp_path / "run"]
    log, end = tmp_path / "run" / "can.log", time.monotonic() + DEADLINE_S
    with subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL) as process:
        while not (log.exists() and log.stat().st_size > 120_000):
            assert process.poll() is None, "it ended before it could be killed"
            assert time.monotonic() < end, "it wrote nothing for a minute"
            time.sleep(0.005)
        process.kill()
    assert process.returncode == -9
    ticks = holds_what_was_run(tmp_path / "run", whole)
    assert ticks >= 120_000 // 160, "what was on disk when it died is there: a tick is at most 160 bytes"
    assert (tmp_path / "run" / "faults.log").read_text().count('"feedback duplicate"') == 20
    can_be_worked_with(capsys, tmp_path / "run", whole, ticks)


def recorded_under_a_quota(tmp_path, most_bytes):
    """A run of four seconds that may write no file longer than this, which ends it."""
    (tmp_path / "long.toml").write_text(LONG.format(seconds=4.0))
    script = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({most_bytes}, {most_bytes}));"
        "from bench.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )
    return subprocess.run(
        [sys.executable, "-c", script, "replay", tmp_path / "long.toml", "--record", tmp_path / "run"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_quota_ends_the_run_with_one_sentence_and_keeps_what_there_is(tmp_path, whole, capsys):
    done = recorded_under_a_quota(tmp_path, 90_000)
    assert done.returncode == 3
    assert done.stderr == (
        f"wheelbench replay: {tmp_path / 'run' / 'can.log'}: cannot be written (File too large); "
        "what stands there stays; free some space or record elsewhere\n"
    )
    can_be_worked_with(capsys, tmp_path / "run", whole, holds_what_was_run(tmp_path / "run", whole))


def small_disk(*command):
    """A command, in a namespace of its own in which /mnt is a disk of 128 kB."""
    mount = "mount -t tmpfs -o size=128k tmpfs /mnt && "
    return ["unshare", "-r", "-m", "sh", "-c", mount + " ".join(command)]


def test_a_full_disk_ends_the_run_with_one_sentence_and_keeps_what_there_is(tmp_path, whole, capsys):
    if shutil.which("unshare") is None or subprocess.run(small_disk("true"), capture_output=True).returncode:
        pytest.skip("a small disk of one's own needs unshare and user namespaces, which this machine refuses")
    (tmp_path / "long.toml").write_text(LONG.format(seconds=4.0))
    replay = f"{sys.executable} -m bench replay {tmp_path / 'long.toml'} --record /mnt/run; echo $?"
    # What is left of it is worked with on the full disk itself, and then brought out.
    command = small_disk(f"{replay}; cp -r /mnt/run {tmp_path / 'run'}; {sys.executable} -m bench replay /mnt/run")
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.stderr == (
        "wheelbench replay: /mnt/run/can.log: cannot be written (No space left on device); "
        "what stands there stays; free some space or record elsewhere\n"
    )
    assert done.stdout.splitlines()[0] == "3"
    ticks = holds_what_was_run(tmp_path / "run", whole)
    assert f"golden    the same: {ticks / 1000:.3f} s" in done.stdout
    can_be_worked_with(capsys, tmp_path / "run", whole, ticks)


def test_a_disk_that_is_full_before_the_first_tick_is_one_sentence_too(tmp_path, capsys):
    done = recorded_under_a_quota(tmp_path, 100)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "cannot be written (File too large)" in done.stderr
    status, _, err = wheelbench(capsys, "replay", tmp_path / "run")
    assert status == 2
    assert err.count("\n") == 1
