"""How fast SLCAN text is read: our reader of blocks beside python-can's, from the same pseudo-terminal, in turns.

Another process writes the same frames again and again, motors' feedback as an adapter sends it. Prints the frames a
second of each round and the median of the rounds' ratios; exit status 1 below --least.
"""

from __future__ import annotations

import os
import random
import statistics
import time
import tty

import can
from arguments import above_zero, at_least_one, end_with, parser

from bench.io.serial_port import open_serial
from bench.io.slcan import SlcanReader, encode

SEED = "slcan bar"
FRAMES = 2000
THEIR_FRAMES = 2000
OUR_FRAMES = 200_000


def block() -> bytes:
    """Feedback frames of four ESCs, each with eight bytes."""
    rng = random.Random(SEED)
    return b"".join(encode((0x201 + k % 4, rng.randbytes(8))) for k in range(FRAMES))


def writer(master: int, text: bytes) -> int:
    """A process that fills the pty for ever; its id."""
    child = os.fork()
    if child == 0:
        try:
            while True:
                left = memoryview(text)
                while left:
                    left = left[os.write(master, left) :]
        finally:
            os._exit(0)
    return child


def theirs(device: str) -> float:
    """python-can's frames a second."""
    bus = can.Bus(interface="slcan", channel=device, bitrate=1_000_000, sleep_after_open=0)
    for _ in range(200):
        bus.recv(1)
    start = time.perf_counter()
    got = sum(bus.recv(1) is not None for _ in range(THEIR_FRAMES))
    took = time.perf_counter() - start
    bus.shutdown()
    return got / took


def ours(device: str) -> float:
    """Our frames a second, from the port to decoded frames."""
    port, reader = open_serial("bar", f"serial:{device}"), SlcanReader()
    got = 0
    start = time.perf_counter()
    while got < OUR_FRAMES:
        got += len(reader.feed(port.read()))
    took = time.perf_counter() - start
    port.close()
    return got / took


def main() -> int:
    """Measure in turns."""
    asked = parser(__doc__)
    asked.add_argument("--rounds", type=at_least_one, default=7, metavar="N", help="default 7")
    asked.add_argument("--least", type=above_zero, default=50.0, metavar="X", help="the ratio to reach (default 50)")
    args = asked.parse_args()
    ratios = []
    for _ in range(args.rounds):
        rates = []
        for reader in (theirs, ours):
            master, slave = os.openpty()
            tty.setraw(slave)
            child = writer(master, block())
            rates.append(reader(os.ttyname(slave)))
            os.kill(child, 9)
            os.waitpid(child, 0)
            os.close(master)
            os.close(slave)
        ratios.append(rates[1] / rates[0])
        print(f"python-can {rates[0]:9.0f} frames/s   ours {rates[1]:9.0f} frames/s   ratio {ratios[-1]:.0f}")
    median = statistics.median(ratios)
    print(f"median ratio {median:.0f} of {args.rounds} rounds; load {os.getloadavg()[0]:.1f}; asked for {args.least:g}")
    return 0 if median >= args.least else 1


if __name__ == "__main__":
    end_with(main)
