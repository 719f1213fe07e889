"""What a bench gets wrong, simulated forward: frames on a line at the right settings, read by a port at wrong ones.

As a program it prints how often `recognise` names the protocol and the mistake, for every mistake and 20 streams:

    python tests/misreadings.py [SEEDS]
"""

import random
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

from streams import walking_sticks

from bench import rc_decode
from bench.rc.line import Settings, read, write
from bench.rc.recognise import recognise

# From the fact sheet, not from the code under test.
LINES = {
    "uart12": (Settings(115_200, True, 2, False), 10_000),
    "sbus": (Settings(100_000, True, 2, True), 9_000),
    "dbus": (Settings(100_000, True, 1, True), 14_000),
    "ibus": (Settings(115_200, False, 1, False), 7_000),
    "crsf": (Settings(420_000, False, 1, False), 4_000),
}
NAMES = {"uart12": "uart12", "sbus": "SBUS", "dbus": "DBUS", "ibus": "i-BUS", "crsf": "CRSF"}
BAUDS = (9_600, 57_600, 100_000, 115_200, 230_400, 420_000)
REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


class Mistake(NamedTuple):
    """One way to read a protocol, and the words that its name must have."""

    protocol: str
    label: str
    reader: Settings
    words: tuple[str, ...]
    """All of them in the verdict's text: named right. Empty: the bytes must decode."""
    turn: str = ""
    drops: bool = False


def frames(protocol: str, seed: int, count: int = 60) -> list[bytes]:
    """Four sticks that wander; the other channels stand where a radio might have them."""
    rng = random.Random(f"{protocol} {seed}")
    name = f"{protocol}-{seed}"
    if protocol == "uart12":
        rows = [[*row, rng.randrange(50) == 0, 0] for row in walking_sticks(name, count, 2048, 4095)]
    elif protocol == "dbus":
        switches, dial = [rng.choice((1, 2, 3)), rng.choice((1, 2, 3))], rng.choice((0, 1024))
        rows = [
            [*(max(364, min(1684, raw)) for raw in row), *switches, *[0] * 6, dial]
            for row in walking_sticks(name, count, 1024, 1684)
        ]
    elif protocol == "ibus":
        rest = [rng.choice((1000, 1500, 2000)) for _ in range(10)]
        rows = [[*(max(1000, raw) for raw in row), *rest] for row in walking_sticks(name, count, 1500, 2000)]
    else:
        rest = [rng.choice((172, 992, 1024, 1811, 0)) for _ in range(12)]
        rows = [[*row, *rest] for row in walking_sticks(name, count, rng.choice((992, 1024)), 1811)]
    return [rc_decode.encode(protocol, row) for row in rows]


def misread(protocol: str, seed: int, reader: Settings, count: int = 60, drops: bool = False, **how: float) -> bytes:
    """The bytes that a port makes of the stream, opened somewhere in it; `drops`: but not those with framing errors."""
    settings, period_us = LINES[protocol]
    signal = write([(k * period_us, frame) for k, frame in enumerate(frames(protocol, seed, count), 1)], settings)
    received = read(signal, reader, **how)
    opened = random.Random(seed).randrange(len(received) // 20)
    return bytes(one.byte for one in received[opened:] if one.stop_bit or not drops)


def mistakes(protocol: str) -> Iterator[Mistake]:
    """What the brief of a bench's day holds, from nothing wrong to much."""
    right, _ = LINES[protocol]
    named = f" {NAMES[protocol]} "
    turned = "that does not invert" if right.inverted else "that inverts"
    other = right._replace(inverted=not right.inverted)
    yield Mistake(protocol, "nothing wrong", right, ())
    yield Mistake(protocol, "complemented", right, (f"{NAMES[protocol]} with each byte complemented:",), "complement")
    yield Mistake(protocol, "bits reversed", right, (f"{NAMES[protocol]} with the bits of each byte",), "reverse")
    yield Mistake(protocol, "inversion wrong", other, (named, turned))
    for baud in BAUDS:
        if baud != right.baud:
            yield Mistake(protocol, f"{baud} baud", right._replace(baud=baud), (named, f"at {baud} baud"))
    plain = Settings(115_200)
    if right.inverted:
        yield Mistake(protocol, "115200 8N1, no inverter", plain, (named, turned, "at 115200 baud"))
    if right.even_parity:
        yield Mistake(protocol, "8N1, errors kept", right._replace(even_parity=False), ())
        yield Mistake(
            protocol, "8N1, errors dropped", right._replace(even_parity=False), ("with even parity",), "", True
        )
    else:
        yield Mistake(protocol, "8E1", right._replace(even_parity=True), (named, "with parity"))
    if protocol == "crsf":
        yield Mistake(protocol, "416666 baud", right._replace(baud=416_666), ())
        yield Mistake(protocol, "400000 baud", right._replace(baud=400_000), ())


def data_of(mistake: Mistake, seed: int, **how: float) -> bytes:
    """The file that somebody would have who makes this mistake."""
    data = misread(mistake.protocol, seed, mistake.reader, drops=mistake.drops, **how)
    if mistake.turn == "complement":
        return bytes(255 - byte for byte in data)
    return data.translate(REVERSED) if mistake.turn == "reverse" else data


def outcome(mistake: Mistake, seed: int, **how: float) -> str:
    """right, unsure or wrong."""
    verdict = recognise(data_of(mistake, seed, **how))
    if verdict.protocol is not None:
        return "right" if verdict.protocol == mistake.protocol else "wrong"
    if mistake.words and all(word in verdict.text for word in mistake.words):
        return "right"
    return "unsure" if verdict.text.startswith("cannot tell: ") or "too few" in verdict.text else "wrong"


def row(mistake: Mistake, seeds: int) -> str:
    """One line of the table, with what was said where it was wrong."""
    outcomes = Counter(outcome(mistake, seed) for seed in range(seeds))
    counts = "".join(f"{outcomes[name]:8}" for name in ("right", "unsure", "wrong"))
    wrong = next((seed for seed in range(seeds) if outcomes["wrong"] and outcome(mistake, seed) == "wrong"), None)
    said = f"   seed {wrong}: {recognise(data_of(mistake, wrong)).text}" if wrong is not None else ""
    return f"{mistake.protocol:8}{mistake.label:28}{counts}{said}"


def main() -> None:
    """Print the table."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    table = [mistake for protocol in LINES for mistake in mistakes(protocol)]
    print(f"{'':36}{'right':>8}{'unsure':>8}{'wrong':>8}")
    with ProcessPoolExecutor() as pool:
        for line in pool.map(row, table, [seeds] * len(table)):
            print(line, flush=True)


if __name__ == "__main__":
    main()
