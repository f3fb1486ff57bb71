"""XTCE 1.2 (OMG), as mission control systems read it: flat parameters, one container a packet, one meta-command a command."""

import re
from xml.sax.saxutils import quoteattr

from .table import Field, Layout, Table

NAMESPACE = "http://www.omg.org/spec/XTCE/20180204"
SCHEMA = "https://www.omg.org/spec/XTCE/20180204/SpaceSystem.xsd"
BITS = {"u8": 8, "u16": 16, "u32": 32, "u64": 64, "i64": 64, "f32": 32, "f64": 64}
# Name, bits, what it is: the header that every packet begins with.
HEADER = [("VERSION", 3, "packet version number, 0"), ("TYPE", 1, "0: telemetry"), ("SEC_HDR_FLG", 1, "1: secondary header"),
          ("PKT_APID", 11, "application process id"), ("SEQ_FLGS", 2, "3: unsegmented"),
          ("SRC_SEQ_CTR", 14, "count of this APID, wraps"), ("PKT_LEN", 16, "octets of the packet less 7"),
          ("CUC_P_FIELD", 8, "0x2F"), ("CUC_SECONDS", 32, "since 1970-01-01T00:00:00"), ("CUC_FRACTION", 24, "units of 2^-24 s"),
          ("LAYOUT_VERSION", 8, "of the field table"), ("TIME_QUALITY", 8, "0: camera time; 1: does not fit")]


def type_name(field: Field) -> str:
    parts = [field.type if field.type != "text" else f"text{field.count}"]
    if field.enum:
        parts.append("_".join(field.enum).lower())
    elif field.unit:
        parts.append(re.sub(r"\W+", "_", field.unit.replace("^", "")).strip("_"))
    return "_".join(parts)


def unit_set(unit: str) -> str:
    return f"<UnitSet><Unit>{unit}</Unit></UnitSet>" if unit else "<UnitSet/>"


def integer_encoding(bits: int, signed: bool) -> str:
    return f'<IntegerDataEncoding sizeInBits="{bits}" encoding="{"twosComplement" if signed else "unsigned"}"/>'


def data_type(field: Field, role: str) -> str:
    """A <role>Type, Parameter or Argument."""
    name = type_name(field)
    if field.type == "text":
        size = f"<SizeInBits><Fixed><FixedValue>{8 * field.count}</FixedValue></Fixed><TerminationChar>00</TerminationChar></SizeInBits>"
        return (f'<String{role}Type name="{name}"><UnitSet/><StringDataEncoding encoding="US-ASCII">{size}'
                f"</StringDataEncoding></String{role}Type>")
    if field.enum:
        labels = "".join(f'<Enumeration value="{value}" label="{label}"/>' for value, label in enumerate(field.enum))
        return (f'<Enumerated{role}Type name="{name}"><UnitSet/>{integer_encoding(BITS[field.type], False)}'
                f"<EnumerationList>{labels}</EnumerationList></Enumerated{role}Type>")
    if field.type.startswith("f"):
        bits = BITS[field.type]
        return (f'<Float{role}Type name="{name}" sizeInBits="{bits}">{unit_set(field.unit)}'
                f'<FloatDataEncoding sizeInBits="{bits}" encoding="IEEE754_1985"/></Float{role}Type>')
    bits, signed = BITS[field.type], field.type.startswith("i")
    return (f'<Integer{role}Type name="{name}" sizeInBits="{bits}" signed="{str(signed).lower()}">{unit_set(field.unit)}'
            f"{integer_encoding(bits, signed)}</Integer{role}Type>")


def header_types() -> dict[str, str]:
    bits = sorted({bits for _, bits, _ in HEADER} | {1})
    types = {f"bits{n}": f'<IntegerParameterType name="bits{n}" sizeInBits="{max(n, 8)}" signed="false"><UnitSet/>'
                         f"{integer_encoding(n, False)}</IntegerParameterType>" for n in bits}
    types["flag"] = ('<BooleanParameterType name="flag" oneStringValue="yes" zeroStringValue="no"><UnitSet/>'
                     f"{integer_encoding(1, False)}</BooleanParameterType>")
    return types


def flag_parameters(packet: Layout) -> list[tuple[str, str, str]]:
    """Name, type, help of the flags' bits, greatest first as they stand in the octet."""
    spare = 8 - len(packet.flags)
    rows = [(f"{packet.name}_flag_spare_{bit}", "bits1", "0") for bit in range(spare)]
    return rows + [(f"{packet.name}_flag_{flag}", "flag", "") for flag in reversed(packet.flags)]


def parameters(packet: Layout) -> list[tuple[str, str, str]]:
    rows = []
    for field in packet.fields:
        if field.is_flags and packet.flags:
            rows += flag_parameters(packet)
        else:
            rows += [(f"{packet.name}_{name}", type_name(field), field.help) for name in field.element_names()]
    return rows


