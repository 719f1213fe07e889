"""The serial line: what is written at some settings is read at the same ones, and known faults at others."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.rc.line import Settings, byte_bits, read, write

SETTINGS = st.builds(
    Settings, st.sampled_from([9_600, 100_000, 115_200, 420_000]), st.booleans(), st.sampled_from([1, 2]), st.booleans()
)


def bytes_of(received):
    return bytes(one.byte for one in received)


def test_a_byte_on_the_line_as_the_books_draw_it():
    # 'A' is 0x41: start 0, then 1 0 0 0 0 0 1 0, two ones so even parity 0, stop 1.
    assert byte_bits(0x41, Settings(9_600)) == [0, 1, 0, 0, 0, 0, 0, 1, 0, 1]
    assert byte_bits(0x41, Settings(9_600, True, 2)) == [0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1]
    assert str(Settings(100_000, True, 2, True)) == "100000 8E2 inverted"


def test_the_signal_of_one_byte():
    signal = write([(1000.0, b"\x55")], Settings(1_000_000))
    assert signal.idle == 1
    assert signal.edges_us == pytest.approx([1000 + k for k in range(10)])
    assert [signal.level(at) for at in (999, 1000.5, 1001.5, 1009.5, 2000)] == [1, 0, 1, 1, 1]
    assert write([(1000.0, b"\x55")], Settings(1_000_000, inverted=True)).idle == 0


@given(st.lists(st.binary(min_size=1, max_size=8), max_size=4), SETTINGS, st.floats(0, 1 / 16))
def test_the_right_port_reads_what_was_written(bursts, settings, late_bits):
    byte_us = 12e6 / settings.baud
    signal = write([(k * 20 * byte_us, data) for k, data in enumerate(bursts)], settings)
    received = read(signal, settings, late_bits)
    assert bytes_of(received) == b"".join(bursts)
    assert all(one.stop_bit for one in received)


@given(st.binary(min_size=1, max_size=20))
def test_a_port_without_parity_gets_every_byte_of_a_line_with_it(data):
    """The parity bit is taken for the stop bit: 0 is a framing error, and the real stop bit brings the line up."""
    signal = write([(0, data)], Settings(100_000, True, 2))
    received = read(signal, Settings(100_000))
    assert bytes_of(received) == data
    assert [one.stop_bit for one in received] == [byte.bit_count() % 2 for byte in data]


def test_a_port_with_parity_misses_every_second_start_bit_of_a_dense_line_without():
    signal = write([(0, b"\xff" * 6)], Settings(115_200))
    assert bytes_of(read(signal, Settings(115_200, True))) == b"\xff" * 3


def test_twice_the_baud_rate_sees_every_bit_twice():
    # 0x0F after the start bit: 0 1 1 1 1 0 0 0 0 1; the reader's byte begins in the start bit's second half.
    signal = write([(0, b"\x0f")], Settings(115_200))
    assert read(signal, Settings(230_400))[0].byte == 0b1111_1110


def test_a_burst_must_wait_for_the_one_before_it():
    with pytest.raises(ValueError, match="busy until"):
        write([(0, b"abc"), (100, b"d")], Settings(115_200))
