"""What a firmware prints stays in the recording, with its tick; and what follows from it: nothing."""

import json
import textwrap
from pathlib import Path

import pytest
from compilers import needs_compiler

from bench.__main__ import main
from bench.check.firmware_log import death
from bench.dut.firmware import firmware_of
from bench.dut.output import LOG_CHARACTERS, TAIL_CHARACTERS, TAKEN_BYTES
from bench.errors import ControllerFailed

pytestmark = needs_compiler

SCENARIO = 'schema = 1\nname = "short"\nseconds = 0.5\ncontroller = "fw.toml"\n'
TALKS = r"""
    #include "wheelbench.h"
    #include <assert.h>
    #include <stdio.h>
    int main(void) {
        printf("boot 7\r\n");
        for (;;) {
            uint32_t now = wb_millis();
            wb_can_write(0x200, (const uint8_t[8]){0}, 8);
            if (now == 20) printf("first half, "), fflush(stdout);
            if (now == 30) printf("second half\n");
            if (now == 40) printf("caf\xc3\xa9 \xff \x1b[31mred\tend\n");
            if (now == 50) fprintf(stderr, "to stderr\nand two lines\n");
            if (now == 60) printf("no end of line"), fflush(stdout);
            assert(now < DIES_AT);
            wb_wait();
        }
    }
    """
