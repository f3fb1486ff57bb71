"""A run's row by made-up runs of known error, and the frames that go with it."""

import numpy as np
import pyarrow.parquet
import pytest
from polhode_ground.campaigns import measures
from polhode_ground.campaigns.measures import longest_run, measure, turned_deg, write_result
from polhode_ground.common.tables import read_motion
from polhode_ground.testing.synthetic import Errors, tumbling_body, write_run, write_sequence
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module")
def body():
    return tumbling_body()


@pytest.fixture(scope="module")
def scene(tmp_path_factory, body):
    return write_sequence(tmp_path_factory.mktemp("scene") / "seq", body)


def measured(tmp_path, scene, body, causal, smoothed=None):
    return measure(write_run(tmp_path / "run", body, causal, smoothed), scene, shape=False)


def test_first_pose_coverage_and_turn(tmp_path, scene, body):
    row, frames = measured(tmp_path, scene, body, Errors(attitude_rms_rad=0.01, first_frame=30))
    steps = (body.R_CT[1:] * body.R_CT[:-1].inv()).magnitude()
    assert row["acquired"] and row["first_pose_frame"] == 30 and row["first_pose_s"] == pytest.approx(30.0)
    assert row["first_pose_turn_deg"] == pytest.approx(np.degrees(steps[:30].sum()), rel=1e-6)
    assert row["turn_total_deg"] == pytest.approx(np.degrees(steps.sum()), rel=1e-6)
    assert row["coverage"] == 90 / 120 and row["coverage_after_first"] == 1.0 and row["silence_frames"] == 0
    assert np.isnan(frames["attitude_error_deg"][:30]).all() and np.isfinite(frames["attitude_error_deg"][30:]).all()


def test_a_run_that_never_acquires_is_silent_from_end_to_end(tmp_path, scene, body):
    row, _ = measured(tmp_path, scene, body, Errors(first_frame=1000))
    assert not row["acquired"] and row["first_pose_frame"] is None and row["coverage"] == 0 == row["coverage_after_first"]
    assert row["silence_frames"] == 120 and row["silence_turn_deg"] == pytest.approx(row["turn_total_deg"])
    assert row["causal_attitude_rms_deg"] is None and row["causal_frames_wrong_confident"] == 0 and not row["causal_depth_reversed"]


def test_errors_and_bounds(tmp_path, scene, body):
    row, frames = measured(tmp_path, scene, body, Errors(attitude_rms_rad=np.radians(1.0)), Errors(attitude_rms_rad=np.radians(0.2)))
    assert row["causal_attitude_rms_deg"] == pytest.approx(1.0, rel=0.02) and row["smoothed_attitude_rms_deg"] == pytest.approx(0.2, rel=0.02)
    # Every error vector has its stated length, which is sqrt(3) sigmas of an axis: inside the 95 % bound of 2.80.
    assert row["causal_attitude_in_95"] == 1.0
    assert frames["attitude_sigma_deg"] == pytest.approx(1.0 / np.sqrt(3))
    assert row["causal_frames_wrong"] == 0


def test_frames_that_are_off_and_sure_of_it_are_counted(tmp_path, scene, body):
    errors = Errors(attitude_rms_rad=np.radians(8.0))
    run = write_run(tmp_path / "run", body, errors)
    text = (run / "motion.csv").read_text()
    sigma = repr(float(errors.attitude_rms_rad / np.sqrt(3)))
    assert sigma in text
    row, _ = measure(run, scene, shape=False)
    assert row["causal_frames_wrong"] == 120 and row["causal_frames_wrong_confident"] == 0, "it says 4.6 deg"
    (run / "motion.csv").write_text(text.replace(sigma, repr(float(np.radians(1.9)))))
    row, _ = measure(run, scene, shape=False)
    assert row["causal_frames_wrong_confident"] == 120 and row["causal_attitude_in_99"] == 0.0


