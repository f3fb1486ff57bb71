"""Images and packets go into an MCAP file and come out of it as they were."""

import base64
import json
import subprocess
import sys

import pytest
from polhode_ground.testing.replay_files import REPOSITORY

reader = pytest.importorskip("mcap.reader")
TOOL = [sys.executable, REPOSITORY / "tools/sequence_to_mcap.py"]


def test_holds_every_image_and_every_packet(played, replayed, tmp_path):
    (played.data / "1300000000.png").unlink()
    packets = replayed(played.path)
    done = subprocess.run([*TOOL, played.path, "--bus", tmp_path / "replayed/bus.ccsds", "--out", tmp_path / "run.mcap"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "run.mcap", "rb") as file:
        messages = list(reader.make_reader(file).iter_messages(log_time_order=False))
        file.seek(0)
        names = [attachment.name for attachment in reader.make_reader(file).iter_attachments()]
    images = [(m.log_time, json.loads(m.data)) for _, channel, m in messages if channel.topic == "/camera/image"]
    assert len(images) == 11
    for stamp, image in images:
        assert base64.b64decode(image["data"]) == (played.data / f"{stamp}.png").read_bytes()
        assert image["timestamp"]["sec"] * 10**9 + image["timestamp"]["nsec"] == stamp
    raw = [m for _, channel, m in messages if channel.topic == "/bus/packet"]
    assert b"".join(m.data for m in raw) == packets
    stamps = {int(stamp) for stamp, _ in played.rows}
    for message in raw:
        assert min(abs(message.log_time - stamp) for stamp in stamps) <= 60  # the time field's resolution
    assert "sensor.yaml" in names


def test_what_is_no_packet_is_passed_over_and_told(played, replayed, tmp_path):
    packets = replayed(played.path)
    (tmp_path / "torn").write_bytes(b"torn" + packets + packets[:50])
    done = subprocess.run([*TOOL, played.path, "--bus", tmp_path / "torn", "--out", tmp_path / "run.mcap"], capture_output=True, text=True)
    assert done.returncode == 0 and "54 octets are no packet" in done.stderr
    with open(tmp_path / "run.mcap", "rb") as file:
        raw = [m.data for _, channel, m in reader.make_reader(file).iter_messages(log_time_order=False) if channel.topic == "/bus/packet"]
    assert b"".join(raw) == packets


def test_a_file_that_is_there_stays_where_the_packets_cannot_be_read(played, tmp_path):
    (tmp_path / "run.mcap").write_text("Made by Polhode, earlier")
    done = subprocess.run([*TOOL, played.path, "--bus", tmp_path / "none", "--out", tmp_path / "run.mcap"], capture_output=True, text=True)
    assert done.returncode == 2 and "none" in done.stderr
    assert (tmp_path / "run.mcap").read_text() == "Made by Polhode, earlier"
