"""Which protocol a file of bytes holds; and where none of ours is in it, which mistake is likely.

First the simple answer: every decoder gets the bytes, and the one that finds the greatest share in good frames wins, if
its frames prove enough. Then what goes wrong at a bench, from the certain to the likely: a text, a dead line, a
protocol that we know but do not speak, a port that dropped bytes, a port with wrong settings (`misread`), bits turned
over or reversed. What fits nothing is described and left at that: a false name costs more than none.
"""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from bench import rc_decode
from bench.messages import RcFrame, RcLinkStatistics, RcNoise
from bench.rc import foreign, misread
from bench.rc.line import Settings
from bench.slamware.framing import FrameDecoder, SlamwareFrame

CAN = "can"
"""A log of a CAN bus."""
JUDGED_BYTES = 64 * 1024
"""Only so much of a file is looked at."""
LEAST_SHARE = 0.25
"""Of the bytes that must be in good frames. Random bytes reach 0.06 (slamware, which has short frames and 8 bits)."""
_SLAMWARE_SHARE = 0.5
_LEAST_BITS = 28
"""What the frames together must prove. One SBUS frame is too little, one of uart12 is enough."""
_FRAME_BITS = {"uart12": 40, "sbus": 18, "dbus": 18, "ibus": 32, "crsf": 29, "slamware": 20}
"""By what chance a frame is none: headers, trailers, checksums, bits that are always 0; slamware a little favoured."""
_GUESS_GAIN, _LIKELY_GAIN = 9.0, 16.0
"""Bits a frame by which a wrong port must explain the bytes better than chance; 84 ports are tried, which costs 6."""
_LEAST_LEAD = 8.0
"""Bits a frame that lie between the best and the best of another protocol."""
_TURNED_SHARE = 0.8
_FEW_BYTES = 24
_NAMES = {"uart12": "uart12", "sbus": "SBUS", "dbus": "DBUS", "ibus": "i-BUS", "crsf": "CRSF", "slamware": "SLAMWARE"}
_RATES = "100000 8E2 inverted (SBUS, DBUS), 115200 (i-BUS 8N1, uart12 8E2), 420000 8N1 (CRSF)"
_CANDUMP = re.compile(rb"\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#")
_UART12_LIKE = re.compile(rb"\xaa.{10}\x55", re.DOTALL)
_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_COMPLEMENT = bytes(255 - byte for byte in range(256))


class Verdict(NamedTuple):
    """What a file holds."""

    protocol: str | None
    """The name that `wheelbench decode` takes, or `CAN`; None where nothing can be decoded."""
    text: str
    """One or two sentences for people: what was seen, or the likely mistake and what to try."""


class Score(NamedTuple):
    """What one decoder found."""

    protocol: str
    frames: int
    share: float
    """Of all bytes, those in good frames."""

    @property
    def enough(self) -> bool:
        """Whether this names the protocol."""
        least_share = _SLAMWARE_SHARE if self.protocol == "slamware" else LEAST_SHARE
        return self.share >= least_share and self.frames * _FRAME_BITS[self.protocol] >= _LEAST_BITS


def recognise(data: bytes, times_us: Sequence[float] | None = None) -> Verdict:
    """The verdict on a file's bytes, with the time of each where they are known. Never raises on bytes."""
    data = data[:JUDGED_BYTES]
    times_us = times_us[:JUDGED_BYTES] if times_us is not None else None
    return _plain(data) or _ours(data, times_us) or _mistake(data) or Verdict(None, _unknown(data, times_us))


def scores(data: bytes, times_us: Sequence[float] | None = None) -> list[Score]:
    """What each of our decoders finds in the bytes, the greatest share first."""
    found = [_rc_score(protocol, data, times_us) for protocol in rc_decode.PROTOCOLS]
    return sorted((*found, _slamware_score(data)), key=lambda score: -score.share)


def _rc_score(protocol: str, data: bytes, times_us: Sequence[float] | None) -> Score:
    decoder = rc_decode.decoder(protocol)
    events = [event for event in decoder.feed(data, times_us) + decoder.finish() if not isinstance(event, RcNoise)]
    frames = sum(isinstance(event, RcFrame | RcLinkStatistics) for event in events)
    return Score(protocol, frames, sum(event.length for event in events) / max(1, len(data)))


