"""Write the RC stream of the demo: bench/demo/drive.bin with its drive.json, from the stick positions below.

A person's drive, made by hand: sticks move in ramps, never quite still (a few counts of jitter from a named seed), and
for 1.2 s no frame arrives. Run it after changing the timeline, then pin the demo's golden anew (docs/goldens.md).
"""

import hashlib
import json
import random
from pathlib import Path

from arguments import end_with, parser

from bench.config import load_profile
from bench.rc.transmitter import Sticks, Transmitter

DEMO = Path(__file__).parents[1] / "bench" / "demo"
SECONDS = 27.0
SEED = 4
BYTE_US = 104.17  # 8 data bits, even parity, 2 stop bits at 115200 baud

# From when on the sticks are held where: forward, left, counter-clockwise. Between two lines they move for 0.15 s.
HELD = [
    (0.0, (0.0, 0.0, 0.0)),
    (0.4, (0.5, 0.0, 0.0)),  # before arming nothing may move
    (0.7, (0.0, 0.0, 0.0)),
    (1.5, (0.45, 0.0, 0.0)),  # forward
    (3.5, (0.0, 0.0, 0.0)),
    (3.8, (0.0, -0.40, 0.0)),  # strafe right
    (5.6, (0.0, 0.0, 0.0)),
    (5.9, (0.0, 0.0, 0.80)),  # spin
    (7.5, (0.0, 0.0, 0.0)),
    (7.8, (0.40, 0.0, -0.50)),  # a curve to the right
    (10.0, (0.0, 0.0, 0.0)),
    (10.3, (0.30, -0.30, 0.60)),  # all three mixed
    (12.4, (0.0, 0.0, 0.0)),  # hands off: the core's leg
    (19.0, (0.45, 0.0, 0.0)),  # forward into the link loss
    (21.5, (0.0, 0.0, 0.0)),
    (23.0, (0.45, 0.0, 0.0)),  # field-centric: field forward, whichever way the robot looks
    (24.3, (-0.45, 0.0, 0.2)),
    (25.6, (0.0, 0.0, 0.0)),
]
MOVE_S = 0.15
AUX1_S = [(1.0, 1.12), (21.9, 22.02), (26.5, 26.62)]  # arm, re-arm, disarm
AUX2_S = [(22.5, 22.62)]
SILENT_S = (19.7, 20.9)


def sticks_at(t_s: float) -> Sticks:
    """Where the hands are at this time."""
    now = max(i for i, (start, _) in enumerate(HELD) if start <= t_s)
    start, held = HELD[now]
    before = HELD[now - 1][1] if now else held
    share = min(1.0, (t_s - start) / MOVE_S)
    forward, left, turn = (old + (new - old) * share for old, new in zip(before, held, strict=True))
    return Sticks(
        forward,
        left,
        turn,
        aux1=any(a <= t_s < b for a, b in AUX1_S),
        aux2=any(a <= t_s < b for a, b in AUX2_S),
    )


def main() -> int:
    """Write the two files."""
    parser(__doc__).parse_args()
    jitter = random.Random(SEED)
    transmitter = Transmitter(load_profile("uart12"))
    data, bursts = bytearray(), []
    for tick in range(round(SECONDS * 1000)):
        t_s = tick / 1000
        sticks = sticks_at(t_s)
        shaken = sticks._replace(
            forward=sticks.forward + jitter.uniform(-0.002, 0.002),
            left=sticks.left + jitter.uniform(-0.002, 0.002),
            turn=sticks.turn + jitter.uniform(-0.002, 0.002),
        )
        frame = transmitter.step(tick, shaken)
        if frame and not SILENT_S[0] <= t_s < SILENT_S[1]:
            bursts.append([len(data), tick * 1000.0])
            data += frame
    DEMO.mkdir(exist_ok=True)
    (DEMO / "drive.bin").write_bytes(data)
    about = {
        "format": "rc-capture/1",
        "name": "drive",
        "bin": "drive.bin",
        "length": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "protocol": "uart12",
        "origin": "constructed by scripts/make_demo.py",
        "serial": {"baud": 115200, "data_bits": 8, "parity": "even", "stop_bits": 2, "inverted_on_wire": False},
        "timing": {
            "kind": "per burst",
            "unit": "us",
            "byte_us": BYTE_US,
            "columns": ["offset of first byte", "time the burst starts"],
            "rows": bursts,
        },
    }
    (DEMO / "drive.json").write_text(json.dumps(about) + "\n", encoding="utf-8")
    print(f"{len(bursts)} frames, {len(data)} bytes, {SECONDS:g} s -> {DEMO / 'drive.bin'}")
    return 0


if __name__ == "__main__":
    end_with(main)
