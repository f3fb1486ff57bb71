"""Commands in XTCE: one meta-command a command, and a table_load for every parameter, with ranges and verifiers.

In a file of their own: readers of telemetry stumble over containers that are none."""

from xml.sax.saxutils import quoteattr

from .table import Layout, Parameter, Table
from .xtce import BITS, enumerated_type, float_type, integer_type, space_system

ANSWER = "/polhode/event_"
# The count that YAMCS gave the command. XTCE has no name for it; other systems have to put their own here.
SENT_COUNT = "/yamcs/cmdHist/ccsds-seqcount"
# Events by which the component closes a command: what it came to.
ACCEPTED = ("command_accepted", "noop", "counters_reset", "command_repeated")
REFUSED = ("command_length", "command_header", "command_crc", "command_unknown", "command_range", "command_state")
WAIT_S = 30  # chosen: a command is carried out with the next frame; frames may stay out for seconds, and a machine be busy


def valid_range(limits: tuple[float, float] | None, whole: bool) -> str:
    if limits is None:
        return ""
    low, high = (int(limit) if whole else float(limit) for limit in limits)
    return f'<ValidRangeSet><ValidRange minInclusive="{low}" maxInclusive="{high}"/></ValidRangeSet>'


def number_type(name: str, kind: str, unit: str, limits: tuple[float, float] | None) -> str:
    if kind.startswith("f"):
        return float_type("Argument", name, BITS[kind], unit, valid_range(limits, False))
    return integer_type("Argument", name, BITS[kind], kind.startswith("i"), unit, valid_range(limits, True))


def argument_name(command: str, argument: str) -> str:
    return f"{command}_{argument}"


def fixed(name: str, value: int, octets: int) -> str:
    return f'<FixedValueEntry name="{name}" binaryValue="{value:0{2 * octets}X}" sizeInBits="{8 * octets}"/>'


def meta_command(name: str, help: str, arguments: str, entries: str) -> str:
    listed = f"<ArgumentList>{arguments}</ArgumentList>" if arguments else ""
    return (f'      <MetaCommand name="{name}" shortDescription={quoteattr(help)}>'
            f'<BaseMetaCommand metaCommandRef="command"/>{listed}<CommandContainer name="{name}"><EntryList>{entries}</EntryList>'
            f'<BaseContainer containerRef="command"/></CommandContainer></MetaCommand>\n')


def argument(name: str, kind: str, help: str) -> str:
    about = f" shortDescription={quoteattr(help)}" if help else ""
    return f'<Argument name="{name}" argumentTypeRef="{kind}"{about}/>'


def plain(command: Layout) -> tuple[str, list[str]]:
    """A command without repeated entries, and its argument types."""
    arguments, entries, types = "", fixed("code", command.number, 1), []
    for field in command.fields:
        kind = argument_name(command.name, field.name)
        types += [number_type(kind, field.type, field.unit, field.range)] if field.name != "spare" else []
        for name in field.element_names():
            if field.name == "spare":
                entries += fixed(name, 0, field.size)
            else:
                arguments += argument(name, kind, field.help)
                entries += f'<ArgumentRefEntry argumentRef="{name}"/>'
    return meta_command(command.name, command.help, arguments, entries), types


def allowed(parameter: Parameter) -> str:
    return ", ".join(parameter.words) or f"{parameter.range[0]} .. {parameter.range[1]} {parameter.unit}".rstrip()


def load(command: Layout, parameter: Parameter) -> tuple[str, str]:
    """A table_load of one entry, and its argument's type."""
    name = f"{command.name}_{parameter.key.replace('.', '_')}"
    kind = argument_name(name, "value")
    head = {"entries": 1}
    entries = fixed("code", command.number, 1)
    entries += "".join(fixed(f"head_{field_name}", head.get(field.name, 0), field.size)
                       for field in command.fields for field_name in field.element_names())
    for field in command.entry.fields:
        entries += ('<ArgumentRefEntry argumentRef="value"/>' if field.name == "value"
                    else fixed(field.name, parameter.crc if field.name == "key_crc" else 0, field.size))
    default = str(parameter.default).lower() if isinstance(parameter.default, bool) else parameter.default
    help = f"loads {parameter.key} into the inactive table: {parameter.help}; {allowed(parameter)}; default {default}"
    bits = BITS[parameter.type]
    data_type = (enumerated_type("Argument", kind, bits, dict(enumerate(parameter.words))) if parameter.words
                 else number_type(kind, parameter.type, parameter.unit, parameter.range))
    return meta_command(name, help, argument("value", kind, parameter.help), entries), data_type


def condition(left: str, right: str) -> str:
    return f'<Condition><ParameterInstanceRef parameterRef="{left}"/><ComparisonOperator>==</ComparisonOperator>{right}</Condition>'


def answered_by(events: tuple[str, ...]) -> str:
    """One of these events, which bears the count of this command."""
    ids = "".join(condition(ANSWER + "id", f"<Value>{event}</Value>") for event in events)
    count = condition(ANSWER + "command_sequence", f'<ParameterInstanceRef parameterRef="{SENT_COUNT}"/>')
    return f"<BooleanExpression><ANDedConditions>{count}<ORedConditions>{ids}</ORedConditions></ANDedConditions></BooleanExpression>"


def verifiers() -> str:
    window = f'<CheckWindow timeToStopChecking="PT{WAIT_S}S" timeWindowIsRelativeTo="commandRelease"/>'
    text = f'<ReturnParmRef parameterRef="{ANSWER}text"/>'
    unanswered = '<AncillaryDataSet><AncillaryData name="yamcs.onTimeout">FAIL</AncillaryData></AncillaryDataSet>'
    return (f"<VerifierSet><AcceptedVerifier>{answered_by(ACCEPTED)}{window}</AcceptedVerifier>"
            f"<CompleteVerifier>{unanswered}{answered_by(ACCEPTED)}{window}{text}</CompleteVerifier>"
            f"<FailedVerifier>{answered_by(REFUSED)}{window}{text}</FailedVerifier></VerifierSet>")


def base_command(table: Table) -> str:
    first = 0x1800 | (table.apid_first + table.apid_command)
    header = fixed("identification", first, 2) + fixed("sequence", 0xC000, 2) + fixed("length", 0, 2)
    header += fixed("layout_version", table.layout_version, 1)
    return (f'      <MetaCommand name="command" abstract="true"><CommandContainer name="command"><EntryList>{header}</EntryList>'
            f"</CommandContainer>{verifiers()}</MetaCommand>\n")


def commands(table: Table) -> str:
    types, meta = [], ""
    for command in table.commands:
        made = [load(command, parameter) for parameter in table.parameters] if command.entry else [plain(command)]
        for text, kinds in made:
            meta += text
            types += kinds if isinstance(kinds, list) else [kinds]
    return ("  <CommandMetaData>\n    <ArgumentTypeSet>\n" + "".join(f"      {kind}\n" for kind in types)
            + "    </ArgumentTypeSet>\n    <MetaCommandSet>\n" + base_command(table) + meta
            + "    </MetaCommandSet>\n  </CommandMetaData>\n")


def files(table: Table) -> dict[str, str]:
    return {"config/bus/polhode_commands.xtce.xml": space_system("polhode_commands", commands(table))}
