"""What a campaign keeps of a run: one row of figures, and one row a frame.

Figures of time, turn and silence count from the first frame of the sequence. A run that never acquires has no attitude
error, and all else: its coverage is 0, its silence is the whole sequence, its first pose is never.
"""

import json
import pathlib
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet
from scipy.stats import chi2

from polhode_ground.campaigns.bus_file import packets_of, pose_covariance
from polhode_ground.campaigns.predictions import judge_points
from polhode_ground.common.fault_log import LOG_FILE, read_log
from polhode_ground.common.sequence import Sequence, read_sequence
from polhode_ground.common.tables import Motion, join
from polhode_ground.judge import align, metrics
from polhode_ground.judge.aligned import Aligned, align_each
from polhode_ground.judge.report import lookup
from polhode_ground.judge.run import Run, judge_run, read_run, read_truth

# A frame is confidently wrong when it is farther off than the one and says that it is not farther off than the other.
WRONG_DEG, CONFIDENT_DEG = 5.0, 2.0
PROBABILITIES = (0.95, 0.99)
FRAME_COLUMNS = (
    "frame",
    "timestamp_ns",
    "turn_deg",
    "pose_valid",
    "target_frame",
    "attitude_error_deg",
    "attitude_sigma_deg",
    "attitude_nees",
    "position_error_percent",
    "position_error_m",
    "position_sigma_m",
    "rate_error_deg_s",
    "rate_sigma_deg_s",
    "smoothed_attitude_error_deg",
    "smoothed_attitude_sigma_deg",
    "smoothed_position_error_m",
    "smoothed_position_sigma_m",
    "features",
    "matches",
    "inliers",
    "fault",
)


def turned_deg(truth: Motion) -> np.ndarray:
    """[N] how far the body has turned as the camera sees it since the first row, all turns added up."""
    R_CT = align.rotations(truth.q_CT)
    return np.asarray(np.degrees(np.concatenate([[0.0], np.cumsum((R_CT[1:] * R_CT[:-1].inv()).magnitude())])))


