"""What the machine does goes to the readers once a second, and into no stream that a replay has to give."""

import sys

from replay_files import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "platform/transport/client/python"))
from polhode_bus import open_bus  # noqa: E402


def test_readers_are_told_of_the_machine(live, played, tmp_path):
    address = f"unix:{tmp_path / 'telemetry'}"
    with open_bus(address) as bus:
        # Nine seconds of frames, of which a busy machine's start takes some.
        run = live(played.path, device__sequence_speed=0.4, device__sequence_passes=3, device__backlog_frames_max=32,
                   settings=[f'transport.send=["{address}"]'])
        packets = list(bus.packets(timeout_s=20.0))
        assert run.finish().status == 0
    told = [packet for packet in packets if packet.name == "platform"]
    assert len(told) >= 2
    assert [packet.header.sequence for packet in told] == list(range(len(told)))
    last = told[-1]
    assert last.packets_dropped == 0 and last.restarts == 0
    assert last.resident_octets > 10**7 and last.longest_step_us >= last.last_step_us > 0
    assert last.timestamp_ns > 0
    with open_bus(f"file:{run.folder / 'bus.ccsds'}") as bus:
        assert {packet.name for packet in bus.packets()}.isdisjoint({"platform"})


def test_restarts_are_counted_from_checkpoint_to_checkpoint(live, played, tmp_path):
    for start in range(3):
        stream = tmp_path / f"stream{start}"
        run = live(played.path, name=f"start{start}", run__checkpoint=tmp_path / "checkpoint",
                   settings=[f'transport.send=["file:{stream}"]'])
        assert run.finish().status == 0
        with open_bus(f"file:{stream}") as bus:
            assert next(packet for packet in bus.packets() if packet.name == "platform").restarts == start
