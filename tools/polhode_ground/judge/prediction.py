"""The prediction of motion_model.json against the truth that came later.

A run that saw only the first frames of a sequence predicts what the rest of truth.csv tells. Alignment is that of the
run's own smoothed motion: nothing later goes into it.
"""

import pathlib
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from polhode_ground.common.sequence import read_json
from polhode_ground.common.tables import Motion
from polhode_ground.judge import align
from polhode_ground.judge.aligned import Aligned
from polhode_ground.judge.metrics import NORMALISED_BOUND


def truth_at(truth: Motion, timestamp_ns: int) -> tuple[Rotation, np.ndarray, np.ndarray] | None:
    """(R_CT, p_CT, w_T) of the truth, between its rows where need be; None outside of its time."""
    row = int(np.searchsorted(truth.timestamp_ns, timestamp_ns))
    if row == len(truth.timestamp_ns) or timestamp_ns < truth.timestamp_ns[0]:
        return None
    if truth.timestamp_ns[row] == timestamp_ns:
        return align.rotations(truth.q_CT[row]), truth.p_CT[row], truth.w_T[row]
    pair = [row - 1, row]
    part = (timestamp_ns - truth.timestamp_ns[row - 1]) / np.diff(truth.timestamp_ns[pair])[0]
    rotation = Slerp([0.0, 1.0], align.rotations(truth.q_CT[pair]))(part)
    p_CT, w_T = ((1 - part) * value[row - 1] + part * value[row] for value in (truth.p_CT, truth.w_T))
    return rotation, p_CT, w_T


def judge_row(row: dict[str, Any], aligned: Aligned) -> dict[str, Any] | None:
    """Errors of one prediction; None where the truth ends before it."""
    true = truth_at(aligned.truth, int(row["timestamp_ns"]))
    if true is None:
        return None
    R_CT, p_CT, w_T = true
    R_CE = align.rotations(np.array(row["q_CT"]))
    attitude_rad = float(align.angles_rad(R_CE * aligned.R_ET, R_CT))
    result = {
        "ahead_s": row["ahead_s"],
        "attitude_deg": np.degrees(attitude_rad),
        "sigma_attitude_deg": np.degrees(row["sigma_att_rad"]),
        "attitude_within_95_percent_bound": attitude_rad <= NORMALISED_BOUND * row["sigma_att_rad"],
        "rate_deg_s": float(np.degrees(np.linalg.norm(aligned.R_ET.inv().apply(row["w_T_rad_s"]) - w_T))),
        "position_percent_of_range": None,
        "position_within_95_percent_bound": None,
    }
    if row["p_CT"] is not None:
        p_E = np.array(row["p_CT"])[None, :]
        similarity = aligned.own_similarity
        moved = align.apply_similarity(similarity, Rotation.concatenate([R_CE]), p_E)[0]
        error_m = float(np.linalg.norm(moved - p_CT))
        result["position_percent_of_range"] = 100 * error_m / float(np.linalg.norm(p_CT))
        result["position_within_95_percent_bound"] = error_m <= NORMALISED_BOUND * similarity.scale * row["sigma_pos"]
    return result


def judge_prediction(model_path: pathlib.Path, aligned: Aligned | None) -> list[dict[str, Any]] | None:
    """One entry per predicted time that the truth covers; None without a prediction."""
    rows = read_json(model_path).get("prediction") or []
    if aligned is None or not rows:
        return None
    return [judged for judged in (judge_row(row, aligned) for row in rows) if judged is not None]
