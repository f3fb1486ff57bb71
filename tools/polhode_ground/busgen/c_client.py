"""C: the structs of all telemetry packets and the tables by which the client library fills them."""

from .table import FLAGS_NUMBER_BITS, Field, Layout, Table

NOTE = "/* Written by tools/generate_bus.py from the files in config/bus: change those. */\n"
TYPES = {"u8": "uint8_t", "u16": "uint16_t", "u32": "uint32_t", "u64": "uint64_t", "i64": "int64_t", "f32": "float", "f64": "double",
         "text": "char"}


def member(field: Field) -> str:
    count = field.count + (1 if field.type == "text" else 0)  # C texts end with a zero
    array = f"[{count}]" if field.is_array or field.type == "text" else ""
    about = "; ".join(part for part in (field.help, field.unit, f"flag {field.valid}" if field.valid else "") if part)
    return f"  {TYPES[field.type]} {field.name}{array};{f' /* {about} */' if about else ''}\n"


def about_values(field: Field, code: int, table: Table) -> str:
    """Of an event's id: what the packet's values are."""
    helps = {event.id: event.values_help for event in table.events if event.numbers} if field.names == "events" else {}
    return f" /* {helps[code].replace('value_0', 'value[0]').replace('value_1', 'value[1]')} */" if code in helps else ""


def header(table: Table) -> str:
    text = NOTE + "#ifndef POLHODE_PACKETS_H\n#define POLHODE_PACKETS_H\n\n#include <stdint.h>\n\n"
    text += f"#define POLHODE_LAYOUT_VERSION {table.layout_version}\n#define POLHODE_APID_FIRST {table.apid_first}\n\n"
    for packet in table.packets:
        name = packet.name.upper()
        text += f"#define POLHODE_{name} {packet.number} /* number of the packet: its APID less the first one */\n"
        text += f"#define POLHODE_{name}_OCTETS {packet.octets}\n"
        for bit, flag in enumerate(packet.flags):
            text += f"#define POLHODE_{name}_{flag.upper()} 0x{1 << bit:02X}\n"
        if packet.flags_number:
            text += f"/* {packet.flags_number_help} */\n"
            text += f"#define POLHODE_{name}_{packet.flags_number.upper()}(flags) ((uint8_t)((flags) >> {8 - FLAGS_NUMBER_BITS}))\n"
        text += "".join(f"#define POLHODE_{name}_{field.name.upper()}_{label} {value}\n"
                        for field in packet.fields for value, label in enumerate(field.enum))
        text += "".join(f"#define POLHODE_{name}_{field.name.upper()}_{code_name.upper()} {code}{about_values(field, code, table)}\n"
                        for field in packet.fields if field.names for code, code_name in table.codes[field.names].items())
        text += f"/* {packet.help} */\nstruct polhode_{packet.name} {{\n" + "".join(map(member, packet.fields)) + "};\n\n"
    return text + "#endif\n"


def rows(packet: Layout) -> str:
    owner = f"struct polhode_{packet.name}"
    lines = "".join(f"    {{offsetof({owner}, {field.name}), {field.offset}, {field.count}, POLHODE_TYPE_{field.type.upper()}}},\n"
                    for field in packet.fields)
    return f"static const struct polhode_field {packet.name}_fields[] = {{\n{lines}}};\n"


def source(table: Table) -> str:
    text = NOTE + '#include "polhode_packets.h"\n\n#include <stddef.h>\n\n#include "polhode_fields.h"\n\n'
    text += "".join(map(rows, table.packets)) + "\nconst struct polhode_layout polhode_layouts[] = {\n"
    for packet in table.packets:
        text += (f"    {{{packet.number}, {packet.octets}, sizeof(struct polhode_{packet.name}), {packet.name}_fields, "
                 f"sizeof {packet.name}_fields / sizeof *{packet.name}_fields}},\n")
    return text + "};\nconst size_t polhode_layout_count = sizeof polhode_layouts / sizeof *polhode_layouts;\n"


def files(table: Table) -> dict[str, str]:
    return {"platform/transport/client/c/polhode_packets.h": header(table),
            "platform/transport/client/c/polhode_packets.c": source(table)}
