"""tools/watch.py: what packets become, that a slow page makes nobody wait, and that the run does not know of it."""

import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import types
import urllib.request
import zlib
from importlib.metadata import version

import numpy as np
import pytest
from PIL import Image
from polhode_bus import Packet, open_bus
from polhode_ground.busgen.table import read_table
from polhode_ground.common.errors import BadInput
from polhode_ground.testing.replay_files import REPOSITORY
from polhode_ground.watching import body, state, words
from polhode_ground.watching.feed import Feed, check_address, open_address
from polhode_ground.watching.images import HEADER, RecordingImages, SequenceImages, open_images
from polhode_ground.watching.serve import draw_until

TABLE = read_table(REPOSITORY / "config/bus")
SECOND_NS = 1_000_000_000
LATE_NS = 2**62


def motion(second: float, **changed) -> Packet:
    """A frame with a pose 10 in front of the camera and a rate."""
    values = {"timestamp_ns": round(second * SECOND_NS), "frame": int(second), "mode": "TRACKING", "pose_valid": True, "rate_valid": True, "scale_known": False,
              "scale_number": 0, "q_CT": [1.0, 0.0, 0.0, 0.0], "p_CT": [0.0, 0.0, 10.0], "w_T_rad_s": [0.0, 0.0, 0.1], "sigma_rate_rad_s": 0.001,
              "sigma_att_rad": 0.01, "sigma_pos": 0.1, "features": 9, "matches": 8, "inliers": 7, "landmarks": 6, "keyframes": 5}
    return Packet("motion", None, values | changed)


def event(number: int, text: str = "") -> Packet:
    return Packet("event", None, {"timestamp_ns": number * SECOND_NS, "id": 4, "value": [0.0, 0.0], "severity": "INFO", "text": text or f"event {number}"})


def cloud(number: int, chunk: int, points: int = 110) -> Packet:
    return Packet("cloud", None, {"cloud": number, "chunk": chunk, "points": points, "p_T": [[float(chunk), float(i), 1.0] for i in range(110)]})


SHAPE = Packet("shape", None, {"shape_valid": True, "q_TB": [1.0, 0.0, 0.0, 0.0], "centroid_T": [0.0, 0.0, 1.0], "dimensions": [2.0, 1.0, 1.0]})


def taken(*packets: Packet) -> state.State:
    made = state.State()
    for packet in packets:
        made.take(packet)
    return made


def test_what_is_kept_is_bounded():
    made = taken(*(motion(i / 100) for i in range(10_000)), *(event(i) for i in range(100)), *(cloud(1, chunk) for chunk in range(250)))
    assert made.frames == 10_000 and len(made.poses) == state.POSES_MAX and len(made.rates) == state.RATES_MAX
    assert [one.text for one in made.events][:2] == ["event 99", "event 98"] and len(made.events) == 20
    assert len(made.cloud_T) == state.CLOUD_POINTS_MAX
    assert made.pose == state.Pose((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 10.0))


