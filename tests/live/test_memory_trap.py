"""With everything on, nothing is asked of the machine between the first frame and the last: the kernel watches."""

import subprocess

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM

NOTHING = "nothing was asked of the machine"


@pytest.fixture(autouse=True)
def fixed(played):
    """Where malloc is the library's own there is nothing to be seen."""
    checked = subprocess.run([PROGRAM, "check", "--config", DEFAULTS, "--sequence", played.path, "--memory"],
                             capture_output=True, text=True)
    assert checked.returncode == 0, checked.stderr


@pytest.mark.parametrize("delay_frames", [0, 1])
def test_a_replay(played, tmp_path, delay_frames):
    (played.data / "1300000000.png").write_bytes(b"no picture")
    done = subprocess.run([PROGRAM, "replay", "--config", DEFAULTS, "--sequence", played.path, "--out", tmp_path / "out",
                           "--memory-trap", "--set", f"jobs.delay_frames={delay_frames}"],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and NOTHING in done.stderr, done.stderr


@pytest.mark.parametrize("delay_frames", [0, 1])
def test_a_live_run_that_records_sends_and_writes_checkpoints(live, played, tmp_path, delay_frames):
    run = live(played.path, memory_trap=True, device__sequence_passes=3,
               settings=[f"jobs.delay_frames={delay_frames}", 'transport.send=["udp:127.0.0.1:40123"]'],
               run__checkpoint=tmp_path / "checkpoint", run__checkpoint_frames=4, recording__folder=tmp_path / "recording",
               recording__complete=True)
    done = run.finish()
    assert done.status == 0 and NOTHING in done.err, done.err
