"""The truth at the frames' times: as it is where it has their stamps, interpolated between its rows where it has stamps of its own."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import Motion, in_frame, target_frames
from polhode_ground.common.units import UNITS, WORDS, likely_units
from polhode_ground.judge import align

# Between rows as far apart as this, a body of 10 deg/s that nutates at the rate of its spin strays from a steady turn by
# rate^2 * gap^2 / 8 = 0.01 deg; motion capture has ten rows in it.
GAP_MAX_S = 0.25
OF_THE_FRAMES = 0.5  # of the frames have their stamp in a truth that was made for them
# The clock's offset is looked for so far to both sides, first on a grid.
OFFSET_SEARCH_S, OFFSET_STEPS = 5.0, 101
OFFSET_FRAMES_MAX = 300  # evenly taken: more do not sharpen an offset that systematic errors limit
OFFSET_SIGMA_MAX_S = 0.5
ERROR_FLOOR_RAD = np.radians(0.01)
ARRAYS = ("timestamp_ns", "q_CT", "p_CT", "v_C", "w_T", "pose_valid", "rate_valid", "velocity_valid", "scale_known")


@dataclass
class Matching:
    """How the truth's rows become those of frames."""

    gap_max_s: float = GAP_MAX_S
    offset_s: float | None = 0.0  # the truth's clock is ahead of the frames' by this; None: to be estimated
    offset_sigma_s: float | None = None  # where it was estimated


def at_frames(truth: Motion, frames_ns: np.ndarray, matching: Matching) -> Motion:
    """The truth with a row at each of the frames that it covers. Its rows before the first and after the last frame stay."""
    half_filled = _half_filled(truth)
    assert matching.offset_s is not None, "estimated before"
    own_ns = truth.timestamp_ns - np.int64(round(matching.offset_s * 1e9))
    shifted = replace(truth, timestamp_ns=own_ns)
    exact = int(np.isin(frames_ns, own_ns).sum())
    if exact >= OF_THE_FRAMES * len(frames_ns):  # made for them: a frame without truth has none on purpose
        return replace(shifted, remark=_remark(matching, len(frames_ns), 0, len(frames_ns) - exact, half_filled))
    _check_unit(truth)
    at = _interpolated(shifted, frames_ns, round(matching.gap_max_s * 1e9))
    covered = at.pose_valid
    if not covered.any():
        raise BadInput(_no_overlap(truth, own_ns, frames_ns, matching))
    beside = _rows(shifted, (own_ns < frames_ns[0]) | (own_ns > frames_ns[-1]))
    remark = _remark(matching, len(frames_ns), int(covered.sum()) - exact, int((~covered).sum()), half_filled)
    return replace(_together(beside, _rows(at, covered)), remark=remark)


def _half_filled(truth: Motion) -> str:
    """What is to be said of rows with a part of a pose; those without any have none on purpose. @errors BadInput where no row has a whole one"""
    known = np.column_stack([np.isfinite(values).all(axis=1) for values in (truth.q_CT, truth.p_CT)])  # a part of a quaternion is none
    bad = np.flatnonzero(~known.all(axis=1) & known.any(axis=1))
    if not known.all(axis=1).any():
        missing = " and ".join(name for name, column in zip(("the quaternion q_CT", "the position p_CT"), known.T) if not column.any())
        raise BadInput(
            f"{truth.path}:2: no row of {len(known)} has a whole pose: {missing or 'one part of it'} has empty or nan cells from this line on"
        )
    return f"{len(bad)} of its {len(known)} rows have a part of a pose and are not used, the first in line {bad[0] + 2}" if len(bad) else ""


def _remark(matching: Matching, frames: int, interpolated: int, without: int, half_filled: str) -> str:
    parts = [half_filled] if half_filled else []
    if interpolated:
        parts.append(f"interpolated at {interpolated} of {frames} frames, between rows at most {matching.gap_max_s:g} s apart")
    if without:
        parts.append(f"{without} of {frames} frames have no truth and are not judged")
    if matching.offset_s:
        how = f" +- {matching.offset_sigma_s:.2g} s, estimated from the motion" if matching.offset_sigma_s is not None else " s, as stated"
        parts.append(f"its clock is ahead of the frames' by {matching.offset_s:+.4g}{how}")
    return "; ".join(parts)


