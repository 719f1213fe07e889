"""The keys that move something."""

from __future__ import annotations

FORWARD, LEFT, TURN = 0, 1, 2
MOTION = {
    "w": (FORWARD, 1.0), "s": (FORWARD, -1.0), "up": (FORWARD, 1.0), "down": (FORWARD, -1.0),
    "a": (LEFT, 1.0), "d": (LEFT, -1.0), "left": (LEFT, 1.0), "right": (LEFT, -1.0),
    "q": (TURN, 1.0), "e": (TURN, -1.0),
}  # fmt: skip
"""Key -> axis and sense: forward, left and counter-clockwise are positive."""
