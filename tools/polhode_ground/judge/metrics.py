"""Errors of one motion file against the truth: the quantities of "How results are judged".

Every function takes the alignments of a run's target frames T (one, unless its map was begun anew) and returns a plain
dictionary over the frames of all of them; a value that can't be computed is None, never 0.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from polhode_ground.common.tables import COUNTS, Motion, join, target_frames
from polhode_ground.judge import align, period, twin
from polhode_ground.judge.aligned import Aligned, align_each

# 95 % bound of the norm of three independent unit normal errors: sqrt(chi2.ppf(0.95, 3)).
NORMALISED_BOUND = 2.7955
# Counts are told over this many equal parts of a run.
COUNT_PARTS = 10


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def coverage(estimate: Motion, frames_in: int) -> dict[str, Any]:
    """Share of the input frames with a valid pose, and how many frames pass before the first one."""
    valid = estimate.pose_valid
    first = int(np.argmax(valid)) if valid.any() else None
    after = int(valid[first:].sum()) / max(frames_in - first, 1) if first is not None else None
    return {
        "frames_in": frames_in,
        "frames_with_pose": int(valid.sum()),
        "coverage": int(valid.sum()) / frames_in,
        "frames_until_first_pose": first,
        "coverage_after_first_pose": after,
    }


def counts(estimate: Motion) -> list[dict[str, Any]]:
    """What the frames had to work with over time: means of each count over the parts of the run, None where not told.

    Features, matches and inliers are those of a frame, landmarks and keyframes those of the map.
    """
    parts = np.array_split(np.arange(len(estimate.timestamp_ns)), min(COUNT_PARTS, len(estimate.timestamp_ns)))
    result = []
    for rows in parts:
        told = {name: estimate.columns[name][rows] for name in COUNTS}
        means = {name: float(np.nanmean(values)) if np.isfinite(values).any() else None for name, values in told.items()}
        result.append({"from_s": float(estimate.seconds[rows[0]]), "to_s": float(estimate.seconds[rows[-1]]), **means})
    return result


def _joined(values: Iterable[Any]) -> np.ndarray:
    """Arrays of the parts as one, over their first axis."""
    return np.concatenate([np.asarray(value) for value in values])


def attitude_error_rad(parts: list[Aligned]) -> np.ndarray:
    """[N] over the frames of all parts."""
    return _joined([part.attitude_error_rad for part in parts])


def attitude(parts: list[Aligned]) -> dict[str, Any]:
    error_deg = np.degrees(attitude_error_rad(parts))
    return {"rmse_deg": rms(error_deg), "max_deg": float(error_deg.max()), "median_deg": float(np.median(error_deg))}


def _camera_path_error(part: Aligned) -> np.ndarray:
    """[N] error of the camera's path in the body frame over range, in the frames of one unit."""
    kept = part.one_unit
    path_m = align.camera_path_errors(
        part.R_CE[kept], part.estimate.p_CT[part.rows_E][kept], part.R_CT[kept], part.truth.p_CT[part.rows_T][kept], part.R_ET
    )
    return np.asarray(path_m / part.range_m[kept])


def position(parts: list[Aligned]) -> dict[str, Any]:
    """RMSE in % of range: of the camera's path in the body frame after a similarity, and of p_CT after scale and offset.

    The first has the attitude error with the range as its lever; the second is how well the target is placed as seen
    from the camera. In metres, with the estimate's own scale, only where it claims one; the scale error is the last T's.
    """
    path = _joined([_camera_path_error(part) for part in parts])
    seen = _joined([(part.position_error_m / part.range_m)[part.one_unit] for part in parts])
    metric = [part for part in parts if part.metric]
    result = {
        "rmse_percent_of_range": 100 * rms(path),
        "max_percent_of_range": 100 * float(np.max(path)),
        "rmse_from_camera_percent_of_range": 100 * rms(seen),
        "max_from_camera_percent_of_range": 100 * float(np.max(seen)),
        "metric": bool(metric),
        "rmse_m": None,
        "scale_error_percent": None,
    }
    if metric:
        result["rmse_m"] = rms(_joined([part.own_position_error_m[part.one_unit] for part in metric]))
        result["scale_error_percent"] = 100 * (1 / float(metric[-1].similarity.scale) - 1)
    return result


