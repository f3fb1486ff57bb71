"""The command database (XTCE): every command and parameter with its range, verifiers that name events, alarms."""

import re
import tomllib
import xml.etree.ElementTree

import pytest
from flights import REPOSITORY

COMMANDS = REPOSITORY / "config/bus/polhode_commands.xtce.xml"
TELEMETRY = REPOSITORY / "config/bus/polhode.xtce.xml"
PARAMETERS = tomllib.loads((REPOSITORY / "config/bus/parameters.toml").read_text())["parameter"]
X = {"x": "http://www.omg.org/spec/XTCE/20180204"}


@pytest.fixture(scope="module")
def commands():
    root = xml.etree.ElementTree.parse(COMMANDS).getroot()
    return {command.get("name"): command for command in root.iterfind(".//x:MetaCommand", X)}, root


@pytest.fixture(scope="module")
def telemetry():
    root = xml.etree.ElementTree.parse(TELEMETRY).getroot()
    types = {kind.get("name"): kind for kind in root.find(".//x:ParameterTypeSet", X)}
    return {row.get("name"): types[row.get("parameterTypeRef")] for row in root.iterfind(".//x:Parameter", X)}


def argument_type(root, command, name):
    wanted = next(row for row in command.iterfind(".//x:Argument", X) if row.get("name") == name).get("argumentTypeRef")
    return next(kind for kind in root.find(".//x:ArgumentTypeSet", X) if kind.get("name") == wanted)


def octets(root, commands, name, values) -> bytes:
    """The packet that the XTCE describes: header, fixed values, arguments; without length and CRC."""
    out = b""
    for entry in [*commands["command"].iterfind("x:CommandContainer/x:EntryList/*", X),
                  *commands[name].iterfind("x:CommandContainer/x:EntryList/*", X)]:
        if entry.tag.endswith("FixedValueEntry"):
            assert 4 * len(entry.get("binaryValue")) == int(entry.get("sizeInBits"))
            out += bytes.fromhex(entry.get("binaryValue"))
        else:
            out += values[entry.get("argumentRef")]
    return out


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda parameter: parameter["key"])
def test_every_parameter_has_a_table_load_that_gives_the_clients_packet(commands, parameter):
    import struct

    from polhode_bus import make_table_load

    by_name, root = commands
    name = "table_load_" + parameter["key"].replace(".", "_")
    kind = argument_type(root, by_name[name], "value")
    default = parameter["default"]
    if "words" in parameter:
        labels = {row.get("label"): int(row.get("value")) for row in kind.iterfind(".//x:Enumeration", X)}
        assert labels == {word: value for value, word in enumerate(parameter["words"])}
        packed = struct.pack(">q", labels[str(default).lower() if isinstance(default, bool) else default])
    else:
        limits = kind.find("x:ValidRangeSet/x:ValidRange", X)
        assert [float(limits.get("minInclusive")), float(limits.get("maxInclusive"))] == parameter["range"]
        packed = struct.pack(">d" if parameter["type"] == "f64" else ">q", default)
    made, ours = octets(root, by_name, name, {"value": packed}), make_table_load({parameter["key"]: default})
    assert made[:4] == ours[:4] and made[6:] == ours[6:-2]


def test_every_command_is_there_and_every_number_has_its_range(commands):
    by_name, root = commands
    table = tomllib.loads((REPOSITORY / "config/bus/commands.toml").read_text())["command"]
    loads = {"table_load_" + parameter["key"].replace(".", "_") for parameter in PARAMETERS}
    assert set(by_name) == {"command", *loads, *(row["name"] for row in table if row["name"] != "table_load")}
    for row in table:
        for argument in row["arguments"] if row["name"] != "table_load" else []:
            if "range" not in argument:
                assert argument["name"] == "crc32"  # any number
                continue
            first = argument["name"] + (f"_{argument['elements'][0]}" if "elements" in argument else "")
            limits = argument_type(root, by_name[row["name"]], first).find("x:ValidRangeSet/x:ValidRange", X)
            assert [float(limits.get("minInclusive")), float(limits.get("maxInclusive"))] == argument["range"]


