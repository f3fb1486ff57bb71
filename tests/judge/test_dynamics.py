"""What a run says of the body's mass is judged against the scene's inertia and the trajectories' own mass centre."""

import copy
import json

import numpy as np
import pytest
from polhode_ground.common.tables import Motion
from polhode_ground.judge.aligned import align_last
from polhode_ground.judge.dynamics import judge_dynamics
from polhode_ground.testing.synthetic import tumbling_body
from scipy.spatial.transform import Rotation

TURN = Rotation.from_rotvec([0.3, -0.2, 0.5])  # R_ET: the estimate's axes against the truth's
OFFSET_E = np.array([0.02, -0.01, 0.03])  # the true mass centre in the estimate's axes, in its unit
SCALE = 4.0
MOMENTS = [0.2, 0.3, 0.5]


@pytest.fixture
def aligned():
    body = tumbling_body()
    everywhere = np.ones(len(body.time_s), dtype=bool)

    def motion(R_CT, p_CT):
        return Motion(path="made up", timestamp_ns=body.timestamp_ns, q_CT=R_CT.as_quat(scalar_first=True), p_CT=p_CT,
                      v_C=body.v_C, w_T=body.w_T, pose_valid=everywhere, rate_valid=everywhere,
                      velocity_valid=everywhere, scale_known=~everywhere)

    R_CE = body.R_CT * TURN.inv()
    return align_last(motion(R_CE, body.p_CT / SCALE - R_CE.apply(OFFSET_E)), motion(body.R_CT, body.p_CT))


def scene(moments=MOMENTS):
    return {"scene": {"motion": {"inertia_kg_m2": list(moments)}}}


def observed(value, sigma):
    return {"value": value, "sigma": sigma, "observability": "observed"}


def true_model():
    axes_E = TURN.apply(np.eye(3))
    return {
        "inertia_ratios": {"middle_over_least": observed(1.5, 0.03), "largest_over_least": observed(2.5, 0.05)},
        "principal_axes_T": [{"axis_T": list(axis), "sigma_rad": 0.01, "observability": "observed"} for axis in axes_E],
        "translation": {"centre_of_mass": [observed(float(OFFSET_E @ axis), 0.001) | {"axis_T": list(axis)} for axis in axes_E]},
    }


def judged(tmp_path, aligned, model, truth=None):
    file = tmp_path / "motion_model.json"
    file.write_text(json.dumps(model))
    return judge_dynamics(file, truth or scene(), aligned)


def test_a_true_model_has_no_errors(aligned, tmp_path):
    report = judged(tmp_path, aligned, true_model())
    for ratio in report["inertia_ratios"].values():
        assert ratio["error_percent"] == pytest.approx(0.0, abs=1e-9)
    assert report["principal_axes_worst_deg"] < 1e-3
    assert report["centre_of_mass"]["axes_known"] == 3
    assert report["centre_of_mass"]["error_m"] < 1e-4


def test_errors_are_told_in_the_truths_units_and_in_sigmas(aligned, tmp_path):
    model = true_model()
    model["inertia_ratios"]["largest_over_least"]["value"] = 2.6
    model["translation"]["centre_of_mass"][1]["value"] += 0.005
    turned = Rotation.from_rotvec([0.0, 0.0, np.radians(2.0)]).apply(model["principal_axes_T"][0]["axis_T"])
    model["principal_axes_T"][0]["axis_T"] = list(turned)
    report = judged(tmp_path, aligned, model)
    largest = report["inertia_ratios"]["largest_over_least"]
    assert largest["error_percent"] == pytest.approx(4.0) and largest["sigmas_off"] == pytest.approx(2.0)
    assert report["centre_of_mass"]["worst_axis_m"] == pytest.approx(0.02, rel=0.01)
    assert 0.5 < report["principal_axes_worst_deg"] <= 2.001


def test_what_is_called_unobserved_is_not_judged(aligned, tmp_path):
    model = true_model()
    nothing = {"value": None, "sigma": None, "observability": "unobserved"}
    model["inertia_ratios"] = {name: dict(nothing) for name in model["inertia_ratios"]}
    model["translation"]["centre_of_mass"][2] |= nothing
    # The order of the moments is unknown then: the one axis that is known may be any.
    model["principal_axes_T"] = [copy.deepcopy(model["principal_axes_T"][i]) for i in (2, 1, 0)]
    for axis in model["principal_axes_T"][:2]:
        axis |= {"axis_T": None, "sigma_rad": None, "observability": "unobserved"}
    report = judged(tmp_path, aligned, model)
    assert all(ratio["error_percent"] is None for ratio in report["inertia_ratios"].values())
    assert report["centre_of_mass"]["axes_known"] == 2
    assert report["principal_axes_worst_deg"] < 1e-3


def test_axes_of_equal_moments_are_not_judged(aligned, tmp_path):
    report = judged(tmp_path, aligned, true_model(), scene([0.2, 0.5, 0.5]))
    assert [axis["error_deg"] is None for axis in report["principal_axes"]] == [False, True, True]


def test_without_a_fit_or_a_scene_little_is_judged(aligned, tmp_path):
    assert judge_dynamics(tmp_path / "missing.json", scene(), aligned) is None
    report = judged(tmp_path, aligned, true_model(), {"scene": {}})
    assert report["inertia_ratios"] is None and report["centre_of_mass"]["error_m"] < 1e-4
