"""A live run is commanded from YAMCS: every command and parameter of the database once, verified by the run's own events."""

import binascii
import collections
import resource
import signal
import struct
import subprocess
import time
import tomllib
import types

import pytest
from browser import open_page
from conftest import HTTP, PAGE, REPOSITORY, TC, TM, wait_until

pytestmark = pytest.mark.further

PROGRAM = REPOSITORY / "build/release/bin/polhode"
PARAMETERS = tomllib.loads((REPOSITORY / "config/bus/parameters.toml").read_text())["parameter"]
# Of one id 16 answers are sent in a window of frames, here 2.5 s; the others are counted but not sent, and verify nothing.
PACE_S = 0.2
ANSWER_S = 60.0  # the verifiers wait for half of that


@pytest.fixture(scope="module")
def run(server, tmp_path_factory):
    """`polhode run` on the sample, over and over; its bus is the server's. Two frames a second and few features, for busy machines."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "run.toml").write_text(f"""\
[device]
source = "{REPOSITORY / 'hil/data/sample'}"
sequence_speed = 2.0
sequence_passes = 100
[features]
count_max = 300
[bus]
housekeeping_every_frames = 2
event_window_frames = 5
[run]
folder = "{folder / 'run'}"
[transport]
send = ["udp:{TM}"]
receive = "udp:{TC}"
[commands]
key = "{server.key}"
window = "{folder / 'window'}"
""")
    with open(folder / "run.log", "w") as log:
        process = subprocess.Popen([PROGRAM, "run", "--config", folder / "run.toml"], stdout=log, stderr=subprocess.STDOUT)
    try:
        yield types.SimpleNamespace(process=process, log=folder / "run.log")
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.wait(timeout=60)


@pytest.fixture(scope="module")
def ground(server, run):
    """issue(command, **arguments) -> the command when it is complete or failed; value(parameter)."""
    processor = server.client.get_processor("polhode", "realtime")
    connection = processor.create_command_connection()

    def value(name):
        found = processor.get_parameter_value(f"/polhode/{name}")
        return found and found.eng_value

    def issue(name, **arguments):
        time.sleep(PACE_S)
        command = connection.issue(f"/polhode_commands/{name}", args=arguments)
        command.await_complete(timeout=ANSWER_S)
        return command

    wait_until(lambda: run.process.poll() is not None or (value("motion_landmarks") or 0) > 0, 120, "a map")
    assert run.process.poll() is None, run.log.read_text()
    return types.SimpleNamespace(issue=issue, value=value, processor=processor)


def good(command):
    accepted = command.acknowledgments["Verifier_Accepted"]
    assert command.is_success() and accepted.status == "OK", (command.name, command.error, command.acknowledgments)
    return command


def name_of(parameter) -> str:
    return "table_load_" + parameter["key"].replace(".", "_")


def other_value(parameter):
    """Not the default, but one that the run goes on well with: the nearest that is allowed."""
    if "words" in parameter:
        default = parameter["default"]
        return str(default).lower() if isinstance(default, bool) else default
    low, high = parameter["range"]
    if parameter["type"] == "i64":
        return parameter["default"] + (1 if parameter["default"] < high else -1)
    near = parameter["default"] * 1.01
    return near if near <= high else parameter["default"] * 0.99


def packed(parameter, value) -> bytes:
    if "words" in parameter:
        return struct.pack(">q", parameter["words"].index(value))
    return struct.pack(">d" if parameter["type"] == "f64" else ">q", value)


def entry(parameter, value) -> bytes:
    return struct.pack(">IHH", binascii.crc32(parameter["key"].encode()), 0, 0) + packed(parameter, value)


def housekeeping_says(ground, what, seconds=60):
    wait_until(lambda: all(ground.value(f"housekeeping_{name}") == value for name, value in what.items()), seconds, f"housekeeping says {what}")


def test_a_command_is_verified_by_the_event_that_bears_its_count(server, ground):
    def events():
        archive = server.client.get_archive("polhode")
        columns = [archive.list_parameter_values(f"/polhode/event_{name}", source="replay") for name in ("command_sequence", "id")]
        return [tuple(value.eng_value for value in row) for row in zip(*columns)]

    command = good(ground.issue("noop"))
    count = command.attributes["ccsds-seqcount"]
    assert count > 0
    wait_until(lambda: (count, "noop") in events(), 30, "the event")
    housekeeping_says(ground, {"last_command": "noop"})


def test_every_parameter_is_loaded_and_all_become_active(ground):
    crc, before = b"", ground.value("housekeeping_table_crc")
    for parameter in PARAMETERS:
        value = other_value(parameter)
        good(ground.issue(name_of(parameter), value=value))
        crc += entry(parameter, value)
    loaded = {"table_loaded_crc": binascii.crc32(crc), "table_entries": len(PARAMETERS)}
    housekeeping_says(ground, loaded)
    good(ground.issue("table_activate", crc32=loaded["table_loaded_crc"], entries=loaded["table_entries"]))
    housekeeping_says(ground, {"table_entries": 0})
    assert ground.value("housekeeping_table_crc") != before


@pytest.mark.parametrize("parameter", [p for p in PARAMETERS if "range" in p], ids=lambda p: p["key"])
def test_the_server_sends_no_value_that_is_out_of_range(ground, parameter):
    from yamcs.client import YamcsError

    for value in (parameter["range"][0] - 1, parameter["range"][1] * 2 + 1):
        with pytest.raises(YamcsError, match="range|does not fit"):
            ground.processor.issue_command(f"/polhode_commands/{name_of(parameter)}", args={"value": value})


def test_what_the_run_refuses_fails_with_its_words_and_raises_an_alarm_that_a_reset_clears(ground):
    def alarm():
        found = [alarm for alarm in ground.processor.list_alarms() if alarm.name == "/polhode/housekeeping_commands_rejected"]
        return found[0] if found else None

    good(ground.issue("reset_counters"))
    housekeeping_says(ground, {"commands_rejected": 0})
    good(ground.issue("table_load_features_count_max", value=700))
    refused = ground.issue("table_activate", crc32=1, entries=1)
    assert refused.is_failure() and refused.acknowledgments["Verifier_Failed"].status == "OK"
    assert "count of entries or CRC differs" in str(refused.attributes) + str(refused.error)
    raised = wait_until(alarm, 60, "the alarm")
    assert raised.severity == "WARNING" and not raised.is_process_ok
    good(ground.issue("table_discard"))
    good(ground.issue("reset_counters"))
    wait_until(lambda: alarm().is_process_ok, 60, "the cause is gone")
    ground.processor.acknowledge_alarm(raised.name, raised.sequence_number, comment="seen")
    wait_until(lambda: alarm() is None, 60, "the alarm is cleared")


def test_every_other_command_is_taken_once(ground):
    stamp = ground.value("motion_timestamp_ns")
    good(ground.issue("servicer_attitude", timestamp_ns=stamp, q_IC_w=1.0, q_IC_x=0.0, q_IC_y=0.0, q_IC_z=0.0, w_C_rad_s_x=0.0, w_C_rad_s_y=0.0,
                      w_C_rad_s_z=0.0))
    good(ground.issue("set_known_length", frame_timestamp_ns=stamp, length_m=1.0, first_px_u=10.0, first_px_v=10.0, second_px_u=20.0,
                      second_px_v=20.0))
    good(ground.issue("set_range", frame_timestamp_ns=stamp, range_m=12.5))
    wait_until(lambda: (ground.value("motion_landmarks") or 0) > 0, 120, "a map")
    good(ground.issue("request_cloud", points_max=100))
    good(ground.issue("checkpoint"))
    good(ground.issue("hold"))
    wait_until(lambda: ground.value("motion_mode") == "IDLE", 30, "held")
    assert ground.issue("hold").is_failure()
    good(ground.issue("resume"))
    wait_until(lambda: ground.value("motion_mode") != "IDLE", 30, "resumed")


def test_a_disk_that_takes_no_more_is_told(run, ground):
    limits = resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        wait_until(lambda: ground.value("platform_event_id") == 1, 60, "the event")
    finally:
        resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE, limits)
    assert ground.value("platform_event_severity") == "ERROR"
    assert ground.value("platform_event_text").startswith("disk: not written: packets of ")


def test_every_parameter_of_the_telemetry_has_had_a_value(server, ground):
    names = [row.qualified_name for row in server.client.get_mdb("polhode").list_parameters() if row.qualified_name.startswith("/polhode/")]
    assert len(names) > 800

    def missing():
        values = ground.processor.get_parameter_values(names, from_cache=True)
        return [name for name, value in zip(names, values) if value is None]

    until = time.monotonic() + 180
    while missing() and time.monotonic() < until:
        time.sleep(2)
    assert missing() == []


def test_every_command_of_the_database_was_issued(server, ground):
    every = {row.qualified_name for row in server.client.get_mdb("polhode").list_commands() if not row.abstract}
    good(ground.issue("reset_map"))
    issued = collections.Counter(row.name for row in server.client.get_archive("polhode").list_command_history())
    assert every == set(issued)


def test_the_page_shows_alarm_prediction_shape_and_axis_of_time(ground, tmp_path_factory):
    """For people: --basetemp keeps the pictures."""
    pictures = tmp_path_factory.mktemp("pictures")
    assert ground.issue("resume").is_failure()  # not held: an alarm
    for width in (1280, 390):
        with open_page(f"http://127.0.0.1:{PAGE}/?yamcs={HTTP}&stale=30", pictures / f"browser{width}") as page:
            page.resize(width, 860)
            page.wait_for("document.querySelector('#alarms').textContent.includes('housekeeping_commands_rejected = ')", 60)
            page.wait_for("document.querySelectorAll('#prediction tr').length > 1 && rates.filter(r => r.w).length > 5", 120)
            page.wait_for("document.querySelectorAll('#events li').length === 8 && rates.length > 100", 60)  # from the archive
            page.wait_for("document.querySelector('#shape').textContent.includes('length along z')", 180)
            assert page.value("document.documentElement.scrollWidth") <= width
            assert page.value("latestPredictions().every(p => !p.p || p.p.some(value => value !== 0))")  # values of one packet
            times = page.value("timeTicks(rates[0].t, rates[rates.length - 1].t, 800).map(tick => tick[1])")
            assert times and all(len(text.split(":")) == 3 for text in times)
            page.screenshot(pictures / f"page{width}.png")
    print(f"screenshots: {pictures}")
