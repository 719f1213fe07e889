"""The vendor's frames (fixtures/known/slamware), as the tests read them, and the robot that was around its base."""

import json
import math
import re
from pathlib import Path
from typing import Any, NamedTuple

from bench.slamware.reference_base import ReferenceWheels
from bench.slamware.sense_payloads import Beacons, Power
from bench.slamware.senses import Senses

PATH = Path(__file__).parent.parent / "fixtures" / "known" / "slamware" / "vendor-frames.jsonl"

LINES: list[dict[str, Any]] = [json.loads(line) for line in PATH.read_text(encoding="utf-8").splitlines()]
BY_NAME = {line["name"]: line for line in LINES}


class Exchange(NamedTuple):
    """A request and all that came back, or (request None) a single answer."""

    name: str
    run: str | None
    lines: list[dict[str, Any]]

    @property
    def request(self) -> bytes | None:
        return bytes.fromhex(self.lines[0]["hex"]) if self.lines[0]["seq"] == 0 else None

    @property
    def answers(self) -> bytes:
        return b"".join(bytes.fromhex(line["hex"]) for line in self.lines if line["seq"])

    def fact(self, key: str) -> Any:
        """A key of any of its lines, the answer's first."""
        return next((line[key] for line in reversed(self.lines) if key in line), None)


def frame(name: str) -> bytes:
    return bytes.fromhex(BY_NAME[name]["hex"])


def _grouped() -> list[Exchange]:
    found: dict[str, Exchange] = {}
    for line in LINES:
        found.setdefault(line["exchange"], Exchange(line["exchange"], line.get("run"), [])).lines.append(line)
    return list(found.values())


EXCHANGES = _grouped()


def exchanges(run: str) -> list[tuple[str, bytes, bytes]]:
    """(name, request, all answers) of one boot of the reference base, in order."""
    return [(each.name, each.request or b"", each.answers) for each in EXCHANGES if each.run == run]


class VendorRobot(Senses):
    """What surrounded the reference base, set by the sentences that the capture has of it."""

    def __init__(self) -> None:
        super().__init__()
        self.wheels = ReferenceWheels(self)
        self.tick = 0
        self.base: Any = None
        self._ranges_mm = [0, 0, 0, 0]
        self._contacts = [False] * 6  # left, right, four cliff sensors
        self._seen = (0, 0, 0)
        self._turned = (0, 0)

    def power(self):
        return self.battery

    def ranges_m(self):
        return [range_mm / 1000 for range_mm in self._ranges_mm]

    def contacts(self):
        return self._contacts

    def beacons(self):
        return Beacons(3, self._seen)

    def ask(self, exchange: Exchange) -> bytes:
        """Set what its setup says, 50 ms after the last exchange, and send the request."""
        self.tick += 50
        for sentence in exchange.fact("setup"):
            self._set(sentence)
        gap = exchange.fact("inter_byte_gap_ms")
        if gap is None:
            return self.base.receive(exchange.request, self.tick)
        answers = b""
        for byte in exchange.request:
            answers += self.base.receive(bytes((byte,)), self.tick)
            self.tick += gap
        return answers

    def _set(self, sentence: str) -> None:
        for pattern, act in _SENTENCES:
            if match := re.match(pattern, sentence):
                act(self, *match.groups())
                return
        raise AssertionError(f"nobody knows what {sentence!r} asks for")

    def _battery(self, percent: str, rest: str) -> None:
        on_dock = rest == ", charging on the dock"
        self.battery = Power(int(percent), charging=on_dock, on_dock=on_dock)

    def _turn_since_boot(self, left: str, right: str) -> None:
        if not any(self._turned):  # each further sentence of the run tells of the same edges
            self._turned = (int(left), int(right))
            self.wheels.turn(*self._turned)

    def _turn(self, left: str, right: str) -> None:
        self.wheels.turn(int(left), int(right))

    def _press(self, side: str) -> None:
        self._contacts[("left", "right").index(side)] = True

    def _release(self) -> None:
        self._contacts[:2] = [False, False]

    def _drop(self, number: str) -> None:
        self._contacts[2 + int(number)] = True

    def _see(self, *pairs: str) -> None:
        names = ("left", "main", "right")
        seen = dict(zip(pairs[0::2], pairs[1::2], strict=True))
        self._seen = tuple(1 << names.index(seen[receiver]) for receiver in names)

    def _ultrasound(self, numbers: str) -> None:
        self._ranges_mm = [int(number) for number in numbers.split(", ")]

    def _lift(self) -> None:
        self.wheels.lifted_status = 4

    def _queue(self, code: str) -> None:
        self.base.ask_core(int(code, 16))

    def _drive_for(self, total_ms: str) -> None:
        if total_ms == "440":
            self._drove_from = self.tick - 50
        self.tick = self._drove_from + int(total_ms)

    def _be_silent(self, ms: str) -> None:
        self.tick += int(ms) - 50

    def _nothing(self, *ignored: str) -> None:
        pass


_SENTENCES = [
    (r"fresh boot", VendorRobot._nothing),
    (r"battery (\d+) %(.*)", VendorRobot._battery),
    (r"(\d+) encoder edges left, (\d+) right .* since boot", VendorRobot._turn_since_boot),
    (r"(\d+) edges left, (\d+) right since the previous reply", VendorRobot._turn),
    (r"no edges since the previous reply", VendorRobot._nothing),
    (r"(left|right) bumper pressed", VendorRobot._press),
    (r"bumper released", VendorRobot._release),
    (r"cliff sensor (\d) reports a drop", VendorRobot._drop),
    (r"no dock beacon visible", VendorRobot._nothing),
    (
        r"receiver (\w+) sees the (\w+) beacon, receiver (\w+) the (\w+) beacon, receiver (\w+) the (\w+) beacon",
        VendorRobot._see,
    ),
    (r"ultrasonic channels 0\.\.3 read (.*) mm", VendorRobot._ultrasound),
    (r"left wheel-drop switch open", VendorRobot._lift),
    (r"the base has queued request (0x\w+)", VendorRobot._queue),
    (r"request acknowledged", VendorRobot._nothing),
    (r"about (\d+) ms of driving", VendorRobot._drive_for),
    (r"then (\d+) ms of complete silence", VendorRobot._be_silent),
    (r"still stopped", VendorRobot._nothing),
]


def without_undefined(exchange: Exchange, answers: bytes) -> bytes:
    """The answers with the bytes zeroed that are uninitialised memory in the reference base, and their checksum."""
    offsets = exchange.fact("undefined_payload_offsets")
    if offsets is None:
        return answers
    data = bytearray(answers)
    for offset in offsets:
        data[4 + offset] = 0
    data[-1] = 0
    for byte in data[:-1]:
        data[-1] ^= byte
    return bytes(data)


def displacement_of(exchange: Exchange) -> tuple[float, float, float]:
    """What a single dead-reckoning answer was made from."""
    given = exchange.fact("input")
    if given is not None:
        return given["dx_m"], given["dy_m"], given["dtheta_rad"]
    raw = [int.from_bytes(exchange.answers[4 + i : 8 + i], "little", signed=True) for i in (0, 4, 8)]
    # the middle of what is cut to this value
    dx, dy, dtheta = ((value + math.copysign(0.5, value) if value else 0.0) / 65536 for value in raw)
    return dx / 1000, dy / 1000, math.radians(dtheta)
