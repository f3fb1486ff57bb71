"""The page of tools/watch.py in a browser, beside a run that plays the sample, and ten minutes beside the packets of one at 30 frames/s."""

import collections
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from PIL import Image
from polhode_bus import crc16, header_of, open_bus
from polhode_bus.packets import APID_FIRST
from polhode_ground.testing.replay_files import REPOSITORY

pytestmark = [pytest.mark.further, pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed")]
browser = pytest.importorskip("browser")

SAMPLE = REPOSITORY / "hil/data/sample"
SECONDS = 600
RATE_HZ = 30
TIME_AT = 16  # octets: the first field of each packet is its time
CATCH = "window.faults = []; addEventListener('error', e => faults.push(e.message)); console.error = (...a) => faults.push(a.join(' '));"
FRAME = "+(document.querySelector('#polhode-frame') || {textContent: '-1'}).textContent"
IMAGE = 'img[src^="blob:"]'
COUNT_IMAGES = (f"window.drawn = 0; const shown = document.querySelector('{IMAGE}'); new MutationObserver(changes => drawn += changes.length)"
                ".observe(shown, {attributes: true, attributeFilter: ['src']})")


@pytest.fixture
def watching():
    """Starts tools/watch.py. @return its process and the page's address."""
    started = []

    def start(address, *arguments):
        process = subprocess.Popen([sys.executable, "-Es", "-X", "utf8", REPOSITORY / "tools/watch.py", address, "--port", "0", *map(str, arguments)],
                                   stdout=subprocess.PIPE, text=True)
        started.append(process)
        return process, process.stdout.readline().strip() + "/"

    yield start
    for process in started:
        process.terminate()
        assert process.wait(30) == 0


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def resident_mb(pid: int) -> float:
    return int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text())[1]) / 1000


def open_at(page, url: str) -> None:
    page._ask("Page.enable")
    page._ask("Page.addScriptToEvaluateOnNewDocument", source=CATCH)
    page._ask("Page.navigate", url=url)


def test_it_shows_a_run_from_its_beginning_to_after_its_end(live, watching, tmp_path):
    port = free_port()
    _, url = watching(f"udp:{port}", "--images", SAMPLE)
    with browser.open_page("about:blank", tmp_path / "profile") as page:
        begin = time.monotonic()
        open_at(page, url)
        page.wait_for("document.body && document.body.innerText.includes('NO PACKETS YET')", 30)
        there_s, begin = time.monotonic() - begin, time.monotonic()
        run = live(SAMPLE, settings=[f'transport.send=["udp:{port}"]'], device__sequence_speed=RATE_HZ, device__sequence_passes=100_000, jobs__delay_frames=12)
        page.wait_for(f"{FRAME} >= 0", 30)
        first_s = time.monotonic() - begin
        page.wait_for("document.body.innerText.includes('TRACKING') && document.body.innerText.includes('rate in T')", 60)
        page.wait_for("document.querySelectorAll('.uplot').length == 1 && document.querySelectorAll('canvas').length > 1", 10)
        page.value(COUNT_IMAGES)
        page.wait_for("drawn > 20", 20)
        run.process.terminate()
        assert run.finish().status == 0
        page.wait_for("document.body.innerText.includes('STALE')", 10)
        elsewhere = page.value("performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.origin) && !/^(blob|data):/.test(n)).join()")
        assert (page.value("faults.join('; ')"), elsewhere) == ("", "")
        page.screenshot(tmp_path / "page.png", whole=False)
    shown = np.asarray(Image.open(tmp_path / "page.png").convert("L"))
    assert all(part.std() > 10 for part in np.array_split(shown, 3, axis=1))  # both panels and the scene between them
    print(f"page after {there_s:.2f} s, first frame of a run after {first_s:.2f} s")
    assert there_s < 5.0  # most of it is the browser's own, without a GPU; 0.5 s on an idle machine
    assert first_s < 2.0


