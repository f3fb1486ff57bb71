"""The focal length that is estimated from pictures, and the refusal where they do not tell it."""

import os
import pathlib
import re
import shutil

import pytest
from made_sources import REPOSITORY, SAMPLE

pytestmark = [pytest.mark.further,
              pytest.mark.skipif(not (REPOSITORY / ".venv-colmap/bin/python3").exists(), reason="COLMAP is not set up: tools/setup.sh colmap")]
TEMPLE = pathlib.Path(os.environ.get("POLHODE_TEMPLE_RING", REPOSITORY.parent / "shared/data/temple_ring"))


def without_focal_length(source: pathlib.Path, folder: pathlib.Path, frames: int | None = None) -> pathlib.Path:
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    (camera / "data").symlink_to(source / "mav0/cam0/data")
    rows = (source / "mav0/cam0/data.csv").read_text().splitlines(keepends=True)
    (camera / "data.csv").write_text("".join(rows[:frames + 1] if frames else rows))
    text = (source / "mav0/cam0/sensor.yaml").read_text()
    (camera / "sensor.yaml").write_text(re.sub(r"(?m)^intrinsics:.*$", "intrinsics: auto", text))
    return folder


def estimated(run, folder):
    """(focal length, sigma) as they were written."""
    from polhode_ground.common.sequence import read_sequence
    done = run(folder, "--intrinsics", "auto")
    assert done.returncode == 0, done.stderr
    assert "1 sigma" in done.stdout
    sequence = read_sequence(folder)
    return sequence.camera.intrinsics_px[0], float(sequence.fields["sigma_focal_px"])


@pytest.mark.slow
def test_the_sample_within_1_per_cent(run, sample, tmp_path):
    focal_px, sigma_px = estimated(run, without_focal_length(SAMPLE, tmp_path / "SEQ"))
    true_px = sample.camera.intrinsics_px[0]
    assert abs(focal_px / true_px - 1) < 0.01 and abs(focal_px - true_px) < 3 * sigma_px and sigma_px < 0.02 * true_px


@pytest.mark.slow
@pytest.mark.skipif(not TEMPLE.exists(), reason="POLHODE_TEMPLE_RING is not there")
def test_the_temple_within_2_per_cent(run, tmp_path):
    focal_px, sigma_px = estimated(run, without_focal_length(TEMPLE, tmp_path / "SEQ"))
    assert abs(focal_px / 1520.4 - 1) < 0.02 and sigma_px < 0.02 * focal_px


def test_a_body_that_hardly_turns_does_not_tell(run, tmp_path):
    folder = without_focal_length(SAMPLE, tmp_path / "SEQ", frames=10)
    before = (folder / "mav0/cam0/sensor.yaml").read_text()
    done = run(folder, "--intrinsics", "auto")
    assert done.returncode == 1
    assert "the focal length can't be known from these pictures" in done.stderr.splitlines()[-1]
    assert "tools/calibrate_camera.py" in done.stderr.splitlines()[-1]
    assert (folder / "mav0/cam0/sensor.yaml").read_text() == before


def test_too_few_frames_are_refused(run, tmp_path):
    done = run(without_focal_length(SAMPLE, tmp_path / "SEQ", frames=5), "--intrinsics", "auto")
    assert done.returncode == 2 and "5 frames, at least 8 are needed" in done.stderr


def test_estimating_again_replaces_what_was_written(tmp_path):
    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.importing.focal import write
    folder = without_focal_length(SAMPLE, tmp_path / "SEQ")
    shutil.copy(folder / "mav0/cam0/sensor.yaml", tmp_path / "before")
    sensor, camera = folder / "mav0/cam0/sensor.yaml", read_sequence(folder, any_lens=True).camera
    for focal_px in (800.0, 900.0):
        write(sensor, camera, {"placed": 9, "points": 5, "focal_px": focal_px, "sigma_px": 4.0, "residual_px": 0.4}, 10)
    text = sensor.read_text()
    assert text.count("sigma_focal_px: 4") == 1 and text.count("focal length estimated") == 1 and "[900, 900, 319.5, 239.5]" in text
    assert "800" not in text
