"""Robot files that nobody ships: the odd example of docs/robots.md, and a ring of eight wheels on its body."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[1] / "docs" / "robots.md").read_text()
EXAMPLE = re.search(r"^```toml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE).group(1)


def eight_wheels(count=8):
    """The example on a ring of small wheels, alternately to the left and to the right."""
    rest = EXAMPLE[EXAMPLE.index("[body]") :]
    ring = "".join(
        f'[[wheel]]\nname = "w{i}"\nbearing_deg = {45 * i + 10}\ndistance_m = 0.18\nradius_m = 0.04\ncan_id = {i + 1}\n'
        f"direction = {-1 if i % 2 else 1}\n"
        for i in range(count)
    )
    return EXAMPLE[: EXAMPLE.index("[[wheel]]")] + ring + rest
