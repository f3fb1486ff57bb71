"""Angular and linear velocity against the truth, with one-sigma bands, as in the paper's figures."""

import numpy as np
from judge import metrics, period
from judge.aligned import align_each
from judge.run import best_alignment
from judge.tables import join
from plots import style
from plots.style import plt


def _panel(axis, time, series: list[dict], truth: np.ndarray | None, unit: str, label: str) -> None:
    """One component: truth as a line below dots and bands of each motion file."""
    if truth is not None:
        axis.plot(time, truth, color=style.TRUTH, lw=1.6, label="truth", zorder=2)
    for one in series:
        colour = style.KIND_COLOURS[one["kind"]]
        name = style.KIND_NAMES[one["kind"]]
        axis.fill_between(one["time"], one["value"] - one["sigma"], one["value"] + one["sigma"],
                          color=colour, alpha=0.25, lw=0, zorder=1, label=f"{name}, 1 sigma")
        axis.plot(one["time"], one["value"], ".", ms=3.2, color=colour, label=name, zorder=3)
        if one.get("curve") is not None:
            axis.plot(one["time"], one["curve"], "--", lw=1, color=colour, label=f"{name}, sine fit", zorder=4)
    axis.set_ylim(*style.robust_limits(truth if truth is not None else np.empty(0), [one["value"] for one in series]))
    hidden = sum(style.count_outside(axis, one["value"]) for one in series)
    axis.set_ylabel(f"{label} [{unit}]" + (f"\n({hidden} beyond)" if hidden else ""))


def _parts(run, kind: str, truth) -> list:
    """Alignments of one motion file's target frames with the truth, or that of the run's other file, or none."""
    if truth is None:
        return []
    last = best_alignment(run, truth)
    return align_each(run.motions[kind], truth) or ([last] if last else [])


def _start_ns(run) -> int:
    return min(int(motion.timestamp_ns[0]) for motion in run.motions.values())


def _rate_series(run, kind: str, truth, start_ns: int) -> dict | None:
    """w of one file in the truth's axes [deg/s] with its sigma; in its own axes without truth."""
    motion = run.motions[kind]
    valid = motion.rate_valid
    if not valid.any():
        return None
    w = motion.w_T.copy()
    for part in _parts(run, kind, truth):
        here = part.estimate.rate_valid
        w[here] = part.R_ET.inv().apply(w[here]) if here.any() else w[here]
    return {"kind": kind, "seconds": (motion.timestamp_ns[valid] - start_ns) * 1e-9, "value": np.degrees(w[valid]),
            "sigma": np.degrees(motion.columns["sigma_rate_rad_s"][valid])}


def _velocity_series(run, kind: str, truth, start_ns: int) -> dict | None:
    """v_C of one file [mm/s], scaled by the alignment where the run has no scale of its own."""
    motion = run.motions[kind]
    valid = motion.velocity_valid
    if not valid.any():
        return None
    scale = np.ones(len(valid))
    for part in _parts(run, kind, truth):
        scale[part.estimate.velocity_valid] = 1.0 if part.metric else part.similarity.scale
    return {"kind": kind, "seconds": (motion.timestamp_ns[valid] - start_ns) * 1e-9,
            "value": 1e3 * scale[valid, None] * motion.v_C[valid], "sigma": 1e3 * scale[valid] * motion.columns["sigma_vel"][valid]}


def _velocity_of_origin(run, truth, start_ns: int):
    """(seconds [M], velocity [M,3] mm/s) that the estimate's own origin has by the truth: it circles the mass centre."""
    aligned = best_alignment(run, truth) if truth is not None else None
    if aligned is None:
        return None
    rows, published, moved, true = metrics.velocity_pairs(aligned)
    if len(rows) == 0 or not np.isfinite(moved).all():
        return None
    return (aligned.estimate.timestamp_ns[rows] - start_ns) * 1e-9, 1e3 * (true + published - moved)


def _figure(series: list[dict], truth_seconds, truth_values, labels, unit: str, title: str, sine: bool, origin=None):
    """Three stacked panels over one time axis; origin: (seconds [M], values [M,3]) of a second true curve, or None."""
    span = np.concatenate([one["seconds"] for one in series] + ([truth_seconds] if truth_values is not None else []))
    factor = 1 / 60 if span.max() > 1200 else 1.0
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(9, 7.5))
    for i, axis in enumerate(axes):
        parts = []
        for one in series:
            part = {"kind": one["kind"], "time": one["seconds"] * factor, "value": one["value"][:, i],
                    "sigma": np.nan_to_num(one["sigma"])}
            if sine and one["kind"] == "smoothed" and len(one["seconds"]) >= period.SAMPLES_MIN:
                fit = period.fit_sine(one["seconds"], part["value"])
                if fit and fit["amplitude"] > 0.02 * np.linalg.norm(one["value"], axis=1).mean() and fit["cycles"] > 0.75:
                    part["curve"] = period.sine_curve(fit, one["seconds"], one["seconds"][0])
            parts.append(part)
        _panel(axis, truth_seconds * factor, parts, None if truth_values is None else truth_values[:, i], unit, labels[i])
    axes[-1].set_xlabel("time [min]" if factor != 1.0 else "time [s]")
    if origin is not None:
        for i, axis in enumerate(axes):
            axis.plot(origin[0] * factor, origin[1][:, i], ":", color=style.TRUTH, lw=1.4, zorder=2,
                      label="truth, moved to the estimate's origin")
    style.head(figure, axes, title)
    return figure


def draw(run, truth, folder, prefix: str = "") -> list:
    """rates.png and velocity.png; what a run does not have is not drawn."""
    start_ns = _start_ns(run)
    paths = []
    overlap = truth is not None and all(len(join(motion, truth)[0]) for motion in run.motions.values())
    truth = truth if overlap else None
    truth_seconds = (truth.timestamp_ns - start_ns) * 1e-9 if truth is not None else np.empty(0)
    rates = [one for one in (_rate_series(run, kind, truth, start_ns) for kind in run.motions) if one]
    if rates:
        values = np.degrees(truth.w_T) if truth is not None and np.isfinite(truth.w_T).any() else None
        axes_of = "truth's" if truth is not None else "estimate's own"
        figure = _figure(rates, truth_seconds, values, ["w_x", "w_y", "w_z"], "deg/s",
                         f"Angular velocity of the target, in the {axes_of} body axes", sine=True)
        paths.append(style.save(figure, folder, f"{prefix}rates.png"))
    velocities = [one for one in (_velocity_series(run, kind, truth, start_ns) for kind in run.motions) if one]
    if velocities:
        values = 1e3 * truth.v_C if truth is not None and np.isfinite(truth.v_C).any() else None
        known = all(run.motions[one["kind"]].scale_known[run.motions[one["kind"]].velocity_valid].all() for one in velocities)
        unit = "mm/s" if known or truth is not None else "map units/s / 1000"
        note = "" if known else ", scale taken from the truth" if truth is not None else ", scale unknown"
        figure = _figure(velocities, truth_seconds, values, ["v_x", "v_y", "v_z"], unit,
                         f"Velocity of the target's origin in the camera frame{note}", sine=False,
                         origin=_velocity_of_origin(run, truth, start_ns))
        paths.append(style.save(figure, folder, f"{prefix}velocity.png"))
    return paths
