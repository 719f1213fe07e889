"""The message tables: literal frames, both directions of every codec, and the exported DBC read by cantools."""

import json
import math
from pathlib import Path

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.canbus import c610, dm3519, instruments, table
from bench.canbus.dbc import dbc
from bench.canbus.table import Field, Message, byte_table

# Each message is a case of its own, and a family has eight that differ in their identifier alone: 20 examples for each.

KNOWN = Path(__file__).parents[1] / "fixtures" / "known" / "can"
C610 = json.loads((KNOWN / "c610-frames.json").read_text())["frames"]
DM3519 = json.loads((KNOWN / "dm3519-frames.json").read_text())["frames"]

FAMILIES = {
    "c610": c610.FAMILY,
    "dm3519": dm3519.family(),
    "dm3519 20.5 A, error, short": dm3519.family(20.5, "error", "short"),
    "dm3519 and instruments": instruments.with_instruments(dm3519.family(), (5, 6, 7), 2),
}
MESSAGES = [
    (name, message) for name, family in FAMILIES.items() for message in (*family.messages, *family.alternatives)
]
BY_NAME = pytest.mark.parametrize(
    "message", [message for _, message in MESSAGES], ids=[f"{name} {message.name}" for name, message in MESSAGES]
)


def some(field):
    return st.integers(field.low, field.high)


def values_of(message):
    return st.tuples(*map(some, message.variables))


@pytest.mark.parametrize("frame", C610, ids=lambda frame: frame["about"])
def test_c610_frames(frame):
    message = c610.FAMILY.message(frame["can_id"])
    assert message.encode(frame["values"]).hex().upper() == frame["data"]
    assert list(message.decode(bytes.fromhex(frame["data"]))) == frame["values"]


@pytest.mark.parametrize("frame", DM3519, ids=lambda frame: frame["about"])
def test_dm3519_frames(frame):
    data = bytes.fromhex(frame["data"])
    message = dm3519.family(**frame["variant"]).message(frame["can_id"], len(data))
    assert message.encode(frame["values"]) == data
    assert list(message.decode(data)) == frame["values"]


def test_the_identifiers_of_a_c610_bus():
    assert [message.can_id for message in c610.FAMILY.messages] == [0x1FF, 0x200, *range(0x201, 0x209), 0x700]
    assert {message.length for message in c610.FAMILY.messages} == {8}


@BY_NAME
def test_any_values_come_back(message):
    @settings(max_examples=20)
    @given(values_of(message))
    def both_ways(values):
        data = message.encode(values)
        assert len(data) == message.length
        assert message.decode(data) == values
        assert message.outside(values) == ()

    both_ways()


@BY_NAME
def test_any_bytes_are_survived(message):
    @settings(max_examples=20)
    @given(st.binary(max_size=12))
    def survived(data):
        values = message.decode(data)
        assert values is None or len(values) == len(message.variables)
        assert (message.describe(data) == {}) == (values is None)
        if values is not None and not message.outside(values):
            assert message.decode(message.encode(values)) == values

    survived()


@given(st.sampled_from(sorted(FAMILIES)), st.integers(0, 0x1FFFFFFF), st.binary(max_size=64))
def test_any_frame_is_described_or_not(name, can_id, data):
    described = FAMILIES[name].describe(can_id, data)
    assert described == {} or 0x1FF <= can_id <= 0x7FF


@BY_NAME
def test_what_is_out_of_range_is_refused_by_name_value_and_limits(message):
    fitting = [field.low for field in message.variables]
    for place, field in enumerate(message.variables):
        for wrong in (field.low - 1, field.high + 1):
            values = [*fitting[:place], wrong, *fitting[place + 1 :]]
            with pytest.raises(ValueError, match=rf"{field.name} {wrong} outside {field.low}\.\.{field.high}"):
                message.encode(values)
            assert message.outside(values) == (field.key,)
    assert message.outside([field.high for field in message.variables]) == ()
    with pytest.raises(ValueError, match=f"has {len(fitting)} values"):
        message.encode([*fitting, 0])
    with pytest.raises(ValueError, match="zip"):
        message.outside([*fitting, 0])


def test_a_peers_values_out_of_range_are_shown_as_they_are():
    # 32000 is what a public driver sends (m2006-c610, 4.3): no codec may hide it
    assert c610.FAMILY.describe(0x200, bytes.fromhex("7D00 0000 8300 0000"))["current_1_ma"] == 32000
    assert c610.FAMILY.message(0x201).decode(bytes.fromhex("FFFF 0000 0000 0000")) == (65535, 0, 0)


