"""Noise on the motors' feedback: off it is not there, on it is what was asked for, and the same every time."""

import json
from collections import Counter

import pytest

from bench.__main__ import main
from bench.check.reading import Recording
from bench.check.sources import from_source
from bench.config import ConfigError
from bench.loop import simulated
from bench.noise import COUNTS, Noise, NoisyFeedback

FRAMES = tuple((0x201 + i, (4096).to_bytes(2, "big") + bytes((0, 100, 0, 5, 0, 0))) for i in range(3))


def heard(noise: Noise, ticks: int = 2000) -> list[tuple[int, int, bytes]]:
    wire = NoisyFeedback(noise)
    return [(tick, *frame) for tick in range(ticks) for frame in wire.step(tick, FRAMES)]


def test_splitmix64_draws_as_its_authors_print_it():
    """The first numbers from seed 1234567, scaled: 6457827717110365317, 3203168211198807973, 9817491932198370423."""
    wire = NoisyFeedback(Noise(angle_counts=1, seed=1234567))
    assert [wire._draw(1 << 64) for _ in range(3)] == [
        6457827717110365317, 3203168211198807973, 9817491932198370423,
    ]  # fmt: skip


def test_without_settings_nothing_stands_in_the_way():
    assert not Noise(seed=9).is_on
    assert simulated("m2006").world.motors.noise is None


def test_angles_are_off_by_up_to_what_was_asked_and_evenly():
    off = Counter(int.from_bytes(data[:2], "big") - 4096 for _, _, data in heard(Noise(angle_counts=2, seed=1)))
    assert sorted(off) == [-2, -1, 0, 1, 2]
    assert all(count == pytest.approx(6000 / 5, rel=0.1) for count in off.values())


def test_angles_wrap_and_the_rest_of_a_frame_stays():
    wire = NoisyFeedback(Noise(angle_counts=3, seed=4))
    angles = {int.from_bytes(wire.step(tick, ((0x201, bytes(8)),))[0][1][:2], "big") for tick in range(200)}
    assert angles == {0, 1, 2, 3, COUNTS - 3, COUNTS - 2, COUNTS - 1}
    assert all(data[2:] == FRAMES[0][1][2:] for _, _, data in heard(Noise(angle_counts=2)))


def test_a_share_of_frames_is_lost():
    noise = Noise(loss_ppm=100_000, seed=3)
    wire = NoisyFeedback(noise)
    arrived = sum(len(wire.step(tick, FRAMES)) for tick in range(2000))
    assert arrived + wire.lost == 6000
    assert wire.lost == pytest.approx(600, rel=0.15)


def test_late_frames_come_within_their_time_all_of_them_and_in_order():
    wire = NoisyFeedback(Noise(late_ticks=3, seed=5))
    sent = {}
    last = {}
    came = 0
    for tick in range(1000):
        frames = [(0x201 + i, tick.to_bytes(2, "big") + bytes(6)) for i in range(3)] if tick < 990 else []
        for can_id, data in frames:
            sent[can_id, data] = tick
        for frame in wire.step(tick, frames):
            assert 0 <= tick - sent[frame] <= 3
            assert sent[frame] > last.get(frame[0], -1)
            last[frame[0]] = sent[frame]
            came += 1
    assert came == 3 * 990
    assert wire.late > 1000


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("angle_count = 2", "noise.angle_count: unknown key; did you mean angle_counts?"),
        ("angle_counts = -1", "noise.angle_counts: expected 0 (off) to 4096, got -1"),
        ("angle_counts = 1.5", "noise.angle_counts: expected a whole number, got 1.5"),
        ("late_ticks = 1001", "noise.late_ticks: expected 0 (off) to 1000, got 1001"),
        ("loss = 1.0", "noise.loss: expected a probability, 0 (off) to less than 1, got 1"),
        ("loss = nan", "noise.loss: expected a finite number, got nan"),
    ],
)
def test_wrong_settings_are_refused_with_file_and_key(tmp_path, text, sentence):
    path = tmp_path / "noisy.toml"
    path.write_text(f'schema = 1\nname = "n"\nseconds = 1.0\n[noise]\n{text}\n')
    with pytest.raises(ConfigError) as refusal:
        from_source(path)
    assert str(refusal.value) == f"{path}: {sentence}"


def test_a_noisy_run_is_recorded_with_its_settings_and_repeats_byte_for_byte(tmp_path, capsys):
    path = tmp_path / "noisy.toml"
    path.write_text(
        'schema = 1\nname = "noisy"\nrobot = "slamware-b"\nseconds = 1.5\nseed = 42\n'
        "[noise]\nangle_counts = 3\nlate_ticks = 2\nloss = 0.01\n[[core]]\nat_s = 0.2\nvx_mps = 0.3\n"
    )
    ends = {}
    for name in ("one", "two"):
        assert main(["replay", str(path), "--record", str(tmp_path / name), "--json"]) == 0
        ends[name] = json.loads(capsys.readouterr().out)["end"]
    assert main(["replay", str(tmp_path / "one"), "--record", str(tmp_path / "again"), "--json"]) == 0
    for file in sorted((tmp_path / "one").iterdir()):
        for other in ("two", "again"):
            assert (tmp_path / other / file.name).read_bytes() == file.read_bytes(), (other, file.name)
    recording = Recording.open(tmp_path / "one")
    assert recording.noise == Noise(3, 2, 10_000, 42)
    assert "noise_loss_ppm = 10000" in (tmp_path / "one" / "run.toml").read_text()
    frames = sum(map(len, recording.feedback.values()))
    assert 1500 * 3 * 0.97 < frames < 1500 * 3
    assert ends["one"][0] > 0.1

    path.write_text(path.read_text().replace("seed = 42", "seed = 43"))
    assert main(["replay", str(path), "--record", str(tmp_path / "other"), "--json"]) == 0
    assert (tmp_path / "other" / "can.log").read_bytes() != (tmp_path / "one" / "can.log").read_bytes()
