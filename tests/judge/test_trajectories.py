"""truth.tum, and evo as an oracle for what the judge says of a path."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest
from polhode_ground.common.tables import read_motion
from polhode_ground.judge import align
from polhode_ground.judge.aligned import align_last
from polhode_ground.judge.run import read_run
from polhode_ground.judge.trajectory import tum_text
from polhode_ground.testing.synthetic import Errors, tumbling_body, write_run, write_sequence

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def made(tmp_path):
    """(run with truth.tum, truth): noise in attitude and position, another frame T, another unit."""
    body = tumbling_body(frames=60)
    sequence = write_sequence(tmp_path / "seq", body)
    run = write_run(tmp_path / "run", body, Errors(attitude_rms_rad=0.01, position_rms_m=0.03, scale=2.5, scale_known=False), sequence=sequence)
    done = subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", run, sequence], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return run, read_motion(sequence / "truth.csv")


# verifies: PRG-07
def test_truth_is_the_camera_in_the_target(made):
    run, truth = made
    lines = (run / "truth.tum").read_text().splitlines()
    assert len(lines) == 60 and lines[1].startswith("1700000001.000000000 ")
    numbers = np.array([[float(cell) for cell in line.split()[1:]] for line in lines])
    p_TC, q_TC = numbers[:, :3], numbers[:, 3:]
    R_CT = align.rotations(truth.q_CT)
    assert np.allclose(R_CT.apply(p_TC) + truth.p_CT, 0, atol=1e-6)  # C's origin, seen from C
    assert np.allclose(np.abs(np.sum(q_TC * R_CT.inv().as_quat(), axis=1)), 1, atol=1e-8)


def test_rows_without_a_pose_are_left_out(made, tmp_path):
    run, truth = made
    truth.pose_valid[5:] = False
    (tmp_path / "t.tum").write_text(tum_text(truth))
    assert len((tmp_path / "t.tum").read_text().splitlines()) == 5
    truth.pose_valid[:] = False
    (tmp_path / "t.tum").write_text(tum_text(truth))
    assert (tmp_path / "t.tum").read_text() == ""


# verifies: PRG-07
@pytest.mark.further
def test_evo_says_the_same_error_of_the_path_as_the_judge(made):
    pytest.importorskip("evo", reason="evo is not installed: tools/setup.sh extras")
    from evo.core import metrics, sync
    from evo.tools import file_interface
    run, truth = made
    motion = read_run(run).motions["causal"]
    (run / "causal.tum").write_text(tum_text(motion))
    reference, estimate = (file_interface.read_tum_trajectory_file(str(run / name)) for name in ("truth.tum", "causal.tum"))
    reference, estimate = sync.associate_trajectories(reference, estimate)
    estimate.align(reference, correct_scale=True)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, estimate))
    part = align_last(motion, truth)
    judged = align.camera_path_errors(part.R_CE, motion.p_CT, part.R_CT, truth.p_CT, part.R_ET)
    assert len(ape.error) == 60 and np.sqrt(np.mean(judged**2)) > 0.05
    assert np.allclose(ape.error, judged, rtol=1e-3, atol=1e-5)  # nine digits are written
