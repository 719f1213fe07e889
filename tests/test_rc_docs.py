"""docs/rc says what is so: worked frames from outside, both ways, reasons by example, line settings, profiles."""

import doctest
import json
import re
from pathlib import Path

import pytest
from streams import KNOWN_RC

from bench import rc_decode
from bench.config import load_profile, profile_names
from bench.messages import RcFrame, RcNoise
from bench.rc import crsf, dbus, ibus, sbus, uart12

FOLDER = Path(__file__).parents[1] / "docs" / "rc"
DECODERS = {
    "uart12": uart12.Uart12Decoder,
    "sbus": sbus.SbusDecoder,
    "dbus": dbus.DbusDecoder,
    "ibus": ibus.IbusDecoder,
    "crsf": crsf.CrsfDecoder,
}
EVERY = pytest.mark.parametrize("protocol", rc_decode.PROTOCOLS)

FRAME = re.compile(r"<!-- frame: (\S+) (\S+) -->\n```text\n((?:[0-9A-F]{2} ?)+)\n([-\d ]+)\n```")
CHANNEL = re.compile(r"^\| (\d+) \| `([0-9A-F ]+)` \| `([0-9A-Fx&>\- ]+)` \| (-?\d+) \|$", re.MULTILINE)
REASON = re.compile(r"^\| `([a-z]+)` \| .* \| (.*)\|$", re.MULTILINE)
LINE = re.compile(r"(\d+) baud, 8([NE])([12])(, inverted)?")


def page(protocol):
    return (FOLDER / f"{protocol}.md").read_text(encoding="utf-8")


def events_of(protocol, data):
    decoder = rc_decode.decoder(protocol)
    return decoder.feed(data) + decoder.finish()


def worked(protocol):
    """(capture, which of it, bytes, channels) as the page shows them."""
    ((capture, which, raw, channels),) = FRAME.findall(page(protocol))
    return capture, which, bytes.fromhex(raw), tuple(map(int, channels.split()))


def from_outside(capture, which):
    """Bytes and channels of the frame where it comes from: a vector by name, a stream's frame by offset."""
    described = json.loads((KNOWN_RC / f"{capture}.json").read_text(encoding="utf-8"))
    if "vectors" in described:
        (vector,) = (one for one in described["vectors"] if one["id"] == which)
        expect = vector["expect"]
        keys = ("switch_bits_44_45", "switch_bits_46_47", "mouse_x", "mouse_y", "mouse_z", "mouse_left", "mouse_right")
        channels = expect.get("channels") or expect.get("channels_low_12_bits")
        return bytes.fromhex(vector["hex"]), tuple(
            channels or (*expect["ch"], *(expect[key] for key in (*keys, "keys", "wheel_raw")))
        )
    at = int(which)
    firmware = {end - 11: tuple(values) for end, values in described["seed_decoder"]["rows"]}
    return (KNOWN_RC / f"{capture}.bin").read_bytes()[at : at + 12], firmware[at]


@EVERY
def test_the_worked_frame_is_the_one_from_outside_and_goes_both_ways(protocol):
    capture, which, data, channels = worked(protocol)
    assert (data, channels) == from_outside(capture, which)
    (frame,) = events_of(protocol, data)
    assert isinstance(frame, RcFrame)
    assert (frame.length, frame.channels) == (len(data), channels)
    assert rc_decode.encode(protocol, channels) == data


@EVERY
def test_the_channels_worked_by_hand(protocol):
    """The bytes stand in the frame, the number is made of them in the protocol's byte order, and the sum is right."""
    _, _, data, channels = worked(protocol)
    rows = CHANNEL.findall(page(protocol))
    assert len(rows) >= 4
    for channel, raw, expression, value in rows:
        piece = bytes.fromhex(raw)
        assert piece in data
        assert int(expression.split()[0], 16) == int.from_bytes(piece, "big" if protocol == "uart12" else "little")
        assert eval(expression) == int(value) == channels[int(channel)]


def example(text):
    """`AA` 8 × `00` `55` -> bytes."""
    return b"".join(
        bytes.fromhex(raw) * int(count or 1) for count, raw in re.findall(r"(?:(\d+) × )?`([0-9A-F ]+)`", text)
    )


@EVERY
def test_every_reason_has_its_row_and_its_example_is_refused_for_it(protocol):
    rows = dict(REASON.findall(page(protocol)))
    ((said),) = re.findall(r"Reasons of noise: ([^.]+)\.", DECODERS[protocol].__doc__)
    assert set(rows) == set(re.sub(r"\([^)]*\)", "", said).replace(" ", "").split(","))
    for reason, text in rows.items():
        first = events_of(protocol, example(text))[0]
        assert isinstance(first, RcNoise), reason
        assert first.reason == reason


@EVERY
def test_line_settings_are_the_same_everywhere(protocol):
    ((row),) = re.findall(rf"^\| \[{protocol}\].*$", page("README"), re.MULTILINE)
    (own,) = re.findall(r"^\*\*Line:\*\* (.*)$", page(protocol), re.MULTILINE)
    found = LINE.search(own)
    assert found.groups() == LINE.search(row).groups()
    baud, parity, stop_bits, _ = found.groups()
    bits = 1 + 8 + (parity == "E") + int(stop_bits)
    assert DECODERS[protocol].byte_us == pytest.approx(bits / int(baud) * 1e6)
    length = len(rc_decode.encode(protocol, worked(protocol)[3]))
    assert protocol == "crsf" or (f"{length} bytes" in own and f"{length} bytes" in row)


@EVERY
def test_the_profiles_are_those_that_ship(protocol):
    ((row),) = re.findall(rf"^\| \[{protocol}\].*$", page("README"), re.MULTILINE)
    (named,) = re.findall(r"Profiles?: (.*?)(?:\. |\.$|, the default)", page(protocol).replace("\n", " "))
    shipped = {name for name in profile_names() if load_profile(name).protocol == protocol}
    assert set(re.findall(r"`([a-z0-9-]+)`", row)) == shipped
    assert set(re.findall(r"`([a-z0-9-]+)`", named)) == shipped


@pytest.mark.parametrize("name", ["README", "crsf"])
def test_the_python_of_the_page_runs(name):
    blocks = re.findall(r"^```python\n(.*?)^```$", page(name), re.DOTALL | re.MULTILINE)
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, name, str(FOLDER), 0)
    failures = []
    doctest.DocTestRunner(verbose=False).run(test, out=failures.append)
    assert not failures, "".join(failures)
    assert test.examples


def test_there_is_a_page_for_every_protocol_and_no_other():
    assert {path.stem for path in FOLDER.glob("*.md")} == {*rc_decode.PROTOCOLS, "README", "auto"}
    assert set(DECODERS) == set(rc_decode.PROTOCOLS)