def parameter(name: str, kind: str, help: str) -> str:
    about = f" shortDescription={quoteattr(help)}" if help else ""
    return f'      <Parameter name="{name}" parameterTypeRef="{kind}"{about}/>\n'


def references(names: list[str]) -> str:
    return "".join(f'          <ParameterRefEntry parameterRef="{name}"/>\n' for name in names)


def container(packet: Layout, table: Table) -> str:
    names = [name for name, _, _ in parameters(packet)] + ["CRC"]
    return (f'      <SequenceContainer name="{packet.name}" shortDescription={quoteattr(packet.help)}>\n        <EntryList>\n'
            f'{references(names)}        </EntryList>\n        <BaseContainer containerRef="CCSDSPacket">\n'
            f"          <RestrictionCriteria>\n"
            f'            <Comparison parameterRef="PKT_APID" value="{table.apid_first + packet.number}"/>\n'
            f"          </RestrictionCriteria>\n        </BaseContainer>\n      </SequenceContainer>\n")


def telemetry(table: Table) -> str:
    types = header_types()
    rows = [(name, f"bits{bits}", help) for name, bits, help in HEADER] + [("CRC", "bits16", "CRC-16/CCITT-FALSE of all octets before it")]
    for packet in table.packets:
        types.update((type_name(field), data_type(field, "Parameter")) for field in packet.fields
                     if not (field.is_flags and packet.flags))
        rows += parameters(packet)
    text = "  <TelemetryMetaData>\n    <ParameterTypeSet>\n" + "".join(f"      {types[name]}\n" for name in sorted(types))
    text += "    </ParameterTypeSet>\n    <ParameterSet>\n" + "".join(parameter(*row) for row in rows)
    text += '    </ParameterSet>\n    <ContainerSet>\n      <SequenceContainer name="CCSDSPacket" abstract="true">\n        <EntryList>\n'
    text += references([name for name, _, _ in HEADER]) + "        </EntryList>\n      </SequenceContainer>\n"
    return text + "".join(container(packet, table) for packet in table.packets) + "    </ContainerSet>\n  </TelemetryMetaData>\n"


def meta_command(command: Layout) -> str:
    arguments, entries = "", f'<FixedValueEntry name="code" binaryValue="{command.number:02X}" sizeInBits="8"/>'
    for field in command.fields:
        for name in field.element_names():
            if field.name == "spare":
                entries += f'<FixedValueEntry name="{name}" binaryValue="{"00" * field.size}" sizeInBits="{8 * field.size}"/>'
                continue
            arguments += f'<Argument name="{name}" argumentTypeRef="{type_name(field)}"/>'
            entries += f'<ArgumentRefEntry argumentRef="{name}"/>'
    listed = f"<ArgumentList>{arguments}</ArgumentList>" if arguments else ""
    return (f'      <MetaCommand name="{command.name}" shortDescription={quoteattr(command.help)}>'
            f'<BaseMetaCommand metaCommandRef="command"/>{listed}<CommandContainer name="{command.name}"><EntryList>{entries}</EntryList>'
            f'<BaseContainer containerRef="command"/></CommandContainer></MetaCommand>\n')


def commands(table: Table) -> str:
    """Commands with repeated entries are not here: XTCE systems differ in how they take such lists."""
    plain = [command for command in table.commands if command.entry is None]
    types = {type_name(field): data_type(field, "Argument") for command in plain for field in command.fields}
    first = 0x1800 | (table.apid_first + table.apid_command)
    header = "".join(f'<FixedValueEntry name="{name}" binaryValue="{value}" sizeInBits="{4 * len(value)}"/>' for name, value in
                     [("identification", f"{first:04X}"), ("sequence", "C000"), ("length", "0000"),
                      ("layout_version", f"{table.layout_version:02X}")])
    return ("  <CommandMetaData>\n    <ArgumentTypeSet>\n" + "".join(f"      {types[name]}\n" for name in sorted(types))
            + "    </ArgumentTypeSet>\n    <MetaCommandSet>\n"
            + f'      <MetaCommand name="command" abstract="true"><CommandContainer name="command"><EntryList>{header}</EntryList>'
            + "</CommandContainer></MetaCommand>\n" + "".join(map(meta_command, plain)) + "    </MetaCommandSet>\n  </CommandMetaData>\n")


def space_system(name: str, content: str) -> str:
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<!-- Written by tools/generate_bus.py from config/bus/*.toml: change those. -->\n'
            f'<SpaceSystem name="{name}" xmlns="{NAMESPACE}" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
            f'xsi:schemaLocation="{NAMESPACE} {SCHEMA}" shortDescription="Motion and shape of a tumbling object from one camera">\n'
            f"{content}</SpaceSystem>\n")


def files(table: Table) -> dict[str, str]:
    """Commands in a file of their own: readers of telemetry stumble over containers that are none."""
    return {"config/bus/polhode.xtce.xml": space_system("polhode", telemetry(table)),
            "config/bus/polhode_commands.xtce.xml": space_system("polhode_commands", commands(table))}
