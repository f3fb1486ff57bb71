"""A YAMCS server takes the stream over UDP, archives it, reports damage, and gives the parameters back by its API."""

import math
import re
import time

import pytest
from browser import open_page
from conftest import HTTP, PAGE, TC, wait_until
from flights import expect_rows

pytestmark = pytest.mark.further

PACE_S = 0.02  # a server that has just started loses what comes faster than about 100 a second


@pytest.fixture(scope="module")
def watching(server, tmp_path_factory):
    """The display, opened before anything is sent."""
    with open_page(f"http://127.0.0.1:{PAGE}/?yamcs={HTTP}", tmp_path_factory.mktemp("display") / "browser") as page:
        page.wait_for("document.querySelector('#link').textContent === 'connected'", 30)
        time.sleep(2.0)  # the subscription is behind the connection
        yield page


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """For people to look at."""
    return tmp_path_factory.mktemp("pictures")


@pytest.fixture(scope="module")
def received(server, watching, flight, damaged, pictures):
    """The damaged stream has been sent and taken."""
    for index, octets in enumerate(damaged.packets):
        server.send(octets)
        time.sleep(PACE_S)
        if index == len(damaged.packets) // 2:
            watching.wait_for("/^motion .* ago/.test(document.querySelector('#age').textContent) && !document.body.className", 30)
            watching.screenshot(pictures / "fresh.png")
    link = wait_until(lambda: (found := server.client.get_link("polhode", "telemetry").get_info()).in_count >= len(damaged.packets) and found, 60,
                      "the packets arrive")
    time.sleep(3.0)  # the archive's writer is behind the link
    return link


@pytest.fixture(scope="module")
def display(watching, received, flight, pictures):
    """The display after the stream, when what it shows has become old."""
    watching.wait_for(f"document.querySelector('#frame').textContent === 'frame {flight.rows[-1]['frame']}'", 30)
    watching.wait_for("!document.querySelector('#stale').hidden", 30)
    watching.screenshot(pictures / "stale.png")
    print(f"screenshots: {pictures}")
    return watching


def archived(server, name):
    return list(server.client.get_archive("polhode").list_packets(name=f"/polhode/{name}"))


def test_every_good_packet_is_archived_as_it_was_sent(server, received, damaged, flight):
    from polhode_bus import crc16

    good = [octets for octets in damaged.packets if crc16(octets) == 0]
    found = [packet.binary for packet in server.client.get_archive("polhode").list_packets()]
    assert sorted(found) == sorted(good)
    assert len(archived(server, "motion")) == len(flight.rows) - 2


def test_archived_packets_have_the_time_of_their_frame(server, received, flight):
    stamps = [packet.generation_time.timestamp() for packet in archived(server, "motion")]
    rows = [row for index, row in enumerate(flight.rows) if index not in (4, 8)]
    assert stamps == pytest.approx([int(row["timestamp_ns"]) * 1e-9 for row in rows], abs=2e-3)


def test_damage_and_gap_are_reported(server, received):
    messages = [event.message.lower() for event in server.client.get_archive("polhode").list_events()]
    assert any("crc" in message or "corrupt" in message for message in messages), messages
    assert any("seq" in message for message in messages), messages


def test_parameters_come_back_with_the_replays_values(server, received, flight):
    archive = server.client.get_archive("polhode")
    fields = ["frame", "timestamp_ns", *(f"q_CT_{a}" for a in "wxyz"), *(f"{v}_{a}" for v in ("p_CT", "v_C", "w_T_rad_s") for a in "xyz"),
              "sigma_att_rad", "sigma_pos", "sigma_vel", "sigma_rate_rad_s"]
    columns = {name: [value.eng_value for value in archive.list_parameter_values(f"/polhode/motion_{name}", source="replay")]
               for name in fields}
    rows = [row for index, row in enumerate(flight.rows) if index not in (4, 8)]
    expect_rows([{name: values[index] for name, values in columns.items()} for index in range(len(rows))], rows)
    modes = [value.eng_value for value in archive.list_parameter_values("/polhode/motion_mode", source="replay")]
    assert modes == [row["mode"] for row in rows]


