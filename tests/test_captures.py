"""Recordings of real transmitters, end to end through the whole bench onto the robot's wheels."""

import json
import math
from bisect import bisect_right
from itertools import pairwise

import pytest

from bench.check.sources import from_capture
from bench.m2006 import decode_command


def row_at(rows, frame):
    """The channel row in force at a frame: rows are written when anything changes."""
    return rows[bisect_right(rows, frame, key=lambda row: row[0]) - 1][1:]


@pytest.fixture(scope="module")
def crossfire(captures):
    """(capture's description, every output, every true twist) of the Crossfire drive at 4 ms a frame."""
    path = captures / "rc" / "crsf-tbs-1.bin"
    run = from_capture(path, profile="crossfire", period_ms=4)
    ticks = [(out, run.bench.world.plant.twist, run.bench.world.plant.pose) for out in run]
    return json.loads(path.with_suffix(".json").read_text()), ticks, run.bench.base.link


def test_every_frame_of_the_crossfire_drive_is_seen_and_no_other(crossfire):
    described, _, link = crossfire
    assert link.frames == described["frames"]["count"] == 1606
    assert (link.noise_bytes, link.flagged_frames) == (0, 0)


# Crossfire: (raw - 992) / 819.5; channel 2 forward, 1 right, 3 clockwise. Forward is +vx, right -vy, clockwise -omega.
AXES = [(2, 0, 1), (1, 1, -1), (3, 2, -1)]


@pytest.mark.parametrize(("channel", "axis", "sign"), AXES)
def test_the_crossfire_drive_pushes_the_robot_the_way_the_sticks_say(crossfire, channel, axis, sign):
    """A stick held well out and alone for 100 ms speeds the robot up that way, and so do the currents on the wire."""
    described, ticks, _ = crossfire
    rows = described["raw_channels"]["rows"]
    pushes = agreed = currents_agreed = 0
    for frame in range(0, 1606 - 25, 5):
        held = [row_at(rows, f)[channel] - 992 for f in range(frame, frame + 25)]
        if min(held) < 250 and max(held) > -250:
            continue
        way = math.copysign(1, held[0]) * sign
        before, after = ticks[frame * 4][1][axis], ticks[frame * 4 + 99][1][axis]
        if abs(after) >= [0.5, 0.4, 1.9][axis] or before * way > [0.3, 0.3, 1.2][axis]:
            continue  # already as fast as it gets
        pushes += 1
        agreed += (after - before) * way > 0
        # Document 004's geometry: which wheel currents (clockwise positive on the wire) push that way.
        pattern = [(-1, 0, 1), (-0.26, 1, -0.26), (-1, -1, -1)][axis]
        mean = [0.0, 0.0, 0.0]
        for out, _, _ in ticks[frame * 4 : frame * 4 + 100]:
            for wheel, raw in enumerate(decode_command(out.can_commands[0][1])[:3]):
                mean[wheel] += raw / 100
        currents_agreed += sum(p * m for p, m in zip(pattern, mean, strict=True)) * way > 0
    assert pushes >= 5
    assert agreed / pushes > 0.8
    assert currents_agreed / pushes > 0.8


def test_the_crossfire_drive_displaces_the_robot(crossfire):
    _, ticks, _ = crossfire
    path = [pose for _, _, pose in ticks[::10]]
    assert sum(math.dist(a[:2], b[:2]) for a, b in pairwise(path)) > 0.1
    assert max(abs(raw) for out, _, _ in ticks for raw in decode_command(out.can_commands[0][1])) > 200


def test_the_futaba_stream_drives_forward_and_every_good_frame_is_seen(captures):
    path = captures / "rc" / "sbus2-futaba-r7008sb-1.bin"
    described = json.loads(path.with_suffix(".json").read_text())
    run = from_capture(path, profile="futaba-sbus2")
    outputs = list(run)
    link = run.bench.base.link
    assert link.frames == described["good_frames"]["count"] == 54
    assert link.flagged_frames == 0
    # Channel 2 stands at 1696, full forward on this transmitter; the others are in the middle.
    assert run.bench.world.plant.pose.x_m > 0.1
    assert abs(run.bench.world.plant.pose.y_m) < 1e-3
    assert min(decode_command(out.can_commands[0][1])[0] for out in outputs) == -600
    assert run.bench.world.plant.twist == pytest.approx((0, 0, 0), abs=1e-6), "the stream ends, the robot stops"
