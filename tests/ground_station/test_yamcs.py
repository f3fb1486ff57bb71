"""A YAMCS server takes the stream over UDP, archives it, reports damage, and gives the parameters back by its API."""

import subprocess
import time
from urllib.parse import quote

import pytest
from conftest import HTTP, PAGE, TC, wait_until
from flights import expect_rows

PACE_S = 0.02  # a server that has just started loses what comes faster than about 100 a second


@pytest.fixture(scope="module")
def received(server, flight, damaged):
    """The damaged stream has been sent and taken."""
    for octets in damaged.packets:
        server.send(octets)
        time.sleep(PACE_S)
    link = wait_until(lambda: (found := server.client.get_link("polhode", "telemetry")).in_count >= len(damaged.packets) and found, 60,
                      "the packets arrive")
    time.sleep(3.0)  # the archive's writer is behind the link
    return link


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
    columns = {name: [value.eng_value for value in archive.list_parameter_values(f"/polhode/motion_{name}", descending=False)]
               for name in fields}
    rows = [row for index, row in enumerate(flight.rows) if index not in (4, 8)]
    expect_rows([{name: values[index] for name, values in columns.items()} for index in range(len(rows))], rows)
    modes = [value.eng_value for value in archive.list_parameter_values("/polhode/motion_mode", descending=False)]
    assert modes == [row["mode"] for row in rows]


def test_commands_reach_the_bus_as_the_field_table_says(server):
    import socket

    from polhode_bus import make_command

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as flight_side:
        flight_side.bind(("127.0.0.1", TC))
        flight_side.settimeout(30)
        processor = server.client.get_processor("polhode", "realtime")
        processor.issue_command("/polhode_commands/set_range", args={"frame_timestamp_ns": 7, "range_m": 12.5})
        octets = bytearray(flight_side.recv(2000))
    octets[2:4] = b"\xc0\x00"  # its sequence count, which is not checked
    from polhode_bus import crc16

    octets[-2:] = crc16(bytes(octets[:-2])).to_bytes(2, "big")
    assert bytes(octets) == make_command("set_range", frame_timestamp_ns=7, range_m=12.5)


def test_the_display_shows_rates_attitude_mode_and_health(server, received, flight, tmp_path):
    page = f"http://127.0.0.1:{PAGE}/?yamcs={HTTP}"
    browser = subprocess.Popen(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,800", "--virtual-time-budget=1",
                                "--version"], stdout=subprocess.PIPE, text=True)
    assert "Chrom" in browser.communicate(timeout=60)[0]
    arguments = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,860", "--timeout=20000"]
    shot = tmp_path / "display.png"
    subprocess.run([*arguments, f"--screenshot={shot}", page], check=True, timeout=120, capture_output=True)
    dom = subprocess.run([*arguments, "--dump-dom", page], check=True, timeout=120, capture_output=True, text=True).stdout
    last = flight.rows[-1]
    assert f'<span id="mode" class="{last["mode"]}">{last["mode"]}</span>' in dom
    assert f">frame {last['frame']}<" in dom
    rate_x = float(last["w_T_x"]) * 57.29577951308232
    assert f'<span class="x">{rate_x:.4f}</span>' in dom
    assert "frames in / used" in dom and "unknown" not in dom.split('id="motion"')[1].split("</table>")[0]
    assert shot.stat().st_size > 20_000
    print(f"screenshot: {shot}", quote(page))
