"""The field table, read and checked: offsets follow from the order, everything on a multiple of its size."""

import binascii
import dataclasses
import math
import pathlib
import re
import tomllib

HEADER_OCTETS = 16
COMMAND_HEADER_OCTETS = 8
CRC_OCTETS = 2
FLAGS_NUMBER_BITS = 4  # the upper half of the octet of flags, in a packet that has a number there
PACKET_OCTETS_MAX = 1400
TEXT_OCTETS_MAX = 122
COMMAND_EVENTS = range(40, 80)  # ids of answers to commands
EVENT_NUMBERS_MAX = 2  # values that its packet has room for
NO_COMMAND = 255  # where the code of the last command stands and none came

SIZES = {"u8": 1, "u16": 2, "u32": 4, "u64": 8, "i64": 8, "f32": 4, "f64": 8, "text": 1}


class TableError(Exception):
    """The table contradicts itself; says where."""


@dataclasses.dataclass
class Field:
    name: str
    type: str
    offset: int
    help: str = ""
    unit: str = ""
    range: tuple[float, float] | None = None
    valid: str | None = None  # flag that must be up
    enum: tuple[str, ...] = ()
    elements: tuple[str, ...] = ()  # names; empty: a single value or numbered ones
    rows: int = 1
    count: int = 1  # values in all; octets of a text
    is_array: bool = False
    is_counter: bool = False  # of the component: a member of Counters
    names: str = ""  # of Table.codes: what the value is a code of
    alarm: dict = dataclasses.field(default_factory=dict)  # level -> {"above": number} or {"at": names}

    @property
    def size(self) -> int:
        return SIZES[self.type]

    @property
    def octets(self) -> int:
        return self.size * self.count

    @property
    def is_flags(self) -> bool:
        return self.name == "flags"

    def element_names(self) -> list[str]:
        """One name a value: q_CT_w, plane_offset_03, p_T_017_x."""
        if not self.is_array or self.type == "text":
            return [self.name]
        if self.rows > 1:
            width = len(str(self.rows - 1))
            return [f"{self.name}_{row:0{width}}_{element}" for row in range(self.rows) for element in self.elements]
        if self.elements:
            return [f"{self.name}_{element}" for element in self.elements]
        width = len(str(self.count - 1))
        return [f"{self.name}_{index:0{width}}" for index in range(self.count)]


@dataclasses.dataclass
class Layout:
    """Fields one after the other: a telemetry packet, a command's arguments, or one of its repeated entries."""
    name: str
    fields: list[Field]
    begin: int
    flags: tuple[str, ...] = ()
    flags_number: str = ""  # name of the number in the upper four bits of the flags; "": there is none
    flags_number_help: str = ""
    help: str = ""
    when: str = ""
    number: int = 0  # APID above the first one, or function code
    entry: "Layout | None" = None
    repeated: int = 0

    @property
    def end(self) -> int:
        return self.fields[-1].offset + self.fields[-1].octets if self.fields else self.begin

    @property
    def octets(self) -> int:
        """With the CRC; a command with entries: with none of them."""
        return self.end + CRC_OCTETS


@dataclasses.dataclass
class Argument:
    """Of an event."""
    name: str
    type: str
    unit: str = ""
    range: tuple[float, float] | None = None
    codes: str = ""  # of Table.codes: what the number is a code of; "" where it is none

    @property
    def help(self) -> str:
        """With its unit and range."""
        limits = f"{self.range[0]:g} .. {self.range[1]:g}" if self.range else ""
        notes = ", ".join(note for note in (self.unit, limits, self.codes) if note)
        return f"{self.name} ({notes})" if notes else self.name


@dataclasses.dataclass
class Event:
    id: int
    name: str
    severity: str
    text: str  # names its arguments: "{frames}"
    burst: int  # sent within a window of frames
    arguments: list[Argument]

    @property
    def numbers(self) -> list[Argument]:
        """In the order of the packet's values."""
        return [argument for argument in self.arguments if argument.type != "text"]

    @property
    def word(self) -> Argument | None:
        return next((argument for argument in self.arguments if argument.type == "text"), None)

    @property
    def pattern(self) -> str:
        """The text as the packet's writer fills it: {0} and {1} are its numbers, {} its word."""
        text = self.text
        for place, argument in enumerate(self.numbers):
            text = text.replace(f"{{{argument.name}}}", f"{{{place}}}")
        return text.replace(f"{{{self.word.name}}}", "{}") if self.word else text

    @property
    def words(self) -> tuple[str, str]:
        """What each number is a code of; "" where it is a number."""
        first, second, *_ = *(number.codes for number in self.numbers), "", ""
        return first, second

    @property
    def values_help(self) -> str:
        """What the packet's values are; empty where it has none."""
        return ", ".join(f"value_{place}: {number.help}" for place, number in enumerate(self.numbers))