def rate_pairs(part: Aligned) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(rows into the estimate [M], w_T of the estimate in the truth's axes [M,3], of the truth [M,3]), rad/s."""
    rows_E, rows_T = join(part.estimate, part.truth)
    both = part.estimate.rate_valid[rows_E] & part.truth.rate_valid[rows_T]
    rows_E, rows_T = rows_E[both], rows_T[both]
    return rows_E, part.R_ET.inv().apply(part.estimate.w_T[rows_E]) if both.any() else np.empty((0, 3)), part.truth.w_T[rows_T]


def all_rate_pairs(parts: list[Aligned]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rate_pairs of all parts, in order of the rows."""
    rows, estimate, truth = (_joined(values) for values in zip(*(rate_pairs(part) for part in parts)))
    order = np.argsort(rows, kind="stable")
    return rows[order], estimate[order], truth[order]


def rates(parts: list[Aligned]) -> dict[str, Any] | None:
    """Angular velocity errors in the truth's axes [deg/s] and period errors; None without rates in both files."""
    rows_E, w_E, w_T = all_rate_pairs(parts)
    if len(w_E) == 0:
        return None
    error_deg_s = np.degrees(w_E - w_T)
    time_s = parts[0].estimate.seconds[rows_E]
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
        "period": {axis: period.period_error(time_s, w_E[:, i], w_T[:, i], speed_true) for i, axis in enumerate("xyz")},
    }


def velocity_pairs(part: Aligned) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(rows into the estimate [M], v_C as published [M,3], moved to the mass centre [M,3], truth [M,3]), m/s.

    An estimate without a scale takes it from the alignment. The published velocity is that of the estimate's origin;
    the truth's is that of the mass centre, at offset o_E: v_mass = v + R_CE * (w x o_E), with w and R of the truth.
    """
    estimate, truth = part.estimate, part.truth
    rows_E, rows_T = join(estimate, truth)
    both = estimate.velocity_valid[rows_E] & truth.velocity_valid[rows_T] & (estimate.scale_known[rows_E] == part.metric)
    rows_E, rows_T = rows_E[both], rows_T[both]
    if not both.any():
        return rows_E, np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3))
    scale = 1.0 if part.metric else part.similarity.scale
    published = scale * estimate.v_C[rows_E]
    R_CE = align.rotations(truth.q_CT[rows_T]) * part.R_ET.inv()
    w_E = part.R_ET.apply(truth.w_T[rows_T])
    moved = published + scale * R_CE.apply(np.cross(w_E, part.similarity.offset_E))
    return rows_E, published, moved, truth.v_C[rows_T]


def all_velocity_pairs(parts: list[Aligned]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """velocity_pairs of all parts."""
    rows, published, moved, true = (_joined(values) for values in zip(*(velocity_pairs(part) for part in parts)))
    return rows, published, moved, true


def velocity(parts: list[Aligned]) -> dict[str, Any] | None:
    """Linear velocity errors [m/s] as published, and with the constant offset of the origin accounted for."""
    _, published, moved, true = all_velocity_pairs(parts)
    if len(true) == 0:
        return None
    result: dict[str, Any] = {"frames": len(true), "scale_from_alignment": not all(part.metric for part in parts)}
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


def _normalised(error: np.ndarray, sigma: np.ndarray) -> dict[str, Any] | None:
    """Share of frames whose error norm is within the 95 % bound of the published sigma (1 sigma of the worst axis).

    A sigma of zero promises that there is no error: it counts among the frames, not among the ratios.
    """
    known = np.isfinite(sigma) & np.isfinite(error)
    if not known.any():
        return None
    error, sigma = error[known], sigma[known]
    ratio = error[sigma > 0] / sigma[sigma > 0]
    return {
        "frames": len(error),
        "within_95_percent_bound": float(np.mean(error <= NORMALISED_BOUND * sigma)),
        "rms_normalised": rms(ratio) / np.sqrt(3.0) if len(ratio) else None,
        "median_normalised": float(np.median(ratio)) if len(ratio) else None,
    }


def consistency(parts: list[Aligned]) -> dict[str, Any]:
    """Error norms over published sigmas. At least 95 % of the frames should be within the bound.

    A sigma is that of the worst axis, so rms_normalised of honest sigmas lies between 0.58 (one axis has all the error)
    and 1 (all axes alike); above, the sigmas promise too much, far below, too little.
    """
    found: dict[str, list[Any]] = {name: [] for name in ("attitude", "position", "velocity", "rate")}
    for part in parts:
        sigma = {name: values for name, values in part.estimate.columns.items() if name.startswith("sigma")}
        length_scale = part.own_similarity.scale
        rows_w, w_E, w_T = rate_pairs(part)
        rows_v, _, v_moved, v_true = velocity_pairs(part)
        found["attitude"].append((part.attitude_error_rad, sigma["sigma_att_rad"][part.rows_E]))
        found["position"].append((part.own_position_error_m, length_scale * sigma["sigma_pos"][part.rows_E]))
        found["velocity"].append((np.linalg.norm(v_moved - v_true, axis=1), length_scale * sigma["sigma_vel"][rows_v]))
        found["rate"].append((np.linalg.norm(w_E - w_T, axis=1), sigma["sigma_rate_rad_s"][rows_w]))
    return {name: _normalised(*(_joined(values) for values in zip(*pairs))) for name, pairs in found.items()}


def judge_frames(parts: list[Aligned], estimate: Motion) -> dict[str, Any]:
    """How many target frames T the poses are in, and each by itself; poses in a T of a single frame can't be judged."""
    judged: list[dict[str, Any]] = [
        {
            "target_frame": part.target_frame,
            "frames": len(part.rows_E),
            "attitude_rmse_deg": rms(np.degrees(part.attitude_error_rad)),
            "twin": twin.judge_twin(part.R_CE, part.R_CT, part.truth.p_CT[part.rows_T]),
        }
        for part in parts
    ]
    return {
        "count": len(target_frames(estimate)),
        "poses_judged": sum(one["frames"] for one in judged),
        "poses_not_judged": int(estimate.pose_valid.sum()) - sum(one["frames"] for one in judged),
        "each": judged,
    }


def judge_motion(estimate: Motion, truth: Motion, frames_in: int) -> dict[str, Any]:
    """Everything that one motion file is judged by."""
    report = {"coverage": coverage(estimate, frames_in), "counts": counts(estimate)}
    parts = align_each(estimate, truth)
    if not parts:
        return report
    frames, last = judge_frames(parts, estimate), parts[-1]
    return report | {
        "attitude": attitude(parts),
        "position": position(parts),
        "rates": rates(parts),
        "velocity": velocity(parts),
        "consistency": consistency(parts),
        "target_frames": frames,
        "twin": twin.worst([one["twin"] for one in frames["each"]]),
        "alignment": {
            "R_ET_rotvec_rad": [float(x) for x in last.R_ET.as_rotvec()],
            "scale": float(last.similarity.scale),
            "offset_E": [float(x) for x in last.similarity.offset_E],
        },
    }
