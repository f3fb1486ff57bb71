"""From octets to values, by the field table."""

import binascii
import struct
from dataclasses import dataclass, field

from .packets import APID_FIRST, CODES, EVENTS, LAYOUT_VERSION, NAMED, PACKETS

HEADER_OCTETS = 16
CRC_OCTETS = 2
PACKET_OCTETS_MAX = 1400


def crc16(octets: bytes) -> int:
    """CRC-16/CCITT-FALSE; over a whole packet it is 0."""
    return binascii.crc_hqx(octets, 0xFFFF)


@dataclass(frozen=True)
class Header:
    apid: int
    sequence: int
    octets: int
    seconds: int
    fraction: int  # units of 2^-24 s
    layout_version: int
    time_quality: int


@dataclass(frozen=True)
class Packet:
    """One telemetry packet. Its fields are attributes: numbers, lists, texts; None where their flag is down."""
    name: str
    header: Header
    values: dict = field(repr=False)

    def __getattr__(self, key):
        try:
            return self.values[key]
        except KeyError:
            raise AttributeError(f"packet {self.name} has no field {key}") from None


def name_of(packet: Packet, field: str) -> str:
    """The name of a code: name_of(event, "id") is "mode_changed", name_of(housekeeping, "last_command") is "noop"."""
    return CODES[NAMED[packet.name, field]].get(packet.values[field], str(packet.values[field]))


def words_of(event: Packet) -> str:
    """What the codes among an event's numbers mean, as in "IDLE to ACQUIRING"; empty where there are none."""
    _, _, numbers = EVENTS.get(event.id, ("", "", []))
    return " to ".join(CODES[of].get(value, "unknown") for (_, _, of), value in zip(numbers, event.value) if of)


def numbers_of(event: Packet) -> dict[str, float]:
    """An event's numbers by their names; an unknown event has none."""
    _, _, numbers = EVENTS.get(event.id, ("", "", []))
    return {name: value for (name, _, _), value in zip(numbers, event.value)}


def header_of(octets: bytes) -> Header | None:
    """None where the fixed bits are wrong or there are too few octets."""
    if len(octets) < HEADER_OCTETS or octets[0] & 0xF8 != 0x08 or octets[2] & 0xC0 != 0xC0 or octets[6] != 0x2F or octets[15] > 1:
        return None
    identification, control, length = struct.unpack_from(">HHH", octets)
    return Header(apid=identification & 0x7FF, sequence=control & 0x3FFF, octets=length + 7,
                  seconds=int.from_bytes(octets[7:11], "big"), fraction=int.from_bytes(octets[11:14], "big"),
                  layout_version=octets[14], time_quality=octets[15])


def _shaped(values: list, shape):
    if shape is None:
        return values[0]
    if len(shape) == 1:
        return values
    return [values[row * shape[1]:(row + 1) * shape[1]] for row in range(shape[0])]


def _value(octets: bytes, row: tuple):
    _, code, count, offset, shape, _, names = row
    if code == "s":
        return octets[offset:offset + count].split(b"\0", 1)[0].decode("ascii", "replace")
    values = list(struct.unpack_from(f">{count}{code}", octets, offset))
    if names:
        values = [names[value] if value < len(names) else value for value in values]
    return _shaped(values, shape)


def flag_name(flag: str, rows: list, bit: int) -> str:
    guards = any(row[5] == bit for row in rows)
    return f"{flag}_valid" if guards and flag != "scale_known" else flag


def decode(octets: bytes, apid_first: int = APID_FIRST) -> Packet | None:
    """None where it is no whole packet of the field table: header, length, layout version or CRC is wrong."""
    header = header_of(octets)
    if header is None or header.octets != len(octets) or header.layout_version != LAYOUT_VERSION or crc16(octets) != 0:
        return None
    known = PACKETS.get(header.apid - apid_first)
    if known is None or known[1] != len(octets):
        return None
    name, _, flags, rows, number = known
    raised = next((octets[row[3]] for row in rows if row[0] == "flags"), 0)
    values = {flag_name(flag, rows, bit): bool(raised >> bit & 1) for bit, flag in enumerate(flags)}
    if number:
        values[number] = raised >> 4
    for row in rows:
        if row[0] in ("flags", "spare"):
            continue
        valid = row[5] is None or raised >> row[5] & 1
        values[row[0]] = _value(octets, row) if valid else None
    return Packet(name=name, header=header, values=values)
