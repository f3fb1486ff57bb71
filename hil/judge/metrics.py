"""Errors of one motion file against the truth: the quantities of "How results are judged".

Every function takes plain arrays and returns a plain dictionary; a value that can't be computed is None, never 0.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from judge import align, period, twin
from judge.tables import COUNTS, Motion, join

# 95 % bound of the norm of three independent unit normal errors: sqrt(chi2.ppf(0.95, 3)).
NORMALISED_BOUND = 2.7955
# Counts are told over this many equal parts of a run.
COUNT_PARTS = 10


@dataclass
class Aligned:
    """The frames [N] that both files have with a valid pose, and the constant freedoms between them."""

    estimate: Motion
    truth: Motion
    rows_E: np.ndarray
    rows_T: np.ndarray
    R_CE: Rotation
    R_CT: Rotation
    R_ET: Rotation
    similarity: align.Similarity
    one_unit: np.ndarray  # [N] the frames whose lengths share one unit; those of the others are not judged
    metric: bool  # that unit is the metre

    @property
    def attitude_error_rad(self) -> np.ndarray:
        return align.angles_rad(self.R_CE * self.R_ET, self.R_CT)

    @property
    def position_error_m(self) -> np.ndarray:
        """[N] after the similarity; NaN in frames of another unit."""
        return self._position_error_m(self.similarity)

    @cached_property
    def own_similarity(self) -> align.Similarity:
        """What a run says in metres keeps its own, since its sigmas hold the error of its scale; one that claims no scale has it fitted."""
        if not self.metric:
            return self.similarity
        return _align_lengths(self.estimate, self.truth, self.rows_E, self.rows_T, self.one_unit, False)

    @property
    def own_position_error_m(self) -> np.ndarray:
        """[N] after own_similarity; NaN in frames of another unit."""
        return self._position_error_m(self.own_similarity)

    def _position_error_m(self, similarity: align.Similarity) -> np.ndarray:
        moved = align.apply_similarity(similarity, self.R_CE, self.estimate.p_CT[self.rows_E])
        return np.where(self.one_unit, np.linalg.norm(moved - self.truth.p_CT[self.rows_T], axis=1), np.nan)

    @property
    def range_m(self) -> np.ndarray:
        return np.linalg.norm(self.truth.p_CT[self.rows_T], axis=1)


def _align_lengths(estimate: Motion, truth: Motion, rows_E, rows_T, one_unit, fit_scale: bool = True) -> align.Similarity:
    kept_E, kept_T = rows_E[one_unit], rows_T[one_unit]
    return align.align_positions(align.rotations(estimate.q_CT[kept_E]), estimate.p_CT[kept_E], truth.p_CT[kept_T], fit_scale)


def align_run(estimate: Motion, truth: Motion) -> Aligned | None:
    """Aligns two files; None where fewer than two frames have a pose in both.

    A run that learns its scale on the way has rows in map units before and in metres after: those in metres are judged.
    """
    rows_E, rows_T = join(estimate, truth)
    both = estimate.pose_valid[rows_E] & truth.pose_valid[rows_T]
    rows_E, rows_T = rows_E[both], rows_T[both]
    if len(rows_E) < 2:
        return None
    R_CE, R_CT = align.rotations(estimate.q_CT[rows_E]), align.rotations(truth.q_CT[rows_T])
    known = estimate.scale_known[rows_E]
    metric = int(known.sum()) >= 2
    one_unit = known if metric else ~known
    return Aligned(estimate, truth, rows_E, rows_T, R_CE, R_CT, align.align_rotation(R_CE, R_CT),
                   _align_lengths(estimate, truth, rows_E, rows_T, one_unit), one_unit, metric)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def coverage(estimate: Motion, frames_in: int) -> dict:
    """Share of the input frames with a valid pose, and how many frames pass before the first one."""
    valid = estimate.pose_valid
    first = int(np.argmax(valid)) if valid.any() else None
    after = int(valid[first:].sum()) / max(frames_in - first, 1) if first is not None else None
    return {"frames_in": frames_in, "frames_with_pose": int(valid.sum()), "coverage": int(valid.sum()) / frames_in,
            "frames_until_first_pose": first, "coverage_after_first_pose": after}


def counts(estimate: Motion) -> list[dict]:
    """What the frames had to work with over time: means of each count over the parts of the run, None where not told.

    Features, matches and inliers are those of a frame, landmarks and keyframes those of the map.
    """
    parts = np.array_split(np.arange(len(estimate.timestamp_ns)), min(COUNT_PARTS, len(estimate.timestamp_ns)))
    result = []
    for rows in parts:
        told = {name: estimate.columns[name][rows] for name in COUNTS}
        result.append({"from_s": float(estimate.seconds[rows[0]]), "to_s": float(estimate.seconds[rows[-1]])} | {
            name: float(np.nanmean(values)) if np.isfinite(values).any() else None for name, values in told.items()})
    return result


def attitude(aligned: Aligned) -> dict:
    error_deg = np.degrees(aligned.attitude_error_rad)
    return {"rmse_deg": rms(error_deg), "max_deg": float(error_deg.max()), "median_deg": float(np.median(error_deg))}


def position(aligned: Aligned) -> dict:
    """RMSE in % of range: of the camera's path in the body frame after a similarity, and of p_CT after scale and offset.

    The first has the attitude error with the range as its lever; the second is how well the target is placed as seen
    from the camera. In metres, with the estimate's own scale, only where it claims one.
    """
    kept = aligned.one_unit
    p_CE, p_CT = aligned.estimate.p_CT[aligned.rows_E][kept], aligned.truth.p_CT[aligned.rows_T][kept]
    path_m = align.camera_path_errors(aligned.R_CE[kept], p_CE, aligned.R_CT[kept], p_CT, aligned.R_ET)
    range_m = aligned.range_m[kept]
    seen = aligned.position_error_m[kept] / range_m
    result = {"rmse_percent_of_range": 100 * rms(path_m / range_m),
              "max_percent_of_range": 100 * float(np.max(path_m / range_m)),
              "rmse_from_camera_percent_of_range": 100 * rms(seen),
              "max_from_camera_percent_of_range": 100 * float(np.max(seen)),
              "metric": aligned.metric, "rmse_m": None, "scale_error_percent": None}
    if aligned.metric:
        result["rmse_m"] = rms(aligned.own_position_error_m[kept])
        result["scale_error_percent"] = 100 * (1 / float(aligned.similarity.scale) - 1)
    return result


def rate_pairs(aligned: Aligned) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(rows into the estimate [M], w_T of the estimate in the truth's axes [M,3], of the truth [M,3]), rad/s."""
    rows_E, rows_T = join(aligned.estimate, aligned.truth)
    both = aligned.estimate.rate_valid[rows_E] & aligned.truth.rate_valid[rows_T]
    rows_E, rows_T = rows_E[both], rows_T[both]
    return rows_E, aligned.R_ET.inv().apply(aligned.estimate.w_T[rows_E]) if both.any() else np.empty((0, 3)), \
        aligned.truth.w_T[rows_T]


