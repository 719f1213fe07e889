"""The figures of a stream, from its events and their times."""

import pytest

from bench.messages import RcFrame, RcLinkStatistics, RcNoise
from bench.rc.health import HealthMeter

FRAME = RcFrame(0, 25, (992,) * 16)


def metered(times_us, frame=FRAME):
    meter = HealthMeter()
    for at_us in times_us:
        meter.take(at_us, [frame])
    return meter


def test_before_anything_there_are_no_figures():
    health = HealthMeter().at(5_000)
    assert (health.frames, health.rate_hz, health.jitter_us, health.longest_gap_us, health.age_us) == (0, *[None] * 4)


def test_an_even_stream():
    health = metered(range(0, 90_000, 9_000)).at(85_000)
    assert health.frames == 10
    assert health.rate_hz == pytest.approx(1e6 / 9_000)
    assert (health.jitter_us, health.longest_gap_us, health.age_us) == (0.0, 9_000, 4_000)


def test_jitter_is_the_standard_deviation_of_the_gaps():
    health = metered([0, 8_000, 18_000, 26_000, 36_000]).at(36_000)
    assert (health.rate_hz, health.jitter_us) == (pytest.approx(1e6 / 9_000), pytest.approx(1_000))


def test_the_longest_gap_is_remembered_and_the_present_silence_counts():
    meter = metered([0, 10_000, 60_000, 70_000])
    assert meter.at(75_000).longest_gap_us == 50_000
    assert meter.at(200_000).longest_gap_us == 130_000
    meter.take(210_000, [FRAME])
    assert meter.at(210_000).longest_gap_us == 140_000


def test_flagged_frames_count_but_are_no_word_of_the_transmitter():
    meter = metered([0, 9_000])
    meter.take(18_000, [FRAME._replace(frame_lost=True)])
    meter.take(27_000, [FRAME._replace(failsafe=True, frame_lost=True)])
    health = meter.at(27_000)
    assert (health.frames, health.failsafe_frames, health.frame_lost_frames, health.age_us) == (4, 1, 2, 18_000)


def test_noise_by_reason_and_link_quality():
    meter = HealthMeter()
    meter.take(0, [RcNoise(0, 3, "header"), RcNoise(28, 4, "checksum"), RcNoise(40, 1, "header")])
    meter.take(1, [RcLinkStatistics(32, 14, 97, -70, 8)])
    health = meter.at(1)
    assert (health.noise_bytes, health.noise_by_reason, health.quality_percent) == (8, {"header": 4, "checksum": 4}, 97)


def test_rate_and_jitter_are_those_of_a_window():
    health = metered([*range(0, 1_000_000, 1_000), *range(1_000_000, 4_000_000, 10_000)]).at(4_000_000)
    assert health.rate_hz == pytest.approx(100)
    assert health.jitter_us == pytest.approx(0)
