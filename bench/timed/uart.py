"""A serial line in time: bytes leave it no faster than its baud rate lets them."""

from __future__ import annotations

from bench.rc.line import Settings

MOST_WAITING_MS = 500
"""A sender's buffer holds what its line carries in so long; what does not fit goes from the front."""
LEAST_WAITING = 64


class Paced:
    """Bytes in, bytes out as a line of these settings carries them. `lost` counts what found no room."""

    def __init__(self, settings: Settings) -> None:
        self.lost = 0
        # In thousandths of a bit, so that no millisecond rounds.
        self._per_byte = 1000 * (9 + settings.even_parity + settings.stop_bits)
        self._per_tick = settings.baud
        self._room = MOST_WAITING_MS * settings.baud // self._per_byte + LEAST_WAITING
        self._credit = 0
        self._waiting = bytearray()

    def put(self, data: bytes) -> int:
        """Queue; how many bytes are lost by that."""
        self._waiting += data
        surplus = max(0, len(self._waiting) - self._room)
        del self._waiting[:surplus]
        self.lost += surplus
        return surplus

    def step(self) -> bytes:
        """What is through at the end of one more millisecond."""
        if not self._waiting:
            self._credit = 0
            return b""
        count, self._credit = divmod(self._credit + self._per_tick, self._per_byte)
        data = bytes(self._waiting[:count])
        del self._waiting[:count]
        return data
