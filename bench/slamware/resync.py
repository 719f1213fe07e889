"""How a core brings a base back whose receiver waits for the rest of a frame that will never come.

    quiet   say nothing until the line has been quiet for longer than the longest answer takes
    fill    send filler until any answer comes, at most as much as the largest frame lacks     nothing came -> gave up
    settle  quiet again: the answers to the rest of the filler
    sync    SYNC with bytes of its own; only when it comes back identical is the line in order  else -> gave up

A base that drops partial frames by itself needs none of this and is none the worse for it. The reference base waits for
ever: only filler ends its frame. Source: behaviour of SLAMTEC's base reference firmware of 2018-11-20, executed.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.messages import TICK_US
from bench.slamware.framing import STANDARD, SYNC, SlamwareEvent, SlamwareFrame, encode_frame

QUIET_TICKS = 40_000 // TICK_US
"""The longest answer of the reference base takes 27 ms."""
SYNC_TICKS = 100_000 // TICK_US
PIECE = bytes(16)
"""Filler is zeros: no frame starts with one. 16 of them take 1.4 ms."""
PIECE_TICKS = 10_000 // TICK_US
FILLER_BYTES = 528
"""The largest frame that the reference base takes has 513."""

RUNNING, DONE, GAVE_UP = "running", "done", "gave up"


class Resync:
    """One attempt. `step` once a tick with what came; sends what it returns while its state is "running"."""

    def __init__(self, tick: int, number: int) -> None:
        self.state = RUNNING
        self._phase = self._quiet
        self._since_tick = tick
        self._heard_tick = tick
        self._sent_bytes = 0
        # Different each time, so that a late copy cannot pass for this one; no byte that could start a frame.
        self._sync = (STANDARD, SYNC, bytes((0xA5, 0x80 | number & 0x0F, 0x5A)))

    def step(self, tick: int, heard: bool, events: Sequence[SlamwareEvent]) -> bytes:
        """Bytes to send in this tick. `heard`: whether any byte came, a frame or not."""
        if heard:
            self._heard_tick = tick
        return self._phase(tick, events)

    def _is_quiet(self, tick: int) -> bool:
        return tick - max(self._heard_tick, self._since_tick) >= QUIET_TICKS

    def _quiet(self, tick: int, events: Sequence[SlamwareEvent]) -> bytes:
        if not self._is_quiet(tick):
            return b""
        self._phase = self._fill
        return self._next_piece(tick)

    def _fill(self, tick: int, events: Sequence[SlamwareEvent]) -> bytes:
        if any(isinstance(event, SlamwareFrame) for event in events):
            self._phase = self._settle
            self._since_tick = tick
            return b""
        if tick - self._since_tick < PIECE_TICKS:
            return b""
        if self._sent_bytes >= FILLER_BYTES:
            self.state = GAVE_UP
            return b""
        return self._next_piece(tick)

    def _next_piece(self, tick: int) -> bytes:
        self._since_tick = tick
        self._sent_bytes += len(PIECE)
        return PIECE

    def _settle(self, tick: int, events: Sequence[SlamwareEvent]) -> bytes:
        if not self._is_quiet(tick):
            return b""
        self._phase = self._wait_for_sync
        self._since_tick = tick
        kind, code, filler = self._sync
        return encode_frame(code, filler, kind)

    def _wait_for_sync(self, tick: int, events: Sequence[SlamwareEvent]) -> bytes:
        for event in events:
            if isinstance(event, SlamwareFrame) and (event.type, event.code, event.payload) == self._sync:
                self.state = DONE
                return b""
        if tick - self._since_tick >= SYNC_TICKS:
            self.state = GAVE_UP
        return b""
