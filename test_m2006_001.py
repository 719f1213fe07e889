"""m2006: 1.975 s

Saved from the dashboard. Replays the inputs of goldens/m2006-001 and compares every frame and every row.
"""

from pathlib import Path

from bench.__main__ import main

GOLDEN = Path(__file__).parent / "goldens" / "m2006-001"


def test_m2006_001_is_as_it_was():
    assert main(["replay", str(GOLDEN)]) == 0, f"see what differs: wheelbench replay {GOLDEN}"