def test_a_c610_ignores_what_a_c620_has_in_bytes_6_and_7():
    assert c610.FAMILY.message(0x201).decode(bytes.fromhex("10E1 300C 0352 2A05")) == (4321, 12300, 850)


@pytest.mark.parametrize("data", ["", "00" * 7, "00" * 7 + "01", "01" + "00" * 7])
def test_only_eight_zeros_are_the_quick_id_frame(data):
    assert c610.FAMILY.describe(0x700, bytes(8)) == {"message": "C610_QuickId"}
    assert c610.FAMILY.describe(0x700, bytes.fromhex(data)) == {}


def test_a_dm3519_says_its_error_by_name():
    error = dm3519.family(feedback_variant="error")
    for code, name in [
        (0, "off"),
        (1, "on"),
        (5, "sensor"),
        (6, "parameter"),
        (8, "over-voltage"),
        (9, "under-voltage"),
        (10, "over-current"),
        (11, "MOSFET hot"),
        (12, "coil hot"),
        (13, "link lost"),
        (14, "overload"),
        *((code, "unknown") for code in (2, 3, 4, 7, 15)),
    ]:
        said = error.describe(0x208, bytes([0, 0, 0, 0, 0, 0, 30, code]))
        assert (said["temperature_degc"], said["error"], said["error_name"]) == (30, code, name)
    assert dm3519.family().describe(0x208, bytes([0, 0, 0, 0, 0, 0, 41, 38])) == {
        "angle_counts": 0,
        "speed_rpm": 0,
        "current_raw": 0,
        "coil_degc": 41,
        "mosfet_degc": 38,
    }


@pytest.mark.parametrize("variant", ["long", "short"])
@pytest.mark.parametrize("number", range(1, 9))
def test_a_clear_frame_names_one_esc_in_either_length(variant, number):
    assert dm3519.cleared_esc(*dm3519.clear_error(number, variant)) == number


@pytest.mark.parametrize("variant", ["long", "short"])
def test_a_clear_frame_of_the_other_length_is_decoded_and_never_sent(variant):
    family = dm3519.family(clear_error=variant)
    assert family.describe(0x7FF, bytes.fromhex("0300553C00000000"))["id_low"] == 3
    assert family.describe(0x7FF, bytes.fromhex("3000553C"))["id_x16"] == 48
    assert [message.length for message in family.messages if message.can_id == 0x7FF] == [8 if variant == "long" else 4]


@pytest.mark.parametrize(
    "frame",
    [
        (0x7FE, "0300553C00000000"),
        (0x7FF, "0301553C00000000"),
        (0x7FF, "0300553C00000001"),
        (0x7FF, "0300AA3C00000000"),
        (0x7FF, "0900553C00000000"),
        (0x7FF, "0000553C00000000"),
        (0x7FF, "3100553C"),
        (0x7FF, "3000553C00"),
        (0x7FF, ""),
    ],
)
def test_anything_else_clears_nobody(frame):
    assert dm3519.cleared_esc(frame[0], bytes.fromhex(frame[1])) is None


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_any_frame_may_be_asked_whom_it_clears(can_id, data):
    assert dm3519.cleared_esc(can_id, data) in (None, *range(1, 9))


def test_clearing_nobody_and_unknown_variants_are_refused():
    for number in (0, 9):
        with pytest.raises(ValueError, match=rf"ESC {number} outside 1\.\.8"):
            dm3519.clear_error(number)
    with pytest.raises(ValueError, match="variant 'temperature' is none of temperatures, error"):
        dm3519.family(feedback_variant="temperature")
    with pytest.raises(ValueError, match=r"full scale 10 A outside 20.0\.\.20.5"):
        dm3519.family(10)


@pytest.mark.parametrize(("name", "last"), [("c610", "C610_QuickId"), ("dm3519", "DM3519_ClearError")])
def test_messages_go_by_their_maker_and_the_numbers_of_their_escs(name, last):
    """In the order of identifiers: 0x1FF comes first."""
    commands = [f"{name.upper()}_Command_5_8", f"{name.upper()}_Command_1_4"]
    feedback = [f"{name.upper()}_Feedback_{number}" for number in range(1, 9)]
    assert [message.name for message in FAMILIES[name].messages] == [*commands, *feedback, last]
    assert FAMILIES[name].name == name
    for_all = FAMILIES[name].messages[-1]
    assert (for_all.sender, for_all.receivers) == ("Controller", tuple(f"ESC_{number}" for number in range(1, 9)))


