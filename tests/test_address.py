"""Address strings: every wire's, what they mean, and what a wrong one is told."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.errors import UsageError
from bench.io.address import can_address, serial_address
from bench.io.can_port import open_can
from bench.io.serial_port import open_serial
from bench.rc.line import Settings


def test_serial_lines():
    assert serial_address("--rc", "sim:").is_sim
    assert serial_address("--rc", "pty:").kind == "pty"
    assert serial_address("--rc", "pty:/tmp/rc").place == "/tmp/rc"
    device = serial_address("--rc", "serial:/dev/ttyUSB0?baud=100000&format=8E2")
    assert (device.place, device.settings) == ("/dev/ttyUSB0", Settings(100_000, True, 2))
    assert serial_address("--rc", "serial:/dev/ttyUSB0").settings is None, "what the wire speaks decides"
    socket = serial_address("--rc", "socket://192.168.4.1:23")
    assert (socket.place, socket.port) == ("192.168.4.1", 23)
    assert serial_address("--rc", "socket://[::1]:23").place == "::1"
    assert serial_address("--rc", "listen://127.0.0.1:5000").kind == "listen"
    assert serial_address("--rc", "listen://0.0.0.0:5000?remote=yes").place == "0.0.0.0"


def test_can_buses():
    assert can_address("--can", "sim:").is_sim
    slcan = can_address("--can", "can:slcan:/dev/ttyACM0@500000")
    assert (slcan.bitrate, slcan.line.place) == (500_000, "/dev/ttyACM0")
    assert can_address("--can", "can:slcan:/dev/ttyACM0").bitrate == 1_000_000, "the motors'"
    assert can_address("--can", "can:slcan:socket://127.0.0.1:5000@1000000").line.port == 5000
    assert can_address("--can", "can:slcan:pty:").line.kind == "pty"
    assert can_address("--can", "can:socketcan:can0").bitrate is None, "the system has set it"
    pcan = can_address("--can", "can:pcan:PCAN_USBBUS1@1000000?auto_reset=yes&state=2&name=a")
    assert (pcan.channel, pcan.bitrate) == ("PCAN_USBBUS1", 1_000_000)
    assert pcan.options == {"auto_reset": True, "state": 2, "name": "a"}
    six = can_address("--can", "can:udp_multicast:ff15::1?port=5000")
    assert (six.channel, six.options["port"]) == ("ff15::1", 5000)


def test_what_can_leave_the_machine_has_to_be_asked_for():
    assert can_address("--can", "can:udp_multicast:239.0.0.1").options["hop_limit"] == 0
    assert can_address("--can", "can:udp_multicast:239.0.0.1?remote=yes").options["hop_limit"] == 1
    for text in ("can:udp_multicast:239.0.0.1?hop_limit=3", "can:udp_multicast:239.0.0.1?remote=maybe"):
        with pytest.raises(UsageError):
            can_address("--can", text)
    for host in ("0.0.0.0", "[::]", "192.168.0.3", "bench.local"):
        with pytest.raises(UsageError, match="remote=yes"):
            serial_address("--rc", f"listen://{host}:5000")


@pytest.mark.parametrize(
    ("text", "harmless"),
    [
        ("sim:", True),
        ("can:virtual:x", True),
        ("can:udp_multicast:239.0.0.1", False),
        ("can:udp_multicast:239.0.0.1?remote=yes", False),
        ("can:slcan:/dev/ttyACM0", False),
        ("can:slcan:pty:", False),
        ("can:socketcan:can0", False),
        ("can:socketcan:vcan0", False),
    ],
)
def test_which_buses_may_have_a_motor(text, harmless):
    assert can_address("--can", text).is_harmless == harmless


@pytest.mark.parametrize(
    ("text", "tells"),
    [
        ("/dev/ttyUSB0", "try serial:/dev/ttyUSB0"),
        ("", "expected sim:"),
        ("tty:", "did you mean pty?"),
        ("seriall:/dev/x", "did you mean serial?"),
        ("serial:", "names no device"),
        ("serial:/dev/x?baud=fast", "expected a number"),
        ("serial:/dev/x?baud=0", "expected a number"),
        ("serial:/dev/x?format=9Q1", "8N1, 8N2, 8E1, 8E2"),
        ("serial:/dev/x?bauds=9600", "did you mean baud?"),
        ("serial:/dev/x?baud", "key=value"),
        ("serial:/dev/x?baud=1&baud=2", "twice"),
        ("socket://127.0.0.1", "HOST:PORT"),
        (f"socket://{'a' * 64}:5000", "no host can have this name"),
        ("listen://a..b:5000?remote=yes", "no host can have this name"),
        ("socket://127.0.0.1:0", "HOST:PORT"),
        ("socket://127.0.0.1:99999", "HOST:PORT"),
        ("socket:127.0.0.1:5000", "HOST:PORT"),
        ("socket://127.0.0.1:5000?x=1", "remote=yes"),
        ("can:virtual:x", "is a CAN bus"),
    ],
)
def test_wrong_serial_addresses(text, tells):
    with pytest.raises(UsageError) as told:
        serial_address("--rc", text)
    assert tells in str(told.value)
    assert str(told.value).startswith(f"--rc {text}: ")


@pytest.mark.parametrize(
    ("text", "tells"),
    [
        ("can0", "expected sim:"),
        ("can:can0", "expected sim:"),
        ("can::can0", "expected sim:"),
        ("can:virtual:", "names no channel"),
        ("can:virtual:@1000000", "names no channel"),
        ("can:slcan:/dev/x@fast", "expected a bitrate"),
        ("can:slcan:/dev/x@9", "expected a bitrate"),
        ("can:slcan:/dev/x?ttyBaudrate=1", "takes no ?ttyBaudrate="),
        ("can:slcan:sim:", "hangs on a serial line"),
        ("can:slcan:COM3", "expected pty:, serial:"),
        ("can:udp_multicast:239.74.163.2?port=99999", "port=99999: expected 1 to 65534"),
        ("can:udp_multicast:239.74.163.2?port=-1", "port=-1: expected 1 to 65534"),
        ("can:udp_multicast:239.74.163.2?port=fast", "port=fast: expected 1 to 65534"),
        ("can:udp_multicast:239.74.163.2?port=yes", "port=True: expected 1 to 65534"),
        ("can:udp_multicast:239.74.163.2?remote=yes&hop_limit=256", "hop_limit=256: expected 0 to 255"),
        ("can:udp_multicast:239.74.163.2?hop_limit=far&remote=yes", "hop_limit=far: expected 0 to 255"),
        ("pty:", "expected sim:"),
    ],
)
def test_wrong_can_addresses(text, tells):
    with pytest.raises(UsageError) as told:
        can_address("--can", text)
    assert tells in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    "text", ["sim:", "sim", "simm:", "can0", "can::can0", "can:virtual:", "tty:", "", "can:slcan:x"]
)
def test_a_wire_that_leaves_the_process_is_offered_none_that_stays_in_it(text):
    for opens in (open_can, open_serial):
        with pytest.raises(UsageError) as told:
            opens("address", text)
        _, expected, kinds = str(told.value).partition("expected ")
        assert expected
        assert "sim:" not in kinds


STARTS = ("", "can:slcan:", "can:udp_multicast:", "serial:", "socket://", "pty:", "listen://")


@given(st.text(max_size=40) | st.builds(str.__add__, st.sampled_from(STARTS), st.text("/:@?=&a1.[]+%", max_size=20)))
def test_any_text_is_an_address_or_a_sentence(text):
    for read in (serial_address, can_address):
        with suppress(UsageError):
            assert read("--wire", text).text in (text, "sim:")
