"""Python: the table by which the client package decodes packets and makes commands."""

import dataclasses

from .table import Field, Layout, Parameter, Table

NOTE = '"""Written by tools/generate_bus.py from config/bus/*.toml: change those."""\n\n'
CODES = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i64": "q", "f32": "f", "f64": "d", "text": "s"}


def field_row(field: Field, layout: Layout) -> str:
    valid = layout.flags.index(field.valid) if field.valid else None
    shape = None if not field.is_array else (field.rows, field.count // field.rows) if field.rows > 1 else (field.count,)
    return f'        ("{field.name}", "{CODES[field.type]}", {field.count}, {field.offset}, {shape}, {valid}, {field.enum}),\n'


def layout_text(layout: Layout, rest: str = "") -> str:
    octets = layout.octets
    return (f'    {layout.number}: ("{layout.name}", {octets}, {layout.flags}, [\n'
            + "".join(field_row(field, layout) for field in layout.fields) + f"    ]{rest}),\n")


def as_tuple(parameter: Parameter) -> Parameter:
    """Its range as Python reads it back."""
    return dataclasses.replace(parameter, range=parameter.range and tuple(parameter.range))


def files(table: Table) -> dict[str, str]:
    text = NOTE + f"LAYOUT_VERSION = {table.layout_version}\nAPID_FIRST = {table.apid_first}\nAPID_COMMAND = {table.apid_command}\n\n"
    text += "# Number of the packet (its APID less the first one): name, octets, flags, fields as (name, code of struct, values,\n"
    text += "# octet, shape, bit of the flag that has to be up, names of the values 0, 1, ...), name of the number in the upper four\n"
    text += "# bits of the flags, or nothing.\nPACKETS = {\n"
    text += "".join(layout_text(packet, f', "{packet.flags_number}"') for packet in table.packets)
    text += "}\n\n# Function code: the same, without such a number.\nCOMMANDS = {\n"
    text += "".join(map(layout_text, table.commands)) + "}\n\n# Entries of commands that repeat them.\nENTRIES = {\n"
    text += "".join(f'    "{command.name}": {[(f.name, CODES[f.type]) for f in command.entry.fields]},\n'
                    for command in table.commands if command.entry) + "}\n\n"
    text += "# Event id: name, severity, and of each of its numbers name, unit and what it is a code of (a key of CODES; empty: it is a number).\nEVENTS = {\n"
    text += "".join(f'    {event.id}: ("{event.name}", "{event.severity}", {[(n.name, n.unit, n.codes) for n in event.numbers]}),\n'
                    for event in table.events) + "}\n\n"
    text += "# Names of codes.\nCODES = {\n" + "".join(f'    "{name}": {table.codes[name]},\n' for name in table.codes_in_use) + "}\n\n"
    named = [(packet.name, field) for packet in table.packets for field in packet.fields if field.names]
    text += "# Fields whose value is a code: its names.\nNAMED = {\n" + "".join(f'    ("{packet}", "{field.name}"): "{field.names}",\n' for packet, field in named) + "}\n"
    parameters = NOTE + "# What make_table_load() may change: type, least and greatest value, words for the values 0, 1, ...\nPARAMETERS = {\n"
    parameters += "".join(f'    "{row.key}": ("{row.type}", {row.range}, {tuple(row.words)}),\n' for row in map(as_tuple, table.parameters)) + "}\n"
    folder = "platform/transport/client/python/polhode_bus"
    return {f"{folder}/packets.py": text, f"{folder}/parameters.py": parameters}
