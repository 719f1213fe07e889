"""What is attacked, and what must hold whatever comes in: one function for each decoder, `check(data)`.

`scripts/fuzz.py` drives these with bytes that reach new code, the tests with Hypothesis and with every finding so far.
Each raises AssertionError where a promise is broken, and otherwise says nothing. inputs.py says what `data` means.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from attacks.inputs import HEAD, answer_frame, built, pieces, rc_frame, request_frame, times_us
from bench import rc_decode
from bench.canbus import dm3519
from bench.canbus.table import Family
from bench.check.lines import CAN_LOG, EXPECTED, PARSERS, RC_LOG, SLAMWARE_LOG, STATE_CSV, cell_value
from bench.config import LinkLimits, load_profile, load_robot
from bench.link import DEGRADED, HOLD, LIVE, LOST, NEUTRAL, NEVER_SEEN, RcLink
from bench.m2006 import FAMILY as C610
from bench.messages import RcFrame, RcNoise, RcOther
from bench.motors import emulated_escs, motor_bus
from bench.rc import crsf, sbus
from bench.rc.ibus import IbusDecoder
from bench.slamware.base_side import SlamwareBase
from bench.slamware.core_side import SlamwareCore
from bench.slamware.describe import Conversation, summary
from bench.slamware.framing import FrameDecoder, SlamwareFrame, SlamwareNoise, encode_frame
from bench.slamware.reference_base import reference_facts
from bench.slamware.reference_firmware import ReferenceFirmware
from bench.slamware.senses import Motion

MOST_WAITING = {"uart12": 12, "sbus": 50, "crsf": 90, "ibus": 32, "dbus": 72}
"""Bytes that an RC decoder may hold back: what it must see to judge the first of them."""
FACTS = reference_facts()
STATES = {NEVER_SEEN, LIVE, DEGRADED, HOLD, NEUTRAL, LOST}


class Four(Motion):
    """Wheels for requests that need some."""

    wheel_count = 4


# --- RC ------------------------------------------------------------------------------------------------------------


def wire_of(protocol: str, frame: RcFrame, raw: bytes) -> bytes | None:
    """The bytes that our encoder makes of a decoded frame; None where the protocol says more than a frame holds."""
    if protocol == "sbus":
        flags = {"failsafe": frame.failsafe, "frame_lost": frame.frame_lost}
        return sbus.encode(frame.channels, digital=frame.digital, upper_flags=raw[23] >> 4, footer=raw[24], **flags)
    if protocol == "crsf":
        return crsf.encode(frame.channels, address=raw[0])
    if protocol == "ibus" and any(byte > 0x0F for byte in raw[3:30:2]):
        return None  # a failsafe mark of some channels, or eighteen of them
    return rc_decode.encode(protocol, frame.channels)


def check_rc_events(protocol: str, data: bytes, decoder: Any, events: list[Any]) -> None:
    """Events cover the bytes, in order and without a gap; frames are what they say; the counters agree."""
    at = 0
    for event in events:
        assert event.offset == at, "events leave a gap or overlap"
        assert event.length > 0
        at += event.length
        raw = data[event.offset : at]
        if isinstance(event, RcFrame):
            again = wire_of(protocol, event, raw)
            assert again is None or again == raw, "a frame encodes to other bytes than it was read from"
        elif isinstance(event, RcNoise):
            assert event.length <= 1024
            assert event.reason
        if protocol == "crsf" and not isinstance(event, RcNoise):
            assert crsf.crc8(raw[2:]) == 0
            assert raw[1] == len(raw) - 2
    assert at == len(data), "bytes are missing from the events"
    counters = decoder.counters
    assert counters.frames == sum(isinstance(event, RcFrame) for event in events)
    assert counters.others == sum(isinstance(event, RcOther) for event in events)
    assert sum(counters.noise_events.values()) == sum(isinstance(event, RcNoise) for event in events)
    assert sum(counters.noise_bytes.values()) == sum(event.length for event in events if isinstance(event, RcNoise))


def fed(decoder: Any, protocol: str, data: bytes, cuts: Iterator[tuple[int, int]], times: Any = None) -> list[Any]:
    """Everything a decoder says of a stream in pieces; it never holds back more than it may."""
    events = []
    for start, end in cuts:
        events += decoder.feed(data[start:end], times and times[start:end])
        assert len(decoder._waiting) <= MOST_WAITING[protocol], "holds back more than it needs"
    events += decoder.finish()
    assert not decoder.pending
    assert decoder.feed(b"", 1e12) == [] == decoder.finish()
    return events


def rc(protocol: str, data: bytes) -> None:
    """An RC decoder: covers every byte, whole or in pieces, with times or without."""
    head, line = data[:HEAD].ljust(HEAD, b"\0"), data[HEAD:]
    if head[0] & 1:
        line = built(line, rc_frame(protocol))
    decoder = rc_decode.decoder(protocol)
    events = decoder.feed(line) + decoder.finish()
    check_rc_events(protocol, line, decoder, events)
    # One other way to feed the same bytes each time: what is tried more often finds more.
    way = head[0] >> 1 & 3
    if way == 0:
        assert fed(rc_decode.decoder(protocol), protocol, line, pieces(line, head)) == events, "cutting matters"
    elif way == 1:
        every = ((at, at + 1) for at in range(len(line)))
        assert fed(rc_decode.decoder(protocol), protocol, line, every) == events, "byte by byte matters"
    elif way == 2:
        times = times_us(len(line), head)
        timed = rc_decode.decoder(protocol)
        said = timed.feed(line, times) + timed.finish()
        check_rc_events(protocol, line, timed, said)
        assert fed(rc_decode.decoder(protocol), protocol, line, pieces(line, head), times) == said, "cutting matters"
    else:
        coarse, said = rc_decode.decoder(protocol, pause_us=2000), []
        for start, end in pieces(line, head):
            said += coarse.feed(line[start:end], 1000 * (start // 7))
            said += coarse.feed(b"", 1000 * (start // 7) + head[7] * 20)
        check_rc_events(protocol, line, coarse, said + coarse.finish())
    if head[0] & 16 and protocol == "ibus":
        eighteen = IbusDecoder(eighteen=True)
        said = eighteen.feed(line) + eighteen.finish()
        assert [event[:2] for event in said] == [event[:2] for event in events]
        assert all(len(event.channels) == 18 for event in said if isinstance(event, RcFrame))


LINK_PROFILES = {"uart12": "uart12", "sbus": "frsky-sbus", "crsf": "crossfire", "ibus": "flysky", "dbus": "dr16"}
PROFILES = {protocol: load_profile(name) for protocol, name in LINK_PROFILES.items()}


def link(data: bytes) -> None:
    """A line through its decoder and the link machine: only known states, no command later than its limits allow."""
    head = data[:HEAD].ljust(HEAD, b"\0")
    protocol = rc_decode.PROTOCOLS[head[1] % 5]
    line = built(data[HEAD:], rc_frame(protocol))
    decoder = rc_decode.decoder(protocol, pause_us=2000)
    machine = RcLink(PROFILES[protocol], LinkLimits())
    last_good, tick = None, 0
    for start, end in pieces(line, head):
        for _ in range(1 + head[4 + start % 4] % 7 * (head[0] >> 2)):
            tick += 1
            before = machine.frames
            state = machine.step(tick, decoder.feed(line[start:end] if start < end else b"", 1000 * tick))
            start = end
            if machine.frames > before:
                last_good = tick
            assert state in STATES
            assert (state == NEVER_SEEN) == (last_good is None)
            if last_good is not None:
                age = tick - last_good
                assert machine.age_ticks(tick) == age
                assert state != LIVE or age <= 99
                assert state not in (LIVE, HOLD, DEGRADED) or age < 100
                assert (state == LOST) == (age >= 500)
                assert machine.reason or state == LIVE


# --- SLAMWARE ------------------------------------------------------------------------------------------------------


def slamware(data: bytes) -> None:
    """The framing in both ways of reading damage, and everything that explains a frame."""
    head, line = data[:HEAD].ljust(HEAD, b"\0"), data[HEAD:]
    if head[0] & 1:
        line = built(line, request_frame if head[0] & 2 else answer_frame)
    rescan = bool(head[0] & 8)
    most = (258, 300, 513, 1024)[head[7] & 3]
    decoder = FrameDecoder(rescan=rescan, max_bytes=most)
    events = decoder.feed(line) + decoder.finish()
    at = 0
    for event in events:
        assert event.offset == at, "events leave a gap or overlap"
        assert event.length > 0
        at += event.length
        if isinstance(event, SlamwareFrame):
            assert encode_frame(event.code, event.payload, event.type) == line[event.offset : at]
        else:
            assert event.reason in ("flag", "length", "checksum", "oversize", "stalled")
    # An oversize frame that is refused whole counts with what it announced.
    ends_in_oversize = bool(events) and isinstance(events[-1], SlamwareNoise) and events[-1].reason == "oversize"
    assert at == len(line) or (not rescan and ends_in_oversize and at > len(line)), "bytes are missing"
    cut, said = FrameDecoder(rescan=rescan, max_bytes=most), []
    for start, end in pieces(line, head):
        said += cut.feed(line[start:end], 7)
        assert len(cut._rest) < most, "holds more than its longest frame"
    assert said + cut.finish() == events, "cutting matters"
    timed, tick = FrameDecoder(rescan=rescan, max_bytes=most), 0
    for start, end in pieces(line, head):
        tick += head[4 + start % 3]
        timed.feed(line[start:end], tick)
        assert len(timed._rest) < most
    talk, asked = Conversation(), b""
    for event in events:
        assert talk.describe(event)["event"] in ("frame", "noise")
        assert isinstance(summary(event, asked), str)
        asked = event.payload if isinstance(event, SlamwareFrame) else b""


def base(data: bytes) -> None:
    """Our base: never raises, its answers are clean frames, and reads of one tick may be cut anywhere."""
    head, line = data[:HEAD].ljust(HEAD, b"\0"), data[HEAD:]
    if head[0] & 1:
        line = built(line, request_frame)
    whole, cut = SlamwareBase(FACTS, Four()), SlamwareBase(FACTS, Four())
    answers = whole.receive(line, 5)
    assert answers == b"".join(cut.receive(line[start:end], 5) for start, end in pieces(line, head)), "cutting matters"
    decoder = FrameDecoder(rescan=False, max_bytes=1024)
    events = decoder.feed(answers) + decoder.finish()
    assert all(isinstance(event, SlamwareFrame) for event in events), "an answer is no frame"
    timed, tick = SlamwareBase(FACTS, Four()), 0
    for start, end in pieces(line, head):
        tick += head[4 + start % 3]
        timed.receive(line[start:end], tick)
        timed.alive(tick)
    assert len(timed.requests) <= 256
    assert len(timed.errors) <= 16


def firmware(data: bytes) -> None:
    """The vendor's base as it is: whatever comes, it answers or does not, and never raises."""
    head, line = data[:HEAD].ljust(HEAD, b"\0"), data[HEAD:]
    if head[0] & 1:
        line = built(line, request_frame)
    whole, cut = ReferenceFirmware(FACTS, Four()), ReferenceFirmware(FACTS, Four())
    answers = whole.receive(line, 5)
    assert answers == b"".join(cut.receive(line[start:end], 5) for start, end in pieces(line, head)), "cutting matters"
    busy = ReferenceFirmware(FACTS, Four(), bytes_per_look=1 + head[7] % 64)
    for start, end in pieces(line, head):
        busy.receive(line[start:end], start)


