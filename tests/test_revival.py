"""Lost, and tried again at most every half second (docs/ports.md): a thing that is there or not, a clock by hand."""

import pytest

from bench.io import revival
from bench.io.revival import Revivable

HALF_S = 500_000_000


class Cable(Revivable):
    """In or out; `tries` counts how often somebody looked."""

    def __init__(self):
        super().__init__("not looked for yet")
        self.plugged, self.tries, self.released = False, 0, 0

    def _open(self):
        self.tries += 1
        if not self.plugged:
            raise FileNotFoundError(2, "No such file or directory")

    def _release(self):
        self.released += 1


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now_ns = 7 * HALF_S

    monkeypatch.setattr(revival, "now_ns", lambda: Clock.now_ns)
    return Clock


def test_it_is_looked_for_at_once_and_then_every_half_second(clock):
    cable = Cable()
    assert (cable.revive(), cable.tries, cable.lost) == (False, 1, "No such file or directory")
    cable.plugged = True
    clock.now_ns += HALF_S - 1
    assert (cable.revive(), cable.tries) == (False, 1), "not before"
    clock.now_ns += 1
    assert (cable.revive(), cable.tries, cable.lost, cable.losses) == (True, 2, "", 0)
    assert (cable.revive(), cable.tries) == (True, 2), "what is there is not opened again"


def test_what_is_lost_is_let_go_counted_and_left_alone_for_half_a_second(clock):
    cable = Cable()
    cable.plugged = True
    assert cable.revive()
    clock.now_ns += 10 * HALF_S
    cable._lose("pulled")
    assert (cable.lost, cable.losses, cable.released) == ("pulled", 1, 1)
    assert (cable.revive(), cable.lost, cable.tries) == (False, "pulled", 1)
    clock.now_ns += HALF_S
    assert (cable.revive(), cable.losses) == (True, 1)


def test_only_what_opening_may_raise_is_a_loss(clock):
    class Broken(Cable):
        def _open(self):
            raise ZeroDivisionError("a bug")

    with pytest.raises(ZeroDivisionError):
        Broken().revive()


@pytest.mark.parametrize(
    ("error", "said"),
    [(OSError(5, "Input/output error"), "Input/output error"), (OSError("gone"), "gone"), (OSError(), "OSError")],
)
def test_a_loss_always_has_a_reason(clock, error, said):
    """An error without words would leave `lost` empty, and an empty `lost` says that all is well."""

    class Mute(Cable):
        def _open(self):
            raise error

    cable = Mute()
    assert not cable.revive()
    assert cable.lost == said


def test_a_kind_that_does_not_say_how_it_is_opened_cannot_be_made():
    class Half(Revivable):
        def _release(self):
            pass

    with pytest.raises(TypeError, match="_open"):
        Half()
