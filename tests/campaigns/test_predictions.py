"""Predicted points against the truth: errors drawn from the covariance have a NEES of 1, and a scene's truth goes on beyond its frames."""

import json

import numpy as np
import pytest
from polhode_ground.campaigns.predictions import Predicted, body_points, judge_points, points_nees, truth_later
from polhode_ground.common.tables import read_motion
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.judge import align
from scipy.spatial.transform import Rotation

SAMPLE = REPOSITORY / "hil/data/sample"
BOX = {"bounding_box_T_m": [[-1.0, -0.5, -0.2], [1.0, 0.7, 0.2]]}
SECOND_NS = 1_000_000_000


class Part:
    """An alignment that is known: the estimate is in map units of 0.5 m, its T turned and shifted."""
    R_ET = Rotation.from_rotvec([0.4, -0.2, 0.9])
    own_similarity = align.Similarity(0.5, np.array([0.3, -0.1, 0.2]))
    metric = False
    rows_E = np.arange(100)


def exact(R_CT: Rotation, p_CT: np.ndarray, covariance: np.ndarray) -> Predicted:
    """What a run without an error would have predicted: p_CT = scale (p_CE + R_CE offset_E), R_CT = R_CE R_ET."""
    R_CE = R_CT * Part.R_ET.inv()
    return Predicted(0, 10 * SECOND_NS, R_CE, p_CT / Part.own_similarity.scale - R_CE.apply(Part.own_similarity.offset_E), covariance)


def test_the_sides_of_the_box_have_their_middles():
    points = body_points(BOX)
    assert points == pytest.approx(np.array([[-1, 0.1, 0], [0, -0.5, 0], [0, 0.1, -0.2], [0, 0.1, 0.2], [0, 0.7, 0], [1, 0.1, 0]]))
    assert body_points({}).tolist() == [[0, 0, 0]]


def test_a_prediction_without_an_error_has_none():
    R_CT, p_CT = Rotation.from_rotvec([1.0, 0.3, -0.4]), np.array([0.2, -0.1, 8.0])
    assert points_nees(exact(R_CT, p_CT, np.eye(6)), Part, body_points(BOX), R_CT, p_CT) == pytest.approx(0, abs=1e-20)


def test_errors_as_large_as_the_covariance_says_have_a_nees_of_1():
    rng, R_CT, p_CT = np.random.default_rng(3), Rotation.from_rotvec([1.0, 0.3, -0.4]), np.array([0.2, -0.1, 8.0])
    root = 0.01 * (rng.normal(size=(6, 6)) + 2 * np.eye(6))
    found = []
    for _ in range(2000):
        error = root @ rng.normal(size=6)
        right = exact(R_CT, p_CT, root @ root.T)
        predicted = Predicted(0, 10 * SECOND_NS, Rotation.from_rotvec(-error[:3]) * right.R_CE, right.p_CE - error[3:], right.covariance)
        found.append(points_nees(predicted, Part, body_points(BOX), R_CT, p_CT))
    # A mean of 3 * 2000 squares has a sigma of 0.018: four of them, for each point.
    assert np.mean(found, axis=0) / 3 == pytest.approx(1.0, abs=0.073)


def test_the_truth_of_a_scene_goes_on_beyond_its_frames():
    truth, scene = read_motion(SAMPLE / "truth.csv"), json.loads((SAMPLE / "scene.json").read_text())
    for row in (0, 40, len(truth.timestamp_ns) - 1):
        rows_R, rows_p = truth_later(truth, scene, int(truth.timestamp_ns[row]))
        early = read_motion(SAMPLE / "truth.csv")
        early.timestamp_ns = early.timestamp_ns - 1000 * SECOND_NS  # no row is there any more: the motion answers
        later_R, later_p = truth_later(early, scene, int(truth.timestamp_ns[row]))
        assert (rows_R.inv() * later_R).magnitude() < 1e-6 and later_p == pytest.approx(rows_p, abs=1e-6)
    assert truth_later(truth, {}, int(truth.timestamp_ns[-1]) + SECOND_NS) is None
    assert truth_later(truth, scene, int(truth.timestamp_ns[0]) - 1) is None


def test_a_run_without_predictions_has_no_figures(tmp_path):
    row = judge_points(tmp_path / "bus.ccsds", SAMPLE, read_motion(SAMPLE / "truth.csv"), [])
    assert row == {f"{name}_{ahead}_s": value for ahead in (10, 60, 300) for name, value in (("predicted_nees", None), ("predicted_beyond_99", None), ("predictions", 0))}
