"""Attitude and position errors over time against the truth, with the published sigmas."""

import numpy as np
from judge import metrics
from judge.aligned import align_each
from plots import style
from plots.style import plt


def _curve(axis, time, error, sigma, kind: str) -> None:
    colour, name = style.KIND_COLOURS[kind], style.KIND_NAMES[kind]
    rmse = metrics.rms(error[np.isfinite(error)])
    axis.plot(time, error, ".-", ms=3.5, lw=0.7, color=colour, label=name, zorder=3)
    axis.axhline(rmse, color=colour, lw=1, ls=":", zorder=2)
    axis.annotate(f"RMSE {rmse:.3g}", (1.005, rmse), xycoords=("axes fraction", "data"), color=colour, fontsize=8,
                  va="bottom" if kind == "causal" else "top", annotation_clip=False)
    if np.isfinite(sigma).any():
        axis.plot(time, sigma, color=colour, lw=1.2, ls="--", label=f"{name}, published 1 sigma", zorder=4)


def draw(run, truth, folder, prefix: str = "") -> list:
    """attitude_error.png: attitude [deg] and position [% of range] on logarithmic axes; a line where a new T begins."""
    if truth is None:
        return []
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(9, 6.5))
    drawn = False
    for kind, motion in run.motions.items():
        parts = align_each(motion, truth)
        if not parts:
            continue
        drawn = True
        attitude_deg, position, sigma_deg, sigma_position = (np.full(len(motion.timestamp_ns), np.nan) for _ in range(4))
        for part in parts:
            rows = part.rows_E
            attitude_deg[rows] = np.degrees(part.attitude_error_rad)
            position[rows] = 100 * part.position_error_m / part.range_m
            sigma_deg[rows] = np.degrees(motion.columns["sigma_att_rad"][rows])
            sigma_position[rows] = 100 * part.similarity.scale * motion.columns["sigma_pos"][rows] / part.range_m
        seconds, label = style.time_axis(motion.seconds)
        _curve(axes[0], seconds, attitude_deg, sigma_deg, kind)
        _curve(axes[1], seconds, position, sigma_position, kind)
        for part in parts[1:] if kind == "causal" else []:
            for axis in axes:
                axis.axvline(seconds[part.rows_E[0]], color=style.BAD, lw=1, ls="-.", zorder=1)
        axes[1].set_xlabel(label)
    if not drawn:
        plt.close(figure)
        return []
    for axis, label in zip(axes, ("attitude error [deg]", "position error of the target\nseen from the camera [% of range]")):
        style.plain_log_axis(axis, label)
    style.head(figure, axes, "Errors after one constant rotation, scale and offset for each target frame T")
    return [style.save(figure, folder, f"{prefix}attitude_error.png")]