def facts(field):
    return field.first_byte, field.size, field.signed, field.low, field.high, field.suffix, field.unit, field.scale


@pytest.mark.parametrize("name", ["c610", "dm3519", "dm3519 20.5 A, error, short"])
def test_both_groups_and_all_escs_speak_alike(name):
    """What stands at the same place of another frame of the kind is the same but for its number."""
    family = FAMILIES[name]
    first, second = family.commands
    assert [facts(field) for field in first.fields] == [facts(field) for field in second.fields]
    assert [field.name for field in (*first.fields, *second.fields)] == [f"current_{number}" for number in range(1, 9)]
    assert first.receivers + second.receivers == tuple(f"ESC_{number}" for number in range(1, 9))
    assert all(message.fields == family.feedback[0].fields for message in family.feedback)
    assert [message.sender for message in family.feedback] == [f"ESC_{number}" for number in range(1, 9)]
    assert {message.receivers for message in family.feedback} == {("Controller",)}


def test_scales():
    assert c610.FAMILY.raw_per_a == 1000
    assert dm3519.family().raw_per_a == 819.2
    assert round(3 * dm3519.family().raw_per_a) == 2458  # "3 A is 2458" on the 20 A scale
    assert round(dm3519.family(20.5).raw_per_a, 3) == 799.22
    assert round(dm3519.GEAR, 4) == 19.2032


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ((Field("a", 0, 2, False, 0, 1), Field("b", 1, 1, False, 0, 1)), "b overlaps"),
        ((Field("a", 7, 2, False, 0, 1),), "9 bytes do not fit into 8"),
    ],
)
def test_a_table_that_cannot_be_is_refused(fields, says):
    with pytest.raises(ValueError, match=says):
        Message("M", 0x123, "A", ("B",), fields)


def test_a_byte_table_shows_what_no_field_uses():
    fields = (Field("a", 2, 1, False, 0, 9), Field("b", 5, 2, True, -1, 1, about="of something"))
    message = Message("M", 0x123, "A", ("B",), fields)
    assert byte_table(message)[2:] == [
        "| 0-1 | | | sent as 0 | | not used |",
        "| 2 | a | u8 | 0 .. 9 |  |  |",
        "| 3-4 | | | sent as 0 | | not used |",
        "| 5-6 | b | i16 | -1 .. 1 |  | of something |",
        "| 7 | | | sent as 0 | | not used |",
    ]
    assert message.encode((7, -1)) == bytes.fromhex("0000 07 0000 FFFF 00")


@pytest.mark.parametrize(("can_id", "says"), [(0x800, "0x800"), (-1, "-0x1")])
def test_an_identifier_that_cannot_be_is_refused(can_id, says):
    with pytest.raises(ValueError, match=f"identifier {says} outside"):
        Message("M", can_id, "A", ("B",), ())
    assert Message("M", 0, "A", ("B",), ()).can_id == 0


@pytest.mark.parametrize("family", [c610.FAMILY, dm3519.family()])
def test_a_family_prints_as_what_it_is_made_of(family):
    again = eval(repr(family), vars(table))
    assert (again.messages, again.alternatives) == (family.messages, family.alternatives)


def test_a_count_is_worth_one_of_its_unit_where_nothing_else_is_said():
    speed = Field("speed", 0, 2, signed=True, low=-9, high=9, unit="rpm")
    assert "| 1 rpm |" in byte_table(Message("M", 1, "A", ("B",), (speed,)))[2]


# --- dead wheels and gyro ------------------------------------------------------------------------------------------


def test_encoder_boards_take_the_places_of_escs_and_report_as_c610s_do():
    family = FAMILIES["dm3519 and instruments"]
    assert [message.name for message in family.feedback[3:7]] == [
        "DM3519_Feedback_4",
        "Encoder_5",
        "Encoder_6",
        "Encoder_7",
    ]
    frame = bytes.fromhex("10E1 300C 0000 0000")
    ours, theirs = family.message(0x205), c610.FAMILY.message(0x205)
    assert ours.decode(frame) == theirs.decode(frame) == (4321, 12300, 0)
    assert [(field.name, field.first_byte, field.size, field.signed) for field in ours.fields] == [
        (field.name, field.first_byte, field.size, field.signed) for field in theirs.fields
    ]