SAID = """\
(0.000000) | boot 7
(0.030000) | first half, second half
(0.040000) | café \\xff \\x1b[31mred\tend
(0.050000) | to stderr
(0.050000) | and two lines
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.scenario.toml").write_text(SCENARIO)
    return tmp_path


def made(folder, source, toml=""):
    (folder / "fw.c").write_text(textwrap.dedent(source))
    (folder / "fw.toml").write_text(f'schema = 1\nname = "fw"\nsources = ["fw.c"]\n{toml}')
    return folder / "fw.toml"


def stepped(base, ticks):
    for tick in range(ticks):
        base.step(tick, b"", b"", ())


def said(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    out = capsys.readouterr()
    return status, out.out, out.err


def test_each_line_stands_in_the_recording_with_its_tick_and_a_replay_needs_none(folder, capsys):
    made(folder, TALKS, 'defines = ["DIES_AT=999"]\n')
    assert said(capsys, "replay", "run.scenario.toml", "--record", "run")[0] == 0
    log = Path("run/firmware.log")
    assert log.read_text(encoding="utf-8") == SAID + "(0.060000) | no end of line\n"
    assert said(capsys, "replay", "run.scenario.toml", "--record", "again")[0] == 0
    assert Path("again/firmware.log").read_bytes() == log.read_bytes(), "a run repeats, what it says too"
    log.write_text("something else\n")
    status, out, error = said(capsys, "replay", "run", "--controller", "fw.toml")
    assert (status, error) == (0, ""), out
    assert said(capsys, "check", "run", "again")[0] == 0, "a comparison does not look at it"
    log.unlink()
    assert said(capsys, "replay", "run", "--controller", "fw.toml")[0] == 0
    assert said(capsys, "replay", "run.scenario.toml", "--record", "again", "--overwrite")[0] == 0


def test_a_base_that_prints_nothing_leaves_no_file(folder, capsys):
    assert said(capsys, "replay", "run.scenario.toml", "--controller", "speed-loop", "--record", "run")[0] == 0
    assert not Path("run/firmware.log").exists()


def test_how_it_died_is_its_last_line_and_is_told_by_check_and_replay(folder, capsys):
    made(folder, TALKS, 'defines = ["DIES_AT=70"]\n')
    status, _, error = said(capsys, "replay", "run.scenario.toml", "--record", "run")
    assert status == 1
    assert error.startswith("wheelbench replay: fw.toml: at tick 70 (0.070 s) the firmware crashed: SIGABRT")
    assert "\\x1b[31mred" in error, "nothing of it steers the terminal"
    *before, died = Path("run/firmware.log").read_text(encoding="utf-8").splitlines()
    assert "\n".join(before[:5]) + "\n" == SAID
    assertion = "firmware: fw.c:15: main: Assertion `now < DIES_AT' failed."
    assert before[5:] == [f"(0.070000) | no end of line{assertion}"], "the path is not this machine's"
    assert died.startswith("(0.070000) ! the firmware crashed: SIGABRT, an abort or a failed assert in main (fw.c:15)")
    status, out, _ = said(capsys, "replay", "run", "--controller", "fw.toml")
    assert status == 0, "up to there it is the same run"
    told = out.partition("died      at 0.070 s the firmware crashed: SIGABRT")[2].splitlines()
    assert told[0].endswith("; its last output:")
    assert told[1] == "          0.000 s  boot 7"
    assert "died      at 0.070 s the firmware crashed: SIGABRT" in said(capsys, "check", "run", "run")[1]
    facts = json.loads(said(capsys, "check", "run", "run", "--json")[1])
    assert facts["died"]["at_s"] == 0.07
    assert facts["died"]["last_output"][0] == {"at_s": 0.0, "text": "boot 7"}


def test_a_log_is_bounded_and_keeps_its_beginning_and_its_end(folder):
    source = """
        #include "wheelbench.h"
        #include <stdio.h>
        int main(void) {
            for (int line = 0;; wb_wait())
                for (int i = 0; i < 20 && line < 60000; i++)
                    printf("line %d of a talkative firmware\\n", line++);
        }
        """
    base = firmware_of(made(folder, source))()
    lines = []
    for tick in range(3010):
        base.step(tick, b"", b"", ())
        if tick % 100 == 0:
            lines += base.log_lines()
    lines += base.log_lines(is_over=True)
    texts = [text for _, _, text in lines]
    assert sum(map(len, texts)) < LOG_CHARACTERS + TAIL_CHARACTERS
    assert texts[0] == "line 0 of a talkative firmware"
    gap = next(at for at, text in enumerate(texts) if text.startswith("..."))
    before, after = (int(texts[at].split()[1]) for at in (gap - 1, gap + 1))
    assert texts[gap] == f"... {after - before - 1} lines are left out"
    assert texts[-1] == "line 59999 of a talkative firmware"
    assert lines[-1][0] == 2999
    assert len(base.output()) <= TAIL_CHARACTERS


def test_a_flood_in_one_millisecond_is_cut_and_so_is_a_line_without_an_end(folder):
    source = """
        #include "wheelbench.h"
        #include <stdio.h>
        int main(void) {
            for (int i = 0; i < 30000; i++)
                printf("%09d\\n", i);
            wb_irq_on();
            for (;; wb_wait())
                if (wb_millis() < 2000) fputs("no end ", stdout), fflush(stdout);
        }
        """
    base = firmware_of(made(folder, source, "blocks_per_ms = 1000000\n"))()
    stepped(base, 2500)
    lines = base.log_lines(is_over=True)
    left_out = int(lines[0][2].split()[1])
    assert lines[0] == (0, "|", f"... {left_out} bytes of one millisecond are left out")
    assert left_out == 30000 * 10 + len("no end ") - TAKEN_BYTES
    assert (0, "|", "000029999") in lines
    assert all(len(text) <= 1100 for _, _, text in lines)


def test_a_sanitizers_report_is_told_but_is_no_line_of_the_firmware(folder):
    source = """
        #include "wheelbench.h"
        #include <stdio.h>
        static uint8_t frame[12];
        static volatile int count = 12;
        int main(void) {
            printf("ready\\n");
            for (;; wb_wait())
                if (wb_millis() > 3) frame[count] = 1;
        }
        """
    base = firmware_of(made(folder, source, "sanitize = true\n"))()
    with pytest.raises(ControllerFailed, match="index 12 out of bounds"):
        stepped(base, 10)
    printed, died = base.log_lines(is_over=True)
    assert printed == (0, "|", "ready")
    assert died[1] == "!"
    assert "index 12 out of bounds" in died[2]


def test_a_log_that_somebody_wrote_in_tells_nothing(folder):
    for text in ("", "(0.1) ! x\n", "(0.100000) ! died\n(0.200000) | lives\n", "\xff\n", "garbage"):
        (folder / "firmware.log").write_text(text, encoding="latin-1")
        assert death(folder) is None
    (folder / "firmware.log").write_text("(0.100000) ! died\n")
    assert death(folder).lines() == ["died      at 0.100 s died"]
