"""A bench in real time, in this process: an InlineLink at absolute deadlines, with the ports of a rig between ticks."""

from __future__ import annotations

from collections.abc import Callable

from bench.io.clock import Metronome
from bench.io.link import InlineLink
from bench.io.rig import Rig

MOST_BEHIND_TICKS = 20
"""So many late ticks may run back to back before ports and people are looked after all the same."""


def run_in_real_time(
    link: InlineLink, rig: Rig | None, metronome: Metronome, between: Callable[[], bool] = lambda: False
) -> None:
    """Run to the link's end, or until `between`, asked after each tick that was not late, says so.

    Late ticks run back to back; what they have for a bus leaves at the end of them, the newest of each identifier.
    Raises like `InlineLink.run`, with the ports as they are.
    """
    metronome.restart()
    behind = 0
    while not link.ended:
        metronome.wait()
        link.run(1)
        if rig is not None:
            rig.step()
        if metronome.is_behind and behind < MOST_BEHIND_TICKS:
            behind += 1
            continue
        behind = 0
        if rig is not None:
            rig.flush()
            rig.look(link.now_tick)
        if between():
            return
    if rig is not None:
        rig.flush()
