"""Tells the depth-reversed (Necker) twin from the truth.

Under weak perspective a body and its mirror image in depth, turning with mirrored in-plane rates, give the same picture:
with D the reflection along the line of sight, R_CT_twin = D * R_CT * D up to a constant rotation. An estimator that has
picked the twin shows every frame "registered" and a low residual, and all its attitudes are wrong.
"""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from polhode_ground.judge.align import align_rotation, angles_rad

# Below this distance between truth and its own twin (RMSE after alignment) the two can't be told apart by attitude:
# the body turned about the line of sight only, or hardly at all.
SEPARATION_MIN_DEG = 2.0
# An attitude error above this part of the separation, or above this angle, fits neither of the two: a map that fell
# apart is nearer to the one or the other by chance.
NEITHER_RATIO = 0.7
NEITHER_DEG = 20.0
# Longer turns between frames have no clear axis.
STEP_MAX_RAD = np.radians(120.0)
# From harmless to worst.
VERDICTS = ("indistinguishable", "truth", "neither", "twin")


def twin_of(R_CT: Rotation, p_CT: np.ndarray) -> Rotation:
    """The depth-reversed twin's attitudes of a trajectory; the reflection is along each frame's line of sight."""
    sight_C = p_CT / np.linalg.norm(p_CT, axis=1, keepdims=True)
    reflection = np.eye(3) - 2 * sight_C[:, :, None] * sight_C[:, None, :]
    return Rotation.from_matrix(reflection @ R_CT.as_matrix() @ np.diag([1.0, 1.0, -1.0]))


def aligned_rmse_deg(R_CE: Rotation, R_CT: Rotation) -> float:
    """Attitude RMSE after the best constant rotation."""
    error_rad = angles_rad(R_CE * align_rotation(R_CE, R_CT), R_CT)
    return float(np.degrees(np.sqrt(np.mean(error_rad**2))))


def in_plane_factor(R_CE: Rotation, R_CT: Rotation) -> float | None:
    """Least-squares factor k in (in-plane turn of the estimate) = k * (in-plane turn of the truth), frame to frame.

    Near +1 when right, near -1 for the twin; needs no alignment. None where the body hardly turns in the plane.
    """
    turn_E = (R_CE[1:] * R_CE[:-1].inv()).as_rotvec()
    turn_T = (R_CT[1:] * R_CT[:-1].inv()).as_rotvec()
    short = (np.linalg.norm(turn_E, axis=1) < STEP_MAX_RAD) & (np.linalg.norm(turn_T, axis=1) < STEP_MAX_RAD)
    flat_E, flat_T = turn_E[short, :2], turn_T[short, :2]
    power = float((flat_T**2).sum())
    total = float((turn_T[short] ** 2).sum())
    if power < 1e-10 or power < 1e-4 * total:
        return None
    return float((flat_E * flat_T).sum() / power)


def judge_twin(R_CE: Rotation, R_CT: Rotation, p_CT: np.ndarray) -> dict[str, Any]:
    """Which of the two an estimate follows; attitudes of the same N >= 2 frames.

    @return verdict: 'truth', 'twin', 'neither' or 'indistinguishable', and the three RMSE [deg] that it rests on.
    """
    R_twin = twin_of(R_CT, p_CT)
    separation_deg = aligned_rmse_deg(R_twin, R_CT)
    to_truth_deg = aligned_rmse_deg(R_CE, R_CT)
    to_twin_deg = aligned_rmse_deg(R_CE, R_twin)
    if separation_deg < SEPARATION_MIN_DEG:
        verdict = "indistinguishable"
    elif min(to_truth_deg, to_twin_deg) > min(NEITHER_RATIO * separation_deg, NEITHER_DEG):
        verdict = "neither"
    else:
        verdict = "twin" if to_twin_deg < to_truth_deg else "truth"
    return {
        "verdict": verdict,
        "rmse_to_truth_deg": to_truth_deg,
        "rmse_to_twin_deg": to_twin_deg,
        "truth_to_twin_deg": separation_deg,
        "in_plane_rate_factor": in_plane_factor(R_CE, R_CT),
    }


def worst(judged: list[dict[str, Any]]) -> dict[str, Any]:
    """Of several parts of a run the one that must not be missed."""
    return max(judged, key=lambda one: VERDICTS.index(one["verdict"]))