@dataclasses.dataclass
class Parameter:
    """That TABLE_LOAD may change."""
    key: str
    type: str  # i64 or f64
    default: float | int | bool | str
    unit: str
    help: str
    range: tuple[float, float] | None = None
    words: tuple[str, ...] = ()  # for the values 0, 1, ...

    @property
    def crc(self) -> int:
        return binascii.crc32(self.key.encode())


@dataclasses.dataclass
class Table:
    layout_version: int
    apid_first: int
    apid_command: int
    packets: list[Layout]
    commands: list[Layout]
    events: list[Event]
    parameters: list[Parameter]
    codes: dict[str, dict[int, str]]  # "commands", "events", "faults", and "packet.field" of each enum: code -> name

    def packet(self, name: str) -> Layout:
        return next(packet for packet in self.packets if packet.name == name)

    @property
    def codes_in_use(self) -> list[str]:
        """Those that a field or an event refers to: of the others the field itself has the words."""
        return sorted(({field.names for packet in self.packets for field in packet.fields}
                       | {word for event in self.events for word in event.words}) - {""})

    @property
    def severities(self) -> tuple[str, ...]:
        return next(field.enum for field in self.packet("event").fields if field.name == "severity")


FIELD_KEYS = {"name", "type", "help", "unit", "range", "valid", "enum", "elements", "rows", "count", "octets", "counter", "names", "alarm"}
ALARM_LEVELS = ("watch", "warning", "distress", "critical", "severe")  # as XTCE has them


def read_field(raw: dict, offset: int, where: str) -> Field:
    unknown = set(raw) - FIELD_KEYS
    if unknown or "name" not in raw or raw.get("type") not in SIZES:
        raise TableError(f"{where}: field {raw.get('name', raw)}: name, a known type and no {sorted(unknown)}")
    elements = tuple(raw.get("elements", ()))
    rows = raw.get("rows", 1)
    count = raw.get("octets") or raw.get("count") or rows * max(1, len(elements))
    low, high = raw.get("range", (-math.inf, math.inf))
    field = Field(name=raw["name"], type=raw["type"], offset=offset, help=raw.get("help", ""), unit=raw.get("unit", ""),
                  is_counter=raw.get("counter", False), range=(low, high) if "range" in raw else None, valid=raw.get("valid"), enum=tuple(raw.get("enum", ())),
                  elements=elements, rows=rows, count=count, is_array=count > 1 or bool(elements), names=raw.get("names", ""),
                  alarm=raw.get("alarm", {}))
    if offset % field.size:
        raise TableError(f"{where}: {field.name} at octet {offset} is not on a multiple of its {field.size} octets")
    check_alarm(field, where)
    return field


def check_alarm(field: Field, where: str) -> None:
    for level, limit in field.alarm.items():
        good = set(limit.get("at", ())) <= set(field.enum) and field.enum if "at" in limit else "above" in limit and not field.enum
        if level not in ALARM_LEVELS or len(limit) != 1 or not good:
            raise TableError(f"{where}: {field.name}: alarm {level}: a level of XTCE, with `above` a number or `at` names of its enum")


def read_layout(raw: dict, begin: int, where: str, key: str) -> Layout:
    fields, offset = [], begin
    for entry in raw[key]:
        fields.append(read_field(entry, offset, where))
        offset = fields[-1].offset + fields[-1].octets
    number = raw.get("flags_number", {"name": "", "help": ""})
    layout = Layout(name=raw["name"], fields=fields, begin=begin, flags=tuple(raw.get("flags", ())), flags_number=number["name"],
                    flags_number_help=number["help"], help=raw["help"], when=raw.get("when", ""), number=raw.get("apid", raw.get("code", 0)))
    names = [name for field in fields for name in field.element_names()]
    if len(set(names)) != len(names):
        raise TableError(f"{where}: a name stands twice")
    for field in fields:
        if field.valid is not None and field.valid not in layout.flags:
            raise TableError(f"{where}: {field.name} is valid by {field.valid}, which is no flag of the packet")
    if layout.flags and not any(field.is_flags for field in fields):
        raise TableError(f"{where}: has flags but no field for them")
    if layout.flags_number and (len(layout.flags) != 8 - FLAGS_NUMBER_BITS or layout.flags_number in names):
        raise TableError(f"{where}: {layout.flags_number} in the flags: beside four flags, by a name that no field has")
    return layout