def rates(aligned: Aligned) -> dict | None:
    """Angular velocity errors in the truth's axes [deg/s] and period errors; None without rates in both files."""
    rows_E, w_E, w_T = rate_pairs(aligned)
    if len(w_E) == 0:
        return None
    error_deg_s = np.degrees(w_E - w_T)
    time_s = aligned.estimate.seconds[rows_E]
    speed_true = np.linalg.norm(w_T, axis=1).mean()
    # Along the true axis: the norm of a noisy vector would be too long.
    axis_T = w_T / np.maximum(np.linalg.norm(w_T, axis=1, keepdims=True), 1e-12)
    speed = np.einsum("ij,ij->i", w_E, axis_T).mean()
    mean_error = np.linalg.norm(w_E.mean(axis=0) - w_T.mean(axis=0))
    return {
        "frames": len(w_E),
        "rmse_deg_s": {axis: rms(error_deg_s[:, i]) for i, axis in enumerate("xyz")},
        "rmse_norm_deg_s": rms(np.linalg.norm(error_deg_s, axis=1)),
        "median_norm_deg_s": float(np.median(np.linalg.norm(error_deg_s, axis=1))),
        "mean_speed_error_percent": 100 * float(abs(speed - speed_true) / speed_true) if speed_true > 0 else None,
        "mean_error_percent": 100 * float(mean_error / speed_true) if speed_true > 0 else None,
        "period": {axis: period.period_error(time_s, w_E[:, i], w_T[:, i], speed_true) for i, axis in enumerate("xyz")}}