def _check_unit(truth: Motion) -> None:
    units = likely_units(truth.timestamp_ns.tolist(), "ns")
    if "ns" not in units:
        likely = f": these look like {' or '.join(WORDS[unit] for unit in units)}" if units else ""
        raise BadInput(
            f"{truth.path}: timestamp_ns in steps of {np.median(np.diff(truth.timestamp_ns)):.6g} are no nanoseconds{likely}; write nanoseconds"
        )


def _no_overlap(truth: Motion, own_ns: np.ndarray, frames_ns: np.ndarray, matching: Matching) -> str:
    apart_s = float(np.median(np.diff(own_ns))) * 1e-9 if len(own_ns) > 1 else 0.0
    fitting = [
        unit for unit, scale in UNITS.items() if scale > 1 and frames_ns[0] <= int(own_ns[len(own_ns) // 2]) * scale <= frames_ns[-1]
    ]
    if fitting:
        return f"{truth.path}: timestamp_ns does not lie among the frames', but would in {WORDS[fitting[0]]}: write nanoseconds"
    begin_s, end_s = (own_ns[[0, -1]] - frames_ns[0]) * 1e-9
    return (
        f"{truth.path}: no frame lies between two of its rows at most {matching.gap_max_s:g} s apart: its {len(own_ns)} rows are {apart_s:.6g} s apart, from "
        f"{begin_s:.6g} s to {end_s:.6g} s after the first frame, the frames end at {(frames_ns[-1] - frames_ns[0]) * 1e-9:.6g} s; another sequence, "
        "a clock of its own (--clock-offset), or a wider gap (--truth-gap-s)?"
    )


def _interpolated(truth: Motion, frames_ns: np.ndarray, gap_max_ns: int) -> Motion:
    """Poses by slerp and lines, rates and velocities by lines; not valid where the rows beside a frame are farther apart."""
    rows = np.flatnonzero(truth.pose_valid)
    count = len(frames_ns)
    empty = np.full((count, 3), np.nan)
    no = np.zeros(count, bool)
    if len(rows) == 0:
        return replace(truth, timestamp_ns=frames_ns, pose_valid=no)
    stamps = truth.timestamp_ns[rows]
    after = np.clip(np.searchsorted(stamps, frames_ns), 0, len(rows) - 1)
    before = np.where(stamps[after] == frames_ns, after, np.maximum(after - 1, 0))
    width = stamps[after] - stamps[before]
    covered = (stamps[before] <= frames_ns) & (frames_ns <= stamps[after]) & (width <= gap_max_ns)
    part = np.where(covered & (width > 0), (frames_ns - stamps[before]) / np.maximum(width, 1), 0.0)
    before, after = rows[before], rows[after]

    def line(values: np.ndarray) -> np.ndarray:
        return np.where(covered[:, None], (1 - part)[:, None] * values[before] + part[:, None] * values[after], empty)

    first, second = align.rotations(truth.q_CT[before]), align.rotations(truth.q_CT[after])
    turned = first * Rotation.from_rotvec(part[:, None] * (first.inv() * second).as_rotvec())
    w_T, v_C = line(truth.w_T), line(truth.v_C)
    return replace(
        truth,
        timestamp_ns=frames_ns,
        q_CT=turned.as_quat(scalar_first=True),
        p_CT=line(truth.p_CT),
        v_C=v_C,
        w_T=w_T,
        pose_valid=covered,
        rate_valid=np.isfinite(w_T).all(axis=1) & truth.rate_valid[before] & truth.rate_valid[after],
        velocity_valid=np.isfinite(v_C).all(axis=1) & truth.velocity_valid[before] & truth.velocity_valid[after],
        scale_known=truth.scale_known[before],
        mode=[],
        columns={name: np.full(count, np.nan) for name in truth.columns},
        target_frame=None,
    )


def _rows(motion: Motion, kept: np.ndarray) -> Motion:
    return replace(
        motion,
        **{name: getattr(motion, name)[kept] for name in ARRAYS},
        mode=[],
        target_frame=None,
        columns={name: values[kept] for name, values in motion.columns.items()},
    )


def _together(one: Motion, other: Motion) -> Motion:
    """Rows of both, in order of time."""
    order = np.argsort(np.concatenate([one.timestamp_ns, other.timestamp_ns]), kind="stable")
    arrays: dict[str, Any] = {name: np.concatenate([getattr(one, name), getattr(other, name)])[order] for name in ARRAYS}
    return replace(
        one,
        **arrays,
        columns={name: np.concatenate([values, other.columns[name]])[order] for name, values in one.columns.items()},
    )


def estimated_offset(estimate: Motion, truth: Motion, gap_max_s: float = GAP_MAX_S) -> Matching:
    """The offset of the truth's clock at which its attitude follows the estimate's best, up to one constant rotation.

    A body that turns steadily about one axis looks alike at any time, but for that rotation: then the motion does not tell it.
    @errors BadInput where the motion does not tell it, or the best lies at the border of the search
    """
    numbers = target_frames(estimate)
    longest = max((in_frame(estimate, number) for number in numbers), key=lambda one: one.pose_valid.sum()) if numbers else estimate
    rows = np.flatnonzero(longest.pose_valid)
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, OFFSET_FRAMES_MAX).astype(int))] if len(rows) else rows
    frames_ns = longest.timestamp_ns[rows]
    R_CE = align.rotations(longest.q_CT[rows]) if len(rows) else Rotation.identity(1)

    def residual_rad(offset_s: float) -> np.ndarray:
        """[N,3] after the best constant rotation; NaN where there is no truth."""
        at = _interpolated(
            replace(truth, timestamp_ns=truth.timestamp_ns - np.int64(round(offset_s * 1e9))), frames_ns, round(gap_max_s * 1e9)
        )
        error = np.full((len(frames_ns), 3), np.nan)
        kept = at.pose_valid
        if 2 * kept.sum() > len(kept):
            R_CT = align.rotations(at.q_CT[kept])
            R_ET = align.align_rotation(R_CE[kept], R_CT)
            error[kept] = ((R_CE[kept] * R_ET).inv() * R_CT).as_rotvec()
        return error

    def cost(offset_s: float) -> float:
        angle = np.linalg.norm(residual_rad(offset_s), axis=1)
        return float(np.nanmedian(angle)) if np.isfinite(angle).any() else np.inf

    grid = np.linspace(-OFFSET_SEARCH_S, OFFSET_SEARCH_S, OFFSET_STEPS)
    costs = [cost(offset_s) for offset_s in grid] if len(rows) > 2 else [np.inf]
    if not np.isfinite(min(costs)):
        raise BadInput(
            f"{truth.path}: --clock-offset auto: within {OFFSET_SEARCH_S:g} s, no clock gives half of the frames with a pose a truth; give SECONDS"
        )
    step_s, best_s = grid[1] - grid[0], grid[int(np.argmin(costs))]
    best_s = float(minimize_scalar(cost, bounds=(best_s - step_s, best_s + step_s), method="bounded", options={"xatol": 1e-4}).x)
    sigma_s = _offset_sigma_s(residual_rad, best_s, step_s)
    if sigma_s > OFFSET_SIGMA_MAX_S or abs(best_s) > OFFSET_SEARCH_S - step_s:
        raise BadInput(
            f"{truth.path}: --clock-offset auto: the motion does not tell it (best {best_s:+.3g} s, sigma {sigma_s:.2g} s, searched within "
            f"{OFFSET_SEARCH_S:g} s); give SECONDS"
        )
    return Matching(gap_max_s, best_s, sigma_s)


def _offset_sigma_s(residual_rad: Callable[[float], np.ndarray], best_s: float, step_s: float) -> float:
    """As if the errors of all frames were one: those of a map are the same over many frames."""
    slope = (residual_rad(best_s + step_s) - residual_rad(best_s - step_s)) / (2 * step_s)
    error, known = residual_rad(best_s), np.isfinite(slope).all(axis=1)
    error_rms, slope_rms = (float(np.sqrt(np.nanmedian((values[known] ** 2).sum(axis=1)))) for values in (error, slope))
    return float(max(error_rms, ERROR_FLOOR_RAD) / max(slope_rms, 1e-9))