def read_packet(raw: dict) -> Layout:
    packet = read_layout(raw, HEADER_OCTETS, f"packet {raw['name']}", "fields")
    if packet.octets > PACKET_OCTETS_MAX or packet.octets % 2:
        raise TableError(f"packet {packet.name}: {packet.octets} octets; allowed are even numbers up to {PACKET_OCTETS_MAX}")
    return packet


def read_command(raw: dict) -> Layout:
    where = f"command {raw['name']}"
    command = read_layout(raw, COMMAND_HEADER_OCTETS, where, "arguments")
    if "entry" in raw:
        command.entry = read_layout({**raw, "name": raw["name"] + "_entry"}, 0, where, "entry")
        command.repeated = raw["repeated"]
        if command.octets + command.repeated * command.entry.end > PACKET_OCTETS_MAX:
            raise TableError(f"{where}: longer than {PACKET_OCTETS_MAX} octets")
    return command


def read_events(raw: dict, severities: tuple[str, ...]) -> list[Event]:
    events = [Event(**{**entry, "arguments": [Argument(**argument) for argument in entry["arguments"]]},
                    burst=raw["command_burst" if entry["id"] in COMMAND_EVENTS else "burst"]) for entry in raw["event"]]
    for event in events:
        if event.severity not in severities or len(event.text) > TEXT_OCTETS_MAX or not event.text.isascii():
            raise TableError(f"event {event.name}: severity, or text longer than {TEXT_OCTETS_MAX} ASCII characters")
        names = [argument.name for argument in event.arguments]
        if (len(event.numbers) > EVENT_NUMBERS_MAX or len(event.arguments) - len(event.numbers) > 1 or len(set(names)) != len(names)
                or {argument.type for argument in event.arguments} - set(SIZES)):
            raise TableError(f"event {event.name}: two numbers and a word at most, of known types, and each name once")
        if unknown := set(re.findall(r"{(\w*)}", event.text)) - set(names):
            raise TableError(f"event {event.name}: its text names {', '.join(sorted(unknown))}, which is no argument")
    if len({event.id for event in events}) != len(events):
        raise TableError("events: an id stands twice")
    return events


def codes_of(table: Table, faults: list[str]) -> dict[str, dict[int, str]]:
    codes = {"commands": {**{command.number: command.name for command in table.commands}, NO_COMMAND: "none"},
             "events": {event.id: event.name for event in table.events}, "faults": dict(enumerate(faults))}
    codes.update((f"{packet.name}.{field.name}", dict(enumerate(field.enum))) for packet in table.packets for field in packet.fields if field.enum)
    if unknown := set(table.codes_in_use) - set(codes):
        raise TableError(f"names or words of {', '.join(sorted(unknown))}: no such codes")
    return codes


def read_table(folder: pathlib.Path) -> Table:
    def load(name):
        return tomllib.loads((folder / name).read_text())

    telemetry, commands, events = load("telemetry.toml"), load("commands.toml"), load("events.toml")
    if telemetry["layout_version"] != commands["layout_version"]:
        raise TableError("telemetry.toml and commands.toml have different layout versions")
    parameters = [Parameter(**raw) for raw in load("parameters.toml")["parameter"]]
    table = Table(layout_version=telemetry["layout_version"], apid_first=telemetry["apid_first"], apid_command=commands["apid"],
                  packets=[read_packet(raw) for raw in telemetry["packet"]],
                  commands=[read_command(raw) for raw in commands["command"]], events=[], parameters=parameters, codes={})
    table.events = read_events(events, table.severities)
    table.codes = codes_of(table, events["faults"])
    numbers = [packet.number for packet in table.packets] + [table.apid_command]
    codes = [command.number for command in table.commands]
    if len(set(numbers)) != len(numbers) or codes != list(range(len(codes))):
        raise TableError("an APID stands twice, or the command codes are not 0, 1, 2, ...")
    return table
