"""Pictures that are not of their time stamp's moment, and things that rest in the picture while the body turns."""

import csv
import json
import math
import pathlib
import subprocess
import sys

import pytest
from attitudes import mean_rotation, off_deg, rotation

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def changed(replay, sample, tmp_path):
    """Replays the sample, changed in one way. @return rows of the causal and the smoothed motion, truth by time, frames changed,
    counters."""

    def call(kind: str, *settings: str):
        sequence = tmp_path / kind
        chosen = [argument for setting in settings for argument in ("--set", f"{kind}.{setting}")]
        subprocess.run([sys.executable, REPOSITORY / "hil/transform.py", "--kind", kind, *chosen, sample, sequence],
                       check=True, capture_output=True, timeout=120)
        done = replay(sequence)
        assert done.status == 0, done.err
        truth = {row["timestamp_ns"]: row for row in csv.DictReader((sequence / "truth.csv").open())}
        rows = [[row for row in csv.DictReader((done.folder / name).open()) if row["pose_valid"] == "1"]
                for name in ("motion.csv", "motion_smoothed.csv")]
        faults = {int(row["frame"]) for row in csv.DictReader((sequence / "faults.csv").open())}
        return *rows, truth, faults, json.loads((done.folder / "summary.json").read_text())["counters"]

    return call


def expect_right(rows, truth, faults=()):
    """Each attitude within three of its own sigmas, in one T, which the good frames tell, each as well as its sigma says."""
    assert {row["target_frame"] for row in rows} == {"1"}
    R_TT = mean_rotation([rotation(truth[row["timestamp_ns"]]).T @ rotation(row) / float(row["sigma_att_rad"]) ** 2
                          for row in rows if int(row["frame"]) not in faults])
    for row in rows:
        assert off_deg(row, truth, R_TT) < 3.0 * math.degrees(float(row["sigma_att_rad"])), row["frame"]


@pytest.mark.parametrize(("kind", "settings"), [pytest.param("near_repeated", ["fraction=0.2"], marks=pytest.mark.further), ("stale", ["fraction=0.07", "age_frames=5"])])
def test_a_picture_of_another_moment_moves_neither_poses_nor_t(changed, kind, settings):
    causal, smoothed, truth, faults, counters = changed(kind, *settings)
    good = [row for row in causal if int(row["frame"]) not in faults]
    assert len(faults) >= 6 and len(good) > 0.9 * (len(truth) - len(faults) - 5), "silence is no answer"
    expect_right(causal, truth, faults)
    expect_right(smoothed, truth, faults)
    assert counters["restarts"] == 0


@pytest.mark.parametrize("kind", ["caption", pytest.param("own_structure", marks=pytest.mark.further)])
def test_what_rests_in_the_picture_keeps_no_target_from_being_acquired(changed, kind):
    causal, _, truth, _, counters = changed(kind)
    assert int(causal[0]["frame"]) <= 10 and len(causal) > 0.85 * len(truth)
    expect_right(causal, truth)
    assert counters["start_contests"] <= 3, "each costs a tenth of a second"
