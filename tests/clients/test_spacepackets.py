"""spacepackets checks headers and checksums, and finds its place again in a stream that slipped."""

import fastcrc
from flights import split
from spacepackets.ccsds.spacepacket import PacketId, PacketType, SequenceFlags, SpacePacketHeader, parse_space_packets

APID_FIRST, KINDS = 0x1A0, 8
IDS = [PacketId(PacketType.TM, True, APID_FIRST + number) for number in range(KINDS)]


def crc_ccitt_false(octets: bytes) -> int:
    return fastcrc.crc16.ibm_3740(octets)  # the catalogue's name of CRC-16/CCITT-FALSE; what spacepackets uses


# verifies: BUS-01
def test_headers_are_the_standards(flight):
    for octets in split(flight.stream):
        header = SpacePacketHeader.unpack(octets)
        assert header.packet_type == PacketType.TM and header.sec_header_flag
        assert header.seq_flags == SequenceFlags.UNSEGMENTED
        assert header.packet_len == len(octets)
        assert APID_FIRST <= header.apid < APID_FIRST + KINDS


# verifies: BUS-01
def test_checksums_vanish_over_whole_packets(flight):
    assert all(crc_ccitt_false(octets) == 0 for octets in split(flight.stream))


def test_a_damaged_packet_fails_its_checksum_alone(damaged):
    assert sum(crc_ccitt_false(octets) != 0 for octets in damaged.packets) == 1


# verifies: BUS-06
def test_a_slipped_stream_is_read_on(flight):
    whole = split(flight.stream)
    slipped = b"\x00\x01\x02" + b"".join(whole[:5]) + b"\xff" * 7 + b"".join(whole[5:])
    result = parse_space_packets(slipped, IDS)
    assert result.tm_list == whole
    assert [len(skipped) for skipped in result.skipped_ranges] == [3, 7]
