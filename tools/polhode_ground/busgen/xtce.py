"""XTCE 1.2 (OMG), as mission control systems read it: flat parameters, one container a packet. Commands: xtce_commands.py."""

import re
from xml.sax.saxutils import escape, quoteattr

from .table import FLAGS_NUMBER_BITS, Field, Layout, Table

NAMESPACE = "http://www.omg.org/spec/XTCE/20180204"
SCHEMA = "https://www.omg.org/spec/XTCE/20180204/SpaceSystem.xsd"
BITS = {"u8": 8, "u16": 16, "u32": 32, "u64": 64, "i64": 64, "f32": 32, "f64": 64}
# Name, bits, what it is: the header that every packet begins with.
HEADER = [("VERSION", 3, "packet version number, 0"), ("TYPE", 1, "0: telemetry"), ("SEC_HDR_FLG", 1, "1: secondary header"),
          ("PKT_APID", 11, "application process id"), ("SEQ_FLGS", 2, "3: unsegmented"),
          ("SRC_SEQ_CTR", 14, "count of this APID, wraps"), ("PKT_LEN", 16, "octets of the packet less 7"),
          ("CUC_P_FIELD", 8, "0x2F"), ("CUC_SECONDS", 32, "since 1970-01-01T00:00:00"), ("CUC_FRACTION", 24, "units of 2^-24 s"),
          ("LAYOUT_VERSION", 8, "of the field table"), ("TIME_QUALITY", 8, "0: camera time; 1: does not fit")]


def type_name(field: Field, packet: Layout) -> str:
    """Shared by fields of one type, unit and words; a field with an alarm or names has one of its own."""
    if field.alarm or field.names:
        return f"{packet.name}_{field.name}"
    parts = [field.type if field.type != "text" else f"text{field.count}"]
    if field.enum:
        parts.append("_".join(field.enum).lower())
    elif field.unit:
        parts.append(re.sub(r"\W+", "_", field.unit.replace("^", "")).strip("_"))
    return "_".join(parts)


def unit_set(unit: str) -> str:
    return f"<UnitSet><Unit>{escape(unit)}</Unit></UnitSet>" if unit else "<UnitSet/>"


def integer_encoding(bits: int, signed: bool) -> str:
    return f'<IntegerDataEncoding sizeInBits="{bits}" encoding="{"twosComplement" if signed else "unsigned"}"/>'


def enumeration(labels: dict[int, str], helps: dict[int, str]) -> str:
    def about(value: int) -> str:
        return f" shortDescription={quoteattr(helps[value])}" if helps.get(value) else ""

    rows = "".join(f'<Enumeration value="{value}" label="{label}"{about(value)}/>' for value, label in labels.items())
    return f"<EnumerationList>{rows}</EnumerationList>"


def integer_type(role: str, name: str, bits: int, signed: bool, unit: str, limits: str = "") -> str:
    return (f'<Integer{role}Type name="{name}" sizeInBits="{bits}" signed="{str(signed).lower()}">{unit_set(unit)}'
            f"{integer_encoding(bits, signed)}{limits}</Integer{role}Type>")


def float_type(role: str, name: str, bits: int, unit: str, limits: str = "") -> str:
    return (f'<Float{role}Type name="{name}" sizeInBits="{bits}">{unit_set(unit)}'
            f'<FloatDataEncoding sizeInBits="{bits}" encoding="IEEE754_1985"/>{limits}</Float{role}Type>')


def enumerated_type(role: str, name: str, bits: int, labels: dict[int, str], limits: str = "", helps: dict[int, str] | None = None) -> str:
    """helps: of some of the labels."""
    return (f'<Enumerated{role}Type name="{name}"><UnitSet/>{integer_encoding(bits, False)}{enumeration(labels, helps or {})}{limits}'
            f"</Enumerated{role}Type>")


def numeric_alarm(field: Field) -> str:
    rows = "".join(f'<{level.capitalize()}Range maxInclusive="{limit["above"]}"/>' for level, limit in field.alarm.items())
    return f"<DefaultAlarm><StaticAlarmRanges>{rows}</StaticAlarmRanges></DefaultAlarm>" if rows else ""


def enumerated_alarm(field: Field) -> str:
    rows = "".join(f'<EnumerationAlarm alarmLevel="{level}" enumerationLabel="{label}"/>'
                   for level, limit in field.alarm.items() for label in limit["at"])
    return f"<DefaultAlarm><EnumerationAlarmList>{rows}</EnumerationAlarmList></DefaultAlarm>" if rows else ""


