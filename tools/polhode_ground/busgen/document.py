"""The interface control document: every octet of every packet, for people."""

from .table import COMMAND_HEADER_OCTETS, HEADER_OCTETS, Event, Field, Layout, Table

HEAD = """# Interface control document of the motion output bus
Written by `tools/generate_bus.py` from `config/bus/*.toml`: change those. How to read, command and transport: `bus.md`.

All numbers are big-endian; floating point is IEEE 754. Packets are CCSDS space packets (133.0-B); the last two octets are the
CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF, no reflection, check value 0x29B1) of all octets before them: over a whole
packet it is 0. No field ever holds a NaN or an infinity. A value that names a flag is zero and means nothing while that flag is
down. "length" is metres where the packet's flag scale_known is up, else map units (unknown, constant). Frames: C camera (x right,
y down, z forward), T target-fixed, B body (principal or geometric axes), I inertial; q_CT takes T components to C components,
Hamilton, w first. sigma: one standard deviation. Layout version {version}.

## Telemetry header, {header} octets
| octet | bits | field | value |
| --- | --- | --- | --- |
| 0-1 | 3 | packet version | 0 |
| | 1 | type | 0: telemetry |
| | 1 | secondary header | 1: present |
| | 11 | APID | `bus.apid_first` (by default 0x{apid:X}) and the packet's number |
| 2-3 | 2 | segmentation flags | 3: whole |
| | 14 | sequence count | one per APID, counts every packet, wraps from 16383 to 0 |
| 4-5 | 16 | packet data length | total octets - 7 |
| 6 | 8 | CUC P-field (CCSDS 301.0-B) | 0x2F: agency-defined epoch, 4 octets of seconds, 3 octets of fraction |
| 7-10 | 32 | seconds | since the epoch of the camera's time stamps, 1970-01-01T00:00:00; no leap seconds applied |
| 11-13 | 24 | fraction | units of 2^-24 s (60 ns), rounded down |
| 14 | 8 | layout version | {version} |
| 15 | 8 | time quality | 0: the camera's time stamp; 1: it does not fit CUC, octets 7-13 are zero |

"""

COMMAND_HEAD = """## Commands
APID {apid}. Header, {header} octets: packet version 0 (3 bits), type 1: telecommand, secondary header 1, APID (11); segmentation
flags 3 (2), sequence count (14); total octets - 7 (16); layout version {version} (8); function code (8). Arguments
follow, then the CRC. Every command is answered by an event and counted, accepted or rejected.
A sequence count of 0 says that the sender does not count. With 1 .. 16383 the answering events bear it, and a command that comes
twice with the same octets is answered by command_repeated and not carried out again (decision 0092).

"""


def range_text(field: Field) -> str:
    if field.enum:
        return ", ".join(f"{value} {label}" for value, label in enumerate(field.enum))
    if field.range is None:
        return ""
    low, high = field.range
    return f">= {low:g}" if high == float("inf") else f"{low:g}" if low == high else f"{low:g} .. {high:g}"


def type_text(field: Field) -> str:
    if field.type == "text":
        return f"text, {field.count}"
    if not field.is_array:
        return field.type
    shape = f"{field.rows} x {len(field.elements)}" if field.rows > 1 else str(field.count)
    names = f": {', '.join(field.elements)}" if field.elements else ""
    return f"{shape} x {field.type}{names}"


def alarm_text(field: Field) -> str:
    """What follows the meaning: the alarms that the XTCE raises on the ground."""
    return "".join(f"; {level} " + (f"above {limit['above']:g}" if "above" in limit else f"at {', '.join(limit['at'])}")
                   for level, limit in field.alarm.items())


def field_rows(layout: Layout) -> str:
    text = ""
    for field in layout.fields:
        help = field.help
        if field.is_flags and layout.flags:
            rest = f"bits 4 to 7: {layout.flags_number}, {layout.flags_number_help}" if layout.flags_number else "the rest 0"
            help = "; ".join(f"bit {bit}: {flag}" for bit, flag in enumerate(layout.flags)) + f"; {rest} (bit 0 is the least)"
        text += f"| {field.offset} | {type_text(field)} | {field.name} | {field.unit} | {range_text(field)} | {field.valid or ''} | {help}{alarm_text(field)} |\n"
    return text