def _slamware_score(data: bytes) -> Score:
    decoder = FrameDecoder()
    frames = [event for event in decoder.feed(data) + decoder.finish() if isinstance(event, SlamwareFrame)]
    return Score("slamware", len(frames), sum(frame.length for frame in frames) / max(1, len(data)))


# --- what needs no decoder -----------------------------------------------------------------------------------------


def _plain(data: bytes) -> Verdict | None:
    """No bytes, one value only, a text, a CAN log."""
    if not data:
        return Verdict(
            None,
            "the file is empty: nothing came through the port. Look at wiring, ground and the receiver's supply,"
            " and whether another program holds the port.",
        )
    if len(set(data)) == 1 and len(data) > 1:
        return Verdict(
            None,
            f"all {len(data)} bytes are 0x{data[0]:02X}: no signal, but a line that is stuck, or a port that reads"
            " pauses. Look at wiring and ground, and whether the line idles the other way round (inverted).",
        )
    if is_can_log(data):
        return Verdict(
            CAN, "a CAN log: read as that of C610 motors. Those of DM3519 use the same identifiers: decode dm3519 FILE"
        )
    return _text(data)


def _text(data: bytes) -> Verdict | None:
    try:
        words = data.decode("ascii").split()
    except UnicodeDecodeError:
        return None
    if not all(byte >= 0x20 or byte in b"\t\n\r\f" for byte in data) or 0x7F in data:
        return None
    if words and all(re.fullmatch(r"(0x)?([0-9A-Fa-f]{2})+,?", word) for word in words):
        return Verdict(
            None, "this is a hex dump, not the bytes themselves. Turn it back into bytes first, with: xxd -r -p FILE"
        )
    return Verdict(
        None,
        "this is a text, not the raw bytes of a line. Record the bytes as they come (cat PORT > FILE, port in raw"
        " mode); a port that sends text is another device, or another port.",
    )


def is_can_log(data: bytes) -> bool:
    """Whether it begins as candump's logs do."""
    return _CANDUMP.match(data.lstrip()) is not None


# --- our protocols -------------------------------------------------------------------------------------------------


def _ours(data: bytes, times_us: Sequence[float] | None) -> Verdict | None:
    best, second, *_ = scores(data, times_us)
    if best.enough:
        after = f"next is {second.protocol} with {_percent(second.share)}" if second.share else "no other finds a frame"
        return Verdict(best.protocol, f"{best.protocol}: {_percent(best.share)} of the bytes in good frames; {after}")
    like = _UART12_LIKE.findall(data)
    if len(like) >= 4 and 12 * len(like) >= len(data) / 2:
        return Verdict(
            "uart12",
            f"uart12 by header and trailer ({_percent(12 * len(like) / len(data))} of the bytes), but its fields are"
            " beyond 4095: no 12-bit converter sends that",
        )
    if best.share == 1.0 or (best.frames and len(data) < _FEW_BYTES + 12):
        return Verdict(
            None,
            f"{len(data)} bytes are too few to tell. What there is would do as {best.protocol}:"
            f" try wheelbench decode {best.protocol}, or record a second of it.",
        )
    return None


# --- likely mistakes -----------------------------------------------------------------------------------------------


def _mistake(data: bytes) -> Verdict | None:
    text = _foreign(data) or _dropped(data)
    if text is None:
        port = _port(data)
        guess = port is not None and not port.proves_the_line_only and port.gain < _LIKELY_GAIN
        # Turned back, bytes that repeat themselves look like SBUS here and there: only a guess weighs less.
        text = (guess and _turned(data)) or (port and _misread(port)) or _turned(data)
    if text:
        return Verdict(None, text)
    if len(data) < _FEW_BYTES:
        return Verdict(None, f"{len(data)} bytes are too few to tell anything. Record at least a second.")
    return None


def _foreign(data: bytes) -> str | None:
    best_share, name = max((foreign.share(key, data), name) for key, name in foreign.PROTOCOLS.items())
    if best_share < LEAST_SHARE or best_share * len(data) < 32:
        return None
    return (
        f"looks like {name}: {_percent(best_share)} of the bytes in its frames. It is not decoded here;"
        f" set the receiver to one of {', '.join(rc_decode.PROTOCOLS[1:])}."
    )


