"""ccsdspy (NASA) decodes the stream by the CSV definitions."""

import io

import ccsdspy
import pytest
from flights import KINDS, REPOSITORY, expect_rows, flat

APID_FIRST = 0x1A0


def load(stream: bytes, name: str) -> dict:
    from polhode_bus.packets import PACKETS

    number = next(number for number, row in PACKETS.items() if row[0] == name)
    parts = ccsdspy.utils.split_by_apid(io.BytesIO(stream))
    definition = ccsdspy.FixedLength.from_file(REPOSITORY / "config/bus/ccsdspy" / f"{name}.csv")
    return definition.load(parts[APID_FIRST + number], include_primary_header=True)


def test_motion_equals_the_table(flight):
    columns = load(flight.stream, "motion")
    rows = [{name: values[index] for name, values in columns.items()} for index in range(len(columns["frame"]))]
    expect_rows(rows, flight.rows)
    assert list(columns["CCSDS_SEQUENCE_COUNT"]) == list(range(len(rows)))


# verifies: BUS-07
@pytest.mark.parametrize("name", KINDS)
def test_every_field_of_every_kind_is_the_python_clients(flight, name):
    ours = [flat(packet) for packet in flight.packets if packet.name == name]
    columns = load(flight.stream, name)
    assert ours and len(columns["CUC_SECONDS"]) == len(ours)
    for index, values in enumerate(ours):
        for field, value in values.items():
            if isinstance(value, str):
                assert bytes(columns[field][index]).rstrip(b"\0").decode() == value
            else:
                assert columns[field][index] == value, (name, index, field)


def test_events_have_their_texts(flight):
    texts = [packet.text for packet in flight.packets if packet.name == "event"]
    assert [bytes(text).rstrip(b"\0").decode() for text in load(flight.stream, "event")["text"]] == texts