def velocity_pairs(aligned: Aligned) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(rows into the estimate [M], v_C as published [M,3], moved to the mass centre [M,3], truth [M,3]), m/s.

    An estimate without a scale takes it from the alignment. The published velocity is that of the estimate's origin;
    the truth's is that of the mass centre, at offset o_E: v_mass = v + R_CE * (w x o_E), with w and R of the truth.
    """
    estimate, truth = aligned.estimate, aligned.truth
    rows_E, rows_T = join(estimate, truth)
    both = estimate.velocity_valid[rows_E] & truth.velocity_valid[rows_T] & (estimate.scale_known[rows_E] == aligned.metric)
    rows_E, rows_T = rows_E[both], rows_T[both]
    if not both.any():
        return rows_E, np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3))
    scale = 1.0 if aligned.metric else aligned.similarity.scale
    published = scale * estimate.v_C[rows_E]
    R_CE = align.rotations(truth.q_CT[rows_T]) * aligned.R_ET.inv()
    w_E = aligned.R_ET.apply(truth.w_T[rows_T])
    moved = published + scale * R_CE.apply(np.cross(w_E, aligned.similarity.offset_E))
    return rows_E, published, moved, truth.v_C[rows_T]


def velocity(aligned: Aligned) -> dict | None:
    """Linear velocity errors [m/s] as published, and with the constant offset of the origin accounted for."""
    _, published, moved, true = velocity_pairs(aligned)
    if len(true) == 0:
        return None
    result = {"frames": len(true), "scale_from_alignment": not aligned.metric}
    mean_true = true.mean(axis=0)
    for name, value in (("", published), ("_offset_corrected", moved)):
        if not np.isfinite(value).all():
            continue
        mean_error = np.linalg.norm(value.mean(axis=0) - mean_true)
        result[f"rmse{name}_m_s"] = rms(np.linalg.norm(value - true, axis=1))
        for i, axis in enumerate("xyz"):
            result[f"rmse{name}_{axis}_m_s"] = rms((value - true)[:, i])
        if np.linalg.norm(mean_true) > 1e-9:
            result[f"mean_error{name}_percent"] = 100 * float(mean_error / np.linalg.norm(mean_true))
            speed = float(np.linalg.norm(value.mean(axis=0)) / np.linalg.norm(mean_true))
            result[f"mean_speed_error{name}_percent"] = 100 * abs(speed - 1)
    return result


def _normalised(error: np.ndarray, sigma: np.ndarray) -> dict | None:
    """Share of frames whose error norm is within the 95 % bound of the published sigma (1 sigma of the worst axis).

    A sigma of zero promises that there is no error: it counts among the frames, not among the ratios.
    """
    known = np.isfinite(sigma) & np.isfinite(error)
    if not known.any():
        return None
    error, sigma = error[known], sigma[known]
    ratio = error[sigma > 0] / sigma[sigma > 0]
    return {"frames": len(error), "within_95_percent_bound": float(np.mean(error <= NORMALISED_BOUND * sigma)),
            "rms_normalised": rms(ratio) / np.sqrt(3.0) if len(ratio) else None,
            "median_normalised": float(np.median(ratio)) if len(ratio) else None}


def consistency(aligned: Aligned) -> dict:
    """Error norms over published sigmas. At least 95 % of the frames should be within the bound.

    A sigma is that of the worst axis, so rms_normalised of honest sigmas lies between 0.58 (one axis has all the error)
    and 1 (all axes alike); above, the sigmas promise too much, far below, too little.
    """
    estimate = aligned.estimate
    sigma = {name: estimate.columns[name] for name in estimate.columns if name.startswith("sigma")}
    length_scale = aligned.own_similarity.scale
    rows_w, w_E, w_T = rate_pairs(aligned)
    rows_v, _, v_moved, v_true = velocity_pairs(aligned)
    return {
        "attitude": _normalised(aligned.attitude_error_rad, sigma["sigma_att_rad"][aligned.rows_E]),
        "position": _normalised(aligned.own_position_error_m, length_scale * sigma["sigma_pos"][aligned.rows_E]),
        "velocity": _normalised(np.linalg.norm(v_moved - v_true, axis=1),
                                length_scale * sigma["sigma_vel"][rows_v]),
        "rate": _normalised(np.linalg.norm(w_E - w_T, axis=1), sigma["sigma_rate_rad_s"][rows_w])}


def judge_motion(estimate: Motion, truth: Motion, frames_in: int) -> dict:
    """Everything that one motion file is judged by."""
    report = {"coverage": coverage(estimate, frames_in), "counts": counts(estimate)}
    aligned = align_run(estimate, truth)
    if aligned is None:
        return report
    report |= {"attitude": attitude(aligned), "position": position(aligned), "rates": rates(aligned),
               "velocity": velocity(aligned), "consistency": consistency(aligned),
               "twin": twin.judge_twin(aligned.R_CE, aligned.R_CT, truth.p_CT[aligned.rows_T]),
               "alignment": {"R_ET_rotvec_rad": [float(x) for x in aligned.R_ET.as_rotvec()],
                             "scale": float(aligned.similarity.scale),
                             "offset_E": [float(x) for x in aligned.similarity.offset_E]}}
    return report