def test_rates_are_those_of_the_last_minute_and_begin_anew_where_time_does():
    made = taken(*(motion(second) for second in range(100)))
    assert [one.timestamp_ns // SECOND_NS for one in made.rates] == list(range(39, 100))
    assert made.rates[-1].w_T_deg_s[2] == pytest.approx(5.7296, abs=1e-4) and made.rates[-1].sigma_deg_s == pytest.approx(0.057296, abs=1e-6)
    made.take(motion(1.0))
    assert [one.timestamp_ns for one in made.rates] == [SECOND_NS]


def test_lengths_of_another_unit_or_map_are_dropped():
    made = taken(motion(1), SHAPE, cloud(1, 0))
    assert len(body.body_of(made, 10.0).corners) == 8 and len(made.cloud_T) == 110
    made.take(motion(2))
    assert "shape" in made.latest
    made.take(motion(3, scale_number=1))
    assert "shape" not in made.latest and made.cloud_T == [] and len(body.body_of(made, 10.0).points) == 0


def test_a_new_request_replaces_the_cloud():
    made = taken(cloud(1, 0), cloud(1, 1), cloud(2, 0, points=3))
    assert made.cloud_T == [(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (0.0, 2.0, 1.0)]


def test_a_snapshot_does_not_change():
    made = taken(motion(1), event(1), cloud(1, 0))
    kept = made.snapshot()
    for packet in (motion(2), event(2), cloud(1, 1)):
        made.take(packet)
    assert kept.latest["motion"].frame == 1 and len(kept.events) == 1 and len(kept.rates) == 1 and len(kept.poses) == 1 and len(kept.cloud_T) == 110


def test_the_outline_is_where_the_camera_sees_the_box():
    made = taken(motion(1), SHAPE)  # 2 x 1 x 1, its centre 11 in front of the camera
    camera = types.SimpleNamespace(width_px=200, project=lambda p_C: 100 * p_C[:, :2] / p_C[:, 2:] + [100, 100])
    picture = body.picture_of(np.zeros((200, 200), np.uint8), camera, made.pose, body.body_of(made, 10.0), 640).astype(int)
    yellow = np.argwhere((picture[:, :, 0] > 200) & (picture[:, :, 1] > 150) & (picture[:, :, 2] < 90))
    half = 100 / 10.5  # its near face's half width and, halved, height
    assert np.allclose(yellow.min(axis=0), [100 - half / 2, 100 - half], atol=2) and np.allclose(yellow.max(axis=0), [100 + half / 2, 100 + half], atol=2)
    bare = body.picture_of(np.zeros((200, 200), np.uint8), camera, None, body.body_of(made, 10.0), 100)
    assert bare.shape == (100, 100, 3) and not bare.any()


def test_words_tell_mode_rates_and_silence():
    made = taken(motion(1))
    assert "TRACKING" in words.head(made, 0.1) and "STALE" not in words.head(made, 4.9)
    assert "STALE: no packet for 6 s" in words.head(made, 6.0)
    assert "NO PACKETS YET" in words.head(state.State(), float("inf"))
    assert "<b>5.730</b> &plusmn; 0.057" in words.motion_rows(made) and "map units" in words.motion_rows(made)
    made.take(motion(2, pose_valid=False, rate_valid=False, scale_known=True, mode="LOST"))
    assert "not known" in words.motion_rows(made) and "LOST" in words.head(made, 0.0)


def test_texts_of_packets_are_no_html():
    assert "<img" not in words.events(taken(event(1, "<img src=x onerror=alert(1)>")))
    assert "&lt;img" in words.events(taken(event(1, "<img src=x onerror=alert(1)>")))


def test_warnings_follow_the_table_of_packets():
    platform = {entry.name: 0 for entry in TABLE.packet("platform").fields}
    assert words.warned(taken(motion(1), Packet("platform", None, platform)), TABLE) == []
    found = words.warned(taken(motion(1, sigma_att_rad=0.2), Packet("platform", None, platform | {"frames_dropped": 3})), TABLE)
    assert [(one.level, one.name, one.value) for one in found] == [("warning", "sigma_att_rad", "0.2"), ("warning", "frames_dropped", "3")]
    assert [one.level for one in words.warned(taken(motion(1, mode="LOST", sigma_rate_rad_s=0.002)), TABLE)] == ["critical", "warning"]
    assert words.warned(taken(motion(1, sigma_att_rad=None)), TABLE) == []


def test_every_command_is_named_with_its_line():
    said = words.commands(TABLE, TABLE.apid_first)
    for layout in TABLE.commands:
        assert f"polhode bus send ADDRESS {layout.name}" in said
    assert "set_known_length frame_timestamp_ns=VALUE length_m=VALUE first_px=U,V second_px=U,V" in said
    assert "bus send --apid-first 500 ADDRESS noop" in words.commands(TABLE, 500)


@pytest.mark.parametrize("address", ["ring:/polhode", "shm:polhode", "shm:/a/b", "udp:", "udp:0", "udp:65536", "udp:host:", "unix:", "bus.ccsds"])
def test_a_wrong_form_is_refused_with_the_allowed_ones(address):
    with pytest.raises(BadInput, match=re.escape(f"{address}: allowed are unix:PATH, udp:PORT, udp:HOST:PORT (bound here), shm:/NAME, file:PATH")):
        check_address(address)


def test_what_is_not_there_or_taken_is_refused(tmp_path):
    with pytest.raises(BadInput, match="shm:/not_there: no such ring"):
        open_address("shm:/not_there", 416)
    with pytest.raises(BadInput, match="no such file"):
        open_address(f"file:{tmp_path}/none", 416)
    with pytest.raises(BadInput, match="no such file or folder"):
        open_address(f"unix:{tmp_path}/none/socket", 416)
    with open_bus(f"unix:{tmp_path}/socket"), pytest.raises(BadInput, match="another reader has it"):
        open_address(f"unix:{tmp_path}/socket", 416)
    with pytest.raises(BadInput, match="no such folder"):
        open_images(tmp_path / "none")


class SlowPage:
    """Draws three times a second."""

    def __init__(self):
        self.frames = []

    def draw(self, now, silence_s, image, note):
        self.frames.append(now.latest["motion"].frame)
        time.sleep(0.3)


def test_a_slow_page_skips_to_the_newest_and_no_packet_is_lost(played, replayed, until, tmp_path):
    octets = replayed(played.path)
    with open_bus(f"file:{tmp_path}/replayed/bus.ccsds") as whole:
        count = sum(1 for _ in whole.packets())
    feed, page, ended = Feed_on(tmp_path / "growing"), SlowPage(), threading.Event()
    drawing = threading.Thread(target=draw_until, args=(ended, feed, page, None, lambda: bool(feed.snapshot().latest)))
    drawing.start()
    with open(tmp_path / "growing", "ab", buffering=0) as file:
        for start in range(0, len(octets), 200):
            file.write(octets[start:start + 200])
            time.sleep(0.005)
    until(lambda: page.frames and page.frames[-1] == 11, 10.0)
    ended.set()
    drawing.join()
    seen = feed.snapshot()
    feed.close()
    assert seen.packets == count and seen.missing == 0 and seen.damaged_octets == 0 and seen.frames == 12
    assert len(page.frames) < 12 and page.frames == sorted(page.frames)


def Feed_on(file):
    file.touch()
    return Feed(f"file:{file}", 416)


def test_a_replaced_file_is_opened_again(played, replayed, until, tmp_path):
    octets = replayed(played.path)
    feed = Feed_on(tmp_path / "bus")
    (tmp_path / "new").write_bytes(octets)
    (tmp_path / "new").rename(tmp_path / "bus")
    until(lambda: feed.snapshot().frames == 12, 10.0)
    feed.close()


# verifies: GND-07
def test_the_run_gives_the_same_bytes_beside_a_watch(live, played, until, tmp_path):
    pytest.importorskip("viser")
    from polhode_ground.watching.page import Page, start_server, stop_server
    alone = live(played.path, name="alone", settings=[f'transport.send=["unix:{tmp_path}/nobody"]'])
    assert alone.finish().status == 0
    feed, ended, server = Feed(f"unix:{tmp_path}/socket", 416), threading.Event(), start_server("127.0.0.1", 0)
    page = Page(server, TABLE, 416, "unix", True)
    drawing = threading.Thread(target=draw_until, args=(ended, feed, page, SequenceImages(played.path), lambda: True))
    drawing.start()
    watched = live(played.path, name="watched", settings=[f'transport.send=["unix:{tmp_path}/socket"]'])
    assert watched.finish().status == 0
    octets = (watched.folder / "bus.ccsds").read_bytes()
    until(lambda: feed.snapshot().frames == 12, 10.0)
    ended.set()
    drawing.join()
    assert octets == (alone.folder / "bus.ccsds").read_bytes() and len(octets) > 1000
    assert feed.snapshot().missing == 0
    feed.close()
    stop_server(server)


def test_images_are_those_of_the_recording_and_of_the_played_sequence(live, played, tmp_path):
    (tmp_path / "recording").mkdir()
    images = open_images(tmp_path / "recording")
    assert isinstance(images, RecordingImages) and images.newest(LATE_NS) is None and images.camera is None
    run = live(played.path, device__sequence_passes=2, recording__folder=tmp_path / "recording", recording__complete=True)
    assert run.finish().status == 0
    sequence, whole = open_images(played.path), (tmp_path / "recording").glob("*.rec")
    file = next(whole)
    octets, seen = file.read_bytes(), {}
    for length in range(0, len(octets) + 1, 997):  # as it grows, cut anywhere
        file.write_bytes(octets[:length])
        found = images.newest(LATE_NS)
        if found is not None:
            seen[found[0]] = found[1]
    file.write_bytes(octets)
    last = images.newest(LATE_NS)
    seen |= {last[0]: last[1]} if last else {}
    assert images.newest(LATE_NS) is None  # nothing new
    assert images.camera.width_px == 160 and images.camera.intrinsics_px == pytest.approx(sequence.camera.intrinsics_px)
    assert len(seen) == 23  # the turning point is played once
    for stamp, picture in seen.items():
        assert np.array_equal(sequence.newest(stamp)[1], picture)
    for stamp in (int(played.rows[5][0]), int(played.rows[5][0]) + 1):  # the packet of the next one is not there yet
        assert RecordingImages(tmp_path / "recording").newest(stamp)[0] == int(played.rows[5][0])
    assert RecordingImages(tmp_path / "recording").newest(0) is None
    first = played.data / f"{played.rows[0][0]}.png"
    assert np.array_equal(seen[int(played.rows[0][0])], np.asarray(Image.open(first)))
    assert sequence.newest(int(played.rows[0][0]) + 1) is None and "no frame of this time" in sequence.problem and sequence.newest(0) is None
    (played.data / f"{played.rows[1][0]}.png").write_bytes(b"no picture")
    assert sequence.newest(int(played.rows[1][0])) is None and f"{played.rows[1][0]}.png" in sequence.problem


def test_a_damaged_recording_shows_what_is_whole(live, played, tmp_path):
    run = live(played.path, recording__folder=tmp_path, recording__complete=True)
    assert run.finish().status == 0
    file = next(tmp_path.glob("*.rec"))
    octets = bytearray(file.read_bytes())
    octets[-100] ^= 1  # of the last frame's content
    file.write_bytes(octets)
    images = RecordingImages(tmp_path)
    assert images.newest(LATE_NS) is None and "damaged" in images.problem
    octets[len(octets) // 2] ^= 1
    file.write_bytes(octets[:-200])
    assert RecordingImages(tmp_path).newest(LATE_NS)[0] < int(played.rows[-1][0])


def test_a_recording_with_another_header_shows_no_image_of_it(live, played, tmp_path):
    """By their places in the header: packing, width, height, flags. Its sums are right."""
    assert live(played.path, recording__folder=tmp_path, recording__complete=True).finish().status == 0
    file, images = next(tmp_path.glob("*.rec")), RecordingImages(tmp_path)
    assert images.newest(LATE_NS)[0] == int(played.rows[-1][0])
    place, header = images._frames[-1]
    whole = file.read_bytes()
    for changed in ({3: 0}, {5: 320}, {6: 60}, {5: 65535, 6: 65535}, {5: 0}, {2: 3}, {3: 9}):
        made = HEADER.pack(*(changed.get(at, value) for at, value in enumerate(header)))
        file.write_bytes(whole[:place - HEADER.size] + made[:-4] + zlib.crc32(made[:-4]).to_bytes(4, "little") + whole[place:])
        images = RecordingImages(tmp_path)
        assert images.newest(LATE_NS) is None and images.problem, changed


class Stalled:
    """A viewer that connects and reads no more."""

    def __init__(self, port: int):
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Protocol: viser-v{version('viser')}\r\n\r\n".encode())
        assert b" 101 " in self._socket.recv(64)

    def close(self) -> int:
        """@return octets that were waiting for it in the system, 64 KiB at most."""
        with self._socket:
            return len(self._socket.recv(65536, socket.MSG_WAITALL | socket.MSG_DONTWAIT))


def test_a_viewer_that_reads_no_more_costs_no_memory_and_no_time():
    from polhode_ground.watching.page import Page, start_server, stop_server
    server = start_server("127.0.0.1", 0)
    page, viewer = Page(server, TABLE, 416, "udp:1", True), Stalled(server.get_port())
    noise = np.random.default_rng(1).integers(0, 255, (480, 640, 3), np.uint8)  # 220 kB as JPEG
    resident_mb, slowest_s = [], 0.0
    for i in range(200):
        begin_s = time.monotonic()
        page.draw(taken(motion(i)), 0.0, np.roll(noise, i, axis=1), "")
        slowest_s = max(slowest_s, time.monotonic() - begin_s)
        resident_mb.append(int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path("/proc/self/status").read_text())[1]) / 1000)
    assert viewer.close() > 4096
    stop_server(server)
    assert resident_mb[-1] - resident_mb[50] < 12  # all of these images: 33 MB
    assert slowest_s < 2.0  # it would wait for ever


def test_the_command_serves_a_page_and_ends_on_a_signal(tmp_path):
    (tmp_path / "bus").touch()
    command = [sys.executable, "-Es", "-X", "utf8", REPOSITORY / "tools/watch.py", f"file:{tmp_path}/bus", "--port"]
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        probe.listen()
        busy = probe.getsockname()[1]
        refused = subprocess.run([*command, str(busy)], capture_output=True, text=True, timeout=60)
    assert refused.returncode == 2 and refused.stdout == "" and f"--port {busy}: Address already in use; --port 0 takes a free one" in refused.stderr
    process = subprocess.Popen([*command, "0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        url = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+", url)
        with urllib.request.urlopen(url, timeout=30) as reply:
            assert b"<html" in reply.read()
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=30)
        assert (process.returncode, out, err) == (0, "", "")
    finally:
        process.kill()
        process.wait()
