"""What the machine does is told once a second, and stands in no stream that a replay has to give."""

import signal

from polhode_bus import open_bus


def packets_of(file) -> list:
    if not file.exists():
        return []
    with open_bus(f"file:{file}") as bus:
        return list(bus.packets())


def told_in(file) -> list:
    return [packet for packet in packets_of(file) if packet.name == "platform"]


def test_readers_are_told_of_the_machine(live, played, until, tmp_path):
    stream = tmp_path / "stream"
    run = live(played.path, device__sequence_passes=100000, settings=[f'transport.send=["file:{stream}"]'])
    until(lambda: len(told_in(stream)) >= 3, limit_s=120)
    run.process.send_signal(signal.SIGTERM)
    assert run.finish().status == 0
    told = told_in(stream)
    assert [packet.header.sequence for packet in told] == list(range(len(told)))
    assert [packet.uptime_s for packet in told[:3]] == sorted({packet.uptime_s for packet in told[:3]})
    last = told[-1]
    assert last.packets_dropped == 0 and last.restarts == 0 and last.timestamp_ns > 0
    assert last.resident_octets > 10**7 and last.longest_step_us >= last.last_step_us > 0
    names = {packet.name for packet in packets_of(run.folder / "bus.ccsds")}
    assert "motion" in names and "platform" not in names


def test_restarts_are_counted_from_checkpoint_to_checkpoint(live, played, tmp_path):
    for start in range(3):
        stream = tmp_path / f"stream{start}"
        run = live(played.path, name=f"start{start}", run__checkpoint=tmp_path / "checkpoint",
                   settings=[f'transport.send=["file:{stream}"]'])
        assert run.finish().status == 0
        assert told_in(stream)[0].restarts == start
