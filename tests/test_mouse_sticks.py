"""The mouse's sticks: where they stand, when they let go, and the same through the app, its bytes and the base."""

import pytest
from desk import armed, frame, piloted
from textual import events

from bench.rc.transmitter import Sticks
from bench.screen.mouse_sticks import MouseSticks, pad_of
from bench.screen.view import picture

PAD = pad_of(80, 9)
MIDDLE = (PAD.stick.x + PAD.stick.width // 2, PAD.stick.y + PAD.stick.height // 2)


def held(x=0, y=0, tick=0):
    """The pad's stick, pressed so many cells right of and below the middle."""
    mouse = MouseSticks()
    assert mouse.press(MIDDLE[0] + x, MIDDLE[1] + y, PAD, tick)
    return mouse


@pytest.mark.parametrize("size", [(60, 7), (80, 9), (120, 9), (200, 9), (60, 5), (60, 3)])
def test_both_sticks_have_a_middle_cell_and_keep_off_the_edges(size):
    pad = pad_of(*size)
    for box in pad:
        assert box.width % 2 == 1
        assert box.height % 2 == 1
        assert box.x > 1
        assert box.y > 0
        assert box.x + box.width < size[0]
        assert box.y + box.height < size[1]
    assert pad.stick.x + pad.stick.width < pad.turn.x


def test_the_way_of_the_stick():
    assert held().sticks(0, 100) == Sticks()
    assert held(y=-3).sticks(0, 100) == Sticks(forward=1.0)
    assert held(y=3).sticks(0, 50) == Sticks(forward=-0.5)
    assert held(x=-14).sticks(0, 100) == Sticks(left=1.0)
    assert held(x=7).sticks(0, 100) == Sticks(left=-0.5)
    mouse = MouseSticks()
    assert mouse.press(PAD.turn.x, PAD.turn.y, PAD, 0)
    assert mouse.sticks(0, 100) == Sticks(turn=1.0)


def test_dragged_beyond_its_frame_it_stands_at_its_end():
    mouse = held()
    mouse.drag(79, -5, PAD, 10)
    assert mouse.sticks(10, 100) == Sticks(forward=1.0, left=-1.0)


def test_beside_the_sticks_nothing_is_taken():
    mouse = MouseSticks()
    assert not mouse.press(0, 0, PAD, 0)
    mouse.drag(*MIDDLE, PAD, 10)
    assert mouse.sticks(10, 100) == Sticks()


def test_let_go_it_springs_back():
    mouse = held(y=-3)
    mouse.release()
    assert mouse.sticks(1, 100) == Sticks()


def test_a_movement_or_a_proof_of_life_is_worth_120_ms():
    mouse = held(y=-3)
    assert mouse.sticks(119, 100).forward == 1.0
    assert mouse.sticks(120, 100) == Sticks()
    mouse = held(y=-3)
    mouse.drag(*MIDDLE, PAD, 100)
    mouse.alive(200)
    mouse.drag(MIDDLE[0], MIDDLE[1] - 3, PAD, 300)
    assert mouse.sticks(419, 100).forward == 1.0
    assert mouse.sticks(420, 100) == Sticks()


def test_after_a_stall_only_a_new_press_takes_the_stick_again():
    mouse = held(y=-3)
    mouse.alive(130)
    mouse.drag(MIDDLE[0], MIDDLE[1] - 2, PAD, 140)
    assert mouse.sticks(141, 100) == Sticks()
    assert mouse.press(MIDDLE[0], MIDDLE[1] - 3, PAD, 200)
    assert mouse.sticks(201, 100).forward == 1.0


def test_a_button_held_still_for_three_seconds_is_let_go():
    mouse = held(y=-3)
    last = max(tick for tick in range(0, 6000, 50) if (mouse.alive(tick), any(mouse.sticks(tick, 100)))[1])
    assert 3000 <= last < 3120


def mouse_at(app, kind, dx, dy):
    place = app._pad_place
    x, y = place.x + MIDDLE[0] + dx, place.y + MIDDLE[1] + dy
    return kind(None, x, y, 0, 0, 1, False, False, False, screen_x=x, screen_y=y)


def test_m_shows_the_pad_and_dragging_drives_through_the_front_door_until_the_button_comes_up():
    async def steps(app, pilot):
        await pilot.press("m")
        frame(app)
        assert "forward, left" in "\n".join(picture(app.session.scene(), 80, 24))

        async def mouse(kind, dx, dy):
            app.post_message(mouse_at(app, kind, dx, dy))
            await pilot.pause()
            frame(app)
            return app.session.link.latest().sticks

        assert (await mouse(events.MouseDown, 0, -3))[0] > 0.4
        sticks = await mouse(events.MouseMove, 14, 0)
        assert sticks[0] == 0.0
        assert sticks[1] < -0.4
        assert await mouse(events.MouseUp, 14, 0) == (0.0, 0.0, 0.0)
        assert (await mouse(events.MouseDown, 0, -3))[0] > 0.4
        assert await mouse(events.MouseMove, -100, 0) == (0.0, 0.0, 0.0), "it has left the window"
        assert (await mouse(events.MouseDown, 0, -3))[0] > 0.4
        app.post_message(events.AppBlur())
        await pilot.pause()
        frame(app, 11)
        assert app.session.link.latest().sticks == (0.0, 0.0, 0.0)
        assert (await mouse(events.MouseDown, 0, -3))[0] > 0.4
        frame(app, 150)  # the connection stalls: nothing more comes
        assert app.session.link.latest().sticks == (0.0, 0.0, 0.0), "150 ms after the last movement"
        await pilot.press("m")
        frame(app)
        assert app._pad_place is None

    piloted(armed(), steps)