def longest_run(flags: np.ndarray) -> tuple[int, int]:
    """(first, length) of the longest stretch of true values; (0, 0) without any."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    if len(edges) == 0:
        return 0, 0
    first, length = edges[::2], edges[1::2] - edges[::2]
    longest = int(np.argmax(length))
    return int(first[longest]), int(length[longest])


def attitude_covariances(bus_file: pathlib.Path) -> dict[int, np.ndarray]:
    """Covariance [3,3] of the attitude error by frame index, in C, from the motion packets; {} where there is no bus file."""
    return {
        packet.frame: pose_covariance(packet.cov_pose)[:3, :3] for packet in packets_of(bus_file, "motion") if packet.cov_pose is not None
    }


def attitude_nees(part: Aligned, covariances: dict[int, np.ndarray]) -> np.ndarray:
    """[N] squared attitude error over its covariance, expected 3; NaN where there is none. Error: R_true = exp(phi) R."""
    phi = (part.R_CT * (part.R_CE * part.R_ET).inv()).as_rotvec()
    result = np.full(len(phi), np.nan)
    for i, row in enumerate(part.rows_E):
        covariance = covariances.get(int(row))
        if covariance is not None and np.linalg.det(covariance) > 0:
            result[i] = phi[i] @ np.linalg.solve(covariance, phi[i])
    return result


def _errors(estimate: Motion, truth: Motion, covariances: dict[int, np.ndarray]) -> dict[str, np.ndarray]:
    """Per row of the estimate [N], NaN where unknown: attitude, its sigma, NEES, position, its sigma, rate, its sigma.

    Positions are laid over the truth by one similarity a target frame T: in percent by a fitted scale, in metres by the run's
    own where it claims one, since its sigma holds the error of that.
    """
    names = (
        "attitude_error_deg",
        "attitude_sigma_deg",
        "attitude_nees",
        "position_error_percent",
        "position_error_m",
        "position_sigma_m",
        "rate_error_deg_s",
        "rate_sigma_deg_s",
    )
    found = {name: np.full(len(estimate.timestamp_ns), np.nan) for name in names}
    for part in align_each(estimate, truth):
        rows = part.rows_E
        found["attitude_error_deg"][rows] = np.degrees(part.attitude_error_rad)
        found["attitude_sigma_deg"][rows] = np.degrees(estimate.columns["sigma_att_rad"][rows])
        found["attitude_nees"][rows] = attitude_nees(part, covariances)
        found["position_error_percent"][rows] = 100 * part.position_error_m / part.range_m
        found["position_error_m"][rows] = part.own_position_error_m
        found["position_sigma_m"][rows] = part.own_similarity.scale * estimate.columns["sigma_pos"][rows]
        rows_w, w_E, w_T = metrics.rate_pairs(part)
        found["rate_error_deg_s"][rows_w] = np.degrees(np.linalg.norm(w_E - w_T, axis=1))
        found["rate_sigma_deg_s"][rows_w] = np.degrees(estimate.columns["sigma_rate_rad_s"][rows_w])
    return found


def _availability(causal: Motion, frames: int, seconds: np.ndarray, turn_deg: np.ndarray) -> dict[str, Any]:
    """First pose, coverage and silence. Frames that never came have no row and count as nothing."""
    valid = causal.pose_valid
    acquired = bool(valid.any())
    first = int(np.argmax(valid)) if acquired else None
    silent_from, silence = longest_run(~valid[first or 0 :])
    silent_from += first or 0
    last = min(silent_from + silence, frames - 1)
    return {
        "frames": frames,
        "turn_total_deg": float(turn_deg[-1]),
        "time_total_s": float(seconds[-1]),
        "acquired": acquired,
        "first_pose_frame": first,
        "first_pose_s": float(seconds[first]) if acquired else None,
        "first_pose_turn_deg": float(turn_deg[first]) if acquired else None,
        "coverage": int(valid.sum()) / frames,
        "coverage_after_first": int(valid[first:].sum()) / (frames - first) if first is not None else 0.0,
        "silence_frames": silence,
        "silence_s": float(seconds[last] - seconds[silent_from]) if silence else 0.0,
        "silence_turn_deg": float(turn_deg[last] - turn_deg[silent_from]) if silence else 0.0,
    }


def _rms(values: np.ndarray) -> float | None:
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else None


def _share(inside: np.ndarray, known: np.ndarray) -> float | None:
    return float(np.mean(inside[known])) if known.any() else None


def _accuracy(prefix: str, found: dict[str, np.ndarray], motion: dict[str, Any]) -> dict[str, Any]:
    """Errors of one motion file; None where it has no pose that can be judged."""
    error, sigma = found["attitude_error_deg"], found["attitude_sigma_deg"]
    known = np.isfinite(error) & np.isfinite(sigma)
    row = {
        "attitude_rms_deg": _rms(error),
        "attitude_max_deg": float(np.nanmax(error)) if np.isfinite(error).any() else None,
        "position_rms_percent": _rms(found["position_error_percent"]),
        "rate_rms_deg_s": _rms(found["rate_error_deg_s"]),
        "rate_mean_error_percent": lookup(motion, "rates.mean_error_percent"),
        "frames_wrong": int(np.sum(known & (error > WRONG_DEG))),
        "frames_wrong_confident": int(np.sum(known & (error > WRONG_DEG) & (sigma <= CONFIDENT_DEG))),
        "depth_reversed": lookup(motion, "twin.verdict") == "twin",
        "verdict": lookup(motion, "twin.verdict"),
        "target_frames": lookup(motion, "target_frames.count") or 0,
    }
    row["begun_anew"] = row["target_frames"] > 1
    for what, unit in (("attitude", "deg"), ("position", "m"), ("rate", "deg_s")):
        norms, sigmas = found[f"{what}_error_{unit}"], found[f"{what}_sigma_{unit}"]
        both = np.isfinite(norms) & np.isfinite(sigmas)
        row[f"{what}_judged_frames"] = int(both.sum())
        for probability in PROBABILITIES:
            # Published sigmas are of the worst axis: at least this share of the norms lies inside.
            inside, percent = norms <= np.sqrt(chi2.ppf(probability, 3)) * sigmas, round(100 * probability)
            row[f"{what}_in_{percent}"] = _share(inside, both)
            row[f"{what}_beyond_{percent}_frames"] = int(np.sum(both & ~inside))
    return {f"{prefix}_{name}": value for name, value in row.items()}


def _nees(values: np.ndarray) -> dict[str, Any]:
    """Mean over 3, expected 1, and shares inside the chi-square bounds, by the published covariance."""
    known = np.isfinite(values)
    row = {"causal_nees": float(np.mean(values[known]) / 3) if known.any() else None}
    for probability in PROBABILITIES:
        row[f"causal_nees_in_{round(100 * probability)}"] = _share(values <= chi2.ppf(probability, 3), known)
    return row


def measure(run_folder: pathlib.Path, sequence_folder: pathlib.Path, shape: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """(row of the run, columns of its frames)."""
    run, sequence = read_run(run_folder), read_sequence(sequence_folder)
    truth = read_truth(sequence)
    causal, smoothed = run.motions["causal"], run.motions["smoothed"]
    judged = (
        judge_run(run, sequence, truth)
        if shape
        else {"motion": {kind: metrics.judge_motion(motion, truth, len(sequence.timestamp_ns)) for kind, motion in run.motions.items()}}
    )
    found = _errors(causal, truth, attitude_covariances(run_folder / "bus.ccsds"))
    found_smoothed = _errors(smoothed, truth, {})
    frames = len(sequence.timestamp_ns)
    rows_E, rows_T = join(causal, truth)
    # Frames without truth are placed between those that have it, and count no turn beyond them.
    turn_deg = np.interp(
        causal.timestamp_ns - causal.timestamp_ns[0], causal.timestamp_ns[rows_E] - causal.timestamp_ns[0], turned_deg(truth)[rows_T]
    )
    row = _availability(causal, frames, causal.seconds, turn_deg)
    row |= _accuracy("causal", found, judged["motion"]["causal"]) | _accuracy("smoothed", found_smoothed, judged["motion"]["smoothed"])
    row |= _nees(found["attitude_nees"])
    row |= judge_points(run_folder / "bus.ccsds", sequence.folder, truth, align_each(causal, truth))
    row |= {
        "cloud_rmse_percent": lookup(judged, "shape.distance_rmse_percent"),
        "inertia_middle_error_percent": lookup(judged, "dynamics.inertia_ratios.middle_over_least.error_percent"),
        "inertia_largest_error_percent": lookup(judged, "dynamics.inertia_ratios.largest_over_least.error_percent"),
        "centre_of_mass_error_m": lookup(judged, "dynamics.centre_of_mass.error_m"),
        "losses": lookup(run.summary, "counters.lost"),
        "bus_sha256": lookup(run.summary, "bus_sha256"),
    }
    row |= _faults(run, sequence)
    kinds = {one.timestamp_ns: one.kind for one in read_log(sequence.folder / LOG_FILE)}
    columns = found | {
        "frame": np.arange(frames),
        "timestamp_ns": causal.timestamp_ns,
        "turn_deg": turn_deg,
        "pose_valid": causal.pose_valid,
        "target_frame": causal.target_frame,
        "smoothed_attitude_error_deg": found_smoothed["attitude_error_deg"],
        "smoothed_attitude_sigma_deg": found_smoothed["attitude_sigma_deg"],
        "smoothed_position_error_m": found_smoothed["position_error_m"],
        "smoothed_position_sigma_m": found_smoothed["position_sigma_m"],
        "fault": [kinds.get(int(stamp), "") for stamp in causal.timestamp_ns],
        **{name: causal.columns[name] for name in ("features", "matches", "inliers")},
    }
    return row, {name: columns[name] for name in FRAME_COLUMNS}


def _faults(run: Run, sequence: Sequence) -> dict[str, Any]:
    """Of the transform "faults": coverage of the good frames, wrong poses of bad ones, counters that are off; else None."""
    from polhode_ground.judge.faulted import COUNTER_OF, judge_faulted

    log = read_log(sequence.folder / LOG_FILE)
    if not log or not {one.kind for one in log} <= set(COUNTER_OF):
        return {"faults_injected": None, "faults_coverage_of_good": None, "faults_wrong_poses": None, "faults_miscounted": None}
    verdict = judge_faulted(run.folder, sequence)
    return {
        "faults_injected": sum(verdict.injected.values()),
        "faults_coverage_of_good": verdict.coverage,
        "faults_wrong_poses": len(verdict.wrong_poses),
        "faults_miscounted": sum(abs(verdict.counted[kind] - verdict.injected[kind]) for kind in COUNTER_OF),
    }


def write_result(row: dict[str, Any], frames: dict[str, Any], folder: pathlib.Path) -> None:
    """run.json and frames.parquet; NaN becomes null."""
    (folder / "run.json").write_text(json.dumps(row, indent=1, default=lambda value: value.item()) + "\n")
    columns = {
        name: pyarrow.array(values, from_pandas=True) if isinstance(values, np.ndarray) else pyarrow.array(values)
        for name, values in frames.items()
    }
    pyarrow.parquet.write_table(pyarrow.table(columns), folder / "frames.parquet")
