"""space_packet_parser (LASP) decodes the stream by the XTCE; `spp validate` accepts the XTCE."""

import pathlib
import subprocess
import sys

import pytest
import space_packet_parser as spp
from flights import KINDS, REPOSITORY, XTCE, expect_rows, flat


@pytest.mark.parametrize("name", ["polhode.xtce.xml", "polhode_commands.xtce.xml"])
def test_spp_validate_accepts_the_xtce(name):
    program = pathlib.Path(sys.executable).parent / "spp"
    level = ["--level", "schema"] if "commands" in name else []  # it takes containers of commands for telemetry's
    done = subprocess.run([program, "validate", "--no-schema-download", *level, REPOSITORY / "config/bus" / name],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def decoded(flight):
    definition = spp.load_xtce(XTCE)
    return [definition.parse_bytes(octets) for octets in spp.ccsds_generator(flight.stream)]


def of(decoded, name):
    prefix = name + "_"
    return [{key[len(prefix):]: value for key, value in packet.items() if key.startswith(prefix)}
            for packet in decoded if prefix + "timestamp_ns" in packet]


def test_motion_equals_the_table(decoded, flight):
    expect_rows(of(decoded, "motion"), flight.rows)


def test_every_packet_is_decoded_to_its_end(decoded, flight):
    from polhode_bus import crc16

    assert len(decoded) == len(flight.packets)
    for packet, octets in zip(decoded, spp.ccsds_generator(flight.stream)):
        assert int(packet["CRC"]) == crc16(bytes(octets)[:-2])


def test_words_and_flags_come_as_such(decoded, flight):
    for values, row in zip(of(decoded, "motion"), flight.rows):
        assert str(values["mode"]) == row["mode"]
        assert int(getattr(values["flag_pose"], "raw_value", values["flag_pose"])) == int(row["pose_valid"])


def number(value):
    """As it stands in the packet: of a word its number."""
    return getattr(value, "raw_value", value)


# verifies: BUS-07
@pytest.mark.parametrize("name", KINDS)
def test_every_field_of_every_kind_is_the_python_clients(decoded, flight, name):
    ours = [flat(packet) for packet in flight.packets if packet.name == name]
    theirs = of(decoded, name)
    assert ours and len(theirs) == len(ours)
    for index, values in enumerate(ours):
        for field, value in values.items():
            if isinstance(value, str):
                assert str(theirs[index][field]).rstrip("\0") == value
            else:
                assert number(theirs[index][field]) == value, (name, index, field)
