"""Does it move the way the stick says? Does it stop when it must? Did the last change alter a frame?"""

import pytest


def test_nothing_moves_before_it_is_armed(bench, rc, plant):
    rc.hold(forward=0.5).run(0.5)
    assert plant.pose.x_m == pytest.approx(0.0, abs=1e-9)


def test_forward_is_forward_and_back_is_back(bench, rc, plant):
    rc.arm().hold(forward=1.0).run(0.8)
    ahead_m = plant.pose.x_m
    assert ahead_m > 0.05
    rc.hold(forward=-1.0).run(1.5)
    assert plant.twist.vx_mps < -0.1


def test_it_stops_when_the_transmitter_is_gone(bench, rc, can_bus, plant):
    rc.arm().hold(forward=1.0).run(0.8)
    rc.transmitter.on = False
    off_tick = bench.bench.now_tick
    bench.run(1.5)
    last = max(tick for tick, fields in can_bus.decoded(0x200) if fields["current_1_ma"])
    assert last - off_tick < 75
    assert plant.twist.vx_mps == pytest.approx(0.0, abs=1e-3)


def test_the_drive_is_the_one_we_have_looked_at(bench, rc, golden):
    rc.arm().hold(forward=0.6).run(0.2).hold().run(0.1)
    golden()
