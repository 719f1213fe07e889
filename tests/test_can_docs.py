"""The pages on CAN: their byte tables are the codec's, their Python runs, their commands print what they show."""

import doctest
import itertools
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from bench.canbus import c610, dm3519
from bench.canbus.instruments import with_instruments
from bench.canbus.table import byte_table

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "docs" / name for name in ("c610.md", "dm3519.md", "bus.md", "gyro.md")]
BY_PAGE = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)

MARK = re.compile(r"<!-- bytes: (\S+) (0x[0-9A-F]{3}) -->\n((?:\|.*\n)*)")
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FAMILIES = {
    "c610": c610.FAMILY,
    "dm3519": dm3519.family(),
    "dm3519-error": dm3519.family(feedback_variant="error"),
    "dm3519-short": dm3519.family(clear_error="short"),
    "gyro": with_instruments(c610.FAMILY, (), 1),
}


def tables():
    for page in PAGES:
        for name, can_id, lines in MARK.findall(page.read_text()):
            message = next(one for one in FAMILIES[name].messages if one.can_id == int(can_id, 16))
            yield pytest.param(message, lines.splitlines(), id=f"{page.stem} {name} {can_id}")


@pytest.mark.parametrize(("message", "lines"), list(tables()))
def test_the_byte_table_is_the_codecs(message, lines):
    assert lines == byte_table(message)


@pytest.mark.parametrize("name", ["c610", "dm3519"])
def test_the_worked_frames_are_those_from_outside(name):
    """The page's own Python decodes and encodes them; here they are held against the fixture's bytes and values."""
    known = json.loads((ROOT / "fixtures" / "known" / "can" / f"{name}-frames.json").read_text())["frames"]
    frames = {(one["can_id"], one["data"]): one["values"] for one in known}
    page = (ROOT / "docs" / f"{name}.md").read_text()
    shown = re.findall(r'(0x[0-9A-F]{3}), bytes\.fromhex\("([0-9A-F ]+)"\)', page)
    assert shown
    for can_id, data in shown:
        values = frames[int(can_id, 16), data.replace(" ", "")]
        words = page.partition(f'{can_id}, bytes.fromhex("{data}")')[2].partition("```")[0]
        assert all(re.search(rf"\b{abs(value)}\b", words) for value in values)


def test_every_kind_of_message_has_a_table():
    assert len(list(tables())) == 8


@BY_PAGE
def test_the_python_of_the_page_runs(page):
    blocks = [block for language, block in FENCE.findall(page.read_text()) if language == "python"]
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, page.name, str(page), 0)
    failures = []
    doctest.DocTestRunner(verbose=False).run(test, out=failures.append)
    assert not failures, "".join(failures)
    assert test.examples or page.stem == "bus"


@BY_PAGE
def test_commands_print_what_the_page_shows(page):
    fences = FENCE.findall(page.read_text())
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for (language, command), (after, shown) in itertools.pairwise(fences):
        if (language, after) == ("sh", "text"):
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=ROOT,
                env={**os.environ, "PATH": path},
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.stdout == shown, command


def test_the_robot_file_of_the_page_is_the_robots():
    (block,) = [
        block for language, block in FENCE.findall((ROOT / "docs" / "dm3519.md").read_text()) if language == "toml"
    ]
    shown = tomllib.loads(block)
    real = tomllib.loads((ROOT / "bench" / "robots" / "dm3519.toml").read_text())
    assert shown["dm3519"] == real["dm3519"]
    assert shown["motor"].items() <= real["motor"].items()
