"""What a replay reaches against truth: the shipped sample, and real photographs where they are at hand."""

import os
import pathlib
import shutil

import pytest
from polhode_ground.testing.replay_files import judged_motion

# The photographs may not be passed on: who has them says where they are (CONTRIBUTING.md).
PHOTOGRAPHS = os.environ.get("POLHODE_TEMPLE_RING")


# verifies: MOT-01, MOT-11
def test_sample(sample_run, tmp_path):
    # The judge adds files to the folder of a run, and others read this one.
    run = shutil.copytree(sample_run.folder, tmp_path / "run")
    found = judged_motion(run, sample_run.sequence, tmp_path / "judgement.json")
    assert found["causal"]["coverage"]["coverage_after_first_pose"] >= 0.95
    assert found["causal"]["attitude"]["rmse_deg"] <= 0.5
    assert max(found["causal"]["rates"]["rmse_deg_s"].values()) <= 0.1
    assert found["smoothed"]["coverage"]["coverage"] == 1.0
    # COLMAP, which sees all frames at once, comes to 0.35 deg and 0.61 % of range on these frames.
    assert found["smoothed"]["attitude"]["rmse_deg"] <= 0.35
    assert found["smoothed"]["position"]["rmse_percent_of_range"] <= 0.6
    assert found["causal"]["consistency"]["attitude"]["within_95_percent_bound"] >= 0.95
    assert found["smoothed"]["consistency"]["attitude"]["within_95_percent_bound"] >= 0.95
    assert found["causal"]["twin"]["verdict"] == "truth"


@pytest.mark.further
@pytest.mark.skipif(not PHOTOGRAPHS, reason="POLHODE_TEMPLE_RING names no folder (CONTRIBUTING.md)")
def test_photographs(replay, tmp_path):
    sequence = pathlib.Path(PHOTOGRAPHS).resolve()
    result = replay(sequence)
    assert result.status == 0, result.err
    found = judged_motion(result.folder, sequence, tmp_path / "judgement.json")
    assert found["causal"]["coverage"]["frames_until_first_pose"] <= 10
    assert found["causal"]["coverage"]["coverage_after_first_pose"] == 1.0
    assert found["causal"]["attitude"]["rmse_deg"] <= 1.0
    assert found["smoothed"]["coverage"]["coverage"] == 1.0
    assert found["smoothed"]["attitude"]["rmse_deg"] <= 0.3
    assert found["smoothed"]["position"]["rmse_percent_of_range"] <= 0.5
