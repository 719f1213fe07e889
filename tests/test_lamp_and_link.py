"""The link that runs a bench for a screen, and the golden's lamp: against the real bench and real recordings."""

import re

import pytest
from desk import M2006, Granted, a_job

from bench.check.golden import pin, verdict
from bench.check.reading import Recording
from bench.check.recording import RecordingError
from bench.check.sources import from_recording
from bench.errors import EXIT_FAILED
from bench.io.clock import FreePacer
from bench.io.link import BenchStopped, InlineLink
from bench.loop import NOTHING, simulated
from bench.messages import BodyTwist, TickInput
from bench.screen.keyboard import Keyboard
from bench.screen.lamp import GoldenLamp


class Taker:
    def __init__(self, fails_at=None):
        self.ticks = []
        self.closed = 0
        self.fails_at = fails_at

    def add(self, out):
        if out.tick == self.fails_at:
            raise RecordingError("run/can.log: cannot be written (No space left on device)")
        self.ticks.append(out.tick)

    def close(self):
        self.closed += 1


class OnlyAdds:
    def add(self, out):
        self.last = out.tick


def a_link(inputs=lambda tick: NOTHING, pacer=None, **options):
    return InlineLink(simulated(M2006), inputs, pacer or Granted(), **options)


# --- the link ------------------------------------------------------------------------------------------------------


def test_it_runs_what_the_pacer_grants_and_no_more():
    link = a_link(pacer=FreePacer(7))
    assert [link.advance(), link.advance()] == [7, 7]
    assert link.now_tick == 14 == link.latest().tick


def test_inputs_are_asked_for_every_tick_in_order_once():
    asked = []
    link = a_link(lambda tick: asked.append(tick) or NOTHING)
    link.run(5)
    link.run(3)
    assert asked == list(range(8))


def test_a_run_ends_at_its_last_tick():
    link = a_link(pacer=FreePacer(40), ticks=100)
    assert [link.advance() for _ in range(4)] == [40, 40, 20, 0]
    assert link.ended
    assert link.run(5) == 0


def test_paused_it_stands_still():
    link = a_link(pacer=FreePacer(10))
    link.pause(True)
    assert link.advance() == 0
    link.pause(False)
    assert link.advance() == 10


def test_takers_get_every_tick_and_are_closed_once():
    taker, simple = Taker(), OnlyAdds()
    link = a_link(takers=[taker, simple])
    link.run(20)
    link.close()
    link.close()
    assert taker.ticks == list(range(20))
    assert simple.last == 19
    assert taker.closed == 1


def test_a_bench_that_raises_ends_the_run_in_one_sentence_with_the_recording_closed():
    def inputs(tick):
        return TickInput(core_twist=BodyTwist(1e9, 0.0, 0.0)) if tick == 12 else NOTHING  # fits on no wire

    taker = Taker()
    link = a_link(inputs, takers=[taker])
    with pytest.raises(BenchStopped) as caught:
        link.run(50)
    assert str(caught.value).startswith("stopped at tick 12: ValueError in ")
    assert "\n" not in str(caught.value)
    assert ".py:" in str(caught.value), "says where"
    assert caught.value.__cause__ is not None
    assert caught.value.exit_status == EXIT_FAILED == 1
    assert taker.ticks == list(range(12))
    assert taker.closed == 1


def test_a_recorder_that_fails_is_told_by_its_own_words():
    full, other = Taker(fails_at=5), Taker()
    link = a_link(takers=[other, full])
    with pytest.raises(RecordingError, match="No space left"):
        link.run(50)
    assert full.closed == other.closed == 1


def test_wires_hold_the_last_of_each_even_where_frames_are_cut():
    frame = bytes.fromhex("AA0800080008000800000055")
    cut = {10: frame[:5], 11: frame[5:], 20: frame[:7], 21: frame[7:] + frame[:3]}
    link = a_link(lambda tick: TickInput(cut.get(tick, b"")))
    assert link.wires.rc is None
    assert link.wires.can_commands is None
    link.run(22)
    wires = link.wires
    assert wires.rc == (21, frame), "the frame's bytes, not what is there of the next one"
    assert wires.can_commands == (21, ((0x200, bytes(8)),))
    assert [can_id for can_id, _ in wires.can_feedback[1]] == [0x201, 0x202, 0x203]
    assert wires.core_to_base[1].payload.hex()[:2] in ("10", "41")
    assert wires.base_to_core[0] <= 21


def test_noise_on_the_rc_wire_is_shown_as_it_came():
    link = a_link(lambda tick: TickInput(b"\x55" * 3 if tick % 10 == 0 else b""))
    link.run(1001)
    tick, data = link.wires.rc
    assert tick == 1000
    assert set(data) == {0x55}
    assert len(data) <= 256


def test_the_trail_is_where_the_robot_was_and_is_bounded():
    keyboard = Keyboard(M2006.rc)
    link = a_link(keyboard.inputs)
    link.run(50)
    keyboard.press("enter", 50, False)
    for _ in range(30):
        link.run(50)
        keyboard.press("w", link.now_tick, True)
    xs = [x for x, _ in link.trail]
    assert xs[0] == 0.0
    assert xs == sorted(xs)
    assert xs[-1] > 0.3
    assert link.trail.maxlen == 1200


