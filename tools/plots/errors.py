"""Attitude and position errors over time against the truth, with the published sigmas."""

import numpy as np
from judge import metrics
from plots import style
from plots.style import plt


def _curve(axis, time, error, sigma, kind: str) -> None:
    colour, name = style.KIND_COLOURS[kind], style.KIND_NAMES[kind]
    rmse = metrics.rms(error)
    axis.plot(time, error, ".-", ms=3.5, lw=0.7, color=colour, label=name, zorder=3)
    axis.axhline(rmse, color=colour, lw=1, ls=":", zorder=2)
    axis.annotate(f"RMSE {rmse:.3g}", (1.005, rmse), xycoords=("axes fraction", "data"), color=colour, fontsize=8,
                  va="bottom" if kind == "causal" else "top", annotation_clip=False)
    if np.isfinite(sigma).any():
        axis.plot(time, sigma, color=colour, lw=1.2, ls="--", label=f"{name}, published 1 sigma", zorder=4)


def draw(run, truth, folder, prefix: str = "") -> list:
    """attitude_error.png: attitude [deg] and position [% of range] on logarithmic axes."""
    if truth is None:
        return []
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(9, 6.5))
    drawn = False
    for kind, motion in run.motions.items():
        aligned = metrics.align_run(motion, truth)
        if aligned is None:
            continue
        drawn = True
        seconds, label = style.time_axis((motion.timestamp_ns - motion.timestamp_ns[0])[aligned.rows_E] * 1e-9)
        sigma_deg = np.degrees(motion.columns["sigma_att_rad"][aligned.rows_E])
        sigma_pos = aligned.similarity.scale * motion.columns["sigma_pos"][aligned.rows_E]
        _curve(axes[0], seconds, np.degrees(aligned.attitude_error_rad), sigma_deg, kind)
        _curve(axes[1], seconds, 100 * aligned.position_error_m / aligned.range_m, 100 * sigma_pos / aligned.range_m, kind)
        axes[1].set_xlabel(label)
    if not drawn:
        plt.close(figure)
        return []
    for axis, label in zip(axes, ("attitude error [deg]", "position error of the target\nseen from the camera [% of range]")):
        style.plain_log_axis(axis, label)
    style.head(figure, axes, "Errors after one constant rotation, scale and offset")
    return [style.save(figure, folder, f"{prefix}attitude_error.png")]
