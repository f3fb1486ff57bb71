"""The constant freedoms between an estimate's body frame E and the truth's T: one rotation, one scale, one offset.

p_C = R_CE * p_E + p_CE (estimate) and p_C = R_CT * p_T + p_CT (truth) describe the same picture in the same camera frame,
so R_CE * R_ET = R_CT with one constant R_ET, and p_CT = scale * (p_CE + R_CE * o_E) with one constant o_E: the truth's
origin (the centre of mass) in E. The second equation is linear in (scale, scale * o_E) and stays well conditioned on a
straight approach, where an alignment of the camera's path in the body frame does not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

# Frames farther off than this many medians do not vote in the final least squares: they are wrong, not noisy.
OUTLIER_MEDIANS = 5.0
# Floors, so that a nearly perfect trajectory does not call its own rounding an outlier.
ANGLE_FLOOR_RAD = np.radians(0.05)
POSITION_FLOOR_RELATIVE = 5e-4
# Weight of "offset = 0" per square root of frame, relative to range: decides only what the data leave open (no rotation).
OFFSET_RIDGE = 1e-5


@dataclass
class Similarity:
    """Positions: p_CT = scale * (p_CE + R_CE * offset_E)."""

    scale: float
    offset_E: np.ndarray


def rotations(q_CT: np.ndarray) -> Rotation:
    """Rotations R_CT from quaternions [N,4] w,x,y,z."""
    return Rotation.from_quat(q_CT, scalar_first=True)


def angles_rad(left: Rotation, right: Rotation) -> np.ndarray:
    """Geodesic distance of two sets of rotations [N], in [0, pi]."""
    return np.asarray((left.inv() * right).magnitude())


def axis_angle_deg(a: np.ndarray, b: np.ndarray) -> float:
    """Between two axes [3], whatever their signs."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b))))


def _median_rotation(samples: Rotation, start: Rotation, steps: int = 50) -> Rotation:
    """L1 median by Weiszfeld's algorithm: a mean whose weights are one over the distance."""
    median = start
    for _ in range(steps):
        before, median = median, samples.mean(weights=1.0 / np.maximum(angles_rad(median, samples), 1e-6))
        if (before.inv() * median).magnitude() < 1e-12:
            break
    return median


def align_rotation(R_CE: Rotation, R_CT: Rotation) -> Rotation:
    """The constant R_ET with R_CE * R_ET ~ R_CT: L1 median over the frames, then least squares over its inliers."""
    samples = R_CE.inv() * R_CT
    # The medoid of a few candidates starts the median inside the largest cluster even where half of the frames are lost.
    candidates = samples[np.unique(np.linspace(0, len(samples) - 1, 25).astype(int))]
    cost = [angles_rad(one, samples).sum() for one in candidates]
    error_rad = angles_rad(_median_rotation(samples, candidates[int(np.argmin(cost))]), samples)
    inlier = error_rad <= max(OUTLIER_MEDIANS * np.median(error_rad), ANGLE_FLOOR_RAD)
    return samples[inlier].mean()


def apply_similarity(similarity: Similarity, R_CE: Rotation, p_CE: np.ndarray) -> np.ndarray:
    """Positions of the truth's origin as the aligned estimate has them, [N,3] in the truth's unit."""
    return similarity.scale * (p_CE + R_CE.apply(similarity.offset_E))


def align_positions(R_CE: Rotation, p_CE: np.ndarray, p_CT: np.ndarray, fit_scale: bool = True) -> Similarity:
    """Least squares for scale and offset, rows divided by range (errors are judged in % of range), outliers left out.

    With fit_scale False the scale stays 1: the estimate's own metres are judged.
    """
    range_m = np.linalg.norm(p_CT, axis=1)
    range_E = np.median(np.linalg.norm(p_CE, axis=1))
    inlier = np.ones(len(p_CE), dtype=bool)
    similarity = Similarity(1.0, np.zeros(3))
    for _ in range(5):
        similarity = _solve(R_CE[inlier], p_CE[inlier], p_CT[inlier], range_E, fit_scale)
        error = np.linalg.norm(apply_similarity(similarity, R_CE, p_CE) - p_CT, axis=1) / range_m
        kept = error <= max(OUTLIER_MEDIANS * np.median(error), POSITION_FLOOR_RELATIVE)
        if np.array_equal(kept, inlier):
            break
        inlier = kept
    return similarity


def _solve(R_CE: Rotation, p_CE: np.ndarray, p_CT: np.ndarray, range_E: float, fit_scale: bool) -> Similarity:
    """One linear least squares; unknowns (scale, scale * offset / range_E) or, with scale 1, the offset alone."""
    count = len(p_CE)
    row_weight = np.repeat(1.0 / np.linalg.norm(p_CT, axis=1), 3)
    offset_columns = R_CE.as_matrix().reshape(3 * count, 3) * range_E * row_weight[:, None]
    ridge = OFFSET_RIDGE * np.sqrt(count) * np.eye(3)
    seen = p_CT.reshape(-1) * row_weight
    moved = p_CE.reshape(-1) * row_weight
    if fit_scale:
        matrix = np.vstack([np.column_stack([moved, offset_columns]), np.column_stack([np.zeros(3), ridge])])
        solution = np.linalg.lstsq(matrix, np.concatenate([seen, np.zeros(3)]), rcond=None)[0]
        scale = solution[0]
        if scale <= 0:  # a mirrored path has no similarity: the ratio of ranges at least gives it a size
            scale = np.median(np.linalg.norm(p_CT, axis=1)) / range_E
            return Similarity(scale, _solve(R_CE, scale * p_CE, p_CT, range_E, False).offset_E / scale)
        return Similarity(scale, solution[1:] * range_E / scale)
    matrix = np.vstack([offset_columns, ridge])
    solution = np.linalg.lstsq(matrix, np.concatenate([seen - moved, np.zeros(3)]), rcond=None)[0]
    return Similarity(1.0, solution * range_E)


def camera_path_errors(R_CE: Rotation, p_CE: np.ndarray, R_CT: Rotation, p_CT: np.ndarray, R_ET: Rotation) -> np.ndarray:
    """Error [N] of the camera's position in the body frame after a similarity, in the truth's unit.

    Here an attitude error counts with the range as its lever. The rotation of the similarity is R_ET where the path is
    nearly a line (it would be free about it), else the least-squares one (Umeyama).
    """
    camera_E = -R_CE.inv().apply(p_CE)
    camera_T = -R_CT.inv().apply(p_CT)
    centred_E, centred_T = camera_E - camera_E.mean(axis=0), camera_T - camera_T.mean(axis=0)
    strength = np.linalg.svd(centred_T.T @ centred_E, compute_uv=False)
    is_line = strength[1] <= 1e-3 * strength[0]
    turn = R_ET.inv() if is_line else Rotation.align_vectors(centred_T, centred_E)[0]
    turned = turn.apply(centred_E)
    scale = (turned * centred_T).sum() / max((turned * turned).sum(), 1e-30)
    return np.asarray(np.linalg.norm(scale * turned - centred_T, axis=1))
