"""What a run says over time and what the truth says of the same, ready to be drawn: shared by the PNGs and the page.

A series has a row of NaN wherever its line or band must break: across a loss, and between two frames T.
"""

import pathlib
from dataclasses import dataclass

import numpy as np

from polhode_ground.common.sequence import read_json
from polhode_ground.common.tables import Motion
from polhode_ground.judge import align, metrics
from polhode_ground.judge.aligned import Aligned, align_each
from polhode_ground.judge.run import Run, best_alignment

SCALE_KNOWN_EVENT = 6  # its values: metres per map unit, relative sigma (config/bus/events.toml)


@dataclass
class Series:
    """One quantity of one motion file: value [N,3] with sigma [N] (one sigma, worst axis); truth [N,3] of the same, or None."""

    kind: str
    seconds: np.ndarray
    value: np.ndarray
    sigma: np.ndarray
    truth: np.ndarray | None = None


@dataclass
class ErrorSeries:
    """Error norms of one motion file. Position in % of range: as published, and with the scale fitted to the truth."""

    kind: str
    seconds: np.ndarray
    attitude_deg: np.ndarray
    sigma_attitude_deg: np.ndarray
    position: np.ndarray  # metres as the run says them; the fitted scale where it says none
    sigma_position: np.ndarray  # the published sigma: the scale's error is in it
    shape_position: np.ndarray  # after a fitted scale
    sigma_shape_position: np.ndarray  # without the scale's part
    metric: bool
    target_frame_starts_s: list[float]


def start_ns(run: Run) -> int:
    return min(int(motion.timestamp_ns[0]) for motion in run.motions.values())


def reference_of(run: Run, kind: str, truth: Motion | None) -> Motion | None:
    """What a series takes its axes and origin from. Without truth the smoothed poses, for the causal ones: each has a T of its own."""
    return truth if truth is not None or kind == "smoothed" else run.motions.get("smoothed")


def parts_of(run: Run, kind: str, truth: Motion | None) -> list[Aligned]:
    """Alignments of one motion file's target frames with the truth, or that of the run's other file, or none."""
    if truth is None:
        return []
    last = best_alignment(run, truth)
    return align_each(run.motions[kind], truth) or ([last] if last else [])


def breaks(motion: Motion, rows: np.ndarray) -> np.ndarray:
    """Places in rows [N] before which a line must break: rows were left out between, or another T begins."""
    apart = np.diff(rows) > 1
    if motion.target_frame is not None:
        frames = np.nan_to_num(motion.target_frame[rows], nan=-1)
        apart |= np.diff(frames) != 0
    return np.flatnonzero(apart) + 1


def broken(motion: Motion, rows: np.ndarray, *columns: np.ndarray) -> list[np.ndarray]:
    """Each column with NaN inserted at the breaks; a column is [N] or [N,3] over these rows."""
    at = breaks(motion, rows)
    return [np.insert(np.asarray(column, dtype=float), at, np.nan, axis=0) for column in columns]


def _series(run: Run, kind: str, valid: np.ndarray, value, sigma, truth) -> Series:
    motion, rows = run.motions[kind], np.flatnonzero(valid)
    seconds = (motion.timestamp_ns[rows] - start_ns(run)) * 1e-9
    # A line ends at the break, but its time goes on: NaN there would leave axes without a place.
    at = breaks(motion, rows)
    seconds = np.insert(seconds, at, seconds[at] if len(at) else [])
    columns = broken(motion, rows, value[rows], sigma[rows], *([] if truth is None else [truth[rows]]))
    return Series(kind, seconds, columns[0], columns[1], columns[2] if truth is not None else None)


def common_rates(run: Run, kind: str, truth: Motion | None) -> np.ndarray:
    """w [N,3] rad/s in the truth's axes, of each T by its own alignment; in the smoothed poses' axes without truth."""
    w = run.motions[kind].w_T.copy()
    for part in parts_of(run, kind, reference_of(run, kind, truth)):
        here = part.estimate.rate_valid
        w[here] = part.R_ET.inv().apply(w[here]) if here.any() else w[here]
    return w