def test_the_verifiers_wait_for_all_events_that_close_a_command(commands, telemetry):
    from polhode_bus.packets import EVENTS

    known = {row.get("label") for row in telemetry["event_id"].iterfind(".//x:Enumeration", X)}
    base = commands[0]["command"]
    waited = {}
    for verifier in base.find("x:VerifierSet", X):
        stage = verifier.tag.rpartition("}")[2]
        waited[stage] = {value.text for value in verifier.iterfind(".//x:Value", X)}
        assert waited[stage] <= known
        names = {row.get("parameterRef") for row in verifier.iterfind(".//x:ParameterInstanceRef", X)}
        assert {"/polhode/event_id", "/polhode/event_command_sequence"} <= names
    assert waited["AcceptedVerifier"] == waited["CompleteVerifier"]
    closing = re.search(r"bool closes_a_command.*?\n}", (REPOSITORY / "platform/app/bus_answers.cpp").read_text(), re.DOTALL)[0]
    closing = {name.lower() for name in re.findall(r"EventId::k(\w+):", closing)} - {"commandtoomany"}  # of no single command
    assert {event.replace("_", "") for event in waited["AcceptedVerifier"] | waited["FailedVerifier"]} == closing
    severities = {name: severity for name, severity, _ in EVENTS.values()}
    assert {severities[name] for name in waited["AcceptedVerifier"]} == {"INFO"}
    assert {severities[name] for name in waited["FailedVerifier"]} == {"ERROR"}


def test_alarms_stand_where_the_field_table_has_them(telemetry):
    found = {}
    for packet in tomllib.loads((REPOSITORY / "config/bus/telemetry.toml").read_text())["packet"]:
        for field in packet["fields"]:
            name = f"{packet['name']}_{field['name']}" + (f"_{field['elements'][0]}" if "elements" in field else "")
            if name not in telemetry:
                continue  # flags, spares
            alarm = telemetry[name].find("x:DefaultAlarm", X)
            assert (alarm is not None) == ("alarm" in field), name
            for level, limit in field.get("alarm", {}).items():
                if "above" in limit:
                    assert float(alarm.find(f"x:StaticAlarmRanges/x:{level.capitalize()}Range", X).get("maxInclusive")) == limit["above"]
                else:
                    rows = alarm.iterfind("x:EnumerationAlarmList/x:EnumerationAlarm", X)
                    assert [row.get("enumerationLabel") for row in rows if row.get("alarmLevel") == level] == limit["at"]
                found[name] = limit
    assert {"motion_sigma_att_rad", "motion_mode", "housekeeping_frames_unreadable", "platform_deadline_misses"} <= set(found)


@pytest.mark.parametrize(("old", "new"), [
    ('at = ["LOST"]', 'at = ["GONE"]'), ("{ above = 0 }", "{ below = 0 }"), ("alarm = { warning", "alarm = { bad"), ('names = "commands"', 'names = "orders"')])
def test_an_alarm_or_a_name_that_the_table_does_not_know_is_refused(tmp_path, old, new):
    from polhode_ground.busgen.table import TableError, read_table

    for file in (REPOSITORY / "config/bus").glob("*.toml"):
        assert file.name != "telemetry.toml" or old in file.read_text()
        (tmp_path / file.name).write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(TableError):
        read_table(tmp_path)


@pytest.mark.parametrize(("values", "says"), [
    ({"features.count_max": 5000}, "features.count_max = 5000: allowed are 50 .. 1000"),
    ({"features.count_max": 500.5}, "features.count_max = 500.5: allowed are 50 .. 1000"),
    ({"features.sigma_px": float("nan")}, "features.sigma_px = nan: allowed are 0.05 .. 5.0"),
    ({"motion.mode": "fast"}, "motion.mode = fast: allowed are dynamics, paper"),
    ({"seed": 5}, "seed: no parameter that a command may change")])
def test_the_python_client_loads_nothing_that_is_out_of_range(values, says):
    from polhode_bus import make_table_load

    with pytest.raises(ValueError, match=re.escape(says)):
        make_table_load(values)


def test_the_python_client_packs_by_the_parameters_type():
    import struct

    from polhode_bus import make_command, make_table_load

    load = make_table_load({"features.sigma_px": 1, "mask.enabled": False, "motion.mode": "paper", "features.count_max": 500.0})
    assert [load[at:at + 8] for at in (24, 40, 56, 72)] == [struct.pack(">d", 1.0), bytes(8), struct.pack(">q", 1), struct.pack(">q", 500)]
    assert make_command("noop", sequence=16383)[2:4] == b"\xff\xff" and make_command("noop")[2:4] == b"\xc0\x00"
    with pytest.raises(ValueError, match="16383"):
        make_command("noop", sequence=16384)