def labels_of(field: Field, table: Table) -> dict[int, str]:
    if not field.names:
        return dict(enumerate(field.enum))
    # Readers refuse a packet with a value that has no label, as a command of an unknown code leaves it in housekeeping.
    others = {code: f"code_{code}" for code in range(256)} if field.type == "u8" else {}
    return dict(sorted({**others, **table.codes[field.names]}.items()))


def helps_of(field: Field, table: Table) -> dict[int, str]:
    """Of an event's id: what the packet's values are."""
    return {event.id: event.values_help for event in table.events} if field.names == "events" else {}


def data_type(field: Field, packet: Layout, table: Table) -> str:
    name = type_name(field, packet)
    if field.type == "text":
        size = f"<SizeInBits><Fixed><FixedValue>{8 * field.count}</FixedValue></Fixed><TerminationChar>00</TerminationChar></SizeInBits>"
        return (f'<StringParameterType name="{name}"><UnitSet/><StringDataEncoding encoding="US-ASCII">{size}'
                f"</StringDataEncoding></StringParameterType>")
    if field.enum or field.names:
        return enumerated_type("Parameter", name, BITS[field.type], labels_of(field, table), enumerated_alarm(field), helps_of(field, table))
    if field.type.startswith("f"):
        return float_type("Parameter", name, BITS[field.type], field.unit, numeric_alarm(field))
    return integer_type("Parameter", name, BITS[field.type], field.type.startswith("i"), field.unit, numeric_alarm(field))


def header_types() -> dict[str, str]:
    bits = sorted({bits for _, bits, _ in HEADER} | {1, FLAGS_NUMBER_BITS})
    types = {f"bits{n}": f'<IntegerParameterType name="bits{n}" sizeInBits="{max(n, 8)}" signed="false"><UnitSet/>'
                         f"{integer_encoding(n, False)}</IntegerParameterType>" for n in bits}
    types["flag"] = ('<BooleanParameterType name="flag" oneStringValue="yes" zeroStringValue="no"><UnitSet/>'
                     f"{integer_encoding(1, False)}</BooleanParameterType>")
    return types


def flag_parameters(packet: Layout) -> list[tuple[str, str, str]]:
    """Name, type, help of the flags' bits, greatest first as they stand in the octet."""
    spare = 8 - len(packet.flags)
    if packet.flags_number:
        rows = [(f"{packet.name}_{packet.flags_number}", f"bits{FLAGS_NUMBER_BITS}", packet.flags_number_help)]
    else:
        rows = [(f"{packet.name}_flag_spare_{bit}", "bits1", "0") for bit in range(spare)]
    return rows + [(f"{packet.name}_flag_{flag}", "flag", "") for flag in reversed(packet.flags)]


def parameters(packet: Layout) -> list[tuple[str, str, str]]:
    rows = []
    for field in packet.fields:
        if field.is_flags and packet.flags:
            rows += flag_parameters(packet)
        else:
            rows += [(f"{packet.name}_{name}", type_name(field, packet), field.help) for name in field.element_names()]
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
        types.update((type_name(field, packet), data_type(field, packet, table)) for field in packet.fields
                     if not (field.is_flags and packet.flags))
        rows += parameters(packet)
    text = "  <TelemetryMetaData>\n    <ParameterTypeSet>\n" + "".join(f"      {types[name]}\n" for name in sorted(types))
    text += "    </ParameterTypeSet>\n    <ParameterSet>\n" + "".join(parameter(*row) for row in rows)
    text += '    </ParameterSet>\n    <ContainerSet>\n      <SequenceContainer name="CCSDSPacket" abstract="true">\n        <EntryList>\n'
    text += references([name for name, _, _ in HEADER]) + "        </EntryList>\n      </SequenceContainer>\n"
    return text + "".join(container(packet, table) for packet in table.packets) + "    </ContainerSet>\n  </TelemetryMetaData>\n"


def space_system(name: str, content: str) -> str:
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<!-- Written by tools/generate_bus.py from config/bus/*.toml: change those. -->\n'
            f'<SpaceSystem name="{name}" xmlns="{NAMESPACE}" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
            f'xsi:schemaLocation="{NAMESPACE} {SCHEMA}" shortDescription="Motion and shape of a tumbling object from one camera">\n'
            f"{content}</SpaceSystem>\n")


def files(table: Table) -> dict[str, str]:
    return {"config/bus/polhode.xtce.xml": space_system("polhode", telemetry(table))}