def test_a_gyros_frame_by_hand():
    # 2 rad/s is 2000 counts, a quarter turn a quarter of 2^32; docs/gyro.md
    message = instruments.gyro(1)
    assert (message.can_id, message.length) == (0x301, 6)
    assert message.encode((2000, 1 << 30)).hex() == "07d040000000"
    assert message.decode(bytes.fromhex("f830c0000000")) == (-2000, 3 << 30)
    rate, heading = message.fields
    assert (rate.scale * 2000, heading.scale * (1 << 30)) == pytest.approx((2.0, math.pi / 2))
    with pytest.raises(ValueError, match=r"gyro 9 outside 1\.\.8"):
        instruments.gyro(9)


# --- the DBC, as cantools reads it ---------------------------------------------------------------------------------


DATABASES = {name: cantools.database.load_string(dbc(family), "dbc", strict=True) for name, family in FAMILIES.items()}
EXPORTED = [(name, message) for name, family in FAMILIES.items() for message in family.messages]
EXPORTED_BY_NAME = pytest.mark.parametrize(
    ("name", "message"), EXPORTED, ids=[f"{name} {message.name}" for name, message in EXPORTED]
)


@pytest.mark.parametrize("name", FAMILIES)
def test_the_dbc_has_every_message_and_signal(name):
    family, database = FAMILIES[name], DATABASES[name]
    assert [message.frame_id for message in database.messages] == [message.can_id for message in family.messages]
    for ours, theirs in zip(family.messages, database.messages, strict=True):
        assert (theirs.name, theirs.length, theirs.senders) == (ours.name, ours.length, [ours.sender])
        assert theirs.cycle_time == (ours.period_ms or None)
        assert [signal.name for signal in theirs.signals] == [field.name for field in ours.fields]
        assert not theirs.is_extended_frame
    assert dbc(family).isascii()


@EXPORTED_BY_NAME
def test_cantools_decodes_what_we_encode(name, message):
    @settings(max_examples=20)
    @given(values_of(message))
    def decodes(values):
        theirs = DATABASES[name].decode_message(
            message.can_id, message.encode(values), scaling=False, decode_choices=False
        )
        assert [theirs[field.name] for field in message.variables] == list(values)

    decodes()


@EXPORTED_BY_NAME
def test_we_decode_what_cantools_encodes(name, message):
    @settings(max_examples=20)
    @given(values_of(message))
    def decodes(values):
        given_values = {field.name: field.low for field in message.fields}
        given_values |= {field.name: value for field, value in zip(message.variables, values, strict=True)}
        data = DATABASES[name].encode_message(message.can_id, given_values, scaling=False)
        assert data == message.encode(values)
        assert message.decode(data) == values

    decodes()


def test_the_dbc_scales_to_units():
    c610_database, dm_database = DATABASES["c610"], DATABASES["dm3519 20.5 A, error, short"]
    assert c610_database.decode_message(0x200, bytes.fromhex("03E8 FC18 0258 0000")) == {
        "current_1": 1000,
        "current_2": -1000,
        "current_3": 600,
        "current_4": 0,
    }
    said = dm_database.decode_message(0x201, bytes.fromhex("10E1 0000 4000 2A0D"))
    assert (said["current"], said["temperature"], str(said["error"])) == (20.5, 42, "link lost")
    current = c610_database.get_message_by_name("C610_Command_1_4").get_signal_by_name("current_1")
    assert (current.minimum, current.maximum, current.unit, current.receivers) == (-10000, 10000, "mA", ["ESC_1"])


def test_the_dbc_says_who_sends_and_hears_how_often():
    database = DATABASES["c610"]
    everyone = [f"ESC_{number}" for number in range(1, 9)]
    assert sorted(node.name for node in database.nodes) == ["Controller", *everyone]
    assert [message.cycle_time for message in database.messages] == [1] * 10 + [None]
    feedback = database.get_message_by_frame_id(0x208)
    assert (feedback.senders, feedback.receivers) == (["ESC_8"], {"Controller"})
    clear = DATABASES["dm3519"].get_message_by_frame_id(0x7FF)
    assert (clear.senders, clear.receivers, clear.cycle_time) == (["Controller"], set(everyone), None)


def test_golden_frames_through_the_dbc():
    for frame in C610:
        said = DATABASES["c610"].decode_message(frame["can_id"], bytes.fromhex(frame["data"]))
        assert list(said.values()) == frame["values"]
