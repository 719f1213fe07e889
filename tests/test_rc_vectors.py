"""Single frames from receivers, publications and other projects' tests: exact values, and what must be refused."""

import json

import pytest
from streams import KNOWN_RC, sbus_frame

from bench import rc_decode
from bench.messages import RcFrame, RcLinkStatistics, RcNoise, RcOther
from bench.rc import crsf, ibus, sbus


def vectors(protocol):
    described = json.loads((KNOWN_RC / f"vectors-{protocol}-1.json").read_text(encoding="utf-8"))
    return [pytest.param(vector, id=vector["id"]) for vector in described["vectors"]]


def decode(protocol, data):
    decoder = rc_decode.decoder(protocol)
    return decoder.feed(data) + decoder.finish()


@pytest.mark.parametrize("vector", vectors("sbus"))
def test_sbus_vector(vector):
    data, expect = bytes.fromhex(vector["hex"]), vector["expect"]
    digital = bool(expect["ch17"]), bool(expect["ch18"])
    frame = sbus_frame(0, tuple(expect["channels"]), bool(expect["failsafe"]), bool(expect["frame_lost"]), digital)
    assert decode("sbus", data) == [frame]
    options = {"upper_flags": expect["upper_flag_bits"], "footer": expect["footer"]}
    assert data == sbus.encode(expect["channels"], frame.failsafe, frame.frame_lost, digital, **options)
    if not any(options.values()):
        assert data == rc_decode.encode("sbus", expect["channels"], frame.failsafe, frame.frame_lost, digital)


@pytest.mark.parametrize("vector", vectors("crsf"))
def test_crsf_vector(vector):
    data, expect = bytes.fromhex(vector["hex"]), vector["expect"]
    events = decode("crsf", data)
    if not expect["valid"]:
        assert events
        assert not [event for event in events if not isinstance(event, RcNoise)]
        return
    length = len(data)
    if "channels" in expect:
        assert events == [RcFrame(0, length, tuple(expect["channels"]))]
        assert data == crsf.encode(expect["channels"], address=expect["address"])
    elif "link" in expect:
        link = expect["link"]
        rssi_dbm = link["up_rssi_2_dbm"] if link["antenna"] else link["up_rssi_1_dbm"]
        assert events == [RcLinkStatistics(0, length, link["up_lq"], rssi_dbm, link["up_snr_db"])]
    else:
        (other,) = events
        assert isinstance(other, RcOther)
        assert (other.offset, other.length) == (0, length)
    assert data == crsf.encode_frame(expect["type"], data[3:-1], address=expect["address"])


@pytest.mark.parametrize("vector", vectors("ibus"))
def test_ibus_vector(vector):
    data, expect = bytes.fromhex(vector["hex"]), vector["expect"]
    events = decode("ibus", data)
    if vector["id"] == "telemetry-discovery":
        assert events == [RcOther(0, 4, "poll 0x81")]
    elif vector["id"] == "eighteen-channels":
        # Its second byte is not that of a real link; with that byte, all eighteen come out where they are asked for.
        assert not [event for event in events if isinstance(event, RcFrame)]
        on_a_link = b"\x20\x40" + data[2:30] + (int.from_bytes(data[30:], "little") - 0x40).to_bytes(2, "little")
        decoder = ibus.IbusDecoder(eighteen=True)
        assert decoder.feed(on_a_link) == [RcFrame(0, 32, tuple(expect["channels_18"]))]
    elif expect.get("checksum_ok"):
        channels, failsafe = tuple(expect["channels_low_12_bits"]), 0xC in expect["high_nibbles"]
        assert events == [RcFrame(0, 32, channels, failsafe)]
        if not failsafe:
            assert rc_decode.encode("ibus", channels) == data
    else:
        assert events
        assert not [event for event in events if not isinstance(event, RcNoise)]


@pytest.mark.parametrize("vector", vectors("dbus"))
def test_dbus_vector(vector):
    data, expect = bytes.fromhex(vector["hex"]), vector["expect"]
    events = decode("dbus", data)
    if not expect["plausible"]:
        assert events == [RcNoise(0, 18, "range")]
        return
    channels = (
        *expect["ch"],
        *(expect[key] for key in ("switch_bits_44_45", "switch_bits_46_47", "mouse_x", "mouse_y", "mouse_z")),
        *(expect[key] for key in ("mouse_left", "mouse_right", "keys", "wheel_raw")),
    )
    assert events == [RcFrame(0, 18, channels)]
    assert rc_decode.encode("dbus", channels) == data


@pytest.mark.parametrize("protocol", ["sbus", "crsf"])
def test_all_vectors_of_a_protocol_laid_end_to_end(protocol):
    """Nothing is said about silence between them, and a frame without its last byte is one of CRSF's."""
    described = [vector.values[0] for vector in vectors(protocol)]
    data = b"".join(bytes.fromhex(vector["hex"]) for vector in described)
    frames = [
        (vector["offset"], tuple(vector["expect"]["channels"]))
        for vector in described
        if "channels" in vector["expect"] and vector["expect"].get("valid", True)
    ]
    found = [(e.offset, e.channels) for e in decode(protocol, data) if isinstance(e, RcFrame)]
    assert found == frames


def test_a_crsf_frame_decodes_behind_junk():
    """As esp-fc tests it."""
    vector = next(v.values[0] for v in vectors("crsf") if v.id == "esp-fc-1")
    data = bytes.fromhex("a104c509") + bytes.fromhex(vector["hex"])
    assert decode("crsf", data) == [RcNoise(0, 4, "header"), RcFrame(4, 26, tuple(vector["expect"]["channels"]))]


def test_an_sbus_frame_decodes_behind_a_zero():
    """As zklapow/sbus publishes its stream."""
    vector = next(v.values[0] for v in vectors("sbus") if v.id == "zklapow-1")
    data = b"\x00" + bytes.fromhex(vector["hex"])
    assert decode("sbus", data) == [
        RcNoise(0, 1, "header"),
        sbus_frame(1, vector["expect"]["channels"], digital=(True, True)),
    ]


# Document 004's frame, with the words of the reference page.
def test_uart12_frame_by_hand():
    data = bytes.fromhex("aa 0800 0800 0400 0c00 01 00 55")
    assert decode("uart12", data) == [RcFrame(0, 12, (2048, 2048, 1024, 3072, 1, 0))]
    assert rc_decode.encode("uart12", (2048, 2048, 1024, 3072, 1, 0)) == data
