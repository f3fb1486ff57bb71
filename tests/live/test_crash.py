"""A run that crashes soon after its start: the next one begins from the checkpoint before, the third one cold."""

import os
import signal
import struct
import zlib

import pytest
from polhode_ground.testing.replay_files import DEFAULTS

BUILD_ID_AT, CONTENT_CRC_AT, HEADER_CRC_AT, HEADER_OCTETS = 108, 128, 236, 240


@pytest.fixture
def start(live, played, tmp_path):
    """A run on the same checkpoint; `slow` plays on and on, a frame each 0.1 s."""

    def run(name, slow=False, **options):
        pace = {"device__sequence_passes": 100000, "device__sequence_speed": 1.0} if slow else {}
        return live(played.path, name=name, run__checkpoint=tmp_path / "checkpoint", **{"run__checkpoint_frames": 4, **pace, **options})

    return run


@pytest.fixture
def crashed(start, until):
    """@return what a run said that died of a signal after its first packets."""

    def run(name, number=signal.SIGSEGV):
        run = start(name, slow=True, run__checkpoint_frames=1000000)
        until(lambda: (run.folder / "bus.ccsds").exists() and (run.folder / "bus.ccsds").stat().st_size > 0)
        os.kill(run.process.pid, number)
        done = run.finish()
        assert done.status == -number, done.err
        return done.err

    return run


# verifies: LIV-05
def test_two_generations_then_cold_then_warm_again(start, crashed):
    assert start("first", device__sequence_speed=1.0).finish().status == 0  # slow enough for two generations
    assert "start warm" in crashed("second")
    err = crashed("third", signal.SIGABRT)
    assert "start warm" in err and "the last checkpoint is not used: a run that began from it crashed" in err
    fourth = start("fourth").finish()
    assert fourth.status == 0 and "start cold: 2 runs in a row crashed soon after their start" in fourth.err
    assert "start warm" in start("fifth").finish().err


def test_a_kill_is_no_crash(start, crashed):
    assert start("first").finish().status == 0
    for name in ("second", "third", "fourth"):
        err = crashed(name, signal.SIGKILL)
        assert "start warm" in err and "is not used" not in err


def with_right_checksums(octets: bytearray) -> bytes:
    octets[CONTENT_CRC_AT:CONTENT_CRC_AT + 4] = struct.pack("<I", zlib.crc32(octets[HEADER_OCTETS:]))
    octets[HEADER_CRC_AT:HEADER_OCTETS] = struct.pack("<I", zlib.crc32(octets[:HEADER_CRC_AT]))
    return bytes(octets)


def of_another_build(octets: bytes) -> bytes:
    other = bytearray(octets)
    other[BUILD_ID_AT] ^= 1
    return with_right_checksums(other)


def poisoned(octets: bytes) -> bytes:
    """Values changed before it was written: all checksums are right."""
    other = bytearray(octets)
    for at in range(HEADER_OCTETS + 1000, len(other), 101):
        other[at] ^= 0x40
    return with_right_checksums(other)


@pytest.mark.parametrize(("spoil", "reason"), [(of_another_build, "of another build"), (poisoned, "holds values that no run leaves")])
def test_with_right_checksums_it_is_refused_all_the_same(start, program_status, played, tmp_path, spoil, reason):
    file = tmp_path / "checkpoint"
    assert start("first", run__checkpoint_frames=1000000).finish().status == 0
    file.write_bytes(spoil(file.read_bytes()))
    status, err = program_status("replay", "--config", DEFAULTS, "--sequence", played.path, "--out", tmp_path / "out", "--checkpoint", file)
    assert status == 2 and reason in err
    second = start("second").finish()
    assert second.status == 0 and f"start cold: the checkpoint is not used: {reason}" in second.err


def test_where_commands_are_signed_checkpoints_are_too(start, tmp_path):
    """One octet that a run may well leave, and all checksums right."""
    key = tmp_path / "commands.key"
    key.write_text("c4" * 32)
    key.chmod(0o600)
    signed = {"commands__key": key, "commands__window": tmp_path / "window"}
    file = tmp_path / "checkpoint"
    assert start("first", **signed).finish().status == 0
    good = file.read_bytes()
    altered = bytearray(good)
    altered[HEADER_OCTETS + 16] ^= 1
    for octets, begun in ((good, "start warm: "), (with_right_checksums(altered), "start cold: the checkpoint is not used: not signed by the key of commands")):
        for old in tmp_path.glob("checkpoint*"):
            old.unlink()
        file.write_bytes(octets)
        file.chmod(0o600)
        done = start(begun.split()[1], **signed).finish()
        assert done.status == 0 and begun in done.err, done.err


def test_a_replay_takes_none_that_was_altered(start, program_status, played, tmp_path):
    assert start("first").finish().status == 0
    good = (tmp_path / "checkpoint").read_bytes()
    for at in (0, 40, 130, HEADER_OCTETS, len(good) // 2, len(good) - 1):
        spoilt = tmp_path / "spoilt"
        spoilt.write_bytes(good[:at] + bytes([good[at] ^ 4]) + good[at + 1:])
        status, err = program_status("replay", "--config", DEFAULTS, "--sequence", played.path, "--out", tmp_path / "out", "--checkpoint", spoilt)
        assert status == 2 and "damaged" in err and str(spoilt) in err, (at, err)