def rate_series(run: Run, kind: str, truth: Motion | None) -> Series | None:
    """common_rates() [deg/s]."""
    motion = run.motions[kind]
    if not motion.rate_valid.any():
        return None
    w, true = common_rates(run, kind, truth), np.full_like(motion.w_T, np.nan)
    for part in parts_of(run, kind, truth):
        rows, _, w_true = metrics.rate_pairs(part)
        true[rows] = w_true
    sigma = motion.columns["sigma_rate_rad_s"]
    return _series(run, kind, motion.rate_valid, np.degrees(w), np.degrees(sigma), None if truth is None else np.degrees(true))


def velocity_series(run: Run, kind: str, truth: Motion | None) -> Series | None:
    """v_C [mm/s] of the estimate's origin, and the truth of that same origin: it circles the mass centre.

    A run without a scale takes it from the alignment. Without truth, causal velocities are those of the smoothed poses' origin.
    """
    motion = run.motions[kind]
    valid = motion.velocity_valid
    if not valid.any():
        return None
    if truth is None:
        return _untrue_velocity_series(run, kind)
    scale, true = np.ones(len(valid)), np.full_like(motion.v_C, np.nan)
    for part in parts_of(run, kind, truth):
        if part.estimate.path != motion.path:
            continue  # the other file's origin is not this one's
        scale[part.estimate.velocity_valid] = 1.0 if part.metric else part.similarity.scale
        rows, published, moved, v_true = metrics.velocity_pairs(part)
        true[rows] = v_true + published - moved
    known = np.isfinite(true).any()
    return _series(
        run, kind, valid, 1e3 * scale[:, None] * motion.v_C, 1e3 * scale * motion.columns["sigma_vel"], 1e3 * true if known else None
    )


def _untrue_velocity_series(run: Run, kind: str) -> Series:
    """Without truth. Causal rows that smoothed ones do not reach, or of another unit, are left out where there are others."""
    motion = run.motions[kind]
    valid, value, sigma = motion.velocity_valid, motion.v_C.copy(), motion.columns["sigma_vel"].copy()
    reached = np.zeros(len(valid), dtype=bool)
    for part in parts_of(run, kind, reference_of(run, kind, None)):
        if part.estimate.path != motion.path:
            continue  # the other file's origin is not this one's
        rows, _, moved, _ = metrics.velocity_pairs(part)
        value[rows], reached[rows] = moved, True
        sigma[rows] *= 1.0 if part.metric else part.similarity.scale
    return _series(run, kind, valid & reached if reached.any() else valid, 1e3 * value, 1e3 * sigma, None)


def velocity_in_metres(run: Run) -> bool:
    """Whether the run itself knows the unit of the velocities that are drawn."""
    drawn = (
        [run.motions["smoothed"]] if "smoothed" in run.motions and run.motions["smoothed"].velocity_valid.any() else run.motions.values()
    )
    return all(motion.scale_known[motion.velocity_valid].all() for motion in drawn)


def events_of(folder: pathlib.Path) -> list:
    """The event packets of a run's bus.ccsds in order; [] where there is none."""
    from polhode_bus import open_bus

    path = folder / "bus.ccsds"
    if not path.exists() or path.stat().st_size == 0:
        return []
    with open_bus(f"file:{path}") as source:
        return [packet for packet in source.packets() if packet.name == "event"]


def time_ns_of(packet) -> int:
    """To the 60 ns that a packet's time field resolves."""
    return packet.header.seconds * 10**9 + round(packet.header.fraction * 1e9 / 2**24)


