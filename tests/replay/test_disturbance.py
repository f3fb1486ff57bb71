"""A body that is touched while it is watched: from one frame to the next it turns twice as fast."""

import csv
import pathlib
import subprocess
import sys

import numpy
from attitudes import mean_rotation, off_deg, rotation

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
JUMP = 40  # the last frame before it


def rate(row) -> numpy.ndarray:
    """w_T [rad/s]."""
    return numpy.array([float(row[f"w_T_{axis}"]) for axis in "xyz"])


# verifies: MOT-09
def test_poses_and_rates_follow_a_contact(replay, program, sample, tmp_path):
    sequence = tmp_path / "touched"
    subprocess.run([sys.executable, REPOSITORY / "hil/transform.py", "--kind", "rate_jump", "--set", "rate_jump.factor=2",
                    "--set", f"rate_jump.at_part={JUMP / 90}", sample, sequence], check=True, capture_output=True, timeout=120)
    done = replay(sequence)
    assert done.status == 0, done.err
    truth = {row["timestamp_ns"]: row for row in csv.DictReader((sequence / "truth.csv").open())}
    rows = [row for row in csv.DictReader((done.folder / "motion.csv").open()) if row["pose_valid"] == "1"]
    before = [row for row in rows if int(row["frame"]) <= JUMP]
    after = [row for row in rows if int(row["frame"]) > JUMP]
    assert len(before) > JUMP // 2 and len(after) >= 20
    R_TT = mean_rotation([rotation(truth[row["timestamp_ns"]]).T @ rotation(row) for row in before])

    assert max(off_deg(row, truth, R_TT) for row in after) < 2.0 and {row["target_frame"] for row in rows} == {"1"}

    assert all(row["rate_valid"] == "0" for row in after if int(row["frame"]) == JUMP + 1), "nobody knows it yet"
    for row in after:
        if row["rate_valid"] == "1":
            w_T = rate(truth[row["timestamp_ns"]])
            assert numpy.linalg.norm(R_TT @ rate(row) - w_T) < 0.1 * numpy.linalg.norm(w_T), row["frame"]

    listed = program("bus", "dump", done.folder / "bus.ccsds")
    assert listed.out.count("dynamics 2 to 1") >= 1, "motion_changed"
