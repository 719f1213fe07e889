"""Every kind of fault on every wire, in one real drive each: it touches what it says, in its time, and is witnessed."""

import re

import pytest

from bench.check.faults import FRAME_KINDS, KINDS
from bench.errors import UsageError
from bench.scenarios import load_robot, prepare, run

# What issue 5 names, by what it is called here.
LINKS = ("rc", "core", "answer", "command", "feedback")
ON_EVERY_LINK = {"drop", "delay", "duplicate", "reorder", "corrupt", "truncate", "stall", "freeze"}
NEEDS = {"delay": {"ms": 7}, "truncate": {"keep": 3}, "weak": {"factor": 0.5}, "slippery": {"factor": 0.3}}
NEEDS |= {
    "push": {"force_n": 3.0, "bearing_deg": 90.0},
    "corrupt": {"probability": 0.2},
    "lose_byte": {"probability": 0.2},
}
BEGIN_MS, EACH_MS = 400, 120
LATE_MS = 60
"""What was held back may come with the next piece, and a core speaks every 50 ms."""
WITNESS = re.compile(r'\((\d+\.\d{3})000\) "([\w ]+)" (\w+) (.+) -> (.+)')


def drive(wire, kinds, times):
    """Keys of a drive in which these kinds act on a wire, one after the other."""
    faults = [
        {"wire": wire, "kind": kind, "name": kind, "for_s": EACH_MS / 1000, **NEEDS.get(kind, {}), **times(number)}
        for number, kind in enumerate(kinds)
    ]
    return {
        "seconds": (BEGIN_MS + 2 * EACH_MS * len(kinds) + 100) / 1000,
        "stick": [{"at_s": 0.1, "aux1": True}, {"at_s": 0.2, "forward": 0.5, "turn": 0.2}],
        "core": [
            {"at_s": 0.05 * step, "vx_mps": 0.001 * step}
            for step in range(1, int((BEGIN_MS + 2 * EACH_MS * len(kinds)) / 50))
        ],
        "fault": faults,
    }


def at_its_time(number):
    return {"at_s": (BEGIN_MS + 2 * EACH_MS * number) / 1000}


def when_its_time_comes(number):
    return {"when": f"t_s >= {(BEGIN_MS + 2 * EACH_MS * number) / 1000}"}


def test_every_kind_is_there_on_every_link():
    for link in LINKS:
        assert set(KINDS[link]) >= ON_EVERY_LINK, link
    assert {"flag", "lost_flag", "freeze"} <= set(KINDS["rc"])
    assert "flag" in KINDS["feedback"]
    assert set(KINDS["esc"]) == {"silent", "weak"}
    assert "stuck" in KINDS["feedback"]
    assert set(KINDS["plant"]) == {"slippery", "push"}


@pytest.mark.parametrize("times", [at_its_time, when_its_time_comes])
@pytest.mark.parametrize("wire", KINDS)
def test_it_touches_what_it_says_and_leaves_a_witness(tmp_path, wire, times):
    kinds = [kind for kind in KINDS[wire] if (wire, kind) != ("feedback", "flag")]
    profile = {"profile": "frsky-sbus"} if wire == "rc" else {}
    result = run(record=tmp_path / "run", **drive(wire, kinds, times), **profile)
    assert result.untouched == ()
    assert [span.name for span in result.faults] == kinds
    lines = (tmp_path / "run" / "faults.log").read_text().splitlines()
    found = [WITNESS.fullmatch(line) for line in lines]
    assert all(found), [line for line, one in zip(lines, found, strict=True) if not one][:3]
    for number, kind in enumerate(kinds):
        touches = [one for one in found if one[2] == kind]
        assert touches, kind
        begins_ms = BEGIN_MS + 2 * EACH_MS * number
        for one in touches:
            assert begins_ms <= round(1000 * float(one[1])) <= begins_ms + EACH_MS + LATE_MS, one[0]
            assert one[3] == wire
            assert one[4] != one[5], one[0]


def test_kinds_of_rc_frames_are_those_of_the_protocol():
    for kind in FRAME_KINDS[:2]:
        with pytest.raises(UsageError, match="uart12 frames cannot say"):
            run(seconds=1, fault=[{"wire": "rc", "kind": kind, "at_s": 0}])


def test_a_motor_that_can_report_an_error_does_and_one_that_cannot_is_refused(tmp_path):
    with pytest.raises(UsageError, match="the feedback of m2006 cannot report an error; that of a DM3519 can"):
        run(seconds=1, fault=[{"wire": "feedback", "kind": "flag", "at_s": 0}])
    text = load_robot("dm3519").file.read_text()
    (tmp_path / "tells.toml").write_text(re.sub('feedback = "\\w+"', 'feedback = "error"', text))
    keys = drive("feedback", ["flag"], at_its_time)
    job = prepare(robot=tmp_path / "tells.toml", **keys)
    errors = {out.tick: [data[7] for _, data in out.can_feedback] for out in job}
    assert errors[350] == [1, 1, 1, 1][: len(errors[350])]
    assert errors[450] == [0xA] * len(errors[450])


def test_frozen_frames_say_what_the_first_said_and_a_single_frame_changes_places_with_the_next():
    frozen = [out.can_commands for out in prepare(**drive("command", ["drop"], at_its_time))]
    assert len({frames for frames in frozen[400:500]}) > 1, "the base goes on: only the motors hear nothing new"
    job = prepare(**drive("feedback", ["freeze"], at_its_time))
    arrived = [out.can_feedback for out in job]
    assert len(set(arrived[400:500])) == 1
    assert len(set(arrived[500:600])) > 1
    swapped = run(**drive("command", ["reorder"], at_its_time)).faults
    assert swapped[0].touched in range(EACH_MS - 1, EACH_MS + 2)