def scale_sigmas(run: Run, kind: str) -> np.ndarray:
    """Relative sigma of the scale [N] that is in each row's metres; NaN before there is one."""
    motion = run.motions[kind]
    scale = read_json(run.folder / "shape.json").get("scale") or {}
    at_end = scale["sigma"] / scale["metres_per_map_unit"] if scale.get("known") and scale.get("sigma") else np.nan
    if kind == "smoothed":
        return np.full(len(motion.timestamp_ns), at_end)
    readings = [(time_ns_of(event), event.value[1]) for event in events_of(run.folder) if event.id == SCALE_KNOWN_EVENT]
    if not readings:
        return np.full(len(motion.timestamp_ns), at_end)
    times, sigmas = (np.array(column) for column in zip(*readings))
    place = np.searchsorted(times, motion.timestamp_ns + 100, side="right") - 1
    return np.where(place >= 0, sigmas[np.maximum(place, 0)], np.nan)


def error_series(run: Run, kind: str, truth: Motion) -> ErrorSeries | None:
    motion = run.motions[kind]
    parts = align_each(motion, truth)
    if not parts:
        return None
    attitude, sigma_attitude, own, sigma_own, fitted, sigma_fitted = (np.full(len(motion.timestamp_ns), np.nan) for _ in range(6))
    relative = scale_sigmas(run, kind)
    for part in parts:
        rows = part.rows_E
        attitude[rows] = np.degrees(part.attitude_error_rad)
        sigma_attitude[rows] = np.degrees(motion.columns["sigma_att_rad"][rows])
        own[rows] = 100 * part.own_position_error_m / part.range_m
        fitted[rows] = 100 * part.position_error_m / part.range_m
        sigma = motion.columns["sigma_pos"][rows]
        sigma_own[rows] = 100 * part.own_similarity.scale * sigma / part.range_m
        of_scale = np.where(motion.scale_known[rows], np.nan_to_num(relative[rows]), 0.0) * np.linalg.norm(motion.p_CT[rows], axis=1)
        without = np.sqrt(np.maximum(sigma**2 - of_scale**2, 0.0))
        # A difference below 1 % of the sigma is lost in the digits of the file.
        without = np.where(without > 0.01 * sigma, without, np.nan)
        sigma_fitted[rows] = 100 * part.similarity.scale * without / part.range_m
    rows = np.flatnonzero(np.isfinite(attitude))
    at = breaks(motion, rows)
    seconds = (motion.timestamp_ns[rows] - start_ns(run)) * 1e-9
    seconds = np.insert(seconds, at, seconds[at] if len(at) else [])
    columns = broken(motion, rows, *(one[rows] for one in (attitude, sigma_attitude, own, sigma_own, fitted, sigma_fitted)))
    starts = [(int(motion.timestamp_ns[part.rows_E[0]]) - start_ns(run)) * 1e-9 for part in parts[1:]]
    return ErrorSeries(kind, seconds, *columns, metric=any(part.metric for part in parts), target_frame_starts_s=starts)


def cloud_and_path(run: Run, truth: Motion | None):
    """(cloud [N,3], camera path [M,3], rows [M] of its motion file, that file's kind, alignment or None, unit) or None."""
    from polhode_ground.judge.aligned import align_last
    from polhode_ground.judge.shape import cloud_in_truth, read_cloud

    kind = next((kind for kind in ("smoothed", "causal") if kind in run.motions and run.motions[kind].pose_valid.any()), None)
    path = next((run.folder / name for name in ("cloud.ply", "cloud_raw.ply") if (run.folder / name).exists()), None)
    if kind is None or path is None:
        return None
    motion = run.motions[kind]
    rows = np.flatnonzero(motion.pose_valid)
    points, camera = read_cloud(path), -align.rotations(motion.q_CT[rows]).inv().apply(motion.p_CT[rows])
    aligned = align_last(motion, truth) if truth is not None else None
    if aligned is not None:
        points, camera = cloud_in_truth(points, aligned), cloud_in_truth(camera, aligned)
    unit = "m" if aligned is not None or motion.scale_known[rows].all() else "map units"
    return points, camera, rows, kind, aligned, unit