def _turned(data: bytes) -> str | None:
    both = bytes(map(_REVERSED.__getitem__, _COMPLEMENT))
    for table, what, advice in (
        (_COMPLEMENT, "each byte complemented", "turn every byte over (255 - byte), or take the inversion out again"),
        (_REVERSED, "the bits of each byte reversed", "record with the lowest bit first"),
        (both, "each byte complemented and its bits reversed", "record with the lowest bit first, and not inverted"),
    ):
        best = scores(data.translate(table))[0]
        if best.enough and best.share >= _TURNED_SHARE:
            name, good = _NAMES[best.protocol], _percent(best.share)
            return f"{name} with {what}: turned back, {good} of the bytes are good frames. To mend: {advice}."
    return None


def _dropped(data: bytes) -> str | None:
    """Half of the bytes may be missing: where only those came through whose parity bit looks like a stop bit."""
    values = Counter(data)
    odd = sum(count for byte, count in values.items() if byte.bit_count() % 2)
    # A value proves itself once, however often it comes; and of any twelve values half should be even.
    if len(data) < 64 or len(values) < 16 or odd < len(data):
        return None
    return (
        "every byte has an odd number of ones: looks like a line with even parity on a port without it, which dropped"
        " half of the bytes as framing errors. Set the port to 8E2, or make it keep such bytes."
    )


def _port(data: bytes) -> misread.Explanation | None:
    """The wrong port that explains the bytes, if there is one and no other protocol comes near it."""
    found = [one for one in misread.search(data) if one.gain >= _GUESS_GAIN]
    if not found:
        return None
    best = found[0]
    rivals = [one for one in found if one.shape.protocol != best.shape.protocol]
    frame_bytes = best.looked_at / len(best.readings)
    if rivals and (best.density - rivals[0].density) * frame_bytes < _LEAST_LEAD:
        return None
    return best


def _misread(best: misread.Explanation) -> str:
    right, name = best.shape.settings, _NAMES[best.shape.protocol]
    port = _wrong(right, best.reader)
    if best.proves_the_line_only:
        return f"looks like a line at {right}, as {name} has it, through a port {port}. Read it at {right}."
    what = f"{name} ({right}) through a port {port}"
    if best.gain < _LIKELY_GAIN:
        return f"cannot tell for certain, but it may be {what}: a guess. Read it at {right} and see."
    return (
        f"looks like {what}: {_percent(best.share)} of the bytes are what it would make of {name} frames."
        f" Read it at {right}."
    )


def _wrong(right: Settings, reader: Settings) -> str:
    """What is wrong about a port. Its parity is only named where nothing else is: it often makes no difference."""
    faults = []
    if reader.inverted != right.inverted:
        faults.append("that does not invert" if right.inverted else "that inverts")
    if reader.baud != right.baud:
        faults.append(f"at {reader.baud} baud")
    if not faults:
        faults.append("with parity" if reader.even_parity else "without parity")
    return " and ".join(faults)


# --- nothing fits --------------------------------------------------------------------------------------------------


def _unknown(data: bytes, times_us: Sequence[float] | None) -> str:
    byte, count = Counter(data).most_common(1)[0]
    seen = [
        f"{len(data)} bytes, {len(set(data))} different ones, most often 0x{byte:02X} ({_percent(count / len(data))})",
        *_period(data),
        *(_bursts(times_us) if times_us is not None else ()),
    ]
    return f"cannot tell: {', '.join(seen)}. Try the port's settings one by one: {_RATES}."


def _period(data: bytes, longest: int = 96) -> list[str]:
    """After how many bytes they repeat themselves, if they do."""
    data = data[:8192]
    constant = sum((count / len(data)) ** 2 for count in Counter(data).values())
    for period in range(2, min(longest, len(data) // 4) + 1):
        same = sum(map(int.__eq__, data, data[period:])) / (len(data) - period)
        if same > 0.6 and same > constant + 0.2:
            return [f"repeating every {period}"]
    return []


def _bursts(times_us: Sequence[float]) -> list[str]:
    """From start to start of what lies between pauses of a millisecond."""
    starts = [later for earlier, later in pairwise(times_us) if later - earlier > 1000]
    gaps = [later - earlier for earlier, later in pairwise(starts)]
    return [f"a burst every {statistics.median(gaps) / 1000:.1f} ms"] if len(gaps) >= 3 else []


def _percent(part: float) -> str:
    """Never 100 % where a byte is missing, never 0 % where there is one."""
    whole = round(100 * part)
    if whole == 100 and part < 1:
        return "99 %"
    return f"{whole} %" if whole or not part else "less than 1 %"