def core(data: bytes) -> None:
    """Our core: whatever the base says, it goes on asking, one request at a time, in frames."""
    head, line = data[:HEAD].ljust(HEAD, b"\0"), data[HEAD:]
    if head[0] & 1:
        line = built(line, answer_frame)
    master, tick, sent = SlamwareCore(), 0, b""
    for start, end in pieces(line, head):
        for _ in range(1 + head[4 + start % 3] % 60):
            sent += master.step(tick, line[start:end] if start < end else b"")
            start, tick = end, tick + 1
    assert sent or not line
    said = FrameDecoder().feed(sent)
    assert said or not line
    assert all(isinstance(event, SlamwareFrame) or event.reason == "flag" for event in said), "a request is no frame"


# --- CAN and files -------------------------------------------------------------------------------------------------

ROBOTS = tuple(load_robot(name) for name in ("m2006", "dm3519"))
FAMILIES: tuple[Family, ...] = (
    C610,
    *(dm3519.family(20.0, feedback, clear) for feedback in dm3519.FEEDBACK_VARIANTS for clear in dm3519.CLEAR_VARIANTS),
)


def can(data: bytes) -> None:
    """Any frame at both ends of the motor bus: nothing raises, currents stay in range, what is decoded encodes."""
    ends = [(motor_bus(robot), emulated_escs(robot)) for robot in ROBOTS]
    at = tick = 0
    while at + 2 <= len(data):
        head, length = data[at], data[at + 1] % 10
        can_id = (0x200 + head % 16, 0x1FF, 0x700, 0x7FF, head * 8)[head >> 5 if head >> 5 < 4 else 4 * (head & 1)]
        payload = data[at + 2 : at + 2 + length]
        at += 2 + length
        for family in FAMILIES:
            family.describe(can_id, payload)
            message = family.message(can_id, len(payload))
            values = message.decode(payload) if message else None
            if message and values is not None and not message.outside(values):
                again = message.encode(values)
                assert message.decode(again) == values
                assert again == payload or not message.exact
        number = dm3519.cleared_esc(can_id, payload)
        if number is not None:
            assert payload in {dm3519.clear_error(number, one)[1] for one in dm3519.CLEAR_VARIANTS}
        frames = ((can_id, payload),) * (1 + (head & 1))
        tick += head & 3
        for bus, escs in ends:
            bus.receive(tick, frames)
            currents = escs.receive(tick, frames)
            assert all(-21.0 <= one <= 21.0 for one in currents)
            assert all(len(sent) == 8 for _, sent in bus.command([one * 3.0 for one in currents]))
            escs.feedback([1.0] * 4, [2.0] * 4, currents)


def lines(data: bytes) -> None:
    """A line of a recording: read or refused, and what is read is what was written."""
    for name in (CAN_LOG, RC_LOG, SLAMWARE_LOG, STATE_CSV):
        for line in re.split(rb"[\n]", data):
            entry = PARSERS[name](line)
            if entry is not None:
                tick, wire, content = entry
                assert tick >= 0
                assert wire
                assert isinstance(content, bytes)
                assert content or name == CAN_LOG, "only a CAN frame may be empty"
    assert EXPECTED
    cell_value(data.decode("utf-8", "replace"))


TARGETS: dict[str, Callable[[bytes], None]] = {
    **{protocol: (lambda data, protocol=protocol: rc(protocol, data)) for protocol in rc_decode.PROTOCOLS},  # type: ignore[misc]
    "slamware": slamware,
    "base": base,
    "firmware": firmware,
    "core": core,
    "can": can,
    "link": link,
    "lines": lines,
}
"""What can be attacked, by name."""

ORDER = ("sbus", "crsf", "uart12", "slamware", "ibus", "dbus", "base", "can", "link", "core", "firmware", "lines")
"""The same, the ones first whose protocols promise least."""
