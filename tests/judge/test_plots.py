"""The pictures: each one is made, none needs what a run does not have, and bad input gets one line."""

import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.sequence import read_sequence
from polhode_ground.testing.synthetic import Errors, tumbling_body, write_acquired, write_run

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
ALL = {"rates.png", "velocity.png", "attitude_error.png", "counts.png", "cloud.png", "contact_sheet.png"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(sequence, run), see write_acquired()."""
    return write_acquired(tmp_path_factory.mktemp("plots"), frames=30)


@pytest.fixture
def run(made, tmp_path):
    """A copy of the run that a test may damage."""
    return pathlib.Path(shutil.copytree(made[1], tmp_path / "run"))


def plot(*arguments):
    return subprocess.run([sys.executable, REPOSITORY / "tools/plot_replay.py", *map(str, arguments)],
                          capture_output=True, text=True)


def pictures(folder):
    return {path.name for path in folder.glob("*.png")}


def test_all_pictures_of_a_whole_run_are_made_and_are_not_blank(run):
    done = plot(run)
    assert done.returncode == 0, done.stderr
    assert pictures(run / "plots") == ALL
    for name in ALL:
        values = np.asarray(Image.open(run / "plots" / name).convert("L"))
        assert values.shape[0] > 500 and values.std() > 10, name


def test_without_truth_the_estimate_is_drawn_in_its_own_axes(made, run, tmp_path):
    sequence = pathlib.Path(shutil.copytree(made[0], tmp_path / "seq"))
    (sequence / "truth.csv").unlink()
    done = plot(run, "--sequence", sequence, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert pictures(tmp_path / "out") == ALL - {"attitude_error.png"}


def test_without_observations_the_cloud_is_drawn_into_the_frames(run):
    (run / "observations.csv").unlink()
    assert plot(run).returncode == 0
    assert "contact_sheet.png" in pictures(run / "plots")


def test_without_cloud_smoothing_and_sequence_the_rest_is_drawn(run):
    for name in ("cloud.ply", "motion_smoothed.csv", "summary.json"):
        (run / name).unlink()
    done = plot(run)
    assert done.returncode == 0 and "give --sequence" in done.stderr
    assert pictures(run / "plots") == {"rates.png", "velocity.png", "counts.png"}


def test_a_run_that_never_acquired_is_drawn(made, tmp_path):
    body = tumbling_body(frames=30)
    run = write_run(tmp_path / "lost", body, Errors(first_frame=999), sequence=made[0])
    done = plot(run)
    assert done.returncode == 0, done.stderr
    assert {"counts.png", "contact_sheet.png"} <= pictures(run / "plots")


def test_a_broken_frame_is_said_in_its_place(made, run, tmp_path):
    sequence = pathlib.Path(shutil.copytree(made[0], tmp_path / "seq"))
    frame = read_sequence(sequence).frame_path(0)
    frame.write_bytes(frame.read_bytes()[:60])
    done = plot(run, "--sequence", sequence)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("arguments, expected", [
    (("/nonexistent",), "no such run folder"),
    (("RUN", "--sequence", "/nonexistent"), "no such sequence folder"),
    (("RUN", "--truth", "/nonexistent.csv"), "nonexistent.csv"),
    (("RUN", "--out", "/dev/null/plots"), "/dev/null/plots"),
])
def test_bad_arguments_get_one_line_and_status_2(run, arguments, expected):
    done = plot(*(run if a == "RUN" else a for a in arguments))
    assert done.returncode == 2
    assert expected in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_16_bit_frames_are_scaled_by_their_depth(made, tmp_path):
    sequence = pathlib.Path(shutil.copytree(made[0], tmp_path / "seq"))
    frame = read_sequence(sequence).frame_path(0)
    Image.fromarray(np.full((240, 320), 200 * 256, dtype=np.uint16)).save(frame)
    assert read_sequence(sequence).read_gray(0).max() == 200
