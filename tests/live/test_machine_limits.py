"""What the machine refuses is said, and ends nothing that can go on."""

import os
import resource
import subprocess

import polhode_bus
import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM


def call(*arguments, close=(), limits=(), out=subprocess.PIPE, err=subprocess.PIPE):
    """With these descriptors closed, and these limits."""

    def prepare():
        for file in close:
            os.close(file)
        for name, value in limits:
            resource.setrlimit(name, (value, value))

    return subprocess.run([PROGRAM, *map(str, arguments)], stdout=out, stderr=err, preexec_fn=prepare, timeout=60)


@pytest.fixture
def replay(played, tmp_path):
    return ["replay", "--config", DEFAULTS, "--sequence", played.path, "--out", tmp_path / "out"]


def test_a_limit_on_the_size_of_files_is_an_error_of_writing(replay):
    done = call(*replay, limits=[(resource.RLIMIT_FSIZE, 200)])
    assert done.returncode == 1 and b".csv: cannot be written: File too large" in done.stderr


@pytest.mark.parametrize("closed", [(1,), (2,), (0, 1, 2)])
def test_a_closed_standard_file_takes_nothing_from_another(replay, tmp_path, closed):
    done = call(*replay, close=closed)
    assert done.returncode == (1 if 1 in closed else 0), done.stderr  # what it prints was lost
    assert (tmp_path / "out/motion.csv").read_text().startswith("frame,timestamp_ns,")
    assert (tmp_path / "out/bus.ccsds").read_bytes()[:1] == b"\x09"


def test_nobody_to_tell_ends_no_run(replay, tmp_path):
    with open("/dev/full", "wb") as full:
        assert call(*replay, err=full).returncode == 0
        assert call("replay", "--config", tmp_path / "absent", "--sequence", "x", "--out", "y", err=full).returncode == 2
        done = call("bus", "dump", tmp_path / "out/bus.ccsds", out=full)
    assert done.returncode == 1 and b"polhode: " in done.stderr


def test_no_memory_is_one_line(replay):
    done = call(*replay, limits=[(resource.RLIMIT_AS, 150_000_000)])
    assert done.returncode in (1, 2) and done.stderr.startswith(b"polhode: ") and len(done.stderr.splitlines()) == 1, done.stderr


# verifies: LIV-08
def test_a_disk_that_takes_no_more_is_said_at_once_and_the_run_goes_on(live, played, tmp_path):
    run = live(played.path, run__checkpoint=tmp_path / "checkpoint", run__checkpoint_frames=2, device__sequence_speed=2.0)
    resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE, (100, 100))
    done = run.finish()
    assert "disk: not written since the start: packets of 1 steps" in done.err, done.err
    assert done.status == 1 and "run.json: cannot be written: File too large" in done.err


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 16 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "none", place], capture_output=True, text=True)
    if mounted.returncode != 0:
        pytest.skip(f"no file system can be mounted here: {mounted.stderr.strip()}")
    yield place
    subprocess.run(["umount", "-l", place], check=True)


def heard(bus, name: str):
    """The next packet of this kind."""
    for _ in range(2000):
        octets = bus.next_octets(30.0)
        assert octets is not None, "the run says nothing more"
        packet = polhode_bus.decode(octets)
        if packet and packet.name == name:
            return packet
    raise AssertionError(f"no {name}")


@pytest.mark.parametrize("what", ["packets", "file: transport"])
def test_a_full_disk_is_said_while_the_run_goes_on(live, played, small_disk, tmp_path, what):
    """On standard error and in an event, with the first packet that the disk does not take."""
    keys = {"run__folder": small_disk / "run"} if what == "packets" else {}
    send = [f"unix:{tmp_path}/telemetry"] + ([f"file:{small_disk}/flight.ccsds"] if what != "packets" else [])
    with polhode_bus.open_bus(send[0]) as bus:
        run = live(played.path, device__sequence_passes=100000, device__sequence_speed=10.0, **keys,
                   settings=["transport.send=[" + ", ".join(f'"{one}"' for one in send) + "]"])
        event = heard(bus, "platform_event")
        assert run.process.poll() is None
        steps, checkpoints, records, streamed = event.value
        assert event.id == 1 and event.severity == "ERROR" and checkpoints == records == 0
        assert (steps >= 1 and streamed == 0) if what == "packets" else (steps == 0 and streamed >= 1)
        assert event.text == f"disk: not written: packets of {steps:.0f} steps, 0 checkpoints, 0 records, {streamed:.0f} packets of files"
        line = next(line for line in run.process.stderr if line.startswith("disk:"))
        assert f"packets of {steps:.0f} steps, 0 checkpoints, 0 records, {streamed:.0f} packets of files" in line
        later = heard(bus, "platform_event")  # once a second while there is more
        assert later.header.sequence == event.header.sequence + 1 and sum(later.value) > sum(event.value)
        assert heard(bus, "motion").frame > 0 and run.process.poll() is None
        run.process.terminate()
    assert run.finish().status == (1 if what == "packets" else 0)  # run.json has no room
    if what == "packets":
        assert [file.name for file in (small_disk / "run").iterdir()] == ["bus.ccsds"], "no part of it is left"