TABLE_HEAD = "| octet | type | field | unit | range | valid by | meaning |\n| --- | --- | --- | --- | --- | --- | --- |\n"


def packet_text(packet: Layout, table: Table) -> str:
    return (f"## {packet.name}: APID {table.apid_first + packet.number} (0x{table.apid_first + packet.number:X}), {packet.octets} octets\n"
            f"{packet.help}\n\nSent {packet.when}.\n\n{TABLE_HEAD}{field_rows(packet)}| {packet.end} | u16 | CRC | | | | |\n\n")


def command_text(command: Layout) -> str:
    octets = f"{command.octets} octets" if command.entry is None else f"{command.octets} octets and {command.entry.end} an entry"
    text = f"### {command.number} {command.name.upper()}, {octets}\n{command.help[0].upper()}{command.help[1:]}.\n\n"
    if command.fields:
        text += TABLE_HEAD + field_rows(command) + "\n"
    if command.entry:
        text += f"Each entry, from its first octet, at most {command.repeated}:\n\n{TABLE_HEAD}{field_rows(command.entry)}\n"
    return text


def events_text(table: Table) -> str:
    text = ("## Events\nOf one id, at most `burst` events are sent within `bus.event_window_frames` frames. The others are counted, and the "
            "next one sent reports how many. Of the arguments the numbers are the packet's values, in their order; a word is in the text alone.\n\n"
            "| id | name | severity | burst | text | arguments | codes in it |\n| --- | --- | --- | --- | --- | --- | --- |\n")
    for event in table.events:
        arguments = "; ".join(argument.help for argument in event.arguments)
        text += f"| {event.id} | {event.name} | {event.severity} | {event.burst} | {event.text} | {arguments} | {codes_text(event, table)} |\n"
    return text


def codes_text(event: Event, table: Table) -> str:
    """Of each kind of code once."""
    told = []
    for place, number in enumerate(event.numbers):
        codes = number.codes
        if codes == "commands":
            told.append(f"{number.name}: code of the command")
        elif codes and codes not in event.words[:place]:
            where = ", ".join(one.name for one in event.numbers if one.codes == codes)
            told.append(f"{where}: " + ", ".join(f"{code} {name}" for code, name in table.codes[codes].items()))
    return "; ".join(told)


PARAMETERS_HEAD = """## Parameters
TABLE_LOAD changes these. Type of the value in its entry: i64, in two's complement, or f64. Words stand for the values 0, 1, ...

| key | key_crc | type | unit | allowed | default | meaning |
| --- | --- | --- | --- | --- | --- | --- |
"""


def parameters_text(table: Table) -> str:
    text = PARAMETERS_HEAD
    for row in table.parameters:
        allowed = ", ".join(f"{value} {word}" for value, word in enumerate(row.words)) or f"{row.range[0]} .. {row.range[1]}"
        default = str(row.default).lower() if isinstance(row.default, bool) else row.default
        text += f"| {row.key} | 0x{row.crc:08X} | {row.type} | {row.unit} | {allowed} | {default} | {row.help} |\n"
    return text + "\n"



def interface_control(table: Table) -> str:
    """The interface control document: every packet and command, octet by octet."""
    text = HEAD.format(version=table.layout_version, header=HEADER_OCTETS, apid=table.apid_first)
    text += "".join(packet_text(packet, table) for packet in table.packets)
    apid = f"{table.apid_first + table.apid_command} (0x{table.apid_first + table.apid_command:X})"
    text += COMMAND_HEAD.format(apid=apid, header=COMMAND_HEADER_OCTETS, version=table.layout_version)
    return text + "".join(map(command_text, table.commands)) + parameters_text(table) + events_text(table)
