"""A prediction is judged against the truth that came after the run."""

import json

import numpy as np
import pytest
from polhode_ground.common.tables import Motion
from polhode_ground.judge import align
from polhode_ground.judge.aligned import align_last
from polhode_ground.judge.prediction import judge_prediction, truth_at
from polhode_ground.testing.synthetic import tumbling_body
from scipy.spatial.transform import Rotation

TURN = Rotation.from_rotvec([0.3, -0.2, 0.5])  # the estimate's axes against the truth's
SCALE = 4.0
AHEAD_S = (0.0, 10.0, 30.0)


def motion(body, rows, R_CT, p_CT, in_metres=False):
    count = len(body.time_s[rows])
    everywhere = np.ones(count, dtype=bool)
    return Motion(path="made up", timestamp_ns=body.timestamp_ns[rows], q_CT=R_CT[rows].as_quat(scalar_first=True),
                  p_CT=p_CT[rows], v_C=body.v_C[rows], w_T=body.w_T[rows], pose_valid=everywhere,
                  rate_valid=everywhere, velocity_valid=everywhere, scale_known=everywhere if in_metres else ~everywhere)


@pytest.fixture
def case():
    """(aligned motion of the first 60 frames, predicted rows for a given attitude error [rad])."""
    body = tumbling_body()
    R_CE, p_CE = body.R_CT * TURN.inv(), body.p_CT / SCALE
    aligned = align_last(motion(body, slice(0, 60), R_CE, p_CE), motion(body, slice(None), body.R_CT, body.p_CT))

    def rows(error_rad, sigma_rad=0.01):
        last = 59
        made = []
        for ahead in AHEAD_S:
            i = last + int(ahead)
            wrong = Rotation.from_rotvec([error_rad, 0.0, 0.0])
            made.append({"ahead_s": ahead, "timestamp_ns": int(body.timestamp_ns[i]),
                         "q_CT": list((wrong * R_CE[i]).as_quat(scalar_first=True)), "sigma_att_rad": sigma_rad,
                         "w_T_rad_s": list(TURN.apply(body.w_T[i])), "sigma_rate_rad_s": 1e-4,
                         "p_CT": list(p_CE[i]), "sigma_pos": 0.01, "v_C": [0.0, 0.0, 0.0], "sigma_vel": 1.0})
        return made

    return aligned, rows


def judged(tmp_path, aligned, rows):
    file = tmp_path / "motion_model.json"
    file.write_text(json.dumps({"prediction": rows}))
    return judge_prediction(file, aligned)


def test_a_right_prediction_has_no_errors(case, tmp_path):
    aligned, rows = case
    for row in judged(tmp_path, aligned, rows(0.0)):
        assert row["attitude_deg"] < 1e-4 and row["rate_deg_s"] < 1e-6
        assert row["position_percent_of_range"] < 1e-3
        assert row["attitude_within_95_percent_bound"] and row["position_within_95_percent_bound"]


def test_an_error_is_told_and_held_against_its_sigma(case, tmp_path):
    aligned, rows = case
    far = judged(tmp_path, aligned, rows(0.05))
    assert [row["ahead_s"] for row in far] == list(AHEAD_S)
    assert far[1]["attitude_deg"] == pytest.approx(np.degrees(0.05), rel=1e-3)
    assert not far[1]["attitude_within_95_percent_bound"]
    assert judged(tmp_path, aligned, rows(0.05, sigma_rad=0.03))[1]["attitude_within_95_percent_bound"]


def test_beyond_the_truth_nothing_is_judged(case, tmp_path):
    aligned, rows = case
    late = rows(0.0)
    late[2]["timestamp_ns"] += 10_000_000_000_000
    assert len(judged(tmp_path, aligned, late)) == 2
    assert truth_at(aligned.truth, int(aligned.truth.timestamp_ns[0]) - 1) is None


def test_between_two_rows_the_truth_is_interpolated(case):
    aligned, _ = case
    truth = aligned.truth
    middle = int(truth.timestamp_ns[5] + truth.timestamp_ns[6]) // 2
    R_CT, p_CT, _ = truth_at(truth, middle)
    before = align.rotations(truth.q_CT[5])
    after = align.rotations(truth.q_CT[6])
    assert (before.inv() * R_CT).magnitude() == pytest.approx(0.5 * (before.inv() * after).magnitude(), rel=1e-6)
    assert p_CT == pytest.approx(0.5 * (truth.p_CT[5] + truth.p_CT[6]))


def test_a_run_without_a_prediction_is_not_judged(case, tmp_path):
    aligned, _ = case
    assert judged(tmp_path, aligned, []) is None
    assert judge_prediction(tmp_path / "missing.json", aligned) is None


def test_what_is_said_in_metres_keeps_its_own_scale(case, tmp_path):
    _, rows = case
    body, scale = tumbling_body(), 1.05
    R_CE, p_CE = body.R_CT * TURN.inv(), body.p_CT * scale
    truth = motion(body, slice(None), body.R_CT, body.p_CT)
    aligned = align_last(motion(body, slice(0, 60), R_CE, p_CE, in_metres=True), truth)
    wrong = [row | {"p_CT": [scale * SCALE * x for x in row["p_CT"]]} for row in rows(0.0)]
    unsure = [row | {"sigma_pos": 0.05 * float(np.linalg.norm(row["p_CT"]))} for row in wrong]
    for sure_row, unsure_row in zip(judged(tmp_path, aligned, wrong), judged(tmp_path, aligned, unsure), strict=True):
        assert sure_row["position_percent_of_range"] > 3.0  # of 5: the offset that is fitted takes some, or adds some later
        assert not sure_row["position_within_95_percent_bound"]
        assert unsure_row["position_within_95_percent_bound"]
