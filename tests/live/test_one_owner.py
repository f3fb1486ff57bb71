"""Where one run writes no other does: refused by a lock that names the other's pid. What another user has made is not taken for our own."""

import json
import os
import pathlib

import polhode_bus
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

NOBODY = 65534  # a user that is not root


@pytest.fixture
def first(live, played, until, tmp_path):
    """A run that plays on and on, with all places that there are."""
    key = tmp_path / "key"
    key.write_text("5a" * 32)
    key.chmod(0o600)
    run = live(played.path, name="first", device__sequence_passes=100000, device__sequence_speed=1.0, run__checkpoint=tmp_path / "checkpoint",
               recording__folder=tmp_path / "recording", commands__key=key, commands__window=tmp_path / "window",
               settings=[f'transport.send=["file:{tmp_path}/flight.ccsds", "shm:/polhode_owner_{os.getpid()}"]', f'transport.receive="unix:{tmp_path}/c"'])
    until(lambda: (run.folder / "bus.ccsds").exists() and (run.folder / "bus.ccsds").stat().st_size > 0)
    yield run
    pathlib.Path(f"/dev/shm/polhode_owner_{os.getpid()}").unlink(missing_ok=True)


PLACES = {
    "run.folder": lambda at: {"run__folder": at / "first"},
    "run.checkpoint": lambda at: {"run__checkpoint": at / "checkpoint"},
    "recording.folder": lambda at: {"recording__folder": at / "recording"},
    "commands.window": lambda at: {"commands__window": at / "window", "commands__key": at / "key", "transport__receive": f"unix:{at}/d"},
    "transport.send": lambda at: {"settings": [f'transport.send=["file:{at}/flight.ccsds"]']},
    "transport.send: shm": lambda at: {"settings": [f'transport.send=["shm:/polhode_owner_{os.getpid()}"]']},
}


def test_a_second_run_is_refused_and_the_first_goes_on(first, live, played, tmp_path):
    for number, (key, keys) in enumerate(PLACES.items()):
        ended = live(played.path, name=f"other{number}", **keys(tmp_path)).finish()
        assert ended.status == 1, (key, ended.err)  # a service manager tries again
        last = ended.err.splitlines()[-1]
        assert key in last and f": process {first.process.pid} has it" in last, ended.err
    first.process.terminate()
    assert first.finish().status == 0
    assert json.loads((first.folder / "run.json").read_text())["checkpoints"]["failed"] == 0


def test_a_run_that_was_killed_holds_nothing(first, live, played, tmp_path):
    first.process.kill()
    first.finish()
    ended = live(played.path, name="second", **{key: value for keys in PLACES.values() for key, value in keys(tmp_path).items()}).finish()
    assert ended.status == 0, ended.err


def test_a_replay_leaves_the_folder_of_another_one_alone(live, played, replayed, program_status, tmp_path):
    out = tmp_path / "replayed"
    replayed(played.path)
    folder = os.open(out, os.O_RDONLY)
    import fcntl

    fcntl.flock(folder, fcntl.LOCK_EX)
    status, err = program_status("replay", "--config", REPOSITORY / "config/default.toml", "--sequence", played.path, "--out", out)
    os.close(folder)
    assert status == 1 and err == f"polhode: --out {out}: process {os.getpid()} has it\n"
    assert (out / "bus.ccsds").exists()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file to another user")
def test_a_ring_made_beforehand_by_another_user_is_not_taken(live, played, program_status, until):
    ring = pathlib.Path(f"/dev/shm/polhode_forged_{os.getpid()}")
    settings = [f'transport.send=["shm:/{ring.name}"]']
    try:
        assert live(played.path, name="forger", settings=settings).finish().status == 0  # whole, with packets
        forged = ring.read_bytes()
        os.chown(ring, NOBODY, NOBODY)
        ended = live(played.path, name="victim", settings=settings).finish()
        assert ended.status == 2 and ended.err.splitlines()[-1].endswith(f"transport.send: shm:/{ring.name}: belongs to user {NOBODY}, not to 0")
        assert ring.read_bytes() == forged
        with pytest.raises(PermissionError, match="another user"):
            polhode_bus.open_bus(f"shm:/{ring.name}")
        status, err = program_status("bus", "follow", f"shm:/{ring.name}", "--timeout", "1")
        assert status == 2 and "belongs to another user" in err and len(err.splitlines()) == 1
        os.chown(ring, 0, 0)
        ring.chmod(0o606)
        with pytest.raises(PermissionError, match="open to others"):
            polhode_bus.open_bus(f"shm:/{ring.name}")
        assert live(played.path, name="again", settings=settings).finish().status == 0  # our own, replaced
        assert ring.stat().st_mode & 0o777 == 0o600
        polhode_bus.open_bus(f"shm:/{ring.name}").close()
    finally:
        ring.unlink(missing_ok=True)