def test_positions_are_held_to_their_sigma(tmp_path, scene, body):
    row, frames = measured(tmp_path, scene, body, Errors(position_rms_m=0.05))
    assert frames["position_error_m"] == pytest.approx(0.05, rel=0.1)
    assert frames["position_sigma_m"] == pytest.approx(0.05 / np.sqrt(3), rel=0.05), "of an axis, in metres"
    assert row["causal_position_in_95"] == 1.0 and row["causal_position_judged_frames"] == 120 and row["causal_position_beyond_99_frames"] == 0
    run = tmp_path / "run"
    lines = (run / "motion.csv").read_text().splitlines()
    column = lines[0].split(",").index("sigma_pos")
    spoiled = [",".join(repr(float(cell) / 4) if i == column else cell for i, cell in enumerate(line.split(","))) for line in lines[1:]]
    (run / "motion.csv").write_text("\n".join([lines[0], *spoiled]) + "\n")
    row, _ = measure(run, scene, shape=False)
    assert row["causal_position_in_99"] == 0.0 and row["causal_position_beyond_99_frames"] == 120


def test_a_depth_reversed_run_is_told(tmp_path, scene, body):
    row, _ = measured(tmp_path, scene, body, Errors(twin=True))
    assert row["causal_depth_reversed"] and row["causal_verdict"] == "twin"


def test_silence_is_the_longest_gap_after_the_first_pose():
    assert longest_run(np.array([1, 1, 0, 1, 1, 1, 0, 1], dtype=bool)) == (3, 3)
    assert longest_run(np.zeros(4, dtype=bool)) == (0, 0) and longest_run(np.ones(3, dtype=bool)) == (0, 3)


def test_silence_after_a_first_pose(tmp_path, scene, body):
    run = write_run(tmp_path / "run", body, Errors(first_frame=10))
    header, *lines = (run / "motion.csv").read_text().splitlines()
    never = write_run(tmp_path / "never", body, Errors(first_frame=1000))
    silent = (never / "motion.csv").read_text().splitlines()[1:]
    (run / "motion.csv").write_text("\n".join([header, *lines[:40], *silent[40:65], *lines[65:]]) + "\n")
    row, _ = measure(run, scene, shape=False)
    assert row["silence_frames"] == 25 and row["silence_s"] == pytest.approx(25.0) and row["coverage_after_first"] == 85 / 110


def test_turns_add_up_whatever_their_axis(scene):
    truth = read_motion(scene / "truth.csv")
    turned = turned_deg(truth)
    # Steps of the truth's own rate, about 2 deg/s in a body that nutates.
    assert turned[0] == 0 and np.diff(turned) == pytest.approx(np.degrees(np.linalg.norm(truth.w_T, axis=1))[:-1], rel=0.01)


def test_frames_without_truth_count_no_turn_of_their_own(tmp_path, scene, body):
    import shutil
    whole, _ = measured(tmp_path, scene, body, Errors(first_frame=30))
    partial = tmp_path / "partial"
    shutil.copytree(scene, partial)
    lines = (partial / "truth.csv").read_text().splitlines()
    (partial / "truth.csv").write_text("\n".join([*lines[:-3]]) + "\n")
    row, _ = measure(tmp_path / "run", partial, shape=False)
    assert row["first_pose_turn_deg"] == pytest.approx(whole["first_pose_turn_deg"])
    assert 0.95 * whole["turn_total_deg"] < row["turn_total_deg"] < whole["turn_total_deg"]


def test_nees_is_three_where_covariances_are_right():
    """5000 errors of a known covariance: the mean of NEES is 3, within 4 sigmas of sqrt(6 / 5000)."""
    class Part:
        pass
    rng, count = np.random.default_rng(2), 5000
    covariance = np.diag([1e-4, 4e-4, 9e-4]) + 1e-5
    part = Part()
    part.rows_E, part.R_ET = np.arange(count), Rotation.identity()
    part.R_CE = Rotation.random(count, rng=rng)
    part.R_CT = Rotation.from_rotvec(rng.multivariate_normal(np.zeros(3), covariance, count)) * part.R_CE
    nees = measures.attitude_nees(part, {int(row): covariance for row in part.rows_E})
    assert np.mean(nees) == pytest.approx(3.0, abs=4 * np.sqrt(6 / count))


def test_what_is_unknown_is_null_in_the_files(tmp_path, scene, body):
    row, frames = measured(tmp_path, scene, body, Errors(first_frame=30))
    folder = tmp_path / "result"
    folder.mkdir()
    write_result(row, frames, folder)
    table = pyarrow.parquet.read_table(folder / "frames.parquet")
    assert table.column("attitude_error_deg").null_count == 30 and table.num_rows == 120
    assert "NaN" not in (folder / "run.json").read_text()
