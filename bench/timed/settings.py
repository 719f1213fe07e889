"""How long things take on a run's wires: the `[wires]` table of a scenario.

    [wires]                     # the CAN bus and the serial lines take their time
    can_bitrate = 1000000       # a multiple of 1000, up to 1,000,000
    slamware_baud = 115200      # 8N1; the RC line runs as its protocol's makers have it
    also = ["0x205:1000"]       # other nodes on the bus: identifier and frames a second, 8 bytes each

Without the table what is sent in a millisecond arrives in it, however much it is.
"""

from __future__ import annotations

from dataclasses import dataclass

from bench.config import Table

CAN_BITRATE, SLAMWARE_BAUD = 1_000_000, 115_200
BITRATE_STEP, LEAST_BITRATE, MOST_BITRATE = 1000, 10_000, 1_000_000
"""So that a millisecond is a whole number of bits."""
BAUDS = 1200, 4_000_000
MOST_HZ = 1000


@dataclass(frozen=True, slots=True)
class Wires:
    """`can_bitrate` 0 is off: nothing takes time. `also` holds (identifier, frames a second) of other nodes."""

    can_bitrate: int = 0
    slamware_baud: int = SLAMWARE_BAUD
    also: tuple[tuple[int, int], ...] = ()

    @property
    def is_on(self) -> bool:
        """Whether anything takes time."""
        return self.can_bitrate > 0

    @property
    def also_text(self) -> str:
        """The other nodes as run.toml and a command line say them; empty where there are none."""
        return " ".join(f"{can_id:#05x}:{hz}" for can_id, hz in self.also)


UNTIMED = Wires()


def read_wires(data: Table) -> Wires:
    """The settings of a `[wires]` table. Raises ConfigError."""
    bitrate: int = data.get("can_bitrate", int, CAN_BITRATE)
    if not LEAST_BITRATE <= bitrate <= MOST_BITRATE or bitrate % BITRATE_STEP:
        raise data.fail("can_bitrate", f"expected {LEAST_BITRATE} to {MOST_BITRATE} in whole thousands, got {bitrate}")
    baud: int = data.get("slamware_baud", int, SLAMWARE_BAUD)
    if not BAUDS[0] <= baud <= BAUDS[1]:
        raise data.fail("slamware_baud", f"expected {BAUDS[0]} to {BAUDS[1]}, got {baud}")
    texts: list[str] = data.get("also", list, [])
    try:
        also = tuple(node_of(text) for text in texts)
    except ValueError as error:
        raise data.fail("also", str(error)) from None
    data.refuse_rest()
    return Wires(bitrate, baud, also)


def node_of(text: object) -> tuple[int, int]:
    """'0x205:1000' -> (0x205, 1000). Raises ValueError with what was expected."""
    if isinstance(text, str):
        can_id, _, hz = text.partition(":")
        try:
            node = int(can_id, 16), int(hz)
        except ValueError:
            node = -1, 0
        if 0 <= node[0] <= 0x7FF and 1 <= node[1] <= MOST_HZ:
            return node
    raise ValueError(f'expected an identifier and frames a second (1 to {MOST_HZ}), like "0x205:1000", got {text!r}')
