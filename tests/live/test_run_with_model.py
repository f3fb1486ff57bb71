"""A live run begins with what an earlier one has learnt of its target."""

import json
import subprocess

import pytest
from polhode_ground.testing.replay_files import PROGRAM, SAMPLE
from test_recording import bus, export


def model(*arguments):
    return subprocess.run([PROGRAM, "model", *arguments], capture_output=True, text=True)


def excerpt(folder, frames):
    """The first frames of the sample."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    for name in ("data", "sensor.yaml"):
        (camera / name).symlink_to(SAMPLE / "mav0/cam0" / name)
    (camera / "data.csv").write_text("\n".join((SAMPLE / "mav0/cam0/data.csv").read_text().splitlines()[:frames + 1]) + "\n")
    return folder


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    """The model of a replay."""
    folder = tmp_path_factory.mktemp("learnt")
    config = folder / "config.toml"
    config.write_text("")
    subprocess.run([PROGRAM, "replay", "--config", PROGRAM.parents[3] / "config/default.toml", "--sequence", excerpt(folder / "sequence", 30),
                    "--out", folder / "out", "--save-model", folder / "target.model"], check=True, capture_output=True)
    return folder / "target.model"


# verifies: LIV-02, MAP-12
def test_a_run_with_a_model_knows_its_target_at_once_and_replays_to_the_same_bytes(live, replayed, learnt, tmp_path):
    run = live(excerpt(tmp_path / "sequence", 12), run__model=learnt, run__checkpoint=tmp_path / "checkpoint",
               recording__folder=tmp_path / "recording", recording__complete=True)
    done = run.finish()
    assert done.status == 0 and f"with the model {learnt}" in done.err, done.err
    assert json.loads((run.folder / "run.json").read_text())["frames_with_pose"] >= 9
    export(tmp_path / "recording", tmp_path / "exported")
    assert replayed(tmp_path / "exported", "--checkpoint", tmp_path / "exported/checkpoint", config=tmp_path / "exported/config.toml") == bus(run)

    made = tmp_path / "from_checkpoint.model"
    told = model("save", tmp_path / "checkpoint", made, "--config", tmp_path / "exported/config.toml")
    assert told.returncode == 0, told.stderr
    assert "landmarks from" in model("check", made).stdout
    again = live(tmp_path / "sequence", name="again", run__model=tmp_path / "absent", run__checkpoint=tmp_path / "checkpoint")
    err = again.finish().err
    assert "start warm" in err and "absent" not in err  # a checkpoint is newer than any model


def test_a_model_that_will_not_do_is_said_and_keeps_no_run_from_starting(live, played, tmp_path):
    (tmp_path / "notes").write_text("mine")
    run = live(played.path, run__model=tmp_path / "notes")
    done = run.finish()
    assert done.status == 0 and f"the model is not used: {tmp_path / 'notes'}: no model of a target" in done.err
    check = subprocess.run([PROGRAM, "check", "--config", tmp_path / "run.toml"], capture_output=True, text=True)
    assert check.returncode == 2 and "run.model" in check.stderr and "no model of a target" in check.stderr
