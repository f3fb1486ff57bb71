"""What a live run records replays to the same bytes."""

import json
import subprocess

from polhode_ground.testing.replay_files import PROGRAM


def export(recording, out, *arguments):
    done = subprocess.run([PROGRAM, "recording", "export", recording, "--out", out, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads((out / "recording.json").read_text())


def bus(run):
    return (run.folder / "bus.ccsds").read_bytes()


# verifies: LIV-02
def test_a_recorded_run_replays_to_the_same_bytes(live, played, replayed, tmp_path):
    (played.data / "1300000000.png").write_bytes(b"no picture")
    run = live(played.path, settings=["seed=5"], recording__folder=tmp_path / "recording", recording__complete=True)
    assert run.finish().status == 0
    about = export(tmp_path / "recording", tmp_path / "exported")
    assert about["frames"] == 12 and about["unreadable"] == 1 and about["same_bytes"] is True
    assert replayed(tmp_path / "exported", config=tmp_path / "exported/config.toml") == bus(run)


# verifies: LIV-02
def test_frames_that_were_passed_over_live_are_absent_in_the_replay(live, played, replayed, tmp_path):
    """Played a thousand times too fast: most frames are late. What was accepted decides the bytes."""
    run = live(played.path, device__sequence_speed=1000.0, recording__folder=tmp_path / "recording", recording__complete=True)
    assert run.finish().status == 0
    counted = json.loads((run.folder / "run.json").read_text())
    assert counted["camera"]["frames_late"] > 0
    about = export(tmp_path / "recording", tmp_path / "exported")
    assert about["frames"] == counted["frames_accepted"] < 12
    assert about["dropped"] == counted["camera"]["frames_late"]
    assert replayed(tmp_path / "exported", config=tmp_path / "exported/config.toml") == bus(run)


# verifies: LIV-02
def test_a_run_from_a_checkpoint_replays_from_it(live, played, replayed, tmp_path):
    options = {"run__checkpoint": tmp_path / "checkpoint", "recording__folder": tmp_path / "recording",
               "recording__complete": True}
    assert live(played.path, name="first", **options).finish().status == 0
    again = live(played.path, name="again", device__sequence_passes=3, **options)
    assert "warm" in again.finish().err
    about = export(tmp_path / "recording", tmp_path / "exported")
    assert about["starts_from_checkpoint"] is True
    # Frames whose time has passed are answered without being used, and a sequence cannot hold them twice.
    assert about["frames"] == 34
    assert replayed(tmp_path / "exported", "--checkpoint", tmp_path / "exported/checkpoint",
                    config=tmp_path / "exported/config.toml") == bus(again)


def test_a_checkpoint_that_is_none_is_refused_by_replay(program_status, played, tmp_path):
    bad = tmp_path / "bad"
    bad.write_bytes(b"x" * 1000)
    status, err = program_status("replay", "--config", "config/default.toml", "--sequence", played.path, "--out",
                                 tmp_path / "out", "--checkpoint", bad)
    assert status == 2 and "not a checkpoint" in err


def test_a_checkpoint_brings_its_own_parameters_and_says_so(live, played, program_status, tmp_path):
    options = {"run__checkpoint": tmp_path / "checkpoint", "recording__folder": tmp_path / "recording", "recording__complete": True}
    for name in ("first", "again"):
        assert live(played.path, name=name, **options).finish().status == 0
    export(tmp_path / "recording", tmp_path / "exported")
    status, err = program_status("replay", "--config", tmp_path / "exported/config.toml", "--sequence", played.path, "--out", tmp_path / "out",
                                 "--checkpoint", tmp_path / "exported/checkpoint", "--set", "bus.apid_first=600")
    assert status == 0 and "its parameters take the configuration's place: bus.apid_first" in err
