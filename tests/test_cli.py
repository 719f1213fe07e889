"""The command line as a person meets it: words, exit statuses, and one sentence where something is wrong."""

import gc
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import can
import pytest

from bench.__main__ import VERBS, main
from bench.check.reading import Recording

ROOT = Path(__file__).parents[1]
DEMO = ROOT / "bench" / "demo" / "demo.toml"
DRIVE = ROOT / "bench" / "demo" / "drive.bin"


def short_scenario(tmp_path, text="", seconds=0.3):
    path = tmp_path / "short.toml"
    path.write_text(f'schema = 1\nname = "short"\nseconds = {seconds}\n{text}')
    return path


def test_help_names_every_verb(call):
    status, out, _ = call("--help")
    assert status == 0
    assert all(f"    {verb} " in out for verb in VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help(call, verb):
    status, out, _ = call(verb, "--help")
    assert status == 0
    assert out.startswith(f"usage: wheelbench {verb}")


def test_help_imports_nothing_heavy():
    code = "import sys, bench.__main__ as m\ntry: m.main(['--help'])\nexcept SystemExit: pass\n"
    heavy = ("textual", "can", "pymunk", "serial", "numpy", "pytest", "dataclasses")
    code += f"print([n for n in {heavy} if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_no_verb_is_a_usage_error(call):
    assert call()[0] == 2
    assert call("drvie")[0] == 2


def test_an_unknown_option_is_told_with_the_verbs_own_usage(call):
    status, _, err = call("kin", "m2006", "--twits", "1,0,0")
    assert (status, err.splitlines()[-1]) == (2, "wheelbench kin: error: unrecognized arguments: --twits 1,0,0")


def test_robots(call):
    status, out, _ = call("robots", "--json")
    assert status == 0
    robots = [json.loads(line) for line in out.splitlines()]
    assert [(robot["name"], robot["wheels"], robot["motor"], robot["rc"]) for robot in robots] == [
        ("deadwheel3", 3, "c610", "frsky-sbus"),
        ("dm3519", 4, "dm3519", "uart12"),
        ("m2006", 3, "c610", "uart12"),
        ("mecanum", 4, "c610", "dr16"),
        ("omni3", 3, "c610", "flysky"),
        ("omni4", 4, "c610", "elrs"),
        ("siegwart", 3, "c610", "frsky-sbus"),
        ("slamware-a", 3, "c610", "frsky-sbus"),
        ("slamware-b", 3, "c610", None),
    ]
    assert "m2006" in call("robots")[1]


def test_kin_both_ways(call):
    facts = json.loads(call("kin", "m2006", "--twist", "1,0,0", "--json")[1])
    assert facts["wheels_radps"] == pytest.approx([35.77503, 0, -35.77503], abs=1e-5)
    assert json.loads(call("kin", "m2006", "--twist", "-.5,0,0", "--json")[1])["twist"] == [-0.5, 0.0, 0.0]
    facts = json.loads(call("kin", "m2006", "--wheels", "-2.25926,-2.25926,-2.25926", "--json")[1])
    assert facts["twist"] == pytest.approx([0, 0, -1], abs=1e-5)
    assert facts["slip"] == pytest.approx([0, 0, 0], abs=1e-9)
    assert "1.7511" in call("kin", "m2006")[1]


@pytest.mark.parametrize("value", ["1,2", "a,b,c", "nan,0,0", ""])
def test_kin_refuses_what_is_no_twist(call, value):
    status, _, err = call("kin", "m2006", f"--twist={value}")
    assert (status, "--twist: expected 3 numbers" in err) == (2, True)


@pytest.mark.parametrize(
    ("option", "value"), [("--twist", "1e308,0,0"), ("--twist", "0,0,-inf"), ("--wheels", "0,1e308,1")]
)
def test_kin_refuses_what_it_could_not_reckon_with(call, option, value):
    """1e308 m/s is a number, and its wheels' speed is none."""
    status, out, err = call("kin", "m2006", f"{option}={value}", "--json")
    assert (status, out) == (2, "")
    assert f"{option}: expected numbers from -1000000 to 1000000, got {value!r}" in err
    assert call("kin", "m2006", "--twist", "1e6,-1e6,1e6")[0] == 0


def test_decode_a_capture(call):
    status, out, _ = call("decode", "uart12", DRIVE, "--json")
    events = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert len(events) == 2580
    assert events[0]["event"] == "frame"
    assert (events[0]["protocol"], events[0]["offset"], events[0]["length"]) == ("uart12", 0, 12)
    assert events[0]["flags"] == {"failsafe": False, "frame_lost": False}
    assert len(events[0]["channels"]) == 6
    assert call("decode", "uart12", DRIVE, "--json", "--chunk", "7", "--no-times")[1] == out


@pytest.mark.parametrize(("flags", "ch17", "ch18"), [(0x00, False, False), (0x01, True, False), (0x02, False, True)])
def test_decode_says_the_digital_channels_of_sbus(call, tmp_path, flags, ch17, ch18):
    """Flag bit 0 is what its makers call channel 17, bit 1 channel 18."""
    stream = tmp_path / "one.bin"
    stream.write_bytes(b"\x0f" + bytes(22) + bytes((flags, 0x00)))
    status, out, _ = call("decode", "sbus", stream, "--json")
    assert status == 0
    assert json.loads(out)["flags"] == {"failsafe": False, "frame_lost": False, "ch17": ch17, "ch18": ch18}


def test_decode_people_can_read(call, tmp_path):
    stream = tmp_path / "junk.bin"
    stream.write_bytes(b"\x01\x02\x03" + bytes.fromhex("AA08000800040C0C00010055"))
    status, out, _ = call("decode", "uart12", stream)
    assert status == 0
    assert out.splitlines() == [
        "       0 +3    noise     header",
        "       3 +12   channels  2048 2048 1036 3072    1    0",
    ]


def test_decode_a_can_log(call, tmp_path):
    log = tmp_path / "can.log"
    log.write_text("(0.001000) can0 200#02580258FDA80000\n(0.001000) can0 202#10E1300C03520000\n")
    status, out, _ = call("decode", "c610", log, "--json")
    first, second = (json.loads(line) for line in out.splitlines())
    assert status == 0
    assert (first["can_id"], first["decoded"]["current_3_ma"]) == (0x200, -600)
    assert second["decoded"] == {"angle_counts": 4321, "speed_rpm": 12300, "current_ma": 850}


# python-can's readers leave the file open that they refuse.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")
@pytest.mark.parametrize("ending", ["blf", "log.gz", "db", "asc"])
def test_decode_a_damaged_can_log_of_any_kind(call, tmp_path, ending):
    log = tmp_path / f"cut.{ending}"
    with can.Logger(log) as writer:
        for number in range(200):
            writer(can.Message(timestamp=number / 1000, arbitration_id=0x201, data=bytes(8), is_extended_id=False))
    whole = log.read_bytes()
    assert call("decode", "c610", log)[0] == 0
    log.write_bytes(whole[: len(whole) // 2])  # as a logger leaves it that was killed
    status, out, err = call("decode", "c610", log)
    assert status in (0, 2), "python-can reads some of them up to the cut"
    assert out or "is no CAN log that can be read (" in err
    log.write_bytes(b"\x00\xff" * 100)
    assert call("decode", "c610", log)[0] in (1, 2)
    gc.collect()  # here, where the warning is known


def test_decode_slamware(call, tmp_path):
    stream = tmp_path / "core.bin"
    stream.write_bytes(bytes.fromhex("1002F830DA") + bytes.fromhex("1003F81001FA"))
    status, out, _ = call("decode", "slamware", stream, "--json")
    second = json.loads(out.splitlines()[1])
    assert status == 0
    assert (second["offset"], second["length"], second["type"], second["code"]) == (5, 6, "standard", 248)
    assert second["payload"] == "1001"


@pytest.mark.parametrize(
    ("content", "status"),
    [(b"", 2), (b"\x00" * 500, 1), (bytes.fromhex("C81816E0031FF8C0073EF0810F7CE0031FF8C0073EF0810F7CAD") * 20, 1)],
    ids=["empty", "zeros", "another protocol"],
)
def test_decode_of_what_holds_no_frame(call, tmp_path, content, status):
    stream = tmp_path / "stream.bin"
    stream.write_bytes(content)
    got, _, err = call("decode", "uart12", stream)
    assert got == status
    assert "stream.bin" in err


def test_decode_a_cut_frame_is_noise(call, tmp_path):
    stream = tmp_path / "cut.bin"
    stream.write_bytes(DRIVE.read_bytes()[:31])
    out = call("decode", "uart12", stream, "--json")[1].splitlines()
    assert [json.loads(line)["event"] for line in out] == ["frame", "frame", "noise"]


@pytest.mark.parametrize(
    "arguments",
    [
        ("decode", "c610", DRIVE),
        ("decode", "c610", ROOT),
        ("decode", "sbuss", DRIVE),
        ("decode", "uart12", DRIVE, "--robot", "m2006"),
    ],
)
def test_decode_of_a_wrong_file_or_protocol(call, arguments):
    status, _, err = call(*arguments)
    assert status == 2
    assert len(err.splitlines()) == 1


def test_replay_in_its_three_forms(call, tmp_path):
    first, again, with_can = tmp_path / "first", tmp_path / "again", tmp_path / "with_can"
    scenario = short_scenario(tmp_path, f'rc = "{DRIVE}"\n[[core]]\nat_s = 0.05\nvx_mps = 0.1\n', seconds=2.5)
    assert call("replay", scenario, "--record", first)[0] == 0
    status, out, _ = call("replay", first, "--record", again)
    assert status == 0
    assert "identical" in out
    status, out, _ = call("replay", first, "--can", "recorded", "--record", with_can)
    assert status == 0
    assert "identical" in out
    names = sorted(path.name for path in first.iterdir())
    assert names == ["can.log", "profile.toml", "rc.log", "robot.toml", "run.toml", "slamware.log", "state.csv"]
    for name in names:
        assert (first / name).read_bytes() == (again / name).read_bytes() == (with_can / name).read_bytes()


def test_replay_says_who_is_on_the_bus_that_should_not_be(call, tmp_path):
    scenario, run = short_scenario(tmp_path, f'rc = "{DRIVE}"\n', seconds=0.1), tmp_path / "run"
    _, out, _ = call("replay", scenario, "--record", run)
    assert "bus       " not in out
    log = run / "can.log"
    lines = [
        line + (f"\n{line[:10]} can0 205#0000000000000000" if " 203#" in line else "")
        for line in log.read_text().splitlines()
    ]
    log.write_text("\n".join(lines) + "\n")
    status, out, _ = call("replay", run, "--can", "recorded")
    assert status == 1
    assert "CHECK     bus: 0x205 unknown ESC" in out
    # Born in tick 0, a frame reaches the base in tick 1; that of the last tick reaches nobody.
    assert "bus       1 finding; the newest: 0x205 unknown ESC, 99 times since 0.001 s: an ESC with ID 5" in out
    (finding,) = json.loads(call("replay", run, "--can", "recorded", "--json")[1])["bus_findings"]
    assert finding.startswith("0x205 unknown ESC, 99 times")


def test_replay_over_real_ports_gives_the_same_recording(call, tmp_path):
    scenario = short_scenario(tmp_path, f'rc = "{DRIVE}"\n', seconds=2.0)
    assert call("replay", scenario, "--record", tmp_path / "plain")[0] == 0
    ports = ("--rc", "pty:", "--slamware", "pty:", "--can", "can:virtual:wheelbench-test")
    status, out, err = call("replay", scenario, *ports, "--golden", tmp_path / "plain")
    assert (status, "identical" in out) == (0, True), err


@pytest.mark.parametrize(
    "arguments",
    [
        ("--rc", "tty:"),
        ("--can", "can:socketcan"),
        ("--can", "recorded"),
        ("--period-ms", "0"),
        ("--jobs", "0"),
        ("--arm",),
        ("--role", "base", "--can", "can:virtual:x", "--arm"),
        ("--protocol", "sbsu"),
        ("--golden", "nowhere"),
        ("--robot", "m2007"),
        ("--profile", "crossfires"),
    ],
)
def test_replay_refuses_arguments_in_one_sentence(call, arguments):
    status, _, err = call("replay", DRIVE, *arguments)
    assert status == 2
    assert len(err.splitlines()) == 1


def test_drive_refuses_what_would_arm_nothing(call):
    for more in ((), ("--role", "base", "--can", "can:virtual:x"), ("--replay", "somewhere")):
        status, out, err = call("drive", "--arm", *more)
        assert (status, out) == (2, "")
        assert "--arm: lets real motors move" in err


def test_a_capture_without_a_frame_is_told_what_to_try(call, tmp_path):
    stream = tmp_path / "notes.txt"
    stream.write_text("a text\n")
    _, out, _ = call("replay", stream)
    lines = out.splitlines()
    at = lines.index("rc        0 frames, 7 bytes of noise")
    assert lines[at + 1] == "          not one frame: wheelbench decode auto FILE says what such bytes may be"
    assert "not one frame" not in call("replay", DRIVE)[1]


def test_a_capture_of_another_protocol_names_the_profile_to_take(call, tmp_path):
    stream = tmp_path / "stick.bin"
    stream.write_bytes(b"\x0f" * 50)
    status, _, err = call("replay", stream, "--protocol", "crsf")
    assert (status, "crossfire, elrs would fit" in err) == (2, True)


def test_check_names_the_first_difference(call, tmp_path):
    scenario = short_scenario(tmp_path, f'rc = "{DRIVE}"\n', seconds=2.0)
    for name in ("run", "golden"):
        assert call("replay", scenario, "--record", tmp_path / name)[0] == 0
    log = tmp_path / "run" / "can.log"
    lines = log.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("(1.700000) can0 200#"))
    data = bytearray.fromhex(lines[at].split("#")[1])
    expected = int.from_bytes(data[2:4], "big", signed=True)
    data[3] ^= 0x05
    got = int.from_bytes(data[2:4], "big", signed=True)
    lines[at] = f"(1.700000) can0 200#{data.hex().upper()}"
    log.write_text("\n".join(lines) + "\n")
    status, out, _ = call("check", tmp_path / "run", tmp_path / "golden")
    assert status == 1
    assert f"(tick 1700) can 0x200: current 2 expected {expected} mA, got {got} mA" in out.splitlines()[0]
    facts = json.loads(call("check", tmp_path / "run", tmp_path / "golden", "--json")[1])
    assert facts["first"] == {
        "tick": 1700,
        "wire": "can 0x200",
        "field": facts["first"]["field"],
        "expected": expected,
        "got": got,
    }
    assert call("check", tmp_path / "golden", tmp_path / "golden")[0] == 0


@pytest.mark.parametrize("place", [ROOT, ROOT / "README.md", ROOT / "nowhere"])
def test_check_of_what_is_no_recording(call, place):
    status, _, err = call("check", place, place)
    assert status == 2
    assert len(err.splitlines()) == 1


def test_recording_into_an_impossible_place(call, tmp_path):
    scenario = short_scenario(tmp_path)
    status, _, err = call("replay", scenario, "--record", "/proc/wheelbench")
    assert status == 3
    assert len(err.splitlines()) == 1
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep")
    assert call("replay", scenario, "--record", tmp_path / "full")[0] == 2
    assert (tmp_path / "full" / "mine.txt").read_text() == "keep"


def test_the_demo_meets_its_golden_without_a_terminal(tmp_path):
    command = [sys.executable, "-m", "bench", "demo", "--record", str(tmp_path / "demo")]
    done = subprocess.run(command, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    for word in ("drove", "odometry", "slamware", "can ", "link", "times real time", "golden"):
        assert word in done.stdout
    with can.LogReader(tmp_path / "demo" / "can.log") as messages:
        ids = {message.arbitration_id for message in messages}
    assert ids == {0x200, 0x201, 0x202, 0x203}


def test_the_demos_facts_as_json(call):
    facts = json.loads(call("demo", "--json")[1])
    assert facts["golden"]["ok"]
    assert facts["frames"]["can_feedback"] == 3 * facts["frames"]["can_commands"] == 81_000
    assert 0.0 < facts["odometry_off_m"] < 0.03  # hard braking slips


def test_a_golden_is_not_pinned_in_ci(call, monkeypatch):
    monkeypatch.setenv("CI", "true")
    status, _, err = call("demo", "--update-pinned")
    assert status != 0
    assert "CI" in err


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_keeps_what_has_been_recorded(tmp_path, stop):
    long = short_scenario(tmp_path, seconds=600.0)
    command = [sys.executable, "-m", "bench", "replay", long, "--record", tmp_path / "cut"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    log = tmp_path / "cut" / "can.log"
    deadline = time.monotonic() + 60
    while not (log.exists() and log.stat().st_size > 0):
        assert time.monotonic() < deadline, "it records nothing"
        time.sleep(0.01)
    process.send_signal(stop)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err.strip() == "wheelbench replay: interrupted"
    status = main(["replay", str(tmp_path / "cut")])
    assert status == 0, "the cut recording replays, byte for byte"


def in_a_shell(command, **streams):
    """Its exit status and what it says on stderr; stdout is buffered, as where nobody asks for anything else."""
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    whole = f"{sys.executable} -m bench {command}"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", whole], cwd=ROOT, stderr=subprocess.PIPE, text=True, env=buffered, **streams
    )
    return done.returncode, done.stderr


def test_a_reader_that_leaves_is_no_error():
    assert in_a_shell(f"decode uart12 {DRIVE} --json | head -1", stdout=subprocess.DEVNULL) == (3, "")


def test_a_reader_that_leaves_takes_no_report_with_him(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(short_scenario(tmp_path, "", seconds=0.1).read_text())
    report, page = tmp_path / "junit.xml", tmp_path / "page.html"
    assert in_a_shell(f"replay {tmp_path}/a.toml {tmp_path}/b.toml --junit {report} | true") == (3, "")
    assert report.read_text().count("<testsuite ") == 2
    assert in_a_shell(f"failsafe --only restart --jobs 1 --html {page} | true") == (3, "")
    assert page.read_text().count('class="ok"') == 5


@pytest.mark.parametrize("command", ["kin m2006", "kin --help"])
def test_a_reader_that_has_left_before_the_last_line_is_no_error(command):
    read_end, write_end = os.pipe()
    os.close(read_end)
    try:
        assert in_a_shell(command, stdout=write_end) == (3, "")
    finally:
        os.close(write_end)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("command", ["kin m2006", f"decode uart12 {DRIVE}"])
def test_a_full_disk_is_one_sentence(command):
    verb = command.split()[0]
    says = f"wheelbench {verb}: output cannot be written (No space left on device); free some space\n"
    assert in_a_shell(f"{command} > /dev/full") == (3, says)


@pytest.mark.parametrize("verb", ["kin", "replay", "check", "goldens", "decode auto", "decode c610"])
def test_a_path_that_cannot_even_be_looked_at_is_one_sentence(call, verb):
    path = 300 * "a"  # longer than any file system takes; a folder that may not be entered comes the same way
    status, _, err = call(*verb.split(), path)
    assert (status, err) == (
        2,
        f"wheelbench {verb.split()[0]}: {path}: cannot be reached (File name too long); check the path\n",
    )


def test_a_name_that_is_no_text_is_spelt_out(call, tmp_path):
    """As the file system hands over one in Latin-1, which has no place in UTF-8."""
    scenario = short_scenario(tmp_path, "", seconds=0.1)
    record = tmp_path / os.fsdecode(b"caf\xe9")
    status, out, err = call("replay", scenario, "--record", record)
    assert (status, err) == (0, "")
    assert f"recorded  {tmp_path}/caf\\udce9\n" in out
    assert (record / "can.log").exists()


def test_a_base_and_a_page_in_a_place_whose_name_is_no_text(call, tmp_path):
    odd = os.fsdecode(b"caf\xe9")
    folder = tmp_path / odd
    folder.mkdir()
    scenario = short_scenario(folder, "", seconds=0.1)
    (folder / f"{odd}.py").write_text("from bench.base import Base\nclass Mine(Base): pass\n")
    status, _, err = call("replay", scenario, "--controller", folder / f"{odd}.py:Mine", "--record", tmp_path / "run")
    assert (status, err) == (0, "")
    assert Recording.open(tmp_path / "run").info.controller == "caf\\udce9.py:Mine"
    status, _, err = call("replay", scenario, "--html", tmp_path / "page.html", "--junit", tmp_path / "junit.xml")
    assert (status, err) == (0, "")
    assert "caf\\udce9" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_scenario_is_not_written_over_by_its_page(call, tmp_path):
    """`--html *.toml` takes the first of them for the page's name."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(short_scenario(tmp_path, "", seconds=0.1).read_text())
    before = (tmp_path / "a.toml").read_bytes()
    status, out, err = call("replay", "--html", tmp_path / "a.toml", tmp_path / "b.toml")
    assert (status, out) == (2, "")
    assert "a.toml: would be written over" in err
    assert (tmp_path / "a.toml").read_bytes() == before


@pytest.mark.parametrize("name", ["\x1b[31mred", "bell\a", os.fsdecode(b"caf\xe9"), "back\b"])
def test_what_the_user_gives_is_no_command_to_their_terminal(call, name):
    for verb in (("replay", name), ("kin", name), ("decode", "sbus", name), ("emulate", "core", name)):
        status, out, err = call(*verb)
        assert (status, out) == (2, "")
        assert repr(name)[1:-1] in err
        assert err.removesuffix("\n").isprintable()
    for verb in (("kin", "m2006", name), ("emulate", "core", "pty:", f"--{name}")):  # argparse's own sentences
        status, out, err = call(*verb)
        assert (status, out) == (2, "")
        assert repr(name)[1:-1] in err
        assert all(map(str.isprintable, err.splitlines()))


def test_a_name_in_what_went_well_is_no_command_to_their_terminal(call, tmp_path, monkeypatch):
    """Not in a line of its own either: `recorded  ...` is the last of what a script reads."""
    monkeypatch.delenv("CI", raising=False)  # nothing is pinned there
    name = "two\nlines\x1b[31m\a"
    odd, spelling = tmp_path / name, "two\\nlines\\x1b[31m\\x07"
    odd.mkdir()
    scenario, run = short_scenario(odd, "", seconds=0.1), odd / "run"
    twin = odd / f"{name}.toml"
    twin.write_bytes(scenario.read_bytes())
    (odd / "capture.log").write_text("")
    for arguments in (
        ("replay", scenario, "--record", run),
        ("replay", scenario, twin),
        ("goldens", odd),
        ("check", run, run, "--update-pinned"),
        ("parity", scenario, "--world", "sim", "--world", run),
        ("dut", "init", odd / "firmware"),
        ("emulate", "core", f"pty:{odd / 'line'}", "--seconds", "0.05"),
        ("decode", "auto", odd / "capture.log"),
    ):
        _, out, err = call(*arguments)
        told = (out + err).splitlines()
        assert spelling in out + err, arguments
        assert all(map(str.isprintable, told)), told


def test_a_result_that_quotes_a_name_is_no_command_to_their_terminal(call, tmp_path):
    (tmp_path / "\x1b[31m.toml").write_text("no scenario")
    status, out, _ = call("replay", tmp_path / "\x1b[31m.toml", "--junit", tmp_path / "junit.xml")
    assert (status, out.splitlines()[0]) == (1, "FAILED  \\x1b[31m")
    assert all(map(str.isprintable, out.splitlines())), out


def test_goldens_of_the_root_of_all_folders(call):
    shut = sorted(path for path in Path("/").iterdir() if path.is_dir() and not os.access(path, os.X_OK))
    if not shut:
        assert call("goldens", "/") == (0, "/ holds no golden\n", "")
    else:  # by somebody else than root
        status, out, err = call("goldens", "/")
        assert (status, err) == (1, "")
        assert [line.split()[0] for line in out.splitlines()] == [path.name for path in shut]


def test_the_page_is_not_written_over_by_the_report(call, tmp_path):
    scenario, page = short_scenario(tmp_path, "", seconds=0.1), tmp_path / "page.html"
    status, out, err = call("replay", scenario, "--html", page, "--junit", tmp_path / "." / "page.html")
    assert (status, out) == (2, "")
    assert "page.html: is given twice" in err
    assert not page.exists()


@pytest.mark.parametrize("option", ["--html", "--junit"])
@pytest.mark.parametrize("name", ["new", "there/short"])
def test_a_page_does_not_take_the_place_of_a_recording(call, tmp_path, option, name):
    scenario = short_scenario(tmp_path, "", seconds=0.1)
    (tmp_path / "there").mkdir()
    record = tmp_path / name if name == "new" else tmp_path / "there"
    status, out, err = call("replay", scenario, option, tmp_path / "." / name, "--record", record)
    assert (status, out) == (2, "")
    says = "will be a recording's directory (--record); give the page another name"
    assert err == f"wheelbench replay: {tmp_path / name}: {says}\n"
    assert not (tmp_path / name).exists()


def test_a_robot_without_a_name_is_not_another_one(call, tmp_path):
    """`--robot "$ROBOT"`, with a variable that nobody has set."""
    for source in (short_scenario(tmp_path), DRIVE):
        status, out, err = call("replay", source, "--robot", "")
        assert (status, out) == (2, "")
        assert "is a directory; a robot is a .toml file" in err


def test_a_folder_of_scenarios_is_told_how_they_are_replayed(call, tmp_path, monkeypatch):
    short_scenario(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert "are replayed by *.toml\n" in call("replay", "")[2]
    assert f"are replayed by {tmp_path}/*.toml\n" in call("replay", f"{tmp_path}/")[2]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize(
    ("command", "status"),
    [
        ("kin nobody 2> /dev/full", 2),
        ("kin nobody > /dev/full 2>&1", 2),
        ("kin m2006 > /dev/full 2>&1", 3),
        ("kin nobody 2>&1 > /dev/null | true", 2),
    ],
)
def test_the_exit_status_tells_what_stderr_does_not_take(command, status):
    assert in_a_shell(command) == (status, "")


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-"])
def test_a_closed_stream_is_no_error(closed, tmp_path):
    scenario = short_scenario(tmp_path)
    assert in_a_shell(f"replay {scenario} {closed}") == (0, "")


# --- robot files -------------------------------------------------------------------------------------------------


def edited_robot(tmp_path, old, new):
    text = (ROOT / "bench" / "robots" / "m2006.toml").read_text()
    assert old in text
    path = tmp_path / "my_robot.toml"
    path.write_text(text.replace(old, new))
    return path


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("mass_kg = 1.6", "mas_kg = 1.6", "body.mass_kg: is missing; is mas_kg meant to be it?"),
        ("[ground]", "[ground]\ngripp = 1.0", "ground.gripp: unknown key; did you mean grip?"),
        ("radius_m = 0.027", "radius_m = -0.027", "wheel[0].radius_m: expected a positive number"),
        ("bearing_deg = 75.0", "bearing_deg = 180.0", "singular"),
        ("distance_m = 0.061", "distance_m = nan", "wheel[0].distance_m: expected a finite number"),
        ("bearing_deg = 180.0", "bearing_deg = 40.0", "is not between the wheels"),
        ("load_friction = 0.0", "load_friction = 1.0", "motor.load_friction: expected less than 1"),
        ("can_id = 3", "can_id = 2", "wheel.can_id: 2 is given to more than one wheel"),
        ("current_a = 0.6", f"current_a = {'9' * 400}", "limits.current_a: expected a finite number, got inf"),
        ("current_a = 0.6", f"current_a = {'9' * 5000}", "is not valid TOML: Exceeds the limit (4300 digits)"),
        ('name = "m2006"', 'name = "m\\n2006"', "name: expected one line without control characters, got 'm\\n2006'"),
        ("can_id = 3", "can_id = 9", "wheel[2].can_id: expected 1 to 8"),
        ("direction = -1", "direction = 2", "wheel[0].direction: expected 1 or -1"),
        ("current_a = 0.6", "current_a = 60", "limits.current_a"),
        ("hold_ms = 100", "hold_ms = 600", "link.hold_ms"),
        ('kind = "c610"', 'kind = "c620"', "did you mean c610?"),
        ('rc = "uart12"', 'rc = "uart21"', "rc: no profile is called 'uart21'; did you mean uart12?"),
        ('rc = "uart12"', 'rc = "mine.toml"', "mine.toml: there is no such file; it is looked for beside the robot's"),
        ("schema = 1", "schema = 2", "schema: expected 1"),
        ("[limits]", "[limits", "is not valid TOML"),
    ],
)
def test_a_robot_file_that_cannot_be_is_refused_with_file_and_key(call, tmp_path, old, new, says):
    path = edited_robot(tmp_path, old, new)
    status, _, err = call("kin", path)
    assert status == 2
    assert says in err
    assert str(path) in err
    assert len(err.splitlines()) == 1


def test_a_robot_with_a_wheel_missing_is_refused(call, tmp_path):
    text = (ROOT / "bench" / "robots" / "m2006.toml").read_text()
    start = text.index('[[wheel]]\nname = "front left"')
    path = tmp_path / "two_wheels.toml"
    path.write_text(text[:start] + text[text.index("[body]") :])
    status, _, err = call("kin", path)
    assert (status, "at least three wheels, got 2" in err) == (2, True)


def test_a_robot_without_load_transfer_is_one(call, tmp_path):
    """As its range says: with its centre of gravity on the floor no acceleration moves load."""
    assert call("kin", edited_robot(tmp_path, "cog_height_m = 0.035", "cog_height_m = 0"))[0] == 0


def test_a_users_own_robot_file_drives(call, tmp_path):
    path = edited_robot(tmp_path, "mass_kg = 1.6", "mass_kg = 2.5")
    scenario = short_scenario(tmp_path, f'rc = "{DRIVE}"\n', seconds=2.0)
    assert call("replay", scenario, "--robot", path, "--record", tmp_path / "own")[0] == 0
    path.unlink()
    assert call("replay", tmp_path / "own")[0] == 0, "a recording brings its robot along"