def test_commands_reach_the_bus_signed_and_as_the_field_table_says(server):
    import socket
    import time

    from polhode_bus import crc16, make_command, read_key, sign

    before = time.time_ns()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as flight_side:
        flight_side.bind(("127.0.0.1", TC))
        flight_side.settimeout(30)
        processor = server.client.get_processor("polhode", "realtime")
        numbers = []
        for _ in range(2):
            processor.issue_command("/polhode_commands/set_range", args={"frame_timestamp_ns": 7, "range_m": 12.5})
            signed = flight_side.recv(2000)
            octets = bytearray(signed[:-24])
            octets[4:6] = (len(octets) - 7).to_bytes(2, "big")
            assert crc16(bytes(octets)) == 0
            numbers.append(int.from_bytes(signed[-24:-16], "big"))
            assert sign(read_key(server.key), numbers[-1], bytes(octets)) == signed
            octets[2:4] = b"\xc0\x00"  # its sequence count, which is not checked
            octets[-2:] = crc16(bytes(octets[:-2])).to_bytes(2, "big")
            assert bytes(octets) == make_command("set_range", frame_timestamp_ns=7, range_m=12.5)
    assert before < numbers[0] < numbers[1] < time.time_ns()


def test_the_display_shows_rates_attitude_mode_and_health(display, flight):
    last = flight.rows[-1]
    assert display.texts("#mode") == [last["mode"]]
    assert display.texts("#frame") == [f"frame {last['frame']}"]
    rates = [f"{math.degrees(float(last[f'w_T_{axis}'])):.4f}" for axis in "xyz"]
    assert display.texts("#motion tr:first-child span") == rates
    health = dict(zip(display.texts("#health td:first-child"), display.texts("#health td:last-child")))
    housekeeping = [packet for packet in flight.packets if packet.name == "housekeeping"][-1]
    assert health["frames in / used"] == f"{housekeeping.frames_in} / {housekeeping.frames_used}"
    assert health["commands taken / refused"] == f"{housekeeping.commands_accepted} / {housekeeping.commands_rejected}"
    assert not any("unknown" in text for text in display.texts("#motion td"))


def test_the_display_marks_what_it_shows_as_old_when_nothing_comes(display):
    """That it did not while the stream came is asked for in between, see received()."""
    assert display.value("document.body.className") == "stale"
    [told], [age] = display.texts("#stale"), display.texts("#age")
    seconds = float(re.fullmatch(r"STALE: no motion packet for ([\d.]+) s", told)[1])
    assert 5.0 <= seconds < 100.0
    assert re.fullmatch(r"motion [\d.]+ (s|min) ago, health [\d.]+ (s|min) ago", age)
    assert float(display.value("getComputedStyle(document.querySelector('main')).opacity")) < 0.6


def test_the_displays_curves_have_a_point_for_every_frame_that_came(display, flight):
    assert display.value("rates.length") == len(flight.rows) - 2
    assert display.value("rates.filter(sample => sample.w).length") == sum(
        row["rate_valid"] == "1" for index, row in enumerate(flight.rows) if index not in (4, 8))


def test_the_display_lists_the_latest_events(display, flight):
    texts = [packet.text for packet in flight.packets if packet.name == "event"]
    shown = display.texts("#events li")
    assert len(shown) == min(8, len(texts))
    assert all(line.split("  ")[2] == text for line, text in zip(shown, reversed(texts))), (shown, texts)
    assert [line.split("  ")[3:] for line in shown if line.split("  ")[2] == "command 12 checkpoint accepted"] == [["(checkpoint)"]]


def test_a_page_that_is_opened_later_shows_the_last_values(server, received, flight, tmp_path):
    with open_page(f"http://127.0.0.1:{PAGE}/?yamcs={HTTP}", tmp_path / "browser") as page:
        page.wait_for(f"document.querySelector('#frame').textContent === 'frame {flight.rows[-1]['frame']}'", 30)
        assert page.texts("#mode") == [flight.rows[-1]["mode"]]
        texts = [packet.text for packet in flight.packets if packet.name == "event"]
        page.wait_for(f"document.querySelectorAll('#events li').length === {min(8, len(texts))}", 30)
        shown = page.texts("#events li")
        assert sorted(line.split("  ")[2] for line in shown) == sorted(texts[-8:])
        page.wait_for(f"rates.length === {len(flight.rows) - 2}", 30)
        rows = [row for index, row in enumerate(flight.rows) if index not in (4, 8)]
        for curve, row in zip(page.value("rates.map(sample => sample.w)"), rows):
            expected = [math.degrees(float(row[f"w_T_{axis}"])) for axis in "xyz"] if row["rate_valid"] == "1" else None
            assert curve == (expected and pytest.approx(expected, rel=1e-6)), row["frame"]
        page.wait_for("document.querySelector('#stale').textContent.startsWith('STALE: no motion packet for')", 30)
