"""C++: plain structs, offsets, and the tables by which they are packed, unpacked and printed."""

from .table import FLAGS_NUMBER_BITS, Argument, Event, Field, Layout, Table

NOTE = "// Written by tools/generate_bus.py from config/bus/*.toml: change those.\n"
TYPES = {"u8": "std::uint8_t", "u16": "std::uint16_t", "u32": "std::uint32_t", "u64": "std::uint64_t", "i64": "std::int64_t",
         "f32": "float", "f64": "double", "text": "char"}
DEFAULTS = {"f32": "0.0F", "f64": "0.0"}


def camel(name: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def constant(name: str) -> str:
    """k and the field's own name: frames and units stay readable, kQ_CT, kTimestamp_ns."""
    return "k" + name[0].upper() + name[1:]


def struct_name(layout: Layout, kind: str) -> str:
    return camel(layout.name) + kind


def comment(field: Field) -> str:
    parts = [field.help] if field.help else []
    if field.unit:
        parts.append(field.unit)
    if field.valid:
        parts.append(f"flag {field.valid}")
    return f"  ///< {'; '.join(parts)}" if parts else ""


def member(field: Field) -> str:
    kind = TYPES[field.type]
    if field.is_array:
        return f"  std::array<{kind}, {field.count}> {field.name}{{}};{comment(field)}\n"
    return f"  {kind} {field.name} = {DEFAULTS.get(field.type, '0')};{comment(field)}\n"


def struct(layout: Layout, kind: str, table_name: str) -> str:
    name = struct_name(layout, kind)
    text = f"/// {layout.help}\nstruct {name} {{\n" if layout.help else f"struct {name} {{\n"
    text += "".join(member(field) for field in layout.fields)
    text += f"  static const Layout& layout();  ///< {table_name}\n}};\n\n"
    return text


def enum(name: str, rows: list[tuple[str, int]], kind: str) -> str:
    body = "".join(f"  k{camel(row.lower())} = {number},\n" for row, number in rows)
    return f"enum class {name} : {kind} {{\n{body}}};\n\n"


def packets_header(table: Table) -> str:
    text = NOTE + "// Everything on the bus as plain data: telemetry packets and the arguments of commands.\n"
    text += '#pragma once\n\n#include <array>\n#include <cstdint>\n\n#include "bus/fields.hpp"\n\nnamespace polhode::bus {\n\n// clang-format off\n'
    text += enum("PacketId", [(packet.name, packet.number) for packet in table.packets], "std::uint8_t")
    text += f"inline constexpr std::size_t kPacketKinds = {max(p.number for p in table.packets) + 1};\n"
    text += f"inline constexpr int kCommandApid = {table.apid_command};  ///< above the first one\n\n"
    text += enum("CommandCode", [(command.name, command.number) for command in table.commands], "std::uint8_t")
    housekeeping = table.packet("housekeeping")
    rejection = next(field for field in housekeeping.fields if field.name == "last_rejection")
    text += enum("Rejection", [(name, number) for number, name in enumerate(rejection.enum)], "std::uint8_t")
    text += "".join(struct(packet, "Packet", f"{packet.octets} octets") for packet in table.packets)
    for command in table.commands:
        if command.fields:
            text += struct(command, "Command", "with the CRC and no entries" if command.entry else f"{command.octets} octets")
        if command.entry:
            text += f"inline constexpr std::size_t k{camel(command.name)}EntriesMax = {command.repeated};\n"
            command.entry.help = ""
            text += struct(command.entry, "", f"{command.entry.end} octets, offsets from its first")
    return text + "// clang-format on\n\n}  // namespace polhode::bus\n"


def layout_header(table: Table) -> str:
    text = NOTE + "// Offsets of all fields from their packet's first octet.\n#pragma once\n\n#include <cstddef>\n#include <cstdint>\n\n"
    text += "namespace polhode::bus {\n\n// clang-format off\n"
    text += f"inline constexpr std::uint8_t kLayoutVersion = {table.layout_version};\n"
    for layout in [*table.packets, *[command for command in table.commands if command.fields]]:
        text += f"\nnamespace {layout.name}_layout {{\n"
        for field in layout.fields:
            kind = f"{field.count} x {field.type}" if field.is_array else field.type
            text += f"inline constexpr std::size_t {constant(field.name)} = {field.offset};  ///< {kind}\n"
        text += f"inline constexpr std::size_t kCrc = {layout.end};  ///< u16 over all octets before it\n" if not layout.entry else ""
        text += f"inline constexpr std::size_t kPacketOctets = {layout.octets};\n"
        for bit, flag in enumerate(layout.flags):
            text += f"inline constexpr std::uint8_t kFlag{camel(flag)} = 0x{1 << bit:02X};\n"
        if layout.flags:
            text += f"inline constexpr std::uint8_t kFlagsUsed = 0x{(1 << len(layout.flags)) - 1:02X};\n"
        if layout.flags_number:
            name = camel(layout.flags_number)
            text += f"inline constexpr unsigned k{name}Shift = {8 - FLAGS_NUMBER_BITS};  ///< its place in the flags\n"
            text += f"inline constexpr std::uint32_t k{name}s = {1 << FLAGS_NUMBER_BITS};  ///< it counts modulo this\n"
        text += f"}}  // namespace {layout.name}_layout\n"
    return text + "// clang-format on\n\n}  // namespace polhode::bus\n"


def number(value: float) -> str:
    if value in (float("inf"), float("-inf")):
        return "-kNoLimit" if value < 0 else "kNoLimit"
    return repr(float(value))


def names_of(codes: str) -> str:
    """The array of code_names.hpp; none for codes without a name."""
    return f"k{camel(codes.replace('.', '_'))}Names" if codes else "{}"


def field_row(field: Field, owner: str, layout: Layout) -> str:
    flags = layout.flags
    low, high = field.range or (float("-inf"), float("inf"))
    if field.enum:
        low, high = 0, len(field.enum) - 1
    if field.is_flags:
        low, high = 0, (1 << len(flags) + (FLAGS_NUMBER_BITS if layout.flags_number else 0)) - 1
    valid = flags.index(field.valid) if field.valid else -1
    return (f'    {{"{field.name}", FieldType::k{field.type.capitalize()}, {field.count}, {str(field.is_array).lower()}, {field.offset}, '
            f'offsetof({owner}, {field.name}), {valid}, {number(low)}, {number(high)}, '
            f'"{" ".join(field.elements)}", "{field.unit}", "{" ".join(field.enum)}", {names_of(field.names)}}},\n')


def layout_rows(layout: Layout, kind: str, where: str) -> str:
    owner = struct_name(layout, kind)
    flags = next((f"offsetof({owner}, flags)" for field in layout.fields if field.is_flags), "kNoFlags")
    octets = layout.octets if kind else layout.end
    return (f"constexpr Field {where}[] = {{\n" + "".join(field_row(field, owner, layout) for field in layout.fields)
            + f"}};\nconstexpr Layout {where}Layout{{\"{layout.name}\", {layout.number}, {octets}, {where}, {flags}, "
            f"\"{' '.join(layout.flags)}\", \"{layout.flags_number}\"}};\nstatic_assert(sizeof({owner}) <= kStructOctetsMax);\n\n")


def packet_table(table: Table) -> str:
    text = NOTE + '#include <cstddef>\n\n#include "bus/packets.hpp"\n\nnamespace polhode::bus {\nnamespace {\n\n// clang-format off\n'
    ends, rows, commands = "", [], []
    for packet in table.packets:
        where = f"k{camel(packet.name)}Packet"
        text += layout_rows(packet, "Packet", where)
        ends += f"const Layout& {camel(packet.name)}Packet::layout() {{ return {where}Layout; }}\n"
        rows.append(f"&{where}Layout")
    for command in table.commands:
        where = f"k{camel(command.name)}Command"
        if command.fields:
            text += layout_rows(command, "Command", where)
            ends += f"const Layout& {camel(command.name)}Command::layout() {{ return {where}Layout; }}\n"
        else:
            text += f'constexpr Layout {where}Layout{{"{command.name}", {command.number}, {command.octets}, {{}}, kNoFlags, "", ""}};\n\n'
        commands.append(f"&{where}Layout")
        if command.entry:
            text += layout_rows(command.entry, "", f"k{camel(command.entry.name)}")
            ends += f"const Layout& {camel(command.entry.name)}::layout() {{ return k{camel(command.entry.name)}Layout; }}\n"
    text += f"constexpr const Layout* kPackets[] = {{{', '.join(rows)}}};\n"
    text += f"constexpr const Layout* kCommands[] = {{{', '.join(commands)}}};\n"
    text += "// clang-format on\n\n}  // namespace\n\n" + ends
    text += "\nstd::span<const Layout* const> packet_layouts() { return kPackets; }\n"
    text += "std::span<const Layout* const> command_layouts() { return kCommands; }\n"
    return text + "\n}  // namespace polhode::bus\n"


def counters_of(table: Table) -> list[Field]:
    return [field for field in table.packet("housekeeping").fields if field.is_counter]


def counters_header(table: Table) -> str:
    text = NOTE + "// What the component counts.\n#pragma once\n\n#include <cstdint>\n\nnamespace polhode {\n\n// clang-format off\n"
    text += "/// All start at 0, wrap at 2^32 and go to 0 by the command reset_counters.\nstruct Counters {\n"
    return text + "".join(map(member, counters_of(table))) + "};\n// clang-format on\n\n}  // namespace polhode\n"


def counter_table(table: Table) -> str:
    fields = counters_of(table)
    text = NOTE + "// Every counter by its name, and where it stands in the housekeeping packet.\n#pragma once\n\n#include <array>\n"
    text += '#include <cstdint>\n\n#include "bus/counters.hpp"\n#include "bus/packets.hpp"\n\nnamespace polhode::bus {\n\n// clang-format off\n'
    text += "struct CounterRow {\n  const char* name;\n  std::uint32_t Counters::*counted;\n  std::uint32_t HousekeepingPacket::*published;\n};\n\n"
    text += f"inline constexpr std::array<CounterRow, {len(fields)}> kCounters{{{{\n"
    text += "".join(f'    {{"{field.name}", &Counters::{field.name}, &HousekeepingPacket::{field.name}}},\n' for field in fields)
    return text + "}};\n// clang-format on\n\n}  // namespace polhode::bus\n"


def event_row(event: Event) -> str:
    return f'    {{EventId::k{camel(event.name)}, Severity::k{camel(event.severity.lower())}, {event.burst}, "{event.name}", "{event.pattern}", {{{{{names_of(event.words[0])}, {names_of(event.words[1])}}}}}}},\n'


def event_header(table: Table) -> str:
    text = NOTE + "// All events: id, severity and the text for people.\n#pragma once\n\n#include <array>\n#include <cstddef>\n"
    text += '#include <cstdint>\n#include <span>\n\n#include "bus/code_names.hpp"\n\nnamespace polhode::bus {\n\n// clang-format off\n'
    text += enum("Severity", [(name, number) for number, name in enumerate(table.severities)], "std::uint8_t")
    text += enum("EventId", [(event.name, event.id) for event in table.events], "std::uint16_t")
    text += "struct EventRow {\n  EventId id;\n  Severity severity;\n  std::uint32_t burst;  ///< sent at most in a window of frames\n  const char* name;\n"
    text += "  const char* text;  ///< {0}, {1}: the event's numbers; {}: its word\n"
    text += "  std::array<std::span<const CodeName>, 2> words;  ///< what the numbers are codes of; empty for numbers\n};\n\n"
    text += f"inline constexpr std::size_t kEventKinds = {len(table.events)};\n"
    text += "inline constexpr std::array<EventRow, kEventKinds> kEvents{{\n" + "".join(map(event_row, table.events)) + "}};\n"
    return text + "// clang-format on\n\n}  // namespace polhode::bus\n"


# C++ types of codes that have one of their own; of the others it is the number's.
CODE_TYPES = {"commands": "CommandCode", "motion.mode": "Mode", "faults": "FrameFault"}
ARGUMENT_TYPES = {**TYPES, "text": "std::string_view"}


def argument_member(argument: Argument) -> str:
    """Without a default: a call that leaves one out does not compile."""
    help = argument.help.removeprefix(argument.name).strip(" ()")
    kind = CODE_TYPES.get(argument.codes, ARGUMENT_TYPES[argument.type])
    return f"  {kind} {argument.name};{f'  ///< {help}' if help else ''}\n"


def event_parameters(event: Event) -> str:
    return f"const {camel(event.name)}& is, EventLog* log" if event.arguments else "EventLog* log"


def event_reports_header(table: Table) -> str:
    text = NOTE + "// One function an event, with its arguments by name: event::target_lost({.poses = 3}, &log).\n#pragma once\n\n#include <cstdint>\n"
    text += '#include <string_view>\n\n#include "bus/packets.hpp"\n#include "image/verdict.hpp"\n#include "motion/motion_state.hpp"\n\n'
    text += "namespace polhode::bus {\n\nstruct EventLog;\n\nnamespace event {\n\n// clang-format off\n"
    for event in table.events:
        text += f"/// {event.severity}: {event.text}\n"
        if event.arguments:
            text += f"struct {camel(event.name)} {{\n{''.join(map(argument_member, event.arguments))}}};\n"
        text += f"void {event.name}({event_parameters(event)});\n\n"
    return text + "// clang-format on\n\n}  // namespace event\n}  // namespace polhode::bus\n"


def event_details(event: Event) -> str:
    parts = []
    if event.numbers:
        values = [f"is.{number.name}" if number.type == "f64" else f"static_cast<double>(is.{number.name})" for number in event.numbers]
        parts.append(f".values = {{{', '.join(values)}}}")
    if event.word:
        parts.append(f".word = is.{event.word.name}")
    return f"{{{', '.join(parts)}}}"


def event_reports(table: Table) -> str:
    text = NOTE + '#include "bus/event_reports.hpp"\n\n#include "bus/events.hpp"\n\nnamespace polhode::bus::event {\n\n// clang-format off\n'
    text += "".join(f"void {event.name}({event_parameters(event)}) {{ log_event(EventId::k{camel(event.name)}, {event_details(event)}, log); }}\n"
                    for event in table.events)
    return text + "// clang-format on\n\n}  // namespace polhode::bus::event\n"


def code_names_header(table: Table) -> str:
    """Only what a field or an event refers to: an enum's own words stand in its field."""
    text = NOTE + "// Names of codes, for the ground.\n#pragma once\n\n#include <cstdint>\n#include <span>\n#include <string_view>\n\n"
    text += "namespace polhode::bus {\n\n// clang-format off\nstruct CodeName {\n  std::uint16_t code;\n  const char* name;\n};\n\n"
    for codes in table.codes_in_use:
        rows = "".join(f'    {{{code}, "{name}"}},\n' for code, name in table.codes[codes].items())
        text += f"inline constexpr CodeName {names_of(codes)}[] = {{\n{rows}}};\n"
    text += "// clang-format on\n\n/// The name of a code; empty where it has none.\n"
    text += "constexpr std::string_view name_of(std::span<const CodeName> names, double code) {\n  for (const CodeName& row : names) {\n"
    text += "    if (row.code == code) {\n      return row.name;\n    }\n  }\n  return {};\n}\n"
    return text + "\n}  // namespace polhode::bus\n"


def files(table: Table) -> dict[str, str]:
    return {"fsw/bus/code_names.hpp": code_names_header(table), "fsw/bus/packets.hpp": packets_header(table), "fsw/bus/packet_layout.hpp": layout_header(table),
            "fsw/bus/packet_table.cpp": packet_table(table), "fsw/bus/event_table.hpp": event_header(table),
            "fsw/bus/event_reports.hpp": event_reports_header(table), "fsw/bus/event_reports.cpp": event_reports(table),
            "fsw/bus/counters.hpp": counters_header(table), "fsw/bus/counter_table.hpp": counter_table(table)}
