"""Every exchange of the vendor's own code, byte for byte, in the behaviour it belongs to: ours, or the vendor's."""

import pytest
from slamware_vendor import EXCHANGES, VendorRobot, displacement_of, frame, without_undefined

from bench.slamware import FrameDecoder, SlamwareBase, SlamwareCore, encode_frame
from bench.slamware.commands import DIALECTS
from bench.slamware.reference_base import reference_facts
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.senses import Motion, Senses

CHECKSUM = bytes.fromhex("50 03 00 03 40 00 10")
FORMAT = bytes.fromhex("50 03 00 03 01 80 D1")

# What the reference base answers and ours does not: its marker bit in checksum errors, and two defects.
OURS_INSTEAD = {
    "err-checksum-std": CHECKSUM,
    "keep-bad-checksum": CHECKSUM,
    "resync-by-filler": CHECKSUM,
    "quirk-len0": FORMAT,
    "quirk-no-sub": FORMAT,
}
# Worked out by the reference base in single precision: ours has the same within its last digits.
SINGLE_PRECISION = {"dr2-straight", "dr3-left-arc", "dr4-reverse", "dr5-spin-right"}
ASKED = [exchange for exchange in EXCHANGES if exchange.request is not None]
SINGLE_ANSWERS = [exchange for exchange in EXCHANGES if exchange.request is None]
DEAD_RECKONED = [exchange for exchange in SINGLE_ANSWERS if exchange.name.startswith("dr-")]
AS_STANDARD_FRAME = [exchange for exchange in SINGLE_ANSWERS if exchange.name.startswith("std-answer")]


def robot_before(exchange, behaviour):
    """A freshly booted base after all that this run had before the exchange."""
    robot = VendorRobot()
    robot.base = behaviour(reference_facts(), robot.wheels, robot)
    for earlier in EXCHANGES:
        if earlier is exchange:
            return robot
        if earlier.run == exchange.run:
            robot.ask(earlier)
            robot.wheels.targets_mmps(robot.base.alive(robot.tick))
    raise AssertionError(exchange.name)


def names(exchanges):
    return [exchange.name for exchange in exchanges]


@pytest.mark.parametrize("exchange", ASKED, ids=names(ASKED))
def test_as_reference_firmware(exchange):
    robot = robot_before(exchange, ReferenceFirmware)
    assert robot.ask(exchange).hex() == without_undefined(exchange, exchange.answers).hex()
    targets = exchange.fact("wheel_targets_mm_s")
    if targets is not None:
        assert robot.wheels.targets_mmps(robot.base.alive(robot.tick)) == (targets["left"], targets["right"])


@pytest.mark.parametrize("exchange", ASKED, ids=names(ASKED))
def test_as_our_base(exchange):
    robot = robot_before(exchange, SlamwareBase)
    got = robot.ask(exchange)
    expected = OURS_INSTEAD.get(exchange.name, without_undefined(exchange, exchange.answers))
    if exchange.name not in SINGLE_PRECISION:
        assert got.hex() == expected.hex()
        return
    assert (got[:4], got[16], len(got)) == (expected[:4], expected[16], len(expected))
    for i in (4, 8, 12):
        ours, vendors = (int.from_bytes(data[i : i + 4], "little", signed=True) for data in (got, expected))
        assert abs(ours - vendors) <= 2


class Moved(Motion):
    def __init__(self, displacement, status):
        self.displacement = displacement
        self.bits = status

    def take_increment(self):
        return self.displacement

    def status(self):
        return self.bits


@pytest.mark.parametrize("exchange", DEAD_RECKONED, ids=names(DEAD_RECKONED))
@pytest.mark.parametrize("behaviour", [SlamwareBase, ReferenceFirmware])
def test_single_dead_reckoning_answers_from_what_they_were_made_of(exchange, behaviour):
    answers = exchange.answers
    later = len(answers) == 22
    facts = reference_facts()._replace(dialect=DIALECTS["sdk-2020" if later else "firmware-2018"])
    base = behaviour(facts, Moved(displacement_of(exchange), answers[16]), Senses())
    halt = encode_frame(0xF8, b"\x41" + bytes(12))
    base.receive(halt, 0)
    got = base.receive(halt, 123456 if later else 50)
    if exchange.name == "dr-omni-big" and behaviour is SlamwareBase:
        # The vendor's single precision moves in steps of 128 here, ours does not.
        for i in (4, 8, 12):
            ours, vendors = (int.from_bytes(data[i : i + 4], "little", signed=True) for data in (got, answers))
            assert abs(ours - vendors) <= 128
    else:
        assert got.hex() == answers.hex()


@pytest.mark.parametrize("exchange", AS_STANDARD_FRAME, ids=names(AS_STANDARD_FRAME))
def test_answers_that_come_as_standard_frames(exchange):
    """No base of ours sends them; the frame can be built, and a core takes it."""
    (event,) = FrameDecoder().feed(exchange.answers)
    assert encode_frame(event.code, event.payload, "standard") == exchange.answers
    core = SlamwareCore()
    core.step(0, b"")
    core.step(1, frame("connect-std.reply"))
    asked = 0x41
    if exchange.name == "std-answer-empty":
        asked = 0x60
        core.request(bytes.fromhex("6063"))
    tick = 2 if asked == 0x60 else 50
    assert core.step(tick, b"")[3] == asked
    assert core.step(tick + 1, exchange.answers) == b""
    if exchange.name == "std-answer-error":
        assert core.errors == {0x8001: 1}
    else:
        assert core.answers == {0x10: 1, asked: 1}
    assert core.unexpected == core.timeouts == core.noise_bytes == 0


def test_none_is_left_out():
    assert len(EXCHANGES) == 86
    assert len([exchange for exchange in EXCHANGES if exchange.lines[0]["normative"]]) == 78
    tested = {exchange.name for exchange in (*ASKED, *DEAD_RECKONED, *AS_STANDARD_FRAME)}
    assert tested == {exchange.name for exchange in EXCHANGES}
    assert (len(ASKED), len(DEAD_RECKONED), len(AS_STANDARD_FRAME)) == (75, 8, 3)
    assert tested >= OURS_INSTEAD.keys() | SINGLE_PRECISION
