"""polhode run beside readers that read, that are stopped and that are not there: all packets to those that read."""

import contextlib
import json
import os
import pathlib
import threading

import polhode_bus
import pytest

PASSES = 25  # 300 frames: with housekeeping in each, packets enough for a stopped reader's queue (some 10) and the sender's (512) to be full


class Listening(threading.Thread):
    """Keeps what it reads until it is told that all is sent."""

    def __init__(self, address):
        super().__init__(daemon=True)
        self.bus = polhode_bus.open_bus(address)
        self.over = threading.Event()
        self.octets = b""
        self.start()

    def run(self):
        with self.bus as bus:
            while True:
                over = self.over.is_set()
                packet = bus.next_octets(0.2)
                if packet is None and over:
                    return
                self.octets += packet or b""

    def all_heard(self):
        self.over.set()
        self.join()
        return self.octets


@pytest.fixture
def ring():
    name = f"/polhode_readers_{os.getpid()}"
    yield f"shm:{name}"
    with contextlib.suppress(FileNotFoundError):
        pathlib.Path(f"/dev/shm{name}").unlink()


# verifies: LIV-07
def test_good_readers_get_everything_beside_stopped_ones(live, played, tmp_path, ring):
    good, stopped, nobody = (f"unix:{tmp_path}/{name}" for name in ("good", "stopped", "nobody"))
    settings = [f'transport.send=["{stopped}", "{nobody}", "{good}", "{ring}"]', "bus.housekeeping_every_frames=1"]
    assert live(played.path, name="first", settings=settings).finish().status == 0  # makes the ring
    listening = [Listening(good), Listening(ring), Listening(ring)]
    with polhode_bus.open_bus(stopped):  # and never read from
        run = live(played.path, device__sequence_passes=PASSES, settings=settings)
        ended = run.finish()
    assert ended.status == 0, ended.err
    stream = (run.folder / "bus.ccsds").read_bytes()
    for reader in listening:
        assert without_platform(reader.all_heard()) == stream
        assert reader.bus.missing == 0
    counts = {c["address"]: c for c in json.loads((run.folder / "run.json").read_text())["transport"]["send"]}
    assert counts[stopped]["dropped"] > 0
    assert counts[nobody]["without_reader"] == counts[good]["sent"] == counts[ring]["sent"]


def without_platform(octets):
    """The packets of the machine's state, once a second, go to the transports only and stand in no bus.ccsds."""
    kept, at = b"", 0
    while at < len(octets):
        size = int.from_bytes(octets[at + 4:at + 6], "big") + 7
        apid = int.from_bytes(octets[at:at + 2], "big") & 0x7FF
        kept += b"" if apid & 0xF in (7, 8, 9) else octets[at:at + size]
        at += size
    return kept
