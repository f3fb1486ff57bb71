"""space_packet_parser (LASP) decodes the stream by the XTCE; `spp validate` accepts the XTCE."""

import pathlib
import subprocess
import sys

import pytest
import space_packet_parser as spp
from flights import REPOSITORY, XTCE, expect_rows


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


def test_all_kinds_agree_with_the_python_client(decoded, flight):
    for name, field in (("housekeeping", "frames_in"), ("event", "id"), ("cloud", "chunk"), ("prediction", "poses")):
        ours = [getattr(packet, field) for packet in flight.packets if packet.name == name]
        assert [int(values[field]) for values in of(decoded, name)] == ours and ours
    texts = [packet.text for packet in flight.packets if packet.name == "event"]
    assert [str(values["text"]).rstrip("\0") for values in of(decoded, "event")] == texts
