"""What is drawn over time: lines break at losses, the truth is of the same origin, the scale's sigma is told apart."""

import csv
import json

import numpy as np
import pytest
from polhode_ground.common.tables import read_motion
from polhode_ground.judge.run import read_run
from polhode_ground.plots import series
from polhode_ground.testing.synthetic import Errors, tumbling_body, write_run, write_sequence
from scipy.spatial.transform import Rotation


@pytest.fixture
def made(tmp_path):
    """(run folder, truth): 30 frames; velocity of another origin than the mass centre's."""
    body = tumbling_body(frames=30)
    sequence = write_sequence(tmp_path / "seq", body)
    run = write_run(tmp_path / "run", body, Errors(position_rms_m=0.02, attitude_rms_rad=0.01, velocity_rms_m_s=1e-5), sequence=sequence)
    return run, read_motion(sequence / "truth.csv")


def change(path, rows, **cells):
    with open(path, newline="") as stream:
        table = list(csv.DictReader(stream))
    for row in rows:
        table[row] |= cells
    with open(path, "w", newline="") as stream:
        writer = csv.DictWriter(stream, table[0].keys())
        writer.writeheader()
        writer.writerows(table)


def test_the_truth_of_a_velocity_is_that_of_the_estimates_own_origin(tmp_path):
    body = tumbling_body(frames=30)
    truth = read_motion(write_sequence(tmp_path / "seq", body) / "truth.csv")
    run = write_run(tmp_path / "run", body, Errors(velocity_rms_m_s=1e-5))
    found = series.velocity_series(read_run(run), "causal", truth)
    assert np.abs(found.value - found.truth).max() < 0.02  # mm/s; each error is 0.01 long, poses are exact
    centre = 1e3 * truth.v_C
    assert np.abs(centre - found.truth).max() > 0.5  # the origin circles the mass centre at 62 mm and 2 deg/s


def test_without_truth_both_motions_are_drawn_in_the_same_axes_and_of_the_same_origin(tmp_path):
    causal = Errors(velocity_rms_m_s=1e-5, scale=2.0, scale_known=False)
    smoothed = Errors(velocity_rms_m_s=1e-5, R_ET=Rotation.from_rotvec([-0.2, 0.4, 1.3]), offset_E_m=(-0.1, 0.06, 0.02), scale=0.5, scale_known=False)
    run = read_run(write_run(tmp_path / "run", tumbling_body(frames=30), causal, smoothed))
    for made, tolerance in ((series.rate_series, 1e-6), (series.velocity_series, 0.02)):  # deg/s; thousandths of a map unit/s, two errors of 0.005 in it
        early, late = made(run, "causal", None), made(run, "smoothed", None)
        assert np.abs(early.value - late.value).max() < tolerance
    assert np.abs(run.motions["causal"].w_T - run.motions["smoothed"].w_T).max() > 0.01  # rad/s: as they stand in the files
    sigma = run.motions["causal"].columns["sigma_vel"]
    assert series.velocity_series(run, "causal", None).sigma == pytest.approx(1e3 * sigma / 4, rel=1e-3)  # the smoothed poses' unit is four times as large


def test_lines_and_bands_break_at_a_loss_and_at_a_new_frame_T(made):
    run, truth = made
    change(run / "motion.csv", range(10, 13), pose_valid="0", rate_valid="0", velocity_valid="0")
    change(run / "motion.csv", range(20, 30), target_frame="2")
    for found in (series.rate_series(read_run(run), "causal", truth), series.velocity_series(read_run(run), "causal", truth)):
        gaps = np.flatnonzero(np.isnan(found.value[:, 0]))
        assert found.seconds[gaps].tolist() == [13.0, 20.0] and np.isnan(found.sigma[gaps]).all()
        assert np.isfinite(found.seconds).all() and len(found.seconds) == 27 + 2
    errors = series.error_series(read_run(run), "causal", truth)
    assert errors.target_frame_starts_s == [20.0] and np.isnan(errors.attitude_deg).sum() == 2


def test_the_sigma_of_a_position_is_told_with_and_without_the_scales(made):
    run, truth = made
    relative, own_m = 0.01, 0.02
    with open(run / "motion_smoothed.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    for index, row in enumerate(rows):
        range_m = np.linalg.norm([float(row[f"p_CT_{axis}"]) for axis in "xyz"])
        change(run / "motion_smoothed.csv", [index], sigma_pos=str(np.hypot(own_m, relative * range_m)))
    (run / "shape.json").write_text(json.dumps({"scale": {"known": True, "metres_per_map_unit": 2.0, "sigma": 2.0 * relative}}))
    found = series.error_series(read_run(run), "smoothed", truth)
    range_m = np.linalg.norm(truth.p_CT, axis=1)
    assert np.allclose(found.sigma_shape_position, 100 * own_m / range_m, rtol=2e-2)  # the fitted scale is not quite 1
    assert np.allclose(found.sigma_position, 100 * np.hypot(own_m, relative * range_m) / range_m, rtol=1e-2)
    assert found.metric


def test_a_run_without_scale_has_no_scale_sigma(made):
    run, truth = made
    found = series.error_series(read_run(run), "causal", truth)
    assert np.allclose(found.sigma_position, found.sigma_shape_position, rtol=5e-2)