# --- the lamp ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A second and a half of driving, recorded."""
    job, keyboard = a_job()
    directory = tmp_path_factory.mktemp("lamp") / "run"
    link = InlineLink(job.bench, keyboard.inputs, Granted(), takers=[job.recorder(directory)])
    link.run(50)
    keyboard.press("enter", 50, False)
    for _ in range(14):
        link.run(100)
        keyboard.press("w", link.now_tick, True)
    link.run(50)
    link.close()
    return Recording.open(directory)


@pytest.fixture(scope="module")
def outputs(recorded):
    return list(from_recording(recorded.directory))


def judged(golden, outputs):
    lamp = GoldenLamp(golden)
    for out in outputs:
        lamp.add(out)
    return lamp


def test_a_replay_of_a_recording_is_identical(recorded, outputs):
    lamp = GoldenLamp(recorded)
    for out in outputs[:700]:
        lamp.add(out)
    assert lamp.text == "identical so far"
    for out in outputs[700:]:
        lamp.add(out)
    lamp.finish(len(outputs))
    assert lamp.text == "identical"
    assert lamp.first is None


def command(*currents):
    return ((0x200, b"".join(current.to_bytes(2, "big", signed=True) for current in currents)),)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"can_commands": command(-477, 5, 3, 0)}, "0x200 current 1 -477 not "),
        ({"can_commands": ()}, "can frames 0x201 0x202 0x203 not 0x200 0x201 0x202 0x203 at"),
        ({"can_feedback": ()}, "can frames 0x200 not 0x200 0x201 0x202 0x203 at"),
        ({"rc": b"\xaa\x00"}, "rc byte "),
        ({"core_to_base": b"\x10"}, "slamware core->base byte 0"),
        ({"base_to_core": b"\x50\x01"}, "slamware base->core byte 0"),
    ],
)
def test_the_first_difference_is_named_and_stays(recorded, outputs, change, words):
    tick = 1203
    changed = [*outputs[:tick], outputs[tick]._replace(**change), *outputs[tick + 1 :]]
    lamp = judged(recorded, changed)
    assert lamp.text.startswith("differs: ")
    assert words in lamp.text
    assert lamp.text.endswith("at 1.203 s")


def a_milliampere(outputs, tick=1200):
    can_id, data = outputs[tick].can_commands[0]
    first = int.from_bytes(data[:2], "big", signed=True) + 1
    nudged = ((can_id, first.to_bytes(2, "big", signed=True) + data[2:]),)
    return [*outputs[:tick], outputs[tick]._replace(can_commands=nudged), *outputs[tick + 1 :]]


def a_tenth_of_a_millimetre(outputs, tick=1200):
    row = list(outputs[tick].state)
    row[1] += 0.000_1
    return [*outputs[:tick], outputs[tick]._replace(state=tuple(row)), *outputs[tick + 1 :]]


@pytest.fixture(scope="module", params=["here", "elsewhere"])
def golden(request, recorded, tmp_path_factory):
    """The recording pinned, here or as if on another platform."""
    directory = tmp_path_factory.mktemp("golden") / request.param
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("CI", raising=False)
        pin(recorded.directory, directory)
    if request.param == "elsewhere":
        path = directory / "golden.toml"
        path.write_text(re.sub('platform = "[^"]*"', 'platform = "another"', path.read_text()))
    return Recording.open(directory)


@pytest.mark.parametrize(
    ("change", "words"), [(a_milliampere, "0x200 current 1"), (a_tenth_of_a_millimetre, "state x_m")]
)
def test_the_lamp_is_as_exact_as_the_verdict(golden, outputs, tmp_path, change, words):
    changed = change(outputs)
    job, _ = a_job()
    with job.recorder(tmp_path / "run") as recorder:
        for out in changed:
            recorder.add(out)
    found = verdict(Recording.open(tmp_path / "run"), golden.directory)
    lamp = judged(golden, changed)
    lamp.finish(len(changed))
    assert (lamp.first is None) == found.ok == (golden.directory.name == "elsewhere")
    if lamp.first is not None:
        assert lamp.first == found.first
    assert lamp.text.startswith(f"{'differs' if lamp.first else 'within tolerances'}: {words}")


def test_a_golden_that_was_changed_lights_no_lamp(recorded, tmp_path, monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    pin(recorded.directory, tmp_path / "golden")
    with open(tmp_path / "golden" / "rc.log", "a") as log:
        log.write("(1.400000) rc0 > 00\n")
    with pytest.raises(RecordingError, match=r"rc\.log: is not what was pinned"):
        GoldenLamp(Recording.open(tmp_path / "golden"))


def test_a_run_of_another_length_differs(recorded, outputs):
    lamp = judged(recorded, outputs[:-10])
    lamp.finish(len(outputs) - 10)
    assert "ticks" in lamp.text
    longer = judged(recorded, [*outputs, outputs[-1]._replace(tick=len(outputs))])
    assert "ticks" in longer.text