class Player(threading.Thread):
    """Sends the packets of a run that went forth and back through a sequence again and again, frame by frame at a steady rate; counts and times go on."""

    def __init__(self, packets: list[bytes], period_ns: int, port: int):
        super().__init__(daemon=True)
        starts = [at for at, octets in enumerate(packets) if header_of(octets).apid == APID_FIRST]
        self._frames = [packets[a:b] for a, b in zip(starts, starts[1:])]  # the last frame is the first one again
        self._period_ns, self._to = period_ns, ("127.0.0.1", port)
        self._counts, self.ended = collections.Counter(), threading.Event()
        self.sent = self.frames = self.last_ns = 0

    def _renumbered(self, octets: bytes, turn: int) -> bytes:
        apid, (stamp_ns,) = header_of(octets).apid, struct.unpack_from(">q", octets, TIME_AT)
        stamp_ns += turn * self._period_ns
        count = self._counts[apid]
        self._counts[apid] += 1
        self.last_ns = stamp_ns if apid == APID_FIRST else self.last_ns
        whole = octets[:2] + struct.pack(">H", 0xC000 | count % 16384) + octets[4:TIME_AT] + struct.pack(">q", stamp_ns) + octets[TIME_AT + 8:-2]
        return whole + struct.pack(">H", crc16(whole))

    def run(self):
        begin_s = time.monotonic()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not self.ended.is_set():
                turn, place = divmod(self.frames, len(self._frames))
                for octets in self._frames[place]:
                    out.sendto(self._renumbered(octets, turn), self._to)
                    self.sent += 1
                self.frames += 1
                time.sleep(max(0.0, begin_s + self.frames / RATE_HZ - time.monotonic()))


# verifies: GND-07
def test_ten_minutes_at_30_frames_a_second_take_no_memory_and_lose_no_packet(live, watching, tmp_path):
    run = live(SAMPLE, device__sequence_passes=2)
    assert run.finish().status == 0
    with open_bus(f"file:{run.folder}/bus.ccsds") as bus:
        packets = list(iter(lambda: bus.next_octets(0.0), None))
    stamps = [int(line.split(",")[0]) for line in (SAMPLE / "mav0/cam0/data.csv").read_text().splitlines()[1:]]
    port = free_port()
    process, url = watching(f"udp:{port}", "--images", SAMPLE)
    player = Player(packets, 2 * (stamps[-1] - stamps[0]), port)
    player.start()
    with browser.open_page(url, tmp_path / "profile") as page:
        page.wait_for(f"{FRAME} >= 0 && !!document.querySelector('{IMAGE}')", 30)
        page.value(COUNT_IMAGES)
        time.sleep(30)  # the client's code, buffers of images, the last minute's rates
        begin_s, begin_drawn, begin_frames, memory_mb = time.monotonic(), page.value("drawn"), player.frames, [resident_mb(process.pid)]
        while time.monotonic() < begin_s + SECONDS:
            time.sleep(10)
            memory_mb.append(resident_mb(process.pid))
        took_s = time.monotonic() - begin_s
        drawn_hz, frames_hz = (page.value("drawn") - begin_drawn) / took_s, (player.frames - begin_frames) / took_s
        player.ended.set()
        player.join()
        end_s = time.monotonic()
        page.wait_for(f"document.body.innerText.includes('{player.last_ns / 1e9:.3f} s')", 10)  # a viewer with a queue would be behind
        behind_s = time.monotonic() - end_s
        missed = page.value("Array.from(document.querySelectorAll('tr'), e => e.innerText).find(t => t.startsWith('packets missed'))")
        page.screenshot(tmp_path / "page.png", whole=False)
    print(f"{player.sent} packets, {frames_hz:.1f} frames/s sent, {drawn_hz:.1f} images/s drawn; resident {memory_mb[0]:.1f} MB, then "
          f"{memory_mb[len(memory_mb) // 2]:.1f} and {memory_mb[-1]:.1f} MB; last frame shown within {behind_s:.1f} s; {missed!r}")
    assert missed.split("\t")[-1].strip() == "0, 0"
    assert memory_mb[-1] < 1.1 * memory_mb[0]
    assert frames_hz > 0.95 * RATE_HZ and drawn_hz > RATE_HZ / 3
