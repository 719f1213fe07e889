"""A controller of somebody's own, behind the seam: bytes and frames in, frames and bytes out, once a millisecond.

It knows uart12 frames and C610 motors, drives forward and back only, in proportion to the stick, and stops when it has
heard nothing for 60 ms. What a firmware in C would do is the same, behind the same four wires.
"""

import struct

FRAME_START, FRAME_END = 0xAA, 0x55
SILENCE_MS = 60
FULL_STICK_MA = 400
# Front right, rear, front left: forward pulls with the right wheel one way and with the left one the other.
PATTERN = (-1, 0, 1)


class CrawlingBase:
    """One `step` each millisecond; nothing else of it is known to the bench."""

    def __init__(self, robot):
        self._bytes = b""
        self._heard_tick = None
        self._stick = 0.0
        self._armed = False
        self._pressed = False

    def step(self, tick, rc_bytes, slamware_bytes, can_in):
        self._listen(tick, rc_bytes)
        if self._heard_tick is None or tick - self._heard_tick > SILENCE_MS:
            self._armed = False
        current_ma = round(self._stick * FULL_STICK_MA) if self._armed else 0
        currents = [sign * current_ma for sign in PATTERN]
        return ((0x200, struct.pack(">4h", *currents, 0)),), b""

    def _listen(self, tick, rc_bytes):
        self._bytes += rc_bytes
        while len(self._bytes) >= 12:
            if self._bytes[0] != FRAME_START or self._bytes[11] != FRAME_END:
                self._bytes = self._bytes[1:]
                continue
            frame, self._bytes = self._bytes[:12], self._bytes[12:]
            forward_raw = struct.unpack_from(">H", frame, 5)[0]
            pressed = frame[9] != 0
            self._heard_tick = tick
            self._stick = (2048 - forward_raw) / 2048
            if pressed and not self._pressed and abs(self._stick) < 0.05:
                self._armed = not self._armed
            self._pressed = pressed
